"""Nothing stays on a level of V but the point: further functions that rise one after the other (LaSalle's principle).

A *bound* on a part of a cell is ``b = sum_l c_l prod_s h_ls ** m_ls`` with numbers ``c_l > 0`` and polynomials h in the
displacement.  Each power is even, or h is a switching surface with the sign that it has there; so b is not negative.
It is zero where of every term one base is zero.  A rate r with ``r >= b`` is zero at no other points.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

from .cells import Cell, Face, Inclusion, SurfaceSigns, no_switching, pattern, whole_domain
from .formulas import Formula
from .lyapunov import Lyapunov
from .polynomials import Polynomial, constant, lie_derivative, variable
from .positivity import Claim, Inequality, Proofs
from .work import BUDGET, items, rational, require, whole

MAX_OTHERS = 4  # functions beside V
MAX_TERMS, MAX_FACTORS, MAX_POWER, MAX_PLACES = 16, 8, 20, 64
THEN = " then "  # between the name of a place and the path of a step


class Bound:
    """A bound on a face, or on a cell, where some surfaces have given signs.

    Attributes:
        value: b as a polynomial on the face.
        are_linear: whether all bases are linear forms.

    Raises:
        RejectedError: for a bound that may be negative.
    """

    def __init__(self, data: Any, face: Face, signs: SurfaceSigns) -> None:
        self.face, self.value, self.are_linear = face, constant(face.dimension, 0), True
        self.terms: list[list[Polynomial]] = []
        for entry in items(data, most=MAX_TERMS):
            factor, powers = items(entry, 2)
            term = constant(face.dimension, rational(factor))
            require(term.at_origin > 0, "positive factors of a bound")
            bases = []
            for power in items(powers, most=MAX_FACTORS):
                base, exponent = self._power(power, signs)
                term *= face.restricted(base).power(exponent)
                bases.append(base)
            self.value += term
            self.terms.append(bases)

    def _power(self, data: Any, signs: SurfaceSigns) -> tuple[Polynomial, int]:
        """A base and its exponent, where the power is not negative."""
        inclusion = self.face.inclusion
        formula, number = items(data, 2)
        base, exponent = (
            Formula(formula, inclusion.domain.displacement).on(no_switching),
            whole(number, MAX_POWER),
        )
        signed = (inclusion.surfaces.signed(j, s) for j, s in signs.items())
        require(exponent and (exponent % 2 == 0 or base in signed), "even powers, or signed surfaces, in a bound")
        self.are_linear = self.are_linear and base.degree == 1 and base.is_form
        return base, exponent

    def places(self) -> list[Face]:
        """The parts of the face on which the bound is zero, but the point alone and what does not meet the cube."""
        places = [self.face]
        for bases in self.terms:
            places = list(_different(part for place in places for base in bases for part in vanishing(place, base)))
            require(len(places) <= MAX_PLACES, f"zeros of a bound in at most {MAX_PLACES} parts")
        return [place for place in places if not place.is_outside]


def _different(places: Iterator[Face]) -> Iterator[Face]:
    """Each part once."""
    coordinates = set()
    for place in places:
        BUDGET.spend(100)
        if place.coordinates not in coordinates:
            coordinates.add(place.coordinates)
            yield place


def vanishing(place: Face, base: Polynomial) -> Iterator[Face]:
    """The part of a face on which a polynomial is zero, if there is any.

    Raises:
        RejectedError: for a polynomial there that cannot be solved for one variable.
    """
    value = place.restricted(base)
    if not value.degree:
        if not value:
            yield place
        return
    alone = [k for k in range(value.count) if value.slope(k) and sum(bool(e[k]) for e in value.terms) == 1]
    require(alone, "zeros of a bound that can be solved for a variable")
    k, size = alone[0], place.dimension - 1
    others = [variable(size, i - (i > k)) if i != k else constant(size, 0) for i in range(place.dimension)]
    solved = [*others[:k], value.on(others, size).times(-1 / value.slope(k)), *others[k + 1 :]]
    yield replace(place, coordinates=tuple(form.on(solved, size) for form in place.coordinates), dimension=size)


# ---- the steps of the principle ----------------------------------------------------------------


class Chain(Lyapunov):
    """The claims about V and further functions ``W_1, ..., W_k``, which are listed after V on every cell.

    Attributes:
        zeros: bounds by the names of the claims that have one.
    """

    def __init__(self, inclusion: Inclusion, proofs: Proofs, zeros: Any) -> None:
        super().__init__(inclusion, proofs)
        require(type(zeros) is dict, "bounds by the names of claims")
        self.zeros = zeros

    def show_chain(self) -> None:
        """The first of ``-V', W_1', ..., W_k'`` that is not zero is positive off the point, for all velocities.

        *Step 0* is about ``r_0 = -V'``, step j about ``r_j = W_j'``.  Of each field on its closed cell ``r_j >= b_j``
        is shown where the bounds and the rates of the steps before are zero, until a rate is positive or no place is
        left.  A mixture of fields in a cell, none of which has a negative rate, has the rate zero only if all of them
        have.  On a face where a function bends all fields have a common bound: r is the rate of their mixtures that are
        tangent to it.
        """
        for name, place, cells in self.first_places():
            self.show_step(name, (), place, cells)

    def first_places(self) -> Iterator[tuple[str, Face, Sequence[Cell]]]:
        """Each field on its cell, and each face on which a function bends, with its name and the cells beside it."""
        space = whole_domain(self.inclusion)
        for cell in self.inclusion.cells:
            for number, field in cell.fields:
                yield f"cell {pattern(cell.signs)} field {number}", space, [replace(cell, fields=((number, field),))]
        for face, name, cells in self.bends:
            yield f"face {name}", face, cells

    def show_step(self, name: str, path: tuple[int, ...], place: Face, cells: Sequence[Cell]) -> None:
        """One step at one place, and those that follow from it.

        Args:
            name: of the cell and its field, or of the face.
            path: which of the zeros of each bound before the place is; its length is the number of the step.
            place: a part of the cell, or of the face.
            cells: beside it, the first with the polynomials of the functions there.
        """
        if len(path) == len(cells[0].functions):
            self.leave(name, place, cells)
            return
        claim_name = step_name(name, path)
        if path and self.is_left_out(claim_name, place):
            return
        bound = self.bound(claim_name, len(path), place, cells)
        if bound is not None:
            self.proofs.are_forms = self.proofs.are_forms and bound.are_linear
        least = constant(place.dimension, 0) if bound is None else bound.value
        inequalities = tuple(self._rises(place, cells, len(path), least))
        if not inequalities:
            return
        away = not place.holds_origin
        self.proofs.show(Claim(claim_name, inequalities, bound is None, away, self.bounded, self.border))
        for number, part in enumerate([] if bound is None else bound.places()):
            self.show_step(name, (*path, number), part, cells)

    def bound(self, name: str, step: int, place: Face, cells: Sequence[Cell]) -> Bound | None:
        """The bound that the hypotheses state for a claim; None where the rate is claimed to be positive."""
        return Bound(self.zeros[name], place, common_signs(cells)) if name in self.zeros else None

    def leave(self, name: str, place: Face, cells: Sequence[Cell]) -> None:
        """Refuse a place at which all functions may stay constant."""
        require(False, f"nothing that stays on {name}")

    def _rises(self, place: Face, cells: Sequence[Cell], step: int, least: Polynomial) -> Iterator[Inequality]:
        """``r_k - b_k`` of each field, where the rates before are zero.

        The weights of a mixture of fields on a face add their pushes ``grad g . f`` to zero, and those rates.
        """
        first = cells[0]
        rising = (-first.functions[0], *first.functions[1:])  # what rises in the steps
        for cell in cells:
            signs = {j: s for j, s in enumerate(cell.signs) if j not in place.zero}
            guards = self._guards(place, signs, first)
            if guards is None:
                continue
            inside = place.dimension == self.count and not place.zero
            free = frozenset(guards) if inside else frozenset[str]()
            side = tuple(cell.signs[j] for j in place.zero)
            for _, field in cell.fields:
                earlier = tuple(self.rate(place, function, field) for function in rising[:step])
                value = self.rate(place, rising[step], field) - least
                pushes = tuple(self.rate(place, self.inclusion.surfaces.listed[j], field) for j in place.zero)
                if len(pushes) > 1:
                    pushes += earlier
                rate_guards = {} if pushes else {f"sv{k}": -rate for k, rate in enumerate(earlier) if rate.degree}
                yield Inequality(value, {**guards, **rate_guards}, pushes, place.zeros(), side, earlier, free)

    def rate(self, place: Face, function: Polynomial, field: Sequence[Polynomial]) -> Polynomial:
        """The derivative of a function along a field, on a face."""
        return place.restricted(lie_derivative(function, field))


def step_name(name: str, path: Sequence[int]) -> str:
    """The name of a claim of a step at a place."""
    return f"{name}{THEN}{'.'.join(map(str, path))}" if path else name


def common_signs(cells: Sequence[Cell]) -> SurfaceSigns:
    """The signs of surfaces that all cells share."""
    first = cells[0].signs
    return {j: s for j, s in enumerate(first) if all(cell.signs[j] == s for cell in cells)}
