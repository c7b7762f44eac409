"""What every request must satisfy before anything is done: own host and origin, a token, a body of moderate size."""

from __future__ import annotations

import asyncio
import hmac
from typing import Any

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

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


class Safety:
    """Refuse what is not the page's own.

    Args:
        app: what answers the rest.
        token: that every request to ``/api`` must bear.
        port: of the server; its hosts are 127.0.0.1 and localhost.
        body_seconds: within which a body must have arrived.
    """

    def __init__(self, app: ASGIApp, token: str, port: int, body_seconds: float = BODY_SECONDS) -> None:
        self._app, self._token, self._seconds = app, token.encode(), body_seconds
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
            async with asyncio.timeout(self._seconds):
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
            return refused(408, f"body: required within {self._seconds:g} s")


def refused(status: int, message: str) -> JSONResponse:
    """One line that says what is wrong; the connection is closed, since the rest of the body was not read."""
    return JSONResponse({"error": message}, status, {"Connection": "close"})


def _replayed(body: bytes, receive: Receive) -> Receive:
    """The body once, then what the connection says."""
    waiting: list[Any] = [{"type": "http.request", "body": body, "more_body": False}]

    async def replay() -> Message:
        return waiting.pop() if waiting else await receive()

    return replay
