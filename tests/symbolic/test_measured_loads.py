"""Loads measured at one pose and carried to others, against springs of unequal height that are pressed there."""

from __future__ import annotations

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.measured_loads import NoSpringsError, carried_table, centre_of
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.springs import pressed

ROUNDING = 1e-9


@pytest.mark.parametrize("seed", range(12))
def test_springs_of_unequal_height_are_predicted_while_none_lifts(seed: int) -> None:
    rng, field = np.random.default_rng(seed), NumberField()
    count = int(rng.integers(3, 9))
    places = np.concatenate([[(2, 1), (-2, 1), (0, -2)], rng.integers(-3, 4, (count - 3, 2))])
    moments = np.column_stack([np.ones(count), places])
    heights = rng.uniform(-0.1, 0.1, count) / count
    measured = pressed(moments, heights, np.ones(count), (0.1, -0.05))
    exact = [field(Fraction(load)) for load in measured]
    table = carried_table(exact, [(field(int(x)), field(int(y))) for x, y in places])
    rows = np.array([[float(entry) for entry in row] for row in table.rows])
    for centre in ((0.1, -0.05), (0.0, 0.0), (-0.15, 0.2)):
        loads = pressed(moments, heights, np.ones(count), centre)
        if loads.min() > 0:
            np.testing.assert_allclose(rows @ [1, *centre], loads, atol=ROUNDING)


def test_sum_and_moments_balance_exactly_everywhere() -> None:
    field = NumberField()
    places = [(field(x), field(y)) for x, y in ((1, 1), (-1, 1), (-1, -2), (1, -1), (0, 0))]
    values = [field(k) for k in (3, 1, 4, 1, 5)]
    rows = carried_table(values, places).rows
    assert [sum(row[k] for row in rows) for k in range(3)] == [1, 0, 0]
    for axis in (0, 1):
        moment = [sum(row[k] * p[axis] for row, p in zip(rows, places, strict=True)) for k in range(3)]
        assert moment == [0, int(axis == 0), int(axis == 1)]
    x, y = centre_of(values, places)
    assert [a + b * x + c * y for a, b, c in rows] == [value / 14 for value in values]


def test_wheels_on_a_line_are_refused() -> None:
    field = NumberField()
    with pytest.raises(NoSpringsError):
        carried_table([field(1)] * 3, [(field(k), field(0)) for k in range(3)])


def four(tmp_path: Path, loads: str) -> Path:
    text = "[friction]\nmu_roll = 1\nmu_side = 1\n"
    text += "".join(f"[[wheel]]\nposition = {place}\n" for place in ("[1, 1]", "[-1, 1]", "[-1, -1]", "[1, -1]"))
    path = tmp_path / "four.toml"
    path.write_text(f'{text}[contact]\nrule = "ellipse"\nloads = {loads}\n', encoding="utf-8")
    return path


def test_a_pose_that_does_not_balance_the_values_is_refused(tmp_path: Path) -> None:
    """At (0, 0) each load would change by 1/14 of the weight, 2/7 of the mean load."""
    values = "values = [1, 2, 1, 3]"
    with pytest.raises(SceneError, match=r"contact.loads.at: required \(0.142857, -0.142857\)"):
        load_scene(str(four(tmp_path, f'{{kind = "measured", {values}, at = [0, 0]}}')))
    for keys in ("at = [0, 0], within = 0.3", 'at = ["1/7", -0.14]'):
        assert load_scene(str(four(tmp_path, f'{{kind = "measured", {values}, {keys}}}')))
