"""The motion of one ordered pair of wheels under rule ``nearest``, over a box of parameters.

Both rows of wheel i hold, so ``v(p_i) = u_i d_i``, and one row of wheel j, with the normal m (its rim d_j, or J d_j
across it) ::

    omega = (u_m - u_i d_i . m) / (m . J (p_j - p_i)),      v = u_i d_i - omega J p_i,

where ``u_m`` is u_j along the rim and zero across it.
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import NamedTuple, TypeAlias

from flint import arb

from nonsmooth.proofs.robust.jets import Jet, over_box, parameter
from nonsmooth.symbolic.scene import Wheel
from nonsmooth.symbolic.tolerances import Tolerance

PARAMETERS = 8  # speed, angle, x and y of either wheel


class SecondRow(Enum):
    """The row of the second wheel that holds."""

    ALONG = "along its rim"
    ACROSS = "across its rim"


class MotionBox(NamedTuple):
    """Enclosures of ``(v_x, v_y, omega)`` over the box."""

    vx: arb
    vy: arb
    omega: arb


Direction: TypeAlias = tuple[Jet, Jet]


def motion_box(first: Wheel, second: Wheel, row: SecondRow, box: Tolerance) -> MotionBox | None:
    """Enclosures of the twist; None where the rows may be dependent somewhere in the box."""
    sizes = [size for wheel in (first, second) for size in _half_widths(wheel, box)]
    middle = _twist(first, second, row, [arb(0)] * PARAMETERS)
    whole = _twist(first, second, row, [size * arb(0, 1) for size in sizes])
    if middle is None or whole is None:
        return None
    return MotionBox(*(over_box(a, b, sizes) for a, b in zip(middle, whole, strict=True)))


def _half_widths(wheel: Wheel, box: Tolerance) -> tuple[arb, arb, arb, arb]:
    """Of speed, angle, x and y."""
    step = box.position.ball()
    angle = arb(box.heading.numerator) / box.heading.denominator * arb.pi()
    return abs((wheel.speed * box.speed).ball()), angle, step, step


def _twist(first: Wheel, second: Wheel, row: SecondRow, shifts: list[arb]) -> tuple[Jet, Jet, Jet] | None:
    """``(v_x, v_y, omega)`` with derivatives in the eight shifts, at balls of shifts; None where it may not exist."""
    u_i, d_i, p_i = _wheel(first, shifts, 0)
    u_j, d_j, p_j = _wheel(second, shifts, PARAMETERS // 2)
    m, speed = (d_j, u_j) if row is SecondRow.ALONG else (_turned(d_j), _constant(arb(0)))
    arm = _turned((p_j[0] - p_i[0], p_j[1] - p_i[1]))
    lever = _inner(m, arm)
    if lever.value.contains(0):
        return None
    omega = (speed - u_i * _inner(d_i, m)) / lever
    jx, jy = _turned(p_i)
    return u_i * d_i[0] - omega * jx, u_i * d_i[1] - omega * jy, omega


def _wheel(wheel: Wheel, shifts: list[arb], start: int) -> tuple[Jet, Direction, Direction]:
    """Speed, rim direction and position of a wheel whose parameters begin at a number."""
    speed, angle, x, y = (parameter(shifts[start + k], start + k, PARAMETERS) for k in range(4))
    a, b = (_constant(entry.ball()) for entry in wheel.unit_direction)
    cosine, sine = _through(angle, arb.cos, lambda at: -at.sin()), _through(angle, arb.sin, arb.cos)
    p, q = (_constant(entry.ball()) for entry in wheel.position)
    return _constant(wheel.speed.ball()) + speed, (a * cosine - b * sine, a * sine + b * cosine), (p + x, q + y)


def _through(jet: Jet, function: Callable[[arb], arb], derivative: Callable[[arb], arb]) -> Jet:
    slope = derivative(jet.value)
    return Jet(function(jet.value), tuple(slope * part for part in jet.slopes))


def _constant(value: arb) -> Jet:
    return Jet(value, (arb(0),) * PARAMETERS)


def _turned(vector: Direction) -> Direction:
    """``J vector``."""
    return _constant(arb(0)) - vector[1], vector[0]


def _inner(a: Direction, b: Direction) -> Jet:
    return a[0] * b[0] + a[1] * b[1]
