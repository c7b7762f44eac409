"""The server of the workbench on this machine: a few routes of Starlette, each a job of a worker."""

from __future__ import annotations

import asyncio
import base64
import hmac
import json
import os
import secrets
import socket
from collections.abc import AsyncGenerator, AsyncIterator, Awaitable, Callable
from contextlib import aclosing, asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.datastructures import Headers, MutableHeaders
from starlette.exceptions import HTTPException
from starlette.middleware import Middleware
from starlette.requests import Request
from starlette.responses import JSONResponse, Response, StreamingResponse
from starlette.routing import Route
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.console import own_version
from nonsmooth.reports.output.processes import DiedError, JobTimeoutError, StoppedError, WorkerPool
from nonsmooth.reports.workbench.requests import RequestError, read_request
from nonsmooth.reports.workbench.worker import CANCELLED, encoded, serve_page

# ---- what every request must satisfy before anything is done -------------------------------------
#
# Own host and origin, a token, a body of moderate size.


MAX_BODY = 1 << 20  # bytes
BODY_SECONDS = 10.0  # within which a body must have arrived
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; connect-src 'self'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
HEADERS = {
    "Content-Security-Policy": POLICY,
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-store",
    "Cross-Origin-Opener-Policy": "same-origin",
    "Cross-Origin-Resource-Policy": "same-origin",
}


class RequestGuard:
    """Refuse what is not the page's own.

    Args:
        app: what answers the rest.
        token: that every request to ``/api`` must bear.
        port: of the server; its hosts are 127.0.0.1 and localhost.
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self._app, self._token = app, token.encode()
        self._hosts = {f"127.0.0.1:{port}", f"localhost:{port}"}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer one request, or refuse it."""
        if scope["type"] == "lifespan":
            await self._app(scope, receive, send)
            return
        if scope["type"] != "http":  # no other protocol is offered
            return

        async def send_safely(message: Message) -> None:
            if message["type"] == "http.response.start":
                headers = MutableHeaders(scope=message)
                for name, value in HEADERS.items():
                    headers[name] = value
            await send(message)

        refusal = self._refusal(scope)
        if refusal is None:
            body = await self._body(receive)
            if isinstance(body, bytes):
                await self._app(scope, _replayed(body, receive), send_safely)
                return
            refusal = body
        await refusal(scope, receive, send_safely)

    def _refusal(self, scope: Scope) -> JSONResponse | None:
        headers = Headers(scope=scope)
        if headers.get("host") not in self._hosts:
            return refused(421, "Host: required the address of this server")
        origin = headers.get("origin")
        if origin is not None and origin.removeprefix("http://") not in self._hosts:
            return refused(403, "Origin: required the page of this server")
        if headers.get("sec-fetch-site", "same-origin") not in ("same-origin", "none"):
            return refused(403, "Sec-Fetch-Site: required the page of this server")
        if scope["path"].startswith("/api/") and not self._is_known(headers.get("authorization", "")):
            return refused(401, "Authorization: required the token that the command printed")
        length = headers.get("content-length", "0")
        if not length.isdecimal() or int(length[:20]) > MAX_BODY:
            return refused(413, f"Content-Length: required at most {MAX_BODY} bytes")
        return None

    def _is_known(self, authorization: str) -> bool:
        scheme, _, token = authorization.partition(" ")
        return scheme.lower() == "bearer" and hmac.compare_digest(token.encode(), self._token)

    async def _body(self, receive: Receive) -> bytes | JSONResponse:
        """The whole body; never more of it than is allowed."""
        body = bytearray()
        try:
            async with asyncio.timeout(BODY_SECONDS):
                while True:
                    message = await receive()
                    if message["type"] != "http.request":
                        return refused(400, "request: required a whole body")
                    body += message.get("body", b"")
                    if len(body) > MAX_BODY:
                        return refused(413, f"body: required at most {MAX_BODY} bytes")
                    if not message.get("more_body", False):
                        return bytes(body)
        except TimeoutError:
            return refused(408, f"body: required within {BODY_SECONDS:g} s")


def refused(status: int, message: str) -> JSONResponse:
    """One line that says what is wrong; the connection is closed, since the rest of the body was not read."""
    return JSONResponse({"error": message}, status, {"Connection": "close"})


def _replayed(body: bytes, receive: Receive) -> Receive:
    """The body once, then what the connection says."""
    waiting: list[Any] = [{"type": "http.request", "body": body, "more_body": False}]

    async def replay() -> Message:
        return waiting.pop() if waiting else await receive()

    return replay


# ---- the server ----------------------------------------------------------------------------------


PAGE = Path(__file__).with_name("page")
TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".png": "image/png",
    ".json": "application/json",
}
SECONDS = {
    "view": 60.0,
    "open": 15.0,
    "scenes": 30.0,
    "scene": 30.0,
    "file": 30.0,
    "edit": 15.0,
    "export": 120.0,
}  # in which a job must end
WARM = "nonsmooth.reports.workbench.warm"  # what workers are forked from
MOST_WAITING = 32  # jobs that wait for a worker; more are refused
MOST_JOBS = 500  # after which a worker is replaced, whatever caches it has filled
TRIES = 2  # of a job whose worker dies before it has said anything
MAX_TAB = 64  # characters of the name of a tab
MAX_SEQUENCE = 2**53  # up to which a browser counts
BUSY = "required fewer requests at once"

Answer = Callable[[Request], Awaitable[Response]]


@dataclass(frozen=True)
class Settings:
    """How the server runs.

    Attributes:
        token: that requests must bear.
        port: on which it listens.
        workers: how many processes compute.
        scene: what the command line named, if anything.
    """

    token: str
    port: int
    workers: int = 3
    scene: str | None = None


def build_app(settings: Settings) -> Starlette:
    """The application."""
    pool = WorkerPool(serve_page, settings.workers, preload=WARM, most_jobs=MOST_JOBS)
    routes = Routes(Jobs(pool), settings)

    @asynccontextmanager
    async def life(app: Starlette) -> AsyncIterator[None]:
        del app
        pool.start()
        try:
            yield
        finally:
            pool.close()

    middleware = [Middleware(RequestGuard, token=settings.token, port=settings.port)]
    handlers = {HTTPException: _unknown}
    return Starlette(routes=routes.table(), middleware=middleware, exception_handlers=handlers, lifespan=life)


async def _unknown(request: Request, error: Exception) -> Response:
    """A path or a method that there is not."""
    del request
    status = error.status_code if isinstance(error, HTTPException) else 500
    return JSONResponse({"error": "required a path and a method of the workbench"}, status)


class Jobs:
    """Jobs of the page: a newer view of a tab cancels the older one, and what stops a job is told in its messages."""

    def __init__(self, pool: WorkerPool) -> None:
        self._pool = pool
        self._tabs: dict[str, asyncio.Event] = {}

    @property
    def is_full(self) -> bool:
        """Whether more jobs wait than are kept."""
        return self._pool.waiting >= MOST_WAITING

    async def lines(self, name: str, body: bytes, tab: str | None = None) -> AsyncGenerator[bytes, None]:
        """The messages of a job, each one line of JSON; the last one is of stage ``done`` or ``cancelled``.

        Args:
            name: of the job.
            body: of the request.
            tab: whose older job this one cancels.
        """
        cancelled = self._begin(tab)
        try:
            async with aclosing(self._tried(name, body, cancelled)) as messages:
                async for message in messages:
                    yield message
        except JobTimeoutError:
            yield _error(
                f"required a scene whose view takes at most {SECONDS[name]:g} s, received one that takes longer"
            )
            yield encoded({"stage": "done"})
        except DiedError:
            yield _error("the process of this computation ended (killed, or out of memory); try again")
            yield encoded({"stage": "done"})
        except StoppedError:
            yield encoded({"stage": CANCELLED})
        finally:
            if tab is not None and self._tabs.get(tab) is cancelled:
                del self._tabs[tab]

    async def _tried(self, name: str, body: bytes, cancelled: asyncio.Event) -> AsyncGenerator[bytes, None]:
        """The messages of a job; where its worker is killed before the first one, once more by another worker."""
        for left in reversed(range(TRIES)):
            has_begun = False
            run = self._pool.run(name.encode() + b"\n" + body, seconds=SECONDS[name], cancelled=cancelled)
            try:
                async with aclosing(run) as messages:
                    async for message in messages:
                        has_begun = True
                        yield message
            except DiedError:
                if has_begun or not left:
                    raise
            else:
                return

    def _begin(self, tab: str | None) -> asyncio.Event:
        """The event that cancels a new job of a tab; that of its older job is set."""
        cancelled = asyncio.Event()
        if tab is not None:
            older = self._tabs.pop(tab, None)
            if older is not None:
                older.set()
            self._tabs[tab] = cancelled
        return cancelled


def _error(text: str) -> bytes:
    return encoded({"stage": "error", "message": text, "key": None})


class Routes:
    """What is answered at which path."""

    def __init__(self, jobs: Jobs, settings: Settings) -> None:
        self._jobs, self._settings = jobs, settings
        self._started = secrets.token_hex(8)
        self._files = {path.name: path.read_bytes() for path in PAGE.iterdir() if path.suffix in TYPES}

    def table(self) -> list[Route]:
        """All routes."""
        return [
            Route("/", self.index),
            Route("/page/{name}", self.file),
            Route("/api/health", self.health),
            Route("/api/scenes", self.scenes),
            Route("/api/scenes/{name:path}", self.scene),
            Route("/api/open", self.open, methods=["POST"]),
            Route("/api/view", self.view, methods=["POST"]),
            Route("/api/edit", self.edit, methods=["POST"]),
            Route("/api/export", self.export, methods=["POST"]),
        ]

    async def index(self, request: Request) -> Response:
        """The page."""
        del request
        return self._file("index.html")

    async def file(self, request: Request) -> Response:
        """A file of the page, one of those read at the start."""
        return self._file(request.path_params["name"])

    def _file(self, name: str) -> Response:
        content = self._files.get(name)
        if content is None:
            return JSONResponse({"error": "required a file of the page"}, 404)
        return Response(content, media_type=TYPES[Path(name).suffix])

    async def health(self, request: Request) -> Response:
        """Which run of the server this is."""
        del request
        return JSONResponse({"started": self._started})

    async def scenes(self, request: Request) -> Response:
        """The built-in scenes, the contact rules, and what the command line named."""
        del request
        answer = await self._answer("scenes", b"")
        if isinstance(answer, Response):
            return answer
        return JSONResponse({**answer, "opened": self._settings.scene, "version": own_version()})

    async def scene(self, request: Request) -> Response:
        """The document of a built-in scene, or of the one that the command line named."""
        name = request.path_params["name"]
        return await self._one("file" if name == self._settings.scene else "scene", name.encode())

    async def open(self, request: Request) -> Response:
        """The document of a text."""
        return await self._one("open", await request.body())

    async def edit(self, request: Request) -> Response:
        """A document after an exact edit."""
        return await self._one("edit", await request.body())

    async def export(self, request: Request) -> Response:
        """A file as an attachment."""
        answer = await self._answer("export", await request.body())
        if isinstance(answer, Response):
            return answer
        headers = {"Content-Disposition": f'attachment; filename="{answer["name"]}"'}
        return Response(base64.b64decode(answer["content"]), headers=headers, media_type=answer["type"])

    async def view(self, request: Request) -> Response:
        """The stages of a view, line by line."""
        body = await request.body()
        try:
            read = read_request(body)
        except RequestError as error:
            return refused(400, str(error))
        tab, sequence = read.get("tab"), read.get("sequence")
        if not isinstance(tab, str) or not 0 < len(tab) <= MAX_TAB:
            return refused(400, f"tab: required a text of 1 to {MAX_TAB} characters")
        if not isinstance(sequence, int) or not 0 <= sequence <= MAX_SEQUENCE:
            return refused(400, f"sequence: required an integer from 0 to {MAX_SEQUENCE}")
        if self._jobs.is_full:
            return refused(503, BUSY)
        stages = _numbered(self._jobs.lines("view", body, tab), sequence)
        return StreamingResponse(stages, media_type="application/x-ndjson")

    async def _one(self, name: str, body: bytes) -> Response:
        """The one answer of a job as JSON."""
        answer = await self._answer(name, body)
        return answer if isinstance(answer, Response) else JSONResponse(answer)

    async def _answer(self, name: str, body: bytes) -> Response | Record:
        """The one answer of a job, or why there is none."""
        if self._jobs.is_full:
            return refused(503, BUSY)
        async with aclosing(self._jobs.lines(name, body)) as lines:
            answer: Record = json.loads(await anext(lines))
        if answer.get("stage") == "error":
            return JSONResponse({"error": answer["message"], "key": answer["key"]}, 400)
        return answer


async def _numbered(lines: AsyncGenerator[bytes, None], sequence: int) -> AsyncIterator[bytes]:
    """Messages with the number of their request in its tab."""
    async with aclosing(lines):
        async for line in lines:
            yield b'{"sequence":%d,' % sequence + line.removeprefix(b"{")


# ---- running the server --------------------------------------------------------------------------


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
