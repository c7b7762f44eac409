"""Answers about bodies with inertia, beside Newton's law in a few lines."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.bodies.mass_study import body_of
from nonsmooth.analysis.bodies.settling import settle, swings_of
from nonsmooth.proofs.answers.answer import Inertia
from nonsmooth.proofs.answers.inertia import near_rest
from tests.evidence.heavy_tables import SPEEDS, Drawn, compared, main
from tests.oracles.heavy_bodies import eigenvalues_by_differences
from tests.pressed_engine import EngineTable
from tests.thorough import few, thorough


@few(1)
@pytest.mark.parametrize("speed", SPEEDS)
def test_eigenvalues_are_those_of_differences(speed: int) -> None:
    """Of the whole law of motion, at a place of rest beside the origin, where the body may turn."""
    verdicts = set()
    for seed in range(6):
        drawn = Drawn(seed, speed)
        near, table = near_rest(drawn.scene()), drawn.table
        if not near.eigenvalues or near.place is None:
            continue
        state = np.array([*near.place, 0.0, 0.0, 0.0, near.spin])
        exact = table.exactly()
        assert np.abs(exact.rate(state[None])[0, 3:5]).max() < 1e-6 * table.gravity
        found = np.sort_complex(eigenvalues_by_differences(exact, state))
        size = np.abs(found).max()
        assert np.abs(found - np.sort_complex(np.array(near.eigenvalues))).max() < 1e-4 * size
        growth = found.real.max()
        assert near.verdict == (Inertia.STABLE if growth < 0 else Inertia.UNSTABLE)
        verdicts.add(near.verdict)
    assert verdicts


@thorough  # the tests above and below look at eigenvalues and at one path; tests/golden has answers about inertia
@pytest.mark.parametrize(("seed", "speed"), [(0, 250), (1, 1000), (0, 1000), (1, 250), (0, 50), (2, 250), (3, 1000)])
def test_bodies_do_what_is_said(seed: int, speed: int) -> None:
    found = compared(Drawn(seed, speed))
    assert found.found.bodies
    assert not found.wrong


@few(1)
@pytest.mark.parametrize(("seed", "speed"), [(2, 250), (0, 250), (0, 50), (1, 1000), (5, 1000)])
def test_bodies_do_in_the_engine_what_is_said(seed: int, speed: int) -> None:
    drawn = Drawn(seed, speed)
    found = compared(drawn, EngineTable(drawn.table))
    assert found.found.bodies
    assert not found.wrong


def test_the_study_goes_on_with_the_rows_that_are_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """And says what is wrong in them."""
    file = tmp_path / "rows.jsonl"
    row = {"table": 0, "verdict": "stable", "bodies": ["comes to rest"], "massless_holds_to": 1.0}
    rows = [row | {"speed": speed, "wrong": ["ends 3 away"] * (speed == 50)} for speed in SPEEDS]
    file.write_text("".join(json.dumps(row) + "\n" for row in rows), encoding="utf-8")
    monkeypatch.setattr(sys, "argv", ["heavy_tables", "--tables", "1", "--rows", str(file)])
    before = file.read_bytes()
    assert main() == 1
    assert file.read_bytes() == before


def test_the_engine_and_newtons_law_agree_at_any_mass() -> None:
    """A tenth of a kilogram and ten follow the path of the law that knows no mass."""
    table, start = Drawn(1, 250).table, np.array([[40.0, 20.0, 0.0]])
    times, states = table.follow(start, 0.3)
    for mass in (0.1, 10.0):
        looked, poses = EngineTable(table, mass).follow(start, 0.3)
        for entry, close in zip(range(3), (0.15, 0.15, 1e-3), strict=True):
            expected = np.interp(looked, times, states[:, 0, entry])
            assert np.abs(poses[:, 0, entry] - expected).max() < close


def test_bodies_of_any_mass_with_the_same_share_of_inertia_follow_the_same_path() -> None:
    drawn, ends = Drawn(0, 250), []
    for mass in (0.1, 10.0):
        scene = drawn.scene(mass)
        assert scene.inertia is not None
        body = body_of(scene, 1 / float(scene.inertia.gravity))
        ends.append(settle(scene, body, (20.0, 5.0, 0.0), float(scene.accuracy), 0.5, False))
    assert ends[0].end == pytest.approx(ends[1].end, rel=1e-9)
    assert ends[0].settles_after == pytest.approx(ends[1].settles_after)


@pytest.mark.parametrize(
    ("distances", "count"),
    [([9, 5, 1, 0], 0), ([9, 0, 5, 0, 3, 0], 2), ([9, 0, 0.9, 0], 0), ([9, 4, 6, 0], 1), ([0.2, 0.1], 0)],
)
def test_swings_are_counted(distances: list[float], count: int) -> None:
    assert swings_of(np.array(distances, float), 1.0) == count
