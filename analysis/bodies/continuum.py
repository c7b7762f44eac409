"""The continuous idealization: where a force field under a whole object brings it to rest, and at which headings.

Each point p of an object's footprint is pushed by a force per area f(p), and friction is taken to damp the motion.  So
equilibria are poses without force and moment; position settles first, and a heading is stable where the moment at the
settled position turns back (for a field with a potential that is exactly its minimum).

A field linear in the position needs second moments only: ``F = area A c`` and

    M = (a_22 - a_11)((S_xx - S_yy)/2 sin 2 theta + S_xy cos 2 theta)        for diagonal A

(Kavraki 1997: two stable headings, half a turn apart).  A field that turns with the world (radial, spiral) prefers no
heading.  For the others of constant size the moment is a closed form whose sign changes are sought over one period,
half a turn; only their directions matter, so A is scaled to entries up to one, s to its sign.

It fails where a position is not found by Newton's method from the field's centre, and overlooks two headings closer
together than the grid.  Floats: what it says is computed, not proved; which fields prefer a heading is decided exactly.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum
from fractions import Fraction
from functools import partial
from typing import NamedTuple

import numpy as np

from nonsmooth.symbolic.files.layouts import LINEAR_KINDS
from nonsmooth.symbolic.files.scene_document import rectangle
from nonsmooth.symbolic.mechanics.body import ContinuousField, Disc, Footprint, PolygonShape
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers import plane
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import around
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    cross,
    float_points,
    following,
    max_norm,
    norm,
    norms,
    row_products,
    squared_norms,
)

DIGITS = 3  # of the radius of the disc that covers the wheels, rounded up
STEEPEST = 1e6  # ratio of the largest to the smallest pull of a field of constant size: below, closed forms keep digits
LARGEST = 1e60  # lengths whose fourth powers floats hold
HEADINGS = 360  # grid over half a turn on which sign changes of the moment are sought
GRID_SHIFT = 0.37  # of a step: symmetric footprints have their equilibria at simple fractions of a turn, not here
NEGLIGIBLE = 1e-11  # moment relative to area times size: below is rounding
AT_ZERO = 1e-12  # radian: a root this near to 0 or to half a turn is 0, to the precision of the search
FLAT = 1e-7  # slope of that moment per radian, and of the force relative to its largest: below is not told from zero
NEWTON_STEPS = 50
SETTLED = 1e-13  # force relative to the area: below is rounding
THROUGH_CENTRE = 1e-30  # of a side: nearer to the centre, the logarithm of the distance is multiplied by less than that


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


# ---- what a scene stands for ---------------------------------------------------------------------


class NoIdealizationError(ValueError):
    """A scene that no continuous field stands for; ``str(error)`` says what was required."""


def predictions(scene: Scene) -> tuple[Prediction, ...]:
    """The continuous idealization of a scene, for each of its objects.

    Raises:
        NoIdealizationError: where no field or no object stands for it.
    """
    field, found = idealization(scene), footprints(scene)
    for footprint in found:
        lengths = [footprint.radius] if isinstance(footprint, Disc) else [x for v in footprint.vertices for x in v]
        _require_float(max(abs(float(length)) for length in lengths))
    return tuple(predict(field, footprint) for footprint in found)


def idealization(scene: Scene) -> ContinuousField:
    """The field that a scene's wheels sample.

    Raises:
        NoIdealizationError: for a field of another kind, and for wheels that do not follow it.
    """
    field = scene.continuum
    if field is None or field.matrix is None:
        kinds = f"{', '.join(LINEAR_KINDS[:-1])} or {LINEAR_KINDS[-1]}"
        received = "none" if field is None else field.kind
        raise NoIdealizationError(f"field.kind: required {kinds} for a continuous field, received {received}")
    if not _is_regular(field):
        raise NoIdealizationError("field: required a field that vanishes at its centre only, received another")
    if field.speed is not None and np.linalg.cond(_directions(field)) > STEEPEST:
        raise NoIdealizationError(f"field: required pulls in a ratio of at most {STEEPEST:g}, received a larger one")
    for wheel in scene.wheels:
        if not _follows(wheel, field):
            raise NoIdealizationError(
                f"wheel[{wheel.index}]: required wheels that all follow one {field.kind} field for a continuous field, "
                "received another heading or speed"
            )
    return field


def footprints(scene: Scene) -> tuple[Footprint, ...]:
    """The scene's body, or else a rectangle and a disc that just cover the wheels, at rest at the checked point.

    Raises:
        NoIdealizationError: for lengths beyond the range of floats.
    """
    if scene.body is not None:
        if scene.body.is_balanced:
            return (scene.body.outline,)
        raise NoIdealizationError("body.centre_of_mass: required the centroid for a continuous field, received another")
    away = [plane.minus(wheel.position, scene.check.equilibrium) for wheel in scene.wheels]
    width, height = (max(abs(place[k]) for place in away) for k in (0, 1))
    reach = max(math.hypot(float(x), float(y)) for x, y in away)
    _require_float(reach)
    unit = Fraction(10) ** (math.floor(math.log10(reach)) + 1 - DIGITS)
    disc = Disc(scene.field.rational(math.ceil(Fraction(reach) / unit) * unit))
    return (rectangle(width, height), disc) if width and height else (disc,)


def _require_float(length: float) -> None:
    if not 1 / LARGEST <= length <= LARGEST:
        raise NoIdealizationError(f"body: required a length from {1 / LARGEST:g} to {LARGEST:g}, received {length:g}")


def _follows(wheel: Wheel, field: ContinuousField) -> bool:
    """Whether a wheel points along the field at its place, runs at the field's speed, and grips along its rim."""
    if field.matrix is None or wheel.axis is not None:
        return False
    x, y = (p - c for p, c in zip(wheel.position, field.centre, strict=True))
    fx, fy = (row[0] * x + row[1] * y for row in field.matrix)
    dx, dy = wheel.direction
    along = (fx * dy - fy * dx).sign() == 0 and (fx * dx + fy * dy).sign() > 0
    if field.speed is not None:
        return along and wheel.speed == field.speed
    return along and wheel.speed.sign() > 0 and wheel.speed * wheel.speed == fx * fx + fy * fy


def _is_regular(field: ContinuousField) -> bool:
    """Whether the field is linear before it is scaled, and vanishes at its centre only."""
    return field.matrix is not None and bool(plane.cross(*field.matrix)) and (field.speed is None or bool(field.speed))


def _directions(field: ContinuousField) -> Floats:
    """A, scaled to entries of at most one."""
    rows = field.matrix or ()
    largest = max(abs(entry) for row in rows for entry in row)
    return np.array([[float(entry / largest) for entry in row] for row in rows])


# ---- what it predicts ----------------------------------------------------------------------------


def predict(field: ContinuousField, footprint: Footprint) -> Prediction:
    """Equilibria of an object on a field whose A is diagonal, or turns with the world (``a_11 = a_22, a_12 = -a_21``).

    The stiffness dF/dc is area times A for a linear field and, for one of constant size, ``s A G`` of a disc and of any
    object where the field turns with the world, with G symmetric and positive: there trace and determinant of ``s A``
    say whether the position is attracted, exactly.

    Raises:
        ValueError: for a field that is not linear in the position before it is scaled, a singular one, or zero.
    """
    if field.matrix is None or not _is_regular(field):
        raise ValueError(f"required a regular linear field that is not zero, received {field.kind}")
    (a, b), (c, d) = field.matrix
    has_size, predicted = field.speed is not None, partial(Prediction, footprint, field)
    sense = 1 if field.speed is None else field.speed.sign()
    attracts = (a + d).sign() * sense < 0 < (a * d - b * c).sign()
    of_disc = "a disc is the same at every heading, and by symmetry there is no moment"
    if a == d and b == -c:
        place: Floats | None = np.zeros(2)
        if has_size and isinstance(footprint, PolygonShape):
            place = PolygonOnField(field, footprint).settle(0.0, np.zeros(2))
        if place is None:
            return predicted(None, math.nan, HeadingEffect.UNKNOWN, (), "no position at rest was found")
        if c:
            reason = "the field is the same from every side, and its moment never vanishes"
            return predicted(attracts, norm(place), HeadingEffect.TURNS, (), reason)
        reason = "the field is the same from every side, and it has a potential: no moment at rest"
        reason = of_disc if has_size and isinstance(footprint, Disc) else reason
        return predicted(attracts, norm(place), HeadingEffect.KEEPS, (), reason)
    if has_size and isinstance(footprint, PolygonShape):
        return _search(predicted, PolygonOnField(field, footprint))
    second = moments(footprint)
    if has_size or second.are_isotropic:
        reason = of_disc if has_size else "second moments are equal about every axis: no moment at any heading"
        return predicted(attracts, 0.0, HeadingEffect.KEEPS, (), reason)
    reason = "M ~ sin 2(theta - theta_0): the long principal axis turns to the weaker pull"
    headings = _principal_headings(second, weaker_along_x=(d - a).sign() < 0)
    return predicted(attracts, 0.0, HeadingEffect.ORIENTS, headings, reason)


# ---- linear fields: second moments ---------------------------------------------------------------


@dataclass(frozen=True)
class Moments:
    """``area``, ``int x^2``, ``int y^2`` and ``int x y`` over a footprint about its centroid, in units of ``unit``.

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
    """Exact moments of a footprint about its centroid, from which it is measured; of a polygon by Green's theorem.

    With ``c_k = p_k x p_(k+1)`` the area is ``1/2 sum c_k``, and for coordinates u and w::

        int u w = 1/24 sum (u_k w_k + u_(k+1) w_(k+1) + (u_k + u_(k+1)) (w_k + w_(k+1))) c_k
    """
    if isinstance(footprint, Disc):
        squared = footprint.radius * footprint.radius
        quarter = squared * squared / 4
        return Moments(squared, quarter, quarter, quarter * 0, math.pi)
    sides = [(p, q, plane.cross(p, q)) for p, q in around(footprint.vertices)]

    zero = footprint.vertices[0][0] * 0

    def second(u: int, w: int) -> Number:
        return sum(((p[u] * p[w] + q[u] * q[w] + (p[u] + q[u]) * (p[w] + q[w])) * c for p, q, c in sides), zero) / 24

    return Moments(sum((c for *_, c in sides), zero) / 2, second(0, 0), second(1, 1), second(0, 1), 1.0)


def _principal_headings(second: Moments, *, weaker_along_x: bool) -> tuple[MomentFreeHeading, ...]:
    """The headings at which the long principal axis lies along x (stable where the pull is weaker there) and y."""
    axis = math.atan2(2 * float(second.xy), float(second.xx - second.yy)) / 2
    along_x = MomentFreeHeading(-axis % math.pi, weaker_along_x)
    along_y = MomentFreeHeading((math.pi / 2 - axis) % math.pi, not weaker_along_x)
    return tuple(sorted((along_x, along_y), key=lambda heading: heading.theta))


# ---- fields of constant size: where a polygon settles --------------------------------------------


class PolygonOnField:
    """A polygon on a field of constant size, in floats; positions are measured from the field's centre.

    Attributes:
        size: largest distance from the centroid.
        area: of the polygon; forces are of its size.
    """

    def __init__(self, field: ContinuousField, footprint: PolygonShape) -> None:
        self._matrix = _directions(field)
        self._sense = 1.0 if field.speed is None else float(field.speed.sign())
        self._vertices = float_points(footprint.vertices)
        self._settles_at_centre = footprint.is_centrally_symmetric
        self.size = float(norms(self._vertices).max())
        self.area = float(moments(footprint).area)

    def wrench(self, theta: float, place: Floats) -> FieldWrench:
        """Force and moment at a pose."""
        c, s = math.cos(theta), math.sin(theta)
        turned = self._vertices @ np.array([[c, s], [-s, c]])
        return polygon_wrench(self._matrix, self._sense, turned + place, place)

    def settle(self, theta: float, place: Floats) -> Floats | None:
        """The position without force near a place, by Newton's method with bounded steps; None where it fails."""
        if self._settles_at_centre:
            return np.zeros(2)
        for _ in range(NEWTON_STEPS):
            wrench = self.wrench(theta, place)
            if max_norm(wrench.force) <= SETTLED * self.area:
                return place
            if not np.linalg.det(wrench.stiffness):
                return None
            step = np.linalg.solve(wrench.stiffness, wrench.force)
            place = place - step * min(1.0, self.size / (2 * norm(step)))
        return None

    def level(self, theta: float, near: Floats) -> float:
        """The moment at the position that is settled near a place, relative to area times size."""
        place = self.settle(theta, near)
        return math.nan if place is None else self.wrench(theta, place).moment / (self.area * self.size)


def _search(predicted: Callable[..., Prediction], body: PolygonOnField) -> Prediction:
    """Headings at which the moment at the settled position changes sign."""
    thetas = ((np.arange(HEADINGS + 1) + GRID_SHIFT) * math.pi / HEADINGS).tolist()
    places, wrenches = [np.zeros(2)], []
    for theta in thetas:
        place = body.settle(theta, places[-1])
        if place is None:
            reason = "no position at rest was found at some heading"
            return predicted(None, math.nan, HeadingEffect.UNKNOWN, (), reason)
        places.append(place)
        wrenches.append(body.wrench(theta, place))
    returns = {_is_restoring(wrench.stiffness) for wrench in wrenches}
    attracts = next((answer for answer in (False, None) if answer in returns), True)
    at_rest = partial(predicted, attracts, max(norm(place) for place in places))
    levels = np.array([wrench.moment for wrench in wrenches])
    if max_norm(levels) <= NEGLIGIBLE * body.area * body.size:
        return at_rest(HeadingEffect.KEEPS, (), "no moment beyond rounding at any heading")
    changes = np.flatnonzero(np.sign(levels[:-1]) * np.sign(levels[1:]) < 0)
    found = [_heading_between(body, thetas[k], thetas[k + 1], places[k + 1]) for k in changes]
    if not found:
        return at_rest(
            HeadingEffect.TURNS, (), f"the moment at rest has one sign at {HEADINGS} headings of half a turn"
        )
    reason = f"sign changes of the moment at rest over {HEADINGS} headings of half a turn"
    return at_rest(HeadingEffect.ORIENTS, tuple(sorted(found, key=lambda heading: heading.theta)), reason)


def _is_restoring(stiffness: Floats) -> bool | None:
    """Whether damped motion under the force returns: eigenvalues with negative real parts; None near zero."""
    stiffness = stiffness / np.abs(stiffness).max()
    trace, determinant = np.trace(stiffness), np.linalg.det(stiffness)
    if trace < -FLAT and determinant > FLAT:
        return True
    return False if trace > FLAT or determinant < -FLAT else None


def _heading_between(body: PolygonOnField, low: float, high: float, place: Floats) -> MomentFreeHeading:
    """The heading between two of opposite moments, and whether the moment turns back there."""
    from scipy.optimize import brentq

    theta = float(brentq(body.level, low, high, (place,), xtol=1e-14)) % math.pi
    slope = (body.level(high, place) - body.level(low, place)) / (high - low)
    theta = 0.0 if min(theta, math.pi - theta) <= AT_ZERO else theta
    return MomentFreeHeading(theta, None if abs(slope) <= FLAT else bool(slope < 0))


# ---- fields of constant size: closed forms -------------------------------------------------------


class FieldWrench(NamedTuple):
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
    """Force and moment of ``f(p) = s A p/|A p|`` on a polygon.

    The field depends on the direction of p only, so the polygon is swept by triangles from the field's centre: on the
    triangle over a side ``p(t) = p_0 + t (p_1 - p_0)`` the area element is ``r (p_0 x p_1) dr dt``, and

        F = sum_sides (p_0 x p_1)/2 int f dt,     M_0 = sum_sides (p_0 x p_1)/3 int p x f dt

    with integrals of 1, t and t^2 over the root of a quadratic.  They are written in the arc length of A p measured
    from the point of the side that is nearest in that length, which keeps every difference free of cancellation.
    (Bohringer, Donald, Kavraki & Lamiraux 2000 study the radial case.)

    Args:
        matrix: A, (2, 2), regular.
        speed: s, force per area.
        vertices: (n, 2), counterclockwise, measured from the field's centre.
        centroid: c, (2,).
    """
    start, end = vertices, following(vertices)
    step = end - start
    image = step @ matrix.T
    length = np.sqrt(squared_norms(image))
    direction, image = step / length[:, None], image / length[:, None]
    first = row_products(start @ matrix.T, image)
    nearest = start - first[:, None] * direction
    push = nearest @ matrix.T
    zeroth, linear, square = _root_integrals(first, first + length, np.sqrt(squared_norms(push)))
    along = (push * zeroth[:, None] + image * linear[:, None]) / length[:, None]
    mixed = cross(nearest, image) + cross(direction, push)
    turning = (cross(nearest, push) * zeroth + mixed * linear + cross(direction, image) * square) / length
    sweep = cross(start, end)
    force = speed * (sweep @ along) / 2
    moment = speed * float(sweep @ turning) / 3 - float(cross(centroid, force))
    outward = np.stack([step[:, 1], -step[:, 0]], axis=1)  # normal times length
    return FieldWrench(force, moment, speed * along.T @ outward)


def _root_integrals(first: Floats, last: Floats, height: Floats) -> tuple[Floats, Floats, Floats]:
    """``int s^k ds/sqrt(s^2 + h^2)`` from ``first`` to ``last`` for k = 0, 1, 2."""
    near, far = np.hypot(first, height), np.hypot(last, height)
    apart = height > THROUGH_CENTRE * (np.abs(first) + np.abs(last))
    h = np.where(apart, height, 1.0)
    a, b = first / h, last / h
    with np.errstate(divide="ignore", invalid="ignore"):
        one_sided = np.arcsinh((b - a) * (b + a) / (b * np.hypot(1, a) + a * np.hypot(1, b)))
    zeroth = np.where(apart, np.where(a * b > 0, one_sided, np.arcsinh(b) - np.arcsinh(a)), 0.0)
    linear = (last - first) * (last + first) / (near + far)
    square = (last * far - first * near - height**2 * zeroth) / 2
    return zeroth, linear, square
