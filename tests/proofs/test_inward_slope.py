"""Discs of starts that come home under rules without cells, against minimizers of D all over them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.oracles.clause_evidence import evidence_holds
from tests.thorough import few, keep

INWARD = ("four-wheel", "four-wheel-side", "ring-5", "ring-6", "grid-4x4")
POINTS = 200


def translation_of(scene: Scene) -> EllipseTranslation:
    found = check_theorem4(scene, beside=False).results["translation"]
    assert isinstance(found, EllipseTranslation)
    assert evidence_holds(found)
    return found


def largest_product(scene: Scene, radius: float, seed: int = 5) -> float:
    """The largest ``c . v/|c|`` over random points of a disc, most of them near its border or its centre."""
    centred, rng = scene.recentred(), np.random.default_rng(seed)
    angles = rng.uniform(0, 2 * np.pi, POINTS)
    reaches = radius * rng.choice([0.02, 0.3, 0.9, 1.0], POINTS) * rng.uniform(0.9, 1.0, POINTS)
    points = reaches[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
    twists = minima_under(smooth_rule_of(centred), centred, points).twists
    return float(((points * twists[:, :2]).sum(axis=1) / reaches).max())


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
@pytest.mark.parametrize("name", INWARD)
def test_the_distance_falls_all_over_the_disc(name: str, rule: str) -> None:
    scene = load_scene(name, rule=rule)
    found = translation_of(scene)
    assert found.home_radius is not None
    assert found.home_radius == scene.check.radius
    assert largest_product(scene, float(found.home_radius)) < 0


def test_a_spin_at_the_point_does_not_matter() -> None:
    scene = load_scene("spiral-30", rule="ellipse")
    found = translation_of(scene)
    assert found.home_radius is not None
    assert largest_product(scene, float(found.home_radius)) < 0


@few(4)
@pytest.mark.parametrize("name", builtin_scenes())
def test_no_disc_is_claimed_where_the_distance_may_grow(name: str) -> None:
    """Every built-in scene: where a minimizer moves outward, no disc reaches there."""
    found = check_theorem4(load_scene(name, rule="ellipse"), beside=False).results["translation"]
    if isinstance(found, EllipseTranslation) and found.home_radius is None:
        assert found.region_radius is None
        return
    assert found.verdict is Translation.ASYMPTOTICALLY_STABLE


@pytest.mark.parametrize(("name", "radius"), keep(1, [("ring-6", Fraction(3, 5)), ("grid-4x4", Fraction(5, 4))]))
def test_the_disc_ends_where_a_spring_lifts_off(name: str, radius: Fraction) -> None:
    """Beyond, the loads have another form: the disc is no larger than the part of the square that holds the point."""
    base = load_scene(name, rule="ellipse")
    wide = replace(base, check=replace(base.check, radius=base.field(radius)))
    found = translation_of(wide)
    assert found.home_radius is not None
    assert 0 < found.home_radius < wide.check.radius
    assert largest_product(wide, float(found.home_radius)) < 0


def test_another_disc_is_refused() -> None:
    found = translation_of(load_scene("four-wheel", rule="ellipse"))
    assert found.home_radius is not None
    assert not evidence_holds(replace(found, region_radius=found.home_radius * 2))
    saddle = translation_of(load_scene("elliptic", rule="ellipse"))
    assert saddle.home_radius is None
    assert not evidence_holds(replace(saddle, region_radius=saddle.point.scene.check.radius))
