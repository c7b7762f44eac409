"""Models of friction ranked on the measured pushes, with bootstrap intervals.

Models with parameters are fitted log by log on four fifths of its pushes and judged on the last fifth, in turn, so that
no push is judged by a model that has seen it.  Intervals are those of a bootstrap of the median over all pushes
(resampled with replacement, percentiles), with a fixed seed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import StrEnum
from itertools import pairwise

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.pushes.measured_pushes import PushLog, angles, load_pushes
from nonsmooth.analysis.pushes.models import MODELS, Model

FOLDS = 5
RESAMPLES = 2_000
CONFIDENCE = 0.95
SEED = 1602_06056


class Direction(StrEnum):
    """What is predicted from what."""

    WRENCH = "wrench from motion"
    MOTION = "motion from wrench"


@dataclass(frozen=True, eq=False)
class Ranked:
    """The errors of one model in one direction.

    Attributes:
        model: which.
        direction: what is predicted.
        errors: angles in degrees, one for each push in the order of the logs.
        interval: of the median, at :data:`CONFIDENCE`.
    """

    model: Model
    direction: Direction
    errors: Floats
    interval: tuple[float, float]

    @property
    def median(self) -> float:
        """Of the errors, degrees."""
        return float(np.median(self.errors))


@dataclass(frozen=True)
class Difference:
    """How much a model's median is above that of the better one before it, with its interval over paired resamples."""

    better: Ranked
    worse: Ranked
    interval: tuple[float, float]

    @property
    def is_clear(self) -> bool:
        """Whether the interval leaves out zero."""
        return self.interval[0] > 0


def rank(
    direction: Direction,
    models: Sequence[Model] = MODELS,
    logs: Sequence[PushLog] | None = None,
) -> tuple[Ranked, ...]:
    """The models on the pushes of some logs, all eight unless given, the best median first.

    Args:
        direction: what is predicted from what.
        models: those to judge.
        logs: the pushes.
    """
    chosen = load_pushes() if logs is None else logs
    found = []
    for model in models:
        errors = np.concatenate([judged(model, log, direction) for log in chosen])
        found.append(Ranked(model, direction, errors, median_interval(errors)))
    return tuple(sorted(found, key=lambda one: one.median))


def differences(ranked: Sequence[Ranked]) -> tuple[Difference, ...]:
    """Each model against the one before it."""
    found = []
    for better, worse in pairwise(ranked):
        interval = _interval((worse.errors, better.errors), _difference_of_medians, paired=True)
        found.append(Difference(better, worse, interval))
    return tuple(found)


def judged(model: Model, log: PushLog, direction: Direction) -> Floats:
    """Errors in degrees on the pushes of a log, shape (n,), each by a fit without it."""
    if not model.parameters:
        return _errors(model, log, direction, np.ones(len(log), bool), np.ones(len(log), bool))
    errors = np.empty(len(log))
    fold = np.random.default_rng(SEED).permutation(len(log)) % FOLDS
    for k in range(FOLDS):
        errors[fold == k] = _errors(model, log, direction, fold != k, fold == k)
    return errors


def _errors(model: Model, log: PushLog, direction: Direction, seen: Floats, judged_on: Floats) -> Floats:
    predictor = model.fit(log, log.motions[seen], log.wrenches[seen])
    motions, wrenches = log.motions[judged_on], log.wrenches[judged_on]
    if direction is Direction.WRENCH:
        return angles(predictor.wrenches(motions), wrenches)
    return angles(predictor.motions(wrenches), motions)


def median_interval(errors: Floats) -> tuple[float, float]:
    """Of the median of errors."""
    return _interval((errors,), np.median, paired=False)


def _difference_of_medians(first: Floats, second: Floats, axis: int = -1) -> Floats:
    return np.asarray(np.median(first, axis=axis) - np.median(second, axis=axis))


def _interval(samples: tuple[Floats, ...], statistic: Callable[..., Floats], *, paired: bool) -> tuple[float, float]:
    from scipy.stats import bootstrap

    found = bootstrap(
        samples,
        statistic,
        n_resamples=RESAMPLES,
        confidence_level=CONFIDENCE,
        method="percentile",
        paired=paired,
        vectorized=True,
        random_state=np.random.default_rng(SEED),
    ).confidence_interval
    return float(found.low), float(found.high)
