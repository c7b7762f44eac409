"""A body with mass under full dynamics: a path, or its distance from every contact rule's path by mass.

Run times are left out: equal input gives equal bytes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from contextlib import suppress
from dataclasses import asdict, dataclass, replace
from itertools import cycle
from typing import TYPE_CHECKING

from nonsmooth.analysis.bodies.mass_study import (
    MassStudy,
    PathDistance,
    body_of,
    body_path,
    mass_ladder,
    mass_study,
    rules_by_limit,
)
from nonsmooth.analysis.bodies.newton_euler import DynamicPath, RigidBody
from nonsmooth.analysis.bodies.path import smooth_path
from nonsmooth.analysis.cells.contact_rule import massless_rule
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.simulations.path_ends import in_unit, pose_text, shown_angle
from nonsmooth.reports.simulations.paths import ArrayPath
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number_text import float_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.figures.path import PathPicture

MASSES_SCHEMA = "nonsmooth-masses/1"
MASS = 0.1  # per weight, of a scene that states no unit of length: about 1/g in metres and seconds
MOMENTS = 5  # of a path that are listed on a terminal
SIZE = (6.4, 5.0)  # inches, of the picture of distances
MARKS = (("#D55E00", "o"), ("#0072B2", "s"), ("#009E73", "^"), ("#CC79A7", "D"), ("#56B4E9", "v"), ("#E69F00", "P"))


def mass_per_weight(scene: Scene) -> float:
    """``1/g`` in the scene's unit of length and seconds; :data:`MASS` where it states no unit."""
    return MASS if scene.inertia is None else 1 / float(scene.inertia.gravity)


def mass_note(scene: Scene) -> str:
    """What a mass is, in words: in the scene's units, or that a scene without any is given one."""
    if scene.inertia is None:
        return f"mass per weight (1/g): {MASS:g} unless stated, 0.102 in metres and seconds; the scene names no [units]"
    return f"mass per weight (1/g): {mass_per_weight(scene):.3g} in {scene.units.length} and seconds"


def _chosen_body(scene: Scene, options: SimulateOptions) -> RigidBody:
    """What the user asked for; else as the scene says (:func:`nonsmooth.analysis.bodies.mass_study.body_of`)."""
    chosen = mass_per_weight(scene) if options.mass is None else options.mass
    try:
        body = body_of(scene, chosen)
        return body if options.inertia is None else replace(body, inertia=options.inertia)
    except ValueError as error:
        raise OptionError(f"--{error}") from None


# ---- one path ------------------------------------------------------------------------------------


@dataclass(frozen=True, repr=False, kw_only=True)
class NewtonEulerPath(ArrayPath):
    """The path of a body with mass, from rest.

    Attributes:
        motion: its states at every step, and the body.
    """

    motion: DynamicPath

    def facts(self) -> Record:
        """The record of a trajectory, with the body and the velocity of its centre of mass at every time."""
        path, said = self.motion, super().facts()
        without = {key: value for key, value in said.items() if key not in {"law", "speeds"}}
        return {**without, "velocity": path.states[:, 3:].tolist(), **asdict(path.body), "creep_speed": path.creep}

    def table(self) -> DataTable:
        """Time, pose, velocity of the centre of mass and rotation rate at every step."""
        steps = zip(self.motion.times.tolist(), self.motion.states.tolist(), strict=True)
        return DataTable(("t", "x", "y", "theta", "w_x", "w_y", "omega"), [(t, *state) for t, state in steps])

    def head(self) -> Sequence[str]:
        """The body."""
        body = self.motion.body
        return [f"{one_line(self.name)}: full dynamics, mass {body.mass:.6g}, inertia {body.inertia:.6g}, from rest"]

    def blocks(self) -> Sequence[Block]:
        """Events, a few moments of the motion, and how it ends."""
        path, rows, units = self.trajectory, [], self.scene.units
        for k in range(MOMENTS):
            t = float(path.end.t) * k / (MOMENTS - 1)
            x, y, theta, *velocity, omega = self.motion.state(t).tolist()
            turned = [shown_angle(units, angle) for angle in (theta, omega)]
            rows.append([*map(float_text, (t, x, y, turned[0], sum(w**2 for w in velocity) ** 0.5, turned[1]))])
        angle = units.angle if units.length or units.in_degrees else ""
        labels = (units.time, units.length, units.length, angle, units.speed, angle and f"{angle}/{units.time}")
        names = map(in_unit, ("t", "x", "y", "theta", "speed", "omega"), labels)
        moments = table(tuple(names), rows)
        begin = super().blocks() if path.events else sentences(*self.head(), self.ending[1])
        return [*begin, moments, *sentences(f"end: {self.end}", mass_note(self.scene))]

    def summary(self) -> str:
        """How many steps, and how it ends."""
        return f"{len(self.motion.times)} steps, {self.end}"

    def picture(self) -> PathPicture:
        """The path between the wheels, beside that of the rule that is the limit without mass, where it has one."""
        from nonsmooth.reports.figures.path import wheels_picture

        body, path, beside = self.motion.body, self.trajectory, None
        limit = massless_rule(self.scene)
        with suppress(TrajectoryError):
            beside = smooth_path(limit, self.scene, path.states[0], float(path.end.t)), f"rule {limit.name} (mass 0)"
        title = f"{one_line(self.name)}: full dynamics, mass {body.mass:.6g}, inertia {body.inertia:.6g}"
        return wheels_picture(self.scene, path, title, beside)


def follow_body(scene: Scene, options: SimulateOptions) -> NewtonEulerPath:
    """The path of a body with mass under full dynamics, from rest.

    Raises:
        OptionError: for a start that is no pose, and a mass or an inertia that cannot be used.
        ValueError: for a start at which a body with an outline tips.
        SceneError: for a table of loads beside an outline.
        TrajectoryError: where the path cannot be followed.
    """
    start, array = options.pose, whole(scene)
    motion = body_path(array, _chosen_body(array, options), start, options.last)
    return NewtonEulerPath(array, motion.trajectory, motion=motion)


# ---- distances by mass ---------------------------------------------------------------------------


@dataclass(frozen=True, repr=False)
class MassResult(Result):
    """Distances of bodies under full dynamics from the path of every contact rule, by mass.

    Attributes:
        scene: the array.
        study: the distances.
    """

    scene: Scene
    study: MassStudy

    @property
    def limit(self) -> str:
        """The rule that bodies approach as their mass goes to zero."""
        return massless_rule(self.scene).name

    def facts(self) -> Record:
        """Distances by mass and rule."""
        rows = [
            {**asdict(row.body), "evaluations": row.evaluations, "distances": list(map(asdict, row.distances))}
            for row in self.study.rows
        ]
        limits = self.study.limits
        return {
            "schema": MASSES_SCHEMA,
            "scene": self.scene.name,
            "start": list(self.study.start),
            "until": self.study.until,
            "rows": rows,
            "limits": None if limits is None else list(map(asdict, limits)),
            "skipped": [{"rule": str(rule), "why": why} for rule, why in self.study.skipped.items()],
        }

    def table(self) -> DataTable:
        """One line per mass and rule; mass 0 stands for the path of the rule that is the limit."""
        found = [(row.body.mass, distance) for row in self.study.rows for distance in row.distances]
        found += [(0.0, limit) for limit in self.study.limits or ()]
        lines = [
            (mass, distance.rule, distance.position, distance.rotation, distance.until) for mass, distance in found
        ]
        return DataTable(("mass", "rule", "position", "rotation", "until"), lines)

    def summary(self) -> str:
        """The distance of the lightest body from the rule that is the limit."""
        last, limit = self.study.rows[-1], self.limit
        return f"distance {last.distance(limit).position:.3g} from rule {limit} at mass {last.body.mass:.3g}"

    def blocks(self) -> Sequence[Block]:
        """Distances by mass, and what they tend to."""
        study = self.study
        rules = [rule for rule in rules_by_limit(self.scene) if rule not in study.skipped]
        rows = [[float_text(row.body.mass, 3), *(_pair(row.distance(rule)) for rule in rules)] for row in study.rows]
        if study.limits is not None:
            limits = {limit.rule: limit for limit in study.limits}
            rows.append(["-> 0", *("0, 0" if rule == self.limit else _pair(limits[rule]) for rule in rules)])
        x, y, theta = study.start
        head = (
            f"{one_line(self.scene.name)}: full dynamics from rest at {pose_text(self.scene.units, (x, y, theta), 6)}"
        )
        what = f"largest distance from the path of each contact rule until t = {study.until:g}: of (x, y), of theta"
        limit = "" if study.limits is None else f"-> 0: the distance of rule {self.limit}'s own path from the others; "
        names = ("mass", *(f"rule {rule}" for rule in rules))
        said = [*self._notes(), limit + mass_note(self.scene)]
        distances = table(names, rows)
        return [*sentences(head, what), distances, *sentences(*said)]

    def _notes(self) -> Iterable[str]:
        """Which paths were compared for a shorter time, and which not at all."""
        for distance in self.study.rows[0].distances:
            if distance.until < self.study.until:
                until = f"t = {distance.until:.6g}"
                yield f"rule {distance.rule}: compared until {until}, where a path leaves the square or tips"
        if self.study.limits is None:
            rule = self.limit
            yield f"rule {rule}: its path slides along an edge, where light bodies move otherwise: no limit is stated"
        for rule, why in self.study.skipped.items():
            yield f"rule {rule}: no path: {one_line(why)}"

    def draw(self, ax: Axes) -> None:
        """Distances over mass, both logarithmic: a curve per rule, and a line at a limit that is not zero."""
        from nonsmooth.reports.figures.style import length_label

        study, units = self.study, self.scene.units
        masses = [row.body.mass for row in study.rows]
        marks = dict(zip(rules_by_limit(self.scene), cycle(MARKS), strict=False))
        for rule, (color, marker) in marks.items():
            if rule not in study.skipped:
                distances = [row.distance(rule).position for row in study.rows]
                ax.plot(masses, distances, color=color, marker=marker, label=f"from rule {rule}")
        for limit in study.limits or ():
            ax.axhline(limit.position, color=marks[limit.rule][0], linewidth=1, linestyle=":")
        if study.limits is not None:
            nearest = study.rows[-1].distance(self.limit).position
            slope = [nearest * mass / masses[-1] for mass in masses]
            ax.plot(masses, slope, color="0.6", linewidth=1, linestyle="--", zorder=0, label="in proportion to mass")
        unit = f"{units.time or 'time'}\N{SUPERSCRIPT TWO}/{units.length or 'length'}"
        ax.set(xscale="log", yscale="log", xlabel=f"mass per weight, 1/g [{unit}]")
        ax.set_ylabel(length_label("largest distance of the paths", units))
        title = f"{one_line(self.scene.name)}: full dynamics and the contact rules"
        ax.set_title(title, fontsize="medium", parse_math=False)
        ax.grid(color="0.92")

    def figure(self) -> Figure:
        """The same with a legend below."""
        from nonsmooth.reports.figures.style import figure_with_legend

        return figure_with_legend(self.draw, SIZE)

    def __repr__(self) -> str:
        head = f"full dynamics over {self.scene.name}, by mass: {self.summary()}"
        said = []
        for mass, rule, position, rotation, _ in self.table().lines:
            apart = f"{float_text(position, 3)} apart, {float_text(rotation, 3)} rad"
            said.append((f"{mass:g}, {rule}:", apart))
        return short_lines(head, said)


def compare_masses(scene: Scene, options: SimulateOptions) -> MassResult:
    """The distance of bodies of one shape, each a tenth as heavy as the one before, from every rule's path.

    Raises:
        OptionError: for a start that is no pose, and a mass or an inertia that cannot be used.
        SceneError: for a table of loads beside an outline.
        RefusalError: where the motion is not determined.
        TrajectoryError: where a path cannot be followed.
    """
    start, array = options.pose, whole(scene)
    heaviest = _chosen_body(array, options)
    try:
        bodies = mass_ladder(heaviest)
    except ValueError as error:  # the lightest of them
        raise OptionError(f"--{error}") from None
    return MassResult(array, mass_study(array, bodies, start, options.last))


def _pair(distance: PathDistance) -> str:
    return f"{float_text(distance.position, 3)}, {float_text(distance.rotation, 3)}"
