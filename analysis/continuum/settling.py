"""A polygon on a field of constant size: force and moment at a pose, and the position it settles at.

Newton's method with bounded steps from the field's centre, or from the position at a heading nearby; its Jacobian is
the closed form of the stiffness.  It fails where the force does not vanish, or the stiffness is singular on the way.
Only the directions of the field matter for where an object rests: A is scaled to entries up to one, s to its sign.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from nonsmooth.analysis.continuum.moments import moments
from nonsmooth.analysis.continuum.unit_fields import FieldWrench, Floats, polygon_wrench
from nonsmooth.symbolic.continuum import ContinuousField, PolygonShape
from nonsmooth.symbolic.plane import Vector

NEWTON_STEPS = 50
SETTLED = 1e-13  # force relative to the area: below is rounding


class SettlingBody:
    """A polygon on a field of constant size, in floats; positions are measured from the field's centre.

    Attributes:
        footprint: the polygon.
        scale: size of moments on it: area times the largest distance from the centroid.
    """

    def __init__(self, field: ContinuousField, footprint: PolygonShape) -> None:
        self.footprint = footprint
        self.matrix, self.sense = directions(field), sense_of(field)
        self.vertices = rounded(footprint.vertices)
        area = float(moments(footprint).area)
        self.size = float(np.hypot(*self.vertices.T).max())
        self.force_scale = area
        self.scale = self.force_scale * self.size

    def wrench(self, theta: float, place: Floats) -> FieldWrench:
        """Force and moment at a pose."""
        c, s = math.cos(theta), math.sin(theta)
        turned = self.vertices @ np.array([[c, s], [-s, c]])
        return polygon_wrench(self.matrix, self.sense, turned + place, place)

    def settle(self, theta: float, place: Floats) -> Floats | None:
        """The position without force near a place, by Newton's method with bounded steps."""
        if self.footprint.is_centrally_symmetric:
            return np.zeros(2)
        for _ in range(NEWTON_STEPS):
            wrench = self.wrench(theta, place)
            if np.abs(wrench.force).max() <= SETTLED * self.force_scale:
                return place
            if not np.linalg.det(wrench.stiffness):
                return None
            step = np.linalg.solve(wrench.stiffness, wrench.force)
            place = place - step * min(1.0, self.size / (2 * float(np.hypot(*step))))
        return None

    def settled(self, thetas: Floats) -> Iterator[Floats | None]:
        """The positions at several headings, each sought from the one before."""
        place: Floats | None = np.zeros(2)
        for theta in thetas.tolist():
            place = self.settle(theta, np.zeros(2) if place is None else place)
            yield place


def sense_of(field: ContinuousField) -> float:
    """1 along A p, -1 against it."""
    return 1.0 if field.speed is None else float(field.speed.sign())


def directions(field: ContinuousField) -> Floats:
    """A, scaled to entries of at most one."""
    rows = field.matrix or ()
    largest = max(abs(entry) for row in rows for entry in row)
    return rounded([(x / largest, y / largest) for x, y in rows])


def rounded(rows: Sequence[Vector]) -> Floats:
    """Exact vectors as floats, one per row."""
    return np.array([[float(x), float(y)] for x, y in rows])
