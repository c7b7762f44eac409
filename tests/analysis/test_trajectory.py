"""Event-driven trajectories: golden problems, exact numbers, and what every path must satisfy."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import linprog

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.filippov import cell_derivatives
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.polygon import HalfPlane, square
from nonsmooth.analysis.fields.constant_field import (
    ConstantField,
    array_field,
    feedback_field,
    piecewise_constant,
    smooth_form,
)
from nonsmooth.analysis.fields.feedback_laws import corrected_law, gradient_law, printed_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import Surface, SwitchedField, affine_surface
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.result import (
    EndReason,
    EventKind,
    LyapunovViolationError,
    LyapunovWatch,
    Trajectory,
    TrajectoryError,
)
from nonsmooth.analysis.trajectories.trajectory import distance_watch, follow_smooth, simulate
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.oracles.differences import smooth_surface

ROUNDING = 1e-14
ROOT_HALF = math.sqrt(0.5)


def constant(*velocity: float) -> Callable[[float, Floats], Floats]:
    vector = np.array(velocity, dtype=float)
    return lambda t, x: vector


def kinds(path: Trajectory) -> list[str]:
    return [event.kind.value for event in path.events]


def floats(values: tuple[object, ...]) -> list[float]:
    return [float(value) for value in values]  # type: ignore[arg-type]


def quad_system(equation: int) -> SignField:
    """Eq. (3) or (4) as a plain system: sgn(y^2 - x^2) is a product of two signs."""
    surfaces = [("x", (1, 0, 0)), ("y", (0, 1, 0)), ("y - x", (-1, 1, 0)), ("y + x", (1, 1, 0))]

    def flow(signs: tuple[int, ...]) -> Callable[[float, Floats], Floats]:
        sx, sy, s = signs[0], signs[1], signs[2] * signs[3]
        if equation == 3:
            return constant(-ROOT_HALF * sx * (s + 1), ROOT_HALF * sy * (s - 1), -ROOT_HALF * sx * sy * s)
        return constant(ROOT_HALF * sx * (s - 1), -ROOT_HALF * sy * (s + 1), ROOT_HALF * sx * sy * s)

    return SignField(("x", "y", "theta"), tuple(affine_surface(name, normal) for name, normal in surfaces), flow)


@pytest.fixture(params=["array", "exact array", "array by DOP853", "plain system"])
def quad(request: pytest.FixtureRequest, arrays: Arrays) -> Callable[[int], SwitchedField]:
    """The four-wheel array with leading-order kinematics, eq. (3) or (4), in four forms."""

    def build(equation: int) -> SwitchedField:
        friction = ROLL if equation == 4 else SIDE
        partition = build_nearest_partition(arrays.four_wheel(friction, radius=1))
        match request.param:
            case "plain system":
                return quad_system(equation)
            case "array by DOP853":
                return smooth_form(array_field(partition, Kinematics.LEADING))
            case form:
                return array_field(partition, Kinematics.LEADING, exact=form.startswith("exact"))

    return build


Quad = Callable[[int], SwitchedField]


def test_quad_field_slides_to_the_origin(quad: Quad) -> None:
    path = simulate(quad(4), (1, Fraction(1, 2), 0), 3)
    slide, rest, branch = path.events
    assert [slide.kind, rest.kind, branch.kind] == [EventKind.SLIDE, EventKind.REST, EventKind.NONUNIQUE]
    expected = [(0.5 * ROOT_HALF, 0.5, 0.5), (1.5 * ROOT_HALF, 0.0, 0.0)]
    for event, (t, x, y) in zip((slide, rest), expected, strict=True):
        assert floats((event.t, *event.state)) == pytest.approx([t, x, y, -0.25], abs=ROUNDING)
    times = np.linspace(0, 1.6, 81)
    first, last = np.minimum(times, expected[0][0]), np.clip(times - expected[0][0], 0, 1 / math.sqrt(2))
    xs = 1 - math.sqrt(2) * first - ROOT_HALF * last
    ys = 0.5 - ROOT_HALF * last
    assert np.abs(path.sample(times) - np.stack([xs, ys, -ROOT_HALF * first], axis=1)).max() <= ROUNDING


def test_quad_field_ends_where_the_formula_says(quad: Quad) -> None:
    start = (Fraction(1, 5), Fraction(2, 5), 0)
    assert floats(simulate(quad(4), start, 2).end.state) == pytest.approx([0, 0, 0.1], abs=ROUNDING)
    stopped = simulate(quad(3), start, 2)
    assert floats(stopped.end.state) == pytest.approx([0, 0.4, -0.1], abs=ROUNDING)
    assert kinds(stopped) == ["rest"]
    assert stopped.unique


def test_exact_mode_gives_exact_numbers(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel(radius=1)), Kinematics.LEADING, exact=True)
    path = simulate(field, (1, Fraction(1, 2), 0))
    assert [str(value) for value in (path.end.t, *path.end.state)] == ["3*sqrt(2)/4", "0", "0", "-1/4"]
    assert path.record()["end"]["exact"] == {"t": "3*sqrt(2)/4", "state": ["0", "0", "-1/4"]}
    assert path.events[0].weights == (("cell 2", Fraction(1, 2)), ("cell 1", Fraction(1, 2)))
    drift = path.events[-1].rates
    assert drift is not None
    assert [str(rate) for rate in drift] == ["-sqrt(2)/2", "sqrt(2)/2"]
    with pytest.raises(ValueError, match="leading-order"):
        array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.EXACT, exact=True)


@pytest.mark.parametrize("seed", range(8))
def test_exact_and_float_paths_agree(arrays: Arrays, seed: int) -> None:
    scene = arrays.with_friction(arrays.random(seed, 5), ROLL)
    partition = build_nearest_partition(scene)
    x, y = scene.check.equilibrium
    start = (x + scene.check.radius / 3, y - scene.check.radius / 5, 0)
    exact = simulate(array_field(partition, Kinematics.LEADING, exact=True), start, 2)
    rounded = simulate(array_field(partition, Kinematics.LEADING), start, 2)
    assert kinds(exact) == kinds(rounded)
    assert floats((exact.end.t, *exact.end.state)) == pytest.approx(
        floats((rounded.end.t, *rounded.end.state)), abs=1e-13
    )


def two_surfaces(exact: bool) -> ConstantField:
    """x' = -2 if x > y else 2, y' = -3 if y > x else 1.5."""
    right, left = HalfPlane((-1, 1), 0), HalfPlane((1, -1), 0)
    pieces = [((right,), (-2, 1.5, 0)), ((left,), (2, -3, 0))]
    return piecewise_constant(square((Fraction(0), Fraction(0)), Fraction(4)), pieces, exact=exact)


def test_two_surfaces_that_coincide() -> None:
    surfaces = (affine_surface("x - y", (1, -1)), affine_surface("y - x", (-1, 1)))
    plain = SignField(("x", "y"), surfaces, lambda s: constant(-2 if s[0] > 0 else 2, -3 if s[1] > 0 else 1.5))
    path = simulate(plain, (1.5, 1), 1)
    assert path.events[0].t == pytest.approx(1 / 7, abs=ROUNDING)
    assert path.end.state == pytest.approx((31 / 34, 31 / 34), abs=ROUNDING)
    exact = simulate(two_surfaces(exact=True), (Fraction(3, 2), 1, 0), 1)
    assert exact.events[0].t == Fraction(1, 7)
    assert exact.end.state == (Fraction(31, 34), Fraction(31, 34), 0)


def test_leaving_a_sliding_mode() -> None:
    field = SignField(("x",), (affine_surface("x", (1,)),), lambda s: lambda t, x: np.array([t - s[0]]))
    path = simulate(field, (0,), 1.5)
    assert kinds(path) == ["rest", "leave"]
    assert path.events[1].t == pytest.approx(1, abs=1e-12)
    assert path.end.state[0] == pytest.approx(1 / 8, abs=1e-12)
    assert path.unique


@pytest.mark.parametrize("gradient", [True, False])
def test_circle_problem(gradient: bool) -> None:
    """Spiral out to the unit circle, then in the other sense: one crossing at t = 1 (golden)."""
    matrix = np.array([[1, 2 * math.pi], [-2 * math.pi, 1]])
    value = lambda x: float(x @ x) - 1  # noqa: E731
    circle = Surface("circle", value, lambda x: 2 * x) if gradient else smooth_surface("circle", value)
    field = SignField(("x", "y"), (circle,), lambda s: lambda t, x: (matrix if s[0] > 0 else matrix.T) @ x)
    path = simulate(field, (1 / math.e, 0), math.pi / 2)
    (crossing,) = path.events
    assert crossing.t == pytest.approx(1, abs=1e-10)
    phase = 2 * math.pi * (math.pi / 2 - 1)
    expected = math.exp(math.pi / 2 - 1) * np.array([math.cos(phase), -math.sin(phase)])
    assert np.abs(np.array(path.end.state) - expected).max() <= 1e-10


def test_traps() -> None:
    """Two traps: a line of equilibria; an attracting line along which the state escapes."""
    line = SignField(("x", "y"), (affine_surface("y", (0, 1)),), lambda s: constant(0, -s[0]))
    path = simulate(line, (0.5, 1), 2)
    assert kinds(path) == ["rest"]
    assert path.end.state == pytest.approx((0.5, 0), abs=ROUNDING)
    escape = SignField(("x", "y"), (affine_surface("x", (1, 0)),), lambda s: constant(-s[0], 1))
    assert simulate(escape, (0.5, 0), 3).end.state == pytest.approx((0, 3), abs=ROUNDING)


def test_a_repelling_surface_is_said_to_branch() -> None:
    field = SignField(("x", "y"), (affine_surface("x", (1, 0)),), lambda s: constant(s[0], 1))
    path = simulate(field, (0, 0), 1)
    assert not path.unique
    assert kinds(path) == ["slide", "nonunique"]
    assert path.events[1].note.startswith("also possible: keep to x < 0; keep to x > 0")
    assert simulate(field, (1e-3, 0), 1).unique


def spiral(gain: Fraction) -> ConstantField:
    """Four quadrants turned through counterclockwise; a full turn multiplies the distance by the gain."""
    o = Fraction(0)
    quadrants = [((-1, 0), (0, -1)), ((1, 0), (0, -1)), ((1, 0), (0, 1)), ((-1, 0), (0, 1))]
    rates = [(-1 / gain, 1, 2), (-1, -1, 3), (1, -1, 5), (1, 1, 7)]
    pieces = [([HalfPlane(n, o) for n in normals], rate) for normals, rate in zip(quadrants, rates, strict=True)]
    return piecewise_constant(square((o, o), Fraction(2)), pieces, exact=True)


def test_accumulating_switches_end_at_their_limit() -> None:
    """From (1, 0): to (0, g) in time g, then one length g for each of three quadrants: series in closed form."""
    field, gain = spiral(Fraction(1, 3)), Fraction(1, 3)
    path = simulate(field, (1, 0, 0))
    time, rotation = gain * 4, gain * (2 + 3 + 5 + 7)
    assert (path.end.t, path.end.state) == (time / (1 - gain), (0, 0, rotation / (1 - gain)))
    assert path.end.reason is EndReason.TURNING
    assert any("accumulate" in event.note for event in path.events)
    rounded = simulate(field.floats(), (1, 0, 0), 2)
    moments = [0.5, 0.75, 1.999, 1.9999999]
    assert path.sample(moments) == pytest.approx(rounded.sample(moments), abs=ROUNDING)
    late = float(time / (1 - gain)) - 1e-6  # within the accumulation: still on the shrinking spiral
    assert 0 < np.abs(np.array(rounded.at(late)[:2])).max() < 2e-6


def test_an_expanding_spiral_leaves_the_corner_in_many_ways() -> None:
    path = simulate(spiral(Fraction(3)), (0, 0, 0), 1)
    assert not path.unique
    assert "spiral outward" in path.events[-1].note


def test_the_twisting_algorithm_stops_in_finite_time() -> None:
    """x'' = -a sgn x - b sgn x': each half turn multiplies the speed by sqrt((a - b)/(a + b))."""
    a, b = 2.0, 1.0
    surfaces = (affine_surface("x", (1, 0)), affine_surface("v", (0, 1)))
    field = SignField(("x", "v"), surfaces, lambda s: lambda t, x: np.array([x[1], -a * s[0] - b * s[1]]))
    path = simulate(field, (0, 1), 4)
    ratio = math.sqrt((a - b) / (a + b))
    assert path.events[-1].kind is EventKind.REST
    assert path.events[-1].t == pytest.approx((1 / (a + b) + ratio / (a - b)) / (1 - ratio), abs=1e-11)
    assert path.end.state == pytest.approx((0, 0), abs=1e-12)


def test_sliding_towards_an_equilibrium_never_arrives() -> None:
    """Exact kinematics: s' = -(1 + s)/(2 + s), so s + log(1 + s) = -t, and theta' = 1/(2 + s), so theta = t + s."""
    above, below = HalfPlane((0, -1), 0), HalfPlane((0, 1), 0)
    pieces = [((above,), (-1, -1, 0)), ((below,), (0, 1, 1))]
    field = piecewise_constant(square((Fraction(0), Fraction(0)), Fraction(2)), pieces, Kinematics.EXACT)
    path = simulate(field, (0, 0, 0), 80)
    for t in (0.5, 2.0, 5.0, 80.0):
        s, _, theta = path.at(t)
        assert theta == pytest.approx(t + s, abs=1e-13)
        if t < 10:
            assert s + math.log1p(s) == pytest.approx(-t, abs=1e-13)
    assert path.end.state[0] == pytest.approx(-1, abs=ROUNDING)
    forever = simulate(field, (0, 0, 0))
    assert (forever.end.reason, forever.end.t) == (EndReason.APPROACH, math.inf)
    assert forever.end.state == (-1, 0, math.inf)
    json.dumps(forever.record(), allow_nan=False)


def test_a_closed_orbit_ends_where_no_last_time_is_given(arrays: Arrays) -> None:
    """Three tangential rims turn the body about the origin through all six cells."""
    scene = arrays.scene(arrays.inward([(1, 0), (-1, 0), (0, 1), (0, -1)], turn=(0, 1)))
    field = array_field(build_nearest_partition(scene), Kinematics.EXACT)
    path = simulate(field, (0.2, 0.1, 0))
    assert path.end.reason is EndReason.CIRCLES
    assert np.hypot(*path.array[:, :2].T) == pytest.approx(math.hypot(0.2, 0.1), abs=1e-13)


def in_hull(field: ConstantField, point: Floats, rate: Floats) -> bool:
    """Whether a pose rate lies in the hull of the closed cells' rates at a point, by a linear program."""
    near = [cell for cell, p in enumerate(field.cells.polygons) if all(s.slack((*point,)) >= -1e-9 for s in p.sides)]
    flows = [field.flows[cell][0] for cell in near]
    columns = np.array([[*flow.velocity((point[0], point[1])), flow.omega] for flow in flows]).T
    count = columns.shape[1]
    rows = np.vstack([columns, -columns])  # within the error of the difference quotient
    bounds = np.concatenate([rate + 1e-6, 1e-6 - rate])
    result = linprog(np.zeros(count), A_ub=rows, b_ub=bounds, A_eq=np.ones((1, count)), b_eq=[1])
    return bool(result.status == 0)


@pytest.mark.parametrize("kinematics", list(Kinematics))
@pytest.mark.parametrize("seed", range(12))
def test_every_path_is_a_filippov_solution(arrays: Arrays, seed: int, kinematics: Kinematics) -> None:
    rng = np.random.default_rng(seed)
    scene = arrays.with_friction(arrays.random(seed, int(rng.integers(3, 7))), ROLL)
    field = array_field(build_nearest_partition(scene), kinematics)
    start = (*(np.array(floats(scene.check.equilibrium)) + float(scene.check.radius) * rng.uniform(-1, 1, 2)), 0)
    path = simulate(field, start, 1.5)
    for piece in path.pieces:
        step = 1e-6 * (piece.end - piece.start)
        for part in (0.2, 0.7):
            moment = part * (piece.end - piece.start)
            before, after = (np.array(piece.state(moment + sign * step)) for sign in (-1, 1))
            if step > 1e-9:
                assert in_hull(field, np.array(piece.state(moment)[:2]), (after - before) / (2 * step))
    joints = zip(path.pieces, path.pieces[1:], strict=False)
    for one, following in joints:
        assert np.array(one.state(one.end - one.start)) == pytest.approx(np.array(following.state(0.0)), abs=1e-12)


@pytest.mark.parametrize("kinematics", list(Kinematics))
@pytest.mark.parametrize("seed", range(12))
def test_closed_forms_against_dop853(arrays: Arrays, seed: int, kinematics: Kinematics) -> None:
    rng = np.random.default_rng(seed)
    friction = (ROLL, SIDE)[seed % 2]
    scene = arrays.with_friction(arrays.random(seed, int(rng.integers(3, 7))), friction)
    field = array_field(build_nearest_partition(scene), kinematics)
    start = (*(np.array(floats(scene.check.equilibrium)) + float(scene.check.radius) * rng.uniform(-1, 1, 2)), 0)
    closed, stepped = simulate(field, start, 1.5), simulate(smooth_form(field), start, 1.5)
    assert kinds(closed) == kinds(stepped)
    assert closed.end.reason is stepped.end.reason
    assert closed.unique == stepped.unique
    times = np.linspace(0, min(closed.end.t, stepped.end.t), 40)[:-1]
    assert np.abs(closed.sample(times) - stepped.sample(times)).max() <= 1e-9


def test_cells_in_which_motions_tie_are_not_unique(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel((1, 1))), Kinematics.LEADING)
    for form in (field, smooth_form(field)):
        path = simulate(form, (0.2, 0.1, 0), 0.05)
        assert not path.unique
        assert "tie" in path.events[0].note


def test_the_watch_knows_the_certified_bounds(arrays: Arrays) -> None:
    partition = build_nearest_partition(arrays.four_wheel())
    watch = distance_watch(array_field(partition, Kinematics.LEADING, exact=True))
    for known in cell_derivatives(partition):
        assert watch.bounds[f"cell {known.cell.index}"] == known.largest[0]


@pytest.mark.parametrize("kinematics", list(Kinematics))
def test_a_violated_bound_is_an_error(arrays: Arrays, kinematics: Kinematics) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), kinematics)
    watch = distance_watch(field)
    too_strict = replace(watch, bounds={name: bound - 1 for name, bound in watch.bounds.items()})
    simulate(field, (0.2, 0.1, 0), watch=watch)
    with pytest.raises(LyapunovViolationError, match=r"contradicts the certified bound"):
        simulate(field, (0.2, 0.1, 0), watch=too_strict)


@pytest.mark.parametrize("kinematics", list(Kinematics))
def test_feedback_brings_theta_to_zero_as_corrected_and_not_as_printed(arrays: Arrays, kinematics: Kinematics) -> None:
    """V' <= -sqrt2 V for the corrected law with k = 1, watched on every piece; as printed theta stays away."""
    partition = build_nearest_partition(arrays.four_wheel(radius=1))
    names = [f"cell {cell.index}" for cell in partition.cells]
    watch = LyapunovWatch(lambda s: s[0] ** 2 + s[1] ** 2 + s[2] ** 2, dict.fromkeys(names, 0.0), slack=1e-12)
    start = (0.5, 0.2, 0.3)
    path = simulate(feedback_field(partition, corrected_law(1), kinematics), start, 6, watch=watch)
    potential = (path.array**2).sum(axis=1)
    assert (potential <= potential[0] * np.exp(-math.sqrt(2) * np.array(path.times)) + 1e-12).all()
    assert path.end.state[:2] == pytest.approx((0, 0), abs=1e-12)
    assert path.unique
    gradient = simulate(feedback_field(partition, gradient_law(1), kinematics), start, 6, watch=watch)
    assert np.abs(gradient.end.state).max() < 0.02
    printed = simulate(feedback_field(partition, printed_law(1), kinematics), start, 6)
    assert abs(printed.end.state[2]) > 0.3


def test_input_is_checked(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.LEADING)
    with pytest.raises(ValueError, match="inside the domain"):
        simulate(field, (2, 0, 0))
    with pytest.raises(ValueError, match="inside the domain"):
        simulate(smooth_form(field), (2, 0, 0), 1)
    for start in ((math.nan, 0, 0), (math.inf, 0, 0)):
        with pytest.raises(ValueError, match="inside the domain"):
            simulate(field, start)
        with pytest.raises(ValueError, match="inside the domain"):
            simulate(smooth_form(field), start, 1)
    for until in (None, math.inf, 0, -1, math.nan):
        with pytest.raises(ValueError, match="last time"):
            simulate(smooth_form(field), (0.1, 0, 0), until)
    for until in (0, -1, math.nan):
        with pytest.raises(ValueError, match="last time"):
            simulate(field, (0.1, 0, 0), until)


def test_the_number_of_events_is_bounded() -> None:
    """An oscillator across a line goes on forever; the path says that it was cut."""
    field = SignField(("x", "v"), (affine_surface("x", (1, 0)),), lambda s: lambda t, x: np.array([x[1], -s[0]]))
    path = follow_smooth(field, (0, 1), 1000, max_events=30)
    assert path.end.reason is EndReason.EVENTS
    assert len(path.events) == 30
    assert np.diff([event.t for event in path.events]) == pytest.approx(2, abs=1e-9)


def test_a_path_that_leaves_the_domain_ends_there(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.pushed(1, 1)), Kinematics.LEADING)
    for form in (field, smooth_form(field)):
        path = simulate(form, (0.2, 0.1, 0), 5)
        assert path.end.reason is EndReason.OUTSIDE
        assert np.abs(floats(path.end.state[:2])).max() == pytest.approx(0.5, abs=1e-12)


def test_records_are_json(arrays: Arrays) -> None:
    field = array_field(build_nearest_partition(arrays.four_wheel()), Kinematics.EXACT)
    record = json.loads(json.dumps(simulate(field, (0.2, 0.1, 0), 1).record(), allow_nan=False))
    assert set(record) == {"kinematics", "method", "t", "state", "events", "pieces", "end", "unique"}
    assert {"t", "state", "kind", "surface"} <= set(record["events"][0])
    assert record["method"] == "events"


def test_paths_of_rule_box_are_exact_where_numbers_are_evaluated_late() -> None:
    """Twists of rule box are quotients that are evaluated late; they were once refused by the watch on V."""
    partition = build_box_partition(load_scene("off-center", rule="box"))
    start = (Fraction(2, 5), Fraction(-3, 10), Fraction(0))
    exact = simulate(array_field(partition, Kinematics.LEADING, exact=True), start, 1)
    near = simulate(array_field(partition, Kinematics.LEADING), floats(start), 1)
    assert floats(exact.end.state) == pytest.approx(near.end.state, abs=ROUNDING)


@pytest.mark.parametrize("start", [(9.553e-13, 2.955e-13), (1e-11, 2e-12), (-3e-12, 8e-12)])
def test_a_start_that_counts_as_at_a_corner_is_moved_onto_it(start: tuple[float, float]) -> None:
    """All fields of the flower vanish where its lines meet, and nowhere beside."""
    path = simulate(system_field(load_system("flower")), start, 1.0)
    assert path.end.state == (0.0, 0.0)
    assert path.events[-1].kind is EventKind.REST


def test_a_surface_without_a_value_is_a_fault_and_no_event_that_is_missed() -> None:
    surface = Surface("h", lambda x: math.nan if x[0] > 0.5 else 1.0 + x[0], lambda x: np.array([1.0, 0.0]))
    field = SignField(("x", "y"), (surface,), lambda signs: constant(1.0, 0.0))
    with pytest.raises(TrajectoryError, match="required numbers, received none"):
        simulate(field, (0.0, 0.0), 1.0)
