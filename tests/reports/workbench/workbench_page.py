"""A running workbench and its page in Chromium, for the tests of the page."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, ViewportSize

from tests.workbench_server import Json, Workbench

PATIENCE = 30_000  # milliseconds for an element to appear: other work may run beside the tests
DESK: ViewportSize = {"width": 1400, "height": 900}


@contextmanager
def running(folder: Path) -> Iterator[Workbench]:
    """A server that ends with the block."""
    server = Workbench(folder)
    try:
        yield server
    finally:
        server.stop()


class Opened:
    """A page of the workbench, with what it said and whom it asked."""

    def __init__(self, browser: Browser, address: str, **options: Any) -> None:
        self.context = browser.new_context(**{"viewport": DESK, **options})
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page = self.tab(address)

    def tab(self, address: str) -> Page:
        """Another tab of the same browser."""
        page = self.context.new_page()
        page.set_default_timeout(PATIENCE)
        page.on("console", lambda message: self.said.append(message.text))
        page.on("pageerror", lambda error: self.said.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))
        page.goto(address)
        proved(page)
        return page


def proved(page: Page) -> None:
    """Wait until exact answers about the present scene are shown."""
    page.locator("#status[data-state=exact]").wait_for()


WAIT = """(text) => new Promise((ready, fail) => { const began = performance.now(); const holds = {
    idle: () => !workbench.conversation.flight && !workbench.results.stale.has("checked"),
    moved: () => workbench.store.past.length !== window.steps,
  }[text];
  const look = () => { if (holds()) requestAnimationFrame(() => ready(true));
      else if (performance.now() - began > 20000) fail(new Error(`waited for ${text}`)); else setTimeout(look, 10); };
  look(); })"""


def settled(page: Page) -> None:
    """Wait until nothing about the present scene is being asked any more, and the drawing shows it."""
    page.evaluate("() => new Promise(requestAnimationFrame)")
    page.evaluate(WAIT, "idle")


def edited(page: Page, edit: Callable[[], object]) -> Json:
    """Do something that is one step of undo; wait for it, and return the document after it."""
    page.evaluate("() => { window.steps = workbench.store.past.length; }")
    edit()
    page.evaluate(WAIT, "moved")
    return document(page)


def document(page: Page) -> Json:
    """The scene as the page holds it."""
    found: Json = page.evaluate("() => workbench.store.document")
    return found


def place(page: Page, script: str) -> tuple[float, float]:
    """Pixels of the window where a point of the drawing is; ``script`` gives its pixels in the drawing."""
    x, y = page.evaluate(f"""() => {{ const box = workbench.drawing.element.getBoundingClientRect();
        const {{ drawing }} = workbench; const [x, y] = {script}; return [x + box.left, y + box.top]; }}""")
    return x, y


def drag(page: Page, script: str, by: tuple[float, float], *, steps: int = 4) -> None:
    """Drag what is at a place of the drawing by some pixels."""
    x, y = place(page, script)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + by[0], y + by[1], steps=steps)
    page.evaluate("() => new Promise(requestAnimationFrame)")
    page.mouse.up()
