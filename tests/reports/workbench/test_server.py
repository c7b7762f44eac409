"""The server of the workbench: files, views, restarts, and workers without it."""

from __future__ import annotations

import json
import math
import os
import signal
import time
from multiprocessing import Pipe
from pathlib import Path
from urllib.parse import quote

import pytest
from playwright.sync_api import Browser

from nonsmooth.reports.interface.array import load
from nonsmooth.reports.workbench.documents import document_of, opened, written
from nonsmooth.reports.workbench.worker import answers
from tests.browser import needs_chromium
from tests.reports.workbench.workbench_page import Opened, document, edited, settled
from tests.thorough import keep, thorough
from tests.workbench_server import Workbench

# ---- The stages of a view over HTTP: what they say, and that newer ones cancel older ones --------

CORNERS = [[1, 1], [-1, 1], [-1, -1], [1, -1]]


def test_stages_come_in_order_with_their_number(server: Workbench) -> None:
    document = server.document("four-wheel")
    stages = server.stages(document, sequence=7, starts=[[0.2, 0.1, 0]], until=5)
    names = [stage["stage"] for stage in stages]
    assert names == ["fast", "exact", "paths", "facts", "equilibria", "comparison", "done"]
    assert {stage["sequence"] for stage in stages} == {7}
    fast, exact, paths = stages[:3]
    assert [[wheel["x"], wheel["y"]] for wheel in fast["wheels"]] == CORNERS
    assert all(guess["provisional"] for guess in fast["answers"])
    assert [answer["answer"] for answer in exact["answers"]] == ["comes home", "drifts", "can be held"]
    assert exact["verdict"] == "holds"
    (path,) = paths["paths"]
    assert path["x"][0] == 0.2
    assert math.hypot(path["x"][-1], path["y"][-1]) < 1e-9
    assert "rest" in {event["kind"] for event in path["events"]}


def test_cells_tile_the_square(server: Workbench) -> None:
    fast = server.view(server.document("four-wheel"), want=[])["fast"]
    area = sum(_area(cell["polygon"]) for cell in fast["cells"])
    assert area == pytest.approx((2 * fast["square"]["radius"]) ** 2)


def _area(polygon: list[list[float]]) -> float:
    after = [*polygon[1:], polygon[0]]
    return sum(a * d - b * c for (a, b), (c, d) in zip(polygon, after, strict=True)) / 2


def test_only_what_is_wanted_is_computed(server: Workbench) -> None:
    assert list(server.view(server.document("four-wheel"), want=[])) == ["fast", "exact", "done"]


def test_a_plain_system_has_a_portrait_and_level_sets(server: Workbench) -> None:
    stages = server.view(server.document("relay-oscillator-damped"), starts=[[0.3, 0.1]], until=3)
    assert len(stages["fast"]["system"]["states"]) == 2
    assert len(stages["fast"]["system"]["field"]) > 100
    assert stages["exact"]["verdict"] == "asymptotically stable"
    assert stages["exact"]["system"]["level_sets"]
    assert stages["paths"]["paths"][0]["error"] is None


def test_a_body_that_tips_says_so(server: Workbench) -> None:
    document = server.document("four-wheel")
    document["body"] = {"shape": "disc", "radius": "1/2"}
    stages = server.view(document)
    assert stages["exact"]["answers"][0]["answer"] == "tips"
    assert stages["fast"]["note"]


@pytest.mark.parametrize("rule", keep(1, ["nearest", "ellipse"]))
def test_tolerances_have_a_bound_and_a_factor(server: Workbench, rule: str) -> None:
    document = {**server.document("four-wheel"), "tolerance": {"position": "1/1000", "heading": "1/10 deg"}}
    document["contact"] = {"rule": rule}
    stages = server.view(document, want=["tolerance"])
    assert stages["tolerance"]["verdict"] == "certified"
    assert stages["tolerance"]["factor"] >= 1
    assert stages["tolerance"]["radius"] > 0


def test_rules_without_cells_have_sampled_geometry(server: Workbench) -> None:
    document = {**server.document("four-wheel"), "contact": {"rule": "ellipse"}}
    assert server.view(document)["fast"]["geometry"] == "sampled"


def test_what_is_wrong_names_its_key(server: Workbench) -> None:
    document = server.document("four-wheel")
    document["wheel"][1]["speed"] = "fast"
    error = server.view(document)["error"]
    assert error["key"] == "wheel.2.speed"
    assert "required" in error["message"]


def test_a_start_outside_the_square_spoils_no_other(server: Workbench) -> None:
    stages = server.view(server.document("four-wheel"), starts=[[9, 9, 0], [0.1, 0, 0]], want=["paths"])
    first, second = stages["paths"]["paths"]
    assert first["error"]
    assert second["error"] is None


@pytest.mark.parametrize("slow", ["flower", "grid-4x4"])
def test_a_newer_view_of_the_same_tab_cancels_the_older_one(server: Workbench, slow: str) -> None:
    document = server.document("four-wheel")
    with server.stream(server.document(slow), tab="cancelled", sequence=1) as older:
        assert next(older)["stage"] == "fast"
        newer = server.view(document, tab="cancelled", sequence=2, want=[])
        assert newer["exact"]["verdict"] == "holds"
        rest = [stage["stage"] for stage in older]
    assert rest[-1] == "cancelled"


def test_a_closed_connection_frees_its_worker(server: Workbench) -> None:
    document = server.document("flower")
    for k in range(6):
        with server.stream(document, tab=f"left-{k}", sequence=1) as stages:
            next(stages)
    assert server.view(server.document("four-wheel"), want=[])["exact"]["verdict"] == "holds"


def test_a_worker_that_is_killed_is_replaced(server: Workbench) -> None:
    for pid in server.workers():
        os.kill(pid, signal.SIGKILL)
    for k in range(4):
        document = server.document("four-wheel")
        assert server.view(document, tab=f"{k}", want=[])["exact"]["verdict"] == "holds"
    assert len(server.workers_left(3)) == 3


def test_the_token_is_the_user_s_own(server: Workbench) -> None:
    assert (server.state / "nonsmooth" / "workbench-token").stat().st_mode & 0o077 == 0


# ---- What is opened and saved over HTTP ----------------------------------------------------------

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
    assert found["opened"] == server.scene  # of which the command line named none, or the one below


# ---- A server that is killed and started again: pages and tokens outlive it, its workers do not.


@needs_chromium
def test_a_killed_server_is_told_and_the_page_goes_on(browser: Browser, server: Workbench, tmp_path: Path) -> None:
    """With the token that it has, which outlives the server, too; the workers do not.

    It is started again with a file in another folder, which does not take the place of what the page holds.
    """
    file = tmp_path / "table.toml"
    file.write_text(written({**document_of("four-wheel"), "friction": {"mu_roll": 1, "mu_side": 1}}), encoding="utf-8")
    opened = Opened(browser, server.address)
    page = opened.page
    token, began, pids = server.token, server.ask("/api/health").json["started"], server.workers()
    page.keyboard.press("n")
    server.kill()
    edited(page, lambda: page.keyboard.press("ArrowRight"))
    page.locator("#banner").wait_for()
    assert "does not answer" in page.locator("#banner").inner_text()
    page.keyboard.press("ArrowUp")  # nothing stops the hand
    assert document(page)["wheel"][0]["position"] != [1, 1]
    server.scene = str(file)
    server.start()
    assert server.token == token
    assert server.ask("/api/health").json["started"] != began
    page.locator("#banner").wait_for(state="hidden")
    settled(page)
    shown = page.evaluate("() => workbench.results.geometry.wheels[0].x")
    assert shown == pytest.approx(document(page)["wheel"][0]["position"][0])
    opened.context.close()
    assert not any(map(_lives, pids))
    assert_opened(server, file)


def assert_opened(server: Workbench, file: Path) -> None:
    """Its address has slashes, which are those of a route, too: the usual scene was shown in its place."""
    assert server.ask("/api/scenes").json["opened"] == str(file)
    reply = server.ask(f"/api/scenes/{quote(str(file), safe='')}")
    assert (reply.status, reply.json["document"]["friction"]) == (200, {"mu_roll": 1, "mu_side": 1})


def _lives(pid: int) -> bool:
    """Whether a process is still there after a while."""
    for _ in range(100):
        if not Path(f"/proc/{pid}").exists():
            return False
        time.sleep(0.1)
    return True


# ---- What a worker does when its server is gone --------------------------------------------------


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
