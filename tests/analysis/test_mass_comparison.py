"""Bodies with mass and an outline beside the paths of the contact rules, as the mass goes to zero."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pytest
from rich.console import Console

from nonsmooth.analysis.bodies import mass_study as studies
from nonsmooth.analysis.bodies.mass_study import MassStudy, mass_ladder, mass_study, plate, rule_path
from nonsmooth.analysis.trajectories.result import EventKind, Trajectory
from nonsmooth.reports.simulations.masses import MassResult
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from tests.analysis.test_body_path import pushed_back
from tests.conftest import Arrays
from tests.thorough import keep, thorough

UNTIL, SLIDING = 0.2, 0.5  # the plate begins to slide at 0.211
SLOPE = 0.15  # of log distance against log mass, where 1 is expected


def ladder_study(scene: Scene, mass: float, count: int, start: tuple[float, float, float], until: float) -> MassStudy:
    assert scene.body is not None
    return mass_study(scene, mass_ladder(plate(scene.body, mass), count), start, until)


@thorough  # the small one: test_masses_are_compared_where_wheels_leave, reports/test_bodies.py
def test_the_distance_from_rule_ellipse_falls_like_the_mass_through_changes_of_the_wheels() -> None:
    scene = whole(load_scene("carton-on-6x6"))
    start = (1.3, 0.15, 0.0)
    study = ladder_study(scene, 1e-3, 2, start, UNTIL)
    assert EventKind.LEAVE in {event.kind for event in rule_path(scene, "ellipse", start, UNTIL).events}
    for heavy, light in pairwise(study.rows):
        fall = heavy.distance("ellipse").position / light.distance("ellipse").position
        assert np.log10(fall) == pytest.approx(1, abs=SLOPE)
    own = study.rows[-1].distance("ellipse").position
    assert study.limits is not None
    assert {limit.rule for limit in study.limits} == {"nearest", "box", "roller"}
    for limit in study.limits:
        assert abs(study.rows[-1].distance(limit.rule).position - limit.position) <= own


@thorough
def test_no_limit_is_stated_where_the_path_slides_along_an_edge(arrays: Arrays) -> None:
    scene, _ = pushed_back(arrays)
    study = ladder_study(whole(scene), 1e-2, 1, (0.3, -0.2, 0.0), SLIDING)
    assert study.limits is None
    assert min(row.distance("ellipse").position for row in study.rows) > 0.05  # and indeed they do not meet
    shown = MassResult(scene, study)
    assert shown.facts()["limits"] is None
    console = Console(width=100, record=True)
    with console.capture() as captured:
        console.print(*shown.views())
    assert "no limit is stated" in captured.get()
    assert "-> 0" not in captured.get()


@pytest.mark.parametrize(("rules", "until"), keep(1, [("ellipse alone", 0.215), ("all", 0.215), ("all", 0.25)]))
def test_a_path_that_slides_along_an_edge_is_no_limit(
    arrays: Arrays, monkeypatch: pytest.MonkeyPatch, rules: str, until: float
) -> None:
    scene, start = whole(pushed_back(arrays)[0]), (0.3, -0.2, 0.0)
    path = rule_path(scene, "ellipse", start, until)
    assert EventKind.SLIDE in {event.kind for event in path.events}
    before = next(event.t for event in path.events if event.kind is EventKind.SLIDE)

    def of_rule(scene: Scene, rule: str, start: Sequence[float], until: float) -> Trajectory:
        if rule != "ellipse" and rules != "all":
            raise ValueError("left out")
        return rule_path(scene, rule, start, until)

    monkeypatch.setattr(studies, "rule_path", of_rule)
    assert mass_study(scene, (), start, until).limits is None
    assert mass_study(scene, (), start, float(before) / 2).limits is not None
