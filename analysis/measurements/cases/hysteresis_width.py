"""Hysteresis with a width that goes to zero: the error of a late switch is proportional to it.

Every switch is late by the width, so a path is off by the width times an amplification that does not depend on it.
Small widths are followed for a shorter time, which keeps the number of switches bounded: 10^6 of them would take
minutes and show nothing more.  Widths that floats do not resolve must be refused.
"""

from __future__ import annotations

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.cases.subject import START, Subject, array_subjects, system_subject
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import EPSILON, Rows, brief, counted, judged, refused
from nonsmooth.analysis.trajectories.hysteresis import RELATIVE_TOLERANCE, simulate_hysteresis
from nonsmooth.analysis.trajectories.result import EventKind
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.system import SystemScene

CASE = "hysteresis width"
WIDTHS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9)  # in half-widths of the square
UNRESOLVED = 1e-19  # in half-widths: below the spacing of floats
LONGEST = 2_000  # widths that a path may cover: half as many switches where it slides
LATE = 10  # widths by which a path may be off per unit of amplification: late at every surface, and at its end


def hysteresis_rows(subject: Subject) -> Rows:
    """Paths with hysteresis against the event-driven ones, wider to narrower."""
    on_surface = _surface_start(subject)
    for width in WIDTHS:
        until = subject.span * min(1.0, LONGEST * width)
        start = subject.place(*START)
        if until < subject.span:
            start = on_surface
        length = width * subject.radius
        path, exact = simulate_hysteresis(subject.field, start, until, length), simulate(subject.field, start, until)
        growth = subject.amplification(start, until, length)
        error = subject.error(path, exact.end.state)
        bound = LATE * growth * (width + RELATIVE_TOLERANCE * until / subject.span + EPSILON)
        verdict = counted(len(path.events), "switch")
        yield judged(CASE, brief(width), verdict, error, bound, condition=growth, why="late by the width")
    try:
        path = simulate_hysteresis(subject.field, on_surface, subject.span, UNRESOLVED * subject.radius)
    except ValueError as refusal:
        yield refused(CASE, brief(UNRESOLVED), refusal, expected=True)
    else:
        error = subject.error(path, simulate(subject.field, on_surface, subject.span).end.state)
        verdict = counted(len(path.events), "switch")
        yield judged(CASE, brief(UNRESOLVED), verdict, error, LATE * RELATIVE_TOLERANCE, why="its integrator")


def _surface_start(subject: Subject) -> tuple[float, ...]:
    """A start on a surface from which one path leads; a place of no symmetry where there is none.

    From a surface that repels, hysteresis may follow another solution than the one that is drawn.
    """
    for point, _ in subject.beside_surfaces():
        start = (*point.tolist(), *subject.place(0, 0)[2:])
        events = simulate(subject.field, start, subject.span).events
        if not any(event.kind is EventKind.NONUNIQUE and not event.t for event in events):
            return start
    return subject.place(*START)


def _array_rows(scene: Scene) -> Rows:
    for subject in array_subjects(scene, Kinematics.EXACT):
        yield from hysteresis_rows(subject)


def _system_rows(scene: SystemScene) -> Rows:
    return hysteresis_rows(system_subject(scene))


HYSTERESIS = Case("hysteresis", array=_array_rows, system=_system_rows)
