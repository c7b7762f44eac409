"""The computed parts of ``docs/evidence.md`` and its figure: ``python -m nonsmooth.reports.evidence.page docs``.

The page keeps its text; what stands between ``<!-- vehicles -->``, ``<!-- pushes -->``, ``<!-- ranking -->``,
``<!-- claims -->`` or ``<!-- engine -->`` and the next ``<!-- end -->`` is computed anew.  The table of the physics
engine comes from ``docs/evidence/engine.csv``, which the tests write: the engine is no part of the program.
"""

from __future__ import annotations

import csv
import re
import sys
from collections.abc import Iterable, Sequence
from pathlib import Path

from nonsmooth.reports.evidence.claim import Claim, ClaimKind
from nonsmooth.reports.evidence.pack import Evidence, gather
from nonsmooth.reports.evidence.pushes import PushEvidence
from nonsmooth.reports.files import make_folder, output_path, write_whole
from nonsmooth.reports.progress import steps
from nonsmooth.symbolic.number_text import float_text

COMPUTED = re.compile(r"(?s)(<!-- (vehicles|pushes|ranking|claims|engine) -->\n).*?(?=<!-- end -->)")


def write_page(folder: Path, evidence: Evidence) -> Path:
    """Write ``evidence.md`` and its figure into a folder that holds the page and the engine's table."""
    figure, page = folder / "evidence" / "evidence.svg", folder / "evidence.md"
    make_folder(figure.parent)
    write_whole(output_path(str(figure), (".svg",)), evidence.picture(".svg"))
    engine = (folder / "evidence" / "engine.csv").read_text(encoding="utf-8")
    text = page_text(page.read_text(encoding="utf-8"), evidence, engine)
    write_whole(output_path(str(page), (".md",)), text.encode())
    return page


def page_text(page: str, evidence: Evidence, engine: str) -> str:
    """The page with its computed parts replaced; parts that the evidence does not hold stay."""
    parts = {kind.value: claims_table(evidence, kind) for kind in ClaimKind}
    parts["ranking"] = "" if evidence.pushes is None else ranking_table(evidence.pushes)
    parts["engine"] = _table(*_engine_rows(engine))
    return COMPUTED.sub(lambda found: found[1] + (parts[found[2]] or found[0][len(found[1]) :]), page)


def claims_table(evidence: Evidence, kind: ClaimKind) -> str:
    """The rows of one kind; empty where there are none."""
    rows = [_row(claim) for claim in evidence.claims if claim.kind is kind]
    header = ("claim", "source", "predicted", "measured or claimed", "error", "verdict", "fitted", "what shows it")
    return _table(header, rows) if rows else ""


def ranking_table(pushes: PushEvidence) -> str:
    """Models both ways, with their intervals."""
    header = ("prediction", "place", "model", "numbers fitted", "median [deg]", "95 % interval", "above the one before")
    rows = []
    for row in pushes.record():
        gap = row["above_the_better"]
        cells = (row["direction"], str(row["place"]), row["model"], str(row["fitted"]), float_text(row["median"], 3))
        rows.append((*cells, _interval(row["interval"]), "-" if gap is None else _interval(gap)))
    return _table(header, rows)


def _row(claim: Claim) -> tuple[str, ...]:
    predicted, measured, error = claim.values()
    shown = "-" if claim.kind is ClaimKind.PUSHES and not claim.measured else measured
    parts = (claim.claim, claim.source, predicted, shown, error, claim.verdict.value)
    return (*parts, str(claim.fitted) if claim.fitted else "nothing", claim.witness)


def _interval(interval: Sequence[float]) -> str:
    low, high = (float_text(value, 3) for value in interval)
    return f"{low} to {high}"


def _engine_rows(text: str) -> tuple[Sequence[str], list[list[str]]]:
    header, *rows = csv.reader(text.splitlines())
    return header, rows


def _table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(entry.replace('|', chr(92) + '|') for entry in line)} |" for line in lines) + "\n"


def main() -> None:
    """Write the page into the folder that is named."""
    with steps("evidence"):
        evidence = gather()
    print(write_page(Path(sys.argv[1]), evidence))


if __name__ == "__main__":
    main()
