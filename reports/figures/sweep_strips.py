"""The answers over one number as strips, with the certified rates below as curves."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

from nonsmooth.reports.figures.answer_colors import TITLES, legend_entries, look
from nonsmooth.reports.figures.labels import WIDE_TITLE, wrapped
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.reports.sweeps.borders import Border
from nonsmooth.reports.sweeps.table import sweep_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.sweeps.sweep import Sweep

SIZE = (8.0, 2.6)  # inches, of the strips alone
CURVE = 1.3  # inches for each rate
MOST_COLUMNS = 5  # of the legend
CURVES = {  # rates of an outcome, and what they are called
    "worst_rate": "max V*/|c|",
    "rate": "rate of return",
    "kappa": "kappa of the law",
    "within": "home from within",
    "tolerance_factor": "tolerances, times",
    "fall": "V falls at",
    "level": "certified V below",
}


def build_strips(sweep: Sweep) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    curves = [name for name in CURVES if any(outcome.get(name) is not None for outcome in sweep.outcomes)]
    heights = [SIZE[1], *[CURVE] * len(curves)]
    figure = Figure(figsize=(SIZE[0], sum(heights) + 0.8), layout="constrained")
    rows = figure.subplots(1 + len(curves), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    _draw_strips(rows[0], sweep)
    for axes, name in zip(rows[1:], curves, strict=True):
        _draw_curve(axes, sweep, name)
    rows[-1].set_xlabel(sweep.plan.names[0])
    figure.suptitle(wrapped(sweep_title(sweep), WIDE_TITLE), fontsize="medium", parse_math=False)
    occurring = {answer for _, _, answers in pieces(sweep) for answer in answers}
    entries = legend_entries(occurring)
    figure.legend(handles=entries, loc="outside lower center", ncols=min(len(entries), MOST_COLUMNS), frameon=False)
    return figure


def pieces(sweep: Sweep) -> list[tuple[float, float, tuple[str, ...]]]:
    """Intervals of the number with their answers; borders part them, else the middle between two neighbours."""
    places = positions(sweep)
    cuts: list[tuple[float, tuple[str, ...]]] = []
    for k, (left, right) in enumerate(pairwise(places)):
        before, after = (tuple(sweep.outcomes[i][name] for name in sweep.questions) for i in (k, k + 1))
        borders = [border for border in sweep.borders or () if border.places == (k,)]
        if borders:
            cuts += [(place_of(border), border.after) for border in borders]
        elif before != after:
            cuts.append(((left + right) / 2, after))
    first = tuple(sweep.outcomes[0][name] for name in sweep.questions)
    starts = [(places[0], first), *cuts]
    ends = [*(place for place, _ in cuts), places[-1]]
    return [(start, end, answers) for (start, answers), end in zip(starts, ends, strict=True)]


def positions(sweep: Sweep, axis: int = 0) -> list[float]:
    """Where the values of an axis stand."""
    values = sweep.plan.axes[axis].values
    return [values.value(k).number or 0.0 for k in range(sweep.plan.counts[axis])]


def place_of(border: Border) -> float:
    """Where a border stands on its axis."""
    return border.point[border.axis].number or 0.0


def _draw_strips(axes: Axes, sweep: Sweep) -> None:
    for row in range(len(sweep.questions)):
        for start, end, answers in pieces(sweep):
            axes.barh(-row, end - start, height=0.72, left=start, **look(answers[row]))
    axes.plot(positions(sweep), [0.55] * len(sweep.outcomes), "|", color=INK, markersize=4)  # what was checked
    for border in sweep.borders or ():
        axes.axvline(place_of(border), color=INK, linewidth=0.8)
    axes.set_yticks([-row for row in range(len(sweep.questions))], [TITLES[name] for name in sweep.questions])
    places = positions(sweep)
    axes.set_xlim(places[0], places[-1])


def _draw_curve(axes: Axes, sweep: Sweep, name: str) -> None:
    """One rate where it is known; the curve ends at borders, where it may jump."""
    cut_after = {border.places[0] for border in sweep.borders or ()}
    places: list[float] = []
    values: list[float] = []
    for k, (place, outcome) in enumerate(zip(positions(sweep), sweep.outcomes, strict=True)):
        places.append(place)
        values.append(float("nan") if outcome[name] is None else outcome[name])
        if k in cut_after:
            places.append(place)
            values.append(float("nan"))
    axes.plot(places, values, ".-", color=INK, linewidth=1)
    axes.set_ylabel(CURVES[name], fontsize="small")
    for border in sweep.borders or ():
        axes.axvline(place_of(border), color="0.7", linewidth=0.8, zorder=0)
