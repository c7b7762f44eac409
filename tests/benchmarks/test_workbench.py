"""The workbench under a hand: how soon cells and answers come, and what 10,000 edits leave behind."""

from __future__ import annotations

import copy
import random
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.random_edits import Hand
from tests.workbench_server import Json, Workbench, resident

DRAGS, EDITS, FIRST = 200, 10_000, 500
GROWTH = 50 << 20  # bytes
MOST = {
    "four-wheel": (60.0, 120.0),
    "grid-4x4": (250.0, 250.0),
}  # median and 95 %: milliseconds until cells and answers


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workbench]:
    running = Workbench(tmp_path_factory.mktemp("state"))
    try:
        yield running
    finally:
        assert running.stop() == 0


def drags(document: Json, seed: int) -> Iterator[Json]:
    """The scene with one wheel after the other somewhere near its place."""
    hand = random.Random(seed)
    while True:
        moved = copy.deepcopy(document)
        wheel = hand.choice(moved["wheel"])
        wheel["position"] = [f"({value}) + ({hand.uniform(-0.4, 0.4):.2f})" for value in wheel["position"]]
        yield moved


@pytest.mark.parametrize("name", MOST)
def test_cells_and_answers_come_soon(server: Workbench, name: str) -> None:
    documents = drags(server.document(name), seed=2)
    spent: dict[str, list[float]] = {"fast": [], "exact": [], "paths": []}
    for k in range(DRAGS):
        began = time.perf_counter()
        more: Json = {"want": ["paths"], "starts": [[0.2, 0.1, 0]]}
        with server.stream(next(documents), tab=name, sequence=k, **more) as stages:
            for stage in stages:
                spent.setdefault(stage["stage"], []).append(1e3 * (time.perf_counter() - began))
    for label, values in spent.items():
        middle, late = np.percentile(values, [50, 95])
        print(f"{name}: {label}, {len(values)} times: median {middle:.1f} ms, 95 % within {late:.1f} ms")
    middle, late = np.percentile(spent["fast"], [50, 95])
    assert middle <= MOST[name][0]
    assert late <= MOST[name][1]


def test_ten_thousand_edits_leave_nothing_behind(server: Workbench) -> None:
    hand = Hand(server, "four-wheel", seed=3)
    began = time.perf_counter()
    for _ in range(FIRST):
        hand.edit()
    before = _memory(server)
    for _ in range(EDITS - FIRST):
        hand.edit()
    growth = _memory(server) - before
    seconds = time.perf_counter() - began
    print(
        f"{EDITS} edits in {seconds:.0f} s: {hand.seen}; memory grew by {growth / 2**20:.1f} MB to "
        f"{(before + growth) / 2**20:.0f} MB"
    )
    assert len(server.workers_left(3)) == 3
    assert growth < GROWTH
    assert "Traceback" not in server.log.read_text()


def _memory(server: Workbench) -> int:
    """Of the server, the process that workers are forked from, and the workers, once they are at rest."""
    time.sleep(1)
    children = Path(f"/proc/{server.process.pid}/task/{server.process.pid}/children").read_text().split()
    return resident([server.process.pid, *map(int, children), *server.workers()])
