"""Area and second moments of a footprint, exact, by Green's theorem.

    area = 1/2 sum c_k,   int x^2 = 1/12 sum (x_k^2 + x_k x_l + x_l^2) c_k,
    int x y = 1/24 sum (x_k y_l + 2 x_k y_k + 2 x_l y_l + x_l y_k) c_k,   c_k = x_k y_l - x_l y_k,  l = k + 1

They are taken about the centroid, from which footprints are measured.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from nonsmooth.symbolic.continuum import Disc, Footprint
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import around, cross


@dataclass(frozen=True)
class Moments:
    """``area``, ``int x^2``, ``int y^2`` and ``int x y`` over the footprint, each in units of ``unit``.

    Attributes:
        area: length^2.
        xx: length^4.
        yy: length^4.
        xy: length^4.
        unit: pi for a disc, else 1.
    """

    area: Number
    xx: Number
    yy: Number
    xy: Number
    unit: float

    @property
    def are_isotropic(self) -> bool:
        """Whether they are the same about every axis."""
        return self.xx == self.yy and not self.xy


def moments(footprint: Footprint) -> Moments:
    """Exact moments of a footprint about its centroid."""
    if isinstance(footprint, Disc):
        squared = footprint.radius * footprint.radius
        quarter = squared * squared / 4
        return Moments(squared, quarter, quarter, quarter * 0, math.pi)
    vertices = footprint.vertices
    zero = vertices[0][0] * 0
    twice, xx, yy, xy = zero, zero, zero, zero
    for p, q in around(vertices):
        c = cross(p, q)
        twice += c
        xx += (p[0] * p[0] + p[0] * q[0] + q[0] * q[0]) * c
        yy += (p[1] * p[1] + p[1] * q[1] + q[1] * q[1]) * c
        xy += (p[0] * q[1] + 2 * (p[0] * p[1] + q[0] * q[1]) + q[0] * p[1]) * c
    return Moments(twice / 2, xx / 12, yy / 12, xy / 24, 1.0)
