"""One workbench and one page of it for all tests of this folder."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, Page

from tests.reports.workbench.workbench_page import Opened, settled
from tests.workbench_server import Json, SlowBody, Workbench


@pytest.fixture(scope="package")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Workbench]:
    running = Workbench(tmp_path_factory.mktemp("state"))
    try:
        yield running
    finally:
        assert running.stop() == 0
        assert "Traceback" not in running.log.read_text()


@pytest.fixture(scope="package", autouse=True)
def slow_body(server: Workbench) -> Iterator[SlowBody]:
    """Begun with the server, so that other tests run while it waits."""
    request = SlowBody(server)
    yield request
    request.close()


@pytest.fixture(scope="package")
def opened(browser: Browser, server: Workbench) -> Opened:
    """One page for all tests that need no other: opening it costs more than most of them."""
    return Opened(browser, server.address)


@pytest.fixture(scope="package")
def first_document(server: Workbench) -> Json:
    return server.document("four-wheel")


# What the page asks for beside cells and answers, from then on.
ASK_FOR = """(wanted) => { const { api } = workbench.conversation;
    const lines = Object.getPrototypeOf(api).lines.bind(api);
    const cut = (body) => ({ ...body, want: body.want.filter((part) => wanted.includes(part)) });
    api.lines = (path, body, ...more) => lines(path, path === "/api/view" ? cut(body) : body, ...more); }"""


@pytest.fixture
def page(opened: Opened, first_document: Json) -> Iterator[Page]:
    """The four-wheel array, nothing selected, no starts; no test may leave a word on the console.

    It asks for cells, answers and paths alone: the comparison of rules takes longer than all of these.
    """
    page = opened.page
    page.evaluate(ASK_FOR, ["paths"])
    page.evaluate("(first) => workbench.store.open(first, [])", first_document)
    settled(page)
    page.evaluate("() => { workbench.store.select([]); workbench.drawing.fit(); }")
    yield page
    page.unroute_all(behavior="wait")  # what a test answered in the server's place, also where it failed
    assert opened.said == []


@pytest.fixture
def all_stages(page: Page) -> None:
    """The page asks for all that it asks for by itself."""
    page.evaluate("() => { delete workbench.conversation.api.lines; workbench.conversation.refresh({ again: true }); }")
    settled(page)
