"""Rule ``nearest`` over a box of parameters: a distance that every body reaches and keeps to.

``(c . c)' = 2 c . v`` with exact kinematics too, since ``c . J c = 0``.  Let ``c . v <= -kappa |c|`` hold outside a
disc of radius r on every outer cell, for all velocities of its pair over the box.  Then, for every array of the box,
every Filippov solution that starts at ``|c0| <= R`` (the disc in the checked square) is in the disc of radius r after
the time ``(R - r)/kappa`` and stays there: its velocity is a mean of those of pairs whose cells hold the point.
Inside the disc nothing is said: several zeros, slides and rotations may be there.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from flint import arb, ctx, fmpq

from nonsmooth.proofs.robust.outer_cells import OuterCell, lower_end, outer_cells, upper_end
from nonsmooth.proofs.robust.pair_motion import MotionBox, SecondRow, motion_box
from nonsmooth.proofs.robust.ultimate_bound import BoundedCell, Point, squared_radius
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene, Wheel
from nonsmooth.symbolic.tolerances import Tolerance

PRECISION = 64  # bits of the balls
RATES = 32  # values of kappa that are tried
GROWTH = fmpq(6, 5)  # of the least radius: what a faster rate may cost


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


@dataclass(frozen=True)
class MovingCell:
    """An outer cell with one motion that its pair may have; None where the motion is not bounded."""

    cell: OuterCell
    motion: MotionBox | None

    def bounded(self) -> BoundedCell:
        """With the vector w whose product with c bounds that of every velocity in this quadrant."""
        bound: Point | None = None
        if self.motion is not None:
            bound = _extreme(self.motion.vx, self.cell.signs[0]), _extreme(self.motion.vy, self.cell.signs[1])
        return BoundedCell(self.cell.polygon, bound)


def _extreme(entry: arb, side: int) -> fmpq:
    return upper_end(entry) if side > 0 else lower_end(entry)


def why_not_nearest(scene: Scene) -> str:
    """Why the rule's motion is not bounded here over boxes of parameters; empty where it is."""
    if any(wheel.axis is not None for wheel in scene.wheels):
        return "a friction axis is not the rim of its wheel"
    if any(not wheel.friction.roll or not wheel.friction.side for wheel in scene.wheels):
        return "a wheel has a row without friction"
    if len(scene.wheels) < 2:
        return "there are fewer than two wheels"
    return ""


def is_bounded(scene: Scene, box: Tolerance) -> bool:
    """Whether for every array of the box bodies end nearer to the point of a centred scene than they may start.

    At the rate zero: the distance falls on a compact set, so that it falls at some rate there.
    """
    radius, moving = _in_square(scene, box)
    return squared_radius((cell.bounded() for cell in moving), fmpq(0)) < radius * radius


def ultimate_bound(scene: Scene, box: Tolerance) -> RobustUltimateBound | None:
    """A bound of a centred scene that lies inside its square, with the fastest rate that costs little; else None."""
    radius, moving = _in_square(scene, box)
    fastest = max(upper_end(abs(wheel.speed.ball())) for wheel in scene.wheels)
    cells = [cell.bounded() for cell in moving]
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


def moving_cells(scene: Scene, box: Tolerance, radius: fmpq) -> list[MovingCell]:
    """The outer cells of a square about a centred scene's point, each with a motion that its pair may have."""
    with ctx.workprec(PRECISION):
        return list(_moving_cells(scene, box, radius))


def bounded_cells(scene: Scene, box: Tolerance, radius: fmpq) -> list[BoundedCell]:
    """The outer cells of a square about a centred scene's point, with bounds of the velocities of every array."""
    with ctx.workprec(PRECISION):
        return [moving.bounded() for moving in moving_cells(scene, box, radius)]


def _in_square(scene: Scene, box: Tolerance) -> tuple[fmpq, list[MovingCell]]:
    """Half-width of the square, and all cells in it."""
    with ctx.workprec(PRECISION):
        radius = inner_radius(scene)
        return radius, list(_moving_cells(scene, box, radius))


def _moving_cells(scene: Scene, box: Tolerance, radius: fmpq) -> Iterator[MovingCell]:
    step = box.position.ball()
    motions: dict[tuple[int, int], list[MotionBox | None]] = {}
    for cell in outer_cells(scene.wheels, radius, step):
        pair = cell.first, cell.second
        if pair not in motions:
            first, second = (scene.wheels[k] for k in pair)
            motions[pair] = [motion_box(first, second, row, box) for row in _rows(second, box)]
        for motion in motions[pair]:
            yield MovingCell(cell, motion)


def _rows(second: Wheel, box: Tolerance) -> list[SecondRow]:
    """The rows of the second wheel that may have the larger friction."""
    along, across = second.friction.roll, second.friction.side
    found = []
    if _most(along, box.mu_roll) >= _least(across, box.mu_side):
        found.append(SecondRow.ALONG)
    if _most(across, box.mu_side) >= _least(along, box.mu_roll):
        found.append(SecondRow.ACROSS)
    return found


def _most(value: Number, share: Number) -> Number:
    return value * (1 + share)


def _least(value: Number, share: Number) -> Number:
    return value * (1 - share)


def _turning(moving: list[MovingCell], squared: fmpq) -> fmpq | None:
    """A bound of the rotation rate on the cells that reach out of the disc."""
    rates = [fmpq(0)]
    for part in moving:
        if max(x * x + y * y for x, y in part.cell.polygon.vertices) <= squared:
            continue
        if part.motion is None:
            return None
        rates.append(upper_end(abs(part.motion.omega)))
    return max(rates)
