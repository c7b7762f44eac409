"""``nonsmooth vehicle``: records, files, refusals, and the same in Python."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import nonsmooth as ns
from tests.reports.conftest import Invoke
from tests.thorough import few


@pytest.mark.parametrize("arguments", [("husky-a200",), ("tracked-base", "--rule", "nearest"), ("swerve-base",)])
def test_views_fit_80_columns(invoke: Invoke, monkeypatch: pytest.MonkeyPatch, arguments: tuple[str, ...]) -> None:
    monkeypatch.setenv("COLUMNS", "80")
    out = invoke("vehicle", *arguments).out
    assert max(len(line) for line in out.splitlines()) <= 80


@few(1)
@pytest.mark.parametrize(
    ("scene", "suffix"),
    [("husky-a200", ".svg"), ("husky-a200", ".json"), ("mecanum-base", ".svg"), ("husky-a200", ".csv")],
)
def test_files_are_reproducible(invoke: Invoke, tmp_path: Path, scene: str, suffix: str) -> None:
    file = tmp_path / f"v{suffix}"
    assert invoke("vehicle", scene, "-o", file.name).status == 0
    first = file.read_bytes()
    assert invoke("vehicle", scene, "-o", file.name).status == 0
    assert file.read_bytes() == first


def test_rounding_is_no_slip_in_a_picture(invoke: Invoke, tmp_path: Path) -> None:
    """The swerve base turns about its centre without slip; a husky in place slips at every wheel."""
    for name, slips in (("swerve-base", False), ("husky-a200", True)):
        assert invoke("vehicle", name, "-o", f"{name}.svg").status == 0
        assert ("slip over the ground" in (tmp_path / f"{name}.svg").read_text(encoding="utf-8")) == slips


def test_a_vehicle_that_never_turns_has_a_picture(invoke: Invoke, tmp_path: Path) -> None:
    """Its heavier side drags the other along at every curvature: there is no instant centre to draw."""
    sides = '[vehicle]\ntrack = 0.6\nwheel_base = 0.5\ncentre_of_mass = [0, "0.02"]\n'
    text = f"{sides}[friction]\nmu_roll = 1\nmu_side = 5\n"
    (tmp_path / "uneven.toml").write_text(text, encoding="utf-8")
    assert invoke("vehicle", "uneven.toml", "-o", "uneven.svg").status == 0
    assert "instant centres of rotation" in (tmp_path / "uneven.svg").read_text(encoding="utf-8")


def test_rules_that_say_nothing_are_named_in_the_record(invoke: Invoke, tmp_path: Path) -> None:
    """Rims in three directions with friction across them only: a disc of radius zero grips nothing."""
    wheels = "".join(
        f"[[wheel]]\nposition = {place}\nheading = {angle}\nspeed = 1\n"
        for place, angle in (("[1, 0]", 0), ("[-1, 1]", 120), ("[-1, -1]", 240))
    )
    (tmp_path / "side.toml").write_text(f"[vehicle]\n[friction]\nmu_roll = 0\nmu_side = 1\n{wheels}", encoding="utf-8")
    rules = invoke("vehicle", "side.toml", "--json").record["rules"]
    assert "required a wheel that grips under rule roller" in rules[-1]["refused"]
    assert "roller" not in invoke("vehicle", "side.toml").out


def test_python_holds_the_record_of_the_command(invoke: Invoke, tmp_path: Path) -> None:
    record = invoke("vehicle", "jackal", "--spin", "3", "--json").record
    loaded = ns.Vehicle.load("jackal")
    found = loaded.motion(spin=3)
    assert json.loads(json.dumps(found.to_dict())) == record
    assert found.twist == tuple(record["twist"])
    assert found.multiplier == record["multiplier"]
    assert len(found.rows()) == 19
    found.save(tmp_path / "own.csv")
    invoke("vehicle", "jackal", "-o", "other.csv")
    assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    assert repr(loaded) == "Vehicle 'jackal': 4 wheels"
    assert len(repr(found)) < 200


def test_a_vehicle_made_in_python() -> None:
    corners = [(0.25, 0.25), (-0.25, 0.25), (-0.25, -0.25), (0.25, -0.25)]
    headings = [(-1, 1), (-1, -1), (1, -1), (1, 1)]
    wheels = [ns.Wheel(place, heading=heading, speed=1) for place, heading in zip(corners, headings, strict=True)]
    found = ns.Vehicle(wheels).motion()
    assert found.to_dict()["exact"]["twist"] == ["0", "0", "2*sqrt(2)"]
    with pytest.raises(ns.SceneError, match=r"vehicle: vehicle\.track: required a track beside wheel_base"):
        ns.Vehicle(wheel_base=1)
