"""What the law ``u = -k (a, b)`` by ``V = c^T P c + w theta^2`` is certified for: rate, limited speeds, region.

*Rate.*  One has ``V' = -2 k (a^2 + b^2)``, where a and b are linear in (c, tau), ``tau = w theta + c^T P J c``.  So
``V' <= -2 k kappa V`` near the equilibrium if on every cone ``c = s r_1 + t r_2`` (s, t >= 0, tau free) ::

    (s, t, tau) M (s, t, tau)^T >= 0,     M = A A^T + B B^T - kappa' G

with A, B the coefficients of a, b and G the Gram matrix of ``c^T P c + tau^2/w``.  Tau is free, so its entry must be
positive and the Schur complement copositive on the quadrant: ``S_11, S_22 >= 0`` and ``S_12 >= -sqrt(S_11 S_22)`` (the
S-procedure for a cone of two rays is exact).  Floats bisect for kappa; a rational below it is verified exactly.
For ``P = I`` tau is ``w theta``, and kappa' = kappa.  Otherwise ``|c^T P J c| <= rho |c|^2`` with
``rho^2 = e^2 + f^2``; so ``kappa' = (1 + eta) kappa`` suffices in a disc about c*, where
``|c|^2 <= eta^2 (1 - rho) w/((1 + eta) rho^2)``.  The rate grows with w (a larger w lets theta count more in the law)
up to that of ``tau^2/w = 0``; the weight taken is ``l^2`` times the smallest power of two that gives at least half of
it.

*Limited speeds.*  Let ``V'/2 = sum_w a_w u_w`` and ``sigma = min(1, min_w m_w/|k a_w|)`` for the limits m_w of the
wheels that act.  The limited law ``u = -sigma k a`` gives ``V'/2 = -sigma k |a|^2``.  With ``|a|^2 >= kappa V``, and m
the least limit of a wheel that acts at the equilibrium:

- where ``sigma < 1``, ``sigma k >= m/|a|``, so ``V'/2 <= -m |a|`` and ``(sqrt V)' <= -m sqrt(kappa)``;
- where ``sigma = 1``, ``(sqrt V)' <= -k kappa sqrt(V)`` as without limits.

So ``V' <= -2 k kappa V`` stays true while ``k sqrt(V) <= m/sqrt(kappa)``, and beyond that sqrt(V) falls at least with
the constant speed ``m sqrt(kappa)``, whatever k is.  No wheel is at its limit where, by Cauchy and Schwarz in the
metric ``diag(P, w)``, ::

    k (sqrt(V) q_w + V r_w) <= m_w,    q_w^2 = g_v^T P g_v + w g_omega^2,    r_w = |g_omega| rho/(1 - rho)

for every wheel that acts; the last term comes from exact kinematics and vanishes for ``P = I``.  All of it holds within
the cells at the equilibrium: where ``V < level``.

*Region.*  Where V decreases on a closed cell it does so for every theta.  So the law brings the body home from every
start with ``V < L`` if ``c^T P c >= L`` on the border of the checked square, on every cell away from the equilibrium on
which V need not decrease, and where the body tips: no solution leaves ``V < L``, and V falls along it.  On a segment
``c^T P c`` is a parabola; balls propose its least value.
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from math import isqrt
from operator import add
from typing import Any, NamedTuple, TypeAlias

from flint import arb

from nonsmooth.analysis.cells.polygon import Point, square
from nonsmooth.proofs.clauses.feedback.control_fields import SQUARES, ControlLyapunov, InputCell, RowInputs, Shape
from nonsmooth.proofs.clauses.feedback.rational_bounds import DIGITS, MUCH_BELOW, ball_of, confirmed, late, rounded_down
from nonsmooth.proofs.clauses.translation.quadratic import least_of_parabola
from nonsmooth.symbolic.mechanics.contact_states import Triple
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.lazy import FLOAT_DOUBT, Lazy, sure_float
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import around, dot
from nonsmooth.symbolic.numbers.rounded import plain

_BISECTIONS = 60
SLACK = Fraction(1, 100)  # eta
_LARGEST_EXPONENT = 64  # of the weight, in the square of the array's own length
_FLOAT_RANGE = 10**300
_FEW_BITS = 8  # correct ones of a size

_LEAST, _MOST = 2.0**-30, 2.0**30  # products of sixteen such floats, as in det S, are far from under- and overflow

Segment: TypeAlias = tuple[Point, Point]
# c^T P c by its coefficients at s^2, st, t^2, and a^2 + b^2 by those at s^2, st, t^2, s tau, t tau, tau^2
Form: TypeAlias = tuple[tuple[Any, ...], tuple[Any, ...]]

# ---- the rate ----------------------------------------------------------------------------


@dataclass(frozen=True)
class ConeRate:
    """The quadratic form of one cone.

    Attributes:
        rays: ``r_1, r_2``.
        fields: the control vector fields ``g_i, g_j``.
        lyapunov: V.
    """

    rays: tuple[Point, Point]
    fields: tuple[Triple, ...]
    lyapunov: ControlLyapunov = SQUARES

    @cached_property
    def form(self) -> Form:
        """The form in the numbers of the cone."""
        slopes = [self.lyapunov.slope(ray) for ray in self.rays]
        return _form(self.rays, slopes, self.fields)

    @cached_property
    def _form_in_floats(self) -> tuple[Form, float, float] | None:
        """The form in floats, and bounds of its coefficients without tau; None where floats may under- or overflow."""
        rays, fields = _floats(self.rays), _floats(self.fields)
        slopes = _floats([self.lyapunov.slope(ray) for ray in self.rays]) if any(self.lyapunov.shape) else rays
        sizes = [abs(x) for part in (rays, slopes, fields) for vector in part for x in vector]
        if not sum(sizes) < _MOST or min(filter(None, sizes)) < _LEAST:
            return None
        longest, steepest = max(sizes[:4]), max(sizes[4:8])
        gain = (steepest * sum(sizes[8:])) ** 2
        return _form(rays, slopes, fields), gain, 2 * longest * steepest

    def _clear_minors(self, kappa: Any, lightness: Any) -> tuple[float, ...] | None:
        """The minors in floats, where rounding decides the sign of none."""
        factor, light = float(kappa), float(lightness)
        if self._form_in_floats is None or not _LEAST < factor < _MOST or not _LEAST < light < _MOST:
            return None
        form, gain, size = self._form_in_floats
        minors = _minors(form, factor, light)
        corner, *entries, determinant = minors
        # Rounding errs by a small part of these sums of absolute terms; m13 m23 is no more than a gain times turns.
        turns = form[1][5] + factor * light
        bound = 2 * turns * (gain + factor * size)
        is_clear = abs(corner) > FLOAT_DOUBT * turns and abs(determinant) > FLOAT_DOUBT * 2 * bound * bound
        return minors if is_clear and min(map(abs, entries)) > FLOAT_DOUBT * bound else None

    @cached_property
    def _form_in_balls(self) -> Form:
        """The form in balls, which mostly show of rounded numbers that it holds."""
        slopes = [self.lyapunov.slope(ray) for ray in self.rays]
        return _form(*([[*map(ball_of, vector)] for vector in part] for part in (self.rays, slopes, self.fields)))

    def holds(self, kappa: Fraction) -> bool:
        """Whether ``a^2 + b^2 >= kappa V`` on the closed cone near the equilibrium, exactly."""
        inner = kappa * (1 + SLACK) if any(self.lyapunov.shape) else kappa
        light = self.lyapunov.lightness
        clear = self._clear_minors(inner, light)
        if clear is not None:
            return _is_positive(clear)
        corner, s11, s22, s12, determinant = _minors(self._form_in_balls, rational_ball(inner), rational_ball(light))
        is_clear = corner > 0 and s11 > 0 and s22 > 0 and (s12 > 0 or determinant > 0)
        return is_clear or _is_positive(_minors(self.form, inner, light))


def _floats(vectors: Sequence[Any]) -> list[list[float]]:
    """Vectors in floats; nan for numbers far from one."""
    return [[sure_float(entry) for entry in vector] for vector in vectors]


def _form(rays: Sequence[Any], slopes: Sequence[Any], fields: Sequence[Any]) -> Form:
    """Both forms of a cone by its rays, by ``P r`` of these, and by the control fields."""
    (p, q), ((px, py), (qx, qy)) = rays, slopes
    gains: tuple[Any, ...] = ()
    for x, y, turn in fields:
        a, b = px * x + py * y, qx * x + qy * y
        products = a * a, a * b, b * b, a * turn, b * turn, turn * turn
        gains = tuple(map(add, gains, products)) if gains else products
    return (dot(p, slopes[0]), dot(p, slopes[1]), dot(q, slopes[1])), gains


def _minors(form: Form, kappa: Any, lightness: Any) -> tuple[Any, ...]:
    """The entry of M at ``tau^2``, the Schur complement S times it: ``S_11, S_22, S_12``, and ``det S``."""
    sizes, (*gains, m13, m23, turns) = form
    m11, m12, m22 = (gain - kappa * size for gain, size in zip(gains, sizes, strict=True))
    corner = turns - kappa * lightness
    s11, s22, s12 = corner * m11 - m13 * m13, corner * m22 - m23 * m23, corner * m12 - m13 * m23
    return corner, s11, s22, s12, s11 * s22 - s12 * s12


def _is_positive(minors: tuple[Any, ...]) -> bool:
    """Whether ``a^2 + b^2 >= kappa (c^T P c + lightness tau^2)`` on the closed cone, for every tau."""
    corner, s11, s22, s12, determinant = map(sign, minors)
    return corner > 0 and s11 >= 0 and s22 >= 0 and (s12 >= 0 or determinant >= 0)


class FeedbackRate(NamedTuple):
    """Certified ``V' <= -2 k kappa V`` near the equilibrium.

    Attributes:
        kappa: the rate.
        cones: the forms of all cones.
        limit: distance of the border of the support polygon, or a little less, where the checked square leaves it.
    """

    kappa: Fraction
    cones: tuple[ConeRate, ...]
    limit: Fraction | None = None

    @property
    def reach(self) -> Fraction | None:
        """The rate holds within this distance of c*, in the cells there; None where they alone bound it."""
        bounds = [bound for bound in (self.shape_reach, self.limit) if bound is not None]
        return min(bounds, default=None)

    @property
    def shape_reach(self) -> Fraction | None:
        """Where exact kinematics turn V no more than the rate allows; None for ``P = I``, which they do not turn."""
        rho, weight = self.cones[0].lyapunov.eccentricity, self.cones[0].lyapunov.weight
        if not rho:
            return None
        square = SLACK**2 * (1 - rho) * weight / ((1 + SLACK) * rho**2)
        shift = max(0, 32 - (square.numerator.bit_length() - square.denominator.bit_length()) // 2)
        scaled = square * 4**shift  # at least 2^62
        return Fraction(isqrt(scaled.numerator // scaled.denominator), 2**shift)


def certified_rate(inputs: RowInputs, lyapunov: ControlLyapunov = SQUARES) -> FeedbackRate | None:
    """The largest rate found for a stabilizing law under rule ``nearest``; None if none is."""
    cones = _build_cones(inputs, lyapunov)
    floats, unit = _in_floats(cones, inputs.length)
    proposal = _proposal(floats, _lightness(lyapunov.weight / inputs.length**2, unit))
    if proposal <= 0:
        return None
    kappa = rounded_down(proposal / float(1 + SLACK) if any(lyapunov.shape) else proposal)
    kappa_found = confirmed(kappa, lambda value: all(cone.holds(value) for cone in cones), MUCH_BELOW)
    if kappa_found is None:
        return None
    support = inputs.support
    limit = support.distance_below if support is not None and support.stands else None
    return FeedbackRate(kappa_found, cones, limit)


def balanced(inputs: RowInputs, shape: Shape) -> ControlLyapunov:
    """V with the smallest w, ``l^2`` times a power of two, that gives at least half the rate that any w can give."""
    floats, unit = _in_floats(_build_cones(inputs, ControlLyapunov(shape)), inputs.length)
    enough = _proposal(floats, 0.0) / 2
    exponents = range(-_LARGEST_EXPONENT, _LARGEST_EXPONENT)
    least = exponents[0] + bisect_left(exponents, True, key=lambda k: _proposal(floats, 2.0**-k) >= enough)
    return ControlLyapunov(shape, inputs.length**2 * Fraction(2) ** (least - 2 * unit))


def _build_cones(inputs: RowInputs, lyapunov: ControlLyapunov) -> tuple[ConeRate, ...]:
    """The forms of all cones; products of four numbers occur."""
    rates = []
    for cone in inputs.fan:
        rays: Any = tuple((late(x), late(y)) for x, y in (cone.start, cone.end))
        for state in cone.cell.states:
            fields: Any = tuple(tuple(late(entry) for entry in field) for field in state.control_fields.values())
            rates.append(ConeRate(rays, fields, lyapunov))
    return tuple(rates)


def _in_floats(cones: Sequence[ConeRate], length: Fraction) -> tuple[list[ConeRate], int]:
    """The same forms with floats for numbers, the same ones in every unit of length.

    Rays have entries up to one, and rotation rates are multiples of ``2^unit/l``, about the largest of them.
    """
    unit = max((exponent_of(field[2] * length) for cone in cones for field in cone.fields if field[2]), default=0)
    factor = length * Fraction(2) ** -unit
    floats = []
    for cone in cones:
        sizes = [max(abs(x), abs(y)) for x, y in cone.rays]
        rays: Any = tuple((float(x / size), float(y / size)) for (x, y), size in zip(cone.rays, sizes, strict=True))
        fields: Any = tuple((float(x), float(y), float(w * factor)) for x, y, w in cone.fields)
        floats.append(replace(cone, rays=rays, fields=fields))
    return floats, unit


def exponent_of(value: Any) -> int:
    """About log2 of the size of a nonzero number, also beyond the range of floats.

    Balls of fixed precision do not do: over a field of high degree they may hold zero.
    """
    ball = value.tight_ball() if isinstance(value, Lazy) else plain(value).accurate_ball(_FEW_BITS)
    if isinstance(value, Lazy) and ball.contains(0):  # rounding decides its sign
        numerator, denominator = (plain(part).accurate_ball(_FEW_BITS) for part in value.quotient())
        ball = numerator / denominator
    return round(float(abs(ball).log() / arb(2).log()))


def _lightness(weight: Fraction, unit: int) -> float:
    """``l^2/w`` in the unit of the rotation rates, by ``weight = w/l^2``; too large for a float in enormous units."""
    light = 1 / (weight * Fraction(2) ** (2 * unit))
    return float(light) if light < _FLOAT_RANGE else float("inf")


def _proposal(floats: Sequence[ConeRate], lightness: float) -> float:
    """Largest kappa' of all cones in floats."""
    least = None
    for cone in floats:
        if least is None or not _is_positive(_minors(cone.form, least, lightness)):
            least = _largest(cone, lightness)
    return least or 0.0


def _largest(cone: ConeRate, lightness: float) -> float:
    """Largest kappa' of one cone, by bisection in floats; at most ``2 sum |g_v|^2``, since P is at most 2."""
    low, high = 0.0, 2.0 * sum(float(x) ** 2 for field in cone.fields for x in field[:2])
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2
        low, high = (middle, high) if _is_positive(_minors(cone.form, middle, lightness)) else (low, middle)
    return low


# ---- the region --------------------------------------------------------------------------


class LevelRegion(NamedTuple):
    """All (c, theta) with ``V < level``."""

    lyapunov: ControlLyapunov
    level: Fraction

    def __str__(self) -> str:
        return f"V < {float(self.level):.{DIGITS}g}"

    def value(self, pose: Sequence[float]) -> float:
        """V at ``(x, y, theta)``, c measured from the equilibrium, in floats."""
        return self.lyapunov.value(pose)

    def contains(self, pose: Sequence[float]) -> bool:
        """Whether a pose lies in the region, in floats."""
        return self.value(pose) < self.level


def build_level_region(inputs: RowInputs, lyapunov: ControlLyapunov) -> LevelRegion | None:
    """The largest level, to a few digits in ``l^2``, for a law by V; None if none is found, or the body tips at c*."""
    support = inputs.support
    if support is not None and not support.stands:
        return None
    stalling = [data for data in inputs.away if data.lever is None or not data.sign_condition.sign(lyapunov)]
    sides = [*segments(stalling, inputs.radius), *(() if support is None else support.sides)]
    level = confirmed(least_level(sides, lyapunov, inputs.length), lambda value: are_above(sides, lyapunov, value))
    return None if level is None else LevelRegion(lyapunov, level)


def least_level(sides: Iterable[Segment], lyapunov: ControlLyapunov, length: Fraction) -> Fraction:
    """The least ``c^T P c`` on segments, as a multiple of ``length^2`` to a few digits: a proposal."""
    bounds = (least_of_parabola(*map(ball_of, _parabola(side, lyapunov))) for side in sides)
    least = min(bounds, key=lambda bound: bound.mid())
    return length**2 * Fraction((least / ball_of(length**2)).str(DIGITS, radius=False))


def segments(cells: Iterable[InputCell], radius: Number) -> Iterator[Segment]:
    """The sides of the square about the equilibrium and of some cells."""
    zero = radius * 0
    for polygon in (square((zero, zero), radius), *(data.cell.polygon for data in cells)):
        yield from around(polygon.vertices)


def are_above(sides: Iterable[Segment], lyapunov: ControlLyapunov, level: Fraction) -> bool:
    """Whether ``c^T P c >= level > 0`` on segments, exactly."""
    return level > 0 and all(_is_above(side, lyapunov, level) for side in sides)


def _is_above(side: Segment, lyapunov: ControlLyapunov, level: Fraction) -> bool:
    constant, slope, curve = _parabola(side, lyapunov)
    if sign(constant - level) < 0 or sign(constant + slope * 2 + curve - level) < 0:
        return False
    bottom_inside = sign(slope) < 0 and sign(slope + curve) > 0
    return not bottom_inside or sign((constant - level) * curve - slope * slope) >= 0


def _parabola(side: Segment, lyapunov: ControlLyapunov) -> tuple[Any, Any, Any]:
    """``c^T P c`` at ``start + t (end - start)`` is ``constant + 2 slope t + curve t^2``."""
    (p, q), (u, v) = side
    start, along = (late(p), late(q)), (late(u - p), late(v - q))
    slope = lyapunov.slope(start)
    return dot(slope, start), dot(slope, along), dot(lyapunov.slope(along), along)


# ---- limited speeds ----------------------------------------------------------------------


@dataclass(frozen=True)
class LimitedRate:
    """What limits of speed leave of the certified rate kappa.

    Attributes:
        free: no wheel is at its limit where ``k^2 V <= free`` (for ``P != I`` with a gain of at least one).
        held: ``V' <= -2 k kappa V`` where ``k^2 V <= held``.
        speed: beyond that sqrt(V) falls at least with this speed.
        level: all of this where ``V < level``.
    """

    free: Fraction
    held: Fraction
    speed: Fraction
    level: Fraction


def build_limited_rate(inputs: RowInputs, rate: FeedbackRate | None, lyapunov: ControlLyapunov) -> LimitedRate | None:
    """The largest numbers found; None without a certified rate, and where no wheel that acts near c* has a limit."""
    limits = inputs.partition.scene.speed_limits
    acting = [
        _LimitedInput(field, limits[wheel], lyapunov)
        for data in inputs.local
        for wheel, field in data.state.control_fields.items()
        if wheel in limits
    ]
    if rate is None or not acting:
        return None
    least, kappa = min(entry.limit for entry in acting), rate.kappa
    free = rounded_down(min(entry.proposed_level() for entry in acting))
    bounds = (
        confirmed(free, lambda value: all(entry.is_free(value) for entry in acting)),
        confirmed(rounded_down(float(least) ** 2 / float(kappa)), lambda held: least * least >= held * kappa),
        confirmed(rounded_down(float(least) * float(kappa) ** 0.5), lambda v: v * v <= least * least * kappa),
        _level_nearby(inputs, rate, lyapunov),
    )
    numbers = [number for number in bounds if number is not None and number > 0]
    return LimitedRate(*numbers) if len(numbers) == len(bounds) else None


def level_with_rate(inputs: RowInputs, rate: FeedbackRate, region: LevelRegion) -> Fraction | None:
    """A level below which the law brings the body home, all the way at the certified rate; None where none is found.

    It is that of the region where this keeps to the cells at the equilibrium, and to where the rate is certified.  Else
    the region may hold further cells, in which V falls too, at another rate, and the level is a smaller one.
    """
    lyapunov, level = region.lyapunov, region.level
    is_near = rate.reach is None or level <= rate.reach**2 * (1 - lyapunov.eccentricity)
    if is_near and are_above(segments(inputs.away, inputs.radius), lyapunov, level):
        return level
    nearby = _level_nearby(inputs, rate, lyapunov)
    return None if nearby is None else min(nearby, level)


def _level_nearby(inputs: RowInputs, rate: FeedbackRate, lyapunov: ControlLyapunov) -> Fraction | None:
    """A level that keeps to the cells at the equilibrium, and to where the rate is certified."""
    sides = list(segments(inputs.away, inputs.radius))
    level = least_level(sides, lyapunov, inputs.length)
    if rate.reach is not None:
        level = min(level, rate.reach**2 * (1 - lyapunov.eccentricity))
    return confirmed(rounded_down(float(level)), lambda value: are_above(sides, lyapunov, value))


@dataclass(frozen=True)
class _LimitedInput:
    """An input by its control vector field and the largest speed of its wheel."""

    field: Triple
    limit: Number
    lyapunov: ControlLyapunov

    @cached_property
    def _bend(self) -> Any:
        """``r = |g_omega| rho/(1 - rho)``, with rho rounded up."""
        rho = self.lyapunov.eccentricity
        return abs(self.field[2]) * (rho / (1 - rho))

    @cached_property
    def _squared_norm(self) -> Any:
        """``q^2``."""
        return self.lyapunov.squared_norm(self.field)

    def is_free(self, level: Fraction) -> bool:
        """Whether ``sqrt(level) q + level r <= limit``, exactly."""
        rest = self.limit - self._bend * level
        return sign(rest) >= 0 and sign(rest * rest - self._squared_norm * level) >= 0

    def proposed_level(self) -> float:
        """The largest such level in floats: the root of ``r s^2 + q s = limit``, squared."""
        q, r, most = float(self._squared_norm) ** 0.5, float(self._bend), float(self.limit)
        return (2 * most / (q + (q * q + 4 * r * most) ** 0.5)) ** 2
