"""Energies beside imaginary eigenvalues, forms of one weight, and kept ones that solutions leave: verdicts of chains.

Each is confirmed by paths from small starts, in small steps that know nothing of V, and by the stand-alone checker.
"""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.linear_program import least_sum, some_contradict
from nonsmooth.proofs.kernel.homogeneity import homogeneity_of
from nonsmooth.proofs.many_states import lyapunov_search
from nonsmooth.proofs.system_certificates import certificate_of
from tests.oracles.floats import Floats, runge_kutta, velocity
from tests.plain import built, decided, refused
from tests.thorough import keep

STARTS = 40
STEP, SMALL_STEP = 0.05, 0.01  # of continuous fields with rates up to 2, and of those that jump


def farthest(
    rhs: tuple[str, ...], starts: Floats, time: float, orders: tuple[int, ...] = (1, 1, 1), length: float = STEP
) -> Floats:
    """Sizes ``max |x_k|^(1/r_k)`` along paths over those at the start, of shape (100, starts)."""
    powers, z, sizes = 1 / np.array(orders)[:, None], starts.copy(), []
    every = max(round(time / length / 100), 1)
    for step in range(100 * every):
        z = runge_kutta(lambda places: velocity(rhs, places), z, length)
        if step % every == every - 1:
            sizes.append(np.max(np.abs(z) ** powers, axis=0))
    return np.asarray(sizes / np.max(np.abs(starts) ** powers, axis=0))


def spheres(size: float) -> Floats:
    drawn = np.random.default_rng(5).normal(size=(3, STARTS))
    return np.asarray(size * drawn / np.linalg.norm(drawn, axis=0))


@pytest.mark.parametrize(
    "text",
    keep(
        2,
        [
            "y; z; -x - y - z + Max(x, 0)/2",  # on one side neutral, on the other one stable
            "y; z; -2*x - y - 2*z - Max(y, 0)",
            "y; z; -x - y - z + Max(x, 0)/3",
        ],
    ),
)
def test_a_cell_with_imaginary_eigenvalues_beside_a_stable_one(text: str) -> None:
    rhs = tuple(text.split("; "))
    result = decided(rhs)
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert refused(certificate_of(result)) == ""
    sizes = farthest(rhs, spheres(0.1), 120.0)
    assert sizes.max() < 4
    assert sizes[-1].max() < 0.05


@pytest.mark.parametrize("slope", ["-1/2", "3/2"])
def test_beside_a_side_that_grows_the_point_is_unstable(slope: str) -> None:
    rhs = ("y", "z", f"-x - y - z + ({slope})*Max(x, 0)")
    result = decided(rhs)
    assert result.verdict is Translation.UNSTABLE
    assert farthest(rhs, spheres(1e-3), 150.0).max() > 50


@pytest.mark.parametrize("text", keep(1, ["y; -x; x**2", "y; -x; Abs(x)"]))
def test_a_kept_form_shows_what_it_carries_away(text: str) -> None:
    rhs = tuple(text.split("; "))
    result = decided(rhs)
    assert result.verdict is Translation.UNSTABLE
    assert refused(certificate_of(result)) == ""
    starts = np.array([[0.05], [0.0], [0.0]])
    assert farthest(rhs, starts, 400.0).max() > 8


@pytest.mark.parametrize("text", keep(1, ["y; z; -2*sign(z + sign(y))", "y; z; -sign(y)"]))
def test_a_chain_before_a_relay_keeps_a_form_of_one_weight(text: str) -> None:
    rhs = tuple(text.split("; "))
    result = decided(rhs)
    assert result.verdict is Translation.STABLE
    assert refused(certificate_of(result)) == ""
    directions = np.array([[0.3, -1.0, 1.0, 1.0], [1.0, 1.0, -1.0, 0.0], [1.0, 1.0, 0.0, -1.0]])
    starts = np.array([[1e-3], [1e-2], [1e-1]]) * directions
    sizes = farthest(rhs, starts, 40.0, (3, 2, 1), SMALL_STEP)
    assert sizes.max() < 3
    assert sizes[-30:].max() > 0.5  # it does not come to the point


@pytest.mark.parametrize(
    ("rhs", "weights"),
    [
        (("y", "z", "-sign(y) - sign(z + 1)*y"), None),  # a term of another weight
        (("y", "z", "-2*sign(z + sign(y))"), (3, 2, 1)),  # z + 1 and z - 1 keep their signs beside the point
        (("y", "-x", "Abs(x)"), (1, 1, 1)),
    ],
)
def test_weights_beside_the_point(rhs: tuple[str, ...], weights: tuple[int, ...] | None) -> None:
    system = built(rhs)
    found = homogeneity_of(system, system.check.radius)
    assert (None if found is None else found.weights) == weights


def test_few_products_are_asked_that_fail_nearer_an_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of 216 products on four squares all but two are refuted beside an axis; proofs of a hundred took minutes."""
    asked: list[str] = []
    monkeypatch.setattr(lyapunov_search, "_shown", lambda _, formula, *rest: asked.append(formula.text))
    assert lyapunov_search.find_growing_product(built(("-x**3 + y", "x**6 - y**3"))) is None
    assert len(asked) < 10


def test_few_rows_contradict_each_other_only_where_all_do() -> None:
    drawn, outcomes = np.random.default_rng(3), set()
    for _ in range(30):
        count = int(drawn.integers(2, 6))
        rows = drawn.normal(size=(400, count)) + drawn.normal(size=count) * drawn.choice([0.5, 3.0])
        limits = np.r_[np.zeros(399), -1.0]
        least = least_sum(rows, limits, np.ones(count), 64.0)
        contradict = some_contradict(rows, limits, np.ones(count), 64.0)
        assert least is None or not contradict
        outcomes.add((least is None, contradict))
    assert {(True, True), (False, False)} <= outcomes


@pytest.mark.parametrize("radius", keep(1, ["1/8", "1/100", "1/2"]))
def test_an_energy_of_unlike_powers_is_found_whatever_the_size_of_the_cube(radius: str) -> None:
    """With ``V = x^2 + y^4/2`` and ``V' = -2 x^4`` the coefficients over those of the cube are unlike by its square."""
    rhs = ("-x**3 + y**4", "-x*y")
    result = decided(rhs, radius=radius)
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert refused(certificate_of(result)) == ""
    starts = 0.1 * np.array([[np.cos(a), np.sin(a)] for a in np.arange(8)]).T
    z, energy = starts, [starts[0] ** 2 + starts[1] ** 4 / 2]
    for _ in range(400):
        z = runge_kutta(lambda places: velocity(rhs, places), z, 0.5)
        energy.append(z[0] ** 2 + z[1] ** 4 / 2)
    assert (np.diff(energy, axis=0) <= 0).all()
    assert (np.linalg.norm(z, axis=0) < np.linalg.norm(starts, axis=0)).all()
