"""Claims of certificates end in a proof that the checker takes, in a point that refutes them, or open."""

from __future__ import annotations

from fractions import Fraction
from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.proofs.checker.polynomials import Polynomial, variable
from nonsmooth.proofs.checker.positivity import Claim, Inequality, cube_guards, identity, show
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof
from nonsmooth.proofs.kernel import simplices
from nonsmooth.proofs.kernel.search import decide_claim
from tests.thorough import examples

WORK = 400
STEPS = [Fraction(k, 4) for k in range(-4, 5)]  # of a grid in the cube

# a polynomial by its coefficients, a guard likewise
Terms = dict[tuple[int, ...], int]


def terms(count: int, degree: int) -> st.SearchStrategy[Terms]:
    exponents = [e for e in product(range(degree + 1), repeat=count) if sum(e) <= degree]
    return st.dictionaries(st.sampled_from(exponents), st.integers(-4, 6), min_size=1, max_size=6)


def value(terms: Terms, point: tuple[Fraction, ...]) -> Fraction:
    total = Fraction(0)
    for exponents, coefficient in terms.items():
        term = Fraction(coefficient)
        for x, e in zip(point, exponents, strict=True):
            term *= x**e
        total += term
    return total


def claim_of(count: int, own: Terms, guard: Terms, *, strict: bool) -> Claim:
    surface = Polynomial(count, {e: Fraction(c) for e, c in guard.items()})
    inequality = Inequality(
        Polynomial(count, {e: Fraction(c) for e, c in own.items()}),
        {"s0": surface, **cube_guards(identity(count), count)},
    )
    return Claim("random", (inequality,), strict=strict)


@examples(40)
@given(st.data(), st.sampled_from((1, 2, 3)), st.booleans())
def test_outcomes_against_values_on_a_grid(data: st.DataObject, count: int, strict: bool) -> None:
    own, guard = data.draw(terms(count, 3)), data.draw(terms(count, 1))
    claim = claim_of(count, own, guard, strict=strict)
    outcome = decide_claim(claim, WORK)

    def fails_at(point: tuple[Fraction, ...]) -> bool:
        here = value(own, point)
        return any(point) and value(guard, point) > 0 and (here < 0 or (strict and not here))

    if isinstance(outcome, Proof):
        show(claim, outcome.evidence)
        assert not any(map(fails_at, product(STEPS, repeat=count)))
    elif isinstance(outcome, Counterexample):
        point = tuple(Fraction(int(x.p), int(x.q)) for x in outcome.point)
        assert fails_at(point)
        assert max(map(abs, point)) <= 1
        assert value(own, point) == Fraction(int(outcome.value.p), int(outcome.value.q))


def test_a_pair_of_fields_is_refuted_where_no_mixture_falls() -> None:
    """``p_1 + mu q_1 > 0`` and ``p_2 + mu q_2 > 0`` with q_1 = 1 and q_2 = -1 ask for ``p_1 + p_2 > 0``."""
    x = variable(1, 0)
    one = Polynomial(1, {(0,): Fraction(1)})
    guards = cube_guards(identity(1), 1)
    up, down = Inequality(x, guards, (one,), side=(1,)), Inequality(x - one.times(1), guards, (-one,), side=(-1,))
    outcome = decide_claim(Claim("face", (up, down), strict=True), WORK)
    assert isinstance(outcome, Counterexample)
    (place,) = outcome.point
    assert 2 * place - 1 <= 0


@pytest.mark.parametrize("at_origin", [False, True])
@pytest.mark.parametrize("number", [-1, 0, 1])
def test_claims_about_one_point(number: int, at_origin: bool) -> None:
    """In no variables there is the origin alone, at which something is claimed or not."""
    claim = Claim("point", (Inequality(Polynomial(0, {(): Fraction(number)}), {}),), strict=True, at_origin=at_origin)
    found = simplices.search(claim, WORK)
    assert isinstance(found, Counterexample) == (at_origin and number <= 0)
    if isinstance(found, dict):
        show(claim, found)
