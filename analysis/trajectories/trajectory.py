"""Filippov trajectories: one entry for every kind of field and method.

Event-driven simulation follows a solution from event to event instead of stepping over the switches: in closed form
where the twist is constant on polygons, by DOP853 with polished events elsewhere.  Hysteresis and smoothing, which
replace the discontinuity by a small width, are kept for comparison (:mod:`nonsmooth.analysis.trajectories.hysteresis`).

Sources: Filippov 1988, "Differential equations with discontinuous righthand sides"; Stewart 1990 (high accuracy across
switches); Piiroinen & Kuznetsov 2008 (event-driven simulation of sliding).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.fields.switched_field import SwitchedField
from nonsmooth.analysis.trajectories.lyapunov_watch import LyapunovWatch, distance_watch
from nonsmooth.analysis.trajectories.piecewise_constant import follow_constant
from nonsmooth.analysis.trajectories.result import Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.smooth_path import follow_smooth
from nonsmooth.symbolic.numbers.work_limit import WorkMeter

__all__ = ["SwitchedField", "simulate"]


def simulate(
    field: SwitchedField,
    start: Sequence[Any],
    until: Any | None = None,
    *,
    watch: LyapunovWatch | None = None,
    meter: WorkMeter | None = None,
) -> Trajectory:
    """Event-driven Filippov solution from a state at time zero.

    Args:
        field: constant twists on polygons (floats or exact numbers), or one smooth field per cell or sign pattern.
        start: initial state, ``(x, y, theta)`` for arrays.
        until: last time; None only for constant twists: to the rest, however long that takes.
        watch: certified bound on V'; None watches ``|c - c*|^2`` for constant twists.
        meter: work of several paths together, for fields that are not constant on cells; None for that of one.

    Raises:
        ValueError: for a start outside the domain, a last time that is not positive, or a smooth field without a
            finite one.
        nonsmooth.analysis.trajectories.result.TrajectoryError: for a violated Lyapunov bound or a state without
            continuation.
    """
    if until is not None and not until > 0:
        raise ValueError(f"required a positive last time, received {until}")
    if isinstance(field, ConstantField):
        return follow_constant(field, start, until, watch or distance_watch(field))
    if until is None or not math.isfinite(until):
        raise ValueError("required a finite last time for a field that is not constant on its cells")
    if not field.size > 0:
        raise TrajectoryError("required states within the range of floats")
    return follow_smooth(field, start, float(until), watch, meter=meter)
