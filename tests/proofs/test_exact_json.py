"""Numbers as JSON: only the generators that occur, isolated roots, and points over many square roots."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import pytest

from nonsmooth.proofs.checker.tower import Field
from nonsmooth.proofs.findings.exact_json import encode, homogeneous
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField

HALF = Fraction(1, 2)


def encoded(field: NumberField, *numbers: Number) -> tuple[list[Any], list[Any]]:
    document = encode({"field": field, "numbers": list(numbers)})
    return document["field"], document["numbers"]


def test_rationals_are_text_and_need_no_generators() -> None:
    field = NumberField()
    field.sqrt(2)
    assert encoded(field, field(0), field(-HALF), field(3)) == ([], ["0", "-1/2", "3"])


def test_only_generators_that_occur_are_listed() -> None:
    field = NumberField()
    root, _, other = (field.sqrt(k) for k in (2, 3, 5))
    generators, numbers = encoded(field, root * other / 3 - 1)
    assert generators == [
        {"polynomial": ["-2", "0", "1"], "above": "0"},
        {"polynomial": ["-5", "0", "1"], "above": "0"},
    ]
    assert numbers == [[["-1"], ["1/3", 0, 1]]]


def test_a_nested_root_brings_the_roots_inside_it() -> None:
    field = NumberField()
    field.sqrt(7)
    nested = (field.sqrt(2) + 3).sqrt()
    generators, numbers = encoded(field, nested)
    assert [g["polynomial"] for g in generators] == [["-2", "0", "1"], [[["-3"], ["-1", 0]], "0", "1"]]
    assert numbers == [[["1", 1]]]


@pytest.mark.parametrize("order", [5, 7, 8, 9, 11, 20, 28, 36, 52])
def test_the_base_generator_is_the_largest_root_of_its_polynomial(order: int) -> None:
    field = NumberField(order)
    generators, numbers = encoded(field, field.two_cos(1), field.two_cos(2) / 3)
    assert len(generators) == 1
    assert all(isinstance(c, str) for c in generators[0]["polynomial"])
    read = Field(generators)  # the checker accepts it as a polynomial with one root above the bound
    low, high = read.root(0, 60)
    value = 2 * math.cos(2 * math.pi / order) * 2**60
    assert low - 2**12 <= value <= high + 2**12
    assert numbers[0] == [["1", 0]]


def test_the_checker_reads_the_same_numbers() -> None:
    field = NumberField(7)
    numbers = [field.two_cos(1) * field.sqrt(3) - HALF, (field.sqrt(3) + field.two_cos(2) + 4).sqrt() / 5]
    numbers += [a * b - c for a in numbers for b in numbers for c in numbers]
    generators, texts = encoded(field, *numbers)
    read = Field(generators)
    for number, text in zip(numbers, texts, strict=True):
        assert read.parse(text).sign() == number.sign()
        assert not (read.parse(text) * read.parse(text) - read.parse(encode_again(field, number, generators))).sign()


def encode_again(field: NumberField, number: Number, generators: list[Any]) -> Any:
    """The square of a number, computed by the workbench."""
    everything = [field.two_cos(1), *(Number(field, {1 << i: field.one.terms[0]}) for i in range(len(field.radicands)))]
    document = encode({"field": field, "all": everything, "square": number * number})
    assert document["field"] == generators
    return document["square"]


def test_what_is_no_number_text_or_container_is_refused() -> None:
    with pytest.raises(TypeError, match="float"):
        encode({"field": NumberField(), "value": 0.5})


def test_homogeneous_points() -> None:
    field = NumberField()
    roots = [field.sqrt(k) for k in (2, 3, 5)]
    assert homogeneous((field(1), field(HALF))) == (field(1), field(HALF), field(1))
    x = Lazy.of(roots[0]) / Lazy.of(roots[1] - roots[2])
    y = Lazy.of(roots[2]) / Lazy.of(roots[1] - roots[2])
    for values in ((x, y), (x, field(HALF)), (x, 1 / y), (x, x * y)):
        *above, below = homogeneous(values)
        assert below.sign() > 0
        assert all(value == Lazy.of(top) / Lazy.of(below) for value, top in zip(values, above, strict=True))
