"""A vehicle on its own wheels: an array of wheels seen from the other side.

Wheel i is fixed to the vehicle at ``p_i`` and heads along ``d_i``; the ground is at rest.  A vehicle that moves with
the twist ``xi = (v, omega)`` (in its own frame: x forward, y to the left, v the velocity of the frame's origin) drags
the contact of a wheel that rolls at the speed ``u_i`` over the ground with the slip ``v(p_i) - u_i d_i``.  That is the
slip of a body that moves with xi over fixed wheels with surface velocities ``u_i d_i``, and the friction forces that
the ground exerts on the vehicle are those that such wheels exert on the body.  So a vehicle is a scene whose wheels
stand in the vehicle's frame and whose body has its centre of mass at that of the vehicle (Alexander and Maddocks 1989).

The effective track of a turn is the difference of the side speeds over omega, and its multiplier is that over the
track W.  Of four equal wheels at ``(+-L/2, +-W/2)`` that head forward, left ones at the speed ``-u``, right ones at
``u``, all weighted slips have the same size by symmetry, so under rule ``ellipse`` the dissipation is the root of one
quadratic in omega, ``(mu_R (u - omega W/2))^2 + (mu_S omega L/2)^2``, least where the multiplier ``2u/(omega W)`` is
:data:`FORMULA`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Literal

from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector

FORMULA = "1 + (mu_S/mu_R)^2 (L/W)^2"  # the multiplier of four equal wheels under rule ellipse


@dataclass(frozen=True)
class Vehicle:
    """A vehicle with commanded wheel speeds.

    Attributes:
        scene: its wheels as an array in the vehicle's frame; ``scene.check.equilibrium`` is the centre of mass.
        track: W, distance of the wheels of the left and the right side (length); None where it is not stated.
        wheel_base: L, distance of the first and the last wheel of a side; None where no side is stated.
        left: commanded speed of the wheels of the left side, y > 0; None where they state several, and where a wheel
            stands between the sides.
        right: commanded speed of the wheels of the right side.
        wheel_radius: of all wheels; None where it is not stated.
        measured: the multiplier of an in-place turn that somebody measured, or ships with the vehicle.
        source: where that number is from.
    """

    kind: ClassVar[Literal[SceneKind.VEHICLE]] = SceneKind.VEHICLE

    scene: Scene
    track: Number | None = None
    wheel_base: Number | None = None
    left: Number | None = None
    right: Number | None = None
    wheel_radius: Number | None = None
    measured: Number | None = None
    source: str = ""

    @property
    def name(self) -> str:
        """The name of its scene."""
        return self.scene.name

    @property
    def origin(self) -> str:
        """Where it came from, for messages."""
        return self.scene.origin

    @property
    def centre_of_mass(self) -> Vector:
        """c, in the vehicle's frame."""
        return self.scene.check.equilibrium

    @property
    def turn(self) -> tuple[Number, Number] | None:
        """``(u_right - u_left, W)`` of sides that run at different speeds over a known track; None of others."""
        if self.left is None or self.right is None or self.track is None or self.left == self.right:
            return None
        return self.right - self.left, self.track

    def multiplier(self, omega: Number) -> Number | None:
        """``(u_right - u_left)/(omega W)``; None where the vehicle does not turn, or not by its sides."""
        if self.turn is None or not omega:
            return None
        difference, track = self.turn
        return difference / (omega * track)

    def float_multiplier(self, omega: float) -> float | None:
        """The same of a float rate other than 0."""
        if self.turn is None:
            return None
        difference, track = map(float, self.turn)
        return difference / (omega * track)

    @property
    def has_four_equal_wheels(self) -> bool:
        """Whether the formula is about this vehicle: four wheels of one friction, centre of mass in their middle."""
        if self.track is None or self.wheel_base is None or any(self.centre_of_mass):
            return False
        x, y, wheels = self.wheel_base / 2, self.track / 2, self.scene.wheels
        heads = all(wheel.axis is None and not wheel.direction[1] for wheel in wheels)
        alike = len({wheel.friction for wheel in wheels}) == 1 and self.scene.contact.loads is None
        corners = {(x, y), (x, -y), (-x, y), (-x, -y)}
        return heads and alike and len(wheels) == 4 and {wheel.position for wheel in wheels} == corners

    def friction_ratio(self, multiplier: Number) -> Number | None:
        """``mu_S/mu_R = sqrt(m - 1) W/L``, the inverse of the formula; None of other vehicles, and for m < 1."""
        if not self.has_four_equal_wheels or self.track is None or self.wheel_base is None:
            return None
        excess = multiplier - 1
        return None if excess.sign() < 0 else excess.sqrt() * self.track / self.wheel_base
