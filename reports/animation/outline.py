"""The outline of a body, for drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.symbolic.continuum import Disc, Footprint
from nonsmooth.symbolic.scene import Scene

CORNERS = 72  # of the polygon that a disc is drawn as: its sides leave the circle by less than 0.1 % of the radius

Floats = NDArray[np.float64]


def shape_of(scene: Scene) -> Footprint | None:
    """The outline that a scene gives its body; None where it gives none."""
    return None if scene.continuum is None else scene.continuum.footprint


def outline_points(shape: Footprint) -> Floats:
    """Corners (m, 2) of a polygon or disc, from the body's reference point, at heading zero (length)."""
    if isinstance(shape, Disc):
        angles = 2 * np.pi * np.arange(CORNERS) / CORNERS
        return float(shape.radius) * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.array([[float(x), float(y)] for x, y in shape.vertices])


def placed(points: Floats, pose: Floats) -> Floats:
    """Points of the body in the world, ``c + R(theta) p``."""
    x, y, theta = pose
    cos, sin = np.cos(theta), np.sin(theta)
    return points @ np.array([[cos, sin], [-sin, cos]]) + np.array([x, y])
