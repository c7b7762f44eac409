"""Paths in other units and far from the origin: lengths and speeds from 1e-9 to 1e9, arrays moved by up to 1e9.

A scaled field has scaled paths, so the error in half-widths must not depend on the scale.  A field moved away loses
the digits that its coordinates share: the condition is the distance in half-widths.
"""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.analysis.extremes.row import EPSILON, Rows, StressRow, brief, measured, refused
from nonsmooth.analysis.extremes.subject import START, Subject, array_subject, system_subject
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.partitions.contact_partition import build_partition
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.similar_scenes import moved, scaled, scaled_system
from nonsmooth.symbolic.switched_system import SwitchedSystem

POWERS = (-9, -6, -3, 3, 6, 9)  # of ten
OFFSETS = (3, 6, 9)  # powers of ten, in units of length
ROUNDINGS = 64  # along a path
BEYOND = 1e6  # half-widths: a start far outside


def array_scale_rows(scene: Scene) -> Rows:
    """An array in other units of length, and far from the origin."""
    for power in POWERS:
        yield _row("geometry scale, path", f"1e{power}", _array(scaled(scene, Fraction(10) ** power)))
    for power in OFFSETS:
        yield _row("far from the origin, path", f"1e{power}", _array(moved(scene, Fraction(10) ** power, Fraction(0))))
    yield outside_row(_array(scene))


def system_scale_rows(scene: SwitchedSystem) -> Rows:
    """A plain system in other units of length and of time."""
    for power in POWERS:
        yield _row(
            "state scale, path", f"1e{power}", system_subject(scaled_system(scene, length=Fraction(10) ** power))
        )
    for power in POWERS:
        faster = scaled_system(scene, speed=Fraction(10) ** power)
        yield _row("time scale, path", f"1e{power}", system_subject(faster))


def outside_row(subject: Subject) -> StressRow:
    """A start far outside the checked square has to be refused."""
    case, parameter = "start far outside", brief(BEYOND)
    try:
        path = simulate(subject.field, subject.place(BEYOND, 0.0), subject.span)
    except ValueError as refusal:
        return refused(case, parameter, refusal, expected=True)
    return StressRow(case, parameter, str(path.end.reason), None, None, False, "required a refusal")


def _array(scene: Scene) -> Subject:
    return array_subject(build_partition(scene), Kinematics.LEADING)


def _row(case: str, parameter: str, subject: Subject) -> StressRow:
    start = subject.place(*START)
    until, truth = subject.truth(start, subject.span)
    path = simulate(subject.field, start, until)
    offset = max(abs(x) for x in subject.centre) / subject.radius + 1
    growth = offset * subject.amplification(start, until, max(subject.slack, 1e-7 * subject.radius))
    bound = 2 * growth * (ROUNDINGS * EPSILON + subject.slack / subject.radius / offset) + subject.step_error
    why = "rounding and slack times amplification"
    return measured(case, parameter, str(path.end.reason), subject.error(path, truth), bound, condition=growth, why=why)
