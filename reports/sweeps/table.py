"""A sweep as rows, a record, and blocks of text and tables."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nonsmooth.proofs.answers.answer import Position, at_most
from nonsmooth.proofs.findings import Certainty, Record
from nonsmooth.reports.checks.answers import FAILURE
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.studies.result import counted_words
from nonsmooth.reports.sweeps.borders import Border
from nonsmooth.reports.sweeps.certified_cells import CertifiedCell
from nonsmooth.reports.sweeps.outcome import CLAUSES, NUMBERS, QUESTIONS, SYSTEM_COLUMNS, SYSTEM_NUMBERS, Outcome
from nonsmooth.reports.sweeps.sweep import Sweep
from nonsmooth.reports.sweeps.sweep_plan import Point
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import float_text, lower_text

SCHEMA = "nonsmooth-sweep/2"
CONTRADICTS = "contradict each other"  # in the reason of a scene whose answers do
MOST_SHOWN = 40  # scenes that a terminal lists
SHOWN_NUMBERS = ("rate", "kappa")  # beside the answers on a terminal
NEAR_NUMBERS = ("ends_within", "within", "after")  # the same where bodies come near the point, not to it
# The same where a tolerance varies: what is certified of every array within it, and up to how many times it.
TOLERANCE_NUMBERS = {"tolerance_radius": "all end within", "tolerance_factor": "certified, times"}
HEADERS = {"kappa": "law's rate", **TOLERANCE_NUMBERS}


def sweep_record(sweep: Sweep) -> Record:
    """JSON with stable keys; equal sweeps give equal records, whatever was in the store."""
    plan = sweep.plan
    return {
        "schema": SCHEMA,
        "scene": _name(sweep),
        "rule": _rule(sweep),
        "vary": [{"path": axis.name, "count": axis.values.count if plan.draws is None else None} for axis in plan.axes],
        "random": plan.draws,
        "seed": None if plan.draws is None else plan.seed,
        "rows": [_row_record(sweep, k, outcome) for k, outcome in enumerate(sweep.outcomes)],
        "cells": None if sweep.cells is None else [_cell_record(sweep, cell) for cell in sweep.cells],
        "borders": None if sweep.borders is None else [_border_record(sweep, border) for border in sweep.borders],
    }


def flat_rows(sweep: Sweep) -> Iterator[Record]:
    """One mapping for each scene, as in the CSV file: numbers as floats, and what was varied as exact text too."""
    has_failures = any("failures" in outcome for outcome in sweep.outcomes)
    for k, outcome in enumerate(sweep.outcomes):
        point = sweep.plan.point(k)
        names = sweep.plan.names
        yield {
            **{name: value.number for name, value in zip(names, point, strict=True)},
            **{f"{name} exact": str(value.entry) for name, value in zip(names, point, strict=True)},
            **{name: outcome[name] for name in _columns(sweep)},
            **(_worst(outcome) if has_failures else {}),
            "why": outcome["why"],
        }


def counted(sweep: Sweep) -> str:
    """``40 scenes; position: 20 comes home, 20 stays near; ...``."""
    groups = ((title_of(name), (outcome[name] for outcome in sweep.outcomes)) for name in sweep.questions)
    cells = "" if sweep.cells is None else f"; {_cells_text(sweep.cells)}"
    return f"{len(sweep.outcomes)} scenes; {counted_words(groups)}{cells}"


def title_of(question: str) -> str:
    """The name of a question in words."""
    return "Theorem 4" if question == "theorem4" else question


def sweep_title(sweep: Sweep) -> str:
    """What a picture shows."""
    accuracy = "" if sweep.borders is None else ", borders within 1e-9"
    return f"{one_line(_name(sweep))}: {_kind(sweep)}, {len(sweep.outcomes)} scenes{accuracy}"


def sweep_blocks(sweep: Sweep) -> list[Block]:
    """The answers as a table, where they change, and how many there are of each."""
    head, left = f"{one_line(_name(sweep))}: {_kind(sweep)}", len(sweep.outcomes) - MOST_SHOWN
    more = [f"{left} more scenes (--json and -o list them)"] if left > 0 else []
    below = sentences(*more, *_contradictions(sweep))
    return [*sentences(head), _answers_table(sweep), *below, *_borders_blocks(sweep), *sentences(counted(sweep))]


def _contradictions(sweep: Sweep) -> Iterator[str]:
    """Of how many scenes what is said contradicts itself, and the first of these contradictions."""
    said = [why for outcome in sweep.outcomes if CONTRADICTS in (why := outcome["why"] or "")]
    if said:
        yield f"{len(said)} of {len(sweep.outcomes)} scenes are undecided for that (please report this): {said[0]}"


def border_text(border: Border, name: str) -> str:
    """``position: comes home below, stays near at 1 and above`` of one question."""
    k = border.questions.index(name)
    before, there, after = border.before[k], border.there[k], border.after[k]
    if there == before:
        return f"{before}, there too; then {after}"
    return f"{before}; from there {after}" if there == after else f"{before}; there {there}; then {after}"


# ---- JSON ----------------------------------------------------------------------------------------


def _name(sweep: Sweep) -> str:
    return str(sweep.base.document.get("name", sweep.base.path.stem))


def _rule(sweep: Sweep) -> str | None:
    return None if sweep.base.is_system else str(sweep.base.scene((), ()).contact.rule)


def _kind(sweep: Sweep) -> str:
    return "plain switched system" if sweep.base.is_system else f"rule {_rule(sweep)}"


def _columns(sweep: Sweep) -> tuple[str, ...]:
    """The keys of an outcome that a row of a table holds."""
    return SYSTEM_COLUMNS if sweep.base.is_system else (*QUESTIONS, *CLAUSES, *NUMBERS)


def _values(sweep: Sweep, point: Point) -> Record:
    """What was varied: floats, and the exact texts."""
    names = sweep.plan.names
    return {
        "values": {name: value.number for name, value in zip(names, point, strict=True)},
        "exact": {"values": {name: str(value.entry) for name, value in zip(names, point, strict=True)}},
    }


def _row_record(sweep: Sweep, k: int, outcome: Outcome) -> Record:
    values = _values(sweep, sweep.plan.point(k))
    return {**values, **outcome, "exact": {**values["exact"], **outcome["exact"]}}


def _border_record(sweep: Sweep, border: Border) -> Record:
    said = {"before": border.before, "there": border.there, "after": border.after}
    return {
        "path": sweep.plan.names[border.axis],
        **_values(sweep, border.point),
        "between": [border.below.number, border.above.number],
        "changed": list(border.changed),
        **{when: dict(zip(border.questions, answers, strict=True)) for when, answers in said.items()},
    }


def _cell_record(sweep: Sweep, cell: CertifiedCell) -> Record:
    sides = dict(zip(sweep.plan.names, cell.sides, strict=True))
    numbers = {"ends_within": cell.ends_within, "starts_within": cell.starts_within}
    return {
        "between": {name: [low.number, high.number] for name, (low, high) in sides.items()},
        "verdict": str(cell.verdict),
        **{key: None if value is None else float(value) for key, value in numbers.items()},
        "why": cell.why or None,
        "exact": {
            "between": {name: [str(low.entry), str(high.entry)] for name, (low, high) in sides.items()},
            **{key: str(value) for key, value in numbers.items() if value is not None},
        },
    }


def _cells_text(cells: Sequence[CertifiedCell]) -> str:
    """``12 of 16 cells are certified as a whole``, and from where and how near bodies end in all of these."""
    certified = [cell for cell in cells if cell.verdict is Certainty.CERTIFIED]
    said = f"{len(certified)} of {len(cells)} cells of the grid are certified as a whole"
    ends = [cell.ends_within for cell in certified if cell.ends_within is not None]
    starts = [cell.starts_within for cell in certified if cell.starts_within is not None]
    if not ends:
        return said
    start = f"within {lower_text(min(starts), 4)} of" if len(starts) == len(ends) else "close to"
    return f"{said}: every body that starts {start} the point ends within {at_most(max(ends))} of it, or nearer"


def _worst(outcome: Outcome) -> Record:
    """The worst failure of a scene, for its row."""
    worst = next((failure for failure in outcome.get("failures", ()) if failure["worst"]), None)
    keys = {name: f"worst failure {name}" for name in FAILURE}
    if worst is None:
        return {"worst failure": None, **dict.fromkeys(keys.values())}
    name = f"wheel {worst['wheel']} {worst['failure']}"
    return {"worst failure": name, **{keys[name]: worst[name] for name in FAILURE}}


# ---- text ----------------------------------------------------------------------------------------


def _answers_table(sweep: Sweep) -> Block:
    failures = any("failures" in outcome for outcome in sweep.outcomes)
    titles = list(map(title_of, sweep.questions))
    shorts = [_short_name(name, titles) for name in sweep.plan.names]
    rates = _known_numbers(sweep) if len(shorts) == 1 else ()  # two numbers that vary leave no room for them
    header = [
        *shorts,
        *titles,
        *(["worst failure"] if failures else [HEADERS.get(name, name) for name in rates]),
    ]
    rows = []
    for k, outcome in enumerate(sweep.outcomes[:MOST_SHOWN]):
        entries = [str(value.entry) for value in sweep.plan.point(k)]
        answers = [outcome[name] for name in sweep.questions]
        more = ["" if outcome[name] is None else float_text(outcome[name], 4) for name in rates]
        if failures:
            worst = _worst(outcome)
            name = worst["worst failure"]
            more = ["" if name is None else f"{name}: {worst['worst failure position']}"]
        rows.append([*entries, *answers, *more])
    widest = titles[min(2, len(titles) - 1)]
    return table(header, rows, tuple(2.0 if name == widest else 1.0 for name in header))


def _short_name(name: str, taken: Sequence[str]) -> str:
    """The last part of a key path; all of it where a wheel is named, or where an answer has that name."""
    last = name.rpartition(".")[2]
    if name.startswith("wheel"):
        return name
    return name.replace(".", " ") if last in taken else last


def _known_numbers(sweep: Sweep) -> tuple[str, ...]:
    """The numbers beside the answers that some scene has."""
    names: Sequence[str] = SHOWN_NUMBERS  # of arrays: how fast, unless tolerances vary or bodies come near
    if sweep.base.is_system:
        names = SYSTEM_NUMBERS
    elif any(name.startswith("tolerance.") for name in sweep.plan.names):
        names = tuple(TOLERANCE_NUMBERS)
    elif any(outcome["position"] == Position.COMES_NEAR for outcome in sweep.outcomes):
        names = NEAR_NUMBERS
    return tuple(name for name in names if any(outcome[name] is not None for outcome in sweep.outcomes))


def _borders_blocks(sweep: Sweep) -> Iterator[Block]:
    """Where the answers change."""
    if sweep.borders is None:
        return
    if not sweep.borders:
        yield from sentences("no answer changes along the edges of the grid")
        return
    shown = [(border, name) for border in sweep.borders[:MOST_SHOWN] for name in border.changed]
    rows = [(_place(sweep, border), title_of(name), border_text(border, name)) for border, name in shown]
    yield from sentences("where the answers change (each border within 1e-9):")
    yield table(("border", "question", "answer"), rows, (1.0, 1.0, 2.0))
    left = len(sweep.borders) - MOST_SHOWN
    if left > 0:
        yield from sentences(f"{left} more borders (--json lists them)")


def _place(sweep: Sweep, border: Border) -> str:
    """``friction.mu_side = 1, wheel.1.position.x = 1/2``; what lies between two long fractions as a decimal."""
    values = zip(sweep.plan.names, border.point, strict=True)
    return ", ".join(f"{name} = {_short(str(value.entry), value.number)}" for name, value in values)


def _short(text: str, number: float | None) -> str:
    return text if number is None or len(text) <= 12 else f"{number:.10g}"
