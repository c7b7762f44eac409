"""The largest V* of ``V = |c - c*|^2`` on the square: sampled, and at the vertices of the cells.

V* is linear on every closed cell, so its largest value is attained on a face: a vertex (codimension 2), an edge (1) or
a whole cell (0).  Of n random samples a share proportional to the k-th power of the distance comes that near to a face
of codimension k, so the nearest one is n^(-1/k) away and its value as much too small: slope -1/k.  However many samples
there are, the value is too small, so that no number of samples proves ``V* <= 0``.  A regular grid keeps half a spacing
from a vertex at the centre, slope -1/2 in its number of points; on an edge it depends on how the edge lies.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.filippov import cell_derivatives
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.study_plan import Assessment, LeftOut, Order, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene

Points = NDArray[np.float64]

SAMPLES = tuple(round(10**k) for k in (2, 2.5, 3, 3.5, 4, 4.5, 5, 5.5, 6))
SETS = 4  # of random samples: the mean of their errors scatters half as much as one
BLOCK, LARGE_BLOCK = 64, 1 << 15  # points between two looks at the clock; where no minimizer is sought


def build_upper_derivative(scene: Scene) -> StudyPlan:
    """The plan for the cells of the scene's contact rule.

    Raises:
        LeftOut: where the rule has no cells, hence no exact V*.
    """
    centred = scene.recentred()
    try:
        partition = build_partition(centred)
    except RefusalError as error:
        raise LeftOut(f"no exact V*: {error}") from None
    exact = largest_derivative(partition)
    trials = [Trial("exact cells", partial(_exactly, centred), partial(_judge_exactly, exact))]
    judge = partial(_judge, float(exact))
    for count in SAMPLES:
        work = partial(_sampled, centred, [partial(_random_points, count, seed) for seed in range(SETS)])
        trials.append(Trial("random samples", work, judge, "samples", count, repeats=SETS))
    for count in SAMPLES:
        side = 2 * round(count**0.5 / 2)  # even: the centre itself is no midpoint
        work = partial(_sampled, centred, [partial(_grid_points, side)])
        trials.append(Trial("grid of samples", work, judge, "samples", side**2))
    return StudyPlan(
        f"max V* at the vertices of {len(partition.cells)} closed cells, exact", tuple(trials), _orders(partition)
    )


UPPER_DERIVATIVE = Study(
    "upper-derivative",
    "upper derivative: largest V* on the square",
    "error of max V* [length²/time]",
    build_upper_derivative,
)


def largest_derivative(partition: Partition) -> Number:
    """The largest V* over all closed cells, exactly."""
    return max(derivative.largest[0] for derivative in cell_derivatives(partition))


def codimension_of_largest(partition: Partition) -> int:
    """2 where the largest V* is attained at vertices only, 1 on an edge, 0 on a cell."""
    largest = largest_derivative(partition)
    codimensions = []
    for derivative in cell_derivatives(partition):
        attained = sum(rate == largest for rate in derivative.rates)
        codimensions.append(0 if attained == len(derivative.rates) else 3 - min(attained, 2))
    return min(codimensions)


def _orders(partition: Partition) -> dict[str, Order]:
    codimension = codimension_of_largest(partition)
    if any(len(cell.states) > 1 for cell in partition.cells):
        tied = Order(None, "the rule ties: a sample sees one of several motions")
        return {"random samples": tied, "grid of samples": tied}
    if not codimension:
        all_of_it = Order(None, "the largest V* is attained on a whole cell, which every set of samples meets")
        return {"random samples": all_of_it, "grid of samples": all_of_it}
    place = "at vertices" if codimension == 2 else "along an edge"
    random = Order(-1 / codimension, f"the largest V* is attained {place} only")
    lies = Order(None, "a grid meets an edge, or keeps half a spacing from it, as the edge happens to lie")
    return {"random samples": random, "grid of samples": random if codimension == 2 else lies}


# ---- methods -------------------------------------------------------------------------------------


def _exactly(scene: Scene, clock: Clock) -> Number:
    return largest_derivative(build_partition(scene))


def _sampled(scene: Scene, sets: list[Callable[[float], Points]], clock: Clock) -> list[float]:
    """Largest sampled V* of each set of points."""
    rule = rule_of(scene)
    if not isinstance(rule, CellRule):
        raise TypeError(f"required a rule with cells, received {rule.name}")
    radius, block = float(scene.check.radius), LARGE_BLOCK if rule.functional is None else BLOCK
    found = []
    for points in (make(radius) for make in sets):
        largest = -np.inf
        for start in range(0, len(points), block):
            clock.check()
            part = points[start : start + block]
            largest = max(largest, float(2 * (rule.literal_twists(scene, part)[:, :2] * part).sum(axis=1).max()))
        found.append(largest)
    return found


def _random_points(count: int, seed: int, radius: float) -> Points:
    return np.random.default_rng([seed, count]).uniform(-radius, radius, (count, 2))


def _grid_points(side: int, radius: float) -> Points:
    """Midpoints of side x side squares."""
    middles = radius * ((2 * np.arange(side) + 1) / side - 1)
    return np.stack(np.meshgrid(middles, middles), axis=-1).reshape(-1, 2)


# ---- errors --------------------------------------------------------------------------------------


def _judge(exact: float, found: float | list[float]) -> Assessment:
    return Assessment(float(np.mean(np.abs(np.atleast_1d(found) - exact))))


def _judge_exactly(exact: Number, found: Number) -> Assessment:
    """Numbers of one scene, built twice: their difference in floats would hide what is left of it."""
    return Assessment(0.0 if found.field is exact.field and found == exact else abs(float(found) - float(exact)))
