"""The command ``simulate --grid`` for a plain system in two states: where starts all over the square have come to.

Every start is followed by events up to one time, so the map is sampled and proves nothing. Where stability is proved
with a certified level set of V, the paths from inside it are compared with the proof: V must have fallen as is said.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.result import UNFINISHED, TrajectoryError
from nonsmooth.analysis.trajectories.smooth_path import MAX_WORK
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.answers.contradictions import FollowedStarts, contradictions_of_map
from nonsmooth.proofs.findings import Contradiction, Record, Translation
from nonsmooth.proofs.systems.border_motion import BorderKind
from nonsmooth.reports.checks.answers import contradiction_lines, contradictions_record
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.figures.style import (
    INK,
    TIMES,
    TITLE,
    draw_bar,
    draw_grid,
    legend_below,
    new_figure,
    title_figure,
)
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.facts import floats
from nonsmooth.reports.output.progress import ProgressCall, progress
from nonsmooth.reports.simulations.maps import MapResult, Part, grid_of
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable, short_lines
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite, finite_rows, max_norm, norms
from nonsmooth.symbolic.numbers.work_limit import WorkMeter
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.image import AxesImage


SCHEMA = "nonsmooth-system-map/1"
UNTIL = 10.0  # last time of the paths, where none is given
WORK_OF_A_START = 2_000  # evaluations of fields: usual paths take some hundred
# Of the half-width, and of distances: what differs by less is one place, as far as the integrator can tell.
SAME = 1e-9

# the picture
SIZE = (7.4, 6.6)  # inches
NEAREST, FARTHEST = 1e-6, 10.0  # ratios of distances at the ends of the color scale
RATIOS = (1e-6, 1e-4, 0.01, 1.0)  # its ticks
LOST = "0.85"


class PathLocation(StrEnum):
    """Where a path is at the last time."""

    ARRIVED = "at the checked point"
    NEARER = "nearer than at the start"
    FARTHER = "not nearer, within the square"
    OUTSIDE = "outside the square"
    LOST = "not followed to the end"


@dataclass(frozen=True, repr=False)
class SystemMap(MapResult):
    """Where paths from N x N starts are at one time.

    Attributes:
        portrait: the system, its cells and verdict.
        count: starts in a row and in a column.
        until: last time.
        starts: (N^2, 2), in the displacement from the checked point, first state first.
        ends: (N^2, 2), likewise; not a number where a path could not be followed.
    """

    portrait: PhasePortrait
    count: int
    until: float
    starts: Floats
    ends: Floats

    @cached_property
    def ratios(self) -> Floats:
        """Distance from the checked point at the end by that at the start; the point itself has ratio 0."""
        first, last = (norms(places) for places in (self.starts, self.ends))
        return np.divide(last, first, out=np.where(last > 0, np.inf, 0.0), where=first > 0)

    @cached_property
    def whereabouts(self) -> list[PathLocation]:
        """Of every path."""
        half = self.portrait.system.check.half_width
        return [_whereabouts(end, ratio, half) for end, ratio in zip(self.ends, self.ratios, strict=True)]

    @property
    def title(self) -> str:
        """The system."""
        return self.portrait.system.name

    @property
    def counts(self) -> dict[PathLocation, float]:
        """The share of the starts, for each kind that occurs."""
        counted = {kind: self.whereabouts.count(kind) / len(self.starts) for kind in PathLocation}
        return {kind: share for kind, share in counted.items() if share}

    @property
    def endings(self) -> list[tuple[float, str]]:
        """The same in words."""
        return [(share, str(kind)) for kind, share in self.counts.items()]

    @cached_property
    def contradictions(self) -> tuple[Contradiction, ...]:
        """Where the paths contradict what is proved; then nobody may rely on either."""
        half = self.portrait.system.check.half_width
        # Along borders that repel, and curved ones, solutions may leave that no path shows: there none is followed too.
        curved = any(cell.region.guards for cell in self.portrait.cells)
        kinds = {part.kind for part in self.portrait.borders}
        draws_all = not curved and kinds <= {BorderKind.CROSSING, BorderKind.SLIDING}
        follow = self._followed_too if draws_all else None
        seen = FollowedStarts(self.starts, self.ends, self.until, half, follow)
        return tuple(contradictions_of_map(self.portrait.stability, seen))

    def _followed_too(self, starts: Floats) -> Floats:
        with progress(f"{len(starts)} starts beside the point") as report:
            return np.array(list(_followed(self.portrait, starts, self.until, report)))

    @property
    def verdict(self) -> Translation:
        """What is proved of the checked point, undecided where the paths contradict it."""
        return Translation.UNDECIDED if self.contradictions else self.portrait.stability.verdict

    @property
    def exit_status(self) -> int:
        """0, and 3 where the paths contradict what is proved."""
        return 3 if self.contradictions else 0

    def facts(self) -> Record:
        """JSON with stable keys; starts run along the first state first."""
        system = self.portrait.system
        ends = [end.tolist() if are_finite(end) else None for end in self.ends]
        return {
            "schema": SCHEMA,
            "scene": system.name,
            "states": list(system.states),
            "verdict": str(self.verdict),
            "grid": self.count,
            "until": self.until,
            "shares": {kind.name.lower(): share for kind, share in self.counts.items()},
            "starts": self.starts.tolist(),
            "ends": ends,
            "whereabouts": [kind.name.lower() for kind in self.whereabouts],
            "parts": self.parts_record(),
            **contradictions_record(self.contradictions),
        }

    def table(self) -> DataTable:
        """One start per line; None where there is no number."""
        first, second = self.portrait.system.states
        lines = []
        for row, kind in zip(np.column_stack([self.starts, self.ends]).tolist(), self.whereabouts, strict=True):
            lines.append([*floats(row), kind.name.lower()])
        return DataTable((first, second, f"{first}_end", f"{second}_end", "whereabouts"), lines)

    def draw(self, ax: Axes) -> None:
        """How near every start has come, with the certified region of V."""
        self._draw_ratios(ax)

    def figure(self) -> Figure:
        """The same with the scale of colors and a legend."""
        figure = new_figure(*SIZE)
        axes = figure.add_subplot()
        image = self._draw_ratios(axes)
        label = "distance from the point: at the end by at the start"
        draw_bar(figure, image, label, ax=axes, shrink=0.8, ticks=RATIOS)
        legend_below(figure, columns=3, fontsize="small")
        head = f"{one_line(self.title)}: {self.count} x {self.count} starts at t = {self.until:g}"
        title_figure(figure, f"{head}; proved: {self.verdict}\n{self.summary()}", TITLE)
        return figure

    def _draw_ratios(self, axes: Axes) -> AxesImage:
        """Every start as a square in the color of its ratio, with the borders of the cells and the region of V."""
        from matplotlib.colors import LogNorm

        ratios = np.where(finite_rows(self.ends), np.clip(self.ratios, NEAREST, FARTHEST), np.nan)
        axes.set_facecolor(LOST)
        image = draw_grid(axes, self.starts, ratios, cmap=TIMES, norm=LogNorm(NEAREST, FARTHEST), zorder=0)
        self.portrait.draw_borders(axes)
        self.portrait.draw_potential(axes)
        axes.plot([0], [0], "o", color=INK, markersize=5, zorder=6)
        half = self.portrait.system.check.half_width
        x, y = self.portrait.system.states
        axes.set(xlim=(-half, half), ylim=(-half, half), xlabel=f"{x} at the start", ylabel=f"{y} at the start")
        axes.set_aspect("equal")
        return image

    @property
    def parts(self) -> list[Part]:
        """How many paths are where at the last time."""
        return [Part(str(kind), self.whereabouts.count(kind)) for kind in self.counts]

    def summary(self) -> str:
        """How many starts there are, where they have come to, and what that contradicts."""
        head = f"{super().summary()}, at t = {self.until:g}"
        return "; ".join([head, *(one.text for one in self.contradictions)])

    def blocks(self) -> Sequence[Block]:
        """The shares, and the verdict beside them."""
        rows = [*self.shares, ("proved", str(self.verdict))]
        lines = [line for one in self.contradictions for line in contradiction_lines(one)]
        what = f"{self.count} x {self.count} starts over the checked square, seen at t = {self.until:g} (sampled)"
        return [*sentences(f"{one_line(self.portrait.system.name)}: {what}"), findings(rows), *sentences(*lines)]

    def __repr__(self) -> str:
        contradicted = [("contradiction", one.text) for one in self.contradictions]
        return short_lines(f"{self.title}: {self.summary()} (sampled)", [*self.shares, *contradicted])


def _whereabouts(end: Floats, ratio: float, half: float) -> PathLocation:
    if not are_finite(end):
        return PathLocation.LOST
    if np.hypot(*end) <= SAME * half:
        return PathLocation.ARRIVED
    if max_norm(end) > (1 + SAME) * half:
        return PathLocation.OUTSIDE
    return PathLocation.NEARER if ratio < 1 - SAME else PathLocation.FARTHER


def build_system_map(system: SwitchedSystem, options: SimulateOptions) -> SystemMap:
    """Follow every start of a grid over the checked square, with progress on a terminal.

    Raises:
        OptionError: for a grid that cannot be used.
        SceneError: for another number of states than two, and for arbitrary switching.
    """
    return mapped(PhasePortrait(system), grid_of(options), options.until or UNTIL)


def mapped(portrait: PhasePortrait, count: int, until: float) -> SystemMap:
    """Where ``count x count`` starts have come to at the last time."""
    half = portrait.system.check.half_width
    line = np.linspace(-half, half, count) if count > 1 else np.array([half])
    starts = np.array([(x, y) for y in line for x in line])
    with progress(f"{count} x {count} starts") as report:
        ends = np.array(list(_followed(portrait, starts, until, report)))
    return SystemMap(portrait, count, until, starts, ends)


def _followed(portrait: PhasePortrait, starts: Floats, until: float, report: ProgressCall) -> Iterator[Floats]:
    """The last place of every path; not a number where it is not followed to the last time.

    At a point where a denominator is zero the field has no value: a path that has come to it ends there early, and is
    known to stay if the point is proved to be stable.
    """
    field = system_field(portrait.system, starts.max(axis=0), centred=True)
    meter = WorkMeter(max(MAX_WORK, WORK_OF_A_START * len(starts)))
    stays = portrait.stability.verdict in {Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE}
    for k, start in enumerate(starts):
        report(k, len(starts))
        try:
            end = simulate(field, tuple(start), until, meter=meter).end
        except (TrajectoryError, RefusalError):
            place, is_cut_short = start, True
        else:
            place, is_cut_short = np.array(end.state, float), end.reason in UNFINISHED
        has_come = norms(place) <= SAME * portrait.system.check.half_width
        yield np.full(2, np.nan) if is_cut_short and not (stays and has_come) else place
