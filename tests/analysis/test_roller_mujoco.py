"""Rule ``roller`` against MuJoCo with real rollers: three arrays; the benchmarks take a hundred."""

from __future__ import annotations

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from tests.roller_engine import (
    SETTLING,
    creep_rates,
    random_array,
    relative_errors,
    roller_plate,
    rubber_beside_rollers,
)
from tests.thorough import keep

TWIST = 2e-3  # relative; the largest seen of these three 3e-4
MIXED = 1e-2  # relative; the largest seen of twenty 4.5e-3: bearings brake as by elastic loads
CREEP = 2e-2  # relative; the largest seen 2e-3


@pytest.mark.parametrize("seed", [8, 13, 2])
def test_engines_settled_twist_is_that_of_rule_roller(seed: int) -> None:
    roller, ellipse, _ = relative_errors(*random_array(seed))
    assert roller < TWIST
    assert roller < ellipse / 10


@pytest.mark.parametrize("array", keep(2, range(20)))
def test_rubber_beside_rollers_settles_as_the_mixed_rule_says(array: int) -> None:
    """Every other wheel is of rubber.  The engine's own loads, which slip shifts by a thousandth of the weight."""
    wheels, start = rubber_beside_rollers(array)
    plate = roller_plate(wheels, start)
    plate.step(SETTLING)
    texts = [list(map(repr, row.tolist())) for row in np.column_stack([wheels.positions, wheels.rims, wheels.speeds])]
    made = ns.Array(
        ns.Wheel((x, y), heading=(a, b), speed=u, mu_roll=1, mu_side=repr(side), contact=("ellipse", "roller")[k % 2])
        for k, ((x, y, a, b, u), side) in enumerate(zip(texts, wheels.mu_side.tolist(), strict=True))
    )
    scenes = made.scene, made.scene.under("ellipse")
    models = [smooth_rule_of(scene).contacts(scene) for scene in scenes]
    mixed, alone = (EllipseMinimizer().minimize(model, plate.loads).twists[0] - plate.twist for model in models)
    assert np.abs(mixed).max() < MIXED * np.abs(plate.twist).max()
    assert np.abs(mixed).max() < np.abs(alone).max()


@pytest.mark.parametrize("side", [0.02, 0.5])
def test_rollers_that_stand_creep_home_whatever_their_bearings(side: float) -> None:
    """``c' = -sqrt(2) u c``: under rule box the body rests, under rule ellipse it is ``(mu_R/mu_S)^2`` as fast."""
    assert creep_rates(side) == pytest.approx(np.sqrt(2), rel=CREEP)
