"""Plain systems, audits and certificates through the command line."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from nonsmooth.reports.cli import app
from nonsmooth.reports.console import run

VERDICTS = {
    "relay-oscillator": ("stable", 0),
    "relay-oscillator-damped": ("asymptotically stable", 0),
    "flower": ("asymptotically stable", 0),
    "escaping-slide": ("unstable", 1),
    "line-of-equilibria": ("stable", 0),
    "eq-3": ("stable", 0),
    "eq-4": ("asymptotically stable", 0),
}


def printed(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, Any]:
    status = run(app, [*arguments, "--json"])
    return status, json.loads(capsys.readouterr().out)


@pytest.mark.parametrize("name", VERDICTS)
def test_built_in_systems(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    verdict, expected = VERDICTS[name]
    status, record = printed(capsys, "check", name)
    assert (record["translation"]["verdict"], status) == (verdict, expected)
    assert {"V", "naive", "shevitz_paden", "bacciotti_ceragioli", "verdict", "witness"} <= set(record["lyapunov"])
    assert run(app, ["check", name]) == expected


def test_the_ladder_of_the_relay_oscillator(capsys: pytest.CaptureFixture[str]) -> None:
    """Undamped: 2 / 0 / 0 as suprema; damped: 5/2 / -1/2 / -1/2."""
    suprema = {}
    for name in ("relay-oscillator", "relay-oscillator-damped"):
        _, record = printed(capsys, "check", name)
        suprema[name] = [
            record["lyapunov"][key]["exact"]["value"] for key in ("naive", "shevitz_paden", "bacciotti_ceragioli")
        ]
    assert suprema == {"relay-oscillator": ["2", "0", "0"], "relay-oscillator-damped": ["5/2", "-1/2", "-1/2"]}


@pytest.mark.parametrize(
    ("scene", "function", "verdict", "expected"),
    [
        ("four-wheel", "x**2 + y**2", "valid", 0),
        ("four-wheel", "x**2 + 3*y**2", "valid", 0),
        ("four-wheel", "x**2 - y**2", "invalid", 1),
        ("flower", "x**2 + y**2", "invalid", 1),
        ("relay-oscillator-damped", "Abs(x) + Abs(y)", "valid", 0),
    ],
)
def test_audits(scene: str, function: str, verdict: str, expected: int, capsys: pytest.CaptureFixture[str]) -> None:
    status, record = printed(capsys, "audit", scene, "--lyapunov", function)
    assert (record["verdict"], status) == (verdict, expected)
    assert (record["witness"] is None) == (verdict == "valid")
    assert run(app, ["audit", scene, "--lyapunov", function]) == expected


WHEELS = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[ring]\ncount = 4\nradius = "sqrt(2)"\nphase = "pi/4"\n'
SYSTEM = '[system]\nstates = ["p", "q"]\nrhs = ["-sign(p)", "-sign(q)"]\n'


@pytest.mark.parametrize(
    ("scene", "function", "expected"),
    [(WHEELS, "x**2 + 3*y**2", 0), (WHEELS, "Abs(x) - Abs(y)", 1), (SYSTEM, "Abs(p) + 2*Abs(q)", 0)],
)
def test_the_function_of_the_scene_is_audited_unless_one_is_given(
    scene: str, function: str, expected: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(f'{scene}[check]\nlyapunov = "{function}"\n')
    status, record = printed(capsys, "audit", str(path))
    assert (status, record["V"]) == (expected, function)
    assert (status, record) == printed(capsys, "audit", str(path), "--lyapunov", function)
    other = "-x**2" if scene == WHEELS else "-p**2"
    status, record = printed(capsys, "audit", str(path), "--lyapunov", other)
    assert (status, record["V"]) == (1, other)


def test_no_function_at_all_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "scene.toml"
    for scene in (WHEELS, SYSTEM):
        path.write_text(scene)
        assert run(app, ["audit", str(path)]) == 2
        message = capsys.readouterr().err
        assert message.count("\n") == 1
        assert "required V as --lyapunov or as check.lyapunov, received neither" in message


def test_a_certificate_is_written_and_verified(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = tmp_path / "four-wheel.json"
    assert run(app, ["check", "four-wheel", "--certificate", str(target)]) == 0
    assert run(app, ["verify", str(target)]) == 0
    assert "valid" in capsys.readouterr().out
    forged = target.read_text().replace('"asymptotically stable"', '"unstable"')
    assert forged != target.read_text()
    target.write_text(forged)
    assert run(app, ["verify", str(target)]) == 1


@pytest.mark.parametrize(
    "arguments",
    [
        ["verify", "no-such-file.json"],
        ["audit", "four-wheel", "--lyapunov", "__import__('os')"],
        ["audit", "four-wheel", "--lyapunov", "1/0"],
        ["check", "flower", "--rule", "box"],
        ["check", "flower", "--certificate", "flower.json"],
        ["check", "four-wheel", "--rule", "all", "--certificate", "all.json"],
        ["check", "four-wheel", "--certificate", "four-wheel.txt"],
    ],
)
def test_bad_input_ends_in_one_line(
    arguments: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert run(app, arguments) == 2
    captured = capsys.readouterr()
    assert captured.err.count("\n") == 1
    assert "Traceback" not in captured.err
    assert not list(tmp_path.iterdir())
