"""Which wheels carry a body at the checked pose, and how far it may move before that changes.

A wheel carries iff it lies strictly under the outline.  For wheel i at ``q_i = p_i - c`` let ``d_i`` be its distance
from the outline's border.  A displacement of c by r and a turn by phi move the wheel in the body's frame by at most
``r + |q_i| phi``, so no wheel enters or leaves while ``r + |q_i| phi < d_i`` for all of them; with ``margin = min d_i``
and ``angle = min d_i/|q_i|`` that holds while ``r/margin + phi/angle < 1``.  At a fixed heading the largest square
about c with that property is exact for polygons: convex polygons are apart iff a normal of one of their sides says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from math import hypot, isqrt
from typing import NamedTuple

from flint import arb

from nonsmooth.symbolic.mechanics.body import Body, Disc, chosen, outer_positions, square_rooms, support_polygon
from nonsmooth.symbolic.mechanics.load_model import LoadModel
from nonsmooth.symbolic.mechanics.scene import LoadTable, Scene, Wheel, default_length
from nonsmooth.symbolic.mechanics.springs import radius_to_check
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import PRECISION, rational_above, rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import exact_place, float_text
from nonsmooth.symbolic.numbers.plane import Vector, around, cross, dot, minus, side_of, squared_distance


class TipsError(SceneError):
    """A body that does not stand at the checked pose.

    Attributes:
        carrying: numbers of the wheels under it.
        why: in words, for people.
    """

    def __init__(self, scene: Scene, carrying: tuple[int, ...], why: str) -> None:
        super().__init__(scene.origin, "body", "a body that stands at the checked pose", StatedFact(why))
        self.carrying, self.why = carrying, why


class NoLoadsError(SceneError):
    """Loads that are known of all wheels together only."""

    def __init__(self, scene: Scene) -> None:
        expected = "elastic loads, or a body that covers every wheel"
        super().__init__(scene.origin, "contact.loads", expected, StatedFact("a table of wheels that do not all carry"))


class ContactSet(NamedTuple):
    """The wheels that carry a body at the checked pose, and how far it may move before that changes.

    Attributes:
        wheels: their numbers, ascending.
        margin: displacement of c (length) below which, at the checked heading, no wheel enters or leaves; a lower
            bound.  None without a body: nothing ever changes.
        angle: turn (radian) below which, at the checked place, none does; a lower bound.  None where no turn matters.
    """

    wheels: tuple[int, ...]
    margin: Fraction | None = None
    angle: Fraction | None = None

    def start_that_keeps(self, turn_per_distance: Number | Fraction) -> Number | Fraction | None:
        """Distance from the point within which a body starts and comes home, while no wheel enters or leaves.

        Args:
            turn_per_distance: bound tau on its whole turn, for each 1 of distance, where the distance never grows:
                ``r/margin + tau r/angle < 1``.
        """
        if self.margin is None:
            return None
        inverse = 1 / self.margin if self.angle is None else 1 / self.margin + turn_per_distance / self.angle
        return 1 / inverse

    def keeps(self, reach: Fraction, turn: Fraction | None) -> bool:
        """Whether no wheel enters or leaves on a way.

        Args:
            reach: its largest distance from the point.
            turn: a bound of what the body turns on it (radian); None where none is known.
        """
        if self.margin is None:
            return True
        if self.angle is None:
            return reach < self.margin
        return turn is not None and reach / self.margin + turn / self.angle < 1


def contact_set(scene: Scene) -> ContactSet:
    """The wheels that carry at the checked pose; all of them without a body."""
    numbers = scene.numbers
    if scene.body is None:
        return ContactSet(numbers)
    body, at = scene.body, scene.check.equilibrium
    places = [minus(wheel.position, at) for wheel in (*scene.wheels, *scene.idle)]
    margin = min(distance_below(body, place) for place in places)
    return ContactSet(numbers, margin, None if body.is_round else free_angle(body, places, margin))


def checked_scene(scene: Scene) -> Scene:
    """What a check is about: the wheels that carry at the checked pose; the scene where a body does not stand there."""
    try:
        return standing(scene)
    except SceneError:
        return scene


def accuracy_at_point(scene: Scene) -> Fraction:
    """How near a body must come (length): what a check says."""
    return checked_scene(scene).accuracy


def wheels_text(scene: Scene) -> str:
    """How many wheels there are, and how many of them carry the body of a scene that stands on some."""
    if not scene.idle:
        return f"{len(scene.wheels)} wheels"
    return f"{len(scene.wheels)} of {len(scene.wheels) + len(scene.idle)} wheels carry the body"


def standing(scene: Scene) -> Scene:
    """The array of the wheels that carry at the checked pose, in a square where no wheel enters or leaves.

    The others are kept as ``idle``.  Without a body the scene itself.

    Raises:
        TipsError: where fewer than three wheels carry, or the centre of mass is not strictly inside their hull.
        SceneError: where a wheel lies exactly under the edge, and for a table of loads of wheels that do not all carry.
    """
    if scene.body is None:
        return scene
    point = scene.check.equilibrium
    wheels = whole(scene).wheels
    carrying = tuple(wheel for wheel in wheels if _carries(scene, scene.body, wheel, point))
    idle = tuple(wheel for wheel in wheels if wheel not in carrying)
    require_standing(scene, carrying, point)
    if idle:
        _require_no_table(scene)
    positions = [wheel.position for wheel in carrying]
    check = scene.check
    if check.has_default_radius:
        check = replace(check, radius=chosen(radius_to_check(positions, point, scene.contact), scene.units))
    if check.has_default_length:
        check = replace(check, length=default_length(positions, point))
    widest = chosen(free_half_width(scene.body, [minus(wheel.position, point) for wheel in wheels], scene), scene.units)
    if widest < check.radius:
        stated = None if check.has_default_radius else check.wider or check.radius
        check = replace(check, radius=widest, wider=stated)
    return replace(scene, wheels=carrying, idle=idle, check=check)


def tipped(scene: Scene, tipping: TipsError) -> Scene:
    """The array of a body that does not stand: its wheels are those under the body, idle those that it misses."""
    wheels = whole(scene).wheels
    under = tuple(wheel for wheel in wheels if wheel.index in tipping.carrying)
    return replace(scene, wheels=under, idle=tuple(wheel for wheel in wheels if wheel not in under))


def whole(scene: Scene) -> Scene:
    """The array with all its wheels in their order, whether they carry or not."""
    if not scene.idle:
        return scene
    return replace(scene, wheels=tuple(sorted((*scene.wheels, *scene.idle), key=lambda wheel: wheel.index)), idle=())


def with_only(scene: Scene, wheels: Sequence[Wheel]) -> Scene:
    """The array of some of its wheels, with the loads that these carry without the others.

    Raises:
        NoLoadsError: where these loads are not known.
    """
    every = whole(scene)
    loads = every.contact.loads
    if isinstance(loads, LoadModel):
        loads = loads.on([every.places[wheel.index] for wheel in wheels])
        if loads is None:
            raise NoLoadsError(scene)
    return replace(every, wheels=tuple(wheels), contact=replace(every.contact, loads=loads))


def require_no_outline(scene: Scene) -> None:
    """For simulations that do not follow wheels under an edge.

    Raises:
        SceneError: where the scene has a body.
    """
    if scene.body is not None:
        expected = "a path by events with exact kinematics, or a map of starts, for an outline"
        raise SceneError(scene.origin, "body", expected, StatedFact("another simulation"))


def require_springs(scene: Scene) -> None:
    """For bodies that other wheels carry on the way: wheels lift off and come to carry.

    Raises:
        SceneError: for loads that are known for one set of wheels only, and for unknown ones.
    """
    loads = scene.contact.loads
    if loads is not None and not (isinstance(loads, LoadModel) and loads.lifts_off):
        expected = "elastic loads on the way of a body with an outline"
        received = "a table" if type(loads) is LoadTable else loads.words
        raise SceneError(scene.origin, "contact.loads", expected, StatedFact(received))


def alone(scene: Scene) -> Scene:
    """The wheels that carry the body as an array of their own, numbered anew: what certificates speak of."""
    if scene.body is None:
        return scene
    stands = standing(scene)
    restricted = with_only(scene, stands.wheels)
    wheels = tuple(replace(wheel, index=number) for number, wheel in enumerate(stands.wheels, 1))
    return replace(stands, wheels=wheels, contact=restricted.contact, idle=(), body=None)


def on_wheels(scene: Scene, numbers: Sequence[int]) -> Scene:
    """The array of some wheels alone, numbered as in the scene, with a body that stands on them at the checked point.

    The square is at most a part of their support polygon.

    Raises:
        TipsError: where fewer than three wheels carry, or the centre of mass is not strictly inside their hull.
        SceneError: for a table of loads of wheels that do not all carry.
    """
    wheels, point, check = whole(scene).wheels, scene.check.equilibrium, scene.check
    carrying = tuple(wheel for wheel in wheels if wheel.index in numbers)
    require_standing(scene, carrying, point)
    if len(carrying) < len(wheels):
        _require_no_table(scene)
    inner = chosen(radius_to_check([wheel.position for wheel in carrying], point, scene.contact), scene.units)
    if inner < check.radius:
        check = replace(check, radius=inner)
    return replace(with_only(scene, carrying), body=None, check=check)


def _require_no_table(scene: Scene) -> None:
    if isinstance(scene.contact.loads, LoadTable):
        raise NoLoadsError(scene)


def _carries(scene: Scene, body: Body, wheel: Wheel, point: Vector) -> bool:
    """Whether a wheel lies strictly under the body.

    Raises:
        SceneError: where it lies exactly under the edge.
    """
    place = minus(wheel.position, point)
    side = side_of_outline(body, place)
    if side:
        return side > 0
    shift = f"a small shift along {exact_place(outward_at(body, place))} puts it under the body, against it beside"
    received = StatedFact(f"wheel {wheel.index} under its edge: {shift}")
    raise SceneError(scene.origin, "body", "a pose with every wheel under the body or beside it", received)


def require_standing(scene: Scene, carrying: Sequence[Wheel], point: Vector) -> None:
    """Refuse a pose at which a body does not stand on these wheels.

    Args:
        scene: the array, for messages.
        carrying: the wheels under the body.
        point: where its centre of mass is.

    Raises:
        TipsError: where fewer than three wheels carry, or the centre of mass is not strictly inside their hull.
    """
    numbers = tuple(wheel.index for wheel in carrying)
    if len(carrying) < 3:
        which = " and ".join(map(str, numbers))
        words = {0: "no wheel under it", 1: f"wheel {which} alone under it"}.get(
            len(numbers), f"wheels {which} alone under it"
        )
        raise TipsError(scene, numbers, f"{words}: it tips")
    hull = support_polygon(outer_positions([wheel.position for wheel in carrying]))
    if len(hull) < 3:
        raise TipsError(scene, numbers, f"all {len(numbers)} wheels under it on one line: it tips")
    beyond = [side for side in around(hull) if cross(minus(side[1], side[0]), minus(point, side[0])).sign() <= 0]
    if beyond:
        corner, following = max(beyond, key=lambda side: _distance_beyond(side, point))
        away = _distance_beyond((corner, following), point)
        where = f"{float_text(away, 4)}{scene.units.after_length} beyond" if away > 0 else "on"
        edge = f"wheels {_number_at(carrying, corner)} and {_number_at(carrying, following)}"
        why = f"its centre of mass {where} the line through {edge}: it tips over it"
        raise TipsError(scene, numbers, why)


def _distance_beyond(side: tuple[Vector, Vector], point: Vector) -> float:
    """How far a point is on the outer side of a side of a polygon (length)."""
    along = minus(side[1], side[0])
    return -float(cross(along, minus(point, side[0]))) / hypot(*map(float, along))


def _number_at(wheels: Sequence[Wheel], place: Vector) -> int:
    return next(wheel.index for wheel in wheels if wheel.position == place)


# ---- distance to an outline ----------------------------------------------------------------------
#
# Exact for polygons where the numbers allow it, else short rational lower bounds from balls.


BELOW_ROOT_HALF = Fraction(7071, 10_000)  # a square of that half-width lies in the unit disc
SHORT_BITS = 24  # of a margin, which is rounded down


def side_of_outline(body: Body, place: Vector) -> int:
    """1 strictly inside the outline, 0 on it, -1 outside; the place is measured from the centre of mass."""
    if isinstance(body.outline, Disc):
        away = minus(place, body.centroid)
        return (body.outline.radius * body.outline.radius - dot(away, away)).sign()
    return side_of(body.vertices, place)


def outward_at(body: Body, place: Vector) -> Vector:
    """A direction out of the body at a place on its edge."""
    if isinstance(body.outline, Disc):
        return minus(place, body.centroid)
    for a, b in around(body.vertices):
        if not cross(minus(b, a), minus(place, a)):
            return b[1] - a[1], a[0] - b[0]
    raise ValueError("required a place on the edge")


def distance_below(body: Body, place: Vector) -> Fraction:
    """A lower bound of the distance of a place from the outline's border; the distance itself where it is rational."""
    if isinstance(body.outline, Disc):
        gap = body.outline.radius.accurate_ball(PRECISION) - _length(minus(place, body.centroid))
        return _short(rational_below(abs(gap)))
    return _root_below(_squared_gap(body, place))


def may_turn_off_wheels(scene: Scene) -> bool:
    """Whether some turn about the checked point may bring a wheel under the edge of the outline, or from under it."""
    body, at = scene.body, scene.check.equilibrium
    if body is None or isinstance(body.outline, Disc):
        return body is not None and not body.is_round
    inner, outer = _squared_gap(body, minus(at, at)), max(dot(corner, corner) for corner in body.vertices)
    places = [minus(wheel.position, at) for wheel in (*scene.wheels, *scene.idle)]
    return any(inner <= dot(place, place) <= outer for place in places)


def _squared_gap(body: Body, place: Vector) -> Number:
    """Squared distance of a place from the border of a polygon."""
    return min(squared_distance(minus(a, place), minus(b, place)) for a, b in around(body.vertices))


def free_angle(body: Body, places: Sequence[Vector], margin: Fraction) -> Fraction | None:
    """``min d_i/|q_i|``; wheels that no turn brings nearer to the body than the margin do not count."""
    if isinstance(body.outline, Disc):
        reach = body.outline.radius.accurate_ball(PRECISION) + _length(body.centroid)
    else:
        reach = max(dot(corner, corner) for corner in body.vertices).accurate_ball(PRECISION).sqrt()
    far = reach + rational_ball(margin)
    turned = [place for place in places if any(place) and not _length(place) > far]
    return min((_turn_below(body, place) for place in turned), default=None)


def _turn_below(body: Body, place: Vector) -> Fraction:
    """A lower bound of ``d/|q|``."""
    if isinstance(body.outline, Disc):
        return _short(distance_below(body, place) / rational_above(_length(place)))
    return _root_below(_squared_gap(body, place) / dot(place, place))


def _length(vector: Vector) -> arb:
    """The length of a vector, as a ball."""
    return dot(vector, vector).accurate_ball(PRECISION).sqrt() if any(vector) else arb(0)


def _root_below(squared: Number) -> Fraction:
    """The root of a positive number where it is rational, else a short fraction just below."""
    rational = squared.as_rational()
    if rational is not None:
        above, below = isqrt(int(rational.p)), isqrt(int(rational.q))
        if above * above == rational.p and below * below == rational.q:
            return Fraction(above, below)
    return _short(rational_below(squared.accurate_ball(PRECISION).sqrt()))


def _short(value: Fraction) -> Fraction:
    """A short fraction just below a positive number."""
    exponent = SHORT_BITS - (value.numerator.bit_length() - value.denominator.bit_length())
    scale = Fraction(2) ** exponent
    return Fraction((value * scale).__floor__()) / scale


def free_half_width(body: Body, places: Sequence[Vector], scene: Scene) -> Number:
    """Half-width of the largest square of c in which, at the checked heading, no wheel enters or leaves."""
    if isinstance(body.outline, Disc):
        return scene.field.rational(_short(min(distance_below(body, place) for place in places) * BELOW_ROOT_HALF))
    return min(_half_width_of(body.vertices, place) for place in places)


def _half_width_of(corners: Sequence[Vector], place: Vector) -> Number:
    """How far a square may reach until it brings one wheel across the border of a convex polygon.

    For a side with outward normal m through a: inside, ``m . (place - a) <= -r (|m_x| + |m_y|)`` for every side;
    outside, ``>= r (|m_x| + |m_y|)`` for one of the sides, or of the sides of the square.
    """
    rooms = square_rooms(corners, place)
    if all(room.sign() > 0 for room in rooms):
        return min(rooms)
    x, y = place
    apart = [
        x - max(corner[0] for corner in corners),
        min(corner[0] for corner in corners) - x,
        y - max(corner[1] for corner in corners),
        min(corner[1] for corner in corners) - y,
    ]
    return max(-min(rooms), *apart)
