"""What was removed is refused in one line, exit status 2, that names the way to do without it."""

from __future__ import annotations

from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import BAD_INPUT, run
from nonsmooth.symbolic.messages import removed

ONE_VEHICLE = (
    "vehicle: required one scene: run it for each; `make evidence` in a checkout compares all with measurements"
)


@pytest.fixture(autouse=True)
def _old_names(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command, an option and a table that never were, so that the mechanism itself is tested."""
    monkeypatch.setitem(removed.COMMANDS, "divine", "toss a coin")
    monkeypatch.setitem(removed.OPTIONS, ("check", "--guess"), "use --radius")
    monkeypatch.setitem(removed.TABLES, "tarot", "state [friction]")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("check four-wheel --guess", "--guess was removed: use --radius"),
        ("divine", "the command divine was removed: toss a coin"),
        (
            "design four-wheel --front front.svg",
            "--front was removed: use --maximize rate, then --maximize tolerance",
        ),
        ("simulate eq-3 --from 1,1 --mode heating", "--mode was removed: follow each mode as a [system] of its own"),
        ("vehicle husky-a200 --allow-outside", "--allow-outside was removed: vehicles name no other files"),
        (
            "validate --only vehicles",
            "the command validate was removed: run `make evidence` in a checkout of the repository, "
            "or read its page docs/evidence.md",
        ),
        *((line, ONE_VEHICLE) for line in ("vehicle", "vehicle jackal rosbot", "vehicle --json")),
    ],
)
def test_removed_options_and_commands_are_refused_with_the_way_to_do_without(
    capsys: pytest.CaptureFixture[str], line: str, said: str
) -> None:
    assert run(app, line.split()) == BAD_INPUT
    assert capsys.readouterr() == ("", f"nonsmooth: {said}\n")


def test_other_mistakes_are_told_as_before(capsys: pytest.CaptureFixture[str]) -> None:
    assert run(app, ["check", "four-wheel", "--guesses"]) == BAD_INPUT
    assert "see 'nonsmooth check --help'" in capsys.readouterr().err


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

REMOVED = {
    "tarot": ('[[wheel]]\nposition = [1, 0]\nheading = "inward"\nspeed = 1\n[tarot]\ncards = 1\n', "state [friction]"),
    "mode": (
        MODES,
        "let one [system] rhs switch by the signs of formulas, or follow each mode as a [system] of its own",
    ),
    "network": (
        '[system]\nstates = ["x"]\nrhs = ["u(x)"]\n[[network]]\nname = "u"\nfile = "net.onnx"\n',
        "write its functions as formulas with relu in [system] rhs",
    ),
}


@pytest.mark.parametrize("command", ["check", "simulate --from 15"])
@pytest.mark.parametrize("table", REMOVED)
def test_a_removed_table_is_named(table: str, command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text, without = REMOVED[table]
    scene = tmp_path / "old.toml"
    scene.write_text(text)
    assert run(app, [*command.split(), str(scene)]) == BAD_INPUT
    required = f"{table}: required a scene without it: {without}, received a table that was removed"
    assert capsys.readouterr() == ("", f"nonsmooth: {scene}: {required}\n")


VEHICLE = '[vehicle]\nurdf = "robot.urdf"\n[friction]\nmu_roll = 1\nmu_side = 1\n'


def test_robot_descriptions_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "robot.toml"
    scene.write_text(VEHICLE)
    assert run(app, ["vehicle", str(scene)]) == BAD_INPUT
    without = "a scene without it: place the wheels by track and wheel_base, or one by one in [[wheel]]"
    required = f"vehicle.urdf: required {without}, received a key that was removed"
    assert capsys.readouterr() == ("", f"nonsmooth: {scene}: {required}\n")


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
