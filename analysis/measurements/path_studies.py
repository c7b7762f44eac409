"""The studies of ``precision`` that follow paths: from a scene to a reference, trials and the slopes that are expected.

Trajectories of arrays and paths of plain systems by the same methods.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.constant_field import CellwiseField, ConstantField, smooth_form
from nonsmooth.analysis.fields.polygon_field import PolygonField
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import Member, Velocity
from nonsmooth.analysis.measurements.harness import Assessment, Clock, LeftOut, Order, Study, StudyPlan, Trial
from nonsmooth.analysis.measurements.reference_paths import (
    STARTS,
    MeasuredField,
    ReferenceEnd,
    measured_system,
    reference_paths,
)
from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed
from nonsmooth.analysis.trajectories.result import Event, State, Trajectory
from nonsmooth.analysis.trajectories.steppers import StiffAware
from nonsmooth.analysis.trajectories.trajectory import follow_smooth, simulate
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

# ---- paths ---------------------------------------------------------------------------------------
#
# What theory predicts of the largest distance from the path:
# - hysteresis and smoothing replace a switch by a layer of the width w: the distance is proportional to w, slope 1;
# - a Runge-Kutta method whose step straddles a switch makes a local error of (jump) x (step), whatever its order; step
#   control shrinks that step until the error is the tolerance (Hairer, Norsett & Wanner 1993, sec. II.6), and along a
#   slide it does so at every step: slope 1 in the tolerance, while the number of steps grows like its inverse;
# - with events every stretch is smooth, and where the field is constant between them every step is exact.

WIDTHS = tuple(10**-k for k in (1.5, 2, 2.5, 3, 3.5))  # in units of the half-width of the square
TOLERANCES = tuple(10**-k for k in (2, 2.5, 3, 3.5, 4, 4.5, 5))  # relative; absolute in units of the half-width
EVENT_TOLERANCES = tuple(10.0**-k for k in (3, 5, 7, 9, 11))
EXACT, BY_EVENTS = "events, exact numbers", "DOP853 with events"
LAYERS = {"hysteresis": simulate_hysteresis, "smoothed": simulate_smoothed}
SOLVERS = ("RK45", "DOP853")
STRADDLED = Order(1.0, "a step across a switch errs by the tolerance, whatever the order; where it falls scatters it")
ORDERS = {
    **dict.fromkeys(LAYERS, Order(1.0, "a switch becomes a layer as thick as the width")),
    BY_EVENTS: Order(None, "the field is constant between events, so every step is exact whatever the tolerance"),
    **dict.fromkeys(SOLVERS, STRADDLED),
}
SYSTEM_ORDERS = {
    "hysteresis": Order(1.0, "every switch is late by the width"),
    "smoothed": Order(None, "a switch is early and late by the width, which cancels where the layer is crossed"),
    BY_EVENTS: Order(None, "the field is smooth between events, so errors follow the tolerance of the steps"),
    **dict.fromkeys(SOLVERS, Order(None, STRADDLED.why)),
}
SYSTEM_STARTS = STARTS[:4]
SPANS = 4.0  # last time of a system's path, in times in which a path crosses the square

Start: TypeAlias = tuple[float, ...]
Simulator: TypeAlias = Callable[[Any, Start, float], Trajectory]


@dataclass(frozen=True)
class MethodPath:
    """A path as a method leaves it, without events where the method does not look for them."""

    times: Sequence[Any]
    states: Sequence[State]
    steps: int
    events: Sequence[Event] = ()


Follow: TypeAlias = Callable[[Start, float, Clock], MethodPath]
Method: TypeAlias = tuple[str, Follow, str | None, float | None]  # its name, the method, its setting by name and value


def build_trajectories(scene: Scene) -> StudyPlan:
    """Paths of an array against exact ones; event times are compared where a path first meets the same edges.

    Raises:
        LeftOut: where the rule has no cells, hence no exact paths, and where no start has only one path.
    """
    try:
        partition = build_partition(scene)
    except RefusalError as error:
        raise LeftOut(f"no exact paths: {error}") from None
    field, paths = reference_paths(partition)
    if not paths:
        raise LeftOut("no exact paths: from each start several paths begin")

    def judge(method: str, results: Sequence[MethodPath]) -> Assessment:
        pairs = list(zip(paths, results, strict=True))
        details = {"end": max(path.error_at(r.times[-1], r.states[-1]) for path, r in pairs)}
        late = (path.event_error(result.events) for path, result in pairs)
        known = [error for error in late if error is not None]
        details |= {"event time": max(known)} if known else {}
        note = "the reference, found again" if method == EXACT else ""
        error = max(path.path_error(r.times, r.states) for path, r in pairs)
        return Assessment(error, details, {"steps": sum(r.steps for r in results)}, note)

    methods: list[Method] = [
        (EXACT, partial(_in_closed_form, field), None, None),
        ("events, closed form", partial(_in_closed_form, field.floats()), None, None),
        *_methods(smooth_form(field), field, scene.check.half_width),
    ]
    switching = sum(bool(path.events) for path in paths)
    note = "" if switching else "no path meets a switch: every method follows one smooth motion"
    reference = f"exact paths from {len(paths)} starts, leading-order kinematics, exact numbers"
    trials = _path_trials(methods, [(path.start, path.until) for path in paths], judge)
    return StudyPlan(reference, trials, ORDERS if switching else {}, note)


def build_system_paths(scene: SwitchedSystem) -> StudyPlan:
    """Paths of a plain system in two states, each compared at the last time that its reference reaches.

    Raises:
        LeftOut: where no reference gets on from any start.
    """
    measured = measured_system(scene)
    if not isinstance(measured.field, SignField):
        raise LeftOut("no field of signs")
    routes = list(_routes(measured))
    if not routes:
        raise LeftOut("no reference path: all starts slide, rest or lie on a surface at once")

    def judge(method: str, results: Sequence[MethodPath]) -> Assessment:
        ends = zip(results, routes, strict=True)
        error = max(measured.distance(result.states[-1], reached.state) for result, (_, reached) in ends)
        return Assessment(error, work={"steps": sum(result.steps for result in results)})

    methods = _methods(measured.field, measured.field, measured.radius)
    trials = _path_trials(methods, [(start, reached.time) for start, reached in routes], judge)
    reference = f"{len(routes)} paths, at 60 digits or exact, to where they end or slide"
    crosses = measured.exact is not None or any(reached.crossings for _, reached in routes)
    note = "" if crosses else "no reference path crosses a surface before it ends"
    return StudyPlan(reference, trials, SYSTEM_ORDERS if crosses else {}, note)


def _routes(measured: MeasuredField) -> Iterator[tuple[Start, ReferenceEnd]]:
    """Starts with where the reference gets to; those from which it gets nowhere are left out."""
    for a, b in SYSTEM_STARTS:
        start = measured.place(a / 16, b / 16)
        try:
            reached = measured.reached(start, SPANS * measured.span)
        except ValueError:  # on a surface
            continue
        if reached.time > 0:
            yield start, reached


def _methods(smooth: CellwiseField | SignField, field: PolygonField | SignField, radius: float) -> Iterator[Method]:
    """The methods that both kinds of fields have, with their settings from easy to hard."""
    import scipy.integrate  # noqa: F401  # now, so that no measured time includes it

    for tolerance in EVENT_TOLERANCES:
        by_events = partial(_by_events, tolerances=(tolerance, tolerance * radius))
        yield BY_EVENTS, partial(_simulated, by_events, smooth), "tolerance", tolerance
    for name, with_layers in LAYERS.items():
        for width in (share * radius for share in WIDTHS):
            yield name, partial(_simulated, partial(with_layers, width=width), smooth), "width", width
    for name in SOLVERS:
        for tolerance in TOLERANCES:
            both = (tolerance, tolerance * radius)
            yield name, partial(follow_without_events, field, name, both), "tolerance", tolerance


def _by_events(
    field: CellwiseField | SignField, start: Start, until: float, tolerances: tuple[float, float]
) -> Trajectory:
    """The path with tolerances of its integrator, relative and absolute."""
    return follow_smooth(field, start, until, stepper=StiffAware(*tolerances, field.size))


def _path_trials(
    methods: Iterable[Method],
    routes: Sequence[tuple[Start, float]],
    judge: Callable[[str, Sequence[MethodPath]], Assessment],
) -> tuple[Trial, ...]:
    """Each trial follows the paths from all starts."""

    def work(follow: Follow, clock: Clock) -> list[MethodPath]:
        return [follow(start, until, clock) for start, until in routes]

    return tuple(
        Trial(name, partial(work, follow), partial(judge, name), parameter, setting)
        for name, follow, parameter, setting in methods
    )


def _in_closed_form(field: ConstantField, start: Start, until: float, clock: Clock) -> MethodPath:
    """From event to event of a field that is constant on polygons."""
    found = simulate(field, start, until)
    return MethodPath(found.times, found.states, len(found.pieces), found.events)


def _simulated(
    simulator: Simulator, field: CellwiseField | SignField, start: Start, until: float, clock: Clock
) -> MethodPath:
    """One of the program's own integrators; the field looks at the clock at every evaluation."""

    def watched(velocity: Velocity) -> Velocity:
        def watching(t: float, x: Floats) -> Floats:
            clock.check()
            return velocity(t, x)

        return watching

    if isinstance(field, SignField):
        flow = field.flow
        found = simulator(replace(field, flow=lambda signs: watched(flow(signs))), start, until)
    else:
        members = tuple(Member(member.name, watched(member.velocity)) for member in field.members)
        found = simulator(replace(field, members=members), start, until)
    return MethodPath(found.times, found.states, len(found.times), found.events)


def follow_without_events(
    field: PolygonField | SignField,
    method: str,
    tolerances: tuple[float, float],
    start: Start,
    until: float,
    clock: Clock,
) -> MethodPath:
    """SciPy's ``solve_ivp`` on the field as it stands, jumps and all.

    Args:
        field: the field; outside a domain of polygons the nearest one rules.
        method: a method of ``solve_ivp``.
        tolerances: relative and absolute.
        start: where to start.
        until: when to end.
        clock: the time limit.

    Raises:
        RuntimeError: where the method gives up.
    """
    from scipy.integrate import solve_ivp  # half a second that most commands need not wait

    def velocity(t: float, x: Floats) -> Floats:
        clock.check()
        if isinstance(field, SignField):
            return field.velocity(field.mode_at(x))(t, x)
        return field.velocity(field.nearest_mode(x))(t, x)

    found = solve_ivp(velocity, (0.0, until), start, method, rtol=tolerances[0], atol=tolerances[1])
    if found.status < 0:
        raise RuntimeError(found.message)
    return MethodPath(found.t.tolist(), found.y.T.tolist(), len(found.t))


TRAJECTORIES = Study(
    "trajectories", "trajectories: largest error of a path", "path error [length, rad]", build_trajectories
)
SYSTEM_PATHS = Study("paths", "paths: largest error of a state", "error of a state [half-widths]", build_system_paths)
