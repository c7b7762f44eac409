"""The command ``simulate --grid``: where starts all over the square come to rest, as text, JSON or a table."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.trajectories.maps import SettleMap, grid_starts, settle_map
from nonsmooth.reports.basins import GridRun, basins, map_parts, parts_record, parts_text
from nonsmooth.reports.progress import progress
from nonsmooth.reports.terminal import two_columns
from nonsmooth.symbolic.number_text import percent_text
from nonsmooth.symbolic.scene_error import one_line

SCHEMA = "nonsmooth-map/1"
SHOWN = 12  # ends listed on a terminal


def build_map(partition: Partition, run: GridRun) -> SettleMap:
    """Follow every start of the grid, with progress on a terminal."""
    field = array_field(partition, run.kinematics)
    with progress(f"{run.count} x {run.count} starts") as report:
        found = settle_map(field, grid_starts(field, run.count), run.theta, report)
    return found if run.until is None else found.seen_until(run.until)


@dataclass(frozen=True)
class ShownMap:
    """The ends of a grid of paths."""

    partition: Partition
    run: GridRun
    found: SettleMap

    @property
    def title(self) -> str:
        """The scene and the rule."""
        return f"{self.partition.scene.name}, rule {self.partition.rule}"

    @property
    def shares(self) -> list[tuple[str, str]]:
        """Share and words of every kind of end."""
        return [(percent_text(basin.share), basin.text) for basin in basins(self.found)]

    def record(self) -> dict[str, Any]:
        """JSON with stable keys; starts run along x first."""
        return {
            "schema": SCHEMA,
            "scene": self.partition.scene.name,
            "rule": str(self.partition.rule),
            "kinematics": str(self.run.kinematics),
            "grid": self.run.count,
            "theta_0": self.run.theta,
            "until": self.run.until,
            "summary": _summary_record(self.found),
            **self.found.record(),
            "parts": parts_record(map_parts(self.found)),
        }

    def lines(self) -> Iterable[Iterable[Any]]:
        """One start per line; empty where there is no number."""
        yield ("x", "y", "theta", "arrival", "x_end", "y_end", "reason", "place", "unique")
        found = self.found
        columns = zip(found.starts, found.theta, found.arrival, found.points, found.basin, found.unique, strict=True)
        for start, theta, arrival, point, basin, unique in columns:
            numbers = (repr(float(v)) if np.isfinite(v) else "" for v in (*start, theta, arrival, *point))
            reason, place = found.ends[basin]
            yield (*numbers, reason.value, place, "yes" if unique else "no")

    def picture(self, suffix: str) -> bytes:
        """Where each start ends, when, and at which heading."""
        from nonsmooth.reports.figures.settle_map import settle_map_figure

        return settle_map_figure(self.partition, self.run, self.found, suffix)

    def summary(self) -> str:
        """How many starts end in each way."""
        return parts_text(map_parts(self.found))

    def view(self) -> RenderableType:
        """The shares of the ends, the range of headings, the latest arrival and what is not unique."""
        rows, summary, ends = two_columns(), _summary_record(self.found), basins(self.found)
        for basin in ends[:SHOWN]:
            rows.add_row(Text(percent_text(basin.share)), Text(basin.text))
        if others := ends[SHOWN:]:
            rows.add_row(Text(percent_text(sum(basin.share for basin in others))), Text(f"{len(others)} others"))
        theta, latest = summary["theta"], summary["latest_arrival"]
        rows.add_row(Text("theta_inf"), Text("-" if theta is None else f"{theta[0]:.10g} to {theta[1]:.10g}"))
        rows.add_row(Text("latest arrival"), Text("-" if latest is None else f"t = {latest:.10g}"))
        rows.add_row(Text("never arrive"), Text(percent_text(1 - summary["arrived"])))
        rows.add_row(Text("not unique"), Text(percent_text(1 - summary["unique"])))
        return Group(*self._head(), rows)

    def _head(self) -> tuple[Text, Text]:
        """What was mapped, and from which starts."""
        run, name = self.run, one_line(self.partition.scene.name)
        (left, low), (right, high) = self.found.starts.min(axis=0), self.found.starts.max(axis=0)
        until = "" if run.until is None else f", seen at t = {run.until:.6g}"
        what = f"rule {self.partition.rule}, {run.kinematics} kinematics, {run.count} x {run.count} starts{until}"
        square = f"x from {left:.6g} to {right:.6g}, y from {low:.6g} to {high:.6g}, theta_0 = {run.theta:.6g}"
        return Text(f"{name}: {what}"), Text(square)


def _summary_record(found: SettleMap) -> dict[str, Any]:
    return {
        "shares": list(found.shares),
        "theta": _range(found.theta[found.settled]),
        "latest_arrival": float(found.arrival[found.arrived].max()) if found.arrived.any() else None,
        "arrived": float(found.arrived.mean()),
        "unique": float(found.unique.mean()),
    }


def _range(values: Any) -> list[float] | None:
    return [float(values.min()), float(values.max())] if len(values) else None
