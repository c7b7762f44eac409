"""Rule ``nearest`` by its words, at one point."""

from __future__ import annotations

from nonsmooth.analysis.cells.nearest import greedy_states
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.mechanics.scene import Scene


def nearest_states(scene: Scene, point: Point) -> tuple[ContactState, ...]:
    """Literal rule at one point, for a strict order of distances: the slow definition the cells are tested against."""
    ordered = sorted(scene.wheels, key=lambda w: (point[0] - w.position[0]) ** 2 + (point[1] - w.position[1]) ** 2)
    return greedy_states(ordered)
