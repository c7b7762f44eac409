"""Smaller systems, beside the stated formulas in floats and beside paths of the larger systems."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.oracles.floats import Floats, value
from tests.thorough import keep

# ---- named systems -------------------------------------------------------------------------------

AGREE = "(b - a) + sign(b - a); (a - b) + sign(a - b) + (c - b); b - c"
LOSES = "-x*y; x*y - y*sign(y - 1/4); y*sign(y - 1/4)"
TURNS = "z/9 - x*y; x*y - y; y - z/9"
FOLLOWS = "u - x - (x - u)/sqrt((x - u)**2 + (y - v)**2); v - y - (y - v)/sqrt((x - u)**2 + (y - v)**2); x - u; y - v"
UNIT = "sqrt(x**2 + y**2)"


@pytest.mark.parametrize(
    ("states", "rhs", "formulas", "said"),
    [
        ("abc", AGREE, {"a": "sign(b - a) - a", "b": "a + sign(a - b) - 3*b"}, "(1, 1, 1): a stands for a - c"),
        ("ab", "1 + sin(b - a); 1/2 + 2*sin(a - b)", {"a": "1/2 + sin(-a) - 2*sin(a)"}, "(1, 1): a stands for a - b"),
        ("xy", "1 - 3*sign(y); -2*sign(y)", {"y": "-2*sign(y)"}, "(1, 0): x is left out"),
        ("xyz", LOSES, {"x": "-x*y", "y": "x*y - y*sign(y - 1/4)"}, "(0, 0, 1): z is left out"),
        ("xyz", TURNS, {"x": "(-x - y)/9 - x*y", "y": "x*y - y"}, "x + y + z is conserved: z is -x - y"),
        ("xyuv", FOLLOWS, {"x": f"-2*x - x/{UNIT}", "y": f"-2*y - y/{UNIT}"}, "x stands for x - u, y stands for y - v"),
        ("xy", "Max(x - 2*y, 0); Abs(2*y - x)", {"x": "Max(x, 0) - 2*Abs(-x)"}, "(2, 1): x stands for x - 2*y"),
        ("xy", "-x; x", {"x": "-x"}, "(0, 1): y is left out"),
    ],
)
def test_smaller_systems(states: str, rhs: str, formulas: Mapping[str, str], said: str) -> None:
    document = ns.System(list(states), rhs.split("; ")).reduced().document
    assert document["system"] == {"states": list(formulas), "rhs": list(formulas.values())}
    assert said in document["description"]


def test_the_point_moves_along_and_intervals_stay_alternatives() -> None:
    rhs = ["k*(y - x)", "x - y", "y - z - sign(z - x - 1)"]
    system = ns.System("xyz", rhs, at=["1/2", "1/2", "sqrt(2)"], radius=2, parameters={"k": [1, 2]})
    document = system.reduced().document
    assert document["check"] == {"equilibrium": ["1/2 - sqrt(2)"] * 2, "radius": "2"}
    relay = "sign(-x - 1)"
    assert document["system"]["rhs"] == [
        [f"{relay} - x", f"x + {relay} - 2*y"],
        [f"y + {relay} - 2*x", f"x + {relay} - 2*y"],
    ]


@pytest.mark.parametrize(
    ("states", "rhs"),
    [
        ("xv", "v; -x - sign(v)"),
        ("x", "0*x"),
        ("xy", "0*x; 0*y"),
        (
            "xy",
            "-sign(x) - sign(x + y); sign(x) + sign(x + y)",
        ),  # where x + y = 0 both surfaces are one: two cells of four
        ("xy", f"-x/{UNIT} - y/{UNIT}; x/{UNIT} + y/{UNIT}"),  # on x + y = 0 the unit vectors are two of all
        ("xy", "sin(x)**2 + cos(x)**2 - 1 - y; -y"),  # the same along x, which is not looked for
    ],
)
def test_what_stays_as_it_is(states: str, rhs: str) -> None:
    with pytest.raises(SceneError, match="the same along a line, or that conserves"):
        ns.System(list(states), rhs.split("; ")).reduced()


def test_a_plane_that_misses_cells_hides_velocities() -> None:
    """Why that is refused: the origin of the plane x + y = 0 attracts by two cells, and slides away by the others."""
    rhs = ["-sign(x) - 2*sign(x + y)", "sign(x) + 2*sign(x + y)"]
    with pytest.raises(SceneError):
        ns.System("xy", rhs).reduced()
    assert ns.System("x", ["-sign(x)"]).check().verdict == "asymptotically stable"
    assert ns.System("xy", rhs).check().verdict == "unstable"


def test_long_products_are_refused() -> None:
    sums = "*".join(f"(sign(x - {k}) + sign(y - {k}) + {k})" for k in range(1, 13))
    with pytest.raises(SceneError, match="required shorter formulas"):
        ns.System("xy", [f"-x*Abs(({sums}))", "-y"]).reduced()


def test_agents_agree_in_finite_time() -> None:
    rhs = ["sign(b - a)", "sign(a - b) + sign(c - b)", "sign(b - c) + sign(d - c)", "sign(c - d)"]
    agents = ns.System("abcd", rhs)
    assert agents.check().verdict == "stable"
    differences = agents.reduced().check()
    assert differences.verdict == "asymptotically stable"
    assert differences.evidence.reach.everywhere
    assert differences.evidence.reach.in_finite_time
    assert differences.certificate()


# ---- random systems ------------------------------------------------------------------------------
#
# Functions of sums that are zero along some directions, mixed by a matrix that some weights annihilate.


def random_system(seed: int, *, jumps: bool) -> tuple[ns.System, Floats, Floats]:
    """A system, the directions along which it is the same, and the weights of what it conserves."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(3, 6))
    pivots = rng.permutation(count)
    flat, along = _orthogonal(rng, count, pivots[: rng.integers(1, 3)])
    mixing, weights = _orthogonal(rng, count, pivots[: rng.integers(0, 3)])
    names = list("abcde"[:count])
    terms = []
    for _ in mixing:
        one, two = (_sum(rng.integers(-1, 2, len(flat)) @ flat, names) for _ in range(2))
        kinds = [f"sign({one})", f"Max({one}, {two})"] if jumps else [f"Abs({one})", f"({one})*({two})"]
        terms.append(f"({rng.choice(kinds)} + Abs({two}) - ({one}))")
    rhs = [_sum(row, terms) for row in mixing.T]
    return ns.System(names, rhs), along, weights


def _orthogonal(rng: Any, count: int, pivots: Any) -> tuple[Any, Any]:
    """Rows of integers, and such vectors with a one for each pivot that span all that is orthogonal to the rows."""
    free = np.setdiff1d(np.arange(count), pivots)
    rows, vectors = np.zeros((len(free), count), int), np.zeros((len(pivots), count), int)
    shares = rng.integers(-2, 3, (len(pivots), len(free)))
    rows[np.arange(len(free)), free] = vectors[np.arange(len(pivots)), pivots] = 1
    vectors[:, free], rows[:, pivots] = shares, -shares.T
    return rows, vectors


def _sum(factors: Any, texts: list[str]) -> str:
    return " + ".join(f"{int(factor)}*{text}" for factor, text in zip(factors, texts, strict=True))


def field(system: ns.System, places: Mapping[str, float]) -> dict[str, float]:
    """The velocity by the stated formulas."""
    stated = system.document["system"]
    return {name: float(value(side, **places)) for name, side in zip(stated["states"], stated["rhs"], strict=True)}


def mapped(description: str, places: Mapping[str, float]) -> dict[str, float]:
    """The states of the smaller system, as its description says what they stand for."""
    stands = re.findall(r"(\w+) stands for ([^,;]*)", description)
    return {**places, **{name: float(value(text, **places)) for name, text in stands}}


@pytest.mark.parametrize("seed", keep(8, range(40)))
@pytest.mark.parametrize("jumps", [False, True])
def test_random_systems(seed: int, jumps: bool) -> None:
    system, along, weights = random_system(seed, jumps=jumps)
    reduced = system.reduced()
    names, smaller = system.document["system"]["states"], reduced.document["system"]["states"]
    said = reduced.document["description"]
    assert len(smaller) <= len(names) - len(along)
    if not jumps and len(smaller) > 1:
        assert len(smaller) <= len(names) - max(len(along), len(weights))
    rng = np.random.default_rng(seed)
    for _ in range(5):
        places = mapped(said, dict(zip(names, rng.normal(size=len(names)), strict=True)))
        for name, text in re.findall(r"is conserved: (\w+) is ([^;]*)", said):
            places[name] = float(value(text, **places))
        left_out = {name: 0.0 for name in names if name not in smaller and f": {name} is" not in said}
        full = field(system, {**places, **left_out})
        rates = mapped(said, full)
        expected = field(reduced, {name: places[name] for name in smaller})
        assert [rates[name] for name in smaller] == pytest.approx(list(expected.values()), abs=1e-9)
        for text in re.findall(r"([^;]*) is conserved", said):
            assert float(value(text, **rates)) == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("seed", keep(2, range(6)))
def test_paths_are_those_of_the_larger_system(seed: int) -> None:
    system, _, _ = random_system(seed, jumps=True)
    reduced = system.reduced()
    names, smaller = system.document["system"]["states"], reduced.document["system"]["states"]
    said = reduced.document["description"]
    start = mapped(said, dict(zip(names, np.random.default_rng(seed).normal(size=len(names)) / 4, strict=True)))
    for name, text in re.findall(r"is conserved: (\w+) is ([^;]*)", said):
        start[name] = float(value(text, **start))
    start |= {name: 0.0 for name in names if name not in smaller and f": {name} is" not in said}
    full = system.simulate([start[name] for name in names], 1.0)
    part = reduced.simulate([start[name] for name in smaller], 1.0)
    if full.trajectory.unique and part.trajectory.unique:
        ends = mapped(said, dict(zip(names, full.state[-1], strict=True)))
        assert [ends[name] for name in smaller] == pytest.approx(list(part.state[-1]), abs=1e-6)


# ---- the command ---------------------------------------------------------------------------------


def test_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    rhs = ", ".join(f'"{side}"' for side in AGREE.split("; "))
    Path("agents.toml").write_text(f'[system]\nstates = ["a", "b", "c"]\nrhs = [{rhs}]\n', encoding="utf-8")
    assert run(app, ["check", "agents.toml"]) == 0
    assert "nonsmooth reduce agents.toml" in capsys.readouterr().out
    assert run(app, ["reduce", "agents.toml", "--radius", "2", "-o", "differences.toml"]) == 0
    assert "a stands for a - c" in capsys.readouterr().out
    assert run(app, ["check", "differences.toml", "--require", "everywhere"]) == 0
    assert "abs(a), abs(b) <= 2" in " ".join(capsys.readouterr().out.split())
    assert run(app, ["reduce", "agents.toml"]) == 0
    assert 'name = "agents-reduced"' in capsys.readouterr().out


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["stick-slip"], "required a field that is the same along a line, or that conserves a weighted sum"),
        (["four-wheel"], "required a plain switched system"),
        (["line-of-equilibria", "-o", "smaller.csv"], "smaller.csv: required a file name that ends in .toml"),
        (["line-of-equilibria", "--radius", "0"], "radius: required a positive number"),
    ],
)
def test_refusals(arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["reduce", *arguments]) == 2
    assert said in capsys.readouterr().err
