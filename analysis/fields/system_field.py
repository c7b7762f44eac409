"""Plain switched systems as fields to simulate: smooth modes in floats, or constant motions on exact cells."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache

import numpy as np

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import HalfPlane, square
from nonsmooth.analysis.cells.switched_cells import FieldCell, square_regions, system_cells
from nonsmooth.analysis.fields.constant_field import ConstantField, piecewise_constant
from nonsmooth.analysis.fields.rooted_field import rooted_field, with_roots
from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import Surface, Vector, Velocity
from nonsmooth.analysis.fields.wave_weights import wave_weight
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import SignOf, parse_piecewise
from nonsmooth.symbolic.switched_system import SeenByRoots, SwitchedSystem, require_single, signs_by_factors


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
    if len(system.written) != 1:
        require_single(system)
    states = system.displaced(system.states) if centred else system.coordinates()
    surfaces = system.surfaces(states)

    @cache
    def flow(signs: Signs) -> Velocity:
        sign_of = signs_by_factors(dict(zip(surfaces, signs, strict=True)))
        if system.written:
            return _as_stated(system, sign_of, states)
        value = _Polynomials(system.velocity(sign_of, states))
        return lambda t, x: value(x)

    size = max(float(system.check.radius), *(abs(float(value)) for value in start), 0.0)
    return SignField(system.states, tuple(_surface(surface) for surface in surfaces), flow, size)


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


def _as_stated(system: SwitchedSystem, sign_of: SignOf, states: Sequence[Polynomial]) -> Velocity:
    """The stated field from right-hand sides that are scaled, or enclose it.

    With enclosed sines it is their mixture with the weights that give each sine its value.
    """
    named = dict(zip(system.states, states, strict=True))
    members = _Polynomials([part for member in system.members for part in member.velocity(sign_of, states)])
    arguments = [parse_piecewise(w.argument, system.states).polynomial(named, sign_of) for w in system.waves]
    inner = _Polynomials(arguments) if arguments else None
    scale = _Polynomials([system.scale.polynomial(named, sign_of)]) if system.scale is not None else None
    shape = len(system.members), len(system.states)

    def velocity(t: float, x: Vector) -> Vector:
        weights = [1.0]
        for wave, v in zip(system.waves, inner(x) if inner is not None else (), strict=True):
            e = wave_weight(wave, float(v))
            weights = [weight * share for weight in weights for share in (1.0 - e, e)]
        value = np.array(weights) @ members(x).reshape(shape)
        return np.asarray(value if scale is None else value / scale(x)[0])

    return velocity


def constant_system(system: SwitchedSystem, *, exact: bool = False) -> ConstantField | None:
    """A planar system on its checked square as constant motions on polygons; None where it is not of that kind."""
    cells = system_cells(system, square_regions(system.check.radius))
    pieces = []
    for cell in cells:
        rates = [component.constant_value for component in cell.velocities[0]]
        if cell.region.guards or any(rate is None for rate in rates):
            return None
        pieces.append((_half_planes(cell), (*rates, system.field.zero)))
    zero = system.field.zero
    return piecewise_constant(square((zero, zero), system.check.radius), pieces, exact=exact)


def _half_planes(cell: FieldCell) -> list[HalfPlane]:
    return [HalfPlane((-a, -b), c) for a, b, c in cell.region.sides]


def _surface(polynomial: Polynomial) -> Surface:
    """A switching function with its exact gradient."""
    value = _Polynomials([polynomial])
    gradient = _Polynomials([polynomial.derivative(name) for name in polynomial.variables])
    return Surface(str(polynomial), lambda x: float(value(x)[0]), gradient, flat=polynomial.degree <= 1)


class _Polynomials:
    """Values of some polynomials at a state: coefficients, each rounded once, times monomials.

    Raises:
        RefusalError: for coefficients that floats do not hold.
    """

    def __init__(self, polynomials: Sequence[Polynomial]) -> None:
        exponents = list(dict.fromkeys(e for p in polynomials for e in p.terms))
        self._exponents = np.array(exponents, dtype=float).reshape(-1, len(polynomials[0].variables))
        self._coefficients = np.array(
            [[float(p.terms[e]) if e in p.terms else 0.0 for e in exponents] for p in polynomials]
        ).reshape(len(polynomials), -1)
        if not np.isfinite(self._coefficients).all():
            raise RefusalError("required coefficients within the range of floats, to follow paths: one is above 1e308")
        self._constant = None if self._exponents.any() else self._coefficients.sum(axis=1)

    def __call__(self, x: Vector) -> Vector:
        """The values, in order."""
        if self._constant is not None:
            return self._constant
        return np.asarray(self._coefficients @ np.multiply.reduce(x**self._exponents, axis=1))
