"""The three contact rules side by side: as a table, as JSON and as a picture."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.minimizers.agreement import Agreement, TwistDifference, intersect
from nonsmooth.reports.exact_record import with_exact
from nonsmooth.reports.figures.cell_map import PICTURE, TINT, figure_bytes, require_drawable
from nonsmooth.reports.terminal import brief, header_table
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from matplotlib.figure import Figure

AGREEMENT_SCHEMA = "nonsmooth-agreement/1"
AGREE, DIFFER = "#009E73", "#E69F00"  # bluish green and orange: told apart by color-blind readers, and by hatching


def agreement_view(agreement: Agreement) -> RenderableType:
    """Shares and differences as a table."""
    table = header_table("rules", "agreement on the square")
    shared = agreement.shared
    table.add_row("nearest and box", f"same motion on a share of {brief(shared.share)} of the area (exact)")
    for name, difference in _differences(agreement):
        table.add_row(f"ellipse and {name}", _difference_text(difference))
    cells = f"{len(agreement.nearest.cells)} cells under rule nearest, {len(agreement.box.cells)} under rule box, "
    twists = f"{len(shared.shared_twists)} twists in common"
    note = "differences of the twist (|v|, R omega), R the distance of the farthest wheel, relative to the larger twist"
    return Group(Text(cells + twists), table, Text(note, "dim"))


def agreement_record(agreement: Agreement) -> dict[str, Any]:
    """Shares and differences with stable keys."""
    shared = agreement.shared
    return {
        "schema": AGREEMENT_SCHEMA,
        "scene": agreement.nearest.scene.name,
        "agreement": {
            "nearest_box": {
                **with_exact({"area": shared.area, "share": shared.share}),
                "shared_twists": [with_exact({"twist": twist}) for twist in shared.shared_twists],
                "cells": {"nearest": len(agreement.nearest.cells), "box": len(agreement.box.cells)},
            },
            **{f"ellipse_{name}": _difference_record(difference) for name, difference in _differences(agreement)},
        },
    }


def agreement_map(agreement: Agreement, suffix: str) -> bytes:
    """The square, shaded by whether nearest and box prescribe the same motion; ``suffix`` as for the cell map."""
    require_drawable(agreement.nearest)
    return figure_bytes(lambda: build_figure(agreement), suffix)


def build_figure(agreement: Agreement) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

    figure = Figure(figsize=(PICTURE, PICTURE + 0.4), layout="constrained")
    axes = figure.subplots()
    for first in agreement.nearest.cells:
        for second in agreement.box.cells:
            common = intersect(first.polygon, second.polygon)
            if common is not None:
                same = frozenset(first.twists) == frozenset(second.twists)
                xs, ys = zip(*((float(x), float(y)) for x, y in common.vertices), strict=True)
                axes.fill(xs, ys, facecolor=AGREE if same else DIFFER, alpha=TINT, edgecolor="none")
                axes.fill(xs, ys, facecolor="none", edgecolor="white", linewidth=1, hatch=None if same else "//")
    handles = [
        Patch(facecolor=AGREE, alpha=TINT, label=f"same motion: {brief(agreement.shared.share)} of the area"),
        Patch(facecolor=DIFFER, alpha=TINT, hatch="//", edgecolor="white", label="different motions"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=2, frameon=False)
    axes.set(xlabel="x of the centre of mass [length unit of the scene]")
    axes.set(ylabel="y of the centre of mass [length unit of the scene]", aspect="equal")
    axes.set_title(f"{one_line(agreement.nearest.scene.name)}: rules nearest and box", parse_math=False)
    return figure


def _differences(agreement: Agreement) -> tuple[tuple[str, TwistDifference], ...]:
    return ("nearest", agreement.ellipse_nearest), ("box", agreement.ellipse_box)


def _difference_text(difference: TwistDifference) -> str:
    missing = f"not certified: {difference.not_certified}"
    if difference.mean is None or difference.largest is None or difference.at is None:
        return missing
    x, y = difference.at
    shown = (
        f"relative difference of twist {difference.mean:.3g} in the mean, at most {difference.largest:.3g} "
        f"near ({x:.4g}, {y:.4g}), over {difference.points} points"
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
