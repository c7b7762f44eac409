"""The friction forces that wheels can contribute under rule ``ellipse`` while the body moves with a given twist.

A force is measured in units of the axes of its ellipse, ``(rho, tau)``: on the open half of the unit circle on the side
of the slip where a wheel slips across, ``rho = 2t/(1 + t^2)``, ``tau = s (1 - t^2)/(1 + t^2)``, anywhere in the disc
where it does not.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeVar

from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.symbolic.constraints import Triple, inner, roll_row, scaled, side_row
from nonsmooth.symbolic.scene import Scene

PRECISION = 256  # bits of balls
BITS = 50  # of proposed values
Coordinate = TypeVar("Coordinate", Fraction, arb)


@dataclass(frozen=True)
class WheelForces:
    """What one loaded wheel can contribute to the balance while the body moves with a twist.

    Attributes:
        index: number of the wheel.
        along: ``N mu_R a``.
        across: ``N mu_S b``.
        side: sign of its side slip.
    """

    index: int
    along: Triple
    across: Triple
    side: int

    @cached_property
    def balls(self) -> tuple[tuple[arb, ...], tuple[arb, ...]]:
        """The columns, as balls."""
        with ctx.workprec(PRECISION):
            return tuple(x.ball() for x in self.along), tuple(x.ball() for x in self.across)


def wheel_forces(scene: Scene, region: LoadRegion, twist: Triple) -> tuple[WheelForces, ...]:
    """The wheels that are loaded at the centred equilibrium, while the body moves with a twist."""
    found: list[WheelForces] = []
    for wheel, form in zip(scene.wheels, region.forces, strict=True):
        if form[0]:
            roll, side = roll_row(wheel), side_row(wheel)
            along = scaled(roll.unit_normal, form[0] * wheel.friction.roll)
            across = scaled(side.unit_normal, form[0] * wheel.friction.side)
            found.append(WheelForces(wheel.index, along, across, inner(side.normal, twist).sign()))
    return tuple(found)


def on_circle(t: Coordinate, side: int) -> tuple[Coordinate, Coordinate]:
    """``rho, tau``."""
    size = 1 + t * t
    return 2 * t / size, side * (1 - t * t) / size


def ball_of(value: Fraction) -> arb:
    """The rational as a ball."""
    return arb(fmpq(value.numerator, value.denominator))


def rounded(value: float) -> Fraction:
    """A dyadic rational beside a float."""
    return Fraction(round(float(value) * 2**BITS), 2**BITS)
