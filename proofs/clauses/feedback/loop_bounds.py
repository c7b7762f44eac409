"""What a certified law asks of the wheels, and what it withstands: speeds, limits of speed, late and wrong poses.

*Speeds under the law of imposed twists.* ``-k (g . xi_l) xi_l`` is imposed by ``-k (g . xi_l) u_l``, and with l for
the unit of length ``|g . xi_l| <= |xi_l| |g|``: no rim is faster than ``k max_l |xi_l| max_i |u_l,i| sqrt(V)``. The
longest twist attains its bound, at the error g along it. Speeds and lengths change their unit alike.

*Laws by rows* with ``V = c^T P c + w theta^2``.  Wheel i with the control field ``(f, t)`` runs at ``-k (f . P c + t w
theta)`` to first order, so for c along e no faster than ``k sqrt((f . P e)^2/(e . P e) + w t^2) sqrt(V)``
(Cauchy-Schwarz).

*Limited speeds.*  The law imposes ``-sigma k (g . xi_l) xi_l`` with one factor ``sigma <= 1`` that keeps every speed
within its limit m_i.  With ``q_l = min_i m_i/|u_l,i|``, a law at its limit has ``sigma k |g . xi_l| = q_l``.  So
``V'/2 = -q_l |g . xi_l| <= -q_l sqrt(kappa V)`` where the rate is certified, and sqrt(V) falls at least with the
speed ``min_l q_l sqrt(kappa)``; elsewhere at the certified rate.  Under unknown loads V' is at least ``1 - eta`` of
that.

*Poses that are late and wrong.*  The law acts on ``g~(t) = g(t - tau) + e``, ``|e| <= eps``, ``g = (c, theta)`` with
l for the unit of length: it imposes ``-k (g~ . xi) xi`` with the ``xi = xi_l`` of the largest ``|g~ . xi_l|``, for
which ``(g~ . xi)^2 > kappa |g~|^2``. With ``d = g~ - g`` and M the length of the longest xi_l::

    V'/2 = -k (g~ . xi) (g~ . xi - d . xi) < 0      where      |g| > b |d|,      b = 1 + M/sqrt(kappa),

since ``|g~| >= |g| - |d|``.  The pose moves at ``|g'| <= k M^2 (1 + r) |g~|`` as long as ``|c| <= r``, so where no
``|g|`` of the last 2 tau exceeds m, ``|d| <= eps + a (m + eps)`` with ``a = k tau M^2 (1 + r)``.  Where b a < 1, the
largest ``|g|`` of the last 2 tau hence falls as long as it exceeds ::

    R = b eps (1 + a)/(1 - b a),

and in the end ``|g| <= R`` (Razumikhin's argument).  It is assumed that the pose stood still before the start.  Where
twists change, the velocities of their hull satisfy the same.  A factor below one, of speeds that end, changes
nothing.

Where loads are unknown, motions are only near the xi_l, no longer than some M', and ``(g~ . xi_l) (g~ . xi)`` keeps
``1 - eta`` of its size (module ``every_load_law``): ``b = 1 + M'/((1 - eta) sqrt(kappa))``, and M M' stands for M^2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, NamedTuple

from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion
from nonsmooth.proofs.clauses.feedback.rational_bounds import confirmed, rounded_down, rounded_up
from nonsmooth.proofs.findings import Certainty, Feedback
from nonsmooth.symbolic.mechanics.contact_states import inner
from nonsmooth.symbolic.mechanics.scene import LoopErrors, Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import XY, cross, dot, in_floats

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
    from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback
    from nonsmooth.proofs.clauses.feedback.control_fields import ControlLyapunov, InputCell


FEW_ROUNDINGS = Fraction(1, 2**40)  # more than a few roundings of a quotient or product of floats
PI = Fraction(355, 113)  # above pi
HALVINGS = 6  # of the level from which bodies start: smaller ones move more slowly
SHORTER = Fraction(99, 100)  # of the longest delay, which itself is not certified
MOST_HALVINGS = 50  # of a gain
BY_CELLS = (
    "under rule nearest the law needs the contact state, and a pose that is late or wrong may lie in another cell"
)
BY_CONES = "the law depends on the direction of c, and a misjudged one may belong to other twists"
NEAR_ONLY = "the law is certified near the point, and how near is not known: errors of the pose may be larger than that"
TOO_LATE = "the pose is too old: with gain k = 1 the delay is certified below {:.4g}"
TOO_WRONG = "the errors are too large for the disc in which the law is certified"


# ---- speeds of rims ----------------------------------------------------------------------


class WheelSpeed(NamedTuple):
    """Under the law with gain k no rim is faster than ``k (by_root sqrt(V) + by_level V)``.

    Attributes:
        by_root: speed of a rim over sqrt(V), to first order.
        by_level: what is added over V, where V is no sum of squares: fields turn with the body.
        place: index of the cell, or number of the cone of directions, in which the first is largest.
    """

    by_root: Fraction
    by_level: Fraction
    place: int

    def at_error(self, error: Fraction) -> Fraction:
        """The largest speed at gain one where the error sqrt(V) is at most a number."""
        return self.by_root * error + self.by_level * error**2


def wheel_speed(feedback: AnyFeedback, scene: Scene) -> WheelSpeed | None:
    """How fast the rims run under a certified law, at gain one; None without a V that falls under it.

    Under rule ``nearest`` wheel w is asked for ``(P c, m theta) . g + g_theta c^T P J c`` with its field g.  The first
    part over sqrt(V) is largest for c in some direction of a cell (:func:`_largest_product`), and the second at most
    ``|g_theta| rho V/(1 - rho)``.  Under the other rules it is asked for ``(g . xi_l) u``, at most
    ``sqrt(V) |xi_l| |u|``.
    """
    if not feedback.has_lyapunov:
        return None
    if isinstance(feedback, FeedbackResult):
        rho = feedback.lyapunov.eccentricity
        speeds = [_fastest(data, feedback.lyapunov) for data in feedback.cells]
        largest = max(speeds)
        place = feedback.cells[speeds.index(largest)].cell.index
        turn = max(abs(float(field[2])) for data in feedback.cells for field in data.fields)
        bent = Fraction(turn) * (1 + FEW_ROUNDINGS) * rho / (1 - rho)
        return WheelSpeed(Fraction(largest) * (1 + FEW_ROUNDINGS), bent, place)
    from nonsmooth.proofs.clauses.feedback.driven_law import effort

    scaled = in_own_length(scene.recentred())
    efforts = [max(effort(scaled, imposed) for imposed in cone.twists) for cone in feedback.cones]
    largest = max(efforts)
    return WheelSpeed(Fraction(largest) * (1 + FEW_ROUNDINGS), Fraction(0), efforts.index(largest))


def _fastest(data: InputCell, lyapunov: ControlLyapunov) -> float:
    """The largest ``(P c, w theta) . g`` over sqrt(V) of both fields of a cell."""
    corners = [in_floats(vertex) for vertex in data.cell.polygon.vertices]
    return max(_largest_product(corners, (float(x), float(y)), float(turn), lyapunov) for x, y, turn in data.fields)


def _largest_product(corners: Sequence[XY], push: XY, turn: float, lyapunov: ControlLyapunov) -> float:
    """The largest ``(P c, w theta) . (push, turn)`` over sqrt(V), for c in the directions of a cell with these corners.

    For c along e it is ``sqrt((push . P e)^2/(e . P e) + w turn^2)``, which is largest along the push or against it,
    and where all corners are on one side of that line at one of them.  What floats leave open counts as on the line.
    """
    e, f = map(float, lyapunov.shape)

    def weighted(way: XY) -> XY:
        return (1 + e) * way[0] + f * way[1], f * way[0] + (1 - e) * way[1]

    directions = [corner for corner in corners if any(corner)]
    doubt = float(FEW_ROUNDINGS) * math.hypot(*push)
    sides = {_side(way, push, doubt) for way in directions}
    if sides not in ({1}, {-1}) and any(push):
        directions.append(push)
    along = [dot(push, weighted(way)) ** 2 / dot(way, weighted(way)) for way in directions]
    return math.sqrt(max(along, default=0.0) + float(lyapunov.weight) * turn**2)


def _side(way: XY, push: XY, doubt: float) -> int:
    """On which side of a line a direction lies; 0 where floats leave it open, within a share of its length."""
    beside = cross(way, push)
    return 0 if abs(beside) <= doubt * math.hypot(*way) else sign(beside)


def certified_error(feedback: AnyFeedback) -> Fraction | None:
    """Sqrt(V) on the border of the certified region; None where that is no level of V, or not known."""
    if isinstance(feedback, FeedbackResult):
        level = feedback.region.level if isinstance(feedback.region, LevelRegion) else None
        return None if level is None else Fraction(math.sqrt(level)) * (1 + FEW_ROUNDINGS)
    if feedback.reach is None or feedback.every_load is not None:
        return None
    return Fraction(float(feedback.reach)) * (1 + FEW_ROUNDINGS)


def limited_speed(feedback: DrivenFeedback, scene: Scene) -> Fraction | None:
    """Speed with which sqrt(V) falls at least while a wheel is at its limit; None without a law, or without limits."""
    from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds

    limits, scaled = scene.speed_limits, in_own_length(scene.recentred())
    least: list[float] = []
    for imposed in (imposed for cone in feedback.cones for imposed in cone.twists):
        speeds = dict(zip(scaled.numbers, rim_speeds(scaled, imposed), strict=True))
        least += [float(limit) / abs(speeds[wheel]) for wheel, limit in limits.items() if speeds[wheel]]
    if not least or feedback.kappa is None:
        return None
    ratio = Fraction(min(least)) * (1 - FEW_ROUNDINGS)
    return ratio * rounded_down(float(feedback.kappa) ** 0.5) * feedback.kept


# ---- poses that are late and wrong -------------------------------------------------------


@dataclass(frozen=True)
class UltimateBound:
    """Verdict with its numbers, of the array with l for its unit of length, at gain k = 1.

    Attributes:
        verdict: certified or undecided.
        reason: why nothing is certified; empty where something is.
        radius: R: in the end ``sqrt(V) <= l R``.
        level: from starts with ``sqrt(V) < l level``; None where only starts close by are known to.
        largest_delay: delays below it are certified where the pose is exact but late; None where none is.
        gain: k up to which the loop with these errors is certified, where it is not at k = 1; None where none is known.
    """

    verdict: Certainty
    reason: str = ""
    radius: Fraction | None = None
    level: Fraction | None = None
    largest_delay: Fraction | None = None
    gain: Fraction | None = None


class _Law(NamedTuple):
    """Rational bounds of a law.

    Attributes:
        size: M or more.
        fastest: M' or more; M where loads are known.
        gain: b or more.
    """

    size: Fraction
    fastest: Fraction
    gain: Fraction

    def lag(self, level: Fraction) -> Fraction:
        """``M M' (1 + r)``: a over k tau."""
        return self.size * self.fastest * (1 + level)

    def largest_delay(self, level: Fraction) -> Fraction:
        """Delays below it leave ``b a < 1`` at k = 1."""
        return rounded_down(float(1 / (self.gain * self.lag(level))))


def ultimate_bound(feedback: DrivenFeedback, errors: LoopErrors) -> UltimateBound:
    """What is certified of the loop of a law of imposed twists (module ``by_friction``) with these errors."""
    if feedback.verdict is not Feedback.STABILIZABLE or feedback.kappa is None:
        return _open(f"no law is certified even for an exact pose ({feedback.verdict})")
    if any(cone.rays is not None for cone in feedback.cones):
        return _open(BY_CONES)
    law, delay = _law(feedback, feedback.kappa), _above(errors.delay)
    wrong = _above(errors.position) / feedback.length + PI * errors.heading
    level = _level(feedback)
    bound = _bound_of(law, level, delay, wrong)
    return bound if bound.verdict is Certainty.CERTIFIED else replace(bound, gain=_gain(law, level, delay, wrong))


def _bound_of(law: _Law, level: Fraction | None, delay: Fraction, wrong: Fraction) -> UltimateBound:
    """What is certified at k = 1, from the largest level that serves."""
    if level is None:
        return _near_the_point(law, delay, wrong)
    limit = law.largest_delay(level / 2**HALVINGS)
    for halvings in range(HALVINGS + 1):
        start = level / 2**halvings
        radius = _radius(law, delay, wrong, start)
        if radius is not None and radius < start:
            return UltimateBound(Certainty.CERTIFIED, "", radius, start, limit)
    reason = TOO_LATE.format(float(limit)) if delay >= limit else TOO_WRONG
    return UltimateBound(Certainty.UNDECIDED, reason, largest_delay=limit)


def _gain(law: _Law, level: Fraction | None, delay: Fraction, wrong: Fraction) -> Fraction | None:
    """A gain at which the loop is certified, and with it every smaller one; None where none is known.

    Time in units of 1/k makes of the loop with gain k and delay tau the one with gain 1 and delay k tau; R grows with
    the delay.
    """
    if delay == 0 or _bound_of(law, level, Fraction(0), wrong).verdict is not Certainty.CERTIFIED:
        return None
    limit = law.largest_delay(Fraction(0) if level is None else level / 2**HALVINGS)
    gains = (min(Fraction(1), limit / delay) * SHORTER / 2**n for n in range(MOST_HALVINGS))
    return next((k for k in gains if _bound_of(law, level, k * delay, wrong).verdict is Certainty.CERTIFIED), None)


def _near_the_point(law: _Law, delay: Fraction, wrong: Fraction) -> UltimateBound:
    """Motions differ from the imposed ones by terms of second order: a strict inequality survives them."""
    limit = law.largest_delay(Fraction(0))
    if wrong:
        return UltimateBound(Certainty.UNDECIDED, NEAR_ONLY, largest_delay=limit)
    if delay >= limit:
        return UltimateBound(Certainty.UNDECIDED, TOO_LATE.format(float(limit)), largest_delay=limit)
    return UltimateBound(Certainty.CERTIFIED, "", Fraction(0), None, limit)


def _radius(law: _Law, delay: Fraction, wrong: Fraction, level: Fraction) -> Fraction | None:
    """R; None where the delay is too long."""
    lag = delay * law.lag(level)
    left = 1 - law.gain * lag
    if left <= 0 or not wrong:
        return None if left <= 0 else Fraction(0)
    return rounded_up(float(law.gain * wrong * (1 + lag) / left))


def _open(reason: str) -> UltimateBound:
    return UltimateBound(Certainty.UNDECIDED, reason)


def _law(feedback: DrivenFeedback, kappa: Fraction) -> _Law:
    squares = [inner(twist, twist) for cone in feedback.cones for twist in cone.vectors]
    longest = math.sqrt(max(map(float, squares)))
    size = _bounded(rounded_up(longest), lambda size: all(sign(size**2 - x) >= 0 for x in squares), Fraction(101, 100))
    least = _bounded(rounded_down(math.sqrt(kappa)), lambda root: root**2 <= kappa, Fraction(99, 100))
    fastest = size if feedback.every_load is None else size * feedback.every_load.largest
    return _Law(size, fastest, 1 + fastest / (least * feedback.kept))


def _above(number: Number) -> Fraction:
    """A rational not below a number >= 0; the number itself where it is rational."""
    exact = number.as_rational()
    if exact is not None:
        return as_fraction(exact)
    return _bounded(rounded_up(float(number)), lambda value: sign(value - number) >= 0, Fraction(101, 100))


def _level(feedback: DrivenFeedback) -> Fraction | None:
    """A radius of |g| within which the speeds impose their twists; None where that is not known."""
    bounds = [bound for cone in feedback.cones for bound in cone.bounds]
    if not bounds or feedback.every_load is not None:
        return None
    value = rounded_down(min(float(slack) / float(fall) for slack, fall in bounds))
    return confirmed(value, lambda r: all(sign(s - r * fall) > 0 for s, fall in bounds), Fraction(99, 100), tries=1000)


def _bounded(proposal: Fraction, holds: Callable[[Fraction], bool], factor: Fraction) -> Fraction:
    """The bound that is confirmed.

    Raises:
        ValueError: where rounding spoils what floats propose.
    """
    bound = confirmed(proposal, holds, factor, tries=1000)
    if bound is None:
        raise ValueError("required numbers within the precision of floats")
    return bound
