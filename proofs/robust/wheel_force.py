"""The friction force of one wheel and its moment over a box of twists and of the wheel's own parameters.

Per unit of weight, about the origin, with ``alpha, beta`` the half-axes of the friction set, r and s the slips along
the friction axis a and across it and ``f = |(alpha r, beta s)|`` ::

    g_i = N_i (alpha^2 r a + beta^2 s J a)/f     and its moment p_i x g_i.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import arb

from nonsmooth.proofs.robust.jets import Jet, direction, parameter
from nonsmooth.symbolic.plane import Vector, cross, dot
from nonsmooth.symbolic.scene import Wheel
from nonsmooth.symbolic.tolerances import Tolerance

TWIST, OWN = 3, 7  # the twist; x, y, angle, speed, the two frictions, and the load
COUNT = TWIST + OWN
LOAD = COUNT - 1
# The rules whose forces are written here, and whether rollers cut the disc; another rule has no entry and is a fault.
HAS_ROLLERS = {"ellipse": False, "roller": True}

Balls: TypeAlias = Sequence[arb]
Wrench: TypeAlias = tuple[Jet, Jet, Jet]


@dataclass(frozen=True)
class WheelBox:
    """One wheel with the sizes of its tolerances.

    Attributes:
        wheel: of a centred scene.
        sizes: half-widths of x, y, angle, speed and the two frictions.
        has_rollers: whether the friction set is the disc of mu_R cut by a strip of mu_S (rule ``roller``).
    """

    wheel: Wheel
    sizes: tuple[arb, ...]
    has_rollers: bool

    @classmethod
    def of(cls, wheel: Wheel, box: Tolerance, *, has_rollers: bool) -> WheelBox:
        """The wheel within tolerances."""
        step, speed = box.position.ball(), abs((wheel.speed * box.speed).ball())
        angle = arb(box.heading.numerator) / box.heading.denominator * arb.pi()
        roll, side = wheel.friction.roll * box.mu_roll, wheel.friction.side * box.mu_side
        return cls(wheel, (step, step, angle, speed, roll.ball(), side.ball()), has_rollers)

    def wrench(self, twist: Balls, load: arb, *, whole: bool) -> Wrench | None:
        """Force and moment with their slopes, over the box or at its middle.

        Args:
            twist: balls of ``(v_x, v_y, omega)``.
            load: a ball of ``N_i``.
            whole: whether the wheel's own parameters take their whole box.

        Returns:
            None where the wheel may stick, or its rollers may turn.
        """
        shifts = [size * arb(0, 1) if whole else arb(0) for size in self.sizes]
        vx, vy, omega, x, y, angle, speed, roll, side, force = (
            parameter(value, k, COUNT) for k, value in enumerate([*twist, *shifts, load])
        )
        (px, py), (a, b) = ([_constant(entry.ball()) for entry in pair] for pair in self._frame)
        px, py = px + x, py + y
        cosine = Jet(angle.value.cos(), tuple(-angle.value.sin() * slope for slope in angle.slopes))
        sine = Jet(angle.value.sin(), tuple(angle.value.cos() * slope for slope in angle.slopes))
        a, b = a * cosine - b * sine, a * sine + b * cosine
        drive = _constant(self.wheel.speed.ball()) + speed
        along, across = (_constant(entry.ball()) for entry in self._drive)
        moved = vx - omega * py, vy + omega * px
        r = moved[0] * a + moved[1] * b - drive * along
        s = moved[1] * a - moved[0] * b - drive * across
        mu_roll = _constant(self.wheel.friction.roll.ball()) + roll
        mu_side = _constant(self.wheel.friction.side.ball()) + side
        first, second = mu_roll * r, (mu_roll if self.has_rollers else mu_side) * s
        unit = direction(first, second)
        if unit is None or (self.has_rollers and not abs(unit[1].value) * mu_roll.value < mu_side.value):
            return None
        pull, push = mu_roll * unit[0], (mu_roll if self.has_rollers else mu_side) * unit[1]
        fx, fy = force * (pull * a - push * b), force * (pull * b + push * a)
        return fx, fy, px * fy - py * fx

    @property
    def _frame(self) -> tuple[Vector, Vector]:
        """Position and friction axis."""
        return self.wheel.position, self.wheel.unit_grip

    @property
    def _drive(self) -> Vector:
        """``(a . d, J a . d)``: how the rim's speed divides."""
        if self.wheel.axis is None:
            one = self.wheel.speed.field.one
            return one, one * 0
        axis, rim = self.wheel.unit_grip, self.wheel.unit_direction
        return dot(axis, rim), cross(axis, rim)


def _constant(value: arb) -> Jet:
    return Jet(value, (arb(0),) * COUNT)
