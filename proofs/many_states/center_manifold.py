"""Functions V for a point whose linearization has one eigenvalue zero, or one pair ``+-i w``, and else stable ones.

Let ``x' = f(x)`` be smooth near the point with the Jacobian A.  With the projection ``u = L x`` on the d centre
coordinates and ``w = x - R u - h(u)`` in the stable subspace, where h solves

    ``Dh(u) L f(R u + h) = (I - R L) f(R u + h)``    up to some order,

the point behaves as that of the reduced field ``u' = g(u) = L f(R u + h(u))`` (Carr 1981).

*d = 1*: ``g = a u^m + ...``.  *d = 2*: a normal form is sought as ``W = W_2 + W_3 + W_4`` with ``W_2`` a form that the
linear rotation keeps, and ``W' = c W_2^2 + ...`` (Lyapunov's first quantity c).  In the plane, where that is zero, more
terms are taken, up to ``W' = c W_2^k + ...`` with another c (the next quantities).  Then

    ``V = W(u) + q(u) w + k w^T P w``

falls near the point, for k large, where W falls along g: ``W = +-u^2/2``, ``+-u`` for even m, ``+-(W_2 + W_3 + W_4)``.
The row q takes away what is linear in w and of lower weight than ``u^m W'``, w weighing half of that.  V is a
proposal in rational numbers; the claims of the theorem on stability or on instability are proved of it.

Where h has terms of lower weight than w, those of V' cancel along the manifold, and no sum of squares of the states
shows that it falls: that is asked in coordinates (u, w) which follow the manifold.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.polynomials import Polynomial, constant, lie_derivative, unit, variable
from nonsmooth.proofs.checker.positivity import identity
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.cells import StatedCells, fields_seen, sharpened, started, stated_cells
from nonsmooth.proofs.kernel.first_terms import fields_around, lyapunov_solution, quadratic_form
from nonsmooth.proofs.kernel.search import (
    NotShownError,
    SampledProofs,
    Search,
    directed_hypotheses,
    stability_hypotheses,
)
from nonsmooth.proofs.kernel.written import combined, formula_text, null_basis, part_of, rational_slopes, slopes
from nonsmooth.proofs.many_states.examination import ExaminedLyapunov, examine
from nonsmooth.proofs.sums_of_squares.ansatz import monomials_between
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MOST_ORDER = 7  # of the first term of a reduced field in one coordinate
STILL = 2.0**-30  # real parts, over the largest eigenvalue, that are called zero in floats
GAINS = (1, 8, 64, 1024)  # k, tried in turn
DENOMINATOR = 1 << 6  # of P
MOST_POWER = 5  # k in W' = c W_2^k, in the plane
SHARES = tuple(Fraction(1, 4**k) for k in range(7))  # of the checked cube, tried in turn

SCALES = (Fraction(1), Fraction(1, 16))  # of stable coordinates over centre ones, tried in turn
WIDE = 3  # shares that are tried beside a stable subspace

Vector: TypeAlias = list[Polynomial]


@dataclass(frozen=True)
class SplitFrame:
    """Coordinates z = (u, w), with ``x = T z + h(u)``.

    Attributes:
        basis: T, whose first columns span the centre subspace, and the others the stable one.
        inverse: of T.
        bend: h, with values in the stable subspace; empty where it is zero.
    """

    basis: fmpq_mat
    inverse: fmpq_mat
    bend: tuple[Polynomial, ...] = ()

    def written(self, states: Sequence[str]) -> Record:
        """Both maps as cells of a certificate hold them: matrices, or formulas in the names of the states."""
        if not self.bend:
            rows = [[list(map(str, row)) for row in matrix.tolist()] for matrix in (self.basis, self.inverse)]
            return {"frame": rows}
        count, size = len(states), self.bend[0].count
        coordinates = identity(count)
        center = times(self.inverse, coordinates)[:size]
        bent = [
            line + part.on(coordinates[:size], count)
            for line, part in zip(times(self.basis, coordinates), self.bend, strict=True)
        ]
        back = times(self.inverse, [x - part.on(center, count) for x, part in zip(coordinates, self.bend, strict=True)])
        return {"coordinates": [[formula_text(part, states) for part in way] for way in (bent, back)]}


@dataclass(frozen=True)
class SuggestedFunction:
    """A V that the reduced field suggests.

    Attributes:
        function: V.
        attracts: whether it shows asymptotic stability, not instability.
        words: what the reduced field does.
        is_whole: whether there is no stable subspace beside it.
        frames: coordinates of the centre and stable subspaces in which it may be shown that V falls.
    """

    function: Polynomial
    attracts: bool
    words: str
    is_whole: bool
    frames: tuple[SplitFrame | None, ...]


def center_functions(field: Sequence[Polynomial]) -> Iterator[SuggestedFunction]:
    """Proposals of V for a polynomial field that vanishes at the origin; none where the eigenvalues are others.

    Args:
        field: n polynomials in n variables.
    """
    split = split_at(field)
    if split is None:
        return
    reduced = Reduction(split, field)
    leading = reduced.line() if split.size == 1 else reduced.circle()
    if leading is not None:
        yield from reduced.functions(leading)


# ---- centre and stable subspace ------------------------------------------------------------------


@dataclass(frozen=True)
class Split:
    """The centre subspace of a matrix A and one beside it: the stable one, or for d = 1 any other.

    Attributes:
        matrix: A, of shape (n, n).
        right: R, a basis of the centre subspace, of shape (n, d).
        left: L, with ``L R = I``, which vanishes on the subspace beside it, of shape (d, n).
        center: ``L A R``, of shape (d, d).
    """

    matrix: fmpq_mat
    right: fmpq_mat
    left: fmpq_mat
    center: fmpq_mat

    @property
    def count(self) -> int:
        """The dimension n."""
        return int(self.matrix.nrows())

    @property
    def size(self) -> int:
        """The dimension d of the centre subspace."""
        return int(self.right.ncols())

    @property
    def onto_center(self) -> fmpq_mat:
        """``R L``."""
        return self.right * self.left

    @property
    def hurwitz(self) -> fmpq_mat:
        """A on the subspace beside the centre, and -1 on the centre."""
        beside = _identity(self.count) - self.onto_center
        return beside * self.matrix * beside - self.onto_center

    def by_states(self) -> Iterator[Split]:
        """Of one centre coordinate, the same line beside the axes of all other states, for each that u may be."""
        for k in range(self.count):
            if self.right[k, 0]:
                left = fmpq_mat(1, self.count, [fmpq(int(i == k)) / self.right[k, 0] for i in range(self.count)])
                yield replace(self, left=left)

    def frame(self, scale: Fraction, bend: Sequence[Polynomial] = ()) -> SplitFrame:
        """A basis of both subspaces in columns, that of the stable one scaled, beside h."""
        stable = null_basis(self.left) * as_fmpq(scale)
        basis = fmpq_mat([left + right for left, right in zip(self.right.tolist(), stable.tolist(), strict=True)])
        return SplitFrame(basis, basis.inv(), tuple(bend))

    @property
    def is_along_axes(self) -> bool:
        """Whether both subspaces are spanned by axes."""
        return all(sum(map(bool, column)) == 1 for column in self.frame(Fraction(1)).basis.transpose().tolist())


def split_at(field: Sequence[Polynomial]) -> Split | None:
    """The subspaces at the origin; None unless one eigenvalue is zero, or a pair imaginary, and all others stable.

    Of a pair ``+-i w`` the number ``w^2`` has to be rational.
    """
    count = len(field)
    matrix = fmpq_mat([rational_slopes(part) for part in field])
    values = np.linalg.eigvals(np.array(list(map(slopes, field)), dtype=float))
    size = max(max_norm(values), np.finfo(float).tiny)
    still = [value for value in values if abs(value.real) <= STILL * size]
    if any(part.at_origin for part in field) or max(value.real for value in values) > STILL * size:
        return None
    if len(still) == 1:
        return _split_by(matrix, matrix, 1)
    if len(still) == 2 and min(abs(value.imag) for value in still) > STILL * size:
        square = Fraction(float(abs(still[0]) ** 2)).limit_denominator(1 << 16)
        return _split_by(matrix, matrix * matrix + _identity(count) * as_fmpq(square), 2)
    return None


def _split_by(matrix: fmpq_mat, vanishing: fmpq_mat, size: int) -> Split | None:
    """The split where a polynomial in A vanishes on the centre subspace alone."""
    right, left = null_basis(vanishing), null_basis(vanishing.transpose()).transpose()
    if right.ncols() != size or left.nrows() != size:
        return None
    try:
        left = (left * right).inv() * left
    except ZeroDivisionError:
        return None
    return Split(matrix, right, left, left * matrix * right)


def _identity(count: int) -> fmpq_mat:
    return fmpq_mat([[fmpq(int(i == j)) for j in range(count)] for i in range(count)])


# ---- the reduced field ---------------------------------------------------------------------------


@dataclass(frozen=True)
class Leading:
    """What the reduced field does.

    Attributes:
        potential: W, which falls along it, in the centre coordinates.
        weight: the degree of the first term of its derivative.
        factor: a, or c.
        attracts: whether W is positive.
        words: the same as a clause.
    """

    potential: Polynomial
    weight: int
    factor: Fraction
    attracts: bool
    words: str


class Reduction:
    """The centre manifold of a field, and the functions V that it suggests.

    Args:
        split: the subspaces.
        field: vanishing at the origin.
    """

    def __init__(self, split: Split, field: Sequence[Polynomial]) -> None:
        self.split, self.field = split, field
        self.manifold = self._manifold(MOST_ORDER if split.size == 1 else 3)

    def _manifold(self, order: int) -> Vector:
        """The manifold h up to an order: its terms of degree j solve ``Dh_j A_c u - A h_j = r_j``."""
        split = self.split
        manifold = [constant(split.size, 0)] * split.count
        for degree in range(2, order + 1):
            moved = self._along(manifold, degree)
            carried = [self._carried(component, moved, degree) for component in manifold]
            stable = times(_identity(split.count) - split.onto_center, moved)
            missing = [part_of(velocity - other, degree) for velocity, other in zip(stable, carried, strict=True)]
            manifold = [
                component + more for component, more in zip(manifold, self._homological(missing, degree), strict=True)
            ]
        return manifold

    def _along(self, manifold: Sequence[Polynomial], degree: int) -> Vector:
        """``f(R u + h(u))`` up to a degree."""
        size = self.split.size
        places = times(self.split.right, identity(size))
        places = [place + more for place, more in zip(places, manifold, strict=True)]
        return [_composed(part, places, size, degree) for part in self.field]

    def _carried(self, value: Polynomial, moved: Sequence[Polynomial], degree: int) -> Polynomial:
        """``grad(value) . L f`` up to a degree."""
        return _cut(lie_derivative(value, times(self.split.left, moved)), degree)

    def _homological(self, missing: Sequence[Polynomial], degree: int) -> Vector:
        """The forms h in the stable subspace with ``Dh A_c u - A h = r``, for r there."""
        split = self.split
        monomials = monomials_between(split.size, degree, degree)
        place = {key: i for i, key in enumerate(monomials)}
        count, width = split.count, len(monomials)
        rows = [[fmpq(0)] * (count * width) for _ in range(count * width)]
        for j, key in enumerate(monomials):
            rotated = self._rotated(Polynomial(split.size, {key: Fraction(1)}))
            for k in range(count):
                for other, value in rotated.terms.items():
                    rows[k * width + place[other]][k * width + j] += as_fmpq(value)
                for i in range(count):
                    rows[i * width + j][k * width + j] -= split.hurwitz[i, k]
        right = [as_fmpq(form.terms.get(key, Fraction(0))) for form in missing for key in monomials]
        solved = fmpq_mat(rows).solve(fmpq_mat(len(right), 1, right))
        parts = [[as_fraction(solved[k * width + j, 0]) for j in range(width)] for k in range(count)]
        return [Polynomial(split.size, dict(zip(monomials, part, strict=True))) for part in parts]

    def _rotated(self, value: Polynomial) -> Polynomial:
        """``grad(value) . A_c u``."""
        size = self.split.size
        return lie_derivative(value, times(self.split.center, identity(size)))

    # -- what it does

    def line(self) -> Leading | None:
        """One centre coordinate: the first term of the reduced field decides."""
        (speed,) = times(self.split.left, self._along(self.manifold, MOST_ORDER))
        if not speed:
            return None
        order = min(map(sum, speed.terms))
        factor = speed.terms[(order,)]
        attracts = bool(order % 2) and factor < 0
        sign = 1 if attracts else -1
        words = f"on the centre manifold u' = {_multiple(factor, 'u', order)} + ..."
        if order % 2:
            return Leading(variable(1, 0).power(2).times(Fraction(sign, 2)), order + 1, factor, attracts, words)
        return Leading(variable(1, 0, -1 if factor > 0 else 1), order, factor, False, words)

    def circle(self) -> Leading | None:
        """Two centre coordinates that turn: the first of Lyapunov's quantities that is not zero decides."""
        most = 2 if self.split.count > self.split.size else MOST_POWER
        moved = self._along(self.manifold, 2 * most - 1)
        potential = invariant = self._kept()
        for power in range(2, most + 1):
            odd = self._averaged(part_of(self._carried(potential, moved, 2 * power - 1), 2 * power - 1), None)
            if odd is None:
                return None
            potential -= odd[0]
            even = self._averaged(
                part_of(self._carried(potential, moved, 2 * power), 2 * power), invariant.power(power)
            )
            if even is None:
                return None
            potential, quantity = potential - even[0], even[1]
            if quantity:
                words = f"on the centre manifold W = u**2 + ... has W' = {_multiple(quantity, 'W', power)} + ..."
                return Leading(potential if quantity < 0 else -potential, 2 * power, quantity, quantity < 0, words)
        return None

    def _kept(self) -> Polynomial:
        """The form ``u_1^2 + ...`` that the linear rotation ``A_c = (a, b; c, -a)`` keeps, where ``b c < -a^2``."""
        a, b, c = (as_fraction(self.split.center[i, j]) for i, j in ((0, 0), (0, 1), (1, 0)))
        form = Polynomial(2, {(2, 0): c, (1, 1): -2 * a, (0, 2): -b})
        return form.times(1 / c)

    def _averaged(self, missing: Polynomial, invariant: Polynomial | None) -> tuple[Polynomial, Fraction] | None:
        """The form F and the number c with ``grad F . A_c u + c W_2^k = r`` for the form r.

        Args:
            missing: r.
            invariant: ``W_2^k``, of the degree of r; c is 0 without it.
        """
        degree = max(map(sum, missing.terms), default=0)
        if not degree:
            return missing, Fraction(0)
        monomials = monomials_between(2, degree, degree)
        columns = [self._rotated(Polynomial(2, {key: Fraction(1)})) for key in monomials]
        columns += [invariant] if invariant is not None else []
        rows = [[as_fmpq(column.terms.get(key, Fraction(0))) for column in columns] for key in monomials]
        right = [as_fmpq(missing.terms.get(key, Fraction(0))) for key in monomials]
        if invariant is not None:  # multiples of it may be added to F
            rows.append([fmpq(1), *[fmpq(0)] * len(monomials)])
            right.append(fmpq(0))
        try:
            solved = fmpq_mat(rows).solve(fmpq_mat(len(right), 1, right))
        except ZeroDivisionError:
            return None
        values = [as_fraction(solved[i, 0]) for i in range(len(rows))]
        form = Polynomial(2, dict(zip(monomials, values, strict=False)))
        return form, values[-1] if invariant is not None else Fraction(0)

    # -- the functions

    def functions(self, leading: Leading) -> Iterator[SuggestedFunction]:
        """V for some k."""
        split = self.split
        count, half = split.count, leading.weight // 2
        center = times(split.left, identity(count))
        beside = times(_identity(count) - split.onto_center, identity(count))
        manifold = [_cut(component, half) for component in self.manifold]
        off = [form - other.on(center, count) for form, other in zip(beside, manifold, strict=True)]
        base = leading.potential.on(center, count)
        for row, offset in zip(self._mixed(leading), off, strict=True):
            base += row.on(center, count) * offset
        frames = self._frames(leading, manifold)
        for gain in GAINS if count > split.size else (0,):
            function = base + self._square(off).times(gain) if gain else base
            yield SuggestedFunction(function, leading.attracts, leading.words, count == split.size, frames)

    def _frames(self, leading: Leading, manifold: Sequence[Polynomial]) -> tuple[SplitFrame | None, ...]:
        """Those in which V' may be negative: the states, both subspaces, or the manifold where it bends too much."""
        split = self.split
        if split.count == split.size:
            return (None,)
        if any(sum(e) < leading.weight // 2 for component in manifold for e in component.terms):
            return tuple(split.frame(scale, manifold) for scale in SCALES)
        skew = tuple(map(split.frame, SCALES))
        return skew if leading.attracts and not split.is_along_axes else (None, *skew)

    def _square(self, off: Sequence[Polynomial]) -> Polynomial:
        """``w^T P w`` with ``A^T P + P A = -I`` on the stable subspace, rounded."""
        count, hurwitz = self.split.count, self.split.hurwitz
        floats: Floats = np.array([[float(as_fraction(hurwitz[i, j])) for j in range(count)] for i in range(count)])
        solution = lyapunov_solution(floats, 0.0, np.eye(count))
        if solution is None:
            return constant(count, 0)
        return quadratic_form(solution, DENOMINATOR).on(off, count)

    def _mixed(self, leading: Leading) -> Vector:
        """The row q, for one centre coordinate: ``q A = -(W' L Df + q (B - A) + q' g)``, degree by degree.

        B is the derivative by w of ``w' = (I - R L) f - Dh L f``.
        """
        split, half = self.split, leading.weight // 2
        mixed = [constant(split.size, 0)] * split.count
        if split.size > 1 or split.count == 1:
            return mixed
        beside = _identity(split.count) - split.onto_center
        places = times(split.right, [variable(1, 0)])
        places = [place + more for place, more in zip(places, self.manifold, strict=True)]
        jacobian = [[_composed(part.derivative(k), places, 1, half) for k in range(split.count)] for part in self.field]
        (speed,) = times(split.left, self._along(self.manifold, half + 1))
        slope = leading.potential.derivative(0)
        for degree in range(1, half):
            total = [constant(1, 0)] * split.count
            for k in range(split.count):
                column = [row[k] for row in jacobian]
                (center,) = times(split.left, column)
                entry = slope * center
                for i, part in enumerate(times(beside, column)):
                    entry += mixed[i] * (part - self.manifold[i].derivative(0) * center)
                total[k] = entry
            total = times(beside.transpose(), total)
            total = [part_of(entry + mixed[k].derivative(0) * speed, degree) for k, entry in enumerate(total)]
            solved = times(split.hurwitz.transpose().inv(), total)
            mixed = [entry - more for entry, more in zip(mixed, solved, strict=True)]
        return mixed


# ---- polynomials in the centre coordinates -------------------------------------------------------


def times(matrix: fmpq_mat, vector: Sequence[Polynomial]) -> Vector:
    """A matrix times a vector of polynomials."""
    return [combined(vector, list(map(as_fraction, row))) for row in matrix.tolist()]


def _cut(value: Polynomial, degree: int) -> Polynomial:
    """The terms up to a degree."""
    return Polynomial(value.count, {e: c for e, c in value.terms.items() if sum(e) <= degree})


def _composed(value: Polynomial, places: Sequence[Polynomial], count: int, degree: int) -> Polynomial:
    """The terms up to a degree where every variable is a polynomial in ``count`` others without a constant term.

    A factor of a product of k is needed up to ``degree - k + 1``: the others are of degree one at least.
    """
    total = constant(count, 0)
    for power in range(degree + 1):
        needed = [_cut(place, degree + 1 - power) for place in places]
        total += part_of(value, power).on(needed, count)
    return _cut(total, degree)


def _multiple(factor: Fraction, name: str, power: int) -> str:
    """Such as ``-3/4*u**3``."""
    return formula_text(Polynomial(1, {(power,): factor}), [name])


# ---- functions that are proved -------------------------------------------------------------------


def coordinates_in(cells: Record, states: Sequence[str]) -> list[str]:
    """What is small where the claims of a theorem hold: the states, or the coordinates of a frame of its cells."""
    if "frame" in cells:
        return [_form_text(row, states) for row in cells["frame"][1]]
    return cells["coordinates"][1] if "coordinates" in cells else list(states)


def show_by_center_manifold(system: SwitchedSystem) -> tuple[SuggestedFunction, ExaminedLyapunov | Record] | None:
    """A V that the reduced field suggests and that is proved on a cube.

    With it come its conditions, where the point attracts; else, and in other coordinates, the entry of a certificate.
    None where the field is not smooth near the point, where its eigenvalues are others, and where nothing is shown.

    Args:
        system: in two states or more.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    try:
        subject, search = started(system)
        for number, stated, field in smooth_fields(system, subject, search, SHARES):
            proposals = list(center_functions(field))
            if not proposals or (number == WIDE and not proposals[0].is_whole):
                return None
            for proposal in proposals:
                outcome = _shown(system, subject, stated, proposal, search)
                if outcome is not None:
                    return proposal, outcome
    except NotShownError:
        return None
    return None


def smooth_fields(
    system: SwitchedSystem, subject: System, search: Search, shares: Sequence[Fraction]
) -> Iterator[tuple[int, StatedCells, Vector]]:
    """On cubes on which one field is smooth near the point: the number of the cube, its cells, and the field there.

    Args:
        system: in two states or more.
        subject: the same for the checker.
        search: with what was shown before.
        shares: of the checked cube, the smallest last.

    Raises:
        NotShownError: where the checker refuses the cells.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    if len(fields_seen(stated_cells(system, system.check.radius * shares[-1]), subject.stated)) > 1:
        return
    for number, share in enumerate(shares):
        stated = sharpened(stated_cells(system, system.check.radius * share), subject, search)
        around = {tuple(field) for field in fields_around(stated, subject.stated, search)}
        if len(around) == 1:
            yield number, stated, unscaled(around.pop(), stated)


def unscaled(field: Sequence[Polynomial], stated: StatedCells) -> Vector:
    """A field of the displacement, from one of the displacement in units of half the side of the cube."""
    size = as_fraction(stated.cells.radius)
    return [Polynomial(part.count, {e: c / size ** sum(e) for e, c in part.terms.items()}) for part in field]


def _shown(
    system: SwitchedSystem, subject: System, stated: StatedCells, proposal: SuggestedFunction, search: Search
) -> ExaminedLyapunov | Record | None:
    """A proposal that is proved, or None; floats refute most that are not."""
    text = formula_text(proposal.function, system.states)
    for frame in proposal.frames:
        record = {**stated.record, **({} if frame is None else frame.written(system.states))}
        theorem, hypotheses = "lyapunov", stability_hypotheses(record, text, ASYMPTOTICALLY_STABLE)
        try:
            if not proposal.attracts:
                theorem, hypotheses = "instability", directed_hypotheses(subject, record, text, search)
            SampledProofs().entry(subject, theorem, hypotheses)
            if not proposal.attracts or frame is not None:
                return search.entry(subject, theorem, hypotheses)[0]
        except NotShownError:
            continue
        formula, radius = parse_piecewise(text, system.states), system.field(stated.cells.radius)
        function = examine(system, formula, radius, effort=Effort.STRICT)
        if function.decrease is Decrease.STRICT:
            return function
    return None


def _form_text(row: Sequence[str], states: Sequence[str]) -> str:
    count = len(states)
    form = Polynomial(count, {unit(count, k): Fraction(value) for k, value in enumerate(row)})
    return formula_text(form, states)
