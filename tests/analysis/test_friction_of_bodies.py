"""Bodies with mass under the friction sets of their own wheels: rollers that turn, and rubber beside rollers.

Against Newton's law with fixed steps, written anew (:mod:`tests.oracles.heavy_bodies`), and against the path of the
rule to which light bodies tend.
"""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.bodies.mass_study import body_path, mass_ladder, mass_study, rules_by_limit
from nonsmooth.analysis.dynamics.newton_euler import RigidBody
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Friction, Scene
from tests.oracles.heavy_bodies import HeavyTable
from tests.thorough import thorough

BODY = RigidBody(0.1, 0.08)
START, UNTIL = (0.5, 0.3, 0.3), 0.6
ROUNDED = 0.004  # of the oracle: its forces differ by as much where a wheel nearly sticks
APART = 2e-3  # of poses: the largest seen 9e-4


def four_wheels(*rules: str) -> Scene:
    """Wheels whose bearings pass on a fifth of the friction, or rubber ones that are alike in all directions."""
    scene = load_scene("four-wheel")
    number = scene.field.rational
    wheels = []
    for wheel, rule in zip(scene.wheels, rules, strict=True):
        side = number(Fraction(1, 5)) if rule == "roller" else number(Fraction(1))
        friction = Friction(number(Fraction(1)), side, rule if len(set(rules)) > 1 else "")
        wheels.append(replace(wheel, friction=friction))
    rule = "mixed" if len(set(rules)) > 1 else rules[0]
    return replace(scene, wheels=tuple(wheels), contact=replace(scene.contact, rule=rule))


def table(scene: Scene) -> HeavyTable:
    """The same in the words of the oracle: where bearings hold all the contact does, a disc is not cut."""
    rims = np.array([[float(x) for x in wheel.direction] for wheel in scene.wheels])
    given = [wheel.given_speed for wheel in scene.wheels]
    speeds = [np.hypot(*rim) if own is None else float(own) for rim, own in zip(rims, given, strict=True)]
    friction = np.array([[float(wheel.friction.roll), float(wheel.friction.side)] for wheel in scene.wheels])
    places = np.array([[float(x) for x in wheel.position] for wheel in scene.wheels])
    headings, ratio = np.arctan2(rims[:, 1], rims[:, 0]), BODY.inertia / BODY.mass
    return HeavyTable(places, headings, np.array(speeds), friction, 1 / BODY.mass, ratio, friction[:, 1], ROUNDED)


@pytest.mark.parametrize(
    "rules",
    [("ellipse", "ellipse", "roller", "roller"), pytest.param(("roller",) * 4, marks=thorough)],
    ids=str,
)
def test_a_body_moves_by_the_forces_of_its_own_wheels(rules: tuple[str, ...]) -> None:
    scene = four_wheels(*rules)
    end = np.array(body_path(scene, BODY, START, UNTIL).trajectory.end.state)
    _, states = table(scene).follow(np.array([START]), UNTIL)
    assert np.abs(end - states[-1, 0, :3]).max() < APART
    whole = np.array(body_path(scene.under("ellipse"), BODY, START, UNTIL).trajectory.end.state)
    assert np.abs(end - whole).max() > 5 * APART  # so plain ellipses would be seen


def test_light_bodies_tend_to_the_path_of_their_own_rule() -> None:
    """Where rollers turn D is linear in pieces, and hardly damps: the distance falls like sqrt(m)."""
    scene = four_wheels(*["roller"] * 4)
    assert rules_by_limit(scene)[0] == "roller"
    study = mass_study(scene, mass_ladder(RigidBody(1e-4, 1e-4), 2), START, 0.2)
    heavy, light = (row.distance("roller").position for row in study.rows)
    assert np.log10(heavy / light) == pytest.approx(0.5, abs=0.1)
    limits = {limit.rule: limit.position for limit in study.limits or ()}
    assert set(limits) == {"nearest", "box", "ellipse"}
    assert light < min(limits.values()) / 5
