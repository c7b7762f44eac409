"""Plain switched systems as fields to simulate: smooth modes in floats, or constant motions on exact cells."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cache, partial
from math import inf, isfinite, nan, sqrt
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import HalfPlane, square
from nonsmooth.analysis.cells.switched_cells import square_regions, system_cells
from nonsmooth.analysis.fields.constant_field import ConstantField, piecewise_constant
from nonsmooth.analysis.fields.float_code import Numbers, compiled, listed, names, weighted
from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import (
    SURFACE_SLACK,
    AffineVelocity,
    NoVelocityError,
    ScalarVelocity,
    Surface,
    Velocity,
    affine_surface,
)
from nonsmooth.symbolic.formulas.enclosed_functions import INVERSE, NORM
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf
from nonsmooth.symbolic.formulas.signed_roots import SignedRoots
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SeenByRoots, SwitchedSystem, require_single, signs_by_factors

if TYPE_CHECKING:
    from nonsmooth.analysis.fields.norm_zeros import NormZero

AT_POINT = 2.0**-38  # of the checked radius: as near to the point a path is at it
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
        return _Polynomials(system.velocity(sign_of, states)).velocity

    size = max(system.check.half_width, *(abs(float(value)) for value in start), 0.0)
    field = SignField(system.states, tuple(_surface(surface) for surface in surfaces), flow, size)
    return _with_zeros(system, field, surfaces, states)


def _stated_surfaces(system: SwitchedSystem, states: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
    """The surfaces on which the stated field switches: bounds of norms switch on further ones."""
    if not system.rewriting.norms:
        return system.surfaces(states)
    return replace(system, rhs=system.rewriting.named_rhs, others=()).surfaces(states)


def _in_stated_states(seen: SeenByRoots, start: Sequence[float]) -> SignField:
    """The field of a system with square roots of states, in its own states and time."""
    extended = system_field(seen.extended, with_roots(seen.roots, start))
    known = {surface.name for surface in extended.surfaces}
    turns = {str(speed): speed for speed in _speeds_at_roots(seen)}
    return rooted_field(seen.roots, extended, [_surface(p) for name, p in turns.items() if name not in known])


def _speeds_at_roots(seen: SeenByRoots) -> Iterator[Polynomial]:
    """The speeds across zeros of roots, where they are affine in the other states."""
    own = len(seen.roots.states)
    states = seen.extended.coordinates()
    zero = [state * (name not in seen.roots.rooted) for name, state in zip(seen.roots.states, states, strict=False)]
    values = [*zero, *(state * 0 for state in states[own:])]
    for member in seen.extended.members:
        for side in (1, -1):
            speeds = member.velocity(lambda surface, side=side: side, values)  # type: ignore[misc]
            for name in seen.roots.rooted:
                speed = speeds[seen.roots.states.index(name)]
                if speed.degree == 1:
                    yield Polynomial(speed.field, seen.roots.states, _shortened(speed, own))


def _shortened(polynomial: Polynomial, count: int) -> dict[tuple[int, ...], Number]:
    """The terms of a normed polynomial that holds the first variables only."""
    scale = polynomial.terms[max(polynomial.terms)].inverse()
    return {e[:count]: c * scale for e, c in polynomial.terms.items()}


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
        away = [own - at for own, at in zip(x, point, strict=True)]
        return rates(*([0.0] * len(point) if max(map(abs, away)) <= resolved else away))

    return ScalarVelocity(displaced)


def _as_stated(system: SwitchedSystem, sign_of: SignOf, states: Sequence[Polynomial]) -> Velocity:
    """The stated field from right-hand sides that are scaled, or enclose it."""
    if system.rewriting.names:
        rates = _with_waves(system, system.rewriting.named_rhs, sign_of, states)
    else:
        members = _Polynomials(system.velocity(sign_of, states))
        if system.rewriting.scale is None:
            return members.velocity
        rates = members.at
    if system.rewriting.scale is None:
        return ScalarVelocity(rates)
    scale = _with_waves(system, [system.rewriting.scale], sign_of, states)
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


def _with_waves(
    system: SwitchedSystem, formulas: Sequence[PiecewiseExpression], sign_of: SignOf, states: Sequence[Polynomial]
) -> Callable[..., Numbers]:
    """The values of formulas that are polynomials in the states and in the values of norms, sines and the like."""
    waves = system.rewriting.names
    rates = _Polynomials(_named_polynomials(system, formulas, sign_of, states)).at
    if not waves:
        return rates
    nearest = AT_POINT * system.check.half_width
    values = _values_of_names(system, sign_of, states, partial(_inverse_of, nearest=nearest))
    return lambda *x: rates(*x, *values(*x))


def _named_polynomials(
    system: SwitchedSystem, formulas: Sequence[PiecewiseExpression], sign_of: SignOf, states: Sequence[Polynomial]
) -> list[Polynomial]:
    """Formulas as polynomials in the states and in the names of norms, sines and the like."""
    waves = system.rewriting.names
    if not waves:
        return [own.polynomial(system.named(states), sign_of) for own in formulas]
    variables = (*system.states, *(wave.name for wave in waves))
    beside = (0,) * len(waves)

    def extended(own: Polynomial) -> Polynomial:
        return Polynomial(own.field, variables, {(*e, *beside): c for e, c in own.terms.items()})

    def sign_of_states(own: Polynomial) -> int:  # what switches holds no sines
        return sign_of(Polynomial(own.field, system.states, {e[: len(states)]: c for e, c in own.terms.items()}))

    values = dict(zip(system.states, map(extended, states), strict=True))
    values |= {wave.name: Polynomial.variable(system.field, variables, wave.name) for wave in waves}
    return [own.polynomial(values, sign_of_states) for own in formulas]


def _with_zeros(
    system: SwitchedSystem, field: SignField, surfaces: Sequence[Polynomial], states: Sequence[Polynomial]
) -> SignField:
    """A field with the zeros of norms that it divides by; as it is where there are none, and with other fractions."""
    sets = _zeros_of_norms(system, states)
    if not sets or system.rewriting.scale is not None:
        return field
    from nonsmooth.analysis.fields.norm_zeros import NormField, NormVelocity

    nearest, count = AT_POINT * system.check.half_width, len(states)
    places = {kind: _places_of(system, kind) for kind in (NORM, INVERSE)}

    def flow(signs: Signs, held: tuple[int, ...], width: float) -> Velocity:
        sign_of = signs_by_factors(dict(zip(surfaces, signs, strict=True)))
        rates = _named_polynomials(system, system.rewriting.named_rhs, sign_of, states)
        values = _values_of_names(system, sign_of, states, lambda size: 1 / max(size, width, nearest))
        if not held:
            norms = ({k: sets[own] for own, k in places[kind].items() if own in sets} for kind in (NORM, INVERSE))
            return NormVelocity(_Polynomials(rates).at, values, *norms)
        chosen = [list(sets)[k] for k in held]
        inverses = [count + places[INVERSE][own] for own in chosen]
        return _keeping_to([sets[own] for own in chosen], rates, values, inverses)

    @cache
    @cache
    def keeping(held: tuple[int, ...], width: float) -> SignField:
        return replace(field, flow=cache(partial(flow, held=held, width=width)))

    zeros = tuple(sets.values())
    return NormField(field.states, field.surfaces, field.flow, field.size, zeros=zeros, keeping=keeping)


def _places_of(system: SwitchedSystem, kind: str) -> dict[str, int]:
    """The numbers of the names of a kind, by what these are of."""
    return {wave.argument: k for k, wave in enumerate(system.rewriting.names) if wave.kind == kind}


def _keeping_to(
    zeros: Sequence[NormZero], rates: Sequence[Polynomial], values: Callable[..., Numbers], inverses: Sequence[int]
) -> Velocity:
    """The motion that keeps to zeros of norms s.

    What stands over s is ``sum_k m_k b_k`` with the b_k of which s is the norm: it vanishes there, so its derivatives
    by the states are ``sum_k m_k grad b_k``, and times a displacement what stands with the unit vector of that.

    Args:
        zeros: of the norms.
        rates: polynomials in the states and in names, affine in the names of all 1/s together.
        values: of the names at a state.
        inverses: the numbers of the names of 1/s among all variables.

    Raises:
        NoVelocityError: for products of unit vectors.
    """
    from nonsmooth.analysis.fields.norm_zeros import HeldVelocity

    if any(sum(exponents[k] for k in inverses) > 1 for rate in rates for exponents in rate.terms):
        raise NoVelocityError("products of unit vectors leave open what follows where their norms are zero")
    count, variables = len(rates), rates[0].variables
    alone = _Polynomials([_without(rate, inverses) for rate in rates]).at
    over = [[rate.derivative(variables[k]) for rate in rates] for k in inverses]
    slopes = _Polynomials([part.derivative(name) for own in over for part in own for name in variables[:count]]).at

    def slopes_at(x: Floats) -> Floats:
        own = x.tolist()
        return np.array(slopes(*own, *values(*own))).reshape(len(zeros), count, count)

    return HeldVelocity(zeros, lambda x: np.array(alone(*x.tolist(), *values(*x.tolist()))), slopes_at)


def _without(rate: Polynomial, places: Sequence[int]) -> Polynomial:
    """The terms without some of the variables."""
    terms = {e: c for e, c in rate.terms.items() if not any(e[k] for k in places)}
    return Polynomial(rate.field, rate.variables, terms)


def _values_of_names(
    system: SwitchedSystem, sign_of: SignOf, states: Sequence[Polynomial], inverse_of: Callable[[float], float]
) -> Callable[..., Numbers]:
    """What the names of norms, sines and the like are at a state; of what is over a norm a function of that."""
    waves = system.rewriting.names
    inner = _Polynomials([system.argument_of(wave, states, sign_of) for wave in waves]).at
    functions = [_root if own.kind in (NORM, INVERSE) else getattr(math, own.kind) for own in waves]
    # Of a norm that is zero on a line or more the square, multiplied out, is a small difference of large numbers.
    sizes = _zeros_of_norms(system, states)
    near = [(k, sizes[own.argument].size) for k, own in enumerate(waves) if own.argument in sizes]
    over = [k for k, own in enumerate(waves) if own.kind == INVERSE]

    def values(*x: float) -> Numbers:
        found = [own(v) if isfinite(v) else nan for own, v in zip(functions, inner(*x), strict=True)]
        for k, size in near:
            found[k] = size(*x)
        for k in over:
            found[k] = inverse_of(found[k])
        return tuple(found)

    return values


def _zeros_of_norms(system: SwitchedSystem, states: Sequence[Polynomial]) -> dict[str, NormZero]:
    """The places where norms are zero that the stated field divides by, by what stands under the root."""
    arguments = [wave.argument for wave in system.rewriting.names if wave.kind == INVERSE]
    if not arguments:
        return {}
    from nonsmooth.analysis.fields.norm_zeros import norm_zero

    squares = {wave.argument: system.argument_of(wave, states) for wave in system.rewriting.names}
    return {own: norm_zero(squares[own], f"sqrt({own})") for own in arguments}


def _root(square: float) -> float:
    """The root of a sum of squares, which is multiplied out: rounded it may be below zero."""
    return sqrt(max(square, 0.0))


def _inverse_of(size: float, nearest: float) -> float:
    """One over a norm that is larger than the least one that counts.

    Raises:
        NoVelocityError: elsewhere.
    """
    if size <= nearest:
        raise NoVelocityError("the field has no value where a root of a sum of squares in a denominator is zero")
    return 1 / size


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


def _surface(polynomial: Polynomial) -> Surface:
    """A switching function with its exact gradient."""
    at = _Polynomials([polynomial]).at
    gradient = _Polynomials([polynomial.derivative(name) for name in polynomial.variables])
    return Surface(str(polynomial), lambda x: at(*x.tolist())[0], gradient, flat=polynomial.degree <= 1)


Terms: TypeAlias = Sequence[tuple[float, tuple[int, ...]]]  # coefficients and exponents
MOST_FACTORS = 500  # of polynomials that are written out: longer text takes long to compile


class _Polynomials:
    """Values of some polynomials at a state: coefficients, each rounded once, times powers of the states.

    Attributes:
        at: the values, in order, from the states one by one.
        velocity: the values as a field.

    Raises:
        RefusalError: for coefficients that floats do not hold.
    """

    def __init__(self, polynomials: Sequence[Polynomial]) -> None:
        sums = [[(float(c), exponents) for exponents, c in p.terms.items()] for p in polynomials]
        terms = [term for own in sums for term in own]
        if not all(isfinite(c) for c, _ in terms):
            raise RefusalError("required coefficients within the range of floats, to follow paths: one is above 1e308")
        count = len(polynomials[0].variables)
        factors = sum(1 + sum(exponents) for _, exponents in terms)
        self.at = (_written_out if factors <= MOST_FACTORS else _in_arrays)(count, sums)
        self.velocity: Velocity = ScalarVelocity(self.at)
        if len(sums) == count and all(p.degree <= 1 for p in polynomials):
            self.velocity = AffineVelocity(self.at, *_affine(count, sums))
        self._constant = None if any(any(e) for _, e in terms) else np.array(self.at(*[0.0] * count))

    def __call__(self, x: Floats) -> Floats:
        """The values, in order."""
        return np.array(self.at(*x.tolist())) if self._constant is None else self._constant


def _affine(count: int, sums: Sequence[Terms]) -> tuple[Floats, Floats]:
    """A and b of polynomials of degree one."""
    matrix, offset = np.zeros((count, count)), np.zeros(count)
    for row, terms in enumerate(sums):
        for c, exponents in terms:
            if any(exponents):
                matrix[row, exponents.index(1)] = c
            else:
                offset[row] = c
    return matrix, offset


def _written_out(count: int, sums: Sequence[Terms]) -> Callable[..., Numbers]:
    """The values as a function of x0, x1, ...; powers are products, which may overflow."""
    x = names("x", count)
    products = ([(c, [x[k] for k, power in enumerate(e) for _ in range(power)]) for c, e in own] for own in sums)
    return compiled(", ".join(x), f"return {listed(map(weighted, products))}")


def _in_arrays(count: int, sums: Sequence[Terms]) -> Callable[..., Numbers]:
    """The same for polynomials of many terms: coefficients times monomials."""
    exponents = list(dict.fromkeys(e for terms in sums for _, e in terms))
    powers = np.array(exponents, dtype=float).reshape(-1, count)
    coefficients = np.zeros((len(sums), len(exponents)))
    for row, terms in zip(coefficients, sums, strict=True):
        for c, e in terms:
            row[exponents.index(e)] = c
    return lambda *x: tuple((coefficients @ np.multiply.reduce(np.array(x) ** powers, axis=1)).tolist())


# ---- signed roots --------------------------------------------------------------------------------
#
# The field is followed in its own states and time.  Where x vanishes its slope is unbounded, so ``x = 0`` is a surface
# even where nothing switches there: a stretch ends at it, and the steps of the next one grow out of it.  Nearer to it
# than the slack of surfaces slopes are those at this distance.


# Of the size of the states, which slacks and tolerances are relative to: while all roots shrink by a factor their
# states shrink by its square, so the last turns around a corner are this much smaller than those of other systems.
SMALL_SCALE = 1e-3


def rooted_field(roots: SignedRoots, extended: SignField, turns: Sequence[Surface] = ()) -> SignField:
    """The field of the stated states.

    Args:
        roots: which states stand under roots.
        extended: the field with the size of each root as a further state, behind the others.
        turns: where speeds across zeros of roots vanish: further surfaces, on which nothing switches, so that a path
            that switches ever faster there has a corner to end in.
    """
    own, places = len(roots.states), _places(roots)
    roots_at = [(place, _root_of(order)) for place, order in places]
    known = tuple(_rooted_surface(roots, surface) for surface in extended.surfaces)
    units = [tuple(float(k == place) for k in range(own)) for place, _ in places]
    missing = [
        (name, unit)
        for name, unit in zip(roots.rooted, units, strict=True)
        if name not in [surface.name for surface in known]
    ]
    surfaces = (*known, *(affine_surface(name, unit) for name, unit in missing), *turns)

    def flow(signs: Signs) -> Velocity:
        velocity = extended.flow(signs[: len(known)])
        if not isinstance(velocity, ScalarVelocity):
            return lambda t, x: velocity(t, _with_roots(x, roots))[:own]
        rates = velocity.rates
        return ScalarVelocity(lambda *x: rates(*x, *[root(abs(x[place])) for place, root in roots_at])[:own])

    return SignField(roots.states, surfaces, flow, extended.size * SMALL_SCALE)


def with_roots(roots: SignedRoots, start: Sequence[float]) -> tuple[float, ...]:
    """A state with the sizes of its roots behind it."""
    return tuple(_with_roots(np.array(start, dtype=float), roots).tolist()) if len(start) else ()


def _with_roots(x: Floats, roots: SignedRoots) -> Floats:
    return np.concatenate([x, [_root_of(order)(abs(float(x[place]))) for place, order in _places(roots)]])


def _root_of(order: int) -> Callable[[float], float]:
    """``x**(1/q)`` of a size."""
    return sqrt if order == 2 else lambda x: x ** (1 / order)


def _places(roots: SignedRoots) -> list[tuple[int, int]]:
    """Which states stand under a root, and its order."""
    return [(roots.states.index(name), order) for name, order in roots.order.items()]


def _rooted_surface(roots: SignedRoots, surface: Surface) -> Surface:
    """A switching function of states and roots as one of the states, by the chain rule."""
    own = len(roots.states)

    def value(x: Floats) -> float:
        return surface.value(_with_roots(x, roots))

    def gradient(x: Floats) -> Floats:
        inner = surface.gradient(_with_roots(x, roots))
        slopes = np.array(inner[:own], dtype=float)
        for (place, order), along in zip(_places(roots), inner[own:], strict=True):
            size = _root_of(order)(max(abs(float(x[place])), SURFACE_SLACK))
            slopes[place] += along * np.copysign(1 / order, x[place]) / size ** (order - 1)
        return slopes

    depends = any(root in surface.name for root in roots.names.values())
    return Surface(roots.restored(surface.name), value, gradient, flat=surface.flat and not depends)
