"""The page of a path in a real browser: it plays, the slider moves the drawing, it fits a phone and the dark."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import pytest
from playwright.sync_api import Browser, Page, expect

import nonsmooth as ns
from tests.browser import CONTRAST, NARROW, READABLE, STICKING_OUT, WIDE, needs_chromium, opened
from tests.thorough import few, keep

pytestmark = needs_chromium
PATHS: dict[str, Any] = {
    "open": ("four-wheel", (0.2, 0.4, 0.1), {}),
    "closed": ("four-wheel", (0.2, 0.1, 0.3), {"feedback": True}),
    "ellipse": ("ring-6", (0.1, 0.2, 0.0), {"rule": "ellipse"}),
}


class Pages(dict[str, Path]):
    """The page of each path, written when it is first asked for."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self._folder = folder

    def __missing__(self, name: str) -> Path:
        scene, start, options = PATHS[name]
        path = ns.load(scene).simulate(start, until=3.0, **options)
        self[name] = written = path.animate(self._folder / f"{name}.html")
        return written


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Pages:
    """The films that the tests open."""
    return Pages(tmp_path_factory.mktemp("films"))


@pytest.fixture
def page(browser: Browser, pages: Pages) -> Iterator[Page]:
    """The open loop on a desk."""
    seen = opened(browser, pages["open"])
    yield seen.page
    assert seen.said == []
    assert len(seen.asked) == 1
    seen.page.context.close()


def drawn(page: Page) -> tuple[str, ...]:
    """All that moves, as it stands."""
    script = """() => [document.getElementById('marker').getAttribute('transform'),
        ...[...document.querySelectorAll('#picture .slip')].map((e) => e.getAttribute('d')),
        ...[...document.querySelectorAll('#picture .ring')].map((e) => e.getAttribute('class')),
        document.getElementById('time').textContent]"""
    return tuple(page.evaluate(script))


@few(1)
@pytest.mark.parametrize("width", [NARROW, WIDE])
@pytest.mark.parametrize("name", keep(2, PATHS))
def test_a_page_opens_quietly_and_fits(browser: Browser, pages: Pages, name: str, width: int) -> None:
    seen = opened(browser, pages[name], width)
    assert seen.said == []
    assert seen.asked == [pages[name].as_uri()]
    assert seen.page.evaluate("document.documentElement.scrollWidth") <= width
    assert seen.page.evaluate(STICKING_OUT) == []
    size = seen.page.locator("#picture .name").first.evaluate("(e) => e.getBoundingClientRect().height")
    assert size >= 11
    seen.page.context.close()


def test_text_is_readable(browser: Browser, pages: Pages) -> None:
    seen = opened(browser, pages["closed"])
    schemes: tuple[Literal["light", "dark"], ...] = ("light", "dark")
    for scheme in schemes:
        seen.page.emulate_media(color_scheme=scheme)
        brightness = seen.page.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)[0]")
        assert (brightness > 128) == (scheme == "light")
        for place in ("h1", "main p", "li", "td", "caption", "#play", "#time", "#picture .name", ".pace"):
            assert seen.page.locator(place).first.evaluate(CONTRAST) >= READABLE, place
    seen.page.context.close()


def test_the_slider_moves_the_drawing_by_the_keyboard(page: Page) -> None:
    slider = page.locator("#scrubber")
    slider.focus()
    states = [drawn(page)]
    for _ in range(6):
        page.keyboard.press("ArrowRight")
        states.append(drawn(page))
    assert len(set(states)) == 7
    assert slider.get_attribute("aria-valuetext") == page.locator("#time").inner_text()
    page.keyboard.press("End")
    assert page.locator("#time").inner_text() == "t = 3.000"
    page.keyboard.press("Home")
    assert drawn(page) == states[0]


def test_the_button_plays_in_real_time_and_pauses(page: Page) -> None:
    button = page.locator("#play")
    assert button.inner_text() == "Play"
    button.focus()
    page.keyboard.press("Space")
    assert button.inner_text() == "Pause"
    first = drawn(page)
    expect(page.locator("#time")).to_have_text(re.compile(r"t = (0\.[5-9]|1)"))
    assert drawn(page) != first
    button.click()
    assert button.inner_text() == "Play"
    kept = drawn(page)
    page.wait_for_timeout(200)
    assert drawn(page) == kept
    for key in ("End", "PageDown"):  # the last tenth of the film
        page.locator("#scrubber").press(key)
    button.click()
    expect(button).to_have_text("Again")
    assert page.locator("#time").inner_text() == "t = 3.000"
    button.click()
    assert button.inner_text() == "Pause"


def test_events_are_marked_and_lead_to_their_time(page: Page) -> None:
    count = page.locator("button.event").count()
    assert count == page.locator(".tick").count() > 0
    button = page.locator("button.event").nth(1)
    share = float(button.get_attribute("data-share") or "nan")
    button.click()
    time = float(page.locator("#time").inner_text().removeprefix("t = "))
    assert time == pytest.approx(3 * share, abs=0.026)
    track = page.locator("#scrubber").bounding_box()
    tick = page.locator(".tick").nth(1).bounding_box()
    assert track
    assert tick
    thumb = track["x"] + 10 + share * (track["width"] - 20)
    assert tick["x"] + tick["width"] / 2 == pytest.approx(thumb, abs=2)


def test_speeds_of_a_closed_loop_change(browser: Browser, pages: Pages) -> None:
    seen = opened(browser, pages["closed"])
    page = seen.page
    arrows = "() => [...document.querySelectorAll('#picture .speed')].map((e) => e.getAttribute('d'))"
    first = page.evaluate(arrows)
    assert sum(bool(arrow) for arrow in first) == 2
    page.locator("#scrubber").press("PageUp")
    assert page.evaluate(arrows) != first
    page.context.close()


def test_reduced_motion_goes_on_by_steps(browser: Browser, pages: Pages) -> None:
    seen = opened(browser, pages["open"], reduced_motion="reduce")
    button = seen.page.locator("#play")
    assert button.inner_text() == "Next"
    times = []
    for _ in range(3):
        button.click()
        times.append(seen.page.locator("#time").inner_text())
        seen.page.wait_for_timeout(120)
        assert seen.page.locator("#time").inner_text() == times[-1]
    assert len(set(times)) == 3
    seen.page.context.close()


def test_the_page_serves_with_scripts_off(browser: Browser, pages: Pages) -> None:
    seen = opened(browser, pages["open"], java_script_enabled=False)
    assert not seen.page.locator(".controls").is_visible()
    assert seen.page.locator("#picture .rim").count() == 4
    assert seen.page.locator("#picture").bounding_box()
    seen.page.context.close()
