"""Films of paths, frames against the definitions, and how pictures are laid out."""

from __future__ import annotations

import io
import json
import re
from fractions import Fraction
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal
from unittest.mock import patch

import numpy as np
import pytest
from PIL import Image

import nonsmooth as ns
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.motion.frames import Frames, WheelContact, build_frames
from nonsmooth.reports.animation import film as film_module
from nonsmooth.reports.animation.film import MOST_FRAMES, RATE, build_film, frame_times
from nonsmooth.reports.animation.page import _number
from nonsmooth.reports.cli import app
from nonsmooth.reports.figures.cells import cells_figure
from nonsmooth.reports.figures.style import figure_bytes, lay_out
from nonsmooth.reports.figures.wheels import array_figure, outline_of, placed
from nonsmooth.reports.output.console import BAD_INPUT, run
from nonsmooth.reports.output.study_options import PathMethod
from nonsmooth.reports.simulations.closed_paths import CellLoopPath
from nonsmooth.reports.simulations.paths import PathResult, follow_cells
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import standing, whole
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from matplotlib.transforms import Bbox
if TYPE_CHECKING:
    from matplotlib.figure import Figure


# ---- Films of paths, ``nonsmooth simulate -o path.gif`` and ``.html``: frames, files, refusals ----

START = ("--from", "0.2,0.4,0.1")
LARGEST_GIF = 3_000_000  # bytes


def data_of(page: str) -> dict[str, Any]:
    """What the page's script draws."""
    found = re.search(r'<script type="application/json" id="film">(.*?)</script>', page, re.DOTALL)
    assert found
    data: dict[str, Any] = json.loads(found.group(1))
    return data


@pytest.mark.parametrize("duration", [0.01, 1.0, 3.0, 7.3, 14.9, 60.0, 1e6])
def test_frames_are_at_a_constant_pace_and_few(duration: float) -> None:
    times, seconds = frame_times(duration)
    assert (times[0], times[-1]) == (0, pytest.approx(duration))
    assert np.ptp(np.diff(times)) <= 1e-12 * duration
    assert len(times) <= MOST_FRAMES
    assert seconds == pytest.approx((len(times) - 1) / RATE)
    if 3 <= duration < 14.9:
        assert seconds == pytest.approx(duration, abs=0.5 / RATE)  # real time


@pytest.mark.parametrize("until", keep(1, [0.2, 1, 3, 4]))
def test_a_gif_has_its_frames_and_is_small(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, until: float
) -> None:
    monkeypatch.setattr(film_module, "SHORTEST", min(until, film_module.SHORTEST))  # no slow motion of the short one
    file = tmp_path / "path.gif"
    assert run(app, ("simulate", "four-wheel", *START, "--feedback", "--until", str(until), "-o", str(file))) == 0
    assert capsys.readouterr().err == ""
    with Image.open(file) as film:
        assert film.n_frames == round(until * RATE) + 1  # type: ignore[attr-defined]
        assert film.info["duration"] == 1000 // RATE
    assert file.stat().st_size < LARGEST_GIF


def test_a_film_of_a_law_under_friction_sets_is_refused_before_the_work(invoke: Invoke) -> None:
    common = ("simulate", "ring-6", "--rule", "ellipse", "--from", "0,0,0.1", "--feedback", "-o", "path.html")
    with patch("nonsmooth.reports.simulations.simulate._run_array", side_effect=AssertionError):
        done = invoke(*common)
    assert (done.status, done.err[:30]) == (2, "nonsmooth: -o: required sample")


def test_slips_that_are_rounding_are_none() -> None:
    assert [_number(value, 2e-4) for value in (-4.91e-06, 2.52e-05, 0.00817)] == ["0", "0", "0.00817"]


@pytest.mark.parametrize("until", keep(1, [1.0, 4.0]))
def test_a_page_holds_what_the_frames_hold(tmp_path: Path, until: float) -> None:
    array = ns.load("ring-6").with_(rule="ellipse")
    assert isinstance(array, ns.Array)
    path = array.simulate((0.1, 0.2, 0.0), until=until)
    page = path.animate(tmp_path / "path.html").read_text(encoding="utf-8")
    data = data_of(page)
    film = build_film(array.scene, path.trajectory)
    assert data["times"] == pytest.approx(film.frames.times.tolist(), rel=1e-5)
    assert data["contacts"] == film.frames.contacts.tolist()
    assert len(data["slips"]) == len(data["poses"]) == len(film.frames)
    left, right, _, high = film.view
    scale = 1000 / (right - left)
    x, y, theta = film.frames.poses[-1]
    assert data["poses"][-1] == pytest.approx([(x - left) * scale, (high - y) * scale, -np.degrees(theta)], abs=0.06)
    assert "http" not in page.replace("http-equiv", "")


def test_a_friction_axis_is_drawn_where_it_is_not_the_rim(tmp_path: Path) -> None:
    """Of mecanum wheels at 45 degrees to the rim, half as long again; of others there is none."""
    array = ns.load("mecanum-4")
    assert isinstance(array, ns.Array)
    page = array.with_(rule="box").simulate((0.01, 0.02, 0.0), until=0.1).animate(tmp_path / "a.html").read_text()
    lines = re.findall(r'<line class="(axis|rim)" x1="(.*?)" y1="(.*?)" x2="(.*?)" y2="(.*?)"/>', page)[:8]
    assert [kind for kind, *_ in lines] == ["axis", "rim"] * 4
    ends = np.array([[float(value) for value in line[1:]] for line in lines])
    halves = (ends[:, 2:] - ends[:, :2]) @ [1, -1j]
    turns = halves[0::2] / halves[1::2]
    assert np.abs(turns) == pytest.approx(np.full(4, 1.5), abs=0.01)
    angles = [np.angle(complex(*map(float, w.grip)) / complex(*map(float, w.direction))) for w in array.scene.wheels]
    assert np.exp(2j * np.angle(turns)) == pytest.approx(np.exp(2j * np.array(angles)), abs=0.01)
    assert "friction axis" in page
    plain = ns.load("four-wheel")
    assert isinstance(plain, ns.Array)
    text = plain.simulate((0.2, 0.4, 0.0), until=0.1).animate(tmp_path / "b.html").read_text()
    assert 'class="axis"' not in text


def test_a_page_has_a_scale_and_the_words_of_the_table(tmp_path: Path) -> None:
    """Numbers at the edges are where wheels with such coordinates are; wheels have their own names."""
    (tmp_path / "table.toml").write_text(NAMED, encoding="utf-8")
    array = ns.load(tmp_path / "table.toml")
    assert isinstance(array, ns.Array)
    array.simulate((10, 5, 0), 0.05).animate(tmp_path / "path.html")
    page = (tmp_path / "path.html").read_text(encoding="utf-8")
    across = {text: float(x) for x, text in re.findall(r'<text x="([\d.]+)" y="[\d.]+">(-?[\d.]+)</text>', page)}
    down = {text: float(y) for y, text in re.findall(r'<text class="left" x="-14" y="([\d.]+)">(-?[\d.]+)<', page)}
    rings = [tuple(map(float, ring)) for ring in re.findall(r'data-wheel="[^"]*" cx="([\d.]+)" cy="([\d.]+)"', page)]
    assert rings[1] == pytest.approx((across["-100"], down["100"]), abs=0.1)
    assert rings[3] == pytest.approx((across["100"], down["-100"]), abs=0.1)
    assert re.findall(r'<text class="unit"[^>]*>(mm)<', page) == ["mm"]
    assert "<h1>table: rule nearest, exact kinematics, without inertia</h1>" in page
    assert re.search(r"<p>ends [\d.]+ mm from the point, .*</p>", page)
    assert data_of(page)["wheels"] == ["M1", "M2", "M3", "M4"]
    assert "speed u [mm/s]" in page


NAMED = """
name = "table"
units = { length = "mm" }
friction = { mu_roll = 0.8, mu_side = 0.4 }
check = { radius = 40 }
""" + "".join(
    f'[[wheel]]\nname = "M{k + 1}"\nposition = [{x}, {y}]\nheading = "inward"\nspeed = 100\n'
    for k, (x, y) in enumerate([(100, 100), (-100, 100), (-100, -100), (100, -100)])
)


def test_names_of_scenes_are_text(tmp_path: Path) -> None:
    array = ns.load("ring-3").with_(name="</script><b>&\"'")
    page = array.simulate((0.05, 0.02, 0.1), until=0.2).animate(tmp_path / "path.html").read_text(encoding="utf-8")
    assert "<b>" not in page
    assert page.count("</script>") == 2


def test_the_outline_follows_the_pose() -> None:
    array = ns.Array.grid(2, 2, pitch=2, mu_roll=1, mu_side="1/2")
    disc = outline_of(array.with_(body={"shape": "disc", "radius": 2}).scene)
    assert disc is not None
    assert np.allclose(np.hypot(*disc.T), 2)
    corners = [[1, 0], [0, 1], [-1, -1]]
    body = {"shape": "polygon", "vertices": corners, "centre_of_mass": [0, 0], "heading": "90 deg"}
    turned = outline_of(array.with_(body=body).scene)
    assert turned is not None
    assert np.allclose(sorted(turned.tolist()), sorted([[0, 1], [-1, 0], [1, -1]]))
    there = placed(turned, np.array([3.0, 4.0, -np.pi / 2]))
    assert np.allclose(sorted(there.tolist()), sorted([[4, 4], [3, 5], [2, 3]]))
    assert outline_of(array.scene) is None


@thorough  # the small one: test_the_outline_follows_the_pose
def test_a_body_is_drawn_with_its_outline(tmp_path: Path) -> None:
    box = {"shape": "rectangle", "width": "5/2", "height": 3}
    array = ns.load("four-wheel").with_(body=box, rule="ellipse")
    path = array.simulate((0.1, 0.05, 0.1), until=0.5)
    page = path.animate(tmp_path / "path.html").read_text(encoding="utf-8")
    assert '<polygon class="outline"' in page
    with Image.open(io.BytesIO(path.animate(tmp_path / "path.gif").read_bytes())) as film:
        assert film.n_frames > 50  # type: ignore[attr-defined]


def test_a_large_array_shows_the_wheels_near_the_path(tmp_path: Path) -> None:
    array = ns.Array.grid(16, 16, pitch="1/4", mu_roll=1, mu_side="1/2", radius="1/2")
    page = array.simulate((0.2, 0.3, 0), until=1).animate(tmp_path / "path.html").read_text(encoding="utf-8")
    assert len(data_of(page)["wheels"]) == 150
    assert "150 of 256 wheels are drawn" in page


@thorough
def test_a_rule_without_cells_moves_on_the_command_line_too(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    simulate = ("simulate", "ring-6", "--rule", "ellipse", "--from", "0.1,0.2,0", "--until", "0.3")
    assert run(app, (*simulate, "--json")) == 0
    record = json.loads(capsys.readouterr().out)
    array = ns.load("ring-6")
    assert isinstance(array, ns.Array)
    path = array.simulate((0.1, 0.2, 0.0), until=0.3, rule="ellipse")
    assert record["state"] == path.to_dict()["state"]
    assert (record["schema"], record["law"], record["speeds"]) == ("nonsmooth-trajectory/1", None, None)
    for suffix in (".html", ".svg", ".csv"):
        assert run(app, (*simulate, "-o", str(tmp_path / f"path{suffix}"))) == 0
    assert 0 not in data_of((tmp_path / "path.html").read_text(encoding="utf-8"))["contacts"][0]  # all six carry
    capsys.readouterr()
    assert run(app, simulate) == 0
    assert "ring-6: exact kinematics, method minimizer (rule ellipse)" in capsys.readouterr().out
    for refused in (("--method", "smoothed"), ("--kinematics", "leading")):
        assert run(app, (*simulate, *refused)) == BAD_INPUT
        assert "ring-6: contact.rule: required" in capsys.readouterr().err
    assert run(app, (*simulate[:5], "3,0,0")) == BAD_INPUT
    assert capsys.readouterr().err.count("\n") == 1


# ---- Frames of a path against the definitions: slips from the twist, twists from the cells, contact sets by the
# rules.

PATHS: dict[str, tuple[str, tuple[float, float, float], dict[str, Any]]] = {
    "open": ("four-wheel", (0.2, 0.4, 0.1), {}),
    "sliding": ("ring-5", (0.11, 0.2, 0.0), {}),
    "box": ("four-wheel", (0.2, 0.45, 0.0), {"rule": "box", "mu_side": "1/10"}),
    "ellipse": ("ring-6", (0.1, 0.2, 0.0), {"rule": "ellipse"}),
    "closed": ("ring-5", (0.1, 0.12, 0.2), {"feedback": True, "gain": 2.0}),
    "cascade": ("ring-6", (0.1, 0.05, 0.1), {"feedback": "cascade"}),
}


def followed(name: str) -> PathResult:
    scene, start, options = PATHS[name]
    array = ns.load(scene)
    assert isinstance(array, ns.Array)
    return array.simulate(start, 1.0, **options)


def frames_of(path: PathResult, count: int = 37) -> Frames:
    assert path.scene
    inputs = path.loop.inputs(path.partition) if isinstance(path, CellLoopPath) else None
    times = np.linspace(0, path.t[-1], count)
    return build_frames(path.scene, path.trajectory, times, partition=path.partition, inputs=inputs)


@pytest.mark.parametrize("name", PATHS)
def test_slips_are_those_of_the_twist(name: str) -> None:
    path = followed(name)
    frames = frames_of(path)
    assert path.scene
    for k in range(len(frames)):
        v_x, v_y, omega = frames.twists[k]
        for i, wheel in enumerate(path.scene.wheels):
            (x, y), (a, b) = ([float(e) for e in pair] for pair in (wheel.position, wheel.unit_direction))
            moving = (v_x - omega * y, v_y + omega * x)  # v + omega J p
            along = moving[0] * a + moving[1] * b - frames.speeds[k, i]
            across = -moving[0] * b + moving[1] * a
            assert np.allclose(frames.slips[k, i], (along, across), rtol=0, atol=1e-12, equal_nan=True)


@pytest.mark.parametrize("name", ["open", "sliding", "box"])
def test_twists_are_in_the_hull_of_the_cells_that_hold_the_point(name: str) -> None:
    path = followed(name)
    frames = frames_of(path)
    assert path.partition
    seen = set()
    for pose, twist in zip(frames.poses, frames.twists, strict=True):
        slack = 1e-9
        held = [
            np.array([float(entry) for entry in cell.twists[0]])
            for cell in path.partition.cells
            if all(
                float(side.normal[0]) * pose[0] + float(side.normal[1]) * pose[1] <= float(side.offset) + slack
                for side in cell.polygon.sides
            )
        ]
        seen.add(min(len(held), 3))
        if len(held) == 1:
            assert np.abs(twist - held[0]).max() < 1e-7
        if len(held) == 2:
            ahead = held[1] - held[0]
            share = float((twist - held[0]) @ ahead) / float(ahead @ ahead)
            assert -1e-6 <= share <= 1 + 1e-6
            assert np.abs(held[0] + share * ahead - twist).max() < 1e-6
    assert seen >= {1} if name != "sliding" else seen >= {1, 2}


def test_a_law_gives_the_acting_wheels_what_their_rows_ask_for() -> None:
    """In the closed loop both rows of the nearest wheel hold, and the roll row of the second."""
    frames = frames_of(followed("closed"), 101)
    acting = np.isfinite(frames.speeds)
    assert set(acting.sum(axis=1)) == {2}
    assert (frames.contacts[acting] != WheelContact.FREE).all()
    assert (frames.contacts[~acting] == WheelContact.FREE).all()
    assert np.abs(frames.slips[..., 0][acting]).max() < 1e-6
    across = np.where(acting, np.abs(frames.slips[..., 1]), np.inf)
    assert across.min(axis=1).max() < 1e-6
    slips = np.abs(frames.slips).max(axis=2)
    sticking, slipping = (slips[frames.contacts == kind] for kind in (WheelContact.STICKS, WheelContact.SLIPS))
    assert sticking.size
    assert sticking.max() < 1e-5 < slipping.max()


@thorough  # the small one: test_twists_are_in_the_hull_of_the_cells_that_hold_the_point
def test_rule_ellipse_moves_with_its_minimizer_and_is_carried_by_loaded_wheels() -> None:
    path = followed("ellipse")
    frames = frames_of(path, 9)
    assert path.scene
    rule, model = smooth_rule_of(path.scene), contact_model(path.scene)
    expected = minima_under(rule, path.scene, frames.poses[:, :2]).twists
    assert np.abs(frames.twists - expected).max() < 1e-5
    assert np.array_equal(frames.contacts != WheelContact.FREE, loads_at(model, frames.poses[:, :2]) > 1e-9)


def test_leading_order_kinematics_and_samples_without_pieces() -> None:
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    partition = array.partition
    radius = float(array.scene.check.radius)
    x, y = (float(entry) + 0.3 * radius for entry in array.scene.check.equilibrium)
    for method in (PathMethod.EVENTS, PathMethod.HYSTERESIS):
        options = SimulateOptions(start=(x, y, 0.0), until=0.05, kinematics=Kinematics.LEADING, method=method)
        path = follow_cells(partition, options)
        frames = build_frames(array.scene, path, [0.01], partition=partition, pivot=(0.0, 0.0))
        point = [array.scene.field.rational(Fraction(float(entry))) for entry in frames.poses[0, :2]]
        cell = partition.cells_at((point[0], point[1]))[0]
        assert np.abs(frames.twists[0] - [float(x) for x in cell.twists[0]]).max() < 1e-6


def test_a_path_of_no_time_has_one_still_frame() -> None:
    path = followed("open")
    assert path.scene
    end = build_frames(path.scene, path.trajectory, [float(path.t[-1])], partition=path.partition)
    assert np.abs(end.twists).max() < 1e-9


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


@pytest.mark.parametrize("name", ["a sorting table with a long name, " * 4, "a_long_name_in_one_word_" * 4])
def test_a_long_name_stands_on_as_many_lines_as_it_needs(name: str) -> None:
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    for figure in (array_figure(array.with_(name=name).scene), cells_figure(array.with_(name=name).partition)):
        boxes = text_boxes(figure, laid_out(figure))
        assert outside(figure, boxes) == []


def test_ticks_of_the_scale_of_a_map_are_apart() -> None:
    figure = ns.System(["x", "y"], ["y", "-x"]).map(3, until=1).figure()
    renderer = laid_out(figure)
    ticks = [text for text in figure.axes[-1].get_yticklabels(which="both") if text.get_text()]
    assert [text.get_text() for text in ticks] == ["1e-06", "0.0001", "0.01", "1"]
    assert overlapping({text.get_text(): text.get_window_extent(renderer) for text in ticks}) == []


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


@pytest.mark.parametrize("name", keep(1, ["ring-8", "grid-4x4"]))
def test_a_title_above_cells_with_a_long_legend_is_not_cut_off(name: str) -> None:
    figure = cells_figure(build_partition(load_scene(name, rule="box" if name == "ring-8" else None)))
    lay_out(figure, ".png")
    assert figure.axes[0].title.get_window_extent().y1 <= figure.bbox.y1


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
