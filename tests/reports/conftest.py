"""The command line as a fixture, ``invoke``, which runs it in this process in an empty folder; and one browser."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

import pytest

from nonsmooth.reports import cli
from nonsmooth.reports.output.console import run
from tests.browser import chromium

if TYPE_CHECKING:
    from playwright.sync_api import Browser

Record: TypeAlias = dict[str, Any]


class Outcome(NamedTuple):
    """What a run leaves behind."""

    status: int
    out: str
    err: str

    @property
    def record(self) -> Record:
        """The printed JSON document."""
        record: Record = json.loads(self.out)
        return record


Invoke: TypeAlias = Callable[..., Outcome]


@pytest.fixture(scope="package", autouse=True)
def commands() -> Iterator[None]:
    """Each command is made of its function once, not once a call."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cli, "_made", cache(cli._made))
        yield


@pytest.fixture
def invoke(capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Invoke:
    """Run the command line in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def call(*arguments: str) -> Outcome:
        capsys.readouterr()
        status = run(cli.app, arguments)
        return Outcome(status, *capsys.readouterr())

    return call


@pytest.fixture(scope="package")
def browser() -> Iterator[Browser]:
    """For all tests of pages, those of the workbench too."""
    with chromium() as running:
        yield running
