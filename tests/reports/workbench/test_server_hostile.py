"""Requests that are not the page's own, or ask for too much: refused in bounded time, and the server goes on."""

from __future__ import annotations

import json
import socket
import time
from collections.abc import Iterator

import pytest

from tests.workbench_server import Json, SlowBody, Workbench

BOUND = 60.0  # seconds, on a busy machine: what is refused unread takes milliseconds
WHEELS = [{"position": [1, 1]}, {"position": [-1, 1]}, {"position": [-1, -1]}, {"position": [1, -1]}]
SCENE: Json = {"name": "s", "friction": {"mu_roll": 1, "mu_side": "1/2"}, "wheel": WHEELS}


@pytest.fixture(autouse=True)
def bounded(server: Workbench) -> Iterator[None]:
    """Every one of these ends soon, and the server still answers."""
    began = time.monotonic()
    yield
    assert time.monotonic() - began < BOUND
    assert server.ask("/api/health").status == 200


@pytest.mark.parametrize("host", ["evil.example", "evil.example:80", "127.0.0.1", "127.0.0.1:1", ""])
def test_another_host_is_refused(server: Workbench, host: str) -> None:
    reply = server.ask("/", headers={**server.headers, "Host": host})
    assert reply.status == 421


def test_both_names_of_this_machine_are_answered(server: Workbench) -> None:
    for name in ("127.0.0.1", "localhost"):
        assert server.ask("/api/health", headers={**server.headers, "Host": f"{name}:{server.port}"}).status == 200


@pytest.mark.parametrize("origin", ["http://evil.example", "null", "https://127.0.0.1", "http://127.0.0.1:1"])
def test_a_foreign_origin_is_refused(server: Workbench, origin: str) -> None:
    assert server.ask("/api/health", headers={**server.headers, "Origin": origin}).status == 403


def test_a_request_from_another_site_is_refused(server: Workbench) -> None:
    assert server.ask("/api/health", headers={**server.headers, "Sec-Fetch-Site": "cross-site"}).status == 403


@pytest.mark.parametrize("given", [None, "", "Bearer", "Bearer ", "Bearer wrong", "Basic {token}", "{token}"])
def test_without_the_token_nothing_is_told(server: Workbench, given: str | None) -> None:
    headers = {} if given is None else {"Authorization": given.format(token=server.token)}
    for path in ("/api/health", "/api/scenes", "/api/scenes/four-wheel", "/api/none"):
        assert server.ask(path, headers=headers).status == 401


def test_the_token_does_not_count_in_the_address(server: Workbench) -> None:
    assert server.ask(f"/api/health?token={server.token}", headers={}).status == 401


@pytest.mark.parametrize(
    "path",
    [
        "/page/../app.py",
        "/page/..%2fsafety.py",
        "/page/%2e%2e/app.py",
        "/page//etc/passwd",
        "/page/py.typed",
        "/../../etc/passwd",
    ],
)
def test_no_path_of_a_request_is_opened(server: Workbench, path: str) -> None:
    assert server.ask(path).status == 404


@pytest.mark.parametrize("name", ["..%2ffour-wheel", "%2fetc%2fpasswd", "my.toml", "husky-a200"])
def test_scenes_are_built_in_names(server: Workbench, name: str) -> None:
    reply = server.ask(f"/api/scenes/{name}")
    assert reply.status in {400, 404}
    assert set(reply.json) <= {"error", "key"}


def test_a_large_body_is_refused_unread(server: Workbench) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=BOUND) as connection:
        connection.sendall(server.head("Content-Length: 104857600"))
        assert b" 413 " in connection.recv(4096)


def test_a_large_body_without_a_length_is_refused_while_it_comes(server: Workbench) -> None:
    with socket.create_connection(("127.0.0.1", server.port), timeout=BOUND) as connection:
        connection.sendall(server.head("Transfer-Encoding: chunked"))
        chunk = b"10000\r\n" + b" " * 0x10000 + b"\r\n"
        sent = 0
        try:
            while sent < 100 << 20:
                connection.sendall(chunk)
                sent += len(chunk)
        except OSError:
            pass
        assert sent < 20 << 20


def test_a_slow_body_is_given_up(slow_body: SlowBody) -> None:
    assert b" 408 " in slow_body.answer()


@pytest.mark.parametrize(
    "body",
    [
        b"",
        b"{",
        b"[1]",
        b'"text"',
        b"\xff\xfe",
        b"[" * 200_000,
        b'{"a":' * 100_000,
        b'{"tab":"t","sequence":NaN}',
        b'{"tab":"t","sequence":' + b"9" * 100_000 + b"}",
        b'{"tab":"t","sequence":1,"document":[' + b"0," * 100_000 + b"0]}",
        b'{"tab":"t","sequence":1,"document":{"name":"' + b"x" * 100_000 + b'"}}',
        b'{"tab":7,"sequence":1}',
        b'{"tab":"","sequence":1}',
        b'{"tab":"t","sequence":"1"}',
        b'{"tab":"t","sequence":-1}',
    ],
)
def test_what_is_no_request_is_refused(server: Workbench, body: bytes) -> None:
    for path in ("/api/view", "/api/edit", "/api/open", "/api/export"):
        reply = server.ask(path, body)
        assert reply.status == 400
        assert "\n" not in reply.json["error"]


@pytest.mark.parametrize(
    "formula",
    [
        "9**9**9",
        "9**9**9**9",
        "10**10000000",
        "2**64**64",
        "1e999999999",
        "sqrt(" * 20 + "2" + ")" * 20,
        "sqrt(2)+" * 100 + "1",
        "(" * 1_500 + "1" + ")" * 1_500,
        "+".join(f"sqrt({p})" for p in (2, 3, 5, 7, 11, 13, 17, 19, 23, 29)),
        "cos(pi/359)*cos(pi/353)*cos(pi/349)",
        "__import__('os').system('true')",
        "open('/etc/passwd')",
        "1/0",
        "nan",
        "inf",
        "x",
        "",
    ],
)
def test_a_formula_bomb_is_refused(server: Workbench, formula: str) -> None:
    wheel = {"position": [formula, 1], "speed": formula}
    stages = server.view({**SCENE, "wheel": [wheel, *WHEELS[1:]]}, want=[])
    assert "exact" not in stages
    assert set(stages) == {"error", "done"}
    assert "\n" not in stages["error"]["message"]


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"wheel": [{"position": [k, 1]} for k in range(401)]}, "wheel"),
        ({"wheel": None, "ring": {"count": 401}}, "ring"),
        ({"wheel": None, "grid": {"rows": 100_000, "columns": 1}}, "grid"),
        ({"wheel": None, "grid": {"rows": 10**9, "columns": 10**9}}, "grid"),
        ({"wheel": None, "wheels": {"file": "/etc/passwd"}}, "wheels"),
        ({"wheel": None, "wheels": {"file": "../secret.csv"}}, "wheels"),
        ({"vehicle": {"urdf": "/etc/passwd"}}, "vehicle"),
    ],
)
def test_too_many_wheels_and_named_files_are_refused(server: Workbench, change: Json, key: str) -> None:
    document = {name: value for name, value in {**SCENE, **change}.items() if value is not None}
    stages = server.view(document)
    assert stages["error"]["key"] == key
    reply = server.ask("/api/export", {"document": document, "kind": "toml"})
    assert reply.status == 400
    assert "root:" not in reply.body.decode()


def test_a_hundred_thousand_wheels_are_refused(server: Workbench) -> None:
    head = '{"tab":"t","sequence":1,"document":{"wheel":['
    short = head + ",".join(["[]"] * 100_000) + "]}}"
    assert server.ask("/api/view", short.encode()).status == 400
    with socket.create_connection(("127.0.0.1", server.port), timeout=BOUND) as connection:
        connection.sendall(server.head(f"Content-Length: {100_000 * len(json.dumps(WHEELS[0]))}") + head.encode())
        assert b" 413 " in connection.recv(4096)


def test_a_file_is_opened_as_text_and_never_by_its_path(server: Workbench) -> None:
    for text in ("/etc/passwd", "[wheels]\nfile = '/etc/passwd'", "[vehicle]\nurdf = 'x'", "x = 1", "a = [" * 2_000):
        reply = server.ask("/api/open", {"toml": text})
        assert reply.status == 400
        assert "root:" not in reply.body.decode()
    assert server.ask("/api/open", {"path": "/etc/passwd"}).status == 400


@pytest.mark.parametrize("method", ["PUT", "DELETE", "OPTIONS", "PATCH", "TRACE", "GET"])
def test_other_methods_are_refused(server: Workbench, method: str) -> None:
    assert server.ask("/api/view", b"{}", method=method).status == 405


def test_the_page_may_ask_only_its_own_server(server: Workbench) -> None:
    reply = server.ask("/", headers={})
    assert reply.status == 200
    policy = reply.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert reply.headers["referrer-policy"] == "no-referrer"
    assert reply.headers["x-content-type-options"] == "nosniff"
    assert server.token not in reply.body.decode()
