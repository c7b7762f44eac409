"""Running the server of the workbench on this machine alone."""

from __future__ import annotations

import os
import secrets
import socket
from pathlib import Path

import uvicorn

from nonsmooth.reports.workbench.app import Settings, build_app

HOST = "127.0.0.1"
PORT = 8421  # unless another is asked for; a free one where it is taken
BACKLOG = 64
MOST_CONNECTIONS = 64


def listening(port: int | None) -> socket.socket:
    """A socket on this machine alone, on the port, or on a free one where none is asked for and ours is taken.

    Raises:
        OSError: for a port that is taken.
    """
    for candidate in (port,) if port is not None else (PORT, 0):
        # named TCP: only then asyncio sends each stage at once, and does not wait for the last one's acknowledgement
        listener = socket.socket(socket.AF_INET, socket.SOCK_STREAM, socket.IPPROTO_TCP)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((HOST, candidate))
        except OSError:
            listener.close()
            if candidate == 0 or port is not None:
                raise
        else:
            listener.listen(BACKLOG)  # at once: who reads the address may connect
            return listener
    raise OSError("no port")


def run(listener: socket.socket, settings: Settings) -> None:
    """Serve until interrupted."""
    config = uvicorn.Config(
        build_app(settings),
        log_level="warning",
        access_log=False,
        server_header=False,
        limit_concurrency=MOST_CONNECTIONS,
        backlog=BACKLOG,
        timeout_keep_alive=60,
        timeout_graceful_shutdown=1,
    )
    uvicorn.Server(config).run(sockets=[listener])


def own_token() -> str:
    """The token of this user: kept in a file that only the user can read, so that a page outlives the server."""
    state = Path(os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state")
    path = state / "nonsmooth" / "workbench-token"
    try:
        token = path.read_text(encoding="ascii").strip()
        if len(token) >= 32 and not path.stat().st_mode & 0o077:
            return token
        path.unlink()
    except (OSError, ValueError):
        pass
    token = secrets.token_urlsafe(32)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with os.fdopen(os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
            file.write(token)
    except OSError:  # nowhere to keep it: it lasts as long as this run
        pass
    return token
