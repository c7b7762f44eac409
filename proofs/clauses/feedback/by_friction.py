"""Clause 4 under the rules that minimize the dissipation: a feedback for all wheels at once, or why there is none.

With ``V = |c|^2 + l^2 theta^2`` one has ``V'/2 = g . xi``, ``g = (c, l^2 theta)``, under exact and leading-order
kinematics.  The array is taken with l for its unit of length, where ``g = (c, theta)``: so all that follows is the same
in every unit.  A twist ``(v, omega)`` there is ``(v, omega/l)`` in the scene's unit, imposed by the same speeds.

- *Stabilizable.* Let some speeds impose the twist ``xi_l``, as the only minimizer of D at c*, for three independent
  ``xi_l`` (modules ``twist_candidates``, ``balanced_twists``). D is homogeneous in twist and speeds together, so all
  multiples are imposed too. The law takes the ``xi_l`` with the largest ``|g . xi_l|`` and imposes ``-k (g . xi_l)
  xi_l``: ``V'/2 = -k (g . xi_l)^2 <= -k kappa |g|^2`` near c* (module ``driven_law``). Where the law switches, each
  of the velocities that meet satisfies this, hence all of their hull: V* < 0. Under rule ``box`` it suffices that
  twists are imposed in every open cone of a fan of directions of c, in each its own three: Filippov solutions do not
  see the rays between. A slope of D that vanishes at c* is linear in c beside it: between the rays on which one
  vanishes, or the loads change their form, each twist is the only minimizer in all of the cone or nowhere in it.
- *Boxes inside friction sets* may prove what forces leave open where the sets are cut (module ``twist_candidates``).
- *Unknown loads.*  Where the loads are only known to lie in a set, other loads than those of level springs turn the
  motions away from the ``xi_l``; the law works under every load as long as they stay in pyramids about the ``xi_l``, at
  the rate ``(1 - eta) kappa`` (module ``every_load_law``).  A plane that no twist leaves on level springs refutes too.
- *A place of rest beside c*.*  A twist is about the origin, whichever point the body is brought to: a law about a point
  c_1 needs that the ``xi_l`` are the only minimizers at c_1, and only loads differ there.  Forces in balance are proved
  with the loads of a whole disc at once; about each of its points, and for every member of what was rounded, the same
  twists then make a law, with ``(c - c_1, theta)`` for g (:func:`decided_around`).
- *Not stabilizable.*  Let all twists that speeds can impose at c* lie in a plane.  Near c* there are no others, so
  Brockett's condition refutes every static feedback (:mod:`nonsmooth.proofs.clauses.feedback.control_fields`).

Between the two stand, under rule ``box``, an exact balance of frictions at c* (a slope of D that vanishes there), and
under rules without cells twists that are neither proved nor excluded.  Two laws of the field are sampled beside that
(:mod:`nonsmooth.analysis.minimizers.sampling`); samples decide nothing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING

from flint import arb, ctx

from nonsmooth.analysis.cells.contact_rule import has_cells, rule_of
from nonsmooth.analysis.cells.fan import by_angle
from nonsmooth.analysis.cells.loads import LoadRegion, load_regions
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.boxes.balanced_forces import load_box
from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.clauses.clause import Witness
from nonsmooth.proofs.clauses.feedback.balanced_twists import PRECISION, BalancedTwist, exclude_twist
from nonsmooth.proofs.clauses.feedback.control_fields import (
    ControlLyapunov,
    askew_reason,
    common_normal,
    obstruction_text,
    side_friction_rules,
    sum_of_squares,
)
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, best_three, certified_gain, in_scene
from nonsmooth.proofs.clauses.feedback.rational_bounds import ball_of
from nonsmooth.proofs.clauses.feedback.twist_candidates import (
    BoxTwist,
    Drives,
    ImposedTwist,
    candidates_of,
    inscribed_boxes,
    rank_of,
    unique_ones,
    with_exclusions,
)
from nonsmooth.proofs.findings import Feedback
from nonsmooth.symbolic.mechanics.contact_states import Triple, with_rims_along_axes
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length, with_wheels
from nonsmooth.symbolic.numbers.lazy import Lazy, divided, float_quotient, quotient
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import brief_text, lower_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, plus
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING, remembered
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampling import LoopSample
    from nonsmooth.proofs.clauses.feedback.every_load_law import EveryLoadLaw

LAW = "impose -k (g . xi_l) xi_l, g = (c, theta), with the xi_l of the largest |g . xi_l|"
WEIGHED_LAW = "impose -k (g . xi_l) xi_l, g = (c, w theta), with the xi_l of the largest |g . xi_l|, w = {}"
SAME_REACH = 2.0**-20  # relative: reaches as close as this are compared exactly
THREE = "some speeds impose three independent twists at c*, each as the only minimizer of D"
BY_DIRECTION = (
    "frictions balance exactly at c*, but in each of {} cones of directions about it some speeds impose "
    "three independent twists, each as the only minimizer of D (Filippov solutions do not see the rays between)"
)
MARGINAL = (
    "exactly marginal: frictions balance at c* (a slope of D vanishes), and towards ({}, {}) speeds impose twists of "
    "rank {} only, as the only minimizers"
)
IN_BOXES = "{}; no rim slips along, and rollers turn (boxes inside the friction sets)"
FOR_EVERY_LOAD = (
    "some speeds impose three independent twists on level springs, and under every load motions so close to them that "
    "V falls (at {} times the rate on level springs)"
)
NOT_FOR_EVERY_LOAD = "no law of three imposed twists is shown to work under every load; on level springs: {}"
UNITS = 5_000_000  # of exact arithmetic for a law that Theorem 4 does not ask for
TOO_LONG = f"whether a law holds the pose is not decided within {UNITS} operations of exact arithmetic"
ENOUGH_FOR_EVERY_LOAD = 24  # candidates, of which no more than sixteen are combined
BESIDE_OPEN = f"{BY_ROUNDING}what is shown at the point is not shown at a place of rest so close to it"
ON_LEVEL_SPRINGS = "on level springs, which are among the loads: {}"
STALL = "V' = 0 for every input at small multiples of this (c, theta)"


@dataclass(frozen=True)
class DrivenFeedback:
    """Verdict with its evidence.

    Attributes:
        verdict: see :class:`nonsmooth.proofs.findings.Feedback`.
        reason: one sentence for people.
        scene: the array, centred.
        cones: the law, by direction of c, of the array with ``length`` for its unit (stabilizable).
        kappa: ``V' <= -2 k kappa V`` near c* (stabilizable), on level springs where loads are unknown.
        obstruction: the normal m of a plane that holds every twist inputs can impose (no certificate): no static
            feedback stabilizes.
        candidates: all candidates in the unit ``length``, those off the plane excluded (no certificate).
        samples: two laws of the field, sampled, best first; empty where nobody asked.
        every_load: what is left of the rate under every load of a set (stabilizable, unknown loads).
        beyond: the same decision where Theorem 4 asks nothing of feedback (not applicable).
    """

    verdict: Feedback
    reason: str
    scene: Scene
    cones: tuple[LawCone, ...] = ()
    kappa: Fraction | None = None
    obstruction: Triple | None = None
    candidates: tuple[ImposedTwist, ...] = ()
    samples: tuple[LoopSample, ...] = field(default=(), compare=False)
    every_load: EveryLoadLaw | None = None
    beyond: DrivenFeedback | None = None

    @property
    def length(self) -> Fraction:
        """The characteristic length l of ``V = |c|^2 + l^2 theta^2``."""
        return self.scene.check.length

    @property
    def holding(self) -> DrivenFeedback:
        """Whether some law holds the pose, whatever Theorem 4 asks: this decision, or the one beyond the theorem."""
        return self if self.beyond is None else self.beyond

    @property
    def lyapunov(self) -> ControlLyapunov:
        """``V = |c|^2 + l^2 theta^2``."""
        return sum_of_squares(self.length)

    @property
    def has_lyapunov(self) -> bool:
        """Whether V certifies a law."""
        return self.verdict is Feedback.STABILIZABLE

    @property
    def law(self) -> str | None:
        """The stabilizing law, where there is one."""
        if not self.has_lyapunov:
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
    def kept(self) -> Fraction:
        """``1 - eta``: the share of the rate that is left under every load; one where the load is known."""
        return Fraction(1) if self.every_load is None else 1 - self.every_load.slack

    @property
    def position_error(self) -> None:
        """None: how much the law may misjudge the position is not examined."""

    @cached_property
    def reach(self) -> Number | Lazy | None:
        """The rate holds while ``|x|, |y| < reach`` about c*, for every theta, where all slopes of D are known.

        So it is under rule ``box``, and with boxes inside friction sets, for loads that are known.
        """
        if self.every_load is not None:
            return None
        bounds = dict.fromkeys(bound for cone in self.cones for bound in cone.bounds)
        floats = {bound: float_quotient(*bound) for bound in bounds}
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

    def undecided(self, reason: str) -> DrivenFeedback:
        """The same without a claim."""
        return DrivenFeedback(Feedback.UNDECIDED, reason, self.scene, samples=self.samples)


def decide_driven_feedback(scene: Scene) -> DrivenFeedback:
    """Decide the feedback clause for a centred scene of a rule that minimizes the dissipation.

    Where ``mu_S >= mu_R`` Theorem 4 asks nothing of feedback; whether a law holds the pose is decided all the same,
    and undecided where that takes too much arithmetic.
    """
    blocked = side_friction_rules(scene.wheels)
    if blocked is None:
        return decide_whatever_friction(scene)
    try:
        with work_limit(scene.field, UNITS):
            beyond = decide_whatever_friction(scene)
    except WorkLimitError:
        beyond = DrivenFeedback(Feedback.UNDECIDED, TOO_LONG, scene)
    return DrivenFeedback(Feedback.NOT_APPLICABLE, blocked, scene, beyond=beyond)


def decided_around(feedback: DrivenFeedback, distance: Fraction) -> DrivenFeedback:
    """What was decided at the checked point, where the same is so about every point that near; else undecided.

    The speeds, and the rate, stay those about the checked point: about others they differ as little as the points.

    Args:
        feedback: the decision at the point, of loads that are known, under a rule without cells.
        distance: of a place of rest from the point, at most.
    """
    if feedback.beyond is not None:
        return replace(feedback, beyond=decided_around(feedback.beyond, distance))
    if feedback.verdict is Feedback.UNDECIDED or _holds_around(feedback, distance):
        return feedback
    return feedback.undecided(BESIDE_OPEN)


def _holds_around(feedback: DrivenFeedback, distance: Fraction) -> bool:
    """Whether the twists of a law are imposed, or those off its plane excluded, with the body at all places so near."""
    scene = feedback.scene
    with ctx.workprec(PRECISION):
        forms, disc = load_box(scene, arb(0)), ball_of(distance) * UNIT
        loads = [] if forms is None else forms.at((disc, disc))
        if forms is None or not all(load > 0 for load in loads):
            return False
        pairs = zip(scene.wheels, loads, forms.forms, strict=True)
        shares = {wheel.index: load / form[0] for wheel, load, form in pairs}
    if feedback.verdict is Feedback.NO_CERTIFICATE:
        off = [candidate for candidate in feedback.candidates if candidate.is_excluded]
        return all(isinstance(one, BalancedTwist) and exclude_twist(one.around(shares)).is_excluded for one in off)
    if feedback.reach is not None:
        return all(cone.rays is None for cone in feedback.cones) and feedback.reach > distance
    twists = [twist for cone in feedback.cones for twist in cone.twists]
    return all(isinstance(twist, BalancedTwist) and twist.around(shares).is_unique for twist in twists)


def decide_whatever_friction(scene: Scene) -> DrivenFeedback:
    """Whether a law of imposed twists holds the pose, whatever the friction.

    Wheels on rollers that turn freely are driven like wheels whose rims lie along the axes of the rollers.
    """
    plain = with_rims_along_axes(scene)
    if plain is None:
        return DrivenFeedback(Feedback.UNDECIDED, askew_reason(scene.wheels), scene)
    return replace(_decide_at_rest(with_wheels(in_own_length(plain), _at_rest), scene.check.length), scene=scene)


def _at_rest(wheel: Wheel) -> Wheel:
    return replace(wheel, given_speed=wheel.speed * 0)


@remembered(2)  # a law chooses the speeds: an array is decided once, whichever of its wheels are stopped
def _decide_at_rest(scene: Scene, length: Fraction) -> DrivenFeedback:
    """The decision for an array with l for its unit of length, whose speeds are not looked at."""
    return (_decide_for_every_load if scene.contact.loads_are_unknown else _decide)(scene, length)


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
        cone_and_law = search_law(scene, unique)
        if cone_and_law is not None:
            cone, law = cone_and_law
            reason = FOR_EVERY_LOAD.format(lower_text(1 - law.slack, 3))
            return replace(_stabilizable(reason, scene, (cone,)), every_load=law)
        why = "some speeds impose three independent twists"
    return DrivenFeedback(Feedback.UNDECIDED, NOT_FOR_EVERY_LOAD.format(why), scene)


def _imposed(scene: Scene) -> list[ImposedTwist]:
    """Twists that some speeds impose as the only minimizer, forces and boxes inside friction sets together."""
    boxed = None if has_cells(scene) else inscribed_boxes(scene)
    imposed = []
    for each in (scene, boxed):
        if each is not None:
            candidates, _ = candidates_of(each, _regions_at(each)[0], ENOUGH_FOR_EVERY_LOAD)
            imposed += unique_ones(candidates)
    return imposed


def _decide(scene: Scene, length: Fraction) -> DrivenFeedback:
    """The decision for an array with l for its unit of length; a plane of twists is given in the unit before.

    What forces leave open, boxes inside the friction sets may prove.
    """
    feedback = _decide_by_twists(scene, length)
    boxed = None
    if feedback.verdict is Feedback.UNDECIDED and not has_cells(scene):
        boxed = inscribed_boxes(scene)
    inside = feedback if boxed is None else _decide_by_twists(boxed, length)
    if inside is feedback or inside.verdict is not Feedback.STABILIZABLE:
        return feedback
    return replace(inside, reason=IN_BOXES.format(inside.reason))


def _decide_by_twists(scene: Scene, length: Fraction) -> DrivenFeedback:
    regions = _regions_at(scene)
    candidates, complete = candidates_of(scene, regions[0])
    unique = unique_ones(candidates)
    if rank_of(unique) == 3:
        three = best_three(scene, unique)
        others = [Drives(scene, region) for region in regions[1:]] if has_cells(scene) else []
        elsewhere = tuple(drives.examine(one.twist) for drives in others for one in three)
        if all(one.is_unique for one in elsewhere):
            return _stabilizable(THREE, scene, (LawCone(None, three, elsewhere),))
    if complete:
        candidates = with_exclusions(candidates)
    possible = [candidate.twist for candidate in candidates if not candidate.is_excluded]
    normal = common_normal([in_scene(twist, length) for twist in possible], scene.field)
    if complete and normal is not None:
        reason, proofs = obstruction_text(normal), tuple(candidates)
        return DrivenFeedback(Feedback.NO_CERTIFICATE, reason, scene, obstruction=normal, candidates=proofs)
    rank = rank_of(unique)
    reason = f"twists of rank {rank} are proved to be imposed at c*; others are neither proved nor excluded"
    if not complete:
        reason = f"the first {len(candidates)} candidates show twists of rank {rank}; more were not looked at"
    if has_cells(scene) and normal is None:
        cones, why = law_by_direction(scene, regions, possible)
        if cones:
            return _stabilizable(why, scene, cones)
        reason = why if complete else reason
    return DrivenFeedback(Feedback.UNDECIDED, reason, scene)


def _regions_at(scene: Scene) -> Sequence[LoadRegion]:
    """The load regions that meet at the point."""
    zero = scene.field.zero
    return load_regions(scene, (zero, zero))


def _stabilizable(reason: str, scene: Scene, cones: tuple[LawCone, ...]) -> DrivenFeedback:
    kappa = min(certified_gain(cone.vectors) for cone in cones)
    return DrivenFeedback(Feedback.STABILIZABLE, reason, scene, cones, kappa)


# ---- an exact balance of frictions: a law by directions of c -----------------------------


def law_by_direction(
    scene: Scene, regions: Sequence[LoadRegion], twists: Sequence[Triple]
) -> tuple[tuple[LawCone, ...], str]:
    """The cones of a law and a sentence; no cones, and why, where some directions have no three twists."""
    by_region = [[drives.examine(twist) for twist in twists] for drives in (Drives(scene, r) for r in regions)]
    cones: list[LawCone] = []
    for start, end in _cones(scene, regions, by_region):
        middle = plus(start, end)  # inside a cone of less than a half turn
        here = next(twists for region, twists in zip(regions, by_region, strict=True) if _points_into(region, middle))
        unique = [twist for twist in here if twist.is_unique_towards(middle)]
        if rank_of(unique) < 3:
            x, y = (brief_text(entry) for entry in middle)
            return (), MARGINAL.format(x, y, rank_of(unique))
        cones.append(LawCone((start, end), best_three(scene, unique)))
    return tuple(cones), BY_DIRECTION.format(len(cones))


def _cones(
    scene: Scene, regions: Sequence[LoadRegion], by_region: Sequence[Sequence[BoxTwist]]
) -> list[tuple[Point, Point]]:
    """Cones of directions inside which no slope that vanishes at c* changes its sign, nor the loads their form."""
    rays = sorted((ray for a, b in _lines(scene, regions, by_region) for ray in ((-b, a), (b, -a))), key=by_angle)
    rays = [rays[0], *(ray for last, ray in pairwise(rays) if cross(last, ray))]  # none is a half turn from the next
    return around(rays)


def _lines(scene: Scene, regions: Sequence[LoadRegion], by_region: Sequence[Sequence[BoxTwist]]) -> Iterator[Point]:
    """Normals of the lines through the point on which a slope vanishes or the loads change, and both axes."""
    zero, one = scene.field.zero, scene.field.one
    yield from ((one, zero), (zero, one))
    for region in regions:
        yield from (side.normal for side in region.polygon.sides if not sign(side.offset))
    for twists in by_region:
        yield from ((form[1], form[2]) for twist in twists for form in twist.ties if any(form))


def _points_into(region: LoadRegion, direction: Point) -> bool:
    """Whether a direction leads from the equilibrium into a load region that holds it."""
    through = (side for side in region.polygon.sides if not sign(side.offset))
    return all(sign(dot(side.normal, direction)) < 0 for side in through)


# ---- two laws of the field in closed loop, sampled beside an undecided clause: they decide nothing ---------------


# Random states per law, each one minimization (a linear program of a millisecond under rule box); the search adds
# a few hundred.
STATES = {"box": 100, "ellipse": 1_000}


def with_samples(feedback: DrivenFeedback, scene: Scene) -> DrivenFeedback:
    """The feedback with two laws of the field sampled in the checked square of the centred scene."""
    from nonsmooth.analysis.fields.contact_model import contacts_under
    from nonsmooth.analysis.minimizers.minimum import free_motions, functional_of
    from nonsmooth.analysis.minimizers.sampling import LoopSample, SampledLaw, sample_closed_loop

    rule = rule_of(scene)
    functional = functional_of(rule)
    if functional is None:
        raise TypeError(f"required a rule that minimizes the dissipation, received {scene.contact.rule}")
    scaled = in_own_length(scene)
    model = contacts_under(rule, scaled)
    radius, states = scaled.check.half_width, STATES[functional]
    free = free_motions(scene)
    if free:
        return replace(feedback, samples=tuple(LoopSample(law, 0, None, None, free) for law in SampledLaw))
    length = float(scene.check.length)
    samples = [sample_closed_loop(model, functional, law, radius, states).in_unit(length) for law in SampledLaw]
    return replace(feedback, samples=tuple(sorted(samples, key=_worst_rate)))


def _worst_rate(sample: LoopSample) -> float:
    """The rate by which laws are ordered; one without any comes last."""
    return math.inf if sample.worst_rate is None else sample.worst_rate
