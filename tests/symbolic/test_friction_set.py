"""Friction sets: support function, gradient and Hessian against the set itself, the same in every arithmetic."""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from flint import arb
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.proofs.boxes.intervals import Intervals
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece, Box, CutEllipse, FrictionSet, float_sets
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.thorough import examples

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
