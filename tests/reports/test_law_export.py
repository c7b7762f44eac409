"""The exported law, run alone, is the library's law on random poses, under every contact rule."""

from __future__ import annotations

import ast
import csv
import runpy
import sys
from collections.abc import Mapping
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.minimizers.box_minimizers import BoxHighs
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.driven_law import in_scene, rim_speeds
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.proofs.theorem4_result import CellCheck, Check
from nonsmooth.reports.laws.feedback_loop import build_loop
from nonsmooth.reports.laws.law_languages import law_of
from nonsmooth.reports.laws.law_table import LawKind
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.conftest import Arrays
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

POSES = 60
ENOUGH = 3  # arrays whose law is of another V: each is exported, and many are tried to find them
ROUNDING = 1e-12  # relative: a handful of operations each
BOX_ERROR = 1e-7  # relative, of a minimizer by linear programs
NO_LAW = ("four-wheel-side", "off-center", "differential-drive", "omni-3", "mecanum-4", "roller-bed")
HAVE_ONE = [name for name in builtin_scenes() if name not in NO_LAW]


def exported(check: Check, folder: Path) -> Mapping[str, Any]:
    """The names of the exported file, run as a file."""
    found: Mapping[str, Any] = runpy.run_path(str(law_of(check).save(folder / "law.py")))
    return found


def poses(check: Check, seed: int = 0) -> Floats:
    """Random poses in the checked square, measured from its centre, of all sizes."""
    rng = np.random.default_rng(seed)
    sizes = float(check.scene.check.radius) * 10 ** rng.uniform(-3, 0, (POSES, 1))
    return np.asarray(rng.uniform(-1, 1, (POSES, 3)) * sizes)


def library_speeds(check: Check, pose: Floats) -> Mapping[int, float]:
    """By the law that the library follows, in the cell that exact arithmetic names."""
    assert isinstance(check, CellCheck)
    assert isinstance(check.feedback, FeedbackResult)
    loop = build_loop(check.partition, LawName.CERTIFIED, Kinematics.EXACT, check.feedback)
    point = tuple(check.scene.field(Fraction(float(value))) for value in pose[:2])
    cell = check.partition.cells_at((point[0], point[1]))[0]
    return loop.speeds(cell.states[0])(pose)


def assert_close(found: Mapping[int, float], expected: Mapping[int, float]) -> None:
    assert found.keys() == expected.keys()
    size = max(map(abs, expected.values()))
    assert all(abs(found[wheel] - expected[wheel]) <= ROUNDING * size for wheel in expected)


@few(4)
@pytest.mark.parametrize("name", HAVE_ONE)
def test_under_nearest_the_program_is_the_law_that_is_followed(name: str, tmp_path: Path) -> None:
    check = check_theorem4(load_scene(name, rule="nearest"), prune=False)
    law = exported(check, tmp_path)
    for pose in poses(check):
        assert_close(law["speeds"](*pose.tolist()), library_speeds(check, pose))


@pytest.mark.parametrize("turn", [(Fraction(20, 29), Fraction(21, 29)), (Fraction(3, 5), Fraction(-4, 5))])
def test_a_cascade_is_exported(arrays: Arrays, turn: tuple[Fraction, Fraction], tmp_path: Path) -> None:
    check = check_theorem4(arrays.four_wheel((1, Fraction(1, 2)), turn), prune=False)
    assert law_of(check).law.kind is LawKind.CASCADE
    law = exported(check, tmp_path)
    for pose in poses(check):
        assert_close(law["speeds"](*pose.tolist()), library_speeds(check, pose))


@thorough  # the small one: test_under_nearest_the_program_is_the_law_that_is_followed
def test_a_law_of_another_v_is_exported(arrays: Arrays, tmp_path: Path) -> None:
    shaped = 0
    for seed in range(60):
        if shaped == ENOUGH:
            break
        check = check_theorem4(arrays.cocircular(seed, (1, Fraction(1, 2))))
        feedback = check.feedback
        if not (isinstance(feedback, FeedbackResult) and feedback.law and any(feedback.lyapunov.shape)):
            continue
        law = exported(check, tmp_path)
        for pose in 1e-3 * poses(check, seed):
            assert_close(law["speeds"](*pose.tolist()), library_speeds(check, pose))
        shaped += 1
    assert shaped == ENOUGH


@few(2)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("name", keep(2, ["four-wheel", "ring-5", "conveyor-3", "ring-8", "grid-4x4"]))
def test_under_other_rules_the_program_imposes_the_twist_of_the_clause(name: str, rule: str, tmp_path: Path) -> None:
    """In another unit of length too: the twists are those of the clause in the scene's own."""
    scene = load_scene(name, rule=rule)
    for length in (Fraction(1), Fraction(3, 10)):
        check = check_theorem4(replace(scene, check=replace(scene.check, length=length)))
        law = exported(check, tmp_path)
        for pose in poses(check):
            assert_close(law["speeds"](*pose.tolist(), k=2.0), imposed_speeds(check, pose, gain=2.0)[1])


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "ellipse"])
def test_the_program_keeps_speed_limits_by_one_factor(rule: str, tmp_path: Path) -> None:
    scene = load_scene("ring-5", rule=rule)
    limits = [scene.field(Fraction(k, 10)) for k in (1, 2, 3, 4)]
    wheels = [replace(wheel, speed_limit=limit) for wheel, limit in zip(scene.wheels, limits, strict=False)]
    check = check_theorem4(replace(scene, wheels=(*wheels, scene.wheels[4])), prune=False)
    law, at_a_limit = exported(check, tmp_path), 0
    for pose in poses(check):
        expected = imposed_speeds(check, pose, 1.0)[1] if rule == "ellipse" else library_speeds(check, pose)
        excess = max((abs(u) / float(limits[w - 1]) for w, u in expected.items() if w <= 4), default=0.0)
        if rule == "ellipse" and excess > 1:
            expected = {wheel: speed / excess for wheel, speed in expected.items()}
        found = law["speeds"](*pose.tolist())
        assert_close(found, expected)
        assert all(abs(found[w]) <= float(limits[w - 1]) * (1 + ROUNDING) for w in found if w <= 4)
        at_a_limit += excess > 1 - ROUNDING
    assert 5 < at_a_limit < POSES
    limit_of = {int(row["wheel"]): row["speed_limit"] for row in law_of(check).rows()}
    assert limit_of == {1: "0.1", 2: "0.2", 3: "0.3", 4: "0.4", 5: ""}


def imposed_speeds(check: Check, pose: Floats, gain: float) -> tuple[Floats, Mapping[int, float]]:
    """``-k (g . xi_l) xi_l`` and its speeds, from the evidence."""
    feedback = check.feedback
    assert isinstance(feedback, DrivenFeedback)
    own = in_own_length(check.scene.recentred())
    x, y = pose[:2]
    (cone,) = [cone for cone in feedback.cones if cone.rays is None or _between(cone.rays, (x, y))]
    g = np.array([x, y, float(feedback.length) ** 2 * pose[2]])
    twists = [np.array(_floats(in_scene(imposed.twist, feedback.length))) for imposed in cone.twists]
    best = max(range(len(twists)), key=lambda k: abs(float(g @ twists[k])))
    factor = -gain * float(g @ twists[best])
    speeds = rim_speeds(own, cone.twists[best])
    numbers = [wheel.index for wheel in own.wheels]
    return factor * twists[best], {w: factor * u for w, u in zip(numbers, speeds, strict=True)}


def _floats(values: Any) -> tuple[float, ...]:
    return tuple(float(value) for value in values)


def _between(rays: tuple[Any, Any], c: tuple[float, float]) -> bool:
    start, end = (_floats(ray) for ray in rays)
    return start[0] * c[1] > start[1] * c[0] and c[0] * end[1] > c[1] * end[0]


@few(2)
@pytest.mark.parametrize("name", ["four-wheel", "ring-5", "elliptic"])
def test_under_box_a_minimizer_moves_as_the_program_wants(name: str, tmp_path: Path) -> None:
    """The exported speeds, not the clause's twist, are given to the minimizer of D, within the certified reach."""
    scene = load_scene(name, rule="box").recentred()
    check = check_theorem4(scene)
    assert isinstance(check.feedback, DrivenFeedback)
    assert check.feedback.reach is not None
    law, model = exported(check, tmp_path), contact_model(scene)
    size = 0.9 * float(check.feedback.reach) / float(scene.check.radius)
    for pose in size * poses(check)[:20]:
        speeds = law["speeds"](*pose.tolist())
        targets = np.zeros(2 * model.wheels)
        targets[0::2] = [speeds[wheel.index] for wheel in scene.wheels]
        found = BoxHighs().minimize(replace(model, targets=targets), loads_at(model, pose[None, :2])).twists[0]
        wanted, _ = imposed_speeds(check, pose, gain=1.0)
        assert np.abs(found - wanted).max() <= BOX_ERROR * np.abs(wanted).max()


def test_the_program_needs_nothing_but_python(tmp_path: Path) -> None:
    check = check_theorem4(load_scene("four-wheel"))
    text = law_of(check).program()
    imported = [node for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert [alias.name for node in imported for alias in node.names] == ["math"]
    assert "math" in sys.stdlib_module_names
    assert "certified from starts with V < 0.25" in text
    with pytest.raises(ValueError, match="required a place in a region of the law"):
        exported(check, tmp_path)["speeds"](9.0, 0.0, 0.0)


def test_the_program_states_units_and_the_speed_of_its_wheels() -> None:
    scene = load_scene("ring-5", rule="ellipse")
    text = law_of(check_theorem4(replace(scene, units=Units("mm")))).program()
    assert "Units: mm (lengths), mm/s (speeds), s (times)." in text
    assert "k sqrt(V), V = |c|^2 + theta^2 (the largest of all regions: all directions)." in " ".join(text.split())
    assert "Units: " not in law_of(check_theorem4(scene)).program()


@pytest.mark.parametrize("name", ["four-wheel", 'x\n"""\nregion,where'])
def test_a_table_says_what_a_program_says(name: str) -> None:
    """Region, largest speed and the constants of its formulas, in comments before the names of its columns."""
    law = law_of(check_theorem4(replace(load_scene("four-wheel"), name=name)))
    lines = law.formats[".csv"](law, ".csv").decode().splitlines()
    first = next(k for k, line in enumerate(lines) if not line.startswith("# "))
    assert lines[first] == "region,where,xi_l,wheel,speed"
    head = " ".join(" ".join(lines[:first]).replace("#", "").split())
    assert "certified from starts with V < 0.25" in head
    assert "No rim is asked for a speed above 1.00001 k sqrt(V)" in head
    assert "w = 1.0" in head


def test_a_hostile_name_stays_text(tmp_path: Path) -> None:
    scene = replace(load_scene("ring-3"), name='"""\nimport os\n\\"""{0}')
    assert exported(check_theorem4(scene), tmp_path)["speeds"](0.01, 0.0, 0.0)
    assert "os" not in runpy.run_path(str(tmp_path / "law.py"))


def test_the_command_writes_table_and_program(invoke: Invoke, tmp_path: Path) -> None:
    assert invoke("check", "four-wheel", "--law", "law.csv").status == 0
    lines = (tmp_path / "law.csv").read_text(encoding="utf-8").splitlines()
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    assert [row["wheel"] for row in rows[:2]] == ["1", "2"]
    assert {row["region"] for row in rows} == {f"cell {k}" for k in range(1, 9)}
    outcome = invoke("check", "four-wheel", "--rule", "box", "--law", "law.py", "--json")
    assert outcome.record["feedback"]["verdict"] == "stabilizable"
    assert runpy.run_path("law.py")["speeds"](0.0, 0.0, 0.0) == {1: 0.0, 2: 0.0, 3: 0.0, 4: 0.0}


def test_no_certificate_is_written_where_the_law_beside_it_is_refused(invoke: Invoke, tmp_path: Path) -> None:
    done = invoke("check", "roller-bed", "--certificate", "bed.json", "--law", "bed.py")
    assert done.status == 2
    assert "required a certified feedback law" in done.err
    assert not list(tmp_path.glob("bed.*"))
