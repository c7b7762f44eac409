"""The feedback clause in the derivation report: the law, why it works, and the sign it needs in every cell."""

from __future__ import annotations

from nonsmooth.proofs.clauses.authority import Authority
from nonsmooth.proofs.clauses.control_lyapunov import SQUARES, ControlLyapunov
from nonsmooth.proofs.clauses.feedback import FeedbackResult
from nonsmooth.proofs.clauses.input_cell import InputCell
from nonsmooth.proofs.clauses.input_margin import InputMargin
from nonsmooth.proofs.clauses.sampled_feedback import SampledFeedback
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.reports.document import (
    Block,
    Entry,
    Math,
    Paragraph,
    Table,
    cell_mark,
    display,
    matrix,
    number,
    point,
    table,
)
from nonsmooth.reports.prose import listed, paragraph, prose
from nonsmooth.symbolic.scene import dot

_SIGNS = {1: Math("+", "+"), -1: Math("-", "-"), 0: Math("0", "0")}


def feedback_blocks(feedback: FeedbackResult | SampledFeedback, authority: Authority) -> tuple[Block, ...]:
    """Reason, law, witness, table of cells or samples, and torque authority, as far as there are any."""
    blocks: list[Block] = [paragraph("Reason: {}.", feedback.reason)]
    if isinstance(feedback, FeedbackResult) and feedback.verdict is Feedback.STABILIZABLE:
        blocks += _law_blocks() if feedback.lyapunov == SQUARES else _shaped_law_blocks(feedback)
    if feedback.witness is not None:
        words = "Witness: `c` = {} and `theta` = {} ({})."
        witness = feedback.witness
        blocks.append(paragraph(words, point(witness.point), number(witness.value), witness.meaning))
    if isinstance(feedback, SampledFeedback):
        blocks += _sample_blocks(feedback)
    else:
        blocks += _sign_blocks(feedback)
    missing = listed([point(twist) for twist in authority.missing])
    shown = prose("no twist is missing") if not missing else (*prose("missing twists `xi = (v, omega)`: "), *missing)
    rank = prose("Torque authority: the roll rows have rank {} of 3 at the checked point; ", str(authority.rank))
    return (*blocks, Paragraph((*rank, *shown, ".")))


def _sign_blocks(feedback: FeedbackResult) -> list[Block]:
    blocks: list[Block] = []
    if feedback.rate is not None:
        kappa = feedback.rate.kappa
        bound = f"-{float(2 * kappa):.4g}"
        formula = Math(rf"\dot V \le {bound}\, k V", f"V' <= {bound} k V")
        blocks.append(paragraph("Certified on every closed cone at the equilibrium: {}.", formula))
    if feedback.margin is not None:
        blocks += _margin_blocks(feedback.margin)
    if feedback.cells:
        blocks.append(_cell_table(feedback))
    failing = ", ".join(str(index) for index in feedback.printed_sign_fails)
    if failing:
        blocks.append(paragraph("The paper's `u_j = -k theta` (sec. 3.3) has the wrong sign in the cells {}.", failing))
    return blocks


def _margin_blocks(margin: InputMargin) -> list[Block]:
    """Side by side, up to which error in c one input serves both cells."""
    header = ("side of the cells", "one input serves both within this part of the distance")
    rows = [(f"{side.cells[0]}, {side.cells[1]}", f"{float(side.squared) ** 0.5:.4g}") for side in margin.sides]
    return [paragraph("{}.", str(margin).capitalize()), table(header, rows, (2, 4))]


def _sample_blocks(feedback: SampledFeedback) -> list[Block]:
    if not feedback.laws:
        return []
    rows: list[tuple[Entry, ...]] = []
    for sample in feedback.laws:
        state = listed([Math(x, x) for x in (f"{value:.4g}" for value in sample.worst_state)])
        rate = f"{sample.worst_rate:.4g}"
        rows.append((str(sample.law), str(sample.states), Math(f"{rate}\\, k", f"{rate} k"), state))
    header = ("law", "states", prose("largest `V'/V` found"), "at (x, y, theta)")
    return [paragraph("Sampled, not proved, with gain `k`:"), table(header, rows, (3, 1.5, 3, 4))]


def _law_blocks() -> list[Block]:
    law = display(
        r"u_i = -k a, \qquad u_j = -k b, \qquad b = \frac{\theta - c \cdot J p_i}{d_j \cdot J(p_j - p_i)},"
        r" \qquad a = c \cdot d_i - (d_i \cdot d_j)\, b",
        "u_i = -k a, u_j = -k b, b = (theta - c . J p_i)/(d_j . J(p_j - p_i)), a = c . d_i - (d_i . d_j) b",
    )
    rate = display(
        r"V = \lvert c \rvert^2 + \theta^2, \qquad \tfrac12 \dot V = a u_i + b u_j = -k (a^2 + b^2)",
        "V = |c|^2 + theta^2, V'/2 = a u_i + b u_j = -k (a^2 + b^2)",
    )
    why = paragraph(
        "The two coefficients vanish together only where `c . d_i = 0`; the table shows that this product has "
        "one strict sign on each closed cell at the equilibrium."
    )
    return [law, rate, why]


def _shaped_law_blocks(feedback: FeedbackResult) -> list[Block]:
    (e, f), w = feedback.lyapunov.shape, feedback.lyapunov.weight
    exact = feedback.cells[0].cell.twists[0].omega.field
    law = display(
        r"\begin{gathered} u_i = -k a, \qquad u_j = -k b, \\ b = \frac{w \theta - P c \cdot J (p_i - c)}"
        r"{d_j \cdot J(p_j - p_i)}, \qquad a = P c \cdot d_i - (d_i \cdot d_j)\, b \end{gathered}",
        "u_i = -k a, u_j = -k b, b = (w theta - P c . J(p_i - c))/(d_j . J(p_j - p_i)), a = P c . d_i - (d_i . d_j) b",
    )
    rate = display(
        r"V = c^T P c + w \theta^2, \qquad \tfrac12 \dot V = a u_i + b u_j = -k (a^2 + b^2)",
        "V = c^T P c + w theta^2, V'/2 = a u_i + b u_j = -k (a^2 + b^2)",
    )
    shape = matrix([[exact(1 + e), exact(f)], [exact(f), exact(1 - e)]])
    values = paragraph("With `P` = {} and `w` = {}:", shape, number(exact(w)))
    why = paragraph(
        "The two coefficients vanish together only where `c^T P d_i = 0`, and no closed cell at the equilibrium holds "
        "such a point; for `P = I` some cell does."
    )
    return [values, law, rate, why]


def _cell_table(feedback: FeedbackResult) -> Table:
    squares = feedback.lyapunov == SQUARES
    header = (
        "cell",
        prose("`i`"),
        prose("`j`"),
        prose("sign of `u_j` that turns `theta > 0` back"),
        prose("signs of `c . d_i` at the vertices" if squares else "signs of `c^T P d_i` at the vertices"),
    )
    marks = [(cell_mark(data.cell.index),) for data in feedback.cells]
    rows = [_cell_row(data, feedback.lyapunov) for data in feedback.cells]
    return table(header, rows, (1.2, 1, 1, 4, 4), marks)


def _cell_row(data: InputCell, lyapunov: ControlLyapunov) -> tuple[Entry, ...]:
    needed = _SIGNS[-data.torque_sign] if data.torque_sign else "none: side row"
    slopes = [dot(lyapunov.slope(vertex), data.nearest.direction) for vertex in data.cell.polygon.vertices]
    signs = listed([_SIGNS[slope.sign()] for slope in slopes])
    return str(data.cell.index), str(data.nearest.index), str(data.second.index), needed, signs
