"""A polygon around a bounded basin over which all velocities lead outward: no start outside of it comes to the point.

Backward in time solutions from outside come to the border of such a basin, as those from inside do.  So a ring that is
wider than the certified region follows the field backward, turned inward by an angle that all velocities then keep to
the ring at least (:mod:`nonsmooth.proofs.systems.basin_rings`).  Floats propose; each side is shown by theorem
``outside``.  Basins that reach to infinity have no such polygon.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from nonsmooth.proofs.checker.basin import Plane
from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.outside import show_outside
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.systems.basin_rings import FloatField, Floats, Pace, area, next_ring

WIDER = (1.15, 1.4, 2.0)  # of the certified region: first rings, tried in turn
TURNS, SLENDER = (3.0, 1.0, 0.5), 0.3  # of the angle, one after the other; the largest gap over it
STEPS, PAUSE, STILL = 400, 25, 0.9995  # at most; between looks at the area; by which this must shrink
FARTHEST, POWER = 50.0, 2  # times the certified region; p of the speed
BITS = 24  # of places on a ring


def find_outer_ring(
    system: System, surfaces: Sequence[str], border: Floats, pace: Pace, steps: int
) -> dict[str, Any] | None:
    """The hypotheses of theorem ``outside``, which are shown; None where no polygon is found.

    Args:
        system: in the plane, without sines and cosines.
        surfaces: on which it switches, in the displacement.
        border: of the certified region, a ring that is counterclockwise: shape (corners, 2).
        pace: about by which angle velocities are turned inward, and how near neighbours on a ring are.
        steps: of all rings that are tried, at most.
    """
    plane = Plane(system, "1", list(surfaces), Proofs({}))
    if any(plane.waves):
        return None
    field = FloatField(plane)
    best: dict[str, Any] | None = None
    rings = [wider * border for wider in WIDER]
    for own in (turn * pace.angle for turn in TURNS):
        for ring in rings:
            inward = Pace(-own, min(pace.gap, SLENDER * own), pace.move)
            taken, nearer = _shrunk(field, ring, border, inward, min(steps, STEPS))
            steps -= taken
            hypotheses = None if nearer is None else _on_lattice(nearer, surfaces)
            if nearer is not None and hypotheses is not None and _is_shown(system, hypotheses):
                best, rings = hypotheses, [nearer]
                break
        if best is None:  # a smaller angle is harder; after one that is shown it may be shown where another was not
            break
    return best


def _is_shown(system: System, hypotheses: dict[str, Any]) -> bool:
    try:
        show_outside(system, hypotheses, Proofs({}))
    except RejectedError:
        return False
    return True


def _shrunk(field: FloatField, ring: Floats, border: Floats, pace: Pace, most: int) -> tuple[int, Floats | None]:
    """How many steps a ring follows the field backward until it shrinks no more, and the ring.

    None where it comes to the region, or leaves.
    """
    limit = FARTHEST * float(np.abs(border).max())
    least, before = area(border), area(ring)
    for step in range(1, most):
        ring = next_ring(field, ring, pace, limit, POWER)
        if not np.isfinite(ring).all() or np.abs(ring).max() > limit / 2 or area(ring) < least:
            return step, None
        if step % PAUSE == 0:
            if area(ring) > STILL * before:
                return step, ring
            before = area(ring)
    return most, ring


def _on_lattice(ring: Floats, surfaces: Sequence[str]) -> dict[str, Any]:
    """A ring in whole numbers, as a certificate holds it."""
    power = BITS - int(np.ceil(np.log2(float(np.abs(ring).max()))))
    places = np.rint(ring * 2.0**power).astype(np.int64)
    unit = f"1/{2**power}" if power >= 0 else str(2**-power)
    return {"surfaces": list(surfaces), "unit": unit, "corners": [f"{x} {y}" for x, y in places.tolist()]}


def ring_of(hypotheses: dict[str, Any]) -> Floats:
    """The corners of a polygon in floats: shape (corners, 2)."""
    numerator, _, denominator = hypotheses["unit"].partition("/")
    places = np.array([own.split(" ") for own in hypotheses["corners"]], dtype=float)
    return np.asarray(places * float(numerator) / float(denominator or 1))
