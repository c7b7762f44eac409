"""Rays and curves of equilibria through the checked point, which therefore does not attract: in any number of states.

On a ray from the point, which may lie in switching surfaces, the fields f_i of all cells beside it act.  *If 0 is a
mixture of all f_i at the point with positive weights, and along the ray the f_i stay in the space that they span at the
point, then every place of the ray near the point is one of rest*: 0 lies inside their hull in that space, where it
stays for small changes of the f_i.  Coulomb friction is an example, and relays that agree on a common value.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain, combinations, product
from math import comb
from typing import TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.lyapunov import sign_along
from nonsmooth.proofs.checker.polynomials import Polynomial, constant, variable
from nonsmooth.proofs.checker.positivity import identity
from nonsmooth.proofs.checker.theorems import STABLE
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.proofs.kernel.cells import BeyondReachError, Field, SignCells, build_cells, rational, started
from nonsmooth.proofs.kernel.first_terms import lyapunov_solution, quadratic_form
from nonsmooth.proofs.kernel.search import NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.written import formula_text, null_basis, rational_slopes
from nonsmooth.proofs.many_states.center_manifold import (
    DENOMINATOR,
    Reduction,
    Split,
    Vector,
    smooth_fields,
    split_at,
    times,
)
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, examine
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MOST_SURFACES = 8  # through the point, whose subsets are tried

Ray = tuple[Fraction, ...]
Along = dict[int, list[fmpq]]  # a field along a ray: a vector for each power of the distance


def ray_of_rest(system: SwitchedSystem) -> Ray | None:
    """A direction from the checked point in which all near places are equilibria; None where none is found.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    cells = build_cells(system, system.check.radius)
    for ray in _rays(cells):
        fields = _beside(cells, ray)
        if fields and _rests(fields):
            return ray
    return None


def _rays(cells: SignCells) -> Iterator[Ray]:
    """Axes of the subspaces on which some linear surfaces through the point vanish, in both directions.

    Then those of the parts of these subspaces along which the fields beside them stay, to first order, in the space
    that they span at the point.
    """
    numbers = [k for k, form in enumerate(cells.forms) if form.degree == 1 and form.is_form]
    if len(numbers) > MOST_SURFACES:
        raise BeyondReachError(f"over {MOST_SURFACES} surfaces through the point")
    sizes = range(min(len(numbers), len(cells.states) - 1) + 1)
    chosen = [subset for size in sizes for subset in combinations(numbers, size)]
    rows = [[rational_slopes(cells.forms[k]) for k in subset] for subset in chosen]
    resting = (same + more for subset, same in zip(chosen, rows, strict=True) for more in _conditions(cells, subset))
    seen = set[Ray]()
    for equations in chain(rows, resting):
        zero = [fmpq(0)] * len(cells.states)
        for axis, side in product(null_basis(fmpq_mat([zero, *equations])).transpose().tolist(), (1, -1)):
            ray = tuple(as_fraction(value * side) for value in axis)
            if ray not in seen:
                seen.add(ray)
                yield ray


def _conditions(cells: SignCells, surfaces: Sequence[int]) -> Iterator[list[list[fmpq]]]:
    """Rows that vanish at a direction in which the fields beside some surfaces keep to the space that they span.

    For each choice of the signs of the other surfaces: ``n . A r = 0`` for the Jacobians A of the fields of these
    cells, and for all n on which their values at the point are zero.  These depend on each other where 0 is a mixture.
    """
    groups: dict[tuple[int, ...], list[Field]] = {}
    for cell in cells.cells:
        others = tuple(sign for k, sign in enumerate(cell.signs) if k not in surfaces)
        groups.setdefault(others, []).extend(cell.velocities)
    for fields in groups.values():
        at_point = fmpq_mat([[as_fmpq(part.at_origin) for part in field] for field in fields])
        if at_point.rank() == len(fields):
            continue
        normals = null_basis(at_point).transpose()
        jacobians = (fmpq_mat([rational_slopes(part) for part in field]) for field in fields)
        yield [row for jacobian in jacobians if normals.nrows() for row in (normals * jacobian).tolist()]


def _beside(cells: SignCells, ray: Ray) -> list[Along]:
    """The fields of all cells whose closures hold the ray near the point; none where a curved surface holds it.

    Of linear surfaces through the ray a cell has the signs of one of its places, and so of places near the ray in that
    direction.  Cells beside curved ones may have no points.
    """
    signs = [sign_along(form, ray) for form in cells.forms]
    if any(not sign and form.degree > 1 for sign, form in zip(signs, cells.forms, strict=True)):
        return []
    fields = []
    for cell in cells.cells:
        if all(sign in (0, side) for sign, side in zip(signs, cell.signs, strict=True)):
            fields += [_field_along(field, ray) for field in cell.velocities]
    return fields


def _field_along(field: Field, ray: Ray) -> Along:
    parts = [part.parts_at(ray) for part in field]
    powers = {0, *(power for part in parts for power in part)}
    return {power: [as_fmpq(part.get(power, Fraction(0))) for part in parts] for power in powers}


def _rests(fields: Sequence[Along]) -> bool:
    """Whether 0 is a mixture with positive weights at the point, and fields stay in the space spanned there."""
    at_point = [field[0] for field in fields]
    size = fmpq_mat(at_point).rank()
    stays = all(fmpq_mat([*at_point, vector]).rank() == size for field in fields for vector in field.values())
    return stays and _is_inside(at_point)


def _is_inside(vectors: Sequence[list[fmpq]]) -> bool:
    """Whether 0 is a sum of all vectors with positive weights: each has a part in a mixture to 0, and in their mean."""
    field = NumberField()
    columns, target = mixtures_to_zero([list(map(field, vector)) for vector in vectors])
    for k in range(len(columns)):
        mixture = best_mixture(columns, target, [field(int(i == k)) for i in range(len(columns))])
        if mixture is None or not mixture.value:
            return False
    return True


# ---- curves of equilibria ------------------------------------------------------------------------
#
# A function V for a point on a curve of equilibria beside which everything falls back to the curve (Malkin 1952).
#
# Let ``x' = f(x)`` be smooth near the point, its Jacobian have one eigenvalue zero and else stable ones, and let the
# curve ``x = R u + h(u)`` rest, u one number, h a polynomial with values in a subspace beside R: the stable one, or
# that of all states but one, as a curve is often a polynomial of a state.  With
# ``u = L x`` and ``w = K (x - h(u))``, where ``[R S]`` is a basis of both subspaces and ``[L; K]`` its inverse,
#
#     ``u' = a(u) w + ...``,    ``w' = B(u) w + ...``
#
# up to terms of degree two in w, with ``a = L Df S`` and ``B = (K - K h' L) Df S`` on the curve.  Let
#
#     ``V = W(u) - (2 u / det B(0)) a(u) adj B(u) w + k w^T P w``,    ``W' = 2 u det B(u) / det B(0)``.
#
# Then W falls and rises as the second term rises and falls, up to terms of degree two in w, which ``k w^T P w``
# outweighs near the point, for k large.  So V is positive and does not increase: the epidemic ``S' = -S I, I' = S I -
# I`` is stable where S is below one.  V is a proposal in rational numbers; the claims of the theorem on stability are
# proved of it, where the curve bends in coordinates (u, w): V' vanishes along it, which no cut of the cube follows.


SHARES = tuple(Fraction(1, 8**k) for k in range(3))  # of the checked cube, tried in turn
GAINS = (1, 16)  # k, tried in turn
MOST_MONOMIALS = 20  # up to half of the degree of V': beyond that squares take too long
NAMES = tuple("urstpqkmn")  # of a number along the curve, one more than a system has states

Matrix: TypeAlias = list[Vector]


@dataclass(frozen=True)
class RestingCurve:
    """A curve of equilibria near which a point is stable.

    Attributes:
        words: the curve.
        function: V with its conditions, which shows that; None where it was not asked for, or is shown by evidence.
        entry: the theorem with its evidence in coordinates that follow the curve, as a certificate holds it.
    """

    words: str
    function: ExaminedLyapunov | None = None
    entry: Record | None = None


def beside_curve_of_rest(system: SwitchedSystem, *, with_function: bool) -> RestingCurve | None:
    """The curve, and a V that is proved to be positive and not to increase; None where one is not found.

    Args:
        system: in two states or more.
        with_function: whether V is asked for.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    try:
        subject, search = started(system)
        for number, stated, field in smooth_fields(system, subject, search, SHARES):
            curve = curve_of_rest(field)
            if curve is None:
                return None
            words, radius = curve.words(system), system.check.radius * SHARES[number]
            if not with_function:
                return RestingCurve(words)
            for function in curve.functions():
                text = formula_text(function, system.states)
                examined = examine(system, parse_piecewise(text, system.states), radius)
                if examined.decrease is Decrease.WEAK:
                    return RestingCurve(words, examined)
                entry = _shown_along(curve, subject, search, text, stated.record)
                if entry is not None:
                    return RestingCurve(words, None, entry)
    except NotShownError:
        return None
    return None


def _shown_along(curve: Curve, subject: System, search: Search, text: str, cells: Record) -> Record | None:
    """The theorem on stability with evidence in coordinates that follow a curve which bends; None where not shown."""
    if not any(curve.manifold):
        return None
    framed_cells = {**cells, **curve.split.frame(Fraction(1), curve.manifold).written(subject.states)}
    entry = search.tried(subject, "lyapunov", stability_hypotheses(framed_cells, text, STABLE))
    return None if entry is None else entry[0]


def curve_of_rest(field: Sequence[Polynomial]) -> Curve | None:
    """The curve of equilibria of a polynomial field through the origin; None without one, and for other eigenvalues."""
    line = split_at(field)
    if line is None or line.size != 1 or line.count == 1:
        return None
    for split in (line, *line.by_states()):
        manifold = Reduction(split, field).manifold
        along = times(split.right, [variable(1, 0)])
        places = [place + more for place, more in zip(along, manifold, strict=True)]
        if not any(part.on(places, 1) for part in field):
            return Curve(split, tuple(field), tuple(places), tuple(manifold))
    return None


@dataclass(frozen=True)
class Curve:
    """A curve of equilibria through the origin.

    Attributes:
        split: the line along it at the origin, and the subspace beside it.
        field: f, which vanishes on it.
        places: ``R u + h(u)``.
        manifold: h.
    """

    split: Split
    field: tuple[Polynomial, ...]
    places: tuple[Polynomial, ...]
    manifold: tuple[Polynomial, ...]

    def words(self, system: SwitchedSystem) -> str:
        """Its equations, each state as a function of one number, under a name that no state has."""
        name = next(name for name in NAMES if name not in system.states)
        centre = [rational(value) for value in system.check.equilibrium]
        parts = []
        for state, value, displacement in zip(system.states, centre, self.places, strict=True):
            place = constant(1, as_fraction(value)) + displacement
            parts.append(f"{state} = {formula_text(place, [name])}")
        return ", ".join(parts)

    def functions(self) -> Iterator[Polynomial]:
        """V for some k, of no large degree."""
        split, count = self.split, self.split.count
        side = null_basis(split.left)
        onto_side = fmpq_mat(split.frame(Fraction(1)).inverse.tolist()[1:])
        slopes, rates = self._first_terms(side, onto_side)
        adjugate, determinant = _adjugate(rates)
        scale = 1 / determinant.at_origin
        u = variable(1, 0, 2)
        rising = _integral(u * determinant.times(scale))
        mixed = [(u * entry).times(-scale) for entry in _row_times(slopes, adjugate)]
        (centre,) = times(split.left, identity(count))
        off = [variable(count, k) - component.on([centre], count) for k, component in enumerate(self.manifold)]
        beside = times(onto_side, off)
        base = rising.on([centre], count)
        for row, coordinate in zip(mixed, beside, strict=True):
            base += row.on([centre], count) * coordinate
        floats = np.array([[float(entry.at_origin) for entry in row] for row in rates])
        solution = lyapunov_solution(floats, 0.0, np.eye(count - 1))
        degree = base.degree - 1 + max(part.degree for part in self.field)
        if solution is None or comb(count + (degree + 1) // 2, count) > MOST_MONOMIALS:
            return
        square = quadratic_form(solution, DENOMINATOR).on(beside, count)
        for gain in GAINS:
            yield base + square.times(gain)

    def _first_terms(self, side: fmpq_mat, onto_side: fmpq_mat) -> tuple[Vector, Matrix]:
        """``a(u)`` and ``B(u)``."""
        count = self.split.count
        jacobian = [[part.derivative(k).on(self.places, 1) for k in range(count)] for part in self.field]
        by_side = [times(side.transpose(), row) for row in jacobian]  # Df S
        columns = [[row[j] for row in by_side] for j in range(count - 1)]
        slopes = [times(self.split.left, column)[0] for column in columns]
        bend = times(onto_side, [component.derivative(0) for component in self.manifold])  # K h'
        moved = [times(onto_side, column) for column in columns]
        rates = [
            [moved[j][i] - bend[i] * slopes[j] for j in range(count - 1)]  # entry i, j of B
            for i in range(count - 1)
        ]
        return slopes, rates


def _adjugate(matrix: Matrix) -> tuple[Matrix, Polynomial]:
    """The adjugate and the determinant of a matrix of polynomials (Faddeev and LeVerrier)."""
    size = len(matrix)
    auxiliary = [[constant(1, int(i == j)) for j in range(size)] for i in range(size)]
    for step in range(1, size + 1):
        product = [_row_times(row, auxiliary) for row in matrix]
        trace = constant(1, 0)
        for i in range(size):
            trace += product[i][i]
        last = trace.times(Fraction(-1, step))
        if step == size:
            sign = 1 if size % 2 else -1
            return [[entry.times(sign) for entry in row] for row in auxiliary], last.times(-sign)
        auxiliary = [
            [entry + last if i == j else entry for j, entry in enumerate(row)] for i, row in enumerate(product)
        ]
    raise AssertionError("required a matrix with rows")


def _row_times(row: Sequence[Polynomial], matrix: Matrix) -> Vector:
    totals = []
    for j in range(len(matrix[0])):
        total = constant(1, 0)
        for entry, other in zip(row, matrix, strict=True):
            total += entry * other[j]
        totals.append(total)
    return totals


def _integral(value: Polynomial) -> Polynomial:
    """The polynomial in one variable that is zero at the origin and has a derivative."""
    return Polynomial(1, {(power + 1,): factor / (power + 1) for (power,), factor in value.terms.items()})
