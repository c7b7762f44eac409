"""Pictures: all texts inside the figure, and the bytes of their files."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pytest

from nonsmooth.reports.figures.style import figure_bytes, lay_out
from nonsmooth.reports.figures.wheels import array_figure
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing, whole
from tests.thorough import few, keep

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox
if TYPE_CHECKING:
    from matplotlib.figure import Figure


# ---- Texts of pictures: all inside the figure, names of wheels apart from each other and from the rims.

HEAD = 'units = { length = "mm", speed = "mm/s" }\nfriction = { mu_roll = 0.62, mu_side = 0.62 }\n'
TABLE = f"""{HEAD}
name = "sorting table 7"
contact = {{ rule = "ellipse" }}
field = {{ kind = "radial", speed = 250 }}
wheels = {{ file = "wheels.csv" }}
body = {{ shape = "rectangle", width = 400, height = 380 }}
"""


def table(folder: Path, names: str = "M{row}{column}") -> Path:
    """Twelve named wheels in millimetres under a carton."""
    rows = [
        f"{names.format(row=row + 1, column='ABCD'[column])},{column * 150 - 225},{row * 150 - 150 + column}"
        for row in range(3)
        for column in range(4)
    ]
    (folder / "wheels.csv").write_text("\n".join(["name,x,y", *rows]), encoding="utf-8")
    (folder / "table.toml").write_text(TABLE, encoding="utf-8")
    return folder / "table.toml"


def laid_out(figure: Figure, suffix: str = ".png") -> Any:
    """What measures text, as the file would have it."""
    lay_out(figure, suffix)
    figure.canvas.draw()
    return figure.canvas.get_renderer()  # type: ignore[attr-defined]


def text_boxes(figure: Figure, renderer: Any) -> dict[str, Bbox]:
    """The boxes of all texts that are drawn, by their words and a count."""
    from matplotlib.text import Text

    shown = [text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()]
    in_legends = {text for legend in figure.legends for text in legend.get_texts()}
    kept = [text for text in shown if text.axes is not None or text in in_legends]
    return {f"{k}: {text.get_text()}": text.get_window_extent(renderer) for k, text in enumerate(kept)}


def outside(figure: Figure, boxes: dict[str, Bbox]) -> list[str]:
    width, height = figure.bbox.width, figure.bbox.height
    return [name for name, box in boxes.items() if box.x0 < 0 or box.y0 < 0 or box.x1 > width or box.y1 > height - 2]


def overlapping(boxes: dict[str, Bbox]) -> list[tuple[str, str]]:
    pairs = combinations(boxes.items(), 2)
    return [(a, b) for (a, first), (b, second) in pairs if first.overlaps(second)]


def test_the_check_itself_finds_a_clipped_title_and_two_texts_on_each_other() -> None:
    from nonsmooth.reports.figures.style import new_figure

    figure = new_figure(2.0, 2.0)
    axes = figure.subplots()
    axes.text(0.5, 0.5, "one")
    axes.text(0.5, 0.5, "two")
    axes.set_title("a title that is much wider than the figure is, on one line")
    boxes = text_boxes(figure, laid_out(figure))
    assert any("much wider" in name for name in outside(figure, boxes))
    assert any("one" in a and "two" in b for a, b in overlapping(boxes))


@few(3)
@pytest.mark.parametrize("scene", ["four-wheel", "carton-on-6x6", "ring-8", "grid-4x4", "named", "long names"])
def test_names_of_an_array_are_inside_and_apart(tmp_path: Path, scene: str) -> None:
    names = "roller {row}/{column}" if scene == "long names" else "M{row}{column}"
    source = table(tmp_path, names) if "name" in scene else scene
    found = standing(load_scene(source))
    figure = array_figure(found)
    renderer = laid_out(figure)
    boxes = text_boxes(figure, renderer)
    assert not outside(figure, boxes)
    wanted = {str(wheel.index) for wheel in whole(found).wheels}
    named = {name: box for name, box in boxes.items() if name.partition(": ")[2] in wanted}
    ticks = {str(label.get_text()) for axis in figure.axes for label in axis.get_xticklabels() + axis.get_yticklabels()}
    assert {name.partition(": ")[2] for name in named} >= wanted
    names_alone = {name: box for name, box in named.items() if name.partition(": ")[2] not in ticks}
    assert not overlapping(names_alone)
    rims = [line for line in figure.axes[0].lines if line.get_linewidth() == 5 and np.size(line.get_xdata()) == 2]
    assert len(rims) == len(wanted)
    for line in rims:
        ends = figure.axes[0].transData.transform(line.get_xydata())
        points = [ends[0] + share / 20 * (ends[1] - ends[0]) for share in range(21)]
        assert not [name for name, box in names_alone.items() if any(box.contains(*point) for point in points)]


def test_the_names_of_a_crowded_array_are_left_out(tmp_path: Path) -> None:
    text = HEAD + "[grid]\nrows = 24\ncolumns = 25\npitch = 10\n[field]\nkind = 'expression'\nx = '1'\ny = '0'\n"
    (tmp_path / "many.toml").write_text(text, encoding="utf-8")
    figure = array_figure(load_scene(tmp_path / "many.toml"))
    assert not [text for text in figure.axes[0].texts if text.get_text() == "17"]


# ---- Pictures as files: laid out once before they are saved, they are those that Matplotlib lays out as it saves.

LAST = {".svg": b"</svg>", ".png": b"IEND", ".pdf": b"%%EOF"}  # near the end of a whole file


def crowded(layout: Literal["constrained"] | None) -> Figure:
    """Two panels of equal axes, one with a scale of colors, with titles, a legend and long labels."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5, 3), layout=layout)
    left, right = figure.subplots(1, 2)
    left.set_aspect("equal")
    left.plot([0, 1], [0, 2000], label="a line")
    left.set_ylabel("a long label of an axis")
    figure.colorbar(right.scatter([0, 1], [0, 1], c=[0.0, 1.0]), ax=right, label="a scale")
    right.set_title("a title\nof two lines")
    figure.legend(loc="outside lower center")
    return figure


@pytest.mark.parametrize("suffix", keep(1, LAST))
def test_the_layout_is_that_of_saving(suffix: str, monkeypatch: pytest.MonkeyPatch) -> None:
    ours = figure_bytes(lambda: crowded("constrained"), suffix)
    assert LAST[suffix] in ours[-40:]
    assert ours != figure_bytes(lambda: crowded(None), suffix)
    monkeypatch.setattr("nonsmooth.reports.figures.style.lay_out", lambda figure, suffix: None)
    assert ours == figure_bytes(lambda: crowded("constrained"), suffix)


def test_a_picture_is_drawn_once(monkeypatch: pytest.MonkeyPatch) -> None:
    from matplotlib.figure import Figure

    drawn: list[Figure] = []
    draw = Figure.draw

    def counted(figure: Figure, renderer: Any) -> None:
        drawn.append(figure)
        draw(figure, renderer)

    monkeypatch.setattr(Figure, "draw", counted)
    figure_bytes(lambda: crowded("constrained"), ".svg")
    assert len(drawn) == 1
