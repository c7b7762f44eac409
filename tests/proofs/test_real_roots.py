"""Real roots isolated exactly: against NumPy, against known roots, and signs at roots that have no name."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from nonsmooth.proofs.inequalities.real_roots import RealRoot, Sturm, positive_roots, separated, value
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.thorough import examples

RANDOM = examples(80)
FIELD = NumberField()
ROOT = FIELD.sqrt(2)


def is_isolated(root: RealRoot) -> bool:
    """Whether the polynomial has exactly one root between the bounds, and none at them."""
    ends = root.sturm.sign_at(root.low) and root.sturm.sign_at(root.high)
    return bool(ends) and root.low < root.high and root.sturm.count(root.low, root.high) == 1


def product(*factors: list[Number]) -> list[Number]:
    """Ascending coefficients of a product."""
    total = [FIELD.one]
    for factor in factors:
        longer = [FIELD.zero] * (len(total) + len(factor) - 1)
        for i, a in enumerate(total):
            for j, b in enumerate(factor):
                longer[i + j] = longer[i + j] + a * b
        total = longer
    return total


def minus(root: Number | Fraction | int) -> list[Number]:
    """``t - root``."""
    return [-FIELD(root), FIELD.one]


NUMBERS = st.builds(
    lambda q, k: FIELD(q) + k * ROOT, st.fractions(min_value=-3, max_value=3, max_denominator=4), st.integers(-1, 1)
)


@RANDOM
@given(st.lists(NUMBERS, min_size=1, max_size=4), st.lists(st.integers(1, 3), min_size=4, max_size=4))
def test_known_roots_are_isolated_whatever_their_multiplicities(roots: list[Number], powers: list[int]) -> None:
    coefficients = product(
        *[minus(r) for r, k in zip(roots, powers, strict=False) for _ in range(k)], [FIELD(1), FIELD(0), FIELD(1)]
    )
    positive = sorted({r for r in roots if r.sign() > 0})
    found = positive_roots(coefficients)
    assert len(found) == len(positive)
    for isolated, root in zip(found, positive, strict=True):
        assert is_isolated(isolated)
        assert isolated.low < root < isolated.high
        rational = all(c.as_rational() is not None for c in coefficients)
        assert isolated.exact() == root or (not rational and isolated.exact() is None)  # no factors over Q(sqrt2)
        assert isolated.sign_of(minus(root)) == 0
        assert isolated.sign_of(minus(root - 1)) == 1
        assert is_isolated(isolated.halved())


@RANDOM
@given(st.lists(st.integers(-20, 20), min_size=2, max_size=9))
def test_random_polynomials_against_numpy(integers: list[int]) -> None:
    assume(any(integers))
    coefficients = [FIELD(c) for c in integers]
    found = positive_roots(coefficients)
    roots = np.roots(integers[::-1])
    real = sorted(r.real for r in roots if abs(r.imag) < 1e-7 and r.real > 1e-7)
    distinct = [r for k, r in enumerate(real) if not k or r - real[k - 1] > 1e-4]
    clustered = len(distinct) < len(real) or any(abs(r.imag) < 1e-3 for r in roots if abs(r.imag) >= 1e-7)
    if not clustered:  # NumPy cannot tell double roots from near ones
        assert len(found) == len(distinct)
        for isolated, root in zip(found, distinct, strict=True):
            assert float(isolated.low) - 1e-6 <= root <= float(isolated.high) + 1e-6
    for isolated in found:
        assert is_isolated(isolated)


def test_roots_of_different_polynomials_are_told_apart() -> None:
    cubic = [FIELD(-2), FIELD(0), FIELD(0), FIELD(1)]  # 2^(1/3)
    near = minus(Fraction(125992, 100000))
    several = [*positive_roots(cubic), *positive_roots(product(cubic, minus(5))), *positive_roots(near)]
    found = separated(several)
    assert len(found) == 3
    assert all(a.high <= b.low for a, b in pairwise(found))
    assert found[0].exact() == Fraction(125992, 100000)
    assert found[1].exact() is None
    assert found[1].sign_of(near) == 1
    assert found[1].sign_of(product(cubic, minus(7))) == 0
    assert found[1].sign_of([]) == 0


def test_a_bound_with_none_or_two_roots_is_refused() -> None:
    quadratic = tuple(product(minus(1), minus(2)))
    assert is_isolated(RealRoot(quadratic, Fraction(1, 2), Fraction(3, 2)))
    assert not is_isolated(RealRoot(quadratic, Fraction(1, 2), Fraction(5, 2)))
    assert not is_isolated(RealRoot(quadratic, Fraction(3), Fraction(4)))
    assert not is_isolated(RealRoot(quadratic, Fraction(1), Fraction(3, 2)))  # a bound that is a root itself
    with pytest.raises(ValueError, match="nonzero"):
        positive_roots([FIELD.zero])


def test_sturm_counts_distinct_roots() -> None:
    coefficients = product(minus(1), minus(1), minus(ROOT), minus(3))
    sturm = Sturm(coefficients)
    assert sturm.count(Fraction(0), None) == 3
    assert sturm.count(Fraction(5, 4), Fraction(2)) == 1
    assert value(coefficients, Fraction(2)).sign() < 0


@RANDOM
@given(st.lists(st.integers(-9, 9), min_size=2, max_size=7), st.fractions(-5, 5, max_denominator=9))
def test_signs_of_rational_polynomials_are_those_of_their_values(numbers: list[int], point: Fraction) -> None:
    """Rational chains are evaluated by FLINT, up to positive factors."""
    assume(numbers[-1])
    expected = sum(Fraction(c) * point**k / 7 for k, c in enumerate(numbers))
    chain = Sturm([FIELD(Fraction(c, 7)) for c in numbers])
    assert chain.sign_at(point) == (expected > 0) - (expected < 0)


@RANDOM
@given(st.lists(st.integers(-3, 3), min_size=1, max_size=5))
def test_rational_chains_count_what_irrational_ones_count(roots: list[int]) -> None:
    """Times the square root of two the coefficients are irrational, and the chain is another."""
    rational = product(*(minus(root) for root in roots))
    irrational = [c * ROOT for c in rational]
    counts = {Sturm(chain).count(Fraction(-7, 2), Fraction(1, 2)) for chain in (rational, irrational)}
    assert counts == {len({root for root in roots if root <= 0})}


def test_close_roots_of_many_polynomials_are_told_apart_with_little_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Roots ``10^-8 k``, of products of two factors each: what was found of a root is not found again for each pair."""
    field, halvings = NumberField(), 0
    halved = RealRoot.halved

    def counted(root: RealRoot) -> RealRoot:
        nonlocal halvings
        halvings += 1
        return halved(root)

    monkeypatch.setattr(RealRoot, "halved", counted)
    scale = 10**8
    curves = [[field(k * (k + 1)), field(-scale * (2 * k + 1)), field(scale**2)] for k in range(1, 40)]
    found = separated(root for curve in curves for root in positive_roots(curve))
    assert [sum(root.low < Fraction(k, scale) < root.high for root in found) for k in range(1, 41)] == [1] * 40
    assert len(found) == 40
    assert halvings < 100 * 78


@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_halves_hold_the_root_whatever_its_multiplicity(power: int) -> None:
    field = NumberField()
    coefficients = [field(c) for c in np.polynomial.polynomial.polypow([-1, 3], power).astype(int).tolist()]
    [root] = positive_roots(coefficients)
    for _ in range(30):
        root = root.halved()
        assert root.low < Fraction(1, 3) < root.high
    assert is_isolated(root)
