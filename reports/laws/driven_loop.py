"""The closed loop of an array under the rules ``box`` and ``ellipse``: the certified law of three imposed twists.

Under rule ``box`` the twists are imposed exactly as long as c stays in the square of the certified reach, so the loop
is a switched field with known motions.  From ``V < reach^2``, V measured with l for the unit of length, the body stays
there and comes home.  Under rule ``ellipse`` the speeds impose their twists at c* only, and motions near them near
c*: each is the minimizer of D for these speeds at these loads, and none is used that is not proved to be the motion.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np

from nonsmooth.analysis.bodies.newton_euler import MovingLoads
from nonsmooth.analysis.cells.contact_rule import SmoothRule, has_cells, rule_of
from nonsmooth.analysis.fields.contact_model import ContactModel, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer
from nonsmooth.analysis.minimizers.float_loads import hull_sides
from nonsmooth.analysis.minimizers.minimum import proved
from nonsmooth.analysis.trajectories.imposed_twists import (
    HeldLaw,
    ImposedMotions,
    Motion,
    PoseErrors,
    driven_field,
    follow_held,
)
from nonsmooth.analysis.trajectories.result import End, EndReason, Trajectory, TrajectoryError
from nonsmooth.analysis.trajectories.steppers import StiffAware
from nonsmooth.analysis.trajectories.trajectory import follow_smooth
from nonsmooth.proofs.clauses.feedback.by_friction import DrivenFeedback
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, rim_speeds
from nonsmooth.proofs.findings import ContradictionError
from nonsmooth.reports.laws.feedback_loop import GAIN, RISE_SLACK, law_and_path
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.similar_scenes import in_own_length
from nonsmooth.symbolic.numbers.number_text import float_text, place_text
from nonsmooth.symbolic.numbers.plane import Pose, pose_in_floats
from nonsmooth.symbolic.numbers.plane_arrays import Floats, places_of

MOST_CONES = 4  # of directions of c: on the axis c = 0 all their planes meet, and the follower tries 3^m patterns of m
REMEMBERED = 64  # places: where modes meet, several of them ask for one motion
OUTSIDE = "the body leaves the square in which the speeds impose their twists"
TOLERANCE = 1e-9  # of a step under rule ellipse, relative; a minimizer is right to about 1e-12


@dataclass(frozen=True, eq=False)
class DrivenLoop:
    """The certified law of a centred scene, and its closed loop.

    Attributes:
        scene: the array, measured from the checked point.
        feedback: what the feedback clause says of it: stabilizable.
        gain: k (1/time).
    """

    scene: Scene
    feedback: DrivenFeedback
    gain: float = GAIN

    @property
    def name(self) -> str:
        """Of the law."""
        return "imposed twists"

    @property
    def title(self) -> str:
        """Its name with what the clause says of it."""
        return f"{self.name}, {self.status}"

    @property
    def formula(self) -> str | None:
        """The law in plain text."""
        return self.feedback.law

    @property
    def is_certified(self) -> bool:
        """Others are not followed."""
        return True

    @property
    def status(self) -> str:
        """That it is certified, in words."""
        return "certified by the feedback clause"

    @property
    def region_text(self) -> str | None:
        """The certified region in words; None where it is not known."""
        return None if self.reach is None else f"sqrt(V) < {self.reach:.6g}"

    def holds(self, pose: Pose) -> bool | None:
        """Whether the certified region holds a start; None where it is not known."""
        return None if self.reach is None else self.value(pose) < self.reach**2

    def words(self, pose: Pose) -> list[str]:
        """Lines about the law, for a path from any start."""
        region = self.region_text or "near c*; how near is not known"
        lines = [f"feedback: {self.title}, k = {self.gain:g}", f"{self.formula}; certified for an exact pose: {region}"]
        unit = self.scene.units.after_length
        lines.append(
            f"in words: of the motions xi_l the one that points most along the error g is driven, against it (a radian "
            f'counts as {float_text(self.length, 4)}{unit}); where "tie" is zero two of them do so alike, and at a '
            '"direction" the motions change with that of c'
        )
        if self.errors is not None:
            lines.append("the pose is late and off as [feedback] says, at every sample by the worst of 27 errors")
        return lines

    @property
    def length(self) -> float:
        """L of ``V = |c|^2 + l^2 theta^2``."""
        return float(self.feedback.length)

    @property
    def reach(self) -> float | None:
        """``V < reach^2`` brings the body home; None where only starts near c* are known to."""
        return None if self.feedback.reach is None else float(self.feedback.reach)

    @property
    def is_smooth(self) -> bool:
        """Whether the imposed motions change with the place."""
        return not has_cells(self.scene)

    @property
    def is_sampled(self) -> bool:
        """Whether the law is sampled and held, and not followed event by event.

        So it is where it has too many cones, where speeds end, and where the pose is late or wrong.
        """
        held = self.scene.loop_errors is not None or bool(self.scene.speed_limits)
        return held or len(self.feedback.cones) > MOST_CONES

    @property
    def errors(self) -> PoseErrors | None:
        """Of the pose that the law is given, with l for the unit of length; None where it is exact."""
        stated = self.scene.loop_errors
        if stated is None:
            return None
        turn = float(stated.heading) * math.pi
        return PoseErrors(float(stated.delay), float(stated.position) / self.length, turn)

    @cached_property
    def held(self) -> HeldLaw:
        """The law at samples, with l for the unit of length."""
        wheels, limits = self.scene.wheels, self.scene.speed_limits
        sides = hull_sides(places_of(wheels) / self.length)
        if not limits:
            return HeldLaw(self.cones, self.gain, sides=sides)
        sizes = [float(limits[wheel.index]) if wheel.index in limits else math.inf for wheel in wheels]
        return HeldLaw(self.cones, self.gain, np.array(sizes) / self.length, sides)

    def speeds(self, pose: Sequence[float]) -> list[float]:
        """The speeds of all wheels for a pose measured from the checked point."""
        x, y, theta = pose_in_floats(pose)
        pose_in_lengths = np.array([x / self.length, y / self.length, theta])
        return [float(speed) * self.length for speed in self.held.speeds(pose_in_lengths)]

    def value(self, pose: Sequence[float]) -> float:
        """V of a pose measured from the checked point."""
        x, y, theta = pose_in_floats(pose)
        return x * x + y * y + (self.length * theta) ** 2

    @cached_property
    def cones(self) -> tuple[ImposedMotions, ...]:
        """The law in floats, with l for the unit of length."""
        scene = in_own_length(self.scene)
        return tuple(self._cone(scene, cone) for cone in self.feedback.cones)

    def _cone(self, scene: Scene, cone: LawCone) -> ImposedMotions:
        rays = None if cone.rays is None else (np.array(cone.rays[0], float), np.array(cone.rays[1], float))
        twists = np.array([imposed.twist for imposed in cone.twists], float)
        speeds = np.array([rim_speeds(scene, imposed) for imposed in cone.twists])
        rule = rule_of(scene)
        if not isinstance(rule, SmoothRule):
            return ImposedMotions(rays, twists, tuple(_constant(twist) for twist in twists), speeds)
        model = contacts_under(rule, scene)
        return ImposedMotions(rays, twists, tuple(_minimizing(model, targets) for targets in speeds), speeds)

    def follow(self, start: Sequence[float], until: float) -> Trajectory:
        """The path from a pose measured from the checked point: event by event, or sampled where cones are many.

        Raises:
            TrajectoryError: where a motion is not proved, or the body leaves where the law is certified.
            ContradictionError: where V rises along a path from the certified region.
        """
        x, y, theta = start
        if self._is_sampled_outside(x, y):
            raise TrajectoryError(OUTSIDE)
        start_in_lengths = (x / self.length, y / self.length, theta)
        path = self._within_reach(self._followed(start_in_lengths, until).in_lengths(self.length))
        self._refuse_contradiction(path)
        return path

    def _is_sampled_outside(self, x: float, y: float) -> bool:
        """Whether the speeds of a law that is sampled and held impose other motions there than its own.

        Under rules with cells motions are not sought at every sample.
        """
        return self.is_sampled and self.reach is not None and max(abs(x), abs(y)) >= self.reach

    def _within_reach(self, path: Trajectory) -> Trajectory:
        """A path as far as its samples are those of the law."""
        out = next((k for k, (x, y, _) in enumerate(path.states) if self._is_sampled_outside(x, y)), None)
        if out is None:
            return path
        kept = path.times[: out + 1], path.states[: out + 1]
        end = End(float(kept[0][-1]), kept[1][-1], EndReason.UNPROVED, OUTSIDE)
        return replace(path, sampled=kept, end=end)

    def _followed(self, start: Pose, until: float) -> Trajectory:
        """The path, with l for the unit of length."""
        if self.is_sampled:
            return follow_held(self.held, start, until, self.errors)
        field = driven_field(self.cones, max(map(abs, start)), self.gain)
        if self.is_smooth:
            stepper = StiffAware(TOLERANCE, TOLERANCE * field.size, field.size)
            return follow_smooth(field, start, until, stepper=stepper)
        return follow_smooth(field, start, until)

    def _refuse_contradiction(self, path: Trajectory) -> None:
        """Within the certified region V falls; outside of it a path that leaves the reach is none of this law."""
        values = np.array([self.value(pose) for pose in path.states])
        if self.reach is None or self.errors is not None:
            return
        if values[0] < self.reach**2:
            rise = float((values - np.minimum.accumulate(values)).max())
            if rise > RISE_SLACK * values[0]:
                where = place_text(path.states[0])
                certified = "the feedback clause certifies that V falls under the law"
                seen = f"the path from {where}, as it was computed, lets V rise by {rise:.3g} from {values[0]:.3g}"
                raise ContradictionError(self.scene.name, law_and_path(certified, seen))
        elif np.abs(path.array[:, :2]).max() >= self.reach:
            raise TrajectoryError(OUTSIDE)


def _constant(twist: Floats) -> Motion:
    return lambda c: twist


def _minimizing(model: ContactModel, speeds: Floats) -> Motion:
    """The motion at given speeds under a rule without cells, by the place."""
    targets = np.zeros(2 * model.wheels)
    targets[0::2] = speeds
    driven, loads, minimizer = replace(model, targets=targets), MovingLoads(model, np.zeros(2)), EllipseMinimizer()

    @lru_cache(maxsize=REMEMBERED)
    def motion_at(x: float, y: float) -> Floats:
        minima = minimizer.minimize(driven, loads.at(np.array([x, y]))[0])
        if not proved(minima)[0]:
            at = place_text((x, y))
            raise TrajectoryError(f"required a certified motion, received a minimum without proof at {at}")
        twist: Floats = minima.twists[0]
        return twist

    return lambda c: motion_at(float(c[0]), float(c[1]))
