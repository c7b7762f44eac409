"""LaSalle's principle under arbitrary switching: counterexamples to asking the fields one by one, and signals that
try to keep V.
"""

from __future__ import annotations

from functools import cache
from pathlib import Path
from types import CodeType

import numpy as np
import pytest

from nonsmooth.analysis.cells.switched_cells import square_regions
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.domain import scene_cells
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.proofs.systems.invariance import Staying, decide_staying, resting_place
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.thorough import few, keep

Fields = list[list[str]]

NAMES = {"sign": np.sign, "Abs": np.abs, "relu": lambda a: np.maximum(a, 0.0)}
STEP, STEPS, NEAR = 1 / 128, 1_800, 1e-6  # somewhat more than two turns
DISC = "x**2 + y**2"
AGAINST = [[f"{turn}*y - x*(x - 2*y)**2", f"{-turn}*x - y*(x - 2*y)**2"] for turn in (1, -1)]


def built(fields: Fields, lyapunov: str | None = None) -> SwitchedSystem:
    check = {"radius": "1/2"} if lyapunov is None else {"radius": "1/2", "lyapunov": lyapunov}
    return build_system({"system": {"states": ["x", "y"], "rhs": fields}, "check": check}, "t", Path("t.toml"))


def staying(fields: Fields, lyapunov: str) -> Staying:
    system = built(fields, lyapunov)
    radius = system.check.radius
    return decide_staying(system, system.check.lyapunov, radius, scene_cells(system, square_regions(radius)))


@few(7)
@pytest.mark.parametrize(
    ("fields", "lyapunov", "found"),
    [
        ([["y", "-x - y**3"], ["y", "-x - 2*y**3"]], DISC, Staying.NONE),
        ([["y", "-x - y**3"], ["2*y", "-2*x - y"]], DISC, Staying.NONE),
        ([["y", "-x - relu(x)*y"], ["y", "-x - y"]], DISC, Staying.NONE),  # a half without friction is crossed
        ([["y", "-sign(x) - y**3"], ["y", "-sign(x) - y"]], "Abs(x) + y**2/2", Staying.NONE),
        ([["y", "-x - y"], ["y", "-x - y*Abs(y)"], ["2*y", "-2*x - y"]], DISC, Staying.NONE),
        # either attracts alone, and either turns out of the half in which it keeps V: together they keep it
        ([["y", "-x - relu(x)*y"], ["y", "-x - relu(-x)*y"]], DISC, Staying.CELLS),
        # either attracts alone; they turn in two senses, and rest together on y = 0
        ([["y", "-x - y"], ["-y", "x - y"]], DISC, Staying.RESTS),
        ([["y", "-x - y"], ["-2*y", "2*x - 3*y"], ["y", "-x - y**3"]], DISC, Staying.RESTS),
        # the same on x = 2 y, inside of cells: each field leaves that line, but they are opposed there
        (AGAINST, DISC, Staying.UNDECIDED),
        ([AGAINST[0], ["y - x*(x - 2*y)**2", "-x - 2*y*(x - 2*y)**2"]], DISC, Staying.NONE),
        ([["y", "-x"], ["y", "-x - y"]], DISC, Staying.CELLS),  # one keeps V for ever
        ([["y", "-x - y"], ["y", "-x - sign(y)"]], DISC, Staying.RESTS),
        ([["y", "-x - y*(x**2 + y**2 - 1/16)**2"], ["y", "-x - y"]], DISC, Staying.ARC),
    ],
)
def test_what_stays_under_switching(fields: Fields, lyapunov: str, found: Staying) -> None:
    assert staying(fields, lyapunov) is found


@pytest.mark.parametrize("steps", keep(1, [STEPS // 2, STEPS]))
def test_each_attracts_where_both_do_not(steps: int) -> None:
    """The counterexamples: each field alone is decided, and a signal that takes the better one loses nothing."""
    pairs: list[Fields] = [
        [["y", "-x - relu(x)*y"], ["y", "-x - relu(-x)*y"]],
        [["y", "-x - y"], ["-y", "x - y"]],
    ]
    for fields in pairs:
        for field in fields:
            assert staying([field], DISC) is Staying.NONE
            assert lost([field], DISC, steps) > 0.05
    assert lost(pairs[0], DISC, steps) < 1e-6
    starts = np.array([[0.3], [0.0]])  # on y = 0, halves of both rest
    velocities = [np.array(rates(field, starts)) for field in pairs[1]]
    assert np.allclose(np.mean(velocities, axis=0), 0.0)


@pytest.mark.usefixtures("strict_search")
@pytest.mark.parametrize("lyapunov", keep(1, ["y**2/2 + Abs(x)", None]), ids=["named", "searched"])
def test_the_check_takes_the_principle(lyapunov: str | None) -> None:
    result = decide_system(built([["y", "-sign(x) - y**3"], ["y", "-sign(x) - y"]], lyapunov))
    assert (result.verdict, result.method) == (Translation.ASYMPTOTICALLY_STABLE, Method.INVARIANCE)
    assert result.check()
    assert {"stability": "asymptotically stable"} in certificate_of(result)["statement"]["claims"]


@pytest.mark.usefixtures("strict_search")
def test_the_check_calls_no_kept_energy_attracting() -> None:
    for fields in ([["y", "-x"], ["y", "-x - y"]], [["y", "-x - y"], ["-y", "x - y"]]):
        assert decide_system(built(fields)).verdict is Translation.STABLE


# ---- against signals ------------------------------------------------------------------------------

FRICTIONS = (
    *("y", "y**3", "sign(y)", "relu(y)", "relu(y - 1/8)", "relu(x)*y", "relu(-x)*y", "x**2*y", "y*Abs(y)", "0"),
    *("relu(-x)*relu(y)", "2*y", "relu(x - 1/8)*y"),
)


def rates(field: list[str], places: np.ndarray) -> list[np.ndarray]:
    """One field at places (2, m)."""
    values = [_value(text, *places) for text in field]
    return [np.broadcast_to(value, places[0].shape) for value in values]


@cache
def _compiled(text: str) -> CodeType:
    return compile(text, "formula", "eval")


def _value(text: str, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return np.asarray(eval(_compiled(text), dict(NAMES), {"x": x, "y": y}))  # noqa: S307 - formulas of this file


def lost(fields: Fields, lyapunov: str, steps: int = STEPS) -> float:
    """The least share of V that paths lose over several starts, to fields of largest V' and to such at random.

    What is lost is the integral of -V' along a polygon, with V' by differences: nothing where V is kept.
    """
    rng = np.random.default_rng(5)
    angles = np.linspace(0.2, 6.2, 5)
    x, y = np.tile(0.2 * np.cos(angles), 3), np.tile(0.2 * np.sin(angles), 3)
    greedy = np.arange(len(x)) < len(angles)
    every, start, total = np.arange(len(x)), _value(lyapunov, x, y), np.zeros(len(x))
    for _ in range(steps):
        options = np.array([rates(field, np.array([x, y])) for field in fields])
        slope_x = (_value(lyapunov, x + NEAR, y) - _value(lyapunov, x - NEAR, y)) / (2 * NEAR)
        slope_y = (_value(lyapunov, x, y + NEAR) - _value(lyapunov, x, y - NEAR)) / (2 * NEAR)
        falls = np.maximum(-(slope_x * options[:, 0] + slope_y * options[:, 1]), 0.0)
        taken = np.where(greedy, np.argmin(falls, axis=0), rng.integers(len(fields), size=len(x)))
        total += STEP * falls[taken, every]
        y = y + STEP * options[taken, 1, every]
        moved = np.array([rates(field, np.array([x, y]))[0] for field in fields])
        x = x + STEP * moved[taken, every]
    return float(np.min(total / start))


@few(1)
@pytest.mark.parametrize("seed", range(8))
def test_random_switched_oscillators_against_signals(seed: int) -> None:
    rng = np.random.default_rng(seed)
    frictions = rng.choice(FRICTIONS, size=rng.integers(2, 4), replace=False)
    force, lyapunov = [("x", DISC), ("sign(x)", "Abs(x) + y**2/2")][rng.integers(2)]
    fields = [["y", f"-{force} - {friction}"] for friction in frictions]
    found = staying(fields, lyapunov)
    share = lost(fields, lyapunov)
    if found is Staying.NONE:
        assert share > 1e-4, fields
    if share < 1e-6:
        assert found is not Staying.NONE, fields


@pytest.mark.parametrize("count", keep(1, [14, 24]))
def test_rests_of_several_fields_against_their_hulls(count: int) -> None:
    """Random affine fields: 0 lies between those that act at a place that is said to rest, or beside it."""
    rng = np.random.default_rng(11)
    known = {True: 0, False: 0}
    for _ in range(count):
        entries = rng.integers(-3, 4, size=(rng.integers(2, 4), 2, 3)) * np.array([1, 1, 2])
        entries[:, 0, 2] += 3 * rng.integers(0, 2)
        fields = [[f"{a}*x + {b}*y + {c} + sign(x)" for a, b, c in field] for field in entries.tolist()]
        system = built(fields)
        place = resting_place(scene_cells(system, square_regions(system.check.radius)))
        known[place is not None] += 1
        if place is None:
            continue
        x, y = map(float, place)
        sides = [np.sign(x)] if x else [-1.0, 1.0]
        affine = entries[:, :, :2] @ np.array([x, y]) + entries[:, :, 2]
        values = np.concatenate([affine + np.array([side, side]) for side in sides])
        angles = np.sort(np.arctan2(values[:, 1], values[:, 0]))
        assert np.diff(angles, append=angles[0] + 2 * np.pi).max() <= np.pi + 1e-9 or not np.all(np.any(values, axis=1))
    assert known[True] >= 2
    assert known[False] >= 2
