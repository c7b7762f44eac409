"""Instant centres of rotation over the commanded curvature, and the mean friction ratio that one spin tells.

The sides run at ``u_left = cos a - sin a`` and ``u_right = cos a + sin a``: straight on at ``a = 0``, in place at
``a = pi/2``; without slip the curvature is ``2 tan(a)/W``.  The instant centre of a side is the point of the vehicle's
plane at which its tread stands still on the ground, ``y = (v_x - u)/omega`` (Mandow and others 2007); the distance of
both is the effective track.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.analysis.contact_rule import SmoothRule, contact_rule
from nonsmooth.analysis.fields.contact_model import ContactModel, Floats
from nonsmooth.analysis.minimizers.ellipse_minimizer import EllipseInterior
from nonsmooth.analysis.minimizers.float_loads import loads_at
from nonsmooth.symbolic.vehicles.multiplier import has_four_equal_wheels
from nonsmooth.symbolic.vehicles.vehicle import Vehicle

COMMANDS = 19  # angles a from 0 to pi/2, both included
RATIOS = (1e-3, 1e3)  # of mu_side to mu_roll, between which a measured spin is sought
RATIO = 1e-13  # of the logarithm of the ratio
PLATEAU = 1e-9  # a multiplier closer to 1 is 1, as float minimizers give it
TURNS = 1e-12  # of the rate at which both sides would turn without slip: a smaller rate is no turn


@dataclass(frozen=True)
class CurvedMotion:
    """The motion for one commanded curvature.

    Attributes:
        left: speed of the left side.
        right: speed of the right side.
        curvature: commanded, without slip (1/length); None in place.
        twist: ``(v_x, v_y, omega)``.
        icr: instant centre of the vehicle; None straight on.
        left_centre: y of the instant centre of the left tread; None straight on.
        right_centre: of the right tread.
        multiplier: effective track over the track; None straight on.
    """

    left: float
    right: float
    curvature: float | None
    twist: tuple[float, float, float]
    icr: tuple[float, float] | None
    left_centre: float | None
    right_centre: float | None
    multiplier: float | None


def turns(vehicle: Vehicle, rule: SmoothRule | None = None, count: int = COMMANDS) -> tuple[CurvedMotion, ...]:
    """The vehicle from straight on to in place, sampled; empty where its sides have no speeds of their own.

    Args:
        vehicle: with two sides and a track.
        rule: one without cells; the vehicle's own where that is one, else ``ellipse``.
        count: number of commanded curvatures.

    Raises:
        LoadError: where the vehicle tips over.
    """
    if vehicle.track is None or vehicle.left is None or vehicle.right is None:
        return ()
    chosen = _smooth(vehicle) if rule is None else rule
    angles = np.linspace(0, np.pi / 2, count)
    left, right = np.cos(angles) - np.sin(angles), np.cos(angles) + np.sin(angles)
    left[np.abs(left) < TURNS], left[-1], right[-1] = 0.0, -1.0, 1.0  # exact at the ends
    twists = _twists(vehicle, chosen.contacts(vehicle.scene), left, right)
    track = float(vehicle.track)
    return tuple(_turn(u, w, track, twist) for u, w, twist in zip(left, right, twists, strict=True))


def _twists(vehicle: Vehicle, model: ContactModel, left: Floats, right: Floats) -> Floats:
    """The minimizers for speeds (m,) of both sides, shape (m, 3)."""
    is_left = np.array([wheel.position[1].sign() > 0 for wheel in vehicle.scene.wheels])
    heads = np.array([wheel.direction[0].sign() for wheel in vehicle.scene.wheels])
    speeds = heads * np.where(is_left, left[:, None], right[:, None])
    loads = np.repeat(loads_at(model, [[float(x) for x in vehicle.centre_of_mass]]), len(left), axis=0)
    return EllipseInterior().minimize(model.with_targets(model.targets_of(speeds)), loads).twists + 0.0


def _turn(left: float, right: float, track: float, twist: Floats) -> CurvedMotion:
    vx, vy, omega = (float(value) for value in twist)
    difference, mean = float(right - left), float(right + left) / 2
    curvature = difference / track / mean if mean else None
    if abs(omega) <= TURNS / track:
        return CurvedMotion(float(left), float(right), curvature, (vx, vy, omega), None, None, None, None)
    return CurvedMotion(
        float(left),
        float(right),
        curvature,
        (vx, vy, omega),
        (-vy / omega, vx / omega),
        (vx - float(left)) / omega,
        (vx - float(right)) / omega,
        difference / (omega * track),
    )


def friction_ratio(vehicle: Vehicle, multiplier: float) -> float | None:
    """A ratio mu_S/mu_R of all wheels at which an in-place turn has this multiplier under rule ``ellipse``.

    Of four equal wheels it is that of the formula, else it is sought by bisection between 1/1000 and 1000; every wheel
    keeps its mu_R.  A multiplier that many ratios give
    tells none: wheels without side slip, such as the middle ones of three, hold the multiplier at 1 up to some ratio.

    Args:
        vehicle: with two sides and a track.
        multiplier: measured, ``(u_right - u_left)/(omega W)``.

    Returns:
        The ratio; None where none between the bounds gives this multiplier, or it is 1.
    """
    from scipy.optimize import bisect

    if vehicle.track is None or vehicle.left is None or vehicle.right is None or multiplier <= 1 + PLATEAU:
        return None
    if has_four_equal_wheels(vehicle) and vehicle.wheel_base is not None:
        return float(np.sqrt(multiplier - 1)) * float(vehicle.track / vehicle.wheel_base)
    model, track = _rule("ellipse").contacts(vehicle.scene), float(vehicle.track)

    def excess(log_ratio: float) -> float:
        """How far the multiplier of a ratio is above the measured one."""
        friction = np.repeat(model.mu_roll, 2) * np.tile([1.0, np.exp(log_ratio)], model.wheels)
        omega = float(_twists(vehicle, replace(model, friction=friction), np.array([-1.0]), np.array([1.0]))[0, 2])
        return np.inf if abs(omega) <= TURNS / track else 2 / (omega * track) - multiplier

    low, high = (float(np.log(ratio)) for ratio in RATIOS)
    if excess(low) > 0 or excess(high) < 0:
        return None
    return float(np.exp(bisect(excess, low, high, xtol=RATIO)))


def _smooth(vehicle: Vehicle) -> SmoothRule:
    """The vehicle's own rule, or ``ellipse`` where that has cells."""
    own = contact_rule(vehicle.scene.contact.rule)
    return own if isinstance(own, SmoothRule) else _rule("ellipse")


def _rule(name: str) -> SmoothRule:
    rule = contact_rule(name)
    if not isinstance(rule, SmoothRule):
        raise TypeError(f"required a rule without cells, received {rule.name}")
    return rule
