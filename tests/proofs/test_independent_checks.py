"""What fans, rays and motions at the point say, held against the stand-alone checker, definitions, and forces."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import pytest

from nonsmooth.analysis.cells.full_turns import Growth
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation, ellipse_point
from nonsmooth.proofs.clauses.translation import fan_stability as fans
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, decide_fan
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.mechanics.constraints import Twist
from tests.oracles.clause_evidence import evidence_holds
from tests.proofs.forces_oracle import verifies

FANS = ("conveyor-3", "saddle", "outward", "spiral-30", "four-wheel")
POINTS = ("spiral-30", "outward", "ring-5", "conveyor-3", "four-wheel")


def forged_fans(result: FanResult) -> Iterator[FanResult]:
    for verdict in set(Translation) - {result.verdict}:
        yield replace(result, verdict=verdict)
    for k, entry in enumerate(result.evidence):
        if entry.move is Move.TIE:  # what is undecided claims nothing
            continue
        before, after = result.evidence[:k], result.evidence[k + 1 :]
        x, y = entry.ray
        yield replace(result, evidence=(*before, replace(entry, ray=(-x, -y)), *after))
        if entry.move in (Move.SLIDE, Move.REST) and len(entry.twists) == 2:
            yield replace(result, evidence=(*before, replace(entry, value=entry.value - 1), *after))
    for k, turn in enumerate(result.turns):
        rest = (*result.turns[:k], *result.turns[k + 1 :])
        yield replace(result, turns=rest)
        yield replace(result, turns=(*rest, replace(turn, order=turn.order * 2)))
        for growth in set(Growth) - {turn.growth}:
            yield replace(result, turns=(*rest, replace(turn, growth=growth)))
        if turn.gain is not None:
            yield replace(result, turns=(*rest, replace(turn, gain=turn.gain * 2)))


@pytest.mark.parametrize("name", FANS)
def test_the_verdict_of_a_fan_is_verified_without_deciding_again(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the stand-alone checker."""
    found = decide_fan(check_cells(load_scene(name)).partition)

    def forbidden(*_: object) -> None:
        raise AssertionError("decided again")

    for decider in ("decide_cones", "slide_speed", "full_turns", "_escapes", "_slides"):
        monkeypatch.setattr(fans, decider, forbidden)
    assert evidence_holds(found)
    assert not [
        forged for forged in forged_fans(found) if forged.verdict is not found.verdict and evidence_holds(forged)
    ]


def test_a_fan_of_a_plain_system_with_turns() -> None:
    result = decide_system(load_system("relay-oscillator"))
    fan = PlanePoint(result.scene).fan
    assert fan is not None
    assert fan.fan.turns
    assert evidence_holds(fan.fan)
    forged = [other for other in forged_fans(fan.fan) if other.verdict is not fan.fan.verdict]
    assert not [other for other in forged if evidence_holds(other)]


def point_of(name: str) -> EllipsePoint:
    scene = load_scene(name, rule="ellipse").recentred()
    return ellipse_point(scene, load_regions(scene, scene.check.equilibrium))


@pytest.mark.parametrize("name", POINTS)
def test_the_motion_at_the_point_verifies_by_forces_and_moments(name: str) -> None:
    point = point_of(name)
    assert evidence_holds(point)
    assert verifies(point)
    if point.twist is None:
        return
    zero, one = point.scene.field.zero, point.scene.field.one
    forged = [replace(point, twist=Twist(zero, zero, point.twist.omega + one))]
    forged += [replace(point, twist=Twist(one, zero, zero)), replace(point, twist=None)]
    forged += [replace(point, situation=s) for s in (Situation.CARRIED, Situation.STICKING) if s is not point.situation]
    assert not [k for k, other in enumerate(forged) if evidence_holds(other) or verifies(other)]
