"""How long the workbench takes from a pointer move to new cells and answers, in Chromium, over 200 drags.

Two ways of dragging. *Step by step*: the next move comes when the answers to the last are there. *Flowing*: a move
every 16 ms, as a hand makes them; moves that a newer one overtakes are never asked for, and the time counts from the
newest move that a reply is about. Times end when the frame with the new cells is on the screen.
"""

from __future__ import annotations

import math
import os
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest
from playwright.sync_api import Browser, Page

from tests.browser import chromium, needs_chromium
from tests.reports.workbench.workbench_page import Opened, running, settled
from tests.workbench_server import Workbench

pytestmark = needs_chromium

MOVES = 200
SCENES = {"four-wheel": (60, 120), "grid-4x4": (250, 250)}  # milliseconds: median, 95 %
LONGEST_TASK = 100  # milliseconds that the page's own work may hold up a frame
RADIUS = 30  # pixels of the circle on which the wheel is dragged

# Watches pointer moves, requests, replies, painted frames, and tasks and frames of more than 50 ms.
WATCH = """() => {
    const seen = { move: 0, sent: {}, rows: [], frames: [], tasks: [] };
    window.watch = seen;
    for (const name of ['pointermove', 'pointerrawupdate'])
        addEventListener(name, (event) => { seen.move = event.timeStamp; }, true);
    const { conversation, results } = workbench;
    conversation.addEventListener('asked', ({ detail }) => { seen.sent[detail.sequence] = seen.move; });
    results.addEventListener('change', ({ detail }) => {
        if (detail.stage !== 'fast' && detail.stage !== 'exact') return;
        if (results.geometry.geometry === 'later') return;
        const row = { stage: detail.stage, moved: seen.sent[results.sequence], took: results.took };
        requestAnimationFrame(() => { const { port1, port2 } = new MessageChannel();
            port1.onmessage = () => { row.shown = performance.now(); seen.rows.push(row); };
            port2.postMessage(null); });
    });
    const observe = (type, found) => new PerformanceObserver((list) =>
        found.push(...list.getEntries().map((entry) => entry.duration))).observe({ entryTypes: [type] });
    observe('longtask', seen.tasks);
    observe('long-animation-frame', seen.frames);
}"""
PLACE = """(k) => { const wheel = workbench.drawing.wheels()[k];
    const box = workbench.drawing.element.getBoundingClientRect();
    const [x, y] = workbench.drawing.view.at(wheel.x, wheel.y);
    return [x + box.left, y + box.top]; }"""
ANSWERED = """() => new Promise((ready) => { const began = performance.now();
    const look = () => { const answered = !workbench.results.stale.has('checked');
        if (answered || performance.now() - began > 5000) requestAnimationFrame(() => setTimeout(ready, 0));
        else setTimeout(look, 2); };
    requestAnimationFrame(() => requestAnimationFrame(look)); })"""


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workbench]:
    with running(tmp_path_factory.mktemp("state")) as server:
        yield server


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with chromium() as browser:
        yield browser


def opened(browser: Browser, server: Workbench, scene: str) -> Page:
    """The page with the scene, watched."""
    page = Opened(browser, server.address).page
    if scene != "four-wheel":
        page.select_option("#scene", scene)
        page.locator("#status[data-state=working]").wait_for(state="detached")
    settled(page)
    page.evaluate(WATCH)
    return page


def along(centre: tuple[float, float]) -> Iterator[tuple[float, float]]:
    """Places on a circle through the wheel's own; no two alike, so every move changes the scene."""
    x, y = centre
    for k in range(1, MOVES + 1):
        turn, radius = 2 * math.pi * k / 47, RADIUS * (1 + 0.3 * math.sin(k))
        yield x - radius + radius * math.cos(turn), y + radius * math.sin(turn)


def drag(page: Page, scene: str, *, flowing: bool) -> None:
    """One wheel, moved MOVES times."""
    x, y = page.evaluate(PLACE, 0)
    page.mouse.move(x, y)
    page.mouse.down()
    for place in along((x, y)):
        began = time.perf_counter()
        page.mouse.move(*place)
        if flowing:
            page.wait_for_timeout(max(0.0, 16 - 1000 * (time.perf_counter() - began)))
        else:
            page.evaluate(ANSWERED)
    page.mouse.up()
    settled(page)


def times(rows: list[dict[str, Any]], stage: str) -> Any:
    """Milliseconds from the pointer move to the frame that shows this stage."""
    return np.array([row["shown"] - row["moved"] for row in rows if row["stage"] == stage and row["moved"]])


def told(seen: dict[str, Any]) -> Iterator[str]:
    """What was measured, in words."""
    for stage in ("fast", "exact"):
        found = times(seen["rows"], stage)
        if len(found):
            reply = np.median([row["took"] for row in seen["rows"] if row["stage"] == stage])
            median, most = np.percentile(found, [50, 95])
            yield f"{stage}: reply after {reply:.0f} ms (median); {len(found)} shown, median {median:.0f} ms"
            yield f"{stage}: 95 % within {most:.0f} ms, the last after {found.max():.0f}"
    frame, task = (max(seen[kind], default=0) for kind in ("frames", "tasks"))
    yield f"{len(seen['frames'])} frames above 50 ms, the longest {frame:.0f}; longest task {task:.0f} ms"


@pytest.mark.parametrize("flowing", [False, True], ids=["step by step", "flowing"])
@pytest.mark.parametrize("scene", SCENES)
def test_cells_and_answers_follow_the_pointer(
    browser: Browser, server: Workbench, scene: str, flowing: bool, capsys: pytest.CaptureFixture[str]
) -> None:
    page = opened(browser, server, scene)
    load = os.getloadavg()[0]
    drag(page, scene, flowing=flowing)
    seen = page.evaluate("() => watch")
    page.context.close()
    with capsys.disabled():
        print(f"\n  {scene}, {'flowing' if flowing else 'step by step'}, load {load:.1f} on {os.cpu_count()} cores:")
        print("\n".join(f"    {line}" for line in told(seen)), end="")
    median, most = np.percentile(times(seen["rows"], "fast"), [50, 95])
    assert max(seen["tasks"], default=0) <= LONGEST_TASK
    assert median <= SCENES[scene][0]
    assert most <= SCENES[scene][1]
