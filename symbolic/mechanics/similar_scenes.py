"""Scenes that must behave like a given one: scaled, sped up, moved away, or with another ratio of frictions.

All changes are exact.  What has to follow:

- *scaled* (positions, square, equilibrium, length l times s; speeds kept): twists ``(v, omega/s)``, the same verdicts;
- *moved* (array and equilibrium shifted alike): the same verdicts about the shifted point;
- *with friction ratio* r (``mu_S = r mu_R``): under rule ``nearest`` only ``r < 1``, ``= 1`` or ``> 1`` matters.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

from nonsmooth.symbolic.mechanics.body import Body, Disc, Footprint, extent, outer_positions, support_polygon
from nonsmooth.symbolic.mechanics.load_model import LoadModel
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel


def with_wheels(scene: Scene, change: Callable[[Wheel], Wheel]) -> Scene:
    """Every wheel changed alike."""
    return replace(scene, wheels=tuple(change(wheel) for wheel in scene.wheels))


def scaled(scene: Scene, factor: Fraction) -> Scene:
    """All lengths times a positive factor; surface speeds stay, and inertia is left out: it would count otherwise."""

    def larger(wheel: Wheel) -> Wheel:
        x, y = wheel.position
        return replace(wheel, position=(x * factor, y * factor))

    (x, y), loads = scene.check.equilibrium, scene.contact.loads
    if isinstance(loads, LoadModel):
        loads = loads.scaled(factor)
    check = replace(
        scene.check,
        equilibrium=(x * factor, y * factor),
        radius=scene.check.radius * factor,
        wider=None,
        lyapunov=None,
        length=scene.check.length * factor,
        accuracy=None if scene.check.accuracy is None else scene.check.accuracy * factor,
    )
    body = None if scene.body is None else _scaled_body(scene.body, factor)
    box = None if scene.tolerances is None else scene.tolerances.scaled(factor)
    contact = replace(scene.contact, loads=loads)
    return replace(with_wheels(scene, larger), contact=contact, check=check, body=body, tolerances=box, inertia=None)


def _scaled_body(body: Body, factor: Fraction) -> Body:
    x, y = body.centre
    outline = body.outline
    if isinstance(outline, Disc):
        larger: Footprint = replace(outline, radius=outline.radius * factor)
    else:
        larger = replace(outline, vertices=tuple((a * factor, b * factor) for a, b in outline.vertices))
    return replace(body, outline=larger, centre=(x * factor, y * factor))


def in_own_length(scene: Scene) -> Scene:
    """The same array with its length l for the unit: there ``V = |c|^2 + l^2 theta^2`` is ``|c|^2 + theta^2``."""
    return scene if scene.check.length == 1 else scaled(scene, 1 / scene.check.length)


def counted_in_own_length(scene: Scene) -> Scene:
    """The same array in another unit of length, its length l; times stay, so speeds are counted in it too."""
    if scene.check.length == 1:
        return scene
    factor = 1 / scene.check.length

    def slower(wheel: Wheel) -> Wheel:
        if wheel.given_speed is not None:
            return replace(wheel, given_speed=wheel.given_speed * factor)
        x, y = wheel.direction
        return replace(wheel, direction=(x * factor, y * factor))

    return with_wheels(scaled(scene, factor), slower)


def covering(scene: Scene) -> Scene:
    """The same array with a checked square that holds all its wheels."""
    corners = support_polygon(outer_positions(scene.positions))
    middle = tuple((min(values) + max(values)) / 2 for values in zip(*corners, strict=True))
    widest = max(extent(corners, 0), extent(corners, 1))
    return replace(scene, check=replace(scene.check, equilibrium=(middle[0], middle[1]), radius=widest))


def moved(scene: Scene, x: Fraction, y: Fraction) -> Scene:
    """Array, load table and equilibrium shifted alike."""

    def shifted(wheel: Wheel) -> Wheel:
        return replace(wheel, position=(wheel.position[0] + x, wheel.position[1] + y))

    (p, q), loads = scene.check.equilibrium, scene.contact.loads
    if isinstance(loads, LoadModel):
        loads = loads.moved(x, y)
    check = replace(scene.check, equilibrium=(p + x, q + y))
    return replace(with_wheels(scene, shifted), contact=replace(scene.contact, loads=loads), check=check)


def with_friction_ratio(scene: Scene, ratio: Fraction) -> Scene:
    """``mu_R = 1`` and ``mu_S = ratio`` at every wheel."""
    roll, side = scene.field.one, scene.field(ratio)
    return with_wheels(scene, lambda wheel: replace(wheel, friction=replace(wheel.friction, roll=roll, side=side)))
