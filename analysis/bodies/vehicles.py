"""How a vehicle on its own wheels moves: its twist under every contact rule, its turns, and what a spin tells.

Rules with cells give exact twists, all of them where several meet at the centre of mass.  Under the others the
minimizer of the dissipation D is found in floats with the forces that prove it, and exactly where all weighted slips
are alike, as in every in-place turn of four equal wheels.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import CellRule, Rule, SmoothRule, all_rules, contact_rule
from nonsmooth.analysis.cells.loads import LoadError, elastic_loads_at
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.contact_model import ContactModel, contact_model, contacts_under
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseMinimizer, minima_under
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.analysis.minimizers.minimum import free_motions
from nonsmooth.symbolic.mechanics.body import support_polygon
from nonsmooth.symbolic.mechanics.contact_states import (
    Twist,
    cofactors,
    combine,
    inner,
    scaled,
    scene_rows,
    total,
    wheel_rows,
)
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.mechanics.vehicles import Vehicle
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane import XY, Vector, in_floats, side_of
from nonsmooth.symbolic.numbers.plane_arrays import Floats

MOST_EXACT = 12  # wheels up to which the cells of the rules with cells are built
ROUNDING = 1e-9  # rate of turn times the length of the vehicle, relative to the speeds: below it a float is no turn
COMMANDS = 19  # commanded turns from straight on to in place, both included
TURNS = 1e-12  # of the rate at which both sides would turn without slip: a smaller rate is no turn
RATIOS = (1e-3, 1e3)  # of mu_side to mu_roll, between which a measured spin is sought
RATIO = 1e-13  # of the logarithm of the ratio
PLATEAU = 1e-9  # a multiplier closer to 1 is 1, as float minimizers give it


# ---- the motion under one rule -------------------------------------------------------------------


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
    rule: Rule
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
    def icr(self) -> XY | None:
        """The instant centre of rotation ``J v/omega``; None where the vehicle does not turn, or moves in many ways."""
        vx, vy, omega = (float(value) for value in self.twists[0])
        return (-vy / omega, vx / omega) if self._turns else None

    @property
    def exact_icr(self) -> Vector | None:
        """The same exactly."""
        if self.exact is None or not self.is_unique or not self.exact[0].omega:
            return None
        vx, vy, omega = self.exact[0]
        return -vy / omega, vx / omega

    @property
    def multiplier(self) -> float | None:
        """``(u_right - u_left)/(omega W)``; None where it is not defined, or twists of different rates are allowed."""
        if self.exact is None:
            return self.vehicle.float_multiplier(float(self.twists[0, 2])) if self._turns else None
        return None if self.exact_multiplier is None else float(self.exact_multiplier)

    @property
    def exact_multiplier(self) -> Number | None:
        """The same exactly; None where only floats are known."""
        rates = {twist.omega for twist in self.exact or ()}
        return self.vehicle.multiplier(rates.pop()) if len(rates) == 1 else None

    @property
    def speed(self) -> float:
        """The largest wheel speed, 1 where all stand."""
        return self.vehicle.scene.fastest or 1.0

    @property
    def size(self) -> float:
        """Distance of the farthest wheel from the origin."""
        return max(math.hypot(*in_floats(wheel.position)) for wheel in self.vehicle.scene.wheels)

    @property
    def _turns(self) -> bool:
        return self.is_unique and abs(float(self.twists[0, 2])) > ROUNDING * self.speed / self.size


def vehicle_motions(vehicle: Vehicle) -> tuple[VehicleMotion | RefusalError, ...]:
    """What every registered rule says, or why it says nothing."""
    motions: list[VehicleMotion | RefusalError] = []
    for rule in all_rules(vehicle.scene):
        try:
            motions.append(vehicle_motion(vehicle, rule))
        except RefusalError as error:
            motions.append(error)
    return tuple(motions)


def vehicle_motion(vehicle: Vehicle, rule: Rule | None = None) -> VehicleMotion:
    """What a rule says, the vehicle's own unless given.

    Raises:
        RefusalError: where the motion is not determined; a ``LoadError`` where the vehicle tips over.
    """
    scene = vehicle.scene
    chosen = contact_rule(scene.contact.rule) if rule is None else rule
    if chosen.needs_loads and scene.contact.loads is None:
        _require_standing(vehicle)
    judged = replace(vehicle, scene=scene.under(chosen.name))
    if isinstance(chosen, SmoothRule):
        return _least_dissipation(judged, chosen)
    return _by_cells(judged, chosen)


def _require_standing(vehicle: Vehicle) -> None:
    """Refuse a vehicle that tips over, or is about to, by the key of its own file.

    Raises:
        LoadError: where the centre of mass is not inside the support polygon.
    """
    hull = support_polygon(vehicle.scene.positions)
    if len(hull) > 2 and side_of(hull, vehicle.centre_of_mass) <= 0:
        required = "vehicle.centre_of_mass: required a point inside the support polygon of the wheels"
        raise LoadError(f"{required}, received {place_text(vehicle.centre_of_mass)}: the vehicle tips over")


def _by_cells(vehicle: Vehicle, rule: CellRule) -> VehicleMotion:
    if len(vehicle.scene.wheels) > MOST_EXACT:
        return VehicleMotion(vehicle, rule, rule.literal_twists(vehicle.scene, _centre(vehicle)), None)
    cells = build_partition(vehicle.scene).cells_at(vehicle.centre_of_mass)
    exact = tuple(dict.fromkeys(twist for cell in cells for twist in cell.twists))
    return VehicleMotion(vehicle, rule, np.array(exact, float), exact)


def _least_dissipation(vehicle: Vehicle, rule: SmoothRule) -> VehicleMotion:
    scene = vehicle.scene
    require_friction(scene, rule)
    minimum = minima_under(rule, scene, _centre(vehicle))
    twists = minimum.faces.get(0, minimum.twists)
    forces = minimum.forces[0]
    exact = None if minimum.faces else equal_slip_twist(scene, rule)
    motion = VehicleMotion(vehicle, rule, twists, None if exact is None else (exact,), forces)
    if exact is not None and not any(row.residual(exact) for row in scene_rows(scene)):
        return replace(motion, forces=np.zeros_like(forces), gap=0.0)  # no friction is needed
    scale = float(minimum.model.limits(minimum.loads).max(axis=-1).sum()) * motion.speed
    return replace(motion, gap=abs(float(minimum.gaps[0])) / scale)


def _centre(vehicle: Vehicle) -> Floats:
    """The centre of mass, shape (1, 2)."""
    return np.array([vehicle.centre_of_mass], float)


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


# ---- exactly, where all weighted slips are alike -------------------------------------------------


def equal_slip_twist(scene: Scene, rule: SmoothRule) -> Twist | None:
    """The exact twist at the checked point; None where weighted slips differ, or a friction set is a cut ellipse.

    Minus the gradient of ``D = sum N_i sqrt(q_i)``, with ``q_i = mu_R^2 r_i^2 + mu_S^2 s_i^2``, balances forces and
    moments at a minimizer.  Where all loaded wheels slip with one size ``sqrt(q_i) = q > 0``, the balance is that of
    the weighted least squares fit ``sum N_i q_i`` times 1/q: three linear equations in the twist.  So the fit is solved
    exactly, and it is the minimizer of D exactly if its weighted slips are alike; nothing is assumed of symmetry.
    Where no loaded wheel slips at all nothing is dissipated, which is the least for every friction set.

    Raises:
        LoadError: where the point lies outside the support polygon or on its border, or the wheels are collinear.
    """
    if scene.contact.loads is not None:
        return None
    loads = elastic_loads_at(scene, scene.check.equilibrium)
    sets = [rule.friction_set(wheel.friction) for wheel in scene.wheels]
    fits = []  # of each loaded wheel its load and two rows, with the weight of the square of their residual in q_i
    for wheel, load, one in zip(scene.wheels, loads, sets, strict=True):
        if load:
            weights = ((half_axis / wheel.grip_length) ** 2 for half_axis in (one.along, one.across))
            fits.append((load, tuple(zip(wheel_rows(wheel), weights, strict=True))))
    weighted = [(row, load * weight) for load, rows in fits for row, weight in rows]
    zero = scene.field.zero
    first, second, third = (
        total(zero, (scaled(row.normal, weight * row.normal[k]) for row, weight in weighted)) for k in range(3)
    )
    columns = cofactors(first, second, third)
    determinant = inner(first, columns[0])
    if not determinant:
        return None
    right = total(zero, (scaled(row.normal, weight * row.rhs) for row, weight in weighted))
    twist = Twist(*scaled(combine(right, columns), determinant.inverse()))
    squares = [sum((weight * row.residual(twist) ** 2 for row, weight in rows), zero) for _, rows in fits]
    if any(squares) and (any(one.is_cut for one in sets) or any(square != squares[0] for square in squares)):
        return None
    return twist


# ---- turns, and what a spin tells ----------------------------------------------------------------


class CurvedMotion(NamedTuple):
    """The motion for one commanded curvature.

    Attributes:
        left: speed of the left side.
        right: speed of the right side.
        curvature: commanded, without slip (1/length); None in place.
        twist: ``[v_x, v_y, omega]``.
        icr: instant centre ``[x, y]`` of the vehicle; None straight on.
        left_centre: y of the instant centre of the left tread; None straight on.
        right_centre: of the right tread.
        multiplier: effective track over the track; None straight on.
    """

    left: float
    right: float
    curvature: float | None
    twist: list[float]
    icr: list[float] | None = None
    left_centre: float | None = None
    right_centre: float | None = None
    multiplier: float | None = None


def turns(vehicle: Vehicle) -> tuple[CurvedMotion, ...]:
    """The vehicle from straight on to in place, sampled, under its own rule or ``ellipse`` where that has cells.

    The sides run at ``u_left = cos a - sin a`` and ``u_right = cos a + sin a``: straight on at ``a = 0``, in place at
    ``a = pi/2``; without slip the curvature is ``2 tan(a)/W``.  The instant centre of a side is the point of the
    vehicle's plane at which its tread stands still on the ground, ``y = (v_x - u)/omega`` (Mandow and others 2007); the
    distance of both is the effective track.  Empty where the sides have no speeds of their own.

    Raises:
        LoadError: where the vehicle tips over.
    """
    if vehicle.track is None or vehicle.left is None or vehicle.right is None:
        return ()
    rule = contact_rule(vehicle.scene.contact.rule)
    model = contacts_under(rule, vehicle.scene)
    angles = np.linspace(0, np.pi / 2, COMMANDS)
    left, right = np.cos(angles) - np.sin(angles), np.cos(angles) + np.sin(angles)
    left[np.abs(left) < TURNS], left[-1], right[-1] = 0.0, -1.0, 1.0  # exact at the ends
    twists = _twists(vehicle, model, left, right)
    commands = zip(left.tolist(), right.tolist(), twists.tolist(), strict=True)
    return tuple(_turn(*command, float(vehicle.track)) for command in commands)


def _turn(left: float, right: float, twist: list[float], track: float) -> CurvedMotion:
    vx, vy, omega = twist
    difference, mean = right - left, (right + left) / 2
    curvature = difference / track / mean if mean else None
    if abs(omega) <= TURNS / track:
        return CurvedMotion(left, right, curvature, twist)
    icr, centres = [-vy / omega, vx / omega], ((vx - left) / omega, (vx - right) / omega)
    return CurvedMotion(left, right, curvature, twist, icr, *centres, difference / (omega * track))


def friction_ratio(vehicle: Vehicle, multiplier: float) -> float | None:
    """A ratio mu_S/mu_R of all wheels at which an in-place turn has this multiplier under rule ``ellipse``.

    Of four equal wheels it is that of the formula, else it is sought by bisection between 1/1000 and 1000; every wheel
    keeps its mu_R.  A multiplier that many ratios give tells none: wheels without side slip, such as the middle ones of
    three, hold the multiplier at 1 up to some ratio.

    Args:
        vehicle: with two sides and a track.
        multiplier: measured, ``(u_right - u_left)/(omega W)``.

    Returns:
        The ratio; None where none between the bounds gives this multiplier, or it is 1.
    """
    from scipy.optimize import bisect

    if vehicle.track is None or vehicle.left is None or vehicle.right is None or multiplier <= 1 + PLATEAU:
        return None
    if vehicle.has_four_equal_wheels and vehicle.wheel_base is not None:
        return float(np.sqrt(multiplier - 1)) * float(vehicle.track / vehicle.wheel_base)
    model, track = contact_model(vehicle.scene), float(vehicle.track)  # of rule ellipse

    def excess(log_ratio: float) -> float:
        """How far the multiplier of a ratio is above the measured one."""
        friction = np.repeat(model.mu_roll, 2) * np.tile([1.0, np.exp(log_ratio)], model.wheels)
        omega = float(_twists(vehicle, replace(model, friction=friction), np.array([-1.0]), np.array([1.0]))[0, 2])
        return np.inf if abs(omega) <= TURNS / track else 2 / (omega * track) - multiplier

    low, high = (float(np.log(ratio)) for ratio in RATIOS)
    if excess(low) > 0 or excess(high) < 0:
        return None
    return float(np.exp(bisect(excess, low, high, xtol=RATIO)))


def _twists(vehicle: Vehicle, model: ContactModel, left: Floats, right: Floats) -> Floats:
    """The minimizers for speeds (m,) of both sides, shape (m, 3)."""
    is_left = np.array([wheel.position[1].sign() > 0 for wheel in vehicle.scene.wheels])
    heads = np.array([wheel.direction[0].sign() for wheel in vehicle.scene.wheels])
    speeds = heads * np.where(is_left, left[:, None], right[:, None])
    loads = np.repeat(loads_at(model, _centre(vehicle)), len(left), axis=0)
    return EllipseMinimizer().minimize(model.with_targets(model.targets_of(speeds)), loads).twists + 0.0
