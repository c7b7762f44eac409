"""Enclosures by balls, against eigenvalues, known zeros, and values at drawn members of boxes."""

from __future__ import annotations

import math

import numpy as np
import pytest
from flint import arb, arb_mat

from nonsmooth.proofs.boxes.enclosures import (
    UNIT,
    Jet,
    approximate_inverse,
    holds_on,
    is_positive_definite,
    krawczyk,
    lies_inside,
    linear_stability,
    newton,
    parameters,
    turned_by,
    unit_vector,
)
from nonsmooth.proofs.findings.verdicts import Translation

CIRCLE = 5.0  # x^2 + y^2 = 5 meets x y = 2 at (2, 1) and (1, 2)


def test_definite_matrices_are_those_with_positive_eigenvalues() -> None:
    rng = np.random.default_rng(1)
    found = []
    for _ in range(200):
        entries = rng.integers(-4, 6, (3, 3))
        matrix = entries + entries.T + 4 * np.eye(3, dtype=int)
        found.append(is_positive_definite(matrix.tolist()))
        assert found[-1] == (np.linalg.eigvalsh(matrix).min() > 1e-9)
    assert 20 < sum(found) < 180


def test_a_matrix_of_balls_is_definite_only_if_all_members_are() -> None:
    rows = [[arb(2), arb(0, 1), arb(0)], [arb(0, 1), arb(1), arb(0)], [arb(0), arb(0), arb(1)]]
    assert is_positive_definite(rows)
    rows[0][1] = rows[1][0] = arb(0, 1.5)
    assert not is_positive_definite(rows)


def test_stability_is_that_of_the_eigenvalues() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        matrix = rng.integers(-3, 4, (2, 2))
        real = np.linalg.eigvals(matrix).real
        expected = Translation.UNDECIDED
        if real.max() > 1e-9:
            expected = Translation.UNSTABLE
        elif real.max() < -1e-9:
            expected = Translation.ASYMPTOTICALLY_STABLE
        assert linear_stability(matrix.tolist()) is expected


def equations(z: arb_mat, product: int = 2) -> tuple[arb_mat, arb_mat]:
    x, y = z.entries()
    value = arb_mat([[x * x + y * y - CIRCLE], [x * y - product]])
    return value, arb_mat([[2 * x, 2 * y], [y, x]])


def test_krawczyks_operator_encloses_a_zero() -> None:
    centre = newton(equations, arb_mat([[arb(2.2)], [arb(0.9)]]), 8)
    assert centre is not None
    inverse = approximate_inverse(equations(centre)[1])
    assert inverse is not None
    box = arb_mat([[entry + 0.1 * UNIT] for entry in centre.entries()])
    image = krawczyk(centre, equations(centre)[0], inverse, equations(box)[1], box)
    assert lies_inside(image, box)
    assert all(entry.contains(zero) for entry, zero in zip(image.entries(), (2, 1), strict=True))
    wide = arb_mat([[entry + UNIT] for entry in centre.entries()])  # holds both zeros
    assert not lies_inside(krawczyk(centre, equations(centre)[0], inverse, equations(wide)[1], wide), wide)


def test_no_zero_is_proved_where_there_is_none() -> None:
    """The circle and the hyperbola x y = 3 do not meet."""

    def apart(z: arb_mat) -> tuple[arb_mat, arb_mat]:
        return equations(z, 3)

    centre = arb_mat([[arb(1.75)], [arb(1.5)]])
    inverse = approximate_inverse(apart(centre)[1])
    assert inverse is not None
    for radius in (0.01, 0.05, 0.2):
        box = arb_mat([[entry + radius * UNIT] for entry in centre.entries()])
        assert not lies_inside(krawczyk(centre, apart(centre)[0], inverse, apart(box)[1], box), box)


def test_parts_of_an_interval() -> None:
    assert holds_on(lambda x: bool(x * x - x + 0.26 > 0), arb(0), arb(1), 12)
    assert not holds_on(lambda x: bool(x * x - x + 0.25 > 0), arb(0), arb(1), 12)
    assert not holds_on(lambda x: bool(x * x - x + 0.26 > 0), arb(0), arb(1), 2)


def along(jets: list[Jet]) -> list[Jet]:
    """Something of every operation: a unit vector, turned, and a quotient."""
    x, y, angle = jets
    unit = unit_vector(x * y + arb(3), y - x)
    assert unit is not None
    a, b = turned_by(arb(1), arb(2), angle)
    return [a * unit[0] - b * unit[1], (a + b) / (x * x + arb(2)), -unit[1] * a]


@pytest.mark.parametrize("size", [0.01, 0.2])
def test_the_mean_value_theorem_encloses_every_member(size: float) -> None:
    middle, sizes = [0.3, -0.4, 0.7], [arb(size)] * 3
    whole = along(parameters([arb(value) + size * UNIT for value in middle]))
    boxes = [
        jet.over(sizes, at.value) for jet, at in zip(whole, along(parameters([arb(v) for v in middle])), strict=True)
    ]
    rng = np.random.default_rng(3)
    for shift in rng.uniform(-size, size, (50, 3)):
        x, y, angle = np.array(middle) + shift
        a, b = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]) @ (1, 2)
        e, f = np.array([x * y + 3, y - x]) / math.hypot(x * y + 3, y - x)
        for box, value in zip(boxes, (a * e - b * f, (a + b) / (x * x + 2), -f * a), strict=True):
            assert box.overlaps(arb(value, 1e-12))
            assert float(box.rad()) < 8 * size


def test_slopes_are_those_of_differences() -> None:
    middle, step = [0.3, -0.4, 0.7], 1e-6
    for k in range(3):
        ends = []
        for side in (-step, step):
            values = [arb(value + side * (k == j)) for j, value in enumerate(middle)]
            ends.append([float(jet.value) for jet in along(parameters(values))])
        slopes = [float(jet.slopes[k]) for jet in along(parameters([arb(value) for value in middle]))]
        assert slopes == pytest.approx((np.array(ends[1]) - np.array(ends[0])) / (2 * step), abs=1e-8)
