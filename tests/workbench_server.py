"""A workbench in a process of its own, and a browser's side of the conversation with it."""

from __future__ import annotations

import http.client
import json
import os
import signal
import socket
import subprocess
import sys
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

Json = dict[str, Any]
REPLACED = 20.0  # seconds after which a worker that is replaced must have ended
ANSWERS = 120.0  # seconds in which it must answer: the machine of a test may be busy


class Reply(NamedTuple):
    """What came back."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Json:
        found: Json = json.loads(self.body)
        return found


class Workbench:
    """A server that runs."""

    def __init__(self, state: Path, scene: str | None = None) -> None:
        self.state, self.log, self.scene = state, state / "log", scene
        self.port = 0
        self.start()

    def start(self) -> None:
        """Start, on the port of the run before, if there was one."""
        arguments = [*([self.scene] if self.scene else []), "--no-browser", "--port", str(self.port)]
        command = [sys.executable, "-m", "nonsmooth.reports.cli", "workbench", *arguments]
        environment = {**os.environ, "XDG_STATE_HOME": str(self.state)}
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=log, env=environment, text=True)
        stdout = self.process.stdout
        assert stdout is not None
        self.address = stdout.readline().strip()
        assert self.address, self.log.read_text()
        self.port = int(self.address.split(":")[2].split("/")[0])
        self.token = self.address.partition("token=")[2]

    @property
    def headers(self) -> dict[str, str]:
        return {"Authorization": f"Bearer {self.token}", "Content-Type": "application/json"}

    def ask(
        self, path: str, body: object = None, *, headers: Mapping[str, str] | None = None, method: str | None = None
    ) -> Reply:
        """One request on a connection of its own; a body that is no bytes is sent as JSON."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=ANSWERS)
        try:
            content = body if body is None or isinstance(body, bytes) else json.dumps(body).encode()
            verb = method or ("GET" if body is None else "POST")
            connection.request(verb, path, content, self.headers if headers is None else dict(headers))
            reply = connection.getresponse()
            return Reply(reply.status, dict(reply.getheaders()), reply.read())
        finally:
            connection.close()

    def head(self, length: str) -> bytes:
        """The lines before the body of a view, with the one that tells how long the body is."""
        host, token = f"Host: 127.0.0.1:{self.port}", f"Authorization: Bearer {self.token}"
        return "\r\n".join(["POST /api/view HTTP/1.1", host, token, length, "", ""]).encode()

    def document(self, name: str) -> Json:
        found: Json = self.ask(f"/api/scenes/{name}").json["document"]
        return found

    def view(self, document: Json, *, tab: str = "tab", sequence: int = 0, **more: object) -> dict[str, Json]:
        """All stages by their names; asserts that the stream came to its end."""
        return {stage["stage"]: stage for stage in self.stages(document, tab=tab, sequence=sequence, **more)}

    def stages(self, document: Json, *, tab: str = "tab", sequence: int = 0, **more: object) -> list[Json]:
        with self.stream(document, tab=tab, sequence=sequence, **more) as lines:
            found = list(lines)
        assert found[-1]["stage"] in {"done", "cancelled"}, found[-1]
        return found

    @contextmanager
    def stream(self, document: Json, *, tab: str, sequence: int, **more: object) -> Iterator[Iterator[Json]]:
        """The stages of a view as they come."""
        connection = http.client.HTTPConnection("127.0.0.1", self.port, timeout=ANSWERS)
        try:
            request = {"tab": tab, "sequence": sequence, "document": document, **more}
            connection.request("POST", "/api/view", json.dumps(request), self.headers)
            reply = connection.getresponse()
            assert reply.status == 200, reply.read()
            yield (json.loads(line) for line in iter(reply.readline, b""))
        finally:
            connection.close()

    def workers(self) -> list[int]:
        """Processes that compute: the children of the server's children."""
        return [grandchild for child in _children(self.process.pid) for grandchild in _children(child)]

    def workers_left(self, count: int) -> list[int]:
        """The workers, once there are no more than a count of them: one that is replaced ends a little later."""
        deadline = time.monotonic() + REPLACED
        while len(self.workers()) > count and time.monotonic() < deadline:
            time.sleep(0.05)
        return self.workers()

    def kill(self) -> None:
        """As when the machine kills it."""
        self.process.send_signal(signal.SIGKILL)
        self._wait()

    def stop(self) -> int:
        """As when its user presses Ctrl-C."""
        self.process.send_signal(signal.SIGINT)
        return self._wait()

    def _wait(self) -> int:
        status = self.process.wait(ANSWERS)
        if self.process.stdout is not None:
            self.process.stdout.close()
        return status


class SlowBody:
    """A request whose body never ends; the server gives it up after ten seconds."""

    def __init__(self, server: Workbench) -> None:
        self._server = server
        self._begin()

    def answer(self) -> bytes:
        """What the server says in the end; asked again where it was killed before it said anything."""
        try:
            said = self._connection.recv(4096)
        except ConnectionResetError:
            said = b""
        if not said and self._server.process.pid != self._asked:
            self.close()
            self._begin()
            said = self._connection.recv(4096)
        return said

    def close(self) -> None:
        """Hang up."""
        self._connection.close()

    def _begin(self) -> None:
        self._asked = self._server.process.pid
        self._connection = socket.create_connection(("127.0.0.1", self._server.port), timeout=ANSWERS)
        self._connection.sendall(self._server.head("Content-Length: 1000") + b'{"tab"')


def _children(pid: int) -> list[int]:
    found: list[int] = []
    for task in Path(f"/proc/{pid}/task").glob("*/children"):
        found += map(int, task.read_text().split())
    return found


def resident(pids: list[int]) -> int:
    """Bytes of memory that processes hold, shared pages counted in parts."""
    total = 0
    for pid in pids:
        lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
        total += sum(int(line.split()[1]) for line in lines if line.startswith("Pss:"))
    return total * 1024
