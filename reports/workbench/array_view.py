"""The stages of the view of an array.

``fast`` shows the cells, which are exact (or a sampled field), with answers that floats guess and nobody has proved;
``exact`` says what ``nonsmooth check`` says.  Paths, other equilibria, tolerances and the other rules follow.
"""

from __future__ import annotations

import math
import time
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import combinations
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.analysis.cells.contact_rule import has_cells
from nonsmooth.analysis.cells.equilibria import find_equilibria
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.minimizers.sampling import sample_field
from nonsmooth.proofs.answers.answer import Answer, Heading, Position, has_dynamics
from nonsmooth.proofs.answers.answers import OtherRule, other_rules, robust_answer
from nonsmooth.proofs.answers.inertia import inertia_answer
from nonsmooth.proofs.clauses.clause import JudgedEquilibrium
from nonsmooth.proofs.clauses.workspace import ClauseResult
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.theorem4 import SEARCH_UNITS, judge_equilibria
from nonsmooth.reports.checks.check import check_array
from nonsmooth.reports.checks.check_results import ArrayAnswers, CheckResult, TippedResult
from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.output.facts import fact_lines, fact_record, floats
from nonsmooth.reports.workbench.shapes import (
    Announce,
    body_record,
    cells_record,
    contact_record,
    edges_record,
    loads_at_point,
    path_records,
    point,
    square_record,
    wheels_record,
)
from nonsmooth.symbolic.files.scene_file import unit_of_speed
from nonsmooth.symbolic.mechanics.contact_set import TipsError, contact_set, standing
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import XY, around, cross, dot, minus
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, watched, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition

Stage: TypeAlias = Record

FAST_UNITS = 40_000  # of exact arithmetic for the cells of the first stage: a second or so
LATER = "later"  # geometry that a second stage ``fast`` shows
CELL_SECONDS = 12.0  # for the cells of that stage; without cells there are no answers either
TOO_LONG = (
    "no cells and no answers: required cells of rule {rule} within {seconds:g} s, received an array that takes longer "
    "(fewer wheels or a smaller checked radius take less; nonsmooth check has more time)"
)
FIELD = 15  # points in a row of the sampled field
QUESTIONS = {
    "position": "Where does a body go that starts near the point?",
    "heading": "What does its heading do?",
    "pose": "Can feedback hold position and heading together?",
    "inertia": "What does a body with inertia do?",
}


def array_stages(array: Array, request: Record, announce: Announce) -> Iterator[Stage]:
    """Everything that the request wants, one stage after the other.

    Raises:
        RefusalError: where the motion is not determined.
        SceneError: where a wheel lies exactly under the edge of the body.
    """
    began = time.perf_counter()

    def timed(stage: Stage) -> Stage:
        return {**stage, "time": round(time.perf_counter() - began, 6)}

    watch = _Watch(announce)
    with watched(array.scene.field, watch):
        shown = fast_stage(array, FAST_UNITS)
        yield timed(shown)
        if shown["geometry"] == LATER:
            try:
                with watch.at_most(CELL_SECONDS):
                    whole = fast_stage(array)
            except _TooLongError:
                for stage in _without_cells(array, shown, request):
                    yield timed(stage)
                return
            yield timed(whole)
        try:
            result = proved(array, announce)
        except TipsError as tipping:
            yield timed(exact_stage(TippedResult(array.scene, tipping)))
            return
        yield timed(exact_stage(result))
        for stage in _later_stages(array, result, request, announce):
            yield timed(stage)


class _TooLongError(BaseException):
    """Time is over; no step may take that for an error of its own."""


class _Watch:
    """Looks up now and then in exact arithmetic: whether the view is still wanted, and whether there is time."""

    def __init__(self, announce: Announce) -> None:
        self._announce, self._last = announce, math.inf

    def __call__(self) -> None:
        """See the class.

        Raises:
            _TooLongError: where there is no time left.
        """
        self._announce("")
        if time.monotonic() > self._last:
            raise _TooLongError

    @contextmanager
    def at_most(self, seconds: float) -> Iterator[None]:
        """Limit what is done inside the block."""
        self._last = time.monotonic() + seconds
        try:
            yield
        finally:
            self._last = math.inf


def _without_cells(array: Array, shown: Stage, request: Mapping[str, Any]) -> Iterator[Stage]:
    """What there is to say of an array whose cells take too long: why, and what the other rules answer."""
    line = TOO_LONG.format(rule=array.scene.contact.rule, seconds=CELL_SECONDS)
    yield {**shown, "geometry": "none", "note": "no cells: they take too long"}
    yield {"stage": "unanswered", "message": line, "key": None}
    if _is_wanted("comparison", request.get("want")):
        yield _comparison_stage(array)


def _comparison_stage(array: Array) -> Stage:
    return {"stage": "comparison", "rules": [_other_record(other) for other in other_rules(standing(array.scene))]}


def _later_stages(array: Array, result: CheckResult, request: Mapping[str, Any], announce: Announce) -> Iterator[Stage]:
    """What takes longer and changes no answer."""
    wanted = request.get("want")
    if _is_wanted("paths", wanted) and request.get("starts"):
        yield {"stage": "paths", "paths": path_records(array, request, announce)}
    if _is_wanted("inertia", wanted) and has_dynamics(array.scene):
        announce("inertia")
        answer = inertia_answer(result.evidence.scene)
        if answer is not None:
            yield {"stage": "inertia", "answer": answer_records((answer,))[0]}
    if _is_wanted("clauses", wanted):
        announce("facts")
        yield facts_stage(result)
    if _is_wanted("equilibria", wanted):
        announce("other equilibria")
        yield {"stage": "equilibria", **equilibria_record(array)}
    if _is_wanted("tolerance", wanted) and array.scene.tolerances is not None:
        announce("tolerances")
        yield {"stage": "tolerance", **tolerance_record(result)}
    if _is_wanted("comparison", wanted):
        announce("other rules")
        yield _comparison_stage(array)


def _is_wanted(name: str, wanted: object) -> bool:
    """Whether the request wants this stage; without a list it wants all."""
    return not isinstance(wanted, list) or name in wanted


# ---- what shows at once --------------------------------------------------------------------------


def fast_stage(array: Array, units: int | None = None) -> Stage:
    """Wheels, body, square, and the cells or a sampled field, with guessed answers.

    Args:
        array: the array.
        units: of exact arithmetic for the cells; where they take more, they are left for ``later``.
    """
    scene = array.scene
    geometry: Stage = {"cells": [], "edges": [], "field": [], "geometry": "none", "note": None}
    answers = None
    try:
        stands = standing(scene)
        contact = contact_set(stands)
        carrying = contact.wheels
        if has_cells(scene):
            with _limited(scene, units):
                partition = array.partition
            geometry |= {"cells": cells_record(partition), "edges": edges_record(partition), "geometry": "exact"}
            answers = guessed_answers(partition)
        else:
            geometry |= {"field": _field(stands), "geometry": "sampled"}
    except TipsError as tipping:
        stands, contact, carrying = scene, None, tipping.carrying
        geometry["note"] = tipping.why
    except _LaterError:
        geometry |= {"geometry": LATER, "note": "the cells take a moment"}
    except RefusalError as refusal:
        geometry["note"] = str(refusal)
    return {
        "stage": "fast",
        "kind": "array",
        **geometry,
        "wheels": wheels_record(stands, unit_of_speed(array.document, scene), carrying, loads_at_point(stands)),
        "body": body_record(scene),
        "square": square_record(stands),
        "values": _values(stands),
        "contact": None if contact is None else contact_record(contact),
        "answers": answers,
    }


class _LaterError(Exception):
    """Cells that take more than a blink."""


@contextmanager
def _limited(scene: Scene, units: int | None) -> Iterator[None]:
    """Limit the exact arithmetic of the cells.

    Raises:
        _LaterError: where they take more; whatever was refused for that reason is not refused yet.
    """
    if units is None:
        yield
        return
    try:
        with work_limit(scene.field, units):
            meter = scene.field.meter
            yield
    except (WorkLimitError, RefusalError):
        if meter is not None and meter.left <= 0:
            raise _LaterError from None
        raise


def _field(scene: Scene) -> list[list[float | None]]:
    """``[x, y, x', y', omega]`` at the points of a grid, sampled; None where the motion is not determined."""
    field = sample_field(scene, FIELD)
    rows = zip(field.points.tolist(), field.velocities.tolist(), field.rates.tolist(), strict=True)
    return [floats((*place, *velocity, rate)) for place, velocity, rate in rows]


def _values(scene: Scene) -> Record:
    """What holds where the document states nothing."""
    square = square_record(scene)
    named = {key: {"value": square[key], "text": square["exact"][key]} for key in ("radius", "length")}
    return {**named, "rule": scene.contact.rule}


# ---- what is proved ------------------------------------------------------------------------------


def proved(array: Array, announce: Announce) -> CheckResult:
    """The check of the array, whose evidence is verified; the cells that are shown are not built again.

    Raises:
        RefusalError: where the motion is not determined.
        SceneError: where a wheel lies exactly under the edge of the body.
    """
    built = array.partition if has_cells(array.scene) else None
    return check_array(array.scene, ask_others=False, beside=False, announce=announce, built=built)


def exact_stage(result: ArrayAnswers) -> Stage:
    """The answers and clauses of a check whose evidence is verified, or that the body tips."""
    clauses = result.evidence.clauses if isinstance(result, CheckResult) else ()
    return {
        "stage": "exact",
        "kind": "array",
        "answers": answer_records((result.position, result.heading, result.pose)),
        "clauses": [_clause_record(clause.name, found) for clause, found in clauses],
        "verdict": result.theorem4,
        "reason": result.reason,
        "rule": result.scene.contact.rule,
    }


def facts_stage(result: CheckResult) -> Stage:
    """The clauses with everything else that there is to say of them."""
    evidence = result.evidence
    clauses = [
        {
            **_clause_record(clause.name, found),
            "facts": [{"label": "", "text": line} for line in fact_lines(evidence.facts(clause))],
        }
        for clause, found in evidence.clauses
    ]
    return {"stage": "facts", "clauses": clauses}


def _clause_record(name: str, found: ClauseResult) -> Record:
    return {"key": name, "title": name, "verdict": str(found.verdict), "reason": found.reason, "facts": []}


def answer_records(answers: Collection[Answer]) -> list[Record]:
    """Question, answer, how it looks, and why."""
    return [
        {
            "key": answer.name,
            "question": QUESTIONS[answer.name],
            "answer": str(answer.verdict),
            "tone": answer.tone,
            "sentence": answer.sentence,
        }
        for answer in answers
    ]


def tolerance_record(result: CheckResult) -> Record:
    """What holds for every array within the tolerances: the disc in which bodies end, and the certified factor."""
    answer = robust_answer(result.evidence.scene, result.evidence.results)
    if answer is None:
        return {"verdict": None, "sentence": "", "tone": "open"}
    return {
        "verdict": str(answer.verdict),
        "tone": answer.tone,
        "sentence": answer.sentence,
        **fact_record(answer.facts),
    }


def _other_record(other: OtherRule) -> Record:
    answers = [
        {"key": answer.name, "answer": str(answer.verdict), "tone": answer.tone, "sentence": answer.sentence}
        for answer in other.answers
    ]
    return {"rule": other.name, "answers": answers, "why_not": other.why_not or None}


# ---- answers that floats guess -------------------------------------------------------------------
#
# At the checked point ``c*`` every cell has the velocity ``v* = v + omega J c*``, and along it ``|c - c*|^2/2`` changes
# at the rate ``(c - c*) . v*``, linear in c (the turning part of c' is normal to ``c - c*``).  So the largest rate of a
# cell is that of a corner.  What is not clear beyond rounding is not guessed.


CLEAR = 1e-9  # of the speeds and lengths at hand: what rounding makes of zero is well below
MOST_MEMBERS = 12  # motions that meet at the point, of which all triples are tried
TONES = {Position.COMES_HOME: "good", Position.STAYS_NEAR: "fair", Heading.KEEPS: "good", Heading.DRIFTS: "fair"}


def guessed_answers(partition: Partition) -> list[Record]:
    """Position and heading, as far as floats tell; each marked as provisional."""
    point = partition.scene.check.place
    radius = partition.scene.check.half_width
    velocities, rates, turns = [], [], []
    for cell in partition.cells:
        away = [(float(x) - point[0], float(y) - point[1]) for x, y in cell.polygon.vertices]
        far = [corner for corner in away if math.hypot(*corner) > CLEAR * radius]
        for twist in cell.twists:
            vx, vy, omega = (float(value) for value in twist)
            velocity = (vx - omega * point[1], vy + omega * point[0])
            rates.append(max(dot(corner, velocity) / math.hypot(*corner) for corner in far))
            if _holds(away, radius):
                velocities.append(velocity)
                turns.append(omega)
    return _answers(velocities, turns, max(rates))


def _holds(away: Sequence[XY], radius: float) -> bool:
    """Whether a counterclockwise polygon holds the origin, its border included."""
    for corner, following in around(away):
        along = minus(following, corner)
        if -cross(along, corner) < -CLEAR * radius * math.hypot(*along):
            return False
    return True


def _answers(velocities: Sequence[XY], turns: Sequence[float], worst: float) -> list[Record]:
    scale = max((math.hypot(*velocity) for velocity in velocities), default=0.0)
    if not scale or len(velocities) > MOST_MEMBERS:
        return []
    drift = _turns_at_rest(velocities, turns, scale)
    if not drift:
        return []
    guesses: list[tuple[str, Position | Heading]] = []
    if worst < -CLEAR * scale:
        guesses.append(("position", Position.COMES_HOME))
    elif worst <= CLEAR * scale:
        guesses.append(("position", Position.STAYS_NEAR))
    clear = max(map(abs, drift)) > CLEAR * max(1.0, *map(abs, turns))
    guesses.append(("heading", Heading.DRIFTS if clear else Heading.KEEPS))
    return [
        {"key": key, "answer": str(verdict), "tone": TONES[verdict], "provisional": True} for key, verdict in guesses
    ]


def _turns_at_rest(velocities: Sequence[XY], turns: Sequence[float], scale: float) -> list[float]:
    """Rates of rotation of mixtures of up to three motions whose velocities cancel; none away from an equilibrium."""
    motions = [((x / scale, y / scale), turn) for (x, y), turn in zip(velocities, turns, strict=True)]
    found = [turn for velocity, turn in motions if math.hypot(*velocity) <= CLEAR]
    for (a, turn), (b, other) in combinations(motions, 2):
        apart = math.hypot(*minus(a, b))
        if apart > CLEAR and abs(cross(a, b)) <= CLEAR * apart and dot(a, b) <= 0:  # the line through both meets zero
            share = dot(minus(a, b), a) / apart**2
            found.append(turn + share * (other - turn))
    for three in combinations(motions, 3):
        (a, *_), (b, *_), (c, *_) = three
        weights = cross(b, c), cross(c, a), cross(a, b)
        total = sum(weights)
        if abs(total) > CLEAR and all(weight / total >= -CLEAR for weight in weights):
            found.append(sum(weight * turn for weight, (_, turn) in zip(weights, three, strict=True)) / total)
    return found


# ---- where else bodies rest ----------------------------------------------------------------------


def equilibria_record(array: Array) -> Record:
    """Every equilibrium as points (one, the ends of a segment, or the corners of an area) with its verdicts.

    ``searched`` is false where there was no search: under a rule without cells, and where it would take too long.
    """
    if not has_cells(array.scene):
        return {"searched": False, "equilibria": []}
    try:
        partition = array.partition
        scene = partition.scene
        with work_limit(scene.field, SEARCH_UNITS):
            judged = judge_equilibria(scene, find_equilibria(partition))
    except (WorkLimitError, RefusalError):
        return {"searched": False, "equilibria": []}
    return {"searched": True, "equilibria": [_equilibrium_record(equilibrium) for equilibrium in judged]}


def _equilibrium_record(equilibrium: JudgedEquilibrium) -> Record:
    found = equilibrium.found
    return {
        "place": str(found.place),
        "points": [point(vertex) for vertex in found.points],
        "translation": None if equilibrium.translation is None else str(equilibrium.translation),
        "rotation": None if equilibrium.rotation is None else str(equilibrium.rotation),
    }
