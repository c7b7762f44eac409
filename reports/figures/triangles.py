"""Certified regions as triangles: of plain systems in the plane, and of arrays beside sampled starts."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.reports.figures.style import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.proofs.answers.array_basin import ArrayBasin
    from nonsmooth.proofs.systems.basin import CertifiedBasin

MESH, BORDER, OUTER = "#999999", "#0072B2", "#D55E00"


def draw_triangles(axes: Axes, basin: CertifiedBasin, at: tuple[float, float] = (0.0, 0.0)) -> None:
    """The triangles of a basin about a point, and its border."""
    x, y = (basin.corners[:, :2] + at).T
    axes.triplot(x, y, basin.triangles, color=MESH, linewidth=0.3)
    border = np.concatenate([basin.border, basin.border[:1]]) + at
    axes.plot(*border.T, color=BORDER, linewidth=2.0, label="certified region")
    if basin.outside is not None:
        from nonsmooth.proofs.systems.outer_ring import ring_of

        outer = ring_of(basin.outside)
        outer = np.concatenate([outer, outer[:1]]) + at
        axes.plot(*outer.T, "--", color=OUTER, linewidth=1.5, label="no start outside comes")
    axes.plot(*at, "o", color=INK, markersize=5)


def draw_array_basin(axes: Axes, basin: ArrayBasin, at: tuple[float, float]) -> None:
    """The triangles of a basin, and all sampled starts that come where bodies from these come."""
    axes.plot(*(basin.coming + at).T, ".", color=BORDER, markersize=1.5, label="sampled starts that come")
    draw_triangles(axes, basin.triangles, at)
