"""The paper, audited: each printed claim against what this program computes from the four-wheel array.

The numbers of the findings are those of the project's list; every finding is computed when the report is written,
none is a stored sentence about a result.  Most compare two built-in scenes: *side* is ``four-wheel-side``
(``mu_S > mu_R``, eq. 3), *roll* is ``four-wheel`` (``mu_S < mu_R``, eq. 4).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from functools import cache

import numpy as np
import sympy

from nonsmooth.analysis.cells.box import build_box_partition, rest_cells
from nonsmooth.analysis.cells.filippov import filippov_twists, lyapunov_rate, upper_derivative_at
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.minimizers.agreement import shared_area
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.control_fields import InputCell
from nonsmooth.proofs.findings import Rotation, Theorem4
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.proofs.theorem4 import CellCheck, check_cells, check_smooth
from nonsmooth.reports.output.document import (
    Block,
    Bullets,
    Entry,
    Math,
    Paragraph,
    Section,
    Text,
    display,
    number,
    point,
    table,
)
from nonsmooth.reports.output.prose import paragraph, prose
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import (
    EQUATION_3,
    EQUATION_4,
    RATE_OF_SECTION_3_2,
    THEOREM_4_KINEMATICS,
    THEOREM_4_RATE,
    c,
    s,
    theta_b,
    ui,
    uj,
    x,
    x1,
    x2,
    y,
    y1,
    y2,
)
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Contact, Friction, Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import dot, turned

PAPER = "Murphey and Burdick, On the Stability and Design of Distributed Manipulation Control Systems (2001)"


class ClaimOutcome(StrEnum):
    """How a printed claim fares."""

    CONFIRMED = "confirmed"
    CORRECTED = "true after a correction"
    STRENGTHENED = "conclusion right, argument completed"
    REFUTED = "refuted"


@dataclass(frozen=True)
class AuditedClaim:
    """A printed claim against the computation.

    Attributes:
        item: number of the finding.
        title: its subject.
        outcome: how the claim fares.
        claim: as printed.
        computed: what was computed, with formulas and tables.
        conclusion: what follows.
    """

    item: int
    title: str
    outcome: ClaimOutcome
    claim: Text
    computed: tuple[Block, ...]
    conclusion: Text

    def section(self) -> Section:
        """The finding as a part of a report."""
        claim, conclusion = Paragraph(("Printed: ", *self.claim)), Paragraph(("Finding: ", *self.conclusion))
        return Section(f"{self.title}: {self.outcome}", (claim, *self.computed, conclusion))


@cache
def audit_paper() -> tuple[AuditedClaim, ...]:
    """All findings: the same in every report, so computed once."""
    roll, side = (check_cells(load_scene(name)) for name in ("four-wheel", "four-wheel-side"))
    return (
        audit_equations_3_and_4(roll, side),
        audit_translation(roll, side),
        audit_rotation(roll, side),
        audit_largest_weights(),
        audit_feedback(roll),
        audit_theorem_4_displays(),
        audit_every_array(),
        audit_uniqueness(),
        audit_friction_ellipse(),
    )


def audit_section() -> Section:
    """The findings as a part of a report."""
    findings = audit_paper()
    summary: tuple[Text, ...] = tuple((f"{finding.title}: {finding.outcome}.",) for finding in findings)
    intro = paragraph("This is the array of {}. What the paper prints about it, against the computation:", PAPER)
    return Section("The paper, audited", (intro, Bullets(summary)), tuple(finding.section() for finding in findings))


def _rows(header: str, rows: list[tuple[Entry, ...]], *widths: float) -> Block:
    """A table; bars part the entries of its header."""
    return table([prose(entry) for entry in header.split("|")], rows, widths)


# ---- 1: equations (3) and (4) --------------------------------------------------------------------


def audit_equations_3_and_4(roll: CellCheck, side: CellCheck) -> AuditedClaim:
    """Eqs. (3) and (4), cell by cell."""
    rows: list[tuple[Entry, ...]] = []
    for name, printed, result in (("(3)", EQUATION_3, side), ("(4)", EQUATION_4, roll)):
        for cell in result.partition.cells:
            said = "equal" if agrees(printed, cell) else "different"
            rows.append((name, cell.states[0].name, point(cell.polygon.centre), point(cell.twists[0]), said))
    equal = sum(row[-1] == "equal" for row in rows)
    return AuditedClaim(
        1,
        "Equations (3) and (4)",
        ClaimOutcome.CONFIRMED if equal == len(rows) else ClaimOutcome.REFUTED,
        prose("the motion of the four-wheel array is eq. (3) for `mu_S > mu_R` and eq. (4) for `mu_S < mu_R`."),
        (_rows("equation|rows held|at c|`xi = (v, omega)`|printed field", rows, 1.9, 2, 3, 4, 2),),
        prose(
            "{} of {} cells agree exactly, as spatial twists under the rule of sec. 3.1. The pose rate of the "
            "centre of mass has the extra term `omega J c`; it does not change V' of `|c|^2`, because `c . J c "
            "= 0`.",
            str(equal),
            str(len(rows)),
        ),
    )


def agrees(printed: sympy.Matrix, cell: Cell) -> bool:
    """Whether a printed field, evaluated at an interior point of a cell, is the cell's twist; exact."""
    values = dict(zip((x, y), (entry.to_sympy() for entry in cell.polygon.centre), strict=True))
    derived = sympy.Matrix([entry.to_sympy() for entry in cell.twists[0]])
    return bool((printed.subs(values) - derived).expand().is_zero_matrix)


# ---- 2: V' and V* of section 3.2 -----------------------------------------------------------------

# Points on the half-axes and half-diagonals, by their names.
RAYS = {
    "x > 0": (1, 0),
    "y > 0": (0, 1),
    "x < 0": (-1, 0),
    "y < 0": (0, -1),
    "x = y > 0": (1, 1),
    "-x = y > 0": (-1, 1),
    "x = y < 0": (-1, -1),
    "x = -y > 0": (1, -1),
}


def audit_translation(roll: CellCheck, side: CellCheck) -> AuditedClaim:
    """V' of sec. 3.2 in all symbols, and V* on rays and closed cells."""
    factor = str(missing_factor())
    confirmed = rate_is(side.partition, larger=False) and rate_is(roll.partition, larger=True)
    computed: list[Block] = [
        paragraph("V' of the printed field divided by the displayed V' is {}, identically.", factor),
        paragraph(
            "The signs that occur in the cells meeting at each ray, and exactly, at its point half-way to the "
            "sides of the square, `V*` and whether 0 belongs to the Filippov set:"
        ),
        _rows(
            "ray|`sgn x`|`sgn y`|`sgn(y^2 - x^2)`|`V*` of (3)|`V*` of (4)|equilibria of (3)",
            [_ray_row(roll.partition, side.partition, ray) for ray in RAYS],
            *(2, 1.4, 1.4, 2, 2, 2, 2),
        ),
    ]
    conclusion = prose("the display lacks the factor {}; see the table for `V*`.", factor)
    if confirmed:
        closed = display(
            r"\dot V^* = -2\sqrt2 \min(\lvert x \rvert, \lvert y \rvert) \text{ for (3)}, \qquad"
            r" \dot V^* = -2\sqrt2 \max(\lvert x \rvert, \lvert y \rvert) \text{ for (4)}",
            "V* = -2 sqrt(2) min(|x|, |y|) for (3), V* = -2 sqrt(2) max(|x|, |y|) for (4)",
        )
        computed += [paragraph("On every closed cell, decided at its vertices:"), closed]
        conclusion = prose(
            "the display lacks the factor {}. On an axis `sgn(y^2 - x^2)` has one value; what jumps is the "
            "sign of the vanishing coordinate, whose factor in V' is 0, so `V* = 0` stands. The diagonals, "
            "where `sgn(y^2 - x^2)` does jump, are not checked in the paper; there `V* < 0`. Under eq. (3) the "
            "axes consist of equilibria, so the origin is stable, not asymptotically; under eq. (4) `V* < 0` "
            "everywhere but at the origin.",
            factor,
        )
    return AuditedClaim(
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


def missing_factor() -> sympy.Expr:
    """V' of ``x^2 + y^2`` along eq. (3) divided by the V' that sec. 3.2 displays, in all symbols.

    Raises:
        ValueError: if the quotient is not constant.
    """
    ratio = sympy.cancel((2 * x * EQUATION_3[0] + 2 * y * EQUATION_3[1]) / RATE_OF_SECTION_3_2)
    if not ratio.is_number:
        raise ValueError(f"required a constant quotient of the two rates, received {ratio}")
    return ratio


def rate_is(partition: Partition, *, larger: bool) -> bool:
    """Whether ``V* = -2 sqrt2 max(|x|, |y|)`` (larger) or ``-2 sqrt2 min(|x|, |y|)`` on every closed cell.

    Both sides are linear on a cell whose interior holds no axis and no diagonal: then the vertices decide.
    """
    chosen, factor = max if larger else min, -2 * partition.scene.field.sqrt(2)
    return all(
        all(_signs(cell.polygon.centre)) and lyapunov_rate(cell.twists[0], vertex) == factor * chosen(map(abs, vertex))
        for cell in partition.cells
        for vertex in cell.polygon.vertices
    )


def _ray_row(roll: Partition, side: Partition, ray: str) -> tuple[Entry, ...]:
    place = ray_point(side, ray)
    signs = [", ".join(f"{sign:+d}" for sign in sorted(found)) for found in sign_sets(side, place)]
    rates = [number(upper_derivative_at(cells, ray_point(cells, ray))) for cells in (side, roll)]
    return ray, *signs, *rates, "yes" if rests(side, place) else "no"


def ray_point(partition: Partition, ray: str) -> Point:
    """The point of a ray half-way to the sides of the square."""
    (a, b), half = RAYS[ray], partition.scene.check.radius / 2
    return half * a, half * b


def sign_sets(partition: Partition, place: Point) -> list[set[int]]:
    """Signs of x, y and ``y^2 - x^2`` inside the cells that meet at a point."""
    signs = [_signs(cell.polygon.centre) for cell in partition.cells_at(place)]
    return [set(column) for column in zip(*signs, strict=True)]


def _signs(place: Point) -> tuple[int, int, int]:
    x, y = place
    return x.sign(), y.sign(), (y * y - x * x).sign()


def rests(partition: Partition, place: Point) -> bool:
    """Whether 0 lies in the hull of the twists that meet at a point: then the body may rest all along its ray."""
    twists = filippov_twists(partition, place)
    return best_mixture(*mixtures_to_zero(twists), [partition.scene.field.zero] * len(twists)) is not None


# ---- 3: instability of theta ---------------------------------------------------------------------


def audit_rotation(roll: CellCheck, side: CellCheck) -> AuditedClaim:
    """Theta, by the convex combinations of motions at the origin."""
    unstable = all(r.rotation.verdict is Rotation.UNSTABLE for r in (roll, side))
    rows: list[tuple[Entry, ...]] = []
    for equation, drift in (("(3)", side.rotation.drift), ("(4)", roll.rotation.drift)):
        if drift is None:
            continue
        for rate, mixture in zip(drift.interval, (drift.lowest, drift.highest), strict=True):
            for k, weight in mixture.weights.items():
                twist = drift.twists[k]
                rows.append((equation, number(rate), point(twist.velocity), number(twist.omega), number(weight)))
    conclusion = prose(
        "invariance alone proves that `theta = 0` is not attractive, no more. These combinations belong to the "
        "Filippov set at the origin, so the body may spin there for ever: theta is unstable."
    )
    return AuditedClaim(
        3,
        "Instability of theta",
        ClaimOutcome.STRENGTHENED if unstable else ClaimOutcome.REFUTED,
        prose("theta is unstable because the equations do not depend on it."),
        (
            paragraph(
                "Convex combinations of the motions that meet at the origin, with velocity zero, and the "
                "extreme rates of rotation that they reach:"
            ),
            _rows("equation|rate|`v`|`omega`|weight", rows, 2, 2, 4, 3, 2),
        ),
        conclusion if unstable else prose("no combination of the motions at the origin proves instability."),
    )


# ---- 4: the three largest weights ----------------------------------------------------------------

WEIGHTS, SPEEDS = (3, 2, 2), (0, 1, 1)  # one scalar motion, three contacts: the largest weight loses
RATIOS = (2, Fraction(1, 2), Fraction(1, 5), Fraction(1, 10), Fraction(1, 100))


def audit_largest_weights() -> AuditedClaim:
    """The constraints with the three largest weights need not minimize D."""
    losses = {x: sum(w * abs(x - u) for w, u in zip(WEIGHTS, SPEEDS, strict=True)) for x in sorted(set(SPEEDS))}
    best = min(losses, key=lambda x: losses[x])
    scene = load_scene("four-wheel")
    return AuditedClaim(
        4,
        "The three largest weights",
        ClaimOutcome.REFUTED if losses[best] < losses[SPEEDS[0]] else ClaimOutcome.CONFIRMED,
        prose("the minimum of D satisfies the three constraints with the largest weights, so those nearest to c."),
        (
            paragraph(
                "One scalar motion x and three contacts with weights {} and speeds {}: D is {} at x = {} and {} at "
                "x = {}. The minimizer {} violates the constraint with the largest weight.",
                *(str(list(values)) for values in (WEIGHTS, SPEEDS)),
                *(str(entry) for x in losses for entry in (losses[x], x)),
                str(best),
            ),
            paragraph("The four-wheel array with elastic loads on the square of half-width 1/2, areas exact:"),
            _rows(
                "mu_S/mu_R|cells of the minimizer|area on which the rule's twist minimizes D|area at rest",
                [_share_row(scene, ratio) for ratio in RATIOS],
                *(0.2, 0.25, 0.35, 0.2),
            ),
        ),
        prose(
            "with elastic loads the rule of sec. 3.1 gives the minimizer on a part of the square that grows as "
            "mu_S/mu_R tends to 0, and the origin lies in a rest area. "
            "The rule is the limit of loads that fall off very fast where the row that it takes of the second-nearest "
            "wheel also has the larger friction times lever, as it has here; elsewhere it is not."
        ),
    )


def _share_row(scene: Scene, ratio: Fraction | int) -> tuple[Entry, ...]:
    """Ratio, number of cells, exact share of agreement, exact rest area."""
    near = _with_friction(scene, ratio)
    box = build_box_partition(replace(near, contact=Contact("box")))
    shared = shared_area(build_nearest_partition(near), box)
    rest: Number = sum((cell.polygon.area for cell in rest_cells(box)), scene.field.zero)
    return number(scene.field.rational(ratio)), str(len(box.cells)), number(shared.share), number(rest)


def _with_friction(scene: Scene, ratio: Fraction | int) -> Scene:
    """The array under rule ``nearest`` with ``mu_S/mu_R`` the ratio at every wheel."""
    friction = Friction(scene.field.one, scene.field.rational(ratio))
    wheels = tuple(replace(wheel, friction=friction) for wheel in scene.wheels)
    return replace(scene, wheels=wheels, contact=Contact("nearest"))


# ---- 5: the printed feedback law -----------------------------------------------------------------


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
    """

    data: InputCell
    lever: Number

    @property
    def rays(self) -> list[Point]:
        """Directions that generate the closed cell as a cone."""
        return [vertex for vertex in self.data.cell.polygon.vertices if any(vertex)]

    def proves(self, kappa: Number) -> bool:
        """Whether ``V' <= -2 kappa k V`` on the closed cell, for every theta."""
        for ray in self.rays:
            m = -dot(ray, self.data.nearest.unit_direction)
            w = dot(ray, turned(self.data.nearest.position)) / abs(self.lever)
            if m.sign() < 0 or m * m < kappa * kappa * dot(ray, ray) or m < abs(w):
                return False
        return bool(kappa * abs(self.lever) <= 1)


def corrected_law(data: InputCell) -> CorrectedLaw:
    """The corrected law in one cell.

    Raises:
        ValueError: unless the third row is a roll row of a wheel with a rim at right angles to that of wheel i.
    """
    if data.lever is None or data.state.control_fields[data.nearest.index][2]:
        raise ValueError("required d_i . d_j = 0 and a roll row in third place")
    return CorrectedLaw(data, data.lever / data.second.length)


def audit_feedback(roll: CellCheck) -> AuditedClaim:
    """The printed law ``u_j = -k theta, u_i = |u_j| + k|c|`` cell by cell, and the corrected one."""
    if not isinstance(roll.feedback, FeedbackResult):
        raise ValueError("required a check under rule nearest, received sampled feedback")
    laws = [corrected_law(data) for data in roll.feedback.cells]
    kappa = roll.partition.scene.field.sqrt(2) / 2
    proved = all(law.proves(kappa) for law in laws)
    wrong = [str(law.data.cell.index) for law in laws if law.lever.sign() < 0]
    rows: list[tuple[Entry, ...]] = []
    for law in laws:
        places = (str(item.index) for item in (law.data.cell, law.data.nearest, law.data.second))
        printed = prose("`theta' < 0`: back" if law.lever.sign() > 0 else "`theta' > 0`: away")
        rows.append((*places, number(law.lever), printed, "proved" if law.proves(kappa) else "not proved"))
    outcome = ClaimOutcome.CORRECTED if wrong else ClaimOutcome.CONFIRMED
    words = "`u_j = -k theta` has the wrong sign in {} of the {} cells ({}). With the sign of `Delta` the law gives "
    words += "`V' <= -sqrt(2) k V` on every closed cell." if proved else "no proved rate."
    return AuditedClaim(
        5,
        "The printed feedback law",
        outcome if proved else ClaimOutcome.REFUTED,
        prose("`u_i = |u_j| + k |(x, y)|` and `u_j = -k theta` stabilize the array for `mu_S < mu_R`."),
        (
            paragraph("In each cell `d_i . d_j = 0`, so `theta' = u_j/Delta` with `Delta = d_j . J(p_j - p_i)`:"),
            _rows(
                "cell|`i`|`j`|`Delta`|printed law, `theta > 0`|corrected law, the bound below",
                rows,
                *(1.2, 1, 1, 2, 4, 4),
            ),
            paragraph("With `u_j = -sgn(Delta) k theta` and `V = x^2 + y^2 + theta^2`:"),
            display(
                r"-\tfrac{1}{2k} \dot V = m \lvert c \rvert + m \lvert \theta \rvert"
                r" + \frac{\theta^2}{\lvert \Delta \rvert} - \theta w,"
                r" \qquad m = -c \cdot d_i, \quad w = \frac{c \cdot J p_i}{\lvert \Delta \rvert}",
                "-V'/(2k) = m |c| + m |theta| + theta^2/|Delta| - theta w, m = -c . d_i, w = c . J p_i/|Delta|",
            ),
            paragraph(
                "On the rays of each closed cell `m >= kappa |c|`, `m >= |w|` and `1/|Delta| >= kappa` with "
                "`kappa` = {}, checked exactly; the differences are concave, so they are not negative on the whole "
                "cell.",
                number(kappa),
            ),
        ),
        prose(words, str(len(wrong)), str(len(laws)), ", ".join(wrong) or "none"),
    )


# ---- 6: Theorem 4's displays ---------------------------------------------------------------------

SymbolicRow = tuple[sympy.Expr, ...]
SymbolicVector = tuple[sympy.Expr, sympy.Expr]


def symbolic_row(direction: SymbolicVector, position: SymbolicVector, speed: sympy.Expr) -> SymbolicRow:
    """A wheel's row ``(d, d . J p | u)``; its side row is that of ``J d`` and 0."""
    return *direction, dot(direction, turned(position)), speed


def twist_of(*rows: SymbolicRow) -> sympy.Matrix:
    """``(v_x, v_y, omega)`` of three rows, by cofactors."""
    whole = sympy.Matrix(rows)
    return whole[:, :3].adjugate() * whole[:, 3] / whole[:, :3].det()


def pair_twist() -> sympy.Matrix:
    """The twist of both rows of wheel i and the roll row of wheel j, in the symbols of Theorem 4.

    Its formulas are those of eq. (2)'s sign ``+Psi`` (so ``d_i = -(cos theta, sin theta)``), a rim of wheel j
    through the origin (``d_j = -p_2/|p_2|``), and ``u_j`` standing for the speed times ``|p_2|``.
    """
    d, reach = (-c, -s), sympy.sqrt(x2**2 + y2**2)
    return twist_of(
        symbolic_row(d, (x1, y1), ui),
        symbolic_row(turned(d), (x1, y1), sympy.Integer(0)),
        symbolic_row((-x2 / reach, -y2 / reach), (x2, y2), uj / reach),
    )


def pair_rate(twist: sympy.Matrix) -> sympy.Expr:
    """``V' = 2 (x x' + y y' + theta_b theta')`` of ``V = x^2 + y^2 + theta_b^2``, theta_b the body's orientation."""
    return 2 * sympy.Matrix([x, y, theta_b]).dot(twist)


def lowest_terms(expression: sympy.Expr) -> sympy.Expr:
    """A rational function of ``cos theta`` and ``sin theta`` in ``t = tan(theta/2)``: equal ones become the same."""
    t = sympy.Symbol("t", real=True)
    return sympy.cancel(expression.subs({c: (1 - t**2) / (1 + t**2), s: 2 * t / (1 + t**2)}))


def audit_theorem_4_displays() -> AuditedClaim:
    """The kinematics and V' in the proof of Theorem 4, as identities in all symbols."""
    twist = pair_twist()
    equal = all(lowest_terms(entry) == 0 for entry in twist - THEOREM_4_KINEMATICS)
    quotient = lowest_terms(pair_rate(twist) / THEOREM_4_RATE)
    confirmed = equal and quotient.is_number
    ratio = Math(str(quotient), str(quotient)) if confirmed else "not constant"
    conclusion = prose("the displays do not follow from the constraints in this reading.")
    if confirmed:
        conclusion = prose(
            "the kinematics hold when theta inside cos and sin is the rim angle of wheel i, not the "
            "orientation of the body, and when `u_j` stands for the speed times `|p_2|`. The displayed V' is "
            "to be multiplied by {} (it is that of `V/2`); in it, theta stands for both angles.",
            ratio,
        )
    return AuditedClaim(
        6,
        "Theorem 4's displays",
        ClaimOutcome.CORRECTED if confirmed else ClaimOutcome.REFUTED,
        prose("the governing equations of a pair (i, j) and V' of `V = x^2 + y^2 + theta^2`."),
        (
            paragraph(
                "The rows of wheel i (index 1) and the roll row of wheel j (index 2) were solved by cofactors with "
                "symbolic positions, headings and speeds, then read as follows, with the sign of eq. (2):"
            ),
            display(
                r"d_i = -(\cos\theta, \sin\theta), \qquad d_j = -p_2 / \lvert p_2 \rvert, \qquad"
                r" u_j = \lvert p_2 \rvert \times \text{speed of wheel } j",
                "d_i = -(cos theta, sin theta), d_j = -p_2/|p_2|, u_j = |p_2| times the speed of wheel j",
            ),
            paragraph(
                "In all symbols, the displayed kinematics {} the derived one. Derived V' divided by displayed V' is "
                "{}.",
                "equals" if equal else "does not equal",
                ratio,
            ),
        ),
        conclusion,
    )


# ---- 7: every planar array -----------------------------------------------------------------------


def audit_every_array() -> AuditedClaim:
    """The theorem does not hold for every planar array."""
    names = "off-center", "outward", "saddle", "differential-drive"
    results = [check_cells(load_scene(name)) for name in names]
    refuted = [r for r in results if r.verdict in (Theorem4.FAILS, Theorem4.HYPOTHESES_NOT_MET)]
    rows: list[tuple[Entry, ...]] = [(r.scene.name, str(r.verdict), r.reason) for r in results]
    return AuditedClaim(
        7,
        "Theorem 4 for every planar array",
        ClaimOutcome.REFUTED if refuted else ClaimOutcome.CONFIRMED,
        prose("for a discrete planar array the motion is stable in (x, y) and unstable in theta."),
        (_rows("array|Theorem 4|witness", rows, 0.2, 0.2, 0.6),),
        prose(
            f"{len(refuted)} of these {len(results)} arrays are counterexamples: the point need not be an equilibrium, "
            "fields that push outward break the first clause, and no feedback moves a unicycle along its axle. "
            "The theorem needs hypotheses on the array."
        ),
    )


# ---- 8: uniqueness and isotropic friction --------------------------------------------------------


def audit_uniqueness() -> AuditedClaim:
    """Where the minimizer is not unique."""
    cells = build_nearest_partition(_with_friction(load_scene("four-wheel"), 1)).cells
    tied = sum(len(cell.states) > 1 for cell in cells)
    two = ContactModel.build([[0, 0], [2, 1]], [[1, 0], [1, 0]], [[1, 0.3], [-0.2, 0.5]], [1, 1])
    both = EllipseMinimizer().minimize(two, np.array([[1.0, 2.0], [1.0, 1.0]]))
    circle_is_unique = list(both.faces) == [1]
    return AuditedClaim(
        8,
        "Uniqueness and isotropic friction",
        ClaimOutcome.CORRECTED if circle_is_unique and tied else ClaimOutcome.CONFIRMED,
        prose("the minimum is non-unique only when the friction ellipse is a circle (mu_S = mu_R)."),
        (
            paragraph(
                "Rule of sec. 3.1 with mu_S = mu_R: {} of {} cells hold two contact states, which differ in the "
                "third row.",
                str(tied),
                str(len(cells)),
            ),
            paragraph(
                "Two isotropic wheels at (0, 0) and (2, 1), surface velocities (1, 0.3) and (-0.2, 0.5). Weights 1 and "
                "2: D = {}, omega = {}, {}. Equal weights: {}.",
                f"{both.values[0]:.5f}",
                f"{both.twists[0, 2]:.3f}",
                _face_text(both, 0),
                _face_text(both, 1),
            ),
        ),
        prose(
            "equal friction leaves the third row of the rule open. The circle functional itself is strictly convex "
            "unless slips are parallel, so isotropic friction alone does not make it non-unique."
        ),
    )


def _face_text(minima: Minima, k: int) -> str:
    return f"a segment between {len(minima.faces[k])} twists minimizes D" if k in minima.faces else "one minimizer"


# ---- 9: the friction ellipse of Fig. 3 -----------------------------------------------------------


def audit_friction_ellipse() -> AuditedClaim:
    """The theorem under the functional of the paper's own Fig. 3."""
    result = check_smooth(load_scene("four-wheel", rule="ellipse"))
    linear = result.translation.point.linearization
    if linear is None:
        raise ValueError("required a smooth equilibrium of the four-wheel array")
    (a, b), (c, d) = linear.translation
    formula = display(
        rf"\dot c = \begin{{pmatrix}} {number(a).latex} & {number(b).latex} \\ {number(c).latex} & {number(d).latex} "
        r"\end{pmatrix} c + O(\lvert c \rvert^2)",
        f"c' = [{a}, {b}; {c}, {d}] c + O(|c|^2)",
    )
    return AuditedClaim(
        9,
        "The friction ellipse of Fig. 3",
        ClaimOutcome.REFUTED if result.verdict is Theorem4.FAILS else ClaimOutcome.CONFIRMED,
        prose("friction may vary smoothly with direction, as in Fig. 3, and theta is unstable."),
        (paragraph("Minimizer of the ellipse functional near the origin, elastic loads, exactly:"), formula),
        prose(
            f"the field is smooth there: translation is {result.translation.verdict}, "
            f"theta is {result.rotation.verdict}, nothing rests and nothing slides. "
            "Theorem 4 is a statement about the rule of sec. 3.1."
        ),
    )
