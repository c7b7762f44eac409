"""What is opened and saved over HTTP."""

from __future__ import annotations

import json
from pathlib import Path
from urllib.parse import quote

import pytest

from nonsmooth.reports.interface.load import load
from nonsmooth.reports.workbench.documents import document_of, opened
from tests.thorough import keep, thorough
from tests.workbench_server import Workbench

ENDS = {
    "toml": (".toml", "application/toml"),
    "report": (".html", "text/html"),  # in `make test` by test_page.py: test_the_report_is_a_page_of_its_own
    "figure": (".svg", "image/svg+xml"),
    "json": (".json", "application/json"),
    "certificate": (".json", "application/json"),
}


@pytest.mark.parametrize("kind", [k if k != "report" else pytest.param(k, marks=thorough) for k in ENDS])
def test_an_array_is_saved_as(server: Workbench, kind: str) -> None:
    reply = server.ask("/api/export", {"document": server.document("ring-3"), "kind": kind})
    suffix, media = ENDS[kind]
    assert reply.status == 200
    assert reply.headers["content-type"].startswith(media)
    assert reply.headers["content-disposition"] == f'attachment; filename="ring-3{suffix}"'
    assert len(reply.body) > 100


def test_a_scene_file_comes_back_byte_for_byte(server: Workbench) -> None:
    document = server.document("ring-5")
    document["wheel"][0]["position"] = [0.95, "1/3"]
    text = server.ask("/api/export", {"document": document, "kind": "toml"}).body
    again = server.ask("/api/open", {"toml": text.decode()}).json["document"]
    assert server.ask("/api/export", {"document": again, "kind": "toml"}).body == text


def test_the_record_is_that_of_the_command(server: Workbench) -> None:
    found = json.loads(server.ask("/api/export", {"document": document_of("ring-3"), "kind": "json"}).body)
    expected = json.loads(json.dumps(load("ring-3").check().to_dict()))
    for record in (found, expected):
        record.pop("seconds")
    assert found == expected


def test_the_name_of_a_file_is_plain(server: Workbench) -> None:
    document = {**server.document("four-wheel"), "name": '../x"; filename="é'}
    reply = server.ask("/api/export", {"document": document, "kind": "toml"})
    assert reply.headers["content-disposition"] == 'attachment; filename="x-filename.toml"'


def test_what_there_is_not_is_refused(server: Workbench) -> None:
    for kind in ("exe", None, 7):
        assert server.ask("/api/export", {"document": server.document("eq-3"), "kind": kind}).status == 400
    without_cells = {**server.document("ring-3"), "contact": {"rule": "ellipse"}}
    assert server.ask("/api/export", {"document": without_cells, "kind": "certificate"}).status == 400


@pytest.mark.parametrize("kind", keep(3, ["toml", "json", "certificate", "report"]))
def test_a_plain_system_is_saved_as(server: Workbench, kind: str) -> None:
    reply = server.ask("/api/export", {"document": server.document("relay-oscillator-damped"), "kind": kind})
    assert reply.status == 200
    assert reply.headers["content-disposition"].endswith(f'{ENDS[kind][0]}"')


def test_an_edit_is_exact(server: Workbench) -> None:
    document = server.document("four-wheel")
    reply = server.ask("/api/edit", {"document": document, "operation": {"kind": "rotate", "angle": "30 deg"}})
    assert reply.json["wheels"] == [1, 2, 3, 4]
    assert reply.json["document"]["wheel"][0]["position"] == ["-1/2 + sqrt(3)/2", "1/2 + sqrt(3)/2"]
    assert opened(reply.json["document"])


def test_everything_built_in_is_listed(server: Workbench) -> None:
    found = server.ask("/api/scenes").json
    assert {"four-wheel", "flower"} <= {scene["name"] for scene in found["scenes"]}
    assert {rule["name"] for rule in found["rules"]} == {"nearest", "box", "ellipse", "roller"}
    assert found["opened"] is None


def test_a_file_in_another_folder_is_opened(tmp_path: Path) -> None:
    """Its address has slashes, which are those of a route, too: the usual scene was shown in its place."""
    file = tmp_path / "table.toml"
    file.write_text(
        "grid = { rows = 2, columns = 2, pitch = 1 }\nfriction = { mu_roll = 1, mu_side = 1 }\n", encoding="utf-8"
    )
    running = Workbench(tmp_path, str(file))
    try:
        assert running.ask("/api/scenes").json["opened"] == str(file)
        reply = running.ask(f"/api/scenes/{quote(str(file), safe='')}")
        assert (reply.status, len(reply.json["document"]["wheel"])) == (200, 4)
    finally:
        running.stop()
