"""400 measured pushes of a block on three known supports: models of friction, fitted, ranked, and what follows.

The table is ``data/pushes.csv``; the README beside it says where it is from.  Motions are ``(dx, dy, rho dtheta)`` and
wrenches ``(f_x, f_y, m/rho)``, so that both have one unit and their product is the power.  Each model predicts both
ways, the direction of the wrench from the motion and that of the motion from the wrench:

==============  ==========  ==============================================================================
name            fitted      what it says
==============  ==========  ==============================================================================
``naive``       nothing     the wrench is parallel to the motion
``isotropic``   nothing     point contacts at the supports, one friction in all directions, loads by statics
``ellipse``     2 numbers   the same with a friction ellipse: its ratio, and its direction in the block
``ellipsoid``   6 numbers   a limit surface of degree 2
``quartic``     15 numbers  a convex limit surface of degree 4
==============  ==========  ==============================================================================

Models with parameters are fitted log by log on four fifths of its pushes and judged on the last fifth, in turn, so that
no push is judged by a model that has seen it.  Intervals are those of a bootstrap of the median over all pushes
(resampled with replacement, percentiles), with a fixed seed.
"""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple, Protocol

import numpy as np
from scipy.optimize import minimize
from scipy.stats import bootstrap

from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.evidence.comparison import Comparison, Verdict
from tests.evidence.limit_surfaces import LimitSurface, fit_surface
from tests.evidence.pushed_body import Contacts

DATA = Path(__file__).parent / "data"
SOURCE = "Zhou, Paolini, Bagnell and Mason 2016 (arXiv 1602.06056), robinzhoucmu/Pushing, Apache-2.0"
CENTRE_OF_MASS = (0.05, 0.05)  # of the block, from its corner (metres)
RHO = 0.05 * math.sqrt(2)  # radius of gyration by which the source weighs moments (metres)
SUPPORTS = {  # from the corner (metres)
    1: ((0.03, 0.03), (0.06333, 0.04333), (0.04333, 0.06333)),
    2: ((0.01, 0.01), (0.01, 0.13), (0.13, 0.01)),
    3: ((0.03, 0.03), (0.09, 0.03), (0.03, 0.09)),
    4: ((0.01, 0.01), (0.09, 0.03), (0.01, 0.13)),
}
RATIOS = np.exp(np.linspace(-1.5, 1.5, 13))  # of the axes of a friction ellipse, tried before the search
DIRECTIONS = np.linspace(0, np.pi / 2, 7)[:-1]  # of its first axis; the rest is the same ellipse
FOLDS = 5
RESAMPLES = 2_000
CONFIDENCE = 0.95
SEED = 1602_06056

Interval = tuple[float, float]


# ---- the block and its pushes --------------------------------------------------------------------


class PushLog(NamedTuple):
    """The pushes of the block on one surface and one set of supports: motions (n, 3) and wrenches (n, 3) in newton."""

    surface: str
    support_set: int
    motions: Floats
    wrenches: Floats


def load_pushes() -> list[PushLog]:
    """The eight logs of fifty pushes, in the order of the table."""
    with (DATA / "pushes.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    logs = []
    for surface, number in dict.fromkeys((row["surface"], row["support_set"]) for row in rows):
        own = [row for row in rows if (row["surface"], row["support_set"]) == (surface, number)]
        motions, wrenches = (
            np.array([[float(row[key]) for key in keys] for row in own])
            for keys in (("dx_m", "dy_m", "dtheta_rad"), ("fx_N", "fy_N", "moment_over_rho_N"))
        )
        logs.append(PushLog(surface, int(number), motions * [1.0, 1.0, RHO], wrenches))
    return logs


def supports(support_set: int) -> Contacts:
    """The supports from the centre of mass, in units of rho, with the loads ``sum N_i = 1, sum N_i p_i = 0``."""
    points = np.array(SUPPORTS[support_set]) - np.array(CENTRE_OF_MASS)
    loads = np.linalg.solve(np.vstack([np.ones(3), points.T]), [1.0, 0.0, 0.0])
    return Contacts.isotropic(points / RHO, loads)


def angles(first: Floats, second: Floats) -> Floats:
    """Angles between vectors (n, 3), degrees; of a vector without direction 90."""
    sizes = np.linalg.norm(first, axis=1) * np.linalg.norm(second, axis=1)
    products = (first * second).sum(axis=1)
    cosines = np.divide(products, sizes, out=np.zeros(len(sizes)), where=sizes > 0)
    return np.asarray(np.degrees(np.arccos(np.clip(cosines, -1, 1))))


# ---- models of friction --------------------------------------------------------------------------


class Predictor(Protocol):
    """Predicts directions both ways."""

    def wrenches(self, motions: Floats) -> Floats:
        """Of motions (n, 3), up to their size."""

    def motions(self, wrenches: Floats) -> Floats:
        """Of wrenches (n, 3), up to their size."""


class Model(NamedTuple):
    """A model: its name, how many numbers are fitted, and how it is fitted to motions and wrenches of a log."""

    name: str
    parameters: int
    fit: Callable[[PushLog, Floats, Floats], Predictor]


class Parallel:
    """The wrench is parallel to the motion."""

    def wrenches(self, motions: Floats) -> Floats:
        return motions

    def motions(self, wrenches: Floats) -> Floats:
        return wrenches


class PointContacts(NamedTuple):
    """Friction of point contacts."""

    contacts: Contacts

    def wrenches(self, motions: Floats) -> Floats:
        return self.contacts.wrenches(motions)

    def motions(self, wrenches: Floats) -> Floats:
        return np.array([self.contacts.twist_of(wrench) for wrench in wrenches])


class Surface(NamedTuple):
    """Motions along the normals of a limit surface."""

    surface: LimitSurface

    def wrenches(self, motions: Floats) -> Floats:
        return self.surface.wrenches(motions)

    def motions(self, wrenches: Floats) -> Floats:
        return self.surface.gradients(wrenches)


def fit_ellipse(log: PushLog, motions: Floats, wrenches: Floats) -> PointContacts:
    """The friction ellipse whose wrenches are nearest on average: a grid, then a search from its best entry."""
    known = supports(log.support_set)

    def contacts(parameters: Floats) -> Contacts:
        """Half-axes 1 and a ratio, given by its logarithm, in axes turned by an angle."""
        log_ratio, turn = parameters
        c, s = np.cos(turn), np.sin(turn)
        return Contacts(known.points, known.loads, np.diag([1.0, np.exp(log_ratio)]) @ np.array([[c, s], [-s, c]]))

    def error(parameters: Floats) -> float:
        return float(angles(contacts(parameters).wrenches(motions), wrenches).mean())

    grid = [np.array([np.log(ratio), turn]) for ratio in RATIOS for turn in DIRECTIONS]
    options = {"xatol": 1e-4, "fatol": 1e-4}
    return PointContacts(contacts(minimize(error, min(grid, key=error), method="Nelder-Mead", options=options).x))


MODELS = (
    Model("naive", 0, lambda log, motions, wrenches: Parallel()),
    Model("isotropic", 0, lambda log, motions, wrenches: PointContacts(supports(log.support_set))),
    Model("ellipse", 2, fit_ellipse),
    Model("ellipsoid", 6, lambda log, motions, wrenches: Surface(fit_surface(2, motions, wrenches))),
    Model("quartic", 15, lambda log, motions, wrenches: Surface(fit_surface(4, motions, wrenches))),
)


# ---- their ranking -------------------------------------------------------------------------------


class Direction(StrEnum):
    """What is predicted from what."""

    WRENCH = "wrench from motion"
    MOTION = "motion from wrench"


class Ranked(NamedTuple):
    """The errors of one model in one direction, an angle in degrees for each push, and the interval of their median."""

    model: Model
    direction: Direction
    errors: Floats
    interval: Interval

    @property
    def median(self) -> float:
        """Of the errors, degrees."""
        return float(np.median(self.errors))


Ranking = Mapping[Direction, Sequence[Ranked]]


def rank(direction: Direction, models: Sequence[Model] = MODELS, logs: Sequence[PushLog] | None = None) -> list[Ranked]:
    """Models on the pushes of some logs, all eight unless given, the best median first."""
    chosen = load_pushes() if logs is None else logs
    ranked = []
    for model in models:
        errors = np.concatenate([errors_on(model, log, direction) for log in chosen])
        ranked.append(Ranked(model, direction, errors, median_interval(errors)))
    return sorted(ranked, key=lambda one: one.median)


def errors_on(model: Model, log: PushLog, direction: Direction) -> Floats:
    """Errors in degrees on the pushes of a log, shape (n,), each by a fit without it."""
    count = len(log.motions)
    if not model.parameters:
        return _errors(model, log, direction, np.ones(count, bool), np.ones(count, bool))
    errors = np.empty(count)
    fold = np.random.default_rng(SEED).permutation(count) % FOLDS
    for k in range(FOLDS):
        errors[fold == k] = _errors(model, log, direction, fold != k, fold == k)
    return errors


def _errors(model: Model, log: PushLog, direction: Direction, fitted: Floats, judged: Floats) -> Floats:
    predictor = model.fit(log, log.motions[fitted], log.wrenches[fitted])
    motions, wrenches = log.motions[judged], log.wrenches[judged]
    if direction is Direction.WRENCH:
        return angles(predictor.wrenches(motions), wrenches)
    return angles(predictor.motions(wrenches), motions)


def median_interval(errors: Floats) -> Interval:
    """Of the median of errors."""
    return _interval(np.median, errors)


def gap(better: Ranked, worse: Ranked) -> Interval:
    """How much the median of one model is above that of another: its interval over paired resamples."""

    def difference(first: Floats, second: Floats, axis: int = -1) -> Floats:
        return np.asarray(np.median(first, axis=axis) - np.median(second, axis=axis))

    return _interval(difference, worse.errors, better.errors)


def _interval(statistic: Callable[..., Floats], *samples: Floats) -> Interval:
    """Of a statistic of one sample, or of a pair of them."""
    found = bootstrap(
        samples,
        statistic,
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="percentile",
        paired=len(samples) > 1,
        vectorized=True,
        random_state=np.random.default_rng(SEED),
    ).confidence_interval
    return float(found.low), float(found.high)


# ---- what follows --------------------------------------------------------------------------------


def push_comparisons(ranking: Ranking) -> Iterator[Comparison]:
    """What the pushes say of the point contacts with nothing fitted, and of the source's own ranking."""
    for direction in Direction:
        yield _median(one_of(ranking, direction, "isotropic"), one_of(ranking, direction, "naive"))
    isotropic, ellipsoid, quartic = (
        one_of(ranking, Direction.MOTION, name) for name in ("isotropic", "ellipsoid", "quartic")
    )
    yield _order(quartic, ellipsoid, "a convex quartic predicts motions better than an ellipsoid")
    yield _order(isotropic, quartic, "known supports with nothing fitted predict motions better than a fitted quartic")


def one_of(ranking: Ranking, direction: Direction, name: str) -> Ranked:
    """One model of a ranking."""
    return next(one for one in ranking[direction] if one.model.name == name)


def _median(own: Ranked, naive: Ranked) -> Comparison:
    """The median angle beside that of a guess; it agrees where its interval lies below the guess's."""
    claim = f"{own.direction} of 400 pushes, point contacts: median angle between predicted and measured direction"
    verdict = Verdict.AGREES if own.interval[1] < naive.interval[0] else Verdict.MISSES
    witness = f"median within {interval_text(own.interval)}; the guess that they are parallel: "
    witness += float_text(naive.median, 3)
    return Comparison(claim, SOURCE, own.median, None, verdict, witness=witness, unit="deg")


def _order(better: Ranked, worse: Ranked, claim: str) -> Comparison:
    """Two medians in an order, with the interval of their difference."""
    interval, fitted = gap(better, worse), better.model.parameters
    verdict = Verdict.AGREES if interval[0] > 0 else Verdict.REFUTED
    witness = f"difference of medians within {interval_text(interval)} deg"
    medians = better.median, worse.median
    return Comparison(claim, SOURCE, *medians, verdict, witness=witness, unit="deg", fitted=fitted)


def interval_text(interval: Interval) -> str:
    """Both ends to three digits."""
    low, high = (float_text(value, 3) for value in interval)
    return f"{low} to {high}"
