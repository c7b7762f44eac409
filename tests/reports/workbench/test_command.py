"""``nonsmooth workbench`` where it cannot start: one line, exit status 2."""

from __future__ import annotations

import socket
import sys
from pathlib import Path

import pytest

from nonsmooth.reports.workbench import app
from tests.reports.conftest import Invoke


@pytest.fixture(autouse=True)
def own_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr(app, "run", None)  # nothing here is ever served


def test_without_its_packages_it_says_how_to_install_them(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    for name in [name for name in sys.modules if name.startswith("nonsmooth.reports.workbench")]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "uvicorn", None)
    result = invoke("workbench", "--no-browser")
    assert result.status == 2
    assert "nonsmooth[workbench]" in result.err
    assert len(result.err.splitlines()) == 1


@pytest.mark.parametrize("scene", ["no-such-scene", "husky-a200", "/dev/null"])
def test_a_scene_that_cannot_be_used_is_refused(invoke: Invoke, scene: str) -> None:
    result = invoke("workbench", scene, "--no-browser")
    assert result.status == 2
    assert not result.out
    assert len(result.err.splitlines()) == 1


def test_a_port_that_is_taken_is_refused(invoke: Invoke) -> None:
    with socket.create_server(("127.0.0.1", 0)) as taken:
        result = invoke("workbench", "--no-browser", "--port", str(taken.getsockname()[1]))
    assert result.status == 2
    assert "--port" in result.err


@pytest.mark.parametrize("port", ["-1", "65536", "x"])
def test_a_port_that_is_none_is_refused(invoke: Invoke, port: str) -> None:
    assert invoke("workbench", "--port", port).status == 2
