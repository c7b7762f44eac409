"""What a design may change, as a vector of numbers between 0 and 1, and the scene document of such a vector.

Every number that is chosen is rational with a small denominator: a heading has the direction ``(q^2 - p^2, 2 p q)``,
with ``p/q`` near the tangent of half its angle; speeds and displacements are whole multiples of a part of their range.
So a candidate is an exact scene, and nothing has to be rounded afterwards.  Scenes that state units get headings in
degrees and decimals, rounded before they are judged.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.findings import Record
from nonsmooth.symbolic.files.scene_file import LAYOUTS, unit_of_speed, wheel_entry
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.plane import Vector, in_floats, minus, turned

PARTS = 64  # of the range of a speed or a displacement
HALF_TANGENTS = 64  # largest denominator of the tangent of half a heading
WHEELS = "wheels"  # which wheels of the array there are
DEGREE_DIGITS = 3  # of headings that are written in degrees
RATIONAL = re.compile(r"-?\d+(/\d+)?")  # as exact numbers are written
FIELDS = {"headings": "direction", "speeds": "given_speed", "positions": "position"}  # of a wheel
KINDS = tuple(FIELDS)
STRETCHES = ((1, 1), (1, 0), (0, 1))  # in x and y


@dataclass(frozen=True)
class Freedom:
    """Which values of the wheels may change, and how far.

    Attributes:
        kinds: of :data:`KINDS`.
        turn: how far a heading may turn, either way (radian).
        slowest: least speed, as a share of the scene's.
        fastest: largest speed, as a share of the scene's.
        move: how far each coordinate of a wheel may move (length).
        order: of the symmetry that the array has and keeps.
    """

    kinds: tuple[str, ...]
    turn: float = math.pi
    slowest: Fraction = Fraction(1, 2)
    fastest: Fraction = Fraction(5, 2)
    move: Fraction = Fraction(1, 4)
    order: int = 1

    @property
    def numbers_per_wheel(self) -> int:
        """How many numbers each orbit of wheels takes of the vector."""
        return ("headings" in self.kinds) + ("speeds" in self.kinds) + 2 * ("positions" in self.kinds)

    def start(self, scene: Scene) -> list[float]:
        """The vector of the scene itself, where it has the symmetry."""
        speed = float((1 - self.slowest) / (self.fastest - self.slowest)) if self.fastest > self.slowest else 0.0
        middle = [0.5] * ("headings" in self.kinds) + [speed] * ("speeds" in self.kinds)
        return (middle + [0.5, 0.5] * ("positions" in self.kinds)) * len(self._orbits(scene))

    def together(self, scene: Scene) -> list[list[float]]:
        """Directions of vectors in which all wheels change alike; their largest entries are one half.

        All wheels move away from the checked point, or along one axis only; all turn; all become faster.  Where the
        worst direction of a symmetric array counts, to change one wheel alone never helps.
        """
        at = scene.check.equilibrium
        offsets = [minus(scene.wheels[orbit[0]].position, at) for orbit in self._orbits(scene)]
        moves = {
            "headings": ([[1.0]],),
            "speeds": ([[1.0]],),
            "positions": tuple([[a * float(x), b * float(y)] for x, y in offsets] for a, b in STRETCHES),
        }
        found = []
        for kind in self.kinds:
            for move in moves[kind]:
                parts = move * len(offsets) if len(move) == 1 else move
                found.append(self._direction(kind, parts))
        return [direction for direction in found if any(direction)]

    def _direction(self, kind: str, parts: Sequence[Sequence[float]]) -> list[float]:
        """The vector in which one kind of number changes, for each orbit as given, and nothing else does."""
        most = max((abs(entry) for part in parts for entry in part), default=0.0) or 1.0
        vector: list[float] = []
        for part in parts:
            for other in self.kinds:
                width = 2 if other == "positions" else 1
                vector += [entry / most / 2 for entry in part] if other == kind else [0.0] * width
        return vector

    def _orbits(self, scene: Scene) -> Orbits:
        found = orbits_of(scene, self.order)
        if found is None:
            raise ValueError(f"required an array of the symmetry {self.order}")
        return found

    def document(self, base: Mapping[str, Any], scene: Scene, vector: Sequence[float]) -> Record:
        """The scene document of a vector."""
        kept = {key: value for key, value in base.items() if key not in LAYOUTS}
        numbers, unit = iter(vector), unit_of_speed(base, scene)
        tables: list[Record] = [{} for _ in scene.wheels]
        for orbit in self._orbits(scene):
            chosen = self._chosen(scene.wheels[orbit[0]], [next(numbers) for _ in range(self.numbers_per_wheel)])
            for step, place in enumerate(orbit):
                like = wheel_after_turns(scene, chosen, step * 4 // self.order)
                free = {FIELDS[kind]: getattr(like, FIELDS[kind]) for kind in self.kinds}
                placed = replace(scene.wheels[place], **free)  # what is not free stays its own
                entry = wheel_entry(placed, scene, unit)
                tables[place] = _measured(entry, placed) if scene.units.in_degrees else entry
        return {**kept, "wheel": tables}

    def _chosen(self, wheel: Wheel, numbers: list[float]) -> Wheel:
        """The first wheel of an orbit with what is chosen for it."""
        left = list(numbers)
        direction, speed, position = wheel.direction, wheel.speed, wheel.position
        if "headings" in self.kinds:
            direction = self._heading(wheel, left.pop(0))
        if "speeds" in self.kinds:
            speed *= self.slowest + _part(left.pop(0)) * (self.fastest - self.slowest)
        if "positions" in self.kinds:
            x, y = (entry + self.move * (2 * _part(number) - 1) for entry, number in zip(position, left, strict=True))
            position = x, y
        return replace(wheel, direction=direction, given_speed=speed, position=position)

    def _heading(self, wheel: Wheel, number: float) -> Vector:
        """A direction of whole numbers; the wheel's own at one half."""
        offset = (2 * number - 1) * self.turn
        if abs(offset) < math.pi / 2**12:
            return wheel.direction
        a, b = in_floats(wheel.unit_direction)
        angle = math.remainder(math.atan2(b, a) + offset, 2 * math.pi)
        quarters = round(angle / (math.pi / 2))
        half = Fraction(math.tan((angle - quarters * math.pi / 2) / 2)).limit_denominator(HALF_TANGENTS)
        p, q, field = half.numerator, half.denominator, wheel.speed.field
        return quarter_turns((field(q * q - p * p), field(2 * p * q)), quarters)


def _measured(entry: Record, wheel: Wheel) -> Record:
    """The entry of a wheel as somebody who measures writes it: the heading in degrees, decimals where they are exact.

    The heading is rounded, and what is judged is the array of the document, so nothing is said of another one.
    """
    a, b = in_floats(wheel.unit_direction)
    degrees = Decimal(str(round(math.degrees(math.atan2(b, a)), DEGREE_DIGITS) + 0.0))
    written = {key: value if key == "name" else _decimals(value) for key, value in entry.items()}
    return written | {"heading": degrees.normalize() + 0}


def _decimals(value: Any) -> Any:
    """Texts of rational numbers with finitely many decimals as such numbers, in lists too; everything else as it is."""
    if isinstance(value, list):
        return [_decimals(part) for part in value]
    if not isinstance(value, str) or not RATIONAL.fullmatch(value):
        return value
    number = Fraction(value)
    decimal = Decimal(number.numerator) / Decimal(number.denominator)
    return decimal if Fraction(decimal) == number else value


def wheel_after_turns(scene: Scene, chosen: Wheel, turns: int) -> Wheel:
    """The first wheel of an orbit after some quarter turns about the checked point."""
    at = scene.check.equilibrium
    x, y = quarter_turns(minus(chosen.position, at), turns)
    return replace(
        chosen,
        position=(x + at[0], y + at[1]),
        direction=quarter_turns(chosen.direction, turns),
        given_speed=chosen.speed,
    )


def _part(number: float) -> Fraction:
    return Fraction(round(min(max(number, 0.0), 1.0) * PARTS), PARTS)


# ---- symmetry ------------------------------------------------------------------------------------
#
# A generic array has no equilibrium at a given point; one that is symmetric under a half turn has: forces of opposite
# wheels cancel.  So a design keeps the symmetry that the places of its wheels have.


Orbits: TypeAlias = tuple[tuple[int, ...], ...]  # places of wheels, each the one before turned

ORDERS = (4, 2, 1)  # of the turns that are exact for all rational numbers


def quarter_turns(vector: Vector, count: int) -> Vector:
    """A vector after some quarter turns."""
    for _ in range(count % 4):
        vector = turned(vector)
    return vector


def orbits_of(scene: Scene, order: int) -> Orbits | None:
    """The wheels in orbits under turns by ``2 pi/order`` about the checked point; None where they are not symmetric.

    Args:
        scene: the array.
        order: one of :data:`ORDERS`.
    """
    at = scene.check.equilibrium
    places = {_offset(wheel.position, at): k for k, wheel in enumerate(scene.wheels)}
    left, found = set(places.values()), []
    for k, wheel in enumerate(scene.wheels):
        if k not in left:
            continue
        offset = _offset(wheel.position, at)
        images = [places.get(quarter_turns(offset, step * 4 // order)) for step in range(order)]
        orbit = tuple(image for image in images if image is not None)
        if len(set(orbit)) != order or any(scene.wheels[i].friction != wheel.friction for i in orbit):
            return None
        found.append(orbit)
        left -= set(orbit)
    return tuple(found)


def _offset(position: Vector, at: Vector) -> Vector:
    return minus(position, at)


def largest_symmetry(scene: Scene) -> int:
    """The largest order that the array has."""
    return next(order for order in ORDERS if orbits_of(scene, order) is not None)
