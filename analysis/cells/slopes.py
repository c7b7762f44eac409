"""The slopes of D at one vertex of the arrangement: all of them in floats, and exactly the few that are asked for.

At rest all side rows hold, and two hundred of them span twenty thousand edges; yet a cell has a handful of sides.
Floats with a bound of their error leave out the slopes that are positive wherever it is asked, and propose the one
that falls most or cuts deepest; what decides is the exact form (:meth:`Arrangement.slopes_along`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from nonsmooth.analysis.cells.arrangement import Arrangement, SlopeOfD, minus
from nonsmooth.analysis.cells.loads import Affine
from nonsmooth.analysis.cells.nearest import SMALLEST_NORMAL
from nonsmooth.analysis.cells.outline import Filtered, Form, Three
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.symbolic.mechanics.contact_states import Triple, inner
from nonsmooth.symbolic.numbers.lazy import FLOAT_DOUBT
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Indices, Mask

MOST_TIGHT = 300  # rows that hold at one twist: their pairs times their number are held in memory, in floats
BLOCK = 256  # vectors whose products with the rows of all wheels are in the processor's cache together
SAME_DIRECTION = 2.0**-20  # of unit vectors: edges as close as this are compared exactly, others are kept apart
SHORTEST = 2.0**-30  # of the domain: sides that are shorter may be corners
WIDER = 1 + 2.0**-6  # than the square in which no slope vanishes, in floats: there one surely does
LEADING = 2.0**-10  # of a unit vector: its first entry beyond this is made positive

Corner: TypeAlias = tuple[float, float, int]  # and the number of the slope behind the side that starts there, or -1


class Slopes:
    """The slopes of D that can vanish in the load region, where the residuals of the rows have these signs.

    Nothing else of the twist and of the speeds counts.  Slopes 2k and 2k + 1 are those along direction k and back.

    Attributes:
        possible: numbers of the slopes that are not certainly positive all over the load region.

    Raises:
        RefusalError: for so many tight rows that the table would not fit into memory.
    """

    def __init__(self, arrangement: Arrangement, signs: Indices) -> None:
        self._arrangement, self._signs = arrangement, signs
        table = _PairTable(arrangement, signs)
        sure = certainty(table.values, table.bounds[:, None], arrangement.corners, arrangement.corner_sizes)
        possible: Mask = np.logical_or.reduce(~(sure > 1), axis=2)
        kept = table.distinct(np.logical_or.reduce(possible, axis=1).nonzero()[0])
        self._pairs: list[list[int]] = table.pairs.take(kept, 0).tolist()
        self._values = table.values.take(kept, 0).reshape(-1, 3)
        self._bounds = table.bounds.take(kept, 0).repeat(2, axis=0)
        self._numbers = arrangement.numbers(self._values)
        self.possible: list[int] = possible.take(kept, 0).ravel().nonzero()[0].tolist()
        self._known: dict[int, SlopeOfD] = {}

    def __len__(self) -> int:
        return len(self._values)

    def __getitem__(self, number: int) -> SlopeOfD:
        """A slope, of which the exact form is built once."""
        if number not in self._known:
            first, second = self._pairs[number // 2]
            self._known[number] = SlopeOfD(
                (first, second),
                1 - number % 2 * 2,
                self.filtered(number),
                lambda: self._built((first, second))[number % 2],
            )
        return self._known[number]

    def filtered(self, number: int) -> Filtered:
        """The same in floats or whole numbers."""
        values, error = self._numbers[number], self._arrangement.error
        sizes = self._bounds[number].tolist() if error else [*map(abs, values)]
        return Filtered.bounded(values, sizes, error)

    def _built(self, pair: tuple[int, int]) -> tuple[Affine, Affine]:
        return self._arrangement.slopes_along(pair, self._signs)

    def learn(self, slope: SlopeOfD, before: Form) -> SlopeOfD | None:
        """The slope back along the direction of another, along which D fell or kept until here; None where none is.

        Args:
            slope: the other.
            before: the slope of D along its direction before this vertex.
        """
        if list(slope.pair) not in self._pairs:
            return None
        back = self[2 * self._pairs.index(list(slope.pair)) + (slope.sense > 0)]
        if not slope.is_learned:  # it may be from this one
            back.build, back.is_learned = (lambda: minus(before.exact)), True
        return back

    def sides(self) -> list[int]:
        """Numbers of the slopes that seem to bound the cell, found by cutting the load region in floats."""
        outline: list[Corner] = [(x, y, -1) for _, x, y in self._arrangement.corners.tolist()]
        reach = self._arrangement.reach
        doubts = (self._bounds @ (reach * FLOAT_DOUBT)).tolist()
        for number in self.possible:
            a, b, c = self._numbers[number]
            values = [a + b * x + c * y for x, y, _ in outline]
            if min(values, default=0.0) < -doubts[number]:
                outline = _clipped(outline, values, number)
        around = zip(outline, [*outline[1:], *outline[:1]], strict=True)
        least = max(reach[1:].tolist()) * SHORTEST
        return sorted({k for (x, y, k), (u, v, _) in around if k >= 0 and abs(u - x) + abs(v - y) > least})

    def at(self, point: Floats, sizes: Floats | None = None) -> tuple[int | None, list[int]]:
        """At a point ``(1, x, y)``: the number of the slope that most certainly falls, and those that may vanish."""
        sure = certainty(self._values, self._bounds, point, sizes)
        (falling,) = (sure < -1).nonzero()
        steepest = int(falling[sure[falling].argmin()]) if falling.size else None
        return steepest, (~(np.abs(sure) > 1)).nonzero()[0].tolist()

    def first_to_vanish(self) -> list[int]:
        """Where none falls at the origin: numbers of the slopes that may vanish there, or before all others beside it.

        Squares about the origin are meant, that grow: the others are positive in a square where one of these is not.
        """
        everything = list(range(len(self)))
        positive = certainty(self._values, self._bounds, np.array([1.0, 0.0, 0.0])) > 1
        if not positive.any():
            return everything
        constants, *rates = np.abs(self._values[positive]).T
        with np.errstate(divide="ignore"):
            width = (constants / np.add(*rates)).min() * WIDER
        if not np.isfinite(width):
            return everything
        corners = np.array([(1.0, x, y) for x in (-width, width) for y in (-width, width)])
        sure = certainty(self._values, self._bounds, corners)
        is_beyond = bool((sure[positive] < -1).any())
        return np.flatnonzero(~(sure > 1).all(axis=1)).tolist() if is_beyond else everything

    @cached_property
    def flat(self) -> dict[int, SlopeOfD]:
        """Directions along which D does not change, whatever c, by number: twists that tie on the whole cell."""
        if self._arrangement.whole:
            return {k: self[k] for k, values in enumerate(self._numbers) if not any(values)}
        clear = np.abs(self._values) > self._bounds * FLOAT_DOUBT + SMALLEST_NORMAL
        return {k: self[k] for k in np.flatnonzero(~clear.any(axis=1)).tolist() if not any(self[k].exact)}


def certainty(values: Floats, bounds: Floats, points: Floats, sizes: Floats | None = None) -> Floats:
    """Affine forms at points ``(1, x, y)``, one column each, in units of the doubt: beyond one they are sure.

    Args:
        values: coefficients, the last axis of three.
        bounds: sums of absolute terms, which bound their errors.
        points: or positive multiples.
        sizes: bounds of the points' entries, where these err by as little of them.
    """
    doubt = bounds @ np.abs(points if sizes is None else sizes).T * FLOAT_DOUBT + SMALLEST_NORMAL
    return values @ points.T / doubt


class _PairTable:
    """All pairs of tight rows in floats: directions of edges, and the slopes along them and back, shape (m, 2, 3)."""

    def __init__(self, arrangement: Arrangement, signs: Indices) -> None:
        self.arrangement = arrangement
        (tight,) = (signs == 0).nonzero()  # few, most often: `take` is then much quicker than an index of numbers
        self.pairs = tight.take(_pairs(len(tight)))
        normals, weights = arrangement.normals, arrangement.float_weights
        first, second = self.pairs.T
        self.directions = arrangement.directions(first, second)
        self.sizes = arrangement.direction_sizes(first, second)
        rows, column = np.ascontiguousarray(normals.take(tight, 0).T), weights.take(tight, 0)
        parts = [np.abs(block @ rows) @ column for block in blocks(self.directions)]
        kept = np.concatenate(parts) if len(parts) > 1 else parts[0]
        along = self.directions @ ((normals.T * signs) @ weights)
        self.values = np.empty((len(kept), 2, 3))
        self.values[:, 0], self.values[:, 1] = kept + along, kept - along
        self.bounds = self.sizes @ arrangement.moment_sizes

    def distinct(self, numbers: Indices) -> Indices:
        """Of these pairs the first of each direction; none of those whose rows are parallel."""
        ways = self.arrangement.lines.ways(self.pairs.take(numbers, 0))
        if ways is not None:
            firsts: dict[Three, int] = {}
            for way, k in zip(ways, numbers.tolist(), strict=True):
                firsts.setdefault(way, k)
            firsts.pop((0, 0, 0), None)
            return np.array(list(firsts.values()), dtype=int)
        keys = self._keys(numbers)
        order = np.argsort(keys, kind="stable")
        ends = [0, *(np.flatnonzero(np.diff(keys[order])) + 1).tolist(), len(order)]
        others = [k for ends in pairwise(ends) for k in self._distinct_in(numbers[order[slice(*ends)]])]
        return np.array(sorted(others), dtype=int)

    def _has_direction(self, pair: int) -> bool:
        """Whether the rows of a pair are not parallel."""
        m, sizes = self.directions[pair].tolist(), self.sizes[pair].tolist()
        clear = (abs(x) > size * FLOAT_DOUBT + SMALLEST_NORMAL for x, size in zip(m, sizes, strict=True))
        return any(clear) or any(self._direction(pair))

    def _keys(self, numbers: Indices) -> Indices:
        """Whole numbers, equal for directions that differ in length alone; zero where a direction may vanish.

        Each is made of three of 21 bits; that others than such directions have the same costs time alone.
        """
        m = self.directions[numbers]
        lengths = np.abs(m).max(axis=1, keepdims=True)
        vanishing = lengths <= self.sizes[numbers].max(axis=1, keepdims=True) * FLOAT_DOUBT
        unit = np.divide(m, lengths, out=np.zeros_like(m), where=~vanishing)
        leading = np.take_along_axis(unit, np.argmax(np.abs(unit) > LEADING, axis=1)[:, None], axis=1)
        return np.rint(unit * np.sign(leading) / SAME_DIRECTION).astype(int) @ [1, 1 << 21, 1 << 42]

    def _distinct_in(self, bucket: Indices) -> Iterator[int]:
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
                    orthogonal[k] = not inner(self.arrangement.lines.normals[k], direction)
                bucket = bucket[~orthogonal[rows].all(axis=1)]

    def _direction(self, pair: int) -> Triple:
        first, second = self.pairs[pair].tolist()
        return self.arrangement.lines.edge((first, second))


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
def _pairs(count: int) -> Indices:
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
