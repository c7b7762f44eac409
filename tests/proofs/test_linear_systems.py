"""Quadratic functions of linear systems: short, nearly as fast as solutions, and never faster."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel_strategies import linear_matrix, rate_of, short_forms
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.decay_rate import DecayKind
from tests.plain import built
from tests.thorough import keep


def random_matrix(seed: int, count: int) -> np.ndarray:
    """A matrix whose eigenvalues have real parts of at most -1/4."""
    drawn = np.random.default_rng(seed).integers(-4, 5, size=(count, count)).astype(float)
    return drawn - np.eye(count) * (np.ceil(np.linalg.eigvals(drawn).real.max()) + 1 / 4)


@pytest.mark.parametrize("count", [2, 3, 4, 6])
@pytest.mark.parametrize("seed", keep(2, range(30)))
def test_forms_keep_a_good_part_of_the_rate(seed: int, count: int) -> None:
    """Against generalized eigenvalues, and the rate of solutions themselves."""
    matrix = random_matrix(seed, count)
    best = -2 * np.linalg.eigvals(matrix).real.max()
    forms = list(short_forms(matrix))
    assert forms
    for form in forms:
        assert (form == form.T).all()
        assert (np.diag(form) % 2 == 0).all()
        falls = -(matrix.T @ form + form @ matrix)
        rate = scipy.linalg.eigh(falls, form, eigvals_only=True).min()
        assert rate_of(form, matrix) == pytest.approx(rate, rel=1e-6)
        assert best / 4 <= rate <= best * (1 + 1e-9)


def test_the_smallest_form_comes_first() -> None:
    """Of an oscillator the one whose level sets are its own ellipses; of a stiff one the best form has long numbers."""
    (first, *_) = short_forms(np.array([[0.0, 1], [-1, -1]]))
    assert first.tolist() == [[2, 1], [1, 2]]
    (first, *_) = short_forms(np.diag([-1.0, -3]))
    assert first.tolist() == [[2, 0], [0, 2]]
    stiff = np.array([[0.0, 1], [-1e6, -1e3]])
    assert all(rate_of(form, stiff) > 0 for form in short_forms(stiff))
    assert not list(short_forms(np.array([[0.0, 1], [-1, 0]])))
    assert not list(short_forms(np.array([[1.0]])))


EXACT = [
    (("y", "-x - y"), "x**2 + x*y + y**2", Fraction(1)),
    (("-x", "-y"), "x**2 + y**2", Fraction(2)),
    (("-x", "-y", "-z"), "x**2 + y**2 + z**2", Fraction(2)),
]


@pytest.mark.parametrize(("rhs", "function", "kappa"), EXACT)
def test_rates_are_exact_where_they_are_short(rhs: tuple[str, ...], function: str, kappa: Fraction) -> None:
    result = decide_system(built(rhs))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.reach.everywhere
    assert result.function.text == function
    rate = result.reach.rate
    assert rate is not None
    assert (rate.decay, rate.kappa) == (DecayKind.EXPONENTIAL, kappa)
    claims = certificate_of(result)["statement"]["claims"]
    assert {"attracts": "everywhere"} in claims
    assert any(own.get("rate", {}).get("within", "") is None for own in claims)


def test_rates_of_several_states_are_near_those_of_solutions() -> None:
    """Chains of equal poles had 1/40 of the rate that this V shows."""
    rate = decide_system(built(["y", "z", "-x - 3*y - 3*z"])).reach.rate
    assert rate is not None
    assert Fraction(3, 4) < rate.kappa < 2


@pytest.mark.parametrize(
    ("rhs", "is_linear"),
    [
        (("-x + 2*y", "-y"), True),
        (("-x + 2*y", "-y - y**3"), False),
        (("-x + Abs(y)", "-y"), False),
        (("-x + 2*y + 1", "-y"), False),
        (("-x*sqrt(2)", "-y"), True),
    ],
)
def test_only_linear_systems_have_a_matrix(rhs: tuple[str, ...], is_linear: bool) -> None:
    assert (linear_matrix(built(rhs)) is not None) == is_linear


def test_a_stated_function_comes_before() -> None:
    """What the scene names is examined as it is."""
    result = decide_system(built(["y", "-x - y"], lyapunov="3*x**2/2 + x*y + y**2"))
    assert result.function.text == "3*x**2/2 + x*y + y**2"
