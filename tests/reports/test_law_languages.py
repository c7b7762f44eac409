"""Laws as programs in Python, C and Structured Text, each run as what it is, beside the law of a simulation.

And beside the evidence of the clause: the twists that it imposes under rules other than ``nearest``.
"""

from __future__ import annotations

import ast
import ctypes
import json
import math
import re
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import replace
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.fields.feedback_laws import LawKind
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult
from nonsmooth.proofs.clauses.feedback.driven_law import in_scene, rim_speeds
from nonsmooth.proofs.clauses.feedback.loop_bounds import certified_error, wheel_speed
from nonsmooth.proofs.theorem4 import CellCheck, Check, check_theorem4
from nonsmooth.reports.laws.driven_loop import DrivenLoop
from nonsmooth.reports.laws.feedback_loop import build_loop
from nonsmooth.reports.laws.law_languages import Language, LawResult, law_of
from nonsmooth.reports.laws.law_table import NoLawError
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.reports.simulations.closed_paths import follow_closed
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.built_in import checked
from tests.conftest import Arrays
from tests.reports.conftest import Invoke
from tests.structured_text import FunctionBlock, StructuredTextError
from tests.thorough import few, keep

Speeds: TypeAlias = Mapping[int, float]
Law: TypeAlias = Callable[[float, float, float, float], Speeds]

OUTLINED = """
units = { length = "m" }
friction = { mu_roll = 1, mu_side = 0.5 }
contact = { rule = "ellipse" }
field = { kind = "expression", x = "1.5 - x", y = "0.5 - y" }
wheels = { file = "wheels.csv" }
body = { shape = "rectangle", width = 1.6, height = 1.6 }
check = { equilibrium = [1.5, 0.5] }
"""
POSES = 40
CLOSE = 1e-9  # of the fastest wheel
COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
LANGUAGES = list(Language)


# ---- the programs, run ---------------------------------------------------------------------------


def in_python(program: str, folder: Path, poses: Floats, gain: float) -> list[Speeds]:
    """By a process of its own, which is given the file and nothing of the library."""
    (folder / "law.py").write_text(program, encoding="utf-8")
    script = (
        "import json, sys; names = {}; exec(open('law.py').read(), names); "
        "print(json.dumps([names['speeds'](*pose, k) for *pose, k in json.load(sys.stdin)]))"
    )
    given = json.dumps([[*pose, gain] for pose in poses.tolist()])
    command = [sys.executable, "-I", "-S", "-c", script]
    done = subprocess.run(command, input=given, capture_output=True, text=True, check=True, cwd=folder)
    return [{int(wheel): speed for wheel, speed in each.items()} for each in json.loads(done.stdout)]


def c_law(program: str, folder: Path, *, lost: bool = False) -> Law:
    """Compiled, with every warning an error, and loaded."""
    if COMPILER is None:
        pytest.skip("no C compiler (cc, gcc, clang) on this machine")
    (folder / "law.c").write_text(program, encoding="ascii")
    flags = ["-std=c99", "-pedantic", "-Wall", "-Wextra", "-Wconversion", "-Werror", "-O1", "-shared", "-fPIC"]
    command = [COMPILER, *flags, "law.c", "-o", "law.so", "-lm"]
    subprocess.run(command, check=True, capture_output=True, cwd=folder)
    library = ctypes.CDLL(str(folder / "law.so"))
    library.law_speeds.argtypes = [ctypes.c_double] * 4 + [ctypes.POINTER(ctypes.c_double)]
    count = int(re.findall(r"#define LAW_WHEELS (\d+)", program)[0])
    numbers = list((ctypes.c_int * count).in_dll(library, "law_wheels"))

    def law(x: float, y: float, theta: float, k: float) -> Speeds:
        speeds = (ctypes.c_double * count)()
        assert (library.law_speeds(x, y, theta, k, speeds) == 0) is lost
        return dict(zip(numbers, speeds, strict=True))

    return law


def st_law(program: str, folder: Path, *, lost: bool = False) -> Law:
    """By the interpreter of the tests; the block keeps its variables, as in a controller."""
    block = FunctionBlock(program)
    numbers = [int(number) for number in block["wheels"]]

    def law(x: float, y: float, theta: float, k: float) -> Speeds:
        block(x=x, y=y, theta=theta, k=k)
        assert (block["region"] == [0]) is lost
        return dict(zip(numbers, block["speeds"], strict=True))

    return law


def run(law: LawResult, language: Language, folder: Path, poses: Floats, gain: float) -> list[Speeds]:
    """The speeds at poses (m, 3) by the program in a language."""
    program = law.program(str(language))
    if language is Language.PYTHON:
        return in_python(program, folder, poses, gain)
    found = (c_law if language is Language.C else st_law)(program, folder)
    return [found(x, y, theta, gain) for x, y, theta in poses.tolist()]


# ---- the law of the simulation -------------------------------------------------------------------


def simulated(check: Check, name: LawName, gain: float) -> Callable[[Floats], Speeds]:
    """The speeds that ``simulate --feedback`` gives the wheels."""
    feedback = check.feedback
    if isinstance(feedback, DrivenFeedback):
        loop = DrivenLoop(check.scene.recentred(), feedback.holding, gain)
        numbers = [wheel.index for wheel in check.scene.wheels]
        return lambda pose: dict(zip(numbers, loop.speeds(pose.tolist()), strict=True))
    assert isinstance(check, CellCheck)
    assert isinstance(feedback, FeedbackResult)
    rows = build_loop(check.partition, name, Kinematics.EXACT, feedback, gain)

    def speeds(pose: Floats) -> Speeds:
        x, y = (check.scene.field(Fraction(float(value))) for value in pose[:2])
        return rows.speeds(check.partition.cells_at((x, y))[0].states[0])(pose)

    return speeds


def random_poses(check: Check, seed: int, size: float = 1.0) -> Floats:
    """In the checked square, of all sizes."""
    rng = np.random.default_rng(seed)
    sizes = size * float(check.scene.check.radius) * 10 ** rng.uniform(-3, 0, (POSES, 1))
    return np.asarray(rng.uniform(-1, 1, (POSES, 3)) * sizes)


def assert_alike(found: Speeds, expected: Speeds) -> None:
    """Wheels that are not driven there stand still in the languages of fixed arrays."""
    size = max(map(abs, expected.values()))
    for wheel in found.keys() | expected.keys():
        assert abs(found.get(wheel, 0.0) - expected.get(wheel, 0.0)) <= CLOSE * size


def turned_wheels(arrays: Arrays, sine: int, cosine: int, radius: int) -> Check:
    return check_theorem4(arrays.four_wheel((1, Fraction(1, 2)), (Fraction(sine, radius), Fraction(cosine, radius))))


@cache
def case(arrays: Arrays, name: str) -> tuple[Check, LawName, LawKind]:
    """A check, which of its laws, and of which kind that is."""
    match name.split():
        case ["cascade"]:
            return turned_wheels(arrays, 20, 21, 29), LawName.CERTIFIED, LawKind.CASCADE
        case ["tangential"]:
            return turned_wheels(arrays, 0, 1, 1), LawName.CERTIFIED, LawKind.SLOW_TURNS
        case ["shaped"]:
            return check_theorem4(shaped(arrays)), LawName.CERTIFIED, LawKind.GRADIENT
        case ["limited", rule]:
            scene = load_scene("ring-5", rule=rule)
            limits = [scene.field(Fraction(k, 10)) for k in (1, 2, 3, 4)]
            few_limits = [replace(wheel, speed_limit=u) for wheel, u in zip(scene.wheels, limits, strict=False)]
            scene = replace(scene, wheels=(*few_limits, scene.wheels[4]))
            return check_theorem4(scene), LawName.CERTIFIED, LawKind.GRADIENT if rule == "nearest" else LawKind.DRIVEN
        case [scene_name, rule]:
            kind = LawKind.GRADIENT if rule == "nearest" else LawKind.DRIVEN
            kind = LawKind.SLOW_TURNS if scene_name in ("conveyor-3", "saddle") else kind
            return check_theorem4(load_scene(scene_name, rule=rule)), LawName.CERTIFIED, kind
        case [scene_name, rule, law]:
            return check_theorem4(load_scene(scene_name, rule=rule)), LawName(law), LawKind.PAPER
    raise AssertionError(name)


@cache
def shaped(arrays: Arrays) -> Scene:
    """An array whose law is of another V than a sum of squares."""
    for seed in range(60):
        scene = arrays.cocircular(seed, (1, Fraction(1, 2)))
        feedback = check_theorem4(scene).feedback
        if isinstance(feedback, FeedbackResult) and feedback.law and any(feedback.lyapunov.shape):
            return scene
    raise AssertionError("no such array")


CASES = [
    "four-wheel nearest",
    "four-wheel box",
    "ring-5 ellipse",
    "four-wheel nearest printed",
    "ring-5 nearest corrected",
    "cascade",
    "tangential",
    "shaped",
    "limited nearest",
    "limited ellipse",
]
NO_LAW = ("four-wheel-side", "off-center", "differential-drive", "omni-3", "mecanum-4", "roller-bed")
MORE_CASES = [f"{name} nearest" for name in builtin_scenes() if name not in (*NO_LAW, "four-wheel")]


@few(4)
@pytest.mark.parametrize("name", [*CASES, *MORE_CASES])
def test_every_language_is_the_law_of_the_simulation(arrays: Arrays, name: str, tmp_path: Path) -> None:
    check, law_name, kind = case(arrays, name)
    law = law_of(check, law_name)
    assert law.law.kind is kind
    gain = 1.0 if name.startswith("limited") else 1.75
    poses = random_poses(check, 1, 1e-3 if name == "shaped" else 1.0)
    expected = [simulated(check, law_name, gain)(pose) for pose in poses]
    for speeds, (x, y, theta) in zip(expected, poses.tolist(), strict=True):
        assert_alike(law(x, y, theta, k=gain), speeds)
    for language in LANGUAGES:
        if language is Language.C and COMPILER is None:
            continue  # test_c_compiles says so
        for found, speeds in zip(run(law, language, tmp_path, poses, gain), expected, strict=True):
            assert_alike(found, speeds)


@pytest.mark.parametrize("rule", ["nearest", "ellipse"])
@pytest.mark.parametrize("language", LANGUAGES)
def test_what_is_no_number_gets_no_speed(language: Language, rule: str, tmp_path: Path) -> None:
    """Of a pose that was lost, or a gain: wheels at rest in region 0, errors in Python."""
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    law = array.check(rule=rule).law()
    good = (0.1, 0.05, 0.2, 1.0)
    lost = [(*good[:k], value, *good[k + 1 :]) for k in range(4) for value in (math.nan, math.inf, -math.inf)]
    for pose in lost:
        with pytest.raises(ValueError, match="required a p"):
            law(*pose)
    if language is Language.PYTHON:
        names: dict[str, Any] = {}
        exec(law.program(), names)  # noqa: S102 (a law that the test has just written)
        for pose in lost:
            with pytest.raises(ValueError, match="required a p"):
                names["speeds"](*pose)
        return
    run_law = (c_law if language is Language.C else st_law)(law.program(str(language)), tmp_path, lost=True)
    assert not any(speed for pose in lost for speed in run_law(*pose).values())


def test_c_compiles(tmp_path: Path) -> None:
    c_law(law_of(checked("four-wheel", "nearest")).program("c"), tmp_path)(0.1, 0.0, 0.1, 1.0)


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_closed_loop_ends_where_the_simulation_does(language: Language, tmp_path: Path) -> None:
    """Euler steps with the program's speeds end where they do with the law of the simulation, and near its own path."""
    if language is Language.C and COMPILER is None:
        pytest.skip("no C compiler (cc, gcc, clang) on this machine")
    check = checked("four-wheel", "nearest")
    start, until, step = (0.2, 0.1, 0.3), 2.0, 8e-3
    law = law_of(check)
    if language is Language.PYTHON:
        names: dict[str, Callable[..., Speeds]] = {}
        exec(law.program(), names)  # noqa: S102 (a law that the test has just written)
        own = simulated_path(check, lambda pose: names["speeds"](*pose.tolist(), 1.0), start, until, step)
    else:
        run_law = (c_law if language is Language.C else st_law)(law.program(str(language)), tmp_path)
        own = simulated_path(
            check, lambda pose: run_law(float(pose[0]), float(pose[1]), float(pose[2]), 1.0), start, until, step
        )
    other = simulated_path(check, simulated(check, LawName.CERTIFIED, 1.0), start, until, step)
    assert np.abs(own - other).max() <= CLOSE
    path = follow_closed(check.scene, SimulateOptions(start=start, until=until, feedback=True), LawName.CERTIFIED)
    assert np.abs(own - np.array(path.state[-1], dtype=float)).max() < 4 * step
    assert np.abs(own).max() < 0.8 * max(start)


def simulated_path(
    check: Check, law: Callable[[Floats], Speeds], start: tuple[float, float, float], until: float, step: float
) -> Floats:
    """The pose after steps in which the wheels that hold in the cell impose the twist of their speeds."""
    assert isinstance(check, CellCheck)
    pose = np.array(start)
    for _ in range(round(until / step)):
        x, y = (check.scene.field(Fraction(float(value))) for value in pose[:2])
        fields = check.partition.cells_at((x, y))[0].states[0].control_fields
        speeds = law(pose)
        twists = [speeds[wheel] * np.array([float(g) for g in field]) for wheel, field in fields.items()]
        vx, vy, omega = np.sum(twists, axis=0)
        pose = pose + step * np.array([vx - omega * pose[1], vy + omega * pose[0], omega])
    return np.asarray(pose)


# ---- the evidence of the clause ------------------------------------------------------------------


def imposed_speeds(check: Check, pose: Floats, gain: float) -> Speeds:
    """The speeds that impose ``-k (g . xi_l) xi_l``, from the evidence."""
    feedback = check.feedback
    assert isinstance(feedback, DrivenFeedback)
    x, y = pose[:2]
    (cone,) = [cone for cone in feedback.cones if cone.rays is None or is_between(cone.rays, (x, y))]
    g = np.array([x, y, float(feedback.length) ** 2 * pose[2]])
    twists = [np.array(list(map(float, in_scene(imposed.twist, feedback.length)))) for imposed in cone.twists]
    best = max(range(len(twists)), key=lambda k: abs(float(g @ twists[k])))
    own = in_own_length(check.scene.recentred())
    speeds = rim_speeds(own, cone.twists[best])
    factor = -gain * float(g @ twists[best])
    return {wheel.index: factor * speed for wheel, speed in zip(own.wheels, speeds, strict=True)}


def is_between(rays: tuple[Any, Any], c: tuple[float, float]) -> bool:
    """Whether a place lies in the cone between two rays."""
    start, end = (tuple(map(float, ray)) for ray in rays)
    return start[0] * c[1] > start[1] * c[0] and c[0] * end[1] > c[1] * end[0]


@few(2)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
@pytest.mark.parametrize("name", keep(2, ["four-wheel", "ring-5", "conveyor-3", "ring-8", "grid-4x4"]))
def test_under_other_rules_the_program_imposes_the_twist_of_the_clause(name: str, rule: str) -> None:
    """In another unit of length too: the twists are those of the clause in the scene's own."""
    scene = load_scene(name, rule=rule)
    for length in (Fraction(1), Fraction(3, 10)):
        check = check_theorem4(replace(scene, check=replace(scene.check, length=length)))
        law = law_of(check)
        for pose in random_poses(check, 0):
            x, y, theta = pose.tolist()
            assert_alike(law(x, y, theta, k=2.0), imposed_speeds(check, pose, gain=2.0))


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "ellipse"])
def test_the_program_keeps_speed_limits_by_one_factor(arrays: Arrays, rule: str) -> None:
    check, *_ = case(arrays, f"limited {rule}")
    law, limits, at_a_limit = law_of(check), dict(enumerate((0.1, 0.2, 0.3, 0.4), 1)), 0
    for pose in random_poses(check, 0):
        expected = (
            imposed_speeds(check, pose, 1.0) if rule == "ellipse" else simulated(check, LawName.CERTIFIED, 1)(pose)
        )
        excess = max((abs(u) / limits[w] for w, u in expected.items() if w in limits), default=0.0)
        if rule == "ellipse" and excess > 1:
            expected = {wheel: speed / excess for wheel, speed in expected.items()}
        found = law(*pose.tolist())
        assert_alike(found, expected)
        assert all(abs(found[w]) <= limit * (1 + CLOSE) for w, limit in limits.items() if w in found)
        at_a_limit += excess > 1 - CLOSE
    assert 2 < at_a_limit < POSES
    limit_of = {int(row["wheel"]): row["speed_limit"] for row in law.rows()}
    assert limit_of == {1: "0.1", 2: "0.2", 3: "0.3", 4: "0.4", 5: ""}


# ---- what the header says ------------------------------------------------------------------------


@few(3)
@pytest.mark.parametrize("name", ["four-wheel nearest", "ring-5 box", "four-wheel box", "ring-5 nearest", "shaped"])
def test_the_largest_speed_is_as_printed(arrays: Arrays, name: str) -> None:
    """On the border of the certified region no wheel is asked for more, and some for nearly as much."""
    check, law_name, _ = case(arrays, name)
    law = law_of(check, law_name)
    (printed,) = re.findall(r"which is ([\d.e-]+) k on the border", law.law.effort)
    feedback = check.feedback.holding
    region = feedback.region if isinstance(feedback, FeedbackResult) else None
    reach = feedback.reach
    assert region is not None or reach is not None
    level = float(region.level) if region is not None else float(reach or 0) ** 2
    fastest = max(fastest_at_level(law, feedback.lyapunov.value, float(level)))
    assert (0.6 if name == "shaped" else 0.99) * float(printed) < fastest <= float(printed)


def test_the_pose_answer_bounds_speeds_under_another_v(arrays: Arrays) -> None:
    """With P != I speeds have a part of second order: of this array 48.7 where sqrt(V(g)) alone is 46.2."""
    check = check_theorem4(arrays.cocircular(10, (1, Fraction(1, 2))), beside=False)
    feedback = check.feedback
    assert isinstance(feedback, FeedbackResult)
    assert feedback.region is not None
    bound, error = wheel_speed(feedback, check.scene), certified_error(feedback)
    assert bound is not None
    assert error is not None
    level = float(feedback.region.level)
    fastest = max(fastest_at_level(law_of(check), feedback.lyapunov.value, level))
    assert 0.5 * float(bound.at_error(error)) < fastest <= float(bound.at_error(error))


def fastest_at_level(law: LawResult, value: Callable[[Any], float], level: float) -> list[float]:
    """The speed of the fastest wheel at random poses with V at a level, c in the regions of the law."""
    rng, speeds = np.random.default_rng(3), list[float]()
    while len(speeds) < 4000:
        pose = rng.normal(size=3)
        pose *= math.sqrt(level / value(pose)) * (1 - 1e-12)
        speeds.append(max(map(abs, law(*pose.tolist()).values())))
    return speeds


@pytest.mark.parametrize("language", LANGUAGES)
def test_the_header_says_what_the_program_is(language: Language) -> None:
    scene = replace(load_scene("four-wheel"), units=Units("mm"))
    check = check_theorem4(scene)
    text = words(law_of(check).program(str(language)))
    for said in (
        "The feedback law of four-wheel, rule nearest, gradient law, certified by the feedback clause",
        "The law: u_i = -k a, u_j = -k b with b = (theta - c.J p_i)/(d_j.J(p_j - p_i))",
        "The checked point is (0, 0)",
        "It is certified from starts with V < 0.25, V = |c|^2 + theta^2.",
        "Units: mm (lengths), mm/s (speeds), s (times).",
        "the error sqrt(V) shrinks at least like exp(-0.1909 k t)",
        "1.00001 k sqrt(V), V = |c|^2 + theta^2 (the largest of all regions: cell 1)",
        "which is 0.500001 k mm/s on the border of the certified region.",
        "Limits of speed: the scene states none.",
    ):
        assert said in text
    printed = words(law_of(check, LawName.PRINTED).program(str(language)))
    assert "printed law, not certified (the feedback clause certifies the gradient law)" in printed
    assert "It is NOT certified" in printed
    assert "It is certified" not in printed


def words(program: str) -> str:
    """Without line breaks and the marks of comments."""
    return " ".join(program.replace(" * ", " ").split())


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_hostile_name_stays_a_comment(language: Language, tmp_path: Path) -> None:
    scene = replace(load_scene("ring-3"), name='*) */ """\n#error\nIF (* /* \\" \u00e9')
    check = check_theorem4(scene)
    if language is Language.C and COMPILER is None:
        pytest.skip("no C compiler (cc, gcc, clang) on this machine")
    (found,) = run(law_of(check), language, tmp_path, np.array([[0.01, 0.02, 0.03]]), 1.0)
    assert_alike(found, law_of(check)(0.01, 0.02, 0.03))


def test_the_program_needs_nothing_but_python() -> None:
    program = law_of(checked("four-wheel", "nearest")).program()
    imported = [node for node in ast.walk(ast.parse(program)) if isinstance(node, ast.Import | ast.ImportFrom)]
    assert [alias.name for node in imported for alias in node.names] == ["math"]
    assert "certified from starts with V < 0.25" in program
    names: dict[str, Callable[..., Speeds]] = {}
    exec(program, names)  # noqa: S102 (a law that the test has just written)
    with pytest.raises(ValueError, match="required a place in a region of the law"):
        names["speeds"](9.0, 0.0, 0.0)


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


def test_outside_of_all_regions_nothing_runs() -> None:
    law = law_of(checked("four-wheel", "nearest"))
    with pytest.raises(ValueError, match="required a place in a region"):
        law(9.0, 0.0, 0.0)
    block = FunctionBlock(law.program("st"))
    block(x=0.1, y=0.2, theta=0.3)
    block(x=9.0, y=0.0, theta=0.0)
    assert block["region"] == [0]
    assert block["speeds"] == [0, 0, 0, 0]


def test_limits_can_be_set_in_the_program() -> None:
    """All speeds by one factor, so that the body takes the same way."""
    block = FunctionBlock(law_of(checked("four-wheel", "nearest")).program("st"))
    block(x=0.1, y=0.02, theta=0.3)
    free = block["speeds"]
    block(limits=[0.05, 0.0, 0.0, 0.1])
    factor = min(0.05 / abs(free[0]), 0.1 / abs(free[3]))
    assert factor < 1
    assert block["speeds"] == pytest.approx([factor * speed for speed in free], rel=1e-12)


# ---- the command, Python, and the interpreter itself ---------------------------------------------


@cache
def python_check(name: str) -> Any:
    """As a user of Python has it."""
    return ns.load(name).check()


def test_the_command_writes_every_language(invoke: Invoke, tmp_path: Path) -> None:
    for ending in (".py", ".c", ".st"):
        done = invoke("check", "four-wheel", "--law", f"law{ending}")
        assert (done.status, done.err) == (0, f"law{ending}: the certified law of 4 wheels\n")
        program = python_check("four-wheel").law().program(ending.removeprefix("."))
        assert (tmp_path / f"law{ending}").read_text(encoding="utf-8") == program
    assert invoke("check", "four-wheel", "--law", "printed.st", "--law-name", "printed").status == 0
    assert "NOT certified" in (tmp_path / "printed.st").read_text(encoding="utf-8")


def test_no_line_ends_within_the_name_of_a_wheel() -> None:
    result = ns.load("grid-4x4").check(rule="box")
    assert isinstance(result, ns.CheckResult)
    program = result.law().program("st")
    named = re.findall(r"\[\d+\] wheel \d+(?:,| \*\))", program)
    assert len(named) == 16


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_answers_are_shown_beside_a_law_that_there_is_not(invoke: Invoke) -> None:
    done = invoke("check", "four-wheel-side", "--law", "a.c", "--json")
    assert (done.status, done.record["answers"]["position"]["verdict"]) == (2, "stays near")


def test_a_law_of_python_can_be_called() -> None:
    law = python_check("four-wheel").law()
    assert law(0.1, 0.02, 0.3, k=2.0) == pytest.approx({w: 2 * u for w, u in law(0.1, 0.02, 0.3).items()})
    assert law.to_dict()["certified"] is True
    with pytest.raises(ValueError, match="required a language among python, c, st"):
        law.program("fortran")
    with pytest.raises(NoLawError, match="required a certified feedback law"):
        python_check("four-wheel-side").law()


@pytest.mark.parametrize(
    ("body", "said"),
    [
        ("a := 1", "required ;"),
        ("b := 1.0;", "not declared"),
        ("k := 1.0;", "may be assigned"),
        ("n := 1.5;", "required an INT"),
        ("a := c[3];", "no place"),
        ("(* (* *) *) a := 1.0;", "a comment within a comment"),
        ("a := 1E5;", "required ;"),
    ],
)
def test_the_interpreter_refuses_what_a_compiler_would(body: str, said: str) -> None:
    head = "FUNCTION_BLOCK F VAR CONSTANT k : LREAL := 1.0; c : ARRAY[1..2] OF LREAL := [1.0, 2.0]; END_VAR "
    text = f"{head}VAR a : LREAL; n : INT; END_VAR {body} END_FUNCTION_BLOCK"
    with pytest.raises(StructuredTextError, match=re.escape(said)):
        FunctionBlock(text)()


def test_the_place_of_each_wheel_in_the_array_of_speeds_is_said(tmp_path: Path) -> None:
    """Of a body on wheels 2, 3, 5 and 6 of nine: Structured Text counts from 1, C from 0."""
    lines = "".join(f"W{k + 1},{x},{y}\n" for k, (y, x) in enumerate((y, x) for y in (0, 1, 2) for x in (0, 1, 2)))
    (tmp_path / "wheels.csv").write_text(f"name,x,y\n{lines}", encoding="utf-8")
    scene = tmp_path / "table.toml"
    scene.write_text(OUTLINED, encoding="utf-8")
    law = law_of(check_theorem4(load_scene(scene)))
    text = " ".join(law.program("st").split())
    assert "[1] wheel 2 W2, [2] wheel 3 W3, [3] wheel 5 W5, [4] wheel 6 W6" in text
    assert "[0] wheel 2 W2, [1] wheel 3 W3" in law.program("c")
    head = text.split("FUNCTION_BLOCK")[0]
    assert "speed of every rim, each in its place, named beside the result" in head
    assert "the body on wheels W2, W3, W5, W6 and no others: they carry it for certain within 0.3 m of the" in head
    assert not re.search(r"\d/\d", head)
