"""Where the law of slow turns (module ``cascade_law``) is certified: a set about the equilibrium.

With gain one, and where wheel i is nearest, let ``r = c . p_i/|p_i|``, ``s = c . J p_i/|p_i|``, ``x = r/l``,
``z = s/r``, ``y = Theta = theta - x z^2/2``.  Under exact kinematics the law gives, without remainder ::

    x' = -omega x z,   z' = 1 + omega z^2,   y' = -y - omega x z^3/2,   omega = x z - y

With the mean m of z^2 over a turn, ``chi' = z^2 - m`` (continuous around the turn) and ``X = x + x^2 chi(z)`` ::

    X' = -m x^2 + x y z + x^2 (x z - y) h(z),   h = z^2 (z^2 - m) - 2 z chi

Let Z, C, H bound ``|z|, |chi|, |h|``.  Then ``W = X^2 + q y^2`` obeys ``W'/2 <= -A x^3 + B x^2 |y| - D y^2`` with ::

    A = (1 - x C) m - (1 + x C) x Z H,   B = (1 + x C)(Z + x H) + q Z^4/2,   D = q (1 - x Z^3/2)

A and D fall with x and B grows, so W decreases on ``0 <= x <= x_0`` if ``A, D > 0`` and ``x_0 B^2 < 4 A D`` at x_0.
As ``X >= x (1 - x C)``, which grows up to ``x = 1/(2 C)``, no solution with ``W < x_0^2 (1 - x_0 C)^2`` passes x_0.
If moreover ``Z^2 (x_0 Z + |y|) < 1`` there, then ``z' > 0``: the rays between wheels are crossed, and W is continuous
on them.  Every inequality is verified with balls.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from flint import arb
from numpy.typing import NDArray

from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw
from nonsmooth.proofs.clauses.feedback.control_lyapunov import SQUARES
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell
from nonsmooth.proofs.clauses.feedback.level_region import DIGITS, NEXT_BELOW, ball_of, fills, is_above, segments
from nonsmooth.symbolic.number_text import float_text
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.plane import dot, turned

_STEPS = 80  # proposals for x_0 and for q
_TOPS = (-4.0, -0.3)  # decimal exponents of x_0
_WEIGHTS = (-5.0, 2.0)  # decimal exponents of q

Floats: TypeAlias = NDArray[np.float64]


@dataclass(frozen=True)
class TurnBounds:
    """The bounds of one turn about the equilibrium, as balls.

    Attributes:
        mean: m.
        largest: Z.
        constants: ``chi = z^3/3 - m z + constant`` in the cone of each nearest wheel.
        swing: C.
        bend: H.
    """

    mean: arb
    largest: arb
    constants: tuple[arb, ...]
    swing: arb
    bend: arb

    def decreases(self, top: Fraction, weight: Fraction) -> bool:
        """Whether W decreases and every ray is crossed where ``x <= top`` and ``W < level(top)``."""
        x, q, large = ball_of(top), ball_of(weight), self.largest
        less, more = 1 - x * self.swing, 1 + x * self.swing
        a = less * self.mean - more * x * large * self.bend
        b = more * (large + x * self.bend) + q * large**4 / 2
        d = q * (1 - x * large**3 / 2)
        heading = self.level(top).sqrt() / q.sqrt()
        grows = 2 * x * self.swing < 1
        crosses = large**2 * (x * large + heading) < 1
        return bool(grows and crosses and a > 0 and d > 0 and x * b * b < 4 * a * d)

    def level(self, top: Fraction) -> arb:
        """``x_0^2 (1 - x_0 C)^2``."""
        x = ball_of(top)
        return (x * (1 - x * self.swing)) ** 2


@dataclass(frozen=True)
class TurnRegion:
    """All (c, theta) with ``r < top l`` and ``W < level``.

    Attributes:
        cascade: the law of slow turns.
        length: l, the half-width of the checked square.
        top: ``x_0``.
        weight: q.
        level: at most ``x_0^2 (1 - x_0 C)^2``.
    """

    cascade: CascadeLaw
    length: Number
    top: Fraction
    weight: Fraction
    level: Fraction

    def __str__(self) -> str:
        level, length = float_text(self.level, DIGITS), float_text(self.length)
        low = f"W < {level}, r < {float_text(self.top, 3)} l with l = {length}"
        return f"{low}, W = (r/l + (r/l)^2 chi)^2 + {float_text(self.weight, 3)} Theta^2"

    def value(self, pose: Sequence[float]) -> float:
        """W at ``(x, y, theta)``, c measured from the equilibrium, in floats; infinite where no wheel is near."""
        x, z, chi = self._turn(pose)
        heading = pose[2] - x * z * z / 2
        return float((x + x * x * chi) ** 2 + float(self.weight) * heading**2)

    def contains(self, pose: Sequence[float]) -> bool:
        """Whether a pose lies in the region, in floats."""
        return self._turn(pose)[0] < self.top and self.value(pose) < self.level

    def check(self, cells: Sequence[InputCell], local: frozenset[int]) -> bool:
        """Re-verify the inequalities of W, and that the cells at the equilibrium hold the region."""
        turn = build_turn(self.cascade)
        if turn is None or not turn.decreases(self.top, self.weight):
            return False
        if not self.level > 0 or not ball_of(self.level) <= turn.level(self.top):
            return False
        reach = _above(ball_of(self.length * self.length) * ball_of(self.top) ** 2 * (1 + turn.largest**2))
        away = [data for data in cells if data.cell.index not in local]
        inside = all(is_above(segment, SQUARES, reach) for segment in segments(away, self.length))
        return inside and fills(cells, self.length)

    def _turn(self, pose: Sequence[float]) -> tuple[float, float, float]:
        """x, z and chi by the wheel that is nearest near the equilibrium."""
        tops, constants, mean = self._floats
        c = np.array(pose[:2])
        if not c.any():
            return 0.0, 0.0, 0.0
        k = int(np.argmax(tops @ c))
        r, s = float(tops[k] @ c), float(tops[k, 0] * c[1] - tops[k, 1] * c[0])
        if r <= 0:
            return float("inf"), 0.0, 0.0
        z = s / r
        return r / float(self.length), z, constants[k] + z**3 / 3 - mean * z

    @cached_property
    def _floats(self) -> tuple[Floats, list[float], float]:
        """Unit vectors to the wheels, the constants of chi, and m."""
        turn = build_turn(self.cascade)
        if turn is None:
            raise ValueError("required wheels that surround the equilibrium")
        tops = np.array([[float(x) for x in wheel.position] for wheel in self.cascade.wheels])
        units: Floats = tops / np.hypot(*tops.T)[:, None]
        return units, [float(constant.mid()) for constant in turn.constants], float(turn.mean.mid())


def build_turn(cascade: CascadeLaw) -> TurnBounds | None:
    """The bounds of one turn; None where a cone is not within a quarter turn of its wheel's direction."""
    ranges: list[tuple[arb, arb]] = []
    for cone, wheel in zip(cascade.fan.cones, cascade.wheels, strict=True):
        along = [dot(ray, wheel.position) for ray in (cone.start, cone.end)]
        if any(sign(value) <= 0 for value in along):
            return None
        across = [dot(ray, turned(wheel.position)) for ray in (cone.start, cone.end)]
        first, last = (ball_of(s) / ball_of(r) for s, r in zip(across, along, strict=True))
        ranges.append((first, last))
    mean = _total([b**3 - a**3 for a, b in ranges]) / (3 * _total([b - a for a, b in ranges]))
    constants = [arb(0)]
    for (_, end), (start, _) in pairwise(ranges):
        constants.append(constants[-1] + _chi(end, mean) - _chi(start, mean))
    middle = (max(float(k.mid()) for k in constants) + min(float(k.mid()) for k in constants)) / 2
    constants = [constant - middle for constant in constants]  # chi is free up to one constant
    largest = _largest([abs(z) for pair in ranges for z in pair])
    shift = _largest([abs(constant) for constant in constants])
    borders = [abs(k + _chi(z, mean)) for k, pair in zip(constants, ranges, strict=True) for z in pair]
    swing = _largest([*borders, shift + mean * mean.sqrt() * 2 / 3])  # the extremes lie at the ends or at z^2 = m
    bend = largest**4 / 3 + mean * largest**2 + 2 * shift * largest  # h = z^4/3 + m z^2 - 2 z constant
    return TurnBounds(mean, largest, tuple(constants), swing, bend)


def build_turn_region(
    cascade: CascadeLaw, cells: Sequence[InputCell], local: frozenset[int], radius: Number
) -> TurnRegion | None:
    """The region of the law of slow turns with ``l = radius``; None where no proposal verifies."""
    turn = build_turn(cascade)
    if turn is None:
        return None
    for top, weight in _proposals(turn):
        level = Fraction(turn.level(top).str(DIGITS, radius=False)) * NEXT_BELOW
        region = TurnRegion(cascade, radius, top, weight, level)
        if region.check(cells, local):
            return region
    return None


def _proposals(turn: TurnBounds) -> Iterator[tuple[Fraction, Fraction]]:
    """Pairs (x_0, q) that verify, those of the largest range of c times that of theta first."""
    tops = [Fraction(f"{top:.2g}") for top in np.logspace(*_TOPS, _STEPS)]
    weights = [Fraction(f"{weight:.2g}") for weight in np.logspace(*_WEIGHTS, _STEPS)]
    good = [(top, weight) for top in tops for weight in weights if turn.decreases(top, weight)]
    yield from sorted(good, key=lambda pair: -float(turn.level(pair[0]).mid()) / float(pair[1]) ** 0.5)


def _chi(z: arb, mean: arb) -> arb:
    return z**3 / 3 - mean * z


def _total(balls: Sequence[arb]) -> arb:
    return sum(balls, arb(0))


def _largest(balls: Sequence[arb]) -> arb:
    best = balls[0]
    for ball in balls[1:]:
        best = best.max(ball)
    return best


def _above(ball: arb) -> Fraction:
    """A rational that is not below a ball."""
    upper = ball.upper().fmpq()
    return Fraction(int(upper.p), int(upper.q))
