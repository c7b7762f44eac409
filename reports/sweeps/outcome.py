"""What is kept of one scene of a sweep: a flat record of answers, verdicts and rates, which a store holds as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.answers.answer import Answer, Heading, Pose, Position
from nonsmooth.proofs.answers.answers import Answers, answers_of
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.answers.failures import failures_of
from nonsmooth.proofs.answers.robust import TOLERANCES, robust_answer
from nonsmooth.proofs.findings.verdicts import Fact, Quantity, Theorem4
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.reports.checks.records import failure_records
from nonsmooth.reports.output.facts import exact_texts, floats
from nonsmooth.reports.sweeps.base import Base
from nonsmooth.reports.sweeps.values import Entry
from nonsmooth.symbolic.files.key_paths import Path
from nonsmooth.symbolic.mechanics.contact_set import TipsError
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line

if TYPE_CHECKING:
    from nonsmooth.reports.sweeps.base import Base

Outcome: TypeAlias = Mapping[str, Any]

QUESTIONS = ("position", "heading", "pose", "theorem4")
CLAUSES = ("equilibrium", "translation", "rotation", "feedback")

# Numbers of a record, and where they come from: the answer or clause, and the key of its fact.
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


def outcome_of(base: Base, paths: Sequence[Path], entries: Sequence[Entry], *, failures: bool = False) -> Outcome:
    """Check one scene of a sweep.

    Args:
        base: the scene before anything varies.
        paths: the numbers that vary.
        entries: their values.
        failures: also ask what happens when any one wheel fails.
    """
    if base.is_system:
        return system_outcome(base, paths, entries)
    try:
        scene = base.scene(paths, entries)
        found = _checked(scene)
        return {**found, "failures": failure_records(failures_of(scene))} if failures else found
    except TipsError as tipping:
        why = f"a body with {tipping.why}"
        return _record(Position.TIPS, Heading.UNDECIDED, Pose.UNDECIDED, Theorem4.HYPOTHESES_NOT_MET, why)
    except SceneError as error:
        return refused(without_file(error))
    except RefusalError as error:
        return refused(str(error))


def refused(why: str, *, is_system: bool = False) -> Outcome:
    """A scene without answers."""
    if is_system:
        return refused_system(why)
    return _record(REFUSED, REFUSED, REFUSED, REFUSED, one_line(why))


def questions_of(outcome: Outcome) -> tuple[str, ...]:
    """The questions that an outcome answers: those of an array, or that of a plain system."""
    return SYSTEM_QUESTIONS if SYSTEM_QUESTIONS[0] in outcome else QUESTIONS


def _checked(scene: Scene) -> Outcome:
    decided = check_theorem4(scene, beside=False)
    robust = robust_answer(decided.scene, decided.results)
    check, answered = reconciled(decided, Answers(answers_of(decided), None, (), robust))
    answers = {answer.name: answer for answer in answered.answers}
    contradicted = "; ".join(one.text for one in check.contradictions) or None
    if robust is not None and contradicted is None:
        answers[TOLERANCES] = robust
    position, heading, pose = (str(answers[name].verdict) for name in QUESTIONS[:3])
    verdicts = {name: str(check.results[name].verdict) for name in CLAUSES}
    numbers = {name: _number(check, answers, *place) for name, place in NUMBERS.items()}
    exact = {name: exact_texts(value) for name, value in numbers.items()}
    return {
        **_record(position, heading, pose, check.verdict, contradicted),
        **verdicts,
        **{name: floats(value) for name, value in numbers.items()},
        "exact": {name: text for name, text in exact.items() if text is not None},
    }


def _record(position: str, heading: str, pose: str, theorem4: str, why: str | None) -> dict[str, Any]:
    """A record without clauses and numbers."""
    answers = dict(zip(QUESTIONS, map(str, (position, heading, pose, theorem4)), strict=True))
    return {**answers, **dict.fromkeys(CLAUSES), **dict.fromkeys(NUMBERS), "exact": {}, "why": why}


def _number(check: Check, answers: Mapping[str, Answer], place: str, key: str) -> Any:
    """One number of an answer or a clause; None where it has none, and where it would be sampled."""
    if place == "translation" and not isinstance(check, CellCheck):
        return None
    facts = answers[place].facts if place in answers else tuple(_clause_facts(check, place))
    value = next((fact.value for fact in facts if fact.key == key), None)
    return value.value if isinstance(value, Quantity) else value


def _clause_facts(check: Check, name: str) -> Iterator[Fact]:
    """What one clause says."""
    for clause, _ in check.clauses:
        if clause.name == name:
            yield from check.facts(clause)


# ---- plain systems -------------------------------------------------------------------------------


REFUSED = "refused"  # the answer of a scene that cannot be checked; why stands beside it
SYSTEM_QUESTIONS = ("stability",)
# Numbers of a record: kappa of `V' <= -kappa V` and of `V' <= -kappa`, in the square of half-width `rate_within` (null:
# everywhere); every start with `V < level` in the square of half-width `within` arrives; in one state every start
# between `from` and `to` does.
SYSTEM_NUMBERS = ("rate", "fall", "rate_within", "level", "within", "from", "to")
RATES = {DecayKind.EXPONENTIAL: "rate", DecayKind.FINITE: "fall"}
SYSTEM_TEXTS = ("method", "V")
SYSTEM_COLUMNS = (*SYSTEM_QUESTIONS, *SYSTEM_TEXTS, *SYSTEM_NUMBERS)


def system_outcome(base: Base, paths: Sequence[Path], entries: Sequence[Entry]) -> Mapping[str, Any]:
    """Check one plain system of a sweep."""
    try:
        result = decide_system(base.system(paths, entries))
    except SceneError as error:
        return refused_system(without_file(error))
    numbers = _numbers(result)
    exact = {name: exact_texts(value) for name, value in numbers.items()}
    return {
        **_system_record(str(result.verdict), None),
        **_texts(result),
        **{name: floats(value) for name, value in numbers.items()},
        "exact": {name: text for name, text in exact.items() if text is not None},
    }


def refused_system(why: str) -> Mapping[str, Any]:
    """A system without an answer."""
    return _system_record(REFUSED, one_line(why))


def without_file(error: SceneError) -> str:
    """What is wrong, without the name of the file, which is that of the whole sweep."""
    return f"{error.key}: {str(error).partition(f'{error.key}: ')[2]}" if error.key else str(error)


def _system_record(stability: str, why: str | None) -> dict[str, Any]:
    """A record without texts and numbers."""
    return {**dict.fromkeys(SYSTEM_COLUMNS), SYSTEM_QUESTIONS[0]: stability, "exact": {}, "why": why}


def _texts(result: StabilityResult) -> dict[str, str | None]:
    function = result.function
    return {"method": str(result.method), "V": None if function is None else function.text}


def _numbers(result: StabilityResult) -> dict[str, Any]:
    found: dict[str, Any] = {}
    reach = result.reach
    if reach.rate is not None and reach.rate_domain is not None and reach.rate.decay in RATES:
        found[RATES[reach.rate.decay]] = reach.rate.kappa
        found["rate_within"] = reach.rate_domain.radius
    if reach.region is not None:
        found |= {"level": reach.region.level, "within": reach.region.radius}
    intervals = (fact.value for fact in result.deciding.facts if fact.key == "region" and fact.value)
    for interval in intervals:  # of starts, in one state
        found |= {key: interval[key].value for key in ("from", "to")}
    return found
