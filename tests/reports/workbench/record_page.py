"""Record docs/workbench.gif: a rim is turned, a wheel dragged, a path played.

Run it from the repository's root: ``python -m tests.reports.workbench.record_page docs/workbench.gif``.
"""

from __future__ import annotations

import io
import math
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TypeAlias

from PIL import Image
from playwright.sync_api import Page

from tests.browser import chromium
from tests.reports.workbench.workbench_page import Opened, place, running, settled

Place: TypeAlias = tuple[float, float]
Shot: TypeAlias = Callable[[], Image.Image]

SIZE = {"width": 1180, "height": 640}
WIDTH, COLORS, MILLISECONDS = 820, 256, 110  # of a picture
RIM = """(() => { const knob = drawing.element.querySelector('[data-rim="0"]'); const { unit } = drawing.view;
    const [x, y] = drawing.view.at(drawing.wheels()[0].x, drawing.wheels()[0].y);
    return [x + unit * knob.getAttribute('cx'), y + unit * knob.getAttribute('cy')]; })()"""
WHEEL = "drawing.view.at(drawing.wheels()[0].x, drawing.wheels()[0].y)"


def shots(page: Page) -> Iterator[Image.Image]:
    """The pictures, one after the other."""

    def shot() -> Image.Image:
        picture = Image.open(io.BytesIO(page.screenshot())).convert("RGB")
        return picture.resize((WIDTH, WIDTH * SIZE["height"] // SIZE["width"]), Image.Resampling.LANCZOS)

    page.keyboard.press("n")
    page.evaluate("() => workbench.store.edit(() => ({ starts: [[-0.3, 0.45, 0]], until: 2 }))")
    settled(page)
    yield shot()
    (x, y), (cx, cy) = place(page, RIM), place(page, WHEEL)
    reach, angle = math.hypot(x - cx, y - cy), math.atan2(y - cy, x - cx)
    yield from dragged(
        page, shot, (x, y), [arc(cx, cy, reach, angle + 0.9 * math.sin(k * math.pi / 14)) for k in range(15)]
    )
    x, y = place(page, WHEEL)
    yield from dragged(page, shot, (x, y), [(x - 10 * min(k, 12), y + 5 * min(k, 12)) for k in range(13)])
    page.keyboard.press("Escape")
    for share in range(0, 1000, 70):
        page.locator("#time").evaluate("(e, v) => { e.value = v; e.dispatchEvent(new Event('input')); }", share)
        page.wait_for_timeout(60)
        yield shot()


def arc(x: float, y: float, radius: float, angle: float) -> tuple[float, float]:
    """A point of a circle."""
    return x + radius * math.cos(angle), y + radius * math.sin(angle)


def dragged(page: Page, shot: Shot, start: Place, places: list[Place]) -> Iterator[Image.Image]:
    """A picture at each place of a drag, with the answers to it."""
    page.mouse.move(*start)
    page.mouse.down()
    for target in places:
        page.mouse.move(*target)
        settled(page)
        yield shot()
    page.mouse.up()
    settled(page)


def common_palette(pictures: list[Image.Image]) -> Image.Image:
    """One palette for all: what does not change between two pictures then costs nothing."""
    few = pictures[:: max(1, len(pictures) // 6)]
    height = few[0].height
    sheet = Image.new("RGB", (few[0].width, height * len(few)))
    for row, picture in enumerate(few):
        sheet.paste(picture, (0, row * height))
    return sheet.quantize(COLORS)


def main(target: Path) -> None:
    """Write the film."""
    with tempfile.TemporaryDirectory() as folder, running(Path(folder)) as server, chromium() as browser:
        page = Opened(browser, server.address, viewport=SIZE, color_scheme="light").page
        full = list(shots(page))
    palette = common_palette(full)
    pictures = [picture.quantize(palette=palette, dither=Image.Dither.NONE) for picture in full]
    pictures[0].save(target, save_all=True, append_images=pictures[1:], duration=MILLISECONDS, loop=0, optimize=True)
    print(f"{target}: {len(pictures)} pictures, {target.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(Path(sys.argv[1]))
