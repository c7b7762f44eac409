"""Certified regions as triangles: of plain systems in the plane, and of arrays beside sampled starts."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.proofs.checker.outside import place_of
from nonsmooth.proofs.systems.outer_ring import ring_of
from nonsmooth.reports.figures.style import INK
from nonsmooth.symbolic.numbers.plane import XY

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.proofs.answers.array_basin import ArrayBasin
    from nonsmooth.proofs.systems.basin import CertifiedBasin
    from nonsmooth.proofs.systems.basin_rings import Floats

MESH, BORDER, OUTER = "#999999", "#0072B2", "#D55E00"


def draw_triangles(axes: Axes, basin: CertifiedBasin, at: XY = (0.0, 0.0)) -> None:
    """The triangles of a basin about a point, its border, and polygons and lines from beyond which no start comes."""
    x, y = (basin.corners[:, :2] + at).T
    axes.triplot(x, y, basin.simplices, color=MESH, linewidth=0.3)
    axes.plot(*_closed(basin.border + at), color=BORDER, linewidth=2.0, label="certified region")
    for own in basin.never:
        outer = _passed(own) + np.array([at]).T
        label = "from beyond no start comes" if own is basin.never[0] else None
        axes.plot(*outer, "--", color=OUTER, linewidth=1.5, label=label)
    axes.plot(*at, "o", color=INK, markersize=5)
    if basin.saddles:  # lines beside them have no end
        (left, right), (low, high) = basin.window
        axes.set_xlim(left + at[0], right + at[0])
        axes.set_ylim(low + at[1], high + at[1])
    axes.legend(fontsize="x-small", frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.1))


def _closed(ring: Floats) -> Floats:
    """Coordinates (2, corners + 1) of a closed line through a ring (corners, 2)."""
    return np.concatenate([ring, ring[:1]]).T


def _passed(hypotheses: dict[str, Any]) -> Floats:
    """Coordinates (2, corners) of a closed polygon, or of a line with a part of both of its half-lines."""
    ring = ring_of(hypotheses)
    if "ends" not in hypotheses:
        return _closed(ring)
    first, last = np.array([place_of(own) for own in hypotheses["ends"]]) * np.abs(ring).max() / 4
    return np.concatenate([[ring[0] + first], ring, [ring[-1] + last]]).T


def draw_array_basin(axes: Axes, basin: ArrayBasin, at: XY) -> None:
    """The triangles of a basin, and all sampled starts that come where bodies from these come."""
    axes.plot(*(basin.coming + at).T, ".", color=BORDER, markersize=1.5, label="sampled starts that come")
    draw_triangles(axes, basin.triangles, at)
