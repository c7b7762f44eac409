"""Faces of cells: where some affine surfaces vanish, in coordinates of their own."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from flint import fmpq, fmpq_mat

from nonsmooth.proofs.kernel.sign_cells import RationalTerms
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms


@dataclass(frozen=True)
class AffineFace:
    """An affine subspace: every coordinate as an affine form in those that stay free.

    Attributes:
        coordinates: one form for each state.
        dimension: how many stay free.
    """

    coordinates: tuple[RationalTerms, ...]
    dimension: int

    def restricted(self, terms: Mapping[Exponents, fmpq]) -> RationalTerms:
        """A polynomial of the states on the subspace."""
        if self.dimension == len(self.coordinates):
            return dict(terms)
        total: Terms = {}
        for exponents, value in terms.items():
            product: Terms = {(0,) * self.dimension: value}
            for form, exponent in zip(self.coordinates, exponents, strict=True):
                for _ in range(exponent):
                    product = multiply_terms(product, form)
            total = add_terms(total, product)
        return total


def whole_space(count: int) -> AffineFace:
    """The face of no surfaces."""
    return AffineFace(tuple({unit(count, k): fmpq(1)} for k in range(count)), count)


def unit(count: int, k: int) -> Exponents:
    """The exponents of one variable."""
    return tuple(int(i == k) for i in range(count))


def build_face(forms: Sequence[Mapping[Exponents, fmpq]], count: int) -> AffineFace | None:
    """Where affine forms vanish together; None where they do nowhere.

    Args:
        forms: of degree one, in all states.
        count: of states.
    """
    if not forms:
        return whole_space(count)
    zero = (0,) * count
    rows = [[*(f.get(unit(count, k), fmpq(0)) for k in range(count)), f.get(zero, fmpq(0))] for f in forms]
    reduced, rank = fmpq_mat(rows).rref()
    pivots = [next(j for j in range(count + 1) if reduced[i, j]) for i in range(rank)]
    if count in pivots:
        return None
    free = [k for k in range(count) if k not in pivots]
    size = len(free)
    coordinates: list[RationalTerms] = []
    for k in range(count):
        if k in free:
            coordinates.append({unit(size, free.index(k)): fmpq(1)})
            continue
        i = pivots.index(k)
        form = {unit(size, j): -reduced[i, other] for j, other in enumerate(free)}
        form[(0,) * size] = -reduced[i, count]
        coordinates.append({e: c for e, c in form.items() if c})
    return AffineFace(tuple(coordinates), size)
