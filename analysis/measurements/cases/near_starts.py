"""Starts next to a switching surface, and next to the checked point.

A start closer than the slack is moved onto the surface, so paths may be off by the slack times their amplification.
Beside a repelling surface that is another solution: then the path has to say that it is not unique.
"""

from __future__ import annotations

import math

import numpy as np

from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.cases.followed_field import FollowedField, followed_fields, followed_system
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import EPSILON, ResultRow, Rows, asserted, judged
from nonsmooth.analysis.trajectories.result import EventKind, Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.number_text import power_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import SwitchedSystem

DISTANCES = (1e-9, 1e-12)  # in half-widths
ANGLES = (0.3, 1.9, 3.7, 5.1)  # directions from the checked point, radians
LEGS = 64  # roundings along a path
RESOLVED = 1e-3  # in half-widths: a larger bound asks nothing
WHY = "slack and rounding times amplification"
SAID = "the start counts as on a surface, and the path says at once that others leave it"


def start_rows(followed: FollowedField, case: str) -> Rows:
    """Paths from beside every surface (some of them) and from beside the checked point."""
    for number, (point, normal) in enumerate(followed.beside_surfaces(), 1):
        for distance in DISTANCES:
            side = 1 if number % 2 else -1
            move = side * normal
            parameter = f"surface {number}, {power_text(distance)}"
            yield _row(followed, case, parameter, point, distance * move)
    for angle in ANGLES:
        move = np.array([math.cos(angle), math.sin(angle)])
        parameter = f"{power_text(DISTANCES[-1])} at {angle} rad"
        yield _row(followed, case, parameter, np.array(followed.centre), DISTANCES[-1] * move)


def _row(followed: FollowedField, case: str, parameter: str, point: Floats, move: Floats) -> ResultRow:
    position = point + followed.radius * move
    start = (*position.tolist(), *followed.place(0, 0)[2:])
    reached = followed.reference.reached(start, followed.span)
    until, truth = (reached.time, reached.state) if reached.time > 0 else (followed.span, start)
    path = simulate(followed.field, start, until)
    error = followed.distance(path.end.state, truth)
    growth = followed.amplification(start, until, followed.slack)
    bound = 2 * growth * (followed.slack / followed.radius + LEGS * EPSILON) + followed.step_error
    row = judged(case, parameter, str(path.end.reason), error, bound, condition=growth, why=WHY)
    if (row.ok and bound <= RESOLVED) or not _starts_on_a_surface(path):
        return row
    said = "not unique, as it says"
    return asserted(case, parameter, said, SAID, ok=math.isfinite(error), error=error, condition=growth)


def _starts_on_a_surface(path: Trajectory) -> bool:
    """Whether the path says at its start that others leave it: the start counts as on a surface."""
    return any(event.kind is EventKind.NONUNIQUE and not event.t for event in path.events)


def _array_rows(scene: Scene) -> Rows:
    for kinematics, case in ((Kinematics.LEADING, "start, leading order"), (Kinematics.EXACT, "start, exact pose")):
        for followed in followed_fields(scene, kinematics):
            yield from start_rows(followed, case)


def _system_rows(scene: SwitchedSystem) -> Rows:
    return start_rows(followed_system(scene), "start")


STARTS = Case("starts", array=_array_rows, system=_system_rows)
