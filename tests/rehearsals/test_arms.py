"""A new section of the report is a function and a line; a new figure is a function that a section names."""

from __future__ import annotations

from pathlib import Path

import pytest

from nonsmooth.reports.checks.subject import ReportPart
from nonsmooth.reports.derivations import parts
from tests.rehearsals.arms import arms_section, without_arms
from tests.reports.conftest import Invoke


@pytest.fixture(autouse=True)
def _arms(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = (*parts.PARTS[:2], ReportPart("arms", arms_section, without_arms), *parts.PARTS[2:])
    monkeypatch.setattr(parts, "PARTS", whole)


def test_a_new_section_is_in_every_format_with_its_figure(invoke: Invoke) -> None:
    assert "There are 4 arms." in invoke("derive", "four-wheel", "--only", "arms").out
    for ending, figure in ((".html", "<svg"), (".tex", "includegraphics"), (".md", "Arms of the wheels")):
        assert invoke("derive", "four-wheel", "--only", "arms", "-o", f"r{ending}").status == 0
        text = Path(f"r{ending}").read_text(encoding="utf-8")
        assert "There are 4 arms" in text
        assert figure in text
    assert "There are 4 arms" not in invoke("derive", "four-wheel", "--only", "array", "--without", "arms").out


def test_a_section_that_a_scene_lacks_is_named_with_the_reason(invoke: Invoke) -> None:
    shown = invoke("derive", "ring-6", "--only", "arms,left-out").out
    assert "Section arms: six arms are too many." in shown
    assert "There are 6 arms" not in shown
    assert "arms" in invoke("derive", "four-wheel", "--only", "legs").err
