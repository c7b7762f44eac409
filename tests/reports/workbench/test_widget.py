"""The view in a notebook: one module without requests, answers of the workers' function, and the page's own drawing."""

from __future__ import annotations

import asyncio
import re
import sys
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import pytest
from playwright.sync_api import Browser, Page

import nonsmooth as ns
from nonsmooth.reports.workbench import notebook_view as notebook_module
from nonsmooth.reports.workbench.notebook_view import NotebookView
from tests.browser import needs_chromium

Json = dict[str, Any]

TRAITS = ("document", "starts", "until", "_styles", "_symbols")
NAMESPACE = "http://www.w3.org/2000/svg"
HTML = """<!doctype html><div id="cell"></div><script type="module">
import widget from "/widget.js";
const heard = {};
const traits = await window.traits();
window.model = {
    get: (name) => traits[name],
    set: (name, value) => { traits[name] = value; },
    save_changes: () => window.save(traits),
    on: (names, call) => names.split(" ").forEach((name) => { heard[name] = call; }),
    off: () => {},
    send: async (content) => { for (const message of await window.ask(content)) heard["msg:custom"](message); },
    become: (name, value) => { traits[name] = value; heard[`change:${name}`](); },
};
window.end = widget.render({ model, el: document.getElementById("cell") });
</script>"""


class Kernel:
    """A view outside of any notebook, and what it sends."""

    def __init__(self, name: str, **more: Any) -> None:
        self.view, self.sent = ns.widget(name, **more), list[Json]()
        self.view.send = lambda content, buffers=None: self.sent.append(content)

    def ask(self, content: Json) -> list[Json]:
        """The messages that answer a request."""
        first = len(self.sent)
        _in_a_thread(lambda: self.view._heard(self.view, content, []))
        return self.sent[first:]

    def save(self, traits: Json) -> None:
        """What the view has changed."""
        for name in TRAITS[:3]:
            setattr(self.view, name, traits[name])

    def look(self, number: int, document: Json, **more: Any) -> dict[str, Json]:
        """The stages of a view by their names."""
        body = {"document": document, "starts": [], "want": [], **more}
        found = self.ask({"id": number, "path": "/api/view", "body": body})
        assert {message["id"] for message in found} == {number}
        return {message["message"]["stage"]: message["message"] for message in found}


def _in_a_thread(work: Callable[[], object]) -> None:
    """Where no event loop runs: Playwright keeps one in this thread."""
    with ThreadPoolExecutor(1) as pool:
        pool.submit(work).result()


def test_a_view_is_answered_as_the_page_is() -> None:
    kernel = Kernel("four-wheel", start=(0.2, 0.1, 0.0))
    stages = kernel.look(1, kernel.view.document, starts=kernel.view.starts, want=["paths"])
    assert list(stages) == ["fast", "exact", "paths", "done"]
    assert [answer["answer"] for answer in stages["exact"]["answers"]] == ["comes home", "drifts", "can be held"]
    assert stages["fast"]["geometry"] == "exact"
    assert stages["paths"]["paths"][0]["error"] is None


def test_what_was_dragged_goes_on_in_python() -> None:
    kernel = Kernel("four-wheel")
    wheels = [dict(wheel) for wheel in kernel.view.document["wheel"]]
    wheels[0]["position"] = [1.25, "sqrt(3)/2"]
    kernel.view.document = {**kernel.view.document, "wheel": wheels}
    made = kernel.view.made
    assert isinstance(made, ns.Array)
    assert [str(value) for value in made.scene.wheels[0].position] == ["5/4", "sqrt(3)/2"]


def test_wrong_scenes_and_messages_are_told_in_a_line() -> None:
    kernel = Kernel("four-wheel")
    broken = {**kernel.view.document, "wheel": [{"position": ["9**9**9", 0]}]}
    stages = kernel.look(1, broken)
    assert list(stages) == ["error", "done"]
    assert "wheel[1].position" in stages["error"]["message"]
    assert kernel.ask({"id": 2, "path": "/api/export", "body": {}}) == []
    assert kernel.ask({"path": "/api/view"}) == []
    (reply, done) = kernel.ask({"id": 3, "path": "/api/edit", "body": {"document": {}, "operation": {"kind": "add"}}})
    assert (reply["message"]["stage"], done["message"]["stage"]) == ("error", "done")
    with pytest.raises(TypeError, match="required an array"):
        ns.widget(3)  # type: ignore[arg-type]


def test_a_newer_view_takes_the_place_of_an_older_one() -> None:
    kernel = Kernel("four-wheel")
    content = {"path": "/api/view", "body": {"document": kernel.view.document}}

    async def both() -> None:
        for number in (1, 2):
            kernel.view._heard(kernel.view, {"id": number, **content}, [])
            await asyncio.sleep(0)
        while kernel.view._tasks:
            await asyncio.sleep(0.01)

    _in_a_thread(lambda: asyncio.run(both()))
    ends = {message["id"]: message["message"]["stage"] for message in kernel.sent}
    assert ends == {1: "cancelled", 2: "done"}


def test_a_view_keeps_the_kernel_for_a_bounded_time(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(notebook_module, "SECONDS", 0.0)
    kernel = Kernel("four-wheel")
    stages = kernel.look(1, kernel.view.document)
    assert list(stages)[-2:] == ["error", "done"]
    assert "at most 0 s" in stages["error"]["message"]


def test_the_module_asks_for_nothing() -> None:
    text = NotebookView._esm
    assert isinstance(text, str)
    assert not re.search(r"^\s*import\b|\bimport\(|\bfetch\(|XMLHttpRequest|WebSocket", text, re.MULTILINE)
    assert set(re.findall(r"\w+://[^\s\"'`)]*", text + notebook_module.styles())) == {NAMESPACE}
    assert "@import" not in notebook_module.styles()
    assert "i-undo" in notebook_module.symbols()


@pytest.mark.parametrize("path", sorted(notebook_module.PAGE.glob("*.js")), ids=lambda path: path.stem)
def test_modules_keep_to_the_forms_that_are_bundled(path: Path) -> None:
    text = path.read_text(encoding="utf-8")
    assert len(re.findall(r"^import\b", text, re.MULTILINE)) == len(notebook_module.IMPORT.findall(text))
    assert len(re.findall(r"^export\b", text, re.MULTILINE)) == len(notebook_module.EXPORT.findall(text))
    assert not re.search(r"\bimport\(|\bimport\.meta\b", text)


@pytest.fixture
def cell(browser: Browser) -> Iterator[tuple[Page, Kernel, list[str]]]:
    """A page with one cell, whose widget asks a kernel in this process."""
    kernel, said = Kernel("four-wheel", start=(0.2, 0.1, 0.0)), list[str]()
    page = browser.new_context(viewport={"width": 1100, "height": 800}).new_page()
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.expose_function("traits", lambda: {name: getattr(kernel.view, name) for name in TRAITS})
    page.expose_function("save", kernel.save)
    page.expose_function("ask", kernel.ask)
    files = {"/": ("text/html", HTML), "/widget.js": ("text/javascript", NotebookView._esm)}
    page.route("**/*", lambda route: route.fulfill(**_file(files, route.request.url)))
    page.goto("http://notebook.test/")
    page.locator("#status[data-state=exact]").wait_for()
    yield page, kernel, said
    page.context.close()


def _file(files: dict[str, tuple[str, str]], address: str) -> dict[str, Any]:
    kind, body = files.get("/" + address.split("/", 3)[3], ("text/plain", ""))
    return {"content_type": kind, "body": body}


@needs_chromium
def test_a_wheel_is_dragged_in_a_notebook(cell: tuple[Page, Kernel, list[str]]) -> None:
    page, kernel, said = cell
    page.locator("#status[data-state=exact]").wait_for()
    words = [word.inner_text() for word in page.locator(".answer-word").all()]
    assert words == ["comes home", "drifts", "can be held"]
    assert page.locator(".layer-cells path").count() == 8
    box = page.locator("[data-wheel='0'] .rim").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + 30, y + 20, steps=3)
    page.mouse.up()
    moved = "() => window.model.get('document').wheel[0].position[0] !== 1"
    page.wait_for_function(moved)
    assert kernel.view.document["wheel"][0]["position"][0] > 1
    page.get_by_role("button", name="Undo").click()
    page.wait_for_function("() => window.model.get('document').wheel[0].position[0] === 1")
    assert page.locator(".layer-paths path").get_attribute("d")
    page.evaluate("(d) => model.become('document', d)", ns.widget("mecanum-4").document)
    page.locator("#status[data-state=exact]").wait_for()
    page.evaluate("() => window.end()")
    assert said == []


def test_without_its_package_it_says_how_to_install_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nonsmooth.reports.workbench.notebook_view", None)
    with pytest.raises(ImportError, match=r"nonsmooth\[notebook\]"):
        ns.widget("four-wheel")
