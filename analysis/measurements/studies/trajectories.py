"""Trajectories: event-driven, hysteresis, smoothed and plain SciPy, against the exact paths.

What theory predicts of the largest distance from the path:

- hysteresis and smoothing replace a switch by a layer of the width w: the distance is proportional to w, slope 1;
- a Runge-Kutta method whose step straddles a switch makes a local error of (jump) x (step), whatever its order; step
  control shrinks that step until the error is the tolerance (Hairer, Norsett & Wanner 1993, sec. II.6), and along a
  slide it does so at every step: slope 1 in the tolerance, while the number of steps grows like its inverse;
- with events the field between two of them is constant, and every step is exact whatever the tolerance: no slope.

Event times are compared where a path first meets the same edges, and only for methods that look for events.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.cellwise_field import CellwiseField, smooth_form
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.fields.polygon_field import PolygonField
from nonsmooth.analysis.fields.switched_field import Member, Vector, Velocity
from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.references.reference_paths import ExactPath, reference_paths
from nonsmooth.analysis.measurements.study_plan import Assessment, LeftOut, Order, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed
from nonsmooth.analysis.trajectories.result import Event, State
from nonsmooth.analysis.trajectories.smooth_path import follow_smooth
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.scene import Scene

WIDTHS = tuple(10**-k for k in (1.5, 2, 2.5, 3, 3.5))  # in units of the half-width of the square
TOLERANCES = tuple(10**-k for k in (2, 2.5, 3, 3.5, 4, 4.5, 5))  # relative; absolute in units of the half-width
EVENT_TOLERANCES = tuple(10.0**-k for k in (3, 5, 7, 9, 11))
EXACT = "events, exact numbers"
SOLVERS = ("RK45", "DOP853")
LAYER = Order(1.0, "a switch becomes a layer as thick as the width")
STRADDLED = Order(1.0, "a step across a switch errs by the tolerance, whatever the order; where it falls scatters it")
NO_STEPS = Order(None, "the field is constant between events, so every step is exact whatever the tolerance")


@dataclass(frozen=True)
class Followed:
    """A path as a method leaves it."""

    times: Sequence[object]
    states: Sequence[State]
    events: tuple[Event, ...] | None = None  # None where the method does not look for events
    steps: int = 0


Follow = Callable[[ExactPath, Clock], Followed]


def build_trajectories(scene: Scene) -> StudyPlan:
    """The plan for the cells of the scene's contact rule.

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
    trials = tuple(
        Trial(method, partial(_follow_all, follow, paths), partial(_judge, paths, method), parameter, setting)
        for method, follow, parameter, setting in _entrants(field, float(scene.check.radius))
    )
    orders = {"hysteresis": LAYER, "smoothed": LAYER, "DOP853 with events": NO_STEPS}
    orders |= dict.fromkeys(SOLVERS, STRADDLED)
    switching = sum(bool(path.events) for path in paths)
    note = "" if switching else "no path meets a switch: every method follows one smooth motion"
    reference = f"exact paths from {len(paths)} starts, leading-order kinematics, exact numbers"
    return StudyPlan(reference, trials, orders if switching else {}, note)


TRAJECTORIES = Study(
    "trajectories",
    "trajectories: largest error of a path",
    "path error [length, rad]",
    build_trajectories,
)


def _entrants(field: ConstantField, radius: float) -> Iterator[tuple[str, Follow, str | None, float | None]]:
    """Methods with their settings, from easy to hard."""
    smooth = smooth_form(field)
    yield EXACT, partial(_closed, field), None, None
    yield "events, closed form", partial(_closed, field.floats()), None, None
    for tolerance in EVENT_TOLERANCES:
        yield "DOP853 with events", partial(_by_events, smooth, tolerance, radius), "tolerance", tolerance
    for width in (share * radius for share in WIDTHS):
        yield "hysteresis", partial(_by_hysteresis, smooth, width), "width", width
    for width in (share * radius for share in WIDTHS):
        yield "smoothed", partial(_by_smoothing, smooth, width), "width", width
    for name in SOLVERS:
        for tolerance in TOLERANCES:
            both = (tolerance, tolerance * radius)
            yield name, partial(follow_without_events, field, name, both), "tolerance", tolerance


def _follow_all(follow: Follow, paths: Sequence[ExactPath], clock: Clock) -> list[Followed]:
    return [follow(path, clock) for path in paths]


def _judge(paths: Sequence[ExactPath], method: str, results: Sequence[Followed]) -> Assessment:
    """The largest errors over all starts."""
    pairs = list(zip(paths, results, strict=True))
    errors = [path.path_error(r.times, r.states) for path, r in pairs]
    details = {"end": max(path.error_at(r.times[-1], r.states[-1]) for path, r in pairs)}
    if all(r.events is not None for r in results):
        late = [path.event_error(r.events) for path, r in pairs if r.events is not None]
        known = [error for error in late if error is not None]
        details |= {"event time": max(known)} if known else {}
    steps = sum(r.steps for r in results)
    return Assessment(max(errors), details, {"steps": steps}, "the reference, found again" if method == EXACT else "")


# ---- methods -------------------------------------------------------------------------------------


def _closed(field: ConstantField, path: ExactPath, clock: Clock) -> Followed:
    clock.check()
    found = simulate(field, path.start, path.until)
    return Followed(found.times, found.states, found.events, len(found.pieces))


def _by_events(field: CellwiseField, tolerance: float, radius: float, path: ExactPath, clock: Clock) -> Followed:
    watched = _watched(field, clock)
    found = follow_smooth(watched, path.start, path.until, rtol=tolerance, atol=tolerance * radius)
    return Followed(found.times, found.states, found.events, len(found.times))


def _by_hysteresis(field: CellwiseField, width: float, path: ExactPath, clock: Clock) -> Followed:
    found = simulate_hysteresis(_watched(field, clock), path.start, path.until, width)
    return Followed(found.times, found.states, found.events, len(found.times))


def _by_smoothing(field: CellwiseField, width: float, path: ExactPath, clock: Clock) -> Followed:
    found = simulate_smoothed(_watched(field, clock), path.start, path.until, width)
    return Followed(found.times, found.states, None, len(found.times))


def follow_without_events(
    field: PolygonField, method: str, tolerances: tuple[float, float], path: ExactPath, clock: Clock
) -> Followed:
    """SciPy's ``solve_ivp`` on the field as it stands, jumps and all.

    Args:
        field: the field; outside the domain the nearest one rules.
        method: a method of ``solve_ivp``.
        tolerances: relative and absolute.
        path: where to start and when to end.
        clock: the time limit.

    Raises:
        RuntimeError: where the method gives up.
    """
    from scipy.integrate import solve_ivp  # half a second that most commands need not wait

    def velocity(t: float, x: Vector) -> Vector:
        clock.check()
        return field.velocity(field.nearest_mode(x))(t, x)

    found = solve_ivp(velocity, (0.0, path.until), path.start, method, rtol=tolerances[0], atol=tolerances[1])
    if found.status < 0:
        raise RuntimeError(found.message)
    return Followed(found.t.tolist(), found.y.T.tolist(), None, len(found.t))


def _watched(field: CellwiseField, clock: Clock) -> CellwiseField:
    """The same field, which looks at the clock at every evaluation."""
    members = [Member(member.name, partial(_checked, member.velocity, clock)) for member in field.members]
    return replace(field, members=tuple(members))


def _checked(velocity: Velocity, clock: Clock, t: float, x: Vector) -> Vector:
    clock.check()
    return velocity(t, x)
