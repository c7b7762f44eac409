"""Arrays that a turn about the checked point leaves as they are, exactly.

A generic array has no equilibrium at a given point; one that is symmetric under a half turn has: forces of opposite
wheels cancel.  So a design keeps the symmetry that the places of its wheels have.
"""

from __future__ import annotations

from typing import TypeAlias

from nonsmooth.symbolic.plane import Vector, minus, turned
from nonsmooth.symbolic.scene import Scene

Orbits: TypeAlias = tuple[tuple[int, ...], ...]  # places of wheels, each the one before turned

ORDERS = (4, 2, 1)  # of the turns that are exact for all rational numbers


def quarter_turns(vector: Vector, count: int) -> Vector:
    """A vector after some quarter turns."""
    for _ in range(count % 4):
        vector = turned(vector)
    return vector


def orbits_of(scene: Scene, order: int) -> Orbits | None:
    """The wheels in orbits under turns by ``2 pi/order`` about the checked point; None where they are not symmetric.

    Args:
        scene: the array.
        order: one of :data:`ORDERS`.
    """
    at = scene.check.equilibrium
    places = {_offset(wheel.position, at): k for k, wheel in enumerate(scene.wheels)}
    left, found = set(places.values()), []
    for k, wheel in enumerate(scene.wheels):
        if k not in left:
            continue
        offset = _offset(wheel.position, at)
        images = [places.get(quarter_turns(offset, step * 4 // order)) for step in range(order)]
        orbit = tuple(image for image in images if image is not None)
        if len(set(orbit)) != order or any(scene.wheels[i].friction != wheel.friction for i in orbit):
            return None
        found.append(orbit)
        left -= set(orbit)
    return tuple(found)


def _offset(position: Vector, at: Vector) -> Vector:
    return minus(position, at)


def largest_symmetry(scene: Scene) -> int:
    """The largest order that the array has."""
    return next(order for order in ORDERS if orbits_of(scene, order) is not None)
