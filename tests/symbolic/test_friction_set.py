"""Friction sets and friction axes, the same in every arithmetic."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_states import (
    Twist,
    combine,
    free_text,
    free_twists,
    regular_states,
    rows_with_friction,
    scene_rows,
    take_census,
    triples_with_friction,
    with_rims_along_axes,
)
from nonsmooth.symbolic.mechanics.equations import input_symbol, wheel_constraints
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece, Box, CutEllipse, FrictionSet, float_sets
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.thorough import examples

# ---- Friction sets: support function, gradient and Hessian against the set itself, the same in every arithmetic.

SETS = [(1, 1, 1), (2, Fraction(1, 2), 1), (1, 1, Fraction(1, 2)), (2, 2, Fraction(1, 20)), (3, 0, 1)]
STEP = 1e-5  # of differences

small = st.fractions(-3, 3, max_denominator=8)
sets = pytest.mark.parametrize("entries", SETS, ids=str)


def exact_set(entries: tuple[int, int, Fraction | int]) -> FrictionSet:
    field = NumberField()
    return CutEllipse(*(field(entry) for entry in entries))


def border(limits: CutEllipse[float]) -> np.ndarray:
    """Forces all along the border of the set, shape (k, 2), corners included."""
    angles = np.linspace(0, 2 * np.pi, 200_001)
    heights = np.clip(np.sin(angles), -limits.cut, limits.cut)
    ends = np.sqrt(1 - limits.cut**2) * np.array([[1, 1], [1, -1], [-1, 1], [-1, -1]])
    ends[:, 1] = limits.cut * np.array([1, -1, 1, -1])
    forces = np.concatenate([np.column_stack([np.cos(angles), heights]), ends])
    return forces * [limits.along, limits.across]


@sets
def test_the_support_function_is_the_most_that_a_force_takes(entries: tuple[int, int, Fraction | int]) -> None:
    limits = exact_set(entries).map(float)
    forces = border(limits)
    rng = np.random.default_rng(0)
    for r, s in rng.normal(size=(40, 2)):
        powers = forces @ (r, s)
        assert limits.support(r, s) == pytest.approx(powers.max(), rel=1e-9)
        assert limits.gradient(r, s) == pytest.approx(tuple(forces[powers.argmax()]), abs=1e-4 * float(limits.along))


@sets
def test_derivatives_are_those_of_differences(entries: tuple[int, int, Fraction | int]) -> None:
    limits = exact_set(entries).map(float)
    for r, s in np.random.default_rng(1).normal(size=(40, 2)):
        if limits.piece(r, s) is not limits.piece(r, s + STEP) or limits.piece(r, s - STEP) is not limits.piece(r, s):
            continue
        by_r = np.subtract(limits.gradient(r + STEP, s), limits.gradient(r - STEP, s)) / (2 * STEP)
        by_s = np.subtract(limits.gradient(r, s + STEP), limits.gradient(r, s - STEP)) / (2 * STEP)
        rr, rs, ss = limits.hessian(r, s)
        size = 1 + limits.along * limits.across / np.hypot(r, s)
        np.testing.assert_allclose([*by_r, *by_s], [rr, rs, rs, ss], atol=1e-3 * size)
        slope = (limits.support(r + STEP, s) - limits.support(r - STEP, s)) / (2 * STEP)
        assert slope == pytest.approx(limits.gradient(r, s)[0], abs=1e-3 * limits.along)


@sets
@given(small, small)
@examples(60)
def test_every_arithmetic_says_the_same(entries: tuple[int, int, Fraction | int], r: Fraction, s: Fraction) -> None:
    exact = exact_set(entries)
    field = exact.along.field
    floats, balls, many = exact.map(float), exact.map(lambda number: number.ball()), float_sets([exact, exact])
    slips = (field(r), field(s)), (float(r), float(s)), (field(r).ball(), field(s).ball())
    pieces = [one.piece(*slip) for one, slip in zip((exact, floats, balls), slips, strict=True)]
    assert pieces[2] in {pieces[0], BorderPiece.OPEN}
    assert pieces[1] is pieces[0] or BorderPiece.SEAM in pieces
    if pieces[2] in {BorderPiece.KINK, BorderPiece.OPEN} or pieces[0] is BorderPiece.KINK:
        return
    for name in ("support", "gradient", "hessian"):
        found = [np.ravel([getattr(one, name)(*slip)]) for one, slip in zip((exact, floats, balls), slips, strict=True)]
        together = np.array(getattr(many, name)(np.full(2, float(r)), np.full(2, float(s)))).reshape(-1, 2)
        if name == "hessian" and BorderPiece.SEAM in pieces:
            continue  # there are two
        for number, rounded, ball, column in zip(*found, together, strict=True):
            assert ball.overlaps(number.ball())
            np.testing.assert_allclose([rounded, *column], float(number), rtol=1e-12, atol=1e-12)


@sets
def test_where_no_force_is_determined_none_is_said(entries: tuple[int, int, Fraction | int]) -> None:
    exact = exact_set(entries)
    zero = exact.along.field.zero
    assert exact.piece(zero, zero) is BorderPiece.KINK
    with pytest.raises(ValueError, match="required slips that determine a force"):
        exact.gradient(zero, zero)
    balls = exact.map(lambda number: number.ball())
    assert balls.piece(arb(0, 1), arb(0, 1)) is BorderPiece.OPEN
    with pytest.raises(ValueError, match="required slips that determine a force"):
        balls.hessian(arb(0, 1), arb(0, 1))
    many = float_sets([exact])
    forces = np.array(many.gradient(np.zeros(1), np.zeros(1)))[:, 0]
    np.testing.assert_array_equal(forces, 0.0)


def test_a_slip_across_a_straight_side_meets_a_force_of_it() -> None:
    cut = exact_set((1, 1, Fraction(1, 2)))
    zero, one = cut.along.field.zero, cut.along.field.one
    assert cut.piece(zero, one) is BorderPiece.KINK
    assert np.array(float_sets([cut]).gradient(np.zeros(1), np.ones(1)))[:, 0].tolist() == [0.0, 0.5]


def test_forces_inside() -> None:
    cut = exact_set((1, 1, Fraction(1, 2)))
    field = cut.along.field
    inside: list[tuple[Fraction | int, Fraction | int]] = [
        (0, 0),
        (Fraction(9, 10), 0),
        (Fraction(4, 5), Fraction(49, 100)),
    ]
    outside: list[tuple[Fraction | int, Fraction | int]] = [
        (1, 0),
        (0, Fraction(1, 2)),
        (Fraction(9, 10), Fraction(49, 100)),
    ]
    assert all(cut.holds_strictly(field(x), field(y)) for x, y in inside)
    assert not any(cut.holds_strictly(field(x), field(y)) for x, y in outside)


# ---- arrays: rounded edges, intervals, boxes ------------------------------------------------------


def many(shape: Any, count: int) -> CutEllipse[Any]:
    """Sets of random half-axes, some of them cut."""
    rng = np.random.default_rng(5)
    cuts = np.ones(count) if shape is Box else np.minimum(rng.uniform(0.1, 1.6, count), 1.0)
    return shape(*rng.uniform(0.2, 2.0, (2, count)), cuts)


def random_slips(count: int) -> np.ndarray:
    rng = np.random.default_rng(6)
    return np.asarray(rng.normal(size=(2, count)) * 10.0 ** rng.uniform(-5, 0, (2, count)))


@pytest.mark.parametrize("shape", [CutEllipse, Box])
def test_no_force_takes_more_than_the_support_function(shape: Any) -> None:
    limits, (r, s) = many(shape, 400), random_slips(400)
    most, (f, g) = limits.support(r, s), limits.gradient(r, s)
    np.testing.assert_allclose(f * r + g * s, most, rtol=1e-12)
    np.testing.assert_allclose(limits.gauge(f / limits.along, g / limits.across), 1, rtol=1e-12)
    for x, y in np.random.default_rng(7).normal(size=(50, 2)):
        size = limits.gauge(np.full(400, x), np.full(400, y))
        assert (limits.along * x * r + limits.across * y * s <= size * most * (1 + 1e-12)).all()


@pytest.mark.parametrize("shape", [CutEllipse, Box])
def test_rounded_forces_lie_inside_and_tend_to_those_at_the_border(shape: Any) -> None:
    limits, (r, s) = many(shape, 400), random_slips(400)
    for width in (1.0, 1e-3):
        f, g = limits.rounded_gradient(r, s, limits.along * width)
        assert (limits.gauge(f / limits.along, g / limits.across) <= 1 + 1e-15).all()
        step = 1e-6 * (width + np.hypot(r, s))
        by_r = (limits.rounded_gradient(r + step, s, limits.along * width)[0] - f) / step
        rr, _, ss = limits.rounded_hessian(r, s, limits.along * width)
        assert (rr >= 0).all()
        assert (ss >= 0).all()
        smooth = np.abs(by_r - rr) <= 1e-3 * (np.abs(rr) + limits.along / (width + np.hypot(r, s)))
        assert smooth.mean() > 0.98  # but where arc and corner meet
    sharp = limits.rounded_gradient(r, s, limits.along * 1e-12)
    np.testing.assert_allclose(sharp, limits.gradient(r, s), atol=1e-5)


@pytest.mark.parametrize("shape", [CutEllipse, Box])
@pytest.mark.parametrize("width", [0.0, 1e-12, 0.3])
def test_intervals_hold_the_support_functions_of_all_members(shape: Any, width: float) -> None:
    limits, (r, s), rng = many(shape, 400), random_slips(400), np.random.default_rng(8)

    def around(middle: np.ndarray, most: float = np.inf) -> Intervals:
        return Intervals(middle * (1 - width), np.minimum(middle * (1 + width), most))

    wide = shape(around(limits.along), around(limits.across), around(limits.cut, 1.0))
    spread = width * np.hypot(r, s)
    found = wide.support(Intervals(r - spread, r + spread), Intervals(s - spread, s + spread))
    for _ in range(20):
        shares = rng.uniform(-1, 1, (5, 400))
        entries = [middle * (1 + width * share) for middle, share in zip(vars_of(limits), shares[:3], strict=True)]
        member = shape(*entries[:2], np.minimum(entries[2], 1.0))
        value = member.support(r + spread * shares[3], s + spread * shares[4])
        assert (found.low <= value * (1 + 1e-15)).all()
        assert (value * (1 - 1e-15) <= found.high).all()
    if not width:
        np.testing.assert_allclose(found.high, limits.support(r, s), rtol=1e-12)


def vars_of(limits: CutEllipse[Any]) -> tuple[Any, Any, Any]:
    return limits.along, limits.across, limits.cut


def test_a_box_is_the_same_in_every_arithmetic() -> None:
    field = NumberField()
    exact: CutEllipse[Any] = Box(field(2), field(Fraction(1, 3)), field(1))
    balls = exact.map(lambda number: number.ball())
    slips: list[tuple[Any, Any]] = [(field(-3), field(2)), (-3.0, 2.0), (arb(-3), arb(2))]
    for one, slip in zip((exact, exact.map(float), balls), slips, strict=True):
        assert one.piece(*slip) is BorderPiece.CORNER
        assert float(one.support(*slip)) == pytest.approx(6 + 2 / 3)
        assert [float(entry) for entry in one.gradient(*slip)] == pytest.approx([-2, 1 / 3])
        assert not float(one.bend(*slip))
    assert exact.piece(field(0), field(1)) is BorderPiece.KINK
    assert exact.holds_strictly(field(Fraction(1, 2)), field(Fraction(9, 10)))
    assert not exact.holds_strictly(field(1), field(0))


@pytest.mark.parametrize("shape", [CutEllipse, Box])
@pytest.mark.parametrize("cut", [1.0, 0.4])
def test_the_slips_of_a_force_are_those_from_which_it_takes_the_most(shape: Any, cut: float) -> None:
    """Exactly these satisfy the linear conditions, at forces inside, on the arc, on a straight side and at a corner."""
    limits = shape(np.ones(1), np.ones(1), np.full(1, 1.0 if shape is Box else cut))
    corner = (1.0, 1.0) if shape is Box else (np.sqrt(1 - cut * cut), cut)
    heights = (0.0, 0.1, 0.3, 0.9 * corner[1], corner[1])
    arcs = [(np.sqrt(1 - y * y), y) for y in heights]
    sides = [(share * corner[0], corner[1]) for share in (0.0, 0.5, 1.0)]
    directions = np.array([0, 0.3, 0.5, 0.8, np.pi / 4, 1.2, np.pi / 2, *np.arctan2(*np.transpose(arcs)[::-1])])
    turned = np.concatenate([directions + k * np.pi / 2 for k in range(4)] + [-directions, np.pi - directions])
    slips = np.concatenate([np.column_stack([np.cos(turned), np.sin(turned)]), np.zeros((1, 2))])
    for place in [(0.2, 0.1), (0.0, 0.0), *arcs, *sides]:
        for signs in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            x, y = np.array(place) * signs
            if limits.gauge(np.array([x]), np.array([y]))[0] > 1 + 1e-12:
                continue
            (forms,), (equations,) = limits.slip_cone(np.array([x]), np.array([y]), 1e-9)
            values = slips @ forms.T
            meant = np.where(equations, np.abs(values) < 1e-9, values > -1e-9).all(axis=1)
            most = np.array([limits.support(*slip[:, None])[0] for slip in slips])
            np.testing.assert_array_equal(meant, most + slips @ (x, y) < 1e-9)


def test_forces_on_the_border_may_move_along_it_alone() -> None:
    # on the arc, in the middle, at a cut, at a corner
    limits, turning = CutEllipse(np.ones(4), np.ones(4), np.array([1.0, 1.0, 0.6, 0.6])), 1e-2
    x, y = (
        np.array([0.6, 0.0, 0.5, 0.8]),
        np.array([0.8, 0.0, 0.6, -0.6]),
    )
    arc, middle, side, corner = limits.room(x, y, turning)
    np.testing.assert_allclose(arc @ [0.6, 0.8], 0, atol=1e-15)
    np.testing.assert_allclose(arc @ [-0.8, 0.6], turning * np.array([-0.8, 0.6]), atol=1e-15)
    np.testing.assert_array_equal(middle, np.eye(2))
    np.testing.assert_allclose(side @ [0, 1], 0, atol=1e-15)
    assert side[0, 0] > turning**2
    np.testing.assert_allclose(corner, 0, atol=1e-15)
    box = Box(np.ones(2), np.ones(2), np.ones(2)).room(np.array([1.0, 0.25]), np.array([-0.5, 1.0]), turning)
    np.testing.assert_allclose(box, [np.diag([0, 0.5]), np.diag([0.75, 0])], atol=1e-15)


# ---- Friction axes that are not the rims: constraints against a derivation with SymPy, files, and what is refused.

SEEDS = range(6)
FRICTION = "[friction]\nmu_roll = 1\nmu_side = '1/2'\n"
REST = "[[wheel]]\nposition = [-1, 1]\n[[wheel]]\nposition = [-1, -1]\n"


def askew(seed: int, count: int = 4, side: str = "1/3") -> Scene:
    """Random places, rims, axes and speeds; every third wheel has no axis of its own."""
    rng = np.random.default_rng(seed)
    wheels = []
    for k in range(count):
        x, y = (int(v) for v in rng.integers(-8, 9, 2))
        (a, b), (c, d) = ([int(v) for v in pair] for pair in rng.integers(-4, 5, (2, 2)))
        place = (x + 20 * (k % 2), y + 20 * (k // 2))
        axis = None if k % 3 == 2 else (c, d or 1)
        wheels.append(ns.Wheel(place, heading=(a or 1, b), speed=int(rng.integers(-3, 4)), axis=axis))
    return ns.Array(wheels, mu_roll=1, mu_side=side, radius=1).scene


def sympy_rows(wheel: Wheel) -> sympy.Matrix:
    """Slip along and across the axis from vectors: the surface runs with ``u d``, the body with ``v + omega J p``."""
    vx, vy, omega, u = sympy.symbols("vx vy omega u", real=True)
    p, rim, axis = (sympy.Matrix([x.to_sympy() for x in v]) for v in (wheel.position, wheel.direction, wheel.grip))
    turn = sympy.Matrix([[0, -1], [1, 0]])
    slip = sympy.Matrix([vx, vy]) + omega * turn * p - u * rim / rim.norm()
    along = axis / axis.norm()
    parts = [(along.T * slip)[0], ((turn * along).T * slip)[0]]
    return sympy.Matrix([[sympy.diff(part, name) for name in (vx, vy, omega, u)] for part in parts])


@pytest.mark.parametrize("seed", SEEDS)
def test_the_constraints_are_those_of_the_slip(seed: int) -> None:
    for wheel in askew(seed).wheels:
        derived = sympy_rows(wheel)
        inputs = wheel_constraints(wheel, symbolic_input=True)
        derived[:, 3] *= input_symbol(wheel.index)
        assert (inputs - derived).applyfunc(sympy.simplify) == sympy.zeros(2, 4)
        at_speed = wheel_constraints(wheel) - derived.subs(input_symbol(wheel.index), wheel.speed.to_sympy())
        assert at_speed.applyfunc(sympy.simplify) == sympy.zeros(2, 4)


@pytest.mark.parametrize("seed", SEEDS)
def test_control_fields_add_up_to_the_twist(seed: int) -> None:
    scene = askew(seed, 3)
    speeds = {wheel.index: wheel.speed for wheel in scene.wheels}
    states = regular_states(scene)
    assert states
    for state in states:
        fields = state.control_fields
        assert tuple(state.twist) == combine([speeds[w] for w in fields], fields.values())


def test_mecanum_wheels_follow_the_textbook() -> None:
    """``u = v_x -+ v_y -+ (l_x + l_y) omega`` for rollers on the ground along the ring (Lynch and Park 2017, 13.2)."""
    scene = load_scene("mecanum-4")
    signs = [(-1, -1), (1, -1), (-1, 1), (1, 1)]
    for vx, vy, omega in ((1, 0, 0), (0, 1, 0), (0, 0, 1), (3, -2, 5)):
        speeds = [vx + a * vy + b * 3 * omega for a, b in signs]
        twist = Twist(*(scene.field(value) for value in (vx, vy, omega)))
        for row, speed in zip(rows_with_friction(scene), speeds, strict=True):
            assert row.residual(twist) + row.rhs == row.gain * speed


@pytest.mark.parametrize("axis", [(-2, -2), (3, 3), "225 deg", "inward"])
def test_an_axis_along_the_rim_is_none(axis: object) -> None:
    wheels = [ns.Wheel(p, heading="inward") for p in ((1, 1), (-1, 1), (-1, -1))]
    own = [ns.Wheel((1, 1), heading="inward", axis=axis), *wheels[1:]]
    plain, named = (ns.Array(group, mu_roll=1, mu_side="1/2", radius="1/4") for group in (wheels, own))
    assert [repr(wheel) for wheel in plain.scene.wheels] == [repr(wheel) for wheel in named.scene.wheels]
    assert named.scene.wheels[0].axis is None


def test_an_axis_has_no_sense() -> None:
    forth, back = (
        ns.Array([ns.Wheel((1, 0), axis=(a, 2 * a)), ns.Wheel((0, 1))], mu_roll=1, mu_side=0).scene for a in (1, -1)
    )
    first, second = ([(*map(str, row.normal), str(row.rhs)) for row in scene_rows(scene)] for scene in (forth, back))
    assert first == second


def test_files_tables_and_python_say_the_same(tmp_path: Path) -> None:
    toml = tmp_path / "scene.toml"
    toml.write_text(
        f"{FRICTION}[[wheel]]\nposition = [1, 1]\naxis = '30 deg'\n"
        "[[wheel]]\nposition = [-1, 1]\naxis = [1, 2]\n[[wheel]]\nposition = [-1, -1]\n"
    )
    (tmp_path / "wheels.csv").write_text('x,y,Axis\n1,1,30 deg\n-1,1,"[1, 2]"\n-1,-1,\n')
    table = tmp_path / "table.toml"
    table.write_text(f"{FRICTION}[wheels]\nfile = 'wheels.csv'\n")
    wheels = [ns.Wheel((1, 1), axis="30 deg"), ns.Wheel((-1, 1), axis=(1, 2)), ns.Wheel((-1, -1))]
    scenes = load_scene(toml), load_scene(table), ns.Array(wheels, mu_roll=1, mu_side="1/2").scene
    axes = [[None if w.axis is None else tuple(map(str, w.axis)) for w in scene.wheels] for scene in scenes]
    assert axes[0] == axes[1] == axes[2]
    assert axes[0][1] == ("-1", "-2")  # towards the heading, inward
    assert axes[0][2] is None


def test_the_axis_of_all_wheels_yields_to_their_own(tmp_path: Path) -> None:
    file = tmp_path / "scene.toml"
    file.write_text(f"{FRICTION}axis = [1, 0]\n[[wheel]]\nposition = [1, 1]\naxis = [0, 1]\n{REST}")
    axes = [wheel.axis and tuple(map(str, wheel.axis)) for wheel in load_scene(file).wheels]
    assert axes == [("0", "-1"), ("1", "0"), ("1", "0")]
    array = ns.Array([ns.Wheel((1, 1)), ns.Wheel((1, 0))], mu_roll=1, mu_side=0).with_(axis=(1, 0))
    first, second = (wheel.axis for wheel in array.scene.wheels)
    assert first is not None
    assert [str(x) for x in first] == ["-1", "0"]
    assert second is None


def test_similar_scenes_keep_their_axes() -> None:
    scene = askew(1)
    for other in (scaled(scene, Fraction(3)), moved(scene, Fraction(1), Fraction(2)), scene.recentred()):
        assert [wheel.axis for wheel in other.wheels] == [wheel.axis for wheel in scene.wheels]


@pytest.mark.parametrize("seed", SEEDS)
def test_free_rollers_are_wheels_with_rims_along_their_axes(seed: int) -> None:
    """The same rows with friction, up to their scale, at the scene's speeds."""
    scene = askew(seed, side="0")
    plain = with_rims_along_axes(scene)
    if plain is None:
        assert any(w.axis is not None and not w.gains[0] for w in scene.wheels)
        return
    for own, other in zip(rows_with_friction(scene), rows_with_friction(plain), strict=True):
        assert own.normal == other.normal
        assert own.rhs == other.rhs
        assert own.unit_normal == other.unit_normal


def test_friction_across_the_axis_or_a_drive_across_it_is_another_wheel() -> None:
    assert with_rims_along_axes(askew(0)) is None
    wheels = [ns.Wheel((1, 0), heading=(1, 0), axis=(0, 1)), ns.Wheel((0, 1))]
    assert with_rims_along_axes(ns.Array(wheels, mu_roll=1, mu_side=0).scene) is None


def test_rows_without_friction_are_no_contact_states() -> None:
    scene = load_scene("mecanum-4")
    assert triples_with_friction(scene) == 4
    assert take_census(scene).possible == len(regular_states(scene)) == 4
    assert all(row.kind == "R" for state in regular_states(scene) for row in state.rows)


def test_free_twists_are_the_kernel_of_the_rows() -> None:
    """Free rollers with all axes through one point do not resist a turn about it, (-J p, 1) from the origin."""
    at = (Fraction(1, 3), 2)
    places = ((1, 1), (-1, 1), (-1, -1))
    wheels = [ns.Wheel(p, axis=(p[0] - at[0], p[1] - at[1]), heading=(1, 0)) for p in places]
    scene = ns.Array(wheels, mu_roll=1, mu_side=0).scene
    (free,) = free_twists(scene)
    assert [str(x) for x in free] == ["2", "-1/3", "1"]
    assert free_text(free_twists(scene)) == "no row with friction resists the motion xi = (2, -1/3, 1)"
    assert free_twists(load_scene("mecanum-4")) == ()
