"""The functions of docs/tour.md exist, and its command calls them in the order of the page."""

from __future__ import annotations

import re
import sys
from importlib import import_module
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run

TOUR = Path(__file__).resolve().parents[1] / "docs" / "tour.md"
HEADING = re.compile(r"^### ([0-9]+)\. `(nonsmooth[\w.]+)`$", re.MULTILINE)
COMMAND = re.compile(r"^```sh\nnonsmooth (check .*)\n```$", re.MULTILINE)
FUNCTIONS = 16


def function_of(name: str) -> Any:
    """The function of a dotted name: in a module, or in a class of one."""
    parts = name.split(".")
    for size in range(len(parts) - 1, 0, -1):
        try:
            found: Any = import_module(".".join(parts[:size]))
        except ModuleNotFoundError:
            continue
        for part in parts[size:]:
            found = getattr(found, part)
        return found
    raise AssertionError(name)


def test_the_tour_goes_where_the_command_goes(tmp_path: Path, monkeypatch: Any, capsys: Any) -> None:
    text = TOUR.read_text(encoding="utf-8")
    headings = HEADING.findall(text)
    assert [int(number) for number, _ in headings] == list(range(1, FUNCTIONS + 1))
    wanted: dict[CodeType, str] = {function_of(name).__code__: name for _, name in headings}
    assert len(wanted) == FUNCTIONS
    (command,) = COMMAND.findall(text)
    called: list[str] = []

    def note(frame: FrameType, event: str, argument: object) -> None:
        if event == "call" and frame.f_code in wanted and wanted[frame.f_code] not in called:
            called.append(wanted[frame.f_code])

    monkeypatch.chdir(tmp_path)
    sys.setprofile(note)
    try:
        assert run(app, command.split()) == 0
    finally:
        sys.setprofile(None)
    assert "asymptotically stable" in capsys.readouterr().out
    assert called == [name for _, name in headings]
    assert (tmp_path / "relays.json").exists()
