"""Over what a body tips."""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.symbolic.plane import Vector, around
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.support_polygon import outer_positions, support_polygon


def tipping_edge(scene: Scene, carrying: frozenset[int], pose: Floats) -> str:
    """The side of the hull of the carrying wheels that the centre of mass is farthest beyond, in words.

    Args:
        scene: the array.
        carrying: places in its list of wheels.
        pose: of the body.
    """
    number = {scene.wheels[k].position: scene.wheels[k].index for k in carrying}
    if not number:
        return "with no wheel under it"
    if len(number) == 1:
        return f"over wheel {min(number.values())}"
    corners = support_polygon(outer_positions(list(number)))
    sides = [(number[a], number[b], _line_distance(a, b, pose)) for a, b in around(corners)]
    first, second, _ = min(sides, key=lambda side: side[2])
    return f"over the line through wheels {first} and {second}"


def _line_distance(a: Vector, b: Vector, pose: Floats) -> float:
    """Distance of the centre of mass from the inner side of the line through two corners; negative beyond it."""
    (ax, ay), (bx, by) = ((float(x), float(y)) for x, y in (a, b))
    along = np.array([bx - ax, by - ay])
    return float((along[0] * (pose[1] - ay) - along[1] * (pose[0] - ax)) / np.hypot(*along))
