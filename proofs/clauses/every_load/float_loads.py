"""Sets of loads in floats: the least of linear functions over them with bounds of their errors, and samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.load_sets import LoadPolytope, SpringLoads
from nonsmooth.symbolic.numbers.lazy import FLOAT_DOUBT

Floats: TypeAlias = NDArray[np.float64]

INSIDE = 2.0**-10  # part of the middle in samples: at a corner wheels carry nothing


@dataclass(frozen=True, eq=False)
class FloatLoads:
    """``sum_k weights_k centres_k`` over all convex weights, plus ``[-1, 1]`` times each generator.

    Attributes:
        centres: the corners of the set, or the centre of a zonotope, (m, n).
        generators: of the zonotope, (g, n); none where the set is the hull of its corners.
    """

    centres: Floats
    generators: Floats

    @property
    def sizes(self) -> Floats:
        """Bounds of the loads of all wheels, (n,)."""
        reach: Floats = np.abs(self.centres).max(axis=0) + np.abs(self.generators).sum(axis=0)
        return reach

    def lowest(self, prices: Floats) -> Floats:
        """The least ``sum prices_i N_i``, rounded; prices (..., n)."""
        values: Floats = (prices @ self.centres.T).min(axis=-1) - np.abs(prices @ self.generators.T).sum(axis=-1)
        return values

    def doubt(self, sizes: Floats) -> Floats:
        """A bound of the error of the least value where rounded prices are sums of terms of these sizes, (..., n)."""
        error: Floats = sizes @ self.sizes * FLOAT_DOUBT
        return error

    def samples(self, directions: Floats) -> Floats:
        """Loads close to the corners at which linear functions (k, n) are least; under them every wheel carries."""
        ends = self.centres[np.argmin(directions @ self.centres.T, axis=1)]
        ends = ends - np.sign(directions @ self.generators.T) @ self.generators
        middle = self.centres.mean(axis=0)
        return np.unique((1 - INSIDE) * ends + INSIDE * middle, axis=0)


def float_loads(loads: LoadPolytope) -> FloatLoads:
    """A set of loads, each number rounded once."""
    count = len(loads.middle)
    generators = loads.generators if isinstance(loads, SpringLoads) else ()
    corners = (loads.centre,) if isinstance(loads, SpringLoads) else loads.corners or ()
    return FloatLoads(_array(corners, count), _array(generators, count))


def _array(rows: tuple[tuple[object, ...], ...], count: int) -> Floats:
    return np.array([[float(x) for x in row] for row in rows]).reshape(-1, count)  # type: ignore[arg-type]
