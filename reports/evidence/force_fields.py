"""Parts on force fields: a unit radial field with a small constant one, and a linear one with a constant one.

A constant field has no moment about the centroid, so it only moves the place at which a part rests; there the radial
field of unit size has a moment that depends on the heading, the linear one none.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from nonsmooth.analysis.continuum.settling import SettlingBody
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.symbolic.continuum import ContinuousField, PolygonShape
from nonsmooth.symbolic.numbers.number_field import NumberField

HEADINGS = 360  # over a whole turn, at which the moment is looked at
SHIFT = 0.37  # of a step: symmetric parts have their equilibria elsewhere
STEPS, SETTLED = 80, 1e-12  # of Newton's method; of the force per area
SMALL, LARGE = 0.01, 0.2  # constant fields, of the unit field

Points = tuple[tuple[Fraction, Fraction], ...]

TRIANGLE: Points = tuple((Fraction(x), Fraction(y)) for x, y in ((0, 0), (3, 0), (0, 1)))  # from its corner


def centred(points: Points) -> Points:
    """A triangle measured from its centroid."""
    x, y = (sum((point[k] for point in points), Fraction(0)) / len(points) for k in (0, 1))
    return tuple((px - x, py - y) for px, py in points)


def stable_headings(points: Points, constant: float) -> list[float]:
    """Headings at which a part rests and is turned back, on a unit radial field plus a constant along x; sampled.

    Args:
        points: the part, from its centroid.
        constant: size of the constant field.
    """
    body = _body(points)
    area = _area(points)
    place = np.zeros(2)
    thetas = (np.arange(HEADINGS + 1) + SHIFT) * 2 * math.pi / HEADINGS
    moments = []
    for theta in thetas:
        place = _settled(body, float(theta), place, constant * area)
        moments.append(body.wrench(float(theta), place).moment)
    signs = np.sign(moments)
    falls = (signs[:-1] > 0) & (signs[1:] < 0)
    return [float(theta) % (2 * math.pi) for theta in (thetas[:-1] + thetas[1:])[falls] / 2]


def _body(points: Points) -> SettlingBody:
    field = NumberField()
    zero, one = field.zero, field.one
    shape = PolygonShape(tuple((field.rational(x), field.rational(y)) for x, y in points))
    inward = ContinuousField("radial", ((-one, zero), (zero, -one)), one, (zero, zero))
    return SettlingBody(inward, shape)


def _area(points: Points) -> float:
    (ax, ay), (bx, by), (cx, cy) = points
    return float(abs((bx - ax) * (cy - ay) - (by - ay) * (cx - ax)) / 2)


def _settled(body: SettlingBody, theta: float, place: Floats, push: float) -> Floats:
    """The place without force, by Newton's method from a place nearby.

    Raises:
        RuntimeError: where it is not found.
    """
    for _ in range(STEPS):
        wrench = body.wrench(theta, place)
        force = wrench.force + np.array([push, 0.0])
        if np.abs(force).max() <= SETTLED * body.force_scale:
            return place
        step = np.linalg.solve(wrench.stiffness, force)
        place = place - step * min(1.0, body.size / (2 * float(np.hypot(*step))))
    raise RuntimeError(f"required a place of rest at heading {theta}, found none")


def linear_moment(points: Points, cosine: Fraction, sine: Fraction) -> Fraction:
    """The moment of ``f = -p + e`` on a triangle at its place of rest and a rational heading, exactly.

    The force vanishes where the centroid is at e; from there ``(p - c) x f`` is integrated over the triangle by its
    second moments.
    """
    turned = [(cosine * x - sine * y, sine * x + cosine * y) for x, y in points]
    rest = (Fraction(1), Fraction(0))
    total = Fraction(0)
    for k, (x, y) in enumerate(turned):
        for m, (u, v) in enumerate(turned):
            weight = Fraction(2 if k == m else 1, 12)  # of the products of corners, per area of a triangle
            arm, pull = (x, y), (-(u + rest[0]) + rest[0], -(v + rest[1]) + rest[1])
            total += weight * (arm[0] * pull[1] - arm[1] * pull[0])
    return total
