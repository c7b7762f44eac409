"""The paper's stability arguments against the computation: V' of sec. 3.2, and the instability of theta."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.filippov import filippov_twists, upper_derivative_at
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.proofs.verdicts import Rotation
from nonsmooth.reports.document import Block, Entry, display, number, point, table
from nonsmooth.reports.papers.murphey_burdick_2001.finding import ClaimOutcome, Finding
from nonsmooth.reports.papers.murphey_burdick_2001.printed_equations import (
    equation_3,
    plane_symbols,
    rate_of_section_3_2,
)
from nonsmooth.reports.prose import paragraph, prose
from nonsmooth.symbolic.plane import dot

if TYPE_CHECKING:
    import sympy


def missing_factor() -> sympy.Expr:
    """V' of ``x^2 + y^2`` along eq. (3) divided by the V' that sec. 3.2 displays, in all symbols.

    Raises:
        ValueError: if the quotient is not constant.
    """
    import sympy

    x, y = plane_symbols()
    field = equation_3()
    ratio = sympy.cancel((2 * x * field[0] + 2 * y * field[1]) / rate_of_section_3_2())
    if not ratio.is_number:
        raise ValueError(f"required a constant quotient of the two rates, received {ratio}")
    return ratio


def rays(partition: Partition) -> dict[str, Point]:
    """One point on each half-axis and each half-diagonal, half-way to the sides of the square."""
    h = partition.scene.check.radius / 2
    zero = h - h
    axes = {"x > 0": (h, zero), "y > 0": (zero, h), "x < 0": (-h, zero), "y < 0": (zero, -h)}
    return axes | {"x = y > 0": (h, h), "-x = y > 0": (-h, h), "x = y < 0": (-h, -h), "x = -y > 0": (h, -h)}


def sign_sets(partition: Partition, place: Point) -> tuple[set[int], set[int], set[int]]:
    """Signs of x, y and ``y^2 - x^2`` inside the cells that meet at a point."""
    centres = [cell.polygon.centre for cell in partition.cells_at(place)]
    return (
        {x.sign() for x, _ in centres},
        {y.sign() for _, y in centres},
        {(y * y - x * x).sign() for x, y in centres},
    )


def rests(partition: Partition, place: Point) -> bool:
    """Whether 0 lies in the hull of the twists that meet at a point: then the body may rest all along its ray."""
    twists = filippov_twists(partition, place)
    return best_mixture(*mixtures_to_zero(twists), [partition.scene.field.zero] * len(twists)) is not None


def rate_is(partition: Partition, *, larger: bool) -> bool:
    """Whether ``V* = -2 sqrt2 max(|x|, |y|)`` (larger) or ``-2 sqrt2 min(|x|, |y|)`` on every closed cell.

    Both sides are linear on a cell whose interior holds no axis and no diagonal: then the vertices decide.
    """
    for cell in partition.cells:
        x, y = cell.polygon.centre
        if not (x.sign() and y.sign() and (y * y - x * x).sign()):
            return False
        for vertex in cell.polygon.vertices:
            sizes = sorted((abs(vertex[0]), abs(vertex[1])))
            expected = -2 * x.field.sqrt(2) * sizes[1 if larger else 0]
            if 2 * dot(cell.twists[0].velocity, vertex) != expected:
                return False
    return True


def audit_translation(roll: CellCheck, side: CellCheck) -> Finding:
    """Finding 2: V' and V* of sec. 3.2."""
    factor = str(missing_factor())
    confirmed = rate_is(side.partition, larger=False) and rate_is(roll.partition, larger=True)
    closed = display(
        r"\dot V^* = -2\sqrt2 \min(\lvert x \rvert, \lvert y \rvert) \text{ for (3)}, \qquad"
        r" \dot V^* = -2\sqrt2 \max(\lvert x \rvert, \lvert y \rvert) \text{ for (4)}",
        "V* = -2 sqrt(2) min(|x|, |y|) for (3), V* = -2 sqrt(2) max(|x|, |y|) for (4)",
    )
    computed: list[Block] = [
        paragraph("V' of the printed field divided by the displayed V' is {}, identically.", factor),
        paragraph(
            "The signs that occur in the cells meeting at each ray, and exactly, at its point half-way to the "
            "sides of the square, `V*` and whether 0 belongs to the Filippov set:"
        ),
        _ray_table(roll, side),
    ]
    conclusion = prose("the display lacks the factor {}; see the table for `V*`.", factor)
    if confirmed:
        computed += [paragraph("On every closed cell, decided at its vertices:"), closed]
        conclusion = prose(
            "the display lacks the factor {}. On an axis `sgn(y^2 - x^2)` has one value; what jumps is the "
            "sign of the vanishing coordinate, whose factor in V' is 0, so `V* = 0` stands. The diagonals, "
            "where `sgn(y^2 - x^2)` does jump, are not checked in the paper; there `V* < 0`. Under eq. (3) the "
            "axes consist of equilibria, so the origin is stable, not asymptotically; under eq. (4) `V* < 0` "
            "everywhere but at the origin.",
            factor,
        )
    return Finding(
        2,
        "V' and V* of section 3.2",
        ClaimOutcome.CORRECTED if confirmed else ClaimOutcome.REFUTED,
        prose(
            "V' as displayed; on x = 0 the set-valued term is `sgn(y^2 - x^2)`, and `V* = 0` there; `V* < 0` "
            "for `mu_S < mu_R`."
        ),
        tuple(computed),
        conclusion,
    )


def _ray_table(roll: CellCheck, side: CellCheck) -> Block:
    header = (
        "ray",
        prose("`sgn x`"),
        prose("`sgn y`"),
        prose("`sgn(y^2 - x^2)`"),
        prose("`V*` of (3)"),
        prose("`V*` of (4)"),
        "equilibria of (3)",
    )
    rows: list[tuple[Entry, ...]] = []
    places = rays(roll.partition)
    for name, place in rays(side.partition).items():
        signs = [", ".join(f"{sign:+d}" for sign in sorted(s)) for s in sign_sets(side.partition, place)]
        first = number(upper_derivative_at(side.partition, place))
        second = number(upper_derivative_at(roll.partition, places[name]))
        rows.append((name, *signs, first, second, "yes" if rests(side.partition, place) else "no"))
    return table(header, rows, (2, 1.4, 1.4, 2, 2, 2, 2))


def audit_rotation(roll: CellCheck, side: CellCheck) -> Finding:
    """Finding 3: instability of theta."""
    unstable = all(r.rotation.verdict is Rotation.UNSTABLE and r.rotation.check() for r in (roll, side))
    rows = [row for equation, result in (("(3)", side), ("(4)", roll)) for row in _spin_rows(equation, result)]
    conclusion = prose(
        "invariance alone proves that `theta = 0` is not attractive, no more. These combinations belong to the "
        "Filippov set at the origin, so the body may spin there for ever: theta is unstable."
    )
    return Finding(
        3,
        "Instability of theta",
        ClaimOutcome.STRENGTHENED if unstable else ClaimOutcome.REFUTED,
        prose("theta is unstable because the equations do not depend on it."),
        (
            paragraph(
                "Convex combinations of the motions that meet at the origin, with velocity zero, and the "
                "extreme rates of rotation that they reach:"
            ),
            table(("equation", "rate", prose("`v`"), prose("`omega`"), "weight"), rows, (2, 2, 4, 3, 2)),
        ),
        conclusion if unstable else prose("no combination of the motions at the origin proves instability."),
    )


def _spin_rows(equation: str, result: CellCheck) -> list[tuple[Entry, ...]]:
    drift = result.rotation.drift
    if drift is None:
        return []
    return [
        (equation, number(rate), point(drift.twists[k].velocity), number(drift.twists[k].omega), number(weight))
        for rate, mixture in zip(drift.interval, (drift.lowest, drift.highest), strict=True)
        for k, weight in mixture.weights.items()
    ]
