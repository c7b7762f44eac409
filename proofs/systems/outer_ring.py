"""Polygons that solutions do not cross toward the point: no start on their other side comes to it.

*Around* a bounded basin all velocities lead outward over one.

Backward in time solutions from outside come to the border of such a basin, as those from inside do.  So a ring that is
wider than the certified region follows the field backward, turned inward by an angle that all velocities then keep to
the ring at least (:mod:`nonsmooth.proofs.systems.basin_rings`).  Floats propose; each side is shown by theorem
``outside``.  Basins that reach to infinity have no such polygon.

*Traps*: all velocities lead into a polygon about another place of rest, and the point is outside of it.  It grows
backward in time from a small ellipse, as the certified region does, and needs no exact place of rest.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import chain
from operator import add
from typing import TypeAlias

import numpy as np

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.outside import show_outside
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.systems.basin_rings import (
    FloatField,
    RingGrowth,
    area,
    grow,
    lattice_unit,
    next_ring,
    sines,
    unit_ball,
)
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    are_finite,
    finite_rows,
    following,
    grid_points,
    max_norm,
    max_norms,
    row_norms,
    spread,
    unit_vectors,
)

Beside: TypeAlias = tuple[Floats, Record]  # another place of rest, in floats, and hypotheses that are shown

WIDER = (1.15, 1.4, 2.0)  # of the certified region: first rings, tried in turn
TURNS, SLENDER = (3.0, 1.0, 0.5), 0.3  # of the angle, one after the other; the largest gap over it
STEPS, PAUSE, STILL = 400, 25, 0.9995  # at most; between looks at the area; by which this must shrink
FARTHEST, POWER = 50.0, 2  # times the certified region; p of the speed
BITS = 24  # of places on a ring
AROUND, GRID, NEWTON = 3.0, 15, 12  # half-widths of the region where other places of rest are searched; starts; steps
SETTLED, NEAR, MOST_TRAPS = 2.0**-30, 2.0**-8, 2  # speeds and distances of one place, over the size; places
COARSER, MOST_POINTS, POINTS_A_STEP = 2.0, 4_000, 5  # angles and gaps than those of the region; points of a ring
SLOWER = 0.75  # than the slowest solutions a V falls
LESS = 0.75  # of the angle at which velocities lead into the first ring: that at which they meet the next ones
FIRST, SMALLER, LOOKS = 200, (2, 4, 8, 16, 64), 25  # points of the first ring; distance over its size; rings tried
KEPT, LONGEST, COARSENINGS = 0.25, (1 / 24, 1 / 96), 6  # of the angle; of the size, sides with fewer corners; rounds


def find_outer_ring(
    system: System, surfaces: Sequence[str], border: Floats, pace: RingGrowth, steps: int
) -> Record | None:
    """The hypotheses of theorem ``outside``, which are shown; None where no polygon is found.

    Args:
        system: in the plane.
        surfaces: on which it switches, in the displacement.
        border: of the certified region, a ring that is counterclockwise: shape (corners, 2).
        pace: about by which angle velocities are turned inward, and how near neighbours on a ring are.
        steps: of all rings that are tried, at most.
    """
    field = FloatField.of(system, surfaces)
    best: Record | None = None
    rings = [wider * border for wider in WIDER]
    for angle in (turn * pace.angle for turn in TURNS):
        for ring in rings:
            inward = RingGrowth(-angle, min(pace.gap, SLENDER * angle), pace.move)
            taken, nearer = _shrunk(field, ring, border, inward, min(steps, STEPS))
            steps -= taken
            hypotheses = None if nearer is None else shown_polygon(system, surfaces, field, nearer)
            if nearer is not None and hypotheses is not None:
                best, rings = hypotheses, [nearer]
                break
        if best is None:  # a smaller angle is harder; after one that is shown it may be shown where another was not
            break
    return best


def find_traps(system: System, surfaces: Sequence[str], border: Floats, pace: RingGrowth, steps: int) -> list[Beside]:
    """Other places of rest, in floats, each with the hypotheses of theorem ``outside``, which are shown, of a polygon.

    Args:
        system: in the plane.
        surfaces: on which it switches, in the displacement.
        border: of the certified region: shape (corners, 2).
        pace: of rings.
        steps: of the rings about one place, at most.
    """
    field, traps = FloatField.of(system, surfaces), list[Beside]()
    for place, slope in other_rests(field, AROUND * max_norm(border))[:MOST_TRAPS]:
        moved = (ring_of(polygon) + place - other for other, polygon in traps)  # fields may repeat themselves
        polygon = next(filter(None, (shown_polygon(system, surfaces, field, ring) for ring in moved)), None)
        polygon = polygon or _grown_about(system, surfaces, place, slope, pace, steps)
        traps += [(place, polygon)] if polygon is not None else []
    return traps


def other_rests(field: FloatField, half: float) -> list[tuple[Floats, Floats]]:
    """Places in a square at which velocities vanish and nearby ones lead to them, with their slopes, in floats."""
    rests = places_of_rest(field, half)
    return [(place, slope) for place, slope in rests if (np.linalg.eigvals(slope).real < 0).all()]


def places_of_rest(field: FloatField, half: float) -> list[tuple[Floats, Floats]]:
    """Places in a square, but the point itself, at which velocities vanish, with their slopes, in floats."""
    lines = np.linspace(-half, half, GRID)
    x = grid_points(lines, lines)
    width = 2.0**-20 * half
    for _ in range(NEWTON):
        with np.errstate(all="ignore"):
            slopes, velocities = _slopes(field, x, width), field.at(x)[0]
        finite = np.isfinite(slopes).all(axis=(1, 2)) & finite_rows(velocities)
        x = x[finite] - np.einsum("kij,kj->ki", np.linalg.pinv(slopes[finite]), velocities[finite])
        x = x[max_norms(x) < 4 * half]
        if not len(x):
            return []
    settled = row_norms(field.at(x)[0]) < SETTLED * half
    x = np.round(x[settled] / width) * width + 0.0
    sizes = row_norms(x)
    rests: list[tuple[Floats, Floats]] = []
    for place in x[np.argsort(sizes, kind="stable")]:
        apart = all(
            np.linalg.norm(place - other) > NEAR * half for other in (np.zeros(2), *(rest for rest, _ in rests))
        )
        if apart and max_norm(place) < half:
            rests.append((place, _slopes(field, place[None], width)[0]))
    return rests


def _slopes(field: FloatField, x: Floats, width: float) -> Floats:
    """The Jacobians of the first right-hand side at places, by differences: shape (places, 2, 2)."""
    columns = [(field.at(x + step)[0] - field.at(x - step)[0]) / (2 * width) for step in np.eye(2) * width]
    return np.stack(columns, axis=2)


def _grown_about(
    system: System, surfaces: Sequence[str], place: Floats, slope: Floats, pace: RingGrowth, steps: int
) -> Record | None:
    """A polygon about a place of rest, as large as is shown; None where none is."""
    away = [Fraction(round(coordinate * 2**BITS), 2**BITS) for coordinate in place.tolist()]
    middle, distance = np.array(away, dtype=float), float(np.linalg.norm(place))
    moved = replace(system, at=tuple(map(add, system.at, away)))
    field = FloatField.of(moved, _moved(system, surfaces, away))
    whole = FloatField.of(system, surfaces)

    def shown(ring: Floats) -> Record | None:
        return shown_polygon(system, surfaces, whole, ring[::-1] + middle)

    ellipse = _small_ring(slope) * distance
    first = next((ellipse / share for share in SMALLER if shown(ellipse / share)), None)
    if first is None:
        return None
    most = min(MOST_POINTS, POINTS_A_STEP * steps)
    angle = min(COARSER * pace.angle, LESS * float(np.arcsin(sines(field, first[::-1]).min())))
    outward = RingGrowth(angle, min(COARSER * pace.gap, SLENDER * angle), pace.move)
    rings = list(grow(field, first, outward, FARTHEST * distance, most, steps * pace.move, lambda done, total: None))
    return next(filter(None, map(shown, rings[:: -max(1, len(rings) // LOOKS)])), None)


def _small_ring(slope: Floats) -> Floats:
    """An ellipse of size 1, counterclockwise: a level set of a V that falls about as fast as the slowest solutions."""
    ring = unit_vectors(np.linspace(0, 2 * np.pi, FIRST, endpoint=False)) @ unit_ball(slope, SLOWER).T
    return ring / np.abs(ring).max()


def _moved(system: System, surfaces: Sequence[str], away: Sequence[Fraction]) -> list[str]:
    """The surfaces in the displacement from another place."""
    moved = {name: f"({name} + ({offset}))" for name, offset in zip(system.states, away, strict=True)}
    names = re.compile(rf"\b({'|'.join(moved)})\b")
    return [names.sub(lambda match: moved[match[0]], surface) for surface in surfaces]


def shown_polygon(system: System, surfaces: Sequence[str], field: FloatField, ring: Floats) -> Record | None:
    """The hypotheses of a polygon with few corners, or of all of them, which the checker's theorem takes; else None.

    Args:
        system: in the plane.
        surfaces: on which it switches, in the displacement.
        field: its velocities.
        ring: corners of a polygon with the point to its left.
    """
    if not (sines(field, ring) > 0).all():
        return None
    size = spread(ring)
    coarser = (_with_fewer_corners(field, ring, part * size) for part in LONGEST)
    listed = (on_lattice(polygon, surfaces) for polygon in chain(coarser, [ring]))
    return next((hypotheses for hypotheses in listed if is_shown(system, hypotheses)), None)


def _with_fewer_corners(field: FloatField, ring: Floats, longest: float) -> Floats:
    """A ring without corners between which velocities lead over the longer side at a good part of the angle, too."""
    least = KEPT * float(sines(field, ring).min())
    for _ in range(COARSENINGS):
        longer = following(ring) - np.roll(ring, 1, axis=0)
        left_out = sines(field, np.roll(ring, 1, axis=0), longer) > least
        left_out &= row_norms(longer) < longest
        left_out[::2] = left_out[-1] = False  # never two neighbours
        if not left_out.any():
            break
        ring = ring[~left_out]
    return ring


def is_shown(system: System, hypotheses: Record) -> bool:
    """Whether the checker's theorem takes a polygon or a line."""
    try:
        show_outside(system, hypotheses, Proofs({}))
    except RejectedError:
        return False
    return True


def _shrunk(field: FloatField, ring: Floats, border: Floats, pace: RingGrowth, most: int) -> tuple[int, Floats | None]:
    """How many steps a ring follows the field backward until it shrinks no more, and the ring.

    None where it comes to the region, or leaves.
    """
    limit = FARTHEST * max_norm(border)
    least, before = area(border), area(ring)
    for step in range(1, most):
        ring = next_ring(field, ring, pace, limit, POWER)
        if not are_finite(ring) or max_norm(ring) > limit / 2 or area(ring) < least:
            return step, None
        if step % PAUSE == 0:
            if area(ring) > STILL * before:
                return step, ring
            before = area(ring)
    return most, ring


def on_lattice(ring: Floats, surfaces: Sequence[str]) -> Record:
    """A ring in whole numbers, as a certificate holds it."""
    power = BITS - int(np.ceil(np.log2(max_norm(ring))))
    places = np.rint(ring * 2.0**power).astype(np.int64)
    return {
        "surfaces": list(surfaces),
        "unit": lattice_unit(power),
        "corners": [f"{x} {y}" for x, y in places.tolist()],
    }


def ring_of(hypotheses: Record) -> Floats:
    """The corners of a polygon in floats: shape (corners, 2)."""
    places = np.array([corner.split(" ") for corner in hypotheses["corners"]], dtype=float)
    return places * float(Fraction(hypotheses["unit"]))
