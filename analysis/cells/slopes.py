"""The slopes of D at one vertex of the arrangement: all of them in floats, and exactly the few that are asked for.

At rest all side rows hold, and two hundred of them span twenty thousand edges; yet a cell has a handful of sides.
Floats with a bound of their error leave out the slopes that are positive wherever it is asked, and propose the one
that falls most or cuts deepest; what decides is the exact form (:meth:`Arrangement.slopes_along`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.arrangement import (
    Arrangement,
    SlopeOfD,
    beyond_floats,
    normal_floats,
)
from nonsmooth.analysis.cells.nearest import SMALLEST_NORMAL
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.symbolic.mechanics.constraints import Triple, inner
from nonsmooth.symbolic.numbers.lazy import FLOAT_DOUBT

MOST_TIGHT = 300  # rows that hold at one twist: their pairs times their number are held in memory, in floats
BLOCK = 256  # vectors whose products with the rows of all wheels are in the processor's cache together
SAME_DIRECTION = 2.0**-20  # of unit vectors: edges as close as this are compared exactly, others are kept apart
NEXT, AFTER = np.array([1, 2, 0]), np.array([2, 0, 1])  # the other coordinates, in turn
LEADING = 2.0**-10  # of a unit vector: its first entry beyond this is made positive

Floats = NDArray[np.float64]
Corner: TypeAlias = tuple[float, float, int]  # and the number of the slope behind the side that starts there, or -1


@dataclass(frozen=True)
class FloatForms:
    """Affine forms of c, rounded: coefficients (m, 3), and the sums of absolute terms that bound their errors."""

    values: Floats
    bounds: Floats

    @beyond_floats
    def certainty(self, points: Floats) -> Floats:
        """Values at points ``(1, x, y)``, one column each, in units of the doubt: beyond one they are sure."""
        doubt = self.bounds @ np.abs(points).T * FLOAT_DOUBT + SMALLEST_NORMAL
        return np.asarray(self.values @ points.T / doubt)

    def chosen(self, numbers: NDArray[np.int_]) -> FloatForms:
        """Some of them."""
        return FloatForms(self.values[numbers], self.bounds[numbers])


class Slopes:
    """The slopes of D that can vanish in the load region, where the residuals of the rows have these signs.

    Nothing else of the twist and of the speeds counts.  Slopes 2k and 2k + 1 are those along direction k and back.

    Attributes:
        possible: numbers of the slopes that are not certainly positive all over the load region.

    Raises:
        RefusalError: for so many tight rows that the table would not fit into memory.
    """

    def __init__(self, arrangement: Arrangement, signs: NDArray[np.int_]) -> None:
        self._arrangement, self._signs = arrangement, signs
        table = _PairTable(arrangement, signs)
        possible = ~(table.forms.certainty(arrangement.corners) > 1).all(axis=2)
        kept = table.distinct(possible.any(axis=1).nonzero()[0])
        self._pairs = table.pairs[kept]
        forms = table.forms.chosen(kept)
        self._forms = FloatForms(forms.values.reshape(-1, 3), forms.bounds.repeat(2, axis=1).reshape(-1, 3))
        self.possible: list[int] = possible[kept].ravel().nonzero()[0].tolist()
        self._exact: dict[int, SlopeOfD] = {}

    def __len__(self) -> int:
        return len(self._forms.values)

    def __iter__(self) -> Iterator[SlopeOfD]:
        return (self[k] for k in range(len(self)))

    def __getitem__(self, number: int) -> SlopeOfD:
        """The exact slope, built once."""
        if number not in self._exact:
            first, second = self._pairs[number // 2].tolist()
            both = self._arrangement.slopes_along((first, second), self._signs)
            for k, slope in enumerate(both, number - number % 2):
                self._keep(k, slope)
        return self._exact[number]

    def learn(self, slope: SlopeOfD) -> int | None:
        """Take over a slope that is known exactly, and its number here; None where it is none of these."""
        found = np.flatnonzero((self._pairs == slope.pair).all(axis=1)).tolist()
        if not found:
            return None
        number = 2 * int(found[0]) + (slope.direction != self._arrangement.edge(slope.pair))
        self._keep(number, slope)
        return number

    def _keep(self, number: int, slope: SlopeOfD) -> None:
        self._exact[number] = slope
        self._forms.values[number] = normal_floats(slope.form)
        self._forms.bounds[number] = np.abs(self._forms.values[number])

    def doubtful(self, points: Floats, among: Sequence[int]) -> list[int]:
        """Of these numbers those of the slopes that are not certainly positive at all points ``(1, x, y)``."""
        numbers = np.array(among, dtype=int)
        return numbers[~(self._forms.chosen(numbers).certainty(points) > 1).all(axis=1)].tolist()

    def sides_of(self, corners: Floats) -> list[int]:
        """Numbers of the slopes that seem to bound the cell in a polygon, found by the deepest cuts.

        What cuts nothing off cuts nothing off a part either, so that fewer and fewer are looked at.
        """
        outline: list[Corner] = [(x, y, -1) for _, x, y in corners.tolist()]
        numbers = np.array(self.possible, dtype=int)
        forms = self._forms.chosen(numbers)
        while len(outline) > 2:
            places = np.array([(1.0, x, y) for x, y, _ in outline])
            depths = forms.certainty(places).min(axis=1)
            (cutting,) = (depths < 0).nonzero()
            if not cutting.size:
                break
            deepest = cutting[depths[cutting].argmin()]
            outline = _clipped(outline, (places @ forms.values[deepest]).tolist(), int(numbers[deepest]))
            cutting = cutting[cutting != deepest]
            numbers, forms = numbers[cutting], forms.chosen(cutting)
        return sorted({k for *_, k in outline if k >= 0})

    def at(self, point: Floats) -> tuple[int | None, list[int]]:
        """At a point ``(1, x, y)``: the number of the slope that most certainly falls, and those that may vanish."""
        certainty = self._forms.certainty(point)
        (falling,) = (certainty < -1).nonzero()
        steepest = int(falling[certainty[falling].argmin()]) if falling.size else None
        return steepest, (~(np.abs(certainty) > 1)).nonzero()[0].tolist()

    @cached_property
    def flat(self) -> tuple[SlopeOfD, ...]:
        """Directions along which D does not change, whatever c: twists that tie on the whole cell."""
        clear = np.abs(self._forms.values) > self._forms.bounds * FLOAT_DOUBT + SMALLEST_NORMAL
        return tuple(self[k] for k in np.flatnonzero(~clear.any(axis=1)).tolist() if not any(self[k].form))


class _PairTable:
    """All pairs of tight rows in floats: directions of edges, and the slopes along them and back, shape (m, 2, 3)."""

    @beyond_floats
    def __init__(self, arrangement: Arrangement, signs: NDArray[np.int_]) -> None:
        self.arrangement = arrangement
        (tight,) = (signs == 0).nonzero()
        self.tight = len(tight)
        self.pairs = tight[_pairs(self.tight)]
        normals, weights = arrangement.normals, arrangement.float_weights
        first, second = normals[self.pairs.T]
        left, right = first[:, NEXT] * second[:, AFTER], first[:, AFTER] * second[:, NEXT]
        self.directions, self.sizes = left - right, np.abs(left) + np.abs(right)  # of the cross products
        rows = np.ascontiguousarray(normals[tight].T)
        kept = np.concatenate([np.abs(block @ rows) @ weights[tight] for block in blocks(self.directions)])
        along = self.directions @ ((normals.T * signs) @ weights)
        bounds = self.sizes @ arrangement.moment_sizes
        self.forms = FloatForms(np.stack([kept + along, kept - along], axis=1), bounds[:, None])

    def distinct(self, numbers: NDArray[np.int_]) -> NDArray[np.int_]:
        """Of these pairs the first of each direction; none of those whose rows are parallel."""
        if self.tight <= 3:
            return np.array([k for k in numbers.tolist() if self._has_direction(k)], dtype=int)
        keys = self._keys(numbers)
        order = np.argsort(keys, kind="stable")
        ends = [0, *(np.flatnonzero(np.diff(keys[order])) + 1).tolist(), len(order)]
        found = [k for ends in pairwise(ends) for k in self._distinct_in(numbers[order[slice(*ends)]])]
        return np.array(sorted(found), dtype=int)

    def _has_direction(self, pair: int) -> bool:
        """Whether the rows of a pair are not parallel."""
        m, sizes = self.directions[pair].tolist(), self.sizes[pair].tolist()
        clear = (abs(x) > size * FLOAT_DOUBT + SMALLEST_NORMAL for x, size in zip(m, sizes, strict=True))
        return any(clear) or any(self._direction(pair))

    def _keys(self, numbers: NDArray[np.int_]) -> NDArray[np.int_]:
        """Whole numbers, equal for directions that differ in length alone; zero where a direction may vanish.

        Each is made of three of 21 bits; that others than such directions have the same costs time alone.
        """
        m = self.directions[numbers]
        lengths = np.abs(m).max(axis=1, keepdims=True)
        vanishing = lengths <= self.sizes[numbers].max(axis=1, keepdims=True) * FLOAT_DOUBT
        unit = np.divide(m, lengths, out=np.zeros_like(m), where=~vanishing)
        leading = np.take_along_axis(unit, np.argmax(np.abs(unit) > LEADING, axis=1)[:, None], axis=1)
        return np.rint(unit * np.sign(leading) / SAME_DIRECTION).astype(int) @ [1, 1 << 21, 1 << 42]

    def _distinct_in(self, bucket: NDArray[np.int_]) -> Iterator[int]:
        """Pairs in which some row is not orthogonal to the directions before: so their own are others."""
        orthogonal = np.zeros(len(self.arrangement.rows), dtype=bool)
        while bucket.size:
            first, bucket = int(bucket[0]), bucket[1:]
            if self._has_direction(first):
                yield first
                if not bucket.size:
                    return
                direction, rows = self._direction(first), self.pairs[bucket]
                for k in np.flatnonzero(np.bincount(rows.ravel())).tolist():
                    orthogonal[k] = not inner(self.arrangement.rows[k].normal, direction)
                bucket = bucket[~orthogonal[rows].all(axis=1)]

    def _direction(self, pair: int) -> Triple:
        first, second = self.pairs[pair].tolist()
        return self.arrangement.edge((first, second))


def _clipped(outline: Sequence[Corner], values: Sequence[float], number: int) -> list[Corner]:
    """A polygon in floats where an affine form is non-negative, given at its corners; each names the side behind it."""
    found: list[Corner] = []
    for k, ((x, y, side), here) in enumerate(zip(outline, values, strict=True)):
        u, v, _ = outline[(k + 1) % len(outline)]
        after = values[(k + 1) % len(outline)]
        if here >= 0:
            found.append((x, y, side))
        if (here >= 0) != (after >= 0):
            t = here / (here - after)
            found.append((x + t * (u - x), y + t * (v - y), number if here >= 0 else side))
    return found


def blocks(vectors: Floats) -> list[Floats]:
    """Parts of a table (m, 3) that are small enough for products with the rows of all wheels to stay in the cache."""
    return [vectors[k : k + BLOCK] for k in range(0, max(len(vectors), 1), BLOCK)]


@lru_cache(16)
def _pairs(count: int) -> NDArray[np.int_]:
    """All pairs of so many rows, which span the directions of edges where they hold, shape (m, 2).

    Raises:
        RefusalError: for so many rows that the table of slopes would not fit into memory.
    """
    if count > MOST_TIGHT:
        raise RefusalError(
            f"wheels: required at most {MOST_TIGHT} rows that hold at one motion (at rest all side rows do), "
            f"received {count}"
        )
    return np.stack(np.triu_indices(count, 1), axis=1)
