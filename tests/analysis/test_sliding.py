"""Sliding along edges and events of codimension two, and paths that switch without end."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import linprog

from nonsmooth.analysis.cells.cell_complex import AtCorner
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields import convex_weights
from nonsmooth.analysis.fields.constant_field import (
    CellwiseField,
    ConstantField,
    Flow,
    Speeds,
    array_field,
    feedback_field,
)
from nonsmooth.analysis.fields.convex_weights import (
    basic_weights,
    central_weights,
    columns_of,
    extreme_mixtures,
    origin_distance,
    shortest_mixture,
)
from nonsmooth.analysis.fields.feedback_laws import gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.sliding_edges import EdgeKind, SwitchingStretch, switching_stretches
from nonsmooth.analysis.fields.switched_field import affine_surface
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories import guards
from nonsmooth.analysis.trajectories.closed_forms import DRAWN_DISTANCE, Ray, junction_at
from nonsmooth.analysis.trajectories.follow import find_root
from nonsmooth.analysis.trajectories.result import EndReason, EventKind, Trajectory
from nonsmooth.analysis.trajectories.smooth_path import LoopLimit, LoopMemory
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import around
from tests.analysis.stick_slip import random_stick_slip, reference_events
from tests.conftest import Arrays, WheelData
from tests.oracles.floats import Floats
from tests.thorough import few, keep, thorough

# ---- Edges with sliding, rest or departure, against trajectories that start beside them and against closed forms.

STEP = 1e-6  # distance beside an edge, of lengths of order one
AHEAD = 1e-4  # time in which a path that slides is on the edge, and one that is repelled is away from it
NAMES = (
    "four-wheel",
    "four-wheel-side",
    "rectangle",
    "ring-5",
    "elliptic",
    "spiral-30",
    "saddle",
    "outward",
    "off-center",
)


def middle(stretch: SwitchingStretch) -> tuple[np.ndarray, np.ndarray]:
    """A point on the stretch away from its ends, and a unit normal."""
    start, end = np.array(stretch.start), np.array(stretch.end)
    along = (end - start) / np.hypot(*(end - start))
    return 0.55 * start + 0.45 * end, np.array([-along[1], along[0]])


@pytest.mark.parametrize("name", NAMES)
def test_paths_beside_an_edge_do_what_its_kind_says(name: str) -> None:
    partition = build_partition(load_scene(name))
    field = array_field(partition, Kinematics.EXACT)
    for stretch in switching_stretches(partition):
        point, normal = middle(stretch)
        for side in (1, -1):
            path = simulate(field, (*(point + side * STEP * normal), 0.0), AHEAD)
            kinds = {event.kind for event in path.events}
            off = abs(float(np.dot(path.array[-1, :2] - point, normal)))
            if stretch.kind is EdgeKind.REPELLING:
                assert kinds <= {EventKind.NONUNIQUE}
                assert off >= STEP / 2
            else:
                expected = EventKind.SLIDE if stretch.kind is EdgeKind.SLIDING else EventKind.REST
                assert expected in kinds
                assert off < STEP / 100


@pytest.mark.parametrize("name", NAMES)
def test_all_other_edges_are_crossed(name: str) -> None:
    """From the middle of an edge without a stretch, the two neighbours move to the same side."""
    partition = build_partition(load_scene(name))
    stretches = {frozenset(s.cells) for s in switching_stretches(partition)}
    cells = array_field(partition, Kinematics.EXACT).cells
    for edge in cells.edges:
        if edge.left is None or edge.right is None:
            continue
        beside = [partition.cells[k] for k in (edge.left, edge.right)]
        if frozenset(cell.index for cell in beside) in stretches:
            continue
        a, b = (np.array(cells.points[k], dtype=float) for k in (edge.start, edge.end))
        place, along = (a + b) / 2, b - a
        speeds = []
        for cell in beside:
            vx, vy, omega = (float(value) for value in cell.twists[0])
            speeds.append(along[0] * (vy + omega * place[0]) - along[1] * (vx - omega * place[1]))
        assert speeds[0] * speeds[1] >= 0


def kinds(partition: Partition) -> dict[EdgeKind, int]:
    found = [stretch.kind for stretch in switching_stretches(partition)]
    return {kind: found.count(kind) for kind in set(found)}


def test_the_papers_array() -> None:
    """Eq. (3): the axes are rest, the diagonals repel; eq. (4): everything slides inward."""
    assert kinds(build_partition(load_scene("four-wheel-side"))) == {EdgeKind.RESTING: 4, EdgeKind.REPELLING: 4}
    assert kinds(build_partition(load_scene("four-wheel"))) == {EdgeKind.SLIDING: 8}
    assert kinds(build_partition(load_scene("conveyor-3"))) == {}


def test_an_edge_may_change_its_kind_along_the_way() -> None:
    """On the elliptic array's rays between 30-degree sectors the normal speed vanishes at a point of the edge."""
    stretches = [s for s in switching_stretches(build_partition(load_scene("elliptic"))) if s.cells == (1, 3)]
    assert {s.kind for s in stretches} == {EdgeKind.SLIDING, EdgeKind.REPELLING}
    (outer,) = [s for s in stretches if s.kind is EdgeKind.SLIDING]
    (inner,) = [s for s in stretches if s.kind is EdgeKind.REPELLING]
    assert np.hypot(*outer.end) > np.hypot(*inner.start)


# ---- Slides on which both normal speeds vanish, in a point or on the way home: the weights there are no quotient.


ROLL = (1, Fraction(1, 2))
# Opposite pairs of wheels by seed, and starts whose paths slide into a two-fold.
TWO_FOLDS = [(177, (0.05438333, -0.79814939, -0.24)), (67, (-0.98065471, -0.99606556, 0.19279027))]
# The same, and paths that slide home along an edge, theta following c.
HOMECOMINGS = [(231, (-0.70211890, -0.38344367, 0.24)), (277, (-0.04006792, 0.20585195, -0.06291456))]
MOMENT = 1e-7  # half a time over which a velocity is read off a path
OFF = 1e-5  # of a velocity read off a path: its states err by 1e-12
BESIDE = 1e-6  # cells within this of a state are around it: more than the paths move in a moment


def closed_loop(scene: Scene, shape: tuple[float, float] = (0.0, 0.0), weight: float = 1.0) -> CellwiseField:
    """The array under the gradient law about its checked point, gain one."""
    centre = np.array([*map(float, scene.check.equilibrium), 0.0])
    centred = {s.name: s for cell in build_nearest_partition(scene.recentred()).cells for s in cell.states}
    law = gradient_law(1.0, shape, weight)

    def prepared(state: ContactState) -> Speeds:
        speeds = law(centred[state.name])
        return lambda pose: speeds(pose - centre)

    return feedback_field(build_nearest_partition(scene), prepared, Kinematics.EXACT)


def velocities_around(field: CellwiseField, x: Floats) -> Floats:
    """Fields of the cells beside a position, told from their sides alone."""
    beside = [
        member.velocity(0.0, x)
        for polygon, member in zip(field.cells.polygons, field.members, strict=True)
        if all(side.normal[0] * x[0] + side.normal[1] * x[1] <= side.offset + BESIDE for side in polygon.sides)
    ]
    return np.array(beside)


def distance_from_inclusion(field: CellwiseField, path: Trajectory, time: float) -> float:
    """How far the velocity of a path is from the hull of the velocities around; relative to these, if above one."""
    before, here, after = path.sample([time - MOMENT, time, time + MOMENT])
    around = velocities_around(field, here)
    return origin_distance(around - (after - before) / (2 * MOMENT)) / max(1.0, float(np.abs(around).max()))


def energies(path: Trajectory, shape: tuple[float, float] = (0.0, 0.0), weight: float = 1.0) -> Floats:
    """V along a path."""
    x, y, theta = path.array.T
    return np.asarray((1 + shape[0]) * x**2 + 2 * shape[1] * x * y + (1 - shape[0]) * y**2 + weight * theta**2)


def assert_is_a_solution(field: CellwiseField, path: Trajectory) -> None:
    """In the differential inclusion, at even times and close about every event."""
    events = np.unique([float(event.t) for event in path.events])
    late = [time + step for time in events for step in (1e-6, 1e-5, 1e-4, 1e-3)]
    times = [*np.linspace(1e-3, path.end.t - 1e-3, 300), *late]
    for time in times:
        if np.abs(events - time).min() > 2 * MOMENT and time < path.end.t - MOMENT:
            assert distance_from_inclusion(field, path, time) < OFF, time


@pytest.mark.parametrize("block", range(8))
@pytest.mark.parametrize(("seed", "start"), TWO_FOLDS)
def test_rounding_does_not_decide_how_a_two_fold_is_passed(
    arrays: Arrays, seed: int, start: tuple[float, float, float], block: int
) -> None:
    """Wherever among speeds that count as zero a slide is found to end: where one is, and where both are."""
    field = closed_loop(arrays.cocircular(seed, ROLL))
    for nearby in range(block, 60, 8):
        path = simulate(field, tuple(value * (1 + nearby * 1e-9) for value in start), 1.6)
        assert path.end.reason is EndReason.TIME
        assert path.unique is False


@few(1)
@pytest.mark.parametrize(("seed", "start"), TWO_FOLDS)
def test_a_slide_goes_through_a_two_fold(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    field = closed_loop(arrays.cocircular(seed, ROLL))
    path = simulate(field, start, 6.0)
    assert path.end.reason is EndReason.TIME
    assert len(path.events) < 50
    assert_is_a_solution(field, path)
    assert (np.diff(energies(path)) <= 1e-12).all()
    fold = next(event for event in path.events if event.kind == "nonunique")
    x = np.array(fold.state)
    around = velocities_around(field, x)
    across = np.array([-x[1], x[0], 0.0]) / np.hypot(*x[:2])  # the edges of these arrays lead to the origin
    assert np.abs(around @ across).max() <= 1e-8  # both are tangent
    assert np.ptp(around, axis=0).max() > 0.1  # and still differ
    assert path.unique is False


def test_a_stiff_slide_into_a_two_fold_is_followed(arrays: Arrays) -> None:
    shape, weight = (19 / 64, -41 / 64), 8.0  # of the V that is certified for this array
    wheels = [WheelData((-2, 1), (1, 0)), WheelData((-1, 2), (-1, 1)), WheelData((1, -2), (-1, -3))]
    scene = arrays.scene([*wheels, WheelData((1, 2), (2, 3))], ROLL, radius=Fraction(5, 2))
    field = closed_loop(scene, shape, weight)
    path = simulate(field, (0.1775988071108182, 1.412774159257611, 0.25322290401431646), 12.0)
    assert path.end.reason is EndReason.TIME
    assert "Radau" in path.method
    assert_is_a_solution(field, path)
    assert (np.diff(energies(path, shape, weight)) <= 1e-12).all()


def test_weights_in_a_two_fold_by_a_line_that_is_known() -> None:
    """With speeds ``N_1 = a, N_2 = b`` and constant drifts the slide on ``b = -2 a`` is a straight line."""
    drifts = {1: (1.0, -3.0), -1: (1.0, 0.0)}
    surfaces = (affine_surface("z", (0, 0, 1)),)
    field = SignField(
        ("a", "b", "z"), surfaces, lambda signs: lambda t, x: np.array([*drifts[signs[0]], x[0 if signs[0] > 0 else 1]])
    )
    share = 2 / 3  # l a + (1 - l) b = 0 on the line
    speed = share * np.array(drifts[1]) + (1 - share) * np.array(drifts[-1])
    path = simulate(field, (*(-speed), 0.0), 2.0)
    assert path.end.reason is EndReason.TIME
    assert np.allclose(path.sample([0.5, 1.0])[:, :2], [-speed / 2, 0 * speed], atol=1e-8)


@few(1)
@pytest.mark.parametrize(("seed", "start"), HOMECOMINGS)
def test_a_slide_comes_home(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    field = closed_loop(arrays.cocircular(seed, ROLL))
    path = simulate(field, start, 6.0)
    assert path.end.reason is EndReason.TIME
    assert path.unique
    assert len(path.times) < 1000  # tens of thousands before, and no end
    assert_is_a_solution(field, path)
    values = energies(path)
    assert (np.diff(values) <= 1e-12 * values[0]).all()
    assert values[-1] < 1e-30


@few(1)
@pytest.mark.parametrize(("seed", "start"), HOMECOMINGS)
def test_home_may_lie_anywhere(arrays: Arrays, seed: int, start: tuple[float, float, float]) -> None:
    """Rounding of the coordinates grows with the distance from their origin; the path does not care."""
    scene = arrays.cocircular(seed, ROLL)
    dx, dy = move = scene.field(Fraction(31, 7)), scene.field(Fraction(-45, 11))
    wheels = tuple(replace(w, position=(w.position[0] + dx, w.position[1] + dy)) for w in scene.wheels)
    moved = replace(scene, wheels=wheels, check=replace(scene.check, equilibrium=move))
    by = np.array([float(dx), float(dy), 0.0])
    times = np.linspace(0, 6, 25)
    far = simulate(closed_loop(moved), (np.array(start) + by).tolist(), 6.0).sample(times) - by
    assert np.abs(far - simulate(closed_loop(scene), start, 6.0).sample(times)).max() < 1e-9  # corners: 1e-10


# ---- Events of sliding of codimension two against references in closed form or in 40 digits ------

EVENT_ERROR = 1e-9
UNTIL = 2.5, 5.0


def follow(tmp_path: Path, states: str, rhs: list[str], start: list[float], until: float) -> Trajectory:
    file = tmp_path / "my.toml"
    file.write_text(f"[system]\nstates = {list(states)}\nrhs = {rhs}\n", encoding="utf-8")
    return simulate(system_field(load_system(file), start), start, until)


def event_times(path: Trajectory) -> list[float]:
    return [float(event.t) for event in path.events if event.t > 0 and event.kind is not EventKind.NONUNIQUE]


def test_leaving_a_line_of_two_surfaces(tmp_path: Path) -> None:
    """y' = -sign(y) + z with z = t: slides on x = y = 0 until z = 1 exactly, then y = (t - 1)^2/2."""
    path = follow(tmp_path, "xyz", ["-2*sign(x)", "-sign(y) + z", "1"], [0.1, 0.1, 0.0], 3.0)
    assert event_times(path) == pytest.approx([0.05, 1 - math.sqrt(0.8), 1.0], abs=1e-11)
    assert path.end.state == pytest.approx((0.0, 2.0, 3.0), abs=1e-11)
    assert path.unique


@pytest.mark.parametrize("rate", [1.0, 1e-2, 1e-4])
def test_slow_exits(tmp_path: Path, rate: float) -> None:
    """The same with z' = rate: from z = 1 - rate it slides for one unit of time."""
    rhs = ["-2*sign(x)", "-sign(y) + z", f"{rate:.4f}"]
    path = follow(tmp_path, "xyz", rhs, [0.0, 0.0, 1.0 - rate], 2.0)
    assert event_times(path) == pytest.approx([1.0], abs=EVENT_ERROR)


def test_an_exit_and_a_return_between_two_steps(tmp_path: Path) -> None:
    """z is a polynomial of the time, so that one step may cover it all: z - 1 = -(t - 1)(t - 2)(t - 3)(t - 4)/20.

    y leaves at t = 1 with y' = z - 1, and is back where the integral of that polynomial from 1 on is zero.
    """
    parts = ["(t - 2)*(t - 3)*(t - 4)", "(t - 1)*(t - 3)*(t - 4)", "(t - 1)*(t - 2)*(t - 4)", "(t - 1)*(t - 2)*(t - 3)"]
    rhs = ["-2*sign(x)", "-sign(y) + z", f"-({' + '.join(parts)})/20", "1"]
    path = follow(tmp_path, "xyzt", rhs, [0.0, 0.0, 1 - 24 / 20, 0.0], 5.0)
    gone = np.polynomial.Polynomial.fromroots([1, 2, 3, 4]).integ(lbnd=1)
    roots = np.asarray(gone.roots(), dtype=complex)
    back = min(float(r.real) for r in roots if abs(r.imag) < 1e-9 and r.real > 1 + 1e-3)
    assert event_times(path) == pytest.approx([1.0, back], abs=EVENT_ERROR)


@few(2)
@pytest.mark.parametrize("until", keep(1, UNTIL))
@pytest.mark.parametrize("number", range(40))
@pytest.mark.parametrize("states", ["xvyw", "xvywzu"])
def test_masses_on_a_belt(tmp_path: Path, states: str, number: int, until: float) -> None:
    """Two of them and three: sliding of codimension three is left on time too."""
    system, start = random_stick_slip(number, masses=len(states) // 2)
    times, end = reference_events(system, start, until)
    path = follow(tmp_path, states, system.formulas(), [float(v) for v in start], until)
    assert event_times(path) == pytest.approx([float(t) for t in times], abs=EVENT_ERROR)
    assert path.end.state == pytest.approx([float(v) for v in end], abs=EVENT_ERROR)
    assert path.unique


@few(1)
@pytest.mark.parametrize("seed", range(20))
def test_central_weights_against_a_linear_program(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(20):
        rank = int(rng.integers(1, 4))
        count = int(rng.integers(rank + 1, 9))
        vectors = rng.normal(size=(count, rank))
        if rank > 1 and rng.random() < 0.3:
            vectors[:, -1] = vectors[:, 0]
        equations = np.vstack([np.c_[vectors.T, np.zeros(rank)], [*np.ones(count), 0.0]])
        least = linprog(
            [*np.zeros(count), -1.0],
            A_ub=np.c_[-np.eye(count), np.ones(count)],
            b_ub=np.zeros(count),
            A_eq=equations,
            b_eq=[*np.zeros(rank), 1.0],
            bounds=[(None, None)] * (count + 1),
        )
        weights = central_weights(vectors)
        assert (weights is None) == (least.status != 0)
        if weights is not None:
            assert weights.sum() == pytest.approx(1.0)
            assert weights @ vectors == pytest.approx(np.zeros(rank), abs=1e-9)
            assert weights.min() == pytest.approx(-least.fun, rel=1e-7, abs=1e-9)
            assert (weights.min() >= 0) == bool(len(basic_weights(columns_of(vectors))))


@few(1)
@pytest.mark.parametrize("seed", range(10))
def test_programs_find_of_many_vectors_what_lists_hold(monkeypatch: pytest.MonkeyPatch, seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(10):
        rank = int(rng.integers(1, 4))
        count = int(rng.integers(rank + 1, 11))
        vectors, fields = rng.normal(size=(count, rank)) + rng.uniform(0, 0.5), rng.normal(size=(count, 4))
        if rank > 1 and rng.random() < 0.3:
            vectors[:, -1] = vectors[:, 0]
        central, shortest = central_weights(vectors), shortest_mixture(vectors, fields)
        extremes = extreme_mixtures(vectors, fields)
        with monkeypatch.context() as patched:
            patched.setattr(convex_weights, "MOST_SUBSETS", 0)
            assert central_weights(vectors) == (None if central is None else pytest.approx(central, abs=1e-8))
            sought, ends = shortest_mixture(vectors, fields), extreme_mixtures(vectors, fields)
        assert (sought is None) == (shortest is None) == (not len(extremes)) == (not len(ends))
        if sought is not None and shortest is not None:
            assert sought @ vectors == pytest.approx(np.zeros(rank), abs=1e-9)
            assert sought @ fields == pytest.approx(shortest @ fields, abs=1e-4)
            assert np.linalg.norm(sought @ fields) == pytest.approx(np.linalg.norm(shortest @ fields), abs=1e-8)
            assert ends.min(axis=0) == pytest.approx(extremes.min(axis=0), abs=1e-9)
            assert ends.max(axis=0) == pytest.approx(extremes.max(axis=0), abs=1e-9)


def test_where_five_surfaces_cross(tmp_path: Path) -> None:
    """32 fields meet there, of which six mix in 906,192 ways: these are not listed."""
    states, start = "abcde", [0.1, -0.2, 0.3, -0.4, 0.5]
    path = follow(tmp_path, states, [f"-sign({name})" for name in states], start, 1.0)
    assert event_times(path) == pytest.approx(np.abs(start), abs=EVENT_ERROR)
    assert path.end.state == pytest.approx(np.zeros(5), abs=EVENT_ERROR)
    assert path.unique


ESCAPING = [  # with the time at which the solution is infinite
    ("x", ["x**2"], [2.0], 1 / 2),
    ("x", ["x**5"], [-1.0], 1 / 4),
    ("xy", ["y", "2*x**3"], [1.0, 1.0], 1.0),
    ("xyz", ["-sign(x)", "y*Abs(y)", "-z"], [0.1, 4.0, 1.0], 1 / 4),
]


@pytest.mark.parametrize(("states", "rhs", "start", "time"), ESCAPING)
def test_escapes_in_finite_time_end_there(
    tmp_path: Path, states: str, rhs: list[str], start: list[float], time: float
) -> None:
    path = follow(tmp_path, states, rhs, start, 2.0)
    assert path.end.reason is EndReason.ESCAPES
    assert float(path.end.t) == pytest.approx(time, abs=EVENT_ERROR)


def test_what_grows_for_long_ends_where_floats_do(tmp_path: Path) -> None:
    """x = exp(t) is 1e150 at t = 345."""
    path = follow(tmp_path, "xy", ["x", "-y"], [1.0, 1.0], 900.0)
    assert path.end.reason is EndReason.FAR
    assert float(path.end.t) == pytest.approx(math.log(path.end.state[0]), rel=1e-9)
    assert 1e150 < path.end.state[0] < 1e154


LEFT_BY_OTHERS = [  # formulas, start, until, and whether no other solution leaves the corner that the path keeps to
    ("xy", ["sign(y)", "-sign(x) + sign(y)/2"], [0.0, 0.0], 1.0, False),  # turns grow threefold
    ("xy", ["sign(y)", "-sign(x) - sign(y)/2"], [0.0, 0.0], 1.0, True),
    ("xyz", [*(f"-sign({own}) + z*(1 + sign(x))*(1 + sign(y))/4" for own in "xy"), "1"], [0.0] * 3, 0.9, True),
    ("xyz", [*(f"-sign({own}) + z*(1 + sign(x))*(1 + sign(y))/4" for own in "xy"), "1"], [0.0] * 3, 1.5, False),
]


@pytest.mark.parametrize(("states", "rhs", "start", "until", "unique"), LEFT_BY_OTHERS)
def test_solutions_that_leave_along_a_slide_at_a_corner_are_told(
    tmp_path: Path, states: str, rhs: list[str], start: list[float], until: float, unique: bool
) -> None:
    """Beyond z = 1 both rates lead out of the corner where x and y are positive."""
    path = follow(tmp_path, states, rhs, start, until)
    assert path.end.state[:2] == (0.0, 0.0)
    assert path.unique is unique


def test_a_flat_secant_is_not_a_root() -> None:
    """A guard that only says yes and no: bisection goes on where the slope is zero."""
    assert find_root(lambda t: 1.0 if t < 0.3 else -1.0, (0.0, 1.0), (1.0, -1.0)) == pytest.approx(0.3, abs=1e-14)


# ---- Turns around a corner that get ever faster without a limit: the mean that is drawn, against the turns
# themselves.

STARTS = [((0.1, 0.1, 0.1), 8.0), ((0.1, 0.05, -0.1), 8.8), ((0.05, 0.2, 0.3), 5.9)]
DRAWN = 5e-4 * 0.5  # of the size of the square: the turns that are drawn as their corner


@pytest.fixture
def rectangle() -> CellwiseField:
    """The built-in array under the law that is certified for it."""
    return feedback_field(build_nearest_partition(load_scene("rectangle")), gradient_law(1.0), Kinematics.EXACT)


@thorough  # the small one: test_turns_end_neither_in_time_nor_at_rest
@pytest.mark.parametrize(("start", "until"), keep(1, STARTS))
def test_turns_ever_faster_are_followed_in_their_mean(
    rectangle: CellwiseField, monkeypatch: pytest.MonkeyPatch, start: tuple[float, float, float], until: float
) -> None:
    path = simulate(rectangle, start, until)
    assert path.end.reason is EndReason.TIME
    (event,) = [event for event in path.events if "mean" in event.note]
    monkeypatch.setattr(guards, "WHIRL_EXTENT", 0.0)
    turns = simulate(rectangle, start, until)
    assert len(turns.events) > 1.5 * len(path.events)
    times = np.linspace(float(event.t), until, 50)
    mean, literal = path.sample(times), turns.sample(times)
    assert np.abs(mean[:, :2] - literal[:, :2]).max() <= DRAWN
    assert np.abs(mean[:, 2] / literal[:, 2] - 1).max() <= 1e-3  # the mean over turns that last some 1e-2


@pytest.mark.parametrize(("start", "until"), keep(1, STARTS))
def test_turns_end_neither_in_time_nor_at_rest(
    rectangle: CellwiseField, start: tuple[float, float, float], until: float
) -> None:
    """On the way V falls; theta falls exponentially, however long that takes."""
    path = simulate(rectangle, start, 60.0)
    assert path.end.reason is EndReason.TIME
    assert path.unique
    assert (np.diff((path.array**2).sum(axis=1)) <= 1e-12).all()
    theta = path.sample(np.linspace(until, 60, 20))[:, 2]
    ratios = theta[1:] / theta[:-1]
    assert 0 < ratios.min() < ratios.max() < 1
    assert np.ptp(ratios) < 1e-3


@pytest.mark.parametrize(("gain", "lasts"), [(1.0, True), (0.99, True), (1.01, False)])
def test_a_mean_lasts_as_long_as_turns_do_not_grow(gain: float, lasts: bool) -> None:
    """Four quadrants, entered at the speed ``gain`` and left at one: by every one distance changes by that factor."""
    flows: dict[tuple[int, ...], tuple[float, float]] = {
        (1, 1): (-1.0, gain),
        (-1, 1): (-gain, -1.0),
        (-1, -1): (1.0, -gain),
        (1, -1): (gain, 1.0),
    }
    surfaces = (affine_surface("x", (1, 0)), affine_surface("y", (0, 1)))
    field = SignField(("x", "y"), surfaces, lambda signs: lambda t, x: np.array(flows[signs]))
    faces = field.faces_at(np.zeros(2))
    names = [face.name for face in faces if not face.keep]
    fields = {tuple(member.velocity(0, np.zeros(2))): member.name for member in faces[0].members}
    assert sorted(names) == sorted(fields.values())
    order = [(1, -1), (1, 1), (-1, 1), (-1, -1), (1, -1)]  # left through y = 0, x = 0, y = 0, ...
    turn = [
        guards.SurfaceCrossing(float(k), np.zeros(2), fields[flows[signs]], surfaces[(k + 1) % 2])
        for k, signs in enumerate(order)
    ]
    motion = guards.whirl_around(faces, turn, 5.0, np.zeros(2))
    assert (motion is not None) is lasts
    if motion is not None:
        assert np.allclose(motion(5.0, np.zeros(2)), 0)


# ---- A million switches and more: spirals that hardly contract, in floats, against the exact geometric series.
#
# The cells of an array around its corner nearest to the checked point get motions that turn about it and lose a given
# share of the distance per turn. The limit of infinitely many turns is a geometric series; time and condition (``1/(1
# - gain)``) follow from one turn of the floats as they are, exactly. Where the gain is not told from one, the path
# must not be summed: it ends with the largest number of events, or is taken for a closed orbit.

LOSSES = (1e-3, 1e-5, 1e-8, 1e-11)  # share of the distance lost per turn: some 1e5 to 1e13 switches
UNTOLD = 1e-14  # a loss that floats do not tell from none
ROUNDINGS = 256 * 2.0**-52  # of a turn: half a dozen quotients for each ray, and the series


@pytest.mark.parametrize("name", ["four-wheel", "ring-3", "ring-5", "spiral-30", "grid-4x4"])
def test_spirals_of_many_switches_end_where_the_series_does(name: str) -> None:
    field = array_field(build_partition(load_scene(name)), Kinematics.LEADING)
    corner = inner_corner(field)
    for loss in (*LOSSES, UNTOLD):
        turning, rays = turning_field(field, corner, loss)
        x, y = turning.cells.points[corner]
        distance = min(ray.reach for ray in rays) * DRAWN_DISTANCE / 4
        a, b = rays[0].direction
        end = simulate(turning, (x + distance * a, y + distance * b, 0.0), None).end
        gain, time = exact_turn(turning, rays, distance)
        if loss == UNTOLD:
            assert end.reason in {EndReason.EVENTS, EndReason.CIRCLES}
            continue
        error = max(abs(float(end.t) / float(time / (1 - gain)) - 1), abs(end.state[0] - x), abs(end.state[1] - y))
        assert error <= ROUNDINGS / float(1 - gain)


def inner_corner(field: ConstantField) -> int:
    """The corner nearest to the centre that no border of the domain meets and around which paths can turn."""
    x, y = field.centre
    found = []
    for k, (a, b) in enumerate(field.cells.points):
        junction = junction_at(field, AtCorner(k), (a, b))
        if not junction.border and len(junction.rays) > 2:
            found.append((math.hypot(a - x, b - y), k))
    return min(found)[1]


def turning_field(field: ConstantField, corner: int, loss: float) -> tuple[ConstantField, list[Ray]]:
    """Motions that turn counterclockwise about a corner, each along the chord of its cone, a little inward."""
    rays = list(junction_at(field, AtCorner(corner), field.cells.points[corner]).rays)
    rays.sort(key=lambda ray: math.atan2(ray.direction[1], ray.direction[0]))
    flows = list(field.flows)
    for ray, following in around(rays):
        a, b = np.array(ray.direction), np.array(following.direction)
        v = b - a - loss / len(rays) * b
        flows[ray.left] = (Flow(float(v[0]), float(v[1]), 0.0, 0.0),)
    return replace(field, flows=tuple(flows)), rays


def exact_turn(field: ConstantField, rays: Sequence[Ray], start: float) -> tuple[Fraction, Fraction]:
    """Gain and duration of one turn from a distance on the first ray, for the floats as they are."""
    distance, time = Fraction(start), Fraction(0)
    for ray, following in around(rays):
        flow = field.flows[ray.left][0]
        (a, b), (c, d) = (map(Fraction, pair) for pair in (ray.direction, following.direction))
        v, w = Fraction(flow.vx), Fraction(flow.vy)
        lasts = distance * (a * d - b * c) / (c * w - d * v)
        distance = ((distance * a + lasts * v) * c + (distance * b + lasts * w) * d) / (c * c + d * d)
        time += lasts
    return distance / Fraction(start), time


# ---- Limits of loops of crossings whose times are only as sure as slow crossings can be ----------

LIMIT = 2.0


def first_limit(ratio: float, noise: float, crossings: int = 60) -> LoopLimit | None:
    """Of a loop of two crossings a turn, ``LIMIT - t`` in a ratio, each time wrong by the noise over its speed."""
    memory, rng = LoopMemory(), np.random.default_rng(0)
    left = ratio ** (np.arange(crossings) / 2)
    for k, (rest, wrong) in enumerate(zip(left, rng.uniform(-noise, noise, crossings), strict=True)):
        time = LIMIT - rest + wrong / rest
        found = memory.limit_after(time, np.array([0.0, (-1.0) ** k * rest]), "+-"[k % 2], 10.0)
        if found is not None:
            return found
    return None


@pytest.mark.parametrize("ratio", [0.02, 0.16, 0.6])
@pytest.mark.parametrize("noise", [0.0, 1e-14, 1e-12])
def test_limits_are_as_sure_as_crossings_are(ratio: float, noise: float) -> None:
    found = first_limit(ratio, noise)
    assert found is not None
    assert found.time == pytest.approx(LIMIT, abs=1e-11 if noise == 0 else 1e-7)
    assert np.abs(found.x).max() < 1e-6


def test_loops_that_are_not_regular_have_no_limit() -> None:
    assert first_limit(0.16, 1e-6, crossings=12) is None
