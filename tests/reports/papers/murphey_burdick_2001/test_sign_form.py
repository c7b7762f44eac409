"""Sign forms: the paper's eqs. (3) and (4) as printed, and forms found again from what they say."""

from __future__ import annotations

import itertools
from fractions import Fraction
from math import prod

import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.reports.papers.murphey_burdick_2001 import sign_form
from nonsmooth.reports.papers.murphey_burdick_2001.sign_form import (
    EQUATION_3,
    EQUATION_4,
    MOST_FACTORS,
    Direction,
    SignForm,
    find_sign_form,
    line_factors,
    partition_forms,
    sign_at,
)
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.thorough import examples

FIELD = NumberField()
RANDOM = examples(60)


def directions(*pairs: tuple[int, int]) -> list[Direction]:
    one = FIELD.zero + 1
    return [(one * a, one * b) for a, b in pairs]


def value_at(form: SignForm, point: Direction) -> Number:
    """The sum at a point, term by term."""
    zero = next(iter(form.factors[0].values())) * 0
    signs = [sign_at(factor, point) for factor in form.factors]
    return sum((number * prod(signs[k] for k in product) for number, product in form.terms), zero)


FOUR_LINES = directions((1, 0), (0, 1), (1, 1), (1, -1))
SECTORS = directions((3, 1), (1, 3), (-1, 3), (-3, 1), (-3, -1), (-1, -3), (1, -3), (3, -1))


@pytest.mark.parametrize(("name", "printed"), [("four-wheel-side", EQUATION_3), ("four-wheel", EQUATION_4)])
def test_the_four_wheel_array_gives_the_printed_equations(name: str, printed: sympy.Matrix) -> None:
    partition = build_partition(load_scene(name))
    centres = [cell.polygon.centre for cell in partition.cells]
    for (x, y), (form, expected) in itertools.product(centres, zip(partition_forms(partition), printed, strict=True)):
        assert form is not None
        value = expected.subs({sign_form.x: x.to_sympy(), sign_form.y: y.to_sympy()})
        assert sympy.expand(value_at(form, (x, y)).to_sympy() - value) == 0


def test_the_printed_form_is_kept() -> None:
    forms = partition_forms(build_partition(load_scene("four-wheel-side")))
    assert [form.plain for form in forms if form] == [
        "-sqrt(2)/2 sgn(x) (sgn(y^2 - x^2) + 1)",
        "sqrt(2)/2 sgn(y) (sgn(y^2 - x^2) - 1)",
        "-sqrt(2)/2 sgn(x y^3 - x^3 y)",
    ]
    assert forms[0] is not None
    assert (
        forms[0].latex
        == r"-\frac{\sqrt{2}}{2}\, \operatorname{sgn}(x)\, \left(\operatorname{sgn}(y^2 - x^2) + 1\right)"
    )


@pytest.mark.parametrize("name", ["ring-5", "ring-6", "rectangle", "spiral-30", "saddle", "elliptic"])
def test_a_form_has_the_value_of_every_cell(name: str) -> None:
    partition = build_partition(load_scene(name))
    forms = partition_forms(partition)
    assert any(forms)
    for cell, (k, form) in itertools.product(partition.cells, enumerate(forms)):
        if form is not None:
            x, y = cell.polygon.centre
            corner = next(v for v in cell.polygon.vertices if v[0] or v[1])
            for inner in ((x, y), ((x + corner[0]) / 2, (y + corner[1]) / 2)):
                assert value_at(form, inner) == cell.twists[0][k]


@RANDOM
@given(
    st.tuples(st.integers(-5, 5), st.integers(-5, 5)),
    st.tuples(st.integers(0, 7), st.integers(0, 7)),
)
def test_two_terms_are_found_again(numbers: tuple[int, int], products: tuple[int, int]) -> None:
    """Build the values of ``a sgn(p) + b sgn(q)`` literally; whatever form is found must have them."""
    factors = line_factors(FOUR_LINES)
    assert len(factors) == 3
    samples = []
    for x, y in SECTORS:
        signs = [sign_at(factor, (x, y)) for factor in factors]
        value = FIELD.zero
        for number, product in zip(numbers, products, strict=True):
            term = number
            for k in range(3):
                term *= signs[k] if product >> k & 1 else 1
            value = value + term
        samples.append(((x, y), value))
    form = find_sign_form(factors, samples)
    assert form is not None
    assert all(value_at(form, point) == value for point, value in samples)


def test_values_without_a_short_form_have_none() -> None:
    factors = line_factors(FOUR_LINES)
    values = [FIELD.zero + Fraction(k * k, 3) for k in range(8)]
    assert find_sign_form(factors, list(zip(SECTORS, values, strict=True))) is None
    many = line_factors(directions(*((k, 1) for k in range(1, MOST_FACTORS + 2))))
    assert find_sign_form(many, [((SECTORS[0]), FIELD.zero)]) is None


def test_mirrored_lines_are_one_factor() -> None:
    factors = line_factors(directions((1, 2), (1, -2), (0, 1)))
    assert [sorted(factor) for factor in factors] == [[(1, 0)], [(0, 2), (2, 0)]]
    assert str(factors[1][2, 0]) == "-4"
