"""Lines and points by floats and whole numbers: what they say of a sign is true, and outlines are exact polygons."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import TypeAlias

import numpy as np
import pytest

from nonsmooth.analysis.cells.loads import at_least_zero
from nonsmooth.analysis.cells.outline import Filtered, Outline, OutlineSide, between, known_sign, meet
from nonsmooth.analysis.cells.polygon import Polygon, square
from nonsmooth.symbolic.numbers.coefficients import whole_multiples
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_field import NumberField

Draw: TypeAlias = Callable[[], Number]
FIELDS = {"rational": (1, ()), "one root": (1, (2,)), "two roots": (1, (2, 3)), "of ring-5": (5, ())}


def draws(name: str, rng: np.random.Generator) -> tuple[NumberField, Draw]:
    """A field and short numbers of it at random."""
    order, radicands = FIELDS[name]
    field = NumberField(order)
    units = [field.one, *(field.sqrt(radicand) for radicand in radicands), *([field.two_cos(1)] if order > 1 else [])]
    return field, lambda: sum((unit * int(rng.integers(-4, 5)) for unit in units), field.zero) / int(rng.integers(1, 5))


def product(line: tuple[Number, ...], point: tuple[Number, ...]) -> Number:
    return line[0] * point[0] + line[1] * point[1] + line[2] * point[2]


@pytest.mark.parametrize("name", FIELDS)
def test_known_signs_are_those_of_exact_numbers(name: str) -> None:
    rng = np.random.default_rng(0)
    field, draw = draws(name, rng)
    decided = 0
    for _ in range(150):
        first, second, third = ((draw(), draw(), draw()) for _ in range(3))
        a, b = first, second
        point = (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
        met = meet(Filtered.of(first), Filtered.of(second))
        for line in (first, third):
            known = known_sign(Filtered.of(line), met)
            assert known is None or known == sign(product(line, point))
            assert name != "rational" or known is not None
            decided += known is not None
        one, x, y, u, v = field.one, *(draw() for _ in range(4))
        middle = between(Filtered.of((one, x, y)), Filtered.of((one, u, v)))
        known = known_sign(Filtered.of(third), middle)
        assert known is None or known == sign(product(third, (one * 2, x + u, y + v)))
    assert decided >= 100


@pytest.mark.parametrize("name", FIELDS)
def test_an_outline_is_the_polygon_that_exact_numbers_cut(name: str) -> None:
    """Lines of few slopes through few places: many pass through corners of others."""
    rng = np.random.default_rng(1)
    field, draw = draws(name, rng)
    cut = 0
    for _ in range(60):
        exact: Polygon | None = square((field.zero, field.zero), field(2))
        outline: Outline | None = Outline.of(exact) if exact else None
        for _ in range(6):
            form = (draw() + Fraction(3, 2), draw(), draw())
            if not any(form[1:]):
                continue
            half_plane = at_least_zero(form, "cut")
            side = OutlineSide(Filtered.of(form), lambda half_plane=half_plane: half_plane)  # type: ignore[misc]
            exact = exact and exact.clipped(half_plane)
            outline = outline and outline.clipped(side)
            assert (outline is None) == (exact is None)
            if outline is not None:
                cut += 1
                assert outline.polygon == exact
    assert cut >= 60


def test_what_floats_do_not_hold_is_not_known() -> None:
    field = NumberField()
    root = field.sqrt(2)
    for size in (Fraction(10) ** 400, Fraction(1, 10**400), Fraction(10) ** 90):
        far = (field(size) * root, field(size), field.one)
        assert known_sign(Filtered.of(far), Filtered.of((field.one, root, root))) is None
    near = (field.one, root - 1 + Fraction(1, 10**30), field.zero)
    assert known_sign(Filtered.of(near), Filtered.of((1 - root, field.one, field.zero))) is None


def test_whole_multiples() -> None:
    field = NumberField()
    root = field.sqrt(2)
    thirds = [(root / 3).terms, (root * 2).terms, field.zero.terms]
    assert whole_multiples(thirds, 10) == [1, 6, 0]
    assert whole_multiples(thirds, 2) is None
    assert whole_multiples([root.terms, field.one.terms], 10) is None
    assert whole_multiples([field.zero.terms] * 2, 10) == [0, 0]
    assert whole_multiples([NumberField(5).two_cos(1).terms], 10) is None
