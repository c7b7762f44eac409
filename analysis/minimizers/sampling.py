"""What is sampled in floats: twists and V* at points, the field on a grid, and two laws of feedback.

Rule ``nearest`` the slow literal way (wheel distances, greedy rows and a 3 x 3 solve at every sample) is the oracle
of the exact cells, with which the tests and the study ``precision`` compare them: it knows nothing of cells, bisectors
or fields, and no verdict uses it.  Rules without cells are evaluated by the numerical minimizer.  A sampled maximum is
a lower bound of the true one; it is reported as sampled, never as proved.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, contact_model
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer, minima_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import (
    Functional,
    Minima,
    Minimizer,
    free_motions,
    minima_without_proof,
    proved,
)
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane_arrays import (
    Floats,
    Mask,
    grid_points,
    norms,
    point_velocities,
    row_products,
    squared_norms,
    turned,
    unit_rows,
)

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


def _random_points(scene: Scene, samples: int) -> Floats:
    radius = scene.check.half_width
    return np.random.default_rng(0).uniform(-radius, radius, size=(samples, 2))


def _rates(points: Floats, twists: Floats) -> Floats:
    """``2 c . v``."""
    return 2 * row_products(twists[:, :2], points)


def _largest_rates(points: Floats, rates: Floats, not_certified: str = "") -> SampledDerivative:
    if not len(points):
        return SampledDerivative(0, None, None, None, not_certified)
    relative = rates / norms(points)
    best = int(np.argmax(relative))
    at = (points[best, 0], points[best, 1])
    return SampledDerivative(len(points), float(rates.max()), float(relative[best]), at, not_certified)


def literal_twist(model: ContactModel, point: Floats) -> Floats:
    """Twist of rule ``nearest`` at a point: wheels by distance, larger friction first, greedy to rank three."""
    return greedy_twist(model, np.argsort(norms(model.positions - point), kind="stable"))[0]


def literal_twists(scene: Scene, points: Floats) -> Floats:
    """:func:`literal_twist` at points (m, 2), shape (m, 3): once for all points with the same nearest wheels."""
    model = contact_model(scene)
    nearest = min(model.wheels, NEAREST)
    order = np.argsort(norms(points[:, None, :] - model.positions), axis=1, kind="stable")
    codes = order[:, :nearest] @ model.wheels ** np.arange(nearest)
    _, first, group = np.unique(codes, return_index=True, return_inverse=True)
    found = [greedy_twist(model, order[k]) for k in first]
    twists = np.array([twist for twist, _ in found])[group]
    for number in (k for k, (_, used) in enumerate(found) if used > nearest):  # wheels farther away decide
        members = np.flatnonzero(group == number)
        twists[members] = [greedy_twist(model, order[k])[0] for k in members]
    return twists


def greedy_twist(model: ContactRows, ordered: Iterable[int]) -> tuple[Floats, int]:
    """The twist that keeps the first three independent rows with friction, and how many wheels were asked for rows.

    It is not a number where no three are independent.
    """
    kept: list[int] = []
    for used, wheel in enumerate(ordered, 1):
        for row in sorted((2 * wheel, 2 * wheel + 1), key=lambda row: -model.friction[row]):  # the larger one first
            trial = [*kept, row]
            size = np.linalg.svd(model.rows[trial], compute_uv=False)[-1] if len(kept) < 3 else 0.0
            if model.friction[row] and size > RANK_TOLERANCE:
                kept = trial
        if len(kept) == 3:
            return np.asarray(np.linalg.solve(model.rows[kept], model.targets[kept])), used
    return np.full(3, np.nan), model.wheels


def sample_smooth_derivative(scene: Scene, samples: int) -> SampledDerivative:
    """Evaluate V* under the scene's rule without cells at random points of the checked square (centred scene).

    Where the minimizer is not unique V* is the largest rate over all of them.  Points at which the motion is not
    proved do not count.
    """
    free = free_motions(scene)
    if free:
        return SampledDerivative(0, None, None, None, free)
    points = _random_points(scene, samples)
    minima = minima_under(smooth_rule_of(scene), scene, points)
    rates = _rates(points, minima.twists)
    for k, face in minima.faces.items():
        rates[k] = (2 * face[:, :2] @ points[k]).max()
    found = proved(minima)
    return _largest_rates(points[found], rates[found], minima_without_proof(found))


# ---- the velocity field of a rule without cells at the points of a grid --------------------------
#
# In floats: sampled, and said to be.
#
# ``c' = v + omega J c`` by the minimizer of D at each point, each with the forces that prove it; where a minimizer is
# not unique or not proved the point has no velocity.


RESTS = 1e-9  # of the fastest velocity: slower is what rounding leaves of rest


@dataclass(frozen=True, eq=False)
class SampledField:
    """Velocities at ``count x count`` points of the checked square.

    Attributes:
        scene: the array; points in its coordinates.
        count: points in a row and in a column.
        points: positions of the centre of mass (m, 2), x first.
        velocities: ``c'`` (m, 2); not a number where the motion is not determined.
        rates: omega (m,).
    """

    scene: Scene
    count: int
    points: Floats
    velocities: Floats
    rates: Floats

    @property
    def speeds(self) -> Floats:
        """``|c'|`` (m,)."""
        return norms(self.velocities)

    @property
    def is_determined(self) -> Mask:
        """Where the motion is unique and proved (m,)."""
        return ~np.isnan(self.velocities[:, 0])

    @property
    def rests(self) -> Mask:
        """Where c stands still (m,)."""
        fastest = float(np.nanmax(self.speeds, initial=0.0))
        return self.is_determined & (self.speeds <= RESTS * fastest)

    @property
    def upper_derivative(self) -> Floats:
        """``V* = 2 (c - c*) . c'`` of ``V = |c - c*|^2`` (m,); zero where it is what rounding leaves of zero."""
        centre = np.array(self.scene.check.place)
        found = 2 * row_products(self.points - centre, self.velocities)
        least = RESTS * self.scene.check.half_width * float(np.nanmax(self.speeds, initial=0.0))
        return np.where(np.abs(found) <= least, 0.0, found)


def sample_field(scene: Scene, count: int) -> SampledField:
    """The field at an even grid over the checked square, its border included.

    Raises:
        TypeError: for a rule with cells.
        RefusalError: where some motion meets no friction, so that no velocity is determined.
    """
    free = free_motions(scene)
    if free:
        raise RefusalError(f"friction: required friction against every motion, received: {free}")
    centred, rule = scene.recentred(), smooth_rule_of(scene)
    radius = scene.check.half_width
    places = grid_points(*[np.linspace(-radius, radius, count)] * 2)
    minima = minima_under(rule, centred, places)
    velocities, omega = point_velocities(minima.twists, places), minima.twists[:, 2]
    unknown = ~proved(minima)
    unknown[list(minima.faces)] = True
    velocities[unknown], omega = np.nan, np.where(unknown, np.nan, omega)
    centre = np.array(scene.check.place)
    return SampledField(scene, count, places + centre, velocities, omega)


# ---- feedback under the rules ``box`` and ``ellipse`` --------------------------------------------
#
# Sampled: two laws, their worst rate of ``V = |c|^2 + theta^2``.
#
# The array is given with the length l of ``V = |c|^2 + l^2 theta^2`` for its unit.
#
# Under these rules the motion depends on all inputs at once, so no law can be read off a contact state.
#
# - *paper*: the nearest two wheels drive, ``u_i = |u_j| + k |c|``, ``u_j = -+k theta`` with the sign the cell needs;
# all
#   other wheels stand still and brake (Murphey & Burdick, sec. 3.3, signs corrected).
# - *tracking*: every rim moves as the wanted rigid motion would, ``u_i = d_i . (v + omega J(p_i - c))`` with the wanted
#   pose rate ``(v, omega) = -k (c, theta)``.
#
# Sampling proves nothing, in either sense: floats tell ``V' = 0`` from a small negative rate by a tolerance alone.
# A few rounds of random search around the worst states look between the samples.


GAIN = 1.0  # k, 1/time: the rate scales with it
SEARCH_ROUNDS = 4
SEARCH_BEST = 8  # worst states around which each round looks
SEARCH_TRIES = 8  # random states per worst state and round
# Relative to V: a minimizer with a duality gap of 1e-9 may err by its square root in the twist.
ZERO_RATE = 1e-4
RATE_NOISE = 1e-12  # of a sampled V'/V at gain one: less is noise


class SampledLaw(StrEnum):
    """A feedback law for all wheels at once."""

    PAPER = "paper, signs corrected"
    TRACKING = "twist tracking"


@dataclass(frozen=True)
class LoopSample:
    """Sampled closed loop of one law.

    Attributes:
        law: the law.
        states: how many states (c, theta) count: those at which the motion is proved.
        worst_rate: largest ``V'/V`` found (1/time at gain one); None where no state counts.
        worst_state: where.
        not_certified: what is missing, in words; empty where all states count.
    """

    law: SampledLaw
    states: int
    worst_rate: float | None
    worst_state: tuple[float, float, float] | None
    not_certified: str = ""

    @property
    def rate_text(self) -> str:
        """The rate in three digits; rounding noise is zero, and so is nothing."""
        rate = self.worst_rate or 0.0
        return float_text(rate, 3) if abs(rate) > RATE_NOISE else "0"

    def in_unit(self, length: float) -> LoopSample:
        """The same with its state in a unit of length of which the present one is so many."""
        if self.worst_state is None:
            return self
        x, y, theta = self.worst_state
        return replace(self, worst_state=(x * length, y * length, theta))

    @property
    def fails(self) -> bool | None:
        """Whether V does not fall at the worst state, as far as floats tell; None where there is none."""
        return None if self.worst_rate is None else self.worst_rate >= -ZERO_RATE


def sample_closed_loop(
    model: ContactModel, functional: Functional, law: SampledLaw, radius: float, samples: int
) -> LoopSample:
    """Largest ``V'/V`` over random states with ``|c|, |theta| <= radius``, refined by random search."""
    rng = np.random.default_rng(0)
    states = _random_states(rng, samples, radius)
    rates = relative_rates(model, functional, law, states)
    for k in range(SEARCH_ROUNDS):
        worst = states[np.argsort(np.where(np.isnan(rates), -np.inf, rates))[-SEARCH_BEST:]]
        spread = radius * 0.5 ** (k + 1)
        near = np.repeat(worst, SEARCH_TRIES, axis=0) + spread * rng.normal(size=(SEARCH_BEST * SEARCH_TRIES, 3))
        near = np.clip(near, -radius, radius)
        states = np.concatenate([states, near])
        rates = np.concatenate([rates, relative_rates(model, functional, law, near)])
    found = ~np.isnan(rates)
    missing = minima_without_proof(found)
    if not found.any():
        return LoopSample(law, 0, None, None, missing)
    best = int(np.nanargmax(rates))
    x, y, theta = (float(s) for s in states[best])
    return LoopSample(law, int(found.sum()), float(rates[best]), (x, y, theta), missing)


def _random_states(rng: np.random.Generator, samples: int, radius: float) -> Floats:
    """States of all sizes: logarithmic distances from the equilibrium, and the axes."""
    directions = unit_rows(rng.normal(size=(samples, 3)))
    states = directions * radius * 10 ** rng.uniform(-3, 0, size=(samples, 1))
    axes = radius * np.concatenate([np.eye(3), -np.eye(3), 0.1 * np.eye(3), -0.1 * np.eye(3)])
    return np.concatenate([axes, states])


def relative_rates(model: ContactModel, functional: Functional, law: SampledLaw, states: Floats) -> Floats:
    """``V'/V`` at states (m, 3), ``V' = 2 (c . c' + theta omega)``, at gain one; nan where no motion is proved.

    Since ``c . (v + omega J c) = c . v``, that is twice the product of state and twist; the largest of all minimizers.
    """
    speeds = _LAWS[law](model, states)
    minima = _minimizers(model, functional, states[:, :2], speeds)
    products = row_products(minima.twists, states)
    for k, face in minima.faces.items():
        products[k] = (face @ states[k]).max()
    return np.where(proved(minima), 2 * products / squared_norms(states), np.nan)


def paper_speeds(model: ContactModel, states: Floats) -> Floats:
    """``u_i = |u_j| + k |c|``, ``u_j = -sgn(d_j . J(p_j - p_i)) k theta``, zero elsewhere."""
    distances = np.linalg.norm(states[:, None, :2] - model.positions, axis=2)
    order = np.argsort(distances, axis=1)
    nearest, second = order[:, 0], order[:, 1]
    gap = model.positions[second] - model.positions[nearest]
    lever = model.rims[second, 1] * gap[:, 0] - model.rims[second, 0] * gap[:, 1]
    steering = -np.sign(lever) * GAIN * states[:, 2]
    speeds = np.zeros((len(states), model.wheels))
    rows = np.arange(len(states))
    speeds[rows, second] = steering
    speeds[rows, nearest] = np.abs(steering) + GAIN * norms(states)
    return speeds


def tracking_speeds(model: ContactModel, states: Floats) -> Floats:
    """``u_i = d_i . (v + omega J(p_i - c))`` for the wanted pose rate ``(v, omega) = -k (c, theta)``."""
    arms = model.positions - states[:, None, :2]
    turning = turned(arms) * states[:, None, 2:]
    return -GAIN * ((states[:, None, :2] + turning) * model.rims).sum(axis=-1)


_LAWS = {SampledLaw.PAPER: paper_speeds, SampledLaw.TRACKING: tracking_speeds}


def _minimizers(model: ContactModel, functional: Functional, points: Floats, speeds: Floats) -> Minima:
    """Minimizers at points with their own speeds."""
    minimizer: Minimizer = BoxHighs() if functional is Functional.BOX else EllipseMinimizer()
    return minimizer.minimize(model.with_targets(model.targets_of(speeds)), loads_at(model, points))
