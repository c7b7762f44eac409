"""Pictures as files: laid out once before they are saved, they are those that Matplotlib lays out as it saves."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import pytest

from nonsmooth.reports.figures.style import figure_bytes
from tests.thorough import keep

if TYPE_CHECKING:
    from matplotlib.figure import Figure

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
