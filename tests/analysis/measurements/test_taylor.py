"""Reference paths at 60 digits against closed forms, and where they must stop."""

from __future__ import annotations

import math
from fractions import Fraction

import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.analysis.fields.cellwise_field import feedback_field
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.feedback_laws import gradient_law
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.system_field import constant_system
from nonsmooth.analysis.measurements.reference_paths import (
    ReferencePiece,
    array_pieces,
    follow_series,
    gradient_pieces,
    system_pieces,
)
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_file import load_system
from tests.conftest import Arrays
from tests.four_wheel import CORNERS

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
    exact = constant_system(scene, exact=True)
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
