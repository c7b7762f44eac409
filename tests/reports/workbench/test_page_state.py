"""What the workbench's page keeps: undo, the address, two tabs, a server that is killed; and how it looks."""

from __future__ import annotations

import random
from functools import partial
from typing import Any

import pytest
from playwright.sync_api import Browser, Page, ViewportSize

from tests.browser import CONTRAST, READABLE, STICKING_OUT, needs_chromium
from tests.reports.workbench.workbench_page import (
    DESK,
    Opened,
    document,
    edited,
    proved,
    settled,
)
from tests.thorough import keep
from tests.workbench_server import Workbench

pytestmark = needs_chromium

SMALL: ViewportSize = {"width": 500, "height": 400}  # pixels of a page that nobody looks at
KEYS = ("ArrowLeft", "ArrowUp", "Shift+ArrowRight", "Alt+ArrowDown", "[", "]", "{", "c", "a", "r", "M", "Delete", "o")
REFUSED = 1500  # milliseconds: an edit that Python refuses, such as two wheels at one place, changes nothing
CHANGED = """(most) => new Promise((ready) => { const began = performance.now(); const look = () => {
    const moved = JSON.stringify(workbench.store.now) !== window.before;
    const said = !document.getElementById('note').hidden;
    if (moved || said || performance.now() - began > most) ready(moved); else setTimeout(look, 5); }; look(); })"""


def toml(server: Workbench, page: Page) -> bytes:
    """The scene file of what the page holds."""
    return server.ask("/api/export", {"document": document(page), "kind": "toml"}).body


def random_edit(page: Page, hand: random.Random) -> None:
    """A key that somebody may press, on a wheel that somebody may have selected; wait for what comes of it."""
    count = page.evaluate("() => workbench.store.document.wheel.length")
    page.evaluate("(k) => { workbench.store.select([k]); workbench.store.seal(); }", hand.randrange(count))
    page.evaluate("""() => { window.before = JSON.stringify(workbench.store.now);
        document.getElementById('note').hidden = true; }""")
    key = hand.choice(KEYS[:9] if count < 4 else KEYS)
    page.keyboard.press(key)
    page.evaluate(CHANGED, REFUSED)


@pytest.mark.parametrize("edits", keep(1, [8, 50]))
def test_undo_of_random_edits_gives_the_same_file_byte_for_byte(
    browser: Browser, server: Workbench, edits: int
) -> None:
    opened = Opened(browser, server.address, viewport=SMALL)
    page = opened.page
    page.evaluate("() => { workbench.conversation.dragging = true; }")  # cells and answers suffice, as in a drag
    first = toml(server, page)
    hand = random.Random(7)
    while page.evaluate("() => workbench.store.past.length") < edits:
        random_edit(page, hand)
    last = toml(server, page)
    assert last != first
    for _ in range(edits):
        page.keyboard.press("Control+z")
    assert toml(server, page) == first
    assert page.locator("#undo").is_disabled()
    for _ in range(edits):
        page.keyboard.press("Control+Shift+z")
    assert toml(server, page) == last
    opened.context.close()


# Waits until the address carries what is shown.
CARRIED = """async () => { const { unpack } = await import("/page/address.js");
    for (let tries = 0; tries < 1500; tries += 1) {
      if (JSON.stringify(await unpack(location.hash.slice(1))) === JSON.stringify(workbench.store.now)) return;
      await new Promise((ready) => setTimeout(ready, 20));
    }
    throw new Error("waited for the address"); }"""


def test_the_last_edit_before_a_reload_is_kept(browser: Browser, server: Workbench) -> None:
    opened = Opened(browser, server.address, viewport=SMALL)
    page = opened.page
    edited(page, lambda: page.click("#add-start"))
    page.keyboard.press("n")
    for key in ("ArrowRight", "ArrowUp"):
        edited(page, partial(page.keyboard.press, key))
        state = page.evaluate("() => JSON.stringify(workbench.store.now)")
        page.reload()  # the address is written later
        proved(page)
        assert page.evaluate("() => JSON.stringify(workbench.store.now)") == state
        page.evaluate("() => workbench.store.select([0])")
    written = "() => location.hash !== window.hash"
    page.evaluate(CARRIED)
    former, known = page.evaluate("() => [location.href, JSON.stringify(workbench.store.now)]")
    assert len(former) < 2000
    page.evaluate("() => { window.hash = location.hash; }")
    edited(page, lambda: page.keyboard.press("ArrowRight"))
    page.wait_for_function(written)
    edited(page, lambda: page.keyboard.press("["))
    page.goto("about:blank")
    page.goto(former)  # an address that is followed says what is shown, not what the tab left at another one
    proved(page)
    assert page.evaluate("() => JSON.stringify(workbench.store.now)") == known
    opened.context.close()


def test_two_tabs_do_not_disturb_each_other(opened: Opened, page: Page, server: Workbench) -> None:
    second = opened.tab(server.address)
    second.select_option("#scene", "mecanum-4")
    for own in (page, second):
        own.keyboard.press("n")
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
        second.keyboard.press("ArrowUp")
    for own, name in ((page, "four-wheel"), (second, "mecanum-4")):
        settled(own)
        proved(own)
        assert document(own)["name"] == name
        shown, stated = own.evaluate(
            """() => { const { store, results } = workbench; const wheel = results.geometry.wheels[0];
            return [[wheel.x, wheel.y], store.document.wheel[0].position]; }"""
        )
        assert shown == pytest.approx(stated)
    second.close()


def test_a_page_without_a_token_asks_for_it(browser: Browser, server: Workbench) -> None:
    context = browser.new_context(viewport=SMALL)
    page = context.new_page()
    page.clock.install()
    page.goto(server.address.partition("?")[0])
    page.locator("#token").fill(server.address)
    page.get_by_role("button", name="Connect").click()
    page.clock.fast_forward(2500)  # the page asks again after a while
    proved(page)
    assert not page.locator("#banner").is_visible()
    context.close()


DRAWN = "() => new Promise((ready) => requestAnimationFrame(() => requestAnimationFrame(ready)))"


@pytest.mark.usefixtures("all_stages")
@pytest.mark.parametrize("system", keep(1, ["relay-oscillator-damped", "flower"]))
def test_nothing_sticks_out_from_a_phone_to_a_wall(page: Page, system: str) -> None:
    page.locator("#numbers > summary").click()
    beyond = STICKING_OUT.replace("'main *, nav *'", "'header *, main > *, .details *'")
    for scene in ("four-wheel", "carton-on-6x6", system):
        page.select_option("#scene", scene)
        page.wait_for_function("(scene) => workbench.store.document.name === scene", arg=scene)
        proved(page)
        page.evaluate("() => workbench.store.select([0])")
        for width in (400, 1400, 3840):
            page.set_viewport_size({"width": width, "height": 900})
            page.wait_for_function("(width) => innerWidth === width", arg=width)
            page.evaluate(DRAWN)
            assert page.evaluate("document.documentElement.scrollWidth") <= width, (scene, width)
            assert page.evaluate(beyond) == [], (scene, width)
            box = page.locator("#drawing").bounding_box()
            assert box is not None
            assert box["width"] > 0.5 * width
    page.set_viewport_size(DESK)
    page.locator("#numbers > summary").click()


@pytest.mark.usefixtures("all_stages")
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_is_readable(page: Page, scheme: Any) -> None:
    page.emulate_media(color_scheme=scheme)
    page.keyboard.press("n")
    edited(page, lambda: page.click("#add-start"))
    settled(page)
    places = [
        "h1", "h1 span", "#scene", "#status", ".answer-title", ".answer-word", ".answer-sentence", "#description",
        ".slider label", ".slider output", ".field label", ".field input", ".clause .reason", ".clause .verdict",
        ".wheels td", ".legend li", "#clock", ".start-name", ".layer-grid-labels text:not([visibility=hidden])",
    ]  # fmt: skip
    for name in places:
        first = page.locator(f"{name}:visible").evaluate_all(f"(elements) => elements.slice(0, 4).map({CONTRAST})")
        assert min(first, default=READABLE) >= READABLE, (name, first)
    dark = page.evaluate("() => getComputedStyle(document.body).colorScheme")
    page.click("#theme")
    assert page.evaluate("() => document.documentElement.dataset.theme") == ("light" if scheme == "dark" else "dark")
    page.click("#theme")
    assert page.evaluate("() => document.documentElement.dataset.theme ?? ''") == ""
    assert dark
    page.emulate_media(color_scheme="null")


@pytest.mark.usefixtures("all_stages")
def test_every_control_has_a_name(page: Page) -> None:
    edited(page, lambda: page.click("#add-start"))
    unnamed = page.evaluate("""() =>
        [...document.querySelectorAll('button, input, select, dialog, [role]')].filter((e) => {
        const labels = e.labels?.length || e.getAttribute('aria-label') || e.getAttribute('aria-labelledby');
        return !labels && !e.textContent.trim() && !e.title && !['alert', 'status'].includes(e.getAttribute('role'));
    }).map((e) => e.outerHTML.slice(0, 120))""")
    assert unnamed == []


def test_a_scene_that_is_refused_is_told_once(browser: Browser, server: Workbench) -> None:
    context = browser.new_context()
    page = context.new_page()
    asked: list[str] = []
    page.on("request", lambda request: asked.append(request.url))
    refusal: dict[str, Any] = {"status": 500, "content_type": "application/json", "body": '{"error": "no such luck"}'}
    page.route("**/api/scenes/*", lambda route: route.fulfill(**refusal))
    page.clock.install()
    page.goto(server.address)
    page.locator("#error", has_text="no such luck").wait_for()
    page.clock.run_for(2500)
    page.wait_for_timeout(100)  # for requests that were sent in this time
    assert len([address for address in asked if "/api/scenes/" in address]) == 1
    context.close()
