"""Bodies with an outline on arrays, and their geometry in floats, written anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from functools import partial
from typing import TypeAlias

import numpy as np

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.body import Body, Disc, PolygonShape
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
from tests.conftest import Arrays, WheelData
from tests.oracles.floats import Floats

Depths: TypeAlias = Callable[[Floats, Floats], Floats]  # of places (n, 2) at a pose
Pair: TypeAlias = tuple[Fraction | int, Fraction | int]


def on(scene: Scene, outline: Disc | PolygonShape, centre: Pair = (0, 0), rule: str = "ellipse") -> Scene:
    """The scene with a body whose centroid lies at ``centre`` from its centre of mass."""
    field = scene.field
    body = Body(outline, (field(centre[0]), field(centre[1])), (field(1), field(0)))
    return replace(scene, body=body, contact=Contact(rule))


def polygon_of(scene: Scene, corners: list[Pair]) -> PolygonShape:
    return PolygonShape(tuple((scene.field(x), scene.field(y)) for x, y in corners))


def seen(places: Floats, pose: Floats) -> Floats:
    """Places from the body: complex numbers turned back."""
    away = (places[:, 0] - pose[0]) + 1j * (places[:, 1] - pose[1])
    turned = away * np.exp(-1j * pose[2])
    return np.column_stack([turned.real, turned.imag])


def disc_depths(radius: float, centre: Floats, places: Floats, pose: Floats) -> Floats:
    return np.asarray(radius - np.linalg.norm(seen(places, pose) - centre, axis=1))


def polygon_depths(corners: Floats, places: Floats, pose: Floats) -> Floats:
    """Twice the area of the triangle over a side, over its length; the least over all sides."""
    depths = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        away, along = seen(places, pose) - a, b - a
        depths.append((along[0] * away[:, 1] - along[1] * away[:, 0]) / np.linalg.norm(along))
    return np.asarray(np.min(depths, axis=0))


def under(depths: Floats) -> frozenset[int]:
    return frozenset(int(k) for k in np.flatnonzero(depths > 0))


def carton(rule: str = "nearest") -> tuple[Scene, Depths]:
    """The built-in carton, on all wheels of its table."""
    scene = whole(load_scene("carton-on-6x6", rule=rule))
    assert scene.body is not None
    corners = np.array([[float(x) for x in corner] for corner in scene.body.vertices])
    return scene, partial(polygon_depths, corners)


def pushed_back(arrays: Arrays, rule: str = "ellipse") -> tuple[Scene, Depths]:
    """Four wheels carry a plate to the right and up, onto a fifth of more grip that runs to the left."""
    ways = [(10, 3), (10, 4), (12, 3), (11, 5)]
    corners: list[Pair] = [(1, 1), (-1, 1), (-1, -1), (1, -1)]
    wheels = [WheelData(at, way, Fraction(1, 2)) for at, way in zip(corners, ways, strict=True)]
    scene = arrays.scene([*wheels, WheelData((2, Fraction(3, 10)), (-10, 1), 2, (8, 4))])
    half, high = Fraction(8, 5), Fraction(9, 5)
    plate: list[Pair] = [(-half, -high), (half, -high), (half, high), (-half, high)]
    return on(scene, polygon_of(scene, plate), rule=rule), partial(polygon_depths, np.array(plate, float))
