"""The integrators between events: DOP853, Radau where fields are stiff, and smoothed or delayed signs."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import partial

import mpmath
import numpy as np
import pytest
from scipy.integrate import DOP853, solve_ivp

import nonsmooth
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import CellwiseField, array_field, feedback_field
from nonsmooth.analysis.fields.feedback_laws import corrected_law, gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import ScalarVelocity, SwitchedField, affine_surface
from nonsmooth.analysis.measurements.harness import log_slope
from nonsmooth.analysis.trajectories import hysteresis
from nonsmooth.analysis.trajectories.hysteresis import simulate_hysteresis, simulate_smoothed
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.smooth_path import EXPLICIT, IMPLICIT
from nonsmooth.analysis.trajectories.steppers import (
    STAGES,
    Dop853,
    ScalarDop853,
    StiffAware,
    comes_to_rest,
    decay_rate,
    written_out,
)
from nonsmooth.analysis.trajectories.trajectory import follow_smooth, simulate
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.conftest import Arrays
from tests.four_wheel import ROLL
from tests.thorough import few

# ---- Our DOP853 against SciPy's: the same steps and the same solution between them, bit by bit.
#
# In single floats sums are rounded in another order, so there a step is compared within rounding, and by its order.

STEP_TOLERANCES = {"rtol": 1e-9, "atol": 1e-11}


def van_der_pol(t: float, x: Floats) -> Floats:
    """Its steps are refused now and then."""
    return np.array([x[1], 20 * (1 - x[0] ** 2) * x[1] - x[0] + np.sin(t)])


@few(1)
@pytest.mark.parametrize("first", [None, 1e-3, 0.5])
def test_steps_are_those_of_scipy(first: float | None) -> None:
    start, until, refused = np.array([2.0, 0.0]), 30.0, 0
    theirs = DOP853(van_der_pol, 0.0, start, until, first_step=first, **STEP_TOLERANCES)
    ours = Dop853(van_der_pol, 0.0, start, until, first, **STEP_TOLERANCES)
    while theirs.status == "running":
        before = theirs.nfev
        step = ours.step()
        theirs.step()
        assert (step.end, ours.step_size, ours.following) == (theirs.t, theirs.step_size, theirs.h_abs)
        assert step.last.tolist() == theirs.y.tolist()
        assert step.work == theirs.nfev - before
        refused += step.work > STAGES
    assert ours.t == until
    assert refused > 2


def test_the_solution_between_is_that_of_scipy_when_it_is_asked_for_late() -> None:
    ours = Dop853(van_der_pol, 0.0, np.array([2.0, 0.0]), 30.0, 1e-2, **STEP_TOLERANCES)
    theirs = DOP853(van_der_pol, 0.0, np.array([2.0, 0.0]), 30.0, first_step=1e-2, **STEP_TOLERANCES)
    step = ours.step()
    theirs.step()
    between = theirs.dense_output()
    ours.step()
    times = np.linspace(step.start, step.end, 7)
    assert step(times).tolist() == between(times).tolist()
    assert step(float(times[3])).tolist() == between(times[3]).tolist()


@pytest.mark.filterwarnings("ignore:invalid value", "ignore:overflow")
def test_a_field_that_is_no_number_ends_the_steps() -> None:
    solver = Dop853(lambda t, x: x * np.nan, 0.0, np.ones(1), 1.0, 0.1, **STEP_TOLERANCES)
    with pytest.raises(TrajectoryError, match="less than spacing between numbers"):
        solver.step()


# ---- single floats -------------------------------------------------------------------------------

ROUNDING = 1e-14  # of states of size one after a step
FIELDS = (
    ScalarVelocity(lambda x: (1 - x * x,)),
    ScalarVelocity(lambda x, y: (y - x * x / 3, -2 * x - y * x)),
    ScalarVelocity(lambda x, y, z: (y * z, -x * z - y, x - z / 2)),
    ScalarVelocity(lambda x, y, z, w: (y, -x + z * w, w * w - z, -y - w / 3)),
)
TURNING = ScalarVelocity(lambda x, y: (y, -x))


@pytest.mark.parametrize("field", FIELDS, ids=("one", "two", "three", "four"))
def test_a_step_in_single_floats_is_that_of_arrays(field: ScalarVelocity) -> None:
    count = 1 + FIELDS.index(field)
    for start in np.random.default_rng(count).uniform(-1, 1, (20, count)):
        single, arrays = (kind(field, 0.5, start, 9.0, 0.3, rtol=1e-3, atol=1e-5) for kind in (ScalarDop853, Dop853))
        ours, theirs = single.step(), arrays.step()
        assert (ours.start, ours.end, ours.work) == (theirs.start, theirs.end, theirs.work)
        assert ours.last == pytest.approx(theirs.last, abs=ROUNDING)
        assert np.array(ours.slopes) == pytest.approx(np.array(theirs.slopes), abs=10 * ROUNDING)
        assert single.following == pytest.approx(arrays.following, rel=1e-6)  # by errors of some 1e-8
        times = np.linspace(ours.start, ours.end, 7)
        assert ours(times) == pytest.approx(theirs(times), abs=ROUNDING)
        assert ours(float(times[3])) == pytest.approx(ours(times)[:, 3], abs=ROUNDING)


def test_a_step_in_single_floats_is_of_order_eight() -> None:
    """Of one step from (1, 0) on the circle the state errs by h^9, and the solution between by h^8."""
    lengths, at_end, between = [1.6, 1.2, 0.9, 0.7], [], []
    for h in lengths:
        step = ScalarDop853(TURNING, 0.0, np.array([1.0, 0.0]), 9.0, h, rtol=1.0, atol=1.0).step()
        assert step.end == h
        at_end.append(float(np.abs(step.last - [np.cos(h), -np.sin(h)]).max()))
        times = np.linspace(0.0, h, 50)
        between.append(float(np.abs(step(times) - [np.cos(times), -np.sin(times)]).max()))
    assert log_slope(lengths, at_end) == pytest.approx(9, abs=0.5)
    assert log_slope(lengths, between) == pytest.approx(8, abs=0.5)


def test_fields_in_single_floats_are_followed_in_them() -> None:
    """The stepper looks at the field: a step asks for its rates and never for arrays, but at the first time."""
    asked = []

    class Watched(ScalarVelocity):
        def __call__(self, t: float, x: Floats) -> Floats:
            asked.append(t)
            return super().__call__(t, x)

    steps = list(StiffAware(1e-9, 1e-11, 1.0).steps(Watched(TURNING.rates), 0.0, np.array([1.0, 0.0]), 3.0))
    assert steps[-1].last == pytest.approx([np.cos(3.0), -np.sin(3.0)], abs=1e-8)
    assert len(steps) > 5
    assert max(asked) < steps[0].end


def test_written_steps_name_two_functions_alone() -> None:
    names = {name for function in written_out(3) for name in function.__code__.co_names}
    assert names == {"abs", "max"}


def test_rates_in_single_floats_may_overflow() -> None:
    solver = ScalarDop853(ScalarVelocity(lambda x: (x * x * x,)), 0.0, np.array([1e200]), 1.0, 0.1, **STEP_TOLERANCES)
    with pytest.raises(TrajectoryError, match="less than spacing between numbers"):
        solver.step()


# ---- DOP853 with events on a field that is not constant: the error of a path is proportional to the tolerance.

DIGITS = 60
DECAY = 10  # A = N - 1/DECAY, the flower of Johansson and Rantzer
TURNS = (((0, 1), (-5, 0)), ((0, 5), (-1, 0)))  # N where |x| > |y| and elsewhere: N^2 = -5
FORCED_START, FORCED_UNTIL = (1.0, 0.25), 5.0
TOLERANCES = [10.0**-k for k in range(3, 12)]
WITHIN = 0.2


def flow(time: mpmath.mpf, x: mpmath.matrix, cell: int) -> mpmath.matrix:
    """``e^(A t) x = e^(-t/10) (cos(r t) + sin(r t)/r N) x`` with ``r = sqrt(5)``."""
    root = mpmath.sqrt(5)
    turned = mpmath.matrix(TURNS[cell]) * x
    return mpmath.exp(-time / DECAY) * (mpmath.cos(root * time) * x + mpmath.sin(root * time) / root * turned)


def time_to(line: int, x: mpmath.matrix, cell: int) -> mpmath.mpf:
    """First positive time at which ``x + line y = 0``: tan(r t) solves a linear equation."""
    root = mpmath.sqrt(5)
    turned = mpmath.matrix(TURNS[cell]) * x
    angle = mpmath.atan2(-(x[0] + line * x[1]) * root, turned[0] + line * turned[1]) % mpmath.pi
    return (angle if angle > mpmath.mpf(10) ** (-DIGITS // 2) else mpmath.pi) / root


def exact_end() -> mpmath.matrix:
    """The solution at the last time; each cell is left over whichever diagonal comes first."""
    x, left, cell = mpmath.matrix(FORCED_START), mpmath.mpf(FORCED_UNTIL), 0
    while True:
        time = min(time_to(line, x, cell) for line in (1, -1))
        if time > left:
            return flow(left, x, cell)
        x, left, cell = flow(time, x, cell), left - time, 1 - cell


def forced(matrix: np.ndarray, t: float, x: np.ndarray) -> np.ndarray:
    return np.asarray(matrix @ x)


def test_errors_are_proportional_to_the_tolerance() -> None:
    """Tolerances 1e-3 to 1e-11, 13 crossings, against closed forms to sixty digits."""
    matrices = [np.array(turn) - np.eye(2) / DECAY for turn in TURNS]
    surfaces = (affine_surface("x - y", (1, -1)), affine_surface("x + y", (1, 1)))
    field = SignField(("x", "y"), surfaces, lambda s: partial(forced, matrices[0 if s[0] * s[1] > 0 else 1]))
    with mpmath.workdps(DIGITS):
        end, errors = exact_end(), []
        for tolerance in TOLERANCES:
            path = follow_smooth(
                field, FORCED_START, FORCED_UNTIL, stepper=StiffAware(tolerance, tolerance, field.size)
            )
            assert len(path.events) == 13
            errors.append(max(abs(float(exact - found)) for exact, found in zip(end, path.end.state, strict=True)))
    assert log_slope(TOLERANCES, errors) == pytest.approx(1, abs=WITHIN)


def test_an_event_is_as_accurate_as_the_steps() -> None:
    """Between the ends of a long step its polynomial errs more: by 5e-11 here, where short steps of SciPy's tell."""
    speeds = "-0.92*x + 0.39*y - 0.71*x*y", "-0.07*x + 0.34*y + 0.59*x**2"
    system = nonsmooth.System(["x", "y"], [f"{speed} - 1 + sign(x - 0.09*y - 0.11)" for speed in speeds])

    def rates(t: float, state: Floats) -> list[float]:
        x, y = state.tolist()
        return [-0.92 * x + 0.39 * y - 0.71 * x * y, -0.07 * x + 0.34 * y + 0.59 * x**2]

    def height(t: float, state: Floats) -> float:
        return float(state[0] - 0.09 * state[1] - 0.11)

    height.terminal = True  # type: ignore[attr-defined]  # SciPy reads it
    start, finely = (1.0, -0.03), {"rtol": 1e-13, "atol": 1e-15, "max_step": 0.01}
    moment = float(solve_ivp(rates, (0, 6), start, method="DOP853", events=height, **finely).t_events[0][0])
    first = system.simulate(start, until=6).trajectory.events[0]
    assert first.t == pytest.approx(moment, rel=0, abs=1e-11)


# ---- Stiff stretches: when Radau takes over, and that nothing is lost by it ----------------------

ACCURACY = 1e-10  # a hundred steps of 1e-12 each
FEW = 1_000  # samples: an explicit method would need a million
STIFF_START = (0.2, 0.1, 0.3)


def closed_loop(gain: float) -> CellwiseField:
    partition = build_nearest_partition(load_scene("four-wheel"))
    return feedback_field(partition, corrected_law(gain), Kinematics.EXACT)


def linear(matrix: Floats) -> SignField:
    """``x' = A x``, with a surface that is never met."""
    return SignField(("x", "y"), (affine_surface("far", (1.0, 0.0), -10.0),), lambda signs: lambda t, x: matrix @ x)


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_the_decay_rate_is_that_of_the_fastest_mode(size: float) -> None:
    turn = np.array([[3.0, -4.0], [4.0, 3.0]]) / 5
    matrix = turn @ np.diag([-7e5, -2.0]) @ turn.T
    found = decay_rate(lambda t, x: matrix @ x, 0.0, size * np.array([0.3, 0.7]), size)
    assert found == pytest.approx(7e5, rel=1e-6)
    assert decay_rate(lambda t, x: -matrix @ x, 0.0, np.array([0.3, 0.7]), 1.0) == 0
    assert decay_rate(lambda t, x: np.full(2, math.inf), 0.0, np.ones(2), 1.0) == 0


@few(1)
@pytest.mark.parametrize("gain", [1e4, 1e6, 1e8])
def test_feedback_of_high_gain_is_that_of_gain_one_in_its_own_time(gain: float) -> None:
    slow, fast = simulate(closed_loop(1), STIFF_START, 6), simulate(closed_loop(gain), STIFF_START, 2)
    assert (slow.method, fast.method) == (EXPLICIT, IMPLICIT)
    assert fast.end.reason is EndReason.TIME
    assert len(fast.times) < FEW
    times = np.linspace(0, 6, 40)
    assert np.abs(fast.sample(times / gain) - slow.sample(times)).max() <= ACCURACY
    assert np.abs(np.array(fast.end.state)).max() <= ACCURACY


def test_a_stiff_path_follows_its_slow_part_between_the_steps_too() -> None:
    path = simulate(linear(np.array([[-1.0, 0.0], [0.0, -1e7]])), (1.0, 1.0), 3.0)
    assert path.method == IMPLICIT
    assert len(path.times) < FEW
    times = np.linspace(0, 3, 77)
    assert np.abs(path.sample(times)[:, 0] - np.exp(-times)).max() <= ACCURACY
    assert np.abs(path.sample(times[1:])[:, 1]).max() <= ACCURACY


def test_a_loop_that_is_down_to_rounding_rests(arrays: Arrays) -> None:
    """At the equilibrium the corrected law is rounding, on which Radau once took tiny steps without end."""
    partition = build_nearest_partition(arrays.cocircular(4))
    path = simulate(feedback_field(partition, corrected_law(1e6), Kinematics.EXACT), (0.417, 0.244, 0.3), 2.0)
    assert (path.method, path.end.reason) == (IMPLICIT, EndReason.TIME)
    assert len(path.times) < FEW
    assert np.abs(path.sample([1.0, 1.5, 2.0])).max() <= ACCURACY


@pytest.mark.parametrize(("growth", "rests"), [(-1.0, True), (0.1, True), (40.0, False)])
def test_what_grows_until_the_end_does_not_rest(growth: float, rests: bool) -> None:
    matrix = np.diag([growth, -1e6])

    class At:
        t, y = 0.0, np.array([1e-20, 1e-20])

    assert comes_to_rest(lambda t, x: matrix @ x, At, 1.0, 1.0, 1e-13) is rests
    assert not comes_to_rest(lambda t, x: matrix @ x + 1e-3, At, 1.0, 1.0, 1e-13)


def test_oscillations_are_not_stiff() -> None:
    path = simulate(linear(np.array([[0.0, 1.0], [-1.0, 0.0]])), (1.0, 0.0), 400.0)
    assert path.method == EXPLICIT
    assert path.end.state == pytest.approx((math.cos(400), -math.sin(400)), abs=1e-9)


@pytest.mark.parametrize(("seed", "start"), [(2, (-0.286, -0.242, 0.377)), (36, (-0.383, -0.122, 0.473))])
def test_a_trial_step_beyond_floats_is_shortened(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    """Exact kinematics under feedback are cubic in the pose, so a step too long for the next cell overflows.

    ``V = |c|^2 + theta^2`` falls all the same.
    """
    partition = build_nearest_partition(arrays.cocircular(seed, ROLL))
    path = simulate(feedback_field(partition, gradient_law(1.0), Kinematics.EXACT), start, 3)
    assert path.end.reason is EndReason.TIME
    heights = (np.array(path.states) ** 2).sum(axis=1)
    assert (np.diff(heights) <= ACCURACY).all()
    assert heights[-1] < heights[0] / 2


def test_a_slide_is_stiff_before_its_step_is_as_long_as_is_stable(arrays: Arrays) -> None:
    """A rate of 820 holds the step at 1.8 of its inverse; along the edge little happens in 12 units of time."""
    partition = build_nearest_partition(arrays.cocircular(57, ROLL))
    shape = (49 / 64, 17 / 32)  # of the V that is certified for this array
    field = feedback_field(partition, gradient_law(1.0, shape), Kinematics.EXACT)
    path = simulate(field, (-0.31157103, 0.80144174, -0.25690855), 12.0)
    assert path.method == IMPLICIT
    assert len(path.times) < FEW  # 4,874 with DOP853
    x, y, theta = path.array.T
    values = (1 + shape[0]) * x**2 + 2 * shape[1] * x * y + (1 - shape[0]) * y**2 + theta**2
    assert (np.diff(values) < 0).all()
    assert np.abs(path.array[-1] - [-0.1200123462, 0.3360345692, 0.0270193447]).max() < 1e-6  # DOP853's, from nearby


# ---- Hysteresis and smoothed signs converge to the event-driven path, with errors of the order of their width.

START, UNTIL = (0.4, 0.15, 0.0), 0.5
Method = Callable[[SwitchedField, float], Trajectory]
METHODS: dict[str, Method] = {
    "adaptive": lambda field, width: simulate_hysteresis(field, START, UNTIL, width),
    "fixed step": lambda field, width: simulate_hysteresis(field, START, UNTIL, width, step=width),
    "smoothed": lambda field, width: simulate_smoothed(field, START, UNTIL, width),
}
ERROR_PER_WIDTH = 4.0  # the zigzag overshoots by a width and a step, in each of two directions


def relay_system() -> SignField:
    """x' = -sgn(x - y/3) - 1/4, y' = 1/2 - y, theta' = sgn(y - 1/4)/4: slides along one line, crosses the other."""
    surfaces = (affine_surface("x - y/3", (1, -1 / 3, 0)), affine_surface("y - 1/4", (0, 1, 0), 0.25))
    return SignField(
        ("x", "y", "theta"), surfaces, lambda s: lambda t, x: np.array([-s[0] - 0.25, 0.5 - x[1], s[1] / 4])
    )


def error(path: Trajectory, reference: Trajectory) -> float:
    return float(np.abs(reference.sample(path.times) - path.array).max())


@pytest.fixture(params=["leading", "exact", "feedback", "plain"])
def field(request: pytest.FixtureRequest, arrays: Arrays) -> SwitchedField:
    if request.param == "plain":
        return relay_system()
    partition = build_nearest_partition(arrays.four_wheel())
    if request.param == "feedback":
        return feedback_field(partition, corrected_law(1), Kinematics.EXACT)
    return array_field(partition, Kinematics(request.param))


@few(3)
@pytest.mark.parametrize("method", METHODS)
def test_errors_shrink_with_the_width(field: SwitchedField, method: str) -> None:
    reference = simulate(field, START, UNTIL)
    for width in (2e-2, 5e-3, 1e-3):
        path = METHODS[method](field, width)
        assert error(path, reference) <= ERROR_PER_WIDTH * width
        assert path.end.t == UNTIL
        assert path.unique is None


def test_switches_are_counted_and_multiply_as_the_width_shrinks(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.LEADING)
    counts = [len(METHODS["adaptive"](field, width).events) for width in (1e-2, 1e-3)]
    assert counts[1] > 5 * counts[0] > 0
    path = METHODS["adaptive"](field, 1e-2)
    assert {event.kind for event in path.events} == {EventKind.CROSS}
    assert path.events[0].surface == "cell 2 | cell 1"
    assert path.method == "hysteresis"


def test_a_relay_keeps_the_period_of_its_width() -> None:
    """x' = -sgn x with hysteresis w is a triangle wave of period 4 w: switches every 2 w after the first."""
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    width = 0.05
    path = simulate_hysteresis(field, (0.2,), 1, width)
    times = [event.t for event in path.events]
    assert times[0] == pytest.approx(0.2 + width, abs=1e-9)
    assert np.diff(times) == pytest.approx(2 * width, abs=1e-9)


def test_paths_end_at_the_border_of_the_domain(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.pushed(1, 1)), Kinematics.LEADING)
    path = simulate_hysteresis(field, (0.2, 0.1, 0), 5, 1e-3)
    assert path.end.reason is EndReason.OUTSIDE
    assert max(abs(v) for v in path.end.state[:2]) == pytest.approx(0.5, abs=2e-3)


@pytest.mark.parametrize(("width", "step"), [(0, None), (-1, None), (math.nan, None), (1e-2, 0)])
def test_widths_and_steps_are_positive(arrays: Arrays, width: float, step: float | None) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel(ROLL)), Kinematics.LEADING)
    with pytest.raises(ValueError, match="positive"):
        simulate_hysteresis(field, START, 1, width, step)
    if step is None:
        with pytest.raises(ValueError, match="positive"):
            simulate_smoothed(field, START, 1, width)


def test_starts_are_inside(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.LEADING)
    for method in (simulate_hysteresis, simulate_smoothed):
        with pytest.raises(ValueError, match="inside the domain"):
            method(field, (2, 0, 0), 1, 1e-2)


@pytest.mark.parametrize("width", [1e-17, 1e-30, 1e-300])
def test_a_width_that_floats_do_not_resolve_is_refused_at_once(width: float) -> None:
    """Its zigzag would never get on."""
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    with pytest.raises(ValueError, match="required a width whose switches floats resolve, received"):
        simulate_hysteresis(field, (0.5,), 1.0, width)


def test_a_tiny_width_is_followed_where_floats_resolve_it() -> None:
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    path = simulate_hysteresis(field, (0.0,), 1e-11, 1e-13)
    assert len(path.events) == 50  # one after every 2e-13 but the first, which takes 1e-13
    assert max(abs(state[0]) for state in path.states) <= 1.001e-13


@pytest.mark.parametrize("width", [1e-6, 5e-10, 1e-13])
def test_a_surface_away_from_the_origin_is_crossed_once(width: float) -> None:
    """Floats know the height above ``v = 1/2`` to 1e-16, which is less than all but a billionth of these widths."""
    surface = affine_surface("v - 1/2", (0, 1), 0.5)
    field = SignField(("x", "v"), (surface,), lambda signs: lambda t, x: np.array([x[1], -1.0]), 1.0)
    path = simulate_hysteresis(field, (0.3, 0.5 + 1e-3), 0.1, width)
    assert len(path.events) == 1
    assert float(path.end.t) == 0.1


def test_a_layer_that_is_never_crossed_is_refused(arrays: Arrays, monkeypatch: pytest.MonkeyPatch) -> None:
    """Thinner than the tolerance, it would be integrated for ever."""
    field = array_field(build_nearest_partition(arrays.four_wheel(ROLL)), Kinematics.EXACT)
    monkeypatch.setattr(hysteresis, "MAX_EVALUATIONS", 5_000)
    assert simulate_smoothed(field, START, UNTIL, 1e-3).end.t == UNTIL
    with pytest.raises(ValueError, match="required a width that 5000 evaluations resolve, received 1e-12"):
        simulate_smoothed(field, START, UNTIL, 1e-12)


def test_a_zigzag_of_too_many_switches_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A relay at rest switches every four widths: work grows like one over the width."""
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([-float(s[0])]))
    monkeypatch.setattr(hysteresis, "MAX_RELAY_EVALUATIONS", 5_000)
    assert simulate_hysteresis(field, (0.0,), 1.0, 1e-2).end.t == 1.0
    with pytest.raises(ValueError, match="required a width that 5000 evaluations resolve, received 1e-06"):
        simulate_hysteresis(field, (0.0,), 1.0, 1e-6)
