"""Bodies with an outline on arrays, and their geometry in floats, written anew."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import numpy as np

from nonsmooth.symbolic.mechanics.body import Body, Disc, PolygonShape
from nonsmooth.symbolic.mechanics.scene import Contact, Scene
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
