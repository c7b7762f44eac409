"""What a worker does when its server is gone."""

from __future__ import annotations

import json
from multiprocessing import Pipe

import pytest

from nonsmooth.reports.workbench.worker import answers


def test_a_server_that_went_with_messages_unread_is_no_fault_of_the_job(capfd: pytest.CaptureFixture[str]) -> None:
    """A socket that is closed with unread bytes is reset, which is another error than its end."""
    worker, server = Pipe()
    worker.send_bytes(b"an answer that nobody reads")
    server.close()

    def look_up(step: str) -> None:
        del step
        if worker.poll():
            worker.recv_bytes()

    opened, _ = answers("scene", b"four-wheel", lambda step: None)
    request = json.dumps({"document": opened["document"]}).encode()
    with pytest.raises(ConnectionResetError):
        list(answers("view", request, look_up))
    assert capfd.readouterr().err == ""
