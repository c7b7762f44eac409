"""Do the things that are printed about one array contradict each other?  Then nobody may rely on either of them.

A verdict is proved, and what stands beside it is found in another way: by sampled paths, by the field in floats, by
another contact rule, under tolerances.  Each function here compares one pair of statements and yields what cannot both
be true, with both sides as a sentence; the clauses concerned become undecided (:func:`reconciled`).  That such a pair
is found is a fault of the program, or a limit of its rounding: the comparison is the net behind the proofs.  It proves
nothing, and only takes verdicts away; no verdict rests on the accuracies below.

Two statements that differ need not contradict each other.  A body that is still on its way ends nowhere; a sampled end
within :data:`AT_POINT` of the point is the point; instability speaks of starts as near as one likes, so only paths
from there, along every border of cells, speak against it; "stays near" may be "comes home" that nobody proved.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple, Self, SupportsFloat, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.proofs.answers.answer import Answer, Heading, Pose, Position
from nonsmooth.proofs.answers.answers import Answers, answers_of
from nonsmooth.proofs.findings import Contradiction, Equilibrium, Rotation, Theorem4, Translation
from nonsmooth.proofs.own_paths import CLOSE, CLOSER, FAR, paths_from, starts_around, starts_on_borders
from nonsmooth.proofs.theorem4 import CellCheck, Check
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import float_text, place_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, in_floats, squared_distance
from nonsmooth.symbolic.numbers.plane_arrays import (
    finite_rows,
    max_norm,
    norm,
    norms,
    point_velocities,
    unit_vectors,
    with_neighbours,
)

if TYPE_CHECKING:
    from nonsmooth.analysis.fields.constant_field import ConstantField
    from nonsmooth.proofs.answers.destinations import Destination, SampledEnds
    from nonsmooth.proofs.system_decision import StabilityResult
    from nonsmooth.symbolic.numbers.plane_arrays import Floats

AT_POINT = 2.0**-30  # of the half side: an end so near the point is the point, to every digit that is printed
ELSEWHERE = 2.0**-20  # of the half side: an end that far away is another place
WELL_INSIDE = 0.95  # of a radius: starts so far inside a disc are in it, whatever is rounded
NEAR = 1 / 4  # of the half side: sampled starts that are near the point
RING = 8  # starts in a certified disc, where no others are sampled
SOMEWHAT = 2.0**-10  # of the half side: what is away for paths that begin close to the point
STEP = 2.0**-10  # of the half side: over which the field beside the point is differentiated
STILL = 2.0**-13  # of the speed of the rims: a minimizer that moves faster does not rest, whatever floats leave of rest
ROUNDING = 2.0**-27  # of that speed: what is left of it where the minimizer is smooth
CLEARLY = 2.0**-6  # of the largest entry of a derivative: by as much must its eigenvalues be off zero
SMOOTH = 2.0**-7  # of that entry: by as much may one-sided derivatives differ

PLACE = ("equilibrium", "translation", "rotation")  # the clauses that rest on what happens at the point
MOTION = ("translation", "rotation")  # on where bodies beside it go
TURN = ("rotation",)

GOES_AWAY = (Position.LEAVES, Position.UNSTABLE)
STAYS_OR_RESTS = (Position.COMES_HOME, Position.STAYS_NEAR)


@dataclass(frozen=True)
class PrintedAnswers:
    """What is printed about one array.

    Attributes:
        check: the verdicts.
        answers: position, heading and pose by name.
        answered: what stands beside them; parts that nobody asked for are empty.
        sampled: how sampled starts end; None where none are, or not yet.
    """

    check: Check
    answers: Mapping[str, Answer]
    answered: Answers
    sampled: SampledEnds | None = None

    @classmethod
    def of(cls, check: Check, answered: Answers) -> Self:
        """A check and what stands beside it; nothing is sampled yet."""
        return cls(check, {answer.name: answer for answer in answered.answers}, answered)

    @property
    def scene(self) -> Scene:
        """The array."""
        return self.check.scene

    @property
    def radius(self) -> float:
        """The half side of the checked square."""
        return self.scene.check.half_width

    @property
    def equilibrium(self) -> Equilibrium:
        """The verdict on the point."""
        return self.check.equilibrium.verdict

    def position(self, *verdicts: Position) -> bool:
        """Whether the position's answer is one of these."""
        return self.answers["position"].verdict in verdicts

    def said(self, name: str) -> str:
        """An answer in one sentence: ``position comes home: from anywhere within 1/2``."""
        answer = self.answers[name]
        return f"{answer.name} {answer.verdict}: {answer.sentence}"

    def number(self, name: str, key: str) -> float | None:
        """A number of an answer; None where it has none."""
        return _float(self.answers[name].numbers.get(key))


Pair: TypeAlias = Callable[[PrintedAnswers], Iterator[Contradiction]]


def reconciled(check: Check, answered: Answers | None = None, *more: Contradiction) -> tuple[Check, Answers]:
    """The check and its answers without what contradicts something else that is printed.

    Args:
        check: the verdicts; their evidence verifies.
        answered: what stands beside them, where that was asked.
        more: contradictions that were found in what is printed about several checks.
    """
    answered = Answers(answers_of(check), None, ()) if answered is None else answered
    printed = PrintedAnswers.of(check, answered)
    return without_contradictions(replace(printed, sampled=_sampled(printed)), *more)


def without_contradictions(printed: PrintedAnswers, *more: Contradiction) -> tuple[Check, Answers]:
    """What is left of what is printed, whose sampled starts were followed: see :func:`reconciled`."""
    check, answered = printed.check, printed.answered
    contradictions = (*(one for pair in PAIRS for one in pair(printed)), *more)
    if not contradictions:
        return check, answered
    left = check.contradicted(contradictions)
    return left, replace(answered, answers=answers_of(left), destinations=_without_verdict(check, answered))


def _sampled(printed: PrintedAnswers) -> SampledEnds | None:
    """How starts end: those of the destinations; under rules with cells, where there are none, a few."""
    if printed.answered.destinations is not None:
        return printed.answered.destinations.sampled
    starts = sample_of(printed)
    if starts is None:
        return None
    from nonsmooth.proofs.answers.destinations import ends_from

    (ends,) = ends_from([starts])
    return ends


def sample_of(printed: PrintedAnswers) -> tuple[ConstantField, Floats] | None:
    """A few starts in the field of all cells: on the rim of the certified disc and near the point; None where not all
    cells are there.
    """
    partition = printed.check.partition
    if partition is None or not partition.complete:
        return None
    from nonsmooth.analysis.fields.constant_field import array_field
    from nonsmooth.analysis.fields.kinematics import Kinematics

    radii = (printed.number("position", key) for key in ("within", "stays_within"))
    discs = [WELL_INSIDE * radius / printed.radius for radius in radii if radius]
    starts = np.vstack([starts_around(partition, disc, RING) for disc in (*discs[:1], NEAR)])
    return array_field(partition, Kinematics.EXACT), starts


def _without_verdict(check: Check, answered: Answers) -> Any:
    """The destinations without what is said to happen near the checked point."""
    goes = answered.destinations
    if goes is None:
        return None
    destinations = (replace(one, position=None, heading=None) if _is_point(check, one) else one for one in goes.found)
    return replace(goes, found=tuple(destinations))


# ---- one function for each pair ------------------------------------------------------------------


def position_and_ends(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """A point from which bodies are driven away, and sampled bodies that come to rest at it."""
    ends = printed.sampled
    if ends is None or printed.equilibrium is not Equilibrium.FAILS:
        return
    at_point = ends.stays & (ends.distances[1] <= AT_POINT * printed.radius)
    if at_point.any() and not _is_rounded(printed):
        seen = f"{at_point.sum()} of {len(at_point)} sampled starts come to rest at the point"
        yield Contradiction("position and destinations", (printed.said("position"), seen), PLACE)


def leaves_and_ends(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """An unstable point, and no sampled body near it that goes away, not even from much closer, along any border.

    Where motions tie, paths show one mixture of them, and another may leave: nothing is compared.
    """
    ends, check = printed.sampled, printed.check
    if ends is None or not isinstance(check, CellCheck) or not check.partition.complete:
        return
    if check.translation.verdict is not Translation.UNSTABLE or printed.equilibrium is not Equilibrium.HOLDS:
        return
    if any(len(cell.twists) > 1 for cell in check.partition.meeting):
        return
    begin, end = ends.distances
    near = begin <= NEAR * printed.radius
    if not near.any() or not (end[near] <= AT_POINT * printed.radius).all():
        return
    starts = [*starts_around(check.partition, CLOSER, RING), *starts_on_borders(check.partition)]
    paths = list(paths_from(check.partition, starts))
    if len(paths) == len(starts) and all(path.farthest < SOMEWHAT * printed.radius for path in paths):
        seen = f"all {near.sum()} sampled starts near the point, and {len(paths)} close to it, come to rest at it"
        said = f"translation {check.translation.verdict}: {check.translation.reason}"
        yield Contradiction("position and destinations", (said, seen), MOTION)


def discs_and_ends(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """A certified disc, and a sampled start in it that ends farther away than bodies from there are said to."""
    ends = printed.sampled
    if ends is None:
        return
    begin, end = ends.distances
    swing = printed.number("position", "swings_out_to") or 0.0
    discs = (
        ("within", (Position.COMES_HOME,), 0.0),
        ("within", (Position.COMES_NEAR,), printed.number("position", "ends_within")),
        ("stays_within", STAYS_OR_RESTS, begin),
    )
    for key, verdicts, most in discs:
        disc = printed.number("position", key)
        if disc is not None and most is not None and printed.position(*verdicts):
            out = ends.leaves & (max(disc, swing) <= printed.radius)  # who may swing out of the square comes back to it
            away = out | (end > most + ELSEWHERE * printed.radius)
            yield from _against(printed, (begin <= WELL_INSIDE * disc) & away, "position and destinations")


def position_and_paths(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """Stability that the fan of cones alone decides, and a path from very close by that goes far away."""
    check = printed.check
    if not isinstance(check, CellCheck) or not check.partition.complete or not printed.position(*STAYS_OR_RESTS):
        return
    if check.translation.fan is None or check.translation.region_radius is not None:
        return
    for path in paths_from(check.partition, starts_around(check.partition, CLOSE)):
        if path.farthest > FAR * printed.radius:
            seen = f"the path from {place_text(path.start, 3)} beside the point goes {path.farthest:.3g} away"
            yield Contradiction("position and a path", (printed.said("position"), seen), MOTION)
            return


def heading_and_ends(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """A body that does not turn at rest, and one that does; one that turns all the time, and one that does not."""
    ends, rotation = printed.sampled, printed.check.rotation
    if ends is None or not isinstance(printed.check, CellCheck):
        return
    begin, end = ends.distances
    rests = ends.stays & (end <= AT_POINT * printed.radius)
    heading = printed.answers["heading"].verdict
    if heading is Heading.KEEPS:
        seen = rests & np.isinf(ends.turning)
        yield from _against(printed, seen, "heading and destinations", "heading", "turns at the point for ever", TURN)
        bound, disc = rotation.rotation_per_distance, printed.check.translation.region_radius
        if bound is not None and disc is not None:
            most = float(bound) * begin * (1 + ELSEWHERE) + ELSEWHERE
            inside = rests & (begin <= WELL_INSIDE * float(disc)) & np.isfinite(ends.turning)
            seen = inside & (np.abs(ends.turning) > most)
            yield from _against(printed, seen, "heading and destinations", "heading", "turns more on its way", TURN)
    elif heading is Heading.DRIFTS and rotation.drift is not None:
        low, high = rotation.drift.interval
        always = low.sign() > 0 or high.sign() < 0
        seen = rests & np.isfinite(ends.turning) & always
        yield from _against(printed, seen, "heading and destinations", "heading", "stands still at the point", TURN)


def answers_and_rows(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """The answers, and what the list of destinations says of bodies near the checked point."""
    goes = printed.answered.destinations
    for row in () if goes is None else goes.found:
        if not _is_point(printed.check, row):
            continue
        said = f'in the list of destinations bodies near the point: "{row.position}", heading: "{row.heading}"'
        yield from _against_row(printed, "destinations", said, row.position, row.heading)


def answers_and_headings(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """The answers at the checked heading, and the proved list of headings at which a body with an outline rests."""
    listed = printed.answered.headings
    for entry in () if listed is None else listed.found:
        if not entry.proved or not _is_place(printed.check, entry.at) or entry.low is None or entry.high is None:
            continue
        if not (entry.is_every_heading or float(entry.low) < 0 < float(entry.high)):
            continue
        said = f'in the list of headings, at the checked one: "{entry.position}", heading: "{entry.verdict}"'
        rests = printed.equilibrium is not Equilibrium.FAILS or _is_rounded(printed)
        yield from _against_row(printed, "headings of rest", said, entry.position, entry.verdict, rests=rests)


def answers_and_theorem(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """Theorem 4 says that the position is stable and the heading is not, of a point that is an equilibrium."""
    if printed.check.verdict is not Theorem4.HOLDS:
        return
    said = f"Theorem 4 holds: {printed.check.reason}"
    position, heading, pose = (printed.answers[name].verdict for name in ("position", "heading", "pose"))
    if position not in (*STAYS_OR_RESTS, Position.COMES_NEAR):
        yield Contradiction("position and Theorem 4", (printed.said("position"), said), PLACE)
    if heading is not Heading.DRIFTS:
        yield Contradiction("heading and Theorem 4", (printed.said("heading"), said), TURN)
    if pose is Pose.CANNOT_BE_HELD:
        yield Contradiction("pose and Theorem 4", (printed.said("pose"), said), PLACE)


def tolerances_and_ends(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """Where every array within the tolerances brings bodies, and where this one, which is among them, takes one."""
    robust, ends = printed.answered.robust, printed.sampled
    if robust is None or ends is None:
        return
    radius, start, rests = (_float(robust.numbers.get(key)) for key in ("radius", "from", "at_rest_within"))
    said, (begin, end) = f"tolerances {robust.verdict}: {robust.sentence}", ends.distances
    if radius is not None and start is not None:
        away = ends.leaves | (end > radius + ELSEWHERE * printed.radius)
        yield from _against(printed, (begin <= WELL_INSIDE * start) & away, "tolerances and destinations", said)
    if rests:
        moved = ends.leaves | (norms(ends.ends - ends.starts) > ELSEWHERE * printed.radius)
        yield from _against(printed, (begin <= WELL_INSIDE * rests) & moved, "tolerances and destinations", said)


class RuleAtPoint(NamedTuple):
    """What one contact rule says of the point.

    Attributes:
        equilibrium: whether it is one.
        position, heading: the answers.
    """

    equilibrium: str
    position: str
    heading: str

    @classmethod
    def of(cls, equilibrium: str, answers: Iterable[Answer]) -> Self:
        """From the clause on the equilibrium and the first two answers."""
        position, heading, *_ = (str(answer.verdict) for answer in answers)
        return cls(str(equilibrium), position, heading)

    @property
    def at_rest(self) -> bool:
        """Whether a body rests there without turning: zero minimizes D."""
        return self.equilibrium == Equilibrium.HOLDS and self.heading == Heading.KEEPS


def rules_and_rest(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """Rest at the point under this rule, and under the others that were asked."""
    asked = {printed.scene.contact.rule: RuleAtPoint.of(printed.equilibrium, printed.answered.answers)}
    for other in printed.answered.others:
        if other.answers and other.equilibrium is not None:
            asked[other.name] = RuleAtPoint.of(other.equilibrium, other.answers)
    yield from contradictions_of_rules(printed.scene, asked)


def contradictions_of_rules(scene: Scene, asked: Mapping[str, RuleAtPoint]) -> Iterator[Contradiction]:
    """What contact rules say that minimize D, each with its own friction sets and with the same loads.

    At rest the wheels slip along their friction axes, ``(-u_i, 0)``, or not at all (else nothing is compared), and
    rest is a balance of forces in the faces of the friction sets in these directions.  With ``mu_S <= mu_R`` the face
    of `ellipse` lies in that of `roller`, and with ``mu_S >= mu_R`` the other way round, and both lie in that of
    `box`: what rests under the smaller set rests under the larger one.  Where ``mu_S = mu_R``, `roller` is `ellipse`.
    """
    frictions = [wheel.friction for wheel in scene.wheels]
    below = all(friction.side <= friction.roll for friction in frictions)
    above = all(friction.side >= friction.roll for friction in frictions)
    smaller = [("ellipse", "box"), ("roller", "box")]
    smaller += [("ellipse", "roller")] if below else []
    smaller += [("roller", "ellipse")] if above else []
    if any(wheel.scaled_side_speed for wheel in scene.wheels):
        smaller = []
    for small, large in smaller:
        if small in asked and large in asked and asked[small].at_rest and asked[large].equilibrium == Equilibrium.FAILS:
            sides = (
                f"under rule {small} the body rests at the point: {_in_words(asked[small])}",
                f"under rule {large}, whose wheels hold all that those of {small} hold, it does not: "
                f"{_in_words(asked[large])}",
            )
            yield Contradiction(f"the rules {small} and {large}", sides, PLACE)
    if below and above and {"ellipse", "roller"} <= set(asked):
        one, two = asked["ellipse"], asked["roller"]
        if _opposite(one.position, two.position) or _turn_apart(one.heading, two.heading):
            sides = (f"under rule ellipse {_in_words(one)}", f"under rule roller, here the same, {_in_words(two)}")
            yield Contradiction("the rules ellipse and roller", sides, PLACE)


def _in_words(rests: RuleAtPoint) -> str:
    return f"position {rests.position}, heading {rests.heading}"


def verdict_and_field(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """The verdicts at the point, and the field beside it by the numerical minimizer, under rules without cells."""
    beside = _field_beside(printed.scene) if printed.equilibrium is not Equilibrium.UNDECIDED else None
    if beside is None:
        return
    position = printed.said("position")
    if printed.equilibrium is Equilibrium.FAILS:
        if beside.offset is not None and beside.offset <= AT_POINT * printed.radius:
            seen = "the numerical minimizer of D rests at the point itself, to every digit"
            yield Contradiction("position and the field beside the point", (position, seen), PLACE)
        return
    if beside.speed > STILL:
        seen = f"the numerical minimizer of D moves there, at {float_text(beside.speed, 3)} of the speed of the rims"
        yield Contradiction("position and the field beside the point", (position, seen), PLACE)
        return
    grows = beside.growth
    away = grows is not None and grows > CLEARLY and printed.position(*STAYS_OR_RESTS)
    back = grows is not None and grows < -CLEARLY and printed.position(Position.LEAVES)
    if away or back:
        seen = f"bodies beside the point {'move away from' if away else 'approach'} it, by the sampled field"
        yield Contradiction("position and the field beside the point", (position, seen), MOTION)
    if printed.answers["heading"].verdict is Heading.KEEPS and abs(beside.spin) > STILL:
        seen = "the numerical minimizer of D turns at the point"
        yield Contradiction("heading and the field beside the point", (printed.said("heading"), seen), TURN)


def disc_and_samples(printed: PrintedAnswers) -> Iterator[Contradiction]:
    """A disc in which the distance falls, and a sampled point in it at which it grows."""
    translation = printed.check.translation
    sampled, disc = translation.sampled, translation.region_radius
    if sampled is None or disc is None or sampled.at is None or not printed.position(*STAYS_OR_RESTS):
        return
    x, y = sampled.at
    if (sampled.largest_relative or 0.0) > ELSEWHERE and x * x + y * y <= (WELL_INSIDE * float(disc)) ** 2:
        seen = f"at the sampled point {place_text(sampled.at, 4)} from it V* is positive"
        yield Contradiction("position and the samples of V*", (printed.said("position"), seen), MOTION)


PAIRS: tuple[Pair, ...] = (
    position_and_ends,
    leaves_and_ends,
    discs_and_ends,
    position_and_paths,
    heading_and_ends,
    answers_and_rows,
    answers_and_headings,
    answers_and_theorem,
    tolerances_and_ends,
    rules_and_rest,
    verdict_and_field,
    disc_and_samples,
)


OPPOSITES: tuple[tuple[set[str], set[str]], ...] = (  # words of one clause that cannot both be true of one array
    ({Equilibrium.HOLDS, Theorem4.HOLDS}, {Equilibrium.FAILS, Theorem4.FAILS, Theorem4.HYPOTHESES_NOT_MET}),
    ({Translation.UNSTABLE, Rotation.UNSTABLE}, {Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE}),
    ({Rotation.UNSTABLE}, {Rotation.NEUTRAL}),
)


def contradictions_of_certificate(certificate: Mapping[str, Any], check: Check) -> Iterator[Contradiction]:
    """What a certificate states, and what is printed; a certificate may say less."""
    from nonsmooth.proofs.certificate import stated_words

    results = {clause.name: result for clause, result in check.clauses}
    for name, verdict in stated_words(certificate).items():
        printed = results.get(name, check)
        for one, two in OPPOSITES:
            if (verdict in one and printed.verdict in two) or (verdict in two and printed.verdict in one):
                sides = (f"{name} {printed.verdict}: {printed.reason}", f"the certificate states {name} {verdict}")
                yield Contradiction(f"{name} and the certificate", sides, (name,) if name in results else PLACE)


# ---- plain systems: a map of starts beside the verdict -------------------------------------------


@dataclass(frozen=True, eq=False)
class FollowedStarts:
    """Where solutions of a plain system in two states are at one time, measured from the checked point.

    Attributes:
        starts: (m, 2).
        ends: (m, 2), likewise; not a number where one could not be followed.
        until: the time.
        half: the half side of the checked square.
        follow: the ends of solutions from other starts; None where solutions may branch off that are not drawn.
    """

    starts: Floats
    ends: Floats
    until: float
    half: float
    follow: Callable[[Floats], Floats] | None


def contradictions_of_map(result: StabilityResult, seen: FollowedStarts) -> Iterator[Contradiction]:
    """What is proved of a plain system, and where sampled starts have come to."""
    yield from region_and_starts(result, seen)
    yield from unstable_and_starts(result, seen)


def region_and_starts(result: StabilityResult, seen: FollowedStarts) -> Iterator[Contradiction]:
    """A level set from which V falls, at a proved rate where there is one, and a start in it whose V does not."""
    from nonsmooth.analysis.fields.stated_field import potential_values

    function, reach, rate = result.function, result.reach, result.reach.rate
    region = next(
        (sublevel for sublevel in (reach.region, reach.near) if sublevel is not None and sublevel.falls), None
    )
    if function is None or region is None:
        return
    level = float(region.level)
    before, after = (potential_values(function.result.cells, places) for places in (seen.starts, seen.ends))
    is_below = before < level
    begin = np.where(is_below, before, 0)
    bound = begin if rate is None else rate.decay.after(begin, float(rate.kappa) * seen.until)
    high = ~np.isfinite(after) | (after > bound * (1 + ELSEWHERE) + ELSEWHERE * level)
    grown = is_below & finite_rows(seen.ends) & high
    for k in np.flatnonzero(grown)[:1]:
        fast = "" if rate is None else f", {rate}"
        said = f"{result.verdict}: every start with {region} reaches the point{fast}"
        start, end = place_text(seen.starts[k]), place_text(seen.ends[k])
        above = f"V is {after[k]:.4g} there, above {bound[k]:.4g}"
        yield Contradiction(
            "region and map", (said, f"the path from {start} is at {end} at t = {seen.until:g}: {above}"), ()
        )


def unstable_and_starts(result: StabilityResult, seen: FollowedStarts) -> Iterator[Contradiction]:
    """An unstable point, and no start that does not arrive, neither of the map nor from much closer."""
    if result.verdict is not Translation.UNSTABLE or seen.follow is None:
        return
    at_point = norms(seen.ends) <= AT_POINT * seen.half
    if not at_point.all():
        return
    angles = 2 * np.pi * (np.arange(RING) + 0.3) / RING
    near = CLOSER * seen.half * unit_vectors(angles)
    if (norms(seen.follow(near)) < CLOSER * seen.half / 2).all():
        arrived = f"all {len(at_point)} sampled starts, and {RING} close to it, come to the point"
        yield Contradiction("stability and map", (f"{result.verdict}: {result.reason}", arrived), ())


# ---- what they share -----------------------------------------------------------------------------


def _against(
    printed: PrintedAnswers,
    seen: Any,
    between: str,
    said: str = "position",
    what: str = "",
    clauses: tuple[str, ...] = MOTION,
) -> Iterator[Contradiction]:
    """The first of the starts that contradict a statement, with the number of the others.

    Args:
        printed: what is printed.
        seen: whether a start contradicts, (m,).
        between: what is compared.
        said: the name of an answer, or the statement.
        what: becomes of the body; empty for the place where it ends.
        clauses: that it concerns.
    """
    if not seen.any() or printed.sampled is None:
        return
    k = int(seen.argmax())
    start, end = place_text(printed.sampled.starts[k], 4), printed.sampled.ends[k]
    where = "leaves the square, or tips" if printed.sampled.leaves[k] else f"ends at {place_text(end, 4)} from it"
    more = f", as {seen.sum() - 1} others of {len(seen)} starts do" if seen.sum() > 1 else ""
    sentence = f"the sampled body that starts at {start} from the point {what or where}{more}"
    statement = printed.said(said) if said in printed.answers else said
    yield Contradiction(between, (statement, sentence), clauses)


def _against_row(
    printed: PrintedAnswers, listed: str, said: str, position: object, heading: object, *, rests: bool = True
) -> Iterator[Contradiction]:
    """The answers, and a row of a list about the point; ``rests``: whether the point may be a place of rest."""
    if not rests or _opposite(printed.answers["position"].verdict, position):
        yield Contradiction(f"position and {listed}", (printed.said("position"), said), PLACE)
    if _turn_apart(printed.answers["heading"].verdict, heading):
        yield Contradiction(f"heading and {listed}", (printed.said("heading"), said), TURN)


def _is_point(check: Check, row: Destination) -> bool:
    """Whether a destination is the checked point alone."""
    return len(row.points) == 1 and _is_place(check, row.points[0])


def _is_place(check: Check, place: Iterable[SupportsFloat]) -> bool:
    """Whether a place in the coordinates of the scene is the checked point."""
    within = AT_POINT * check.scene.check.half_width
    pairs = zip(place, check.scene.check.equilibrium, strict=True)
    return all(abs(float(one) - float(two)) <= within for one, two in pairs)


def _is_rounded(printed: PrintedAnswers) -> bool:
    """Whether the checked point is not on a border of cells, and so near to one that no path tells.

    So it is where it is a place of rest that was rounded to a float: bodies rest beside it, on that border.
    """
    partition, within = printed.check.partition, AT_POINT * printed.radius
    sides = [side for cell in (() if partition is None else partition.cells) for side in around(cell.polygon.vertices)]
    near = (side for side in sides if squared_distance(*map(in_floats, side)) <= within * within)
    return any(bool(cross(p, q)) or dot(p, q).sign() > 0 for p, q in near)


def _opposite(one: object, two: object) -> bool:
    """Whether one says that bodies leave and the other that they do not."""
    return (one in GOES_AWAY and two in STAYS_OR_RESTS) or (two in GOES_AWAY and one in STAYS_OR_RESTS)


def _turn_apart(one: object, two: object) -> bool:
    """Whether one says that the heading keeps and the other that it drifts."""
    return {one, two} == {Heading.KEEPS, Heading.DRIFTS}


def _float(value: Any) -> float | None:
    return float(value) if isinstance(value, Number | Lazy | Fraction | float | int) else None


class _Beside(NamedTuple):
    """The field at a point and beside it.

    Attributes:
        speed: at the point, in parts of the largest speed of the rims.
        spin: rate of rotation there, times the size of the array, likewise.
        offset: how far from the point the field vanishes, by one step of Newton's method; None where it has kinks.
        growth: the largest real part of an eigenvalue of its derivative, in parts of its largest entry; None where the
            field has kinks, or hardly changes.
    """

    speed: float
    spin: float
    offset: float | None
    growth: float | None


def _field_beside(scene: Scene) -> _Beside | None:
    """By the minimizers at the point and at four points beside it; None where they are not unique, or not proved."""
    rule = rule_of(scene)
    if not isinstance(rule, SmoothRule) or scene.contact.loads_are_unknown:
        return None
    from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under

    centred, step = scene.recentred(), STEP * scene.check.half_width
    points = with_neighbours(step)
    minima = minima_under(rule, centred, points)
    rims = centred.fastest
    if minima.faces or not minima.check().all() or not rims:
        return None
    size = max(abs(float(entry)) for wheel in centred.wheels for entry in wheel.position)
    here, east, west, north, south = point_velocities(minima.twists, points)
    speed, spin = norm(here) / rims, float(minima.twists[0, 2]) * size / rims
    slope = np.stack([east - west, north - south], axis=1) / (2 * step)
    bend = np.stack([east + west - 2 * here, north + south - 2 * here], axis=1) / step
    return _Beside(speed, spin, *_offset_and_growth(here, slope, bend, ROUNDING * rims / step))


def _offset_and_growth(here: Floats, slope: Floats, bend: Floats, rounding: float) -> tuple[float | None, float | None]:
    """Of a field from its value, its derivative, and by how much one-sided derivatives differ."""
    largest = max_norm(slope)
    if largest <= rounding or max_norm(bend) > SMOOTH * largest:
        return None, None
    growth = float(np.linalg.eigvals(slope).real.max()) / largest
    if abs(float(np.linalg.det(slope))) < CLEARLY * CLEARLY * largest**2:
        return None, growth
    return norm(np.linalg.solve(slope, here)), growth


def rests_under(check: Check) -> RuleAtPoint:
    """What a check says of the point."""
    return RuleAtPoint.of(check.equilibrium.verdict, answers_of(check))
