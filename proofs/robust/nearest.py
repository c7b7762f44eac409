"""Rule ``nearest`` over a box of parameters: a distance that every body reaches and keeps to.

*Cells.*  Wheel i is nearer to c than wheel k for some array of the box only where ::

    2 c . (p_k - p_i) - 4 t |c|_1  <=  |p_k|^2 - |p_i|^2 + 2 t (|p_k|_1 + |p_i|_1) + 2 t^2,

with t the tolerance of every coordinate.  In a quadrant ``|c|_1`` is linear, so that this is a half-plane there.  Its
numbers are rounded outward to rationals, and the polygons are exact.

*Motions.*  Both rows of the nearest wheel i hold, so ``v(p_i) = u_i d_i``, and one row of the next one j, with the
normal m (its rim d_j, or J d_j across it) ::

    omega = (u_m - u_i d_i . m) / (m . J (p_j - p_i)),      v = u_i d_i - omega J p_i,

where ``u_m`` is u_j along the rim and zero across it; over the box they are enclosed by the mean value theorem.

*Ends.*  ``(c . c)' = 2 c . v`` with exact kinematics too, since ``c . J c = 0``.  Let ``c . v <= -kappa |c|`` hold
outside a disc of radius r on every outer cell, for all velocities of its pair over the box.  Then, for every array of
the box, every Filippov solution that starts at ``|c0| <= R`` (the disc in the checked square) is in the disc of radius
r after the time ``(R - r)/kappa`` and stays there: its velocity is a mean of those of pairs whose cells hold the point.
Inside the disc nothing is said: several zeros, slides and rotations may be there.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import partial
from typing import NamedTuple

from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.polygon import HalfPlane, Polygon, convex_polygon
from nonsmooth.proofs.boxes.enclosures import UNIT, Jet, parameters, turned_by
from nonsmooth.proofs.robust.box import half_widths
from nonsmooth.proofs.robust.rings import BoundedCell, root_above, squared_radius
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance, Wheel
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.plane import dot

PRECISION = 64  # bits of the balls
RATES = 32  # values of kappa that are tried
GROWTH = fmpq(6, 5)  # of the least radius: what a faster rate may cost
QUADRANTS = ((1, 1), (-1, 1), (-1, -1), (1, -1))

# Of what a certificate states: its checker encloses with arithmetic of its own, and would refuse the last digits.
WIDER = (1 + Fraction(1, 2**8), 1 + Fraction(1, 2**6), 1 + Fraction(1, 2**4), Fraction(5, 4))  # one after the other
PARTS = 2**24  # of the half-width of the square, to which bounds are rounded


def why_not_nearest(scene: Scene) -> str:
    """Why the rule's motion is not bounded here over boxes of parameters; empty where it is."""
    if any(wheel.axis is not None for wheel in scene.wheels):
        return "a friction axis is not the rim of its wheel"
    if any(not wheel.friction.roll or not wheel.friction.side for wheel in scene.wheels):
        return "a wheel has a row without friction"
    if len(scene.wheels) < 2:
        return "there are fewer than two wheels"
    return ""


# ---- where bodies end --------------------------------------------------------------------------


@dataclass(frozen=True)
class RobustUltimateBound:
    """What holds for every array of the box.

    Attributes:
        squared: of the radius r.
        kappa: rate at which the distance falls outside (length/time).
        turning: bound of ``|omega|`` outside the disc (1/time); None where there is none.
    """

    squared: fmpq
    kappa: fmpq
    turning: fmpq | None


def is_bounded(scene: Scene, box: Tolerance) -> bool:
    """Whether for every array of the box bodies end nearer to the point of a centred scene than they may start.

    At the rate zero: the distance falls on a compact set, so that it falls at some rate there.
    """
    radius = inner_radius(scene)
    return squared_radius(bounded_cells(scene, box, radius), fmpq(0)) < radius * radius


def ultimate_bound(scene: Scene, box: Tolerance) -> RobustUltimateBound | None:
    """A bound of a centred scene that lies inside its square, with the fastest rate that costs little; else None."""
    with ctx.workprec(PRECISION):
        radius = inner_radius(scene)
        moving = moving_cells(scene, box, radius)
        fastest = max(upper_end(abs(wheel.speed.ball())) for wheel in scene.wheels)
        cells = [cell.bounded for cell in moving]
        least = squared_radius(cells, fmpq(0))
        if least >= radius * radius or not fastest:
            return None
        for k in range(RATES, 0, -1):
            kappa = fastest * fmpq(2 * k, RATES)
            squared = squared_radius(cells, kappa)
            if squared <= least * GROWTH * GROWTH and squared < radius * radius:
                return RobustUltimateBound(squared, kappa, _turning(moving, squared))
    return None


def inner_radius(scene: Scene) -> fmpq:
    """The half-width of the checked square, or a little less where it is not rational."""
    exact = scene.check.radius.as_rational()
    return lower_end(scene.check.radius.ball()) if exact is None else exact


def _turning(moving: Sequence[MovingCell], squared: fmpq) -> fmpq | None:
    """A bound of the rotation rate on the cells that reach out of the disc."""
    outside = [part for part in moving if max(x * x + y * y for x, y in part.cell.polygon.vertices) > squared]
    if any(part.motion is None for part in outside):
        return None
    return max((upper_end(abs(part.motion.omega)) for part in outside if part.motion is not None), default=fmpq(0))


@dataclass(frozen=True)
class CertifiedBound:
    """A claim for the checker about all arrays within tolerances.

    Attributes:
        radius: of the disc in which every body ends (length).
        start: radius of the disc of starts (length).
        rate: at which the distance falls between the two (length/time).
    """

    radius: Fraction
    start: Fraction
    rate: Fraction


def certified_bounds(scene: Scene) -> list[CertifiedBound]:
    """Claims from the strongest to the weakest; empty where none is proved, or the scene states no tolerances."""
    box = scene.tolerances
    if box is None or scene.contact.rule != "nearest" or scene.body is not None:
        return []
    centred = scene.recentred()
    bound = None if why_not_nearest(centred) else ultimate_bound(centred, box)
    if bound is None:
        return []
    start = as_fraction(inner_radius(centred))
    unit, least, rate = start / PARTS, root_above(as_fraction(bound.squared)), as_fraction(bound.kappa)
    wider = [(unit * (1 + least * factor // unit), rate / factor) for factor in WIDER]
    return [CertifiedBound(radius, start, slower) for radius, slower in wider if radius < start]


# ---- cells with their motions ------------------------------------------------------------------


class MotionBox(NamedTuple):
    """Enclosures of ``(v_x, v_y, omega)`` over the box."""

    vx: arb
    vy: arb
    omega: arb


@dataclass(frozen=True)
class OuterCell:
    """A part in one quadrant of what may be the cell of a pair.

    Attributes:
        first: place of the nearest wheel in the list.
        second: place of the next one.
        signs: of the coordinates in the quadrant.
        polygon: over the rationals.
    """

    first: int
    second: int
    signs: tuple[int, int]
    polygon: Polygon


@dataclass(frozen=True)
class MovingCell:
    """An outer cell with one motion that its pair may have; None where the motion is not bounded."""

    cell: OuterCell
    motion: MotionBox | None

    @property
    def bounded(self) -> BoundedCell:
        """With the vector w whose product with c bounds that of every velocity in this quadrant."""
        if self.motion is None:
            return BoundedCell(self.cell.polygon, None)
        x, y = (
            upper_end(entry) if side > 0 else lower_end(entry)
            for entry, side in zip(self.motion[:2], self.cell.signs, strict=True)
        )
        return BoundedCell(self.cell.polygon, (x, y))


def moving_cells(scene: Scene, box: Tolerance, radius: fmpq) -> list[MovingCell]:
    """The outer cells of a square about a centred scene's point, each with a motion that its pair may have."""
    with ctx.workprec(PRECISION):
        motions: dict[tuple[int, int], list[MotionBox | None]] = {}
        cells = []
        for cell in outer_cells(scene.wheels, radius, box.position.ball()):
            pair = cell.first, cell.second
            if pair not in motions:
                first, second = (scene.wheels[k] for k in pair)
                motions[pair] = [_motion(first, second, box, along=along) for along in _second_rows(second, box)]
            cells += [MovingCell(cell, motion) for motion in motions[pair]]
        return cells


def bounded_cells(scene: Scene, box: Tolerance, radius: fmpq) -> list[BoundedCell]:
    """The outer cells of a square about a centred scene's point, with bounds of the velocities of every array."""
    with ctx.workprec(PRECISION):
        return [moving.bounded for moving in moving_cells(scene, box, radius)]


def _second_rows(wheel: Wheel, box: Tolerance) -> list[bool]:
    """Whether the row of the second wheel that holds is along its rim: which may have the larger friction."""
    roll, side = wheel.friction.roll, wheel.friction.side
    along = roll * (1 + box.mu_roll) >= side * (1 - box.mu_side)
    across = side * (1 + box.mu_side) >= roll * (1 - box.mu_roll)
    return [True] * along + [False] * across


def _motion(first: Wheel, second: Wheel, box: Tolerance, *, along: bool) -> MotionBox | None:
    """Enclosures of the twist of a pair; None where its rows may be dependent somewhere in the box."""
    sizes = [*half_widths(first, box)[:4], *half_widths(second, box)[:4]]
    if all(size.is_zero() for size in sizes):  # one array: its twist has no slopes
        exact = _twist(first, second, [Jet(arb(0), ())] * len(sizes), along=along)
        return None if exact is None else MotionBox(*(entry.value for entry in exact))
    middle = _twist(first, second, parameters([arb(0)] * len(sizes)), along=along)
    whole = _twist(first, second, parameters([size * UNIT for size in sizes]), along=along)
    if middle is None or whole is None:
        return None
    return MotionBox(*(b.over(sizes, a.value) for a, b in zip(middle, whole, strict=True)))


def _twist(first: Wheel, second: Wheel, shifts: Sequence[Jet], *, along: bool) -> tuple[Jet, Jet, Jet] | None:
    """``(v_x, v_y, omega)`` by the shifts of both wheels in x, y, angle and speed; None where it may not exist."""
    (u, (a, b), (x, y)), (speed, rim, (far_x, far_y)) = _shifted(first, shifts[:4]), _shifted(second, shifts[4:])
    m, n = rim if along else (-rim[1], rim[0])
    lever = n * (far_x - x) - m * (far_y - y)
    if lever.value.contains(0):
        return None
    driven = u * (a * m + b * n)
    omega = (speed - driven if along else -driven) / lever
    return u * a + omega * y, u * b - omega * x, omega


def _shifted(wheel: Wheel, shifts: Sequence[Jet]) -> tuple[Jet, tuple[Jet, Jet], tuple[Jet, Jet]]:
    """Speed, rim direction and position of a wheel."""
    x, y, angle, speed = shifts
    (a, b), (p, q) = ([entry.ball() for entry in pair] for pair in (wheel.unit_direction, wheel.position))
    return speed + wheel.speed.ball(), turned_by(a, b, angle), (x + p, y + q)


def outer_cells(wheels: Sequence[Wheel], radius: fmpq, step: arb) -> Iterator[OuterCell]:
    """All pairs that may carry somewhere in the square of half-width ``radius`` about the origin.

    Args:
        wheels: of a centred scene.
        radius: half-width of the square.
        step: tolerance of every coordinate of every wheel.
    """
    near = _among_the_nearest(wheels, radius, step)
    places = {k: tuple(map(float, wheels[k].position)) for k in near}

    def gap(i: int, k: int) -> float:
        return math.dist(places[i], places[k])

    others = {i: sorted(set(near) - {i}, key=partial(gap, i)) for i in near}

    def kept(polygon: Polygon | None, i: int, further: Iterable[int], signs: tuple[int, int]) -> Polygon | None:
        """Where wheel i may be nearer than further ones, which are sorted by their distance from it.

        What is farther from it than twice the polygon cuts nothing off; if rounding hides that, the cell is too large.
        """
        for k in further:
            if polygon is None:
                break
            reach = max(math.dist(places[i], (float(x), float(y))) for x, y in polygon.vertices)
            if gap(i, k) > 2 * reach:
                break
            polygon = polygon.clipped(_nearer(wheels[i], wheels[k], step, signs))
        return polygon

    for signs in QUADRANTS:
        for i in near:
            cell = kept(_quadrant(radius, signs), i, others[i], signs)
            for j in near if cell is not None else ():
                pair = kept(cell, j, (k for k in others[j] if k != i), signs) if j != i else None
                if pair is not None:
                    yield OuterCell(i, j, signs, pair)


def _quadrant(radius: fmpq, signs: tuple[int, int]) -> Polygon:
    """The part of the square."""
    (left, right), (low, high) = (sorted((fmpq(0), side * radius)) for side in signs)
    return convex_polygon([(left, low), (right, low), (right, high), (left, high)])


def _nearer(near: Wheel, far: Wheel, step: arb, signs: tuple[int, int]) -> HalfPlane:
    """Where one wheel may be nearer than another."""
    near_place, far_place = ([entry.ball() for entry in wheel.position] for wheel in (near, far))
    normal = []
    for a, b, side in zip(near_place, far_place, signs, strict=True):
        entry = 2 * (b - a) - 4 * side * step
        normal.append(lower_end(entry) if side > 0 else upper_end(entry))
    (ax, ay), (bx, by) = near_place, far_place
    moved = 2 * step * (abs(ax) + abs(ay) + abs(bx) + abs(by)) + 2 * step * step
    return HalfPlane((normal[0], normal[1]), upper_end(bx * bx + by * by - ax * ax - ay * ay + moved))


def _among_the_nearest(wheels: Sequence[Wheel], radius: fmpq, step: arb) -> list[int]:
    """Places of the wheels that may be one of the two nearest somewhere in the square."""
    edge, reaches = arb(radius), []
    for wheel in wheels:
        sizes = [abs(entry.ball()) for entry in wheel.position]
        gaps = [max(size - edge - step, arb(0), key=float) for size in sizes]
        most = sum(((size + edge + step) ** 2 for size in sizes), arb(0))
        reaches.append((dot(gaps, gaps), most))
    nearest = sorted((most for _, most in reaches), key=float)[:2]
    return [k for k, (least, _) in enumerate(reaches) if not all(least > most for most in nearest)]


def lower_end(ball: arb) -> fmpq:
    """Of a ball, exactly."""
    exact: fmpq = ball.lower().fmpq()
    return exact


def upper_end(ball: arb) -> fmpq:
    """Of a ball, exactly."""
    return -lower_end(-ball)
