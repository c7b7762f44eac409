"""Where both normal speeds of a slide vanish at once (a two-fold), so that they leave its weights open.

A solution that keeps to the surface there has speeds ``N_k = D_k t``, and weights that make them cancel:
``l_1 D_1 + l_2 D_2 = 0`` with ``D_k = l_1 D_k1 + l_2 D_k2``, the derivative of N_k along its own velocity (D_kj: along
the field of member j).  That is one quadratic equation.  A slide usually passes from attracting to repelling in such a
point, in finite time and along with all its neighbours.  (Filippov 1988, sec. 19; Jeffrey & Colombo 2009, "The
two-fold singularity of discontinuous vector fields".)

The limit of the equivalent control is the same root, but no number to compute with: a quotient of rounding errors.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, FacedField, Vector, length, unit_normal
from nonsmooth.analysis.trajectories.face_motion import (
    BEND_SLACK,
    LOOK_AHEAD,
    TANGENT_SLACK,
    FaceMotion,
    largest,
)

# Relative to the size of the states, off the surface: a thousand times what rounding leaves of a state. A speed within
# its effect is known to three digits at most, and so are the weights; an integrator takes tiny steps over such noise.
OFF_SURFACE = 1e-13
# Of the distance to the end of an edge: the part over which derivatives are taken there.
NEAR_END = 1e-3
# In units of the speeds that count as zero. A slide ends where both speeds fall to one, where two is tangent already,
# so that the end is found tangent whatever its rounding; one whose weights were open goes on as such to a hundred: far
# enough not to turn to and fro between both, and passed within some 1e-7 of the size.
BECOMES_TANGENT, IS_TANGENT, CLEAR_OF_TANGENCY = 1.0, 2.0, 100.0
WEIGHT_DOUBT = 1e-6  # outside 0 ... 1: weights are roots of differences, which err by LOOK_AHEAD


def tangency(motion: FaceMotion, t: float, x: Vector, size: float, fields: Vector, speeds: Vector) -> float:
    """How far the normal speeds of a slide are from vanishing both, in units of what counts as zero.

    Args:
        motion: the slide.
        t: a time.
        x: a state on its surface.
        size: of the states.
        fields: of the two members there, one per row.
        speeds: their normal speeds, (2, 1).
    """
    nothing = max(TANGENT_SLACK * largest(fields), _doubt(motion, t, x, size, fields))
    return float(np.abs(speeds).sum()) / nothing if nothing else 0.0


def passing_weights(field: FacedField, motion: FaceMotion, t: float, x: Vector) -> Vector | None:
    """Weights (m, 2) of the motions that keep to the surface through a two-fold, the shortest velocity first.

    None where the speeds vanish to first order too, so that any weights will do.
    """
    fields = motion.fields(t, x)
    scale = largest(fields)
    changes = _changes(field, motion, t, x) if scale else np.zeros((2, 2))
    if largest(changes) <= BEND_SLACK * scale**2 / field.size:
        return None
    (d11, d12), (d21, d22) = changes
    roots = np.roots([d11 - d12 - d21 + d22, d12 + d21 - 2 * d22, d22])
    real = roots[np.abs(roots.imag) <= WEIGHT_DOUBT].real
    shares = np.clip(real[(real >= -WEIGHT_DOUBT) & (real <= 1 + WEIGHT_DOUBT)], 0.0, 1.0)
    weights = np.column_stack([shares, 1 - shares])
    return weights[np.argsort([length(row @ fields) for row in weights])]


def _changes(field: FacedField, motion: FaceMotion, t: float, x: Vector) -> Vector:
    """``D_kj``: derivative of the normal speed of member k along the field of member j."""
    fields = motion.fields(t, x)
    here = motion.normal_speeds(x, fields)[:, 0]
    ahead = _reach(field, motion, x) / max(length(f) for f in fields)
    columns = []
    for velocity in fields:
        later = x + ahead * velocity
        speeds = motion.normal_speeds(later, motion.fields(t + ahead, later))[:, 0]
        columns.append((speeds - here) / ahead)
    return np.column_stack(columns)


def _reach(field: FacedField, motion: FaceMotion, x: Vector) -> float:
    """Length over which derivatives are taken: short of the bounds that the state does not lie on."""
    reach = LOOK_AHEAD * field.size
    for surface, _ in motion.face.bounds:
        away = abs(surface.value(x)) / length(surface.gradient(x))
        if away > SURFACE_SLACK * field.size:
            reach = min(reach, NEAR_END * away)
    return reach


def _doubt(motion: FaceMotion, t: float, x: Vector, size: float, fields: Vector) -> float:
    """What rounding of the state may change the normal speeds of a slide by; ``fields`` are those at the state."""
    normal = unit_normal(motion.face.keep[0], x)
    move = LOOK_AHEAD * size
    change = motion.fields(t, x + move * normal) - fields
    return OFF_SURFACE * max(size, largest(x)) * largest(change) / move
