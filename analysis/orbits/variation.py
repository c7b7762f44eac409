"""The derivative of a path by its start: variational equations along its legs, saltation matrices between them.

Along a leg ``Phi' = (df/dx) Phi``.  Where the field jumps from ``f`` to ``g`` as the path meets ``h = 0``, neighbours
meet it a little sooner or later, so that ``Phi`` is multiplied by ``S = 1 + (g - f) n^T/(n^T f)`` with the normal
``n = grad h`` there (Aizerman & Gantmakher 1958).  A path that begins to slide has ``n^T g = 0``, so ``n^T S = 0``:
distance from the surface is lost, which makes a multiplier of zero.  A path that leaves a surface where the sliding
field and that of the cell agree has ``S = 1``.  (Leine & Nijmeijer 2004, "Dynamics and Bifurcations of Non-Smooth
Mechanical Systems", ch. 7; di Bernardo et al. 2008, "Piecewise-smooth Dynamical Systems", ch. 2.)
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from nonsmooth.analysis.fields.switched_field import FacedField, Vector, Velocity, length
from nonsmooth.analysis.orbits.orbit_error import OrbitError
from nonsmooth.analysis.trajectories.face_motion import largest
from nonsmooth.analysis.trajectories.legs import Leg

# Relative to the size of the states: step of differences of fourth order, exact for polynomials of degree four; for
# others truncation (step^4) and rounding (1e-16/step) are both some 1e-13.
JACOBIAN_STEP = 1e-3
TOLERANCES = 1e-12, 1e-14  # of DOP853 for the variational equation, relative and absolute
GRAZES = 1e-7  # relative to the field: a slower approach to a surface has no saltation matrix to speak of
JUMPS = 1e-9  # relative to the fields: a smaller change at the end of a leg is none


def jacobian(velocity: Velocity, t: float, x: Vector, size: float) -> Vector:
    """``df/dx`` (n, n) by central differences of fourth order; ``size`` is the unit of the states."""
    step = JACOBIAN_STEP * size
    columns = []
    for move in np.eye(len(x)) * step:
        near = velocity(t, x + move) - velocity(t, x - move)
        far = velocity(t, x + 2 * move) - velocity(t, x - 2 * move)
        columns.append((8 * near - far) / (12 * step))
    return np.column_stack(columns)


def leg_derivative(leg: Leg, size: float) -> Vector:
    """Derivative (n, n) of a leg's last state by its first, over a fixed time.

    Raises:
        OrbitError: where the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    count = len(leg.first)
    if leg.end <= leg.start:
        return np.eye(count)
    velocity, (rtol, atol) = leg.motion.velocity, TOLERANCES

    def rates(t: float, z: Vector) -> Vector:
        x, phi = z[:count], z[count:].reshape(count, count)
        return np.concatenate([velocity(t, x), (jacobian(velocity, t, x, size) @ phi).ravel()])

    start = np.concatenate([leg.first, np.eye(count).ravel()])
    done = solve_ivp(rates, (leg.start, leg.end), start, method="DOP853", rtol=rtol, atol=atol * size)
    if not done.success:
        raise OrbitError(f"the variational equation could not be integrated past t = {done.t[-1]:.6g}")
    return np.asarray(done.y[count:, -1].reshape(count, count))


def saltation(before: Leg, after: Leg, field: FacedField) -> Vector:
    """``S`` between two legs.

    Raises:
        OrbitError: for a path that only grazes the surface, or meets another one at the same moment.
    """
    x, t = before.last, before.end
    old, new = before.motion(t, x), after.motion(t, x)
    identity = np.eye(len(x))
    scale = max(largest(old), largest(new))
    if largest(new - old) <= JUMPS * scale:
        return identity
    if not before.met:
        raise OrbitError(
            f"the field jumps at {x.tolist()} where the path meets no surface: its derivative is not known"
        )
    if _surfaces_at(field, x) > len({*map(id, before.motion.face.keep), *map(id, before.met)}):
        raise OrbitError(f"the path meets several surfaces at once at {x.tolist()}: it has no derivative there")
    normal = before.met[0].gradient(x)
    approach = float(normal @ old)
    if abs(approach) <= GRAZES * length(normal) * scale:
        raise OrbitError(f"the path only grazes {before.met[0].name} = 0 at {x.tolist()}: it has no derivative there")
    return np.asarray(identity + np.outer(new - old, normal) / approach)


def monodromy(field: FacedField, legs: Sequence[Leg]) -> Vector:
    """Derivative (n, n) of the last state of some legs by their first.

    Raises:
        OrbitError: where it does not exist.
    """
    total = leg_derivative(legs[0], field.size)
    for before, leg in pairwise(legs):
        total = leg_derivative(leg, field.size) @ saltation(before, leg, field) @ total
    return total


def _surfaces_at(field: FacedField, x: Vector) -> int:
    """How many surfaces pass through a state."""
    return len({id(surface) for face in field.faces_at(x) for surface in face.keep})
