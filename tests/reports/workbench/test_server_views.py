"""The stages of a view over HTTP: what they say, and that newer ones cancel older ones."""

from __future__ import annotations

import math
import os
import signal
import threading

import pytest

from tests.thorough import keep
from tests.workbench_server import Workbench

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


def test_tabs_do_not_disturb_each_other(server: Workbench) -> None:
    documents = {name: server.document(name) for name in ("four-wheel", "ring-3")}
    counts: dict[str, set[int]] = {name: set() for name in documents}

    def drag(name: str) -> None:
        for k in range(10):
            stages = server.view(documents[name], tab=name, sequence=k, want=[])
            counts[name].add(len(stages["fast"]["wheels"]))
            assert stages["exact"]["sequence"] == k

    threads = [threading.Thread(target=drag, args=(name,)) for name in documents]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert counts == {"four-wheel": {4}, "ring-3": {3}}


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
