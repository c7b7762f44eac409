"""The paper's kinematics against the derivation: equations (3) and (4), and Theorem 4's displays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.partition import Cell
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.reports.document import Entry, Math, display, point, table
from nonsmooth.reports.papers.murphey_burdick_2001.finding import ClaimOutcome, Finding
from nonsmooth.reports.papers.murphey_burdick_2001.pair_equations import pair_equations
from nonsmooth.reports.papers.murphey_burdick_2001.printed_equations import (
    equation_3,
    equation_4,
    plane_symbols,
    theorem_4_kinematics,
    theorem_4_rate,
)
from nonsmooth.reports.prose import paragraph, prose

if TYPE_CHECKING:
    import sympy


@dataclass(frozen=True)
class Comparison:
    """A printed field and the derived twist on one cell."""

    equation: int
    cell: Cell
    agrees: bool


def compare_cells(result: CellCheck, equation: int) -> list[Comparison]:
    """Eq. (3) or (4), evaluated at an interior point of every cell, against the cell's twist; exact."""
    printed = equation_3() if equation == 3 else equation_4()
    return [Comparison(equation, cell, _agrees(printed, cell)) for cell in result.partition.cells]


def _agrees(printed: sympy.Matrix, cell: Cell) -> bool:
    import sympy

    values = dict(zip(plane_symbols(), (entry.to_sympy() for entry in cell.polygon.centre), strict=True))
    derived = (entry.to_sympy() for entry in cell.twists[0])
    return all(sympy.expand(p - d) == 0 for p, d in zip(printed.subs(values), derived, strict=True))


def audit_equations_3_and_4(roll: CellCheck, side: CellCheck) -> Finding:
    """Finding 1: eqs. (3) and (4), cell by cell.

    Args:
        roll: the four-wheel array with ``mu_S < mu_R``.
        side: the same with ``mu_S > mu_R``.
    """
    comparisons = compare_cells(side, 3) + compare_cells(roll, 4)
    equal = sum(comparison.agrees for comparison in comparisons)
    header = ("equation", "rows held", "at c", prose("`xi = (v, omega)`"), "printed field")
    return Finding(
        1,
        "Equations (3) and (4)",
        ClaimOutcome.CONFIRMED if equal == len(comparisons) else ClaimOutcome.REFUTED,
        prose("the motion of the four-wheel array is eq. (3) for `mu_S > mu_R` and eq. (4) for `mu_S < mu_R`."),
        (table(header, [_comparison_row(comparison) for comparison in comparisons], (1.9, 2, 3, 4, 2)),),
        prose(
            "{} of {} cells agree exactly, as spatial twists under the rule of sec. 3.1. The pose rate of the "
            "centre of mass has the extra term `omega J c`; it does not change V' of `|c|^2`, because `c . J c "
            "= 0`.",
            str(equal),
            str(len(comparisons)),
        ),
    )


def _comparison_row(comparison: Comparison) -> tuple[Entry, ...]:
    cell = comparison.cell
    return (
        f"({comparison.equation})",
        cell.states[0].name,
        point(cell.polygon.centre),
        point(cell.twists[0]),
        "equal" if comparison.agrees else "different",
    )


@dataclass(frozen=True)
class Theorem4Identities:
    """Whether Theorem 4's displays are identities in all symbols.

    Attributes:
        kinematics: the displayed kinematics equal the derived ones.
        rate_ratio: derived V' divided by the displayed one; a number where the display is right but for a factor.
    """

    kinematics: bool
    rate_ratio: sympy.Expr


def theorem_4_identities() -> Theorem4Identities:
    """Compare the derived pair equations with Theorem 4's displays, for every geometry."""
    import sympy

    pair = pair_equations()
    differences = pair.paper_form() - theorem_4_kinematics()
    ratio = sympy.cancel(sympy.together(pair.paper_rate()) / sympy.together(theorem_4_rate()))
    return Theorem4Identities(all(sympy.cancel(entry) == 0 for entry in differences), ratio)


def audit_theorem_4_displays() -> Finding:
    """Finding 6: the kinematics and V' in the proof of Theorem 4."""
    identities = theorem_4_identities()
    confirmed = identities.kinematics and identities.rate_ratio.is_number
    reading = display(
        r"d_i = -(\cos\theta, \sin\theta), \qquad d_j = -p_2 / \lvert p_2 \rvert, \qquad"
        r" u_j = \lvert p_2 \rvert \times \text{speed of wheel } j",
        "d_i = -(cos theta, sin theta), d_j = -p_2/|p_2|, u_j = |p_2| times the speed of wheel j",
    )
    ratio = Math(str(identities.rate_ratio), str(identities.rate_ratio)) if confirmed else "not constant"
    computed = (
        paragraph(
            "The rows of wheel i (index 1) and the roll row of wheel j (index 2) were solved by cofactors with "
            "symbolic positions, headings and speeds, then read as follows, with the sign of eq. (2):"
        ),
        reading,
        paragraph(
            "In all symbols, the displayed kinematics {} the derived one. Derived V' divided by displayed V' is {}.",
            "equals" if identities.kinematics else "does not equal",
            ratio,
        ),
    )
    conclusion = prose("the displays do not follow from the constraints in this reading.")
    if confirmed:
        conclusion = prose(
            "the kinematics hold when theta inside cos and sin is the rim angle of wheel i, not the "
            "orientation of the body, and when `u_j` stands for the speed times `|p_2|`. The displayed V' is "
            "to be multiplied by {} (it is that of `V/2`); in it, theta stands for both angles.",
            ratio,
        )
    return Finding(
        6,
        "Theorem 4's displays",
        ClaimOutcome.CORRECTED if confirmed else ClaimOutcome.REFUTED,
        prose("the governing equations of a pair (i, j) and V' of `V = x^2 + y^2 + theta^2`."),
        computed,
        conclusion,
    )
