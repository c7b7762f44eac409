"""The Filippov set at a point as a script holds it, and what of it a notebook shows."""

from __future__ import annotations

from collections.abc import Iterator
from decimal import Decimal
from fractions import Fraction

import matplotlib as mpl
import pytest
import sympy
from matplotlib import pyplot as plt

import nonsmooth as ns
from nonsmooth.analysis.cells.filippov import filippov_twists, upper_derivative_at
from nonsmooth.reports.interface.filippov_set import FilippovSet
from nonsmooth.symbolic import annihilator, constraint_matrix, stacked_constraints, wheel_constraints


@pytest.fixture(autouse=True)
def _no_window() -> Iterator[None]:
    mpl.use("Agg")
    yield
    plt.close("all")


def ring(**more: object) -> ns.Array:
    return ns.Array.ring(4, radius="sqrt(2)", phase="pi/4", mu_roll=1, mu_side="1/2", **more)


def test_the_velocities_that_meet_at_a_point() -> None:
    array = ring()
    edge = array.filippov_set((0, "1/4"))
    assert edge.twists == filippov_twists(array.partition, edge.point)
    assert [state.name for _, state in edge.members] == ["R1 S1 R2", "R2 S2 R1"]
    assert edge.upper_derivative == upper_derivative_at(array.partition, edge.point) == edge.rates[0]
    assert [str(entry) for entry in edge.velocities[0]] == ["-sqrt(2)/8", "-sqrt(2)"]
    assert not edge.holds_zero


def test_weights_mix_the_velocities_into_zero() -> None:
    centre = ring().filippov_set((0, 0))
    assert centre.holds_zero
    assert centre.weights is not None
    assert sum(centre.weights) == 1
    for k in range(2):
        mixed = [weight * velocity[k] for weight, velocity in zip(centre.weights, centre.velocities, strict=True)]
        assert sum(mixed) == 0


def test_rates_are_about_the_checked_point() -> None:
    """``V = |c - c*|^2``: the same numbers as of the array moved to the origin."""
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    moved = array.with_(at=("1/2", "1/4"))
    found = moved.filippov_set(("1/4", "1/8"))
    recentred = moved.check().evidence.partition
    assert recentred is not None
    x, y = (recentred.scene.field.one * Fraction(value) for value in ("-1/4", "-1/8"))
    assert found.upper_derivative == upper_derivative_at(recentred, (x, y))


@pytest.mark.parametrize("quarter", [0.25, "1/4", "0.25", Fraction(1, 4), Decimal("0.25"), sympy.Rational(1, 4)])
def test_a_coordinate_means_what_it_says(quarter: object) -> None:
    assert ring().filippov_set((0, quarter)).point[1] == Fraction(1, 4)


@pytest.mark.parametrize(
    ("point", "message"),
    [
        ((0, 2), r"required a point of the checked square, received \(0, 2\)"),
        ((0, "sqrt(2)/8"), "required rational coordinates, received 'sqrt"),
        ((0, float("nan")), "required rational coordinates, received nan"),
        ((0, "1/0"), "required rational coordinates, received '1/0'"),
    ],
)
def test_other_points_are_refused(point: tuple[object, object], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ring().filippov_set(point)


@pytest.mark.parametrize("rule", ["nearest", "box"])
@pytest.mark.parametrize("point", [(0, 0), (0, "1/4"), ("1/8", "1/4")])
def test_it_shows_itself(rule: str, point: tuple[object, object]) -> None:
    found = ring(rule=rule, name="<i>").filippov_set(point)
    lines = repr(found).splitlines()
    assert len(lines) == 1 + len(found.members)
    html = found._repr_html_()
    assert html.count("<tr>") == 1 + len(found.members)
    assert "<i>" not in html
    _, axes = plt.subplots()
    assert found.plot(axes) is axes
    labels = " ".join(text.get_text() for text in axes.texts)
    assert all(str(cell) in labels for cell, _ in found.members)


def test_the_scale_of_the_rates_stands_beside_a_figure_of_its_own() -> None:
    assert len(ring().plot(show="rates").figure.axes) == 2
    figure, axes = plt.subplots()
    ring().plot(axes, show="rates")
    assert figure.axes == [axes]


@pytest.mark.usefixtures("without_other_rules")
def test_destinations_are_a_table_in_a_notebook() -> None:
    array = ns.load("off-center")
    assert isinstance(array, ns.Array)
    destinations = array.check().destinations
    assert destinations is not None
    assert "rests at a point" in destinations._repr_html_()
    assert "(0.5, 0.25)" in destinations._repr_html_()


def test_constraints_are_matrices_in_a_notebook() -> None:
    array = ring()
    wheel, state = array.scene.wheels[0], array.partition.states[0]
    own = sympy.Matrix([[entry.to_sympy() for entry in row] for row in constraint_matrix(wheel)])
    assert wheel_constraints(wheel) == own
    assert sympy.simplify(stacked_constraints(state) * annihilator(state)) == sympy.zeros(3, 1)
    assert state.twist.omega._repr_latex_() == f"${state.twist.omega.latex()}$"


def test_it_is_a_public_name() -> None:
    assert ns.FilippovSet is FilippovSet
