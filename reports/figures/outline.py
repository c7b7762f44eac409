"""The outline of a body, for drawing."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from nonsmooth.symbolic.continuum import Disc
from nonsmooth.symbolic.scene import Scene

CORNERS = 72  # of the polygon that a disc is drawn as: its sides leave the circle by less than 0.1 % of the radius

Floats = NDArray[np.float64]


def outline_of(scene: Scene) -> Floats | None:
    """Corners (m, 2) of the body at theta = 0, from its centre of mass (length); None where the scene names none."""
    if scene.body is None:
        return None
    outline = scene.body.outline
    if isinstance(outline, Disc):
        angles = 2 * np.pi * np.arange(CORNERS) / CORNERS
        middle = np.array([float(entry) for entry in scene.body.centroid])
        return middle + float(outline.radius) * np.column_stack([np.cos(angles), np.sin(angles)])
    return np.array([[float(x), float(y)] for x, y in scene.body.vertices])


def placed(points: Floats, pose: Floats) -> Floats:
    """Points of the body in the world, ``c + R(theta) p``."""
    x, y, theta = pose
    cos, sin = np.cos(theta), np.sin(theta)
    return points @ np.array([[cos, sin], [-sin, cos]]) + np.array([x, y])
