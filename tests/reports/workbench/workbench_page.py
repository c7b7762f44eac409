"""A running workbench and Chromium, for the tests of the page: one server and one browser for each module."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from playwright.sync_api import Browser, Page, sync_playwright

CHROMIUM = next((p for p in map(shutil.which, ("chromium", "chromium-browser", "google-chrome")) if p), None)
NO_CHROMIUM = "no Chromium: chromium or google-chrome is not on the path (`make tools` tries)"
OPTIONS = [
    "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
    "--disable-component-update", "--disable-sync",
]  # fmt: skip
PATIENCE = 30_000  # milliseconds for an element to appear: other work may run beside the tests
DESK = {"width": 1400, "height": 900}


class Server:
    """``nonsmooth workbench`` as a process of its own; its token is kept in a folder, as between two runs."""

    def __init__(self, folder: Path, port: int = 0, scene: str = "four-wheel") -> None:
        self.folder, self.scene = folder, scene
        self.address = self.start(port)

    def start(self, port: int) -> str:
        """Start the server; returns the address that it prints."""
        line = [sys.executable, "-m", "nonsmooth.reports.cli", "workbench", self.scene]
        line += ["--no-browser", "--port", str(port)]
        environment = {**os.environ, "XDG_STATE_HOME": str(self.folder)}
        self.log = (self.folder / "log").open("ab")
        self.process = subprocess.Popen(line, stdout=subprocess.PIPE, stderr=self.log, env=environment, text=True)
        assert self.process.stdout is not None
        self.address = self.process.stdout.readline().strip()
        assert self.address.startswith("http://127.0.0.1:"), (self.folder / "log").read_text(encoding="utf-8")
        return self.address

    @property
    def port(self) -> int:
        """On which it listens."""
        return int(self.address.split(":")[2].split("/")[0])

    def kill(self) -> None:
        """End the process at once."""
        self.process.send_signal(signal.SIGKILL)
        self.process.wait()

    def close(self) -> None:
        """End the process as Ctrl+C does."""
        self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(10)
        except subprocess.TimeoutExpired:
            self.kill()
        self.log.close()


@contextmanager
def running(folder: Path) -> Iterator[Server]:
    """A server that ends with the block."""
    server = Server(folder)
    try:
        yield server
    finally:
        server.close()


@contextmanager
def chromium() -> Iterator[Browser]:
    """Headless Chromium."""
    options = [*OPTIONS, *(["--no-sandbox"] if os.geteuid() == 0 else [])]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=options)
        try:
            yield browser
        finally:
            browser.close()


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


def settled(page: Page) -> None:
    """Wait until nothing of the present scene is being asked any more."""
    proved(page)
    script = "() => workbench.results.finished && !workbench.conversation.flight"
    page.evaluate(f"""() => new Promise((ready) => {{
        const look = () => (({script})() ? ready() : setTimeout(look, 20));
        look();
    }})""")
