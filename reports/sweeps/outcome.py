"""What is kept of one scene of a sweep: a flat record of answers, verdicts and rates, which a store holds as JSON."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise, product
from typing import Any, TypeAlias, TypeVar

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.proofs.answers.answer import Answer, Heading, Pose, Position
from nonsmooth.proofs.answers.answers import Answers, answers_of
from nonsmooth.proofs.answers.contradictions import Printed, sample_of, without_contradictions
from nonsmooth.proofs.answers.destinations import SampledEnds, ends_from
from nonsmooth.proofs.answers.failures import failures_of
from nonsmooth.proofs.answers.robust import TOLERANCES, robust_answer
from nonsmooth.proofs.findings.exact_json import Record
from nonsmooth.proofs.findings.verdicts import Certainty, Quantity, Theorem4
from nonsmooth.proofs.robust.decide import decided_statement
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.domain import DecayKind
from nonsmooth.proofs.theorem4 import CellCheck, Check, check_theorem4
from nonsmooth.reports.checks.answers import failure_records
from nonsmooth.reports.output.facts import exact_texts, floats
from nonsmooth.reports.output.refusals import beyond_floats_named
from nonsmooth.reports.sweeps.base import Base
from nonsmooth.reports.sweeps.sweep_plan import Axis, Entry, SweepError, SweepPlan, Value, WrittenValue
from nonsmooth.symbolic.files.key_paths import Path
from nonsmooth.symbolic.mechanics.contact_set import TipsError, standing
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line, shown
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Outcome: TypeAlias = Mapping[str, Any]
Kept = TypeVar("Kept")

QUESTIONS = ("position", "heading", "pose", "theorem4")
CLAUSES = ("equilibrium", "translation", "rotation", "feedback")

COEFFICIENTS = ("mu_roll", "mu_side")  # of friction, as key paths end

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


def outcomes_of(
    base: Base, paths: Sequence[Path], scenes: Iterable[Sequence[Entry]], *, failures: bool = False
) -> list[Outcome]:
    """Check scenes of a sweep one after the other, and follow the paths by which they are compared all together.

    Scenes whose answers follow from the same (:func:`_follows_from`) are checked once.

    Args:
        base: the scene before anything varies.
        paths: the numbers that vary.
        scenes: their values in each scene.
        failures: also ask what happens when any one wheel fails.
    """
    known: dict[Hashable, _Decided] = {}
    begun = [_begun(base, paths, entries, known, failures=failures) for entries in scenes]
    decided = list(dict.fromkeys(one for one in begun if isinstance(one, _Decided)))
    samples = [one.sample for one in decided if one.sample is not None]
    ends = iter(ends_from(samples) if samples else ())
    ended = {one: _ended(one, ends) for one in decided}
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

    printed: Printed
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
                return _ended(found, iter(ends_from([found.sample]))) if found.sample else found
            source = _follows_from(scene, paths, entries)
            if source not in known:
                known[source] = _decided(scene, failures=failures)
            return known[source]

    return _unless_refused(decided)


def _follows_from(scene: Scene, paths: Sequence[Path], entries: Sequence[Entry]) -> Hashable:
    """What tells the answers of a scene from those of the others of its sweep.

    That are the values that vary; but of friction, which nobody knows well and many sweeps vary, only what the contact
    rule sees, where that is less.  Tolerances are of the friction itself.
    """
    if scene.tolerances is not None or not rule_of(scene).sees_order_of_friction:
        return tuple(entries)
    others = tuple(entry for path, entry in zip(paths, entries, strict=True) if path[-1] not in COEFFICIENTS)
    frictions = [wheel.friction for wheel in (*scene.wheels, *scene.idle)]
    return others, tuple((bool(own.roll), bool(own.side), sign(own.side - own.roll)) for own in frictions)


def _decided(scene: Scene, *, failures: bool) -> _Decided:
    """The verdicts and answers of one scene, not yet compared with paths."""
    check = check_theorem4(scene, beside=False)
    robust = robust_answer(check.scene, check.results)
    printed = Printed.of(check, Answers(answers_of(check), None, (), robust))
    further = failure_records(failures_of(scene)) if failures else None
    return _Decided(printed, robust, sample_of(printed), further)


def _ended(decided: _Decided, ends: Iterator[SampledEnds | None]) -> Outcome:
    """The outcome of a scene, whose paths end as the next ones do."""
    own = None if decided.sample is None else next(ends)
    return _unless_refused(lambda: decided.outcome(own))


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


def refused(why: str, *, is_system: bool = False) -> Outcome:
    """A scene without answers."""
    if is_system:
        return _system_record(REFUSED, one_line(why))
    return _record(REFUSED, REFUSED, REFUSED, REFUSED, one_line(why))


def questions_of(outcome: Outcome) -> tuple[str, ...]:
    """The questions that an outcome answers: those of an array, or that of a plain system."""
    return SYSTEM_QUESTIONS if SYSTEM_QUESTIONS[0] in outcome else QUESTIONS


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


def _with_numbers(record: Outcome, numbers: Mapping[str, Any]) -> Outcome:
    """A record with its numbers as floats, and the texts of those that are exact."""
    exact = {name: exact_texts(value) for name, value in numbers.items()}
    texts = {name: text for name, text in exact.items() if text is not None}
    return {**record, **{name: floats(value) for name, value in numbers.items()}, "exact": texts}


def _record(position: str, heading: str, pose: str, theorem4: str, why: str | None) -> Record:
    """A record without clauses and numbers."""
    answers = dict(zip(QUESTIONS, map(str, (position, heading, pose, theorem4)), strict=True))
    return {**answers, **dict.fromkeys(CLAUSES), **dict.fromkeys(NUMBERS), "exact": {}, "why": why}


def _number(check: Check, answers: Mapping[str, Answer], place: str, key: str) -> Any:
    """One number of an answer or a clause; None where it has none, and where it would be sampled."""
    if place == "translation" and not isinstance(check, CellCheck):
        return None
    clauses = (clause for clause, _ in check.clauses if clause.name == place)
    facts = answers[place].facts if place in answers else (fact for own in clauses for fact in check.facts(own))
    value = next((fact.value for fact in facts if fact.key == key), None)
    return value.value if isinstance(value, Quantity) else value


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


def system_outcome(base: Base, paths: Sequence[Path], entries: Sequence[Entry]) -> Outcome:
    """Check one plain system of a sweep."""
    try:
        result = decide_system(base.system(paths, entries))
    except SceneError as error:
        return refused(without_file(error), is_system=True)
    function = result.function
    texts = {"method": str(result.method), "V": None if function is None else function.text}
    return _with_numbers({**_system_record(str(result.verdict), None), **texts}, _numbers(result))


def without_file(error: SceneError) -> str:
    """What is wrong, without the name of the file, which is that of the whole sweep."""
    return f"{error.key}: {str(error).partition(f'{error.key}: ')[2]}" if error.key else str(error)


def _system_record(stability: str, why: str | None) -> Record:
    """A record without texts and numbers."""
    return {**dict.fromkeys(SYSTEM_COLUMNS), SYSTEM_QUESTIONS[0]: stability, "exact": {}, "why": why}


def _numbers(result: StabilityResult) -> Record:
    found: Record = {}
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


# ---- cells of a sweep's grid that are certified as a whole ---------------------------------------
#
# Every array between their corners, and within its tolerances.
#
# A cell is one scene, the middle of it, with tolerances that are larger by half the cell's sides: what is proved of all
# arrays within those holds in the whole cell.  What is not proved is left open; nothing is sampled.


TABLE = "tolerance"
ENTRIES = ("position", "heading", "speed", "mu_roll", "mu_side")
ROOM = 1 + Fraction(1, 2**20)  # of half a side: headings of the scene are right to 1e-15
HALF_TURN = 180  # degrees
FOLLOWING = ("inward", "outward", "that of the field")  # headings that follow the position of a wheel

Sides: TypeAlias = tuple[tuple[Value, Value], ...]


@dataclass(frozen=True)
class CertifiedCell:
    """One cell of the grid.

    Attributes:
        sides: from where to where, along each axis.
        verdict: whether a bound is proved for all of it.
        ends_within: radius of the disc in which every body ends (length); None where none is proved.
        starts_within: radius of the disc of starts (length); None where only starts close by are meant, or none.
        why: why not, else empty.
    """

    sides: Sides
    verdict: Certainty
    ends_within: Fraction | None
    starts_within: Fraction | None
    why: str


@dataclass(frozen=True)
class Cells:
    """All cells of a grid.

    Attributes:
        base: the scene with a table of tolerances in which every entry stands.
        paths: what the scene of a cell changes: the numbers that vary, and the tolerances.
        sides: of every cell.
        entries: the values of ``paths`` for every cell.
    """

    base: Base
    paths: tuple[Path, ...]
    sides: tuple[Sides, ...]
    entries: tuple[tuple[Entry, ...], ...]


def exact_base(base: Base) -> Base:
    """The scene without tolerances."""
    return replace(base, document={key: value for key, value in base.document.items() if key != TABLE})


def planned_cells(base: Base, plan: SweepPlan) -> Cells:
    """The cells of a grid, before anything is proved.

    Raises:
        SweepError: for draws, values that do not ascend, and numbers that are not in boxes of tolerances.
    """
    _require_cells(plan)
    _require_independent(base, plan)
    given = base.document.get(TABLE) or {}
    whole = replace(base, document={**base.document, TABLE: {**dict.fromkeys(ENTRIES, 0), **given}})
    paths = (*(axis.path for axis in plan.axes), *((TABLE, name) for name in ENTRIES))
    own = None if TABLE not in base.document else base.scene((), ()).tolerances
    stated = {name: "0" if own is None else str(getattr(own, name)) for name in ENTRIES}
    radians = (base.document.get("units") or {}).get("angle") == "rad"
    sides = tuple(_sides_of(plan))
    return Cells(whole, paths, sides, tuple(_entries(plan, cell, stated, radians=radians) for cell in sides))


def _require_cells(plan: SweepPlan) -> None:
    if plan.draws is not None:
        raise SweepError("certify: required a grid of scenes, received random draws")
    for axis in plan.axes:
        if _entry_of(axis) is None:
            allowed = "positions, headings, speeds, mu_roll, mu_side of wheels or the checked point"
            raise SweepError(f"certify: required numbers that tolerances follow ({allowed}), received {axis.name}")
        values = [axis.values.value(k) for k in range(axis.values.count or 0)]
        if len(values) < 2 or any(isinstance(value, WrittenValue) for value in values) or not _ascends(values):
            raise SweepError(f"certify: required two or more rational values of {axis.name} that ascend")


def _require_independent(base: Base, plan: SweepPlan) -> None:
    """Refuse a number of a wheel that another one follows, or should turn with: tolerances move each on its own."""
    friction = base.document.get("friction") or {}
    for axis in plan.axes:
        if axis.path[0] != "wheel":
            continue
        place = int(axis.path[1])
        wheel = base.document["wheel"][place]
        grip = wheel.get("axis", friction.get("axis"))
        if axis.path[2] == "heading" and grip is not None:
            raise SweepError(f"certify: required a friction axis that turns with {axis.name}, received {shown(grip)}")
        for name, value in (("heading", wheel.get("heading", "that of the field")), ("axis", grip)):
            if axis.path[2] == "position" and value in FOLLOWING:
                expected = f"an angle or a direction as {name} of wheel {place + 1}, since {axis.name} varies"
                raise SweepError(f"certify: required {expected}, received {shown(value)}")


def _ascends(values: Sequence[Value | WrittenValue]) -> bool:
    numbers = [value.number for value in values if value.number is not None]
    return all(a < b for a, b in pairwise(numbers))


def _sides_of(plan: SweepPlan) -> Iterator[Sides]:
    """The sides of all cells, the last axis fastest."""
    intervals = []
    for axis in plan.axes:
        values = [axis.values.value(k) for k in range(axis.values.count or 0)]
        known = [value for value in values if isinstance(value, Value)]
        intervals.append(list(pairwise(known)))
    yield from product(*intervals)


def _entries(plan: SweepPlan, sides: Sides, stated: Mapping[str, str], *, radians: bool) -> tuple[Entry, ...]:
    """The middle of a cell, and its tolerances."""
    middles = [low.between(high, Fraction(1, 2)) for low, high in sides]
    larger = dict.fromkeys(ENTRIES, Fraction(0))
    for axis, (low, high), middle in zip(plan.axes, sides, middles, strict=True):
        name = _entry_of(axis)
        side = replace(low, constant=high.constant - low.constant, multiple=high.multiple - low.multiple)
        if name is not None:
            larger[name] += _size(name, side, middle, radians=radians) / 2 * ROOM
    sizes = (_enlarged(name, stated[name], larger[name]) for name in ENTRIES)
    return (*(middle.entry for middle in middles), *sizes)


def _enlarged(name: str, stated: str, size: Fraction) -> str:
    """A tolerance larger by half a side; of a share s of a value within a share h of the middle, ``s + h + s h``."""
    if name == "heading":
        return f"({stated} + {size})*pi rad"
    return f"{stated} + {size}" if name == "position" else f"{stated} + {size} + ({stated})*({size})"


def _size(name: str, side: Value, middle: Value, *, radians: bool) -> Fraction:
    """A side of a cell in the unit of its tolerance: a length, a share of the middle, or a turn in half turns."""
    if name == "heading":
        return _turn(side, radians=radians)
    if side.multiple or middle.multiple:
        raise SweepError(f"certify: required rational values of {name}, received multiples of pi")
    if name == "position":
        return side.constant
    if not middle.constant:
        raise SweepError(f"certify: required {name} of one sign, for a tolerance is a share of it; received 0")
    return side.constant / abs(middle.constant)


def _turn(side: Value, *, radians: bool) -> Fraction:
    in_degrees = side.unit == "deg" or (not side.unit and not side.multiple and not radians)
    if in_degrees and not side.multiple:
        return side.constant / HALF_TURN
    if not side.constant and side.unit != "deg":
        return side.multiple
    raise SweepError("certify: required headings in degrees or as multiples of pi, received radians")


def _entry_of(axis: Axis) -> str | None:
    """The tolerance that follows a number; None for others."""
    table, *middle, last = axis.path
    if table == "check":
        return "position" if middle == ["equilibrium"] else None
    if table == "friction":
        return str(last) if last in ("mu_roll", "mu_side") else None
    if table != "wheel":
        return None
    if middle[1:] == ["position"]:
        return "position"
    return str(last) if last in ("heading", "speed", "mu_roll", "mu_side") else None


def cell_outcome(base: Base, paths: Sequence[Path], entries: Sequence[Entry]) -> Record:
    """What is proved of one cell, as a record that a store holds."""
    try:
        found = decided_statement(standing(base.scene(paths, entries)))
    except (SceneError, RefusalError) as error:
        return {"verdict": str(Certainty.UNDECIDED), "radius": None, "start": None, "why": one_line(str(error))}
    exact = [None if value is None else str(value) for value in (found.radius, found.start)]
    certified = found.verdict is Certainty.CERTIFIED
    return {
        "verdict": str(found.verdict),
        "radius": exact[0],
        "start": exact[1],
        "why": "" if certified else found.reason,
    }


def certified_cell(sides: Sides, outcome: Any) -> CertifiedCell:
    """A cell from its record."""
    radius, start = (None if outcome[key] is None else Fraction(outcome[key]) for key in ("radius", "start"))
    return CertifiedCell(sides, Certainty(outcome["verdict"]), radius, start, outcome["why"])
