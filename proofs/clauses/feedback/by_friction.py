"""Clause 4 under the rules that minimize the dissipation: a feedback for all wheels at once, or why there is none.

With ``V = |c|^2 + l^2 theta^2`` one has ``V'/2 = g . xi``, ``g = (c, l^2 theta)``, under exact and leading-order
kinematics.  The array is taken with l for its unit of length, where ``g = (c, theta)``: so all that follows is the same
in every unit.  A twist ``(v, omega)`` there is ``(v, omega/l)`` in the scene's unit, imposed by the same speeds.

- *Stabilizable.*  Let some speeds impose the twist ``xi_l``, as the only minimizer of D at c*, for three independent
  ``xi_l`` (module ``box_twists``, module ``ellipse_twists``).  D is
  homogeneous in twist and speeds together, so all multiples are imposed too.  The law takes the ``xi_l`` with the
  largest ``|g . xi_l|`` and imposes ``-k (g . xi_l) xi_l``: ``V'/2 = -k (g . xi_l)^2 <= -k kappa |g|^2`` near c*, where
  ``kappa |g|^2 < 1`` at the corners ``g . xi_l = +-1`` of a parallelepiped.  Where the law switches, each of the
  velocities that meet satisfies this, hence all of their hull: V* < 0.  Under rule ``box`` it suffices that twists are
  imposed in every open cone of a fan of directions of c, in each its own three: Filippov solutions do not see the rays
  between.
- *Unknown loads.*  Where the loads are only known to lie in a set, other loads than those of level springs turn the
  motions away from the ``xi_l``; the law works under every load as long as they stay in pyramids about the ``xi_l``, at
  the rate ``(1 - eta) kappa`` (module ``every_load_law``).  A plane that no twist leaves on level springs refutes too.
- *Not stabilizable.*  Let all twists that speeds can impose at c* lie in a plane.  Near c* there are no others, so
  Brockett's condition refutes every static feedback (:mod:`nonsmooth.proofs.clauses.feedback.obstruction`).

Between the two stand, under rule ``box``, an exact balance of frictions at c* (a slope of D that vanishes there), and
under rules without cells twists that are neither proved nor excluded.  Two laws of the field are sampled beside that
(:mod:`nonsmooth.analysis.minimizers.sampled_feedback`); samples decide nothing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from itertools import pairwise
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.fan import by_angle
from nonsmooth.analysis.cells.loads import LoadRegion, load_regions
from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.proofs.clauses.feedback.box_twists import BoxTwist
from nonsmooth.proofs.clauses.feedback.by_direction import drives_in, law_by_direction
from nonsmooth.proofs.clauses.feedback.control_fields import askew_reason, side_friction_rules
from nonsmooth.proofs.clauses.feedback.control_lyapunov import ControlLyapunov, sum_of_squares
from nonsmooth.proofs.clauses.feedback.driven_law import (
    ImposedTwist,
    LawCone,
    best_three,
    certified_gain,
    gains,
    in_scene,
    rank_of,
)
from nonsmooth.proofs.clauses.feedback.inscribed_box import inscribed_boxes
from nonsmooth.proofs.clauses.feedback.obstruction import common_normal, obstruction_text
from nonsmooth.proofs.clauses.feedback.twist_candidates import candidates_of, with_exclusions
from nonsmooth.proofs.clauses.witness import Witness
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.symbolic.constraints import Triple, inner
from nonsmooth.symbolic.free_rollers import with_rims_along_axes
from nonsmooth.symbolic.number_text import lower_text
from nonsmooth.symbolic.numbers.lazy import Lazy, divided, quotient
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit
from nonsmooth.symbolic.plane import around, cross
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import in_own_length
from nonsmooth.symbolic.unknown_loads import UnknownLoads

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampled_feedback import LoopSample
    from nonsmooth.proofs.clauses.feedback.every_load_law import EveryLoadLaw

LAW = "impose -k (g . xi_l) xi_l, g = (c, theta), with the xi_l of the largest |g . xi_l|"
WEIGHED_LAW = "impose -k (g . xi_l) xi_l, g = (c, w theta), with the xi_l of the largest |g . xi_l|, w = {}"
SAME_REACH = 2.0**-20  # relative: reaches as close as this are compared exactly
FOR_EVERY_LOAD = (
    "some speeds impose three independent twists on level springs, and under every load motions so close to them that "
    "V falls (at {} times the rate on level springs)"
)
NOT_FOR_EVERY_LOAD = "no law of three imposed twists is shown to work under every load; on level springs: {}"
UNITS = 5_000_000  # of exact arithmetic for a law that Theorem 4 does not ask for
TOO_LONG = f"whether a law holds the pose is not decided within {UNITS} operations of exact arithmetic"
ENOUGH_FOR_EVERY_LOAD = 24  # candidates, of which no more than sixteen are combined
ON_LEVEL_SPRINGS = "on level springs, which are among the loads: {}"
STALL = "V' = 0 for every input at small multiples of this (c, theta)"


@dataclass(frozen=True)
class DrivenFeedback:
    """Verdict with its evidence.

    Attributes:
        verdict: see :class:`nonsmooth.proofs.verdicts.Feedback`.
        reason: one sentence for people.
        cones: the law, by direction of c, of the array with ``length`` for its unit (stabilizable).
        kappa: ``V' <= -2 k kappa V`` near c* (stabilizable), on level springs where loads are unknown.
        obstruction: the normal m of a plane that holds every twist inputs can impose (no certificate): no static
            feedback stabilizes.
        candidates: all candidates in the unit ``length``, those off the plane with the proof that they are excluded
            (no certificate).
        samples: two laws of the field, sampled, best first; empty where nobody asked.
        length: l of ``V = |c|^2 + l^2 theta^2``.
        every_load: what is left of the rate under every load of a set (stabilizable, unknown loads).
        beyond: the same decision where Theorem 4 asks nothing of feedback (not applicable).
    """

    verdict: Feedback
    reason: str
    cones: tuple[LawCone, ...] = ()
    kappa: Fraction | None = None
    obstruction: Triple | None = None
    candidates: tuple[ImposedTwist, ...] = ()
    samples: tuple[LoopSample, ...] = field(default=(), compare=False)
    length: Fraction = Fraction(1)
    every_load: EveryLoadLaw | None = None
    beyond: DrivenFeedback | None = None

    @property
    def holding(self) -> DrivenFeedback:
        """Whether some law holds the pose, whatever Theorem 4 asks: this decision, or the one beyond the theorem."""
        return self if self.beyond is None else self.beyond

    @property
    def lyapunov(self) -> ControlLyapunov:
        """``V = |c|^2 + l^2 theta^2``."""
        return sum_of_squares(self.length)

    @property
    def law(self) -> str | None:
        """The stabilizing law, where there is one."""
        if self.verdict is not Feedback.STABILIZABLE:
            return None
        return LAW if self.length == 1 else WEIGHED_LAW.format(self.lyapunov.weight)

    @property
    def must_know(self) -> tuple[str, ...]:
        """What the law must know to choose its inputs."""
        return "the position", "the heading"

    @property
    def certified_kappa(self) -> Fraction | None:
        """Kappa with ``V' <= -2 k kappa V`` near the equilibrium under every load that may be, k the gain."""
        return None if self.kappa is None else self.kappa * self.kept

    @property
    def has_lyapunov(self) -> bool:
        """Whether V certifies a law."""
        return self.verdict is Feedback.STABILIZABLE

    @property
    def kept(self) -> Fraction:
        """``1 - eta``: the share of the rate that is left under every load; one where the load is known."""
        return Fraction(1) if self.every_load is None else 1 - self.every_load.slack

    @property
    def position_error(self) -> None:
        """None: how much the law may misjudge the position is not examined."""

    @property
    def reach(self) -> Number | Lazy | None:
        """The rate holds while ``|x|, |y| < reach`` about c*, for every theta, where all slopes of D are known.

        So it is under rule ``box``, and with boxes inside friction sets, for loads that are known.
        """
        if self.every_load is not None:
            return None
        bounds = dict.fromkeys(bound for cone in self.cones for bound in cone.bounds)
        floats = {bound: float(bound[0]) / float(bound[1]) for bound in bounds}
        least = min(floats.values(), default=0) * (1 + SAME_REACH)
        near = [bound for bound, value in floats.items() if value <= least]
        if not near:
            return None
        slack, fall = min(near, key=lambda bound: divided(*bound))
        return quotient(slack * self.length, fall)

    @property
    def witness(self) -> Witness | None:
        """A direction of (c, theta) along which no input changes V (no certificate)."""
        if self.obstruction is None:
            return None
        x, y, turn = self.obstruction
        return Witness((x, y), turn / self.lyapunov.weight, STALL)

    def check(self) -> bool:
        """Re-verify the twists and the rate (stabilizable), or that all off the plane is excluded (no certificate)."""
        normal = self.obstruction
        if self.verdict is Feedback.NO_CERTIFICATE:
            kept = normal is not None and all(
                not inner(normal, in_scene(c.twist, self.length)) or c.is_excluded for c in self.candidates
            )
            return kept and not self.cones and normal is not None and any(normal)
        if self.verdict is not Feedback.STABILIZABLE:
            return not self.cones and normal is None and (self.beyond is None or self.beyond.check())
        kappa = self.kappa
        fast = kappa is not None and kappa > 0 and all(gains(cone.vectors, kappa) for cone in self.cones)
        safe = self.every_load is None or all(map(self.every_load.check, self.cones))
        return fast and safe and _go_around(self.cones) and all(cone.check() for cone in self.cones)


def decide_driven_feedback(scene: Scene) -> DrivenFeedback:
    """Decide the feedback clause for a centred scene of a rule that minimizes the dissipation.

    Where ``mu_S >= mu_R`` Theorem 4 asks nothing of feedback; whether a law holds the pose is decided all the same.
    """
    blocked = side_friction_rules(scene.wheels)
    if blocked is not None:
        beyond = _decide_within_limit(scene)
        return DrivenFeedback(Feedback.NOT_APPLICABLE, blocked, length=scene.check.length, beyond=beyond)
    if with_rims_along_axes(scene) is None:
        return DrivenFeedback(Feedback.UNDECIDED, askew_reason(scene.wheels), length=scene.check.length)
    return decide_whatever_friction(scene)


def _decide_within_limit(scene: Scene) -> DrivenFeedback:
    """The decision, undecided where it takes too much arithmetic."""
    try:
        with work_limit(scene.field, UNITS):
            return decide_whatever_friction(scene)
    except WorkLimitError:
        return DrivenFeedback(Feedback.UNDECIDED, TOO_LONG, length=scene.check.length)


def decide_whatever_friction(scene: Scene) -> DrivenFeedback:
    """Whether a law of imposed twists holds the pose, whatever the friction.

    Wheels on rollers that turn freely are driven like wheels whose rims lie along the axes of the rollers.
    """
    plain = with_rims_along_axes(scene)
    if plain is None:
        return DrivenFeedback(Feedback.UNDECIDED, askew_reason(scene.wheels), length=scene.check.length)
    decide = _decide_for_every_load if isinstance(scene.contact.loads, UnknownLoads) else _decide
    return replace(decide(in_own_length(plain), scene.check.length), length=scene.check.length)


def _decide_for_every_load(scene: Scene, length: Fraction) -> DrivenFeedback:
    """One law for all loads; where even those of level springs leave a plane of twists only, none."""
    from nonsmooth.proofs.clauses.feedback.every_load_law import on_level_springs, search_law

    level = on_level_springs(scene)
    unique = _imposed(level)
    if rank_of(unique) < 3:
        without = _decide(level, length)
        if without.verdict is Feedback.NO_CERTIFICATE:
            return replace(without, reason=ON_LEVEL_SPRINGS.format(without.reason))
        why = without.reason
    else:
        found = search_law(scene, unique)
        if found is not None:
            cone, law = found
            reason = FOR_EVERY_LOAD.format(lower_text(1 - law.slack, 3))
            return replace(_stabilizable(reason, (cone,)), every_load=law)
        why = "some speeds impose three independent twists"
    return DrivenFeedback(Feedback.UNDECIDED, NOT_FOR_EVERY_LOAD.format(why))


def _imposed(scene: Scene) -> list[ImposedTwist]:
    """Twists that some speeds impose as the only minimizer, forces and boxes inside friction sets together."""
    zero = scene.field.zero
    boxed = None if isinstance(rule_of(scene), CellRule) else inscribed_boxes(scene)
    found = []
    for each in (scene, boxed):
        if each is not None:
            candidates, _ = candidates_of(each, load_regions(each, (zero, zero))[0], ENOUGH_FOR_EVERY_LOAD)
            found += [imposed for imposed in candidates if imposed.is_unique]
    return found


def _decide(scene: Scene, length: Fraction) -> DrivenFeedback:
    """The decision for an array with l for its unit of length; a plane of twists is given in the unit before.

    What forces leave open, boxes inside the friction sets may prove (module ``inscribed_box``).
    """
    found = _decide_by_twists(scene, length)
    if found.verdict is not Feedback.UNDECIDED or isinstance(rule_of(scene), CellRule):
        return found
    boxed = inscribed_boxes(scene)
    inside = None if boxed is None else _decide_by_twists(boxed, length)
    if inside is None or inside.verdict is not Feedback.STABILIZABLE:
        return found
    words = f"{inside.reason}; no rim slips along, and rollers turn (boxes inside the friction sets)"
    return replace(inside, reason=words)


def _decide_by_twists(scene: Scene, length: Fraction) -> DrivenFeedback:
    zero = scene.field.zero
    regions = load_regions(scene, (zero, zero))
    candidates, complete = candidates_of(scene, regions[0])
    unique = [imposed for imposed in candidates if imposed.is_unique]
    if rank_of(unique) == 3:
        reason = "some speeds impose three independent twists at c*, each as the only minimizer of D"
        three = best_three(scene, unique)
        others = regions[1:] if isinstance(rule_of(scene), CellRule) else ()
        elsewhere = tuple(drives.examine(one.twist) for drives in drives_in(scene, others) for one in three)
        return _stabilizable(reason, (LawCone(None, three, elsewhere),))
    if not complete:
        return _decide_by_ties(scene, regions, candidates)
    candidates = with_exclusions(candidates)
    possible = [candidate.twist for candidate in candidates if not candidate.is_excluded]
    normal = common_normal([in_scene(twist, length) for twist in possible], scene.field)
    if normal is not None:
        reason = obstruction_text(normal)
        return DrivenFeedback(Feedback.NO_CERTIFICATE, reason, obstruction=normal, candidates=tuple(candidates))
    if isinstance(rule_of(scene), CellRule):
        cones, why = law_by_direction(scene, regions, possible)
        return _stabilizable(why, cones) if cones else DrivenFeedback(Feedback.UNDECIDED, why)
    reason = f"twists of rank {rank_of(unique)} are proved to be imposed at c*; others are neither proved nor excluded"
    return DrivenFeedback(Feedback.UNDECIDED, reason)


def _decide_by_ties(scene: Scene, regions: Sequence[LoadRegion], candidates: Sequence[ImposedTwist]) -> DrivenFeedback:
    """Of some candidates only: a law by directions of c where they give one, and otherwise nothing."""
    possible = [candidate.twist for candidate in candidates if not candidate.is_excluded]
    if isinstance(rule_of(scene), CellRule) and common_normal(possible, scene.field) is None:
        cones, reason = law_by_direction(scene, regions, possible)
        if cones:
            return _stabilizable(reason, cones)
    rank = rank_of([candidate for candidate in candidates if candidate.is_unique])
    reason = f"the first {len(candidates)} candidates show twists of rank {rank}; more were not looked at"
    return DrivenFeedback(Feedback.UNDECIDED, reason)


def is_driven_by(feedback: DrivenFeedback, scene: Scene) -> bool:
    """Whether all that is imposed is imposed in a load region of the centred scene, or by its wheels."""
    zero = scene.field.zero
    if feedback.length != scene.check.length:
        return False
    if feedback.beyond is not None:
        return is_driven_by(feedback.beyond, scene)
    own = in_own_length(scene)
    if feedback.every_load is not None:
        plain = with_rims_along_axes(scene)
        if plain is None or feedback.every_load.scene != in_own_length(plain):
            return False
    if isinstance(scene.contact.loads, UnknownLoads):
        if feedback.cones and feedback.every_load is None:
            return False
        own = replace(own, contact=replace(own.contact, loads=None))
    regions = load_regions(own, (zero, zero))
    shown = [twist for cone in feedback.cones for twist in (*cone.twists, *cone.elsewhere)]
    imposed = (*shown, *feedback.candidates)
    numbers = {wheel.index for wheel in scene.wheels}
    return all(
        twist.region in regions if isinstance(twist, BoxTwist) else {w.index for w in twist.wheels} <= numbers
        for twist in imposed
    )


def _stabilizable(reason: str, cones: tuple[LawCone, ...]) -> DrivenFeedback:
    kappa = min(certified_gain(cone.vectors) for cone in cones)
    return DrivenFeedback(Feedback.STABILIZABLE, reason, cones, kappa)


def _go_around(cones: Sequence[LawCone]) -> bool:
    """Whether cones cover all directions of c: one all around, or each from the last ray of the one before it."""
    rays = [cone.rays for cone in cones if cone.rays is not None]
    if len(rays) != len(cones) or not rays:
        return len(cones) == 1
    chained = all(before[1] == after[0] for before, after in around(rays))
    ordered = all(by_angle(a[0]) < by_angle(b[0]) for a, b in pairwise(rays))
    return chained and ordered and all(sign(cross(*pair)) > 0 for pair in rays)
