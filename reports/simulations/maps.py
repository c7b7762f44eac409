"""A map of starts: where a grid of starts over the checked square ends, when, and at which heading; sampled.

:class:`MapResult` says what all maps share; :class:`SettleMapResult` is that of an array, by the cells of its rule.  A
body with an outline (:mod:`nonsmooth.reports.simulations.body_maps`) and a plain system
(:mod:`nonsmooth.reports.simulations.system_maps`) have maps of their own.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import Partition, RefusalError
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.trajectories.maps import SettleMap, grid_starts, settle_map
from nonsmooth.analysis.trajectories.result import EndReason, TrajectoryError
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.style import (
    INK,
    LEGEND_LINE,
    TIMES,
    TOLD_APART,
    draw_bar,
    draw_grid,
    grid_extent,
    legend_below,
    new_figure,
    require_drawable,
    start_labels,
    time_label,
    title_figure,
)
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.facts import floats
from nonsmooth.reports.output.progress import progress
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.simulations.path_ends import accuracy_text, heading_text, range_text, shown_angle
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.mechanics.contact_set import accuracy_at_point
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import percent_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, float_points

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

SCHEMA = "nonsmooth-map/1"
SHOWN = 12  # ends listed on a terminal
MAX_GRID = 500  # starts in a row: a quarter of a million paths, some 40 MB of JSON
PLACED = (EndReason.REST, EndReason.TURNING, EndReason.APPROACH)  # ends whose place is where the body stays

# the picture
SIZE = (12.6, 6.0)  # inches, without the legend
SCALE = 0.05  # height of a color scale, relative to its map
HEADINGS = "PuOr"  # map of colors that is safe for color-blind readers
OTHER_ENDS = "#F2F2F2"  # color of all ends beyond the palette
SHADE = 0.45  # opacity of the dark veil over starts with several solutions
NOTHING: dict[str, Any] = {"facecolor": "0.85", "edgecolor": "0.6", "hatch": "///", "linewidth": 0.0}
NO_NUMBER = "no limit of theta, or no arrival"


def grid_of(options: SimulateOptions) -> int:
    """Starts in a row and in a column of a map.

    Raises:
        OptionError: for too few or too many, and a heading that is no angle.
    """
    count = options.grid or 0
    if not 2 <= count <= MAX_GRID:
        raise OptionError(f"--grid: required 2 to {MAX_GRID} starts in a row, received {count}")
    if not math.isfinite(options.heading):
        raise OptionError(f"--heading: required a finite number (radian), received {options.heading}")
    return count


class Part(NamedTuple):
    """How many starts end in one way; the parts of a map add up to all its starts."""

    text: str
    starts: int


class MapResult(Result):
    """Where, when and at which heading the bodies of a grid of starts end, or solutions of a system; sampled."""

    @property
    @abstractmethod
    def title(self) -> str:
        """The scene and the rule."""

    @property
    @abstractmethod
    def parts(self) -> list[Part]:
        """How many starts end in each way."""

    @property
    @abstractmethod
    def endings(self) -> list[tuple[float, str]]:
        """Share and words of every kind of end, largest first."""

    @property
    def shares(self) -> list[tuple[str, str]]:
        """The same with shares in percent."""
        return [(percent_text(share), words) for share, words in self.endings]

    def parts_record(self) -> list[Record]:
        """JSON of the parts."""
        return [{"end": part.text, "starts": part.starts} for part in self.parts]

    def summary(self) -> str:
        """``961 starts: the body rests (896), still moving at the last time (65)``; the largest part first."""
        parts = self.parts
        named = ", ".join(f"{part.text} ({part.starts})" for part in sorted(parts, key=lambda part: -part.starts))
        return f"{sum(part.starts for part in parts)} starts: {named}"

    def dimensions(self) -> Sequence[str]:
        """The two coordinates of the starts."""
        return self.table().columns[:2]

    def __repr__(self) -> str:
        return short_lines(f"{self.title}: {self.summary()} (sampled)", self.shares)


class ArrayMap(MapResult):
    """The map of an array: how many bodies end at its checked point is said beside where all end.

    Attributes:
        options: what was mapped.
    """

    options: SimulateOptions

    @property
    @abstractmethod
    def array(self) -> Scene:
        """What bodies move over."""

    @property
    @abstractmethod
    def home(self) -> Mask:
        """Which starts end within the accuracy of the checked point, by every solution (m,)."""

    @property
    def massless(self) -> str:
        """Said of times where the scene says what gravity is, for a body with inertia takes longer."""
        return ", without inertia" if self.array.inertia is not None else ""

    def are_near(self, places: Floats) -> Mask:
        """Which of the places (m, 2) are within the accuracy of the checked point; none is not."""
        away = places - self.array.check.place
        return np.hypot(*away.T) <= float(accuracy_at_point(self.array))

    def home_record(self) -> Record:
        """JSON of how many end at the checked point, and of all parts."""
        accuracy = float(accuracy_at_point(self.array))
        return {"accuracy": accuracy, "home": int(self.home.sum()), "parts": self.parts_record()}

    def first_rows(self, perhaps: int = 0, *, moving: bool = False) -> list[tuple[str, str]]:
        """How many of all starts end within the accuracy, and the largest shares of the ends.

        Args:
            perhaps: how many more may, by one of several solutions.
            moving: whether some still move at the last time, of which where they are then counts.
        """
        more = f", {perhaps} more by one of several solutions" if perhaps else ""
        end = "end, or are at the last time," if moving else "end"
        home = f"{int(self.home.sum())} of {len(self.home)} {end} within {accuracy_text(self.array)} of it{more}"
        rows, others = [("at the point", home), *self.shares[:SHOWN]], self.endings[SHOWN:]
        if others:
            rows.append((percent_text(sum(share for share, _ in others)), f"{len(others)} others"))
        return rows

    def square(self, starts: Floats) -> str:
        """Over which square the starts (m, n) lie, and at which heading."""
        units, ((left, low), (right, high)) = self.array.units, (starts[:, :2].min(axis=0), starts[:, :2].max(axis=0))
        places = f"x from {left:.6g} to {right:.6g}, y from {low:.6g} to {high:.6g}{units.after_length}"
        return f"{places}, {heading_text(units, self.options.heading, 'theta_0')}"


@dataclass(frozen=True)
class Basin:
    """Kinds of ends that read the same: their numbers in the map, and the share of the starts that end so."""

    text: str
    kinds: tuple[int, ...]
    share: float


@dataclass(frozen=True, repr=False)
class SettleMapResult(ArrayMap):
    """The ends of a grid of paths through cells.

    Attributes:
        partition: the cells.
        options: what was mapped.
        found: the ends.
    """

    partition: Partition
    options: SimulateOptions
    found: SettleMap

    @property
    def array(self) -> Scene:
        """That of the cells."""
        return self.partition.scene

    @property
    def title(self) -> str:
        """The scene and the rule."""
        return f"{self.array.name}, rule {self.partition.rule}"

    @cached_property
    def home(self) -> Mask:
        """Which starts end within the accuracy of the checked point, by every solution (m,)."""
        return self._near & self.found.unique

    @cached_property
    def _near(self) -> Mask:
        """Which do by the solution that is followed (m,)."""
        return self.are_near(self.found.points)

    @property
    def parts(self) -> list[Part]:
        """How many starts end in each way, wherever that is."""
        reasons = [self.found.ends[k][0] for k in self.found.basin]
        return [Part(reason.value, reasons.count(reason)) for reason in dict.fromkeys(reasons)]

    @cached_property
    def basins(self) -> list[Basin]:
        """The ends, largest share first; told apart by place only where the body stays there."""
        kinds: dict[str, list[int]] = {}
        for k, (reason, place) in enumerate(self.found.ends):
            kinds.setdefault(f"{reason.value}: {place}" if reason in PLACED else reason.value, []).append(k)
        basins = [Basin(text, tuple(ends), sum(self.found.shares[k] for k in ends)) for text, ends in kinds.items()]
        return sorted(basins, key=lambda basin: -basin.share)

    @property
    def endings(self) -> list[tuple[float, str]]:
        """Share and words of every basin, and when bodies arrive there."""
        return [(basin.share, basin.text + self._arrivals(basin)) for basin in self.basins]

    def _arrivals(self, basin: Basin) -> str:
        """The range of times; empty where bodies only come nearer."""
        times = self.found.arrival[self.found.arrived & np.isin(self.found.basin, basin.kinds)]
        second = self.array.units.after_time
        return f", by t = {range_text(times)}{second}" if len(times) else ""

    def facts(self) -> Record:
        """JSON with stable keys; starts run along x first."""
        return {
            "schema": SCHEMA,
            "scene": self.array.name,
            "rule": str(self.partition.rule),
            "kinematics": str(self.options.kinematics),
            "grid": self.options.grid,
            "theta_0": self.options.heading,
            "until": self.options.until,
            "summary": self._summary,
            **self.found.record(),
            **self.home_record(),
        }

    @property
    def _summary(self) -> Record:
        found = self.found
        return {
            "shares": list(found.shares),
            "theta": _range(found.theta[found.settled]),
            "latest_arrival": float(found.arrival[found.arrived].max()) if found.arrived.any() else None,
            "arrived": float(found.arrived.mean()),
            "unique": float(found.unique.mean()),
        }

    def table(self) -> DataTable:
        """One start per line; None where there is no number."""
        found = self.found
        names = ("x", "y", "theta", "arrival", "x_end", "y_end", "reason", "place", "unique")
        numbers = np.column_stack([found.starts, found.theta, found.arrival, found.points])
        lines = []
        for row, basin, unique in zip(numbers.tolist(), found.basin, found.unique, strict=True):
            reason, place = found.ends[basin]
            lines.append([*floats(row), reason.value, place, "yes" if unique else "no"])
        return DataTable(names, lines)

    def blocks(self) -> Sequence[Block]:
        """The shares of the ends, the range of headings, the latest arrival and what is not unique."""
        rows = self.first_rows(int((self._near & ~self.found.unique).sum()))
        summary, units = self._summary, self.array.units
        theta, latest = summary["theta"], summary["latest_arrival"]
        shown = [shown_angle(units, angle) for angle in theta or ()]
        last = f"{shown[0]:.10g} to {shown[1]:.10g}{' deg' * units.in_degrees}" if shown else "-"
        rows.append(("last heading" if units.in_degrees else "theta_inf", last))
        arrival = "-" if latest is None else f"t = {latest:.10g}{units.after_time}"
        rows.append((f"latest arrival{self.massless}", arrival))
        rows.append(("never arrive", percent_text(1 - summary["arrived"])))
        rows.append(("not unique", percent_text(1 - summary["unique"])))
        return [*sentences(self.head, self.square(self.found.starts)), findings(rows)]

    @property
    def head(self) -> str:
        """What was mapped."""
        options, count = self.options, self.options.grid
        until = "" if options.until is None else f", seen at t = {options.until:.6g}"
        what = f"rule {self.partition.rule}, {options.kinematics} kinematics, {count} x {count} starts{until}"
        return f"{one_line(self.array.name)}: {what}"

    def draw(self, ax: Axes) -> None:
        """Ends by color, over the cells; what is not unique is darker."""
        from matplotlib.colors import to_rgb, to_rgba

        found = self.found
        colors = np.zeros((len(found.ends), 3))
        for basin, color in self._colored():
            colors[list(basin.kinds)] = to_rgb(color)
        ax.set_title("end")
        draw_grid(ax, found.starts, colors[found.basin])
        veil = np.zeros((len(found.starts), 4))
        veil[~found.unique] = to_rgba(INK, SHADE)
        draw_grid(ax, found.starts, veil)
        _draw_cell_borders(ax, self.partition)
        ax.set(**start_labels(self.array.units), aspect="equal")

    def figure(self) -> Figure:
        """Where each start ends, when, and at which heading.

        Raises:
            SceneError: where the square is too large, too small or too far away to be drawn with floats.
        """
        require_drawable(self.array)
        entries = self._legend()
        figure = new_figure(SIZE[0], SIZE[1] + LEGEND_LINE * -(-len(entries) // 2))
        rows = figure.add_gridspec(2, 3, height_ratios=(1, SCALE))
        heading, arrival, ends = (figure.add_subplot(rows[0, k]) for k in range(3))
        self._draw_heading(heading, figure.add_subplot(rows[1, 0]))
        self._draw_arrival(arrival, figure.add_subplot(rows[1, 1]))
        self.draw(ends)
        for axes in (heading, arrival):
            _draw_cell_borders(axes, self.partition)
            axes.set(**start_labels(self.array.units), aspect="equal")
        for axes in (arrival, ends):
            axes.set_ylabel("")
            axes.tick_params(labelleft=False)
        title_figure(figure, f"{self.head}\n{self.summary()}")
        legend_below(figure, entries)
        return figure

    def _draw_heading(self, axes: Axes, scale: Axes) -> None:
        from matplotlib.colors import CenteredNorm

        found, start = self.found, self.options.heading
        values = np.degrees(np.where(found.settled, found.theta, np.nan))
        start = math.degrees(start)
        turned = np.abs(values[found.settled] - start)
        norm = CenteredNorm(start, float(turned.max(initial=0.0)) or 1.0)
        axes.set_title(f"heading at rest ({start:.6g} deg at the start)")
        _draw_numbers(axes, scale, found.starts, values, "heading at rest [deg]", cmap=HEADINGS, norm=norm)

    def _draw_arrival(self, axes: Axes, scale: Axes) -> None:
        found, label = self.found, time_label("t", self.array.units)
        values = np.where(found.arrived, found.arrival, np.nan)
        latest = float(values[found.arrived].max(initial=0.0)) or 1.0
        axes.set_title(f"time of arrival{self.massless}")
        _draw_numbers(axes, scale, found.starts, values, label, cmap=TIMES, vmin=0.0, vmax=latest)

    def _colored(self) -> list[tuple[Basin, str]]:
        return [(basin, TOLD_APART[k] if k < len(TOLD_APART) else OTHER_ENDS) for k, basin in enumerate(self.basins)]

    def _legend(self) -> list[Patch]:
        """An entry for each color, and for what else occurs."""
        from matplotlib.patches import Patch

        found, colored = self.found, self._colored()
        entries = [
            Patch(facecolor=color, label=f"{percent_text(basin.share)}: {basin.text}")
            for basin, color in colored[: len(TOLD_APART)]
        ]
        if others := colored[len(TOLD_APART) :]:
            label = f"{percent_text(sum(basin.share for basin, _ in others))}: {len(others)} other ends"
            entries.append(Patch(facecolor=OTHER_ENDS, edgecolor="0.6", label=label))
        if not found.unique.all():
            entries.append(Patch(facecolor=INK, alpha=SHADE, label="darker: several solutions, one of them is drawn"))
        if not (found.settled & found.arrived).all():
            entries.append(Patch(label=NO_NUMBER, **NOTHING))
        return entries


def build_settle_map(scene: Scene, options: SimulateOptions) -> SettleMapResult:
    """Follow every start of a grid, with progress on a terminal.

    Raises:
        OptionError: for a grid or a heading that cannot be used.
        RefusalError: where the motion is not determined, and where cells are so thin that floats lose their borders.
    """
    count = grid_of(options)
    partition = build_partition(scene)
    try:
        found = settled(partition, count, options)
    except TrajectoryError as error:
        place = str(error).removesuffix(": please report this")
        required = "required cells that floats tell apart, to follow paths"
        raise RefusalError(f"{required}, received thinner ones ({place})") from None
    return SettleMapResult(partition, options, found)


def settled(partition: Partition, count: int, options: SimulateOptions) -> SettleMap:
    """The ends of ``count x count`` starts."""
    field = array_field(partition, options.kinematics)
    with progress(f"{count} x {count} starts") as report:
        found = settle_map(field, grid_starts(field, count), options.heading, report)
    return found if options.until is None else found.seen_until(options.until)


def _range(values: Any) -> list[float] | None:
    return [float(values.min()), float(values.max())] if len(values) else None


# ---- the picture -----------------------------------------------------------------------------------


def _draw_numbers(axes: Axes, scale: Axes, starts: Floats, values: Floats, label: str, **colors: Any) -> None:
    """One number per start, with its scale; a hatched ground shows where there is none."""
    from matplotlib.patches import Rectangle

    left, right, low, high = grid_extent(starts)
    axes.add_patch(Rectangle((left, low), right - left, high - low, zorder=0, **NOTHING))
    axes.set(xlim=(left, right), ylim=(low, high))
    if np.isnan(values).all():
        scale.set_axis_off()
        return
    image = draw_grid(axes, starts, np.ma.masked_invalid(values), zorder=1, **colors)
    draw_bar(scale.figure, image, label, cax=scale, orientation="horizontal")


def _draw_cell_borders(axes: Axes, partition: Partition) -> None:
    for cell in partition.cells:
        corners = float_points(cell.polygon.vertices)
        axes.fill(*corners.T, facecolor="none", edgecolor=INK, alpha=0.4, linewidth=0.5, zorder=2)
