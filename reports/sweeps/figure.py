"""A sweep as a picture.

*Strips* over one number: the answers, with the certified rates below as curves.  *Maps* over two, one a question:
every square between four neighbouring scenes is cut where the answers change on its sides; each piece of the side with
one answer and the middle of the cuts make a polygon of its color.  So a border is exact on the lines of the grid, and
straight between them.  *Cells* that are certified as a whole, or left white.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from nonsmooth.proofs.findings import Certainty
from nonsmooth.reports.figures.style import INK, legend_below, new_figure, title_figure
from nonsmooth.reports.sweeps.borders import Border, has_place
from nonsmooth.reports.sweeps.certified_cells import CertifiedCell
from nonsmooth.reports.sweeps.outcome import REFUSED
from nonsmooth.reports.sweeps.sweep_plan import Axis, SweepError, SweepPlan
from nonsmooth.reports.sweeps.table import counted, sweep_title, title_of
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import XY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.sweeps.sweep import Sweep

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
REFUSED_HATCH = "////"
MOST_COLUMNS = 5  # of the legend
SEAM = 0.7  # points by which a piece overlaps its neighbours, so that no ground shows between equal ones


def _look(answer: str) -> dict[str, Any]:
    """How a piece with this answer is filled."""
    color = COLORS[answer]
    if answer == REFUSED:
        return {"facecolor": color, "linewidth": 0, "hatch": REFUSED_HATCH, "edgecolor": "0.6"}
    return {"facecolor": color, "linewidth": SEAM, "edgecolor": color}


def _explain(figure: Figure, sweep: Sweep, answers: set[str]) -> None:
    """A title, and a legend with a patch for each color that occurs and the answers that it stands for."""
    from matplotlib.patches import Patch

    words: dict[str, list[str]] = {}
    for answer, color in COLORS.items():
        if answer in answers:
            words.setdefault(color, []).append(answer)
    entries = [Patch(label=", ".join(said), **_look(said[0])) for said in words.values()]
    title_figure(figure, sweep_title(sweep))
    legend_below(figure, entries, min(len(entries), MOST_COLUMNS))


def require_picture(plan: SweepPlan) -> None:
    """Refuse what has no picture.

    Raises:
        SweepError: for random draws, more than two numbers, and values that do not ascend.
    """
    if plan.draws is not None:
        raise SweepError("output: required .csv, .json or .parquet for random draws, received a picture")
    if len(plan.axes) > 2:
        raise SweepError(f"output: required one or two numbers that vary for a picture, received {len(plan.axes)}")
    for axis in plan.axes:
        if not has_place(axis.values) or (axis.values.count or 0) < 2:
            required = "two or more rational values that ascend for a picture"
            raise SweepError(f"vary {axis.name}: required {required}, received others")


def build_figure(sweep: Sweep) -> Figure:
    """The picture as a Matplotlib figure."""
    if sweep.cells is not None:
        return _cells(sweep, sweep.cells)
    return _strips(sweep) if len(sweep.plan.axes) == 1 else _maps(sweep)


# ---- strips --------------------------------------------------------------------------------------

STRIPS = (8.0, 2.6)  # inches, of the strips alone
CURVE = 1.3  # inches for each rate
NEAR = "ends_within"
CURVES = {  # numbers of an outcome, and what they are called
    NEAR: "ends within",
    "worst_rate": "max V*/|c|",
    "rate": "rate of return",
    "kappa": "kappa of the law",
    "within": "comes from within",
    "tolerance_factor": "tolerances, times",
    "fall": "V falls at",
    "level": "certified V below",
}


LENGTHS = {NEAR, "within"}
# Keys of numbers that are varied, by what they are; a speed of [tolerance] is a share.
OF_LENGTH = {
    *("position", "equilibrium", "radius", "length", "accuracy", "pitch", "width", "height", "vertices"),
    *("centre_of_mass", "centre_height", "position_error"),
}
OF_SPEED, OF_ANGLE = {"speed", "speed_limit"}, {"heading", "phase", "axis", "direction", "heading_error"}


def axis_label(axis: Axis, document: Mapping[str, Any]) -> str:
    """The key of a number that varies, with the unit in which the scene states it, where it states units."""
    units = document.get("units", {})
    length, keys = units.get("length"), {step for step in axis.path if isinstance(step, str)}
    unit = ""
    if keys & OF_LENGTH:
        unit = length
    elif keys & OF_SPEED and "tolerance" not in keys:
        unit = units.get("speed", f"{length}/s")
    elif keys & OF_ANGLE:
        in_radians = any(word in str(axis.values.value(0).entry) for word in ("pi", "rad"))
        unit = "rad" if in_radians else units.get("angle", "deg")
    elif keys & {"mass", "delay"}:
        unit = "kg" if "mass" in keys else "s"
    return f"{axis.name} [{unit}]" if length and unit else axis.name


def _label(sweep: Sweep, place: int) -> str:
    return axis_label(sweep.plan.axes[place], sweep.base.document)


def _is_drawn(sweep: Sweep, name: str) -> bool:
    """Whether some scene has a number; of how near bodies come, whether it is not zero for all that come."""
    known = [outcome[name] for outcome in sweep.outcomes if outcome.get(name) is not None]
    return any(known) if name == NEAR else bool(known)


def _strips(sweep: Sweep) -> Figure:
    curves = [name for name in CURVES if _is_drawn(sweep, name)]
    heights = [STRIPS[1], *[CURVE] * len(curves)]
    figure = new_figure(STRIPS[0], sum(heights) + 0.8)
    rows = figure.subplots(1 + len(curves), 1, sharex=True, squeeze=False, height_ratios=heights)[:, 0]
    _draw_strips(rows[0], sweep)
    for axes, name in zip(rows[1:], curves, strict=True):
        _draw_curve(axes, sweep, name)
    rows[-1].set_xlabel(_label(sweep, 0))
    _explain(figure, sweep, {answer for _, _, answers in _pieces(sweep) for answer in answers})
    return figure


def _pieces(sweep: Sweep) -> list[tuple[float, float, tuple[str, ...]]]:
    """Intervals of the number with their answers; borders part them, else the middle between two neighbours."""
    places = _positions(sweep)
    cuts: list[tuple[float, tuple[str, ...]]] = []
    for k, (left, right) in enumerate(pairwise(places)):
        before, after = (tuple(sweep.outcomes[i][name] for name in sweep.questions) for i in (k, k + 1))
        borders = [border for border in sweep.borders or () if border.places == (k,)]
        if borders:
            cuts += [(_place_of(border), border.after) for border in borders]
        elif before != after:
            cuts.append(((left + right) / 2, after))
    first = tuple(sweep.outcomes[0][name] for name in sweep.questions)
    starts = [(places[0], first), *cuts]
    ends = [*(place for place, _ in cuts), places[-1]]
    return [(start, end, answers) for (start, answers), end in zip(starts, ends, strict=True)]


def _positions(sweep: Sweep, axis: int = 0) -> list[float]:
    """Where the values of an axis stand."""
    values = sweep.plan.axes[axis].values
    return [values.value(k).number or 0.0 for k in range(sweep.plan.counts[axis])]


def _place_of(border: Border) -> float:
    """Where a border stands on its axis."""
    return border.point[border.axis].number or 0.0


def _draw_strips(axes: Axes, sweep: Sweep) -> None:
    for row in range(len(sweep.questions)):
        for start, end, answers in _pieces(sweep):
            axes.barh(-row, end - start, height=0.72, left=start, **_look(answers[row]))
    axes.plot(_positions(sweep), [0.55] * len(sweep.outcomes), "|", color=INK, markersize=4)  # what was checked
    for border in sweep.borders or ():
        axes.axvline(_place_of(border), color=INK, linewidth=0.8)
    axes.set_yticks([-row for row in range(len(sweep.questions))], list(map(title_of, sweep.questions)))
    places = _positions(sweep)
    axes.set_xlim(places[0], places[-1])


def _draw_curve(axes: Axes, sweep: Sweep, name: str) -> None:
    """One rate where it is known; the curve ends at borders, where it may jump."""
    cut_after = {border.places[0] for border in sweep.borders or ()}
    places: list[float] = []
    values: list[float] = []
    for k, (place, outcome) in enumerate(zip(_positions(sweep), sweep.outcomes, strict=True)):
        places.append(place)
        values.append(float("nan") if outcome[name] is None else outcome[name])
        if k in cut_after:
            places.append(place)
            values.append(float("nan"))
    axes.plot(places, values, ".-", color=INK, linewidth=1, clip_on=False)  # whole dots at both ends
    length = sweep.base.document.get("units", {}).get("length")
    unit = f" [{length}]" if length and name in LENGTHS else ""
    axes.set_ylabel(CURVES[name] + unit, fontsize="small")
    for border in sweep.borders or ():
        axes.axvline(_place_of(border), color="0.7", linewidth=0.8, zorder=0)


# ---- maps ----------------------------------------------------------------------------------------

MAPS = (9.0, 8.2)  # inches
MANY = 900  # scenes beyond which they are not marked one by one
THIN = 1e-6  # of its length: a piece so narrow is drawn as a line

Sides: TypeAlias = dict[tuple[int, tuple[int, ...]], list[Border]]


class Cut(NamedTuple):
    """A corner of a square, or a border on its side.

    Attributes:
        place: where it is.
        answer: what follows it, counterclockwise.
        axis: of the side that a border cuts, 0 across and 1 along; None at a corner.
    """

    place: XY
    answer: str
    axis: int | None = None


def _maps(sweep: Sweep) -> Figure:
    figure = new_figure(*MAPS)
    count = len(sweep.questions)
    panels = figure.subplots(*((2, 2) if count > 1 else (1, 1)), sharex=True, sharey=True, squeeze=False)
    for k, (axes, name) in enumerate(zip(panels.flat, sweep.questions, strict=True)):
        _draw_map(axes, sweep, k)
        axes.set_title(title_of(name))
    for axes in panels[-1]:
        axes.set_xlabel(_label(sweep, 0))
    for axes in panels[:, 0]:
        axes.set_ylabel(_label(sweep, 1))
    said = {outcome[name] for outcome in sweep.outcomes for name in sweep.questions}
    said |= {answer for border in sweep.borders or () for answer in (*border.before, *border.after)}
    _explain(figure, sweep, said)
    return figure


def _draw_map(axes: Axes, sweep: Sweep, question: int) -> None:
    xs, ys = _positions(sweep, 0), _positions(sweep, 1)
    sides: Sides = {}
    for border in sweep.borders or ():
        sides.setdefault((border.axis, border.places), []).append(border)
    for i in range(len(xs) - 1):
        for j in range(len(ys) - 1):
            _draw_square(axes, list(_way_round(sweep, question, sides, (i, j), xs, ys)))
    if len(sweep.outcomes) <= MANY:
        axes.plot(*zip(*((x, y) for x in xs for y in ys), strict=True), ".", color=INK, markersize=1.5)
    axes.set(xlim=(xs[0], xs[-1]), ylim=(ys[0], ys[-1]))


def _way_round(
    sweep: Sweep, question: int, sides: Sides, corner: tuple[int, int], xs: list[float], ys: list[float]
) -> Iterator[Cut]:
    """Corners and cuts of a square, counterclockwise from its lower left corner, with the answers that follow them."""
    i, j = corner
    around = (((i, j), 0, False), ((i + 1, j), 1, False), ((i + 1, j + 1), 0, True), ((i, j + 1), 1, True))
    name = sweep.questions[question]
    for (a, b), axis, backward in around:
        yield Cut((xs[a], ys[b]), sweep.outcomes[sweep.plan.index((a, b))][name])
        low = ((a - 1, b) if axis == 0 else (a, b - 1)) if backward else (a, b)
        found = sides.get((axis, low), [])
        for border in reversed(found) if backward else found:
            before, after = border.before[question], border.after[question]
            if before != after:
                place = _place_of(border)
                at = (place, ys[b]) if axis == 0 else (xs[a], place)
                yield Cut(at, before if backward else after, axis)


def _draw_square(axes: Axes, way: list[Cut]) -> None:
    """The pieces of one square, and the borders between them."""
    changes = [k for k, cut in enumerate(way) if cut.answer != way[k - 1].answer]
    if not changes:
        axes.fill(*zip(*(cut.place for cut in way), strict=True), **_look(way[0].answer))
        return
    middle = _meeting([way[k] for k in changes])
    for first, last in zip(changes, [*changes[1:], changes[0] + len(way)], strict=True):
        arc = [way[k % len(way)].place for k in range(first, last + 1)]
        axes.fill(*zip(*arc, middle, strict=True), **_look(way[first].answer))
        if _is_thin([*arc, middle]):  # the answer holds along a line alone
            axes.plot(*zip(*arc, strict=True), color=_look(way[first].answer)["facecolor"], linewidth=2.5, zorder=4)
    for k in changes:
        (x, y), (u, v) = way[k].place, middle
        axes.plot([x, u], [y, v], color=INK, linewidth=1, solid_capstyle="round", zorder=3)


def _is_thin(polygon: list[XY]) -> bool:
    """Whether a polygon is a line, within the width to which borders are known."""
    (xs, ys) = zip(*polygon, strict=True)
    width, height = max(xs) - min(xs), max(ys) - min(ys)
    return bool(min(width, height) <= THIN * max(width, height))


def _meeting(cuts: list[Cut]) -> XY:
    """Where the borders of a square meet: half-way between two; of more where those across and along cross."""
    across = [cut.place[0] for cut in cuts if cut.axis == 0]
    along = [cut.place[1] for cut in cuts if cut.axis == 1]
    if len(cuts) > 2 and across and along:
        return _mean(across), _mean(along)
    return _mean([cut.place[0] for cut in cuts]), _mean([cut.place[1] for cut in cuts])


def _mean(values: list[float]) -> float:
    return sum(values) / len(values)


# ---- certified cells -----------------------------------------------------------------------------

MAP, STRIP = (7.5, 6.8), (8.0, 2.2)  # inches
MOST_NAMED = 64  # cells beyond which their radii are not written in them


def _cells(sweep: Sweep, cells: Sequence[CertifiedCell]) -> Figure:
    """Over two numbers a map, over one a strip."""
    from matplotlib.patches import Patch

    is_map = len(sweep.plan.axes) == 2
    figure = new_figure(*(MAP if is_map else STRIP))
    axes = figure.subplots()
    for cell in cells:
        _draw_cell(axes, cell, named=len(cells) <= MOST_NAMED)
    axes.autoscale_view(tight=True)
    axes.set_xlabel(_label(sweep, 0))
    if is_map:
        axes.set_ylabel(_label(sweep, 1))
    else:
        axes.set_yticks([])
    title_figure(figure, f"{sweep_title(sweep)}\n{counted(sweep).rpartition('; ')[2]}")
    known = Patch(facecolor=COLORS["holds"], label="certified for every array in the cell (radius where bodies end)")
    open_ = Patch(facecolor="white", edgecolor=INK, label="not certified")
    legend_below(figure, [known, open_])
    return figure


def _draw_cell(axes: Axes, cell: CertifiedCell, *, named: bool) -> None:
    """A rectangle; of one number as high as the strip."""
    from matplotlib.patches import Rectangle

    (left, right), (low, high) = [(a.number, b.number) for a, b in cell.sides] + [(0.0, 1.0)] * (2 - len(cell.sides))
    color = COLORS["holds"] if cell.verdict is Certainty.CERTIFIED else "white"
    axes.add_patch(Rectangle((left, low), right - left, high - low, facecolor=color, edgecolor="0.75", linewidth=0.5))
    if named and cell.ends_within is not None:
        text = float_text(float(cell.ends_within), 2)
        axes.text((left + right) / 2, (low + high) / 2, text, ha="center", va="center", fontsize="x-small")
