"""The certified rate of the feedback law, against brute force."""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.feedback.by_rows import decide_feedback
from nonsmooth.proofs.clauses.feedback.control_fields import RowInputs
from nonsmooth.proofs.clauses.feedback.gradient_law import ConeRate, certified_rate, exponent_of
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import Arrays
from tests.four_wheel import ROLL
from tests.thorough import thorough


def sampled_kappa(cone: ConeRate, samples: int = 40_000) -> float:
    """Least ``(a^2 + b^2)/(|c|^2 + theta^2)`` over random points of the cone."""
    rng = np.random.default_rng(0)
    rays = np.array([[float(x) for x in ray] for ray in cone.rays])
    c = rng.uniform(0, 1, (samples, 2)) ** 2 @ rays
    theta = rng.normal(size=samples) * np.hypot(*c.T) * 10 ** rng.uniform(-2, 2, samples)
    value = np.zeros(samples)
    for field in cone.fields:
        x, y, turn = (float(entry) for entry in field)
        value += (c[:, 0] * x + c[:, 1] * y + theta * turn) ** 2
    return float((value / ((c**2).sum(axis=1) + theta**2)).min())


@pytest.mark.parametrize("name", ["four-wheel", "ring-3", "ring-5", "ring-6", "rectangle", "elliptic", "spiral-30"])
def test_the_rate_is_certified_and_nearly_the_best(name: str) -> None:
    rate = certified_rate(RowInputs(build_nearest_partition(load_scene(name).recentred())))
    assert rate is not None
    assert all(cone.holds(rate.kappa) for cone in rate.cones)
    best = min(sampled_kappa(cone) for cone in rate.cones)
    assert float(rate.kappa) <= best
    assert float(rate.kappa) >= 0.9 * best  # the samples come within a few per cent of the minimum
    assert not all(cone.holds(rate.kappa * Fraction(102, 100)) for cone in rate.cones)


def test_four_wheel_rate_in_closed_form(arrays: Arrays) -> None:
    """kappa = (3 - sqrt 5)/4 on every cone."""
    rate = certified_rate(RowInputs(build_nearest_partition(arrays.four_wheel())))
    assert rate is not None
    assert 0 <= (3 - np.sqrt(5)) / 4 - float(rate.kappa) < 3e-4


@thorough  # the small one: test_the_rate_is_certified_and_nearly_the_best
def test_random_arrays_have_a_rate_iff_the_law_stabilizes(arrays: Arrays) -> None:
    with_rate = without = 0
    for seed in range(25):
        partition = build_nearest_partition(arrays.cocircular(seed, ROLL))
        feedback = decide_feedback(partition)
        if feedback.has_lyapunov:
            with_rate += 1
            assert feedback.rate is not None, seed
        elif feedback.cells and all(data.lever is not None for data in feedback.cells):
            without += 1
            assert feedback.rate is None, seed
            assert certified_rate(RowInputs(partition)) is None, seed
    assert (with_rate, without) == (22, 2)  # in the last one a cell has no lever


@pytest.mark.parametrize("turn", [Fraction(1, 180), Fraction(89, 180), Fraction(7, 180)])
def test_the_size_of_a_number_over_a_field_of_high_degree(turn: Fraction) -> None:
    """At the precision of a float its ball holds zero, and the size of that ended in a traceback."""
    field = NumberField(360)
    for number in (field.cos_pi(turn), -field.sin_pi(turn), field.cos_pi(turn) ** 5 / 1000):
        for value in (number, Lazy.of(number)):
            assert exponent_of(value) == pytest.approx(math.log2(abs(float(number))), abs=0.51)
