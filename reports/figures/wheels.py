"""Wheels, the outline of a body, and the picture of an array.

A wheel is a rim with an arrow for its surface speed, a number, and a friction axis of its own where it has one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from nonsmooth.reports.figures.style import (
    INK,
    LABEL,
    LEGEND_ROW,
    PALETTE,
    PICTURE,
    POINTS_PER_INCH,
    TINT,
    draw_checked_point,
    legend_below,
    length_label,
    line_entry,
    mark_entry,
    new_figure,
    title_axes,
    view_square,
)
from nonsmooth.symbolic.mechanics.body import Disc, support_polygon
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.contact_states import askew_wheels
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import XY, in_floats
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    even_angles,
    float_points,
    following,
    places_of,
    spread,
    unit_vectors,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ARROW = {"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0, "linewidth": 1.2}
RIM_WIDTH = 5  # points, as drawn
ON_SIDE = 200  # points on a side of an outline at which names are kept off it
BOLD = 0.72  # width of a bold letter, of the size
SHORT_NAME = 0.35  # of the gap between neighbours: names that are no longer may stand beyond the ends of their rims
LEAST_NAME, NAME_SHARE = 5.0, 0.75  # points; of the gap between neighbours that a name may take
RIM_SHARE = 0.16  # half of a rim's length of the distance to the next wheel, so that arrows stay apart
AXIS, AXIS_COLOR = 1.5, "#d95f02"  # half of a friction axis, in half-lengths of the rim
TIP = 2.1  # where an arrowhead lies, in half-lengths of the rim
TIPS = "#d7191c"
IDLE, IDLE_NAME = "0.7", "0.4"  # colors of wheels that do not carry the body, and of their names
CORNERS = 72  # of the polygon that a disc is drawn as: its sides leave the circle by less than 0.1 % of the radius

Segment: TypeAlias = tuple[XY, XY]

# ---- wheels --------------------------------------------------------------------------------------


def wheels_in_view(axes: Axes, wheels: Iterable[Wheel]) -> list[Wheel]:
    """The wheels whose points lie within the limits of the axes."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    places = [(wheel, *in_floats(wheel.position)) for wheel in wheels]
    return [wheel for wheel, x, y in places if left <= x <= right and low <= y <= high]


def draw_axis(axes: Axes, place: XY, along: XY, half: float) -> None:
    """A friction axis as a thin line through the wheel, longer than the rim."""
    axes.plot(*_through(place, along, AXIS * half), color=AXIS_COLOR, linewidth=1.2, zorder=3.5)


def _through(place: XY, along: XY, half: float) -> tuple[list[float], list[float]]:
    """A line of this half-length with its middle at a place."""
    (x, y), (dx, dy) = place, along
    return [x - half * dx, x + half * dx], [y - half * dy, y + half * dy]


def draw_rim(axes: Axes, wheel: Wheel, half: float, color: str = INK) -> None:
    """The rim as a thick line."""
    rim = _through(in_floats(wheel.position), in_floats(wheel.unit_direction), half)
    axes.plot(*rim, color=color, linewidth=RIM_WIDTH, solid_capstyle="butt", zorder=3)


def draw_wheel(axes: Axes, wheel: Wheel, half: float, *, tip: float = TIP, named: bool = True) -> list[Segment]:
    """The rim as a thick line, its surface speed as an arrow, its name beside it; returns what they cover.

    A friction axis that is not the rim is a thin line.

    Args:
        axes: where to draw.
        wheel: the wheel.
        half: half of the rim's length.
        tip: where the arrowhead lies, in half-lengths of the rim.
        named: whether its name, or its number, is written.
    """
    (x, y), (dx, dy) = in_floats(wheel.position), in_floats(wheel.unit_direction)
    draw_rim(axes, wheel, half)
    if wheel.axis is not None:
        draw_axis(axes, (x, y), in_floats(wheel.unit_grip), half)
    sense = wheel.speed.sign()
    end = (x + tip * half * sense * dx, y + tip * half * sense * dy)
    if sense:
        axes.annotate("", xy=end, xytext=(x, y), arrowprops=ARROW, zorder=3)
    if named:
        name = str(wheel.index)
        _write_name(axes, (x, y), name_offset((dx, dy), name, LABEL), name, INK, LABEL)
    back = (x - half * (sense or 1) * dx, y - half * (sense or 1) * dy)
    return [(back, end), ((x, y), (x - 1.6 * half * dy, y + 1.6 * half * dx))]


def _write_name(axes: Axes, place: XY, offset: XY, name: str, color: str, size: float) -> None:
    """A name with its middle some points from its wheel."""
    axes.annotate(
        name,
        place,
        offset,
        textcoords="offset points",
        ha="center",
        va="center",
        color=color,
        fontsize=size,
        fontweight="bold",
        zorder=4,
    )


def name_offset(along: XY, name: str, size: float) -> XY:
    """Where the middle of a name is from its wheel (points): on the left of the rim, not touching it nor its arrow.

    The box of the text, ``width x size``, stays on one side of the line of the rim where its middle is
    ``(width |n_x| + size |n_y|)/2`` away from it along the normal n.
    """
    nx, ny = -along[1], along[0]
    away = (name_width(name, size) * abs(nx) + size * abs(ny)) / 2 + RIM_WIDTH
    return away * nx, away * ny


def name_width(name: str, size: float = LABEL) -> float:
    """About the width of a name in bold letters (points)."""
    return BOLD * size * len(name)


def wheel_labels(wheels: Sequence[Wheel], gap: float) -> tuple[float, list[str]]:
    """Names of wheels, or their numbers where the longest name does not fit the gap between neighbours.

    Args:
        wheels: to be named.
        gap: in points.

    Returns:
        The size of the letters (points), and a text for each wheel; 0 and none where numbers do not fit either.
    """
    for labels in ([str(wheel.index) for wheel in wheels], [f"{wheel.index:d}" for wheel in wheels]):
        size = min(float(LABEL), NAME_SHARE * gap / max(name_width(label, 1.0) for label in labels))
        if size >= LEAST_NAME:
            return size, labels
    return 0.0, []


# ---- outlines ------------------------------------------------------------------------------------


def outline_of(scene: Scene) -> Floats | None:
    """Corners (m, 2) of the body at theta = 0, from its centre of mass (length); None where the scene names none."""
    if scene.body is None:
        return None
    outline = scene.body.outline
    if isinstance(outline, Disc):
        angles = even_angles(CORNERS)
        middle = np.array(scene.body.centroid, float)
        return middle + float(outline.radius) * unit_vectors(angles)
    return float_points(scene.body.vertices)


def placed(points: Floats, pose: Floats) -> Floats:
    """Points of the body in the world, ``c + R(theta) p``."""
    x, y, theta = pose
    cos, sin = np.cos(theta), np.sin(theta)
    return points @ np.array([[cos, sin], [-sin, cos]]) + np.array([x, y])


# ---- the picture of an array ---------------------------------------------------------------------

LARGEST_RIM = 0.035  # half of a rim's length, of the width of the view
SLOWEST, FASTEST = 1.4, 2.6  # where the arrowheads of the slowest and fastest wheels lie, in half-lengths of the rim
SAME = 1e-3  # of the fastest speed: a difference that no arrow shows
AXES_SHARE = 0.8  # of the width of the picture that the axes take


def array_figure(scene: Scene, tips: str = "") -> Figure:
    """Every wheel with its rim and surface speed, the body, and the square that is checked, with a legend.

    Args:
        scene: the array.
        tips: why the body does not stand on the wheels that are under it, which have their hull drawn.
    """
    from matplotlib.patches import Patch

    figure = new_figure(PICTURE, PICTURE + 2 * LEGEND_ROW)
    axes = figure.subplots()
    draw_array(axes, scene)
    if tips:
        title_axes(axes, f"{one_line(scene.name)}: {tips}")
        hull = float_points(support_polygon(scene.positions)) if scene.wheels else np.empty((0, 2))
        axes.fill(*hull.T, fill=False, edgecolor=TIPS, linestyle=":", linewidth=1.6, zorder=2.5)
    entries = [
        line_entry("wheel: rim and number", color=INK, linewidth=5),
        mark_entry(r"$\rightarrow$", _speed_words(scene), markersize=9),
        *[line_entry("friction axis", color=AXIS_COLOR, linewidth=1.2)] * bool(askew_wheels(scene)),
        *[line_entry("outline of the body", color=INK, linewidth=1)] * (scene.body is not None),
        *[line_entry("wheel that does not carry it", color=IDLE, linewidth=5)] * bool(scene.idle),
        *[line_entry("hull of the wheels under it", color=TIPS, linestyle=":", linewidth=1.6)] * bool(tips),
        Patch(facecolor=PALETTE[0], alpha=TINT / 2, edgecolor=INK, linestyle="--", label="checked square"),
        mark_entry("+", "its centre of mass" if tips else "checked point", markersize=9),
    ]
    legend_below(figure, entries, fontsize=LABEL - 1)
    return figure


def _speed_words(scene: Scene) -> str:
    """What the arrows stand for: ``surface speed: 100 to 250 mm/s``, the longest is the fastest."""
    speeds = sorted({abs(float(wheel.speed)) for wheel in scene.wheels} or {0.0})
    unit = scene.units.after_speed
    if speeds[-1] - speeds[0] <= SAME * speeds[-1]:
        return f"surface speed: {float_text(speeds[-1], 3)}{unit}"
    return f"surface speed: {float_text(speeds[0], 3)} to {float_text(speeds[-1], 3)}{unit}"


def draw_array(axes: Axes, scene: Scene, near: Floats | None = None) -> None:
    """The wheels, the body at the checked point, and the checked square, on axes of equal scale.

    Args:
        axes: where to draw.
        scene: the array.
        near: points (m, 2) that are shown, with the checked square; the whole array unless given.
    """
    places = places_of(whole(scene).wheels)
    centre, radius = np.array(scene.check.place), scene.check.half_width
    square = np.array([centre - radius, centre + radius])
    outline = outline_of(scene)
    body = np.empty((0, 2)) if outline is None else outline + centre
    rim = rim_length(places, np.concatenate([places, square, body] if near is None else [square, near]))
    shown = [places - 3 * rim, places + 3 * rim, square, body] if near is None else [square, near]
    corners = np.concatenate(shown)
    low, high = corners.min(axis=0), corners.max(axis=0)
    (x, y), half = (low + high) / 2, 0.53 * float((high - low).max())
    view_square(axes, (x, y), half)
    _draw_square(axes, centre, radius)
    draw_checked_point(axes, scene)
    if len(body):
        axes.fill(*body.T, fill=False, edgecolor=INK, linewidth=1, zorder=2)
    draw_names(axes, scene, AXES_SHARE * PICTURE * POINTS_PER_INCH)
    if near is not None:  # names of wheels at its border would lie on the numbers of the axes
        for name in axes.texts:
            name.set_clip_path(axes.patch)
    for wheel in wheels_in_view(axes, scene.idle):
        draw_rim(axes, wheel, rim, IDLE)
    largest = scene.fastest or 1.0
    for wheel in wheels_in_view(axes, scene.wheels):
        tip = SLOWEST + (FASTEST - SLOWEST) * abs(float(wheel.speed)) / largest
        draw_wheel(axes, wheel, rim, tip=tip, named=False)
    axes.set(xlabel=length_label("x", scene.units), ylabel=length_label("y", scene.units))
    carried = f"{len(scene.wheels)} of {len(places)}" if scene.idle else f"{len(places)}"
    title_axes(axes, f"{one_line(scene.name)}: {carried} wheels")


def draw_names(axes: Axes, scene: Scene, points: float, rings: Sequence[Floats] | None = None) -> None:
    """The names or numbers of all wheels beside their rims, as their distances allow; none where they are too many.

    Each stands on a side of its rim, or beyond an end of it, where it covers the fewest points of lines.

    Args:
        axes: with the limits of the view.
        scene: the array.
        points: that the view is wide.
        rings: closed lines (m, 2) that names keep off; the outline at the checked point and the checked square unless
            given.
    """
    wheels = whole(scene).wheels
    left, right = axes.get_xlim()
    gap = nearest_gap(places_of(wheels), right - left)
    size, labels = wheel_labels(wheels, gap * points / (right - left))
    lines = _points_on(_rings(scene) if rings is None else rings) * points / (right - left)
    for wheel, name in zip(wheels, labels, strict=False):
        color = INK if wheel.index in scene.places else IDLE_NAME
        place, (dx, dy) = in_floats(wheel.position), in_floats(wheel.unit_direction)
        near = lines - np.array(place) * points / (right - left)
        offsets = [name_offset(way, name, size) for way in ((dx, dy), (-dx, -dy))]
        # room beyond the ends of the rim too, where rims are as long as an array's picture draws them
        if rings is None and name_width(name, size) < SHORT_NAME * gap * points / (right - left):
            half = min(LARGEST_RIM * (right - left), gap * RIM_SHARE) * points / (right - left)
            offsets += _beyond_ends((dx, dy), wheel.speed.sign() < 0, half, name, size)
        middle = min(offsets, key=lambda offset: _covered(near, offset, name, size))
        _write_name(axes, place, middle, name, color, size)


def _beyond_ends(along: XY, backward: bool, half: float, name: str, size: float) -> Iterator[XY]:
    """Where the middle of a name is from its wheel (points) behind the rim, close to it, and before the arrow's tip."""
    dx, dy = (-along[0], -along[1]) if backward else along
    for ahead, reach in ((-1, half), (1, FASTEST * half)):
        x, y = name_offset((ahead * dy, -ahead * dx), name, size)
        yield x + ahead * reach * dx, y + ahead * reach * dy


def _rings(scene: Scene) -> list[Floats]:
    """The outline of the body at the checked point and the border of the checked square."""
    centre, radius = np.array(scene.check.place), scene.check.half_width
    outline = outline_of(scene)
    rings = [centre + radius * np.array([(1, 1), (-1, 1), (-1, -1), (1, -1)])]
    return rings if outline is None else [*rings, outline + centre]


def _points_on(rings: Sequence[Floats]) -> Floats:
    """Points (m, 2) close together on closed lines."""
    if not rings:
        return np.empty((0, 2))
    shares = np.linspace(0, 1, ON_SIDE)[:, None, None]
    return np.concatenate([(ring + shares * (following(ring) - ring)).reshape(-1, 2) for ring in rings])


def _covered(points: Floats, middle: XY, name: str, size: float) -> int:
    """How many of some points the name covers whose middle is there, all in points from its wheel."""
    room = np.array([name_width(name, size) / 2 + 1, size / 2 + 1])
    return int((np.abs(points - middle) < room).all(axis=1).sum())


def nearest_gap(places: Floats, width: float) -> float:
    """The smallest distance of two wheels; the width of the view where they are all in one place."""
    apart = np.hypot(*(places[:, None] - places[None, :]).transpose(2, 0, 1))
    return float(apart[apart > 0].min(initial=width))


def rim_length(places: Floats, shown: Floats) -> float:
    """Half of a rim's length: small beside the view and beside the distance of neighbours."""
    width = spread(shown)
    return min(LARGEST_RIM * width, nearest_gap(places, width) * RIM_SHARE)


def _draw_square(axes: Axes, centre: Floats, radius: float) -> None:
    (x, y), r = centre, radius
    corners = ([x - r, x + r, x + r, x - r], [y - r, y - r, y + r, y + r])
    axes.fill(*corners, facecolor=PALETTE[0], alpha=TINT / 2, edgecolor="none", zorder=1)
    axes.fill(*corners, facecolor="none", edgecolor=INK, linestyle="--", linewidth=0.8, zorder=1)
