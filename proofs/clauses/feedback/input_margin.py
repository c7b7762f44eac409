"""How far the contact state may be in doubt: up to which distance from a cell's side one common input still serves.

Let V be a control Lyapunov function and let c be known to within ``sigma |c|``, so that any cell within this distance
may be the true one.  A common input (one speed for each wheel) lowers V in several cells iff zero is not in the hull of
their covectors ``alpha`` (``V'/2 = alpha . u``; Gordan).  Near the equilibrium all sets are cones, so one number sigma
says it all: the law survives an error eps in c wherever ``|c| > eps/sigma``.

Cells with one nearest wheel i never conflict: only (i, k) acts through wheel k, so zero in the hull needs b = 0, and
then every alpha is ``P c . d_i`` times the input of wheel i.  Cells (i, j) and (j, i) hold both roll rows R_i, R_j.
Mixtures of their twists satisfy these and a mixture of S_i and S_j, so the covectors of V that are orthogonal to
all of them are mixtures ``lambda S_j(m) S_i + (1 - lambda) S_i(m) S_j``, with m the twist on which R_i and R_j vanish;
``S_i(m) S_j(m)`` has the sign of ``-Delta_ij Delta_ji``.  Hence a common input exists at c for every theta iff ::

    (c^T P d_i) (c^T P d_j) Delta_ij Delta_ji < 0

On the side's ray r it holds or not; from there it lasts until ``c^T P d_i`` or ``c^T P d_j`` vanishes, at the angle
whose sine is ``|r^T P d|/(|r| |P d|)``: there the law of the neighbouring cell has no input left.  The same is true of
all cells of two neighbouring wheels together, unless both have cells with the same third wheel; and where all rims
point at one point, of all cells together: there m is one twist for all pairs, the speeds of a rigid motion ``xi`` give
``V'/2 = (eta - (eta . m)/S_i(m) S_i) . xi`` in the cells of wheel i, with eta the covector of V, and some motion in the
plane serves all of them iff ``c^T P d_i/S_i(m)`` has one sign.  So the least of these sines is the margin, exactly,
unless three nearest wheels or two cells with the same third wheel come within reach before that and the rims do not
meet: then what is reported is a lower bound.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.fan import CellCone
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.control_fields import RowInputs, lever
from nonsmooth.proofs.clauses.feedback.control_lyapunov import ControlLyapunov
from nonsmooth.proofs.clauses.witness import Witness
from nonsmooth.symbolic.mechanics.constraints import independent
from nonsmooth.symbolic.mechanics.scene import Wheel
from nonsmooth.symbolic.numbers.lazy import divided
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, turned
from nonsmooth.symbolic.numbers.rounded import either_way

DENOMINATOR = 10**4  # of a rational lower bound
NO_COMMON = "no common input lowers V in both cells at this c and theta (read c as a direction)"

Fan: TypeAlias = tuple[CellCone, ...]
Gap: TypeAlias = tuple[Point, Point]  # two directions, less than a half turn apart


@dataclass(frozen=True)
class SideMargin:
    """A side through the equilibrium between cells (i, j) and (j, i).

    Attributes:
        cones: the cells' cones, the clockwise one first.
        squared: square of the largest sine; 0 where already the side itself has no common input for some theta.
        witness: (c, theta) at that distance at which there is none.
    """

    cones: tuple[CellCone, CellCone]
    squared: Any
    witness: Witness

    @property
    def cells(self) -> tuple[int, int]:
        """Numbers of the cells."""
        return self.cones[0].cell.index, self.cones[1].cell.index


@dataclass(frozen=True)
class InputMargin:
    """The margin of a control Lyapunov function.

    Attributes:
        sides: every side at which the nearest wheel changes.
        squared: square of the margin sigma, or of a lower bound.
        is_exact: whether no larger sigma serves.
    """

    sides: tuple[SideMargin, ...]
    squared: Any
    is_exact: bool

    def __str__(self) -> str:
        if not self.squared:
            side = next(side for side in self.sides if not side.squared)
            return f"margin 0: on the side of the cells {side.cells[0]} and {side.cells[1]} no input serves both"
        bound, value = "" if self.is_exact else " at least", float_text(self.value, 4)
        return f"margin{bound} {value}: one input serves all cells within {value} |c| of c"

    @property
    def value(self) -> float:
        """Sigma, for reading."""
        return float(self.squared) ** 0.5


def build_margin(inputs: RowInputs, lyapunov: ControlLyapunov) -> InputMargin:
    """The margin for an array with two inputs in each cell at the equilibrium, and a V for it."""
    fan = inputs.fan
    turning = [pair for pair in around(fan) if _nearest(pair[0]) != _nearest(pair[1])]
    sides = tuple(_side_margin(cones, lyapunov) for cones in turning)
    with either_way(inputs.partition.scene.field):  # of margins that are as small any will do
        least = min(side.squared for side in sides)
    bounds = [] if _meet(fan) else [gap for gap in _conflicts(fan) if not _is_wider(gap, least)]
    if not bounds:
        return InputMargin(sides, least, is_exact=True)
    return InputMargin(sides, _lower_bound(bounds), is_exact=False)


# ---- one side --------------------------------------------------------------------------------------


def _side_margin(cones: tuple[CellCone, CellCone], lyapunov: ControlLyapunov) -> SideMargin:
    """The nearer of the two directions in which an input vanishes, or the side itself."""
    i, j = _nearest(cones[0]), _nearest(cones[1])
    ray = cones[0].end
    normals = [lyapunov.slope(wheel.direction) for wheel in (i, j)]
    if sign(dot(ray, normals[0])) * sign(dot(ray, normals[1])) * sign(lever(i, j)) * sign(lever(j, i)) >= 0:
        return SideMargin(cones, i.speed * 0, Witness(ray, _conflict(ray, i, j, lyapunov), NO_COMMON))
    sines = [_squared_sine(ray, normal) for normal in normals]
    k = 0 if sign(sines[0] - sines[1]) <= 0 else 1
    x, y = turned(normals[k])
    point = (x, y) if sign(dot(ray, (x, y))) >= 0 else (-x, -y)
    theta = lyapunov.stalling_theta(point, (i, j)[k].position)
    return SideMargin(cones, sines[k], Witness(point, theta, NO_COMMON))


def _squared_sine(ray: Point, normal: Point) -> Any:
    """Of the angle between a ray and the line at right angles to a normal (its cosine to the normal itself)."""
    along = dot(ray, normal)
    return divided(along * along, dot(ray, ray) * dot(normal, normal))


def _conflict(ray: Point, i: Wheel, j: Wheel, lyapunov: ControlLyapunov) -> Any:
    """The theta with ``(P c, w theta + P c . J c) = x S_i + y S_j`` on a side without a common input.

    ``P c = x J D_i + y J D_j`` gives x and y; ``S_i = (J D_i, D_i . p_i)``.  (Parallel rims never conflict.)
    """
    slope, both = lyapunov.slope(ray), cross(i.direction, j.direction)
    x, y = dot(slope, j.direction), -dot(slope, i.direction)
    turning = x * dot(i.direction, i.position) + y * dot(j.direction, j.position)
    return (divided(turning, both) - dot(slope, turned(ray))) / lyapunov.weight


# ---- what else comes within reach ------------------------------------------------------------------


def _meet(fan: Fan) -> bool:
    """Whether the rims of all wheels in the fan point at one point: their roll rows have rank two."""
    wheels = {wheel.index: wheel for cone in fan for wheel in (_nearest(cone), _second(cone))}.values()
    rows = [(*wheel.direction, dot(wheel.direction, turned(wheel.position))) for wheel in wheels]
    return len(independent(rows)) < 3


def _conflicts(fan: Fan) -> Iterator[Gap]:
    """Angles of which both ends in reach would bring in cells that the theorem leaves open.

    Between the cells of the wheels before and after a third one, and between (i, k) and (j, k).
    """
    for k, first in enumerate(fan):
        for step in range(2, len(fan)):
            second = fan[(k + step) % len(fan)]
            if sign(cross(first.end, second.start)) <= 0:
                break
            between = [_nearest(fan[(k + n) % len(fan)]) for n in range(step + 1)]
            changes = sum(a != b for a, b in pairwise(between))
            if changes > 1 or (changes and _second(first) == _second(second)):
                yield first.end, second.start
                break


def _is_wider(gap: Gap, squared: Any) -> bool:
    """Whether ``sin^2(gap/2) >= squared``: ``-a . b + (1 - 2 squared) |a| |b| >= 0``, without taking roots."""
    a, b = gap
    plain, factor, square = -dot(a, b), 1 - 2 * squared, dot(a, a) * dot(b, b)
    if sign(plain) * sign(factor) >= 0:
        return sign(plain) >= 0 and sign(factor) >= 0
    return sign(plain) * sign(plain * plain - factor * factor * square) >= 0


def _lower_bound(gaps: Sequence[Gap]) -> Fraction:
    """Square of a rational just below the smallest half sine."""
    cosines = [sign(dot(a, b)) * float(_squared_sine(a, b)) ** 0.5 for a, b in gaps]
    numerator = int(((1 - max(cosines)) / 2) ** 0.5 * DENOMINATOR)
    while not all(_is_wider(gap, Fraction(numerator, DENOMINATOR) ** 2) for gap in gaps):
        numerator -= 1
    return Fraction(numerator, DENOMINATOR) ** 2


def _nearest(cone: CellCone) -> Wheel:
    return cone.cell.states[0].rows[0].wheel


def _second(cone: CellCone) -> Wheel:
    return cone.cell.states[0].rows[2].wheel
