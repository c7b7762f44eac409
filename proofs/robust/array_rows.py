"""The rows of an array and the limits of its friction forces, in floats: what proofs look at to find their guesses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.symbolic.scene import LoadTable, Scene

Floats: TypeAlias = NDArray[np.float64]


class ArrayRows:
    """Of a centred scene with known loads.

    Attributes:
        length: by which moments are divided.
        rows: of each wheel along and across its friction axis, by ``(v, length omega)`` (2n, 3).
        speeds: their right sides (2n).
        friction: their coefficients of friction (2n).
    """

    def __init__(self, scene: Scene) -> None:
        places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
        grips = np.array([[float(x) for x in wheel.unit_grip] for wheel in scene.wheels])
        sides = np.stack([-grips[:, 1], grips[:, 0]], axis=1)
        normals = np.stack([grips, sides], axis=1).reshape(-1, 2)
        at = np.repeat(places, 2, axis=0)
        self.length = float(np.sqrt((places**2).sum(axis=1).mean())) or 1.0
        moments = (at[:, 0] * normals[:, 1] - at[:, 1] * normals[:, 0]) / self.length
        self.rows = np.column_stack([normals, moments])  # by (v, length omega)
        self.speeds = np.array([[float(x) for x in wheel.slip_speeds] for wheel in scene.wheels]).ravel()
        self.friction = np.array([[float(w.friction.roll), float(w.friction.side)] for w in scene.wheels]).ravel()
        self._forms = _load_forms(scene, places)

    def limits(self, place: Sequence[float]) -> Floats:
        """Largest friction force of each row with the body at a place."""
        return self.friction * np.repeat(self.loads(place), 2)

    def loads(self, place: Sequence[float]) -> Floats:
        """Of all wheels with the body at a place."""
        return np.asarray(self._forms @ np.array([1.0, *place]))

    @property
    def fastest(self) -> float:
        """Speed of the fastest row."""
        return float(np.abs(self.speeds).max())


def _load_forms(scene: Scene, places: Floats) -> Floats:
    """Loads as affine functions of the body's place, (n, 3)."""
    loads = scene.contact.loads
    if isinstance(loads, LoadTable):
        return np.array([[float(x) for x in row] for row in loads.rows])
    moments = np.column_stack([np.ones(len(places)), places])
    return moments @ np.linalg.pinv(moments.T @ moments)
