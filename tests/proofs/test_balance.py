from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import minimize

from nonsmooth.analysis.cells.loads import LoadRegion, load_regions, value_at
from nonsmooth.proofs.boxes.linearization import linearize
from nonsmooth.proofs.clauses.at_point.ellipse import rest_balance
from nonsmooth.proofs.clauses.authority import roll_authority
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.conftest import Arrays
from tests.four_wheel import ROLL, SIDE
from tests.proofs.forces_oracle import solves
from tests.ruled import ruled

Pair = tuple[Fraction | int, Fraction | int]


def ellipse_twist(scene: Scene, region: LoadRegion, point: tuple[Fraction, Fraction]) -> np.ndarray:
    """Minimizer of the smooth ellipse functional near rest, by a general-purpose solver."""
    c = (scene.field(point[0]), scene.field(point[1]))
    loads = np.array([float(value_at(form, c)) for form in region.forces])
    p = np.array([[float(x) for x in w.position] for w in scene.wheels])
    d = np.array([[float(x) for x in w.unit_direction] for w in scene.wheels])
    n = np.stack([-d[:, 1], d[:, 0]], axis=1)
    arm = np.stack([-p[:, 1], p[:, 0]], axis=1)
    roll = np.column_stack([d, (d * arm).sum(1)])
    side = np.column_stack([n, (n * arm).sum(1)])
    speed = np.array([float(w.speed) for w in scene.wheels])
    mu_r = np.array([float(w.friction.roll) for w in scene.wheels])
    mu_s = np.array([float(w.friction.side) for w in scene.wheels])

    def total(xi: np.ndarray) -> float:
        return float((loads * np.hypot(mu_r * (roll @ xi - speed), mu_s * (side @ xi))).sum())

    def gradient(xi: np.ndarray) -> np.ndarray:
        r, s = roll @ xi - speed, side @ xi
        length = np.hypot(mu_r * r, mu_s * s)
        return roll.T @ (loads * mu_r**2 * r / length) + side.T @ (loads * mu_s**2 * s / length)

    result = minimize(total, np.zeros(3), jac=gradient, method="BFGS", options={"gtol": 1e-14, "xrtol": 1e-15})
    return np.asarray(result.x)


@pytest.mark.parametrize("friction", [ROLL, (1, Fraction(1, 10)), SIDE])
def test_four_wheel_closed_form(arrays: Arrays, friction: Pair) -> None:
    """c' = -sqrt2 (mu_R/mu_S)^2 c, no rotation."""
    scene = ruled(arrays.four_wheel(friction), "ellipse")
    (region,) = load_regions(scene)
    assert not any(rest_balance(scene, region).residual)
    linear = linearize(scene, region, scene.field.zero)
    assert linear is not None
    ratio = Fraction(friction[0]) / Fraction(friction[1])
    rate = -scene.field.sqrt(2) * ratio * ratio
    zero = scene.field.zero
    assert linear.translation == ((rate, zero), (zero, rate))
    assert linear.rotation_map == (zero, zero)
    assert linear.spectral_abscissa == rate
    assert solves(linear)


@pytest.mark.parametrize("sides", [(1, 1, 1, 1), (1, 2, 3, 4), (3, 1, 1, 5)])
def test_linearization_against_a_minimizer(arrays: Arrays, sides: tuple[int, ...]) -> None:
    """The twist at a small c agrees with M c up to second order; mu_S differs from wheel to wheel."""
    scene = ruled(arrays.four_wheel(), "ellipse")
    wheels = (
        replace(w, friction=replace(w.friction, side=scene.field(side) / 3))
        for w, side in zip(scene.wheels, sides, strict=True)
    )
    scene = replace(scene, wheels=tuple(wheels))
    (region,) = load_regions(scene)
    assert not any(rest_balance(scene, region).residual)
    linear = linearize(scene, region, scene.field.zero)
    assert linear is not None
    small = Fraction(1, 1000)
    for point in ((small, Fraction(0)), (Fraction(0), small), (small, -small)):
        predicted = sum(
            np.array([float(x) for x in column]) * float(s) for column, s in zip(linear.columns, point, strict=True)
        )
        found = ellipse_twist(scene, region, point)
        # relative to the twist: the second-order term is of the order of |c| / mu_S
        assert np.abs(found - predicted).max() < 2e-2 * np.abs(predicted).max()


def test_a_wheel_out_of_balance_is_refuted(arrays: Arrays) -> None:
    scene = ruled(arrays.four_wheel(), "ellipse")
    wheels = (replace(scene.wheels[0], given_speed=scene.field(-1)), *scene.wheels[1:])
    scene = replace(scene, wheels=wheels)
    (region,) = load_regions(scene)
    balance = rest_balance(scene, region)
    assert any(balance.residual)
    assert not balance.strict


def test_wheels_that_stick_hold_the_body_at_rest(arrays: Arrays) -> None:
    """Two driven, two braking wheels: the brakes answer any small imbalance."""
    scene = ruled(arrays.four_wheel(), "ellipse")
    zero = scene.field.zero
    wheels = tuple(replace(w, given_speed=zero) if w.index % 2 == 0 else w for w in scene.wheels)
    scene = replace(scene, wheels=wheels)
    (region,) = load_regions(scene)
    balance = rest_balance(scene, region)
    assert balance.stuck
    assert balance.strict
    rest = ellipse_like_value(scene, region, np.zeros(3))
    rng = np.random.default_rng(0)
    assert all(ellipse_like_value(scene, region, rng.normal(size=3) * 1e-3) > rest for _ in range(200))


def ellipse_like_value(scene: Scene, region: LoadRegion, xi: np.ndarray) -> float:
    total = 0.0
    for wheel, form in zip(scene.wheels, region.forces, strict=True):
        d, p = ([float(x) for x in v] for v in (wheel.unit_direction, wheel.position))
        vx, vy = xi[0] - xi[2] * p[1], xi[1] + xi[2] * p[0]
        r, s = d[0] * vx + d[1] * vy - float(wheel.speed), -d[1] * vx + d[0] * vy
        total += float(form[0]) * np.hypot(float(wheel.friction.roll) * r, float(wheel.friction.side) * s)
    return total


def test_torque_authority_is_the_rank_of_the_roll_rows(arrays: Arrays) -> None:
    scene = ruled(arrays.four_wheel(), "ellipse")
    inward = roll_authority(scene)
    zero, one = scene.field.zero, scene.field.one
    assert (inward.rank, inward.missing) == (2, ((zero, zero, one),))
    tangential = arrays.four_wheel(turn=(0, 1))
    assert roll_authority(tangential).rank == 3
    parallel = arrays.scene([w._replace(direction=(1, 0)) for w in arrays.inward([(1, 0), (-1, 0), (2, 0)])])
    assert roll_authority(parallel).rank == 1


def test_rims_on_one_line_through_the_point_leave_two_twists_missing(arrays: Arrays) -> None:
    """Their row has no moment: the missing twists are the motion across it and the rotation."""
    scene = arrays.scene(arrays.inward([(1, Fraction(3, 2)), (-1, Fraction(-3, 2))]), ROLL)
    authority = roll_authority(scene)
    assert authority.rank == 1
    assert np.linalg.matrix_rank(np.array([[float(x) for x in twist] for twist in authority.missing])) == 2
    assert check_theorem4(scene).check()


@pytest.mark.parametrize("seed", range(20))
def test_torque_authority_against_numerical_rank(arrays: Arrays, seed: int) -> None:
    scene = arrays.cocircular(seed)
    rows = []
    for wheel in scene.wheels:
        d, p = ([float(x) for x in v] for v in (wheel.direction, wheel.position))
        rows.append([*d, d[1] * p[0] - d[0] * p[1]])
    authority = roll_authority(scene)
    assert authority.rank == np.linalg.matrix_rank(np.array(rows))


def many_wheels(arrays: Arrays, rows: int) -> Scene:
    """A grid under the rims (-x, -2 y), with side friction that differs from wheel to wheel."""
    scene = arrays.grid(rows, rows)
    wheels = [
        replace(
            wheel,
            direction=(wheel.direction[0], wheel.direction[1] * 2),
            friction=replace(wheel.friction, side=scene.field(1 + k % 3) / 4),
        )
        for k, wheel in enumerate(scene.wheels)
    ]
    return replace(scene, wheels=tuple(wheels))


@pytest.mark.parametrize("rows", [4, 10])
def test_many_square_roots_leave_the_linearization_exact(arrays: Arrays, rows: int) -> None:
    """An exact inverse of det H would have up to 2^r terms over r square roots: quotients are put off."""
    scene = ruled(many_wheels(arrays, rows), "ellipse")
    linear = linearize(scene, load_regions(scene)[0], scene.field.zero)
    assert linear is not None
    assert solves(linear)
    assert not solves(replace(linear, columns=(linear.columns[1], linear.columns[0])))
    hessian, slope = (np.array([[float(x) for x in row] for row in part]) for part in (linear.hessian, linear.slope))
    motion = -np.linalg.solve(hessian, slope.T)
    columns = np.array([[float(x) for x in column] for column in linear.columns])
    assert np.abs(columns.T - motion).max() < 1e-12
    rates = np.linalg.eigvals(motion[:2])
    assert float(linear.spectral_abscissa) == pytest.approx(rates.real.max(), rel=1e-12)
    turned = -motion[2] @ np.linalg.inv(motion[:2])
    assert [float(x) for x in linear.rotation_map] == pytest.approx(turned, abs=1e-12)
    assert np.abs(turned).max() > 1e-3
