"""Arithmetic on a grid and clipped polygons of the checker, against fractions, which are not rounded."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from itertools import product
from operator import add, mul, sub, truediv
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.proofs.checker.intervals import GRID, ONE, Interval, Jet, interval, mean_value
from nonsmooth.proofs.checker.plane import Side, clipped, corners
from nonsmooth.proofs.checker.tolerances import outer_ends
from nonsmooth.proofs.checker.tower import Field
from nonsmooth.proofs.checker.work import RejectedError

ENDS = st.integers(-(1 << 140), 1 << 140) | st.integers(-3, 3) | st.integers(-(1 << 64), 1 << 64)
INTERVALS = st.tuples(ENDS, ENDS).map(lambda ends: Interval(min(ends), max(ends)))


def inside(own: Interval, share: Fraction) -> Fraction:
    """One of the numbers of an interval."""
    return (own.low + share * (own.high - own.low)) / GRID


@given(INTERVALS, INTERVALS, st.fractions(0, 1), st.fractions(0, 1), st.sampled_from([add, sub, mul, truediv]))
def test_operations_hold_what_their_operands_give(
    a: Interval, b: Interval, s: Fraction, t: Fraction, operation: Callable[[Any, Any], Any]
) -> None:
    if operation is truediv and b.low <= 0 <= b.high:
        with pytest.raises(RejectedError, match="a divisor that is not zero"):
            operation(a, b)
        return
    found = operation(a, b)
    assert found.low <= operation(inside(a, s), inside(b, t)) * GRID <= found.high


def test_numbers_of_a_field_are_enclosed_closely() -> None:
    field = Field([{"polynomial": ["-2", "0", "1"], "above": "1"}])
    own = interval(field.parse([["1/3", 0], ["-5/7"]]))
    assert 0 < own.high - own.low < 8
    low, high = (3 * (Fraction(end, GRID) + Fraction(5, 7)) for end in (own.low, own.high))
    assert low**2 < 2 < high**2


def test_slopes_bound_what_a_function_may_change() -> None:
    """``x y/(x + y)`` about (2, 3), x off by 1/2 and y by 1/4: bounds hold it, and are less than twice as wide."""
    sizes = (GRID // 2, GRID // 4)
    zero = Interval(0, 0)
    middle = [Interval(2 * GRID, 2 * GRID), Interval(3 * GRID, 3 * GRID)]
    x, y = (
        Jet(Interval(own.low - size, own.high + size), slopes)
        for own, size, slopes in zip(middle, sizes, ((ONE, zero), (zero, ONE)), strict=True)
    )
    found = mean_value(middle[0] * middle[1] / (middle[0] + middle[1]), x * y / (x + y), sizes)
    values = [a * b / (a + b) for a in (1.5, 2.5) for b in (2.75, 3.25)]
    low, high = found.low / GRID, found.high / GRID
    assert low < min(values) < max(values) < high
    assert high - low < 2 * (max(values) - min(values))


def polygon(rng: np.random.Generator) -> tuple[list[Side], list[Side]]:
    """A square of half side two, and whole half planes, some of which pass through its corners and each other's."""
    square = [(GRID, 0, 2 * GRID), (0, GRID, 2 * GRID), (-GRID, 0, 2 * GRID), (0, -GRID, 2 * GRID)]
    lines = [tuple(int(v) * GRID // 4 for v in rng.integers(-4, 5, 3)) for _ in range(int(rng.integers(1, 6)))]
    return square, lines  # type: ignore[return-value]  # of three each


def test_clipped_polygons_hold_the_points_of_their_half_planes() -> None:
    """Points of a grid lie in the part if they lie strictly in all half planes; its corners lie in them."""
    rng, areas = np.random.default_rng(3), 0
    for _ in range(50):
        square, lines = polygon(rng)
        part = clipped(square, lines)
        areas += bool(part)
        assert set(part) <= {*square, *lines}
        for x, y, w in corners(part) if part else ():
            assert w > 0
            assert all(a * x + b * y <= c * w for a, b, c in (*square, *lines))
        for x, y in product(range(-6, 7), repeat=2):  # thirds
            if all(a * x + b * y < 3 * c for a, b, c in (*square, *lines)):
                assert part
                assert all(a * x + b * y < 3 * c for a, b, c in part)
    assert 10 < areas < 45


def test_rays_to_what_lies_outside_the_disc_lie_between_the_ends() -> None:
    """A function that is convex on rays, ``|c| - 2 m . c``, is positive outside the disc only if it is at an end."""
    rng, seen = np.random.default_rng(4), 0
    for _ in range(150):
        square, lines = polygon(rng)
        part = clipped(square, lines)
        ends = [np.array([float(x), float(y)]) for x, y, _ in outer_ends(part)] if part else []
        m = rng.normal(size=2)
        points = rng.uniform(-2, 2, (300, 2))
        sides = np.array(part, dtype=float).reshape(-1, 3)
        kept = (points @ sides[:, :2].T <= sides[:, 2]).all(axis=1) & bool(part)
        outer = points[kept & (np.hypot(*points.T) > 1)]
        positive = np.hypot(*outer.T) - 2 * outer @ m > 1e-9
        if not ends:
            assert not len(outer)
        elif positive.any():
            assert any(np.hypot(*end) > 2 * end @ m for end in ends)
            seen += not all(np.hypot(*end) > 2 * end @ m for end in ends)
    assert seen > 10
