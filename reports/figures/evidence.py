"""The evidence as a picture: vehicles, histograms of 400 pushes, and models of friction with their intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.pushes.ranking import Direction
from nonsmooth.reports.figures.cell_map import figure_bytes
from nonsmooth.reports.figures.measurements import COLORS
from nonsmooth.reports.figures.wheels import INK

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.evidence.claim import Claim
    from nonsmooth.reports.evidence.pack import Evidence
    from nonsmooth.reports.evidence.pushes import PushEvidence

BINS = list(range(0, 95, 5))  # degrees


def evidence_figure(evidence: Evidence, suffix: str) -> bytes:
    """One panel for each kind of evidence that there is."""
    return figure_bytes(lambda: _build(evidence), suffix)


def _build(evidence: Evidence) -> Figure:
    from matplotlib.figure import Figure

    vehicles, counted = evidence.multipliers, evidence.published
    panels = bool(vehicles) + 2 * (evidence.pushes is not None) + bool(counted)
    figure = Figure(figsize=(11, 4.2 * ((panels + 1) // 2)), layout="constrained")
    axes = iter(figure.subplots((panels + 1) // 2, 2, squeeze=False).ravel())
    if vehicles:
        _draw_errors(next(axes), vehicles)
    if evidence.pushes is not None:
        _draw_histogram(next(axes), evidence.pushes)
        _draw_ranking(next(axes), evidence.pushes)
    if counted:
        _draw_verdicts(next(axes), counted)
    for unused in axes:
        unused.set_axis_off()
    return figure


def _draw_errors(axes: Axes, claims: list[Claim]) -> None:
    """Relative errors of the vehicles."""
    names = [claim.claim.rpartition(", ")[2] for claim in claims]
    errors = [100 * (claim.error or 0.0) for claim in claims]
    axes.barh(range(len(names)), errors, color=COLORS[0])
    axes.set_yticks(range(len(names)), names, fontsize="small")
    axes.invert_yaxis()
    axes.axvline(0, color=INK, linewidth=0.8)
    axes.set(xlabel="predicted over measured, less one [%]")
    axes.set_title("effective track of turns, nothing fitted", fontsize="medium")


def _draw_histogram(axes: Axes, pushes: PushEvidence) -> None:
    """Errors of the point contacts with nothing fitted, both ways, beside a guess."""
    for k, direction in enumerate(Direction):
        own = pushes.of(direction, "isotropic")
        axes.hist(own.errors, BINS, histtype="step", linewidth=1.6, color=COLORS[k], label=direction.value)
    naive = pushes.of(Direction.WRENCH, "naive")
    axes.hist(naive.errors, BINS, histtype="step", linestyle=":", color=INK, label="guess: parallel")
    axes.set(xlabel="angle between predicted and measured direction [deg]", ylabel="pushes")
    axes.set_title("400 measured pushes, point contacts, nothing fitted", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")


def _draw_ranking(axes: Axes, pushes: PushEvidence) -> None:
    """Medians with their intervals."""
    names = [one.model.name for one in pushes.ranked[Direction.WRENCH]]
    for k, (direction, ranked) in enumerate(pushes.ranked.items()):
        places = [names.index(one.model.name) + 0.18 * (2 * k - 1) for one in ranked]
        medians = np.array([one.median for one in ranked])
        low, high = np.array([one.interval for one in ranked]).T
        style: dict[str, Any] = {"color": COLORS[k], "capsize": 3, "linestyle": "none", "marker": "o"}
        axes.errorbar(medians, places, xerr=[medians - low, high - medians], label=direction.value, **style)
    parameters = {one.model.name: one.model.parameters for one in pushes.ranked[Direction.WRENCH]}
    axes.set_yticks(range(len(names)), [f"{name} ({parameters[name]} fitted)" for name in names])
    axes.invert_yaxis()
    axes.set(xlabel="median angle [deg], 95 % bootstrap interval", xlim=(0, None))
    axes.set_title("models of friction on pushes that they have not seen", fontsize="medium")
    axes.legend(frameon=False, fontsize="small")


def _draw_verdicts(axes: Axes, claims: list[Claim]) -> None:
    """How many published claims agree, and how many are refuted."""
    verdicts = sorted({claim.verdict.value for claim in claims})
    counts = [sum(claim.verdict.value == verdict for claim in claims) for verdict in verdicts]
    axes.bar(verdicts, counts, color=[COLORS[k] for k in range(len(verdicts))])
    axes.set(ylabel="published claims")
    axes.set_title("published claims, as scenes", fontsize="medium")
