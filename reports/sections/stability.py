"""Sections of the derivation report on stability: Filippov set, upper derivative, the clauses of Theorem 4."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from flint import arb

from nonsmooth.analysis.cells.filippov import CellDerivative
from nonsmooth.proofs.clauses.clause import Clause
from nonsmooth.proofs.clauses.equilibrium.clause import EquilibriumResult
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.rotation.clause import RotationResult
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.clauses.workspace import ClauseResult
from nonsmooth.proofs.findings import Equilibrium, Fact, Translation
from nonsmooth.proofs.theorem4 import CellCheck, Check
from nonsmooth.reports.checks.cells import CellsResult
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Entry,
    Figure,
    Inline,
    Paragraph,
    Section,
    cell_mark,
    column,
    display,
    number,
    point,
    table,
)
from nonsmooth.reports.output.prose import listed, paragraph, prose, with_formulas
from nonsmooth.reports.output.study_options import Drawing
from nonsmooth.reports.sections.feedback import feedback_blocks
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text


def filippov_section(result: CellCheck) -> Section:
    """The twists that meet at the checked point."""
    general = display(
        r"F(c) = \operatorname{co} \{ \dot c \text{ of every cell whose closure holds } c \}",
        "F(c) = co { c' of every cell whose closure holds c }",
    )
    cells = [_cells_of(result, twist) for twist in result.equilibrium.twists]
    rows = [
        (", ".join(str(index) for index in indices), point(twist.velocity), number(twist.omega))
        for indices, twist in zip(cells, result.equilibrium.twists, strict=True)
    ]
    words = paragraph("Values on the boundaries of cells are ignored. At the checked point these motions meet:")
    marks = [tuple(cell_mark(index) for index in indices) for indices in cells]
    meeting = table(("cells", prose("`v`"), prose("`omega`")), rows, (2, 5, 3), marks)
    return Section("Filippov set", (general, words, meeting))


def _cells_of(result: CellCheck, twist: Twist) -> list[int]:
    meeting = result.partition.meeting
    return [cell.index for cell in meeting if twist in cell.twists]


def lyapunov_section(subject: ArraySubject) -> Section:
    """V* on every closed cell, as a table and a heat map."""
    result = subject.cells
    general = display(
        r"\dot V^*(c) = \max_{f \in F(c)} \nabla V \cdot f, \qquad \nabla V \cdot \dot c = 2\, c \cdot v"
        r" \quad \text{on a cell, because } c \cdot J c = 0",
        "V*(c) = max over f in F(c) of grad V . f; on a cell grad V . c' = 2 c . v, because c . J c = 0",
    )
    intro = paragraph(
        "With `V = |c - c*|^2` this is linear on each closed cell, so its sign is decided at the vertices, exactly. "
        "The last column is the supremum of `V*/|c|` on the cell."
    )
    if result.translation.lemma is not None:
        lemma = "All wheels lie on one circle about the point with rims inward, so `V* <= 0` on the whole square."
        intro = Paragraph((*intro.text, " ", *prose(lemma)))
    header = ("cell", prose("`v`"), prose("`V*` at the vertices"), "supremum")
    derivatives = result.translation.derivatives
    rows = [_derivative_row(derivative) for derivative in derivatives]
    listing = table(header, rows, (1.2, 4, 5.8, 2.7), [(cell_mark(d.cell.index),) for d in derivatives])
    where = "On the whole square" if result.partition.complete else "On these cells"
    worst = paragraph(where + " the supremum of `V*/|c|` is {}.", number(result.translation.worst_rate))
    return Section("Upper derivative", (general, intro, _rate_map(subject), listing, worst))


def _rate_map(subject: ArraySubject) -> Figure:
    return Figure(
        "rate-map",
        prose("The upper derivative `V*` over the cells; where it is negative, `V` falls along every solution."),
        "Heat map of V* over the cells of the checked square.",
        subject.invocation.line("partition", "--show", "rates", "-o", "rates.pdf"),
        CellsResult(subject.cells.partition, Drawing.RATES).content,
    )


def _derivative_row(derivative: CellDerivative) -> tuple[Entry, ...]:
    rates = listed([number(rate) for rate in derivative.rates])
    supremum = number(derivative.relative().value)
    return str(derivative.cell.index), point(derivative.twist.velocity), rates, supremum


def equilibria_section(result: CellCheck) -> Section:
    """Every equilibrium of the square, where they were searched for."""
    if result.others is None:
        return Section("Equilibria of the square", (paragraph("Other equilibria were not searched for."),))
    if not result.others:
        return Section("Equilibria of the square", (paragraph("There is none."),))
    rows: list[tuple[Entry, ...]] = [
        (
            str(judged.found.place),
            listed([point(p) for p in judged.found.points]),
            ", ".join(str(cell) for cell in judged.found.cells),
            "" if judged.translation is None else str(judged.translation),
            "" if judged.rotation is None else str(judged.rotation),
        )
        for judged in result.others
    ]
    words = paragraph("Points with zero velocity in the Filippov set of the exact kinematics, all of them:")
    return Section(
        "Equilibria of the square",
        (words, table(("where", "points", "cells", "(x, y)", "theta"), rows, (2, 3, 2, 2, 2))),
    )


def theorem_section(result: Check) -> Section:
    """The clauses with certificate or witness, and the conclusion."""
    clauses = tuple(
        Section(f"Clause {count}, {clause.name}: {found.verdict}", _clause_blocks(result, clause, found))
        for count, (clause, found) in enumerate(result.clauses, 1)
    )
    conclusion = Section(
        f"Conclusion: {result.verdict}", (Paragraph(("Because ", *with_formulas(result.reason), ".")),)
    )
    return Section("Theorem 4, clause by clause", (), (*clauses, conclusion))


def _clause_blocks(result: Check, clause: Clause[Any], found: ClauseResult) -> tuple[Block, ...]:
    """Reason and facts of a clause, then its evidence as formulas and tables where this report explains it."""
    said: list[Block] = [Paragraph(("Reason: ", *with_formulas(found.reason), ".")), *fact_list(result.facts(clause))]
    return (*said, *_explanation(found, result))


def _explanation(found: ClauseResult, result: Check) -> tuple[Block, ...]:
    match found:
        case EquilibriumResult():
            return _equilibrium_blocks(found)
        case TranslationResult():
            return _translation_blocks(found)
        case RotationResult():
            return _rotation_blocks(found)
        case FeedbackResult() | DrivenFeedback():
            return feedback_blocks(found, result.authority, result.scene)
        case _:
            return ()


def _equilibrium_blocks(equilibrium: EquilibriumResult) -> tuple[Block, ...]:
    if equilibrium.verdict is Equilibrium.HOLDS:
        rows = [(point(equilibrium.twists[k].velocity), number(w)) for k, w in equilibrium.weights.items()]
        words = paragraph("These convex weights give velocity zero, so 0 lies in `F(c*)`:")
        return words, table((prose("`v`"), "weight"), rows, (3, 1))
    if equilibrium.separator is None:
        return ()
    separator = column(equilibrium.separator)
    words = paragraph(
        "This vector has a positive product with every velocity that meets there, so 0 is not in `F(c*)`:"
    )
    return words, display(separator.latex, separator.plain)


def _translation_blocks(translation: TranslationResult) -> tuple[Block, ...]:
    blocks: list[Block] = []
    if translation.region_radius is not None:
        relation = "`V* < 0`" if translation.verdict is Translation.ASYMPTOTICALLY_STABLE else "`V* <= 0`"
        region = relation + " on the disc of radius {} about the checked point, but at the point itself."
        blocks.append(paragraph(region, number(translation.region_radius)))
    if translation.support_note:
        blocks.append(paragraph("Here {}.", translation.support_note))
    decay = translation.decay_rate
    if decay is not None:
        bound = display(
            rf"\dot V^* \le -\kappa \lvert c \rvert, \quad \kappa = {number(decay).latex}, \quad"
            r" \text{so } c \text{ arrives within } 2 \lvert c_0 \rvert / \kappa",
            f"V* <= -kappa |c|, kappa = {number(decay).plain}, so c arrives within 2 |c_0|/kappa",
        )
        blocks.append(bound)
    if translation.witness is not None:
        words, witness = "Witness: at `c` = {} the upper derivative `V*` is {} ({}).", translation.witness
        blocks.append(paragraph(words, point(witness.point), number(witness.value), witness.meaning))
    if translation.fan is not None:
        blocks += _fan_blocks(translation.fan)
    return tuple(blocks)


def _fan_blocks(fan: FanResult) -> list[Block]:
    """What the cones around the point decide where V does not."""
    said = paragraph("The fan of the {} cones that meet at the point says: {}.", str(len(fan.cones)), fan.reason)
    if fan.squared_overshoot is None:
        return [said]
    growth = float_text(math.sqrt(float(fan.squared_overshoot)))
    return [said, paragraph("Near the point the distance of a solution grows at most {}-fold on its way.", growth)]


def _rotation_blocks(rotation: RotationResult) -> tuple[Block, ...]:
    invariance = paragraph(
        "No twist depends on `theta`, so `theta = 0` is never asymptotically stable. This alone does not prove "
        "that it is unstable; the drift decides: the range of `omega` over those members of `F(c*)` that leave "
        "`c` at rest."
    )
    if rotation.spin is not None:
        slowest, fastest = (float_text(float(end)) for end in rotation.spin)
        words = "At the place of rest, which is enclosed, it lies between {} and {}."
        return invariance, paragraph(words, slowest, fastest)
    if rotation.drift is None:
        return (invariance,)
    low, high = (number(end) for end in rotation.drift.interval)
    interval = display(rf"\omega \in \left[{low.latex},\ {high.latex}\right]", f"omega in [{low.plain}, {high.plain}]")
    ends = (("lowest", rotation.drift.lowest), ("highest", rotation.drift.highest))
    twists = rotation.drift.twists
    rows = [
        (name, point(twists[k].velocity), number(twists[k].omega), number(weight))
        for name, mixture in ends
        for k, weight in mixture.weights.items()
    ]
    bounds = paragraph(
        "No weights pass beyond: the multipliers `y` below satisfy `y . (v, 1) >= omega` for every twist (for "
        "the lowest end with `-omega`), and their last entry is the bound."
    )
    multipliers = [(name, point(mixture.multipliers)) for name, mixture in ends]
    return (
        invariance,
        interval,
        paragraph("Convex weights that leave `c` at rest and attain the ends:"),
        table(("end", prose("`v`"), prose("`omega`"), "weight"), rows, (2, 5, 3, 2)),
        bounds,
        table(("end", prose("`y`")), multipliers, (1, 5)),
    )


# ---- facts as sentences --------------------------------------------------------------------------


def fact_list(facts: Iterable[Fact]) -> list[Bullets]:
    """The sentences as a list of a report, with numbers as formulas; no list where there are none."""
    told = [fact for fact in facts if fact.words and not fact.explained]
    items = [prose(fact.words, *map(_entry, fact.shown)) for fact in told]
    return [Bullets(tuple(items))] if items else []


def _entry(shown: Any) -> Inline:
    if isinstance(shown, Number):
        return number(shown)
    return brief_text(shown) if isinstance(shown, Lazy | arb) else str(shown)
