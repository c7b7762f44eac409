"""Where a path ends, when and how: one sentence in the scene's own units, and its record.

``ends 0.108 mm from the point, heading 7.49 deg, within 4.15 mm of its end after 0.8 s, at rest since 1.1 s``.  The
motion at the end is that of :func:`nonsmooth.analysis.trajectories.result.ending`; swings and the time after which a
body stays near where it ends are counted as for bodies with inertia (:mod:`nonsmooth.analysis.bodies.settling`).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.bodies.settling import Settling, SettlingResult, arrival, swings_of
from nonsmooth.analysis.trajectories.result import (
    UNFINISHED,
    End,
    Ending,
    EndMotion,
    EndReason,
    Trajectory,
    ending,
    parts_of,
)
from nonsmooth.proofs.findings import Record
from nonsmooth.symbolic.mechanics.contact_set import accuracy_at_point
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.units import Units
from nonsmooth.symbolic.numbers.number_text import float_text, place_text
from nonsmooth.symbolic.numbers.plane import pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, norms

if TYPE_CHECKING:
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

DIGITS = 3
AT_POINT = 1e-9  # of the scene's length: a distance that is rounding
SLOWLY = 1e-6  # rotation rate over the speed of the fastest rim at the scene's length, below which it is not named


def size_of(scene: Scene) -> float:
    """What a radian counts as: the length l of the scene."""
    return float(scene.check.length)


@dataclass(frozen=True)
class ArrayPathEnd:
    """The end of one path of an array.

    Attributes:
        scene: the array.
        path: of ``(x, y, theta)`` in the world.
    """

    scene: Scene
    path: Trajectory

    @cached_property
    def ending(self) -> Ending:
        """Whether it is at rest, and since when."""
        return ending(self.path, size_of(self.scene), self.scene.fastest)

    @cached_property
    def _distances(self) -> tuple[Floats, Floats]:
        """Times, and distances of the centre of mass from where it ends."""
        times = parts_of(self.path)
        found = self.path.sample(times)[:, :2]
        return times, norms(found - found[-1])

    @property
    def _goes_on(self) -> bool:
        """Whether it moves on at the end, or is not followed to its end."""
        return self.ending.motion is EndMotion.MOVING or self.path.end.reason in UNFINISHED

    @property
    def settles_after(self) -> float | None:
        """The time after which it stays within the accuracy of where it ends; None where it moves on."""
        if self._goes_on:
            return None
        return arrival(*self._distances, float(accuracy_at_point(self.scene)))

    @property
    def swings(self) -> int | None:
        """How often it comes back to more than the accuracy; None where it moves on."""
        if self._goes_on:
            return None
        return swings_of(self._distances[1], float(accuracy_at_point(self.scene)))

    @property
    def distance(self) -> float:
        """From the checked point (length)."""
        return distance_from_point(self.scene, self.path.end.state)

    def motion(self) -> str:
        """``at rest since 1.1 s``, ``creeps at 0.3 mm/s``, ``moving at 20 mm/s and turning at 3 deg/s``."""
        return _motion(self.ending, self.scene)

    def record(self) -> Record:
        """JSON-ready: ``motion, since, speed, turning, distance, accuracy, settles_after, swings``."""
        where = {"distance": self.distance, "accuracy": float(accuracy_at_point(self.scene))}
        return self.ending.record() | where | {"settles_after": self.settles_after, "swings": self.swings}

    def words(self) -> str:
        """The sentence."""
        state = [float(value) for value in self.path.end.state]
        parts = [f"{_ends(self.path.end, self.scene.units)} {_place(self.scene, state)}"]
        if self.path.end.reason is EndReason.TIPS:
            return ", ".join([*parts, "where it tips"])
        if self.settles_after is not None:
            parts += [_settles(self.scene, self.settles_after)]
        if self.swings:
            parts += [_swings(self.swings)]
        return ", ".join([*parts, self.motion()])


def distance_from_point(scene: Scene, state: Any) -> float:
    """From the checked point (length)."""
    x, y = scene.check.place
    return math.hypot(float(state[0]) - x, float(state[1]) - y)


def is_near(scene: Scene, state: Any) -> bool:
    """Whether a body is within the accuracy of the checked point."""
    return distance_from_point(scene, state) <= float(accuracy_at_point(scene))


def accuracy_text(scene: Scene) -> str:
    """How near a body must come, with its unit."""
    return float_text(accuracy_at_point(scene), DIGITS) + scene.units.after_length


def sampled_record(schema: str, scene: Scene) -> Record:
    """The first keys of what is sampled over an array."""
    return {"schema": schema, "scene": scene.name, "rule": scene.contact.rule, "status": "sampled"}


def _place(scene: Scene, state: Any) -> str:
    """How far from the point, and at which heading."""
    distance, unit = distance_from_point(scene, state), scene.units.after_length
    near = distance <= AT_POINT * size_of(scene)
    place = "at the point" if near else f"{float_text(distance, DIGITS)}{unit} from the point"
    return f"{place}, heading {_in_words(scene, float(state[2]))}"


def _ends(end: End, units: Units | None = None) -> str:
    """What stands before the place: a path that is broken off does not end there."""
    if end.reason not in UNFINISHED:
        return "ends"
    return f"followed until t = {float_text(end.t, DIGITS)}{units.after_time if units else ''},"


def _in_words(scene: Scene, radians: float) -> str:
    """An angle in the unit of a scene that states units, and in degrees where none are stated."""
    if scene.units.length and not scene.units.in_degrees:
        return f"{float_text(radians, DIGITS)} {scene.units.angle}"
    return degrees_text(radians)


def degrees_text(theta: float) -> str:
    """A heading (radian) in degrees: ``7.49 deg``."""
    degrees = math.degrees(theta)
    return f"{float_text(degrees if abs(degrees) > 1e-9 else 0.0, DIGITS)} deg"


def pose_text(units: Units, state: Sequence[Any], digits: int) -> str:
    """``(180, 120) mm, heading 5 deg`` of a scene with degrees, ``(0.2, 0.4), theta = 0.3`` of others."""
    x, y, theta = pose_in_floats(state)
    if not units.in_degrees:
        return f"{place_text((x, y), digits)}, theta = {float_text(theta, digits)}"
    return f"{place_text((x, y), digits)}{units.after_length}, {heading_text(units, theta, digits=digits)}"


def heading_text(units: Units, theta: float, symbol: str = "theta", digits: int = 6) -> str:
    """``heading 5 deg`` of a scene with degrees, ``theta_0 = 0.3`` of others."""
    if not units.in_degrees:
        return f"{symbol} = {float_text(theta, digits)}"
    return f"heading {float_text(math.degrees(theta), digits)} {units.angle}"


def shown_angle(units: Units, radians: float) -> float:
    """An angle, or a rate of one, as people read it."""
    return math.degrees(radians) if units.in_degrees else radians


def in_unit(name: str, unit: str) -> str:
    """The head of a column: ``moved (mm)``."""
    return f"{name} ({unit})" if unit else name


def _settles(scene: Scene, after: float) -> str:
    accuracy = accuracy_text(scene)
    if not after:  # it does not come there
        return f"within {accuracy} of its end already at the start"
    return f"within {accuracy} of its end after {float_text(after, DIGITS)}{scene.units.after_time}"


def _swings(count: int) -> str:
    return f"{count} swing{'' if count == 1 else 's'}"


def _motion(end: Ending, scene: Scene) -> str:
    """``at rest since 1.1 s``, ``creeps at 0.3 mm/s``, ``moving at 20 mm/s and turning at 3 deg/s``."""
    units, turning = scene.units, end.turning or 0.0
    if end.motion is EndMotion.AT_REST and end.since is not None:
        return f"at rest since {'t = ' * (not units.time)}{float_text(end.since, DIGITS)}{units.after_time}"
    moves = f"{end.motion.value} at {float_text(end.speed, DIGITS)}{units.after_speed}"
    slow = SLOWLY * max(scene.fastest, end.speed) / size_of(scene)
    return moves if abs(turning) <= slow else f"{moves} and turning at {_in_words(scene, turning)}{units.per_time}"


# ---- with inertia --------------------------------------------------------------------------------


def settled_words(scene: Scene, body: SettlingResult) -> str:
    """What becomes of a body with inertia, from rest."""
    if body.kind is Settling.THROWN_OFF:
        return f"thrown off after {float_text(body.until, DIGITS)}{scene.units.after_time}"
    if body.kind is Settling.LIMIT_CYCLE and body.amplitude is not None:
        size = float_text(body.amplitude, DIGITS) + scene.units.after_length
        return f"swings on for ever, up to {size} from a place {_place(scene, body.end)}"
    if body.settles_after is None:
        return f"still moving after {float_text(body.until, DIGITS)}{scene.units.after_time}"
    parts = [f"ends {_place(scene, body.end)}", _settles(scene, body.settles_after), _swings(body.swings or 0)]
    return ", ".join(parts)


def settled_record(scene: Scene, body: SettlingResult) -> Record:
    """JSON-ready."""
    return {
        "status": "simulated",
        "what": str(body.kind),
        "end": list(body.end),
        "distance": distance_from_point(scene, body.end),
        "settles_after": body.settles_after,
        "swings": body.swings,
        "limit_cycle": body.amplitude,
        "until": body.until,
    }


def range_text(values: Floats) -> str:
    """``0.9 to 1.9``; one number where both read the same."""
    low, high = (float_text(float(value), 3) for value in (values.min(), values.max()))
    return low if low == high else f"{low} to {high}"


# ---- plain systems -------------------------------------------------------------------------------


def system_end(system: SwitchedSystem, path: Trajectory) -> tuple[Record, str]:
    """The record and the sentence of a path of a plain system."""
    end = ending(path)
    distance = _distance(system, path.end.state)
    away = f"{float_text(distance, DIGITS)} from the checked point"
    place = "at the checked point" if is_at_point(system, path.end.state) else away
    motion = f"{end.motion.value} at {float_text(end.speed, DIGITS)}"
    if end.since is not None:
        motion = f"at rest since t = {float_text(end.since, DIGITS)}"
    record = end.record() | {"distance": distance}
    return {key: value for key, value in record.items() if key != "turning"}, f"{_ends(path.end)} {place}, {motion}"


def is_at_point(system: SwitchedSystem, state: Sequence[Any]) -> bool:
    """Whether a state of a path is the checked point, to rounding."""
    return _distance(system, state) <= AT_POINT * system.check.half_width


def _distance(system: SwitchedSystem, state: Sequence[Any]) -> float:
    """From the checked point."""
    return math.dist(list(map(float, state)), system.check.place)
