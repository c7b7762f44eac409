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


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("check four-wheel --guess", "--guess was removed: use --radius"),
        ("divine", "the command divine was removed: toss a coin"),
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


TAROT = '[[wheel]]\nposition = [1, 0]\nheading = "inward"\nspeed = 1\n[tarot]\ncards = 1\n'


@pytest.mark.parametrize("command", ["check", "simulate --from 15"])
def test_a_removed_table_is_named(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scene = tmp_path / "old.toml"
    scene.write_text(TAROT)
    assert run(app, [*command.split(), str(scene)]) == BAD_INPUT
    required = "tarot: required a scene without it: state [friction], received a table that was removed"
    assert capsys.readouterr() == ("", f"nonsmooth: {scene}: {required}\n")


@pytest.mark.parametrize("name", removed.NAMES)
def test_removed_names_of_the_interface_say_what_to_do_without(name: str) -> None:
    with pytest.raises(AttributeError, match=f"^{name} was removed: "):
        getattr(ns, name)
    assert name not in dir(ns)
