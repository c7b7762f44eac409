"""How every body of a disc about the checked point is driven: along one direction, and how fast it turns at most.

Let ``m . c' >= delta > 0`` for one direction m, every place of the disc of radius a and every velocity that is possible
there.  Then no body stays in the disc for longer than ``2 a/delta``: none comes to rest there, and none ends there,
for whenever it came back it would be driven out again.

Bounds are those of cells with one motion each where the rule has cells, else of forces that balance a pull
(:mod:`nonsmooth.proofs.boxes.balanced_forces`), on squares that cover the disc.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, clipped_by, square
from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.proofs.robust.nearest import PRECISION, moving_cells, why_not_nearest
from nonsmooth.proofs.robust.touching_rings import no_tolerance
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import enclosure, rational_above, rational_below
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane_arrays import Floats, even_angles, unit_vectors

Corners: TypeAlias = list[tuple[arb, arb]]
Motion: TypeAlias = tuple[arb, arb, arb]  # (v_x, v_y, omega)

DIRECTIONS = 64  # that are tried
PARTS = 8  # of each side of the square about the disc


def driven_out(scene: Scene, accuracy: Fraction) -> Fraction | None:
    """The time after which every body has left the disc of that radius about a centred scene's point; None if unknown.

    Args:
        scene: centred, without an outline; with loads that are known where its rule needs them.
        accuracy: the radius.
    """
    speed = _slowest_of_cells(scene, accuracy) if scene.contact.rule == "nearest" else _slowest(scene, accuracy)
    return None if speed is None or speed <= 0 else 2 * accuracy / speed


def largest_spin(scene: Scene, radius: Fraction) -> Fraction | None:
    """A bound of ``|omega|`` over the disc of that radius, of the same scenes; None where none is known."""
    if scene.contact.rule == "nearest":
        with ctx.workprec(PRECISION):
            motions = _cell_motions(scene, radius)
            return None if motions is None else max(rational_above(abs(motion[2])) for _, motion in motions)
    forces = BalancedForces.of(scene)
    if forces is None:
        return None
    corners = _squares(float(radius))
    zero, one = (Intervals.of(np.full(corners.shape[:2], entry)) for entry in (0.0, 1.0))
    most = max(float(forces.largest_powers(corners, (zero, zero, turn)).max()) for turn in (one, -one))
    return Fraction(most) / Fraction(forces.length) if math.isfinite(most) else None


# ---- one side of a line through the point --------------------------------------------------------
#
# Of an array that a half turn does not change bodies on the two sides of the point go opposite ways, and of one that
# nearly is so the point is driven to one side.  So the same is asked of a half of the disc.


def is_driven_out_on_one_side(scene: Scene, accuracy: Fraction) -> bool:
    """Whether bodies on one side of some line through a centred scene's point are driven out of the disc.

    Let ``m . c' > 0`` at all places of a square about the disc with ``m . c >= 0``, for every motion of the cells that
    have places with ``m . c > 0`` there.  A body that starts in the disc with ``m . c > 0`` then moves away from the
    line, at a speed that is bounded from below, as the cells are compact; so it leaves the disc.  Such starts are as
    near the point as one likes.

    Args:
        scene: centred, without an outline, under a rule with cells.
        accuracy: the radius of the disc.
    """
    half = scene.field.rational(accuracy * (1 + Fraction(1, 2**20)))
    if half > scene.check.radius:
        return False
    try:
        cells = build_partition(scene).cells
    except RefusalError:
        return False
    about = square((scene.field.zero, scene.field.zero), half)
    near = [(clipped_by(cell.polygon, about.sides), cell.twists) for cell in cells]
    clipped = [(polygon, twists) for polygon, twists in near if polygon is not None]
    return any(_drives(clipped, direction) for direction in _directions(clipped))


def _directions(cells: Sequence[tuple[Polygon, Sequence[Twist]]]) -> Iterator[Point]:
    """Directions to try: the normals of all sides, and the velocities at the point."""
    for polygon, twists in cells:
        yield from (side.normal for side in polygon.sides)
        if all(sign(side.offset) >= 0 for side in polygon.sides):
            yield from (twist.velocity for twist in twists if any(twist.velocity))


def _drives(cells: Sequence[tuple[Polygon, Sequence[Twist]]], direction: Point) -> bool:
    """Whether every motion moves along a direction at all places on its side: affine in c, so corners decide."""
    a, b = direction
    beyond = HalfPlane((-a, -b), a - a)
    for polygon, twists in cells:
        part = polygon.clipped(beyond)
        for x, y in () if part is None else part.vertices:
            for twist in twists:
                vx, vy = twist.velocity
                if sign(a * (vx - twist.omega * y) + b * (vy + twist.omega * x)) <= 0:
                    return False
    return True


# ---- rule nearest --------------------------------------------------------------------------------


def _cell_motions(scene: Scene, radius: Fraction) -> list[tuple[Corners, Motion]] | None:
    """The corners of all cells of a square about the point, with each motion that is possible on the cell."""
    if why_not_nearest(scene):
        return _partition_motions(scene, radius)
    motions = []
    for moving in moving_cells(scene, no_tolerance(scene), fmpq(radius.numerator, radius.denominator)):
        if moving.motion is None:
            return None
        corners = [(arb(x), arb(y)) for x, y in moving.cell.polygon.vertices]
        motions.append((corners, (moving.motion.vx, moving.motion.vy, moving.motion.omega)))
    return motions


def _partition_motions(scene: Scene, radius: Fraction) -> list[tuple[Corners, Motion]] | None:
    """The same by the exact cells, where wheels have friction axes of their own; None where rounding decides them."""
    before = scene.field.rounded_signs
    try:
        partition = build_partition(scene.checked_at(scene.check.equilibrium, scene.field.rational(radius)))
    except RefusalError:
        return None
    if scene.field.rounded_signs != before:
        return None
    return [
        ([(enclosure(x), enclosure(y)) for x, y in cell.polygon.vertices], (vx.ball(), vy.ball(), omega.ball()))
        for cell in partition.cells
        for vx, vy, omega in cell.twists
    ]


def _slowest_of_cells(scene: Scene, accuracy: Fraction) -> Fraction | None:
    """Delta: ``m . (v + omega J c)`` is affine on each cell."""
    with ctx.workprec(PRECISION):
        motions = _cell_motions(scene, accuracy) or []
        velocities = [(vx - omega * y, vy + omega * x) for corners, (vx, vy, omega) in motions for x, y in corners]
        if not velocities:
            return None
        direction = _direction(np.array([(float(x), float(y)) for x, y in velocities]))
        if direction is None:
            return None
        a, b = (arb(entry) for entry in direction)
        return min(rational_below(a * x + b * y) for x, y in velocities)


def _direction(velocities: Floats) -> tuple[float, float] | None:
    """A rational direction no longer than one along which all velocities go, about the best; None where none is."""
    angles = even_angles(DIRECTIONS)
    rays = unit_vectors(angles) * (1 - 2.0**-40)
    least = (velocities @ rays.T).min(axis=0)
    best = int(least.argmax())
    return (float(rays[best, 0]), float(rays[best, 1])) if least[best] > 0 else None


# ---- rules with loads ----------------------------------------------------------------------------


def _slowest(scene: Scene, accuracy: Fraction) -> Fraction | None:
    """Delta by forces that balance a pull back, ``G . xi = -lambda m . c'``."""
    forces = BalancedForces.of(scene)
    if forces is None:
        return None
    corners = _squares(float(accuracy))
    direction = _direction(forces.velocities(corners.reshape(-1, 2)))
    if direction is None:
        return None
    a, b = (Intervals.of(np.full(corners.shape[:2], -entry)) for entry in direction)
    x, y = (Intervals.of(corners[:, :, k]) for k in range(2))
    most = float(forces.largest_powers(corners, forces.covector(a, b, b * x - a * y)).max())
    return Fraction(-most) if math.isfinite(most) else None


def _squares(half: float) -> Floats:
    """Squares that cover the square about a disc, (pieces, 4, 2); neighbours share their corners."""
    ends = np.linspace(-half, half, PARTS + 1) * (1 + 2.0**-20)
    low, high = ends[:-1], ends[1:]
    x0, y0 = (grid.ravel() for grid in np.meshgrid(low, low))
    x1, y1 = (grid.ravel() for grid in np.meshgrid(high, high))
    return np.stack(
        [np.stack(pair, axis=1) for pair in ((x0, y0), (x1, y0), (x1, y1), (x0, y1))],
        axis=1,
    )
