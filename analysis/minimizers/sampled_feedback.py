"""Feedback under the rules ``box`` and ``ellipse``, sampled: two laws, their worst rate of ``V = |c|^2 + theta^2``.

The array is given with the length l of ``V = |c|^2 + l^2 theta^2`` for its unit.

Under these rules the motion depends on all inputs at once, so no law can be read off a contact state.

- *paper*: the nearest two wheels drive, ``u_i = |u_j| + k |c|``, ``u_j = -+k theta`` with the sign the cell needs; all
  other wheels stand still and brake (Murphey & Burdick, sec. 3.3, signs corrected).
- *tracking*: every rim moves as the wanted rigid motion would, ``u_i = d_i . (v + omega J(p_i - c))`` with the wanted
  pose rate ``(v, omega) = -k (c, theta)``.

Sampling proves nothing, in either sense: floats tell ``V' = 0`` from a small negative rate by a tolerance alone.
A few rounds of random search around the worst states look between the samples.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.fields.plane_arrays import turned
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.choice import Minimizer
from nonsmooth.analysis.minimizers.dissipation import Functional
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import Minima, minima_without_proof, proved
from nonsmooth.symbolic.numbers.number_text import float_text

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
    model: ContactModel, functional: Functional, law: SampledLaw, radius: float, samples: int, seed: int = 0
) -> LoopSample:
    """Largest ``V'/V`` over random states with ``|c|, |theta| <= radius``, refined by random search."""
    rng = np.random.default_rng(seed)
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
    directions = rng.normal(size=(samples, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    states = directions * radius * 10 ** rng.uniform(-3, 0, size=(samples, 1))
    axes = radius * np.concatenate([np.eye(3), -np.eye(3), 0.1 * np.eye(3), -0.1 * np.eye(3)])
    return np.concatenate([axes, states])


def relative_rates(model: ContactModel, functional: Functional, law: SampledLaw, states: Floats) -> Floats:
    """``V'/V`` at states (m, 3), ``V' = 2 (c . c' + theta omega)``, at gain one; nan where no motion is proved.

    Since ``c . (v + omega J c) = c . v``, that is twice the product of state and twist; the largest of all minimizers.
    """
    speeds = _LAWS[law](model, states)
    minima = _minimizers(model, functional, states[:, :2], speeds)
    products = (minima.twists * states).sum(axis=1)
    for k, face in minima.faces.items():
        products[k] = (face @ states[k]).max()
    return np.where(proved(minima), 2 * products / (states**2).sum(axis=1), np.nan)


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
    speeds[rows, nearest] = np.abs(steering) + GAIN * np.hypot(states[:, 0], states[:, 1])
    return speeds


def tracking_speeds(model: ContactModel, states: Floats) -> Floats:
    """``u_i = d_i . (v + omega J(p_i - c))`` for the wanted pose rate ``(v, omega) = -k (c, theta)``."""
    arms = model.positions - states[:, None, :2]
    turning = turned(arms) * states[:, None, 2:]
    return np.asarray(-GAIN * ((states[:, None, :2] + turning) * model.rims).sum(axis=-1))


_LAWS = {SampledLaw.PAPER: paper_speeds, SampledLaw.TRACKING: tracking_speeds}


def _minimizers(model: ContactModel, functional: Functional, points: Floats, speeds: Floats) -> Minima:
    """Minimizers at points with their own speeds."""
    minimizer: Minimizer = BoxHighs() if functional is Functional.BOX else EllipseMinimizer()
    return minimizer.minimize(model.with_targets(model.targets_of(speeds)), loads_at(model, points))
