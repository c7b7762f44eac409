"""Paths of bodies with an outline: minimizers from the last one, and an end after so much work."""

from __future__ import annotations

import pytest

from nonsmooth.analysis.bodies import path as body_path
from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.minimizers import ellipse_minimizer
from nonsmooth.analysis.minimizers.cut_norms import minimize_cut_norms
from nonsmooth.analysis.minimizers.ellipse_minimizer import WarmInterior
from nonsmooth.analysis.minimizers.minimum import Minima
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.symbolic.files.scene_file import load_scene


def smooth(name: str) -> SmoothRule:
    rule = contact_rule(name)
    assert isinstance(rule, SmoothRule)
    return rule


def test_a_body_that_all_wheels_carry_along_hardly_needs_interior_points(monkeypatch: pytest.MonkeyPatch) -> None:
    """On parallel rollers all contacts stick: Newton's method goes on from the last minimizer, with the same proof.

    The path is known by the definition: nothing slips.
    """
    asked: list[bool] = []
    begun: list[bool] = []
    warm, cold = WarmInterior.minimize, minimize_cut_norms

    def counted_warm(self: WarmInterior, loads: Floats) -> Minima:
        asked.append(True)
        return warm(self, loads)

    def counted_cold(*arguments: Floats) -> tuple[Floats, Floats]:
        begun.append(True)
        return cold(*arguments)

    monkeypatch.setattr(WarmInterior, "minimize", counted_warm)
    monkeypatch.setattr(ellipse_minimizer, "minimize_cut_norms", counted_cold)
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
