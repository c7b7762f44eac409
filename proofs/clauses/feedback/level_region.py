"""Where a feedback law with ``V = c^T P c + w theta^2`` is certified: the starts with ``V < L``.

Where V decreases on a closed cell it does so for every theta.  So the law brings the body home from every start with
``V < L`` if ``c^T P c >= L`` on the border of the checked square, and on every cell away from the equilibrium on which
V need not decrease: no solution leaves ``V < L``, and V falls along it.  On a segment ``c^T P c`` is a parabola; balls
propose its least value, which is rounded down and verified exactly.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from flint import arb, fmpq

from nonsmooth.analysis.cells.polygon import Point, square
from nonsmooth.proofs.clauses.feedback.control_lyapunov import ControlLyapunov
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell
from nonsmooth.symbolic.numbers.lazy import FEW_ROOTS, Lazy
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.plane import around, dot

DIGITS = 4  # significant digits of a level
NEXT_BELOW = 1 - Fraction(1, 10 ** (DIGITS - 1))  # next try where rounding made a level too large
_TRIES = 3

Segment: TypeAlias = tuple[Point, Point]


@dataclass(frozen=True)
class LevelRegion:
    """All (c, theta) with ``V < level``.

    Attributes:
        lyapunov: V.
        level: L.
        radius: half-width of the checked square.
    """

    lyapunov: ControlLyapunov
    level: Fraction
    radius: Number

    def __str__(self) -> str:
        return f"V < {float(self.level):.{DIGITS}g}"

    def value(self, pose: Sequence[float]) -> float:
        """V at ``(x, y, theta)``, c measured from the equilibrium, in floats."""
        (e, f), w = (float(entry) for entry in self.lyapunov.shape), float(self.lyapunov.weight)
        x, y, theta = pose
        return (1 + e) * x * x + 2 * f * x * y + (1 - e) * y * y + w * theta * theta

    def contains(self, pose: Sequence[float]) -> bool:
        """Whether a pose lies in the region, in floats."""
        return self.value(pose) < self.level

    def check(self, cells: Sequence[InputCell], local: frozenset[int]) -> bool:
        """Re-verify the level on the border and on the cells where V need not decrease, exactly."""
        if not self.level > 0 or not fills(cells, self.radius):
            return False
        stalling = _stalling(cells, local, self.lyapunov)
        return all(is_above(segment, self.lyapunov, self.level) for segment in segments(stalling, self.radius))


def build_level_region(
    cells: Sequence[InputCell],
    local: frozenset[int],
    radius: Number,
    lyapunov: ControlLyapunov,
    length: Fraction = Fraction(1),
) -> LevelRegion | None:
    """The largest level, to a few digits in ``l^2``, for a law by V on all cells of the square; None if none is found.

    Args:
        cells: of the square, with their inputs.
        local: numbers of the cells at the equilibrium.
        radius: half-width of the square.
        lyapunov: V.
        length: l.
    """
    sides = segments(_stalling(cells, local, lyapunov), radius)
    level = least_level(sides, lyapunov, length)
    for _ in range(_TRIES):
        region = LevelRegion(lyapunov, level, radius)
        if region.check(cells, local):
            return region
        level *= NEXT_BELOW
    return None


def least_level(sides: Iterable[Segment], lyapunov: ControlLyapunov, length: Fraction = Fraction(1)) -> Fraction:
    """The least ``c^T P c`` on segments, as a multiple of ``length^2`` to a few digits: a proposal."""
    least = min((_least(side, lyapunov) for side in sides), key=lambda bound: bound.mid())
    return length**2 * Fraction((least / ball_of(length**2)).str(DIGITS, radius=False))


def fills(cells: Sequence[InputCell], radius: Number) -> bool:
    """Whether the cells reach to the border of the square about the equilibrium, and not beyond it."""
    sizes = [abs(entry) for data in cells for vertex in data.cell.polygon.vertices for entry in vertex]
    return all(sign(radius - size) >= 0 for size in sizes) and any(not sign(radius - size) for size in sizes)


def segments(cells: Iterable[InputCell], radius: Number) -> Iterator[Segment]:
    """The sides of the square about the equilibrium and of some cells."""
    zero = radius * 0
    for polygon in (square((zero, zero), radius), *(data.cell.polygon for data in cells)):
        yield from around(polygon.vertices)


def is_above(segment: Segment, lyapunov: ControlLyapunov, level: Fraction) -> bool:
    """Whether ``c^T P c >= level`` on a segment, exactly."""
    constant, slope, curve = _parabola(segment, lyapunov)
    if sign(constant - level) < 0 or sign(constant + slope * 2 + curve - level) < 0:
        return False
    bottom_inside = sign(slope) < 0 and sign(slope + curve) > 0
    return not bottom_inside or sign((constant - level) * curve - slope * slope) >= 0


def ball_of(value: Any) -> arb:
    """An enclosure of a number of any kind."""
    if isinstance(value, Fraction):
        return arb(fmpq(value.numerator, value.denominator))
    if isinstance(value, Lazy):
        return value.ball
    return value.ball() if isinstance(value, Number) else arb(value)


def _stalling(cells: Sequence[InputCell], local: frozenset[int], lyapunov: ControlLyapunov) -> list[InputCell]:
    """The cells away from the equilibrium on which V need not decrease for every theta."""
    away = [data for data in cells if data.cell.index not in local]
    return [data for data in away if data.lever is None or not data.demand.sign(lyapunov)]


def _parabola(segment: Segment, lyapunov: ControlLyapunov) -> tuple[Any, Any, Any]:
    """``c^T P c`` at ``start + t (end - start)`` is ``constant + 2 slope t + curve t^2``."""
    (p, q), (u, v) = segment
    start, along = (_lazy(p), _lazy(q)), (_lazy(u - p), _lazy(v - q))
    slope = lyapunov.slope(start)
    return dot(slope, start), dot(slope, along), dot(lyapunov.slope(along), along)


def _least(segment: Segment, lyapunov: ControlLyapunov) -> arb:
    """A ball that ``c^T P c`` does not fall below on a segment."""
    constant, slope, curve = (ball_of(value) for value in _parabola(segment, lyapunov))
    if slope >= 0:
        return constant
    if slope + curve <= 0:
        return constant + 2 * slope + curve
    return constant - slope * slope / curve


def _lazy(value: Any) -> Any:
    """Over many square roots numbers are evaluated lazily, since products of four occur."""
    many = isinstance(value, Number) and len(value.field.radicands) > FEW_ROOTS
    return Lazy.of(value) if many else value
