"""A design on a terminal and as JSON: what was required, what was found, and how it compares with the given array."""

from __future__ import annotations

from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.facts import fact_record
from nonsmooth.reports.terminal import header_table, verdict_text
from nonsmooth.symbolic.number_text import float_text
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from nonsmooth.reports.designs.objective import Evaluation
    from nonsmooth.reports.designs.search import Design, Fewest, Wish

SCHEMA = "nonsmooth-design/1"
WHAT = {
    "rate": "how fast bodies come home",
    "gain": "kappa, how fast feedback holds the pose",
    "margin": "the part of the distance by which feedback may misjudge the position",
    "basin": "radius of the disc whence bodies come home",
    "tolerance": "the multiple of the tolerances that is certified",
}


def design_view(design: Design, wish: Wish) -> RenderableType:
    """The outcome, both arrays side by side, and the wheels that were found."""
    parts: list[RenderableType] = [Text(headline(design, wish))]
    answers = header_table("question", "the given array", "the best found", widest="the best found")
    for before, after in zip(design.base.answers, design.best.answers, strict=False):
        answers.add_row(before.name, verdict_text(before.verdict), Text(f"{after.verdict}: {after.sentence}"))
    answers.add_row(WHAT[wish.maximize], _value(design.base), _value(design.best))
    parts.append(answers)
    if design.best.why_not:
        parts.append(Text(f"the best is refused: {design.best.why_not}"))
    if design.fewest is not None:
        return Group(*parts, _wheels(design), Text(_fewest_words(design.fewest)))
    parts += [_wheels(design), Text("every candidate is exact and its answers are proved; that none is better is not")]
    return Group(*parts)


def headline(design: Design, wish: Wish) -> str:
    """What was found, in a line."""
    name = one_line(design.scene.name)
    if design.impossible:
        return f"{name}: no speeds meet the requirements: {design.impossible}"
    asked = ", ".join(wish.required)
    if design.is_found:
        return f"{name}: found an array with {asked} among {design.checks} checked"
    missing = ", ".join(design.best.unmet)
    return f"{name}: none of {design.checks} arrays meets all of {asked}; the nearest lacks {missing}"


def _fewest_words(fewest: Fewest) -> str:
    """What is proved of smaller choices."""
    if not fewest.all_checked:
        return "not all choices were checked (--checks allows more)"
    which = "no choice" if fewest.count is None else f"no choice of fewer than {fewest.count}"
    which += " of the wheels under the body"
    if fewest.order > 1:
        which += f" that keeps its symmetry (turns by 1/{fewest.order})"
    if fewest.undecided:
        return f"{which} is known to suffice; {fewest.undecided} choices are undecided, all others are refuted"
    return f"{which} suffices: all were checked and refuted"


def _value(found: Evaluation) -> str:
    return "-" if found.value is None else float_text(found.value, 4)


def _wheels(design: Design) -> RenderableType:
    table = header_table("wheel", "position", "heading", "speed", widest="position")
    for wheel in design.scene.wheels:
        x, y = (float_text(float(entry), 4) for entry in wheel.position)
        a, b = (float_text(float(entry), 4) for entry in wheel.unit_direction)
        table.add_row(str(wheel.index), f"({x}, {y})", f"({a}, {b})", float_text(float(wheel.speed), 4))
    return table


def design_record(design: Design, wish: Wish) -> Record:
    """JSON: what was asked, both arrays, and the document of the best."""
    return {
        "schema": SCHEMA,
        "required": list(wish.required),
        "maximize": wish.maximize,
        "seed": wish.seed,
        "checks": design.checks,
        "found": design.is_found,
        "impossible": design.impossible or None,
        "fewest": None if design.fewest is None else vars(design.fewest),
        "given": _evaluation(design.base),
        "best": _evaluation(design.best),
        "scene": design.document if not design.impossible else None,
    }


def _evaluation(found: Evaluation) -> Record:
    answers = {answer.name: {"verdict": str(answer.verdict), **fact_record(answer.facts)} for answer in found.answers}
    return {"value": found.value, "unmet": list(found.unmet), "why_not": found.why_not or None, "answers": answers}
