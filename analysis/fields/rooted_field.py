"""Systems with ``sqrt(Abs(x))`` as fields to simulate: the roots are further arguments that the states give.

The field is followed in its own states and time.  Where x vanishes its slope is unbounded, so ``x = 0`` is a surface
even where nothing switches there: a stretch ends at it, and the steps of the next one grow out of it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Surface, Vector, Velocity, affine_surface
from nonsmooth.symbolic.signed_roots import SignedRoots

LEAST_ROOT = float(np.sqrt(SURFACE_SLACK))  # of slopes of roots: nearer than the slack of surfaces a state is on x = 0
# Of the size of the states, which slacks and tolerances are relative to: while all roots shrink by a factor their
# states shrink by its square, so the last turns around a corner are this much smaller than those of other systems.
SMALL_SCALE = 1e-3


def rooted_field(roots: SignedRoots, extended: SignField, turns: Sequence[Surface] = ()) -> SignField:
    """The field of the stated states.

    Args:
        roots: which states stand under square roots.
        extended: the field with each root as a further state, behind the others.
        turns: where speeds across zeros of roots vanish: further surfaces, on which nothing switches, so that a path
            that switches ever faster there has a corner to end in.
    """
    own, places = len(roots.states), [roots.states.index(name) for name in roots.rooted]
    known = tuple(_surface(roots, surface, places) for surface in extended.surfaces)
    units = [tuple(float(k == place) for k in range(own)) for place in places]
    missing = [
        (name, unit)
        for name, unit in zip(roots.rooted, units, strict=True)
        if name not in [surface.name for surface in known]
    ]
    surfaces = (*known, *(affine_surface(name, unit) for name, unit in missing), *turns)

    def flow(signs: Signs) -> Velocity:
        velocity = extended.flow(signs[: len(known)])
        return lambda t, x: velocity(t, _with_roots(x, places))[:own]

    return SignField(roots.states, surfaces, flow, extended.size * SMALL_SCALE)


def with_roots(roots: SignedRoots, start: Sequence[float]) -> tuple[float, ...]:
    """A state with its roots behind it."""
    places = [roots.states.index(name) for name in roots.rooted]
    return tuple(_with_roots(np.array(start, dtype=float), places).tolist()) if len(start) else ()


def _with_roots(x: Vector, places: Sequence[int]) -> Vector:
    return np.concatenate([x, np.sqrt(np.abs(x[list(places)]))])


def _surface(roots: SignedRoots, surface: Surface, places: Sequence[int]) -> Surface:
    """A switching function of states and roots as one of the states, by the chain rule."""
    own = len(roots.states)

    def value(x: Vector) -> float:
        return surface.value(_with_roots(x, places))

    def gradient(x: Vector) -> Vector:
        inner = surface.gradient(_with_roots(x, places))
        slopes = np.array(inner[:own], dtype=float)
        for place, along in zip(places, inner[own:], strict=True):
            slopes[place] += along * np.copysign(0.5, x[place]) / max(float(np.sqrt(abs(x[place]))), LEAST_ROOT)
        return slopes

    depends = any(root in surface.name for root in roots.names.values())
    return Surface(roots.restored(surface.name), value, gradient, flat=surface.flat and not depends)
