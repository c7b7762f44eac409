"""What was removed is refused in one line, exit status 2, that names the way to do without it."""

from __future__ import annotations

from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import BAD_INPUT, run
from nonsmooth.symbolic.messages import removed


@pytest.fixture(autouse=True)
def _old_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command, an option and a table that never were, so that the mechanism itself is tested."""
    monkeypatch.setitem(removed.COMMANDS, "divine", "toss a coin")
    monkeypatch.setitem(removed.OPTIONS, ("check", "--guess"), "use --radius")
    monkeypatch.setitem(removed.TABLES, "tarot", "state [friction]")


def test_removed_options_and_commands_are_refused_with_the_way_to_do_without(
    capsys: pytest.CaptureFixture[str],
) -> None:
    assert run(app, ["check", "four-wheel", "--guess"]) == BAD_INPUT
    assert capsys.readouterr() == ("", "nonsmooth: --guess was removed: use --radius\n")
    assert run(app, ["divine"]) == BAD_INPUT
    assert capsys.readouterr() == ("", "nonsmooth: the command divine was removed: toss a coin\n")


def test_designs_have_no_front(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["design", "four-wheel", "--front", "front.svg"]) == BAD_INPUT
    said = "nonsmooth: --front was removed: use --maximize rate, then --maximize tolerance\n"
    assert capsys.readouterr() == ("", said)


def test_other_mistakes_are_told_as_before(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["check", "four-wheel", "--guesses"]) == BAD_INPUT
    assert "see 'nonsmooth check --help'" in capsys.readouterr().err


def test_a_removed_table_is_named(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "old.toml"
    scene.write_text('name = "old"\n[[wheel]]\nposition = [1, 0]\nheading = "inward"\nspeed = 1\n[tarot]\ncards = 1\n')
    assert run(app, ["check", str(scene)]) == BAD_INPUT
    required = "tarot: required a scene without it: state [friction], received a table that was removed"
    assert capsys.readouterr().err == f"nonsmooth: {scene}: {required}\n"


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        (
            ["validate", "--only", "vehicles"],
            "the command validate was removed: run `make evidence` in a checkout of the repository, "
            "or read its page docs/evidence.md",
        ),
        *(
            (
                arguments,
                "vehicle: required one scene: run it for each; "
                "`make evidence` in a checkout compares all with measurements",
            )
            for arguments in (["vehicle"], ["vehicle", "jackal", "rosbot"], ["vehicle", "--json"])
        ),
    ],
)
def test_what_was_removed_names_the_way_to_do_without(
    capsys: pytest.CaptureFixture[str], arguments: list[str], line: str
) -> None:
    assert run(app, arguments) == BAD_INPUT
    assert capsys.readouterr() == ("", f"nonsmooth: {line}\n")


MODES = """
[system]
states = ["T"]
[[mode]]
name = "heating"
rhs = ["26 - T"]
leave = { idle = "T - 21" }
[[mode]]
name = "idle"
rhs = ["10 - T"]
"""


@pytest.mark.parametrize("command", ["check", "simulate --from 15"])
def test_systems_with_modes_are_refused(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "heater.toml"
    scene.write_text(MODES)
    assert run(app, [*command.split(), str(scene)]) == BAD_INPUT
    without = "let one [system] rhs switch by the signs of formulas, or follow each mode as a [system] of its own"
    required = f"mode: required a scene without it: {without}, received a table that was removed"
    assert capsys.readouterr() == ("", f"nonsmooth: {scene}: {required}\n")


def test_the_first_mode_of_a_path_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["simulate", "eq-3", "--from", "1,1", "--mode", "heating"]) == BAD_INPUT
    assert capsys.readouterr() == ("", "nonsmooth: --mode was removed: follow each mode as a [system] of its own\n")


def test_networks_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "loop.toml"
    scene.write_text('[system]\nstates = ["x"]\nrhs = ["u(x)"]\n[[network]]\nname = "u"\nfile = "net.onnx"\n')
    assert run(app, ["check", str(scene)]) == BAD_INPUT
    without = "a scene without it: write its functions as formulas with relu in [system] rhs"
    required = f"network: required {without}, received a table that was removed"
    assert capsys.readouterr() == ("", f"nonsmooth: {scene}: {required}\n")


VEHICLE = '[vehicle]\nurdf = "robot.urdf"\n[friction]\nmu_roll = 1\nmu_side = 1\n'


def test_robot_descriptions_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "robot.toml"
    scene.write_text(VEHICLE)
    assert run(app, ["vehicle", str(scene)]) == BAD_INPUT
    without = "a scene without it: place the wheels by track and wheel_base, or one by one in [[wheel]]"
    required = f"vehicle.urdf: required {without}, received a key that was removed"
    assert capsys.readouterr() == ("", f"nonsmooth: {scene}: {required}\n")
    assert run(app, ["vehicle", "husky-a200", "--allow-outside"]) == BAD_INPUT
    assert capsys.readouterr() == ("", "nonsmooth: --allow-outside was removed: vehicles name no other files\n")


def test_films_for_which_ffmpeg_was_needed_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "path.mp4"
    assert run(app, ["simulate", "four-wheel", "--from", "0.2,0.4,0", "-o", str(file)]) == BAD_INPUT
    required = "a file name that ends in .csv, .json, .parquet, .svg, .png, .pdf, .gif or .html"
    received = "'.mp4', which was removed: a film is a .gif, or an .html page with a slider"
    assert capsys.readouterr() == ("", f"nonsmooth: {file}: required {required}, received {received}\n")
    assert not file.exists()


@pytest.mark.parametrize("name", removed.NAMES)
def test_removed_names_of_the_interface_say_what_to_do_without(name: str) -> None:
    with pytest.raises(AttributeError, match=f"^{name} was removed: "):
        getattr(ns, name)
    assert name not in dir(ns)
