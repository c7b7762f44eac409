"""Hints at units: sizes and speeds a thousand times off are mostly a table in millimetres beside one in metres."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

from nonsmooth.symbolic.mechanics.body import Body
from nonsmooth.symbolic.mechanics.continuum import Disc
from nonsmooth.symbolic.mechanics.scene import CheckedSquare, Wheel
from nonsmooth.symbolic.mechanics.units import AngleUnit, LengthUnit, Units

SIZES = 1 / 500, 50.0  # metres that an array may measure without a hint
SPEEDS = 1 / 2000, 50.0  # m/s of the fastest wheel
BODIES = 0.01, 100.0  # of the size of an array that a body may have
SQUARES = 1 / 2000, 20.0  # of the size of an array that the half-width of the checked square may have
AWAY = 20.0  # sizes of an array that the checked point may be away from its first wheel
MEANT = {LengthUnit.METRE: LengthUnit.MILLIMETRE, LengthUnit.MILLIMETRE: LengthUnit.METRE}


def unit_hints(wheels: Sequence[Wheel], body: Body | None, check: CheckedSquare, units: Units) -> Iterator[str]:
    """What looks as if it were stated in another unit; nothing where the scene states none."""
    metres = units.metres
    if metres is None:
        return
    size = max(_extent([float(wheel.position[k]) for wheel in wheels]) for k in (0, 1))
    fastest = max(abs(float(wheel.speed)) for wheel in wheels)
    meant = MEANT.get(LengthUnit(units.length))
    ask = "" if meant is None else f': is length = "{meant}" meant?'
    if not SIZES[0] <= size * float(metres) <= SIZES[1]:
        yield f"[units]: the wheels lie within {size:.4g} {units.length}{ask}"
    elif fastest and not SPEEDS[0] <= fastest * float(metres) <= SPEEDS[1]:
        yield f"[units]: the fastest wheel runs at {fastest:.4g} {units.speed}: is another units.speed meant?"
    if body is not None and not BODIES[0] * size <= body_size(body) <= BODIES[1] * size:
        wide, apart = f"{body_size(body):.4g} {units.length}", f"{size:.4g} {units.length}"
        yield f"[body]: it is {wide} wide, and the wheels lie within {apart}: are both in {units.length}?"
    yield from _of_check(wheels, check, size, units)


def angle_hints(turns: Iterable[Fraction], unit: AngleUnit | None) -> Iterator[str]:
    """Angles of more than a full turn where radians are stated: mostly degrees; ``turns`` are angles over pi."""
    largest = max(map(abs, turns), default=Fraction(0))
    if unit is AngleUnit.RADIAN and largest > 2:
        said = f"an angle is {float(largest) * math.pi:.4g} rad, more than a full turn"
        yield f'[units]: {said}: is angle = "{AngleUnit.DEGREE}" meant?'


def _of_check(wheels: Sequence[Wheel], check: CheckedSquare, size: float, units: Units) -> Iterator[str]:
    """A checked point far from all wheels, or a checked square that is far larger or smaller than the array."""
    length, first = units.length, wheels[0]
    away = max(abs(float(check.equilibrium[k]) - float(first.position[k])) for k in (0, 1))
    radius, wheels_lie = float(check.radius), f"the wheels lie within {size:.4g} {length}"
    if away > AWAY * size:
        place = f"{away:.6g} {length} away from wheel {first.index}"
        yield f"[check]: equilibrium is {place}, and {wheels_lie}: are both in {length}?"
    elif not SQUARES[0] * size <= radius <= SQUARES[1] * size:
        yield f"[check]: radius is {radius:.6g} {length}, and {wheels_lie}: are both in {length}?"


def body_size(body: Body) -> float:
    """The larger side of the box around a body, or its diameter."""
    if isinstance(body.outline, Disc):
        return 2 * float(body.outline.radius)
    return max(_extent([float(corner[k]) for corner in body.vertices]) for k in (0, 1))


def _extent(values: Sequence[float]) -> float:
    return max(values) - min(values)
