"""Maps of the checked square: cells with their motions, V* over the cells, the sampled field of rules without cells.

*Cells.*  Arrows show the direction in which the centre of mass moves at the arrow's place (exact kinematics), a turning
sign the sense of rotation; magnitudes are in the cell table.  Cells and edges where the body rests are hatched and
dotted.  Each cell carries its mark as the id of its shape.

*Rates.*  On a cell ``V* = 2 c . v`` is linear in c, V = |c - c*|^2, so contour bands drawn on its triangles are exact;
between cells it jumps.  Where several motions tie, the largest of their derivatives is drawn.  Colors run from violet
(V falls) through white to orange (V grows), symmetric about zero, told apart also by color-blind readers.

*Sampled fields.*  Streamlines of the centre of mass over V*; dots cover where the body rests, and what is not
determined stays blank.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.fields.sliding_edges import EdgeKind, switching_stretches
from nonsmooth.reports.figures.style import (
    INK,
    LABEL,
    LEGEND_ROW,
    PALETTE,
    PICTURE,
    POINTS_PER_INCH,
    TINT,
    draw_bar,
    draw_checked_point,
    drawn,
    legend_below,
    line_entry,
    mark_entry,
    new_figure,
    require_drawable,
    square_rate_label,
    title_axes,
    view_centre,
)
from nonsmooth.reports.figures.wheels import ARROW, Segment, draw_wheel, wheels_in_view
from nonsmooth.reports.output.document import cell_mark
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.plane import XY, around, between, dot, in_floats, minus
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points, max_norm

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.contour import QuadContourSet
    from matplotlib.figure import Figure, SubFigure

    from nonsmooth.analysis.minimizers.sampling import SampledField
    from nonsmooth.proofs.answers.array_basin import ArrayBasin
    from nonsmooth.proofs.systems.basin import CertifiedBasin


POINTS = POINTS_PER_INCH * PICTURE * 0.8  # points that the axes take
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


def view_square(axes: Axes, scene: Scene) -> float:
    """Equal axes around the checked square; returns the width of the view."""
    half = scene.check.half_width * (1 + 2 * MARGIN)
    view_centre(axes, scene, half)
    return 2 * half


def motion_colors(partition: Partition) -> list[str]:
    """One color per motion, in cell order."""
    twists = list(dict.fromkeys(cell.twists for cell in partition.cells))
    return [PALETTE[twists.index(cell.twists) % len(PALETTE)] for cell in partition.cells]


def fill_cells(axes: Axes, partition: Partition) -> None:
    """The cells in light colors under something else, one color per motion."""
    for cell, color in zip(partition.cells, motion_colors(partition), strict=True):
        corners = float_points(cell.polygon.vertices).T
        axes.fill(*corners, facecolor=color, alpha=TINT / 2, edgecolor="none", zorder=1)
        axes.fill(*corners, facecolor="none", edgecolor="white", linewidth=1.2, zorder=2)


def draw_hatch(axes: Axes, corners: Floats, hatch: str) -> None:
    """Hatch a polygon (m, 2) without a border: a hatch has the color of the border."""
    axes.fill(*corners.T, facecolor="none", edgecolor=INK, linewidth=0, hatch=hatch, zorder=2)


# ---- cells ---------------------------------------------------------------------------------------


def cell_map(partition: Partition, suffix: str) -> bytes:
    """The picture of the cells of a partition as the bytes of a file; equal input gives equal bytes.

    Args:
        partition: the cells, in the scene's unit of length.
        suffix: of the file, one of PICTURES.

    Raises:
        SceneError: where the square is too large, too small or too far away to be drawn with floats.
    """
    return drawn(cells_figure, partition)(suffix)


def cells_figure(partition: Partition) -> Figure:
    """The cells with a legend."""
    require_drawable(partition.scene)
    figure = new_figure(PICTURE, PICTURE)
    axes = figure.subplots()
    explain_cells(figure, axes, partition, draw_cells(axes, partition))
    return figure


def draw_cells(axes: Axes, partition: Partition) -> list[EdgeKind]:
    """The cells with their motions, the wheels in view and the checked point; returns the kinds of edges drawn."""
    scene = partition.scene
    width = view_square(axes, scene)
    centre = scene.check.place
    marks: list[Segment] = [(centre, centre)]
    for wheel in wheels_in_view(axes, scene.wheels):
        marks += draw_wheel(axes, wheel, RIM * width)
    kinds = _draw_switching(axes, partition)
    for cell, color in zip(partition.cells, motion_colors(partition), strict=True):
        _draw_cell(axes, cell, color, marks, points_per_length=POINTS / width)
    draw_checked_point(axes, scene)
    title_axes(axes, f"{one_line(scene.name)}: rule {partition.rule}, {len(partition.cells)} cells")
    return kinds


def _draw_cell(axes: Axes, cell: Cell, color: str, marks: list[Segment], points_per_length: float) -> None:
    """The cell with its arrow and, where there is room beside these and the other marks, its label."""
    corners = float_points(cell.polygon.vertices)
    (shape,) = axes.fill(*corners.T, facecolor=color, alpha=TINT, edgecolor="none", zorder=1)
    shape.set_gid(cell_mark(cell.index))
    axes.fill(*corners.T, facecolor="none", edgecolor="white", linewidth=1.5, zorder=2)
    if not any(cell.twists[0]):
        draw_hatch(axes, corners, REST_HATCH)
    vertices = [in_floats(vertex) for vertex in cell.polygon.vertices]
    centre, sides = in_floats(cell.polygon.centre), around(vertices)
    room = _clearance(centre, sides)
    if room * points_per_length < LABEL:  # too small for any mark
        return
    obstacles = [*sides, *_draw_velocity(axes, cell, centre, 0.65 * room), *marks]
    ends = [*vertices, *(between(start, end, 0.5) for start, end in sides)]
    places = [centre, *(between(centre, end, t / 10) for end in ends for t in range(1, 9))]
    place = max(places, key=lambda place: _clearance(place, obstacles))
    label = f"{cell.index}{TURNS[cell.twists[0].omega.sign()]}"
    if _clearance(place, obstacles) * points_per_length >= LABEL_ROOM * len(label):
        axes.text(*place, label, ha="center", va="center", color=INK, zorder=4)


def _draw_velocity(axes: Axes, cell: Cell, centre: XY, half: float) -> list[Segment]:
    """The arrow of the cell's motion at its centre; returns its shaft, nothing where the body rests."""
    vx, vy = in_floats(cell.twists[0].pose_rate(cell.polygon.centre))
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
    along = minus(end, start)
    t = dot(minus(place, start), along) / dot(along, along) if any(along) else 0.0
    return math.dist(place, between(start, end, min(max(t, 0.0), 1.0)))


def _draw_switching(axes: Axes, partition: Partition) -> list[EdgeKind]:
    """The edges where solutions slide, rest or part; returns the kinds that occur."""
    resting = {cell.index for cell in partition.cells if not any(cell.twists[0])}  # hatched: their sides say no more
    stretches = [s for s in switching_stretches(partition) if resting.isdisjoint(s.cells)]
    for stretch in stretches:
        (x1, y1), (x2, y2) = stretch.start, stretch.end
        axes.plot([x1, x2], [y1, y2], zorder=2.5, **EDGES[stretch.kind])
    return [kind for kind in EdgeKind if any(stretch.kind is kind for stretch in stretches)]


def explain_cells(figure: Figure, axes: Axes, partition: Partition, kinds: list[EdgeKind]) -> None:
    """The legend of cells with these kinds of edges, below the axes."""
    from matplotlib.patches import Patch

    wheels = wheels_in_view(axes, partition.scene.wheels)
    rests = any(not any(cell.twists[0]) for cell in partition.cells)
    entries = [
        Patch(facecolor=PALETTE[0], alpha=TINT, label=f"cell: number, {TURNS[1]} {TURNS[-1]} how the body turns"),
        mark_entry(r"$\rightarrow$", "velocity of the centre of mass (direction)", markersize=9),
        mark_entry("+", "checked point", markersize=9),
    ]
    if wheels:
        entries.append(line_entry("wheel: rim, surface speed, number", color=INK, linewidth=5))
    entries += [line_entry(EDGE_WORDS[kind], **EDGES[kind]) for kind in kinds]
    if rests:
        entries.append(Patch(facecolor="none", edgecolor=INK, hatch=REST_HATCH, label="the body rests"))
    figure.set_figheight(PICTURE + LEGEND_ROW * math.ceil(len(entries) / 2))
    legend_below(figure, entries, fontsize=LABEL - 1)


# ---- rates ---------------------------------------------------------------------------------------

BANDS = 10  # from zero to the largest absolute value
SPLIT = 20  # pieces of each side of a triangle where motions tie and V* is not linear
COLORS, ZERO = "PuOr_r", "#f7f7f7"  # Matplotlib's name, and its color in the middle
DARK = "#101418"  # text over the map's own colors, whatever the page's
PLATE = {"boxstyle": "round,pad=0.25", "facecolor": "#fcfcfc", "edgecolor": "none"}  # behind a number
WITH_BAR = (PICTURE + 0.7, PICTURE - 0.2)  # inches


def rates_figure(partition: Partition) -> Figure:
    """V* over the cells with its scale."""
    require_drawable(partition.scene)
    figure = new_figure(*WITH_BAR)
    axes = figure.subplots()
    draw_scale(figure, axes, partition.scene, draw_rates(axes, partition))
    return figure


def draw_scale(figure: Figure | SubFigure, axes: Axes, scene: Scene, levels: Floats) -> None:
    """The scale of V* beside the axes; ``levels`` are the borders of its bands."""
    from matplotlib.cm import ScalarMappable

    ticks = levels[:: max(1, len(levels) // 8)]
    colors = ScalarMappable(_symmetric(levels), COLORS)
    label = square_rate_label("upper derivative V*", scene.units)
    draw_bar(figure, colors, label, ax=axes, shrink=0.85, boundaries=levels, ticks=list(ticks))


def draw_rates(axes: Axes, partition: Partition) -> Floats:
    """V* on every cell; returns the borders of its bands."""
    scene = partition.scene
    view_square(axes, scene)
    rates = [_rates(partition, cell, float_points(cell.polygon.vertices)) for cell in partition.cells]
    levels = _bands_of(np.concatenate(rates))
    for cell in partition.cells:
        _draw_bands_of_cell(axes, partition, cell, levels)
    title_axes(axes, f"{one_line(scene.name)}: V* of V = |c - c*|^2")
    return levels


def _bands_of(rates: Floats) -> Floats:
    """Borders of bands: multiples of one step, zero among them, that cover all values."""
    step = max_norm(rates) / BANDS or 1.0
    lowest, highest = (round(float(end) / step, 6) for end in (rates.min(), rates.max()))
    steps = np.arange(min(math.floor(lowest), 0), max(math.ceil(highest), 0) + 1)
    return np.asarray((steps if len(steps) > 1 else np.array([-1, 0, 1])) * step)


def _rates(partition: Partition, cell: Cell, points: Floats) -> Floats:
    """``V* = max 2 (c - c*) . v`` at points (m, 2) of the closed cell, as seen from inside."""
    centre = np.array(partition.scene.check.place)
    x, y = points.T
    rates = []
    for twist in cell.twists:
        vx, vy, omega = (float(value) for value in twist)
        rates.append(2 * ((x - centre[0]) * (vx - omega * y) + (y - centre[1]) * (vy + omega * x)))
    return np.max(rates, axis=0)


def _draw_bands_of_cell(axes: Axes, partition: Partition, cell: Cell, levels: Floats) -> None:
    """Bands of V* on a cell, its border, and its number where there is room."""
    from matplotlib.tri import Triangulation

    corners = float_points(cell.polygon.vertices)
    points, triangles = _triangles(corners, SPLIT if len(cell.twists) > 1 else 1)
    rates = np.clip(_rates(partition, cell, points), levels[0], levels[-1])
    if np.any(rates):
        triangulation = Triangulation(points[:, 0], points[:, 1], triangles)
        axes.tricontourf(triangulation, rates, levels=levels, cmap=COLORS, norm=_symmetric(levels), zorder=1)
    else:
        axes.fill(*corners.T, facecolor=ZERO, edgecolor="none", zorder=1)
    axes.fill(*corners.T, facecolor="none", edgecolor="white", linewidth=1.5, zorder=3)
    (shape,) = axes.fill(*corners.T, facecolor="none", edgecolor="none", zorder=3.5)
    shape.set_gid(cell_mark(cell.index))
    x, y = corners.mean(axis=0).tolist()
    left, right = axes.get_xlim()
    sides = around([in_floats(vertex) for vertex in cell.polygon.vertices])
    if _clearance((x, y), sides) * POINTS / (right - left) >= LABEL:
        axes.text(x, y, str(cell.index), ha="center", va="center", color=DARK, bbox=PLATE, zorder=4)


def _symmetric(levels: Floats) -> Any:
    """Colors symmetric about zero: white is where V* vanishes."""
    from matplotlib.colors import Normalize

    largest = max_norm(levels)
    return Normalize(-largest, largest)


def _triangles(corners: Floats, split: int) -> tuple[Floats, NDArray[np.int64]]:
    """A fan of triangles over a convex polygon, each split into ``split^2``."""
    points: list[Floats] = []
    triangles: list[tuple[int, int, int]] = []
    for second, third in pairwise(corners[1:]):
        index: dict[tuple[int, int], int] = {}
        for i in range(split + 1):
            for j in range(split + 1 - i):
                index[i, j] = len(points)
                points.append(corners[0] + (i * (second - corners[0]) + j * (third - corners[0])) / split)
        for (i, j), here in index.items():
            if i + j < split:
                triangles.append((here, index[i + 1, j], index[i, j + 1]))
            if i + j < split - 1:
                triangles.append((index[i + 1, j], index[i + 1, j + 1], index[i, j + 1]))
    return np.array(points), np.array(triangles)


# ---- sampled fields ------------------------------------------------------------------------------

FIELD_TINT = 0.7  # opacity of the bands, so that lines stay visible on them
DENSITY = 1.1  # of streamlines
DOT = 2.0  # points: where the body rests


def field_figure(field: SampledField) -> Figure:
    """Streamlines over V* with its scale."""
    figure = new_figure(*WITH_BAR)
    axes = figure.subplots()
    bands = draw_field(axes, field)
    if bands is not None:
        draw_bar(
            figure, bands, square_rate_label("upper derivative V*, sampled", field.scene.units), ax=axes, shrink=0.85
        )
    entries = [
        mark_entry(r"$\rightarrow$", "motion of the centre of mass", markersize=9),
        mark_entry("+", "checked point", markersize=9),
        *[mark_entry("o", "the body rests", markersize=DOT)] * bool(field.rests.any()),
        *[mark_entry("s", "white: not determined", color="0.7", markerfacecolor="white")]
        * bool((~field.is_determined).any()),
        *[line_entry("wheel: rim, surface speed, number", color=INK, linewidth=5)]
        * bool(wheels_in_view(axes, field.scene.wheels)),
    ]
    figure.set_figheight(WITH_BAR[1] + LEGEND_ROW * math.ceil(len(entries) / 2))
    legend_below(figure, entries, fontsize=LABEL - 1)
    return figure


def draw_field(axes: Axes, field: SampledField) -> QuadContourSet | None:
    """Bands of V* with streamlines, the wheels in view and the checked point; returns the bands, if any."""
    scene = field.scene
    width = view_square(axes, scene)
    bands = _draw_sampled_bands(axes, field)
    _draw_streamlines(axes, field)
    resting = field.points[field.rests]
    if len(resting):
        axes.plot(*resting.T, linestyle="none", marker="o", markersize=DOT, color=INK, zorder=3)
    for wheel in wheels_in_view(axes, scene.wheels):
        draw_wheel(axes, wheel, RIM * width)
    draw_checked_point(axes, scene)
    sampled = f"field sampled at {field.count} x {field.count} points"
    title_axes(axes, f"{one_line(scene.name)}: rule {scene.contact.rule}, {sampled}")
    return bands


def _draw_sampled_bands(axes: Axes, field: SampledField) -> QuadContourSet | None:
    """V* in colors symmetric about zero; nothing where the body rests everywhere."""
    rates = field.upper_derivative
    if not float(np.nanmax(np.abs(rates), initial=0.0)):
        return None
    x, y, heights = _squares(field, *field.points.T, rates)
    levels = _bands_of(rates[field.is_determined])
    found = np.ma.masked_invalid(np.clip(heights, levels[0], levels[-1]))
    return axes.contourf(x, y, found, levels=levels, cmap=COLORS, norm=_symmetric(levels), alpha=FIELD_TINT, zorder=1)


def _draw_streamlines(axes: Axes, field: SampledField) -> None:
    """Where the body moves; lines stop where it rests."""
    moving = field.is_determined & ~field.rests
    if not moving.any():
        return
    shown = np.where(moving[:, None], field.velocities, np.nan)
    x, y, u, v = _squares(field, *field.points.T, *shown.T)
    u, v = np.ma.masked_invalid(u), np.ma.masked_invalid(v)
    axes.streamplot(x[0], y[:, 0], u, v, color=INK, density=DENSITY, linewidth=0.8, arrowsize=0.8, zorder=2)


def _squares(field: SampledField, *columns: Floats) -> Sequence[Floats]:
    """Values at the points of the grid as tables."""
    return [values.reshape(field.count, field.count) for values in columns]


# ---- regions of triangles ------------------------------------------------------------------------
#
# Certified regions as triangles: of plain systems in the plane, and of arrays beside sampled starts.


MESH, BORDER, OUTER = "#999999", "#0072B2", "#D55E00"


def draw_triangles(axes: Axes, basin: CertifiedBasin, at: XY = (0.0, 0.0)) -> None:
    """The triangles of a basin about a point, its border, and polygons and lines from beyond which no start comes."""
    x, y = (basin.corners[:, :2] + at).T
    axes.triplot(x, y, basin.simplices, color=MESH, linewidth=0.3)
    axes.plot(*_closed(basin.border + at), color=BORDER, linewidth=2.0, label="certified region")
    for barrier in basin.never:
        outer = _passed(barrier) + np.array([at]).T
        label = "from beyond no start comes" if barrier is basin.never[0] else None
        axes.plot(*outer, "--", color=OUTER, linewidth=1.5, label=label)
    axes.plot(*at, "o", color=INK, markersize=5)
    if basin.saddles:  # lines beside them have no end
        (left, right), (low, high) = basin.window
        axes.set_xlim(left + at[0], right + at[0])
        axes.set_ylim(low + at[1], high + at[1])
    axes.legend(fontsize="x-small", frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.1))


def _closed(ring: Floats) -> Floats:
    """Coordinates (2, corners + 1) of a closed line through a ring (corners, 2)."""
    return np.concatenate([ring, ring[:1]]).T


def _passed(hypotheses: dict[str, Any]) -> Floats:
    """Coordinates (2, corners) of a closed polygon, or of a line with a part of both of its half-lines."""
    from nonsmooth.proofs.checker.outside import place_of
    from nonsmooth.proofs.systems.outer_ring import ring_of

    ring = ring_of(hypotheses)
    if "ends" not in hypotheses:
        return _closed(ring)
    first, last = np.array([place_of(end) for end in hypotheses["ends"]]) * np.abs(ring).max() / 4
    return np.concatenate([[ring[0] + first], ring, [ring[-1] + last]]).T


def draw_array_basin(axes: Axes, basin: ArrayBasin, at: XY) -> None:
    """The triangles of a basin, and all sampled starts that come where bodies from these come."""
    axes.plot(*(basin.coming + at).T, ".", color=BORDER, markersize=1.5, label="sampled starts that come")
    draw_triangles(axes, basin.triangles, at)
