"""A vehicle on its own wheels: an array of wheels seen from the other side.

Wheel i is fixed to the vehicle at ``p_i`` and heads along ``d_i``; the ground is at rest.  A vehicle that moves with
the twist ``xi = (v, omega)`` (in its own frame: x forward, y to the left, v the velocity of the frame's origin) drags
the contact of a wheel that rolls at the speed ``u_i`` over the ground with the slip ``v(p_i) - u_i d_i``.  That is the
slip of a body that moves with xi over fixed wheels with surface velocities ``u_i d_i``, and the friction forces that
the ground exerts on the vehicle are those that such wheels exert on the body.  So a vehicle is a scene whose wheels
stand in the vehicle's frame and whose body has its centre of mass at that of the vehicle (Alexander and Maddocks 1989).
"""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True)
class VehicleMeasurement:
    """What somebody measured, or ships with the vehicle.

    Attributes:
        multiplier: effective track of an in-place turn over the track.
        source: where the number is from.
    """

    multiplier: Number
    source: str = ""


@dataclass(frozen=True)
class Vehicle:
    """A vehicle with commanded wheel speeds.

    Attributes:
        scene: its wheels as an array in the vehicle's frame; ``scene.check.equilibrium`` is the centre of mass.
        track: W, distance of the wheels of the left and the right side (length); None where it is not stated.
        wheel_base: L, distance of the first and the last wheel of a side; None where no side is stated.
        left: commanded speed of the wheels of the left side; None where wheels state their own.
        right: commanded speed of the wheels of the right side.
        wheel_radius: of all wheels; None where it is not stated.
        measured: what was measured of an in-place turn.
        description: one line.
    """

    scene: Scene
    track: Number | None = None
    wheel_base: Number | None = None
    left: Number | None = None
    right: Number | None = None
    wheel_radius: Number | None = None
    measured: VehicleMeasurement | None = None
    description: str = ""

    @property
    def name(self) -> str:
        """The name of its scene."""
        return self.scene.name

    @property
    def centre_of_mass(self) -> Vector:
        """c, in the vehicle's frame."""
        return self.scene.check.equilibrium

    @property
    def turns_by_sides(self) -> bool:
        """Whether the wheels of each side run at one speed, the two at different ones, over a known track."""
        return None not in (self.left, self.right, self.track) and self.left != self.right

    def multiplier(self, omega: Number) -> Number | None:
        """``(u_right - u_left)/(omega W)``: the effective track over the track.

        None where the vehicle does not turn, or its sides have no speeds.
        """
        if not self.turns_by_sides or not omega:
            return None
        if self.left is None or self.right is None or self.track is None:
            return None
        return (self.right - self.left) / (omega * self.track)
