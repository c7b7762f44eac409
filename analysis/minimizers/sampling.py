"""Twists and V* at points, in floats.

Rule ``nearest`` the slow literal way (wheel distances, greedy rows and a 3 x 3 solve at every sample) is the oracle
of the exact cells, with which the tests and the study ``precision`` compare them: it knows nothing of cells, bisectors
or fields, and no verdict uses it.  Rules without cells are evaluated by the numerical minimizer.  A sampled maximum is
a lower bound of the true one; it is reported as sampled, never as proved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.fields.plane_arrays import turned
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel

if TYPE_CHECKING:
    pass

RANK_TOLERANCE = 1e-9  # relative to the row norms: below it a row counts as dependent on the earlier ones
NEAREST = 6  # wheels by which points are grouped: three rows seldom need more than two


@dataclass(frozen=True)
class SampledDerivative:
    """Largest sampled value of V* and of ``V*/|c|``, with the sample that attains the latter.

    Attributes:
        samples: the points that count: those at which the motion is proved.
        largest: largest V*; None without such points.
        largest_relative: largest ``V*/|c|``.
        at: where.
        not_certified: what is missing, in words; empty where all points count.
    """

    samples: int
    largest: float | None
    largest_relative: float | None
    at: tuple[float, float] | None
    not_certified: str = ""


def sample_upper_derivative(scene: Scene, samples: int, seed: int = 0) -> SampledDerivative:
    """Evaluate ``2 c . v`` under rule ``nearest`` at random points of the checked square (centred scene)."""
    points = _random_points(scene, samples, seed)
    return _largest_rates(points, _rates(points, literal_twists(scene, points)))


def _random_points(scene: Scene, samples: int, seed: int) -> NDArray[np.float64]:
    radius = float(scene.check.radius)
    return np.random.default_rng(seed).uniform(-radius, radius, size=(samples, 2))


def _rates(points: NDArray[np.float64], twists: NDArray[np.float64]) -> NDArray[np.float64]:
    """``2 c . v``."""
    return np.asarray(2 * (twists[:, :2] * points).sum(axis=1))


def _largest_rates(
    points: NDArray[np.float64], rates: NDArray[np.float64], not_certified: str = ""
) -> SampledDerivative:
    if not len(points):
        return SampledDerivative(0, None, None, None, not_certified)
    relative = rates / np.hypot(*points.T)
    best = int(np.argmax(relative))
    at = (points[best, 0], points[best, 1])
    return SampledDerivative(len(points), float(rates.max()), float(relative[best]), at, not_certified)


def literal_twist(scene: Scene, point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Twist of rule ``nearest`` at a point: wheels by distance, larger friction first, greedy to rank three."""
    return greedy_twist(_by_distance(scene, point))[0]


def literal_twists(scene: Scene, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """:func:`literal_twist` at points (m, 2), shape (m, 3): once for all points with the same nearest wheels."""
    positions = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
    nearest = min(len(positions), NEAREST)
    distances = np.hypot(*(points[:, None, :] - positions).transpose(2, 0, 1))
    order = np.argsort(distances, axis=1, kind="stable")[:, :nearest]
    codes = order @ len(positions) ** np.arange(nearest)
    _, first, group = np.unique(codes, return_index=True, return_inverse=True)
    found = [greedy_twist(_by_distance(scene, points[k])) for k in first]
    twists = np.array([twist for twist, _ in found])[group]
    for number in (k for k, (_, used) in enumerate(found) if used > nearest):  # wheels farther away decide
        members = np.flatnonzero(group == number)
        twists[members] = [literal_twist(scene, points[k]) for k in members]
    return np.asarray(twists)


def _by_distance(scene: Scene, point: NDArray[np.float64]) -> list[Wheel]:
    """The wheels, the nearest first."""
    return sorted(scene.wheels, key=lambda w: np.hypot(*(point - [float(x) for x in w.position])))


def greedy_twist(ordered: Sequence[Wheel]) -> tuple[NDArray[np.float64], int]:
    """The twist that keeps the first three independent rows with friction, and how many wheels were asked for rows."""
    rows: list[NDArray[np.float64]] = []
    rhs: list[float] = []
    used = 0
    while len(rows) < 3:
        for normal, speed in _ordered_rows(ordered[used]):
            rank = np.linalg.matrix_rank(np.array([*rows, normal]), tol=RANK_TOLERANCE)
            if len(rows) < rank <= 3:
                rows.append(normal)
                rhs.append(speed)
        used += 1
    return np.asarray(np.linalg.solve(np.array(rows), np.array(rhs))), used


def _ordered_rows(wheel: Wheel) -> list[tuple[NDArray[np.float64], float]]:
    """The rows of a wheel that have friction, with their right-hand sides; the larger friction first."""
    p, a = (np.array([float(x) for x in v]) for v in (wheel.position, wheel.unit_grip))
    n, moved = turned(a), turned(p)
    along, across = (float(speed) for speed in wheel.slip_speeds)
    roll = float(wheel.friction.roll), np.append(a, a @ moved), along
    side = float(wheel.friction.side), np.append(n, n @ moved), across
    ordered = (side, roll) if side[0] > roll[0] else (roll, side)
    return [(normal, speed) for friction, normal, speed in ordered if friction]


def sample_smooth_derivative(scene: Scene, samples: int, seed: int = 0) -> SampledDerivative:
    """Evaluate V* under the scene's rule without cells at random points of the checked square (centred scene).

    Where the minimizer is not unique V* is the largest rate over all of them.  Points at which the motion is not
    proved do not count.
    """
    from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
    from nonsmooth.analysis.minimizers.minimum import free_motions, minima_without_proof, proved

    free = free_motions(scene)
    if free:
        return SampledDerivative(0, None, None, None, free)
    points = _random_points(scene, samples, seed)
    minima = minima_under(smooth_rule_of(scene), scene, points)
    rates = _rates(points, minima.twists)
    for k, face in minima.faces.items():
        rates[k] = (2 * face[:, :2] @ points[k]).max()
    found = proved(minima)
    return _largest_rates(points[found], rates[found], minima_without_proof(found))
