"""What the site adds to the documents: pages made from docstrings, documents of the root, formulas as MathML.

Called by MkDocs (mkdocs.yml).  The public names are those of ``nonsmooth.__init__``; each gets a page of its own.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from html import escape
from pathlib import Path
from typing import Any

import latex2mathml.converter
from mkdocs.structure.files import File, Files

import nonsmooth

ROOT = Path(__file__).resolve().parents[2]
FROM_ROOT = {
    "contributing.md": "CONTRIBUTING.md",
    "changelog.md": "CHANGELOG.md",
    "security.md": "SECURITY.md",
    "conduct.md": "CODE_OF_CONDUCT.md",
}
MATH = re.compile(r"^```math\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"\]\((docs/)?([\w./-]+\.md)(#[\w-]+)?\)")
LIST_AFTER_TEXT = re.compile(r"^(?!\s*([-*]|\d+\.)\s|\s*$|\s*[|#>])(.+)\n(?=([-*]|1\.) )", re.MULTILINE)
ROLE = re.compile(r":(meth|class|mod|func|data|attr):(?=<code>)")
FENCE = re.compile(r"^```.*?^```$", re.MULTILINE | re.DOTALL)
PACKAGES = ("symbolic", "analysis", "proofs", "reports")


def on_files(files: Files, config: Any) -> Files:
    """Add the generated pages."""
    for name, source in FROM_ROOT.items():
        text = (ROOT / source).read_text(encoding="utf-8")
        files.append(File.generated(config, name, content=_at_home(text)))
    for name, text in reference_pages():
        files.append(File.generated(config, name, content=text))
    return files


def reference_pages() -> Iterator[tuple[str, str]]:
    """A page for each public name of the Python interface, one for the names of each package, and their index."""
    lines = ["# Classes and functions", "", "`import nonsmooth as ns`; made from the docstrings.", ""]
    for name, module in sorted(nonsmooth._MODULES.items()):
        yield f"reference/{name}.md", f"::: nonsmooth.{module}.{name}\n"
        lines.append(f"- [`ns.{name}`]({name}.md)")
    lines += ["", "The packages below it, by their public names:", ""]
    for package in PACKAGES:
        yield f"reference/{package}.md", "\n".join(_package_page(package))
        lines.append(f"- [`nonsmooth.{package}`]({package}.md)")
    yield "reference/index.md", "\n".join([*lines, ""])


def _package_page(package: str) -> Iterator[str]:
    """The names that a package offers itself."""
    yield f"# nonsmooth.{package}"
    yield ""
    for name, module in sorted(offered(package).items()):
        yield f"::: {module}.{name}"
        yield "    options:"
        yield "      heading_level: 2"
        yield ""


def offered(package: str) -> dict[str, str]:
    """The public names of a package, each with its module: what its ``__init__`` names for type checkers."""
    tree = ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8"))
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {name.name: str(node.module) for node in imports for name in node.names if name.asname == name.name}


def on_page_markdown(markdown: str, **_: Any) -> str:
    """Formulas as MathML, which browsers draw by themselves; lists below a line of text as lists."""
    with_formulas = MATH.sub(lambda found: _mathml(found.group(1)), markdown)
    parts, place = [], 0
    for fence in FENCE.finditer(with_formulas):
        parts += [_spaced(with_formulas[place : fence.start()]), fence.group()]
        place = fence.end()
    return "".join([*parts, _spaced(with_formulas[place:])])


def on_page_content(html: str, **_: Any) -> str:
    """Roles of docstrings, such as ``:meth:``, are no words."""
    return ROLE.sub("", html)


def _spaced(text: str) -> str:
    """GitHub begins a list right below a line of text; Markdown of Python wants an empty line between."""
    return LIST_AFTER_TEXT.sub(lambda found: f"{found.group()}\n", text)


def _mathml(latex: str) -> str:
    drawn = latex2mathml.converter.convert(" ".join(latex.split()), display="block")
    return f'<div role="math" aria-label="{escape(latex.strip())}">{drawn}</div>'


def _at_home(text: str) -> str:
    """A document of the root with links as they are in docs/."""

    def moved(found: re.Match[str]) -> str:
        home = {source: name for name, source in FROM_ROOT.items()}
        return f"]({home.get(found.group(2), found.group(2))}{found.group(3) or ''})"

    return LINK.sub(moved, text)
