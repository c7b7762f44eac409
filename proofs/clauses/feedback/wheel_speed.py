"""How fast wheels run under a certified law, for each unit of the error sqrt(V) and at gain k = 1.

- *Imposed twists.*  ``-k (g . xi_l) xi_l`` is imposed by ``-k (g . xi_l) u_l``, and with l for the unit of length
  ``|g . xi_l| <= |xi_l| |g|``: no rim is faster than ``k max_l |xi_l| max_i |u_l,i| sqrt(V)``.  The longest twist
  attains its bound, at the error g along it.  Speeds and lengths change their unit alike.
- *Laws by rows* with ``V = c^T P c + w theta^2``.  Wheel i with the control field ``(f, t)`` runs at
  ``-k (f . P c + t w theta)`` to first order, so no faster than ``k sqrt(f^T P f + w t^2) sqrt(V)`` (Cauchy-Schwarz).
"""

from __future__ import annotations

from fractions import Fraction
from typing import TYPE_CHECKING

from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import in_own_length

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.clause import AnyFeedback

ABOVE = 1 + Fraction(1, 2**40)  # more than a few roundings of a product of floats


def wheel_speed(feedback: AnyFeedback, scene: Scene) -> Fraction | None:
    """The largest speed of a rim over sqrt(V), at gain one; None without a V that falls under the law."""
    if isinstance(feedback, FeedbackResult):
        fastest = _by_rows(feedback) if feedback.has_lyapunov else 0.0
    else:
        from nonsmooth.proofs.clauses.feedback.driven_law import effort

        own = in_own_length(scene.recentred())
        fastest = max((effort(own, imposed) for cone in feedback.cones for imposed in cone.twists), default=0.0)
    return Fraction(fastest) * ABOVE if fastest else None


def _by_rows(feedback: FeedbackResult) -> float:
    (e, f), weight = ([float(x) for x in feedback.lyapunov.shape], float(feedback.lyapunov.weight))
    squares = [
        (1 + e) * x * x + 2 * f * x * y + (1 - e) * y * y + weight * turn * turn
        for data in feedback.cells
        for x, y, turn in (map(float, control) for control in data.state.control_fields.values())
    ]
    return float(max(squares) ** 0.5)
