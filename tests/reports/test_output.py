"""What commands write and read: standard output, files, names of long steps, tables outside the scene's folder."""

from __future__ import annotations

import ast
import json
import os
import re
import subprocess
import sys
import threading
import time
import xml.etree.ElementTree as ET
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from types import SimpleNamespace
from typing import IO, TypeAlias

import pytest

import nonsmooth as ns
from nonsmooth.reports.checks.check import CHECK
from nonsmooth.reports.cli import app
from nonsmooth.reports.derivations.derivation import DERIVE
from nonsmooth.reports.designs.design import DESIGN
from nonsmooth.reports.output import progress as progress_module
from nonsmooth.reports.output.console import BAD_INPUT, run
from nonsmooth.reports.output.files import OutputError, write_whole
from nonsmooth.reports.output.progress import CLEAR_LINE, end_progress, steps
from nonsmooth.reports.output.refusals import RefusedError
from nonsmooth.reports.simulations.simulate import SIMULATE
from nonsmooth.reports.sweeps.sweep_study import SWEEP
from nonsmooth.symbolic.messages.under_way import listening, part_of, parts, tell, tell_count
from nonsmooth.symbolic.numbers.plane import Vector
from tests.conftest import Arrays
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

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
QUESTION = "asked of CVXPY: "
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


def run_alone(environment: dict[str, str], *arguments: str) -> subprocess.CompletedProcess[str]:
    line = [sys.executable, *arguments]
    return subprocess.run(line, capture_output=True, text=True, timeout=300, check=False, env=environment)


def looked_at(environment: dict[str, str]) -> str:
    path = Path(environment["LOOKED_AT"])
    return path.read_text(encoding="utf-8") if path.exists() else ""


@thorough  # the small one: test_what_cvxpy_requires_is_there..., which reads what they print too
def test_the_packages_are_loud(loud: dict[str, str]) -> None:
    """The test itself: CVXPY, imported plainly, looks at them."""
    done = run_alone(loud, "-c", "import cvxpy")
    assert LICENCE in done.stdout
    assert "gurobipy" in looked_at(loud)


@pytest.fixture(scope="module")
def array_check(tmp_path_factory: pytest.TempPathFactory, arrays: Arrays) -> Loud:
    """What one process prints: the record of an array whose quadratic V is found by a cone program; then which solvers
    CVXPY found, who imports, and whether a loud package was looked at; then what a loud package prints.

    One process for all of it, since it is the import of CVXPY that takes long.
    """
    folder = tmp_path_factory.mktemp("loud")
    environment, scene = loud_environment(folder), arrays.cocircular(3)
    wheels = [
        f'[[wheel]]\nposition = {pair(w.position)}\nheading = {pair(w.direction)}\nspeed = "{w.speed}"\n'
        f'mu_roll = "{w.friction.roll}"\nmu_side = "{w.friction.side}"\n'
        for w in scene.wheels
    ]
    path = folder / "array.toml"
    path.write_text("\n".join([*wheels, f'[check]\nradius = "{scene.check.radius}"\n']), encoding="utf-8")
    code = (
        "from nonsmooth.reports.cli import app; from nonsmooth.reports.output.console import run; "
        "from nonsmooth.proofs.answers import answers; answers._destinations_of = lambda check: None; "
        "answers.other_rules = lambda scene: (); "
        f"run(app, ['check', {str(path)!r}, '--json']); "
        "import builtins, json, os; from cvxpy.reductions.solvers import defines; "
        "looked_at = os.path.exists(os.environ['LOOKED_AT']); "
        "asked = [defines.INSTALLED_SOLVERS, builtins.__import__.__name__, looked_at]; "
        "print('" + QUESTION + "' + json.dumps(asked), flush=True); import gurobipy"
    )
    return run_alone(environment, "-c", code).stdout.partition(QUESTION)


def test_json_is_all_that_check_prints(array_check: Loud) -> None:
    printed, _, asked = array_check
    *_, looked_at = json.loads(asked.splitlines()[0])
    assert json.loads(printed)["translation"]["quadratic"] is not None
    assert not looked_at


def pair(vector: Vector) -> str:
    return f'["{vector[0]}", "{vector[1]}"]'


def test_what_cvxpy_requires_is_there_and_other_modules_import_what_they_like(array_check: Loud) -> None:
    """Our own way in finds the same solvers as the plain import of an environment without optional ones."""
    first, *printed_by_others = array_check[2].splitlines()
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


# ---- Equal input gives equal files, which are whole, and no others ---------------------------------

DRAWN = [
    ("partition ring-5", ".svg"),
    ("simulate ring-3 --from 0.05,0.02,0.1 --until 0.2", ".gif"),
    ("partition ring-5", ".png"),
    ("simulate conveyor-3 --grid 7 --until 0.3", ".png"),
    ("partition ring-5", ".pdf"),
    ("vehicle husky-a200", ".svg"),
    ("vehicle mecanum-base", ".svg"),
    ("simulate four-wheel-side --grid 3 --until 0.3", ".svg"),  # starts that never arrive, or are not unique
    ("simulate saddle --grid 7 --until 0.3", ".pdf"),  # more ends than there are colors
    ("simulate ring-3 --from 0.05,0.02,0.1 --until 0.2", ".html"),
    ("simulate four-wheel --from 0.1,0.15,0.3 --feedback --gain 3 --until 1", ".svg"),
    ("stress line-of-equilibria", ".svg"),
    ("stress line-of-equilibria", ".pdf"),
]
BEGINNINGS = {".svg": b"<?xml", ".png": b"\x89PNG", ".pdf": b"%PDF", ".gif": b"GIF8", ".html": b"<!DOCTYPE html>"}


@pytest.mark.parametrize(("line", "suffix"), keep(3, DRAWN))
def test_equal_input_gives_equal_files(
    invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, line: str, suffix: str
) -> None:
    monkeypatch.setattr("nonsmooth.reports.animation.film.MOST_FRAMES", 5)
    file = tmp_path / f"drawn{suffix}"
    assert invoke(*line.split(), "-o", file.name).status == 0
    first = file.read_bytes()
    assert invoke(*line.split(), "-o", file.name).status == 0
    assert file.read_bytes() == first
    assert [entry.name for entry in tmp_path.iterdir()] == [file.name]
    assert first.startswith(BEGINNINGS[suffix])
    assert len(first) > 5_000
    if suffix == ".svg":
        assert ET.fromstring(first).tag.endswith("svg")


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


# ---- Long steps are named on a terminal, on standard error alone, and leave nothing behind -------

HASTY = (
    "from nonsmooth.reports import cli; from nonsmooth.reports.output import progress; "
    "progress.PATIENCE = 0.0; cli.main()"
)


class Shown:
    """What is written to a pseudo-terminal, read as it comes."""

    def __init__(self, leader: int) -> None:
        self._blocks: list[bytes] = []
        self._thread = threading.Thread(target=self._read, args=(leader,), daemon=True)
        self._thread.start()

    def _read(self, leader: int) -> None:
        with suppress(OSError):  # Linux: the other side is closed
            while block := os.read(leader, 100_000):
                self._blocks.append(block)

    @property
    def text(self) -> str:
        """All so far."""
        return b"".join(self._blocks).decode()

    def wait_for(self, said: str) -> None:
        """Wait until it is written, however busy the machine is."""
        end = time.monotonic() + 60
        while said not in self.text and time.monotonic() < end:
            time.sleep(0.005)
        assert said in self.text

    def wait_for_end(self) -> None:
        """Wait until the other side is closed."""
        self._thread.join()


@contextmanager
def terminal(
    monkeypatch: pytest.MonkeyPatch, patience: float = 0.0, clock: Callable[[], float] = lambda: 0.0
) -> Iterator[tuple[IO[str], Shown]]:
    """A pseudo-terminal as standard error, and what is written to it, by a clock that stands still unless given."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(progress_module, "PATIENCE", patience)
    monkeypatch.setattr(progress_module, "TICK", 0.01)
    monkeypatch.setattr(progress_module, "time", SimpleNamespace(monotonic=clock))
    leader, follower = os.openpty()
    shown = Shown(leader)
    with os.fdopen(follower, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        yield stream, shown
    shown.wait_for_end()
    os.close(leader)


def on_terminal(monkeypatch: pytest.MonkeyPatch, patience: float) -> str:
    """What two steps leave there, cleared at the end."""
    with terminal(monkeypatch, patience) as (stream, shown):
        with steps("count wheels") as announce:
            announce("count cells")
        stream.write("end")
    return shown.text


def test_steps_are_named_in_turn_and_the_line_is_cleared(monkeypatch: pytest.MonkeyPatch) -> None:
    shown = on_terminal(monkeypatch, patience=0.0)
    assert shown.index("count wheels (0 s)") < shown.index("count cells (0 s)")
    assert shown.endswith(f"{CLEAR_LINE}end")


def test_short_work_shows_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    assert on_terminal(monkeypatch, patience=60.0) == "end"


def test_seconds_are_seen_where_the_step_is_wider_than_the_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "14")
    shown = on_terminal(monkeypatch, patience=0.0)
    assert f"{CLEAR_LINE}count w (0 s)" in shown
    assert f"{CLEAR_LINE}count c (0 s)" in shown


def test_an_error_ends_the_line_too(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a step that has been shown when it fails."""
    with terminal(monkeypatch) as (_, shown), suppress(KeyError), steps("count wheels"):
        shown.wait_for("count wheels")
        raise KeyError
    assert shown.text.endswith(CLEAR_LINE)


def test_what_the_work_tells_is_shown_and_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    """From any depth, within a step inside another; the outer step is named again afterwards."""
    with terminal(monkeypatch) as (stream, shown), steps("simulate"):
        with steps("path"):
            for count in (1, 2):
                tell_count(count, 2, "starts")
                shown.wait_for(f"path: {count} of 2 starts (0 s)")
        tell("film")
        shown.wait_for("simulate: film (0 s)")
        end_progress()
        stream.write("output")
        tell("nothing more")
        time.sleep(0.1)
    places = [shown.text.index(said) for said in ("path: 1 of 2 starts (0 s)", "path: 2 of 2", "simulate: film (0 s)")]
    assert places == sorted(places)
    assert shown.text.endswith(f"{CLEAR_LINE}output")


def test_only_the_innermost_listener_hears() -> None:
    outer: list[str] = []
    inner: list[str] = []
    tell("nobody hears")
    with listening(outer.append):
        with listening(inner.append):
            tell("first")
        tell("second")
    tell("nobody hears")
    assert (outer, inner) == (["second"], ["first"])


def test_what_is_told_of_a_part_comes_after_how_many_there_are() -> None:
    told: list[str] = []
    with listening(told.append):
        with part_of(3, 21, "paths"):
            tell("t = 1 of 2")
        tell("all")
    with part_of(0, 1, "nobody hears"):
        tell("nor this")
    assert told == ["3 of 21 paths", "3 of 21 paths, t = 1 of 2", "all"]


def test_a_count_stays_while_parts_tell_more() -> None:
    told: list[str] = []
    with listening(told.append), parts() as say:
        tell("first")
        say("2 of 6")
        tell("rings")
        say("3 of 6")
    assert told == ["first", "2 of 6", "2 of 6, rings", "3 of 6"]


BUILT = """
name = "built table"
friction = { mu_roll = 0.6, mu_side = 0.3 }
contact = { rule = "ellipse" }
grid = { rows = 2, columns = 2, pitch = 200 }
field = { kind = "radial", speed = 100 }
body = { shape = "rectangle", width = 240, height = 230 }
tolerance = { position = 1, heading = "1 deg" }
"""


def test_headings_and_tolerances_are_named_while_they_are_decided(tmp_path: Path) -> None:
    """Each heading and each multiple of the tolerances, and how many there are, where that is known."""
    (tmp_path / "built.toml").write_text(BUILT, encoding="utf-8")
    array, told = ns.load(tmp_path / "built.toml"), list[str]()
    assert isinstance(array, ns.Array)
    found = array.check()
    with listening(told.append):
        assert found.answers.robust is not None
    expected = (
        "headings of rest",
        "1 of 16 intervals of headings",
        "1 of 16 headings with a wheel under the edge",
        "tolerances",
        "arrays within 1 times the tolerances",
        "1 of 2 tolerances, without that of heading",
    )
    places = [told.index(what) for what in expected]
    assert places == sorted(places)


LOGGED = """
import sys, time
from nonsmooth.reports import cli
from nonsmooth.reports.output import progress
from nonsmooth.reports.simulations.simulate import SIMULATE
from nonsmooth.symbolic.messages.under_way import tell
progress.LOGGED = 0.1
run = type(SIMULATE).run
def late(self, scene, options):
    for count in range(4):
        tell(f"part {count}")
        time.sleep(0.15)
    return run(self, scene, options)
type(SIMULATE).run = late
sys.exit(cli.main())
"""


@few(1)
@pytest.mark.parametrize("terminal", ["xterm", "dumb"])
def test_a_log_has_whole_lines_that_move(terminal: str) -> None:
    """Where standard error is a pipe, each ends in a line feed, and none clears another."""
    command = [sys.executable, "-c", LOGGED, "simulate", "four-wheel", "--from", "0,0,0", "--until", "0.1"]
    environment = {**os.environ, "TERM": terminal, "COLUMNS": "14"}  # lines of a file are not cut
    found = subprocess.run(command, capture_output=True, text=True, env=environment, check=True)
    lines = found.stderr.splitlines()
    assert len(lines) >= 3
    assert all(re.fullmatch(r"simulate(: .+)? \(\d+ s\)", line) for line in lines)
    assert len({line for line in lines if "part" in line}) >= 3
    assert CLEAR_LINE not in found.stderr


@few(1)
@pytest.mark.parametrize(
    ("arguments", "named"),
    [
        (["check", "four-wheel", "--rule", "box"], ["feedback ("]),
        (["check", "four-wheel", "--rule", "all"], ["rule box: feedback (", "rule ellipse: feedback ("]),
        (["partition", "four-wheel", "--rule", "box"], ["cells of rule box ("]),
        (["derive", "four-wheel", "--only", "theorem"], ["feedback ("]),
        (["simulate", "stick-slip", "--from", "2,0", "--orbit"], ["simulate ("]),
    ],
)
def test_commands_name_their_steps_on_a_terminal_only(
    arguments: list[str], named: list[str], monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    leader, follower = os.openpty()
    with subprocess.Popen(
        [sys.executable, "-c", HASTY, *arguments],
        stdout=subprocess.PIPE,
        stderr=follower,
        env={**os.environ, "TERM": "xterm"},
    ) as process:
        os.close(follower)
        shown = terminal_text(leader)
        written = process.stdout.read() if process.stdout is not None else b""
    os.close(leader)
    assert all(step in shown for step in named)
    assert shown.endswith(CLEAR_LINE)
    monkeypatch.setattr(progress_module, "PATIENCE", 0.0)
    run(app, arguments)  # here, where standard error is no terminal
    assert capfd.readouterr() == (written.decode(), "")


ASKED = {
    "check": ["four-wheel"],
    "derive": ["four-wheel"],
    "simulate": ["four-wheel", "--from", "0,0,0"],
    "sweep": ["four-wheel", "--vary", "friction.mu_side=1/2,1/4"],
    "design": ["saddle"],
}


@pytest.mark.parametrize("command", ASKED)
def test_every_command_that_can_take_long_shows_moving_seconds(command: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a study that takes two seconds by a clock of the test, and says nothing of itself."""
    study = {"check": CHECK, "derive": DERIVE, "simulate": SIMULATE, "sweep": SWEEP, "design": DESIGN}[command]
    clock = [0.0]
    with terminal(monkeypatch, clock=lambda: clock[0]) as (_, shown):

        def slow(self: object, scene: object, options: object) -> None:
            for second in range(3):
                clock[0] = second
                shown.wait_for(f"{command} ({second} s)")
            raise RefusedError("enough")

        monkeypatch.setattr(type(study), "run", slow)
        assert run(app, [command, *ASKED[command]]) == 2
    assert "enough" in shown.text.rpartition(CLEAR_LINE)[2]


def terminal_text(leader: int) -> str:
    """All that is written to a pseudo-terminal until its other side is closed."""
    shown = b""
    while True:
        try:
            block = os.read(leader, 100_000)
        except OSError:  # Linux: the other side is closed
            return shown.decode()
        if not block:
            return shown.decode()
        shown += block
