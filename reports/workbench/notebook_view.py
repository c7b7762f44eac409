"""The view of the workbench as a widget of a notebook.

The page's own modules draw it and ask; the kernel answers with the function that the workbench's processes answer with.
A kernel computes in one thread, so a view is told stage by stage, and between two stages a newer one takes its place.
"""

from __future__ import annotations

import asyncio
import json
import re
import time
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import anywidget
import traitlets

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.interface.system import System
from nonsmooth.reports.output.processes import CancelledError
from nonsmooth.reports.workbench.documents import expanded, opened
from nonsmooth.reports.workbench.shapes import UNTIL
from nonsmooth.reports.workbench.worker import CANCELLED, answers

if TYPE_CHECKING:
    from nonsmooth.reports.workbench.worker import Announce

# ---- the page as one module ----------------------------------------------------------------------


PAGE = Path(__file__).with_name("page")
STYLES = ("tokens.css", "layout.css", "controls.css", "panels.css", "drawing.css", "notebook.css")
IMPORT = re.compile(r'^import \{ (.+) \} from "\./(\w+)\.js";$', re.MULTILINE)
EXPORT = re.compile(r"^export (?=(?:async function|function|class|const) (\w+))", re.MULTILINE)
SYMBOLS = re.compile(r'<svg class="symbols".*?</svg>\n', re.DOTALL)


def bundled(entry: str, *exports: str) -> str:
    """A module of the page with all that it imports, as one ES module.

    Args:
        entry: name of the module, without ``.js``.
        exports: of its names, which the default export holds.
    """
    parts = "\n".join(_as_function(name) for name in _in_order(entry))
    return f"{parts}\nexport default {{ {', '.join(f'{name}: ${entry}.{name}' for name in exports)} }};\n"


def _text(name: str) -> str:
    return (PAGE / f"{name}.js").read_text(encoding="utf-8")


def _in_order(entry: str) -> list[str]:
    """The module and all that it imports, each after its own imports."""
    found: list[str] = []

    def visit(name: str) -> None:
        for _, needed in IMPORT.findall(_text(name)):
            if needed not in found:
                visit(needed)
        found.append(name)

    visit(entry)
    return found


def _as_function(name: str) -> str:
    text = IMPORT.sub(lambda match: f"const {{ {match[1]} }} = ${match[2]};", _text(name))
    exported = EXPORT.findall(text)
    return f"const ${name} = (() => {{\n{EXPORT.sub('', text)}return {{ {', '.join(exported)} }};\n}})();"


def styles() -> str:
    """The styles of the page for a root of its own inside another page."""
    texts = ((PAGE / name).read_text(encoding="utf-8") for name in STYLES)
    return "\n".join(texts).replace(":root", ":host")


def symbols() -> str:
    """The pictures of buttons, as ``index.html`` holds them."""
    found = SYMBOLS.search((PAGE / "index.html").read_text(encoding="utf-8"))
    return "" if found is None else found[0]


JOBS = {"/api/view": "view", "/api/edit": "edit"}  # what a view may ask for
SECONDS = 30.0  # that one view keeps the kernel at most
BREATH = 1e-3  # seconds between two stages, in which the kernel hears of a newer view


class _LateError(BaseException):
    """A view that takes too long; no step of it may take that for an error of its own."""


class NotebookView(anywidget.AnyWidget):
    """An array or a plain system in a notebook: drag, and cells, answers and paths follow.

    Attributes:
        document: the tables of the scene as they are now, see ``docs/workbench.md``; may be set.
        starts: ``[x, y, theta]`` of the paths that are followed; may be set.
        until: how long paths are followed (time); may be set.
    """

    _esm = bundled("notebook", "render")
    _styles = traitlets.Unicode(styles()).tag(sync=True)
    _symbols = traitlets.Unicode(symbols()).tag(sync=True)
    document = traitlets.Dict().tag(sync=True)
    starts: traitlets.List[list[float]] = traitlets.List().tag(sync=True)
    until = traitlets.Float(UNTIL).tag(sync=True)

    def __init__(self, made: Array | System, **more: Any) -> None:
        super().__init__(document=expanded(made.document, made), **more)
        self._newest, self._tasks = 0, set[asyncio.Task[None]]()
        self.on_msg(self._heard)

    @property
    def made(self) -> Array | System:
        """The array or plain system as it is now.

        Raises:
            SceneError: where what stands in the fields cannot be used.
        """
        return opened(self.document)

    def _heard(self, widget: object, content: Mapping[str, Any], buffers: object) -> None:
        """Answer one request of a view: at once outside of an event loop, else between other work of the kernel."""
        del widget, buffers
        name, number = JOBS.get(content.get("path", "")), content.get("id")
        if name is None or not isinstance(number, int):
            return
        if name == "view":
            self._newest = number
        stages = self._stages(name, number, json.dumps(content.get("body")).encode())
        try:
            asyncio.get_running_loop()
        except RuntimeError:
            for _ in stages:
                pass
            return
        task = asyncio.ensure_future(_between(stages))
        self._tasks.add(task)
        task.add_done_callback(self._tasks.discard)

    def _stages(self, name: str, number: int, body: bytes) -> Iterator[None]:
        """Compute and tell one message after the other."""
        look_up = self._watch(name, number)
        try:
            for message in answers(name, body, look_up):
                self.send({"id": number, "message": message})
                yield
        except CancelledError:
            self.send({"id": number, "message": {"stage": CANCELLED}})
        except _LateError:
            expected = f"required a scene whose view takes at most {SECONDS:g} s, received one that takes longer"
            for message in ({"stage": "error", "message": expected, "key": None}, {"stage": "done"}):
                self.send({"id": number, "message": message})

    def _watch(self, name: str, number: int) -> Announce:
        """What ends a job between two steps: a newer view, or the time."""
        last = time.monotonic() + SECONDS

        def look_up(step: str) -> None:
            del step
            if name == "view" and number != self._newest:
                raise CancelledError
            if time.monotonic() > last:
                raise _LateError

        return look_up


async def _between(stages: Iterator[None]) -> None:
    """Take the steps with breaks for the kernel."""
    for _ in stages:
        await asyncio.sleep(BREATH)
