"""Where bodies end that start near the checked point, to an accuracy: a disc about it, or a place away from it.

Bodies are followed by rings about a centre (:mod:`nonsmooth.proofs.robust.touching_rings`): about the checked point,
about a place of rest near it, or about where a path from it ends.  Floats propose the centre, whose coordinates are
then exact, and the shape of the rings; what is proved of them is proved, wherever they lie.  With d the distance of the
centre from the checked point, bodies from within ``R' - d`` of the point end within ``d + r'`` of it.

Kinematics are exact: ``c' = v + omega J c``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.robust.level_sets import Distance, LevelFunction, Place, shapes_about
from nonsmooth.proofs.robust.rings import TouchingRings, root_above
from nonsmooth.proofs.robust.touching_rings import FINER, FINEST, rings_about
from nonsmooth.symbolic.mechanics.body import outer_positions, support_polygon
from nonsmooth.symbolic.mechanics.contact_set import ContactSet
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.under_way import parts
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    are_finite,
    cross,
    field_beside,
    float_points,
    following,
    norm,
    norms,
    point_velocities,
)

Velocity: TypeAlias = Callable[[Floats], Floats]

MOST_WHEELS = 400  # some ten seconds
WIDE = 5  # accuracies: the least radius of the largest disc of starts that is looked for
CLOSE = Fraction(1, 256)  # of the accuracy: a smaller disc about a place of rest is not worth the time
NEAR_REST = Fraction(1, 8)  # of its distance from the point: nor is one that small
BEYOND = 1.05  # of that distance: the disc of starts that is needed where bodies end away from the point
STARTS = (Fraction(1), Fraction(3, 4), Fraction(1, 2), Fraction(1, 4), Fraction(0))  # of a disc of starts
DIGITS = 5  # decimals of a centre, below those of the accuracy
DRIFT_STEPS = 160
GROWTH = 1.5  # of the steps in time of a path
NEWTON_STEPS = 12
STILL = 2.0**-20  # of the fastest wheel: a path so slow is at rest
TIGHT = 2.0**-26  # of the accuracy: when a path is at rest
COARSE = 0.5  # of the accuracy: the same, across edges of the field
DIFFERENCE = 2.0**-22  # of the size of the array, over which the field is differentiated


@dataclass(frozen=True)
class Ends:
    """Where every body from near the point ends.

    Attributes:
        ends_within: radius of the disc about the point in which bodies end, within the accuracy (length); None where
            they end farther away.
        within: radius of the disc of starts (length).
        swings_out_to: a distance from the point that no body from there exceeds (length).
        after: time after which they are there and stay (time).
        at: centre of the disc in which they end, from the checked point (length).
        about: radius of that disc (length).
    """

    ends_within: Fraction | None
    within: Fraction
    swings_out_to: Fraction
    after: Fraction
    at: Place
    about: Fraction

    @property
    def is_near(self) -> bool:
        """Whether that is within the accuracy of the point."""
        return self.ends_within is not None

    @property
    def distance(self) -> float:
        """Of the centre from the point."""
        return math.hypot(*(float(entry) for entry in self.at))


class _OpenReason(Enum):
    """Why rings about a centre do not say where bodies end."""

    RINGS = "they are not shown"
    WHEELS = "other wheels may come under the body on its way, or leave it"


def decide_ends(
    scene: Scene,
    accuracy: Fraction,
    *,
    rests: bool = False,
    kept: ContactSet | None = None,
    finer: Sequence[int] = FINER,
    finest: Sequence[int] = FINEST,
) -> Ends | None:
    """Where bodies end that start near the point of a centred scene; None where that is not shown.

    Args:
        scene: centred, of the wheels that carry, with loads that are known where its rule needs them.
        accuracy: a length.
        rests: whether a body at the point is known to stay there, so that no other place is looked for.
        kept: how far a body with an outline may move and turn on the same wheels.
        finer: into how many parts a ring is divided that is not shown whole.
        finest: the same about places that seem to attract, which takes longest.
    """
    if len(scene.wheels) > MOST_WHEELS:
        return None
    velocity, away = velocity_of(scene), None
    if velocity is None:
        return None
    keeps, ellipses = kept or ContactSet(()), []
    for centre in [(Fraction(0), Fraction(0))] if rests else _centres(scene, velocity, accuracy):
        for shape in _shapes(scene, velocity, centre, accuracy):
            outcome = _about(scene, centre, shape, accuracy, keeps, finer)
            if isinstance(outcome, Ends):
                if outcome.is_near:
                    return outcome
                away = away or outcome
                break
            if outcome is _OpenReason.RINGS and not isinstance(shape, Distance):
                ellipses.append((centre, shape))
    return away or (_in_smaller_pieces(scene, ellipses, accuracy, keeps, finest) if finest else None)


def _in_smaller_pieces(
    scene: Scene,
    ellipses: Sequence[tuple[Place, LevelFunction]],
    accuracy: Fraction,
    keeps: ContactSet,
    finest: Sequence[int],
) -> Ends | None:
    """About places that seem to attract, once more.

    Where rings are shown then, and bodies may come onto other wheels on their way, other rings would not keep them.
    """
    for centre, shape in ellipses:
        outcome = _about(scene, centre, shape, accuracy, keeps, finest)
        if outcome is not _OpenReason.RINGS:
            return outcome if isinstance(outcome, Ends) else None
    return None


def _shapes(scene: Scene, velocity: Velocity, centre: Place, accuracy: Fraction) -> Iterator[LevelFunction]:
    """Of the rings about a centre: circles, and where the field is smooth ellipses that it suggests.

    Where it has an edge nearby, other ellipses are those of its slope over a length that matters.
    """
    if scene.contact.rule in {"nearest", "box"}:
        yield Distance()
        return
    place = np.array([float(entry) for entry in centre])
    _, slope = field_beside(velocity, place, DIFFERENCE * scene.check.half_width)
    if not are_finite(slope):
        yield Distance()
        return
    yield from shapes_about(slope)
    _, coarse = field_beside(velocity, place, COARSE * float(accuracy))
    if are_finite(coarse) and np.linalg.norm(slope - coarse) > np.linalg.norm(coarse):
        yield from (shape for shape in shapes_about(coarse) if not isinstance(shape, Distance))


def _about(
    scene: Scene,
    centre: Place,
    shape: LevelFunction,
    accuracy: Fraction,
    contacts: ContactSet,
    finer: Sequence[int],
) -> Ends | _OpenReason:
    """What rings about a centre show; ``finer``: into how many parts one is divided that is not shown whole."""
    x, y = (scene.field.rational(entry) for entry in centre)
    distance = root_above(centre[0] ** 2 + centre[1] ** 2)
    there = scene.checked_at((x, y), scene.check.radius).recentred() if distance else scene
    most = min(max(scene.check.half_width - float(distance), float(WIDE * accuracy + 2 * distance)), _standing(there))
    if contacts.margin is not None:
        free = max(float(contacts.margin - distance), 0.0) * (1 - 2.0**-20)
        most = min(most, free * shape.inside / shape.outside)
    # to come near they must come from twice the accuracy; to end farther away they need only come from the point
    through = 2 * float(accuracy) + float(distance) if distance < accuracy else float(distance) * BEYOND
    if most <= through:
        return _OpenReason.RINGS
    wanted = max(CLOSE * accuracy, min(NEAR_REST * distance, abs(accuracy - distance) / 2))
    useful = abs(accuracy - distance)  # they end nearer than the accuracy, or as near to a place farther away
    with parts() as say:
        say(f"rings about {place_text(centre, 3)} from the point")
        rings = rings_about(there, most, through, float(wanted) / 2, shape, finer, useful)
    if rings is None or rings.start <= distance:
        return _OpenReason.RINGS
    # bodies arrive in the smallest disc in a finite time where cells end at the place of rest, and slow down elsewhere
    soon = rings.radius if scene.contact.rule == "nearest" else min(wanted, accuracy - distance)
    near = max(rings.radius, soon)
    if distance + near <= accuracy and rings.start >= 2 * accuracy + distance:
        ends_within, about, least = distance + near, near, 2 * accuracy + distance
    else:
        ends_within, about, least = None, max(rings.radius, min(wanted, CLOSE * accuracy)), distance * Fraction(BEYOND)
        if distance * (1 - Fraction(1, 2**20)) - about <= accuracy:
            return _OpenReason.RINGS
    within = _kept_start(there, rings, contacts, distance, least, about)
    if within is None:
        return _OpenReason.WHEELS
    swing, after = distance + rings.swing_from(within), rings.time_to(about, within)
    return Ends(ends_within, within - distance, swing, after, centre, about)


def _kept_start(
    scene: Scene, rings: TouchingRings, contacts: ContactSet, distance: Fraction, least: Fraction, near: Fraction
) -> Fraction | None:
    """Radius of a disc of starts about a centre from which no wheel enters or leaves on the way; None below ``least``.

    Args:
        scene: recentred about the centre.
        rings: about it.
        contacts: how far the body may move from the checked point, and turn.
        distance: of the centre from the checked point.
        least: the least radius that is of use.
        near: radius of the disc at which the way ends.
    """
    if contacts.margin is None:
        return rings.start
    turns = _Turns(scene, rings, near)

    def keeps(start: Fraction) -> bool:
        turn = Fraction(0) if contacts.angle is None else turns.on_the_way_from(start)
        return contacts.keeps(distance + rings.swing_from(start), turn)

    # bodies from farther away swing out farther and turn more: where the nearest do not serve, none do
    smallest = min(least, rings.start)
    if not keeps(smallest):
        return None
    starts = (share * rings.start for share in STARTS)
    return next((start for start in starts if start > smallest and keeps(start)), smallest)


class _Turns:
    """Bounds of how far bodies turn on their way inward, of one ring after the other."""

    def __init__(self, scene: Scene, rings: TouchingRings, near: Fraction) -> None:
        """For a scene that is centred about the rings, and a radius at which the way ends."""
        self._scene, self._rings, self._near = scene, rings, near
        self._spins: dict[Fraction, Fraction | None] = {}

    def on_the_way_from(self, start: Fraction) -> Fraction | None:
        """The sum over rings of the time that bodies spend in each and the largest rate there; None if unknown."""
        total, outer = Fraction(0), self._rings.start
        while outer > self._near:
            inner = max(outer / 2, self._near)
            if inner < start:
                spin = self._spin(outer)
                if spin is None:
                    return None
                total += spin * self._rings.time_to(inner, min(outer, start))
            outer = inner
        return total

    def _spin(self, radius: Fraction) -> Fraction | None:
        """The largest rotation rate of bodies that come from within a radius."""
        if radius not in self._spins:
            from nonsmooth.proofs.robust.drift import largest_spin

            self._spins[radius] = largest_spin(self._scene, self._rings.swing_from(radius))
        return self._spins[radius]


def _standing(scene: Scene) -> float:
    """A radius about the point of a centred scene within which the body stands on the wheels."""
    corners = support_polygon(outer_positions(scene.positions))
    if len(corners) < 3:
        return 0.0
    places = float_points(corners)
    along = following(places) - places
    lengths = norms(along)
    if not lengths.all():  # floats do not tell corners apart that are far away
        return 0.0
    distances = (cross(places, along)) / lengths
    return float(distances.min()) * (1 - 2.0**-30)


# ---- centres, proposed by floats ---------------------------------------------------------------


def _centres(scene: Scene, velocity: Velocity, accuracy: Fraction) -> Iterator[Place]:
    """The point itself, a zero of the field near it, and where a path from it ends."""
    size = float(accuracy)
    earlier: list[Floats] = []
    for place in _proposed(scene, velocity, size):
        if place is not None and all(np.hypot(*(place - other)) > size / 64 for other in earlier):
            earlier.append(place)
            unit = Fraction(10) ** (math.floor(math.log10(size)) - DIGITS)
            x, y = (round(Fraction(float(entry)) / unit) * unit for entry in place)
            yield x, y


def _proposed(scene: Scene, velocity: Velocity, size: float) -> Iterator[Floats | None]:
    most = scene.check.half_width
    yield np.zeros(2) if scene.contact.rule in {"nearest", "box"} else _zero(velocity, size, most)
    if scene.contact.rule == "nearest":
        yield _end_of_path(velocity, size, STILL * scene.fastest)
    else:
        yield _end_of_stiff_path(velocity, size, most)
    yield np.zeros(2)


def velocity_of(scene: Scene) -> Velocity | None:
    """Of the centre of mass at a place, in floats."""
    if scene.contact.rule == "nearest":
        from nonsmooth.analysis.fields.contact_model import contact_model
        from nonsmooth.analysis.minimizers.sampling import literal_twist

        model = contact_model(scene)
        return lambda place: point_velocities(literal_twist(model, place), place)
    forces = BalancedForces.of(scene)
    if forces is None:
        return None

    def velocity(places: Floats) -> Floats:
        velocities = forces.velocities(np.atleast_2d(places))
        return velocities if places.ndim > 1 else velocities[0]

    return velocity


def _end_of_stiff_path(velocity: Velocity, size: float, most: float) -> Floats | None:
    """Where a path from the point ends, by implicit steps in time that become longer; None where they lead away."""
    place, duration = np.zeros(2), 0.0
    for _ in range(DRIFT_STEPS // 2):
        here, slope = field_beside(velocity, place, DIFFERENCE * most)
        speed = norm(here)
        if not are_finite(slope) or not np.isfinite(speed):
            return None
        duration = duration * GROWTH or size / 4 / speed if speed else 0.0
        if not duration:
            return place
        try:
            move = np.linalg.solve(np.eye(2) - duration * slope, duration * here)
        except np.linalg.LinAlgError:
            return None
        length = norm(move)
        if length > size:  # the field is not linear so far
            move, duration = move * size / length, duration / GROWTH**3
        place = place + move
        if np.hypot(*place) > 2 * most:
            return None
        if length <= TIGHT * size:
            break
    return place


def _zero(velocity: Velocity, size: float, most: float) -> Floats | None:
    """By Newton's method from the point, with differences; None where it leaves the checked square."""
    place = np.zeros(2)
    for _ in range(NEWTON_STEPS):
        here, slope = field_beside(velocity, place, DIFFERENCE * most)
        try:
            move = -np.linalg.solve(slope, here)
        except np.linalg.LinAlgError:
            return None
        length = norm(move)
        if not np.isfinite(length):
            return None
        place = place + move * min(1.0, most / 4 / length if length else 1.0)
        if np.hypot(*place) > most:
            return None
        if length <= TIGHT * size:
            return place
    return None


def _end_of_path(velocity: Velocity, size: float, still: float) -> Floats | None:
    """Where steps along the field lead that become shorter whenever it turns back; None where they lead away."""
    place, step = np.zeros(2), size / 2
    before = np.zeros(2)
    for _ in range(DRIFT_STEPS):
        now = velocity(place)
        speed = norm(now)
        if not np.isfinite(speed):
            return None
        if speed <= still or step <= TIGHT * size:
            return place
        now = now / speed
        if now @ before < 0:
            step /= 2
        place, before = place + step * now, now
    return place
