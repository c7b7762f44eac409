"""Plain switched systems as fields to simulate: smooth modes in floats, or constant motions on exact cells."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cache
from math import inf
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.polygon import HalfPlane, square
from nonsmooth.analysis.cells.switched_cells import square_regions, system_cells
from nonsmooth.analysis.fields.constant_field import ConstantField, piecewise_constant
from nonsmooth.analysis.fields.float_code import Numbers
from nonsmooth.analysis.fields.float_polynomials import Polynomials, polynomial_surface
from nonsmooth.analysis.fields.named_formulas import AT_POINT, formula_values, with_zeros_of_norms
from nonsmooth.analysis.fields.rooted_field import rooted_field, speeds_at_roots, with_roots
from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import (
    NoVelocityError,
    ScalarVelocity,
    Velocity,
)
from nonsmooth.symbolic.formulas.piecewise import SignOf
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SeenByRoots, SwitchedSystem, require_single, signs_by_factors

if TYPE_CHECKING:
    pass

POINT_SLACK = 2.0**-48  # relative to the entries of the checked point


def system_field(system: SwitchedSystem, start: Sequence[float] = (), *, centred: bool = False) -> SignField:
    """One smooth field in floats for every pattern of signs of the switching surfaces.

    The typical size of the states, which sets the slack of the surfaces, is the largest of the start's entries and
    the checked radius.

    Args:
        system: in any number of states.
        start: of the path that will be followed.
        centred: whether states are measured from the checked point.

    Raises:
        SceneError: for formulas with too many switching surfaces, or that are no polynomials, and for arbitrary
            switching.
    """
    if system.by_roots is not None:
        return _in_stated_states(system.by_roots, start)
    if len(system.rewriting.written) != 1:
        require_single(system)
    states = system.displaced(system.states) if centred else system.coordinates()
    surfaces = _stated_surfaces(system, states)

    @cache
    def flow(signs: Signs) -> Velocity:
        known = dict(zip(surfaces, signs, strict=True))
        if system.vanishing and not centred:
            return _beside_point(system, known)
        sign_of = signs_by_factors(known)
        if system.rewriting.written:
            return _as_stated(system, sign_of, states)
        return Polynomials(system.velocity(sign_of, states)).velocity

    size = max(system.check.half_width, *(abs(float(value)) for value in start), 0.0)
    field = SignField(system.states, tuple(polynomial_surface(surface) for surface in surfaces), flow, size)
    return with_zeros_of_norms(system, field, surfaces, states)


def _stated_surfaces(system: SwitchedSystem, states: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
    """The surfaces on which the stated field switches: bounds of norms switch on further ones."""
    if not system.rewriting.norms:
        return system.surfaces(states)
    return replace(system, rhs=system.rewriting.named_rhs, others=()).surfaces(states)


def _in_stated_states(seen: SeenByRoots, start: Sequence[float]) -> SignField:
    """The field of a system with square roots of states, in its own states and time."""
    extended = system_field(seen.extended, with_roots(seen.roots, start))
    known = {surface.name for surface in extended.surfaces}
    turns = {str(speed): speed for speed in speeds_at_roots(seen)}
    return rooted_field(seen.roots, extended, [polynomial_surface(p) for name, p in turns.items() if name not in known])


def _beside_point(system: SwitchedSystem, signs: Mapping[Polynomial, int]) -> Velocity:
    """The stated field with a denominator that is zero at the checked point, for the signs of its surfaces.

    It is found from displacements: there a denominator, multiplied out, would be a small difference of large numbers.
    A state counts as at the point where floats hardly resolve it beside that.
    """
    states, point = system.displaced(system.states), system.check.place
    sign_of = signs_by_factors({surface.composed(states): sign for surface, sign in signs.items()})
    velocity = _as_stated(system, sign_of, states)
    if not any(point) or not isinstance(velocity, ScalarVelocity):
        return velocity
    rates, resolved = velocity.rates, POINT_SLACK * max(map(abs, point))

    def displaced(*x: float) -> Numbers:
        away = [value - at for value, at in zip(x, point, strict=True)]
        return rates(*([0.0] * len(point) if max(map(abs, away)) <= resolved else away))

    return ScalarVelocity(displaced)


def _as_stated(system: SwitchedSystem, sign_of: SignOf, states: Sequence[Polynomial]) -> Velocity:
    """The stated field from right-hand sides that are scaled, or enclose it."""
    if system.rewriting.names:
        rates = formula_values(system, system.rewriting.named_rhs, sign_of, states)
    else:
        members = Polynomials(system.velocity(sign_of, states))
        if system.rewriting.scale is None:
            return members.velocity
        rates = members.at
    if system.rewriting.scale is None:
        return ScalarVelocity(rates)
    scale = formula_values(system, [system.rewriting.scale], sign_of, states)
    vanishes = bool(system.vanishing)

    # Beside a norm that is zero at the point the field turns ever faster, without a surface for a step to end on.
    nearest = AT_POINT * system.check.half_width if vanishes and system.rewriting.norms else -1.0

    def divided(*x: float) -> Numbers:
        (factor,) = scale(*x)
        if (not factor and not any(rates(*x))) or max(map(abs, x)) <= nearest:
            raise NoVelocityError("the field has no value at the checked point, where a denominator is zero")
        # Beyond its cell one that is zero at the point may be negative: steps that try that are too long.
        has_value = factor > 0 if vanishes else factor != 0
        return tuple([value / factor if has_value else value * inf for value in rates(*x)])

    return ScalarVelocity(divided)


def constant_system(system: SwitchedSystem) -> ConstantField | None:
    """A planar system on its checked square as exact constant motions on polygons; None where it is of another kind."""
    cells = system_cells(system, square_regions(system.check.radius))
    pieces = []
    for cell in cells:
        rates = [component.constant_value for component in cell.velocities[0]]
        if cell.region.guards or any(rate is None for rate in rates):
            return None
        sides = [HalfPlane((-a, -b), c) for a, b, c in cell.region.sides]
        pieces.append((sides, (*rates, system.field.zero)))
    zero = system.field.zero
    return piecewise_constant(square((zero, zero), system.check.radius), pieces, exact=True)
