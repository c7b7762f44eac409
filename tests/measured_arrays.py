"""Random arrays as they are measured: headings in whole degrees, positions in millimetres, two digits for the rest.

Three kinds.  Of a ``scattered`` array the checked point is mostly no equilibrium.  A ``mirrored`` one is symmetric
about both axes, so that under the rules ``box`` and ``ellipse`` the body rests at the point, and all clauses have
work.  The wheels of a ``cocircular`` one lie on one circle about the point and pull roughly inward, so that under rule
``nearest`` all cells meet there.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import StrEnum
from math import isqrt
from random import Random
from typing import TypeAlias

Point: TypeAlias = tuple[int, int]  # millimetres

CIRCLE = 325  # millimetres: 60 points of whole millimetres have this distance from the origin
INWARD_WITHIN = 50  # degrees
FEWEST, MOST = 4, 9
SHARE = 0.8  # of the largest square about the point in which the body does not tip


class Kind(StrEnum):
    """What the array is made for."""

    SCATTERED = "scattered"
    MIRRORED = "mirrored"
    COCIRCULAR = "cocircular"


@dataclass(frozen=True)
class MeasuredWheel:
    """One wheel: millimetres, whole degrees, hundredths."""

    position: Point
    degrees: int
    speed: int
    mu_roll: int
    mu_side: int

    @property
    def toml(self) -> str:
        """The wheel as a table of a scene file."""
        x, y = (f"{value / 1000:.3f}" for value in self.position)
        rest = ((name, f"{value / 100:.2f}") for name, value in self._hundredths())
        numbers = "\n".join(f"{name} = {text}" for name, text in rest)
        return f'[[wheel]]\nposition = [{x}, {y}]\nheading = "{self.degrees}*pi/180"\n{numbers}\n'

    def _hundredths(self) -> tuple[tuple[str, int], ...]:
        return ("speed", self.speed), ("mu_roll", self.mu_roll), ("mu_side", self.mu_side)

    def mirrored(self, x: int, y: int) -> MeasuredWheel:
        """The wheel mirrored at the axes, by two signs."""
        turned = self.degrees if x > 0 else 180 - self.degrees
        position = x * self.position[0], y * self.position[1]
        return MeasuredWheel(position, turned * y % 360, self.speed, self.mu_roll, self.mu_side)


def measured_array(kind: Kind, seed: int) -> str:
    """A random array whose support polygon holds the origin, as the text of a scene file."""
    random = Random(f"{kind} {seed}")  # no secret
    build = {Kind.SCATTERED: _scattered, Kind.MIRRORED: _mirrored, Kind.COCIRCULAR: _cocircular}[kind]
    while True:
        wheels = build(random)
        half_width = int(SHARE * _reach([wheel.position for wheel in wheels]))
        if half_width >= 10:
            tables = "\n".join(wheel.toml for wheel in wheels)
            return f'name = "{kind}-{seed}"\n\n{tables}\n[check]\nradius = {half_width / 1000:.3f}\n'


def _scattered(random: Random) -> list[MeasuredWheel]:
    count, table = random.randint(FEWEST, MOST), random.randint(200, 1000)
    places = {(random.randint(-table, table) // 2, random.randint(-table, table) // 2) for _ in range(count)}
    return [_wheel(random, place, random.randrange(360)) for place in sorted(places)]


def _mirrored(random: Random) -> list[MeasuredWheel]:
    """Four or eight wheels, or four and two on an axis."""
    wheels: list[MeasuredWheel] = []
    for _ in range(random.randint(1, 2)):
        place = random.randint(100, 500), random.randint(100, 500)
        first = _wheel(random, place, random.randrange(360))
        wheels += [first.mirrored(x, y) for x in (1, -1) for y in (1, -1)]
    if len(wheels) == 4 and random.random() < 0.5:
        first = _wheel(random, (random.randint(100, 500), 0), 180)
        wheels += [first, first.mirrored(-1, 1)]
    return wheels


def _cocircular(random: Random) -> list[MeasuredWheel]:
    from math import atan2, degrees

    places = random.sample(_on_circle(), random.randint(FEWEST, MOST))
    inward = [round(degrees(atan2(-y, -x))) for x, y in places]
    turned = [(angle + random.randint(-INWARD_WITHIN, INWARD_WITHIN)) % 360 for angle in inward]
    return [_wheel(random, place, angle) for place, angle in zip(places, turned, strict=True)]


def _on_circle() -> list[Point]:
    pairs = ((x, isqrt(CIRCLE**2 - x**2)) for x in range(-CIRCLE, CIRCLE + 1))
    upper = [(x, y) for x, y in pairs if x**2 + y**2 == CIRCLE**2]
    return sorted({(x, s * y) for x, y in upper for s in (1, -1)})


def _wheel(random: Random, place: Point, degrees: int) -> MeasuredWheel:
    speed, mu_roll, mu_side = random.randint(10, 99), random.randint(20, 120), random.randint(5, 120)
    return MeasuredWheel(place, degrees, speed, mu_roll, mu_side)


def _reach(places: list[Point]) -> float:
    """Half-width of the largest square about the origin inside the convex hull of the places; negative outside.

    Every line through two places with all others on one side bounds the hull.
    """
    reach = float("inf")
    for p in places:
        for q in places:
            along = q[0] - p[0], q[1] - p[1]
            sides = [along[0] * (r[1] - p[1]) - along[1] * (r[0] - p[0]) for r in places]
            if p != q and min(sides) >= 0 and max(sides) > 0:
                reach = min(reach, (along[1] * p[0] - along[0] * p[1]) / (abs(along[0]) + abs(along[1])))
    return reach
