"""Lines beside the stable manifold of a saddle, beyond which no start comes to the point.

On the border of a basin there are often saddles, and what separates the starts that come from those that do not is the
stable manifold of one.  A line begins a little beyond the saddle, along its stable direction, and goes on at both ends
backward in time, turned by an angle such that velocities lead over it, away from the point.  Far from the region it
ends in half-lines along the axes over which they lead, too.  Floats propose; theorem ``outside`` shows it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.checker.basin import Plane
from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.outside import closed, place_of
from nonsmooth.proofs.checker.positivity import Proofs
from nonsmooth.proofs.systems.basin_rings import FloatField, Floats, Pace, inside_ring
from nonsmooth.proofs.systems.outer_ring import AROUND, Beside, is_shown, on_lattice, places_of_rest, unit_of

MOST_SADDLES, MOST_POINTS = 3, 1_500  # the nearest ones; points of one branch
CLEAR = 2.0**-16  # of the square of the Jacobian's size: a determinant that is as small counts as zero, as on a curve
NEAR = 1 / 64  # of its distance from the point: how far from a saddle a line is straight, at most
SHARPER = 1 / 4  # than the angle of rings: a line is one ring, and many are tried
BEND = 1 / 3  # of the angle, by which a line turns from one point to the next, at most
LONGEST = 1 / 16  # of the size of the region: a side
FARTHEST = 20.0  # half-widths of the window: no line goes there
SAMPLES = tuple(2.0**k for k in range(-6, 20))  # places on a half-line, in floats, over the size
AXES = ((1, 0), (0, 1), (-1, 0), (0, -1))


def find_borders(system: System, surfaces: Sequence[str], border: Floats, pace: Pace) -> list[Beside]:
    """Saddles, in floats, each with the hypotheses of theorem ``outside``, which are shown, of a line beside it.

    Args:
        system: in the plane, without sines.
        surfaces: on which it switches, in the displacement.
        border: of the certified region: shape (corners, 2).
        pace: of rings.
    """
    plane = Plane(system, "1", list(surfaces), Proofs({}))
    if any(plane.waves):
        return []
    field, half, found = FloatField(plane), float(np.abs(border).max()), list[Beside]()
    rests = [(own, slope) for own, slope in places_of_rest(field, AROUND * half) if np.isfinite(slope).all()]
    saddles = [(own, slope) for own, slope in rests if np.linalg.det(slope) < -CLEAR * np.sum(slope**2)]
    with np.errstate(all="ignore"):  # far out, and where velocities vanish
        for saddle, slope in saddles[:MOST_SADDLES]:
            search = _Search(field, saddle, slope, half, SHARPER * pace.angle)
            shown = next((own for own in search.lines(surfaces) if is_shown(system, own)), None)
            found += [] if shown is None else [(saddle, shown)]
    return found


def left_of(hypotheses: dict[str, Any], x: Floats) -> NDArray[np.bool_]:
    """Which places are to the left of a line, in floats: shape (places, 2)."""
    unit = unit_of(hypotheses)
    half = 1 + int(np.abs(x).max() / unit)
    first, last = map(place_of, hypotheses["ends"])
    whole = closed([place_of(own) for own in hypotheses["corners"]], first, last, half)
    return inside_ring(np.array(whole, dtype=float) * unit, x)


@dataclass(frozen=True)
class _Search:
    """A line beside the stable manifold of one saddle.

    Attributes:
        field: its velocities.
        saddle: where it is.
        slope: the Jacobian there.
        half: half-width of the certified region.
        angle: by which the line is turned.
    """

    field: FloatField
    saddle: Floats
    slope: Floats
    half: float
    angle: float

    def lines(self, surfaces: Sequence[str]) -> Iterator[dict[str, Any]]:
        """Hypotheses of lines on either side of the stable manifold, that away from the point first."""
        values, vectors = np.linalg.eig(self.slope)
        order = np.argsort(values.real)
        (falls, grows), (stable, unstable) = values.real[order], vectors.real.T[order]
        for beyond in (unstable, -unstable) if unstable @ self.saddle > 0 else (-unstable, unstable):
            # The line is passed with the point to its left: what is beyond is to its right.
            way = stable if stable[1] * beyond[0] - stable[0] * beyond[1] > 0 else -stable
            near = min(NEAR, self.angle / 4) * float(np.linalg.norm(self.saddle))
            start = self.saddle + near * self.angle * -falls / grows * beyond
            before = self._branch(start - near * way, 1)
            after = None if before is None else self._branch(start + near * way, -1)
            if before is not None and after is not None:
                chain = np.concatenate([before[0][::-1], after[0]])
                ends = [f"{x} {y}" for x, y in (before[1], after[1])]
                yield {**on_lattice(chain, surfaces), "ends": ends}

    def _branch(self, start: Floats, along: int) -> tuple[Floats, tuple[int, int]] | None:
        """Points of a line backward in time until a half-line begins, and its direction.

        Args:
            start: the first point.
            along: 1 where the line is passed as solutions pass, -1 where against them.
        """
        points, step = [start], self.half / 1024
        while len(points) < MOST_POINTS and np.abs(points[-1]).max() < FARTHEST * self.half:
            direction = self._direction(points[-1], along)
            end = self._half_line(points[-1], along)
            if end is not None:
                return np.array(points), end
            while True:
                middle = self._direction(points[-1] + step / 2 * direction, along)
                after = self._direction(points[-1] + step * middle, along)
                if np.dot(direction, after) > np.cos(BEND * self.angle):
                    break
                step /= 2
                if not step > 2.0**-20 * self.half:
                    return None
            points.append(points[-1] + step * middle)
            step = min(1.5 * step, LONGEST * self.half)
        return None

    def _direction(self, place: Floats, along: int) -> Floats:
        """Backward in time, turned so that velocities lead to the right of the line."""
        velocity = self.field.at(place[None])[0, 0]
        turn = self.angle * along
        (c, s), (x, y) = (np.cos(turn), np.sin(turn)), -velocity / np.linalg.norm(velocity)
        return np.array([c * x - s * y, s * x + c * y])

    def _half_line(self, place: Floats, along: int) -> tuple[int, int] | None:
        """A direction along an axis, away from the region, over which all velocities lead to the right, in floats."""
        for x, y in AXES:
            if place @ (x, y) < AROUND / 2 * self.half:
                continue
            normal = along * np.array([-y, x], dtype=float)  # the first branch is passed inward, the last one outward
            there = place + np.outer(SAMPLES, (x, y)) * self.half
            if (self.field.at(np.concatenate([place[None], there])) @ normal > 0).all():
                return x, y
        return None
