"""Paths of bodies with an outline: minimizers from the last one, and an end after so much work."""

from __future__ import annotations

import pytest

from nonsmooth.analysis.bodies import path as body_path
from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers import ellipse_minimizer
from nonsmooth.analysis.minimizers.ellipse_minimizer import WarmMinimizer
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.analysis.minimizers.sum_of_supports import by_smoothing
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.friction_set import UnitDiscs


def smooth(name: str) -> SmoothRule:
    rule = contact_rule(name)
    assert isinstance(rule, SmoothRule)
    return rule


def test_a_body_that_all_wheels_carry_along_hardly_begins_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    """On parallel rollers all contacts stick: multipliers go on from the last minimizer, with the same proof.

    The path is known by the definition: nothing slips.
    """
    asked: list[bool] = []
    begun: list[bool] = []
    warm, cold = WarmMinimizer.minimize, by_smoothing

    def counted_warm(self: WarmMinimizer, loads: Floats) -> Minima:
        asked.append(True)
        return warm(self, loads)

    def counted_cold(weights: Floats, maps: Floats, targets: Floats, sets: UnitDiscs) -> tuple[Floats, Floats]:
        begun.append(True)
        return cold(weights, maps, targets, sets)

    monkeypatch.setattr(WarmMinimizer, "minimize", counted_warm)
    monkeypatch.setattr(ellipse_minimizer, "by_smoothing", counted_cold)
    scene = load_scene("roller-bed")
    path = BodyPath(smooth("roller").contacts(scene), scene).follow((0.1, 0.05, 0.2), 0.1)
    assert path.end.state == pytest.approx((0.2, 0.05, 0.2), abs=1e-9)
    assert len(begun) < len(asked) / 4


def test_a_path_of_a_body_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was followed until then is the path."""
    scene = load_scene("carton-on-6x6")
    whole = BodyPath(smooth("ellipse").contacts(scene), scene).follow((0.15, 0.1, 0.08), 2.0)
    monkeypatch.setattr(body_path, "MOST_RATES", 400)
    part = BodyPath(smooth("ellipse").contacts(scene), scene).follow((0.15, 0.1, 0.08), 2.0)
    assert part.end.reason is EndReason.STEPS
    assert 0 < part.end.t < whole.end.t
    assert part.end.state == pytest.approx(whole.at(part.end.t), abs=1e-9)
