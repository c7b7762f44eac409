"""Rays of equilibria from the checked point, which therefore does not attract: in any number of states.

On a ray from the point, which may lie in switching surfaces, the fields f_i of all cells beside it act.  *If 0 is a
mixture of all f_i at the point with positive weights, and along the ray the f_i stay in the space that they span at the
point, then every place of the ray near the point is one of rest*: 0 lies inside their hull in that space, where it
stays for small changes of the f_i.  Coulomb friction is an example, and relays that agree on a common value.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import combinations

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.kernel.cells import BeyondReachError, SignCells, build_cells, rational_terms
from nonsmooth.proofs.kernel.written import null_basis
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

MOST_SURFACES = 8  # through the point, whose subsets are tried
DENOMINATOR = 1 << 12  # of weights

Ray = tuple[fmpq, ...]
Along = dict[int, list[fmpq]]  # a field along a ray: a vector for each power of the distance


def ray_of_rest(system: SwitchedSystem) -> tuple[Fraction, ...] | None:
    """A direction from the checked point in which all near places are equilibria; None where none is found.

    Raises:
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    cells = build_cells(system, system.check.radius)
    for ray in _rays(cells):
        fields = _beside(cells, ray)
        if fields and _rests(fields):
            return tuple(Fraction(int(value.p), int(value.q)) for value in ray)
    return None


def _rays(cells: SignCells) -> Iterator[Ray]:
    """Axes of the subspaces on which some linear surfaces through the point vanish, in both directions."""
    forms = [rational_terms(own) for own in cells.surfaces if own.degree == 1 and own.is_homogeneous]
    count, seen = len(cells.states), set[Ray]()
    if len(forms) > MOST_SURFACES:
        raise BeyondReachError(f"over {MOST_SURFACES} surfaces through the point")
    rows = [[form.get(tuple(int(j == k) for j in range(count)), fmpq(0)) for k in range(count)] for form in forms]
    for size in range(min(len(rows), count - 1) + 1):
        for chosen in combinations(rows, size):
            basis = null_basis(fmpq_mat(list(chosen) or [[fmpq(0)] * count])).transpose().tolist()
            for axis in basis:
                for side in (1, -1):
                    ray = tuple(value * side for value in axis)
                    if ray not in seen:
                        seen.add(ray)
                        yield ray


def _beside(cells: SignCells, ray: Ray) -> list[Along]:
    """The fields of all cells whose closures hold the ray near the point; none where a curved surface holds it.

    Of linear surfaces through the ray a cell has the signs of one of its places, and so of places near the ray in that
    direction.  Cells beside curved ones may have no points.
    """
    signs = []
    for surface in cells.surfaces:
        values = _along(rational_terms(surface), ray)
        first = min((power for power, value in values.items() if value), default=None)
        if first is None and surface.degree > 1:
            return []
        signs.append(0 if first is None else (1 if values[first] > 0 else -1))
    found = []
    for cell in cells.cells:
        if all(sign in (0, own) for sign, own in zip(signs, cell.signs, strict=True)):
            found += [_field_along(own, ray) for own in cell.velocities]
    return found


def _along(terms: dict[tuple[int, ...], fmpq], ray: Ray) -> dict[int, fmpq]:
    """A polynomial along a ray: its coefficients by powers of the distance."""
    found: dict[int, fmpq] = {}
    for exponents, coefficient in terms.items():
        value = coefficient
        for part, power in zip(ray, exponents, strict=True):
            value *= part**power
        found[sum(exponents)] = found.get(sum(exponents), fmpq(0)) + value
    return found


def _field_along(field: Sequence[dict[tuple[int, ...], fmpq]], ray: Ray) -> Along:
    parts = [_along(part, ray) for part in field]
    powers = {0, *(power for part in parts for power in part)}
    return {power: [part.get(power, fmpq(0)) for part in parts] for power in powers}


def _rests(fields: Sequence[Along]) -> bool:
    """Whether 0 is a mixture with positive weights at the point, and fields stay in the space spanned there."""
    at_point = [own[0] for own in fields]
    size = fmpq_mat(at_point).rank()
    stays = all(fmpq_mat([*at_point, vector]).rank() == size for own in fields for vector in own.values())
    return stays and _is_inside(at_point)


def _is_inside(vectors: Sequence[list[fmpq]]) -> bool:
    """Whether 0 is a sum of all vectors with positive weights: floats propose them, and fractions confirm."""
    kept = null_basis(fmpq_mat(list(vectors)).transpose())
    if not kept.ncols():
        return False
    basis = np.array([[float(value) for value in row] for row in kept.tolist()])
    columns = basis.shape[1]
    solved = solve_program(
        np.r_[np.zeros(columns), -1.0],
        A_ub=np.hstack([-basis, np.ones((len(basis), 1))]),
        b_ub=np.zeros(len(basis)),
        bounds=[(-1, 1)] * columns + [(0, 1)],
    )
    if solved.status != 0 or solved.x[-1] <= 0:
        return False
    rounded = [Fraction(float(value)).limit_denominator(DENOMINATOR) for value in solved.x[:columns]]
    weights = kept * fmpq_mat([[fmpq(value.numerator, value.denominator)] for value in rounded])
    return all(value > 0 for (value,) in weights.tolist())
