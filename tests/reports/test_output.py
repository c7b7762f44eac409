"""What commands write and read: standard output, files of their own, tables outside the scene's folder."""

from __future__ import annotations

import ast
import json
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TypeAlias

import pytest

from nonsmooth.reports.output.console import BAD_INPUT
from nonsmooth.reports.output.files import OutputError, write_whole
from nonsmooth.symbolic.numbers.plane import Vector
from tests.conftest import Arrays
from tests.reports.conftest import Invoke
from tests.thorough import thorough

# ---- Nothing but the product writes on standard output, whatever else is installed ---------------

ROOT = Path(__file__).resolve().parents[2]
# Every package that a solver interface of CVXPY 1.9 imports and that CVXPY does not require.
OPTIONAL = """
coptpy cosmopy cplex cupy cuopt cvxopt cyipopt cylp daqp diffcp ecos google gurobipy jax juliacall knitro moreau mosek
mpax naginterfaces ortools piqp proxsuite pyscipopt qoco qpalm sdpap unopy xpress
""".split()  # noqa: SIM905  (a list of one name to a line says no more)
LICENCE = "Restricted license - for non-production use only"
LOUD = f"""
import os, sys
print("{LICENCE}")
sys.stdout.flush()
os.write(1, b"{LICENCE}\\n")
with open(os.environ["LOOKED_AT"], "a") as file:
    file.write(__name__ + "\\n")
class Model: pass
"""
ASKED = "asked of CVXPY: "
Loud: TypeAlias = tuple[str, str, str]  # what a loud process prints before ASKED, this, and what it prints after


@pytest.fixture
def loud(tmp_path: Path) -> dict[str, str]:
    """An environment in which every optional solver prints a licence text when it is imported."""
    return loud_environment(tmp_path)


def loud_environment(folder: Path) -> dict[str, str]:
    packages = folder / "packages"
    packages.mkdir()
    for name in OPTIONAL:
        (packages / f"{name}.py").write_text(LOUD, encoding="utf-8")
    path = os.pathsep.join([str(packages), *filter(None, [os.environ.get("PYTHONPATH")])])
    return {**os.environ, "PYTHONPATH": path, "LOOKED_AT": str(folder / "looked-at")}


def run(environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, *arguments]
    return subprocess.run(line, capture_output=True, text=True, timeout=300, check=False, env=environment)


def looked_at(environment: dict[str, str]) -> str:
    path = Path(environment["LOOKED_AT"])
    return path.read_text(encoding="utf-8") if path.exists() else ""


@thorough  # the small one: test_what_cvxpy_requires_is_there..., which reads what they print too
def test_the_packages_are_loud(loud: dict[str, str]) -> None:
    """The test itself: CVXPY, imported plainly, looks at them."""
    done = run(loud, "-c", "import cvxpy")
    assert LICENCE in done.stdout
    assert "gurobipy" in looked_at(loud)


@pytest.fixture(scope="module")
def flower(tmp_path_factory: pytest.TempPathFactory) -> Loud:
    """What one process prints: the record of a plain system whose V is found by a semidefinite program; then which
    solvers CVXPY found, who imports, and whether a loud package was looked at; then what a loud package prints.

    One process for all of it, since it is the import of CVXPY that takes long.
    """
    environment = loud_environment(tmp_path_factory.mktemp("loud"))
    code = (
        "from nonsmooth.reports.cli import app; from nonsmooth.reports.output.console import run; "
        "run(app, ['check', 'flower', '--json']); "
        "import builtins, json, os; from cvxpy.reductions.solvers import defines; "
        "looked_at = os.path.exists(os.environ['LOOKED_AT']); "
        "asked = [defines.INSTALLED_SOLVERS, builtins.__import__.__name__, looked_at]; "
        "print('" + ASKED + "' + json.dumps(asked), flush=True); import gurobipy"
    )
    return run(environment, "-c", code).stdout.partition(ASKED)


def test_json_is_all_that_check_prints(flower: Loud) -> None:
    """Of a plain system whose V is found by a semidefinite program."""
    printed, _, asked = flower
    *_, looked_at = json.loads(asked.splitlines()[0])
    assert json.loads(printed)["scene"] == "flower"
    assert not looked_at


@thorough
def test_json_is_all_that_check_of_an_array_prints(loud: dict[str, str], arrays: Arrays, tmp_path: Path) -> None:
    """Of an array whose quadratic V is found by a cone program."""
    scene = arrays.cocircular(3)
    wheels = [
        f'[[wheel]]\nposition = {pair(w.position)}\nheading = {pair(w.direction)}\nspeed = "{w.speed}"\n'
        f'mu_roll = "{w.friction.roll}"\nmu_side = "{w.friction.side}"\n'
        for w in scene.wheels
    ]
    path = tmp_path / "array.toml"
    path.write_text("\n".join([*wheels, f'[check]\nradius = "{scene.check.radius}"\n']), encoding="utf-8")
    done = run(loud, "-m", "nonsmooth.reports.cli", "check", str(path), "--json")
    assert json.loads(done.stdout)["translation"]["quadratic"] is not None
    assert looked_at(loud) == ""


def pair(vector: Vector) -> str:
    return f'["{vector[0]}", "{vector[1]}"]'


def test_what_cvxpy_requires_is_there_and_other_modules_import_what_they_like(flower: Loud) -> None:
    """Our own way in finds the same solvers as the plain import of an environment without optional ones."""
    first, *printed_by_others = flower[2].splitlines()
    solvers, importer, _ = json.loads(first)
    assert {"CLARABEL", "SCS", "OSQP"} <= set(solvers)
    assert not {"GUROBI", "MOSEK", "CPLEX"} & set(solvers)
    assert importer == "__import__"  # the interpreter's own is back
    assert printed_by_others == [LICENCE, LICENCE]


def imports_of_cvxpy(path: Path) -> Iterator[tuple[str, list[str]]]:
    """Each function that imports CVXPY, with its statements before that."""
    text = path.read_text(encoding="utf-8")
    tree = ast.parse(text if "cvxpy" in text else "")
    for function in (node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)):
        statements = [ast.unparse(statement) for statement in function.body]
        firsts = [k for k, text in enumerate(statements) if text.startswith(("import cvxpy", "from cvxpy"))]
        if firsts:
            yield f"{path.name}: {function.name}", statements[: firsts[0]]


def test_every_import_of_cvxpy_goes_through_ours() -> None:
    found = 0
    for package in ("symbolic", "analysis", "proofs", "reports"):
        for path in sorted((ROOT / package).rglob("*.py")):
            for place, before in imports_of_cvxpy(path):
                assert "load_cvxpy()" in before, place
                found += 1
    assert found >= 2  # where V and P are searched


# ---- Output files: a temporary file that nobody can foresee, never through a link ----------------


def test_a_planted_link_is_not_followed(tmp_path: Path) -> None:
    """The name was foreseeable: a link planted there made the program overwrite its target."""
    victim = tmp_path / "victim"
    victim.write_text("untouched", encoding="utf-8")
    (tmp_path / f".nonsmooth-{os.getpid()}.tmp").symlink_to(victim)
    write_whole(tmp_path / "out.json", b"{}")
    assert victim.read_text(encoding="utf-8") == "untouched"
    assert (tmp_path / "out.json").read_bytes() == b"{}"


@pytest.mark.parametrize("dangling", [True, False])
def test_a_link_at_the_very_name_is_not_followed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, dangling: bool
) -> None:
    victim = tmp_path / "victim"
    if not dangling:
        victim.write_text("untouched", encoding="utf-8")
    names = iter(["taken", "free"])
    monkeypatch.setattr("secrets.token_hex", lambda _: next(names))
    (tmp_path / ".nonsmooth-taken.tmp").symlink_to(victim)
    write_whole(tmp_path / "out.json", b"{}")
    assert victim.exists() is not dangling
    assert dangling or victim.read_text(encoding="utf-8") == "untouched"
    assert (tmp_path / "out.json").read_bytes() == b"{}"
    assert (tmp_path / ".nonsmooth-taken.tmp").is_symlink()


def test_names_that_are_all_taken_are_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("secrets.token_hex", lambda _: "taken")
    (tmp_path / ".nonsmooth-taken.tmp").write_text("somebody else's", encoding="utf-8")
    with pytest.raises(OutputError, match="required a file that can be written"):
        write_whole(tmp_path / "out.json", b"{}")
    assert (tmp_path / ".nonsmooth-taken.tmp").read_text(encoding="utf-8") == "somebody else's"
    assert not (tmp_path / "out.json").exists()


def test_new_files_follow_the_umask_and_old_ones_keep_their_mode(tmp_path: Path) -> None:
    before = os.umask(0o027)
    try:
        write_whole(tmp_path / "new", b"1")
        (tmp_path / "old").write_bytes(b"0")
        (tmp_path / "old").chmod(0o604)
        write_whole(tmp_path / "old", b"1")
    finally:
        os.umask(before)
    assert (tmp_path / "new").stat().st_mode & 0o777 == 0o640
    assert (tmp_path / "old").stat().st_mode & 0o777 == 0o604
    assert sorted(entry.name for entry in tmp_path.iterdir()) == ["new", "old"]


# ---- ``--allow-outside``: every command that reads a scene keeps its table of wheels in the scene's folder without
# it.

SCENE = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[wheels]\nfile = "../table.csv"\n[check]\nradius = "1/10"\n'
COMMANDS = {
    "check": (),
    "partition": (),
    "derive": ("--only", "verdict"),
    "simulate": ("--from", "0,0,0", "--until", "0.1"),
    "precision": ("--study", "derivation", "--runs", "1", "--time-limit", "0.1"),
    "stress": (),
    "audit": ("--lyapunov", "x**2 + y**2"),
}


@pytest.fixture
def scene(tmp_path: Path) -> str:
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "my.toml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "table.csv").write_text("x,y\n1,1\n-1,1\n-1,-1\n1,-1\n", encoding="utf-8")
    return "folder/my.toml"


@pytest.mark.parametrize("command", COMMANDS)
def test_a_table_outside_is_refused_in_one_line(invoke: Invoke, scene: str, command: str) -> None:
    outcome = invoke(command, scene, *COMMANDS[command])
    assert (outcome.status, outcome.out) == (BAD_INPUT, "")
    assert "my.toml: wheels.file ../table.csv: required a file in the scene's folder" in outcome.err
    assert outcome.err.count("\n") == 1


@pytest.mark.parametrize("command", [name for name in COMMANDS if name != "stress"])
def test_the_option_allows_it(invoke: Invoke, scene: str, command: str) -> None:
    outcome = invoke(command, scene, *COMMANDS[command], "--allow-outside")
    assert outcome.status in (0, 1, 3)
    assert outcome.out


def test_a_report_names_the_option_that_it_needs(invoke: Invoke, scene: str) -> None:
    assert "--allow-outside" in invoke("derive", scene, "--only", "versions", "--allow-outside").out
