"""Where a force field brings an object to rest, and at which headings: the continuous idealization's prediction.

Friction is taken to damp the motion, so equilibria are poses without force and moment; position settles first, and a
heading is stable where the moment at the settled position turns back (for a field with a potential that is exactly its
minimum).  A field linear in the position needs second moments only: ``F = area A c`` and

    M = (a_22 - a_11)((S_xx - S_yy)/2 sin 2 theta + S_xy cos 2 theta)        for diagonal A

(Kavraki 1997: two stable headings, half a turn apart).  A field that turns with the world (radial, spiral) prefers no
heading.  For the others of constant size the moment is a closed form (:mod:`nonsmooth.analysis.continuum.unit_fields`)
whose sign changes are sought over one period, half a turn.

It fails where a position is not found by Newton's method from the field's centre, and overlooks two headings closer
together than the grid.  Floats: what it says is computed, not proved; which fields prefer a heading is decided exactly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from nonsmooth.analysis.continuum.moments import Moments, moments
from nonsmooth.analysis.continuum.settling import SettlingBody, directions, sense_of
from nonsmooth.analysis.continuum.unit_fields import Floats, disc_stiffness
from nonsmooth.symbolic.continuum import ContinuousField, Disc, Footprint
from nonsmooth.symbolic.plane import Vector

HEADINGS = 360  # grid over half a turn on which sign changes of the moment are sought
GRID_SHIFT = 0.37  # of a step: symmetric footprints have their equilibria at simple fractions of a turn, not here
NODES = 512  # of the trapezoidal rule on a circle; every node has the sign of the whole on the diagonal
NEGLIGIBLE = 1e-11  # moment relative to area times size: below is rounding
AT_ZERO = 1e-12  # radian: a root this near to 0 or to half a turn is 0, to the precision of the search
FLAT = 1e-7  # slope of that moment per radian, and of the force relative to its largest: below is not told from zero


class HeadingEffect(StrEnum):
    """What the field does to the heading."""

    ORIENTS = "turns to certain headings"
    KEEPS = "keeps every heading"
    TURNS = "turns for ever"
    UNKNOWN = "not found"


@dataclass(frozen=True)
class MomentFreeHeading:
    """A heading without moment (radian, from 0 to pi); the same half a turn later.  ``stable`` None: not decided."""

    theta: float
    stable: bool | None


@dataclass(frozen=True)
class Prediction:
    """The continuous idealization of an array under an object.

    Attributes:
        footprint: the object.
        field: the field.
        attracts: whether the position returns, at every equilibrium found; None where none was found, or where a
            float cannot tell.
        offset: distance of the centroid at rest from the field's centre (length), the largest of those found.
        rotation: what happens to the heading.
        headings: those without moment, ascending over half a turn, where there are preferred ones.
        reason: why, in words.
    """

    footprint: Footprint
    field: ContinuousField
    attracts: bool | None
    offset: float
    rotation: HeadingEffect
    headings: tuple[MomentFreeHeading, ...]
    reason: str


def predict(field: ContinuousField, footprint: Footprint) -> Prediction:
    """Equilibria of an object on a field.

    Raises:
        ValueError: for a field that is not linear in the position before it is scaled, a singular one, or zero.
    """
    matrix = field.matrix
    if matrix is None or not _determinant(matrix) or not (field.speed is None or field.speed):
        raise ValueError(f"required a regular linear field that is not zero, received {field.kind}")
    if field.speed is None:
        return _predict_linear(field, matrix, footprint)
    return _predict_unit(field, matrix, footprint)


def _determinant(matrix: tuple[Vector, Vector]) -> bool:
    (a, b), (c, d) = matrix
    return bool(a * d - b * c)


def _turns_with_the_world(matrix: tuple[Vector, Vector]) -> bool:
    (a, b), (c, d) = matrix
    return a == d and b == -c


# ---- linear fields -------------------------------------------------------------------------------


def _predict_linear(field: ContinuousField, matrix: tuple[Vector, Vector], footprint: Footprint) -> Prediction:
    (a, b), (c, d) = matrix
    second = moments(footprint)
    back = (a + d).sign() < 0 < (a * d - b * c).sign()
    if _turns_with_the_world(matrix):
        rotation = HeadingEffect.TURNS if c else HeadingEffect.KEEPS
        return Prediction(footprint, field, back, 0.0, rotation, (), _because(rotation))
    if second.are_isotropic:
        reason = "second moments are equal about every axis: no moment at any heading"
        return Prediction(footprint, field, back, 0.0, HeadingEffect.KEEPS, (), reason)
    headings = _principal_headings(second, weaker_along_x=(d - a).sign() < 0)
    reason = "M ~ sin 2(theta - theta_0): the long principal axis turns to the weaker pull"
    return Prediction(footprint, field, back, 0.0, HeadingEffect.ORIENTS, headings, reason)


def _because(rotation: HeadingEffect) -> str:
    if rotation is HeadingEffect.KEEPS:
        return "the field is the same from every side, and it has a potential: no moment at rest"
    return "the field is the same from every side, and its moment never vanishes"


def _principal_headings(second: Moments, *, weaker_along_x: bool) -> tuple[MomentFreeHeading, ...]:
    """The headings at which the long principal axis lies along x (stable where the pull is weaker there) and y."""
    axis = math.atan2(2 * float(second.xy), float(second.xx - second.yy)) / 2
    found = [
        MomentFreeHeading(-axis % math.pi, weaker_along_x),
        MomentFreeHeading((math.pi / 2 - axis) % math.pi, not weaker_along_x),
    ]
    return tuple(sorted(found, key=lambda heading: heading.theta))


# ---- fields of constant size ---------------------------------------------------------------------


def _predict_unit(field: ContinuousField, matrix: tuple[Vector, Vector], footprint: Footprint) -> Prediction:
    if isinstance(footprint, Disc):
        return _predict_disc(field, matrix, footprint)
    body = SettlingBody(field, footprint)
    if _turns_with_the_world(matrix):
        rotation = HeadingEffect.TURNS if matrix[1][0] else HeadingEffect.KEEPS
        place = body.settle(0.0, np.zeros(2))
        if place is None:
            return Prediction(
                footprint, field, None, math.nan, HeadingEffect.UNKNOWN, (), "no position at rest was found"
            )
        offset = float(np.hypot(*place))
        return Prediction(footprint, field, _pulls_inward(field, matrix), offset, rotation, (), _because(rotation))
    return _search(field, body)


def _predict_disc(field: ContinuousField, matrix: tuple[Vector, Vector], footprint: Disc) -> Prediction:
    rotation = HeadingEffect.TURNS if _turns_with_the_world(matrix) and matrix[1][0] else HeadingEffect.KEEPS
    reason = "a disc is the same at every heading, and by symmetry there is no moment"
    if rotation is HeadingEffect.TURNS:
        reason = _because(rotation)
    if _turns_with_the_world(matrix):
        back: bool | None = _pulls_inward(field, matrix)
    else:
        back = _is_restoring(disc_stiffness(directions(field), sense_of(field), float(footprint.radius), NODES))
    return Prediction(footprint, field, back, 0.0, rotation, (), reason)


def _pulls_inward(field: ContinuousField, matrix: tuple[Vector, Vector]) -> bool:
    """Whether a field that turns with the world attracts: exact.

    It is the inward field turned by an angle, so its stiffness is that of the inward field (symmetric and negative)
    turned by the same angle: the determinant is positive, and the trace has the sign of ``s a_11``.
    """
    return (matrix[0][0] if field.speed is None else matrix[0][0] * field.speed).sign() < 0


def _search(field: ContinuousField, body: SettlingBody) -> Prediction:
    """Headings at which the moment at the settled position changes sign."""
    thetas = (np.arange(HEADINGS + 1) + GRID_SHIFT) * math.pi / HEADINGS
    places = list(body.settled(thetas))
    if any(place is None for place in places):
        reason = "no position at rest was found at some heading"
        return Prediction(body.footprint, field, None, math.nan, HeadingEffect.UNKNOWN, (), reason)
    known = [place for place in places if place is not None]
    wrenches = [body.wrench(theta, place) for theta, place in zip(thetas, known, strict=True)]
    levels = np.array([wrench.moment for wrench in wrenches])
    backs = {_is_restoring(wrench.stiffness) for wrench in wrenches}
    back = next((answer for answer in (False, None) if answer in backs), True)
    offset = max(float(np.hypot(*place)) for place in known)
    if np.abs(levels).max() <= NEGLIGIBLE * body.scale:
        reason = "no moment beyond rounding at any heading"
        return Prediction(body.footprint, field, back, offset, HeadingEffect.KEEPS, (), reason)
    changes = np.flatnonzero(np.sign(levels[:-1]) * np.sign(levels[1:]) < 0)
    headings = sorted(
        (_heading_between(body, thetas[k], thetas[k + 1], known[k]) for k in changes), key=lambda h: h.theta
    )
    if not headings:
        reason = f"the moment at rest has one sign at {HEADINGS} headings of half a turn"
        return Prediction(body.footprint, field, back, offset, HeadingEffect.TURNS, (), reason)
    reason = f"sign changes of the moment at rest over {HEADINGS} headings of half a turn"
    return Prediction(body.footprint, field, back, offset, HeadingEffect.ORIENTS, tuple(headings), reason)


def _heading_between(body: SettlingBody, low: float, high: float, place: Floats) -> MomentFreeHeading:
    """The heading between two of opposite moments, and whether the moment turns back there."""
    from scipy.optimize import brentq

    def level(theta: float) -> float:
        found = body.settle(theta, place)
        return math.nan if found is None else body.wrench(theta, found).moment / body.scale

    theta = float(brentq(level, low, high, xtol=1e-14))
    slope = (level(high) - level(low)) / (high - low)
    theta %= math.pi
    theta = 0.0 if min(theta, math.pi - theta) <= AT_ZERO else theta
    return MomentFreeHeading(theta, None if abs(slope) <= FLAT else bool(slope < 0))


def _is_restoring(stiffness: Floats) -> bool | None:
    """Whether damped motion under the force returns: eigenvalues with negative real parts; None near zero."""
    size = float(np.abs(stiffness).max())
    trace, determinant = float(np.trace(stiffness)) / size, float(np.linalg.det(stiffness / size))
    if trace < -FLAT and determinant > FLAT:
        return True
    return False if trace > FLAT or determinant < -FLAT else None
