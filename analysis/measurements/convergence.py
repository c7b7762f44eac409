"""The slope of log(error) over log(setting): how fast a method converges.

A straight line fitted by least squares to the logarithms.  Errors at rounding level say nothing about convergence and
are left out; what remains must hold at least :data:`FEWEST` settings.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from nonsmooth.analysis.measurements.rows import ResultRow
from nonsmooth.analysis.measurements.study_plan import Order, StudyPlan

FEWEST = 4  # settings: fewer make no line


@dataclass(frozen=True)
class FittedSlope:
    """A fitted slope beside the expected one; ``value`` is None where too few errors are above rounding."""

    study: str
    method: str
    parameter: str
    value: float | None
    order: Order
    first: float | None = None
    last: float | None = None


def log_slope(settings: Sequence[float], errors: Sequence[float]) -> float:
    """Least-squares slope of log(error) over log(setting).

    Raises:
        ValueError: for fewer than two different settings.
    """
    xs, ys = [math.log(s) for s in settings], [math.log(e) for e in errors]
    if len(set(xs)) < 2:
        raise ValueError(f"required at least two different settings, received {sorted(set(settings))}")
    middle, height = sum(xs) / len(xs), sum(ys) / len(ys)
    spread = sum((x - middle) ** 2 for x in xs)
    return sum((x - middle) * (y - height) for x, y in zip(xs, ys, strict=True)) / spread


def fitted_slopes(study: str, plan: StudyPlan, rows: Iterable[ResultRow]) -> list[FittedSlope]:
    """The slope of every method of a study that has a setting."""
    known = [row for row in rows if row.name == study]
    slopes = []
    for method, order in plan.orders.items():
        own = [row for row in known if row.method == method]
        points = [(r.setting, r.error) for r in own if r.setting is not None and r.error is not None]
        parameter = next((r.parameter for r in own if r.parameter), "setting")
        slopes.append(_slope(study, method, parameter, order, [(s, e) for s, e in points if e > plan.rounding]))
    return slopes


def _slope(study: str, method: str, parameter: str, order: Order, points: list[tuple[float, float]]) -> FittedSlope:
    if len(points) < FEWEST:
        return FittedSlope(study, method, parameter, None, order)
    settings, errors = zip(*points, strict=True)
    return FittedSlope(study, method, parameter, log_slope(settings, errors), order, settings[0], settings[-1])
