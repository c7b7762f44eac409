"""The motion of a vehicle for commanded wheel speeds under every contact rule, with slips and forces of each wheel.

Rules with cells give exact twists, all of them where several meet at the centre of mass.  Under the others the
minimizer of D is found in floats with the forces that prove it, and exactly where all weighted slips are alike
(:mod:`nonsmooth.analysis.vehicles.equal_slips`), as in every in-place turn of four equal wheels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.contact_rule import CellRule, ContactRule, SmoothRule, all_rules, contact_rule
from nonsmooth.analysis.fields.contact_model import Floats, contact_model
from nonsmooth.analysis.minimizers.proved import free_motions
from nonsmooth.analysis.vehicles.equal_slips import equal_slip_twist, slips_somewhere
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.vehicles.vehicle import Vehicle

MOST_EXACT = 12  # wheels up to which the cells of the rules with cells are built
TURNS = 1e-9  # rate of turn times the length of the vehicle, relative to the speeds: below it a float is rounding of 0


@dataclass(frozen=True, eq=False)
class VehicleMotion:
    """What one contact rule says of a vehicle.

    Attributes:
        vehicle: with its wheel speeds.
        rule: the contact rule.
        twists: all twists that the rule allows at the centre of mass, shape (k, 3); one where the motion is unique.
            ``(v_x, v_y, omega)`` in the vehicle's frame, v of the frame's origin.
        exact: the same exactly; None where only floats are known.
        forces: of the ground on the wheels along and across their friction axes, shares of the weight, shape (n, 2);
            None under rules that state none.
        gap: how far D of the twist can be from the least, as a share of the power of all wheels slipping at the
            largest speed; None under rules with cells.
    """

    vehicle: Vehicle
    rule: ContactRule
    twists: Floats
    exact: tuple[Twist, ...] | None
    forces: Floats | None = None
    gap: float | None = None

    @property
    def is_unique(self) -> bool:
        """Whether the rule allows one twist only."""
        return len(self.twists) == 1

    @cached_property
    def slips(self) -> Floats | None:
        """Slips along and across the friction axes, shape (n, 2); None where the motion is not unique."""
        return contact_model(self.vehicle.scene).slips(self.twists[0]) if self.is_unique else None

    @property
    def icr(self) -> tuple[float, float] | None:
        """The instant centre of rotation; None where the vehicle does not turn, or its motion is not unique."""
        return instant_centre(self.twists[0], self._threshold) if self.is_unique else None

    @property
    def exact_icr(self) -> Vector | None:
        """The same exactly."""
        if self.exact is None or len(self.exact) > 1 or not self.exact[0].omega:
            return None
        vx, vy, omega = self.exact[0]
        return -vy / omega, vx / omega

    @property
    def multiplier(self) -> float | None:
        """``(u_right - u_left)/(omega W)``; None where it is not defined, or twists of different rates are allowed."""
        if self.exact is not None:
            exact = self.exact_multiplier
            return None if exact is None else float(exact)
        return float_multiplier(self.vehicle, self.twists[0], self._threshold) if self.is_unique else None

    @property
    def exact_multiplier(self) -> Number | None:
        """The same exactly; None where only floats are known."""
        rates = {twist.omega for twist in self.exact or ()}
        return self.vehicle.multiplier(rates.pop()) if len(rates) == 1 else None

    @property
    def _threshold(self) -> float:
        """Rates of turn at or below this count as none."""
        return TURNS * self.speed / self.size

    @property
    def speed(self) -> float:
        """The largest wheel speed, 1 where all stand."""
        return max((abs(float(wheel.speed)) for wheel in self.vehicle.scene.wheels), default=0.0) or 1.0

    @property
    def size(self) -> float:
        """Distance of the farthest wheel from the origin."""
        return max(math.hypot(*map(float, wheel.position)) for wheel in self.vehicle.scene.wheels)


def instant_centre(twist: Floats, threshold: float = 0.0) -> tuple[float, float] | None:
    """The point at rest, ``J v/omega``; None where ``|omega|`` is at most the threshold."""
    vx, vy, omega = (float(value) for value in twist)
    return None if abs(omega) <= threshold else (-vy / omega, vx / omega)


def float_multiplier(vehicle: Vehicle, twist: Floats, threshold: float = 0.0) -> float | None:
    """``(u_right - u_left)/(omega W)`` of a float twist; None where it is not defined."""
    omega = float(twist[2])
    if vehicle.left is None or vehicle.right is None or vehicle.track is None:
        return None
    if not vehicle.turns_by_sides or abs(omega) <= threshold:
        return None
    return float(vehicle.right - vehicle.left) / (omega * float(vehicle.track))


def vehicle_motion(vehicle: Vehicle, rule: ContactRule | None = None) -> VehicleMotion:
    """What a rule says, the vehicle's own unless given.

    Raises:
        RefusalError: where the motion is not determined; a ``LoadError`` where the vehicle tips over.
    """
    chosen = contact_rule(vehicle.scene.contact.rule) if rule is None else rule
    own = replace(vehicle, scene=_under(vehicle, chosen))
    if isinstance(chosen, SmoothRule):
        return _least_dissipation(own, chosen)
    if not isinstance(chosen, CellRule):
        raise TypeError(f"required a rule with or without cells, received {chosen.name}")
    return _by_cells(own, chosen)


def vehicle_motions(vehicle: Vehicle) -> tuple[VehicleMotion | RefusalError, ...]:
    """What every registered rule says, or why it says nothing."""
    found: list[VehicleMotion | RefusalError] = []
    for rule in all_rules():
        try:
            found.append(vehicle_motion(vehicle, rule))
        except RefusalError as error:
            found.append(error)
    return tuple(found)


def _under(vehicle: Vehicle, rule: ContactRule) -> Scene:
    scene = vehicle.scene
    return replace(scene, contact=replace(scene.contact, rule=rule.name))


def _least_dissipation(vehicle: Vehicle, rule: SmoothRule) -> VehicleMotion:
    scene = vehicle.scene
    require_friction(scene, rule)
    centre = np.array([[float(x) for x in vehicle.centre_of_mass]])
    minimum = rule.minima(scene, centre)[0]
    twists = minimum.twist[None] if minimum.face is None else minimum.face
    exact = equal_slip_twist(scene, rule) if minimum.face is None else None
    found = VehicleMotion(vehicle, rule, twists, None if exact is None else (exact,), minimum.forces)
    if exact is not None and not slips_somewhere(scene, exact):
        return replace(found, forces=np.zeros_like(minimum.forces), gap=0.0)  # no friction is needed
    scale = float(minimum.model.limits(minimum.loads).max(axis=-1).sum()) * found.speed
    return replace(found, gap=abs(minimum.gap) / scale)


def require_friction(scene: Scene, rule: SmoothRule) -> None:
    """Refuse contacts that leave a motion free.

    Raises:
        RefusalError: naming the motion.
    """
    free = free_motions(scene)
    if free:
        raise RefusalError(f"friction: required friction against every motion, received: {free}")
    sets = [rule.friction_set(wheel.friction) for wheel in scene.wheels]
    if not any(one.along or one.across for one in sets):
        raise RefusalError(f"friction: required a wheel that grips under rule {rule.name}, received none")


def _by_cells(vehicle: Vehicle, rule: CellRule) -> VehicleMotion:
    scene = vehicle.scene
    if len(scene.wheels) > MOST_EXACT:
        centre = np.array([[float(x) for x in vehicle.centre_of_mass]])
        return VehicleMotion(vehicle, rule, rule.literal_twists(scene, centre), None)
    cells = build_partition(scene).cells_at(vehicle.centre_of_mass)
    exact = tuple(dict.fromkeys(twist for cell in cells for twist in cell.twists))
    twists = np.array([[float(x) for x in twist] for twist in exact])
    return VehicleMotion(vehicle, rule, twists, exact)
