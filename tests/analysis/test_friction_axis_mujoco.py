"""Rule ``roller`` with friction axes against MuJoCo: rollers on real bearings whose axes stand askew to the rims."""

from __future__ import annotations

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.roller_engine import SPEED, random_array, relative_errors, settled_twist

MEDIAN = 2e-3  # relative error of a twist, as for rollers across the rims; 3e-5 was seen, and 2e-3 in one of these five
SLOWED = SPEED / 3  # the fastest rim of the scene runs at 3


def test_twists_of_mecanum_wheels_in_the_engine() -> None:
    """Where a twist jumps, the loads of the engine decide: so the median counts.  Without the axis all are far off."""
    errors = np.array([relative_errors(*random_array(seed, askew=True))[0] for seed in range(5)])
    assert np.median(errors) < MEDIAN


def test_the_scene_turns_in_the_engine_as_it_says() -> None:
    model = contact_model(load_scene("mecanum-4"))
    slow = type(model).build(model.positions, model.rims, SLOWED * model.speeds, (1.0, 0.02), axes=list(model.axes))
    twist, _ = settled_twist(slow, np.array([0.1, 0.05]))
    assert twist / SLOWED == pytest.approx([0, 0, 1], abs=5e-3)
