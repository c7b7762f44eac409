"""The command line: JSON contract, exit statuses, bad input in one line, and manners in a pipeline."""

from __future__ import annotations

import json
import math
import os
import signal
import subprocess
import sys
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from pathlib import Path
from typing import Any
from unittest.mock import patch

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.analysis.trajectories.result import LyapunovViolationError, TrajectoryError
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import BAD_INPUT, run
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.formulas.expression import parse
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from tests.conftest import DESTINATIONS, OTHERS
from tests.reports.conftest import Invoke
from tests.thorough import examples, few

COLUMNS = 80  # width of the output where there is no terminal
CHECK_KEYS = [
    "schema", "scene", "wheels", "rule", "radius", "length", "exact", "contact_set", "answers", "robust",
    "contact_states", "equilibrium", "translation", "rotation", "feedback", "theorem4", "continuum", "failures",
    "notes", "skipped", "seconds",
]  # fmt: skip


def command(*arguments: str, **options: Any) -> subprocess.CompletedProcess[str]:
    """Run the real program in a process of its own."""
    line = [sys.executable, "-m", "nonsmooth.reports.cli", *arguments]
    return subprocess.run(line, capture_output=True, text=True, timeout=120, check=False, **options)


# ---- check: the contract -------------------------------------------------------------------------


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_drift_weights_add_up(invoke: Invoke) -> None:
    """Independent check of the rotation clause from its own record: weights one, velocity zero, rate attained."""
    rotation = invoke("check", "four-wheel", "--json").record["rotation"]
    for end, rate in zip(("lowest", "highest"), rotation["exact"]["drift"], strict=True):
        terms = [entry["exact"] for entry in rotation["weights"][end]]
        field = NumberField()
        weights = [number(term["weight"], field) for term in terms]
        twists = [[number(text, field) for text in term["twist"]] for term in terms]
        assert all(weight.sign() >= 0 for weight in weights)
        assert sum(weights) == 1
        sums = [sum(w * twist[k] for w, twist in zip(weights, twists, strict=True)) for k in range(3)]
        assert sums == [0, 0, number(rate, field)]


def number(text: str, field: NumberField) -> Number:
    return parse(text).value(field)


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("name", ["outward", "saddle"])
def test_witness_against_translation(invoke: Invoke, name: str) -> None:
    """At the witness some cell's velocity has the claimed positive product: 2 c . v from the cell list alone."""
    outcome = invoke("check", name, "--json")
    translation = outcome.record["translation"]
    witness = translation["witness"]
    assert (outcome.status, outcome.record["theorem4"]["verdict"]) == (1, "fails")
    assert translation["verdict"] == "unstable"
    assert witness["value"] > 0
    cells = invoke("partition", name, "--json").record["cells"]
    field = NumberField()
    x, y = (number(text, field) for text in witness["exact"]["point"])
    rates = []
    for cell in cells:
        exact = cell["exact"]
        if witness["exact"]["point"] in exact["polygon"]:
            vx, vy, _ = (number(text, field) for text in exact["twist"])
            rates.append(2 * (x * vx + y * vy))
    assert number(witness["exact"]["value"], field) in rates


@few(4)
@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("name", builtin_scenes())
def test_every_scene_has_a_verdict(invoke: Invoke, name: str) -> None:
    outcome = invoke("check", name, "--json")
    assert list(outcome.record) == CHECK_KEYS
    expected = {"holds": 0, "fails": 1, "hypotheses not met": 1, "undecided": 3}
    assert outcome.status == expected[outcome.record["theorem4"]["verdict"]]


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "grid-4x4", "off-center"])
def test_pruning_changes_no_verdict(invoke: Invoke, name: str) -> None:
    pruned, full = (invoke("check", name, "--json", *option).record for option in ((), ("--no-prune",)))
    for clause in ("equilibrium", "translation", "rotation", "theorem4"):
        assert pruned[clause] == full[clause]


@pytest.mark.parametrize("places", [((1, 0), (-1, 0)), ((1, 0), (-1, 0), (2, 0))])
def test_wheels_on_one_line_have_no_support_polygon(
    invoke: Invoke, tmp_path: Path, places: tuple[tuple[int, int], ...]
) -> None:
    """The body tips, which is said; there is no distance from a border that does not exist."""
    wheels = "".join(f"[[wheel]]\nposition = {list(place)}\n" for place in places)
    (tmp_path / "line.toml").write_text(f'[friction]\nmu_roll = 1\nmu_side = "1/2"\n{wheels}', encoding="utf-8")
    support = invoke("check", "line.toml", "--json").record["translation"]["support"]
    assert support["distance"] is None
    assert "the body tips at c*" in support["note"]
    assert "the body tips at c*" in " ".join(invoke("check", "line.toml").out.split())


# ---- what people see -----------------------------------------------------------------------------


SHOWN = ["check saddle", "partition ring-8", "scenes", "vehicle husky-a200", "vehicle tracked-base --rule nearest"]


@pytest.mark.parametrize("line", [*SHOWN, "vehicle swerve-base"])
def test_views_fit_80_columns_without_colors(invoke: Invoke, monkeypatch: pytest.MonkeyPatch, line: str) -> None:
    monkeypatch.setenv("COLUMNS", str(COLUMNS))
    out = invoke(*line.split()).out
    assert max(len(line) for line in out.splitlines()) <= COLUMNS
    assert "\x1b" not in out


@few(1)
@pytest.mark.parametrize(
    ("typed", "offered"), [("four", ["four-wheel", "four-wheel-side"]), ("my", ["my.toml"]), ("nothing", [])]
)
def test_the_shell_completes_scenes(tmp_path: Path, typed: str, offered: list[str]) -> None:
    (tmp_path / "my.toml").touch()
    asked = {"_NONSMOOTH_COMPLETE": "complete_bash", "COMP_WORDS": f"nonsmooth check {typed}", "COMP_CWORD": "2"}
    program = Path(sys.executable).with_name("nonsmooth")
    done = subprocess.run(
        [program], env={**os.environ, **asked}, cwd=tmp_path, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == offered


# ---- bad input: one line, status 2, nothing written ----------------------------------------------

# Files that cannot be written here; all other refusals are rows of tests/golden/rows.toml.
NOT_WRITTEN = {
    "unwritable": ("/proc/r.md", "/proc/r.md: required a file that"),
    "name too long": ("a" * 300 + ".md", "required a file that can be written"),
    "null character": ("a\0b.md", "required a file that can be written"),
}
# One of every way to be refused: a scene, a value, Typer's own words, an output.
REFUSED = [
    "check four-whel",
    "check four-wheel --radius 0",
    "check four-wheel --colour",
    "derive four-wheel -o no/r.md",
]


@pytest.mark.parametrize("line", ["check four-wheel --rule {}", "simulate four-wheel --from 0,0,0 --method {}", "{}"])
def test_a_line_of_usage_repeats_the_start_of_what_is_long(line: str, invoke: Invoke) -> None:
    refused = invoke(*line.format("7" * 5000).split())
    assert (refused.status, refused.out, refused.err.count("\n")) == (2, "", 1)
    assert "7777..." in refused.err
    assert len(refused.err) < 500


def test_a_start_may_be_given_by_formulas(invoke: Invoke) -> None:
    path = ("simulate", "four-wheel", "--until", "0.1", "--json", "--from")
    formulas = invoke(*path, "1/5, sqrt(2)/4, pi/4").record
    floats = invoke(*path, f"0.2,{2**0.5 / 4!r},{math.pi / 4!r}").record
    assert formulas == floats
    assert formulas["state"][0] == [0.2, 2**0.5 / 4, math.pi / 4]


def test_numbers_of_a_simulation_may_be_formulas(invoke: Invoke) -> None:
    path = ("simulate", "four-wheel", "--from", "0.2,0.1,0", "--json")
    for formulas, floats in (
        (("--until", "1/4"), ("--until", "0.25")),
        (("--feedback", "--gain", "sqrt(4)"), ("--feedback", "--gain", "2")),
        (("--method", "smoothed", "--width", "1/64"), ("--method", "smoothed", "--width", "0.015625")),
    ):
        assert invoke(*path, *formulas).record == invoke(*path, *floats).record
    assert "--until: required" in invoke(*path, "--until", "soon").err


@pytest.mark.parametrize(
    "line",
    [
        "simulate table.toml --from 0,0.01,0 -o wheels.csv",
        "simulate table.toml --from 0,0.01,0 -o ./link.csv",
        "check table.toml --law wheels.csv",
        "sweep table.toml --vary mu_side=0.2:0.4:2 -o wheels.csv",
        "design table.toml --checks 1 -o table.toml",
    ],
)
def test_no_file_that_a_scene_is_read_from_is_written_over(invoke: Invoke, tmp_path: Path, line: str) -> None:
    wheels = tmp_path / "wheels.csv"
    wheels.write_text("x,y\n0.2,0.2\n-0.2,0.2\n-0.2,-0.2\n0.2,-0.2\n", encoding="utf-8")
    scene = 'wheels = { file = "wheels.csv" }\nfriction = { mu_roll = 1, mu_side = 0.5 }\n'
    (tmp_path / "table.toml").write_text(scene, encoding="utf-8")
    (tmp_path / "link.csv").symlink_to(wheels)
    before = wheels.read_bytes()
    outcome = invoke(*line.split())
    assert (outcome.status, outcome.out) == (BAD_INPUT, "")
    assert "required another file than the scene is read from" in outcome.err
    assert wheels.read_bytes() == before
    assert (tmp_path / "table.toml").read_text(encoding="utf-8") == scene


@pytest.mark.parametrize("case", NOT_WRITTEN)
def test_files_that_cannot_be_written_are_refused(invoke: Invoke, tmp_path: Path, case: str) -> None:
    file, message = NOT_WRITTEN[case]
    outcome = invoke("derive", "ring-3", "--only", "verdict", "-o", file)
    assert (outcome.status, outcome.out, outcome.err.count("\n")) == (BAD_INPUT, "", 1)
    assert message in outcome.err
    assert list(tmp_path.iterdir()) == []


@few(1)
@pytest.mark.parametrize("line", REFUSED)
def test_bad_input_through_the_real_program(invoke: Invoke, tmp_path: Path, line: str) -> None:
    """A process of its own says and returns what the command does in this process."""
    done = command(*line.split(), cwd=tmp_path)
    assert (done.returncode, done.stdout, done.stderr) == (BAD_INPUT, "", invoke(*line.split()).err)


def test_a_failed_write_leaves_the_old_file(invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = tmp_path / "r.md"
    path.write_text("old", encoding="utf-8")

    def refuse(self: Path, target: Path) -> Path:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", refuse)
    outcome = invoke("derive", "ring-3", "--only", "verdict", "-o", "r.md")
    assert outcome.status == BAD_INPUT
    assert "no space left" in outcome.err
    assert path.read_text(encoding="utf-8") == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["r.md"]


def test_output_keeps_the_mode_and_follows_links(invoke: Invoke, tmp_path: Path) -> None:
    real, link = tmp_path / "real.md", tmp_path / "link.md"
    real.write_text("old", encoding="utf-8")
    real.chmod(0o600)
    link.symlink_to(real)
    assert invoke("derive", "ring-3", "--only", "verdict", "-o", "link.md").status == 0
    assert link.is_symlink()
    assert real.read_text(encoding="utf-8").startswith("# Derivation report")
    assert real.stat().st_mode & 0o777 == 0o600


# ---- random arguments ----------------------------------------------------------------------------

WORDS = st.sampled_from(
    ["0", "1", "-1/2", "1/3", "sqrt(2)/9", "1e-30", "1e30", "nan", "x", "1/0", "0,0", "1/8,-1/9", ""]
)
OPTIONS = st.lists(st.tuples(st.sampled_from(["--radius", "--at", "--rule"]), WORDS), max_size=2)
COMMANDS = st.sampled_from(["check", "partition", "scenes", "chec"])


@examples(60)
@given(COMMANDS, st.sampled_from(["four-wheel", "ring-3", "off-center", "nope"]), OPTIONS)
def test_any_arguments_end_in_json_or_one_line(name: str, scene: str, options: list[tuple[str, str]]) -> None:
    out, err = StringIO(), StringIO()
    quick = patch(DESTINATIONS, lambda check: None), patch(OTHERS, lambda scene: ())
    with redirect_stdout(out), redirect_stderr(err), quick[0], quick[1]:
        status = run(app, [name, scene, *(part for pair in options for part in pair), "--json"])
    assert status in (0, 1, 2, 3)
    if status == BAD_INPUT:
        assert out.getvalue() == ""
        assert err.getvalue().count("\n") == 1
    else:
        assert err.getvalue() == ""
        json.loads(out.getvalue())


# ---- manners -------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def plain_check() -> subprocess.CompletedProcess[str]:
    """Two checks in a process of its own on an ASCII terminal, which at its end names the heavy libraries it has."""
    code = (
        "import atexit, sys; from nonsmooth.reports.cli import app, main; "
        "from nonsmooth.reports.output.console import run; "
        "heavy = {'sympy', 'scipy', 'cvxpy', 'matplotlib', 'jinja2'}; "
        "atexit.register(lambda: print(sorted(heavy & set(sys.modules)), file=sys.stderr)); "
        "assert run(app, ['check', 'relay-oscillator']) == 0; "
        "sys.argv = ['nonsmooth', 'check', 'four-wheel']; main()"
    )
    environment = {**os.environ, "PYTHONIOENCODING": "ascii", "PYTHONUTF8": "0"}
    line = [sys.executable, "-c", code]
    return subprocess.run(line, capture_output=True, text=True, timeout=60, check=False, env=environment)


def test_check_imports_no_heavy_library(plain_check: subprocess.CompletedProcess[str]) -> None:
    assert plain_check.stderr == "[]\n"


@pytest.mark.skipif(os.name != "posix", reason="a shell and signals")
@pytest.mark.skipif(not hasattr(signal, "SIGPIPE"), reason="a signal of a closed pipe")
def test_a_closed_pipe_ends_quietly() -> None:
    """As ``| head -1`` leaves it behind; here nobody reads from the beginning."""
    reader, writer = os.pipe()
    os.close(reader)
    try:
        line = [sys.executable, "-m", "nonsmooth.reports.cli", "scenes"]
        done = subprocess.run(line, stdout=writer, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    finally:
        os.close(writer)
    assert done.stderr == ""
    assert done.returncode == -signal.SIGPIPE  # as of any command there, and not 1, which says that something is not so


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_bad_input_is_told_by_the_exit_status_where_nothing_can_be_said() -> None:
    """The status was 1, which says that what was asked is not so."""
    with open("/dev/full", "w", encoding="utf-8") as full:
        ended = subprocess.run([sys.executable, "-m", "nonsmooth.reports.cli", "check", "no"], stderr=full, check=False)
    assert ended.returncode == BAD_INPUT


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="a device that is always full")
def test_a_full_disk_is_bad_input_not_a_verdict() -> None:
    with open("/dev/full", "w", encoding="utf-8") as full:
        line = [sys.executable, "-m", "nonsmooth.reports.cli", "check", "ring-3"]
        done = subprocess.run(line, stdout=full, stderr=subprocess.PIPE, text=True, timeout=60, check=False)
    assert done.returncode == BAD_INPUT
    assert done.stderr.count("\n") == 1


def test_an_ascii_terminal_is_served(plain_check: subprocess.CompletedProcess[str]) -> None:
    assert plain_check.returncode == 0
    assert "Theorem 4" in plain_check.stdout
    assert plain_check.stdout.isascii()


def test_an_interrupt_ends_quietly(monkeypatch: pytest.MonkeyPatch, invoke: Invoke) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("nonsmooth.symbolic.files.scene_file.load_any", interrupt)
    assert invoke("check", "four-wheel") == (130, "", "")


def test_a_verdict_that_the_checker_rejects_is_a_fault_and_not_printed(
    monkeypatch: pytest.MonkeyPatch, invoke: Invoke, tmp_path: Path
) -> None:
    def reject(*_: object) -> None:
        raise RejectedError("weights and multipliers of the lowest rate at rest")

    monkeypatch.setattr("nonsmooth.proofs.verified.show_evidence", reject)
    for scene in ("four-wheel", "relay-oscillator-damped"):
        outcome = invoke("check", scene, "--certificate", str(tmp_path / "c.json"))
        assert (outcome.status, outcome.out) == (70, "")
        assert "please report this" in outcome.err
        assert not list(tmp_path.iterdir())


@pytest.mark.parametrize(
    ("error", "status"),
    [
        (TrajectoryError("no Filippov continuation at t = 1"), 2),  # a field outside the integrator's assumptions
        (LyapunovViolationError("cell 1", 1.0, 0.0, 1.0), 70),  # a fault of the program, never hidden as bad input
    ],
)
def test_a_path_that_cannot_go_on_is_refused_and_a_violated_bound_is_a_fault(
    invoke: Invoke, monkeypatch: pytest.MonkeyPatch, error: Exception, status: int
) -> None:
    def give_up(*_: object) -> None:
        raise error

    monkeypatch.setattr("nonsmooth.reports.simulations.paths.follow_cells", give_up)
    outcome = invoke("simulate", "four-wheel", "--from", "0.2,0.4,0")
    assert (outcome.status, outcome.out) == (status, "")
    assert ("Traceback" in outcome.err) == (status == 70)
    assert "four-wheel: no Filippov continuation" in outcome.err or status == 70


# ---- ``nonsmooth check`` for many scenes: one line each, all records, the worst exit status ------

TIPPING = """
[check]
radius = 5
[contact]
rule = "box"
[friction]
mu_roll = 1
mu_side = "1/2"
[ring]
count = 3
radius = 1
"""


@pytest.mark.usefixtures("few_paths")
def test_records_are_those_of_the_single_checks(invoke: Invoke) -> None:
    scenes = ["four-wheel", "eq-4", "differential-drive"]
    status, out, _ = invoke("check", *scenes, "--json")
    found = json.loads(out)
    assert (status, found["schema"]) == (1, "nonsmooth-checks/1")
    for record, scene in zip(found["checks"], scenes, strict=True):
        alone = json.loads(invoke("check", scene, "--json")[1])
        alone.pop("seconds", None)
        record.pop("seconds", None)
        assert record == alone


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_a_refused_scene_stops_no_other(invoke: Invoke, tmp_path: Path) -> None:
    tipping = tmp_path / "tipping.toml"
    tipping.write_text(TIPPING, encoding="utf-8")
    alone = invoke("check", str(tipping))
    status, out, err = invoke("check", "outward", str(tipping), "four-wheel", "--json")
    records = json.loads(out)["checks"]
    assert (status, err) == (2, "")
    assert [record.get("theorem4", {}).get("verdict") for record in records] == ["fails", None, "holds"]
    assert records[1]["refused"] in alone[2]
    assert "support polygon" in records[1]["refused"]
    assert "refused" in invoke("check", "outward", str(tipping))[1]
