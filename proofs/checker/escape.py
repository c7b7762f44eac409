"""One solution that leaves: inside barriers, along a mixture of fields with polynomial weights (Chetaev 1934).

Let S be a linear subspace through the point, perhaps cut by one curved surface, on which some surfaces vanish and all
others have given signs; x is the displacement from the point.  Let cells ``C_k`` be given whose closures hold U, each
with one of its fields ``f_k`` and a polynomial weight ``w_k``, and ``h = sum_k w_k f_k``, with

- ``U = {x in S : p_i(x) > 0 for all i, W(x) > 0}`` in a cube, for polynomials ``p_i`` (barriers) and W, ``W(0) = 0``;
- h tangent to S, ``w_k >= 0`` and ``sum_k w_k > 0`` on the closure of U off the point;
- ``grad p_i . h >= lambda_i p_i`` and ``grad W . h > 0`` on the closure of U off the point, with polynomials lambda_i;
  or ``grad W . h >= speed W^2`` there, with a positive number, where W need not rise on the border of U.

*Theorem.*  If U has points at all small distances, the point is unstable.  *Proof.*  The solution of ``y' = h(y)`` from
such a point stays on S, because h is tangent to it.  As long as it is in U, W rises, so it stays away from the point,
W rises at a speed that is bounded from below (by ``speed W(y(0))^2`` in the second case), and it leaves U after a
finite time.  Then no ``p_i`` is zero, because
``p_i' >= lambda_i p_i`` keeps ``p_i`` above a multiple of ``exp(-L t)``, and W is not zero: it is at the border of the
cube.  With its time divided by ``sum_k w_k > 0`` it is a solution of ``x' in F(x)``, because each ``f_k`` is in F on
the closure of its cell.  One solution that leaves from points at all small distances is enough.

With one cell this is Chetaev's theorem; with the two cells beside a surface and weights that make the normal speeds
cancel it follows a sliding motion, on surfaces that attract and on surfaces that repel; with right-hand sides among
which anything may switch it follows a mixture of them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .cells import Domain, Surfaces, System, no_switching
from .formulas import Formula
from .polynomials import Polynomial, constant, lie_derivative, solve
from .positivity import Claim, Inequality, Proofs, cube_guards
from .theorems import UNSTABLE, Statement
from .work import items, rational, require, take, text, whole

MAX_BARRIERS, MAX_FIELDS = 40, 16


@dataclass(frozen=True)
class Weighted:
    """A field of a mixture.

    Attributes:
        signs: of all surfaces on its cell.
        field: on this cell.
        weight: how much of it is taken.
        toward: a vector that leads from the points of U into the cell.
    """

    signs: tuple[int, ...]
    field: tuple[Polynomial, ...]
    weight: Polynomial
    toward: tuple[Polynomial, ...]


class Escape:
    """The hypotheses as polynomials in the displacement, in units of the half-width of the cube."""

    def __init__(self, system: System, hypotheses: Any, proofs: Proofs) -> None:
        names = "within surfaces signs along mixture barriers function direction"
        within, listed, signs, along, mixture, barriers, function, direction, speed = take(hypotheses, names, "speed")
        require(not any(map(any, system.waves)), "fields that are exact: no sines and cosines")
        self.system, self.count, self.proofs = system, system.count, proofs
        self.domain = Domain(system, within)
        require(self.domain.bounded, "a cube")
        self.surfaces = Surfaces(self.domain, listed, [], proofs)
        self.signs = read_all_signs(signs, len(self.surfaces.listed), "-0+")
        self.forms = [self._polynomial(formula) for formula in items(along, most=self.count)]
        self._read_subspace()
        self.mixture = [self._weighted(entry) for entry in items(mixture, most=MAX_FIELDS)]
        self.rise = self._polynomial(function)
        self.speed = Fraction(0) if speed is None else rational(speed)
        require(speed is None or self.speed > 0, "a positive speed")
        pairs = [items(entry, 2) for entry in items(barriers, most=MAX_BARRIERS)]
        self.barriers = [(self._polynomial(p), self._polynomial(factor)) for p, factor in pairs]
        self.direction = [rational(value) for value in items(direction, self.count)]
        self.guards = self._guards()

    def _polynomial(self, data: Any) -> Polynomial:
        return Formula(data, self.domain.displacement).on(no_switching)

    def _read_subspace(self) -> None:
        """S: where linear forms vanish, among them all surfaces with the sign 0, but one that is curved."""
        self.zero = [j for j, sign in enumerate(self.signs) if not sign]
        listed = self.surfaces.listed
        self.forms += [listed[j] for j in self.zero if listed[j].degree == 1]
        require(all(form.degree == 1 and not form.at_origin for form in self.forms), "linear forms, zero on a subspace")
        coordinates = solve(self.forms, self.count)
        self.coordinates = coordinates or ()
        self.dimension = self.coordinates[0].count
        self.curved = [listed[j] for j in self.zero if self._on(listed[j])]
        require(len(self.curved) <= 1, "at most one curved surface beside linear ones")
        for surface in map(self._on, self.curved):
            regular = any(surface.slope(k) for k in range(self.dimension))
            require(regular and not surface.at_origin, "a curved surface with a tangent plane at the point")

    def _weighted(self, entry: Any) -> Weighted:
        cell, rhs, weight, toward = items(entry, 4)
        signs = read_all_signs(cell, len(self.signs), "-+")
        require(all(a == b for a, b in zip(signs, self.signs, strict=True) if b), "cells beside the subspace")
        fields = [  # all of them are read, so that a system with one that is no formula is refused
            tuple(formula.on(lambda value: self.surfaces.sign_on(signs, value)) for formula in side)
            for side in self.system.fields(self.domain.place)
        ]
        field = fields[whole(rhs, len(fields) - 1)]
        vector = tuple(constant(self.count, rational(value)) for value in items(toward, self.count))
        return Weighted(signs, field, self._polynomial(weight), vector)

    def _on(self, value: Polynomial) -> Polynomial:
        """A polynomial on the subspace."""
        return value.on(self.coordinates, self.dimension)

    def _guards(self) -> dict[str, Polynomial]:
        """The cube, the barriers and W are not negative on the closure of U; a curved surface is zero there."""
        named = {f"s{i}": p for i, (p, _) in enumerate(self.barriers)} | {"sw": self.rise}
        for surface in self.curved:
            named |= {"sg": surface, "sh": -surface}
        inside = {name: self._on(guard) for name, guard in named.items()}
        guards = {name: guard for name, guard in inside.items() if guard.degree}
        return {**cube_guards(self.coordinates, self.dimension), **guards}

    def show(self, name: str, value: Polynomial, *, strict: bool) -> None:
        """A polynomial is positive, or not negative, on the closure of U off the point."""
        restriction = self._on(value)
        if not restriction.degree:
            require(restriction.at_origin > 0 or (not strict and not restriction.at_origin), name)
            return
        counted = frozenset(self.guards) - {"sg", "sh"}
        self.proofs.show(Claim(name, (Inequality(restriction, self.guards, open=counted),), strict))

    def show_cells(self) -> None:
        """U lies inside the closures of the cells: a surface has its sign there, or vanishes and is left behind."""
        inside = [self.rise, *(p for p, _ in self.barriers)]
        for j, (sign, surface) in enumerate(zip(self.signs, self.surfaces.listed, strict=True)):
            signed = surface.times(sign)
            if sign and not any(is_multiple(signed, function) for function in inside):
                self.show(f"surface {j}", signed, strict=True)
        for k, term in enumerate(self.mixture):
            for j in self.zero:
                away = lie_derivative(self.surfaces.listed[j], term.toward).times(term.signs[j])
                self.show(f"beside {k} {j}", away, strict=True)

    def show_mixture(self) -> tuple[Polynomial, ...]:
        """The weights are those of a mixture, which is tangent to S: the field h."""
        total, field = constant(self.count, 0), [constant(self.count, 0)] * self.count
        for k, term in enumerate(self.mixture):
            self.show(f"weight {k}", term.weight, strict=False)
            total += term.weight
            field = [part + term.weight * speed for part, speed in zip(field, term.field, strict=True)]
        self.show("weights", total, strict=True)
        tangent = all(not self._on(lie_derivative(function, field)) for function in (*self.forms, *self.curved))
        require(tangent, "a mixture that is tangent to the subspace")
        return tuple(field)

    def show_rises(self, field: Sequence[Polynomial]) -> None:
        """W rises along h on the closure of U off the point; with a speed, at least by this number times its square."""
        rate = lie_derivative(self.rise, field) - self.rise.power(2).times(self.speed)
        self.show("rises", rate, strict=not self.speed)

    def show_start(self) -> None:
        """U has points at all small distances: S has a curve in the direction, where the lowest terms are positive."""
        for function in (*self.forms, *self.curved):
            slope = sum(function.slope(k) * d for k, d in enumerate(self.direction))
            require(not slope, "a direction along the subspace")
        require(not self._on(self.rise).at_origin, "a function that is zero at the point")
        for value in (self.rise, *(p for p, _ in self.barriers)):
            require(value.lowest_at(self.direction) > 0, "barriers and a function that are positive in the direction")


def show_escape(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """A solution that starts in U, at any small distance, reaches the border of the cube; see the head of this file.

    Hypotheses: ``within`` (half-width of the cube), ``surfaces``, their ``signs`` on U (0 where they vanish on S),
    ``along`` (further linear forms that vanish on S), ``mixture`` (cell, number of the right-hand side, weight, vector
    that leads into the cell), ``barriers`` (p and lambda), ``function`` (W), a ``direction`` in U, and perhaps a
    ``speed``.
    """
    escape = Escape(system, hypotheses, proofs)
    escape.show_start()
    escape.show_cells()
    field = escape.show_mixture()
    for i, (barrier, factor) in enumerate(escape.barriers):
        escape.show(f"barrier {i}", lie_derivative(barrier, field) - factor * barrier, strict=False)
    escape.show_rises(field)
    return [{"stability": UNSTABLE}]


def read_all_signs(data: Any, size: int, allowed: str) -> tuple[int, ...]:
    """The signs of all surfaces from a text."""
    marks = text(data)
    require(len(marks) == size and set(marks) <= set(allowed), f"a sign of {allowed} for each surface")
    return tuple("-0+".index(mark) - 1 for mark in marks)


def is_multiple(value: Polynomial, other: Polynomial) -> bool:
    """Whether a polynomial that is not zero is another one times a positive number."""
    key = max(value.terms)
    factor = value.terms[key] / other.terms[key] if key in other.terms else Fraction(0)
    return factor > 0 and other.times(factor) == value
