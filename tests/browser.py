"""Headless Chromium for the tests of pages, pages opened from files, and what is asked of how they look."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pytest

if TYPE_CHECKING:  # not installed beside the oldest libraries
    from playwright.sync_api import Browser, BrowserContext, Page

# The one without windows first: it draws the same pages in half the processor time.
BROWSERS = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
CHROMIUM = next((path for path in map(shutil.which, BROWSERS) if path), None)
needs_chromium = pytest.mark.skipif(
    CHROMIUM is None,
    reason="no Chromium: none of " + ", ".join(BROWSERS) + " is on the path (`make tools` tries)",
)
OPTIONS = [
    "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
    "--in-process-gpu", "--renderer-process-limit=1",  # fewer processes to start for every page
]  # fmt: skip
NARROW, WIDE = 400, 1400  # a phone, a desk
READABLE = 4.5  # contrast of small text to its ground (WCAG 2, level AA)
PATIENCE = 8_000  # milliseconds for an element of a local file to appear
SLACK = 0.5  # pixels of rounding in layout

# Elements that reach beyond the window although no ancestor scrolls them.
STICKING_OUT = """() => {
    const auto = (e) => ['auto', 'scroll'].includes(getComputedStyle(e).overflowX);
    const scrolls = (e) => e && (auto(e) || scrolls(e.parentElement));
    const beyond = (e) => e.getBoundingClientRect().right > innerWidth + SLACK && !scrolls(e.parentElement);
    return [...document.querySelectorAll('main *, nav *')].filter(beyond).map((e) => e.outerHTML.slice(0, 120));
}""".replace("SLACK", str(SLACK))
CONTRAST = """(e) => {
    const part = (v) => (v / 255 <= 0.04045 ? v / 255 / 12.92 : ((v / 255 + 0.055) / 1.055) ** 2.4);
    const numbers = (c) => c.match(/[\\d.]+/g).map(Number);
    const light = ([r, g, b]) => 0.2126 * part(r) + 0.7152 * part(g) + 0.0722 * part(b);
    const ground = (e) => { const c = getComputedStyle(e).backgroundColor;
        return numbers(c)[3] === 0 && e.parentElement ? ground(e.parentElement) : c; };
    const tone = e.closest('svg') ? getComputedStyle(e).fill : getComputedStyle(e).color;
    const [a, b] = [light(numbers(tone)), light(numbers(ground(e)))].sort((x, y) => y - x);
    return (a + 0.05) / (b + 0.05);
}"""


@contextmanager
def chromium() -> Iterator[Browser]:
    """Headless Chromium."""
    from playwright.sync_api import sync_playwright

    options = [*OPTIONS, *(["--no-sandbox"] if os.geteuid() == 0 else [])]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        try:
            yield browser
        finally:
            browser.close()


class Opened:
    """A page of a local file, with what it said and asked for while it was open."""

    def __init__(self, context: BrowserContext, path: Path) -> None:
        self.said: list[str] = []
        self.asked: list[str] = []
        self.page: Page = context.new_page()
        self.page.set_default_timeout(PATIENCE)
        self.page.on("console", lambda message: self.said.append(message.text))
        self.page.on("pageerror", lambda error: self.said.append(str(error)))
        self.page.on("request", lambda request: self.asked.append(request.url))
        self.page.goto(path.as_uri())


def opened(browser: Browser, path: Path, width: int = WIDE, **options: Any) -> Opened:
    """The page of a file in a window of that width, in a context of its own."""
    return Opened(browser.new_context(viewport={"width": width, "height": 900}, **options), path)
