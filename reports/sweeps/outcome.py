"""What is kept of one scene of a sweep: a flat record of answers, verdicts and rates, which a store holds as JSON."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from typing import Any, TypeAlias, TypeVar

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.proofs.answers.answer import Answer, Heading, Pose, Position
from nonsmooth.proofs.answers.answers import TOLERANCES, Answers, answers_of, robust_answer
from nonsmooth.proofs.answers.contradictions import PrintedAnswers, sample_of, without_contradictions
from nonsmooth.proofs.answers.destinations import SampledEnds, ends_from
from nonsmooth.proofs.answers.failures import failures_of
from nonsmooth.proofs.findings import Quantity, Record, Theorem4
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.domain import DecayKind
from nonsmooth.proofs.theorem4 import CellCheck, Check, check_theorem4
from nonsmooth.reports.checks.answers import failure_records
from nonsmooth.reports.output.facts import exact_texts, floats
from nonsmooth.reports.output.refusals import beyond_floats_named
from nonsmooth.reports.sweeps.base import Base
from nonsmooth.reports.sweeps.sweep_plan import Entry
from nonsmooth.symbolic.files.key_paths import Path
from nonsmooth.symbolic.mechanics.contact_set import TipsError
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Outcome: TypeAlias = Mapping[str, Any]
Kept = TypeVar("Kept")

# ---- what a record holds -------------------------------------------------------------------------


REFUSED = "refused"  # the answer of a scene that cannot be checked; why stands beside it

# Of an array: the answers, the verdicts of its clauses, and its numbers with the answer or clause, and the key of the
# fact, from which each comes.
QUESTIONS = ("position", "heading", "pose", "theorem4")
CLAUSES = ("equilibrium", "translation", "rotation", "feedback")
NUMBERS = {
    "accuracy": ("position", "accuracy"),
    "ends_within": ("position", "ends_within"),
    "within": ("position", "within"),
    "after": ("position", "after"),
    "rate": ("position", "rate"),
    "seconds_per_distance": ("position", "seconds_per_distance"),
    "stays_within": ("position", "stays_within"),
    "largest_rate": ("heading", "largest_rate"),
    "turn_per_distance": ("heading", "turn_per_distance"),
    "kappa": ("pose", "rate"),
    "worst_rate": ("translation", "worst_rate"),
    "tolerance_radius": (TOLERANCES, "radius"),
    "tolerance_factor": (TOLERANCES, "factor"),
}

# Of a plain system: its answer, texts, and numbers.  These are kappa of `V' <= -kappa V` and of `V' <= -kappa`, in the
# square of half-width `rate_within` (null: everywhere); every start with `V < level` in the square of half-width
# `within` arrives; in one state every start between `from` and `to` does.
SYSTEM_QUESTIONS = ("stability",)
SYSTEM_NUMBERS = ("rate", "fall", "rate_within", "level", "within", "from", "to")
RATES = {DecayKind.EXPONENTIAL: "rate", DecayKind.FINITE: "fall"}
SYSTEM_TEXTS = ("method", "V")
SYSTEM_COLUMNS = (*SYSTEM_QUESTIONS, *SYSTEM_TEXTS, *SYSTEM_NUMBERS)


def _record(position: str, heading: str, pose: str, theorem4: str, why: str | None) -> Record:
    """A record without clauses and numbers."""
    answers = dict(zip(QUESTIONS, map(str, (position, heading, pose, theorem4)), strict=True))
    return {**answers, **dict.fromkeys(CLAUSES), **dict.fromkeys(NUMBERS), "exact": {}, "why": why}


def _system_record(stability: str, why: str | None) -> Record:
    """A record without texts and numbers."""
    return {**dict.fromkeys(SYSTEM_COLUMNS), SYSTEM_QUESTIONS[0]: stability, "exact": {}, "why": why}


def _with_numbers(record: Outcome, numbers: Mapping[str, Any]) -> Outcome:
    """A record with its numbers as floats, and the texts of those that are exact."""
    exact = {name: exact_texts(value) for name, value in numbers.items()}
    texts = {name: text for name, text in exact.items() if text is not None}
    return {**record, **{name: floats(value) for name, value in numbers.items()}, "exact": texts}


def refused(why: str, *, is_system: bool = False) -> Outcome:
    """A scene without answers."""
    if is_system:
        return _system_record(REFUSED, one_line(why))
    return _record(REFUSED, REFUSED, REFUSED, REFUSED, one_line(why))


def questions_of(outcome: Outcome) -> tuple[str, ...]:
    """The questions that an outcome answers: those of an array, or that of a plain system."""
    return SYSTEM_QUESTIONS if SYSTEM_QUESTIONS[0] in outcome else QUESTIONS


def without_file(error: SceneError) -> str:
    """What is wrong, without the name of the file, which is that of the whole sweep."""
    return f"{error.key}: {str(error).partition(f'{error.key}: ')[2]}" if error.key else str(error)


# ---- arrays --------------------------------------------------------------------------------------


COEFFICIENTS = ("mu_roll", "mu_side")  # of friction, as key paths end
KEPT = 5_000  # outcomes of earlier scenes: as many as those of a long axis under each order of friction


def outcomes_of(
    base: Base,
    paths: Sequence[Path],
    scenes: Iterable[Sequence[Entry]],
    *,
    failures: bool = False,
    earlier: dict[Hashable, Outcome] | None = None,
) -> list[Outcome]:
    """Check scenes of a sweep one after the other, and follow the paths by which they are compared all together.

    Scenes whose answers follow from the same (:func:`_follows_from`) are checked once.

    Args:
        base: the scene before anything varies.
        paths: the numbers that vary.
        scenes: their values in each scene.
        failures: also ask what happens when any one wheel fails.
        earlier: the outcomes of the last scenes of this sweep by what they follow from, to which those of these scenes
            are added.
    """
    earlier = {} if earlier is None else earlier
    known: dict[Hashable, _Decided] = {}  # until the end of the job
    begun = [_begun(base, paths, entries, known, earlier, failures=failures) for entries in scenes]
    decided = list(dict.fromkeys(one for one in begun if isinstance(one, _Decided)))
    samples = [one.sample for one in decided if one.sample is not None]
    ends = iter(ends_from(samples) if samples else ())
    ended = {one: _ended(one, ends) for one in decided}
    earlier.update((source, ended[one]) for source, one in known.items())
    for source in list(islice(earlier, max(len(earlier) - KEPT, 0))):
        del earlier[source]
    return [ended[one] if isinstance(one, _Decided) else one for one in begun]


@dataclass(frozen=True, eq=False)
class _Decided:
    """An array whose verdicts are decided, and not yet compared with paths.

    Attributes:
        printed: the verdicts and answers.
        robust: the answer within tolerances, where there are any.
        sample: the starts of the paths; None where none are followed.
        failures: what happens when any one wheel fails, where that is asked.
    """

    printed: PrintedAnswers
    robust: Answer | None
    sample: tuple[ConstantField, Floats] | None
    failures: list[Record] | None

    def outcome(self, ends: SampledEnds | None) -> Outcome:
        """What is kept, with the ends of the paths."""
        check, answered = without_contradictions(replace(self.printed, sampled=ends))
        found = _kept(check, answered, self.robust)
        return found if self.failures is None else {**found, "failures": self.failures}


def _begun(
    base: Base,
    paths: Sequence[Path],
    entries: Sequence[Entry],
    known: dict[Hashable, _Decided],
    earlier: Mapping[Hashable, Outcome],
    *,
    failures: bool,
) -> _Decided | Outcome:
    """One scene, decided or refused; or what is known of one whose answers follow from the same."""
    if base.is_system:
        return system_outcome(base, paths, entries)

    def decided() -> _Decided | Outcome:
        scene = base.scene(paths, entries)
        with beyond_floats_named(scene) as is_beyond:
            if is_beyond:  # done with at once: only there errors of arithmetic have that reason
                found = _decided(scene, failures=failures)
                return _ended(found, iter(ends_from([found.sample]) if found.sample else ()))
            source = _follows_from(scene, paths, entries)
            if source in earlier:
                return earlier[source]
            if source not in known:
                last = known[next(reversed(known))].printed.check.partition if known else None
                known[source] = _decided(scene, failures=failures, built=last)
            return known[source]

    return _unless_refused(decided)


def _follows_from(scene: Scene, paths: Sequence[Path], entries: Sequence[Entry]) -> Hashable:
    """What tells the answers of a scene from those of the others of its sweep.

    These are the values that vary; but of friction, which nobody knows well and many sweeps vary, only what the contact
    rule sees, where that is less.  Tolerances are of the friction itself.
    """
    if scene.tolerances is not None or not rule_of(scene).sees_order_of_friction:
        return tuple(entries)
    others = tuple(entry for path, entry in zip(paths, entries, strict=True) if path[-1] not in COEFFICIENTS)
    frictions = [wheel.friction for wheel in (*scene.wheels, *scene.idle)]
    return others, tuple(
        (bool(friction.roll), bool(friction.side), sign(friction.side - friction.roll)) for friction in frictions
    )


def _decided(scene: Scene, *, failures: bool, built: Partition | None = None) -> _Decided:
    """The verdicts and answers of one scene, not yet compared with paths; the cells ``built`` last may be alike."""
    check = check_theorem4(scene, beside=False, built=built)
    robust = robust_answer(check.scene, check.results)
    printed = PrintedAnswers.of(check, Answers(answers_of(check), None, (), robust))
    further = failure_records(failures_of(scene)) if failures else None
    return _Decided(printed, robust, sample_of(printed), further)


def _ended(decided: _Decided, ends: Iterator[SampledEnds | None]) -> Outcome:
    """The outcome of a scene, whose paths end as the next ones do."""
    ends_of_paths = None if decided.sample is None else next(ends)
    return _unless_refused(lambda: decided.outcome(ends_of_paths))


def _unless_refused(step: Callable[[], Kept]) -> Kept | Outcome:
    """What a step finds, or why the scene is refused."""
    try:
        return step()
    except TipsError as tipping:
        why = f"a body with {tipping.why}"
        return _record(Position.TIPS, Heading.UNDECIDED, Pose.UNDECIDED, Theorem4.HYPOTHESES_NOT_MET, why)
    except SceneError as error:
        return refused(without_file(error))
    except RefusalError as error:
        return refused(str(error))


def _kept(check: Check, answered: Answers, robust: Answer | None) -> Outcome:
    """The verdicts and numbers of an array; those within tolerances only where nothing contradicts the others."""
    answers = {answer.name: answer for answer in answered.answers}
    contradicted = "; ".join(one.text for one in check.contradictions) or None
    if robust is not None and contradicted is None:
        answers[TOLERANCES] = robust
    position, heading, pose = (str(answers[name].verdict) for name in QUESTIONS[:3])
    verdicts = {name: str(check.results[name].verdict) for name in CLAUSES}
    record = {**_record(position, heading, pose, check.verdict, contradicted), **verdicts}
    return _with_numbers(record, {name: _number(check, answers, *place) for name, place in NUMBERS.items()})


def _number(check: Check, answers: Mapping[str, Answer], place: str, key: str) -> Any:
    """One number of an answer or a clause; None where it has none, and where it would be sampled."""
    if place == "translation" and not isinstance(check, CellCheck):
        return None
    if (place, key) == NUMBERS["kappa"]:  # its fact comes with words about the law and its region, which take longer
        return check.feedback.holding.certified_kappa
    clauses = (clause for clause, _ in check.clauses if clause.name == place)
    facts = answers[place].facts if place in answers else (fact for clause in clauses for fact in check.facts(clause))
    value = next((fact.value for fact in facts if fact.key == key), None)
    return value.value if isinstance(value, Quantity) else value


# ---- plain systems -------------------------------------------------------------------------------


def system_outcome(base: Base, paths: Sequence[Path], entries: Sequence[Entry]) -> Outcome:
    """Check one plain system of a sweep."""
    try:
        result = decide_system(base.system(paths, entries))
    except SceneError as error:
        return refused(without_file(error), is_system=True)
    function = result.function
    texts = {"method": str(result.method), "V": None if function is None else function.text}
    return _with_numbers({**_system_record(str(result.verdict), None), **texts}, _numbers(result))


def _numbers(result: StabilityResult) -> Record:
    found: Record = {}
    reach = result.reach
    if reach.rate is not None and reach.rate.decay in RATES:
        found[RATES[reach.rate.decay]] = reach.rate.kappa
        found["rate_within"] = reach.rate.domain.radius
    if reach.region is not None:
        found |= {"level": reach.region.level, "within": reach.region.radius}
    intervals = (fact.value for fact in result.deciding.facts if fact.key == "region" and fact.value)
    for interval in intervals:  # of starts, in one state
        found |= {key: interval[key].value for key in ("from", "to")}
    return found
