"""A map of starts of a body with an outline: where it ends, followed by explicit steps; sampled."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.bodies.destinations import TOGETHER, PathEnd, destinations
from nonsmooth.analysis.bodies.many_paths import ENDS, BodyEnd, BodyEnds, ManyPaths
from nonsmooth.analysis.contact_rule import CellRule, SmoothRule, rule_of
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.document import Block, Paragraph, findings
from nonsmooth.reports.maps import MapResult, Part, grid_of, parts_record
from nonsmooth.reports.progress import progress
from nonsmooth.reports.result import DataTable, Record
from nonsmooth.reports.simulate_options import SimulateOptions
from nonsmooth.symbolic.contact_set import whole
from nonsmooth.symbolic.number_text import percent_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, one_line

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCHEMA = "nonsmooth-body-map/1"
OPEN_HEADING = "rests: the place does; the rate of theta there is open under this rule, and the steps pick one"
SHOWN = 12  # destinations listed on a terminal


def pose_starts(scene: Scene, count: int, heading: float) -> Floats:
    """``count x count`` poses (m, 3) of one heading, evenly over the checked square, borders included; x runs first."""
    radius = float(scene.check.radius)
    axes = [np.linspace(-radius, radius, count) + float(middle) for middle in scene.check.equilibrium]
    x, y = np.meshgrid(*axes)
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, heading)])


def build_body_map(scene: Scene, options: SimulateOptions) -> BodyMapResult:
    """Follow a body from every start of the grid over the whole array's square, with progress on a terminal.

    Raises:
        OptionError: for a grid or a heading that cannot be used.
        SceneError: for leading-order kinematics, and for a table of loads where loads decide.
        RefusalError: where the motion on some wheels is not determined.
    """
    count, rule = grid_of(options), rule_of(scene)
    if not isinstance(rule, SmoothRule | CellRule):
        raise TypeError(f"required a rule with or without cells, received {rule.name}")
    if options.kinematics is not Kinematics.EXACT:
        expected = "--kinematics exact for a body with an outline"
        raise SceneError(scene.origin, "body", expected, StatedFact(str(options.kinematics)))
    array = whole(scene)
    paths = ManyPaths(array, rule)
    with progress(f"{count} x {count} starts") as report:
        ends = paths.follow(pose_starts(array, count, options.heading), options.until, report)
    return BodyMapResult(array, options, ends, TOGETHER * paths.spacing)


@dataclass(frozen=True, repr=False)
class BodyMapResult(MapResult):
    """Sampled ends of a grid of paths of a body.

    Attributes:
        scene: with all wheels.
        options: what was mapped.
        found: the ends.
        distance: below which bodies rest at one place (length).
    """

    scene: Scene
    options: SimulateOptions
    found: BodyEnds
    distance: float

    @cached_property
    def destinations(self) -> list[PathEnd]:
        """Where the paths end, with shares."""
        return destinations(self.found, self.distance)

    @cached_property
    def destination_of(self) -> list[int]:
        """The place in the list of destinations of every start."""
        numbers = np.zeros(len(self.found.starts), int)
        for k, destination in enumerate(self.destinations):
            numbers[destination.starts] = k
        return [int(k) for k in numbers]

    @property
    def shares(self) -> list[tuple[str, str]]:
        """Share and words of every destination."""
        return [(percent_text(one.share), one.text) for one in self.destinations]

    @property
    def title(self) -> str:
        """The scene and the rule."""
        return f"{one_line(self.scene.name)}, rule {self.scene.contact.rule}"

    def facts(self) -> Record:
        """JSON with stable keys; starts run along x first."""
        found = self.found
        return {
            "schema": SCHEMA,
            "scene": self.scene.name,
            "rule": self.scene.contact.rule,
            "status": "sampled",
            "grid": self.options.grid,
            "theta_0": self.options.heading,
            "until": found.until,
            "destinations": [_record(one) for one in self.destinations],
            "starts": found.starts[:, :2].tolist(),
            "ends": [_end(pose, found, k) for k, pose in enumerate(found.poses.tolist())],
            "destination": self.destination_of,
            "parts": parts_record(self.parts),
        }

    def table(self) -> DataTable:
        """One start per line; the wheels over whose line it tips, where it does."""
        names = ("x", "y", "theta", "t_end", "x_end", "y_end", "theta_end", "reason", "tips_over", "destination")
        found, lines = self.found, []
        for k, (start, pose) in enumerate(zip(found.starts.tolist(), found.poses.tolist(), strict=True)):
            over = "-".join(str(wheel) for wheel in found.over[k].tolist() if wheel)
            reason = ENDS[found.reasons[k]].value
            lines.append([*start, float(found.times[k]), *pose, reason, over, self.destination_of[k] + 1])
        return DataTable(names, lines)

    def draw(self, ax: Axes) -> None:
        """Starts by where they end."""
        from nonsmooth.reports.figures.grids import draw_destinations

        draw_destinations(ax, self)

    def figure(self) -> Figure:
        """Starts by where they end, and the body at each destination."""
        from nonsmooth.reports.figures.grids import destinations_figure

        return destinations_figure(self)

    @property
    def parts(self) -> list[Part]:
        """How many starts end in each way; with rest, at how many places."""
        counts = {reason: int(self.found.by(reason).sum()) for reason in BodyEnd}
        places = sum(one.reason is BodyEnd.REST for one in self.destinations)
        at = {BodyEnd.REST: f" (at {places} {'place' if places == 1 else 'places'})"}
        return [Part(reason.value + at.get(reason, ""), count) for reason, count in counts.items() if count]

    def blocks(self) -> Sequence[Block]:
        """The shares of the destinations."""
        rows, others = self.shares[:SHOWN], self.destinations[SHOWN:]
        if others:
            rows.append((percent_text(sum(one.share for one in others)), f"{len(others)} others"))
        tips = self.found.by(BodyEnd.TIPS)
        if tips.any():
            at_once = float((tips & (self.found.times == 0)).mean())
            rows.append(("of these", f"{percent_text(at_once)} of all starts tip where they start"))
        rows.append(("latest end", f"t = {self.found.times.max():.6g}"))
        (left, low), (right, high) = self.found.starts[:, :2].min(axis=0), self.found.starts[:, :2].max(axis=0)
        head = f"{self.title}: {self.head} until t = {self.found.until:.6g}, sampled"
        square = f"x from {left:.6g} to {right:.6g}, y from {low:.6g} to {high:.6g}"
        starts = f"{square}, theta_0 = {self.options.heading:.6g}"
        open_heading = [Paragraph((OPEN_HEADING,))] if rule_of(self.scene).keeps_rows else []
        return [Paragraph((head,)), Paragraph((starts,)), findings(rows), *open_heading]

    @property
    def head(self) -> str:
        """How many starts."""
        return f"{self.options.grid} x {self.options.grid} starts"


def _record(one: PathEnd) -> dict[str, Any]:
    pose = None if one.pose is None else list(one.pose)
    headings = None if one.headings is None else list(one.headings)
    return {"reason": one.reason.value, "share": one.share, "pose": pose, "headings": headings}


def _end(pose: list[float], found: BodyEnds, k: int) -> dict[str, Any]:
    x, y, theta = pose
    over = [int(wheel) for wheel in found.over[k] if wheel]
    reason = ENDS[found.reasons[k]].value
    return {"x": x, "y": y, "theta": theta, "t": float(found.times[k]), "reason": reason, "tips_over": over or None}
