"""References of the studies: exact paths and twists, minimizers to sixty digits, Taylor series."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction

import mpmath
import numpy as np
import pytest

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.constant_field import array_field, feedback_field
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.feedback_laws import gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.system_field import constant_system
from nonsmooth.analysis.measurements.reference_paths import (
    STARTS,
    ExactPath,
    ReferencePiece,
    array_pieces,
    follow_series,
    gradient_pieces,
    reference_paths,
    system_pieces,
)
from nonsmooth.analysis.measurements.studies import (
    DIGITS,
    POINTS,
    ReferenceTwist,
    box_references,
    ellipse_references,
)
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.trajectories.result import Event, EventKind
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.four_wheel import CORNERS
from tests.thorough import few

# ---- The references of the studies: exact paths, exact twists of cells, and minimizers to sixty digits.

ROUNDING = 1e-13
STEP = mpmath.mpf(10) ** -40  # of difference quotients: their error is of the order of its square
BESIDE = mpmath.mpf(10) ** -50  # from the minimizer: too far for sixty digits
WORKING = 150  # digits


def four_wheel_paths() -> tuple[ExactPath, ...]:
    return reference_paths(build_partition(load_scene("four-wheel")))[1]


# ---- paths ---------------------------------------------------------------------------------------


def test_four_wheels_arrive_as_the_closed_form_says() -> None:
    """T = (|x| + |y|)/sqrt 2; the comparison ends at 15/16 of it, where the drift becomes free."""
    paths = four_wheel_paths()
    assert len(paths) == len(STARTS)
    for path in paths:
        x, y, _ = path.start
        assert path.until == pytest.approx(15 / 16 * (abs(x) + abs(y)) / math.sqrt(2), rel=1e-12)
        assert path.path.unique is False
        assert [event.kind for event in path.events] == [EventKind.SLIDE]
        assert float(path.events[0].t) == pytest.approx(abs(abs(y) - abs(x)) / math.sqrt(2), rel=1e-12)


CELLS = [(name, "nearest") for name in builtin_scenes()] + [(name, "box") for name in ("off-center", "ring-5")]


@few(4)
@pytest.mark.parametrize(("name", "rule"), CELLS)
def test_paths_are_compared_inside_the_square_and_while_they_are_unique(name: str, rule: str) -> None:
    scene = load_scene(name, rule=rule)
    radius = float(scene.check.radius)
    for path in reference_paths(build_partition(scene))[1]:
        assert all(event.kind is not EventKind.NONUNIQUE for event in path.events)
        for share in (0, 0.5, 1):
            state = path.path.at(Fraction(share * path.until))
            offsets = [abs(float(s - c)) for s, c in zip(state, scene.check.equilibrium, strict=False)]
            assert max(offsets) < radius


def test_starts_of_several_paths_are_left_out() -> None:
    """About (1/4, 1/8) two starts lie on edges of the four-wheel array along which theta is free at once."""
    scene = load_scene("four-wheel")
    at = (scene.field(Fraction(1, 4)), scene.field(Fraction(1, 8)))
    paths = reference_paths(build_partition(replace(scene, check=replace(scene.check, equilibrium=at))))[1]
    starts = [path.start[:2] for path in paths]
    assert len(starts) == len(STARTS) - 2
    assert not {(0.0, -0.28125), (-0.0625, 0.0)} & set(starts)
    assert all(event.kind is not EventKind.NONUNIQUE for path in paths for event in path.events)


@few(1)
@pytest.mark.parametrize("shift", [1e-3, 1e-12, 3e-17])
def test_a_shifted_path_errs_by_its_shift(shift: float) -> None:
    """Also by less than the rounding of floats, because differences are exact."""
    path = four_wheel_paths()[0]
    times = [Fraction(k, 1000) * Fraction(path.until) for k in range(1001)]
    states = [path.path.at(t) for t in times]
    moved = [(x, y + Fraction(shift), theta) for x, y, theta in states]
    assert path.path_error(times, states) == 0
    assert path.path_error(times, moved) == pytest.approx(shift, rel=1e-12)


def test_event_times_are_compared_at_the_same_edges() -> None:
    path = next(p for p in reference_paths(build_partition(load_scene("spiral-30")))[1] if len(p.events) > 1)
    late = Fraction(1, 1000)
    moved = [replace(event, t=event.t + late) for event in path.events]
    elsewhere = Event(0.0, path.start, EventKind.CROSS, "cell 98 | cell 99")
    swapped = [replace(event, surface=" | ".join(reversed(event.surface.split(" | ")))) for event in moved]
    for events in (moved, [elsewhere, *moved], swapped):
        assert path.event_error(events) == pytest.approx(float(late))
    assert path.event_error([elsewhere]) is None


# ---- twists --------------------------------------------------------------------------------------


@few(2)
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "grid-4x4", "off-center"])
def test_box_references_are_what_linear_programs_find(name: str) -> None:
    scene = load_scene(name, rule="box")
    references = box_references(build_box_partition(scene))
    assert len(references) == POINTS
    model = contact_model(scene)
    found = BoxHighs().minimize(model, loads_at(model, [r.point for r in references])).twists
    assert max(r.error(twist) for r, twist in zip(references, found, strict=True)) < ROUNDING


def dissipation(scene: Scene, loads: list[mpmath.mpf], twist: list[mpmath.mpf]) -> mpmath.mpf:
    """D of rule ``ellipse``, literally, in mpmath."""
    total = mpmath.mpf(0)
    for wheel, load in zip(scene.wheels, loads, strict=True):
        p, d = ([digits(x) for x in pair] for pair in (wheel.position, wheel.unit_direction))
        velocity = [twist[0] - twist[2] * p[1], twist[1] + twist[2] * p[0]]
        along = d[0] * velocity[0] + d[1] * velocity[1] - digits(wheel.speed)
        across = -d[1] * velocity[0] + d[0] * velocity[1]
        total += load * mpmath.hypot(digits(wheel.friction.roll) * along, digits(wheel.friction.side) * across)
    return total


def digits(number: object) -> mpmath.mpf:
    """A number of the scene by way of SymPy."""
    return mpmath.mpf(number.to_sympy().evalf(WORKING))  # type: ignore[attr-defined]


def least_norm_loads(scene: Scene, point: tuple[float, float]) -> list[mpmath.mpf]:
    """Elastic loads where no spring lifts off: N = M^T (M M^T)^-1 (1, c)."""
    moments = mpmath.matrix([[1] * len(scene.wheels), *([digits(w.position[k]) for w in scene.wheels] for k in (0, 1))])
    goal = mpmath.matrix([1, point[0], point[1]])
    return list(moments.T * mpmath.lu_solve(moments * moments.T, goal))


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "off-center"])
def test_ellipse_references_are_minimizers_to_sixty_digits(name: str) -> None:
    """The slopes of a literal D vanish there, and are seen a little beside it."""
    scene = load_scene(name)
    references = ellipse_references(scene)
    assert references
    with mpmath.workdps(WORKING):
        for reference in references[:3]:
            loads = least_norm_loads(scene, reference.point)
            twist = [mpmath.mpf(entry.str(WORKING, radius=False)) for entry in reference.twist]
            assert largest_slope(scene, loads, twist) < mpmath.mpf(10) ** -DIGITS
            assert largest_slope(scene, loads, [twist[0] + BESIDE, *twist[1:]]) > mpmath.mpf(10) ** -DIGITS


def largest_slope(scene: Scene, loads: list[mpmath.mpf], twist: list[mpmath.mpf]) -> mpmath.mpf:
    """Largest central difference quotient of D; D is convex, so it is zero at minimizers only."""
    slopes = []
    for k in range(3):
        ahead, behind = (
            dissipation(scene, loads, [t + sign * STEP * (j == k) for j, t in enumerate(twist)]) for sign in (1, -1)
        )
        slopes.append(abs(ahead - behind) / (2 * STEP))
    return max(slopes)


def test_an_error_is_formed_before_it_is_rounded() -> None:
    scene = load_scene("four-wheel", rule="box")
    exact = box_references(build_box_partition(scene))[0]
    rounded = np.array([float(entry) for entry in exact.twist])
    truth = max(abs(float(e - Fraction(float(r)))) for e, r in zip(exact.twist, rounded, strict=True))
    assert ReferenceTwist(exact.point, exact.twist).error(rounded) == truth
    assert exact.error(rounded + np.array([0, 0, 0.5])) == pytest.approx(0.5)


# ---- Reference paths at 60 digits against closed forms, and where they must stop -----------------

LAST_DIGIT = 2.0**-52


def test_an_oscillator_is_sines_to_the_last_digit_of_a_float() -> None:
    piece = ReferencePiece((lambda x: x[0] * 0 + 10,), (lambda x: x[1], lambda x: -x[0]))
    path = follow_series([piece], (1.0, 0.0), 20.0)
    assert path.reason == ""
    assert path.state == pytest.approx((math.cos(20), -math.sin(20)), abs=LAST_DIGIT)


@pytest.mark.parametrize("gain", [1e-9, 1.0, 1e9])
def test_decay_in_any_unit_of_time(gain: float) -> None:
    piece = ReferencePiece((lambda x: x[0] * 0 + 1,), (lambda x: x[0] * -gain,))
    path = follow_series([piece], (0.5,), 3 / gain)
    assert path.state[0] == pytest.approx(0.5 * math.exp(-3), rel=4 * LAST_DIGIT)


def test_crossings_of_relays_are_exact() -> None:
    scene, start = load_system("relay-oscillator"), (0.3125, 0.171875)
    exact = constant_system(scene)
    assert exact is not None
    path = follow_series(system_pieces(scene), start, 5.0)
    wanted = simulate(exact, (*(Fraction(x) for x in start), 0), Fraction(5)).end.state
    assert (path.crossings, path.reason) == (10, "")
    assert path.state == pytest.approx([float(x) for x in wanted[:2]], abs=LAST_DIGIT)


def test_arcs_of_an_array() -> None:
    partition = build_nearest_partition(load_scene("spiral-30"))
    start = (0.31, 0.17, 0.1)
    path = follow_series(array_pieces(partition, Kinematics.EXACT), start, 0.3)
    closed = simulate(array_field(partition, Kinematics.EXACT), start, path.time).end.state
    assert path.state == pytest.approx(closed, abs=64 * LAST_DIGIT)


def test_a_loop_about_a_point_away_from_the_origin(arrays: Arrays) -> None:
    partition = build_nearest_partition(arrays.scene(arrays.inward(CORNERS), at=(Fraction(1, 4), Fraction(1, 8))))
    start = (0.41, 0.27, 0.3)
    reached = follow_series(gradient_pieces(partition, 1.0), start, 0.7)
    path = simulate(feedback_field(partition, gradient_law(1.0), Kinematics.LEADING), start, reached.time)
    assert reached.crossings > 0
    assert reached.state == pytest.approx(path.end.state, abs=1e-11)


def test_sliding_and_corners_end_the_reference() -> None:
    path = follow_series(system_pieces(load_system("escaping-slide")), (0.25, 0.0), 1.0)
    assert path.time == 0.25
    assert path.state == pytest.approx((0.0, 0.25))
    assert path.reason != ""
    corner = follow_series(system_pieces(load_system("eq-4")), (0.25, 0.25 + 2**-40), 1.0)
    assert corner.reason != ""
    loop = gradient_pieces(build_nearest_partition(load_scene("four-wheel")), 1.0)
    with pytest.raises(ValueError, match="inside one piece"):
        follow_series(loop, (0.0, 0.1, 0.0), 1.0)


def test_a_side_that_is_only_touched_is_not_crossed() -> None:
    """x = (t - 1)^2 touches zero: the reference cannot tell which piece rules, and ends."""
    right = ReferencePiece((lambda x: x[0],), (lambda x: x[1] * 2, lambda x: x[1] * 0 + 1))
    left = ReferencePiece((lambda x: -x[0],), (lambda x: x[1] * 0 - 1, lambda x: x[1] * 0 + 1))
    path = follow_series([right, left], (1.0, -1.0), 2.0)
    assert path.time == pytest.approx(1, abs=1e-15)
    assert path.reason != ""
