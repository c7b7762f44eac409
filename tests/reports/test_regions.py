"""Regions as triangles and by a V that is reshaped: systems in two and three states, and arrays."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import nonsmooth as ns
from nonsmooth.proofs.answers import array_basin
from nonsmooth.proofs.answers.array_basin import NoBasin, find_array_basin
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.many_states.reshaped_region import EFFORTS as RESHAPED
from nonsmooth.proofs.system_certificates import find_region_of_simplices
from nonsmooth.proofs.systems.basin import EFFORTS, CertifiedBasin
from nonsmooth.proofs.systems.basin_mesh import BasinEffort
from nonsmooth.proofs.systems.basin_rings import RingGrowth
from nonsmooth.proofs.systems.basin_shells import EFFORTS as SHELLS
from nonsmooth.reports.checks.check import check_system
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_builder import build_system
from tests.evidence.published_systems import astray, in_simplices
from tests.oracles.floats import Floats, sizes_after
from tests.oracles.measured_tables import MeasuredTable
from tests.reports.conftest import Invoke
from tests.thorough import keep, thorough

# ---- Regions as triangles: the checker accepts them, they are large, and by another integrator every start comes
# home.


COARSE = replace(EFFORTS["fast"], pace=RingGrowth(0.12, 0.03, 0.04), starts=21)
COARSER = replace(EFFORTS["fast"], pace=RingGrowth(0.12, 0.06, 0.04), starts=11)
STEEP = 1e-3  # width over which the oracle's sign rises
VAN_DER_POL = """
name = "van der Pol, reversed"

[system]
states = ["x", "y"]
rhs = ["-y", "x - (1 - x**2)*y"]

[check]
radius = 1
"""


def relay(x: Floats) -> Floats:
    """A sign without a jump."""
    return np.clip(x / STEEP, -1, 1)


# name: right-hand sides, radius, the same in numpy, step, least share of the coarse search and of a search for best
SYSTEMS: dict[str, tuple[list[str], str, Callable[[Floats, Floats], Any], float, float, float]] = {
    "van der Pol 1": (
        ["-y", "x - (1 - x**2)*y"], "1", lambda x, y: (-y, x - (1 - x**2) * y), 0.01, 0.6, 0.97,
    ),
    "van der Pol 3": (
        ["-y", "x - 3*(1 - x**2)*y"], "1", lambda x, y: (-y, x - 3 * (1 - x**2) * y), 0.01, 0.5, 0.93,
    ),
    "inside an ellipse": (
        ["-x + (2*x**2 + y**2)*x", "-y + (2*x**2 + y**2)*y"], "1",
        lambda x, y: (-x + (2 * x**2 + y**2) * x, -y + (2 * x**2 + y**2) * y), 0.02, 0.9, 0.97,
    ),
    "sliding": (
        ["-x + x**3", "-sign(y) + y*x**2/4 + y**3/4 - x/4"], "1/2",
        lambda x, y: (-x + x**3, -relay(y) + y * x**2 / 4 + y**3 / 4 - x / 4), 2e-3, 0.6, 0.9,
    ),
    "pendulum": (
        ["y", "-sin(x) - y/2"], "1/2", lambda x, y: (y, -np.sin(x) - y / 2), 0.02, 0.2, 0.3,
    ),
    "pendulum with smooth relays": (
        ["y", "-sin(x) - tanh(4*y)/2 - atan(x + y)/4"], "1/2",
        lambda x, y: (y, -np.sin(x) - np.tanh(4 * y) / 2 - np.arctan(x + y) / 4), 0.02, 0.2, 0.3,
    ),
    "two machines": (
        ["y", "-y/2 - (sin(x + pi/3) - sin(pi/3))"], "1/2",
        lambda x, y: (y, -y / 2 - (np.sin(x + np.pi / 3) - np.sin(np.pi / 3))), 0.02, 0.2, 0.3,
    ),
    "narrow ellipse": (
        ["-x + (5*x**2 + 4*x*y + y**2)*x", "-y + (5*x**2 + 4*x*y + y**2)*y"], "1",
        lambda x, y: (-x + (5 * x**2 + 4 * x * y + y**2) * x, -y + (5 * x**2 + 4 * x * y + y**2) * y), 0.01, 0.9, 0.97,
    ),
    "sliding on a tilted line": (
        ["y", "x**3 - 2*sign(x + y)"], "1/2", lambda x, y: (y, x**3 - 2 * relay(x + y)), 1e-3, 0.3, 0.8,
    ),
}  # fmt: skip


def basin_of(name: str, search: str = "fast") -> tuple[Any, CertifiedBasin]:
    """The check of a system, and its triangles."""
    rhs, radius, *_ = SYSTEMS[name]
    result = check_system(ns.System(["x", "y"], rhs, radius=radius).system).with_region(search)
    basin = result.evidence.reach.basin
    assert basin is not None
    return result, basin


def drawn(basin: CertifiedBasin, count: int, seed: int = 1) -> Floats:
    """Random places in triangles, as many in a small one as in a large one."""
    random = np.random.default_rng(seed)
    chosen = basin.corners[random.choice(basin.simplices, count)][:, :, :2]
    return np.asarray(np.einsum("ij,ijk->ik", random.dirichlet(np.ones(3), count), chosen))


def ends_of(name: str, starts: Floats, time: float) -> Floats:
    """Distances from the point after some time."""
    _, _, field, step, *_ = SYSTEMS[name]
    return sizes_after(field, starts, step, int(time / step))


@cache
def coarse_basin_of(name: str) -> tuple[Any, CertifiedBasin]:
    """By a search that takes seconds."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setitem(EFFORTS, "fast", COARSER if name.startswith("sliding") else COARSE)
        return basin_of(name)


@pytest.mark.parametrize(
    "name",
    keep(
        1,
        [
            "sliding on a tilted line",
            "sliding",
            "narrow ellipse",
            "van der Pol 1",
            "van der Pol 3",
            "inside an ellipse",
            "pendulum with smooth relays",
        ],
    ),
)
def test_starts_in_triangles_come_home(name: str) -> None:
    """One smooth system is searched in test_the_command too."""
    result, basin = coarse_basin_of(name)
    assert basin.share >= SYSTEMS[name][4]
    assert_cover_once(basin)
    assert ends_of(name, drawn(basin, 100), 8.0).max() < 0.1
    record = json.loads(json.dumps(result.to_dict()))["basin"]
    assert len(record["simplices"]) == len(basin.simplices)
    assert len(record["vertices"]) == len(record["values"]) == len(basin.corners)
    certificate = result.certificate()
    assert {"attracts": {"mesh": basin.mesh, "below": basin.hypotheses["below"]}} in certificate["statement"]["claims"]
    assert not refusal(certificate, len(json.dumps(certificate)))


@thorough  # the test above is coarse
@pytest.mark.parametrize("name", SYSTEMS)
def test_best_regions_are_large(name: str) -> None:
    """The share is sampled; ten thousand starts are followed."""
    _, basin = basin_of(name, "best")
    assert basin.share >= SYSTEMS[name][5]
    assert ends_of(name, drawn(basin, 10_000), 120.0).max() < 0.05


def assert_cover_once(basin: CertifiedBasin) -> None:
    """The areas of all triangles add up to what lies between the first ring and the last."""
    a, b, c = (basin.corners[basin.simplices[:, k], :2] for k in range(3))
    areas = ((b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]) / 2
    assert areas.min() > 0
    values = basin.corners[:, 2]
    first, last = (area(basin.corners[values == value][:, :2]) for value in (0, values.max()))
    assert float(areas.sum()) == pytest.approx(last - first)


def area(ring: Floats) -> float:
    """Of a polygon, by the shoelace formula."""
    x, y = ring.T
    return float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))) / 2


def test_no_triangles_where_all_is_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every start comes home, or the point does not attract."""
    for rhs in (["-x", "-y"], ["y", "-x"], ["x", "y"]):
        result = check_system(ns.System(["x", "y"], rhs).system)
        assert find_region_of_simplices(result.evidence, "fast", lambda what, done, total: None) is None


@pytest.mark.parametrize("pushed", ["sin(x)*cos(y)", "tanh(x*y)", "exp(-y**2)", "sin(Abs(y))"])
def test_no_triangles_where_fields_are_not_enclosed_on_them(pushed: str, invoke: Invoke, tmp_path: Path) -> None:
    """Sines that are multiplied or not of affine functions, and exp; the check ended with a traceback."""
    system = f'[system]\nstates = ["x", "y"]\nrhs = ["-sign(x) - 2*x + x*{pushed}", "-2*y"]\n'
    (tmp_path / "s.toml").write_text(system, encoding="utf-8")
    status, out, error = invoke("check", "s.toml", "--json")
    assert (status, error) == (0, "")
    found = json.loads(out)
    assert found["translation"]["everywhere"] is False
    assert found["lyapunov"]["region"]["level"] > 0
    assert "basin" not in found


def test_the_command(invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The words, the file that verify accepts, and what is refused."""
    monkeypatch.setitem(EFFORTS, "fast", COARSER)
    scene, file = tmp_path / "scene.toml", tmp_path / "basin.json"
    scene.write_text(VAN_DER_POL)
    found = invoke("check", str(scene), "--region", "fast", "--certificate", str(file))
    assert found.status == 0
    assert "triangles about the region" in " ".join(found.out.replace("│", " ").split())
    assert invoke("verify", str(file)).status == 0
    scene.write_text('[system]\nstates = ["x"]\nrhs = ["-x"]\n')
    refused = invoke("check", str(scene), "--region", "best")
    assert refused.status == 2
    assert "required a plain system in two states or more, or an array, for --region" in refused.err
    assert invoke("check", str(scene), "--region", "none").status == 0


def test_the_picture() -> None:
    """Triangles, and the border of the region."""
    result, basin = coarse_basin_of("sliding on a tilted line")
    axes = result.plot()
    assert any(len(line.get_xdata()) == len(basin.border) + 1 for line in axes.lines)


# ---- Regions of arrays as triangles at the command line: words, JSON, certificates, and why there is none.

COARSE_ARRAY = BasinEffort(RingGrowth(0.2, 0.1, 0.08), 9, way=12.0, triangles=40_000)


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(array_basin.EFFORTS, "fast", (COARSE_ARRAY,))


@pytest.mark.usefixtures("coarse")
def test_the_command_on_an_array(invoke: Invoke, tmp_path: Path) -> None:
    """Words, JSON, and a certificate that verify accepts line by line."""
    file = tmp_path / "four.json"
    found = invoke("check", "four-wheel", "--region", "fast", "--certificate", str(file), "--json")
    assert found.status == 0
    record = json.loads(found.out)["basin"]
    assert record["share"]["sampled"] > 0.9
    assert record["ends_within"] is None
    assert "from anywhere in a region of area 3." in record["text"]
    assert len(record["vertices"]) == len(record["values"]) > 100
    verified = invoke("verify", str(file))
    assert verified.status == 0
    assert f"attracts: from one of {len(record['simplices'])} triangles" in " ".join(verified.out.split())


@pytest.mark.parametrize(("name", "why"), [("rule", "has no cells"), ("rest", "reaches the border")])
def test_why_there_is_none(name: str, why: str, tmp_path: Path) -> None:
    """A rule without cells, and bodies that rest all over the square: one line."""
    table = MeasuredTable.random(2, "ellipse" if name == "rule" else "box", off=9.0)
    file = tmp_path / "table.toml"
    file.write_text(table.toml)
    found = find_array_basin(load_scene(str(file)), "fast", lambda what, done, total: None)
    assert isinstance(found, NoBasin)
    assert why in found.why


# ---- In three states a check is told a larger region without being asked: beside a region that is known exactly.

FORM = "x**2 + 2*y**2 + 3*z**2 + x*y"
SYSTEM = f"""
[system]
states = ["x", "y", "z"]
rhs = ["-x + ({FORM})*x", "-y + ({FORM})*y", "-z + ({FORM})*z"]
"""


def test_nine_tenths_of_a_level_and_no_more_than_it(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Along every ray ``r' = -r + q r`` with the form q: starts come to the point exactly where ``q < 1``."""
    monkeypatch.setitem(SHELLS, "fast", replace(SHELLS["fast"], frequency=4, shells=6))
    file = tmp_path / "ellipsoid.toml"
    file.write_text(SYSTEM, encoding="utf-8")
    certificate = tmp_path / "ellipsoid.json"
    found = json.loads(invoke("check", str(file), "--json", "--certificate", str(certificate)).out)
    own = found["reshaped"]
    q, v = (sympy.lambdify(sympy.symbols("x y z"), sympy.sympify(text), "numpy") for text in (FORM, own["V"]))
    rays = np.random.default_rng(0).normal(size=(3, 1000))
    border = rays / np.sqrt(q(*rays))
    assert (v(*(np.sqrt(0.9) * border)) < own["level"]).all()
    assert (v(*border) >= own["level"]).all()
    assert_inside_and_without_folds(found["basin"], q)
    assert f"one of {len(found['basin']['simplices'])} tetrahedra" in invoke("verify", str(certificate)).out


def assert_inside_and_without_folds(basin: dict[str, Any], q: Callable[..., Floats]) -> None:
    """Corners of tetrahedra lie where ``q < 1``, a convex set, and volumes add up to what is between two borders."""
    corners, values = np.array(basin["vertices"]), np.array(basin["values"])
    simplices = np.array(basin["simplices"])
    assert (q(*corners.T) < 1).all()
    assert basin["share"]["sampled"] > 0.85

    def sizes(own: Floats) -> Floats:
        return np.asarray(np.linalg.det(own[:, 1:] - own[:, :1]) / 6)

    own = sizes(corners[simplices])
    assert own.min() > 0
    between = 0.0
    for value, sign in ((0, -1), (values.max(), 1)):  # pyramids over the sides of a polyhedron, seen from the point
        listed = [side for cell in simplices for side in combinations(cell, 3) if (values[list(side)] == value).all()]
        places = corners[np.array(sorted(set(map(tuple, map(sorted, listed)))))]
        between += sign * float(np.abs(np.linalg.det(places)).sum()) / 6
    assert float(own.sum()) == pytest.approx(between)


RELAYS = {
    "sliding on a slanted plane": (["y", "z", "-2*sign(x + 2*y + 2*z) - z"], 0.5),
    "sliding on an axis": (["-x + y", "-y + x**3/2", "x/4 - sign(z)"], 1.5),
    "saturated": (["y", "-x - y + x**3/3 + z", "-z - sat(y, -1/4, 1/4)"], 1.0),
}


@thorough  # tetrahedra: the test above; fields that switch: test_region_triangles.py
@pytest.mark.parametrize("name", RELAYS)
def test_tetrahedra_where_fields_switch(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Starts in them are followed by polygons along the formulas."""
    effort = replace(SHELLS["fast"], frequency=4, shells=3, steps=60, starts=3)
    monkeypatch.setitem(SHELLS, "fast", effort)
    sides, reaches = RELAYS[name]
    document = {"system": {"states": ["x", "y", "z"], "rhs": sides}, "check": {"radius": "1/2"}}
    system = build_system(document, name, Path("relay.toml"))
    basin = check_system(system).with_region("fast").evidence.reach.basin
    assert basin is not None
    assert np.abs(basin.border).max() > reaches
    assert astray(system, in_simplices(basin, 200)) == 0


def test_programs_that_are_too_large_are_said_to_be(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The verdict is told at once, with a line on why no larger region was sought."""
    monkeypatch.setitem(RESHAPED, "fast", replace(RESHAPED["fast"], work=1_000))
    states = [f"x{k}" for k in range(4)]
    file = tmp_path / "four.toml"
    file.write_text(
        f"[system]\nstates = {json.dumps(states)}\nrhs = {json.dumps([f'-{x} + x0*{x}' for x in states])}\n",
        encoding="utf-8",
    )
    assert "no larger region was sought" in invoke("check", str(file)).out
    assert "no larger region was sought" not in invoke("check", str(file), "--region", "none").out
