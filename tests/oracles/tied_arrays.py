"""Arrays of rules ``nearest`` and ``box`` with exact coincidences at the checked point; all numbers are fractions."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import flint
import numpy as np
import numpy.typing as npt

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.symbolic.mechanics.scene import Contact
from nonsmooth.symbolic.numbers.lazy import Lazy
from tests.conftest import WheelData
from tests.oracles.nearest_paths import NearestArray, Twist, Wheel, as_arb

if TYPE_CHECKING:
    from nonsmooth.symbolic.mechanics.scene import Scene
    from tests.conftest import Arrays


# ---- Arrays of rule ``nearest`` with exact coincidences at the checked point, the origin; all numbers are fractions.
#
# Verdicts go wrong where signs vanish, and random arrays have no vanishing signs. So each array here is random first,
# and then speeds, rims or places are changed until a velocity lies exactly along a ray, two velocities are opposed, a
# motion does not turn, a rim points at another wheel, and so on. ``omega`` takes both signs by itself.

Pair: TypeAlias = tuple[Fraction, Fraction]
Floats: TypeAlias = npt.NDArray[Any]
Numbers: TypeAlias = npt.NDArray[np.int64]
Tie: TypeAlias = Callable[[list[Wheel], random.Random], list[Wheel]]

SPEEDS = [Fraction(n, d) for n in (-7, -5, -4, -3, -2, -1, 1, 2, 3, 4, 5, 7) for d in (1, 2, 3, 5)]
FOUND = Path(__file__).with_name("turning_arrays.csv")
POOL, BATCH = 400, 50_000  # turning arrays to begin with; candidates looked at together
TRIES = 20  # of coincidences for one array that turns, until it still turns
SHARE_OF_OTHERS = 0.2  # of arrays in which not all velocities turn about the origin in one sense
SHARE_OF_ESCAPES = 0.1  # of arrays in which a velocity points into the inside of its own cone: seldom worth a look


def cross(a: Pair, b: Pair) -> Fraction:
    """The planar cross product."""
    return a[0] * b[1] - a[1] * b[0]


def circle_point(rng: random.Random) -> Pair:
    """A rational point of the unit circle."""
    t = Fraction(rng.randint(-12, 12), rng.randint(1, 8))
    x, y = (1 - t * t) / (1 + t * t), 2 * t / (1 + t * t)
    return (x, y) if rng.random() < 0.5 else (-x, y)


def rotated(vector: Pair, turn: Pair) -> Pair:
    """The vector turned by the angle of a unit vector."""
    (x, y), (c, s) = vector, turn
    return c * x - s * y, s * x + c * y


# ---- random arrays -------------------------------------------------------------------------


def on_a_circle(rng: random.Random) -> list[Wheel]:
    """Two to five wheels at equal distances from the origin."""
    points: dict[Pair, None] = {}
    count = rng.choice((2, 3, 3, 3, 4, 4, 5))
    while len(points) < count:
        points[circle_point(rng)] = None
    return _wheels(list(points), rng)


def turning(rng: random.Random) -> list[Wheel]:
    """Three wheels on a circle whose motions all turn about the origin in one sense, at some common speed."""
    pace = abs(rng.choice(SPEEDS))
    return [wheel._replace(speed=pace * wheel.speed) for wheel in rng.choice(turning_pool())]


@cache
def turning_pool() -> list[list[Wheel]]:
    """The arrays that a file lists, for finding them takes many seconds: those of :func:`found_by_search`."""
    numbers = np.loadtxt(FOUND, dtype=int, delimiter=",")
    return [_of_numbers(*row.reshape(3, 3)) for row in numbers]


def found_by_search() -> list[list[int]]:
    """Turning arrays among many at random: one in some 4,000 turns.

    Returns:
        For each the numbers of its three places, then of its rims and of its speeds: what the file lists.
    """
    generator = np.random.default_rng(0)
    points, rims = _circle_points()
    found: list[list[int]] = []
    while len(found) < POOL:
        places, directions = generator.integers(len(points), size=(2, BATCH, 3))
        speeds = generator.integers(len(SPEEDS), size=(BATCH, 3))
        turns = _turning_in_floats(
            np.array(points, dtype=float)[places],
            np.array(rims, dtype=float)[directions],
            np.array(SPEEDS, dtype=float)[speeds],
        )
        for k in np.flatnonzero(turns):
            wheels = _of_numbers(places[k], directions[k], speeds[k])
            if len({wheel.position for wheel in wheels}) == 3 and _turns(wheels):
                found.append([*places[k].tolist(), *directions[k].tolist(), *speeds[k].tolist()])
    return found


@cache
def _circle_points() -> tuple[list[Pair], list[Pair]]:
    """Places and rims to choose from."""
    rng = random.Random(0)
    return [circle_point(rng) for _ in range(600)], [circle_point(rng) for _ in range(600)]


def _of_numbers(places: Numbers, directions: Numbers, speeds: Numbers) -> list[Wheel]:
    points, rims = _circle_points()
    return [_wheel(points[p], rims[d], SPEEDS[u]) for p, d, u in zip(places, directions, speeds, strict=True)]


def _turning_in_floats(p: Floats, d: Floats, u: Floats) -> Floats:
    """Which of many arrays, shape (arrays, 3, 2), turn in every cone: a proposal that fractions confirm."""
    a, b = np.array(list(combinations(range(3), 2))).T
    gaps = p[:, a] - p[:, b]
    angles = np.arctan2(gaps[..., 0], -gaps[..., 1])
    angles = np.sort(np.concatenate([angles, angles + np.pi], axis=1) % (2 * np.pi), axis=1)
    ends = np.roll(angles, -1, axis=1) + np.where(np.arange(6) == 5, 2 * np.pi, 0)
    middles = (angles + ends) / 2
    reach = np.einsum("nkx,ncx->nck", p, np.stack([np.cos(middles), np.sin(middles)], axis=-1))
    order = np.argsort(-reach, axis=2)
    i, j = order[..., 0], order[..., 1]
    rows = np.arange(len(p))[:, None]
    pi, pj, di, dj, ui, uj = p[rows, i], p[rows, j], d[rows, i], d[rows, j], u[rows, i], u[rows, j]
    lever = dj[..., 1] * (pj - pi)[..., 0] - dj[..., 0] * (pj - pi)[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        omega = (uj - ui * (di * dj).sum(axis=-1)) / lever
        vx, vy = ui * di[..., 0] + omega * pi[..., 1], ui * di[..., 1] - omega * pi[..., 0]
        products = [np.cos(ray) * vy - np.sin(ray) * vx for ray in (angles, ends)]
    lowest, highest = np.minimum(*products).min(axis=1), np.maximum(*products).max(axis=1)
    return np.asarray((lowest > 0) | (highest < 0))


def one_nearest(rng: random.Random) -> list[Wheel]:
    """One wheel is the nearest all around, and two or three others are equally far: half-planes, or wide cones."""
    points: dict[Pair, None] = {}
    while len(points) < rng.choice((2, 2, 3)):
        x, y = circle_point(rng)
        points[2 * x, 2 * y] = None
    near = circle_point(rng)
    first = (Fraction(0), Fraction(0)) if rng.random() < 0.1 else near
    return _wheels([first, *points], rng)


def of_fourfold_symmetry(rng: random.Random) -> list[Wheel]:
    """Four wheels that a quarter turn permutes: gains of full turns are fourth powers, often one."""
    (x, y), direction, speed = circle_point(rng), circle_point(rng), rng.choice(SPEEDS)
    quarter = (Fraction(0), Fraction(1))
    place, wheels = (x, y), []
    for _ in range(4):
        wheels.append(_wheel(place, direction, speed))
        place, direction = rotated(place, quarter), rotated(direction, quarter)
    return wheels


def _wheels(points: Sequence[Pair], rng: random.Random) -> list[Wheel]:
    """Rims at random, or turned from the inward direction by one angle."""
    if rng.random() < 0.5:
        return [_wheel(point, circle_point(rng), rng.choice(SPEEDS)) for point in points]
    turn = circle_point(rng)
    wheels = []
    for point in points:
        length = max(abs(point[0]), abs(point[1]))
        squared = point[0] ** 2 + point[1] ** 2
        radius = Fraction(2) if squared == 4 else Fraction(1)
        inward = (-point[0] / radius, -point[1] / radius) if length else (Fraction(1), Fraction(0))
        wheels.append(_wheel(point, rotated(inward, turn), abs(rng.choice(SPEEDS))))
    return wheels


def _wheel(position: Pair, direction: Pair, speed: Fraction) -> Wheel:
    return Wheel(position, direction, speed, Fraction(1), Fraction(1, 2))


# ---- cells at the origin -------------------------------------------------------------------


def cones(wheels: Sequence[Wheel]) -> list[tuple[Pair, Pair, tuple[int, ...]]]:
    """(first ray, last ray, wheels by distance) of each cone at the origin, counterclockwise."""
    array = NearestArray(wheels)
    rays: list[Pair] = []
    for line in array.lines_near_the_point():
        (a, b) = line.slope
        for ray in ((-b, a), (b, -a)):
            if not any(cross(ray, other) == 0 and ray[0] * other[0] + ray[1] * other[1] > 0 for other in rays):
                rays.append(ray)
    rays.sort(key=_angle)
    found = []
    for start, end in zip(rays, [*rays[1:], *rays[:1]], strict=True):
        inside = (start[0] + end[0], start[1] + end[1]) if cross(start, end) else (-start[1], start[0])
        order = array.order((flint.arb(0), flint.arb(0)), (as_arb(inside[0]), as_arb(inside[1])))
        found.append((start, end, order))
    return found


def _angle(ray: Pair) -> tuple[int, Fraction]:
    """A key that sorts directions counterclockwise from the positive x axis."""
    x, y = ray
    half = 0 if y > 0 or (y == 0 and x > 0) else 1
    return half, -x / (abs(x) + abs(y)) if half == 0 else x / (abs(x) + abs(y))


def _twist(wheels: Sequence[Wheel], order: tuple[int, ...]) -> Twist:
    return NearestArray(wheels).motions(order)[0]


def _with_speed(wheels: Sequence[Wheel], index: int, speed: Fraction) -> list[Wheel]:
    return [wheel._replace(speed=speed) if k == index else wheel for k, wheel in enumerate(wheels)]


def _solved_for_speed(wheels: list[Wheel], index: int, value: Callable[[list[Wheel]], Fraction]) -> list[Wheel]:
    """The array with the speed of one wheel at which an affine function of it vanishes; as it was where none does."""
    at_zero = value(_with_speed(wheels, index, Fraction(0)))
    at_one = value(_with_speed(wheels, index, Fraction(1)))
    if at_zero == at_one:
        return wheels
    speed = at_zero / (at_zero - at_one)
    return _with_speed(wheels, index, speed) if speed else wheels


# ---- coincidences --------------------------------------------------------------------------


def velocity_along_a_ray(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """A speed such that the velocity of a cone lies exactly along one of its rays."""
    start, end, order = rng.choice(cones(wheels))
    ray = rng.choice((start, end))

    def off(changed: list[Wheel]) -> Fraction:
        return cross(ray, _twist(changed, order)[:2])

    return _solved_for_speed(wheels, rng.choice(order[:2]), off)


def opposed_velocities(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """A speed such that the velocities of two neighbouring cones are parallel, often opposed."""
    every = cones(wheels)
    k = rng.randrange(len(every))
    first, second = every[k - 1][2], every[k][2]
    alone = [index for index in second[:2] if index not in first[:2]]
    if not alone:
        return wheels

    def off(changed: list[Wheel]) -> Fraction:
        return cross(_twist(changed, first)[:2], _twist(changed, second)[:2])

    return _solved_for_speed(wheels, alone[0], off)


def no_turning(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """A speed such that the motion of a cone does not turn the body."""
    _, _, order = rng.choice(cones(wheels))
    return _solved_for_speed(wheels, order[1], lambda changed: _twist(changed, order).omega)


def rim_through_a_wheel(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """Two wheels whose rims lie along the line between them, which needs a rational length: opposite places."""
    k = rng.randrange(len(wheels))
    (x, y), direction, *rest = wheels[k]
    if not x and not y:
        return wheels
    if (-x, -y) in [wheel.position for wheel in wheels]:
        length = 1 if x * x + y * y == 1 else 2
        return [*wheels[:k], Wheel((x, y), (x / length, y / length), *rest), *wheels[k + 1 :]]
    opposite = Wheel((-x, -y), direction, rng.choice(SPEEDS), *rest[1:])
    return [*wheels, opposite]


def rim_through_the_point(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """A rim that points at the origin."""
    k = rng.randrange(len(wheels))
    x, y = wheels[k].position
    squared = x * x + y * y
    if squared not in (1, 4):
        return wheels
    length = rng.choice((-1, 1)) * (1 if squared == 1 else 2)
    return [*wheels[:k], wheels[k]._replace(direction=(x / length, y / length)), *wheels[k + 1 :]]


def parallel_rims(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """Two wheels with the same or opposite rim directions."""
    a, b = rng.sample(range(len(wheels)), 2)
    x, y = wheels[a].direction
    side = rng.choice((-1, 1))
    return [wheel._replace(direction=(side * x, side * y)) if k == b else wheel for k, wheel in enumerate(wheels)]


def tangential_rims(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """All rims tangential: some cells turn the body about the origin itself."""
    turned = []
    for wheel in wheels:
        x, y = wheel.position
        squared = x * x + y * y
        if squared not in (1, 4):
            return wheels
        length = 1 if squared == 1 else 2
        speed = length if rng.random() < 0.7 else rng.choice(SPEEDS)
        turned.append(wheel._replace(direction=(-y / length, x / length), speed=Fraction(speed)))
    return turned


def equal_frictions(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """The third row ties in the cells whose second wheel has equal frictions."""
    some = rng.random() < 0.5
    return [wheel._replace(side=wheel.roll) if not some or rng.random() < 0.5 else wheel for wheel in wheels]


def side_rows_third(wheels: list[Wheel], rng: random.Random) -> list[Wheel]:
    """More friction across the rims than along them, at all wheels or at some."""
    some = rng.random() < 0.5
    return [wheel._replace(side=Fraction(2)) if not some or rng.random() < 0.5 else wheel for wheel in wheels]


ARRAYS = (on_a_circle, turning, turning, one_nearest, of_fourfold_symmetry)
TIES: tuple[Tie, ...] = (
    velocity_along_a_ray,
    velocity_along_a_ray,
    velocity_along_a_ray,
    opposed_velocities,
    no_turning,
    rim_through_a_wheel,
    rim_through_the_point,
    parallel_rims,
    tangential_rims,
    equal_frictions,
    side_rows_third,
)


def tied_array(seed: int) -> tuple[list[Wheel], str]:
    """An array with one to three coincidences, and what they are.

    Most arrays turn about the origin in every cone, weakly: there coincidences decide; of the others a share is kept.
    """
    rng = random.Random(seed)
    while True:
        build = rng.choice(ARRAYS)
        wheels = build(rng)
        for _ in range(TRIES if build is turning else 1):
            tied, names = _tied(wheels, rng, first=(velocity_along_a_ray,) if build is turning else TIES)
            if len({wheel.position for wheel in tied}) < len(tied):
                continue
            wanted = _turns(tied) or (build is not turning and rng.random() < SHARE_OF_OTHERS)
            if wanted and (not _escapes(tied) or rng.random() < SHARE_OF_ESCAPES):
                return tied, ", ".join([build.__name__, *names])


def _tied(wheels: list[Wheel], rng: random.Random, first: Sequence[Tie]) -> tuple[list[Wheel], list[str]]:
    ties = [rng.choice(first), *(rng.choice(TIES) for _ in range(rng.choice((0, 0, 1, 2))))]
    for tie in ties:
        wheels = tie(wheels, rng)
    return wheels, [tie.__name__ for tie in ties]


def untied_array(seed: int) -> list[Wheel]:
    """An array of equally distant wheels without a coincidence made on purpose."""
    rng = random.Random(seed)
    while True:
        wheels = on_a_circle(rng)
        if len(wheels) > 2 and (not _escapes(wheels) or rng.random() < SHARE_OF_ESCAPES):
            return wheels


def _turns(wheels: Sequence[Wheel]) -> bool:
    """Whether no velocity of a cone at the origin turns against a common sense, and one turns."""
    array = NearestArray(wheels)
    products = [
        cross(ray, (vx, vy))
        for start, end, order in cones(wheels)
        for vx, vy, _ in array.motions(order)
        for ray in (start, end)
    ]
    return any(products) and (min(products) >= 0 or max(products) <= 0)


def _escapes(wheels: Sequence[Wheel]) -> bool:
    """Whether some velocity points into the inside of its own cone."""
    array = NearestArray(wheels)
    for start, end, order in cones(wheels):
        for vx, vy, _ in array.motions(order):
            v = (vx, vy)
            beyond_end = cross(v, end) > 0 if cross(start, end) else True
            if cross(start, v) > 0 and beyond_end:
                return True
    return False


# ---- Arrays of rule ``box`` with a checked point at which exact coincidences meet: a corner of their own cells.
#
# There twists tie, slopes of D vanish, loads are at the border of zero, or frictions balance. The corners come from
# the workbench; the verdicts about them are compared with paths that do not use the cells.

FRICTIONS: list[Pair] = [
    (Fraction(1), Fraction(1, 2)),
    (Fraction(1), Fraction(1, 5)),
    (Fraction(1), Fraction(1, 10)),
    (Fraction(1), Fraction(1)),
    (Fraction(1, 2), Fraction(1)),
]
TURNS: list[Pair] = [(Fraction(1), Fraction(0)), (Fraction(3, 5), Fraction(4, 5)), (Fraction(4, 5), Fraction(3, 5))]
AXES: list[Pair] = [(Fraction(a), Fraction(b)) for a, b in ((1, 0), (0, 1), (-1, 0), (0, -1))]


def box_wheels(rng: random.Random) -> list[Wheel]:
    """Four wheels: opposite pairs on a circle with rims turned alike, or the corners of a square with any rims."""
    roll, side = rng.choice(FRICTIONS)
    on_circle = rng.random() < 0.7
    if on_circle:
        half = [circle_point(rng), circle_point(rng)]
        points = [*half, *((-x, -y) for x, y in half)]
    else:
        points = [(Fraction(a), Fraction(b)) for a in (1, -1) for b in (1, -1)]
    turn = rng.choice([TURNS[0], *TURNS, circle_point(rng)])
    wheels = []
    for x, y in points:
        direction = rotated((-x, -y), turn) if on_circle else rng.choice([circle_point(rng), *AXES])
        speed = rng.choice([Fraction(1), Fraction(1), Fraction(1), rng.choice(SPEEDS)])
        wheels.append(Wheel((x, y), direction, speed, roll, side))
    return wheels


def box_scene(arrays: Arrays, wheels: list[Wheel], at: Pair, radius: Fraction) -> Scene:
    """The scene of rule ``box``, seen from the checked point."""
    data = [WheelData(w.position, w.direction, w.speed, (w.roll, w.side)) for w in wheels]
    scene = arrays.scene(data, radius=radius, at=at)
    return replace(scene, contact=Contact("box")).recentred()


def tied_box(arrays: Arrays, seed: int) -> tuple[list[Wheel], Pair, Partition]:
    """Wheels, a checked point at a rational corner of their cells (or the origin), and the cells about it."""
    rng = random.Random(seed)
    while True:
        wheels = box_wheels(rng)
        size = rng.choice((Fraction(1, 4), Fraction(3, 5)))
        if len({wheel.position for wheel in wheels}) < len(wheels):
            continue
        try:
            whole = build_box_partition(box_scene(arrays, wheels, (Fraction(0), Fraction(0)), size))
            at = rng.choice(_rational_corners(whole, size))
            partition = build_box_partition(box_scene(arrays, wheels, at, size / 16))
        except RefusalError:  # the square leaves the support polygon
            continue
        return wheels, at, partition


def _rational_corners(partition: Partition, size: Fraction) -> list[Pair]:
    found: list[Pair] = [(Fraction(0), Fraction(0))]
    for point in partition.complex.points:
        values = [None if isinstance(x, Lazy) else x.as_rational() for x in point]
        if None not in values:
            x, y = (Fraction(str(value)) for value in values)
            if max(abs(x), abs(y)) < size:
                found.append((x, y))
    return found


# ---- Arrays at whose equilibrium a velocity lies exactly along a ray: once certified as asymptotically stable.


def scene_of(arrays: Arrays, wheels: list[Wheel]) -> Scene:
    data = [WheelData(w.position, w.direction, w.speed, (w.roll, w.side)) for w in wheels]
    return arrays.scene(data, radius=Fraction(1, 10))


def wheel(position: tuple[str, str], heading: tuple[str, str], speed: str) -> Wheel:
    (x, y), (a, b) = position, heading
    numbers = [Fraction(text) for text in (x, y, a, b, speed)]
    return Wheel((numbers[0], numbers[1]), (numbers[2], numbers[3]), numbers[4], Fraction(1), Fraction(1, 2))


LEAVES_LIKE_A_ROOT = [
    wheel(("8/17", "-15/17"), ("0", "1"), "133325/642872"),
    wheel(("12/13", "5/13"), ("15/17", "-8/17"), "-7"),
    wheel(("-9/41", "40/41"), ("21/29", "-20/29"), "-5/4"),
]
CENTRE = [
    wheel(("0", "1"), ("1", "0"), "1"),
    wheel(("2", "1"), ("0", "1"), "-1"),
    wheel(("2", "-1"), ("0", "1"), "-4"),
]
LEAVES_FROM_1E_9 = [
    wheel(("0", "-1"), ("-4/5", "-3/5"), "-5/2"),
    wheel(("1", "0"), ("-4/5", "-3/5"), "-1"),
    wheel(("-1", "0"), ("4/5", "-3/5"), "1/25"),
]
