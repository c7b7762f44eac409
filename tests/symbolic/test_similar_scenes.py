"""Scenes that must behave alike: what the changes do to wheels, loads and formulas."""

from __future__ import annotations

from fractions import Fraction

import pytest

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.mechanics.scene import LoadTable
from nonsmooth.symbolic.mechanics.similar_scenes import moved, scaled, with_friction_ratio
from nonsmooth.symbolic.systems.switched_system import scaled_system, with_rate_ratio
from tests.conftest import Arrays

FACTOR = Fraction(10) ** -9


def test_twists_of_a_scaled_array(arrays: Arrays) -> None:
    """The same velocities, rotation by 1/s; and a speed that was the rim's length stays."""
    scene = arrays.random(2, 5)
    before, after = (build_nearest_partition(s) for s in (scene, scaled(scene, FACTOR)))
    assert [c.twists[0].omega for c in after.cells] == [c.twists[0].omega / FACTOR for c in before.cells]
    x, y = scene.check.equilibrium
    for cell, small in zip(before.cells, after.cells, strict=True):
        assert small.twists[0].pose_rate((x * FACTOR, y * FACTOR)) == cell.twists[0].pose_rate((x, y))
    assert scaled(scene, FACTOR).check.radius == scene.check.radius * FACTOR


@pytest.mark.parametrize("change", ["scaled", "moved"])
def test_a_load_table_goes_along(arrays: Arrays, change: str) -> None:
    scene = arrays.four_wheel()
    rows = tuple((scene.field(k), scene.field(k + 1), scene.field(-k)) for k in range(1, 5))
    loaded = type(scene.contact)(scene.contact.rule, LoadTable(rows))
    table = type(scene)(scene.name, scene.field, scene.wheels, loaded, scene.check)
    after = scaled(table, FACTOR) if change == "scaled" else moved(table, Fraction(5), Fraction(-3))
    here = (Fraction(1, 7), Fraction(2, 5))
    there = (here[0] * FACTOR, here[1] * FACTOR) if change == "scaled" else (here[0] + 5, here[1] - 3)
    assert isinstance(after.contact.loads, LoadTable)
    for old, new in zip(rows, after.contact.loads.rows, strict=True):
        assert old[0] + old[1] * here[0] + old[2] * here[1] == new[0] + new[1] * there[0] + new[2] * there[1]


def test_friction_ratio(arrays: Arrays) -> None:
    ratio = Fraction(1, 10**12)
    for wheel in with_friction_ratio(arrays.random(1, 4), ratio).wheels:
        assert wheel.friction.side / wheel.friction.roll == ratio


@pytest.mark.parametrize("name", ["flower", "eq-4", "relay-oscillator-damped"])
def test_scaled_systems_are_the_same_motion_in_other_units(name: str) -> None:
    """``k s f(x/s)`` at ``s x`` is ``k s f(x)``."""
    scene, speed = load_system(name), Fraction(7, 3)
    other = scaled_system(scene, FACTOR, speed)
    point = (Fraction(3, 10), Fraction(-1, 7))

    def signs(at: tuple[Fraction, Fraction]):  # type: ignore[no-untyped-def]  # a sign function at a point
        return lambda inner: inner((scene.field(at[0]), scene.field(at[1]))).sign()

    there = (point[0] * FACTOR, point[1] * FACTOR)
    for own, changed in zip(scene.velocity(signs(point)), other.velocity(signs(there)), strict=True):
        assert changed(there) == own(point) * speed * FACTOR
    first, second = with_rate_ratio(scene, speed).velocity(signs(point))
    assert first(point) == scene.velocity(signs(point))[0](point)
    assert second(point) == scene.velocity(signs(point))[1](point) * speed
