"""Paths followed for very long: a million crossings of the square, or as long as there are events left."""

from __future__ import annotations

import math

from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.cases.followed_field import START, FollowedField, followed_fields
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.references.taylor import Reached
from nonsmooth.analysis.measurements.rows import EPSILON, Rows, asserted, counted, judged
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.number_text import power_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import SwitchedSystem

LONG = "path followed for long"
SPANS, SMOOTH_SPANS = 1e6, 1e2  # duration of long paths, in times that it takes to cross the square


def long_rows(followed: FollowedField) -> Rows:
    """The scene's own path for a million crossings of the square, or as long as there are events left."""
    closed = isinstance(followed.field, ConstantField)
    spans = SPANS if closed else SMOOTH_SPANS
    start, until = followed.place(*START), spans * followed.span
    path = simulate(followed.field, start, until)
    verdict, parameter = f"{path.end.reason}, {counted(len(path.events), 'event')}", f"{power_text(spans)} crossings"
    if path.end.reason is EndReason.EVENTS:
        ok = all(math.isfinite(float(value)) for value in path.end.state)
        yield asserted(LONG, parameter, verdict, "a clear end: no endless loop, no invented limit", ok=ok)
        return
    reached, why = Reached(float(path.end.t), path.end.state), "it ends"
    if followed.reference.exact is not None:
        reached = followed.reference.reached(start, min(until, reached.time))
        why = "rounding of the time times the speed"
    growth = max(1.0, reached.time / followed.span)
    bound = 64 * EPSILON * growth + followed.slack / followed.radius + followed.step_error
    error = followed.distance(path.at(reached.time), reached.state)
    yield judged(LONG, parameter, verdict, error, bound, condition=growth, why=why)


def _scene_rows(scene: Scene | SwitchedSystem) -> Rows:
    for followed in followed_fields(scene, Kinematics.LEADING):
        yield from long_rows(followed)


SWITCHES = Case("switches", array=_scene_rows, system=_scene_rows)
