"""The dissipation functional: its two readings by hand, their convexity, and the duality bound."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from numpy.typing import NDArray

from nonsmooth.analysis.fields.contact_model import ContactModel, ContactRows, contact_model
from nonsmooth.analysis.minimizers.dissipation import Functional, dissipation, input_power, share_of_limit, usage
from nonsmooth.analysis.minimizers.minimum import balance_forces, imbalance
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.constraints import constraint_matrix

ROUNDING = 1e-13  # relative, of sums of a few dozen terms
BOTH = pytest.mark.parametrize("functional", Functional)

entries = st.floats(-5, 5, allow_subnormal=False)
twists = st.tuples(entries, entries, entries).map(np.array)


@pytest.fixture
def two_wheels() -> ContactModel:
    """Rims along x and along y, frictions 1 and 1/2, speeds 1 and 2."""
    return ContactModel.build([(0, 0), (2, 0)], [(3, 0), (0, 5)], [1, 2], (1, 0.5))


def random_model(seed: int, count: int) -> ContactModel:
    rng = np.random.default_rng(seed)
    friction = rng.uniform(0.1, 2, (count, 2))
    return ContactModel.build(
        rng.normal(size=(count, 2)), rng.normal(size=(count, 2)), rng.normal(size=count), friction
    )


@pytest.mark.parametrize("name", builtin_scenes())
def test_rows_are_the_exact_constraints_rounded_once(name: str) -> None:
    scene = load_scene(name)
    model = contact_model(scene)
    exact = np.array([[float(x) for x in row] for wheel in scene.wheels for row in constraint_matrix(wheel)])
    np.testing.assert_allclose(np.column_stack([model.rows, -model.targets]), exact, rtol=0, atol=1e-15 * len(exact))


def test_geometry_of_the_model(two_wheels: ContactModel) -> None:
    np.testing.assert_array_equal(two_wheels.rims, [(1, 0), (0, 1)])
    np.testing.assert_array_equal(two_wheels.sides, [(0, 1), (-1, 0)])
    np.testing.assert_array_equal(two_wheels.speeds, [1, 2])
    np.testing.assert_array_equal(two_wheels.mu_roll, [1, 1])
    np.testing.assert_array_equal(two_wheels.mu_side, [0.5, 0.5])
    np.testing.assert_array_equal(two_wheels.rows, [(1, 0, 0), (0, 1, 0), (0, 1, 2), (-1, 0, 0)])


def test_slips_of_a_known_twist(two_wheels: ContactModel) -> None:
    """v = (3, 4), omega = 1: p_1 moves with (3, 4), p_2 with (3, 6)."""
    np.testing.assert_array_equal(two_wheels.slips([3, 4, 1]), [(2, 4), (4, -3)])


def test_values_by_hand(two_wheels: ContactModel) -> None:
    """Weighted slips are (2, 2) and (4, -3/2) at unit loads."""
    twist, loads = [3, 4, 1], [2, 1]
    assert dissipation(Functional.BOX, two_wheels, loads, twist) == pytest.approx(2 * 4 + 5.5)
    assert dissipation(Functional.ELLIPSE, two_wheels, loads, twist) == pytest.approx(2 * np.sqrt(8) + np.sqrt(18.25))


@BOTH
def test_points_and_twists_broadcast(functional: Functional, two_wheels: ContactModel) -> None:
    loads, many = np.array([[1.0, 2.0], [3.0, 4.0]]), np.arange(15.0).reshape(5, 3)
    table = dissipation(functional, two_wheels, loads[:, None], many[None])
    assert table.shape == (2, 5)
    assert table[1, 3] == dissipation(functional, two_wheels, loads[1], many[3])


@BOTH
@given(first=twists, second=twists, share=st.floats(0, 1))
def test_convex_in_the_twist(
    functional: Functional, first: NDArray[np.float64], second: NDArray[np.float64], share: float
) -> None:
    model, loads = random_model(1, 4), [0.1, 0.2, 0.3, 0.4]
    between = dissipation(functional, model, loads, share * first + (1 - share) * second)
    ends = dissipation(functional, model, loads, np.stack([first, second]))
    assert between <= share * ends[0] + (1 - share) * ends[1] + ROUNDING * (1 + ends.sum())


@given(twist=twists)
def test_ellipse_lies_between_the_box_and_its_diagonal(twist: NDArray[np.float64]) -> None:
    model, loads = random_model(2, 5), [0.1, 0.1, 0.2, 0.2, 0.4]
    box, ellipse = (float(dissipation(f, model, loads, twist)) for f in Functional)
    assert box / np.sqrt(2) <= ellipse * (1 + ROUNDING)
    assert ellipse <= box * (1 + ROUNDING)


@BOTH
@given(twist=twists, seed=st.integers(0, 100))
def test_power_of_balanced_forces_bounds_every_dissipation(
    functional: Functional, twist: NDArray[np.float64], seed: int
) -> None:
    """Weak duality: ``sum f b <= D(xi)``, for the forces that the repair returns from any inside their limits."""
    model = random_model(3, 4)
    loads = np.array([[0.4, 0.3, 0.2, 0.1]])
    inside = np.random.default_rng(seed).uniform(-0.6, 0.6, (1, 4, 2)) * model.limits(loads)
    forces = balance_forces(functional, model, loads, inside)
    assert imbalance(model, forces)[0] <= ROUNDING
    assert usage(functional, model, loads, forces).max() <= 1 + ROUNDING
    assert input_power(model, forces)[0] <= dissipation(functional, model, loads, twist)[0] + ROUNDING


@BOTH
def test_share_of_a_missing_limit(functional: Functional) -> None:
    """No limit and no force: nothing used. No limit and a force: infinitely much."""
    model = ContactRows(np.eye(3)[[0, 1, 0, 1]], np.zeros(4), np.array([1.0, 0.0, 1.0, 1.0]))
    np.testing.assert_array_equal(share_of_limit(model, [1, 0], [[1, 0], [0, 0]]), [[1, 0], [0, 0]])
    np.testing.assert_array_equal(usage(functional, model, [1, 0], [[0, 1], [0, -1]]), [np.inf, np.inf])


@pytest.mark.parametrize(
    ("rows", "targets", "friction", "expected"),
    [
        (np.ones((3, 3)), np.zeros(3), np.ones(3), "shape"),
        (np.ones((2, 2)), np.zeros(2), np.ones(2), "shape"),
        (np.ones((2, 3)), np.zeros(3), np.ones(2), "2 targets"),
        (np.ones((2, 3)), np.array([0, np.nan]), np.ones(2), "finite"),
        (np.ones((2, 3)), np.zeros(2), np.array([1.0, -1.0]), "friction >= 0"),
    ],
)
def test_rows_are_validated(
    rows: NDArray[np.float64], targets: NDArray[np.float64], friction: NDArray[np.float64], expected: str
) -> None:
    with pytest.raises(ValueError, match=expected):
        ContactRows(rows, targets, friction)


def test_a_rim_without_direction_is_refused() -> None:
    with pytest.raises(ValueError, match="nonzero length"):
        ContactModel.build([(0, 0)], [(0, 0)], [1], (1, 1))
