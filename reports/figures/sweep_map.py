"""The answers over two numbers as maps: one for each question, with borders where they were found by bisection.

Every square between four neighbouring scenes is cut where the answers change on its sides; each piece of the side with
one answer and the middle of the cuts make a polygon of its color.  So a border is exact on the lines of the grid, and
straight between them.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

from nonsmooth.reports.figures.answer_colors import TITLES, legend_entries, look
from nonsmooth.reports.figures.labels import WIDE_TITLE, wrapped
from nonsmooth.reports.figures.sweep_strips import place_of, positions
from nonsmooth.reports.figures.wheels import INK
from nonsmooth.reports.sweeps.borders import Border
from nonsmooth.reports.sweeps.table import sweep_title

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.sweeps.sweep import Sweep

SIZE = (9.0, 8.2)  # inches
MOST_COLUMNS = 5  # of the legend
MANY = 900  # scenes beyond which they are not marked one by one
THIN = 1e-6  # of its length: a piece so narrow is drawn as a line

XY: TypeAlias = tuple[float, float]
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


def build_map(sweep: Sweep) -> Figure:
    """The picture as a Matplotlib figure."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=SIZE, layout="constrained")
    count = len(sweep.questions)
    panels = figure.subplots(*((2, 2) if count > 1 else (1, 1)), sharex=True, sharey=True, squeeze=False)
    for k, (axes, name) in enumerate(zip(panels.flat, sweep.questions, strict=True)):
        _draw_map(axes, sweep, k)
        axes.set_title(TITLES[name])
    for axes in panels[-1]:
        axes.set_xlabel(sweep.plan.names[0])
    for axes in panels[:, 0]:
        axes.set_ylabel(sweep.plan.names[1])
    figure.suptitle(wrapped(sweep_title(sweep), WIDE_TITLE), fontsize="medium", parse_math=False)
    said = {outcome[name] for outcome in sweep.outcomes for name in sweep.questions}
    said |= {answer for border in sweep.borders or () for answer in (*border.before, *border.after)}
    entries = legend_entries(said)
    figure.legend(handles=entries, loc="outside lower center", ncols=min(len(entries), MOST_COLUMNS), frameon=False)
    return figure


def _draw_map(axes: Axes, sweep: Sweep, question: int) -> None:
    xs, ys = positions(sweep, 0), positions(sweep, 1)
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
                place = place_of(border)
                at = (place, ys[b]) if axis == 0 else (xs[a], place)
                yield Cut(at, before if backward else after, axis)


def _draw_square(axes: Axes, way: list[Cut]) -> None:
    """The pieces of one square, and the borders between them."""
    changes = [k for k, cut in enumerate(way) if cut.answer != way[k - 1].answer]
    if not changes:
        axes.fill(*zip(*(cut.place for cut in way), strict=True), **look(way[0].answer))
        return
    middle = _meeting([way[k] for k in changes])
    for first, last in zip(changes, [*changes[1:], changes[0] + len(way)], strict=True):
        arc = [way[k % len(way)].place for k in range(first, last + 1)]
        axes.fill(*zip(*arc, middle, strict=True), **look(way[first].answer))
        if _is_thin([*arc, middle]):  # the answer holds along a line alone
            axes.plot(*zip(*arc, strict=True), color=look(way[first].answer)["facecolor"], linewidth=2.5, zorder=4)
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
