"""Reports and films in a real browser: headless Chromium opens them from a file, without a server and a network."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any, Literal

import pytest
from playwright.sync_api import Browser, Page, expect

import nonsmooth as ns
from tests.browser import CONTRAST, NARROW, READABLE, STICKING_OUT, WIDE, Opened, needs_chromium, opened
from tests.reports import derived
from tests.thorough import few, keep

# ---- The HTML report in a real browser: headless Chromium opens it from a file, without a server and without a
# network.

pytestmark = needs_chromium
BESIDE = 1120  # where two columns begin (70 rem)
SCENES = {"four-wheel": None, "elliptic": None, "ring-8": None, "off-center": "box", "spiral-30": "ellipse"}
THINNEST = 2  # pixels: a lone minus sign is the flattest formula


class Pages(dict[str, Path]):
    """The report of each scene as a file, written when it is first asked for."""

    def __init__(self, folder: Path) -> None:
        super().__init__()
        self._folder = folder

    def __missing__(self, name: str) -> Path:
        path = self[name] = self._folder / f"{name}.html"
        rule = SCENES[name]
        path.write_text(derived.page(name) if rule is None else derived.page(name, rule), encoding="utf-8")
        return path


@pytest.fixture(scope="module")
def pages(tmp_path_factory: pytest.TempPathFactory) -> Pages:
    """The reports that the tests open."""
    return Pages(tmp_path_factory.mktemp("reports"))


@pytest.mark.parametrize(("name", "width"), keep(1, [(name, width) for width in (NARROW, WIDE) for name in SCENES]))
def test_a_report_opens_quietly_and_fits(browser: Browser, pages: Pages, name: str, width: int) -> None:
    seen = opened(browser, pages[name], width)
    assert seen.said == []
    assert seen.asked == [pages[name].as_uri()]
    require_fitting(seen.page, width)
    seen.page.context.close()


def require_fitting(page: Page, width: int) -> None:
    """Nothing sticks out of the window, and no formula has vanished."""
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert page.evaluate(STICKING_OUT) == []
    heights = "[...document.querySelectorAll('main math')].map((m) => m.getBoundingClientRect().height)"
    sizes = page.evaluate(heights)
    assert len(sizes) > 40
    assert min(sizes) >= THINNEST


@pytest.fixture(scope="module")
def desk(browser: Browser, pages: Pages) -> Iterator[Opened]:
    """The four-wheel report on a desk, for all tests that need no other page: to open it takes a second."""
    seen = opened(browser, pages["four-wheel"])
    yield seen
    seen.page.context.close()


@pytest.fixture
def page(desk: Opened) -> Iterator[Page]:
    """The four-wheel report as when it was opened; nobody points at anything."""
    page = desk.page
    page.set_viewport_size({"width": WIDE, "height": 900})
    page.emulate_media(media="null", color_scheme="null")
    page.mouse.move(0, 0)
    page.evaluate("() => { document.activeElement.blur(); scrollTo(0, 0); }")
    yield page
    assert desk.said == []
    assert len(desk.asked) == 1


def test_the_report_fits_a_desk(page: Page) -> None:
    require_fitting(page, WIDE)


def middle(page: Page, mark: str) -> tuple[float, float]:
    """The mean of a cell's corners on the map, in pixels of the window, scrolled into sight."""
    script = """(piece) => {
        piece.scrollIntoView({block: 'center'});
        const path = piece.querySelector('path');
        const numbers = path.getAttribute('d').match(/-?[\\d.]+/g).map(Number);
        const mean = (start) => { const own = numbers.filter((_, k) => k % 2 === start);
            return own.reduce((a, b) => a + b, 0) / own.length; };
        const at = new DOMPoint(mean(0), mean(1)).matrixTransform(path.getScreenCTM());
        return [at.x, at.y];
    }"""
    x, y = page.locator(f"#cell-map-{mark}").evaluate(script)
    return x, y


def lit(page: Page) -> dict[str, set[str]]:
    """What each kind of lit element is about."""
    script = "(kind) => [...document.querySelectorAll(`main ${kind}.lit`)].map((e) => e.dataset.about)"
    return {kind: set(page.evaluate(script, kind)) for kind in ("g", "tr", "section")}


def test_answers_are_whole_beside_the_array(page: Page) -> None:
    page.set_viewport_size({"width": BESIDE, "height": 900})
    table = "document.querySelector('#answers .table')"
    assert page.evaluate(f"{table}.scrollWidth <= {table}.clientWidth")


def test_a_cell_under_the_pointer_lights_its_equations_and_rows(page: Page) -> None:
    page.mouse.move(*middle(page, "cell-3"))
    assert lit(page) == {"g": {"cell-3"}, "tr": {"cell-3"}, "section": {"cell-3"}}
    assert page.locator("#companion g.lit").count() == 1
    page.mouse.move(*middle(page, "cell-5"))
    assert lit(page)["section"] == {"cell-5"}


def test_the_copy_of_the_map_fits_beside_the_text(page: Page) -> None:
    map_box, column = page.locator("#companion svg").bounding_box(), page.locator("nav").bounding_box()
    assert map_box
    assert column
    assert map_box["x"] >= column["x"]
    assert map_box["x"] + map_box["width"] <= column["x"] + column["width"]
    assert map_box["y"] + map_box["height"] <= 900


def test_a_row_or_equations_under_the_pointer_light_the_cell(page: Page) -> None:
    page.locator("#cells tr[data-about=cell-2] td").last.hover()
    assert lit(page)["g"] == {"cell-2"}
    page.locator("section[data-about=cell-6] p").first.hover()
    assert lit(page) == {"g": {"cell-6"}, "tr": {"cell-6"}, "section": {"cell-6"}}
    page.locator("h1").hover()
    assert lit(page)["g"] == set()


def test_cells_are_reached_and_followed_by_the_keyboard(page: Page) -> None:
    links = page.locator("#cell-map a")
    assert links.count() == 8
    links.first.focus()
    reached = [page.evaluate("document.activeElement.querySelector('[data-about]').dataset.about")]
    for _ in range(7):
        page.keyboard.press("Tab")
        reached.append(page.evaluate("document.activeElement.querySelector('[data-about]').dataset.about"))
    assert reached == [f"cell-{k}" for k in range(1, 9)]
    assert lit(page)["section"] == {"cell-8"}
    page.keyboard.press("Enter")
    page.wait_for_function("location.hash !== ''")
    target = page.locator(page.evaluate("location.hash"))
    assert target.get_attribute("data-about") == "cell-8"
    target.locator("a.to-map").focus()
    assert lit(page)["g"] == {"cell-8"}
    page.keyboard.press("Enter")
    page.wait_for_url("**#cell-map-cell-8")


def shown_path(page: Page) -> str:
    """The outline of the one path that is shown."""
    paths = page.locator("#starts g[id$=--path]:visible path")
    assert paths.count() == 1
    outline = paths.get_attribute("d")
    assert outline
    return outline


@pytest.mark.parametrize("last", keep(1, [3, 24]))
def test_the_slider_changes_the_path(page: Page, last: int) -> None:
    slider = page.locator("#starts-slider")
    seen = {shown_path(page): page.locator("#starts output").inner_text()}
    slider.focus()
    page.keyboard.press("Home")
    assert slider.get_attribute("max") == "23"
    for number in range(2, last + 1):
        page.keyboard.press("ArrowRight")
        assert page.locator("tr.lit").get_attribute("data-about") == f"start-{number}"
        seen[shown_path(page)] = page.locator("#starts output").inner_text()
    assert len(seen) == len(set(seen.values())) == last
    page.keyboard.press("Home")
    assert page.locator("#starts output").inner_text().startswith("1: from (0.2, 0.4) to (0, 0)")
    page.locator("tr[data-about=start-7]").click()
    assert slider.input_value() == "6"


def test_the_page_serves_with_scripts_off(browser: Browser, pages: Pages) -> None:
    seen = opened(browser, pages["four-wheel"], java_script_enabled=False)
    assert not seen.page.locator("#starts .slider").is_visible()
    assert shown_path(seen.page)
    assert not seen.page.locator("#companion").is_visible()
    seen.page.mouse.click(*middle(seen.page, "cell-1"))
    seen.page.wait_for_url("**#r1-s1-r2-cell-1")
    seen.page.context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_text_and_figures_are_readable(page: Page, scheme: Any) -> None:
    page.emulate_media(color_scheme=scheme)
    places = ("main p", "main td", "figcaption", "main a", "code", "math mi", "#cell-map svg text, #cell-map svg g use")
    for place in places:
        assert page.locator(place).first.evaluate(CONTRAST) >= READABLE, place
    brightness = page.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)[0]")
    assert (brightness > 128) == (scheme == "light")


def test_the_page_prints_without_its_controls(page: Page) -> None:
    page.emulate_media(media="print", color_scheme="dark")
    assert not page.locator("nav").is_visible()
    assert not page.locator("#starts .slider").is_visible()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert len(page.pdf()) > 50_000


# ---- The page of a path in a real browser: it plays, the slider moves the drawing, it fits a phone and the dark.

PATHS: dict[str, Any] = {
    "open": ("four-wheel", (0.2, 0.4, 0.1), {}),
    "closed": ("four-wheel", (0.2, 0.1, 0.3), {"feedback": True}),
    "ellipse": ("ring-6", (0.1, 0.2, 0.0), {"rule": "ellipse"}),
}


class FilmPages(dict[str, Path]):
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
def films(tmp_path_factory: pytest.TempPathFactory) -> FilmPages:
    """The films that the tests open."""
    return FilmPages(tmp_path_factory.mktemp("films"))


@pytest.fixture
def film(browser: Browser, films: FilmPages) -> Iterator[Page]:
    """The open loop on a desk."""
    seen = opened(browser, films["open"])
    yield seen.page
    assert seen.said == []
    assert len(seen.asked) == 1
    seen.page.context.close()


def drawn_film(film: Page) -> tuple[str, ...]:
    """All that moves, as it stands."""
    script = """() => [document.getElementById('marker').getAttribute('transform'),
        ...[...document.querySelectorAll('#picture .slip')].map((e) => e.getAttribute('d')),
        ...[...document.querySelectorAll('#picture .ring')].map((e) => e.getAttribute('class')),
        document.getElementById('time').textContent]"""
    return tuple(film.evaluate(script))


@few(1)
@pytest.mark.parametrize("width", [NARROW, WIDE])
@pytest.mark.parametrize("name", keep(2, PATHS))
def test_a_page_opens_quietly_and_fits(browser: Browser, films: FilmPages, name: str, width: int) -> None:
    seen = opened(browser, films[name], width)
    assert seen.said == []
    assert seen.asked == [films[name].as_uri()]
    assert seen.page.evaluate("document.documentElement.scrollWidth") <= width
    assert seen.page.evaluate(STICKING_OUT) == []
    size = seen.page.locator("#picture .name").first.evaluate("(e) => e.getBoundingClientRect().height")
    assert size >= 11
    seen.page.context.close()


def test_text_is_readable(browser: Browser, films: FilmPages) -> None:
    seen = opened(browser, films["closed"])
    schemes: tuple[Literal["light", "dark"], ...] = ("light", "dark")
    for scheme in schemes:
        seen.page.emulate_media(color_scheme=scheme)
        brightness = seen.page.evaluate("getComputedStyle(document.body).backgroundColor.match(/\\d+/g).map(Number)[0]")
        assert (brightness > 128) == (scheme == "light")
        for place in ("h1", "main p", "li", "td", "caption", "#play", "#time", "#picture .name", ".pace"):
            assert seen.page.locator(place).first.evaluate(CONTRAST) >= READABLE, place
    seen.page.context.close()


def test_the_slider_moves_the_drawing_by_the_keyboard(film: Page) -> None:
    slider = film.locator("#scrubber")
    slider.focus()
    states = [drawn_film(film)]
    for _ in range(6):
        film.keyboard.press("ArrowRight")
        states.append(drawn_film(film))
    assert len(set(states)) == 7
    assert slider.get_attribute("aria-valuetext") == film.locator("#time").inner_text()
    film.keyboard.press("End")
    assert film.locator("#time").inner_text() == "t = 3.000"
    film.keyboard.press("Home")
    assert drawn_film(film) == states[0]


def test_the_button_plays_in_real_time_and_pauses(film: Page) -> None:
    button = film.locator("#play")
    assert button.inner_text() == "Play"
    button.focus()
    film.keyboard.press("Space")
    assert button.inner_text() == "Pause"
    first = drawn_film(film)
    expect(film.locator("#time")).to_have_text(re.compile(r"t = (0\.[5-9]|1)"))
    assert drawn_film(film) != first
    button.click()
    assert button.inner_text() == "Play"
    kept = drawn_film(film)
    film.wait_for_timeout(200)
    assert drawn_film(film) == kept
    for key in ("End", "PageDown"):  # the last tenth of the film
        film.locator("#scrubber").press(key)
    button.click()
    expect(button).to_have_text("Again")
    assert film.locator("#time").inner_text() == "t = 3.000"
    button.click()
    assert button.inner_text() == "Pause"


def test_events_are_marked_and_lead_to_their_time(film: Page) -> None:
    count = film.locator("button.event").count()
    assert count == film.locator(".tick").count() > 0
    button = film.locator("button.event").nth(1)
    share = float(button.get_attribute("data-share") or "nan")
    button.click()
    time = float(film.locator("#time").inner_text().removeprefix("t = "))
    assert time == pytest.approx(3 * share, abs=0.026)
    track = film.locator("#scrubber").bounding_box()
    tick = film.locator(".tick").nth(1).bounding_box()
    assert track
    assert tick
    thumb = track["x"] + 10 + share * (track["width"] - 20)
    assert tick["x"] + tick["width"] / 2 == pytest.approx(thumb, abs=2)


def test_speeds_of_a_closed_loop_change(browser: Browser, films: FilmPages) -> None:
    seen = opened(browser, films["closed"])
    film = seen.page
    arrows = "() => [...document.querySelectorAll('#picture .speed')].map((e) => e.getAttribute('d'))"
    first = film.evaluate(arrows)
    assert sum(bool(arrow) for arrow in first) == 2
    film.locator("#scrubber").press("PageUp")
    assert film.evaluate(arrows) != first
    film.context.close()


def test_reduced_motion_goes_on_by_steps(browser: Browser, films: FilmPages) -> None:
    seen = opened(browser, films["open"], reduced_motion="reduce")
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


def test_the_film_serves_with_scripts_off(browser: Browser, films: FilmPages) -> None:
    seen = opened(browser, films["open"], java_script_enabled=False)
    assert not seen.page.locator(".controls").is_visible()
    assert seen.page.locator("#picture .rim").count() == 4
    assert seen.page.locator("#picture").bounding_box()
    seen.page.context.close()
