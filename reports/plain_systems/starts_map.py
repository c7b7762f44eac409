"""The command ``simulate --grid`` for a plain system in two states: where starts all over the square have come to.

Every start is followed by events up to one time, so the map is sampled and proves nothing. Where stability is proved
with a certified level set of V, the paths from inside it are compared with the proof: V may not have grown.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.fields.cell_values import potential_values
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.own_paths import ContradictionError
from nonsmooth.reports.basins import Part, parts_record, parts_text
from nonsmooth.reports.phase_portrait import PhasePortrait
from nonsmooth.reports.progress import ProgressCall, progress
from nonsmooth.reports.terminal import two_columns
from nonsmooth.symbolic.number_text import percent_text, place_text
from nonsmooth.symbolic.scene_error import one_line

Floats: TypeAlias = NDArray[np.float64]

SCHEMA = "nonsmooth-system-map/1"
ARRIVED = 1e-9  # of the half-width: a path that is this near has arrived, as far as the integrator can tell
GROWN = 1e-6  # relative: V grew by more than the integrator errs


class Whereabouts(StrEnum):
    """Where a path is at the last time."""

    ARRIVED = "at the checked point"
    NEARER = "nearer than at the start"
    FARTHER = "not nearer, within the square"
    OUTSIDE = "outside the square"
    LOST = "not followed to the end"


@dataclass(frozen=True)
class SystemMap:
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
        first, last = (np.hypot(*places.T) for places in (self.starts, self.ends))
        return np.divide(last, first, out=np.where(last > 0, np.inf, 0.0), where=first > 0)

    @cached_property
    def whereabouts(self) -> list[Whereabouts]:
        """Of every path."""
        half = float(self.portrait.system.check.radius)
        return [_whereabouts(end, ratio, half) for end, ratio in zip(self.ends, self.ratios, strict=True)]

    @property
    def title(self) -> str:
        """The system."""
        return self.portrait.system.name

    @property
    def counts(self) -> dict[Whereabouts, float]:
        """The share of the starts, for each kind that occurs."""
        counted = {kind: self.whereabouts.count(kind) / len(self.starts) for kind in Whereabouts}
        return {kind: share for kind, share in counted.items() if share}

    @property
    def shares(self) -> list[tuple[str, str]]:
        """The same in words."""
        return [(percent_text(share), str(kind)) for kind, share in self.counts.items()]

    def refuse_contradiction(self) -> None:
        """Compare paths from the certified level set with the proof.

        Raises:
            ContradictionError: where V has grown along one of them.
        """
        result = self.portrait.stability
        if result.proving is None or result.region is None or not result.region.falls:
            return
        before, after = (potential_values(result.proving.cells, places) for places in (self.starts, self.ends))
        inside = before < float(result.region.level)
        grown = inside & (~np.isfinite(after) | (after > before * (1 + GROWN) + GROWN * ARRIVED))
        grown &= np.isfinite(self.ends).all(axis=1)
        for k in np.flatnonzero(grown)[:1]:
            start, end = place_text(self.starts[k]), place_text(self.ends[k])
            raise ContradictionError(
                f"{one_line(self.portrait.system.name)}: V < {result.region.level} is certified to fall, but the path "
                f"from {start} is at {end} at t = {self.until:g}, where V is not smaller: a fault of this program"
            )

    def record(self) -> dict[str, Any]:
        """JSON with stable keys; starts run along the first state first."""
        system = self.portrait.system
        ends = [[float(v) for v in end] if np.isfinite(end).all() else None for end in self.ends]
        return {
            "schema": SCHEMA,
            "scene": system.name,
            "states": list(system.states),
            "verdict": str(self.portrait.stability.verdict),
            "grid": self.count,
            "until": self.until,
            "shares": {kind.name.lower(): share for kind, share in self.counts.items()},
            "starts": self.starts.tolist(),
            "ends": ends,
            "whereabouts": [kind.name.lower() for kind in self.whereabouts],
            "parts": parts_record(self.parts),
        }

    def lines(self) -> Iterable[Iterable[Any]]:
        """One start per line; empty where there is no number."""
        first, second = self.portrait.system.states
        yield (first, second, f"{first}_end", f"{second}_end", "whereabouts")
        for start, end, kind in zip(self.starts, self.ends, self.whereabouts, strict=True):
            yield (*(repr(float(v)) if np.isfinite(v) else "" for v in (*start, *end)), kind.name.lower())

    def picture(self, suffix: str) -> bytes:
        """How near every start has come, with the certified region of V."""
        from nonsmooth.reports.figures.system_map import system_map_figure

        return system_map_figure(self, suffix)

    @property
    def parts(self) -> list[Part]:
        """How many paths are where at the last time."""
        return [Part(str(kind), self.whereabouts.count(kind)) for kind in self.counts]

    def summary(self) -> str:
        """How many starts there are, and where they have come to."""
        return f"{parts_text(self.parts)}, at t = {self.until:g}"

    def view(self) -> RenderableType:
        """The shares, and the verdict beside them."""
        system, rows = self.portrait.system, two_columns()
        for share, kind in self.shares:
            rows.add_row(Text(share), Text(kind))
        rows.add_row(Text("proved"), Text(str(self.portrait.stability.verdict)))
        what = f"{self.count} x {self.count} starts over the checked square, seen at t = {self.until:g} (sampled)"
        return Group(Text(f"{one_line(system.name)}: {what}"), rows)


def _whereabouts(end: Floats, ratio: float, half: float) -> Whereabouts:
    if not np.isfinite(end).all():
        return Whereabouts.LOST
    if np.hypot(*end) <= ARRIVED * half:
        return Whereabouts.ARRIVED
    if np.abs(end).max() > half:
        return Whereabouts.OUTSIDE
    return Whereabouts.NEARER if ratio < 1 else Whereabouts.FARTHER


def build_system_map(portrait: PhasePortrait, count: int, until: float) -> SystemMap:
    """Follow every start of the grid, with progress on a terminal.

    Args:
        portrait: of the system.
        count: starts in a row and in a column.
        until: last time.

    Raises:
        ContradictionError: where a path from the certified region contradicts the proof.
    """
    half = float(portrait.system.check.radius)
    line = np.linspace(-half, half, count) if count > 1 else np.array([half])
    starts = np.array([(x, y) for y in line for x in line])
    with progress(f"{count} x {count} starts") as report:
        ends = np.array(list(_followed(portrait, starts, until, report)))
    found = SystemMap(portrait, count, until, starts, ends)
    found.refuse_contradiction()
    return found


def _followed(portrait: PhasePortrait, starts: Floats, until: float, report: ProgressCall) -> Iterator[Floats]:
    """The last place of every path."""
    field = system_field(portrait.system, starts.max(axis=0), centred=True)
    for k, start in enumerate(starts):
        report(k, len(starts))
        try:
            yield np.array([float(v) for v in simulate(field, tuple(start), until).end.state])
        except TrajectoryError:
            yield np.full(2, np.nan)
