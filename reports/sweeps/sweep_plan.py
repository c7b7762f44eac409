"""The scenes of a sweep, by number: every combination of the values of its axes, or random draws within ranges.

Nothing is listed: the values of scene k follow from k, so a plan of 10^12 scenes costs nothing until it is run.
"""

from __future__ import annotations

import math
import random
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.reports.sweeps.values import Listed, Range, SweepError, Value, Values, WrittenValue, read_values
from nonsmooth.symbolic.files.key_paths import Path, find_path, path_text

DRAW_BITS = 20  # of a random share of a range: short fractions keep exact arithmetic fast
LARGE = 10**6  # scenes beyond which a sweep asks first
MAX_DRAWS = 10**12

Point: TypeAlias = tuple[Value | WrittenValue, ...]  # one value for each axis


@dataclass(frozen=True)
class Axis:
    """One number of the scene, and its values.

    Attributes:
        name: ``friction.mu_side``.
        path: where it stands in the document.
        values: a range or a list.
    """

    name: str
    path: Path
    values: Values


@dataclass(frozen=True)
class SweepPlan:
    """The scenes of a sweep.

    Attributes:
        axes: the numbers that vary; the last one varies fastest.
        draws: how many random scenes; None for every combination.
        seed: of the draws.
    """

    axes: tuple[Axis, ...]
    draws: int | None = None
    seed: int = 0

    @property
    def names(self) -> tuple[str, ...]:
        """The key paths."""
        return tuple(axis.name for axis in self.axes)

    @property
    def counts(self) -> tuple[int, ...]:
        """How many values each axis has, in a grid."""
        return tuple(axis.values.count or 0 for axis in self.axes)

    @property
    def size(self) -> int:
        """How many scenes."""
        return math.prod(self.counts) if self.draws is None else self.draws

    def point(self, k: int) -> Point:
        """The values of scene k, counted from 0."""
        return self._drawn(k) if self.draws is not None else self.at(self.places(k))

    def places(self, k: int) -> tuple[int, ...]:
        """Where scene k stands in the grid, along each axis."""
        found = []
        for count in reversed(self.counts):
            k, place = divmod(k, count)
            found.append(place)
        return tuple(reversed(found))

    def index(self, places: Sequence[int]) -> int:
        """The number of the scene at a place of the grid."""
        k = 0
        for count, place in zip(self.counts, places, strict=True):
            k = k * count + place
        return k

    def at(self, places: Sequence[int]) -> Point:
        """The values at a place of the grid."""
        return tuple(axis.values.value(place) for axis, place in zip(self.axes, places, strict=True))

    def _drawn(self, k: int) -> Point:
        """Draw k, which depends on the seed and on k alone: a longer sweep begins with the same scenes."""
        source = random.Random(f"{self.seed}:{k}")
        return tuple(_draw(axis.values, source) for axis in self.axes)


def _draw(values: Values, source: random.Random) -> Value | WrittenValue:
    """One of a list, or a rational number of a range."""
    if isinstance(values, Listed):
        return values.values[source.randrange(values.count)]
    return values.start.between(values.stop, Fraction(source.randrange((1 << DRAW_BITS) + 1), 1 << DRAW_BITS))


def read_plan(
    vary: Mapping[str, str], document: Mapping[str, Any], file: str, draws: int | None = None, seed: int = 0
) -> SweepPlan:
    """The plan of what a user wrote.

    Args:
        vary: values by key path, such as ``{"mu_side": "0.05:1:40"}``.
        document: the tables of the scene.
        file: the scene, for messages.
        draws: how many random scenes; None for every combination.
        seed: of the draws.

    Raises:
        SceneError: for a path that names no number of the scene.
        SweepError: for values that cannot be used.
    """
    if not vary:
        raise SweepError("vary: required a number to vary, such as mu_side=0.05:1:40, received none")
    axes = tuple(_axes(vary, document, file))
    names = [axis.name for axis in axes]
    twice = next((name for name in names if names.count(name) > 1), None)
    if twice is not None:
        raise SweepError(f"vary: required each number once, received {twice} twice")
    if draws is None:
        _require_counts(axes)
    else:
        _require_draws(axes, draws)
    return SweepPlan(axes, draws, seed)


def _axes(vary: Mapping[str, str], document: Mapping[str, Any], file: str) -> Iterator[Axis]:
    for name, text in vary.items():
        path = find_path(name, document, file)
        yield Axis(path_text(path, document), path, read_values(text, f"vary {name}"))


def _require_counts(axes: Sequence[Axis]) -> None:
    for axis in axes:
        if isinstance(axis.values, Range) and axis.values.count is None:
            raise SweepError(f"vary {axis.name}: required start:stop:count, or random draws, received start:stop")


def _require_draws(axes: Sequence[Axis], draws: int) -> None:
    if not 1 <= draws <= MAX_DRAWS:
        raise SweepError(f"random: required 1 to {MAX_DRAWS} draws, received {draws}")
    for axis in axes:
        if isinstance(axis.values, Range) and axis.values.count is not None:
            raise SweepError(f"vary {axis.name}: required start:stop for random draws, received start:stop:count")
