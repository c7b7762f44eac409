"""Certified regions as triangles: of plain systems in the plane, and of arrays beside sampled starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.proofs.systems.outer_ring import ring_of
from nonsmooth.reports.figures.style import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.proofs.answers.array_basin import ArrayBasin
    from nonsmooth.proofs.systems.basin import CertifiedBasin
    from nonsmooth.proofs.systems.basin_rings import Floats

MESH, BORDER, OUTER = "#999999", "#0072B2", "#D55E00"


def draw_triangles(axes: Axes, basin: CertifiedBasin, at: tuple[float, float] = (0.0, 0.0)) -> None:
    """The triangles of a basin about a point, its border, and polygons from beyond which no start comes."""
    x, y = (basin.corners[:, :2] + at).T
    axes.triplot(x, y, basin.simplices, color=MESH, linewidth=0.3)
    axes.plot(*_closed(basin.border + at), color=BORDER, linewidth=2.0, label="certified region")
    for own in basin.never:
        outer = _closed(ring_of(own) + at)
        label = "from beyond no start comes" if own is basin.never[0] else None
        axes.plot(*outer, "--", color=OUTER, linewidth=1.5, label=label)
    axes.plot(*at, "o", color=INK, markersize=5)
    axes.legend(fontsize="x-small", frameon=False, ncols=2, loc="upper center", bbox_to_anchor=(0.5, -0.1))


def _closed(ring: Floats) -> Floats:
    """Coordinates (2, corners + 1) of a closed line through a ring (corners, 2)."""
    return np.concatenate([ring, ring[:1]]).T


def draw_array_basin(axes: Axes, basin: ArrayBasin, at: tuple[float, float]) -> None:
    """The triangles of a basin, and all sampled starts that come where bodies from these come."""
    axes.plot(*(basin.coming + at).T, ".", color=BORDER, markersize=1.5, label="sampled starts that come")
    draw_triangles(axes, basin.triangles, at)
