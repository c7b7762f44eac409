"""Full dynamics for ``simulate --method dynamics``: a path, or its distance from every contact rule's path by mass.

Both come as text, JSON, CSV and a picture.  Run times are left out: equal input gives equal bytes.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass
from fractions import Fraction
from typing import Any

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.analysis.bodies.mass_study import MassStudy, PathDistance, massless_limit, rules_by_limit
from nonsmooth.analysis.bodies.plate import plate
from nonsmooth.analysis.dynamics.newton_euler import DynamicPath, RigidBody, disc
from nonsmooth.analysis.fields.contact_model import ContactModel
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.reports.animation.output import FILMS, film_bytes
from nonsmooth.reports.simulate import POSE, SCHEMA, events_view
from nonsmooth.reports.terminal import header_table
from nonsmooth.symbolic.number_text import float_text
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

MASSES_SCHEMA = "nonsmooth-masses/1"
GRAVITY = Fraction("9.80665")  # standard, m/s^2
MASS = 0.1  # per weight, of a scene that states no unit of length: about 1/g in metres and seconds
MOMENTS = 5  # of a path that are listed on a terminal


def mass_per_weight(scene: Scene) -> float:
    """``1/g`` in the scene's unit of length and seconds, by standard gravity; :data:`MASS` where it states no unit."""
    metres = scene.units.metres
    return MASS if metres is None else float(metres / GRAVITY)


def mass_note(scene: Scene) -> str:
    """What a mass is, in words: in the scene's units, or that a scene without any is given one."""
    if scene.units.metres is None:
        return f"mass per weight (1/g): {MASS:g} unless stated, 0.102 in metres and seconds; the scene names no [units]"
    return f"mass per weight (1/g): {mass_per_weight(scene):.3g} in {scene.units.length} and seconds"


def chosen_body(scene: Scene, model: ContactModel, mass: float | None, inertia: float | None) -> RigidBody:
    """What the user asked for; else a uniform plate of the outline, or a disc as large as the array, under gravity."""
    chosen = mass_per_weight(scene) if mass is None else mass
    if inertia is not None:
        return RigidBody(chosen, inertia)
    return disc(model, chosen) if scene.body is None else plate(scene.body, chosen)


@dataclass(frozen=True)
class ShownPath:
    """One path under full dynamics."""

    scene: Scene
    path: DynamicPath

    @property
    def trajectory(self) -> Trajectory:
        """The poses, sampled, and how the path ends."""
        return self.path.trajectory

    def record(self) -> dict[str, Any]:
        """The record of a trajectory, with the body and the velocity of its centre of mass at every time."""
        return {
            "schema": SCHEMA,
            "scene": self.scene.name,
            "feedback": None,
            **self.path.trajectory.record(),
            "velocity": self.path.states[:, 3:].tolist(),
            **asdict(self.path.body),
            "creep_speed": self.path.creep,
        }

    def lines(self) -> Iterable[Iterable[Any]]:
        """Time, pose, velocity of the centre of mass and rotation rate at every step."""
        yield ("t", "x", "y", "theta", "w_x", "w_y", "omega")
        for t, state in zip(self.path.times.tolist(), self.path.states.tolist(), strict=True):
            yield (t, *state)

    def picture(self, suffix: str) -> bytes:
        """The pose over time and the path between the wheels; or the motion itself."""
        if suffix in FILMS:
            from nonsmooth.reports.animation.film import build_film

            return film_bytes(build_film(self.scene, self.path.trajectory), suffix)
        from nonsmooth.reports.figures.dynamics import path_figure

        return path_figure(self.scene, self.path, suffix)

    def summary(self) -> str:
        """How many steps, and how it ends."""
        return f"{len(self.path.times)} steps, {self.path.trajectory.end.reason}"

    def view(self) -> RenderableType:
        """Events, a few moments of the motion, and how it ends."""
        body, path, name = self.path.body, self.path.trajectory, one_line(self.scene.name)
        head = f"{name}: full dynamics, mass {body.mass:.6g}, inertia {body.inertia:.6g}, from rest"
        table = header_table("t", "x", "y", "theta", "speed", "omega")
        for k in range(MOMENTS):
            t = float(path.end.t) * k / (MOMENTS - 1)
            x, y, theta, *velocity, omega = self.path.state(t).tolist()
            table.add_row(*map(float_text, (t, x, y, theta, sum(w**2 for w in velocity) ** 0.5, omega)))
        begin = events_view(head, path, POSE) if path.events else Text(head)
        return Group(begin, table, Text(f"end: {path.end.reason}"), Text(mass_note(self.scene), "dim"))


@dataclass(frozen=True)
class ShownMasses:
    """Distances from the paths of the contact rules, by mass."""

    scene: Scene
    study: MassStudy

    def record(self) -> dict[str, Any]:
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

    def lines(self) -> Iterable[Iterable[Any]]:
        """One line per mass and rule; mass 0 stands for the path of rule ellipse itself."""
        yield ("mass", "rule", "position", "rotation", "until")
        found = [(row.body.mass, distance) for row in self.study.rows for distance in row.distances]
        for mass, own in [*found, *((0.0, limit) for limit in self.study.limits or ())]:
            yield (mass, own.rule, own.position, own.rotation, own.until)

    def picture(self, suffix: str) -> bytes:
        """Distances over mass, both logarithmic."""
        from nonsmooth.reports.figures.dynamics import masses_figure

        return masses_figure(self.scene, self.study, suffix)

    def summary(self) -> str:
        """The distance from rule ellipse of the lightest body."""
        last, limit = self.study.rows[-1], massless_limit()
        return f"distance {last.distance(limit).position:.3g} from rule {limit} at mass {last.body.mass:.3g}"

    def view(self) -> RenderableType:
        """Distances by mass, and what they tend to."""
        study = self.study
        rules = [rule for rule in rules_by_limit() if rule not in study.skipped]
        table = header_table("mass", *(f"rule {rule}" for rule in rules))
        for row in study.rows:
            table.add_row(float_text(row.body.mass, 3), *(_pair(row.distance(rule)) for rule in rules))
        if study.limits is not None:
            limits = {limit.rule: limit for limit in study.limits}
            table.add_section()
            table.add_row("-> 0", *("0, 0" if rule == massless_limit() else _pair(limits[rule]) for rule in rules))
        x, y, theta = study.start
        head = f"{one_line(self.scene.name)}: full dynamics from rest at ({x:g}, {y:g}), theta = {theta:g}"
        what = f"largest distance from the path of each contact rule until t = {study.until:g}: of (x, y), of theta"
        limit = "" if study.limits is None else "-> 0: the distance of rule ellipse's own path from the others; "
        note = limit + mass_note(self.scene)
        return Group(Text(head), Text(what), table, *map(Text, self._notes()), Text(note, "dim"))

    def _notes(self) -> Iterable[str]:
        """Which paths were compared for a shorter time, and which not at all."""
        for own in self.study.rows[0].distances:
            if own.until < self.study.until:
                yield f"rule {own.rule}: compared until t = {own.until:.6g}, where a path leaves the square or tips"
        if self.study.limits is None:
            rule = massless_limit()
            yield f"rule {rule}: its path slides along an edge, where light bodies move otherwise: no limit is stated"
        for rule, why in self.study.skipped.items():
            yield f"rule {rule}: no path: {one_line(why)}"


def _pair(distance: PathDistance) -> str:
    return f"{float_text(distance.position, 3)}, {float_text(distance.rotation, 3)}"
