"""Sweeps: what is varied, plain systems, cells that are certified as a whole, and clusters."""

from __future__ import annotations

import csv
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from fractions import Fraction
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.reports.sweeps import workers
from nonsmooth.reports.sweeps.base import base_of
from nonsmooth.reports.sweeps.borders import simplest_fraction
from nonsmooth.reports.sweeps.store import Store
from nonsmooth.reports.sweeps.sweep import Means, Sweep, run_sweep
from nonsmooth.reports.sweeps.sweep_plan import Range, SweepError, SweepPlan, read_plan, read_values
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.key_paths import find_path, numeric_paths, path_text, with_value
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from tests.proofs.robust.test_nearest_bounds import drawn, velocities
from tests.reports.conftest import Invoke
from tests.thorough import few, thorough

# ---- What a user writes after ``--vary``: exact values, grids, draws, and what is refused --------


def entries(text: str) -> list[int | str]:
    values = read_values(text, "vary")
    return [values.value(k).entry for k in range(values.count or 0)]


def plan_of(vary: dict[str, str], draws: int | None = None, seed: int = 0) -> SweepPlan:
    document, file, _ = read_document("four-wheel")
    return read_plan(vary, document, file, draws, seed)


def test_ranges_are_exact_and_end_at_both_ends() -> None:
    assert entries("0.05:1:3") == ["1/20", "21/40", 1]
    assert entries("-1:1:3") == [-1, 0, 1]
    assert entries("0:pi/2:3") == [0, "1/4*pi", "1/2*pi"]
    assert entries("0 deg:45 deg:3") == ["0 deg", "45/2 deg", "45 deg"]
    assert entries("10+pi:20+pi:2") == ["10 + 1*pi", "20 + 1*pi"]


def test_lists_hold_formulas_as_they_were_written() -> None:
    assert entries("1/3, sqrt(2)/2, 0.25") == ["1/3", "sqrt(2)/2", "1/4"]


@given(st.fractions(max_denominator=999), st.fractions(max_denominator=999), st.integers(2, 50))
def test_ranges_ascend_in_equal_steps(a: Fraction, b: Fraction, count: int) -> None:
    if a == b:
        return
    values = read_values(f"{min(a, b)}:{max(a, b)}:{count}", "vary")
    assert isinstance(values, Range)
    numbers = [values.value(k).constant for k in range(count)]
    assert (numbers[0], numbers[-1]) == (min(a, b), max(a, b))
    assert {y - x for x, y in pairwise(numbers)} == {(numbers[-1] - numbers[0]) / (count - 1)}


def test_a_count_of_very_many_digits_is_refused_in_a_short_line() -> None:
    with pytest.raises(SweepError, match=r"^vary x: required .*, received ") as refusal:
        read_values(f"0:1:{'9' * 5000}", "vary x")
    assert len(str(refusal.value)) < 250


def test_a_grid_holds_every_combination_with_the_last_number_fastest() -> None:
    plan = plan_of({"mu_side": "1:2:2", "mu_roll": "3,4,5"})
    assert plan.size == 6
    assert [tuple(value.entry for value in plan.point(k)) for k in range(6)] == [
        (1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5)
    ]  # fmt: skip
    assert [plan.index(plan.places(k)) for k in range(6)] == list(range(6))


def test_draws_are_exact_within_their_range_and_reproducible() -> None:
    vary = {"mu_side": "1/3:2/3", "mu_roll": "1,2"}
    short, long = (plan_of(vary, n, seed=7) for n in (20, 50))
    drawn = [short.point(k) for k in range(20)]
    assert drawn == [long.point(k) for k in range(20)]
    assert len({point[0].entry for point in drawn}) == 20
    assert all(1 / 3 <= (point[0].number or 0) <= 2 / 3 for point in drawn)
    assert {point[1].entry for point in drawn} == {1, 2}
    assert drawn != [plan_of(vary, 20, seed=8).point(k) for k in range(20)]


def test_a_plan_of_any_size_costs_nothing() -> None:
    plan = plan_of({"mu_side": "1:2:1000000", "mu_roll": "1:2:1000000", "check.radius": "1:2:1000000"})
    assert plan.size == 10**18
    assert plan.places(plan.size - 1) == (999_999,) * 3


@pytest.mark.parametrize("name", ["four-wheel", "ring-6", "grid-4x4", "spiral-30", "carton-on-6x6", "omni-3"])
def test_every_path_names_its_own_number(name: str) -> None:
    document, file, _ = read_document(name)
    paths = list(numeric_paths(document))
    assert len({path_text(path, document) for path in paths}) == len(paths)
    for path in paths:
        assert find_path(path_text(path, document), document, file) == path
        changed = with_value(document, path, 17)
        inner: object = changed
        for step in path:
            inner = inner[step]  # type: ignore[index]
        assert inner == 17


def test_paths_inside_lists_have_names_or_are_counted_as_messages_count() -> None:
    document = {
        "wheel": [{"position": [0, 1]}, {"position": [2, 3]}],
        "contact": {"loads": {"kind": "measured", "values": [1, 2]}},
        "body": {"shape": "polygon", "vertices": [[0, 0], [1, 0], [0, 1]]},
    }
    assert find_path("wheel.2.position.x", document, "f") == ("wheel", 1, "position", 0)
    assert find_path("wheel.2.heading", document, "f") == ("wheel", 1, "heading")
    named = {"wheel": [{"name": "2", "position": [0, 1]}, {"name": "M2", "position": [2, 3]}]}  # numbers win
    assert find_path("wheel.M2.position.x", named, "f") == find_path("wheel.2.position.x", document, "f")
    assert find_path("wheel.2.position.x", named, "f") == ("wheel", 1, "position", 0)
    assert find_path("body.vertices.3.y", document, "f") == ("body", "vertices", 2, 1)
    assert find_path("contact.loads.values.2", document, "f") == ("contact", "loads", "values", 1)
    rows = {"contact": {"loads": [[1, 0, 0], [1, "1/9", 0]]}}
    assert find_path("contact.loads.2.cx", rows, "f") == ("contact", "loads", 1, 1)
    system = {"states": ["x", "v"], "rhs": ["v", "-x - k*v"], "parameters": {"k": [1, 2]}}
    plain = {"system": system, "check": {"equilibrium": [0, 0]}}
    assert find_path("k.high", plain, "f") == ("system", "parameters", "k", 1)
    assert find_path("check.equilibrium.v", plain, "f") == ("check", "equilibrium", 1)
    space: dict[str, Any] = {"system": {"states": ["x", "y", "z"]}}  # the point is not stated: the origin
    place = find_path("equilibrium.z", space, "f")
    assert with_value(space, place, "1/2")["check"] == {"equilibrium": [0, 0, "1/2"]}


def test_a_coordinate_that_is_counted_is_refused_with_its_name() -> None:
    document = {"wheel": [{"position": [0, 1]}, {"position": [2, 3]}]}
    with pytest.raises(SceneError, match=r"wheel\.1\.position\.x"):
        find_path("wheel.1.position.1", document, "f")


def test_a_long_path_is_refused_in_a_short_line() -> None:
    document, file, _ = read_document("four-wheel")
    with pytest.raises(SceneError, match=r"^four-wheel: required the key path of a number, such as ") as refusal:
        find_path("x" * 10_000, document, file)
    assert len(str(refusal.value)) < 250


@given(st.fractions(max_denominator=50), st.fractions(min_value=0, max_denominator=50))
def test_the_simplest_fraction_has_the_smallest_denominator(low: Fraction, width: Fraction) -> None:
    found = simplest_fraction(low, low + width)
    assert low <= found <= low + width
    for denominator in range(1, found.denominator):
        assert (
            -(-low * denominator // 1) > (low + width) * denominator
        )  # no whole multiple of 1/denominator lies between


# ---- Sweeps of plain systems against checks one by one, and borders against eigenvalues and closed forms.

RELAY: dict[str, Any] = {"states": ["x", "y"], "rhs": ["y", "-a*x - k*y - sgn(x)"], "parameters": {"k": 1, "a": 0}}
INTERVAL: dict[str, Any] = {"states": ["x"], "rhs": ["-sgn(x)*(1 - k*x)"], "parameters": {"k": 4}}


def swept(system: dict[str, Any], vary: dict[str, str], means: Means | None = None, draws: int | None = None) -> Sweep:
    base = base_of({"system": system}, "t", Path("t.toml"))
    return run_sweep(base, read_plan(vary, base.document, base.file, draws), means or Means())


def written_system(folder: Path, system: dict[str, Any]) -> str:
    lines = [f"{key} = {json.dumps(value)}" for key, value in system.items() if key != "parameters"]
    values = ", ".join(f"{name} = {json.dumps(value)}" for name, value in system["parameters"].items())
    file = folder / "system.toml"
    file.write_text("[system]\n" + "\n".join(lines) + f"\nparameters = {{ {values} }}\n")
    return str(file)


def test_rows_are_checks_one_by_one() -> None:
    found = swept(RELAY, {"k": "-1,1/2", "a": "1"})
    system = ns.System(RELAY["states"], RELAY["rhs"], parameters=RELAY["parameters"])
    values = [(-1, 1), ("1/2", 1)]
    for outcome, (k, a) in zip(found.outcomes, values, strict=True):
        check = system.check(parameters={"k": k, "a": a})
        assert outcome["stability"] == check.verdict
        assert outcome["V"] == check.lyapunov or outcome["V"] is None
        region = check.to_dict()["lyapunov"]["region"]
        assert outcome["level"] == (None if region is None else region["level"])


@pytest.mark.usefixtures("without_reach")
def test_the_border_of_a_linear_system_is_where_its_eigenvalues_cross() -> None:
    system = {"states": ["x", "y"], "rhs": ["y - x", "k*x - 2*y"], "parameters": {"k": 0}}
    found = swept(system, {"k": "0:4:3"}, Means(borders=True))
    first, last = found.borders or ()
    assert first.point[0].number == last.point[0].number == 2.0
    assert (first.before, last.after) == (("asymptotically stable",), ("unstable",))
    assert first.after == first.there == last.there == last.before == ("stable",)  # a line of equilibria
    for k in (first.below.number, last.above.number):
        assert abs(np.linalg.eigvals(np.array([[-1.0, 1.0], [float(k or 0), -2.0]])).real.max()) < 1e-8


def test_random_draws_agree_with_the_formula_of_the_region() -> None:
    """The field ``-sgn(x)(1 - k x)`` turns at ``x = 1/k``."""
    found = swept(INTERVAL, {"k": "3:9"}, draws=8)
    for k, outcome in enumerate(found.outcomes):
        value = found.plan.point(k)[0].number
        assert value is not None
        assert outcome["to"] == pytest.approx(1 / value, rel=1e-12)
        assert outcome["from"] == -0.5


@thorough
def test_an_end_of_an_interval_varies() -> None:
    system = {"states": ["x", "y"], "rhs": ["y", "-x - k*y"], "parameters": {"k": [1, 2]}}
    found = swept(system, {"k.low": "-1,1"})
    assert [outcome["stability"] == "asymptotically stable" for outcome in found.outcomes] == [False, True]


def test_a_store_knows_what_was_checked(tmp_path: Path) -> None:
    means = Means(store=tmp_path / "store.db")
    first, second = (swept(INTERVAL, {"k": "1:5:3"}, means) for _ in range(2))
    assert (first.checked, second.checked) == (3, 0)
    assert first.outcomes == second.outcomes


@pytest.mark.usefixtures("without_reach")
def test_files_of_all_kinds(invoke: Invoke, tmp_path: Path) -> None:
    file = written_system(tmp_path, INTERVAL)
    done = invoke("sweep", file, "--vary", "k=-1:5:3", "--workers", "1", "-o", str(tmp_path / "rows.csv"))
    assert done.status == 0
    rows = list(csv.DictReader((tmp_path / "rows.csv").read_text().splitlines()))
    assert [row["system.parameters.k exact"] for row in rows] == ["-1", "2", "5"]
    assert Fraction(rows[2]["to"]) == Fraction("0.2")
    for vary in (["--vary", "k=-1:5:3"], ["--vary", "k=-1:5:2", "--vary", "radius=1/4,1/2"]):
        done = invoke("sweep", file, *vary, "--workers", "1", "-o", str(tmp_path / "picture.svg"))
        assert done.status == 0
        assert b"asymptotically stable" in (tmp_path / "picture.svg").read_bytes()


@pytest.mark.usefixtures("without_reach")
def test_in_python() -> None:
    system = ns.System(["x"], INTERVAL["rhs"], parameters={"k": 4})
    found = system.sweep(k="1:5:3")
    assert [row["stability"] for row in found.rows()] == ["asymptotically stable"] * 3
    assert "asymptotically stable" in repr(found)
    assert "stability" in found._repr_html_()


# ---- Cells of a sweep that are certified as a whole, against arrays drawn from them; what is refused.

SCENE = """
friction = {{ mu_roll = 1, mu_side = {mu_side} }}
check = {{ radius = "1/20" }}
wheel = [
  {{ position = [{x}, "1/10"], heading = {heading}, speed = {speed} }},
  {{ position = ["-1/10", "1/10"], heading = 315, speed = "1/10" }},
  {{ position = ["-1/10", "-1/10"], heading = 45, speed = "1/10" }},
  {{ position = ["1/10", "-1/10"], heading = 135, speed = "1/10" }},
]
"""
TOLERANCE = '[tolerance]\nposition = "1/1000"\nheading = "1 deg"\nspeed = "1/50"\nmu_side = "1/20"\n'
DEFAULTS = {"mu_side": 0.5, "x": 0.1, "heading": 225, "speed": 0.1}
PATHS = {
    "mu_side": "friction.mu_side",
    "x": "wheel.1.position.x",
    "heading": "wheel.1.heading",
    "speed": "wheel.1.speed",
}


def written(folder: Path, **values: float) -> Path:
    file = folder / "table.toml"
    file.write_text(SCENE.format(**{**DEFAULTS, **values}) + TOLERANCE, encoding="utf-8")
    return file


@few(1)
@pytest.mark.parametrize(
    ("first", "second"),
    [(("x", "0.1:0.11:2"), ("mu_side", "0.3:0.5:2")), (("heading", "221:229:3"), ("speed", "0.09:0.11:3"))],
    ids=["position and friction", "heading and speed"],
)
def test_no_array_of_a_certified_cell_breaks_it(
    invoke: Invoke, tmp_path: Path, first: tuple[str, str], second: tuple[str, str]
) -> None:
    """Scenes at corners and inside of the cell, and arrays within the tolerances of each, outside the cell's disc."""
    file, names = written(tmp_path), (first[0], second[0])
    vary = [f"{PATHS[name]}={values}" for name, values in (first, second)]
    record = invoke(
        "sweep", str(file), "--vary", vary[0], "--vary", vary[1], "--certify", "--workers", "1", "--json"
    ).record
    certified = [cell for cell in record["cells"] if cell["verdict"] == "certified"]
    assert len(record["cells"]) == (int(first[1][-1]) - 1) * (int(second[1][-1]) - 1)
    assert certified
    rng = np.random.default_rng(5)
    for cell in certified[:2]:
        for _ in range(6):
            shares = rng.choice([0.0, 1.0, 0.5], 2)
            ends = [cell["between"][PATHS[name]] for name in names]
            chosen = {name: low + s * (high - low) for name, (low, high), s in zip(names, ends, shares, strict=True)}
            scene = load_scene(written(tmp_path, **chosen), rule="nearest")
            sizes = rng.uniform(cell["ends_within"], cell["starts_within"], 400)
            angles = rng.uniform(0, 2 * np.pi, 400)
            points = sizes[:, None] * np.column_stack([np.cos(angles), np.sin(angles)])
            moved = velocities(drawn(scene, 400, int(rng.integers(1000))), points)
            assert ((points * moved).sum(axis=1) < 0).all()


def test_a_cell_across_a_border_is_left_white(invoke: Invoke, tmp_path: Path) -> None:
    """Where mu_side may exceed mu_roll the answer changes: a cell beside the border is certified, one across is not."""
    cells = cells_of(invoke, written(tmp_path), f"{PATHS['mu_side']}=0.5,0.8,1.2,1.4")
    assert [cell["verdict"] for cell in cells] == ["certified", "undecided", "undecided"]
    assert cells[1]["ends_within"] is None
    assert cells[1]["why"]


def cells_of(invoke: Invoke, file: Path, *vary: str) -> list[dict[str, Any]]:
    options = [part for text in vary for part in ("--vary", text)]
    found: list[dict[str, Any]] = invoke("sweep", str(file), *options, "--certify", "--workers", "1", "--json").record[
        "cells"
    ]
    return found


@pytest.mark.parametrize(
    ("given", "stated", "name", "required"),
    [
        ("heading = 225", 'heading = "inward"', "x", "an angle or a direction as heading of wheel 1"),
        ("heading = 225, speed = 0.1", "", "x", "an angle or a direction as heading of wheel 1"),
        ("heading = 225", 'heading = 225, axis = "inward"', "x", "an angle or a direction as axis of wheel 1"),
        ("heading = 225", "heading = 225, axis = 45", "heading", "a friction axis that turns with wheel.1.heading"),
    ],
)
def test_a_number_that_others_follow_makes_no_cell(
    invoke: Invoke, tmp_path: Path, given: str, stated: str, name: str, required: str
) -> None:
    """Of rims that turn as their wheel is moved a cell was certified in which most bodies leave."""
    file = written(tmp_path)
    file.write_text(file.read_text(encoding="utf-8").replace(given, stated).replace(", ,", ",").replace(",  }", " }"))
    vary = {"x": "0.1:0.11:2", "heading": "221:229:3"}[name]
    outcome = invoke("sweep", str(file), "--vary", f"{PATHS[name]}={vary}", "--certify", "--workers", "1")
    assert outcome.status == 2
    assert f"certify: required {required}" in outcome.err
    assert outcome.err.count("\n") == 1


PRESSED = """
units = { length = "m" }
friction = { mu_roll = 1, mu_side = "1/2" }
ring = { count = 4, phase = 45 }
contact = { rule = "roller", loads = LOADS }
check = { radius = "1/4" }
"""


def test_cells_over_the_point_follow_loads_that_were_measured(invoke: Invoke, tmp_path: Path) -> None:
    """Bodies end in the middle of the ring, 0.01 from the points at both ends; within 0.0003 was certified."""
    file = tmp_path / "measured.toml"
    text = PRESSED.replace("LOADS", '{ kind = "measured", values = [1, 1, 1] }').replace("count = 4", "count = 3")
    file.write_text(text.replace('"1/4"', '"1/16"'), encoding="utf-8")
    (cell,) = cells_of(invoke, file, "check.equilibrium.x=-0.01,0.01")
    assert cell["verdict"] == "certified"
    assert cell["ends_within"] >= 0.01


def test_words_about_cells_say_from_where_bodies_end_there(invoke: Invoke, tmp_path: Path) -> None:
    """Where only bodies that start close by are known to, "every body" was said."""
    file = tmp_path / "near.toml"
    file.write_text(PRESSED.replace("LOADS", '"elastic"'), encoding="utf-8")
    vary = ("--vary", "mu_side=0.5,0.52", "--certify", "--workers", "1")
    near = " ".join(invoke("sweep", str(file), *vary).out.split())
    assert "whole: every body that starts close to the point ends within" in near
    wide = " ".join(invoke("sweep", str(file), *vary, "--rule", "nearest").out.split())
    assert "whole: every body that starts within 0.25 of the point ends within" in wide


def test_no_cell_is_certified_over_the_point_of_a_table_of_loads(invoke: Invoke, tmp_path: Path) -> None:
    """A table that is affine in c changes all loads with the point; one of constant loads does not."""
    rows = [[0.25, x, y] for x, y in [(0.35, 0.35), (-0.35, 0.35), (-0.35, -0.35), (0.35, -0.35)]]
    file, vary = tmp_path / "table.toml", "check.equilibrium.x=-0.01,0.01"
    file.write_text(PRESSED.replace("LOADS", str(rows)), encoding="utf-8")
    outcome = invoke("sweep", str(file), "--vary", vary, "--certify", "--workers", "1")
    assert outcome.status == 2
    assert "certify: required elastic or measured loads, or a table of constant ones, since check.eq" in outcome.err
    assert outcome.err.count("\n") == 1
    constant = PRESSED.replace("LOADS", str([[0.25, 0, 0]] * 4)).replace("roller", "nearest")
    file.write_text(constant, encoding="utf-8")
    assert len(cells_of(invoke, file, vary)) == 1


@pytest.mark.parametrize("values", ["221 deg,229", "221,229 deg", "229,221", "221"])
def test_sides_of_cells_have_one_unit_and_ascend(invoke: Invoke, tmp_path: Path, values: str) -> None:
    """Where angles are radians, a cell from 225 degrees to 226 radians was certified that held one degree of them."""
    file = written(tmp_path)
    file.write_text('units = { angle = "rad" }\n' + file.read_text(encoding="utf-8"), encoding="utf-8")
    outcome = invoke("sweep", str(file), "--vary", f"{PATHS['heading']}={values}", "--certify", "--workers", "1")
    assert outcome.status == 2
    assert "certify: required two or more rational values of wheel.1.heading that ascend" in outcome.err


@few(1)
@pytest.mark.parametrize(
    ("vary", "stated", "larger"),
    [
        ("mu_side=0.4,0.6", 'mu_side = "1/20', " + 1/5*1048577/1048576 + 1/20*1/5*1048577/1048576"),
        ("x=0.098,0.102", 'position = "1/1000', " + 1/500*1048577/1048576"),
    ],
)
def test_a_cell_is_its_middle_with_larger_tolerances(
    invoke: Invoke, tmp_path: Path, vary: str, stated: str, larger: str
) -> None:
    """The bound is the one of a check of that scene."""
    name, values = vary.split("=")
    (cell,) = cells_of(invoke, written(tmp_path), f"{PATHS[name]}={values}")
    middle = tmp_path / "middle.toml"
    middle.write_text((SCENE.format(**DEFAULTS) + TOLERANCE).replace(stated, stated + larger), encoding="utf-8")
    robust = invoke("check", str(middle), "--json").record["robust"]
    assert robust["radius"] == pytest.approx(cell["ends_within"], rel=1e-12)
    assert robust["from"] == pytest.approx(cell["starts_within"], rel=1e-12)


def test_the_picture_leaves_white_what_is_not_certified(invoke: Invoke, tmp_path: Path) -> None:
    vary = ("--vary", f"{PATHS['mu_side']}=0.5,0.8,1.2", "--vary", f"{PATHS['x']}=0.098,0.102")
    outcome = invoke("sweep", str(written(tmp_path)), *vary, "--certify", "--workers", "1", "-o", "cells.svg")
    assert outcome.status == 0
    assert "1 of 2 cells of the grid are certified as a whole" in outcome.out
    assert "#009e73" in (tmp_path / "cells.svg").read_text(encoding="utf-8").lower()


def test_results_of_cells_are_kept(invoke: Invoke, tmp_path: Path) -> None:
    vary = ("--vary", f"{PATHS['mu_side']}=0.5,0.8", "--certify", "--workers", "1", "--store", "runs.sqlite", "--json")
    first, again = (invoke("sweep", str(written(tmp_path)), *vary).record for _ in range(2))
    assert first == again


# ---- Sweeps on a Dask cluster, where the optional package is installed ---------------------------

needs_dask = pytest.mark.skipif(find_spec("distributed") is None, reason="the extra cluster is optional")
SWEEP = ("sweep", "four-wheel", "--vary", "mu_side=1/10:2:40", "--store", "r.sqlite", "-o", "t.csv")


@contextmanager
def running(*words: str) -> Iterator[subprocess.Popen[bytes]]:
    """A program of Dask, ended in the end."""
    command = [sys.executable, "-m", "distributed.cli." + words[0], *words[1:], "--no-dashboard"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


@contextmanager
def scheduler(folder: Path) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    file = folder / "scheduler.json"
    with running("dask_scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(file)) as process:
        end = time.monotonic() + 60
        while not (file.exists() and '"tcp://' in file.read_text(encoding="utf-8")) and time.monotonic() < end:
            time.sleep(0.05)
        yield next(w for w in file.read_text(encoding="utf-8").split('"') if w.startswith("tcp://")), process


@contextmanager
def worker(address: str) -> Iterator[subprocess.Popen[bytes]]:
    with running("dask_worker", address, "--nthreads", "1", "--no-nanny") as process:
        yield process


@needs_dask
@pytest.mark.filterwarnings("ignore")  # of the optional package
def test_a_cluster_gives_the_same_table_though_a_worker_is_killed(invoke: Invoke, tmp_path: Path) -> None:
    assert invoke(*SWEEP, "--workers", "1").status == 0
    wanted = (tmp_path / "t.csv").read_bytes()
    for name in ("t.csv", "r.sqlite"):
        (tmp_path / name).unlink()
    with scheduler(tmp_path) as (address, _), worker(address) as first, worker(address):
        command = [sys.executable, "-m", "nonsmooth", *SWEEP, "--scheduler", address]
        sweep = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while count(tmp_path / "r.sqlite") < 5 and sweep.poll() is None:
            time.sleep(0.05)
        os.kill(first.pid, signal.SIGKILL)
        _, said = sweep.communicate(timeout=120)
        assert (sweep.returncode, said) == (0, "")
    assert (tmp_path / "t.csv").read_bytes() == wanted


@needs_dask
@pytest.mark.filterwarnings("ignore")
def test_a_lost_scheduler_is_one_line_and_loses_nothing(tmp_path: Path) -> None:
    with scheduler(tmp_path) as (address, process), worker(address):
        command = [sys.executable, "-m", "nonsmooth", *SWEEP, "--vary", "mu_roll=1:2:99", "--scheduler", address]
        sweep = subprocess.Popen(command, cwd=tmp_path, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        while count(tmp_path / "r.sqlite") < 5 and sweep.poll() is None:
            time.sleep(0.05)
        process.kill()
        _, said = sweep.communicate(timeout=60)
        assert sweep.returncode == 2
        assert (
            said == f"nonsmooth: --scheduler: {address}: required a scheduler that stays, received a lost connection\n"
        )
    assert count(tmp_path / "r.sqlite") >= 5
    assert not (tmp_path / "t.csv").exists()


@needs_dask
@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense://x"])
def test_a_scheduler_that_is_not_there_is_one_line_in_time(invoke: Invoke, address: str) -> None:
    started = time.monotonic()
    done = invoke(*SWEEP, "--scheduler", address)
    assert time.monotonic() - started < 10
    required = f"required a Dask scheduler that answers within {workers.ANSWER} s, received none"
    assert (done.status, done.out, done.err) == (2, "", f"nonsmooth: --scheduler: {address}: {required}\n")


def test_without_the_package_the_extra_is_named(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    done = invoke(*SWEEP, "--scheduler", "tcp://127.0.0.1:1")
    assert (done.status, done.out, done.err.count("\n")) == (2, "", 1)
    assert "required the package distributed (pip install nonsmooth[cluster])" in done.err


def count(path: Path) -> int:
    if not path.exists():
        return 0
    store = Store(path)
    try:
        return len(store)
    finally:
        store.close()
