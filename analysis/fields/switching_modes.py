"""Modes of a switched field as the comparison methods see them: where one is left, which follows, how they blend.

A mode is a sign pattern of a plain system or a cell of an array.  Its *margin* at a state is the distance to its
nearest surface, negative outside.  The comparison methods know nothing of sliding: they switch a little late
(hysteresis) or mix modes within a little of a surface (smoothing).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product
from typing import Any, Protocol, TypeAlias

import numpy as np

from nonsmooth.analysis.fields.cellwise_field import CellwiseField, smooth_form
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.smooth_field import Vector, Velocity
from nonsmooth.analysis.fields.switched_field import ConstantField

Mode: TypeAlias = Any  # a sign pattern or the number of a cell
AnyField: TypeAlias = ConstantField | CellwiseField | SignField


class Modes(Protocol):
    """What a comparison method needs of a switched field."""

    def initial(self, x: Vector) -> Mode | None:
        """The mode at a state; None outside the domain."""

    def margin(self, mode: Mode, x: Vector) -> float:
        """Signed distance from the border of a mode (units of the state), positive inside."""

    def following(self, mode: Mode, x: Vector, width: float) -> Mode | None:
        """The mode after one has been left by ``width``; None outside the domain."""

    def velocity(self, mode: Mode) -> Velocity:
        """The field of a mode."""

    def name(self, mode: Mode) -> str:
        """What the mode is called."""

    def blend(self, x: Vector, width: float) -> Iterator[tuple[Velocity, float]]:
        """Fields with convex weights that vary continuously over ``width`` to either side of a surface."""


def modes_of(field: AnyField) -> Modes:
    """The modes of any switched field."""
    if isinstance(field, SignField):
        return SignModes(field)
    return CellModes(smooth_form(field) if isinstance(field, ConstantField) else field)


@dataclass(frozen=True)
class SignModes:
    """Sign patterns: every switching function is a relay of its own."""

    field: SignField

    def _heights(self, x: Vector) -> list[float]:
        """Signed distances from the surfaces, to first order."""
        heights = []
        for surface in self.field.surfaces:
            gradient = surface.gradient(x)
            heights.append(surface.value(x) / (float(np.sqrt(gradient @ gradient)) or 1.0))
        return heights

    def initial(self, x: Vector) -> Mode | None:
        """Signs of the switching functions."""
        return self.field.signs_at(x)

    def margin(self, mode: Mode, x: Vector) -> float:
        """Smallest signed distance."""
        return min(sign * height for sign, height in zip(mode, self._heights(x), strict=True))

    def following(self, mode: Mode, x: Vector, width: float) -> Mode | None:
        """Relays that are beyond their width switch."""
        reached = 1 - 1e-9  # an event is found to rounding, so "beyond" allows for it
        heights = zip(mode, self._heights(x), strict=True)
        return tuple(-sign if sign * height <= -width * reached else sign for sign, height in heights)

    def velocity(self, mode: Mode) -> Velocity:
        """The field of a pattern."""
        return self.field.flow(mode)

    def name(self, mode: Mode) -> str:
        """The inequalities of a pattern."""
        pairs = zip(self.field.surfaces, mode, strict=True)
        return ", ".join(f"{surface.name} {'>' if sign > 0 else '<'} 0" for surface, sign in pairs)

    def blend(self, x: Vector, width: float) -> Iterator[tuple[Velocity, float]]:
        """Products of smoothed signs ``clip(h/width, -1, 1)``."""
        smoothed = [min(1.0, max(-1.0, height / width)) for height in self._heights(x)]
        for pattern in product((-1, 1), repeat=len(smoothed)):
            weight = float(np.prod([(1 + s * value) / 2 for s, value in zip(pattern, smoothed, strict=True)]))
            if weight:
                yield self.field.flow(pattern), weight


class CellModes:
    """Polygonal cells: a cell is left where the position is ``width`` outside it."""

    def __init__(self, field: CellwiseField) -> None:
        self.field = field
        sides = [(side, k) for k, polygon in enumerate(field.cells.polygons) for side in polygon.sides]
        self._normals = np.array([side.normal for side, _ in sides])
        self._offsets = np.array([side.offset for side, _ in sides])
        self._starts = np.flatnonzero(np.diff([-1] + [k for _, k in sides]))

    def _margins(self, x: Vector) -> Vector:
        """Signed distance of a position from the border of every cell."""
        return np.asarray(np.minimum.reduceat(self._offsets - self._normals @ x[:2], self._starts))

    def initial(self, x: Vector) -> Mode | None:
        """The cell that holds the position."""
        margins = self._margins(x)
        best = int(np.argmax(margins))
        return best if margins[best] >= 0 else None

    def nearest(self, x: Vector) -> Mode:
        """The cell that holds the position or, outside the domain, violates the least."""
        return int(np.argmax(self._margins(x)))

    def margin(self, mode: Mode, x: Vector) -> float:
        """Distance from the nearest side."""
        polygon = self.field.cells.polygons[mode]
        return min(side.offset - side.normal[0] * x[0] - side.normal[1] * x[1] for side in polygon.sides)

    def following(self, mode: Mode, x: Vector, width: float) -> Mode | None:
        """The cell that holds the position now."""
        return self.initial(x)

    def velocity(self, mode: Mode) -> Velocity:
        """The field of a cell."""
        return self.field.members[mode].velocity

    def name(self, mode: Mode) -> str:
        """The name of a cell."""
        return self.field.members[mode].name

    def blend(self, x: Vector, width: float) -> Iterator[tuple[Velocity, float]]:
        """Weights that fall from one to zero between ``width`` inside and ``width`` outside a cell, normalized.

        On the border of the domain, where nothing lies beyond, the cells inside keep all the weight.
        """
        margins = self._margins(x)
        shares = np.clip((margins + width) / (2 * width), 0.0, 1.0)
        if not shares.any():
            shares = (margins == margins.max()).astype(float)
        shares = shares / shares.sum()
        for k in np.flatnonzero(shares):
            yield self.field.members[k].velocity, float(shares[k])
