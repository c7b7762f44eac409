"""Theorem 4 of Murphey and Burdick for one array: what its clauses say of the checked point, and what each rests on.

The cells, the velocities at the point, the fan of cones and all signs are derived from the wheels and looked at here.
Evidence are the weights of a mixture at rest, or a separating direction; what shows where bodies stay and how they come
home (:mod:`.regions`); and what shows that feedback serves, or that none does (:mod:`.feedback`).
"""

from __future__ import annotations

from typing import Any

from .contact import Cells
from .fan import fan_at_point
from .feedback import NO_CERTIFICATE, show_feedback, show_feedback_rate
from .positivity import Proofs
from .regions import show_arrival, show_disc, show_ellipse, show_turning
from .theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE, Statement
from .tower import Vector, dot, is_zero, signs
from .wheels import Array
from .work import require, take

CLAUSES = ("equilibrium", "translation", "rotation", "feedback", "theorem 4")  # kinds of claims
HOLDS, FAILS, HYPOTHESES_NOT_MET = "holds", "fails", "hypotheses not met"
NEUTRAL = "stable, not attractive"


def show_theorem4(array: Array, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The clauses that are decided, and the conclusion.

    The theorem says of an equilibrium: (x, y) is stable, theta unstable, and both are stabilized by feedback.  So a
    clause that shows the opposite refutes it, one left open leaves it open, and where the point is no equilibrium its
    hypotheses are not met.
    """
    points, cells_data, disc, *further = take(hypotheses, "points cells disc", "drift rate turn ellipse law")
    drift, rate, turn, ellipse, law = further
    cells = Cells(array, points, cells_data)
    clauses = Clauses(cells, proofs)
    equilibrium = clauses.show_equilibrium(drift)
    translation = clauses.show_translation()
    rotation = clauses.show_rotation(translation)
    feedback, plane = show_feedback(cells, proofs)
    words = {"translation": translation, "rotation": rotation, "feedback": feedback}
    conclusions: list[Statement] = [{"equilibrium": equilibrium}]
    stated = {**words, "drift": drift, "obstruction": plane}
    conclusions += [{kind: claim} for kind, claim in stated.items() if claim is not None]
    if law is not None:
        conclusions.append({"feedback rate": show_feedback_rate(cells, law)})
    if disc is not None:
        conclusions.append({"disc": {"squared_radius": disc, "decreases": show_disc(cells, proofs, cells.parse(disc))}})
    if rate is not None:
        require(disc is not None, "a disc of starts that arrive")
        show_arrival(cells, cells.parse(rate))
        conclusions.append({"arrival": {"squared_radius": disc, "rate": rate}})
    if turn is not None:
        require(
            disc is not None and clauses.rests, "a disc of starts, and a body that rests at the point without turning"
        )
        show_turning(cells, cells.parse(turn))
        conclusions.append({"turning": {"squared_radius": disc, "per_distance": turn}})
    if ellipse is not None:
        conclusions += show_ellipse(cells, ellipse, rests=clauses.rests)
    if not equilibrium:
        conclusions.append({"theorem 4": HYPOTHESES_NOT_MET})
    elif translation == UNSTABLE or rotation == NEUTRAL or plane is not None:
        conclusions.append({"theorem 4": FAILS})
    elif not {None, NO_CERTIFICATE} & set(words.values()):
        conclusions.append({"theorem 4": HOLDS})
    return conclusions


class Clauses:
    """Clauses 1 to 3 of one array with its cells; each method is a claim that it shows, or leaves open with None."""

    def __init__(self, cells: Cells, proofs: Proofs) -> None:
        self.cells, self.proofs, self.here, self.highest = cells, proofs, cells.here, cells.highest
        self.drift: list[int] | None = None
        self.fan = fan_at_point(cells, lambda motion: motion.twist) if self.highest >= 0 else ASYMPTOTICALLY_STABLE

    @property
    def rests(self) -> bool:
        """Whether a body at rest at the point does not turn."""
        return self.drift is not None and not any(self.drift)

    # ---- clause 1

    def show_equilibrium(self, drift: Any) -> bool:
        """The claim: 0 lies in F(c*), the convex hull of the velocities at the checked point; or it does not.

        Convex weights of velocities that cancel show the first (:meth:`_end_of_drift`).  A direction along which every
        velocity has a positive part shows the second: then so has every convex combination.
        """
        separator = self.proofs.evidence_if_any("separator")
        if separator is None:
            stated = None if drift is None else self.cells.vector(drift, 3)
            self.drift = [self._end_of_drift(-1, "lowest", stated), self._end_of_drift(1, "highest", stated)]
            return True
        direction = self.cells.vector(separator, 2)
        sound = drift is None and all(dot(direction, motion.twist).sign() > 0 for motion in self.here)
        require(sound, "a direction in which all velocities at the point lead")
        return False

    def _end_of_drift(self, side: int, name: str, stated: Vector | None) -> int:
        """The claim: one end of the range of omega over the members of F(c*) with zero velocity; here its sign.

        The weights (not negative, not all zero) mix the velocities to zero, and omega to an end ``w``.  Multipliers
        ``(a, b, t, q)``, q > 0, with ``a vx + b vy - side q omega + t >= 0`` at every twist show that no mixture with
        zero velocity passes ``side omega = t/q``, and the mixture attains it.  Where the range is stated, as
        ``[a/w, b/w]`` by three numbers, it ends there.
        """
        weights, multipliers = take(self.proofs.evidence(name), "weights multipliers")
        a, b, shift, scale = self.cells.vector(multipliers, 4)
        shares = self.cells.vector(weights, len(self.here))
        twists = [motion.twist for motion in self.here]
        x, y, omega, whole = (dot(shares, [twist[k] for twist in twists]) for k in range(4))
        outward = omega if side > 0 else -omega
        attained = [x, y, shift * whole - scale * outward]
        if stated is not None:
            low, high, bottom = stated
            require(bottom.sign() > 0, "a drift over a positive denominator")
            attained.append((low if side < 0 else high) * whole - omega * bottom)
        form = (a, b, -scale if side > 0 else scale, shift)
        above = [dot(form, twist) for twist in twists]
        convex = min(signs([*shares, *above])) >= 0 and min(signs((whole, scale))) > 0
        require(is_zero(attained) and convex, f"weights and multipliers of the {name} rate at rest")
        return omega.sign()

    # ---- clause 2

    def show_translation(self) -> str | None:
        """The claim: the point is (asymptotically) stable or unstable in (x, y).

        ``V = |c|^2`` changes by ``V* = 2 c . v``, linear on each closed cell, so its sign at the corners of the cells
        at the point is that near the point.  Negative: asymptotically stable.  Not positive: stable (Lyapunov for
        differential inclusions), and asymptotically where the fan of cones shows that all paths come home.  Positive
        somewhere: V shows nothing and the fan decides alone.
        """
        if self.highest > 0:
            return self.fan
        require(self.fan != UNSTABLE, "a fan of cones that agrees with V*")  # both are proved: never seen
        return self.fan if self.fan == ASYMPTOTICALLY_STABLE else STABLE

    # ---- clause 3

    def show_rotation(self, translation: str | None) -> str | None:
        """The claim: theta is unstable, or stable and not attractive (it never attracts: no twist depends on it).

        Unstable: the drift holds a rate other than zero, so the body may stay at the point and turn for ever.  With a
        drift of {0} theta is stable where the rotation along a path tends to zero with the distance of its start:
        ``|omega| <= K |v|`` on the polytope F(c*) (Hoffman 1952), so it is enough that paths near the point have
        lengths that do, as where all lead inward, or to rest without ties (tied motions might run to and fro).  It is
        also stable where the translation is and no motion at the point turns the body.
        """
        if self.drift is None:
            return None
        if any(self.drift):
            return UNSTABLE
        tied = any(len(cell.motions) > 1 for cell in self.cells.listed if cell.rays is not None)
        short = self.fan == ASYMPTOTICALLY_STABLE or (self.fan == STABLE and not tied)
        turning = any(motion.twist[2].sign() for motion in self.here)
        stable = translation in (ASYMPTOTICALLY_STABLE, STABLE)
        return NEUTRAL if short or (stable and not turning) else None
