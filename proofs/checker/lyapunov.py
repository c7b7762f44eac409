"""Theorems with a function V: stability, asymptotic stability, instability, regions and rates of an inclusion.

V is continuous, one polynomial on each cell, and zero at the point.

*Falls.*  Along a solution, at almost all times at which exactly the bending surfaces ``g_j, j in B`` vanish, the
velocity v has ``grad g_j . v = 0``; so V has the derivative ``grad P . v`` for any polynomial P that V has beside this
face, and v is a mixture of the fields f of the cells that meet there.  If ``(grad P + sum_j mu_j grad g_j) . f < 0``
for functions mu_j on the face and all these f, it is negative.  B runs through all sets of bending surfaces that vanish
together; for B empty these are the conditions on closed cells.  This holds for every solution, on faces that attract
and that repel.

*Theorem* (Filippov 1988, Lyapunov).  V positive and falling off the point: asymptotically stable; not rising: stable.
Falling, and negative at points at all small distances: unstable.  Where ``V >= level`` on the border of the cube no
solution leaves ``V < level``.  ``V' <= -kappa V`` or ``V' <= -kappa`` is the same with another shift.

*Quotients.*  V may be ``P/Q`` with one polynomial Q that is positive off the point.  Signs of V are those of P, and
``Q^2 V' = Q P' - P Q'`` takes the place of V'.  Where ``Q(0) = 0``, Q is a form and P has terms of higher degree than Q
alone: then V tends to 0 at the point, and what follows from its fall off the point is the same.

*Roots.*  V may be about signed roots ``w = sign(x) Abs(x)**(1/q)`` of states x: a polynomial in w on each cell, with
``dV/dx = (dV/dw)/(q Abs(w)**(q - 1))`` again one.  So V is Lipschitz in x, with continuous derivatives on each closed
cell, and the conditions are those above with this gradient and the velocities of the states.  Where q is even, ``w**2``
may be ``Abs(x)``: V may bend at ``w = 0`` though it is one polynomial around it.

*Logarithms.*  V may be ``Q + ln(1 + P)`` with one polynomial P, where P and Q are not negative: V is positive where
``Q + P`` is, and bounded only where this is, and ``(1 + P) V' = (1 + P) Q' + P'``.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from functools import cached_property
from typing import TypeAlias

from .cells import Cell, Face, Inclusion, SurfaceSigns, components, pattern, whole_domain
from .polynomials import Polynomial, constant, lie_derivative, solve, variable
from .positivity import Claim, Inequality, Proofs
from .work import BUDGET, require

Shift: TypeAlias = Callable[[Cell], Polynomial]


class Lyapunov:
    """The claims about a function V on a domain, each shown by its evidence.

    Args:
        system: the subject.
        cells: half the side of the cube or null, the surfaces, the patterns without points.
        function: V in the displacement: a formula, or one for each of some patterns of signs.
        second: null, or the functions W_1, ..., W_k of :meth:`show_chain`, and the bounds of rates by names of claims.
        proofs: show the claims.
    """

    def __init__(self, inclusion: Inclusion, proofs: Proofs) -> None:
        self.inclusion, self.proofs = inclusion, proofs
        self.below: Fraction | None = None
        self.border = ""
        self.bottom: Polynomial | None = None  # Q, where V is a quotient
        self.inside: Polynomial | None = None  # P, where V holds ln(1 + P)
        self.count, self.bounded = inclusion.count, inclusion.domain.bounded

    def potential(self, cell: Cell) -> Polynomial:
        """V on a cell; with a denominator P, and with a logarithm the sum of Q and P."""
        polynomial = self.listed(cell)
        return polynomial if self.inside is None else polynomial + self.inside

    def listed(self, cell: Cell) -> Polynomial:
        """The first of the functions of a cell."""
        return cell.functions[0]

    def divide_by(self, bottom: Polynomial) -> None:
        """Let V be a quotient: what is listed as its polynomials is P; see the head of this file."""
        low = bottom.at_origin
        require(low > 0 or (not low and bottom.is_form), "a denominator that is a form, or positive at the point")
        inside = Inequality(bottom, whole_domain(self.inclusion).guards({}) or {})
        self.proofs.show(Claim("denominator", (inside,), strict=True, bounded=self.bounded))
        lowest = [sum(exponents) for cell in self.inclusion.around() for exponents in self.potential(cell).terms]
        require(low or min(lowest, default=0) > bottom.degree, "a V that is zero at the point")
        self.bottom = bottom

    def add_logarithm(self, inside: Polynomial) -> None:
        """Let V be ``Q + ln(1 + P)``: what is listed as its polynomials is Q; see the head of this file."""
        here = Inequality(inside, whole_domain(self.inclusion).guards({}) or {})
        self.proofs.show(Claim("logarithm", (here,), strict=False, bounded=self.bounded))
        for name, signs, cell in self.inclusion.pieces():
            guards = self._guards(whole_domain(self.inclusion), signs, cell) or {}
            self._show_on_cell(f"beside {name}", self.listed(cell), guards, strict=False)
        self.inside = inside

    def derivative(self, cell: Cell, field: Sequence[Polynomial]) -> Polynomial:
        """V' along a field, times ``1 + P``, or times the square of the denominator."""
        p = self.listed(cell)
        derivative = self.inclusion.along(field, p, cell)
        if self.inside is not None:
            return derivative + derivative * self.inside + lie_derivative(self.inside, field)
        return derivative if self.bottom is None else derivative * self.bottom - p * lie_derivative(self.bottom, field)

    def above(self, cell: Cell, level: Fraction) -> Polynomial:
        """``V - level``, times the denominator."""
        whole = constant(self.count, level)
        return self.potential(cell) - (whole if self.bottom is None else self.bottom * whole)

    def require_below(self, level: Fraction) -> None:
        """Ask everything, but what concerns the border of the cube, of points with ``V < level`` alone.

        The inequalities are closed, so that they hold where V is the level; but there they need not be strict.  Whoever
        states starts below the level requires that it is positive, on a cube.
        """
        self.below, self.border = level, "sl"

    # -- one claim each

    def show_zero(self) -> None:
        """V is zero at the point."""
        require(
            all(not self.potential(cell).at_origin for cell in self.inclusion.around()), "a V that is zero at the point"
        )

    def show_positive(self) -> None:
        """V > 0 off the point."""
        for name, signs, cell in self.inclusion.pieces():
            guards = self._guards(whole_domain(self.inclusion), signs, cell) or {}
            self._show_on_cell(f"V {name}", self.potential(cell), guards, strict=True)

    def show_below(self, name: str, signs: SurfaceSigns, cell: Cell, bound: Polynomial) -> None:
        """V is at most a bound on a piece."""
        guards = self._guards(whole_domain(self.inclusion), signs, cell) or {}
        self._show_on_cell(f"size {name}", bound - self.potential(cell), guards, strict=False)

    def show_falls(self, prefix: str, shift: Shift, *, strict: bool) -> None:
        """``V' + shift < 0`` off the point, or ``<= 0``: on closed cells and on all faces on which V bends."""
        self.show_falls_on_cells(prefix, shift, strict=strict)
        for face, name, cells in self.bends:
            self._show_falls_on(face, name, cells, prefix, shift, strict=strict)

    def show_falls_on_cells(self, prefix: str, shift: Shift, *, strict: bool) -> None:
        """The same on closed cells alone."""
        space = whole_domain(self.inclusion)
        for cell in self.inclusion.cells:
            guards = self._guards(space, dict(enumerate(cell.signs)), cell) or {}
            for number, field in cell.fields:
                value = -(self.derivative(cell, field) + shift(cell))
                name = f"{prefix}cell {pattern(cell.signs)} field {number}"
                self._show_on_cell(name, value, guards, strict=strict)

    def show_falls_by_square(self, speed: Fraction) -> None:
        """``V' <= -speed V^2``."""
        self.show_falls("", lambda cell: self.potential(cell).power(2).times(speed), strict=False)

    def _show_on_cell(self, name: str, value: Polynomial, guards: dict[str, Polynomial], *, strict: bool) -> None:
        inside = Inequality(value, guards, open=frozenset(guards))
        self.proofs.show(Claim(name, (inside,), strict, bounded=self.bounded, border=self.border))

    def _guards(self, face: Face, signs: SurfaceSigns, cell: Cell) -> dict[str, Polynomial] | None:
        """Guards of surfaces and cube on a face, and that V is below the level; None where one is a negative number."""
        guards = face.guards(signs)
        if guards is None or self.below is None:
            return guards
        guard = -face.restricted(self.above(cell, self.below))
        if guard.degree:
            return {**guards, "sl": guard}
        return guards if guard.at_origin > 0 else None

    @cached_property
    def bends(self) -> list[tuple[Face, str, list[Cell]]]:
        """The parts of faces on which claims about closed cells do not suffice, by name, with the cells beside them."""
        bends = []
        for face in self.inclusion.faces():
            zero = pattern(0 if j in face.zero else None for j in range(len(self.inclusion.surfaces.listed)))
            if self.is_left_out(zero, face):
                continue
            for name, cells in self._groups(face):
                if not self._is_settled(face, cells):
                    bends.append((face, name, cells))
        return bends

    def _is_settled(self, face: Face, cells: Sequence[Cell]) -> bool:
        """Whether the claims about closed cells suffice on a face.

        They do where V is one polynomial around it, and does not bend for all that.  They do too where all cells have
        the same fields on the face: V falls along all of these by the polynomial of any cell that reaches the place.
        """
        domain, surfaces = self.inclusion.domain, self.inclusion.surfaces.listed
        if all(cell.functions == cells[0].functions for cell in cells):
            return not any(domain.system.bends_at(surfaces[j], domain) for j in face.zero)
        fields = [{tuple(map(face.restricted, field)) for _, field in cell.fields} for cell in cells]
        return all(cell_fields == fields[0] for cell_fields in fields)

    def is_left_out(self, name: str, face: Face) -> bool:
        """Whether it is shown that the surfaces of a face vanish together at no place but the checked point.

        The evidence is of ``g_1^2 + ... + g_k^2 > 0`` off the point, for the curved surfaces on the subspace of the
        others.  Without it the face counts.
        """
        zeros = face.zeros().values()
        if not zeros or (len(zeros) == 1 and face.dimension == self.count):
            return False
        total = constant(face.dimension, 0)
        for surface in zeros:
            total += surface * surface
        apart = Inequality(total, face.guards({}) or {})
        away = not face.holds_origin
        return self.proofs.shows(Claim(f"apart {name}", (apart,), strict=True, at_origin=away, bounded=self.bounded))

    def _groups(self, face: Face) -> Iterator[tuple[str, list[Cell]]]:
        """The cells beside a face by the signs of the bending surfaces that do not vanish on it.

        Steps of one sign join the cells that hold a point of it; so the polynomials of a function on them agree there.
        Cells that no such steps join have no common point: they are parts of their own.
        """
        groups: dict[str, list[Cell]] = {}
        bending = self.inclusion.bending
        for cell in self.inclusion.cells:
            BUDGET.spend(1 + len(cell.signs) // 4)
            signs = (0 if j in face.zero else s if j in bending else None for j, s in enumerate(cell.signs))
            groups.setdefault(pattern(signs), []).append(cell)
        for name, cells in groups.items():
            parts = components(set(map(self.inclusion.signs_of_piece, cells)), self.inclusion.parted)
            for number, part in enumerate(parts):
                cells_of_part = [cell for cell in cells if self.inclusion.signs_of_piece(cell) in part]
                yield (name if len(parts) == 1 else f"{name} part {number}"), cells_of_part

    def _show_falls_on(
        self, face: Face, name: str, cells: Sequence[Cell], prefix: str, shift: Shift, *, strict: bool
    ) -> None:
        """``(grad P + sum_j mu_j grad g_j) . f + shift < 0`` on a face, for each field f beside it."""
        first, inequalities = cells[0], []
        for cell in cells:
            others = {j: s for j, s in enumerate(cell.signs) if j not in face.zero}
            guards = self._guards(face, others, first)
            if guards is None:
                continue
            for _, field in cell.fields:
                value = face.restricted(self.derivative(first, field) + shift(first))
                side = tuple(cell.signs[j] for j in face.zero)
                inequalities.append(Inequality(-value, guards, self._pushes(face, field), face.zeros(), side))
        if inequalities:
            away = not face.holds_origin
            self.proofs.show(
                Claim(f"{prefix}face {name}", tuple(inequalities), strict, away, self.bounded, self.border)
            )

    def _pushes(self, face: Face, field: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
        """``-grad g_j . f`` of the surfaces that vanish on a face."""
        return tuple(-face.restricted(self.inclusion.across(field, j)) for j in face.zero)

    def show_gradient(self, bound: Fraction) -> None:
        """``|grad V| <= bound`` on every closed cell, and V bends on at most one surface at a time off the point.

        The gradient and the bound are in units of the half-width of the cube.
        """
        single = all(len(face.zero) == 1 for face, _, _ in self.bends)
        require(single, "surfaces on which V bends that meet at the point alone")
        for name, signs, cell in self.inclusion.pieces():
            guards = self._guards(whole_domain(self.inclusion), signs, cell) or {}
            potential = self.potential(cell)
            square = lie_derivative(potential, [potential.derivative(k) for k in range(self.count)])
            room = constant(self.count, bound * bound) - square
            self._show_on_cell(f"gradient {name}", room, guards, strict=False)

    def show_border(self, level: Fraction) -> None:
        """V is at least the level on the border of the cube."""
        for name, signs, cell in self.inclusion.pieces():
            for k in range(self.count):
                for side in (1, -1):
                    coordinates = solve([variable(self.count, k) - constant(self.count, side)], self.count)
                    face = Face(self.inclusion, (), (), coordinates or (), self.count - 1)
                    guards = face.guards(signs)
                    if guards is not None:
                        above = face.restricted(self.above(cell, level))
                        place = f"border {name} {'-0+'[side + 1]}{k}"
                        self.proofs.show(Claim(place, (Inequality(above, guards),), strict=False))

    def show_proper(self, factor: Fraction) -> None:
        """``V + 1 >= factor |x|^2`` in the whole space."""
        square = constant(self.count, 0)
        for k in range(self.count):
            square += variable(self.count, k, factor) * variable(self.count, k)
        self._show_larger("", square, factor)

    def show_growth(self, factor: Fraction) -> None:
        """``V + 1 >= factor |x_k|`` in the whole space, for every k."""
        for k in range(self.count):
            for side in (1, -1):
                self._show_larger(f" {'-0+'[side + 1]}{k}", variable(self.count, k, side * factor), factor)

    def _show_larger(self, name: str, bound: Polynomial, factor: Fraction) -> None:
        """``V + 1`` is at least a bound in the whole space, which grows with a factor."""
        require(not self.bounded and factor > 0, "the whole space, and a positive factor")
        least = bound if self.bottom is None else bound * self.bottom
        for piece, signs, cell in self.inclusion.pieces():
            guards = self._guards(whole_domain(self.inclusion), signs, cell) or {}
            above = self.above(cell, Fraction(-1)) - least
            self._show_on_cell(f"proper {piece}{name}", above, guards, strict=False)

    def is_negative_along(self, direction: Sequence[Fraction]) -> bool:
        """Whether a direction leads from the point into a cell in which V is negative at all small distances."""
        surfaces = self.inclusion.surfaces
        for cell in self.inclusion.cells:
            inside = all(sign_along(surfaces.signed(j, s), direction) > 0 for j, s in enumerate(cell.signs))
            if inside and sign_along(self.potential(cell), direction) < 0:
                return True
        return False

    def zero(self, cell: Cell) -> Polynomial:
        """No shift."""
        return constant(self.count, 0)

    def require_all_of_space(self) -> None:
        """What was shown on the cube holds in the whole space: cells are cones, and all claims are about forms."""
        cones = all(surface.degree == 1 and surface.is_form for surface in self.inclusion.surfaces.listed)
        require(cones and self.proofs.are_forms, "cones and forms, for the whole space")


def sign_along(value: Polynomial, direction: Sequence[Fraction]) -> int:
    """The sign of a polynomial at all small distances from the origin in a direction."""
    parts = value.parts_at(direction)
    first = next((parts[degree] for degree in sorted(parts) if parts[degree]), Fraction(0))
    return (first > 0) - (first < 0)
