"""The rows of an array and the limits of its friction forces, in floats: what proofs look at to find their guesses."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.minimizers.float_loads import affine_loads
from nonsmooth.symbolic.mechanics.scene import Scene

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
        model = contact_model(scene)
        self.length = float(np.sqrt((model.positions**2).sum(axis=1).mean())) or 1.0
        self.rows = model.rows / [1.0, 1.0, self.length]
        self.speeds, self.friction = model.targets, model.friction
        every = np.arange(model.wheels)
        self._forms = affine_loads(model, every) if model.load_table is None else model.load_table

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
