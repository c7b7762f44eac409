"""The study of masses for ``precision``: its distances are those of the mass study, in every scene's own units."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import pytest

from nonsmooth.analysis.bodies.mass_study import MASS, MASSES, mass_study
from nonsmooth.analysis.dynamics.newton_euler import disc
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.measurements.harness import Clock, LeftOut, StudyPlan, log_slope
from tests.conftest import Arrays
from tests.thorough import thorough

WITHIN = 0.2  # of the slope 1
SCALED = 1e-6  # relative: integrators take other steps in other units


def errors(plan: StudyPlan, method: str, own: slice = slice(None)) -> list[float]:
    """Those of the trials of a method, or of some of them."""
    trials = [trial for trial in plan.trials if trial.method == method]
    return [trial.judge(trial.work(Clock(60.0))).error for trial in trials[own]]


@thorough
def test_the_distance_falls_like_the_mass(arrays: Arrays) -> None:
    scene = arrays.four_wheel((1, Fraction(1, 2)))
    plan = MASS.build(scene)
    found = errors(plan, "full dynamics")
    assert log_slope(MASSES[1:], found[1:]) == pytest.approx(1, abs=WITHIN)
    study = mass_study(scene, [disc(contact_model(scene), MASSES[2] / 2)], (0.2, 0.4, 0), 2.0)
    assert found[2] == pytest.approx(study.rows[0].distance("ellipse").position, rel=SCALED)
    assert study.limits is not None
    limits = {limit.rule: limit.position for limit in study.limits}
    for rule in ("nearest", "box"):
        assert errors(plan, f"rule {rule}") == pytest.approx([limits[rule]], rel=SCALED)


@thorough
def test_units_do_not_matter(arrays: Arrays) -> None:
    """Lengths times 8 and speeds times 4: the same paths, 8 times as large."""
    scene = arrays.four_wheel((1, Fraction(1, 2)))
    wheels = tuple(
        replace(w, position=(w.position[0] * 8, w.position[1] * 8), given_speed=w.speed * 4) for w in scene.wheels
    )
    wider = replace(scene, wheels=wheels, check=replace(scene.check, radius=scene.check.radius * 8))
    small, large = (errors(MASS.build(s), "full dynamics", slice(1, 2)) for s in (scene, wider))
    assert large == pytest.approx([8 * error for error in small], rel=1e-4)  # default tolerances are absolute in part


def test_an_array_at_rest_is_left_out(arrays: Arrays) -> None:
    scene = arrays.four_wheel((1, Fraction(1, 2)))
    still = replace(scene, wheels=tuple(replace(w, given_speed=scene.field.zero) for w in scene.wheels))
    with pytest.raises(LeftOut, match="no wheel is driven"):
        MASS.build(still)
