"""A picture of the partition: cells, their motion, the edges that are slid along, the wheels, the checked point.

Arrows show the direction in which the centre of mass moves at the arrow's place (exact kinematics), a turning
sign the sense of rotation; magnitudes are in the cell table.  Cells and edges where the body rests are hatched and
dotted.  Each cell carries its mark as the id of its shape.
"""

from __future__ import annotations

import io
import math
import warnings
from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.fields.sliding_edges import EdgeKind, switching_stretches
from nonsmooth.reports.document import cell_mark
from nonsmooth.reports.figures.labels import centre_labels, wrapped
from nonsmooth.reports.figures.wheels import ARROW, INK, XY, Segment, draw_wheel, floats, wheels_in_view
from nonsmooth.symbolic.number_text import decimal_text
from nonsmooth.symbolic.plane import around, between, dot, minus
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.backend_bases import FigureCanvasBase
    from matplotlib.figure import Figure


# Okabe and Ito's palette (safe for color-blind readers), drawn lightly; white gaps part equal neighbours.
PALETTE = ("#56B4E9", "#E69F00", "#009E73", "#F0E442", "#CC79A7", "#0072B2", "#D55E00", "#999999")
TINT = 0.45  # opacity of a cell
INKED: Any = dict.fromkeys(
    ("text.color", "axes.edgecolor", "axes.labelcolor", "axes.titlecolor", "xtick.color", "ytick.color"),
    INK,
)
PICTURE = 5.2  # inches, both ways: readable in a column of a page and on a phone
LEGEND_ROW = 0.2  # inches that a row of the legend needs below the picture
POINTS_PER_INCH = 72
DOTS = 150  # to an inch, of a picture of dots
POINTS = POINTS_PER_INCH * PICTURE * 0.8  # points that the axes take
LABEL = 9  # points, the size of a label
LARGEST, RESOLUTION = 1e100, 1e-9  # what Matplotlib draws faithfully with floats
LABEL_ROOM = 3  # points that each character of a label needs around the label's middle
MARGIN = 0.04  # of the square's width, around it
TURNS = {0: "", 1: "\N{ANTICLOCKWISE OPEN CIRCLE ARROW}", -1: "\N{CLOCKWISE OPEN CIRCLE ARROW}"}
RIM = 0.035  # half of a rim's length, of the width of the view
REST_HATCH = "..."
EDGES: dict[EdgeKind, dict[str, Any]] = {  # told apart by form, not by color
    EdgeKind.SLIDING: {"color": INK, "linewidth": 2.6, "solid_capstyle": "butt"},
    EdgeKind.RESTING: {"color": INK, "linewidth": 3.2, "linestyle": (0, (0.8, 0.8))},
    EdgeKind.REPELLING: {"color": INK, "linewidth": 1.1, "linestyle": (0, (5, 3))},
}
EDGE_WORDS = {
    EdgeKind.SLIDING: "edge with sliding",
    EdgeKind.RESTING: "edge on which the body rests",
    EdgeKind.REPELLING: "edge that solutions leave",
}


def cell_map(partition: Partition, suffix: str) -> bytes:
    """The picture as the bytes of a file; ``suffix`` is one of PICTURES.  Equal input gives equal bytes.

    Raises:
        SceneError: where the square is too large, too small or too far away to be drawn with floats.
    """
    return figure_bytes(lambda: build_figure(partition), suffix)


def figure_bytes(build: Callable[[], Figure], suffix: str) -> bytes:
    """A figure as the bytes of a file; ``suffix`` is one of PICTURES.  Equal input gives equal bytes."""
    import matplotlib as mpl

    stamps = {".svg": {"Date": None}, ".png": {"Software": None}, ".pdf": {"CreationDate": None}}
    stream = io.BytesIO()
    with mpl.rc_context({"svg.hashsalt": "nonsmooth", "font.size": LABEL} | INKED), warnings.catch_warnings():
        warnings.filterwarnings("ignore", "Glyph .* missing")  # a scene's name may use any script
        figure = build()
        lay_out(figure, suffix)
        figure.savefig(stream, format=suffix[1:], dpi=DOTS, metadata=stamps[suffix])
    return stream.getvalue()


def lay_out(figure: Figure, suffix: str) -> None:
    """Give axes and legends their room, as they will be in such a file, and keep it.

    Matplotlib does so as it saves, and to do it draws the whole figure once more: a quarter of the time.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    _canvas(suffix)(figure)
    figure.set_dpi(DOTS if suffix == ".png" else POINTS_PER_INCH)
    engine.execute(figure)
    figure.set_layout_engine(None)


def _canvas(suffix: str) -> type[FigureCanvasBase]:
    """What measures text as it is drawn in such a file."""
    if suffix == ".pdf":
        from matplotlib.backends.backend_pdf import FigureCanvasPdf

        return FigureCanvasPdf
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.backends.backend_svg import FigureCanvasSVG

    return FigureCanvasAgg if suffix == ".png" else FigureCanvasSVG


def require_drawable(partition: Partition) -> None:
    """Refuse squares that floats cannot draw faithfully."""
    scene = partition.scene
    radius, far = abs(float(scene.check.radius)), max(abs(float(x)) for x in scene.check.equilibrium)
    if not (1 / LARGEST <= radius <= LARGEST and far * RESOLUTION <= radius):
        expected = f"for a picture, a radius of {1 / LARGEST:g} to {LARGEST:g}, and {RESOLUTION:g} of the coordinates"
        raise SceneError(scene.origin, "check.radius", expected, StatedFact(decimal_text(scene.check.radius, 6)))


def build_figure(partition: Partition) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    require_drawable(partition)
    figure = Figure(figsize=(PICTURE, PICTURE), layout="constrained")
    axes = figure.subplots()
    kinds = draw_cell_map(axes, partition)
    wheels = wheels_in_view(axes, partition.scene.wheels)
    _explain(figure, kinds, wheels=bool(wheels), rests=any(not any(cell.twists[0]) for cell in partition.cells))
    return figure


def draw_cell_map(axes: Axes, partition: Partition) -> list[EdgeKind]:
    """The cells with their motions, the wheels in view and the checked point; returns the kinds of edges drawn."""
    width = view_square(axes, partition)
    wheels = wheels_in_view(axes, partition.scene.wheels)
    x, y = floats(partition.scene.check.equilibrium)
    marks: list[Segment] = [((x, y), (x, y))]
    for wheel in wheels:
        marks += draw_wheel(axes, wheel, RIM * width)
    kinds = draw_switching(axes, partition)
    for cell, color in zip(partition.cells, motion_colors(partition), strict=True):
        _draw_cell(axes, cell, color, marks, points_per_length=POINTS / width)
    axes.plot([x], [y], marker="+", color=INK, markersize=11, markeredgewidth=1.6, zorder=5)
    scene = partition.scene
    title = f"{one_line(scene.name)}: rule {partition.rule}, {len(partition.cells)} cells"
    axes.set_title(wrapped(title), parse_math=False)
    return kinds


def view_square(axes: Axes, partition: Partition) -> float:
    """Equal axes around the checked square; returns the width of the view."""
    points = [floats(p) for p in partition.domain.vertices]
    (left, right), (low, high) = ((min(values), max(values)) for values in zip(*points, strict=True))
    margin = MARGIN * (right - left)
    axes.set(xlim=(left - margin, right + margin), ylim=(low - margin, high + margin), aspect="equal")
    axes.set(**centre_labels(partition.scene.units))
    return right - left + 2 * margin


def motion_colors(partition: Partition) -> list[str]:
    """One color per motion, in cell order."""
    twists = list(dict.fromkeys(cell.twists for cell in partition.cells))
    return [PALETTE[twists.index(cell.twists) % len(PALETTE)] for cell in partition.cells]


def draw_hatch(axes: Axes, xs: Sequence[float], ys: Sequence[float], hatch: str) -> None:
    """Hatch a polygon without a border: a hatch has the color of the border."""
    axes.fill(xs, ys, facecolor="none", edgecolor=INK, linewidth=0, hatch=hatch, zorder=2)


def _draw_cell(axes: Axes, cell: Cell, color: str, marks: list[Segment], points_per_length: float) -> None:
    """The cell with its arrow and, where there is room beside these and the other marks, its label."""
    vertices = [floats(vertex) for vertex in cell.polygon.vertices]
    xs, ys = zip(*vertices, strict=True)
    (shape,) = axes.fill(xs, ys, facecolor=color, alpha=TINT, edgecolor="none", zorder=1)
    shape.set_gid(cell_mark(cell.index))
    axes.fill(xs, ys, facecolor="none", edgecolor="white", linewidth=1.5, zorder=2)
    if not any(cell.twists[0]):
        draw_hatch(axes, xs, ys, REST_HATCH)
    centre = floats(cell.polygon.centre)
    sides = around(vertices)
    room = clearance(centre, sides)
    if room * points_per_length < LABEL:  # too small for any mark
        return
    shaft = _draw_velocity(axes, cell, centre, 0.65 * room)
    obstacles = [*sides, *shaft, *marks]
    corners = [*vertices, *(between(start, end, 0.5) for start, end in sides)]
    places = [centre, *(between(centre, corner, t / 10) for corner in corners for t in range(1, 9))]
    place = max(places, key=lambda place: clearance(place, obstacles))
    label = f"{cell.index}{TURNS[cell.twists[0].omega.sign()]}"
    if clearance(place, obstacles) * points_per_length >= LABEL_ROOM * len(label):
        axes.text(*place, label, ha="center", va="center", color=INK, zorder=4)


def _draw_velocity(axes: Axes, cell: Cell, centre: XY, half: float) -> list[Segment]:
    """The arrow of the cell's motion at its centre; returns its shaft, nothing where the body rests."""
    vx, vy = floats(cell.twists[0].pose_rate(cell.polygon.centre))
    speed = math.hypot(vx, vy)
    if not speed:
        return []
    dx, dy = half * vx / speed, half * vy / speed
    start, end = (centre[0] - dx, centre[1] - dy), (centre[0] + dx, centre[1] + dy)
    axes.annotate("", xy=end, xytext=start, arrowprops=ARROW, zorder=4)
    return [(start, end)]


def room_at(place: XY, vertices: Sequence[XY]) -> float:
    """Distance of a place within a polygon from its border."""
    return clearance(place, around(vertices))


def clearance(place: XY, obstacles: Iterable[Segment]) -> float:
    """Distance of a place from the nearest obstacle."""
    return min(_distance(place, start, end) for start, end in obstacles)


def _distance(place: XY, start: XY, end: XY) -> float:
    """Distance from a segment, or from a point."""
    along = minus(end, start)
    t = dot(minus(place, start), along) / dot(along, along) if any(along) else 0.0
    return math.dist(place, between(start, end, min(max(t, 0.0), 1.0)))


def draw_switching(axes: Axes, partition: Partition) -> list[EdgeKind]:
    """The edges where solutions slide, rest or part; returns the kinds that occur."""
    resting = {cell.index for cell in partition.cells if not any(cell.twists[0])}  # hatched: their sides say no more
    stretches = [s for s in switching_stretches(partition) if resting.isdisjoint(s.cells)]
    for stretch in stretches:
        (x1, y1), (x2, y2) = stretch.start, stretch.end
        axes.plot([x1, x2], [y1, y2], zorder=2.5, **EDGES[stretch.kind])
    return [kind for kind in EdgeKind if any(stretch.kind is kind for stretch in stretches)]


def _explain(figure: Figure, kinds: list[EdgeKind], *, wheels: bool, rests: bool) -> None:
    """The legend, below the axes."""
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    def mark(marker: str, label: str) -> Line2D:
        return Line2D([], [], linestyle="none", color=INK, markersize=9, marker=marker, label=label)

    entries: list[Line2D | Patch] = [
        Patch(facecolor=PALETTE[0], alpha=TINT, label="cell: number, sense of rotation"),
        mark(r"$\rightarrow$", "velocity of the centre of mass (direction)"),
        mark("+", "checked point"),
    ]
    if wheels:
        entries.append(Line2D([], [], color=INK, linewidth=5, label="wheel: rim, surface speed, number"))
    entries += [Line2D([], [], label=EDGE_WORDS[kind], **EDGES[kind]) for kind in kinds]
    if rests:
        entries.append(Patch(facecolor="none", edgecolor=INK, hatch=REST_HATCH, label="the body rests"))
    figure.set_figheight(PICTURE + LEGEND_ROW * math.ceil(len(entries) / 2))
    figure.legend(handles=entries, loc="outside lower center", ncols=2, frameon=False, fontsize=LABEL - 1)
