"""A new option of ``check`` is a field: its flag, keyword, help and refusal follow, and the result says it."""

from __future__ import annotations

import inspect
import sys

import pytest

from nonsmooth.reports.commands import registry
from nonsmooth.reports.studies.study import takes
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.rehearsals import outermost
from tests.reports.conftest import Invoke


@pytest.fixture(autouse=True)
def _asked(monkeypatch: pytest.MonkeyPatch) -> None:
    """The command under a name of its own: commands are made once."""
    monkeypatch.setitem(registry.COMMANDS, "ask", registry.Entry("Check.", "ask four-wheel"))
    monkeypatch.setitem(sys.modules, "nonsmooth.reports.commands.ask", outermost)
    monkeypatch.setattr(outermost, "ask", outermost.check, raising=False)


def test_the_command_has_it(invoke: Invoke) -> None:
    shown = " ".join(invoke("ask", "--help").out.split())
    assert "--outermost Name the wheel farthest from the point." in shown
    assert invoke("ask", "four-wheel", "--outermost", "--json").record["outermost"] in range(1, 5)
    assert "outermost" not in invoke("ask", "four-wheel", "--json").record


def test_python_has_it() -> None:
    study, scene = outermost.AskedStudy(), load_scene("four-wheel")
    assert study.of(scene, outermost=True).to_dict()["outermost"] in {wheel.index for wheel in scene.wheels}
    assert "outermost" not in study.of(scene).to_dict()

    @takes(outermost.AskedOptions)
    def check(**options: object) -> None:
        """Check."""

    assert inspect.signature(check).parameters["outermost"].default is False
    assert "outermost: Name the wheel farthest from the point." in (check.__doc__ or "")
