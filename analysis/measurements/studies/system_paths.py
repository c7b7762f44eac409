"""Paths of plain systems: event-driven, hysteresis, smoothed and plain SciPy, against references at 60 digits.

The reference follows crossings by Taylor series (:mod:`nonsmooth.analysis.measurements.references.taylor`) and stops
where a path slides or meets a corner; states are compared at the time that it reaches.  Hysteresis is late by its width
at every switch, so its error is proportional to the width; a step across a switch errs by the tolerance; with events
every stretch is smooth.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from typing import TypeAlias

from nonsmooth.analysis.fields.sign_field import SignField, Signs
from nonsmooth.analysis.fields.switched_field import Vector, Velocity
from nonsmooth.analysis.measurements.cases.followed_field import FollowedField, followed_system
from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.references.reference_paths import STARTS
from nonsmooth.analysis.measurements.references.taylor import Reached
from nonsmooth.analysis.measurements.studies.trajectories import EVENT_TOLERANCES, SOLVERS, TOLERANCES, WIDTHS
from nonsmooth.analysis.measurements.study_plan import Assessment, LeftOut, Order, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed
from nonsmooth.analysis.trajectories.result import State, Trajectory
from nonsmooth.analysis.trajectories.smooth_path import follow_smooth
from nonsmooth.symbolic.switched_system import SwitchedSystem

COMPARED = 4  # of the starts that arrays have
SPANS = 4.0  # last time, in times in which a path crosses the square
LATE = "every switch is late by the width"
BLURRED = "a switch is early and late by the width, which cancels where the layer is crossed"
STRADDLED = "a step across a switch errs by the tolerance, whatever the order; where it falls scatters it"
STEPPED = "the field is smooth between events, so errors follow the tolerance of the steps"

Route: TypeAlias = tuple[tuple[float, ...], Reached]
Follow: TypeAlias = Callable[[tuple[float, ...], float, Clock], tuple[State, int]]


def build_system_paths(scene: SwitchedSystem) -> StudyPlan:
    """The plan for a planar system.

    Raises:
        LeftOut: where no reference gets on from any start.
    """
    followed = followed_system(scene)
    routes = list(_routes(followed))
    if not routes:
        raise LeftOut("no reference path: all starts slide, rest or lie on a surface at once")
    trials = tuple(
        Trial(method, partial(_follow_all, follow, routes), partial(_judge, followed, routes), parameter, setting)
        for method, follow, parameter, setting in _entrants(followed)
    )
    reference = f"{len(routes)} paths, at 60 digits or exact, to where they end or slide"
    crosses = followed.reference.exact is not None or any(reached.crossings for _, reached in routes)
    note = "" if crosses else "no reference path crosses a surface before it ends"
    return StudyPlan(reference, trials, _orders() if crosses else {}, note)


SYSTEM_PATHS = Study("paths", "paths: largest error of a state", "error of a state [half-widths]", build_system_paths)


def _orders() -> dict[str, Order]:
    named = {"hysteresis": Order(1.0, LATE), "smoothed": Order(None, BLURRED)}
    named["DOP853 with events"] = Order(None, STEPPED)
    return named | dict.fromkeys(SOLVERS, Order(None, STRADDLED))


def _routes(followed: FollowedField) -> Iterator[Route]:
    """Starts with where the reference gets to; those from which it gets nowhere are left out."""
    for a, b in STARTS[:COMPARED]:
        start = followed.place(a / 16, b / 16)
        try:
            reached = followed.reference.reached(start, SPANS * followed.span)
        except ValueError:  # on a surface
            continue
        if reached.time > 0:
            yield start, reached


def _entrants(followed: FollowedField) -> Iterator[tuple[str, Follow, str, float]]:
    """Methods with their settings, from easy to hard."""
    field, radius = followed.field, followed.radius
    if not isinstance(field, SignField):
        raise LeftOut("no field of signs")
    for tolerance in EVENT_TOLERANCES:
        yield "DOP853 with events", partial(_by_events, field, tolerance, radius), "tolerance", tolerance
    for method, simulated in (("hysteresis", simulate_hysteresis), ("smoothed", simulate_smoothed)):
        for width in (share * radius for share in WIDTHS):
            yield method, partial(_by_layer, simulated, field, width), "width", width
    for name in SOLVERS:
        for tolerance in TOLERANCES:
            yield name, partial(_without_events, field, name, tolerance, radius), "tolerance", tolerance


def _follow_all(follow: Follow, routes: Sequence[Route], clock: Clock) -> list[tuple[State, int]]:
    return [follow(start, reached.time, clock) for start, reached in routes]


def _judge(followed: FollowedField, routes: Sequence[Route], results: Sequence[tuple[State, int]]) -> Assessment:
    """The largest error over all starts."""
    pairs = zip(routes, results, strict=True)
    errors = [followed.distance(state, reached.state) for (_, reached), (state, _) in pairs]
    return Assessment(max(errors), {}, {"steps": sum(steps for _, steps in results)})


# ---- methods -------------------------------------------------------------------------------------


def _by_events(
    field: SignField, tolerance: float, radius: float, start: tuple[float, ...], until: float, clock: Clock
) -> tuple[State, int]:
    found = follow_smooth(_watched(field, clock), start, until, rtol=tolerance, atol=tolerance * radius)
    return found.at(until), len(found.times)


def _by_layer(
    simulated: Callable[[SignField, Sequence[float], float, float], Trajectory],
    field: SignField,
    width: float,
    start: tuple[float, ...],
    until: float,
    clock: Clock,
) -> tuple[State, int]:
    found = simulated(_watched(field, clock), start, until, width)
    return found.states[-1], len(found.times)


def _without_events(
    field: SignField, method: str, tolerance: float, radius: float, start: tuple[float, ...], until: float, clock: Clock
) -> tuple[State, int]:
    """SciPy's ``solve_ivp`` on the field as it stands, jumps and all."""
    from scipy.integrate import solve_ivp  # half a second that most commands need not wait

    def velocity(t: float, x: Vector) -> Vector:
        clock.check()
        return field.velocity(field.mode_at(x))(t, x)

    found = solve_ivp(velocity, (0.0, until), start, method, rtol=tolerance, atol=tolerance * radius)
    if found.status < 0:
        raise RuntimeError(found.message)
    return tuple(found.y[:, -1].tolist()), len(found.t)


def _watched(field: SignField, clock: Clock) -> SignField:
    """The same field, which looks at the clock at every evaluation."""

    def flow(signs: Signs) -> Velocity:
        return partial(_checked, field.flow(signs), clock)

    return replace(field, flow=flow)


def _checked(velocity: Velocity, clock: Clock, t: float, x: Vector) -> Vector:
    clock.check()
    return velocity(t, x)
