"""The contact rules side by side: as a table, as JSON and as a picture."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.minimizers.agreement import Agreement, TwistDifference, intersect
from nonsmooth.reports.document import Block, Paragraph, table
from nonsmooth.reports.exact_record import with_exact
from nonsmooth.reports.figures.cell_map import PICTURE, TINT, draw_hatch, figure_bytes, require_drawable
from nonsmooth.reports.figures.labels import centre_labels, wrapped
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.symbolic.number_text import float_text, place_text, short_text
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

AGREEMENT_SCHEMA = "nonsmooth-agreement/1"
AGREE, DIFFER = "#009E73", "#E69F00"  # bluish green and orange: told apart by color-blind readers, and by hatching
HATCH = "//"


def agreement_blocks(agreement: Agreement) -> Sequence[Block]:
    """Shares and differences as a table."""
    rows, twists = [], []
    for (first, second), shared in agreement.shared.items():
        share = short_text(shared.share)
        rows.append((f"{first} and {second}", f"same motion on a share of {share} of the area (exact)"))
        which = "" if len(agreement.shared) == 1 else f" of {first} and {second}"
        twists.append(f"{len(shared.shared_twists)} twists in common{which}")
    for (first, second), difference in agreement.differences.items():
        rows.append((f"{first} and {second}", difference_text(difference)))
    (first, cells), *others = ((name, len(partition.cells)) for name, partition in agreement.partitions.items())
    counts = [f"{cells} cells under rule {first}", *(f"{count} under rule {name}" for name, count in others)]
    note = "differences of the twist (|v|, R omega), R the distance of the farthest wheel, relative to the larger twist"
    found = table(("rules", "agreement on the square"), rows, (1.0, 3.0))
    return [Paragraph((", ".join(counts + twists),)), found, Paragraph((note,))]


def agreement_record(agreement: Agreement) -> dict[str, Any]:
    """Shares and differences with stable keys."""
    shares = {pair: _shared_record(agreement, *pair) for pair in agreement.shared}
    differences = {pair: _difference_record(difference) for pair, difference in agreement.differences.items()}
    records = {f"{first}_{second}": record for (first, second), record in (shares | differences).items()}
    return {"schema": AGREEMENT_SCHEMA, "scene": _scene_name(agreement), "agreement": records}


def _shared_record(agreement: Agreement, first: str, second: str) -> dict[str, Any]:
    shared = agreement.shared[first, second]
    return {
        **with_exact({"area": shared.area, "share": shared.share}),
        "shared_twists": [with_exact({"twist": twist}) for twist in shared.shared_twists],
        "cells": {name: len(agreement.partitions[name].cells) for name in (first, second)},
    }


def _scene_name(agreement: Agreement) -> str:
    return next(iter(agreement.partitions.values())).scene.name


def agreement_map(agreement: Agreement, suffix: str) -> bytes:
    """The square, shaded by whether two rules prescribe the same motion; ``suffix`` as for the cell map."""
    return figure_bytes(lambda: build_figure(agreement), suffix)


def build_figure(agreement: Agreement) -> Figure:
    """The picture as a Matplotlib figure, one panel for each pair of rules with cells."""
    from matplotlib.figure import Figure

    require_drawable(next(iter(agreement.partitions.values())))
    pairs = list(agreement.shared)
    figure = Figure(figsize=(PICTURE * len(pairs), PICTURE + 0.4), layout="constrained")
    panels = [figure] if len(pairs) == 1 else list(figure.subfigures(1, len(pairs), squeeze=False)[0])
    for pair, panel in zip(pairs, panels, strict=True):
        handles = draw_pair(panel.subplots(), agreement, *pair)
        panel.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    return figure


def draw_pair(axes: Axes, agreement: Agreement, first: str, second: str) -> list[Patch]:
    """Where two rules with cells prescribe the same motion; returns what a legend says."""
    from matplotlib.colors import to_rgba
    from matplotlib.patches import Patch

    for own in agreement.partitions[first].cells:
        for other in agreement.partitions[second].cells:
            common = intersect(own.polygon, other.polygon)
            if common is not None:
                same = frozenset(own.twists) == frozenset(other.twists)
                xs, ys = zip(*((float(x), float(y)) for x, y in common.vertices), strict=True)
                axes.fill(xs, ys, facecolor=AGREE if same else DIFFER, alpha=TINT, edgecolor="none")
                axes.fill(xs, ys, facecolor="none", edgecolor="white", linewidth=1)
                if not same:
                    draw_hatch(axes, xs, ys, HATCH)
    share = short_text(agreement.shared[first, second].share)
    units = agreement.partitions[first].scene.units
    axes.set(aspect="equal", **centre_labels(units))
    axes.set_title(wrapped(f"{one_line(_scene_name(agreement))}: rules {first} and {second}"), parse_math=False)
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


def _difference_record(difference: TwistDifference) -> dict[str, Any]:
    return {
        "points": difference.points,
        "mean": difference.mean,
        "largest": difference.largest,
        "at": None if difference.at is None else list(difference.at),
        "not_certified": difference.not_certified or None,
    }
