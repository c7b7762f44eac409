"""Which headings return, and from how far: bodies of N headings from one place, followed to their ends; sampled.

A heading h *returns* from an arc of starts where all bodies of three neighbouring starts or more end upright within
:data:`ALIKE` of h (full turns aside), and h lies in that arc.  All paths are followed at once by explicit steps
(:mod:`nonsmooth.analysis.bodies.many_paths`); the ends of an arc are right to the angle between two starts.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.bodies.many_paths import ENDS, BodyEnd, BodyEnds, ManyPaths, OnStep, turned_heading
from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.style import figure_with_legend, title_axes
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.progress import progress
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.simulations.path_ends import distance_from_point, sampled_record, shown_angle
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, place_text
from nonsmooth.symbolic.numbers.plane import XY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCHEMA = "nonsmooth-headings/1"
FEWEST, MOST = 8, 3_600
ALIKE = math.radians(1.0)
SHOWN = 12  # arcs listed on a terminal
NO_ANGLE = 1e-9  # an angle that is rounding
NEIGHBOURS = 3  # starts of an arc at least


@dataclass(frozen=True)
class HeadingArc:
    """Neighbouring starts whose bodies end alike.

    Attributes:
        first, last: headings of the outermost starts (radian), ``last`` at least ``first``.
        starts: how many there are.
        reason: how their bodies end.
        heading: the middle one of their headings at the end (radian), nearest to the arc; None where they fall.
        returns: whether that heading returns from the arc.
        farthest: the largest distance of their ends from the checked point; None where they fall.
    """

    first: float
    last: float
    starts: int
    reason: BodyEnd
    heading: float | None
    returns: bool
    farthest: float | None


@dataclass(frozen=True, repr=False)
class HeadingsResult(Result):
    """Ends of bodies of many headings from one place.

    Attributes:
        scene: with all wheels.
        place: of all starts.
        found: the ends, by ascending heading in a full turn.
    """

    scene: Scene
    place: XY
    found: BodyEnds

    @cached_property
    def arcs(self) -> tuple[HeadingArc, ...]:
        """Neighbouring starts that end alike, around the full turn."""
        count = len(self.found.starts)
        apart = [k for k in range(count) if not self._alike(k - 1, k)]
        if not apart:
            return (self._arc(list(range(count))),)
        groups = [list(range(a, b)) for a, b in zip(apart, [*apart[1:], apart[0] + count], strict=True)]
        return tuple(map(self._arc, groups))

    def _alike(self, one: int, other: int) -> bool:
        """Whether two starts end in one way, and upright ones at one heading."""
        reasons = self.found.reasons
        if reasons[one] != reasons[other]:
            return False
        turn = turned_heading(self.found.poses[other, 2] - self.found.poses[one, 2])
        return not self._stands(one) or bool(abs(turn) <= ALIKE)

    def _stands(self, start: int) -> bool:
        return ENDS[self.found.reasons[start]] in {BodyEnd.REST, BodyEnd.TIME}

    def _arc(self, group: list[int]) -> HeadingArc:
        count = len(self.found.starts)
        numbers = np.array(group) % count
        turns = 2 * math.pi * (np.array(group) // count)
        begins = self.found.starts[numbers, 2] + turns
        first, last, reason = float(begins[0]), float(begins[-1]), ENDS[self.found.reasons[numbers[0]]]
        if not self._stands(int(numbers[0])):
            return HeadingArc(first, last, len(group), reason, None, False, None)
        ends = self.found.poses[numbers]
        middle = (first + last) / 2
        headings = middle + turned_heading(ends[:, 2] - middle)
        heading = float(np.median(headings))
        within = bool(np.abs(turned_heading(headings - heading)).max() <= ALIKE) and first <= heading <= last
        farthest = max(distance_from_point(self.scene, end) for end in ends)
        return HeadingArc(first, last, len(group), reason, heading, within and len(group) >= NEIGHBOURS, farthest)

    @property
    def returning(self) -> tuple[HeadingArc, ...]:
        """Those whose heading returns."""
        return tuple(arc for arc in self.arcs if arc.returns)

    def facts(self) -> Record:
        """JSON with stable keys, angles in radian."""
        arcs = [{**vars(arc), "reason": arc.reason.value} for arc in self.arcs]
        head = sampled_record(SCHEMA, self.scene)
        ends = self.found.poses.tolist()
        reasons = [ENDS[k].value for k in self.found.reasons]
        rows = [
            {"theta_0": start[2], "x": end[0], "y": end[1], "theta": end[2], "reason": reason}
            for start, end, reason in zip(self.found.starts.tolist(), ends, reasons, strict=True)
        ]
        return head | {"place": list(self.place), "until": self.found.until, "arcs": arcs, "rows": rows}

    def table(self) -> DataTable:
        """One line for each start."""
        return DataTable.of_rows(self.facts()["rows"])

    def summary(self) -> str:
        """The headings that return."""
        if not self.returning:
            return "no heading returns"
        units = self.scene.units
        return "; ".join(
            f"{_angle_text(units, arc.heading or 0.0)} returns from {_arc_text(units, arc)}" for arc in self.returning
        )

    def blocks(self) -> Sequence[Block]:
        """The headings that return, and where all arcs end."""
        units = self.scene.units
        length, time = units.after_length, units.after_time
        place = f"{place_text(self.place, 6)}{length}"
        step = _angle_text(units, 2 * math.pi / len(self.found.starts))
        what = f"bodies from {place}, a heading every {step}, until t = {self.found.until:.4g}{time}, sampled"
        head = f"{one_line(self.scene.name)}, rule {self.scene.contact.rule}: {what}, without inertia"
        rows = []
        shown = sorted(self.arcs, key=lambda arc: (not arc.returns, -arc.starts))[:SHOWN]
        for arc in sorted(shown, key=lambda arc: arc.first):
            ends = "-" if arc.heading is None else _angle_text(units, arc.heading)
            far = "-" if arc.farthest is None else f"{float_text(arc.farthest, 3)}{length}"
            rows.append(
                [_arc_text(units, arc), str(arc.starts), arc.reason.value, ends, far, "yes" if arc.returns else "no"]
            )
        names = ("started at", "starts", "how it ends", "heading", "from the point", "returns")
        found = table(names, rows, (1.2, 0.5, 1.2, 0.8, 0.9, 0.5))
        left = len(self.arcs) - len(shown)
        others = sentences(f"{left} other arcs, none of which returns, are in --json") if left else []
        return [*sentences(head, self.summary()), found, *others]

    def draw(self, ax: Axes) -> None:
        """The heading at the end over that at the start, in the scene's unit; a dashed line where it would be kept."""
        from matplotlib.ticker import MaxNLocator

        units = self.scene.units
        of_radian = shown_angle(units, 1.0)
        begins = of_radian * self.found.starts[:, 2]
        stands = np.array([self._stands(k) for k in range(len(begins))])
        ends = begins + of_radian * turned_heading(self.found.poses[:, 2] - self.found.starts[:, 2])
        ax.plot(begins[stands], ends[stands], "o", color="#0072B2", markersize=3, label="upright")
        if not stands.all():
            ax.plot(begins[~stands], begins[~stands], "x", color="#D55E00", markersize=4, label="falls")
        ax.plot(begins, begins, "--", color="0.6", linewidth=1, label="kept")
        ax.set(xlabel=f"heading at the start [{units.angle}]", ylabel=f"heading at the end [{units.angle}]")
        if units.angle == "deg":
            for axis in (ax.xaxis, ax.yaxis):
                axis.set_major_locator(MaxNLocator(steps=[1, 1.5, 3, 4.5, 9, 10]))
        title_axes(ax, f"{one_line(self.scene.name)}: which headings return")

    def figure(self) -> Figure:
        """The same with a legend below."""
        return figure_with_legend(self.draw)

    def __repr__(self) -> str:
        said = [(_arc_text(self.scene.units, arc), arc.reason.value) for arc in self.arcs]
        return short_lines(f"headings of {self.scene.name}: {self.summary()}", said)


def _arc_text(units: Units, arc: HeadingArc) -> str:
    first, last = _angle_text(units, arc.first), _angle_text(units, arc.last)
    return first if arc.starts == 1 else f"{first.removesuffix(f' {units.angle}')} to {last}"


def _angle_text(units: Units, radians: float) -> str:
    """A heading in the unit of the scene: ``7.49 deg``, ``0.131 rad``."""
    shown = shown_angle(units, radians)
    return f"{float_text(shown if abs(shown) > NO_ANGLE else 0.0, 3)} {units.angle}"


def follow_headings(scene: Scene, options: SimulateOptions) -> HeadingsResult:
    """Follow a body from N headings, at the place of ``start`` or the checked point.

    Raises:
        OptionError: for a number of headings that cannot be used, and a start that is no place.
        SceneError: for a scene without an outline, whose motion does not depend on the heading, and for a table of
            loads where loads decide.
        RefusalError: where the motion on some wheels is not determined.
    """
    count = options.headings or 0
    if not FEWEST <= count <= MOST:
        raise OptionError(f"--headings: required {FEWEST} to {MOST} headings in a full turn, received {count}")
    require_outline(scene)
    x, y = scene.check.place if options.start is None else options.pose[:2]
    with progress(f"{count} headings") as report:
        return from_headings(scene, (x, y), count, options.until, report)


def require_outline(scene: Scene) -> None:
    """Refuse a scene whose motion does not depend on the heading.

    Raises:
        SceneError: for one without an outline.
    """
    if scene.body is None:
        expected = "a body with a shape: one that covers all wheels moves alike at every heading, so none returns"
        raise SceneError(scene.origin, "body", expected, StatedFact("none"))


def from_headings(
    scene: Scene,
    place: XY,
    count: int,
    until: float | None = None,
    report: OnStep | None = None,
) -> HeadingsResult:
    """Follow a body with an outline from so many headings in a full turn, the checked one among them.

    Args:
        scene: the array.
        place: of all starts.
        count: of headings.
        until: the last time; a few crossings of the array unless given.
        report: told from time to time how many of all paths have ended, and up to when all are followed.

    Raises:
        SceneError: for a table of loads where loads decide.
        RefusalError: where the motion on some wheels is not determined.
    """
    headings = 2 * math.pi * (np.arange(count) - count // 2) / count
    starts = np.column_stack([np.full((count, 2), place), headings])
    array = whole(scene)
    return HeadingsResult(array, place, ManyPaths(array, rule_of(scene)).follow(starts, until, report))
