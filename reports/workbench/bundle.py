"""Modules of the page as one: a notebook takes the text of a single module.

Every module becomes a function that is called once and returns what the module exports; imports become names of what
such a function has returned.  The modules keep to the two forms that are read here, which a test holds.
"""

from __future__ import annotations

import re
from pathlib import Path

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
