"""Plain switched systems: one smooth field per sign pattern of some switching functions.

Assumed: on every surface the gradient of its function is nonzero.  ``sign(y**2 - x**2)`` has to be written as the
product ``sign(y - x) sign(y + x)``: a field may depend on its signs in any way.  Where several surfaces meet, a sign
pattern counts only if its tangent cone has points: four lines through the origin give eight cells there, not sixteen.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from itertools import combinations, product
from math import inf
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Face, Member, Surface, Velocity, sign_patterns, span
from nonsmooth.symbolic.numbers.plane_arrays import Floats

Signs: TypeAlias = tuple[int, ...]


class DegenerateSurfaceError(ValueError):
    """A switching function whose gradient vanishes on its surface."""


@dataclass(frozen=True, eq=False)
class SignField:
    """A plain switched system: switching functions and one smooth field per sign pattern.

    Attributes:
        states: names of the states.
        surfaces: the switching functions.
        flow: the field of a sign pattern (one sign -1 or 1 per surface).
        size: typical size of the states (their unit).
        unit: one, as states are given.
    """

    states: tuple[str, ...]
    surfaces: tuple[Surface, ...]
    flow: Callable[[Signs], Velocity]
    size: float = 1.0
    kinematics: str = "given"
    heading: int | None = None
    tied_members: frozenset[str] = frozenset()
    unit: float = 1.0
    _known: dict[tuple[object, ...], list[Face]] = field(default_factory=dict, init=False, repr=False)
    _members: dict[Signs, Member] = field(default_factory=dict, init=False, repr=False)

    def faces_at(self, x: Floats) -> list[Face]:
        """Faces at a state: every pattern of -, 0, + of the surfaces through it that has points there."""
        values = [surface.value(x) for surface in self.surfaces]
        near = [self._active(surface, x, value) for surface, value in zip(self.surfaces, values, strict=True)]
        active = tuple(k for k, close in enumerate(near) if close)
        sides = tuple(0 if close else (1 if v > 0 else -1) for v, close in zip(values, near, strict=True))
        patterns = sign_patterns([self.surfaces[k].normal(x) for k in active])
        key = (sides, patterns)
        if key not in self._known:
            self._known[key] = [self._face(_filled(sides, active, p), patterns, active) for p in patterns]
        return self._known[key]

    def has_contact(self, x: Floats) -> bool:
        """Whether curved surfaces touch at a state: their normals there are more than the dimensions they span.

        Where the normals span the whole space, the tangent cone of a pattern without points is empty with a margin.
        """
        if all(surface.flat for surface in self.surfaces):
            return False
        active = [s for s in self.surfaces if self._active(s, x, s.value(x))]
        subsets = (chosen for count in range(2, len(active) + 1) for chosen in combinations(active, count))
        return any(_touch(chosen, x) for chosen in subsets)

    def on_border(self, x: Floats) -> bool:
        """A plain system has no border."""
        return False

    def _active(self, surface: Surface, x: Floats, value: float) -> bool:
        """Whether a state is within the slack of a surface."""
        steepness = surface.steepness(x)
        if abs(value) > SURFACE_SLACK * self.size * steepness:
            return False
        if steepness <= SURFACE_SLACK:
            raise DegenerateSurfaceError(
                f"required a switching function with nonzero gradient where it vanishes, received {surface.name}: "
                "write a product as the product of the signs of its factors"
            )
        return True

    def _face(self, pattern: Signs, real: Sequence[Signs], active: Sequence[int]) -> Face:
        keep = tuple(surface for surface, side in zip(self.surfaces, pattern, strict=True) if not side)
        bounds = tuple((s, side) for s, side in zip(self.surfaces, pattern, strict=True) if side)
        around = [
            _filled(pattern, active, p)
            for p in real
            if 0 not in p and all(pattern[k] in (0, side) for k, side in zip(active, p, strict=True))
        ]
        name = ", ".join(f"{surface.name} = 0" for surface in keep) or self.mode_name(pattern)
        return Face(name, keep, bounds, tuple(self._member(signs) for signs in around))

    def _member(self, signs: Signs) -> Member:
        if signs not in self._members:
            self._members[signs] = Member(self.mode_name(signs), self.flow(signs))
        return self._members[signs]

    # ---- modes: every switching function is a relay of its own ---------------------------

    def mode_at(self, x: Floats) -> Signs:
        """Signs of the switching functions, 1 on a surface."""
        return tuple(-1 if surface.value(x) < 0 else 1 for surface in self.surfaces)

    def velocity(self, mode: Signs) -> Velocity:
        """The field of a pattern."""
        return self.flow(mode)

    def mode_name(self, mode: Signs) -> str:
        """The inequalities of a pattern."""
        return ", ".join(f"{s.name} {'>' if side > 0 else '<'} 0" for s, side in zip(self.surfaces, mode, strict=True))

    def margin(self, mode: Signs, x: Floats) -> float:
        """Smallest signed distance from a surface; infinite without surfaces."""
        return min((sign * height for sign, height in zip(mode, self._heights(x), strict=True)), default=inf)

    def following(self, mode: Signs, x: Floats, width: float) -> Signs:
        """Relays that are beyond their width switch; the farthest one always does.

        An event is found to rounding: relative to the width, and where the width is small beside the state, to that
        of the heights.
        """
        reached = 1 - 1e-9
        heights = [sign * height for sign, height in zip(mode, self._heights(x), strict=True)]
        beyond = max(-width, min(heights)) * reached
        return tuple(-sign if height <= beyond else sign for sign, height in zip(mode, heights, strict=True))

    def blend(self, x: Floats, width: float) -> Iterator[tuple[Velocity, float]]:
        """Products of smoothed signs ``clip(h/width, -1, 1)``."""
        smoothed = [min(1.0, max(-1.0, height / width)) for height in self._heights(x)]
        sides = [(round(value),) if abs(value) == 1 else (-1, 1) for value in smoothed]
        for pattern in product(*sides):
            weight = float(np.prod([(1 + s * value) / 2 for s, value in zip(pattern, smoothed, strict=True)]))
            if weight:
                yield self.flow(pattern), weight

    def _heights(self, x: Floats) -> list[float]:
        """Signed distances from the surfaces, to first order."""
        heights = []
        for surface in self.surfaces:
            gradient = surface.gradient(x)
            heights.append(surface.value(x) / (float(np.sqrt(gradient @ gradient)) or 1.0))
        return heights


def _touch(surfaces: Sequence[Surface], x: Floats) -> bool:
    """Whether the normals of surfaces, not all of them flat, span less than they may."""
    if all(surface.flat for surface in surfaces):
        return False
    rank = span(np.array([surface.normal(x) for surface in surfaces]).T).shape[1]
    return rank < min(len(surfaces), len(x))


def _filled(sides: Signs, active: Sequence[int], pattern: Signs) -> Signs:
    """A full pattern with the active entries replaced."""
    entries = dict(zip(active, pattern, strict=True))
    return tuple(entries.get(k, side) for k, side in enumerate(sides))
