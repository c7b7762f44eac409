"""Filippov trajectories: one entry for every kind of field and method.

Event-driven simulation follows a solution from event to event instead of stepping over the switches: in closed form
where the twist is constant on polygons, by Taylor series where a plain system is affine in a cell, by DOP853 elsewhere.
Hysteresis and smoothing, which replace the discontinuity by a small width, are kept for comparison
(:mod:`nonsmooth.analysis.trajectories.hysteresis`).

Sources: Filippov 1988, "Differential equations with discontinuous righthand sides"; Stewart 1990 (high accuracy across
switches); Piiroinen & Kuznetsov 2008 (event-driven simulation of sliding).
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.fields.norm_zeros import NormField
from nonsmooth.analysis.fields.switched_field import FacedField, SwitchedField
from nonsmooth.analysis.trajectories.follow import Stepper
from nonsmooth.analysis.trajectories.piecewise_constant import follow_constant
from nonsmooth.analysis.trajectories.result import LyapunovWatch, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.smooth_path import FAR, MAX_EVENTS, MAX_WORK, FilippovFaces, near_rounding
from nonsmooth.symbolic.numbers.plane import dot, minus
from nonsmooth.symbolic.numbers.work_limit import WorkMeter


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
    if not field.size > 0 or FAR < max(map(abs, start)) < math.inf:
        raise TrajectoryError("required states within the range of floats")
    return follow_smooth(field, start, float(until), watch, meter=meter)


def follow_smooth(
    field: FacedField,
    start: Sequence[float],
    until: float,
    watch: LyapunovWatch | None = None,
    *,
    max_events: int = MAX_EVENTS,
    meter: WorkMeter | None = None,
    stepper: Stepper | None = None,
) -> Trajectory:
    """Follow a Filippov solution from a state at time zero.

    Args:
        field: the field.
        start: initial state.
        until: last time.
        watch: bound on V' to check every piece against.
        max_events: number of events after which the path ends in any case.
        meter: evaluations of fields after which the path ends in any case; None for :data:`MAX_WORK`.
        stepper: the method; None for DOP853, or Taylor series, and Radau where that is stiff, with tolerances near
            rounding.

    Raises:
        ValueError: for a start outside the domain.
        TrajectoryError: for a violated Lyapunov bound or a state without continuation.
    """
    kind = FilippovFaces
    if isinstance(field, NormField):
        from nonsmooth.analysis.trajectories.norm_path import FacesAndZeros

        kind = FacesAndZeros
    faces = kind(field, watch, meter or WorkMeter(MAX_WORK), max_events)
    return faces.path(start, until, stepper or near_rounding(field))


# ---- the watch on the distance from the checked point --------------------------------------------
#
# For ``V = |c - c*|^2`` the rate ``2 (c - c*) . c'`` equals ``2 (c - c*) . f(c*)`` on a cell, for both kinematics,
# because ``c . J c = 0`` removes the turning term.  It is linear in c, so its largest value on the closed cell is found
# at a vertex (:mod:`nonsmooth.analysis.cells.filippov`), and on an edge or a corner at one of the cells that meet
# there.


# Relative to the largest V: states and times err by a few 2^-53 per event, and V doubles that.
RISE_SLACK = 1e-12


def distance_watch(field: ConstantField) -> LyapunovWatch:
    """The watch on ``V = |c - c*|^2`` of a field that is constant on cells."""
    bounds = {
        name: max(_rates(field, cell, flow.velocity(field.centre)))
        for cell, name in enumerate(field.names)
        for flow in field.flows[cell][:1]
    }

    def value(state: Sequence[Any]) -> Any:
        away = minus((state[0], state[1]), field.centre)
        return dot(away, away)

    slack = 0 if field.exact else RISE_SLACK * (2 * field.cells.size) ** 2
    return LyapunovWatch(value, bounds, slack)


def _rates(field: ConstantField, cell: int, velocity: Point) -> Iterable[Any]:
    for vertex in field.cells.polygons[cell].vertices:
        yield 2 * dot(minus(vertex, field.centre), velocity)
