"""How fast V falls where speeds are limited, under the law of imposed twists.

The law imposes ``-sigma k (g . xi_l) xi_l`` with one factor ``sigma <= 1`` that keeps every speed within its limit m_i.
With u_i the speeds that impose ``xi_l`` and ``q_l = min_i m_i/|u_i|``, a law at its limit has ``sigma k |g . xi_l| =
q_l``.  So ``V'/2 = -q_l |g . xi_l| <= -q_l sqrt(kappa V)`` where the rate is certified, and sqrt(V) falls at least with
the speed ``min_l q_l sqrt(kappa)``; elsewhere at the certified rate.  Under unknown loads V' is at least ``1 - eta`` of
that.
"""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import rim_speeds
from nonsmooth.proofs.clauses.feedback.rational_bounds import rounded_down
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import in_own_length

BELOW = 1 - Fraction(1, 2**40)  # more than a few roundings of a quotient of floats


def limited_speed(feedback: DrivenFeedback, scene: Scene) -> Fraction | None:
    """Speed with which sqrt(V) falls at least while a wheel is at its limit; None without a law, or without limits."""
    limits = scene.speed_limits
    if feedback.kappa is None or not limits:
        return None
    own = in_own_length(scene.recentred())
    least: list[float] = []
    for cone in feedback.cones:
        for imposed in cone.twists:
            speeds = dict(zip((wheel.index for wheel in own.wheels), rim_speeds(own, imposed), strict=True))
            least += [float(limit) / abs(speeds[wheel]) for wheel, limit in limits.items() if speeds[wheel]]
    if not least:
        return None
    ratio = Fraction(min(least)) * BELOW
    return ratio * rounded_down(float(feedback.kappa) ** 0.5) * feedback.kept
