"""A server that is killed and started again: pages and tokens outlive it, its workers do not."""

from __future__ import annotations

import time
from pathlib import Path

import pytest
from playwright.sync_api import Browser

from tests.browser import needs_chromium
from tests.reports.workbench.workbench_page import Opened, document, edited, settled
from tests.workbench_server import Workbench


@needs_chromium
def test_a_killed_server_is_told_and_the_page_goes_on(browser: Browser, server: Workbench) -> None:
    opened = Opened(browser, server.address)
    page, token, pids = opened.page, server.token, server.workers()
    page.keyboard.press("n")
    server.kill()
    edited(page, lambda: page.keyboard.press("ArrowRight"))
    page.locator("#banner").wait_for()
    assert "does not answer" in page.locator("#banner").inner_text()
    page.keyboard.press("ArrowUp")  # nothing stops the hand
    assert document(page)["wheel"][0]["position"] != [1, 1]
    server.start()
    page.locator("#banner").wait_for(state="hidden")
    settled(page)
    shown = page.evaluate("() => workbench.results.geometry.wheels[0].x")
    assert shown == pytest.approx(document(page)["wheel"][0]["position"][0])
    assert server.token == token
    assert not any(map(_lives, pids))
    opened.context.close()


def _lives(pid: int) -> bool:
    """Whether a process is still there after a while."""
    for _ in range(100):
        if not Path(f"/proc/{pid}").exists():
            return False
        time.sleep(0.1)
    return True
