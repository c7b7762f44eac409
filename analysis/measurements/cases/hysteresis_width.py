"""Hysteresis with a width that goes to zero: the error of a late switch is proportional to it.

Every switch is late by the width, so a path is off by the width times an amplification that does not depend on it.
Small widths are followed for a shorter time, which keeps the number of switches bounded: 10^6 of them would take
minutes and show nothing more.  Widths that floats do not resolve must be refused.
"""

from __future__ import annotations

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.measurements.cases.followed_field import START, FollowedField, followed_fields
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.rows import EPSILON, Rows, counted, judged, refused
from nonsmooth.analysis.trajectories.hysteresis import RELATIVE_TOLERANCE, simulate_hysteresis
from nonsmooth.analysis.trajectories.result import EventKind
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.number_text import power_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import SwitchedSystem

CASE = "hysteresis width"
WIDTHS = (1e-1, 1e-2, 1e-3, 1e-4, 1e-6, 1e-9)  # in half-widths of the square
UNRESOLVED = 1e-19  # in half-widths: below the spacing of floats
LONGEST = 2_000  # widths that a path may cover: half as many switches where it slides
LATE = 10  # widths by which a path may be off per unit of amplification: late at every surface, and at its end


def hysteresis_rows(followed: FollowedField) -> Rows:
    """Paths with hysteresis against the event-driven ones, wider to narrower."""
    on_surface = _surface_start(followed)
    for width in WIDTHS:
        until = followed.span * min(1.0, LONGEST * width)
        start = followed.place(*START)
        if until < followed.span:
            start = on_surface
        length = width * followed.radius
        path, exact = simulate_hysteresis(followed.field, start, until, length), simulate(followed.field, start, until)
        growth = followed.amplification(start, until, length)
        error = followed.distance(path.end.state, exact.end.state)
        bound = LATE * growth * (width + RELATIVE_TOLERANCE * until / followed.span + EPSILON)
        verdict = counted(len(path.events), "switch")
        yield judged(CASE, power_text(width), verdict, error, bound, condition=growth, why="late by the width")
    try:
        path = simulate_hysteresis(followed.field, on_surface, followed.span, UNRESOLVED * followed.radius)
    except ValueError as refusal:
        yield refused(CASE, power_text(UNRESOLVED), refusal, expected=True)
    else:
        exact = simulate(followed.field, on_surface, followed.span)
        error = followed.distance(path.end.state, exact.end.state)
        verdict = counted(len(path.events), "switch")
        yield judged(CASE, power_text(UNRESOLVED), verdict, error, LATE * RELATIVE_TOLERANCE, why="its integrator")


def _surface_start(followed: FollowedField) -> tuple[float, ...]:
    """A start on a surface from which one path leads; a place of no symmetry where there is none.

    From a surface that repels, hysteresis may follow another solution than the one that is drawn.
    """
    for point, _ in followed.beside_surfaces():
        start = (*point.tolist(), *followed.place(0, 0)[2:])
        events = simulate(followed.field, start, followed.span).events
        if not any(event.kind is EventKind.NONUNIQUE and not event.t for event in events):
            return start
    return followed.place(*START)


def _scene_rows(scene: Scene | SwitchedSystem) -> Rows:
    for followed in followed_fields(scene, Kinematics.EXACT):
        yield from hysteresis_rows(followed)


HYSTERESIS = Case("hysteresis", array=_scene_rows, system=_scene_rows)
