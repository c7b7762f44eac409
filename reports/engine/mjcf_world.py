"""A scene as an MJCF file in the frame of the world: the table stands, and a free body lies on it (MuJoCo >= 3.11).

Every wheel of the table is a small sphere that is fixed in the world and whose surface runs (``surfacevel``); the body
is a plate of the scene's outline, or one that covers the whole table, with a free joint.  The engine itself finds which
wheels touch it, and nobody tells it the loads.

An engine turns the friction cone of a contact by the directions that its collision function chooses: between anything
but a capsule and a static plane, the axes of the world.  So friction that differs along and across a wheel is right
only where its axis lies along one of these.  The file is turned so that the first such axis is that of the file's x,
and an array with one askew is refused; the file in the frame of the body (:mod:`nonsmooth.reports.engine.mjcf`) has any
axis.

Contacts are springs with dampers, and slip lifts them by about ``4 u/(g T)`` of the weight, u the speed of the wheels
and T the contacts' time constant: at the speeds of a machine by many times the weight.  So the surfaces run slowly, and
the file says by what factor; at that speed inertia does not show, and mass 1 stands for any.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING
from xml.sax.saxutils import quoteattr

from nonsmooth.reports.engine.mjcf import LEAST_FRICTION, RULE, SLOWED, engine_inertia, inertia_words, model_name
from nonsmooth.reports.simulations.path_ends import pose_text
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.continuum import Disc
from nonsmooth.symbolic.mechanics.scene import require_known_loads
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number_text import float_text, place_text
from nonsmooth.symbolic.numbers.plane import cross, dot

if TYPE_CHECKING:
    from nonsmooth.analysis.trajectories.result import Trajectory
    from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
    from nonsmooth.symbolic.numbers.plane import Vector

SPEED = 5e-4  # largest speed of a surface (metre/second): slip lifts springs by half a per cent of the weight
RADIUS, THICK = 0.01, 0.02  # of the wheels; half the height of the plate (metre)
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
    place: tuple[float, float]
    path: Trajectory
    axis: tuple[float, float]
    scale: float
    pace: float

    @property
    def seconds(self) -> float:
        """How long the predicted path lasts in the file."""
        return float(self.path.end.t) / (self.pace * self.scale)

    @property
    def file_end(self) -> tuple[float, float, float]:
        """``(x, y, theta)`` at its end, in the file; theta is zero at the start."""
        x, y, theta = (float(value) for value in self.path.end.state)
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
        unit = f" {self.scene.units.length}".rstrip()
        turn = math.degrees(math.atan2(self.axis[1], self.axis[0]))
        left = {
            "speed limits": self.scene.speed_limits,
            "tolerances": self.scene.tolerances,
            "errors of a feedback loop": self.scene.loop_errors,
        }
        lines = [
            f"{model_name(self.scene)}, rule {RULE}, exported by nonsmooth: "
            "the frame is that of the world, the table stands.",
            "It needs MuJoCo 3.11 or later: wheels are static geoms whose surfaces run (surfacevel).",
            f"scale: 1 in this file is {float_text(self.scale, 9)}{unit} in the scene; "
            f"speeds are those of the scene times {float_text(self.pace, 9)}",
            f"turned: the file's x lies at {float_text(turn, 9)} degrees in the scene (friction axes along x or y)",
            *(f"left out: {name}" for name, part in left.items() if part),
            *self._least_friction(),
            f"{inertia_words(self.scene, self.scale)}: neither shows, since the wheels run too slowly for it",
            SLOWED,
            f"start of the centre of mass in the scene: {place_text(self.place)}, at rest",
            f"predicted end (x, y, theta) after {self.seconds!r} s: {' '.join(map(repr, self.file_end))}",
            f"how the predicted path ends: {self.path.end.reason}",
            "The engine ends there within some per cent of the way: slip lifts its springs, and the body sinks.",
        ]
        return "\n".join(f"    {line}" for line in lines)

    def _least_friction(self) -> list[str]:
        low = any(float(mu) < LEAST_FRICTION for w in self.scene.wheels for mu in (w.friction.roll, w.friction.side))
        return [f"friction below {LEAST_FRICTION:g} is written as that, the least of the engine"] if low else []

    def _in_file(self, point: tuple[float, float]) -> tuple[float, float]:
        x, y = self._turned(point)
        return x / self.scale, y / self.scale

    def _turned(self, vector: tuple[float, float]) -> tuple[float, float]:
        """A vector of the scene along the file's axes."""
        (x, y), (c, s) = vector, self.axis
        return c * x + s * y, c * y - s * x

    def _plate(self) -> str:
        """The outline as a geom, its frame turned by the heading."""
        body = self.scene.body
        if body is None:
            farthest = max(math.hypot(*map(float, wheel.position)) for wheel in self.scene.wheels)
            half = MARGIN * farthest / self.scale
            return f'type="box" size="{half!r} {half!r} {THICK!r}"'
        px, py = self._in_file((float(body.centroid[0]), float(body.centroid[1])))
        hx, hy = self._turned((float(body.heading[0]), float(body.heading[1])))
        frame = f'pos="{px!r} {py!r} 0" xyaxes="{hx!r} {hy!r} 0 {-hy!r} {hx!r} 0"'
        if isinstance(body.outline, Disc):
            return f'type="cylinder" size="{float(body.outline.radius) / self.scale!r} {THICK!r}" {frame}'
        a, b = (float(value) / self.scale for value in body.outline.vertices[2])
        return f'type="box" size="{a!r} {b!r} {THICK!r}" {frame}'

    def _wheel(self, wheel: Wheel) -> str:
        x, y = self._in_file((float(wheel.position[0]), float(wheel.position[1])))
        dx, dy = self._turned((float(wheel.unit_direction[0]), float(wheel.unit_direction[1])))
        speed = self.pace * float(wheel.speed)
        return (
            f'    <geom name="wheel {wheel.index}" type="sphere" size="{RADIUS!r}" pos="{x!r} {y!r} {-RADIUS!r}" '
            f'contype="0" conaffinity="0" surfacevel="{speed * dx!r} {speed * dy!r} 0 0 0 0"/>'
        )

    def _pair(self, wheel: Wheel) -> str:
        """The first tangent of the engine's contacts is the file's y, the second its x."""
        roll, side = (max(float(mu), LEAST_FRICTION) for mu in (wheel.friction.roll, wheel.friction.side))
        gx, gy = self._turned((float(wheel.unit_grip[0]), float(wheel.unit_grip[1])))
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
    """
    from nonsmooth.analysis.bodies.mass_study import rule_path

    require_known_loads(scene, "to export it")
    _require_engine(scene)
    x, y = scene.check.equilibrium
    radius = scene.check.radius
    there = (x + radius / 2, y + radius / 4) if place is None else place
    table = whole(scene)
    axis = _axis(table)
    point = float(there[0]), float(there[1])
    fastest = max(abs(float(wheel.speed)) for wheel in table.wheels) or 1.0
    scale = max(math.hypot(*map(float, wheel.position)) for wheel in table.wheels)
    path = rule_path(scene, RULE, (*point, 0.0), WAY * scale / fastest)
    return WorldExport(table, point, path, axis, scale, SPEED / fastest)


def _require_engine(scene: Scene) -> None:
    """Refuse what the engine has no means for.

    Raises:
        SceneError: naming the key.
    """
    rule = scene.contact.rule
    if rule != RULE or any(scene.rule_of_wheel(wheel) != RULE for wheel in whole(scene).wheels):
        expected = f'"{RULE}", the friction of the engine (or --rule {RULE}), to export it in the frame of the world'
        raise SceneError(scene.origin, "contact.rule", expected, StatedFact(f'"{rule}"'))
    if scene.contact.loads is not None:
        raise SceneError(scene.origin, "contact.loads", 'elastic loads to export it ("elastic")', StatedFact("a table"))
    if scene.body is not None and not isinstance(scene.body.outline, Disc) and scene.body.outline.name != "rectangle":
        expected = "a rectangle or a disc to export it in the frame of the world"
        raise SceneError(scene.origin, "body.shape", expected, StatedFact(scene.body.words))


def _axis(table: Scene) -> tuple[float, float]:
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
    return float(uneven[0].unit_grip[0]), float(uneven[0].unit_grip[1])
