"""A picture of the partition: cells, their motion, the wheels with their rims, the checked point.

Arrows show the direction in which the centre of mass moves at the arrow's place (exact kinematics), a turning
sign the sense of rotation; magnitudes are in the cell table.  Matplotlib is imported here only.
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable, Iterable
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.analysis.partitions.partition import Cell, Partition
from nonsmooth.symbolic.formulas import decimal_text
from nonsmooth.symbolic.scene import Wheel
from nonsmooth.symbolic.scene_error import Fact, SceneError, one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


# Okabe and Ito's palette (safe for color-blind readers), drawn lightly; white gaps part equal neighbours.
PALETTE = ("#56B4E9", "#E69F00", "#009E73", "#F0E442", "#CC79A7", "#0072B2", "#D55E00", "#999999")
TINT = 0.45  # opacity of a cell
INK = "#222222"
PICTURE = 6.4  # inches, both ways
POINTS = 72 * PICTURE * 0.8  # points that the axes take
LABEL = 9  # points, the size of a label
LARGEST, RESOLUTION = 1e100, 1e-9  # what Matplotlib draws faithfully with floats
LABEL_ROOM = 3  # points that each character of a label needs around the label's middle
ARROW = {"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0, "linewidth": 1.2}
MARGIN = 0.1  # of the width, around everything
TURNS = {0: "", 1: "\N{ANTICLOCKWISE OPEN CIRCLE ARROW}", -1: "\N{CLOCKWISE OPEN CIRCLE ARROW}"}
FAR = 6  # a wheel farther away than this many half-widths of the square stays outside the picture

XY: TypeAlias = tuple[float, float]
Segment: TypeAlias = tuple[XY, XY]


def cell_map(partition: Partition, suffix: str) -> bytes:
    """The picture as the bytes of a file; ``suffix`` is one of PICTURES.  Equal input gives equal bytes.

    Raises:
        SceneError: where the square is too large, too small or too far away to be drawn with floats.
    """
    require_drawable(partition)
    return figure_bytes(lambda: build_figure(partition), suffix)


def figure_bytes(build: Callable[[], Figure], suffix: str) -> bytes:
    """A figure as the bytes of a file; ``suffix`` is one of PICTURES.  Equal input gives equal bytes."""
    import matplotlib as mpl

    stamps = {".svg": {"Date": None}, ".png": {"Software": None}, ".pdf": {"CreationDate": None}}
    stream = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "nonsmooth", "font.size": LABEL}), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # a scene's name may use any script
        build().savefig(stream, format=suffix[1:], dpi=150, metadata=stamps[suffix])
    return stream.getvalue()


def require_drawable(partition: Partition) -> None:
    """Refuse squares that floats cannot draw faithfully."""
    scene = partition.scene
    radius, far = abs(float(scene.check.radius)), max(abs(float(x)) for x in scene.check.equilibrium)
    if not (1 / LARGEST <= radius <= LARGEST and far * RESOLUTION <= radius):
        expected = f"for a picture, a radius of {1 / LARGEST:g} to {LARGEST:g}, and {RESOLUTION:g} of the coordinates"
        raise SceneError(scene.origin, "check.radius", expected, Fact(decimal_text(scene.check.radius, 6)))


def build_figure(partition: Partition) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(PICTURE, PICTURE + 0.5), layout="constrained")
    axes = figure.subplots()
    wheels = _visible_wheels(partition)
    width = _set_view(axes, partition, wheels)
    x, y = _floats(partition.scene.check.equilibrium)
    marks: list[Segment] = [((x, y), (x, y))]
    for wheel in wheels:
        marks += _draw_wheel(axes, wheel, width)
    for cell, color in zip(partition.cells, _colors(partition), strict=True):
        _draw_cell(axes, cell, color, marks, points_per_length=POINTS / width)
    axes.plot([x], [y], marker="+", color=INK, markersize=11, markeredgewidth=1.6, zorder=5)
    scene = partition.scene
    axes.set_title(f"{one_line(scene.name)}: rule {partition.rule}, {len(partition.cells)} cells", parse_math=False)
    _explain(figure)
    return figure


def _floats(point: tuple[object, object]) -> XY:
    return float(point[0]), float(point[1])  # type: ignore[arg-type]


def _visible_wheels(partition: Partition) -> list[Wheel]:
    """The wheels whose rows are held in some cell, unless they are far away."""
    held = {index for cell in partition.cells for index in cell.wheels}
    x, y = _floats(partition.scene.check.equilibrium)
    reach = FAR * float(partition.scene.check.radius)
    wheels = [wheel for wheel in partition.scene.wheels if wheel.index in held]
    near = [w for w in wheels if max(abs(float(w.position[0]) - x), abs(float(w.position[1]) - y)) <= reach]
    return near if len(near) == len(wheels) else []


def _set_view(axes: Axes, partition: Partition, wheels: list[Wheel]) -> float:
    """Equal axes around the square and the wheels; returns the width of the view."""
    points = [_floats(p) for p in partition.domain.vertices] + [_floats(w.position) for w in wheels]
    (left, right), (low, high) = ((min(values), max(values)) for values in zip(*points, strict=True))
    width = max(right - left, high - low) * (1 + 2 * MARGIN)
    x, y = (left + right) / 2, (low + high) / 2
    axes.set(xlim=(x - width / 2, x + width / 2), ylim=(y - width / 2, y + width / 2), aspect="equal")
    axes.set(xlabel="x of the centre of mass [length unit of the scene]")
    axes.set(ylabel="y of the centre of mass [length unit of the scene]")
    return width


def _colors(partition: Partition) -> list[str]:
    """One color per motion, in cell order."""
    twists = list(dict.fromkeys(cell.twists for cell in partition.cells))
    return [PALETTE[twists.index(cell.twists) % len(PALETTE)] for cell in partition.cells]


def _draw_cell(axes: Axes, cell: Cell, color: str, marks: list[Segment], points_per_length: float) -> None:
    """The cell with its arrow and, where there is room beside these and the other marks, its label."""
    vertices = [_floats(vertex) for vertex in cell.polygon.vertices]
    xs, ys = zip(*vertices, strict=True)
    axes.fill(xs, ys, facecolor=color, alpha=TINT, edgecolor="none", zorder=1)
    axes.fill(xs, ys, facecolor="none", edgecolor="white", linewidth=1.5, zorder=2)
    centre = _floats(cell.polygon.centre)
    sides = list(zip(vertices, [*vertices[1:], vertices[0]], strict=True))
    room = _clearance(centre, sides)
    if room * points_per_length < LABEL:  # too small for any mark
        return
    shaft = _draw_velocity(axes, cell, centre, 0.65 * room)
    obstacles = [*sides, *shaft, *marks]
    corners = [*vertices, *(_between(start, end, 0.5) for start, end in sides)]
    places = [centre, *(_between(centre, corner, t / 10) for corner in corners for t in range(1, 9))]
    place = max(places, key=lambda place: _clearance(place, obstacles))
    label = f"{cell.index}{TURNS[cell.twists[0].omega.sign()]}"
    if _clearance(place, obstacles) * points_per_length >= LABEL_ROOM * len(label):
        axes.text(*place, label, ha="center", va="center", color=INK, zorder=4)


def _draw_velocity(axes: Axes, cell: Cell, centre: XY, half: float) -> list[Segment]:
    """The arrow of the cell's motion at its centre; returns its shaft, nothing where the body rests."""
    vx, vy = _floats(cell.twists[0].pose_rate(cell.polygon.centre))
    speed = math.hypot(vx, vy)
    if not speed:
        return []
    dx, dy = half * vx / speed, half * vy / speed
    start, end = (centre[0] - dx, centre[1] - dy), (centre[0] + dx, centre[1] + dy)
    axes.annotate("", xy=end, xytext=start, arrowprops=ARROW, zorder=4)
    return [(start, end)]


def _clearance(place: XY, obstacles: Iterable[Segment]) -> float:
    """Distance of a place from the nearest obstacle."""
    return min(_distance(place, start, end) for start, end in obstacles)


def _distance(place: XY, start: XY, end: XY) -> float:
    """Distance from a segment, or from a point."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    squared = dx * dx + dy * dy
    t = ((place[0] - start[0]) * dx + (place[1] - start[1]) * dy) / squared if squared else 0.0
    x, y = _between(start, end, min(max(t, 0.0), 1.0))
    return math.hypot(place[0] - x, place[1] - y)


def _between(start: XY, end: XY, t: float) -> XY:
    return start[0] + t * (end[0] - start[0]), start[1] + t * (end[1] - start[1])


def _draw_wheel(axes: Axes, wheel: Wheel, width: float) -> list[Segment]:
    """The rim as a thick line, its surface speed as an arrowhead, its number beside it; returns what they cover."""
    (x, y), (dx, dy) = _floats(wheel.position), _floats(wheel.unit_direction)
    half = 0.035 * width
    rim = ([x - half * dx, x + half * dx], [y - half * dy, y + half * dy])
    axes.plot(*rim, color=INK, linewidth=5, solid_capstyle="butt", zorder=3)
    sense = wheel.speed.sign()
    tip = (x + 2.1 * half * sense * dx, y + 2.1 * half * sense * dy)
    if sense:
        axes.annotate("", xy=tip, xytext=(x, y), arrowprops=ARROW, zorder=3)
    side = (x - 1.1 * half * dy, y + 1.1 * half * dx)
    axes.text(*side, str(wheel.index), ha="center", va="center", color=INK, fontweight="bold", zorder=4)
    back = (x - half * (sense or 1) * dx, y - half * (sense or 1) * dy)
    return [(back, tip), ((x, y), (x - 1.6 * half * dy, y + 1.6 * half * dx))]


def _explain(figure: Figure) -> None:
    """The legend, below the axes."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def mark(marker: str, label: str) -> Line2D:
        return Line2D([], [], linestyle="none", color=INK, markersize=9, marker=marker, label=label)

    entries = [
        Patch(facecolor=PALETTE[0], alpha=TINT, label="cell: number, sense of rotation"),
        mark(r"$\rightarrow$", "velocity of the centre of mass (direction)"),
        Line2D([], [], color=INK, linewidth=5, label="wheel: rim, surface speed, number"),
        mark("+", "checked point"),
    ]
    figure.legend(handles=entries, loc="outside lower center", ncols=2, frameon=False, fontsize=LABEL - 1)
