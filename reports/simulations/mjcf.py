"""A scene as an MJCF file for a physics engine (MuJoCo), with what is predicted of it: a test for friction solvers.

The frame is reversed: the body is the ground, a plane, and the array rides on it as a vehicle does, with its centre of
mass where that of the body is.  Slips, loads and friction are the same (module ``symbolic.mechanics.vehicles``), and
the engine aligns the tangents of the contact of a capsule and a plane with the capsule's axis, so that an elliptic
friction cone has mu_roll along the friction axis and mu_side across it, whichever way that points.  Each wheel is a
capsule so short that it counts as a point; its surface runs at the wheel's speed.  Loads come from contacts alike, as
springs.

What the engine has no means for is refused (rollers, loads that springs do not give).  What the file holds otherwise
than the scene, and what it leaves out, is said in its comments: a rule or a place that is another, wheels that do not
carry the body there, friction below the least of the engine, and what the motion does not depend on.

The engine couples slip and normal force by the damping of its contacts, so wheels run slowly: the file states by what
factor.  Its lengths are those of the scene over the distance of the farthest wheel.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import StrEnum
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

import numpy as np

from nonsmooth.analysis.bodies.gyration import squared_radius
from nonsmooth.analysis.bodies.vehicles import require_friction
from nonsmooth.analysis.cells.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.reports.simulations.path_ends import pose_text
from nonsmooth.symbolic.mechanics.body import Disc
from nonsmooth.symbolic.mechanics.contact_set import standing, whole
from nonsmooth.symbolic.mechanics.scene import Scene, require_known_loads
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.numbers.number_text import float_text, numbers_text, place_text
from nonsmooth.symbolic.numbers.plane import XY, Pose, cross, dot, in_floats, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator

    from nonsmooth.analysis.trajectories.result import Trajectory
    from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
    from nonsmooth.symbolic.numbers.plane import Vector


RULE = "ellipse"  # the engine's elliptic cone
BESIDE = (
    "beside the checked point, where a body may rest, unless the option 'from' names a place: so that there is a "
    "motion to compare"
)
SLOWED = (
    "so slow, because the engine couples slip and load: the friction law alone decides, as for a body without inertia"
)
SPEED = 1e-6  # largest speed of a surface in the file (metre/second)
RADIUS, HALF_LENGTH = 0.05, 1e-4  # of the capsules (metre)
LEAST_FRICTION = 1e-5  # of the engine
ROLLERS = "roller"  # the rule of wheels with passive rollers, whose forces are no ellipses
SETTLING = 1.0  # seconds in which contacts settle: a hundred of their time constants
# Of the largest entry of the predicted twist; a body at rest may creep at this share of the wheels' speed.
CONFORMS = 2e-3
AT_REST = 1e-9  # of the wheels' speed: slower is rounding of rest


def model_name(scene: Scene) -> str:
    """The name of a scene on one line, without the two hyphens that end a comment of XML."""
    return one_line(scene.name).replace("--", "- ")


def comment_text(lines: Iterable[str]) -> str:
    """Lines of a comment of XML, in which no two hyphens may stand side by side: a strict parser refuses the file."""
    return "\n".join(f"    {line.replace('--', '- -')}" for line in lines)


def engine_inertia(scene: Scene, scale: float) -> tuple[float, float] | None:
    """Mass (kg) and inertia about the vertical through the centre of mass, in lengths of the file; None without units.

    Args:
        scene: of the wheels that carry the body.
        scale: the file's length of 1 in lengths of the scene.
    """
    if scene.inertia is None:
        return None
    mass = 1.0 if scene.inertia.mass is None else float(scene.inertia.mass)
    return mass, mass * float(squared_radius(scene)) / scale**2


def inertia_words(scene: Scene, scale: float) -> str:
    """Whose mass and inertia the file holds, and that they do not matter."""
    found = engine_inertia(scene, scale)
    if found is None:
        return "mass 1 and inertia 1 stand for any"
    stated = scene.inertia is not None and scene.inertia.mass is not None
    mass = f"mass {float_text(found[0])} kg, {'as stated' if stated else 'for any (none is stated)'}"
    return (
        f"{mass}; inertia {float_text(found[1] / found[0] * scale**2)} {scene.units.length}^2 per mass, as in the scene"
    )


def _low_friction(scene: Scene) -> Iterator[str]:
    """That friction is raised, where the engine knows none so low."""
    if any(float(mu) < LEAST_FRICTION for w in scene.wheels for mu in (w.friction.roll, w.friction.side)):
        yield f"friction below {LEAST_FRICTION:g} is written as that, the least of the engine"


def _friction(wheel: Wheel) -> tuple[float, float]:
    """Along and across the friction axis, as it is written."""
    roll, side = (max(float(mu), LEAST_FRICTION) for mu in (wheel.friction.roll, wheel.friction.side))
    return roll, side


def _left_out(scene: Scene) -> Iterator[str]:
    """What the motion does not depend on."""
    parts = {
        "speed limits": scene.speed_limits,
        "tolerances": scene.tolerances,
        "errors of a feedback loop": scene.loop_errors,
    }
    yield from (f"left out: {name}" for name, part in parts.items() if part)


def _beside(scene: Scene) -> Vector:
    """Where a body is put down unless a place is given: half and a quarter of a radius beside its point."""
    (x, y), radius = scene.check.equilibrium, scene.check.radius
    return x + radius / 2, y + radius / 4


def _sizes(scene: Scene) -> tuple[float, float]:
    """The speed of the fastest surface, one where all stand, and the distance of the farthest wheel."""
    return scene.fastest or 1.0, max(math.hypot(*in_floats(wheel.position)) for wheel in scene.wheels)


def _require_springs(scene: Scene) -> None:
    """Refuse loads that springs do not give.

    Raises:
        SceneError: naming them.
    """
    if scene.contact.loads is not None:
        raise SceneError(scene.origin, "contact.loads", 'elastic loads to export it ("elastic")', StatedFact("a table"))


class Motion(StrEnum):
    """What the body does at the exported place."""

    REST = "rest"
    SLIDE = "slide"
    SPIN = "spin"


@dataclass(frozen=True, eq=False)
class Export:
    """A scene with the body at one place, and what is predicted there.

    Attributes:
        scene: the wheels that carry the body there.
        place: of the centre of mass.
        given: the scene before wheels were left out.
        twist: predicted under rule ``ellipse``, in the scene's units, about its origin, shape (3,).
        scale: the file's length of 1 in lengths of the scene.
        pace: the file's speeds over those of the scene, in lengths of the file.
    """

    scene: Scene
    given: Scene
    place: XY
    twist: Floats
    scale: float
    pace: float

    @property
    def file_twist(self) -> Floats:
        """The predicted twist in the file's units: that of the engine's free joint ``(v_x, v_y, omega)``."""
        vx, vy, omega = self.twist
        return np.array([vx * self.pace, vy * self.pace, omega * self.pace * self.scale])

    @property
    def motion(self) -> Motion:
        """Rest, a turn about the centre of mass, or anything else."""
        x, y = self.place
        vx, vy, omega = self.twist
        slow = AT_REST * self.scene.fastest
        if math.hypot(vx - omega * y, vy + omega * x) > slow:
            return Motion.SLIDE
        return Motion.SPIN if abs(omega) * self.scale > slow else Motion.REST

    @property
    def summary(self) -> str:
        """The wheels, the place, the rule and the motion, on one line."""
        count, every = len(self.scene.wheels), len(whole(self.given).wheels)
        wheels = f"{count} wheels" if count == every else f"{count} of {every} wheels"
        named = self.given.contact.rule
        rule = f"rule {RULE}" if named == RULE else f"rule {RULE} in place of {named}"
        return f"{wheels}, centre of mass {self._where}, {rule}, predicted {self.motion}"

    @property
    def _where(self) -> str:
        """The place, with the checked point where that is another."""
        point = self.given.check.place
        return place_text(self.place) + f" (the checked point is {place_text(point)})" * self._is_beside

    @property
    def _is_beside(self) -> bool:
        """Whether the place is not the checked point."""
        return self.given.check.place != self.place

    def differences(self) -> Iterator[str]:
        """What the file holds otherwise than the scene, and what it leaves out."""
        named, carrying = self.given.contact.rule, set(self.scene.numbers)
        if named != RULE:
            yield f"rule {RULE}, which the engine follows, in place of the scene's {named}"
        idle = tuple(wheel.index for wheel in whole(self.given).wheels if wheel.index not in carrying)
        if idle:
            yield f"left out: wheels {numbers_text(idle)}, which do not carry the body at this place"
        yield from _low_friction(self.scene)
        if self.given.body:
            yield "left out: the outline of the body (the ground has no end)"
        yield from _left_out(self.given)
        yield f"{inertia_words(self.scene, self.scale)}: the predicted motion does not depend on them"

    def text(self) -> str:
        """The MJCF document."""
        wheels = "\n".join(self._wheel(wheel) for wheel in self.scene.wheels)
        pairs = "\n".join(self._pair(wheel) for wheel in self.scene.wheels)
        x, y = (value / self.scale for value in self.place)
        mass, turning = engine_inertia(self.scene, self.scale) or (1.0, 1.0)
        return f"""<mujoco model={quoteattr(model_name(self.scene))}>
  <!--
{self._comment()}
  -->
  <option timestep="0.001" gravity="0 0 -9.81" cone="elliptic" impratio="1e9" iterations="200" tolerance="1e-14"/>
  <worldbody>
    <geom name="body" type="plane" size="5 5 1" contype="0" conaffinity="0"/>
    <body name="array">
      <freejoint/>
      <inertial pos="{x!r} {y!r} {RADIUS!r}" mass="{mass:g}" diaginertia="{turning:.9g} {turning:.9g} {turning:.9g}"/>
{wheels}
    </body>
  </worldbody>
  <contact>
{pairs}
  </contact>
</mujoco>
"""

    def _comment(self) -> str:
        vx, vy, omega = (float(value) + 0.0 for value in self.file_twist)
        unit = self.scene.units.after_length
        lines = [
            f"{model_name(self.scene)}, rule {RULE}, exported by nonsmooth: "
            "the frame is reversed, the array rides on the body.",
            f"centre of mass in the scene: {self._where}",
            *[BESIDE] * self._is_beside,
            f"scale: 1 in this file is {float_text(self.scale, 9)}{unit} in the scene; "
            f"speeds are those of the scene times {float_text(self.pace, 9)}",
            SLOWED,
            *self.differences(),
            f"predicted twist (v_x, v_y, omega): {vx!r} {vy!r} {omega!r}",
            f"predicted motion: {self.motion}",
            f"creep bound: {CONFORMS * SPEED!r}",
            f"A solver conforms if after {SETTLING:g} s the free joint's velocity is the predicted twist within "
            f"{CONFORMS:g} of its largest entry,",
            "or, where rest is predicted, no entry is above the creep bound.",
        ]
        return comment_text(lines)

    def _wheel(self, wheel: Wheel) -> str:
        x, y = (float(value) / self.scale for value in wheel.position)
        ax, ay = in_floats(wheel.unit_grip)
        along, across = (self.pace * float(speed) for speed in wheel.slip_speeds)
        frame = f"0 0 1 {ay!r} {-ax!r} 0"  # the third axis is the friction axis, the second points to its right
        return (
            f'      <geom name="wheel {wheel.index}" type="capsule" size="{RADIUS!r} {HALF_LENGTH!r}" '
            f'pos="{x!r} {y!r} {RADIUS!r}" xyaxes="{frame}" contype="0" conaffinity="0" '
            f'surfacevel="0 {across!r} {-along!r} 0 0 0"/>'
        )

    def _pair(self, wheel: Wheel) -> str:
        roll, side = _friction(wheel)
        return (
            f'    <pair geom1="body" geom2="wheel {wheel.index}" condim="3" friction="{roll!r} {side!r} 0 0 0" '
            'solref="0.01 1" solimp="0.5 0.5 1 0.5 2"/>'
        )


def export_scene(scene: Scene, place: Vector | None = None) -> Export:
    """A scene with the body's centre of mass at a place, half and a quarter of a radius beside its point unless given.

    Raises:
        SceneError: for rule ``roller``, and loads that are not elastic; a ``TipsError`` for a body that does not stand
            there.
        RefusalError: where the motion is not determined; a ``LoadError`` where the body tips.
    """
    require_known_loads(scene, "to export it")
    _require_ellipses(scene)
    there = _beside(scene) if place is None else place
    carried = standing(scene.checked_at(there, scene.check.radius))
    rule = contact_rule(RULE)
    if not isinstance(rule, SmoothRule):
        raise TypeError(f"required a rule without cells, received {rule.name}")
    require_friction(carried, rule)
    point = in_floats(there)
    twist = minima_under(rule, carried, np.array([point])).twists[0]
    fastest, scale = _sizes(carried)
    return Export(carried, scene, point, twist, scale, SPEED / fastest)


def _require_ellipses(scene: Scene) -> None:
    """Refuse rollers, and loads that springs do not give.

    Raises:
        SceneError: naming the rule or the loads.
    """
    for wheel in scene.wheels:
        if scene.rule_of_wheel(wheel) == ROLLERS:
            key = "contact.rule" if scene.contact.rule == ROLLERS else f"wheel[{wheel.index:d}].contact"
            expected = f"a rule of wheels without rollers to export it (the friction of the engine is rule {RULE})"
            raise SceneError(scene.origin, key, expected, StatedFact(f'"{ROLLERS}"'))
    _require_springs(scene)


# ---- the frame of the world: the table stands, and a free body lies on it (MuJoCo >= 3.11) -------
#
# Every wheel of the table is a small sphere that is fixed in the world and whose surface runs (``surfacevel``); the
# body is a plate of the scene's outline, or one that covers the whole table, with a free joint.  The engine itself
# finds which wheels touch it, and nobody tells it the loads.
#
# An engine turns the friction cone of a contact by the directions that its collision function chooses: between anything
# but a capsule and a static plane, the axes of the world.  So friction that differs along and across a wheel is right
# only where its axis lies along one of these.  The file is turned so that the first such axis is that of the file's x,
# and an array with one askew is refused; the file in the frame of the body has
# any axis.
#
# Contacts are springs with dampers, and slip lifts them by about ``4 u/(g T)`` of the weight, u the speed of the wheels
# and T the contacts' time constant: at the speeds of a machine by many times the weight.  So the surfaces run slowly,
# and the file says by what factor; at that speed inertia does not show, and mass 1 stands for any.


WORLD_SPEED = 5e-4  # largest speed of a surface (metre/second): slip lifts springs by half a per cent of the weight
WORLD_RADIUS, THICK = 0.01, 0.02  # of the wheels; half the height of the plate (metre)
TIMESTEP, TIME_CONSTANT = 1e-2, 0.04  # seconds
MARGIN = 4.0  # times the array's size: half the plate of a body without an outline
WAY = 0.25  # of the distance of the farthest wheel: the predicted path lasts as long as the fastest rim takes for that
OTHER_FRAME = "without --frame world, in the frame of the body, any axis can be exported"


@dataclass(frozen=True, eq=False)
class WorldExport:
    """A scene with the body at one place of its table, and its predicted path from there.

    Attributes:
        scene: with all wheels of the table, under rule ``ellipse``.
        place: of the centre of mass at the start.
        path: predicted, without inertia.
        axis: unit vector of the scene that is the file's x.
        scale: the file's length of 1 in lengths of the scene.
        pace: the file's speeds over those of the scene, in lengths of the file.
    """

    scene: Scene
    place: XY
    path: Trajectory
    axis: XY
    scale: float
    pace: float

    @property
    def seconds(self) -> float:
        """How long the predicted path lasts in the file."""
        return float(self.path.end.t) / (self.pace * self.scale)

    @property
    def file_end(self) -> Pose:
        """``(x, y, theta)`` at its end, in the file; theta is zero at the start."""
        x, y, theta = pose_in_floats(self.path.end.state)
        return *self._in_file((x, y)), theta

    @property
    def summary(self) -> str:
        """What was written, on one line."""
        end = pose_text(self.scene.units, self.path.end.state, 4)
        there = f"{place_text(self.file_end, 4)} in the file, after {self.seconds:.4g} s of its time"
        return f"{len(self.scene.wheels)} wheels and a free body, predicted to end at {end}: {there}"

    def text(self) -> str:
        """The MJCF document."""
        wheels = "\n".join(map(self._wheel, self.scene.wheels))
        pairs = "\n".join(map(self._pair, self.scene.wheels))
        x, y = self._in_file(self.place)
        mass, turning = engine_inertia(self.scene, self.scale) or (1.0, 0.5)
        return f"""<mujoco model={quoteattr(model_name(self.scene))}>
  <!--
{self._comment()}
  -->
  <option timestep="{TIMESTEP!r}" gravity="0 0 -9.80665" cone="elliptic" impratio="1e9" iterations="200"
    tolerance="1e-14"/>
  <worldbody>
{wheels}
    <body name="body" pos="{x!r} {y!r} {THICK!r}">
      <freejoint/>
      <inertial pos="0 0 0" mass="{mass:g}" diaginertia="{turning / 2:.9g} {turning / 2:.9g} {turning:.9g}"/>
      <geom name="body" {self._plate()} contype="0" conaffinity="0"/>
    </body>
  </worldbody>
  <contact>
{pairs}
  </contact>
</mujoco>
"""

    def _comment(self) -> str:
        unit = self.scene.units.after_length
        turn = math.degrees(math.atan2(self.axis[1], self.axis[0]))
        lines = [
            f"{model_name(self.scene)}, rule {RULE}, exported by nonsmooth: "
            "the frame is that of the world, the table stands.",
            "It needs MuJoCo 3.11 or later: wheels are static geoms whose surfaces run (surfacevel).",
            f"scale: 1 in this file is {float_text(self.scale, 9)}{unit} in the scene; "
            f"speeds are those of the scene times {float_text(self.pace, 9)}",
            f"turned: the file's x lies at {float_text(turn, 9)} degrees in the scene (friction axes along x or y)",
            *_left_out(self.scene),
            *_low_friction(self.scene),
            f"{inertia_words(self.scene, self.scale)}: neither shows, since the wheels run too slowly for it",
            SLOWED,
            f"start of the centre of mass in the scene: {place_text(self.place)}, at rest",
            f"predicted end (x, y, theta) after {self.seconds!r} s: {' '.join(map(repr, self.file_end))}",
            f"how the predicted path ends: {self.path.end.reason}",
            "The engine ends there within some per cent of the way: slip lifts its springs, and the body sinks.",
        ]
        return comment_text(lines)

    def _in_file(self, point: XY) -> XY:
        x, y = self._turned(point)
        return x / self.scale, y / self.scale

    def _turned(self, vector: XY) -> XY:
        """A vector of the scene along the file's axes."""
        (x, y), (c, s) = vector, self.axis
        return c * x + s * y, c * y - s * x

    def _plate(self) -> str:
        """The outline as a geom, its frame turned by the heading."""
        body = self.scene.body
        if body is None:
            _, farthest = _sizes(self.scene)
            half = MARGIN * farthest / self.scale
            return f'type="box" size="{half!r} {half!r} {THICK!r}"'
        px, py = self._in_file(in_floats(body.centroid))
        hx, hy = self._turned(in_floats(body.heading))
        frame = f'pos="{px!r} {py!r} 0" xyaxes="{hx!r} {hy!r} 0 {-hy!r} {hx!r} 0"'
        if isinstance(body.outline, Disc):
            return f'type="cylinder" size="{float(body.outline.radius) / self.scale!r} {THICK!r}" {frame}'
        a, b = (float(value) / self.scale for value in body.outline.vertices[2])
        return f'type="box" size="{a!r} {b!r} {THICK!r}" {frame}'

    def _wheel(self, wheel: Wheel) -> str:
        x, y = self._in_file(in_floats(wheel.position))
        dx, dy = self._turned(in_floats(wheel.unit_direction))
        speed = self.pace * float(wheel.speed)
        return (
            f'    <geom name="wheel {wheel.index}" type="sphere" size="{WORLD_RADIUS!r}" '
            f'pos="{x!r} {y!r} {-WORLD_RADIUS!r}" '
            f'contype="0" conaffinity="0" surfacevel="{speed * dx!r} {speed * dy!r} 0 0 0 0"/>'
        )

    def _pair(self, wheel: Wheel) -> str:
        """The first tangent of the engine's contacts is the file's y, the second its x."""
        roll, side = _friction(wheel)
        gx, gy = self._turned(in_floats(wheel.unit_grip))
        along_y, along_x = (roll, side) if abs(gy) > abs(gx) else (side, roll)
        return (
            f'    <pair geom1="body" geom2="wheel {wheel.index}" condim="3" friction="{along_y!r} {along_x!r} 0 0 0" '
            f'solref="{TIME_CONSTANT!r} 1" solimp="0.5 0.5 1 0.5 2"/>'
        )


def export_world(scene: Scene, place: Vector | None = None) -> WorldExport:
    """A scene with its body at a place, half and a quarter of a radius beside its point unless given.

    Raises:
        SceneError: for another rule than ``ellipse``, loads that are not elastic, friction axes askew to each other,
            and outlines that are neither rectangles nor discs; a ``TipsError`` for a body that does not stand there.
        RefusalError: where the motion is not determined.
        TrajectoryError: where that of the predicted path is not proved to be the minimizer.
    """
    from nonsmooth.analysis.bodies.mass_study import rule_path
    from nonsmooth.analysis.trajectories.result import EndReason, TrajectoryError

    require_known_loads(scene, "to export it")
    _require_engine(scene)
    table = whole(scene)
    axis = _axis(table)
    point = in_floats(_beside(scene) if place is None else place)
    fastest, scale = _sizes(table)
    path = rule_path(scene, RULE, (*point, 0.0), WAY * scale / fastest)
    if path.end.reason is EndReason.UNPROVED:
        raise TrajectoryError(path.end.note)
    return WorldExport(table, point, path, axis, scale, WORLD_SPEED / fastest)


def _require_engine(scene: Scene) -> None:
    """Refuse what the engine has no means for.

    Raises:
        SceneError: naming the key.
    """
    rule = scene.contact.rule
    if rule != RULE or any(scene.rule_of_wheel(wheel) != RULE for wheel in whole(scene).wheels):
        expected = f'"{RULE}", the friction of the engine (or --rule {RULE}), to export it in the frame of the world'
        raise SceneError(scene.origin, "contact.rule", expected, StatedFact(f'"{rule}"'))
    _require_springs(scene)
    if scene.body is not None and not isinstance(scene.body.outline, Disc) and scene.body.outline.name != "rectangle":
        expected = "a rectangle or a disc to export it in the frame of the world"
        raise SceneError(scene.origin, "body.shape", expected, StatedFact(scene.body.words))


def _axis(table: Scene) -> XY:
    """The friction axis of the first wheel whose friction differs along and across it; x where there is none.

    Raises:
        SceneError: where another is neither along it nor across it.
    """
    uneven = [wheel for wheel in table.wheels if wheel.friction.roll != wheel.friction.side]
    if not uneven:
        return 1.0, 0.0
    first = uneven[0].grip
    for wheel in uneven:
        if cross(first, wheel.grip).sign() and dot(first, wheel.grip).sign():
            expected = f"friction axes along or across that of wheel {uneven[0].index} ({OTHER_FRAME})"
            raise SceneError(table.origin, "--frame world", expected, StatedFact(f"wheel {wheel.index} askew to it"))
    return in_floats(uneven[0].unit_grip)
