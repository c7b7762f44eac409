"""One wheel of an array under rule ``box`` over a box of parameters: its slips, and the power of its forces.

With the friction axis a, ``b = J a`` and the turn eta of the wheel within its tolerance, the slips of a twist are ::

    s_R = cos(eta) a . v(p) + sin(eta) b . v(p) - u a . d,      s_S = cos(eta) b . v(p) - sin(eta) a . v(p) - u b . d.

Each number of the wheel enters each formula once, so that balls lose little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from flint import arb

from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.mechanics.tolerances import Tolerance

Balls: TypeAlias = Sequence[arb]


def half_widths(wheel: Wheel, box: Tolerance) -> list[arb]:
    """Of what is added to a wheel's x, y, angle, speed and the two frictions over a box."""
    step, speed = box.position.ball(), abs((wheel.speed * box.speed).ball())
    angle = arb(box.heading.numerator) / box.heading.denominator * arb.pi()
    roll, side = wheel.friction.roll * box.mu_roll, wheel.friction.side * box.mu_side
    return [step, step, angle, speed, roll.ball(), side.ball()]


@dataclass(frozen=True)
class BoxWheel:
    """Balls of a wheel over the box.

    Attributes:
        place: position at the middle of the box.
        axis: unit friction axis there.
        step: half-width of each coordinate of the position.
        cosine: of the turn within the box.
        sine: of the same.
        speeds: right sides of the two rows over the box.
        nominal: coefficients of friction along and across the axis at the middle.
        shares: the same over the box, divided by those at the middle.
    """

    place: tuple[arb, arb]
    axis: tuple[arb, arb]
    step: arb
    cosine: arb
    sine: arb
    speeds: tuple[arb, arb]
    nominal: tuple[arb, arb]
    shares: tuple[arb, arb]

    @classmethod
    def of(cls, wheel: Wheel, box: Tolerance) -> BoxWheel:
        """A wheel of a centred scene within tolerances."""
        turn = arb(box.heading.numerator) / box.heading.denominator * arb.pi() * UNIT
        (x, y), (a, b), (along, across) = wheel.position, wheel.unit_grip, wheel.slip_speeds
        drive = 1 + box.speed.ball() * UNIT
        return cls(
            place=(x.ball(), y.ball()),
            axis=(a.ball(), b.ball()),
            step=box.position.ball(),
            cosine=turn.cos(),
            sine=turn.sin(),
            speeds=(along.ball() * drive, across.ball() * drive),
            nominal=(wheel.friction.roll.ball(), wheel.friction.side.ball()),
            shares=(1 + box.mu_roll.ball() * UNIT, 1 + box.mu_side.ball() * UNIT),
        )

    def moved(self, twist: Balls) -> tuple[arb, arb]:
        """``a . v(p)`` and ``b . v(p)`` of a twist, with a and b over the box."""
        vx, vy, omega = twist
        (x, y), (a, b) = self.place, self.axis
        at_x, at_y = vx - omega * y, vy + omega * x
        spread = abs(omega) * self.step * (abs(a) + abs(b)) * UNIT
        along, across = a * at_x + b * at_y + spread, a * at_y - b * at_x + spread
        return self.cosine * along + self.sine * across, self.cosine * across - self.sine * along

    def slips(self, twist: Balls) -> tuple[arb, arb]:
        """Along the axis and across it."""
        along, across = self.moved(twist)
        return along - self.speeds[0], across - self.speeds[1]

    def power(self, forces: tuple[arb, arb], twist: Balls) -> arb:
        """Of forces along and across the axis, in a twist; per unit of load."""
        vx, vy, omega = twist
        (x, y), (a, b), (roll, side) = self.place, self.axis, forces
        at_x, at_y = vx - omega * y, vy + omega * x
        along, across = a * at_x + b * at_y, a * at_y - b * at_x
        spread = abs(omega) * self.step * (abs(roll * a - side * b) + abs(roll * b + side * a)) * UNIT
        return self.cosine * (roll * along + side * across) + self.sine * (roll * across - side * along) + spread


def box_wheels(scene: Scene, box: Tolerance) -> list[BoxWheel]:
    """All wheels of a centred scene."""
    return [BoxWheel.of(wheel, box) for wheel in scene.wheels]
