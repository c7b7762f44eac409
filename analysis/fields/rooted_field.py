"""Systems with signed roots of states as fields, in their own states and time.

Where x vanishes the slope of its root is unbounded, so ``x = 0`` is a surface even where nothing switches there: a
stretch ends at it, and the steps of the next one grow out of it.  Nearer to it than the slack of surfaces slopes are
those at this distance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from math import sqrt

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, ScalarVelocity, Surface, Velocity, affine_surface
from nonsmooth.symbolic.formulas.signed_roots import SignedRoots
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SeenByRoots

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
    count, places = len(roots.states), _places(roots)
    roots_at = [(place, _root_of(order)) for place, order in places]
    known = tuple(_rooted_surface(roots, surface) for surface in extended.surfaces)
    units = [tuple(float(k == place) for k in range(count)) for place, _ in places]
    missing = [
        (name, unit)
        for name, unit in zip(roots.rooted, units, strict=True)
        if name not in [surface.name for surface in known]
    ]
    surfaces = (*known, *(affine_surface(name, unit) for name, unit in missing), *turns)

    def flow(signs: Signs) -> Velocity:
        velocity = extended.flow(signs[: len(known)])
        if not isinstance(velocity, ScalarVelocity):
            return lambda t, x: velocity(t, _with_roots(x, roots))[:count]
        rates = velocity.rates
        return ScalarVelocity(lambda *x: rates(*x, *[root(abs(x[place])) for place, root in roots_at])[:count])

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
    count = len(roots.states)

    def value(x: Floats) -> float:
        return surface.value(_with_roots(x, roots))

    def gradient(x: Floats) -> Floats:
        inner = surface.gradient(_with_roots(x, roots))
        slopes = np.array(inner[:count], dtype=float)
        for (place, order), along in zip(_places(roots), inner[count:], strict=True):
            size = _root_of(order)(max(abs(float(x[place])), SURFACE_SLACK))
            slopes[place] += along * np.copysign(1 / order, x[place]) / size ** (order - 1)
        return slopes

    depends = any(root in surface.name for root in roots.names.values())
    return Surface(roots.restored(surface.name), value, gradient, flat=surface.flat and not depends)


def speeds_at_roots(seen: SeenByRoots) -> Iterator[Polynomial]:
    """The speeds across zeros of roots, where they are affine in the other states."""
    count = len(seen.roots.states)
    states = seen.extended.coordinates()
    zero = [state * (name not in seen.roots.rooted) for name, state in zip(seen.roots.states, states, strict=False)]
    values = [*zero, *(state * 0 for state in states[count:])]
    for member in seen.extended.members:
        for side in (1, -1):
            speeds = member.velocity(lambda surface, side=side: side, values)  # type: ignore[misc]
            for name in seen.roots.rooted:
                speed = speeds[seen.roots.states.index(name)]
                if speed.degree == 1:
                    yield Polynomial(speed.field, seen.roots.states, _shortened(speed, count))


def _shortened(polynomial: Polynomial, count: int) -> dict[tuple[int, ...], Number]:
    """The terms of a normed polynomial that holds the first variables only."""
    scale = polynomial.terms[max(polynomial.terms)].inverse()
    return {e[:count]: c * scale for e, c in polynomial.terms.items()}
