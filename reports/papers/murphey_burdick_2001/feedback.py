"""The printed feedback law ``u_j = -k theta, u_i = |u_j| + k|c|`` cell by cell, and the proof of the corrected one."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.reports.document import Block, Code, Entry, display, number, table
from nonsmooth.reports.papers.murphey_burdick_2001.finding import ClaimOutcome, Finding
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import dot, turned


@dataclass(frozen=True)
class CorrectedLaw:
    """The law ``u_j = -g k theta, u_i = |u_j| + k|c|`` in one cell with ``d_i . d_j = 0``, and the proof of its rate.

    With ``g = sgn Delta``, ``m = -c . d_i`` and ``w = c . J p_i/|Delta|``::

        -V'/(2k) = m |c| + m |theta| + theta^2/|Delta| - theta w   >=   kappa (|c|^2 + theta^2)

    follows from ``m >= kappa |c|`` (m - kappa |c| is concave, so the rays of the cell decide), ``1/|Delta| >= kappa``
    and ``m >= |w|`` (m - |w| is concave as well).

    Attributes:
        data: cell, wheels and lever.
        lever: ``Delta = d_j . J(p_j - p_i)``.
        rays: directions that generate the closed cell as a cone.
        forward: m on the rays.
        arms: w on the rays.
    """

    data: InputCell
    lever: Number
    rays: tuple[Point, ...]
    forward: tuple[Number, ...]
    arms: tuple[Number, ...]

    def proves(self, kappa: Number) -> bool:
        """Whether ``V' <= -2 kappa k V`` on the closed cell, for every theta."""
        attracts = all(
            m.sign() >= 0 and m * m >= kappa * kappa * dot(ray, ray)
            for m, ray in zip(self.forward, self.rays, strict=True)
        )
        turns = all(m >= abs(w) for m, w in zip(self.forward, self.arms, strict=True))
        return attracts and turns and bool(kappa * abs(self.lever) <= 1)


def corrected_law(data: InputCell) -> CorrectedLaw:
    """The data of the corrected law in one cell.

    Raises:
        ValueError: unless the third row is a roll row of a wheel with a rim at right angles to that of wheel i.
    """
    fields = data.state.control_fields
    if data.lever is None or fields[data.nearest.index][2]:
        raise ValueError("required d_i . d_j = 0 and a roll row in third place")
    lever = data.lever / data.second.length
    rays = tuple(vertex for vertex in data.cell.polygon.vertices if any(vertex))
    forward = tuple(-dot(ray, data.nearest.unit_direction) for ray in rays)
    arms = tuple(dot(ray, turned(data.nearest.position)) / abs(lever) for ray in rays)
    return CorrectedLaw(data, lever, rays, forward, arms)


def audit_feedback(roll: CellCheck) -> Finding:
    """Finding 5: the printed feedback law, cell by cell, and the corrected one."""
    if not isinstance(roll.feedback, FeedbackResult):
        raise ValueError("required a check under rule nearest, received sampled feedback")
    laws = [corrected_law(data) for data in roll.feedback.cells]
    kappa = roll.partition.scene.field.sqrt(2) / 2
    proved = all(law.proves(kappa) for law in laws)
    wrong = [str(law.data.cell.index) for law in laws if law.lever.sign() < 0]
    outcome = ClaimOutcome.CONFIRMED if not wrong else ClaimOutcome.CORRECTED
    words = "`u_j = -k theta` has the wrong sign in {} of the {} cells ({}). With the sign of `Delta` the law gives "
    words += "`V' <= -sqrt(2) k V` on every closed cell." if proved else "no proved rate."
    return Finding(
        5,
        "The printed feedback law",
        outcome if proved else ClaimOutcome.REFUTED,
        prose("`u_i = |u_j| + k |(x, y)|` and `u_j = -k theta` stabilize the array for `mu_S < mu_R`."),
        (
            paragraph("In each cell `d_i . d_j = 0`, so `theta' = u_j/Delta` with `Delta = d_j . J(p_j - p_i)`:"),
            _law_table(laws, kappa),
            *_proof(kappa),
        ),
        prose(words, str(len(wrong)), str(len(laws)), ", ".join(wrong) or "none"),
    )


def _law_table(laws: list[CorrectedLaw], kappa: Number) -> Block:
    header = (
        "cell",
        prose("`i`"),
        prose("`j`"),
        prose("`Delta`"),
        prose("printed law, `theta > 0`"),
        "corrected law, the bound below",
    )
    return table(header, [_law_row(law, kappa) for law in laws], (1.2, 1, 1, 2, 4, 4))


def _law_row(law: CorrectedLaw, kappa: Number) -> tuple[Entry, ...]:
    return (
        str(law.data.cell.index),
        str(law.data.nearest.index),
        str(law.data.second.index),
        number(law.lever),
        prose("`theta' < 0`: back") if law.lever.sign() > 0 else prose("`theta' > 0`: away"),
        "proved" if law.proves(kappa) else "not proved",
    )


def _proof(kappa: Number) -> tuple[Block, ...]:
    split = display(
        r"-\tfrac{1}{2k} \dot V = m \lvert c \rvert + m \lvert \theta \rvert + \frac{\theta^2}{\lvert \Delta \rvert}"
        r" - \theta w, \qquad m = -c \cdot d_i, \quad w = \frac{c \cdot J p_i}{\lvert \Delta \rvert}",
        "-V'/(2k) = m |c| + m |theta| + theta^2/|Delta| - theta w, m = -c . d_i, w = c . J p_i/|Delta|",
    )
    return (
        paragraph("With `u_j = -sgn(Delta) k theta` and `V = x^2 + y^2 + theta^2`:"),
        split,
        paragraph(
            "On the rays of each closed cell `m >= kappa |c|`, `m >= |w|` and `1/|Delta| >= kappa` with "
            "`kappa` = {}, checked exactly; the differences are concave, so they are not negative on the whole "
            "cell.",
            number(kappa),
        ),
    )


def law_of_section_3_3() -> list[Block]:
    """For the section on feedback laws: the law of sec. 3.3 with the signs that its own proof needs."""
    law = display(
        r"u_j = -\operatorname{sgn}(\Delta)\, k \theta, \qquad u_i = \lvert u_j \rvert + k \lvert (x, y) \rvert,"
        r" \qquad \Delta = d_j \cdot J(p_j - p_i)",
        "u_j = -sgn(Delta) k theta, u_i = |u_j| + k |(x, y)|, Delta = d_j . J(p_j - p_i)",
    )
    words = paragraph(
        "The paper (sec. 3.3) takes another law for this array. There `theta' = u_j/Delta`, so the sign of `u_j` must "
        "follow that of `Delta`; with it, {} follows the law, which the audit below proves for this array:",
        Code("nonsmooth simulate --feedback --law corrected"),
    )
    return [words, law]
