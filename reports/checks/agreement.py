"""The contact rules side by side: where they move a body alike on the checked square."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.polygon import clipped_by
from nonsmooth.analysis.minimizers.agreement import Agreement, TwistDifference, compare_rules
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.cells import draw_hatch
from nonsmooth.reports.figures.style import (
    INK,
    PICTURE,
    TINT,
    centre_labels,
    legend_below,
    new_figure,
    require_drawable,
    title_axes,
)
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.facts import with_exact
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import float_text, place_text, short_text
from nonsmooth.symbolic.numbers.plane_arrays import float_points

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

AGREEMENT_SCHEMA = "nonsmooth-agreement/1"
AGREE, DIFFER = "#009E73", "#E69F00"  # bluish green and orange: told apart by color-blind readers, and by hatching
HATCH = "//"
NOTE = "differences of the twist (|v|, R omega), R the distance of the farthest wheel, relative to the larger twist"


@dataclass(frozen=True, repr=False)
class ComparisonResult(Result):
    """Where the contact rules move a body alike on the checked square.

    Attributes:
        agreement: shares of the area (exact) for rules with cells, sampled differences beside rules without.
    """

    agreement: Agreement

    def facts(self) -> Record:
        """Shares and differences with stable keys."""
        agreement = self.agreement
        shares = {pair: _shared_record(agreement, *pair) for pair in agreement.shared}
        differences = {pair: _difference_record(difference) for pair, difference in agreement.differences.items()}
        records = {f"{first}_{second}": record for (first, second), record in (shares | differences).items()}
        return {"schema": AGREEMENT_SCHEMA, "scene": _scene_name(agreement), "agreement": records}

    def table(self) -> DataTable:
        """One line for each pair of rules: what is compared, and what was found."""
        what, lines = "share of the area with the same motion", []
        for pair, shared in self.agreement.shared.items():
            lines.append((" and ".join(pair), what, short_text(shared.share)))
        for pair, difference in self.agreement.differences.items():
            lines.append((" and ".join(pair), "sampled", difference_text(difference)))
        return DataTable(("rules", "what", "found"), lines)

    def blocks(self) -> Sequence[Block]:
        """Shares and differences."""
        rows, twists, agreement = [], [], self.agreement
        for (first, second), shared in agreement.shared.items():
            share = short_text(shared.share)
            rows.append((f"{first} and {second}", f"same motion on a share of {share} of the area (exact)"))
            which = "" if len(agreement.shared) == 1 else f" of {first} and {second}"
            twists.append(f"{len(shared.shared_twists)} twists in common{which}")
        for (first, second), difference in agreement.differences.items():
            rows.append((f"{first} and {second}", difference_text(difference)))
        (first, cells), *others = ((name, len(partition.cells)) for name, partition in agreement.partitions.items())
        counts = [f"{cells} cells under rule {first}", *(f"{count} under rule {name}" for name, count in others)]
        found = table(("rules", "agreement on the square"), rows, (1.0, 3.0))
        return [*sentences(", ".join(counts + twists)), found, *sentences(NOTE)]

    def summary(self) -> str:
        """The shares of the area on which rules agree."""
        shared = self.agreement.shared.items()
        return "; ".join(f"rules {a} and {b} agree on a share of {found.share}" for (a, b), found in shared)

    def draw(self, ax: Axes) -> None:
        """Where the first two rules with cells prescribe the same motion."""
        _draw_pair(ax, self.agreement, *next(iter(self.agreement.shared)))

    def figure(self) -> Figure:
        """One panel for each pair of rules with cells.

        Raises:
            SceneError: where the square is too large, too small or too far away to be drawn with floats.
        """
        require_drawable(next(iter(self.agreement.partitions.values())).scene)
        pairs = list(self.agreement.shared)
        figure = new_figure(PICTURE * len(pairs), PICTURE + 0.4)
        panels = [figure] if len(pairs) == 1 else list(figure.subfigures(1, len(pairs), squeeze=False)[0])
        for pair, panel in zip(pairs, panels, strict=True):
            legend_below(panel, _draw_pair(panel.subplots(), self.agreement, *pair))
        return figure

    def __repr__(self) -> str:
        said = [(rules, f"{what} {found}") for rules, what, found in self.table().lines]
        return short_lines(f"contact rules on {_scene_name(self.agreement)}", said)


def compare_scene(scene: Scene) -> ComparisonResult:
    """Compare all contact rules on the square of an array.

    Raises:
        RefusalError: where the motion is not determined.
    """
    return ComparisonResult(compare_rules(scene))


def _shared_record(agreement: Agreement, first: str, second: str) -> Record:
    shared = agreement.shared[first, second]
    return {
        **with_exact({"area": shared.area, "share": shared.share}),
        "shared_twists": [with_exact({"twist": twist}) for twist in shared.shared_twists],
        "cells": {name: len(agreement.partitions[name].cells) for name in (first, second)},
    }


def _scene_name(agreement: Agreement) -> str:
    return next(iter(agreement.partitions.values())).scene.name


def _draw_pair(axes: Axes, agreement: Agreement, first: str, second: str) -> list[Patch]:
    """Where two rules with cells prescribe the same motion; returns what a legend says."""
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Patch

    for cell in agreement.partitions[first].cells:
        for other in agreement.partitions[second].cells:
            common = clipped_by(cell.polygon, other.polygon.sides)
            if common is not None:
                same = frozenset(cell.twists) == frozenset(other.twists)
                corners = float_points(common.vertices)
                axes.fill(*corners.T, facecolor=AGREE if same else DIFFER, alpha=TINT, edgecolor="none")
                axes.fill(*corners.T, facecolor="none", edgecolor="white", linewidth=1)
                if not same:
                    draw_hatch(axes, corners, HATCH)
    share = short_text(agreement.shared[first, second].share)
    units = agreement.partitions[first].scene.units
    axes.set(aspect="equal", **centre_labels(units))
    title_axes(axes, f"{one_line(_scene_name(agreement))}: rules {first} and {second}")
    return [
        Patch(facecolor=AGREE, alpha=TINT, label=f"same motion: {share} of the area"),
        Patch(facecolor=to_rgba(DIFFER, TINT), hatch=HATCH, edgecolor=INK, linewidth=0, label="different motions"),
    ]


def difference_text(difference: TwistDifference) -> str:
    """Mean and largest difference, sampled, and what is not certified."""
    missing = f"not certified: {difference.not_certified}"
    if difference.mean is None or difference.largest is None or difference.at is None:
        return missing
    mean, largest = float_text(difference.mean, 3), float_text(difference.largest, 3)
    shown = (
        f"relative difference of twist {mean} in the mean, at most {largest} "
        f"near {place_text(difference.at, 4)}, over {difference.points} points"
    )
    return f"{shown}; {missing}" if difference.not_certified else shown


def _difference_record(difference: TwistDifference) -> Record:
    return {
        "points": difference.points,
        "mean": difference.mean,
        "largest": difference.largest,
        "at": None if difference.at is None else list(difference.at),
        "not_certified": difference.not_certified or None,
    }
