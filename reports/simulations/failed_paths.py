"""Paths of a body from starts with wheels failed, stopped or lifted, beside those of the whole table.

A stopped wheel stands still and keeps its friction; a lifted one touches nothing.  Each path is followed as
``simulate`` follows it, so what is said here is sampled, from these starts, without inertia.  A body is home whose
path ends, or still is when the time is over, within the scene's accuracy of the checked point.  Where none of the
failed wheels ever carries the body on its path over the whole table, that is its path without them too.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.bodies.mass_study import rule_path
from nonsmooth.analysis.bodies.path import BodyPath
from nonsmooth.analysis.bodies.supports import StartTipsError
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.minimizers.float_loads import hull_sides
from nonsmooth.analysis.trajectories.result import (
    UNFINISHED,
    EndMotion,
    EndReason,
    EventKind,
    Trajectory,
    TrajectoryError,
)
from nonsmooth.proofs.answers.failures import NO_TABLE, FailureKind, in_square, stopped, without
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.simulations.path_ends import (
    ArrayPathEnd,
    accuracy_text,
    in_unit,
    is_near,
    pose_text,
    sampled_record,
)
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.mechanics.body import support_polygon, widest_square
from nonsmooth.symbolic.mechanics.contact_set import NoLoadsError, accuracy_at_point, whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line
from nonsmooth.symbolic.messages.under_way import part_of
from nonsmooth.symbolic.numbers.number_text import float_text, numbers_text, place_text
from nonsmooth.symbolic.numbers.plane import Pose, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, float_points, spread

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SCHEMA = "nonsmooth-failed-paths/1"
ANY = "any"
ENOUGH = 20.0  # times in which the fastest rim runs the half-width of the square: paths from a grid of starts
INSIDE = 1e-9  # of the array's width: a centre of mass as near to the edge of its support does not stand, as in a check
COLORS = ("C0", "C1", "C2", "C3", "C4", "C5", "C6", "C8")  # of the worst failures, which are named; C7 is gray
COLUMNS = 4  # of the legend
OTHERS, OTHER_COLOR = "other failures", "0.45"
BRANCHES = "not unique"
RANKED = (
    "by starts that no longer come home, then by those that tip, then by how far an end moves; "
    "check --fail 1 ranks by what is proved"
)
WORDS: dict[StrEnum, str] = {  # each failure is one line
    EndMotion.AT_REST: "rests",
    EndMotion.CREEPS: "creeps",
    EndMotion.MOVING: "moves on",
    EndReason.REST: "rests",
    EndReason.TURNING: "turns",
    EndReason.CIRCLES: "circles",
    EndReason.APPROACH: "comes near",
    EndReason.OUTSIDE: "leaves",
    EndReason.TIPS: "tips",
    **dict.fromkeys(UNFINISHED, "broken off"),
}


@dataclass(frozen=True)
class Failed:
    """Wheels that fail together, and how; none for the whole table."""

    wheels: tuple[int, ...] = ()
    kind: FailureKind | None = None

    def __str__(self) -> str:
        return self.short if self.kind is None else f"wheel{'s' * (len(self.wheels) > 1)} {self.short}"

    @property
    def short(self) -> str:
        """``5, 7 lifted``: for a table of wheels."""
        return "none" if self.kind is None else f"{numbers_text(self.wheels)} {self.kind}"


@dataclass(frozen=True)
class FailedPath:
    """One path.

    Attributes:
        failed: what failed.
        start: the pose it starts from.
        path: it; None where it cannot be followed.
        why_not: why.
        tips: the time at which the centre of mass leaves the support of the wheels that are left, where the rule's
            own path does not say so.
        near: whether it ends within the accuracy of the checked point; false where it is not followed to its end.
    """

    failed: Failed
    start: Pose
    path: Trajectory | None
    why_not: str = ""
    tips: float | None = None
    near: bool = False

    @property
    def end(self) -> Pose | None:
        """The last pose; None without a path to its end, and of a body that tips."""
        if self.path is None or self.does_tip or self.is_broken_off:
            return None
        return pose_in_floats(self.path.end.state)

    @property
    def is_open(self) -> bool:
        """Whether what becomes of the body is not known.

        So it is without a path, of one that is broken off, and of one that other solutions leave for other places: the
        body may go with them.
        """
        return not self.does_tip and (self.path is None or self.is_broken_off or self.branches)

    @property
    def is_broken_off(self) -> bool:
        """Whether it is followed only as far as somewhere on the way."""
        return self.path is not None and self.path.end.reason in UNFINISHED

    @property
    def branches(self) -> bool:
        """Whether other solutions leave this path, and not only by another rate of theta at rest."""
        events = self.path.events if self.path is not None else ()
        return any(event.kind is EventKind.NONUNIQUE and not event.drift_only for event in events)

    @property
    def home(self) -> bool:
        """Whether the body comes within the accuracy of the checked point, by this solution and every other one."""
        return self.near and not self.is_open

    @property
    def does_tip(self) -> bool:
        """Whether the body falls."""
        return self.tips is not None or (self.path is not None and self.path.end.reason is EndReason.TIPS)

    @property
    def how(self) -> str:
        """How it ends, in words."""
        if self.path is None:
            return f"not followed: {self.why_not}"
        how = str(EndReason.TIPS) if self.does_tip else self.path.end.why
        return f"{how}; other solutions branch off" if self.branches else how


@dataclass(frozen=True, repr=False)
class FailedPathsResult(Result):
    """Paths with wheels failed.

    Attributes:
        scene: the whole table.
        until: last time.
        whole: the paths of the whole table, one for each start.
        paths: those with wheels failed, in the order of failures, and of starts for each.
    """

    scene: Scene
    until: float
    whole: tuple[FailedPath, ...]
    paths: tuple[FailedPath, ...]

    @property
    def failures(self) -> tuple[Failed, ...]:
        """What fails, in order."""
        return tuple(dict.fromkeys(path.failed for path in self.paths))

    @property
    def came(self) -> int:
        """From how many starts bodies come home with all wheels."""
        return sum(path.home for path in self.whole)

    def pairs(self, failed: Failed) -> list[tuple[FailedPath, FailedPath]]:
        """The path of the whole table and that of the failed one, start by start."""
        return list(zip(self.whole, (path for path in self.paths if path.failed == failed), strict=True))

    def lost(self, failed: Failed) -> int:
        """How many starts that came home no longer do; those of which that is not known are not counted."""
        return sum(before.home and not after.home and not after.is_open for before, after in self.pairs(failed))

    def unknown(self, failed: Failed) -> int:
        """Of how many starts it is not known where the body ends."""
        return sum(after.is_open for _, after in self.pairs(failed))

    def tipped(self, failed: Failed) -> int:
        """From how many starts the body tips."""
        return sum(after.does_tip for _, after in self.pairs(failed))

    def farthest(self, failed: Failed) -> float | None:
        """How far the end moves at most; None where it is known from no start."""
        return max((move[0] for move in (moved(*pair) for pair in self.pairs(failed)) if move), default=None)

    def facts(self) -> Record:
        """The record of ``--json``."""
        rows = [_record(path, None) for path in self.whole]
        for failed in self.failures:
            rows += [_record(after, moved(before, after)) for before, after in self.pairs(failed)]
        summary = [
            {
                "wheels": list(failed.wheels),
                "kind": failed.kind,
                "moved": self.farthest(failed),
                "no_longer_home": self.lost(failed),
                "not_known": self.unknown(failed),
                "tips": self.tipped(failed),
            }
            for failed in self.failures
        ]
        numbers = {"until": self.until, "accuracy": float(accuracy_at_point(self.scene)), "home": self.came}
        return sampled_record(SCHEMA, self.scene) | numbers | {"failures": summary, "rows": rows}

    def table(self) -> DataTable:
        """One line for each path."""
        names = ("failed", "kind", "x0", "y0", "theta0", "x", "y", "theta", "moved", "turned", "home", "end")
        lines = []
        for path in self.facts()["rows"]:
            wheels = " ".join(map(str, path["wheels"]))
            end = path["end"] or (None, None, None)
            tail = (path["moved"], path["turned"], path["home"], path["reason"])
            lines.append((wheels, path["kind"] or "", *path["start"], *end, *tail))
        return DataTable(names, lines)

    def blocks(self) -> Sequence[Block]:
        """Of one start each end; of many the farthest move, and how many no longer come home."""
        until = f"until t = {self.until:.4g}{self.scene.units.after_time}"
        accuracy = f"home: within {accuracy_text(self.scene)} of the checked point"
        said = f"sampled, without inertia, {until}; {accuracy}"
        if len(self.whole) == 1:
            followed = (self._followed(path) for path in (*self.whole, *self.paths))
            reasons = sentences(*(line for line in followed if line))
            return [*sentences(said), self._of_one_start(), *reasons, *self._worst()]
        names = (
            "failed",
            in_unit("end moves at most", self.scene.units.length),
            "no longer home",
            "tip",
            "not known",
        )
        lines = []
        for failed in self.failures:
            counts = (self.lost(failed), self.tipped(failed), self.unknown(failed))
            lines.append([str(failed), _text(self.farthest(failed)), *map(str, counts)])
        home = f"{self.came} of {len(self.whole)} starts come home with all wheels"
        if any(path.is_open for path in self.whole):
            home += f"; of {sum(path.is_open for path in self.whole)} that is not known"
        return [*sentences(said, home), table(names, lines, (1.5, 1.0, 1.0, 0.5, 0.7)), *self._worst()]

    def _of_one_start(self) -> Block:
        (before,), unit = self.whole, self.scene.units.length
        lines = []
        for path in (before, *self.paths):
            move = moved(before, path) if path.failed.wheels else None
            place = "-" if path.end is None else place_text(path.end[:2], 4)
            heading = "-" if path.end is None else float_text(math.degrees(path.end[2]), 4)
            home = "-" if path.is_open else "yes" if path.home else "no"
            lines.append([path.failed.short, place, heading, _text(move and move[0]), home, self._how(path)])
        names = ("wheel failed", in_unit("ends at", unit), "heading (deg)", in_unit("moved", unit), "home", "then")
        return table(names, lines, (1.2, 1.5, 1.0, 0.9, 0.5, 0.9))

    def _followed(self, path: FailedPath) -> str:
        """As far as where a path is followed, and why not farther; empty where it is to its end."""
        if path.does_tip or not (path.path is None or path.is_broken_off):
            return ""
        name = f"{path.failed}" if path.failed.wheels else "all wheels"
        if path.path is None:
            return f"{name}: {path.how}"
        end, units = path.path.end, self.scene.units
        until = f"t = {float(end.t):.4g}{units.after_time}"
        return f"{name}: followed until {until}, {pose_text(units, end.state, 4)}: {path.how}"

    def _how(self, path: FailedPath) -> str:
        """In a word how a path ends, where its time is over with which motion."""
        if path.path is None and not path.does_tip:
            return "not followed"
        if path.branches:
            return BRANCHES
        reason = EndReason.TIPS if path.does_tip or path.path is None else path.path.end.reason
        if reason is EndReason.TIME and path.path is not None:
            return WORDS[ArrayPathEnd(self.scene, path.path).ending.motion]
        return WORDS.get(reason, str(reason))

    def _worst_first(self) -> list[Failed]:
        """The failures by how many bodies no longer come home, then by how many tip, then by how far ends move."""

        def rank(failed: Failed) -> tuple[int, int, float]:
            return self.lost(failed), self.tipped(failed), self.farthest(failed) or 0.0

        return sorted(self.failures, key=rank, reverse=True)

    def _worst(self) -> list[Block]:
        """The first of :meth:`_worst_first`, and what moves an end farthest where that is another one."""
        if not self.failures:
            return []
        is_one = len(self.whole) == 1
        farthest = max(self.failures, key=lambda failed: self.farthest(failed) or 0.0)
        if not self.came:  # which is the worst for bodies that end elsewhere anyhow is no question
            doubtful = sum(path.is_open for path in self.whole)
            none = f"none of {len(self.whole)} comes home{f'; of {doubtful} that is not known' if doubtful else ''}"
            if is_one:
                none = "it is not known whether the body comes home" if doubtful else "the body does not come home"
            moves = "" if self.farthest(farthest) is None else f"; {farthest} moves the end farthest"
            return sentences(f"with all wheels {none}{moves}")
        worst = self._worst_first()[0]
        lost = self.lost(worst)
        left = sum(map(self.unknown, self.failures))
        if is_one:
            said = "the body no longer comes home" if lost else "the body still comes home"
        else:
            every = "all that came home and are known" if left else "all that came home"
            said = f"{lost} of {self.came} no longer come home" if lost else f"{every} still do"
        unknown = f"of {left} of {len(self.paths)} paths it is not known where bodies end"
        open_ones = sentences(f"{unknown}: not followed so far, or other solutions branch off")
        if farthest != worst:
            unit = self.scene.units.after_length
            said += f"; {farthest} moves an end farthest, by {_text(self.farthest(farthest))}{unit}"
        return [*sentences(f"the worst: {worst}: {said} ({RANKED})"), *(open_ones if left else [])]

    def summary(self) -> str:
        """How many paths."""
        return f"{len(self.paths)} paths with wheels failed"

    def draw(self, ax: Axes) -> None:
        """All paths near the checked square: full with wheels stopped, dashed with wheels lifted, wide and gray of all.

        The worst failures have colors and are named; of the others no line is told from the next.
        """
        from nonsmooth.reports.figures.style import INK, title_axes
        from nonsmooth.reports.figures.wheels import draw_array

        followed = [_points(path.path) for path in (*self.whole, *self.paths) if path.path is not None]
        draw_array(ax, self.scene, np.concatenate(followed) if followed else None)
        colors = dict(zip(self._worst_first(), COLORS, strict=False))
        for failed in self.failures:
            label = str(failed) if failed in colors else OTHERS
            color, order = (colors[failed], 2.5) if failed in colors else (OTHER_COLOR, 2.45)
            style = "--" if failed.kind is FailureKind.LIFTED else "-"
            for path in (after for _, after in self.pairs(failed)):
                _draw(ax, path, color=color, linestyle=style, label=label, linewidth=1.4, zorder=order)
        for path in self.whole:  # below and wide: what it is compared with stays seen
            _draw(ax, path, color="0.75", linewidth=4.5, zorder=2.4, label="all wheels")
        for path in self.whole:
            ax.plot(*path.start[:2], ">", color=INK, markersize=6, zorder=2.6, label="start")
        title_axes(ax, f"{one_line(self.scene.name)}: paths with wheels failed")

    def figure(self) -> Figure:
        """The array, and beside it the same with a legend below, which covers nothing."""
        from nonsmooth.reports.figures.style import (
            INK,
            LABEL,
            LEGEND_ROW,
            PICTURE,
            legend_below,
            line_entry,
            mark_entry,
            new_figure,
        )
        from nonsmooth.reports.figures.wheels import draw_array

        figure = new_figure(2 * PICTURE, PICTURE)
        array, near = figure.subplots(1, 2)
        draw_array(array, self.scene)
        self.draw(near)
        named = {str(label): handle for handle, label in zip(*near.get_legend_handles_labels(), strict=True)}
        entries = [*named.values(), mark_entry("+", "checked point", markersize=9)]
        entries += [mark_entry("o", "end", markersize=4), line_entry("checked square", linestyle="--", color=INK)]
        if any(path.does_tip for path in self.paths):
            entries.append(mark_entry("x", "tips", markersize=4))
        figure.set_figheight(PICTURE + LEGEND_ROW * (1 - (-len(entries) // COLUMNS)))  # and one for the titles
        legend_below(figure, entries, columns=COLUMNS, fontsize=LABEL - 1)
        return figure

    def __repr__(self) -> str:
        said = [(str(failed), f"end moves {_text(self.farthest(failed))}") for failed in self.failures]
        return short_lines(f"paths of {self.scene.name} with wheels failed", said)


def moved(before: FailedPath, after: FailedPath) -> tuple[float, float] | None:
    """How far the end moves (length), and turns (radian); None where one of both has no end."""
    if before.end is None or after.end is None:
        return None
    (x, y, theta), (u, v, phi) = before.end, after.end
    return math.hypot(u - x, v - y), phi - theta


def follow_failures(scene: Scene, options: SimulateOptions) -> FailedPathsResult:
    """Paths from one start or a grid of them, with the wheels failed that ``fail`` names.

    Raises:
        OptionError: for a start that is no pose, and wheels that the scene has not.
        RefusalError: where the motion of the whole table is not determined.
        ValueError: for a start outside the checked square.
        TrajectoryError: where the path of the whole table from the only start cannot be followed.
    """
    cases = list(_cases(scene, str(options.fail)))
    starts = [options.pose] if options.grid is None else _grid(scene, options.grid, float(options.heading))
    fastest = scene.fastest or 1.0
    long = options.last if options.grid is None else ENOUGH * scene.check.half_width / fastest
    until = options.until or long
    total = len(starts) * (1 + len(cases))
    before: list[FailedPath] = []
    for start in starts:
        with part_of(len(before), total, "paths"):
            try:
                path = rule_path(scene, scene.contact.rule, start, until)
            except TrajectoryError as error:
                if len(starts) == 1:
                    raise
                before.append(FailedPath(Failed(), start, None, one_line(str(error))))
                continue
        before.append(FailedPath(Failed(), start, path, near=is_near(scene, path.end.state)))
    after: list[FailedPath] = []
    for failed in cases:
        for start, whole_path in zip(starts, before, strict=True):
            with part_of(len(before) + len(after), total, "paths"):
                after.append(_followed(scene, failed, start, until, whole_path))
    return FailedPathsResult(scene, until, tuple(before), tuple(after))


def _cases(scene: Scene, text: str) -> Iterator[Failed]:
    """Every wheel alone, or the ones that are listed together; stopped and lifted."""
    known = whole(scene).numbers
    if text.strip() == ANY:
        groups: list[tuple[int, ...]] = [(number,) for number in known]
    else:
        parts = [part.strip() for part in text.split(",")]
        named = {f"{number:d}": number for number in known} | {str(number): number for number in known}  # names win
        wrong = next((part for part in parts if part not in named), None)
        if wrong is not None:
            required = f"wheels among {numbers_text(known)}, or {ANY}"
            raise OptionError(f"--fail: required {required}, received {wrong[:60]!r}")
        groups = [tuple(sorted({named[part] for part in parts}))]
    for group in groups:
        yield from (Failed(group, kind) for kind in FailureKind)


def _grid(scene: Scene, count: int, heading: float) -> list[Pose]:
    """Centres of equal squares that tile the checked one."""
    x, y = scene.check.place
    radius = scene.check.half_width
    offsets = [radius * ((2 * k + 1) / count - 1) for k in range(count)]
    return [(x + a, y + b, heading) for b in offsets for a in offsets]


def _followed(scene: Scene, failed: Failed, start: Pose, until: float, before: FailedPath) -> FailedPath:
    """The path with wheels failed, or why there is none; ``before`` is that of the whole table."""
    lifted = failed.kind is FailureKind.LIFTED
    try:
        array = _on_the_others(scene, failed.wheels) if lifted else stopped(scene, failed.wheels)
        on_others = lifted and (scene.body is None or not array.wheels)
        if on_others and _leaves_support(array, [start[:2]]) is not None:
            return FailedPath(failed, start, None, "the body does not stand on the wheels that are left", 0.0)
        if _never_carry(scene, failed, before.path):
            return replace(before, failed=failed)
        path = rule_path(array, scene.contact.rule, start, until)
    except NoLoadsError:
        return FailedPath(failed, start, None, NO_TABLE)
    except StartTipsError as error:
        return FailedPath(failed, start, None, one_line(str(error)), 0.0)
    except (RefusalError, SceneError, TrajectoryError, ValueError) as error:
        return FailedPath(failed, start, None, one_line(str(error)))
    out = _leaves_support(array, [state[:2] for state in path.states]) if lifted and scene.body is None else None
    tips = None if out is None else float(path.times[out])
    ends = path.end.reason not in {EndReason.TIPS, *UNFINISHED}
    near = tips is None and ends and is_near(scene, path.end.state)
    return FailedPath(failed, start, path, tips=tips, near=near)


def _on_the_others(scene: Scene, lifted: Collection[int]) -> Scene:
    """The table without wheels, in as much of the checked square as the hull of the others holds: cells end there."""
    rest = without(scene, lifted)
    room = widest_square(rest.positions, rest.check.equilibrium)
    if scene.body is not None or room is None or (rest.check.radius - room).sign() <= 0:
        return rest
    return in_square(rest, room)


def _never_carry(scene: Scene, failed: Failed, path: Trajectory | None) -> bool:
    """Whether no failed wheel carries a body with an outline on a path that tells which wheels do."""
    if scene.body is None or path is None or path.method != BodyPath.method:
        return False
    carrying = {name for piece in path.pieces for name in piece.cells}
    return carrying.isdisjoint(map(str, failed.wheels))


def _leaves_support(array: Scene, places: Sequence[Sequence[object]]) -> int | None:
    """The first of some places that is not strictly inside the hull of the wheels; None where all are."""
    positions = array.positions
    if len(support_polygon(positions)) < 3:
        return 0
    corners = float_points(positions)
    sides, slack = hull_sides(corners), INSIDE * spread(corners)
    heights = np.array(places, float) @ sides[:, :2].T + sides[:, 2]
    outside = np.flatnonzero(heights.max(axis=1) >= -slack)
    return int(outside[0]) if len(outside) else None


def _record(path: FailedPath, move: tuple[float, float] | None) -> Record:
    distance, turn = move or (None, None)
    said = {"wheels": list(path.failed.wheels), "kind": path.failed.kind, "start": list(path.start)}
    end = None if path.end is None else list(path.end)
    return said | {"end": end, "moved": distance, "turned": turn, "home": path.home, "reason": path.how}


def _draw(ax: Axes, path: FailedPath, **style: object) -> None:
    """A line with a dot at its end, or a cross where the body tips."""
    if path.path is None:
        return
    points = _points(path.path)
    (line,) = ax.plot(*points.T, **style)  # type: ignore[arg-type]
    ax.plot(*points[-1], "x" if path.does_tip else "o", color=line.get_color(), markersize=4)


def _points(path: Trajectory) -> Floats:
    """Places (m, 2) along a path, and its end."""
    return np.array([state[:2] for state in (*path.states, path.end.state)], float)


def _text(value: float | None) -> str:
    return "-" if value is None else float_text(value, 4)
