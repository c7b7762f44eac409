"""A map of starts of a body with an outline: where it ends, followed by explicit steps; sampled."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.bodies.many_paths import ENDS, TOGETHER, BodyEnd, BodyEnds, ManyPaths, PathEnd, destinations
from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.style import (
    INK,
    LEGEND_LINE,
    POINTS_PER_INCH,
    ROOM,
    TOLD_APART,
    centre_labels,
    draw_checked_point,
    draw_grid,
    grid_extent,
    grid_side,
    legend_below,
    line_entry,
    mark_entry,
    new_figure,
    start_labels,
    title_figure,
)
from nonsmooth.reports.figures.wheels import AXES_SHARE, draw_names, outline_of, placed
from nonsmooth.reports.output.document import Block, findings, sentences
from nonsmooth.reports.output.progress import progress
from nonsmooth.reports.simulations.maps import ArrayMap, Part, grid_of
from nonsmooth.reports.simulations.path_ends import (
    SLOWLY,
    accuracy_text,
    degrees_text,
    range_text,
    sampled_record,
    size_of,
)
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable
from nonsmooth.symbolic.mechanics.body import Body, Disc
from nonsmooth.symbolic.mechanics.contact_set import standing, whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, percent_text, short_text
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, grid_points, places_of, unit_vectors

if TYPE_CHECKING:
    from matplotlib.artist import Artist
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.patches import Patch

SCHEMA = "nonsmooth-body-map/1"
OPEN_HEADING = "rests: the place does; the rate of theta there is open under this rule, and the steps pick one"
PLACE_RESTS = "its place rests"  # of a body that covers all wheels
TURNS_ON = f"{PLACE_RESTS}: the body covers all wheels, and turns there as they turn it; headings are those at t"
ELSEWHERE = "elsewhere"
LINES = 4  # over which bodies tip, that are named

# the picture
SIZE = (12.0, 6.0)  # inches, without the legend
OTHER_PLACES = "#BBBBBB"  # places of rest beyond the palette
TIPS = "#FFFFFF"  # under a hatch
MOVING, AT_POINT = "#666666", "#A6DBC8"  # bodies that still move, and those of them that are at the checked point
HATCH = "xxxx"
PIXEL = 0.9  # of the distance between starts: side of a hatched mark
NEAR = 1.3  # the destinations' view, in sizes of the body around them


def pose_starts(scene: Scene, count: int, heading: float) -> Floats:
    """``count x count`` poses (m, 3) of one heading, evenly over the checked square, borders included; x runs first."""
    radius = float(scene.check.radius)
    places = grid_points(*[np.linspace(-radius, radius, count) + middle for middle in scene.check.place])
    return np.column_stack([places, np.full(len(places), heading)])


def build_body_map(scene: Scene, options: SimulateOptions) -> BodyMapResult:
    """Follow a body from every start of the grid over the whole array's square, with progress on a terminal.

    Raises:
        OptionError: for a grid or a heading that cannot be used.
        SceneError: for leading-order kinematics, and for a table of loads where loads decide.
        RefusalError: where the motion on some wheels is not determined.
    """
    count = grid_of(options)
    if options.kinematics is not Kinematics.EXACT:
        expected = "--kinematics exact for a body with an outline"
        raise SceneError(scene.origin, "body", expected, StatedFact(str(options.kinematics)))
    array = whole(scene)
    followed = array if array.body is not None else _covered(array)
    paths = ManyPaths(followed, rule_of(scene), of_places=array.body is None)
    with progress(f"{count} x {count} starts") as report:
        ends = paths.follow(pose_starts(array, count, options.heading), options.until, report)
    return BodyMapResult(array, options, ends, TOGETHER * paths.spacing)


def _covered(scene: Scene) -> Scene:
    """The array under a disc that covers all wheels as long as its centre is over their hull, so until it tips."""
    places = places_of(scene.wheels)
    reach = Fraction(2 * float(np.hypot(*np.ptp(places, axis=0))))
    zero, one = scene.field.zero, scene.field.one
    return replace(scene, body=Body(Disc(scene.field(reach)), (zero, zero), (one, zero)))


@dataclass(frozen=True, repr=False)
class BodyMapResult(ArrayMap):
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

    @property
    def array(self) -> Scene:
        """With all wheels."""
        return self.scene

    @cached_property
    def home(self) -> Mask:
        """Which starts end upright within the accuracy of the checked point (m,)."""
        upright = self.found.by(BodyEnd.REST) | self.found.by(BodyEnd.TIME)
        return self.are_near(self.found.poses[:, :2]) & upright

    @cached_property
    def destinations(self) -> list[PathEnd]:
        """Where the paths end, with shares."""
        return [part for one in destinations(self.found, self.distance) for part in self._told_apart(one)]

    def _told_apart(self, one: PathEnd) -> Iterator[PathEnd]:
        """Bodies that still move by whether they are at the point, where some are; others as they are."""
        near = self.home[one.starts]
        if one.reason is not BodyEnd.TIME or not near.any():
            yield one
            return
        for where, chosen in ((f"within {accuracy_text(self.scene)} of the point", near), (ELSEWHERE, ~near)):
            if chosen.any():
                yield replace(one, starts=one.starts[chosen], share=float(one.share * chosen.mean()), where=where)

    @cached_property
    def destination_of(self) -> list[int]:
        """The place in the list of destinations of every start."""
        numbers = np.zeros(len(self.found.starts), int)
        for k, destination in enumerate(self.destinations):
            numbers[destination.starts] = k
        return [int(k) for k in numbers]

    @property
    def endings(self) -> list[tuple[float, str]]:
        """Share and words of every destination."""
        return [(one.share, self._in_full(one)) for one in self.destinations]

    def _in_full(self, one: PathEnd) -> str:
        """An end in words, and when it is seen; of a body that turns on its heading by then, and how fast it turns."""
        found, units, said = self.found, self.scene.units, self.in_words(one.text)
        second = units.after_time
        if one.reason is not BodyEnd.TIME:
            said += f", by t = {range_text(found.times[one.starts])}{second}"
            if one.reason is not BodyEnd.REST or self.scene.body is not None:
                return said
        else:
            said += f", at heading {range_text(np.degrees(found.poses[one.starts, 2]))} deg"
        turning = found.turning[one.starts]
        slow = SLOWLY * self.scene.fastest / size_of(self.scene)
        if np.isnan(turning).any() or (np.abs(turning) <= slow).all():
            return said
        return f"{said}, turning at {range_text(np.degrees(turning))} deg{units.per_time}"

    def in_words(self, end: str) -> str:
        """An end; of a body that covers all wheels its place rests, and the body may turn on there."""
        return end if self.scene.body is not None else end.replace(BodyEnd.REST.value, PLACE_RESTS)

    @property
    def title(self) -> str:
        """The scene and the rule."""
        return f"{one_line(self.scene.name)}, rule {self.scene.contact.rule}"

    def facts(self) -> Record:
        """JSON with stable keys; starts run along x first."""
        found = self.found
        return {
            **sampled_record(SCHEMA, self.scene),
            "grid": self.options.grid,
            "theta_0": self.options.heading,
            "until": found.until,
            "destinations": [_record(one) for one in self.destinations],
            "starts": found.starts[:, :2].tolist(),
            "ends": [_end(pose, found, k) for k, pose in enumerate(found.poses.tolist())],
            "destination": self.destination_of,
            **self.home_record(),
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

    @property
    def parts(self) -> list[Part]:
        """How many starts end in each way; with rest, at how many places."""
        counts = {reason: int(self.found.by(reason).sum()) for reason in BodyEnd}
        places = sum(one.reason is BodyEnd.REST for one in self.destinations)
        at = {BodyEnd.REST: f" at {places} {'place' if places == 1 else 'places'}"}
        named = {reason: self.in_words(reason.value) + at.get(reason, "") for reason in BodyEnd}
        return [Part(named[reason], count) for reason, count in counts.items() if count]

    def blocks(self) -> Sequence[Block]:
        """The shares of the destinations."""
        moving = self.found.by(BodyEnd.TIME) | self.found.by(BodyEnd.LOST)
        second = self.scene.units.after_time
        rows = [*self.first_rows(moving=bool(moving.any())), *self._tipping()]
        ended = self.found.times[~moving]
        latest = f"t = {ended.max():.6g}{second}" if len(ended) else f"none until t = {self.found.until:.6g}{second}"
        rows.append((f"latest end{self.massless}", latest))
        head = f"{self.title}: {self.head} until t = {self.found.until:.6g}{second}, sampled"
        open_heading = [OPEN_HEADING] if rule_of(self.scene).keeps_rows else []
        if self.scene.body is None:
            open_heading = [TURNS_ON]
        below = sentences(*open_heading, *self._beside_the_check())
        return [*sentences(head, self.square(self.found.starts)), findings(rows), *below]

    def _tipping(self) -> Iterator[tuple[str, str]]:
        """How many bodies tip where they start, from which distance on and over which lines; how many on their way."""
        found, unit = self.found, self.scene.units.after_length
        tips, total = found.by(BodyEnd.TIPS), len(found.starts)
        at_once = tips & (found.times == 0)
        if at_once.any():
            away = np.hypot(*(found.starts[:, :2] - self.scene.check.place).T)
            nearest = float_text(float(away[at_once].min()), 3)
            told = f"{int(at_once.sum())} of {total} starts; all nearer than {nearest}{unit} to the point stand"
            yield "tip where they start", f"{told}; {self._lines_under(at_once)}"
        later = tips & ~at_once
        if later.any():
            yield "tip on their way", f"{int(later.sum())} of {total} starts; {self._lines_under(later)}"

    def _lines_under(self, tips: Mask) -> str:
        """The lines through wheels that the centres of bodies which tip are beyond, the most frequent first."""
        names = {int(wheel.index): str(wheel.index) for wheel in whole(self.scene).wheels}
        most = Counter(tuple(sorted(row)) for row in self.found.over[tips].tolist() if all(row)).most_common(LINES)
        told = [f"{names[a]} and {names[b]} ({count})" for (a, b), count in most]
        others = int(tips.sum()) - sum(count for _, count in most)
        lines = f"beyond the line through wheels {', '.join(told)}" if told else "with fewer than two wheels under it"
        return f"the centre of mass is {lines}{f', or otherwise ({others})' if told and others else ''}"

    def _beside_the_check(self) -> Iterator[str]:
        """Which part of this square ``check`` speaks of, where other wheels carry the body in the rest of it."""
        try:
            checked = standing(self.scene).check
        except SceneError:  # no body stands at the point
            return
        if checked.wider is not None:
            unit = self.scene.units.after_length
            share = percent_text(float(checked.radius / checked.wider) ** 2)
            within = f"within {short_text(checked.radius)}{unit} of the point, {share} of this square"
            yield f"check speaks of the part {within}: there the same wheels carry the body"

    @property
    def head(self) -> str:
        """How many starts."""
        return f"{self.options.grid} x {self.options.grid} starts"

    def draw(self, ax: Axes) -> None:
        """Starts by color; those that tip are hatched."""
        from matplotlib.colors import to_rgb
        from matplotlib.patches import Rectangle

        points = self.found.starts[:, :2]
        steps = np.ptp(points, axis=0) / (grid_side(points) - 1)
        table = np.array([to_rgb(color) for color in _colors(self.destinations)])
        draw_grid(ax, points, table[self.destination_of], zorder=0)
        fallen = self.found.by(BodyEnd.TIPS) | self.found.by(BodyEnd.LEAVES)
        for x, y in points[fallen] - PIXEL * steps / 2:
            ax.add_patch(Rectangle((x, y), *(PIXEL * steps), fill=False, hatch=HATCH, edgecolor=INK, linewidth=0.0))
        left, right, low, high = grid_extent(points)
        ax.set(xlim=(left, right), ylim=(low, high), aspect="equal", title="where a start ends")

    def figure(self) -> Figure:
        """Starts by where they end, and the body at each destination."""
        entries: list[Artist] = [*self._legend()]
        entries += [mark_entry("+", "checked point", markersize=9), mark_entry(".", "wheel", markersize=4)]
        # a body that covers all wheels has no outline to show, and one that moves on no place for it
        has_bodies = self.scene.body is not None and any(one.pose is not None for one in self.destinations)
        if has_bodies:
            entries += [
                line_entry("body where it rests, arrow: its heading", color=INK, linewidth=2),
                line_entry("the same, at the outermost headings", color=INK, linewidth=1, alpha=0.5),
            ]
        panes = 2 if has_bodies else 1
        figure = new_figure(SIZE[0] * panes / 2, SIZE[1] + LEGEND_LINE * -(-len(entries) // 2))
        figure.set_layout_engine("compressed", h_pad=ROOM / POINTS_PER_INCH)
        starts, *others = figure.subplots(1, panes, squeeze=False)[0]
        self.draw(starts)
        self._draw_contacts(starts)
        draw_checked_point(starts, self.scene)
        starts.set(**start_labels(self.scene.units))
        for ends in others:
            self._draw_bodies(ends)
            self._draw_contacts(ends)
            ends.set(**centre_labels(self.scene.units))
        turned = f"heading {degrees_text(self.options.heading)}"
        head = f"{self.title}: {self.head}, {turned}, sampled{self.massless}"
        title_figure(figure, f"{head}\n{self.summary()}")
        legend_below(figure, entries)
        return figure

    def _draw_bodies(self, axes: Axes) -> None:
        """The outline at each destination: at the middle heading, and faintly at the outermost ones."""
        outline = outline_of(self.scene)
        axes.set(aspect="equal", title="the body at its destinations")
        resting = [(one, color) for one, color in zip(self.destinations, _colors(self.destinations), strict=True)]
        resting = [(one, color) for one, color in resting if one.pose is not None][: len(TOLD_APART)]
        if outline is None or not resting:
            return
        reach = float(np.hypot(*outline.T).max())
        for one, color in resting:
            x, y, theta = one.pose or (0.0, 0.0, 0.0)
            for heading in one.headings or ():
                axes.fill(
                    *placed(outline, np.array([x, y, heading])).T, fill=False, edgecolor=color, alpha=0.5, zorder=2
                )
            axes.fill(*placed(outline, np.array([x, y, theta])).T, fill=False, edgecolor=color, linewidth=2.0, zorder=3)
            nose = np.array([x, y]) + 0.5 * reach * unit_vectors(theta)
            arrow = axes.annotate("", xy=tuple(nose), xytext=(x, y), arrowprops={"arrowstyle": "-|>", "color": color})
            arrow.set_in_layout(False)
        centres = np.array([one.pose[:2] for one, _ in resting if one.pose is not None])
        low, high = centres.min(axis=0) - NEAR * reach, centres.max(axis=0) + NEAR * reach
        axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]))

    def _draw_contacts(self, axes: Axes) -> None:
        """Wheels as dots with their names, where there is room; the view stays."""
        limits = {"xlim": axes.get_xlim(), "ylim": axes.get_ylim()}
        places = places_of(self.scene.wheels)
        axes.plot(*places.T, linestyle="none", marker=".", markersize=3, color=INK, zorder=5)
        axes.set(**limits)
        draw_names(axes, self.scene, AXES_SHARE * SIZE[0] / 2 * POINTS_PER_INCH)
        for name in axes.texts:  # those of wheels at the border would lie on the numbers of the axes
            name.set_clip_path(axes.patch)

    def _legend(self) -> list[Patch]:
        """An entry for each color."""
        from matplotlib.patches import Patch

        entries, others = [], list[PathEnd]()
        found = self.destinations
        for k, (one, color) in enumerate(zip(found, _colors(found), strict=True)):
            if one.reason is BodyEnd.REST and k >= len(TOLD_APART):
                others.append(one)
                continue
            hatch = HATCH if color == TIPS else None
            label = f"{100 * one.share:.3g} %: {self.in_words(one.text)}"
            entries.append(Patch(facecolor=color, edgecolor=INK, hatch=hatch, label=label))
        if others:
            share = 100 * sum(one.share for one in others)
            entries.append(Patch(facecolor=OTHER_PLACES, label=f"{share:.3g} %: {len(others)} other places of rest"))
        return entries


def _record(one: PathEnd) -> Record:
    pose = None if one.pose is None else list(one.pose)
    headings = None if one.headings is None else list(one.headings)
    return {"reason": one.reason.value, "share": one.share, "pose": pose, "headings": headings, "where": one.where}


def _end(pose: list[float], found: BodyEnds, k: int) -> Record:
    x, y, theta = pose
    over = [int(wheel) for wheel in found.over[k] if wheel]
    reason, turning = ENDS[found.reasons[k]].value, float(found.turning[k])
    when = {"t": float(found.times[k]), "turning": turning if np.isfinite(turning) else None}
    return {"x": x, "y": y, "theta": theta, **when, "reason": reason, "tips_over": over or None}


# ---- the picture -----------------------------------------------------------------------------------


def _colors(found: list[PathEnd]) -> list[str]:
    """One for each destination."""
    colors = []
    for k, one in enumerate(found):
        if one.reason is BodyEnd.REST:
            colors.append(TOLD_APART[k] if k < len(TOLD_APART) else OTHER_PLACES)
        else:
            moving = AT_POINT if one.where and one.where != ELSEWHERE else MOVING
            colors.append(TIPS if one.reason in {BodyEnd.TIPS, BodyEnd.LEAVES} else moving)
    return colors
