"""Long steps are named on a terminal, on standard error alone, and leave nothing behind."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path
from types import SimpleNamespace

import pytest

import nonsmooth as ns
from nonsmooth.reports.checks.check import CHECK
from nonsmooth.reports.cli import app
from nonsmooth.reports.derivations.derivation import DERIVE
from nonsmooth.reports.designs.design import DESIGN
from nonsmooth.reports.output import progress as progress_module
from nonsmooth.reports.output.console import run
from nonsmooth.reports.output.progress import CLEAR_LINE, end_progress, steps
from nonsmooth.reports.output.refusals import RefusedError
from nonsmooth.reports.simulations.simulate import SIMULATE
from nonsmooth.reports.sweeps.sweep_study import SWEEP
from nonsmooth.symbolic.messages.under_way import listening, part_of, parts, tell, tell_count
from tests.thorough import few

HASTY = (
    "from nonsmooth.reports import cli; from nonsmooth.reports.output import progress; "
    "progress.PATIENCE = 0.0; cli.main()"
)


def on_terminal(monkeypatch: pytest.MonkeyPatch, patience: float) -> str:
    """What two steps leave on a pseudo-terminal, cleared at the end."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(progress_module, "PATIENCE", patience)
    monkeypatch.setattr(progress_module, "TICK", 0.01)
    leader, follower = os.openpty()
    with os.fdopen(follower, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        with steps("count wheels") as announce:
            time.sleep(0.1)
            announce("count cells")
            time.sleep(0.1)
        stream.write("end")
    shown = terminal_text(leader)
    os.close(leader)
    return shown


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
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(progress_module, "PATIENCE", 0.0)
    leader, follower = os.openpty()
    with os.fdopen(follower, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        with pytest.raises(KeyError):
            failing_step()
    shown = terminal_text(leader)
    os.close(leader)
    assert shown.endswith(CLEAR_LINE)


def failing_step() -> None:
    """A step that has been shown when it fails."""
    with steps("count wheels"):
        time.sleep(0.1)
        raise KeyError


def test_what_the_work_tells_is_shown_and_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    """From any depth, within a step inside another; the outer step is named again afterwards."""
    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(progress_module, "PATIENCE", 0.0)
    monkeypatch.setattr(progress_module, "TICK", 0.01)
    leader, follower = os.openpty()
    with os.fdopen(follower, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        with steps("simulate"):
            with steps("path"):
                for count in (1, 2):
                    tell_count(count, 2, "starts")
                    time.sleep(0.1)
            tell("film")
            time.sleep(0.1)
            end_progress()
            stream.write("output")
            tell("nothing more")
            time.sleep(0.1)
    shown = terminal_text(leader)
    os.close(leader)
    places = [shown.index(said) for said in ("path: 1 of 2 starts (0 s)", "path: 2 of 2", "simulate: film (0 s)")]
    assert places == sorted(places)
    assert shown.endswith(f"{CLEAR_LINE}output")


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
units = { length = "mm" }
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
    """By a clock ten times as fast, of a study that takes three of its seconds and says nothing of itself."""
    study = {"check": CHECK, "derive": DERIVE, "simulate": SIMULATE, "sweep": SWEEP, "design": DESIGN}[command]

    def slow(self: object, scene: object, options: object) -> None:
        time.sleep(0.35)
        raise RefusedError("enough")

    monkeypatch.setenv("TERM", "xterm")
    monkeypatch.setattr(type(study), "run", slow)
    monkeypatch.setattr(progress_module, "PATIENCE", 0.1)
    monkeypatch.setattr(progress_module, "TICK", 0.02)
    fast = SimpleNamespace(monotonic=lambda: 10 * time.monotonic())
    monkeypatch.setattr(progress_module, "time", fast)
    leader, follower = os.openpty()
    with os.fdopen(follower, "w") as stream:
        monkeypatch.setattr(sys, "stderr", stream)
        assert run(app, [command, *ASKED[command]]) == 2
    shown = terminal_text(leader)
    os.close(leader)
    seconds = [int(found) for found in re.findall(rf"{command} \((\d+) s\)", shown)]
    assert seconds[0] <= 2
    assert len(set(seconds)) > 1
    assert "enough" in shown.rpartition(CLEAR_LINE)[2]


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
