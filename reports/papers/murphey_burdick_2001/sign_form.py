"""Governing equations with ``sgn`` in one formula for all cells, as the paper prints eqs. (3) and (4).

Where the cells are the sectors of lines through the checked point, every component of the twist is constant on each.
A line is a *factor* (``x``, ``y``, ``a x + b y``); two lines that mirror each other in an axis are one factor
(``b^2 y^2 - a^2 x^2``).  A function on the sectors is sought as one or two terms ``number * sgn(product of factors)``:
every candidate's numbers follow from two sectors and are tested exactly on all.  It fails, and says nothing, where two
terms are too few (rings of many wheels).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import combinations
from math import prod
from typing import Any, TypeAlias

import sympy
from sympy import cos, sin, sqrt

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.reports.checks.subject import ArraySubject
from nonsmooth.reports.output.document import Block, Code, Math, Paragraph, Section, display
from nonsmooth.reports.output.prose import listed, paragraph, prose
from nonsmooth.symbolic.formulas.surfaces import Formula, number_latex
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import EXACT_ROOTS
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import cross, dot
from nonsmooth.symbolic.numbers.polynomial import Terms, multiply_terms
from nonsmooth.symbolic.numbers.printing import number_summands

MOST_FACTORS = 6  # 2^6 products make 2016 pairs
NAMES = (Math("v_x", "v_x"), Math("v_y", "v_y"), Math(r"\omega", "omega"))

Direction: TypeAlias = tuple[Number, Number]
Factor: TypeAlias = Terms  # coefficient of x^i y^j by (i, j)
Product: TypeAlias = tuple[int, ...]  # numbers of the factors, ascending


# ---- the section ---------------------------------------------------------------------------------


def sign_form_section(subject: ArraySubject) -> Section:
    """The twist of all cells in one formula, each component that has a short one."""
    forms = list(zip(NAMES, partition_forms(subject.cells.partition), strict=True))
    found = [(name, form) for name, form in forms if form is not None]
    latex = " \\\\\n".join(rf"{name.latex} &= {form.latex}" for name, form in found)
    blocks: list[Block] = [
        paragraph("The cells are the sectors of lines through the checked point, so the spatial twist is, exactly:"),
        display(
            f"\\begin{{aligned}}\n{latex}\n\\end{{aligned}}",
            "\n".join(f"{name.plain} = {form.plain}" for name, form in found),
        ),
    ]
    missing = [name for name, form in forms if form is None]
    if missing:
        words = prose("No sum of two products of signs equals the others, which the contact states list cell by cell: ")
        blocks.append(Paragraph((*words, *listed(missing), ".")))
    return Section("Governing equations in sgn form", tuple(blocks))


def without_sign_form(subject: ArraySubject) -> str:
    """Why the cells allow no such formula; empty where they do."""
    partition = subject.cells.partition
    if len(partition.scene.field.radicands) > EXACT_ROOTS:
        return "exact coordinates of the cells would take minutes over so many square roots"
    if any(len(set(cell.twists)) > 1 for cell in partition.cells):
        return "several motions tie in a cell"
    if separating_lines(partition) is None:
        return "the cells are not the sectors of lines through the checked point"
    return "" if any(partition_forms(partition)) else "no sum of two products of signs gives the twist"


def partition_forms(partition: Partition) -> list[SignForm | None]:
    """The forms of ``v_x, v_y, omega``; None for a component that has no short one."""
    lines = separating_lines(partition)
    if not lines:
        return [None, None, None]
    factors = line_factors(lines)
    centres = [_exact(cell.polygon.centre) for cell in partition.cells]
    components = zip(*(cell.twists[0] for cell in partition.cells), strict=True)
    return [find_sign_form(factors, list(zip(centres, values, strict=True))) for values in components]


def separating_lines(partition: Partition) -> list[Direction] | None:
    """Directions of the lines through the origin that part the cells; None where another edge does."""
    lines: list[Direction] = []
    for edge in partition.complex.edges:
        if edge.left is None or edge.right is None:
            continue
        first, last = partition.complex.points[edge.start], partition.complex.points[edge.end]
        if sign(cross(first, last)):
            return None
        direction = _exact(first if any(sign(value) for value in first) else last)
        if all(sign(cross(direction, line)) for line in lines):
            lines.append(direction)
    return lines


def _exact(point: tuple[Any, Any]) -> Direction:
    """A point as exact numbers."""
    x, y = (value if isinstance(value, Number) else value.exact() for value in point)
    return x, y


# ---- forms ---------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SignForm:
    """``sum_k number_k sgn(product_k)``, of one or two terms or none (zero); ``sgn`` of the empty product is 1."""

    factors: tuple[Factor, ...]
    terms: tuple[tuple[Number, Product], ...]

    @property
    def latex(self) -> str:
        """As the paper prints it: ``c sgn(p) (sgn(q) + 1)`` where two terms share a product."""
        return self._written(latex=True)

    @property
    def plain(self) -> str:
        """The same in plain text."""
        return self._written(latex=False)

    def _written(self, *, latex: bool) -> str:
        if len(self.terms) == 2:
            (first, common), (second, whole) = self.terms
            if set(common) <= set(whole) and first in (second, -second):
                rest = self._sign(tuple(k for k in whole if k not in common), latex)
                bracket = f"({rest} {'+' if first == second else '-'} 1)"
                if latex and common:
                    bracket = rf"\left{bracket[:-1]}\right)"
                return _joined(second, [self._sign(common, latex), bracket], latex)
        terms = [_joined(number, [self._sign(product, latex)], latex) for number, product in self.terms if number]
        return " + ".join(terms).replace("+ -", "- ") or "0"

    def _sign(self, product: Product, latex: bool) -> str:
        """``sgn`` of a product, empty where that is."""
        if not product:
            return ""
        polynomial = reduce(multiply_terms, (self.factors[k] for k in product))
        formula = Formula(tuple((polynomial[powers], _monomial(*powers)) for powers in sorted(polynomial)))
        if latex:
            return rf"\operatorname{{sgn}}({formula.latex()})"
        return f"sgn({formula.plain().replace('*', ' ')})"


def _monomial(i: int, j: int) -> tuple[str, ...]:
    return tuple(name if power == 1 else f"{name}^{power}" for name, power in (("x", i), ("y", j)) if power)


def _joined(number: Number, signs: list[str], latex: bool) -> str:
    """``number sign sign``; a number that is a sum stands in parentheses."""
    signs = [sign for sign in signs if sign]
    written = number_latex(number) if latex else str(number)
    if signs and len(number_summands(number)) > 1:
        written = rf"\left({written}\right)" if latex else f"({written})"
    if signs and written in ("1", "-1"):
        return written[:-1] + " ".join(signs)
    return (r"\, " if latex else " ").join([written, *signs])


def line_factors(lines: Sequence[Direction]) -> tuple[Factor, ...]:
    """The factors of lines through the origin, given by their directions, no two of them parallel."""
    left, factors = list(lines), list[Factor]()
    while left:
        a, b = left.pop(0)
        mirrored = [(c, d) for c, d in left if a * b and not a * d + b * c]
        left = [line for line in left if line not in mirrored]
        # the product of a y - b x, with the coefficient of the highest power of y, or x, made 1
        lines_of_factor: list[Factor] = [{(0, 1): c, (1, 0): -d} for c, d in [(a, b), *mirrored]]
        product = reduce(multiply_terms, lines_of_factor)
        polynomial = {powers: number for powers, number in product.items() if number}
        leading = polynomial[max(polynomial, key=lambda powers: powers[1])]
        factors.append({powers: number / leading for powers, number in polynomial.items()})
    return tuple(sorted(factors, key=lambda factor: (sum(next(iter(factor))), (0, 1) in factor)))


def find_sign_form(factors: tuple[Factor, ...], samples: Sequence[tuple[Direction, Number]]) -> SignForm | None:
    """The shortest form with the given values.

    Args:
        factors: of the lines that part the sectors.
        samples: an inner point of every sector with the value there.

    Returns:
        None where no two terms suffice.
    """
    if len(factors) > MOST_FACTORS:
        return None
    values = [value for _, value in samples]
    if not any(values):
        return SignForm(factors, ())
    signs = [[sign_at(factor, point) for factor in factors] for point, _ in samples]
    products = [p for size in range(len(factors) + 1) for p in combinations(range(len(factors)), size)]
    columns = {product: [prod(row[k] for k in product) for row in signs] for product in products}
    for terms in _candidates(columns, values):
        if all(value == sum(n * columns[p][k] for n, p in terms) for k, value in enumerate(values)):
            return SignForm(factors, terms)
    return None


def sign_at(factor: Factor, point: Direction) -> int:
    """The sign of a factor at a point."""
    x, y = point
    return sign(sum(number * x**i * y**j for (i, j), number in factor.items()))


def _candidates(
    columns: dict[Product, list[int]], values: Sequence[Number]
) -> Iterator[tuple[tuple[Number, Product], ...]]:
    """One term, then two terms by total degree, with the numbers that the first sectors call for."""
    for product, column in columns.items():
        yield ((values[0] * column[0], product),)
    for first, second in sorted(combinations(columns, 2), key=lambda pair: (len(pair[0]) + len(pair[1]), pair)):
        one, two = columns[first], columns[second]
        # By whether the two signs are equal: the sum or the difference of the numbers, from the first such sector.
        told = {one[k] == two[k]: values[k] * one[k] for k in reversed(range(len(values)))}
        if len(told) == 2:
            yield ((told[True] + told[False]) / 2, first), ((told[True] - told[False]) / 2, second)


# ---- the printed equations -----------------------------------------------------------------------
#
# Murphey & Burdick, "On the Stability and Design of Distributed Manipulation Control Systems" (2001).  Each display is
# stated in SymPy, in the paper's own symbols and with whatever slip it holds.


x, y = sympy.symbols("x y", real=True)

# Eqs. (3) and (4): (x', y', theta') of the four-wheel array for mu_S > mu_R and for mu_S < mu_R.
sgn_x, sgn_y, sgn_squares = map(sympy.sign, (x, y, y**2 - x**2))
turn = sqrt(2) / 2 * sympy.sign(x * y**3 - x**3 * y)
EQUATION_3 = sympy.ImmutableMatrix(
    [-sqrt(2) / 2 * sgn_x * (sgn_squares + 1), sqrt(2) / 2 * sgn_y * (sgn_squares - 1), -turn]
)
EQUATION_4 = sympy.ImmutableMatrix(
    [sqrt(2) / 2 * sgn_x * (sgn_squares - 1), -sqrt(2) / 2 * sgn_y * (sgn_squares + 1), turn]
)

# V' displayed in sec. 3.2 for V = x^2 + y^2 along eq. (3).
RATE_OF_SECTION_3_2 = x * (-sgn_x * (sgn_squares + 1)) + y * (sgn_y * (sgn_squares - 1))

# The proof of Theorem 4 displays (x', y', theta') for a pair of wheels, and V' of V = x^2 + y^2 + theta^2.  The latter
# writes theta both for the angle inside cos and sin and for the orientation of the body, which is theta_b here.
x1, y1, x2, y2, theta, ui, uj = sympy.symbols("x_1 y_1 x_2 y_2 theta u_i u_j", real=True)
theta_b = sympy.Symbol("theta_b", real=True)
c, s = cos(theta), sin(theta)
THEOREM_4_KINEMATICS = sympy.ImmutableMatrix(
    [
        (-(uj * y1) + ui * (c * x1 + s * y1) * y2) / (x2 * y1 - x1 * y2),
        (-(uj * x1) + ui * x2 * (c * x1 + s * y1)) / (-x2 * y1 + x1 * y2),
        (-uj + ui * (c * x2 + s * y2)) / (x2 * y1 - x1 * y2),
    ]
)
THEOREM_4_RATE = (
    ui * (x2 * (c * (theta_b - y * x1) - y * s * y1) + (x * c * x1 + s * (theta_b + x * y1)) * y2)
    - uj * (theta_b - y * x1 + x * y1)
) / (x2 * y1 - x1 * y2)


# ---- whether an array is the paper's -------------------------------------------------------------
#
# And the law that the paper takes for it; its audit is in a file of its own.


def is_paper_array(scene: Scene) -> bool:
    """Whether the array is the paper's: four wheels at (+-1, +-1), rims to the origin, unit speeds."""
    corners = {tuple(coordinate.sign() for coordinate in wheel.position) for wheel in scene.wheels}
    return len(scene.wheels) == len(corners) == 4 and all(
        all(abs(coordinate) == 1 for coordinate in wheel.position)
        and wheel.speed == 1
        and not cross(wheel.position, wheel.direction)
        and dot(wheel.position, wheel.direction).sign() < 0
        for wheel in scene.wheels
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
