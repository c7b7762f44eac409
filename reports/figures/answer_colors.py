"""The colors of answers and verdicts in pictures of sweeps."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nonsmooth.reports.sweeps.system_outcome import REFUSED

if TYPE_CHECKING:
    from matplotlib.patches import Patch

# Exact colors of answers, from Okabe and Ito's palette and a lighter green; equal words are equal colors.
COLORS = {
    "comes home": "#009E73",
    "comes near": "#66C2A5",
    "can be held": "#009E73",
    "holds": "#009E73",
    "stays near": "#F0E442",
    "keeps": "#56B4E9",
    "drifts": "#E69F00",
    "leaves": "#D55E00",
    "cannot be held": "#D55E00",
    "fails": "#D55E00",
    "asymptotically stable": "#009E73",
    "stable": "#F0E442",
    "unstable": "#D55E00",
    "tips": "#0072B2",
    "hypotheses not met": "#CC79A7",
    "undecided": "#999999",
    REFUSED: "#FFFFFF",
}
TITLES = {
    "position": "position",
    "heading": "heading",
    "pose": "pose",
    "theorem4": "Theorem 4",
    "stability": "stability",
}
REFUSED_HATCH = "////"
SEAM = 0.7  # points by which a piece overlaps its neighbours, so that no ground shows between equal ones


def look(answer: str) -> dict[str, Any]:
    """How a piece with this answer is filled."""
    color = COLORS[answer]
    if answer == REFUSED:
        return {"facecolor": color, "linewidth": 0, "hatch": REFUSED_HATCH, "edgecolor": "0.6"}
    return {"facecolor": color, "linewidth": SEAM, "edgecolor": color}


def legend_entries(answers: set[str]) -> list[Patch]:
    """A patch for each color that occurs, with the answers that it stands for."""
    from matplotlib.patches import Patch

    words: dict[str, list[str]] = {}
    for answer, color in COLORS.items():
        if answer in answers:
            words.setdefault(color, []).append(answer)
    return [Patch(label=", ".join(said), **look(said[0])) for said in words.values()]
