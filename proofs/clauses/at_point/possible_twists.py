"""Rule ``box`` under every admissible load: where each twist is the motion under some load, exactly.

A twist xi minimizes D at the centre of mass c under loads N iff friction forces balance there,

    sum_i N_i F_i = 0,     F_i in the hull of the corners  sum_k b_k t_k a_k  over the rows k of wheel i,

b_k the friction of a row per load and t_k the sign of its residual at xi, or either sign where it has none.  With a
weight ``w >= 0`` for each wheel and corner, N_i the sum of those of wheel i ::

    sum w = 1,      sum w F = 0,      sum w p_i = c.

So the places at which xi is possible are the shadow of a polytope, a convex polygon; the farthest in a direction is a
linear program of four rows, solved exactly.  From the farthest along the axes on, each edge between two places is
either a side, where its normal leads no farther, or shows another place.  Looked at are the twists that satisfy three
independent rows: where two wheels or more carry, every minimizer is a mean of such ones.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

from nonsmooth.analysis.cells.partition import RefusalError, require_rank
from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.symbolic.mechanics.body import support_polygon
from nonsmooth.symbolic.mechanics.contact_states import (
    ContactState,
    Triple,
    Twist,
    added,
    regular_states,
    rows_with_friction,
    scaled,
    triples_with_friction,
)
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, around, cross, dot, minus, turned

MOST_TRIPLES = 1000  # of rows: nine wheels, some tens of seconds
AXES = ((1, 0), (0, 1), (-1, 0), (0, -1))


@dataclass(frozen=True)
class PossibleTwist:
    """A twist with the places where it minimizes D under some admissible load.

    Attributes:
        state: three rows that it satisfies.
        corners: of the convex polygon of these places, counterclockwise; two for a segment, one for a point.
    """

    state: ContactState
    corners: tuple[Vector, ...]

    def holds(self, place: Vector) -> bool:
        """Whether it is possible at a place."""
        if len(self.corners) == 1:
            return place == self.corners[0]
        inside = all(cross(minus(b, a), minus(place, a)).sign() >= 0 for a, b in around(self.corners))
        if len(self.corners) > 2:
            return inside
        a, b = self.corners
        return inside and dot(minus(place, a), minus(place, b)).sign() <= 0


def possible_twists(scene: Scene) -> tuple[PossibleTwist, ...]:
    """All twists that are possible anywhere, in the scene's coordinates; the first state of each names it.

    Raises:
        RefusalError: where the rows with friction do not span, and for too many rows.
    """
    require_rank(rows_with_friction(scene), "friction: required rows")
    count = triples_with_friction(scene)
    if count > MOST_TRIPLES:
        raise RefusalError(
            f"wheels: required at most {MOST_TRIPLES} triples of rows with friction (nine wheels) for the motions that "
            f"unknown loads leave possible, received {count}"
        )
    states: dict[Twist, ContactState] = {}
    for state in regular_states(scene):
        states.setdefault(state.twist, state)
    places = ((state, _places(scene, twist)) for twist, state in states.items())
    return tuple(PossibleTwist(state, corners) for state, corners in places if corners)


@dataclass(frozen=True)
class _ProgramColumns:
    """The columns of the linear program: places, and ``(1, F)`` of each wheel and corner."""

    places: tuple[Vector, ...]
    columns: tuple[tuple[Number, ...], ...]

    def farthest(self, direction: Vector) -> Vector | None:
        """A place that is farthest in a direction; None where there is none at all."""
        zero = direction[0].field.zero
        prices = [dot(direction, place) for place in self.places]
        best = best_mixture(self.columns, (zero + 1, zero, zero, zero), prices)
        if best is None:
            return None
        x = sum((w * self.places[k][0] for k, w in best.weights.items()), zero)
        y = sum((w * self.places[k][1] for k, w in best.weights.items()), zero)
        return x, y


def _places(scene: Scene, twist: Twist) -> tuple[Vector, ...]:
    """The corners of the polygon of one twist; none where it is possible nowhere."""
    shadow, zero = _shadow(scene, twist), scene.field.zero
    known: list[Vector] = []
    for x, y in AXES:
        place = shadow.farthest((zero + x, zero + y))
        if place is None:
            return ()
        known.append(place)
    hull, sides = _hull(known), set[tuple[Vector, Vector]]()
    while True:
        edge = next((edge for edge in around(hull) if edge not in sides), None) if len(hull) > 1 else None
        if edge is None:
            return tuple(hull)
        outward = turned(minus(edge[0], edge[1]))
        place = shadow.farthest(outward)
        if place is None or dot(outward, minus(place, edge[0])).sign() <= 0:
            sides.add(edge)
        else:
            hull = _hull([*hull, place])


def _shadow(scene: Scene, twist: Twist) -> _ProgramColumns:
    places, columns = [], []
    for wheel_index, wheel in enumerate(scene.wheels):
        for force in _corner_forces(scene, wheel_index, twist):
            places.append(wheel.position)
            columns.append((scene.field.one, *force))
    return _ProgramColumns(tuple(places), tuple(columns))


def _corner_forces(scene: Scene, place: int, twist: Twist) -> Iterator[Triple]:
    """The corners of the wrenches that a wheel can bear at a twist, per load."""
    wheel, zero = scene.wheels[place], scene.field.zero
    rows = [row for row in rows_with_friction(scene) if row.wheel.index == wheel.index]
    signs = [(row.residual(twist).sign(),) if row.residual(twist) else (1, -1) for row in rows]
    for chosen in product(*signs):
        force: Triple = (zero, zero, zero)
        for row, sign in zip(rows, chosen, strict=True):
            force = added(force, scaled(row.normal, row.friction * sign / wheel.length))
        yield force


def _hull(places: Sequence[Vector]) -> list[Vector]:
    """The corners of the hull, counterclockwise; the ends of a segment, or one point."""
    distinct = list(dict.fromkeys(places))
    return list(support_polygon(distinct)) if len(distinct) > 1 else distinct
