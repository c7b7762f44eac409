"""The derivative of a path by its start: variational equations along its legs, saltation matrices between them.

Along a leg ``Phi' = (df/dx) Phi``.  Where the field jumps from ``f`` to ``g`` as the path meets ``h = 0``, neighbours
meet it a little sooner or later, so that ``Phi`` is multiplied by ``S = 1 + (g - f) n^T/(n^T f)`` with the normal
``n = grad h`` there (Aizerman & Gantmakher 1958).  A path that begins to slide has ``n^T g = 0``, so ``n^T S = 0``:
distance from the surface is lost, which makes a multiplier of zero.  A path that leaves a surface where the sliding
field and that of the cell agree has ``S = 1``.  Where a path begins on a surface that it slides along, neighbours
beside it come onto it at once, so that distance from the surface is lost there too.

Liouville's formula gives the determinant a second time, without the cancellation in that of the product: along a leg
``exp(int div f dt)``, over a jump ``det S = (n^T g)/(n^T f)``.

(Leine & Nijmeijer 2004, "Dynamics and Bifurcations of Non-Smooth Mechanical Systems", ch. 7; di Bernardo et al. 2008,
"Piecewise-smooth Dynamical Systems", ch. 2.)
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from nonsmooth.analysis.fields.switched_field import FacedField, Vector, Velocity, length, unit_normal
from nonsmooth.analysis.orbits.orbit_error import OrbitError
from nonsmooth.analysis.trajectories.face_motion import largest
from nonsmooth.analysis.trajectories.smooth_path import Leg

# Relative to the size of the states: step of differences of fourth order, exact for polynomials of degree four; for
# others truncation (step^4) and rounding (1e-16/step) are both some 1e-13.
JACOBIAN_STEP = 1e-3
TOLERANCES = 1e-12, 1e-14  # of DOP853 for the variational equation, relative and absolute
GRAZES = 1e-7  # relative to the field: a slower approach to a surface has no saltation matrix to speak of
JUMPS = 1e-9  # relative to the fields: a smaller change at the end of a leg is none


@dataclass(frozen=True)
class Variation:
    """The derivative of a path by its start.

    Attributes:
        derivative: of the last state by the first (n, n).
        determinant: its determinant by Liouville's formula.
    """

    derivative: Vector
    determinant: float

    def then(self, later: Variation) -> Variation:
        """This one, followed by a later one."""
        return Variation(later.derivative @ self.derivative, later.determinant * self.determinant)


def jacobian(velocity: Velocity, t: float, x: Vector, step: float) -> Vector:
    """``df/dx`` (n, n) by central differences of fourth order with a step in units of the states."""
    columns = []
    for move in np.eye(len(x)) * step:
        near = velocity(t, x + move) - velocity(t, x - move)
        far = velocity(t, x + 2 * move) - velocity(t, x - 2 * move)
        columns.append((8 * near - far) / (12 * step))
    return np.column_stack(columns)


def leg_variation(leg: Leg, size: float, coarseness: float = 1.0) -> Variation:
    """Of a leg's last state by its first, over a fixed time.

    Args:
        leg: the leg.
        size: the unit of the states.
        coarseness: factor on the tolerances of the integrator and on the step of the differences; a result that another
            factor changes is not known any better.

    Raises:
        OrbitError: where the integrator gives up.
    """
    from scipy.integrate import solve_ivp

    count = len(leg.first)
    if leg.end <= leg.start:
        return Variation(np.eye(count), 1.0)
    velocity, (rtol, atol), step = leg.motion.velocity, TOLERANCES, JACOBIAN_STEP * coarseness * size

    def rates(t: float, z: Vector) -> Vector:
        x, phi = z[:count], z[count:-1].reshape(count, count)
        slopes = jacobian(velocity, t, x, step)
        return np.concatenate([velocity(t, x), (slopes @ phi).ravel(), [np.trace(slopes)]])

    start = np.concatenate([leg.first, np.eye(count).ravel(), [0.0]])
    tolerances = {"rtol": rtol * coarseness, "atol": atol * coarseness * size}
    done = solve_ivp(rates, (leg.start, leg.end), start, method="DOP853", **tolerances)
    if not done.success:
        raise OrbitError(f"the derivative of the path could not be followed past t = {done.t[-1]:.6g}")
    last = done.y[:, -1]
    with np.errstate(over="ignore"):
        return Variation(np.asarray(last[count:-1].reshape(count, count)), float(np.exp(last[-1])))


def saltation(before: Leg, after: Leg, field: FacedField) -> Variation:
    """``S`` between two legs.

    Raises:
        OrbitError: for a path that only grazes the surface, or meets another one at the same moment.
    """
    x, t = before.last, before.end
    old, new = before.motion(t, x), after.motion(t, x)
    identity = np.eye(len(x))
    scale = max(largest(old), largest(new))
    if largest(new - old) <= JUMPS * scale:
        return Variation(identity, 1.0)
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
    jump = np.asarray(identity + np.outer(new - old, normal) / approach)
    return Variation(jump, 0.0 if before.met[0] in after.motion.face.keep else float(normal @ new) / approach)


def normals_held(leg: Leg) -> Vector:
    """Orthonormal normals (n, k) of the surfaces that a leg keeps to, at its first state."""
    held = [unit_normal(surface, leg.first) for surface in leg.motion.face.keep]
    return np.asarray(np.linalg.qr(np.array(held).T)[0]) if held else np.empty((len(leg.first), 0))


def path_variation(field: FacedField, legs: Sequence[Leg], coarseness: float = 1.0) -> Variation:
    """The variation along some legs, from the surfaces that the first one keeps to.

    Raises:
        OrbitError: where it does not exist.
    """
    normals = normals_held(legs[0])
    onto_surfaces = np.eye(len(normals)) - normals @ normals.T
    total = Variation(onto_surfaces, 0.0 if normals.shape[1] else 1.0)
    total = total.then(leg_variation(legs[0], field.size, coarseness))
    for before, leg in pairwise(legs):
        total = total.then(saltation(before, leg, field)).then(leg_variation(leg, field.size, coarseness))
    return total


def _surfaces_at(field: FacedField, x: Vector) -> int:
    """How many surfaces pass through a state."""
    return len({id(surface) for face in field.faces_at(x) for surface in face.keep})
