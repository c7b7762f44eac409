"""``python -m tests.evidence.page docs`` writes the computed parts of ``docs/evidence.md`` and its figure.

The page keeps its text; what stands between ``<!-- vehicles -->``, ``<!-- pushes -->``, ``<!-- ranking -->``,
``<!-- claims -->`` or ``<!-- engine -->`` and the next ``<!-- end -->`` is computed anew.
"""

from __future__ import annotations

import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from matplotlib.figure import Figure

from nonsmooth.reports.figures.style import INK, LINES, figure_bytes
from nonsmooth.symbolic.numbers.number_text import float_text
from tests.evidence.claims import claim_comparisons
from tests.evidence.comparison import Comparison
from tests.evidence.engine import Kind, engine_errors
from tests.evidence.pushes import Direction, Ranking, gap, interval_text, one_of, push_comparisons, rank
from tests.evidence.vehicles import MULTIPLIER, vehicle_comparisons

if TYPE_CHECKING:
    from matplotlib.axes import Axes

COMPUTED = re.compile(r"(?s)(<!-- ((?!end)\w+) -->\n).*?(?=<!-- end -->)")
COMPARED = ("claim", "source", "predicted", "measured or claimed", "error", "verdict", "fitted", "what shows it")
RANKED = ("prediction", "place", "model", "numbers fitted", "median [deg]", "95 % interval", "above the one before")
ENGINE = ("kind", "rule", "arrays", "median", "nine of ten below", "largest")
BINS = list(range(0, 95, 5))  # degrees


class Evidence(NamedTuple):
    """What was predicted and what was measured: about vehicles, pushes and published claims."""

    vehicles: Sequence[Comparison]
    ranking: Ranking
    claims: Sequence[Comparison]


def gather() -> Evidence:
    """All of it: about half a minute."""
    ranking = {direction: rank(direction) for direction in Direction}
    return Evidence(list(vehicle_comparisons()), ranking, list(claim_comparisons()))


# ---- tables --------------------------------------------------------------------------------------


def page_tables(evidence: Evidence, engine: Iterable[Kind]) -> dict[str, str]:
    """The computed parts of the page by their marks."""
    return {
        "vehicles": comparison_table(evidence.vehicles),
        "pushes": comparison_table(push_comparisons(evidence.ranking)),
        "ranking": ranking_table(evidence.ranking),
        "claims": comparison_table(evidence.claims),
        "engine": table(ENGINE, (kind.row() for kind in engine)),
    }


def comparison_table(rows: Iterable[Comparison]) -> str:
    """Predictions beside what others measured or claim."""
    return table(COMPARED, (row.cells() for row in rows))


def ranking_table(ranking: Ranking) -> str:
    """Models both ways, with the intervals of their medians and of the difference to the one before."""
    rows = []
    for direction, ranked in ranking.items():
        for place, one in enumerate(ranked, 1):
            above = "-" if place == 1 else interval_text(gap(ranked[place - 2], one))
            cells = direction, str(place), one.model.name, str(one.model.parameters)
            rows.append((*cells, float_text(one.median, 3), interval_text(one.interval), above))
    return table(RANKED, rows)


def table(header: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """In Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join(f"| {' | '.join(entry.replace('|', chr(92) + '|') for entry in line)} |" for line in lines) + "\n"


# ---- figure --------------------------------------------------------------------------------------


def evidence_figure(evidence: Evidence) -> Figure:
    """Errors of the vehicles, histograms of the pushes, medians of the models, verdicts of the claims."""
    figure = Figure(figsize=(11, 8.4), layout="constrained")
    errors, histogram, medians, verdicts = figure.subplots(2, 2).ravel()
    draw_errors(errors, [row for row in evidence.vehicles if row.claim.startswith(MULTIPLIER)])
    draw_histogram(histogram, evidence.ranking)
    draw_medians(medians, evidence.ranking)
    draw_verdicts(verdicts, evidence.claims)
    return figure


def draw_errors(axes: Axes, rows: Sequence[Comparison]) -> None:
    """Relative errors of the vehicles."""
    names = [row.claim.rpartition(", ")[2] for row in rows]
    axes.barh(range(len(names)), [100 * (row.error or 0.0) for row in rows], color=LINES[0])
    axes.set_yticks(range(len(names)), names, fontsize="small")
    axes.invert_yaxis()
    axes.axvline(0, color=INK, linewidth=0.8)
    axes.set(xlabel="predicted over measured, less one [%]")
    axes.set_title("effective track of turns, nothing fitted", fontsize="medium")


def draw_histogram(axes: Axes, ranking: Ranking) -> None:
    """Errors of the point contacts with nothing fitted, both ways, beside a guess."""
    for color, direction in zip(LINES, Direction, strict=False):
        own = one_of(ranking, direction, "isotropic")
        axes.hist(own.errors, BINS, histtype="step", linewidth=1.6, color=color, label=direction.value)
    naive = one_of(ranking, Direction.WRENCH, "naive")
    axes.hist(naive.errors, BINS, histtype="step", linestyle=":", color=INK, label="guess: parallel")
    axes.set(xlabel="angle between predicted and measured direction [deg]", ylabel="pushes")
    axes.set_title("400 measured pushes, point contacts, nothing fitted", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")


def draw_medians(axes: Axes, ranking: Ranking) -> None:
    """Medians with their intervals."""
    models = [one.model for one in ranking[Direction.WRENCH]]
    for k, (direction, ranked) in enumerate(ranking.items()):
        places = [models.index(one.model) + 0.18 * (2 * k - 1) for one in ranked]
        medians = np.array([one.median for one in ranked])
        low, high = np.array([one.interval for one in ranked]).T
        style: dict[str, Any] = {"color": LINES[k], "capsize": 3, "linestyle": "none", "marker": "o"}
        axes.errorbar(medians, places, xerr=[medians - low, high - medians], label=direction.value, **style)
    axes.set_yticks(range(len(models)), [f"{model.name} ({model.parameters} fitted)" for model in models])
    axes.invert_yaxis()
    axes.set(xlabel="median angle [deg], 95 % bootstrap interval", xlim=(0, None))
    axes.set_title("models of friction on pushes that they have not seen", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")


def draw_verdicts(axes: Axes, rows: Sequence[Comparison]) -> None:
    """How many published claims agree, and how many are refuted."""
    counts = sorted(Counter(row.verdict.value for row in rows).items())
    axes.bar([name for name, _ in counts], [count for _, count in counts], color=LINES[: len(counts)])
    axes.set(ylabel="published claims")
    axes.set_title("published claims, as scenes", fontsize="medium")


# ---- page ----------------------------------------------------------------------------------------


def filled(page: str, tables: Mapping[str, str]) -> str:
    """The page with its computed parts replaced."""
    return COMPUTED.sub(lambda part: part[1] + tables[part[2]], page)


def main() -> None:
    """Write the page into the folder that is named, some minutes."""
    folder = Path(sys.argv[1])
    evidence = gather()
    picture = figure_bytes(lambda: evidence_figure(evidence), ".svg")
    page = folder / "evidence.md"
    text = filled(page.read_text(encoding="utf-8"), page_tables(evidence, engine_errors()))
    (folder / "evidence" / "evidence.svg").write_bytes(picture)
    page.write_text(text, encoding="utf-8")
    print(page)


if __name__ == "__main__":
    main()
