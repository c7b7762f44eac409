"""Clause 4 under rule ``nearest`` where no quadratic V serves: first theta, then c along the rims.

Where wheel i is nearest the body moves with ``n_i . v + lambda_i omega = 0``, ``lambda_i = n_i . J p_i``; all such
motions can be imposed.  The law ``omega = -k theta`` brings theta to zero, whatever c does.  With ``omega = 0`` what is
left is translation along the rim, ``v = +-|c| d_i``, with a sign for each cell: a planar field of constant directions
on the cones at the equilibrium.  If module ``fan`` shows that every Filippov solution of this
field leads to the equilibrium (by sliding inward along rays between cells, or by full turns that contract), then so
does the whole law: the field is homogeneous of degree one, so it has a homogeneous Lyapunov function (Bernuau, Efimov,
Perruquetti and Polyakov, J. Franklin Inst. 351, 2014), and turning adds no more than a multiple of ``|theta|``, which
decays by itself.

No constant signs help where a cone holds the direction of its own rim and no ray between it and the next such cone
can be slid along inward.  Where full turns exist and their gain is exactly one, to first order every input keeps a
function ``V_0(c)``.  The case that occurs is an omniwheel drive: all nearest rims tangential, ``d_i . p_i = 0``.  There
``V_0 = r = c . p_i/|p_i|``; let ``s = c . J p_i/|p_i|``, ``z = s/r``.  Exact kinematics turn c with the body: ``r' =
-omega s``.  With ``s' = r``, any mu > 0 and ``Theta = theta - mu r z^2/2`` the law ``omega = mu s - Theta`` gives
``r' = -mu s^2 + Theta s`` and ``Theta' = -Theta`` up to terms of second order.  Let m > 0 be the mean of z^2 over a
turn, chi' = z^2 - m its periodic integral, and ``R = r + mu r^2 chi(z)``; then ``R' = -mu m r^2 + Theta s`` up to terms
of third order, so ``R^2 + Theta^2`` decreases strictly near the equilibrium along every solution: R and Theta are
continuous across the rays between cells, and every solution crosses these in the sense of the turn.  With leading-order
kinematics r stays, and there is no such law.

*The region of slow turns.* With gain one, and where wheel i is nearest, let ``r = c . p_i/|p_i|``, ``s = c . J
p_i/|p_i|``, ``x = r/l``, ``z = s/r``, ``y = Theta = theta - x z^2/2``. Under exact kinematics the law gives, without
remainder ::

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
from dataclasses import dataclass, field
from enum import StrEnum
from fractions import Fraction
from functools import cached_property, reduce
from itertools import pairwise

import numpy as np
from flint import arb

from nonsmooth.analysis.cells.fan import CellCone, Cone, ray_speeds, slide_speed
from nonsmooth.proofs.clauses.feedback.control_fields import SQUARES, RowInputs
from nonsmooth.proofs.clauses.feedback.gradient_law import are_above, segments
from nonsmooth.proofs.clauses.feedback.rational_bounds import BELOW, DIGITS, ball_of
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, decide_cones
from nonsmooth.proofs.findings import Translation
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.scene import Wheel
from nonsmooth.symbolic.numbers.enclosures import rational_above
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, turned
from nonsmooth.symbolic.numbers.plane_arrays import Floats, norms, places_of

LAW = (
    "u_w = d_w . (v + omega J p_w) for w = i, j with omega = -k theta, v = k |c| e - (n_i . J p_i) omega n_i, "
    "e = {} where that wheel is nearest"
)
SLOW_LAW = (
    "u_w = d_w . (v + omega J p_w) for w = i, j with v = (k - omega) r J p_i/|p_i|, omega = k (s/l - Theta), "
    "Theta = theta - s^2/(2 r l), (r, s) = (c . p_i, c . J p_i)/|p_i|, any length l"
)

_STEPS = 80  # proposals for x_0 and for q
_TOPS = (-4.0, -0.3)  # decimal exponents of x_0
_WEIGHTS = (-5.0, 2.0)  # decimal exponents of q


class Descent(StrEnum):
    """How c comes home while theta is held."""

    SLIDES = "slides along rays between cells"
    TURNS = "full turns that contract"
    SLOW_TURNS = "full turns of gain one, while the body turns to and fro, like 1/t (exact kinematics)"

    @property
    def reason(self) -> str:
        """How theta and c come home."""
        if self is Descent.SLOW_TURNS:
            return f"all nearest rims are tangential, and c comes home by {self}"
        return f"theta decays by itself, and then c comes home by {self}"


@dataclass(frozen=True)
class CascadeLaw:
    """A sign for every cone, with what shows that it serves.

    Attributes:
        signs: of the translation ``v = sign |c| d_i``, one for each nearest wheel, counterclockwise.
        wheels: the nearest wheels.
        descent: how c comes home.
        fan: the decision about the field of these translations, with the cones in which they are nearest.
    """

    signs: tuple[int, ...]
    wheels: tuple[Wheel, ...]
    descent: Descent
    fan: FanResult

    def __str__(self) -> str:
        if self.descent is Descent.SLOW_TURNS:
            return SLOW_LAW
        signs = ", ".join(
            f"{'+' if s > 0 else '-'}d_{wheel.index:d}" for s, wheel in zip(self.signs, self.wheels, strict=True)
        )
        return LAW.format(signs)


def find_cascade(fan: Sequence[CellCone]) -> CascadeLaw | None:
    """The first choice of signs that serves, for the cones of an array with two inputs in each; None without."""
    sectors, wheels = _sectors(fan)
    if not sectors:
        return None  # one wheel is the nearest all around: only its rim's line can be followed
    for signs in _proposals(sectors, wheels):
        law = _judged(_field(sectors, wheels, signs), wheels, signs)
        if law is not None:
            return law
    return None


def _sectors(fan: Sequence[CellCone]) -> tuple[list[Cone], tuple[Wheel, ...]]:
    """The cones joined where the same wheel is nearest, with their nearest wheels."""
    nearest = [cone.cell.states[0].rows[0].wheel for cone in fan]
    starts = [k for k, wheel in enumerate(nearest) if wheel != nearest[k - 1]]
    sectors = [Cone(fan[k].start, fan[following].start, ()) for k, following in around(starts)]
    return sectors, tuple(nearest[k] for k in starts)


def _field(fan: Sequence[Cone], wheels: Sequence[Wheel], signs: Sequence[int]) -> tuple[Cone, ...]:
    """The cones with the translation along the rim of their nearest wheel."""
    zero = wheels[0].direction[0] * 0
    return tuple(
        Cone(cone.start, cone.end, (Twist(wheel.direction[0] * s, wheel.direction[1] * s, zero),))
        for cone, wheel, s in zip(fan, wheels, signs, strict=True)
    )


def _judged(cones: Sequence[Cone], wheels: tuple[Wheel, ...], signs: tuple[int, ...]) -> CascadeLaw | None:
    """The law of these signs, where the field of translations leads home or keeps to turns of gain one."""
    result = decide_cones(cones)
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        return CascadeLaw(signs, wheels, Descent.TURNS if result.gains else Descent.SLIDES, result)
    turning = result.verdict is Translation.UNDECIDED and bool(result.gains)
    tangential = not any(dot(wheel.direction, wheel.position) for wheel in wheels)
    return CascadeLaw(signs, wheels, Descent.SLOW_TURNS, result) if turning and tangential else None


# ---- signs worth trying ------------------------------------------------------------------


class _Rays:
    """How the rims lie beside each ray; ray k is the last of cone k and the first of the next."""

    def __init__(self, fan: Sequence[Cone], wheels: Sequence[Wheel]) -> None:
        self.count = len(fan)
        self.rays = [cone.end for cone in fan]
        self.rims = [wheel.direction for wheel in wheels]
        self.first = [sign(cross(d, cone.start)) for d, cone in zip(self.rims, fan, strict=True)]
        self.last = [sign(cross(d, cone.end)) for d, cone in zip(self.rims, fan, strict=True)]
        # where a closed cone holds its own rim's direction, no translation crosses that line; inward on both sides
        held = [k for k in range(self.count) if self.first[k] * self.last[k] <= 0]
        self.inward = {k: -1 if fan[k].holds(self.rims[k]) else 1 for k in held}
        self.slides = [self._slide(k) for k in range(self.count)]

    def _slide(self, k: int) -> int:
        """Sign of the radial speed where both neighbours of a ray push onto it; 0 where that is none."""
        zero, after = self.rays[k][0] * 0, (k + 1) % self.count
        signs = self.inward.get(k, -self.last[k]), self.inward.get(after, self.first[after])
        pushes = zip((self.rims[k], self.rims[after]), signs, strict=True)
        before, behind = (ray_speeds(self.rays[k], Twist(d[0] * s, d[1] * s, zero)) for d, s in pushes)
        speed = slide_speed(before, behind)
        return 0 if speed is None else sign(speed)

    def towards(self, target: int, start: int, stop: int) -> dict[int, int]:
        """Signs of the cones from ``start`` up to ``stop`` (cyclic) that lead to a ray between them."""
        cones = [k % self.count for k in range(start, stop if stop > start else stop + self.count)]
        turn = cones.index(target) + 1
        return {k: -self.last[k] for k in cones[:turn]} | {k: self.first[k] for k in cones[turn:]}


def _proposals(fan: Sequence[Cone], wheels: Sequence[Wheel]) -> Iterator[tuple[int, ...]]:
    """Full turns in both senses; in each arc between held directions, all cones towards one inward slide."""
    rays = _Rays(fan, wheels)
    signs = dict(rays.inward)
    held = sorted(rays.inward)
    if not held:
        yield tuple(-a for a in rays.first)
        yield tuple(rays.first)
        if not {-1, 1} <= set(rays.slides):
            return
        arc = rays.slides.index(1) + 1
        signs = rays.towards(rays.slides.index(-1), arc, arc)
    for start, stop in zip(held, [*held[1:], *(k + rays.count for k in held[:1])], strict=True):
        target = next((k % rays.count for k in range(start, stop) if rays.slides[k % rays.count] < 0), None)
        if target is None:
            return
        signs |= rays.towards(target, start, stop) | {start: rays.inward[start]}
    yield tuple(signs[k] for k in range(rays.count))


# ---- where slow turns are certified ---------------------------------------------------------------


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

    def proposals(self) -> Iterator[tuple[Fraction, Fraction]]:
        """Pairs (x_0, q) that verify, those of the largest range of c times that of theta first."""
        tops = [Fraction(f"{top:.2g}") for top in np.logspace(*_TOPS, _STEPS)]
        weights = [Fraction(f"{weight:.2g}") for weight in np.logspace(*_WEIGHTS, _STEPS)]
        good = [(top, weight) for top in tops for weight in weights if self.decreases(top, weight)]
        yield from sorted(good, key=lambda pair: -float(self.level(pair[0]).mid()) / float(pair[1]) ** 0.5)


@dataclass(frozen=True)
class TurnRegion:
    """All (c, theta) with ``r < top l`` and ``W < level``.

    Attributes:
        cascade: the law of slow turns.
        length: l, the half-width of the checked square.
        top: ``x_0``.
        weight: q.
        level: at most ``x_0^2 (1 - x_0 C)^2``.
        mean: m, in floats.
        constants: of chi in the cone of each nearest wheel, in floats.
    """

    cascade: CascadeLaw
    length: Number
    top: Fraction
    weight: Fraction
    level: Fraction
    mean: float = field(compare=False)
    constants: tuple[float, ...] = field(compare=False)

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

    def _turn(self, pose: Sequence[float]) -> tuple[float, float, float]:
        """x, z and chi by the wheel that is nearest near the equilibrium."""
        c = np.array(pose[:2])
        if not c.any():
            return 0.0, 0.0, 0.0
        k = int(np.argmax(self._tops @ c))
        r, s = float(self._tops[k] @ c), float(self._tops[k, 0] * c[1] - self._tops[k, 1] * c[0])
        if r <= 0:
            return float("inf"), 0.0, 0.0
        z = s / r
        return r / float(self.length), z, self.constants[k] + z**3 / 3 - self.mean * z

    @cached_property
    def _tops(self) -> Floats:
        """Unit vectors to the wheels."""
        tops = places_of(self.cascade.wheels)
        units: Floats = tops / norms(tops)[:, None]
        return units


def build_turn_region(cascade: CascadeLaw, inputs: RowInputs) -> TurnRegion | None:
    """The region of the law of slow turns with ``l`` the half-width of the square.

    None of other laws, and where no proposal verifies.
    """
    length = inputs.radius
    turn = build_turn(cascade) if cascade.descent is Descent.SLOW_TURNS else None
    if turn is None or inputs.support is not None:
        return None
    sides = list(segments(inputs.away, length))
    for top, weight in turn.proposals():
        level = Fraction(turn.level(top).str(DIGITS, radius=False)) * BELOW
        reach = ball_of(length * length) * ball_of(top) ** 2 * (1 + turn.largest**2)
        below = level > 0 and ball_of(level) <= turn.level(top)
        if below and are_above(sides, SQUARES, rational_above(reach)):
            mean, *constants = (float(ball.mid()) for ball in (turn.mean, *turn.constants))
            return TurnRegion(cascade, length, top, weight, level, mean, tuple(constants))
    return None


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
    mean = sum((b**3 - a**3 for a, b in ranges), arb(0)) / (3 * sum((b - a for a, b in ranges), arb(0)))
    constants = [arb(0)]
    for (_, end), (start, _) in pairwise(ranges):
        constants.append(constants[-1] + _chi(end, mean) - _chi(start, mean))
    middle = (max(float(k.mid()) for k in constants) + min(float(k.mid()) for k in constants)) / 2
    constants = [constant - middle for constant in constants]  # chi is free up to one constant
    largest = reduce(arb.max, (abs(z) for pair in ranges for z in pair))
    shift = reduce(arb.max, map(abs, constants))
    borders = [abs(k + _chi(z, mean)) for k, pair in zip(constants, ranges, strict=True) for z in pair]
    swing = reduce(arb.max, [*borders, shift + mean * mean.sqrt() * 2 / 3])  # extremes lie at the ends or at z^2 = m
    bend = largest**4 / 3 + mean * largest**2 + 2 * shift * largest  # h = z^4/3 + m z^2 - 2 z constant
    return TurnBounds(mean, largest, tuple(constants), swing, bend)


def _chi(z: arb, mean: arb) -> arb:
    return z**3 / 3 - mean * z
