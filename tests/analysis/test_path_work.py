"""Paths of bodies with an outline: minimizers from the last one, and an end after so much work."""

from __future__ import annotations

import pytest

from nonsmooth.analysis.bodies import path as body_path
from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.cells.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.fields.contact_model import Floats, contacts_under
from nonsmooth.analysis.minimizers import ellipse_minimizer
from nonsmooth.analysis.minimizers.ellipse_minimizer import WarmMinimizer
from nonsmooth.analysis.minimizers.sum_of_supports import by_smoothing
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.proofs.answers.failures import without
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.friction_set import UnitDiscs


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

    def counted_warm(self: WarmMinimizer, loads: Floats) -> Floats | None:
        asked.append(True)
        return warm(self, loads)

    def counted_cold(
        weights: Floats, maps: Floats, targets: Floats, sets: UnitDiscs, passes: int
    ) -> tuple[Floats, Floats]:
        begun.append(True)
        return cold(weights, maps, targets, sets, passes)

    monkeypatch.setattr(WarmMinimizer, "minimize", counted_warm)
    monkeypatch.setattr(ellipse_minimizer, "by_smoothing", counted_cold)
    scene = load_scene("roller-bed")
    path = BodyPath(contacts_under(smooth("roller"), scene), scene).follow((0.1, 0.05, 0.2), 0.1)
    assert path.end.state == pytest.approx((0.2, 0.05, 0.2), abs=1e-9)
    assert len(begun) < len(asked) / 4


def test_a_path_of_a_body_ends_after_its_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was followed until then is the path."""
    scene = load_scene("carton-on-6x6")
    whole = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 2.0)
    monkeypatch.setattr(body_path, "MOST_RATES", 400)
    part = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 2.0)
    assert part.end.reason is EndReason.STEPS
    assert 0 < part.end.t < whole.end.t
    assert part.end.state == pytest.approx(whole.at(part.end.t), abs=1e-9)


def without_wheel_15() -> BodyPath:
    """A body on a table where two of the three wheels that are left under it are on either side of the rest point."""
    scene = without(load_scene("carton-on-6x6").under("ellipse"), [15])
    return BodyPath(contacts_under(smooth("ellipse"), scene), scene)


def test_a_centre_of_mass_that_comes_ever_nearer_to_the_border_of_its_support_tips() -> None:
    """Without wheel 15 the rest point lies over the line through two wheels, where rounding alone would move a body.

    From afar this path did not end in ten minutes; that it never crosses the line makes no difference to a table.
    """
    path = without_wheel_15().follow((1e-7, 1e-7, 0.0), 5.0)
    assert path.end.reason is EndReason.TIPS
    assert [event.surface for event in path.events] == ["over the line through wheels 21 and 16"]
    x, y, _ = path.end.state
    assert 0 < x + y < 4e-9
    assert x == pytest.approx(y, abs=1e-12)


def test_a_start_over_the_line_through_two_wheels_is_refused() -> None:
    """It ended with a message of NumPy about shapes."""
    with pytest.raises(
        ValueError, match="where the body stands on its wheels, received one where it tips over the line "
    ):
        without_wheel_15().follow((0.0, 0.0, 0.3), 1.0)


def test_a_path_over_all_wheels_ends_after_its_work_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """One that needs minutes says so in its last line."""
    monkeypatch.setattr(body_path, "MOST_RATES", 30)
    path = BodyPath(contacts_under(smooth("ellipse"), load_scene("four-wheel"))).follow((0.2, 0.4, 0.0), 5.0)
    assert path.end.reason is EndReason.STEPS
    assert 0 < path.end.t < 5


def test_where_one_method_gives_up_the_next_one_goes_on(monkeypatch: pytest.MonkeyPatch) -> None:
    """With tolerances ever wider, and from the last place that was reached."""
    scene = load_scene("carton-on-6x6")
    whole = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 0.5)
    monkeypatch.setattr(body_path, "MANY_STEPS", 3)
    monkeypatch.setattr(body_path, "MANY_STIFF_STEPS", 5)
    rough = BodyPath(contacts_under(smooth("ellipse"), scene), scene).follow((0.15, 0.1, 0.08), 0.5)
    assert rough.end.state == pytest.approx(whole.end.state, abs=1e-5)
