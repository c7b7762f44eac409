"""The gallery of finished reports: ``python -m tests.gallery docs`` writes ``gallery.md`` and its files.

A report holds no times and no dates, so the gallery changes only when the program does; a test rebuilds it and fails
when it is stale.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

from nonsmooth.proofs.theorem4 import CellCheck
from nonsmooth.reports.checks.subject import Invocation
from nonsmooth.reports.derivations.derivation import ReportResult, derive_report, render_report
from nonsmooth.reports.figures.cells import cell_map
from nonsmooth.reports.output.files import output_path, write_whole
from nonsmooth.reports.output.progress import progress
from nonsmooth.symbolic.files.documents import builtin_descriptions
from nonsmooth.symbolic.files.scene_file import load_scene

PAGE, FOLDER = "gallery.md", "gallery"
SHOWN = ("four-wheel", "ring-6", "spiral-30", "outward")
INTRODUCTION = """\
# Gallery

Reports as `nonsmooth derive SCENE -o report.html` writes them: the array, every contact state with its equations, the
cells, V*, Theorem 4 clause by clause, trajectories, the contact rules side by side. Each is one file that needs no
network; download it and open it in a browser. Rebuilt by `make gallery`.
"""


def gallery_report(name: str) -> ReportResult:
    """The report of one scene."""
    return derive_report(load_scene(name), Invocation(name))


def gallery_files(name: str, report: ReportResult) -> Iterator[tuple[str, bytes]]:
    """Path below the documents' folder and content of each file of one scene."""
    if not isinstance(report.result, CellCheck):
        raise TypeError("required a contact rule with cells")
    yield f"{FOLDER}/{name}.html", render_report(report, ".html").encode()
    yield f"{FOLDER}/{name}.svg", cell_map(report.result.partition, ".svg")


def gallery_page(reports: dict[str, ReportResult]) -> str:
    """The page: each scene with its cells, its verdict and the decisive reason."""
    descriptions, parts = builtin_descriptions(), [INTRODUCTION]
    for name, report in reports.items():
        parts += [
            f"## {name}\n",
            f"{descriptions[name]}\n",
            f"Theorem 4: **{report.result.verdict}**. {_sentence(report.result.reason)}\n",
            f"[Report of {name}]({FOLDER}/{name}.html)\n",
            f"![the cells of {name}]({FOLDER}/{name}.svg)\n",
        ]
    return "\n".join(parts)


def _sentence(reason: str) -> str:
    """A reason as a sentence of Markdown."""
    text = reason[:1].upper() + reason[1:]
    return "".join(f"\\{sign}" if sign in "*_|<>[]`" else sign for sign in text) + "."


def write_gallery(folder: Path) -> Path:
    """Write every file of the gallery below a folder, and return the page."""
    reports: dict[str, ReportResult] = {}
    (folder / FOLDER).mkdir(exist_ok=True)
    with progress("reports") as report:
        for done, name in enumerate(SHOWN):
            report(done, len(SHOWN), name)
            reports[name] = gallery_report(name)
            for path, content in gallery_files(name, reports[name]):
                target = folder / path
                write_whole(output_path(str(target), (target.suffix,)), content)
    page = output_path(str(folder / PAGE), (".md",))
    write_whole(page, gallery_page(reports).encode())
    return page


def main(folder: Path) -> None:
    """Write the gallery and say where it is."""
    print(write_gallery(folder))


if __name__ == "__main__":
    main(Path(sys.argv[1]))
