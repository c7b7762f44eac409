"""Where sampled paths of a body gather: places at which it rests, with the headings that occur there.

Bodies that rest within a small distance of each other rest at one place (single linkage).  A place may have a whole
range of headings: the wheels under the body say where it rests, and many headings may have the same wheels under it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.bodies.many_contacts import Numbers
from nonsmooth.analysis.bodies.many_paths import BodyEnd, BodyEnds, turned_heading
from nonsmooth.analysis.fields.contact_model import Floats

TOGETHER = 0.02  # of the wheels' spacing or the body's size: bodies that rest closer together rest at one place


@dataclass(frozen=True)
class PathEnd:
    """One place at which bodies rest, or another way to end.

    Attributes:
        reason: how the paths end.
        starts: their numbers.
        share: of all starts.
        pose: a middle one ``(x, y, theta)`` of the poses at rest; None elsewhere.
        headings: the least and the largest heading at rest, theta without full turns; None elsewhere.
    """

    reason: BodyEnd
    starts: Numbers
    share: float
    pose: tuple[float, float, float] | None = None
    headings: tuple[float, float] | None = None

    @property
    def text(self) -> str:
        """In words."""
        if self.pose is None or self.headings is None:
            return self.reason.value
        x, y, _ = (f"{_plain(value):.4g}" for value in self.pose)
        low, high = (f"{_plain(value):.4g}" for value in self.headings)
        heading = f"theta = {low}" if low == high else f"theta from {low} to {high}"
        return f"{self.reason.value} at ({x}, {y}), {heading}"


def destinations(ends: BodyEnds, distance: float) -> list[PathEnd]:
    """Places of rest, largest share first, then the other ends.

    Args:
        ends: of the paths.
        distance: below which bodies rest together, in lengths.
    """
    resting = np.flatnonzero(ends.by(BodyEnd.REST))
    found = []
    for group in _linked(ends.poses[resting, :2], distance):
        found.append(_at_rest(ends, resting[group]))
    found.sort(key=lambda one: (-one.share, one.text))
    for reason in BodyEnd:
        starts = np.flatnonzero(ends.by(reason))
        if reason is not BodyEnd.REST and len(starts):
            found.append(PathEnd(reason, starts, len(starts) / len(ends.starts)))
    return found


def _at_rest(ends: BodyEnds, starts: Numbers) -> PathEnd:
    """The middle of the poses: means of x and y, and the heading that is the middle one around the first."""
    poses = ends.poses[starts]
    first = poses[0, 2]
    headings = np.sort(first + turned_heading(poses[:, 2] - first))
    x, y = poses[:, :2].mean(axis=0)
    turn = float(
        turned_heading(headings[len(headings) // 2 : len(headings) // 2 + 1])[0] - headings[len(headings) // 2]
    )
    headings = headings + turn
    middle = (float(x), float(y), float(headings[len(headings) // 2]))
    share = len(starts) / len(ends.starts)
    return PathEnd(BodyEnd.REST, starts, share, middle, (float(headings[0]), float(headings[-1])))


def _linked(places: Floats, distance: float) -> list[Numbers]:
    """Groups of points (m, 2) linked by steps of at most a distance."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    if not len(places):
        return []
    pairs = cKDTree(places).query_pairs(distance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(len(places), len(places)))
    count, labels = connected_components(links, directed=False)
    return [np.flatnonzero(labels == k) for k in range(count)]


def _plain(value: float) -> float:
    """Rounding of zero as zero."""
    return 0.0 if abs(value) < 5e-5 else value
