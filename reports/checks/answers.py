"""The answers to a check, written down: as the first block on a terminal, and as JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.cells.contact_rule import rule_notes, rule_of
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.answers.answer import Answer, Position, at_least, contact_facts, has_dynamics
from nonsmooth.proofs.answers.answers import Answers, OtherRule, answers_of
from nonsmooth.proofs.clauses.clause import Clause
from nonsmooth.proofs.findings import Contradiction, Quantity, Record, Theorem4
from nonsmooth.proofs.theorem4 import Check
from nonsmooth.reports.output.facts import as_record, fact_record, with_exact
from nonsmooth.reports.output.terminal import answers_table, blocks_view, verdict_text
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_field import angle_notes
from nonsmooth.symbolic.numbers.number_text import float_text, percent_text, place_text, real_text, short_text

if TYPE_CHECKING:
    from nonsmooth.proofs.answers.destinations import Destination, Destinations, RestPoint
    from nonsmooth.proofs.answers.failures import Failure
    from nonsmooth.reports.output.document import Table
    from nonsmooth.symbolic.mechanics.scene import Scene


MOST_SHOWN = 8  # destinations on a terminal and in a report
MOST_CORNERS = 8  # of an area of rest that are written on a terminal
GOES = ("the body ...", "starts", "near there", "heading")
PLACE_DIGITS = 4
THEOREM_IN_WORDS = (
    "Theorem 4 (the position is stable, the heading is not, feedback holds both where mu_side < mu_roll): "
)


class StatedAnswers(NamedTuple):
    """The answers to a check in words, which a terminal and a report set each in its way.

    Attributes:
        answers: position, heading and pose, and those about inertia and tolerances where some is stated.
        contact: which wheels carry the body.
        rule: the contact rule, with what it means.
        notes: what users of the rule must know.
        contradictions: three lines each.
    """

    answers: tuple[Answer, ...]
    contact: str
    rule: str
    notes: tuple[str, ...]
    contradictions: tuple[tuple[str, str, str], ...]


def stated_answers(result: Check, answers: Answers) -> StatedAnswers:
    """What there is to say of a check beside its tables."""
    rule = rule_of(result.scene)
    return StatedAnswers(
        answers.rows,
        "; ".join(fact.words for fact in contact_facts(result) if fact.words),
        f"rule {rule.name}: {rule.summary}",
        (*rule_notes(result.scene), *inertia_notes(result.scene)),
        tuple(map(contradiction_lines, result.contradictions)),
    )


def answers_view(result: Check, answers: Answers) -> RenderableType:
    """Three answers, where bodies go otherwise, the contact rule, the other rules, and the theorem in one line."""
    stated = stated_answers(result, answers)
    parts: list[RenderableType] = [Text(stated.contact), answers_table(answer_lines(stated.answers))]
    if answers.rest_points is not None:
        parts.append(Text(_rest_points_text(answers.rest_points, result.scene.units.after_length)))
    for lines in stated.contradictions:
        parts += [Text(line, "bold red") for line in lines]
    if answers.destinations is not None:
        parts.append(Text(f"{destinations_head(result.scene, answers.destinations.starts)}:"))
        parts.append(blocks_view([destinations_table(answers.destinations, GOES)]))
    if answers.headings is not None:
        from nonsmooth.reports.checks.equilibrium_headings import headings_blocks

        parts.append(blocks_view(headings_blocks(answers.headings)))
    parts.append(Text(stated.rule))
    parts += [Text(f"note: {note}", "yellow") for note in stated.notes]
    if answers.others:
        parts.append(Text(f"other rules: {'; '.join(map(_in_short, answers.others))}"))
    parts.append(
        Text(THEOREM_IN_WORDS).append_text(verdict_text(result.verdict, bold=True)).append(_theorem_note(result))
    )
    return Group(*parts)


def destinations_head(scene: Scene, starts: int) -> str:
    """Of which starts the shares are: of those in the checked square, over the wheels that carry the body there."""
    bodies, check = "bodies without inertia" if has_dynamics(scene) else "bodies", scene.check
    if check.wider is None:
        return f"where {bodies} go that start in the square (shares sampled from {starts} starts)"
    unit = scene.units.after_length
    share = percent_text(float(check.radius / check.wider) ** 2)
    part = f"{share} of the {short_text(check.wider)}{unit} square that is stated (--grid 9 maps that)"
    here = f"in the square within {short_text(check.radius)}{unit}, {part}"
    return f"where the centres of {bodies} go that start {here}, on the wheels that carry it here, from {starts} starts"


def _theorem_note(result: Check) -> str:
    """What hypotheses that are not met mean for the answers: nothing."""
    if result.verdict is not Theorem4.HYPOTHESES_NOT_MET:
        return ""
    return " (it asks for rest at the point itself; the answers above do not, and stand without it)"


def inertia_notes(scene: Scene) -> Iterator[str]:
    """That an inertia is stated under a rule which no body with inertia follows."""
    if scene.inertia is not None and scene.inertia.is_stated and not has_dynamics(scene):
        rule = scene.contact.rule
        yield f"dynamics are refused under rule {rule}: [body] inertia counts under rules ellipse and roller only"


def contradiction_lines(found: Contradiction) -> tuple[str, str, str]:
    """That two statements contradict each other, and each of them."""
    head = f"contradiction between {found.between}: nobody may rely on either (please report this)"
    return head, f"  one side: {found.sides[0]}", f"  the other: {found.sides[1]}"


def answer_lines(answers: Iterable[Answer]) -> Iterator[tuple[str, str, str]]:
    """Question, verdict and why of each."""
    return ((answer.name, str(answer.verdict), answer.sentence) for answer in answers)


def tipped_view(scene: Scene, answers: Sequence[Answer]) -> RenderableType:
    """The answers about a body that does not stand on the wheels."""
    head = Text(one_line(scene.name), "bold").append(f": {len(scene.wheels)} wheels", "not bold")
    return Group(head, answers_table(answer_lines(answers)))


def answers_record(answers: Sequence[Answer], answered: Answers | None) -> Record:
    """JSON: every answer by its name; destinations and other rules are null where nobody asked."""
    record = {answer.name: _answer_record(answer) for answer in answers}
    if answered is not None and answered.inertia is not None:
        record["position"] = {**record["position"], "inertia": _answer_record(answered.inertia)}
    destinations = None if answered is None else answered.destinations
    others = () if answered is None else answered.others
    headings = None if answered is None else answered.headings
    points = None if answered is None else answered.rest_points
    chosen: Record = {}
    if points is not None:
        entries = (
            {"points": Quantity(p.points), "position": p.position and str(p.position), "within": Quantity(p.within)}
            for p in points
        )
        chosen["rest_points"] = list(map(as_record, entries))
    outlined: Record = {}
    if headings is not None:
        from nonsmooth.reports.checks.equilibrium_headings import headings_record

        outlined = {"equilibrium_headings": headings_record(headings)}
    return {
        **record,
        "destinations": None if destinations is None else _destinations_record(destinations),
        **outlined,
        **chosen,
        "other_rules": {other.name: _other_record(other) for other in others} or None,
    }


def _answer_record(answer: Answer) -> Record:
    return {"verdict": str(answer.verdict), "reason": answer.sentence, **fact_record(answer.facts)}


def _destinations_record(destinations: Destinations) -> Record:
    entries = [
        as_record(
            {
                "goal": str(found.goal),
                "points": Quantity(found.points),
                "position": None if found.position is None else str(found.position),
                "heading": None if found.heading is None else str(found.heading),
                "share": found.share,
            }
        )
        for found in destinations.found
    ]
    return {"sampled_starts": destinations.starts, "found": entries}


def _rest_points_text(points: Sequence[RestPoint], unit: str) -> str:
    """Which places of rest there are beside the one that was taken."""
    if len(points) == 1:
        return "--at auto: no other place of rest is known in the square"
    others = "; ".join(_rest_point_text(point, unit) for point in points[1 : 1 + MOST_SHOWN])
    more = f"; {len(points) - 1 - MOST_SHOWN} more (--json lists them)" if len(points) > 1 + MOST_SHOWN else ""
    taken = f"--at auto took the best of {len(points)} places of rest, by verdict, then by certified disc"
    return f"{taken}; the others: {others}{more}"


def _rest_point_text(point: RestPoint, unit: str) -> str:
    """``(0.3, 0.1) comes home from within 0.02 m``."""
    at = _places_text(point.points)
    verdict = "not judged" if point.position is None else str(point.position)
    if point.within is None:
        return f"{at} {verdict}"
    preposition = "from within" if point.position is Position.COMES_HOME else "within"
    return f"{at} {verdict} {preposition} {at_least(point.within)}{unit}"


def _other_record(other: OtherRule) -> Record:
    said = {answer.name: str(answer.verdict) for answer in other.answers}
    return {"position": said.get("position"), "heading": said.get("heading"), "why_not": other.why_not or None}


def _in_short(other: OtherRule) -> str:
    """``box: stays near, keeps``."""
    said = ", ".join(str(answer.verdict) for answer in other.answers)
    return f"{other.name}: {said or f'no answer (--rule {other.name} says why)'}"


def destinations_table(destinations: Destinations, header: Sequence[str]) -> Table:
    """The places with the largest shares of the starts; how many others there are, with their share."""
    from nonsmooth.reports.output.document import table, without_empty_columns

    found = merged_rows(destinations)
    rows = [(goal_text(one), share_text(one.share), _word(one.position), _word(one.heading)) for one in found]
    more = rows[MOST_SHOWN:]
    if more:
        share = share_text(sum(one.share for one in found[MOST_SHOWN:]))
        rows[MOST_SHOWN:] = [(f"{len(more)} more (--json lists them)", share, "", "")]
    return without_empty_columns(table(header, rows, (5, 2, 2, 2)))


def _word(verdict: object) -> str:
    return "" if verdict is None else str(verdict)


def merged_rows(destinations: Destinations) -> list[Destination]:
    """The destinations, the largest share first; those that read the same are one row."""
    rows: dict[tuple[object, ...], Destination] = {}
    for found in destinations.found:
        key = (goal_text(found), found.position, found.heading)
        rows[key] = replace(rows[key], share=rows[key].share + found.share) if key in rows else found
    return sorted(rows.values(), key=lambda row: -row.share)


def goal_text(found: Destination) -> str:
    """What becomes of a body there, and where that is."""
    return f"{found.goal} {_places_text(found.points)}".rstrip()


def _places_text(points: Sequence[Sequence[Any]]) -> str:
    """A place, the ends of a line, corners of an area (of many how far they reach); nothing without a place."""
    if len(points) > MOST_CORNERS:
        low, high = ([edge(numbers) for numbers in zip(*points, strict=True)] for edge in (min, max))
        reach = f"{place_text(low, PLACE_DIGITS)} to {place_text(high, PLACE_DIGITS)}"
        return f"of {len(points)} corners, from {reach} (--json lists them)"
    return (" to " if len(points) == 2 else ", ").join(place_text(point, PLACE_DIGITS) for point in points)


def share_text(share: float) -> str:
    """A sampled share in per cent."""
    return f"{float_text(100 * share, 3)} %" if share >= 0.001 or not share else "< 0.1 %"


# ---- records -------------------------------------------------------------------------------------
#
# Results as JSON records with stable keys; how values are written: :mod:`nonsmooth.reports.output.facts`.


CHECK_SCHEMA = "nonsmooth-check/2"
CHECKS_SCHEMA = "nonsmooth-checks/1"
PARTITION_SCHEMA = "nonsmooth-partition/1"
SCENES_SCHEMA = "nonsmooth-scenes/1"
FAILURE = ("position", "heading", "pose", "theorem4")  # the answers of a failure, beside wheel, kind and why


def check_record(
    result: Check,
    answered: Answers | None = None,
    continuum: Record | None = None,
    failures: Sequence[Failure] | None = None,
) -> Record:
    """The verdicts of one check; points and twists are measured from ``equilibrium.at``.

    Args:
        result: the verdicts.
        answered: where bodies go and what the other rules say, where that was asked.
        continuum: the record of the continuous idealization, where it is asked for.
        failures: the answers with any one wheel failed, where they are asked for.
    """
    scene = result.scene
    return {
        "schema": CHECK_SCHEMA,
        "scene": scene.name,
        "wheels": len(scene.wheels),
        "rule": str(scene.contact.rule),
        **with_exact({"radius": scene.check.radius, "length": scene.field(scene.check.length)}),
        "contact_set": fact_record(contact_facts(result)),
        "answers": answers_record(answers_of(result), answered),
        "robust": None if answered is None or answered.robust is None else _answer_record(answered.robust),
        "contact_states": _census_record(result),
        **{clause.name: _clause_record(result, clause) for clause, _ in result.clauses},
        "theorem4": {"verdict": str(result.verdict), "reason": result.reason},
        **contradictions_record(result.contradictions),
        "continuum": continuum,
        "failures": None if failures is None else failure_records(failures),
        "notes": [*angle_notes(scene.field), *rule_notes(scene)],
        "skipped": [{"what": s.what, "count": s.count, "why": s.why} for s in result.skipped],
        "seconds": {step: round(seconds, 6) for step, seconds in result.seconds.items()},
    }


def contradictions_record(found: Sequence[Contradiction]) -> Record:
    """What contradicts what, with both sides; without a key where nothing does."""
    sides = [{"between": one.between, "sides": list(one.sides)} for one in found]
    return {"contradictions": sides} if sides else {}


def checks_record(records: Iterable[Record]) -> Record:
    """Checks of one scene under several rules, by their records."""
    return {"schema": CHECKS_SCHEMA, "checks": list(records)}


def failure_records(failures: Sequence[Failure]) -> list[Record]:
    """Failures wheel by wheel as JSON; exactly one of them is the worst."""
    from nonsmooth.proofs.answers.failures import worst_failure

    worst = worst_failure(tuple(failures))
    return [
        {
            "wheel": failure.wheel,
            "failure": str(failure.kind),
            **{name: str(getattr(failure, name)) for name in FAILURE},
            "why": failure.why or None,
            "worst": failure is worst,
        }
        for failure in failures
    ]


def partition_record(partition: Partition) -> Record:
    """The cells, in the partition's coordinates; a cell where the rule ties lists its other motions as alternatives."""
    return {
        "schema": PARTITION_SCHEMA,
        "scene": partition.scene.name,
        "rule": str(partition.rule),
        "cells": [
            {
                **with_exact(
                    {"twist": cell.states[0].twist, "polygon": cell.polygon.vertices, "area": cell.polygon.area}
                ),
                "rows": cell.states[0].row_names,
                "alternatives": [
                    {**with_exact({"twist": state.twist}), "rows": state.row_names} for state in cell.states[1:]
                ],
            }
            for cell in partition.cells
        ],
        **with_exact({"domain": partition.domain.vertices}),
        "area_error": real_text(partition.area_error) if partition.complete else None,
        "notes": list(angle_notes(partition.scene.field)),
    }


def states_record(partition: Partition) -> list[Record]:
    """The contact states that own a cell, with their control vector fields by wheel (None beyond three rows)."""
    return [
        {
            "rows": state.row_names,
            **with_exact({"twist": state.twist}),
            "control_fields": None
            if len(state.rows) > 3
            else [
                {"wheel": w, **with_exact({"field": control_field})}
                for w, control_field in sorted(state.control_fields.items())
            ],
        }
        for state in partition.states
    ]


def scenes_record(descriptions: dict[str, str]) -> Record:
    """The built-in scenes."""
    return {
        "schema": SCENES_SCHEMA,
        "scenes": [{"name": name, "description": text} for name, text in descriptions.items()],
    }


def _clause_record(result: Check, clause: Clause[Any]) -> Record:
    found = result.results[clause.name]
    return {"verdict": str(found.verdict), "reason": found.reason, **fact_record(result.facts(clause))}


def _census_record(result: Check) -> Record:
    census = result.census
    return {
        "possible": census.possible,
        "singular": census.singular,
        "distinct_twists": census.distinct_twists,
        "minimizing": result.minimizing_states,
    }
