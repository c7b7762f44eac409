"""One workbench for the tests of a module."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.workbench_server import Workbench


@pytest.fixture(scope="package")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workbench]:
    running = Workbench(tmp_path_factory.mktemp("state"))
    try:
        yield running
    finally:
        assert running.stop() == 0
        assert "Traceback" not in running.log.read_text()
