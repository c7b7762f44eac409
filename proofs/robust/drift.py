"""Whether every body is driven out of a disc about the checked point, whatever is inside.

Let ``m . c' >= delta > 0`` for one direction m, every place of the disc of radius a and every velocity that is possible
there.  Then no body stays in the disc for longer than ``2 a/delta``: none comes to rest there, and none ends there,
for whenever it came back it would be driven out again.
"""

from __future__ import annotations

import math
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import arb, ctx, fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.robust.balanced_forces import BalancedForces
from nonsmooth.proofs.robust.intervals import Intervals
from nonsmooth.proofs.robust.nearest import PRECISION, moving_cells, why_not_nearest
from nonsmooth.proofs.robust.touching_rings import no_tolerance
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.scene import Scene

Floats: TypeAlias = NDArray[np.float64]

DIRECTIONS = 64  # that are tried
PARTS = 8  # of each side of the square about the disc
SHARES = (0.25, 0.6, 0.1)  # of the friction of all wheels, by which bodies are pulled back


def driven_out(scene: Scene, accuracy: Fraction) -> Fraction | None:
    """The time after which every body has left the disc of that radius about a centred scene's point; None if unknown.

    Args:
        scene: centred; with loads that are known where its rule needs them.
        accuracy: the radius.
    """
    speed = _of_cells(scene, accuracy) if scene.contact.rule == "nearest" else _of_forces(scene, accuracy)
    return None if speed is None or speed <= 0 else 2 * accuracy / speed


def _of_cells(scene: Scene, accuracy: Fraction) -> Fraction | None:
    """Delta under rule ``nearest``: ``m . (v + omega J c)`` is affine on each cell."""
    if why_not_nearest(scene):
        return None
    cells = moving_cells(scene, no_tolerance(scene), fmpq(accuracy.numerator, accuracy.denominator))
    motions = [(cell.cell.polygon.vertices, cell.motion) for cell in cells]
    if any(motion is None for _, motion in motions):
        return None
    velocities = np.array(
        [
            (float(m.vx) - float(m.omega) * float(y), float(m.vy) + float(m.omega) * float(x))
            for vertices, m in motions
            if m is not None
            for x, y in vertices
        ]
    )
    direction = _direction(velocities)
    if direction is None:
        return None
    a, b = (arb(entry) for entry in direction)
    with ctx.workprec(PRECISION):
        return min(
            rational_below(a * (m.vx - m.omega * arb(y)) + b * (m.vy + m.omega * arb(x)))
            for vertices, m in motions
            if m is not None
            for x, y in vertices
        )


def _direction(velocities: Floats) -> tuple[float, float] | None:
    """A rational direction no longer than one along which all velocities go, about the best; None where none is."""
    angles = 2 * math.pi * np.arange(DIRECTIONS) / DIRECTIONS
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=1) * (1 - 2.0**-40)
    least = (velocities @ rays.T).min(axis=0)
    best = int(least.argmax())
    return (float(rays[best, 0]), float(rays[best, 1])) if least[best] > 0 else None


def _of_forces(scene: Scene, accuracy: Fraction) -> Fraction | None:
    """Delta by forces that balance a pull back, ``G . xi = -lambda m . c'``, on squares that cover the disc."""
    try:
        forces = BalancedForces(scene)
    except ArithmeticError:
        return None
    corners = _squares(float(accuracy))
    places = corners.reshape(-1, 2)
    twists = forces.minimizers(places, np.zeros((len(places), 3)))
    omega = twists[:, 2:] / forces.length
    turned = np.stack([-places[:, 1], places[:, 0]], axis=1)
    direction = _direction(twists[:, :2] + omega * turned)
    if direction is None:
        return None
    free = forces.minimizers(corners.mean(axis=1), np.zeros((len(corners), 3)))
    best = np.full(len(corners), -np.inf)
    total = float(forces.float_loads(np.zeros((1, 2))).sum() * max(forces.shape.roll.max(), forces.shape.side.max()))
    for share in SHARES:
        strength = share * total
        pulls = _pulls(corners, direction, strength, forces.length)
        middle = np.stack([pull.middle for pull in pulls], axis=-1).reshape(-1, 3)
        pushed = forces.minimizers(places, middle, np.repeat(free, 4, axis=0)).reshape(-1, 4, 3)
        shown = -forces.powers(corners, pulls, pushed, free) / strength * (1 - 2.0**-40)
        best = np.fmax(best, np.where(np.isfinite(shown).all(axis=1), shown.min(axis=1), -np.inf))
    least = float(best.min())
    return Fraction(least) if least > 0 else None


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


def _pulls(
    corners: Floats, direction: tuple[float, float], strength: float, length: float
) -> tuple[Intervals, Intervals, Intervals]:
    """``-lambda (m, m . J c)`` by ``(v, length omega)``, (pieces, 4) each."""
    a, b = (Intervals.of(np.array(-strength)) * Intervals.of(np.array(entry)) for entry in direction)
    x, y = (Intervals.of(corners[:, :, k]) for k in range(2))
    zero = Intervals.of(np.zeros(corners.shape[:2]))
    inverse = Intervals.of(np.array(1 / length)).widened
    return a + zero, b + zero, (b * x - a * y) * inverse
