"""How fast V falls where speeds are limited: the law ``u = -k (a, b)`` with all inputs scaled by one factor.

Let ``V'/2 = sum_w a_w u_w`` with ``a_w = grad V/2 . g_w``, and ``sigma = min(1, min_w m_w/|k a_w|)`` for the limits
m_w of the wheels that act.  The limited law ``u = -sigma k a`` gives ``V'/2 = -sigma k |a|^2``.  With the certified
``|a|^2 >= kappa V`` on every closed cone at the equilibrium, and m the least limit of a wheel that acts there:

- where ``sigma < 1``, ``sigma k >= m/|a|``, so ``V'/2 <= -m |a|`` and ``(sqrt V)' <= -m sqrt(kappa)``;
- where ``sigma = 1``, ``(sqrt V)' <= -k kappa sqrt(V)`` as without limits.

So ``V' <= -2 k kappa V`` stays true while ``k sqrt(V) <= m/sqrt(kappa)``, and beyond that sqrt(V) falls at least with
the constant speed ``m sqrt(kappa)``, whatever k is.  No wheel is at its limit where, by Cauchy and Schwarz in the
metric ``diag(P, w)``, ::

    k (sqrt(V) q_w + V r_w) <= m_w,    q_w^2 = g_v^T P g_v + w g_omega^2,    r_w = |g_omega| rho/(1 - rho)

for every wheel that acts; the term with ``rho^2 = e^2 + f^2`` comes from exact kinematics and vanishes for ``P = I``.
All of it holds within the cells at the equilibrium: where ``V < level``.  The numbers are rounded down and verified
exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from nonsmooth.proofs.clauses.feedback.control_lyapunov import ControlLyapunov
from nonsmooth.proofs.clauses.feedback.feedback_rate import FeedbackRate, rounded_down
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell
from nonsmooth.proofs.clauses.feedback.level_region import NEXT_BELOW, is_above, least_level, segments
from nonsmooth.proofs.clauses.translation.quadratic import root_above
from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.plane import dot

_TRIES = 40  # of a number that rounding made too large

Limits = Mapping[int, Number]


@dataclass(frozen=True)
class LimitedRate:
    """What limits of speed leave of the certified rate.

    Attributes:
        kappa: of the rate without limits, ``V' <= -2 k kappa V``.
        free: no wheel is at its limit where ``k^2 V <= free`` (for ``P != I`` with a gain of at least one).
        held: ``V' <= -2 k kappa V`` where ``k^2 V <= held``.
        speed: beyond that sqrt(V) falls at least with this speed.
        level: all of this where ``V < level``.
        radius: half-width of the checked square.
    """

    kappa: Fraction
    free: Fraction
    held: Fraction
    speed: Fraction
    level: Fraction
    radius: Number

    def check(
        self, cells: Sequence[InputCell], local: frozenset[int], rate: FeedbackRate, lyapunov: ControlLyapunov
    ) -> bool:
        """Re-verify every number, exactly."""
        near = [data for data in cells if data.cell.index in local]
        limits = limits_of(near)
        if not limits or self.kappa != rate.kappa or not rate.check(lyapunov):
            return False
        positive = all(value > 0 for value in (self.free, self.held, self.speed, self.level))
        least = least_limit(limits)
        fast = sign(least * least * self.kappa - self.speed * self.speed) >= 0
        kept = sign(least * least - self.held * self.kappa) >= 0
        unlimited = all(_is_free(self.free, *entry, lyapunov) for entry in _inputs(near, limits))
        return positive and fast and kept and unlimited and self._is_near(cells, local, rate, lyapunov)

    def _is_near(
        self, cells: Sequence[InputCell], local: frozenset[int], rate: FeedbackRate, lyapunov: ControlLyapunov
    ) -> bool:
        """Whether the level keeps to the cells at the equilibrium, and to where the rate is certified."""
        away = [data for data in cells if data.cell.index not in local]
        reach = rate.reach
        (e, f) = lyapunov.shape
        if reach is not None and self.level > reach * reach * (1 - root_above(e * e + f * f)):
            return False
        return all(is_above(side, lyapunov, self.level) for side in segments(away, self.radius))


def build_limited_rate(
    cells: Sequence[InputCell],
    local: frozenset[int],
    radius: Number,
    rate: FeedbackRate | None,
    lyapunov: ControlLyapunov,
    length: Fraction,
) -> LimitedRate | None:
    """The largest numbers found; None without a certified rate, and where no wheel that acts near c* has a limit."""
    near = [data for data in cells if data.cell.index in local]
    limits = limits_of(near)
    if rate is None or not limits:
        return None
    least, (e, f) = least_limit(limits), lyapunov.shape
    away = [data for data in cells if data.cell.index not in local]
    level = least_level(segments(away, radius), lyapunov, length)
    if rate.reach is not None:
        level = min(level, rate.reach**2 * (1 - root_above(e * e + f * f)))
    size = float(least)
    found = LimitedRate(
        kappa=rate.kappa,
        free=rounded_down(min(_proposed_free(*entry, lyapunov) for entry in _inputs(near, limits))),
        held=rounded_down(size * size / float(rate.kappa)),
        speed=rounded_down(size * float(rate.kappa) ** 0.5),
        level=rounded_down(float(level)),
        radius=radius,
    )
    for _ in range(_TRIES):
        if found.check(cells, local, rate, lyapunov):
            return found
        shrunk = {name: getattr(found, name) * NEXT_BELOW for name in ("free", "held", "speed", "level")}
        found = replace(found, **shrunk)
    return None


def limits_of(cells: Sequence[InputCell]) -> dict[int, Number]:
    """The limits of the wheels that act in some cells, by index."""
    wheels = [row.wheel for data in cells for row in data.state.rows]
    acting = {wheel for data in cells for wheel in data.state.control_fields}
    return {w.index: w.speed_limit for w in wheels if w.index in acting and w.speed_limit is not None}


def least_limit(limits: Limits) -> Number:
    """The smallest of some limits."""
    first, *others = limits.values()
    for other in others:
        if (other - first).sign() < 0:
            first = other
    return first


def _inputs(cells: Sequence[InputCell], limits: Limits) -> Iterator[tuple[Triple, Number]]:
    """The control vector field and the limit of every input that has one."""
    for data in cells:
        for wheel, field in data.state.control_fields.items():
            if wheel in limits:
                yield field, limits[wheel]


def _squared_norm(field: Triple, lyapunov: ControlLyapunov) -> Any:
    """``q^2 = g_v^T P g_v + w g_omega^2``."""
    x, y, turn = field
    return dot(lyapunov.slope((x, y)), (x, y)) + turn * turn * lyapunov.weight


def _bend(field: Triple, lyapunov: ControlLyapunov) -> Any:
    """``r = |g_omega| rho/(1 - rho)``, with rho rounded up."""
    e, f = lyapunov.shape
    if not e and not f:
        return field[2] * 0
    rho = root_above(e * e + f * f)
    return abs(field[2]) * (rho / (1 - rho))


def _is_free(level: Fraction, field: Triple, limit: Number, lyapunov: ControlLyapunov) -> bool:
    """Whether ``sqrt(level) q + level r <= limit``, exactly."""
    rest = limit - _bend(field, lyapunov) * level
    return sign(rest) >= 0 and sign(rest * rest - _squared_norm(field, lyapunov) * level) >= 0


def _proposed_free(field: Triple, limit: Number, lyapunov: ControlLyapunov) -> float:
    """The largest such level in floats: the root of ``r s^2 + q s = limit``, squared."""
    q, r, most = float(_squared_norm(field, lyapunov)) ** 0.5, float(_bend(field, lyapunov)), float(limit)
    return (2 * most / (q + (q * q + 4 * r * most) ** 0.5)) ** 2
