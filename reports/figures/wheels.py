"""Wheels as figures show them: rim, sense and size of the surface speed, number, and a friction axis of its own."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.symbolic.scene import Wheel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

INK = "#222222"
ARROW = {"arrowstyle": "-|>", "color": INK, "shrinkA": 0, "shrinkB": 0, "linewidth": 1.2}
RIM_SHARE = 0.16  # half of a rim's length of the distance to the next wheel, so that arrows stay apart
AXIS, AXIS_COLOR = 1.5, "#d95f02"  # half of a friction axis, in half-lengths of the rim
TIP = 2.1  # where an arrowhead lies, in half-lengths of the rim

XY: TypeAlias = tuple[float, float]
Segment: TypeAlias = tuple[XY, XY]


def floats(point: tuple[object, object]) -> XY:
    """A point of exact numbers as one of floats."""
    return float(point[0]), float(point[1])  # type: ignore[arg-type]


def wheels_in_view(axes: Axes, wheels: Iterable[Wheel]) -> list[Wheel]:
    """The wheels whose points lie within the limits of the axes."""
    (left, right), (low, high) = axes.get_xlim(), axes.get_ylim()
    places = [(wheel, *floats(wheel.position)) for wheel in wheels]
    return [wheel for wheel, x, y in places if left <= x <= right and low <= y <= high]


def draw_axis(axes: Axes, place: XY, along: XY, half: float) -> None:
    """A friction axis as a thin line through the wheel, longer than the rim."""
    (x, y), (ax, ay), reach = place, along, AXIS * half
    axes.plot(
        [x - reach * ax, x + reach * ax], [y - reach * ay, y + reach * ay], color=AXIS_COLOR, linewidth=1.2, zorder=3.5
    )


def draw_wheel(axes: Axes, wheel: Wheel, half: float, *, tip: float = TIP, named: bool = True) -> list[Segment]:
    """The rim as a thick line, its surface speed as an arrow, its number beside it; returns what they cover.

    A friction axis that is not the rim is a thin line.

    Args:
        axes: where to draw.
        wheel: the wheel.
        half: half of the rim's length.
        tip: where the arrowhead lies, in half-lengths of the rim.
        named: whether its number is written.
    """
    (x, y), (dx, dy) = floats(wheel.position), floats(wheel.unit_direction)
    rim = ([x - half * dx, x + half * dx], [y - half * dy, y + half * dy])
    axes.plot(*rim, color=INK, linewidth=5, solid_capstyle="butt", zorder=3)
    if wheel.axis is not None:
        draw_axis(axes, (x, y), floats(wheel.unit_grip), half)
    sense = wheel.speed.sign()
    end = (x + tip * half * sense * dx, y + tip * half * sense * dy)
    if sense:
        axes.annotate("", xy=end, xytext=(x, y), arrowprops=ARROW, zorder=3)
    side = (x - 1.1 * half * dy, y + 1.1 * half * dx)
    if named:
        axes.text(*side, str(wheel.index), ha="center", va="center", color=INK, fontweight="bold", zorder=4)
    back = (x - half * (sense or 1) * dx, y - half * (sense or 1) * dy)
    return [(back, end), ((x, y), (x - 1.6 * half * dy, y + 1.6 * half * dx))]
