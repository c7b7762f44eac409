"""Force and moment of a field of constant size, ``f(p) = s A p/|A p|``, on a polygon: closed forms, side by side.

The field depends on the direction of p only, so the polygon is swept by triangles from the field's centre: on the
triangle over a side ``p(t) = p_0 + t (p_1 - p_0)`` the area element is ``r (p_0 x p_1) dr dt``, and

    F = sum_sides (p_0 x p_1)/2 int f dt,     M_0 = sum_sides (p_0 x p_1)/3 int p x f dt

with integrals of 1, t and t^2 over the root of a quadratic.  They are written in the arc length of A p measured from
the point of the side that is nearest in that length, which keeps every difference free of cancellation.  (Bohringer,
Donald, Kavraki & Lamiraux 2000 study the radial case.)  It fails for a singular A.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.plane_arrays import cross

Floats = NDArray[np.float64]

# Relative to the side: nearer to the centre, the logarithm of the distance is multiplied by a distance that is lost
# in rounding anyway.
THROUGH_CENTRE = 1e-30


@dataclass(frozen=True)
class FieldWrench:
    """Force and moment on a body, with the change of the force as the body is moved.

    Attributes:
        force: ``int f dA``, (2,).
        moment: ``int (p - c) x f dA`` about the body's centroid c.
        stiffness: ``dF/dc``, (2, 2).
    """

    force: Floats
    moment: float
    stiffness: Floats


def polygon_wrench(matrix: Floats, speed: float, vertices: Floats, centroid: Floats) -> FieldWrench:
    """Force and moment on a polygon.

    Args:
        matrix: A, (2, 2), regular.
        speed: s, force per area.
        vertices: (n, 2), counterclockwise, measured from the field's centre.
        centroid: c, (2,).
    """
    start, end = vertices, np.roll(vertices, -1, axis=0)
    along, turning = _side_integrals(matrix, start, end)
    sweep = cross(start, end)
    force = speed * (sweep @ along) / 2
    about_centre = speed * float(sweep @ turning) / 3
    step = end - start
    outward = np.stack([step[:, 1], -step[:, 0]], axis=1)  # normal times length
    moment = about_centre - float(cross(centroid, force))
    return FieldWrench(force, moment, speed * along.T @ outward)


def _side_integrals(matrix: Floats, start: Floats, end: Floats) -> tuple[Floats, Floats]:
    """``int f dt`` (n, 2) and ``int p x f dt`` (n,) of the field of size one, t from 0 to 1 along each side."""
    step = end - start
    image = step @ matrix.T
    length = np.sqrt((image**2).sum(axis=1))
    direction = step / length[:, None]
    image = image / length[:, None]
    first = ((start @ matrix.T) * image).sum(axis=1)
    last = first + length
    nearest = start - first[:, None] * direction
    push = nearest @ matrix.T
    height = np.sqrt((push**2).sum(axis=1))
    zeroth, linear, square = _root_integrals(first, last, height)
    along = (push * zeroth[:, None] + image * linear[:, None]) / length[:, None]
    mixed = cross(nearest, image) + cross(direction, push)
    turning = (cross(nearest, push) * zeroth + mixed * linear + cross(direction, image) * square) / length
    return along, turning


def _root_integrals(first: Floats, last: Floats, height: Floats) -> tuple[Floats, Floats, Floats]:
    """``int s^k ds/sqrt(s^2 + h^2)`` from ``first`` to ``last`` for k = 0, 1, 2."""
    near, far = np.hypot(first, height), np.hypot(last, height)
    apart = height > THROUGH_CENTRE * (np.abs(first) + np.abs(last))
    h = np.where(apart, height, 1.0)
    a, b = first / h, last / h
    plain = np.arcsinh(b) - np.arcsinh(a)
    with np.errstate(divide="ignore", invalid="ignore"):
        stable = np.arcsinh((b - a) * (b + a) / (b * np.hypot(1, a) + a * np.hypot(1, b)))
    zeroth = np.where(apart, np.where(a * b > 0, stable, plain), 0.0)
    linear = (last - first) * (last + first) / (near + far)
    square = (last * far - first * near - height**2 * zeroth) / 2
    return zeroth, linear, square


def disc_stiffness(matrix: Floats, speed: float, radius: float, nodes: int) -> Floats:
    """``dF/dc`` of a disc about the field's centre: ``s r int f e^T dphi`` over directions e, by the trapezoidal rule.

    The integrand is periodic and analytic, so the error falls geometrically with the number of nodes.
    """
    angle = 2 * np.pi * np.arange(nodes) / nodes
    e = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    f = e @ matrix.T
    f = f / np.hypot(f[:, 0], f[:, 1])[:, None]
    return np.asarray(speed * radius * 2 * np.pi / nodes * f.T @ e)
