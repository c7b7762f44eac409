"""The notebooks: stored without outputs, they run without a warning, and as pages they show what they promise."""

from __future__ import annotations

import json
import re
from dataclasses import dataclass
from html import unescape
from pathlib import Path

import nbformat
import pytest

from tests.thorough import keep

ROOT = Path(__file__).resolve().parents[1]
NOTEBOOKS = sorted((ROOT / "docs" / "notebooks").glob("*.ipynb"))
# Every warning is an error, but for those of the kernel about itself.
STRICT = """
import warnings

warnings.simplefilter("error")
warnings.filterwarnings("ignore", module=".*(ipykernel|matplotlib_inline)")
"""
FEWER = """
from nonsmooth.proofs.answers import destinations

destinations.STARTS, destinations.FEW_STARTS = 15, 3  # paths that count where bodies go
"""
SECONDS = 60  # for a whole notebook: a student waits for it
RUN = "from-a-measured-table-to-a-law"
# Of its paths, whose pictures are of the same kind, and of the wheels that fail.
SHORTER = {"until=0.15,": "until=0.05,", "start, until=1": "start, until=0.2", "in names:": "in names[:2]:"}
FORMULA, PICTURE, TABLE = "text/latex", "image/svg+xml", "text/html"
VIEW = "application/vnd.jupyter.widget-view+json"


@dataclass(frozen=True)
class Promise:
    """What a notebook shows: at least so many outputs of a kind, and words of its page."""

    formulas: int
    pictures: int
    tables: int
    words: tuple[str, ...]
    views: int = 1


PROMISED = {
    "from-a-measured-table-to-a-law": Promise(0, 4, 2, ("comes near", "can be held", "FUNCTION_BLOCK FB_Law")),
    "from-one-wheel-to-theorem-4": Promise(
        10,
        8,
        6,
        (
            "asymptotically stable",
            "can be held",
            "hypotheses not met",
            r"\begin{aligned}",
            r"\left[\begin{matrix}",
            r"\dot c \in F(c)",
            "MathJax",
        ),
        views=0,
    ),
    "sliding-modes-and-sampling": Promise(
        1,
        4,
        4,
        (
            "the largest V' is -3",
            "audit: invalid: V increases along a line",
            "at rest, x = 0.0",
            "valid: ",
            "V' < 0 at 100% of the points",
            "MathJax",
        ),
    ),
}

every_notebook = pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)


def outputs(notebook: nbformat.NotebookNode) -> list[nbformat.NotebookNode]:
    return [output for cell in notebook.cells if cell.cell_type == "code" for output in cell.outputs]


def shown(notebook: nbformat.NotebookNode, kind: str) -> list[str]:
    """All outputs of one MIME type."""
    return [output.data[kind] for output in outputs(notebook) if kind in output.get("data", {})]


def test_every_notebook_promises_something() -> None:
    assert [path.stem for path in NOTEBOOKS] == sorted(PROMISED)


@every_notebook
def test_notebook_is_stored_as_a_source(path: Path) -> None:
    """Valid, without outputs and counts, one spelling of the JSON, and identifiers that stay."""
    text = path.read_text(encoding="utf-8")
    notebook = nbformat.reads(text, nbformat.NO_CONVERT)
    nbformat.validate(notebook)
    assert outputs(notebook) == []
    assert all(cell.get("execution_count") is None and not cell.metadata for cell in notebook.cells)
    assert text == json.dumps(json.loads(text), indent=1, ensure_ascii=False) + "\n"
    names = [cell.id for cell in notebook.cells]
    assert len(set(names)) == len(names)
    assert all(re.fullmatch("[a-z][a-z0-9-]+", name) for name in names)
    assert sorted(notebook.metadata) == ["kernelspec", "language_info"]


# One notebook runs in `make test`, with shorter paths; of the calls in the others: test_every_program_of_the_page,
# test_api.py. `make bench` runs all as they are.
RUNS = [*((path, True) for path in NOTEBOOKS if path.stem == RUN), *((path, False) for path in NOTEBOOKS)]


@pytest.mark.parametrize(("path", "short"), keep(1, RUNS), ids=lambda given: getattr(given, "stem", str(given)))
def test_notebook_runs_and_renders(path: Path, short: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from nbclient import NotebookClient
    from nbconvert import HTMLExporter

    for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_RUNTIME_DIR"):
        monkeypatch.setenv(name, str(tmp_path))
    notebook = nbformat.read(path, nbformat.NO_CONVERT)
    cells = len(notebook.cells)
    for cell in notebook.cells:
        for written, shorter in SHORTER.items() if short else ():
            cell.source = cell.source.replace(written, shorter)
    notebook.cells.insert(0, nbformat.v4.new_code_cell(STRICT + FEWER if short else STRICT))
    NotebookClient(
        notebook, timeout=SECONDS, kernel_name="python3", resources={"metadata": {"path": str(tmp_path)}}
    ).execute()
    del notebook.cells[0]
    assert len(notebook.cells) == cells
    assert [output for output in outputs(notebook) if output.output_type == "error"] == []
    assert [output.text for output in outputs(notebook) if output.get("name") == "stderr"] == []
    promise = PROMISED[path.stem]
    assert len(shown(notebook, FORMULA)) >= promise.formulas
    assert len(shown(notebook, PICTURE)) >= promise.pictures
    assert sum("<table>" in table for table in shown(notebook, TABLE)) >= promise.tables
    assert len(shown(notebook, VIEW)) == promise.views

    page, _ = HTMLExporter().from_notebook_node(notebook)
    assert page.count("<svg") + page.count("image/svg+xml") >= len(shown(notebook, PICTURE))
    assert [words for words in promise.words if words not in unescape(page)] == []
    assert "Traceback" not in page
