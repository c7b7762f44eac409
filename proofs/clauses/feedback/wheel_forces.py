"""The friction forces that wheels can contribute under a rule without cells while the body moves with a given twist.

A force is measured in units of the half-axes of its friction set, ``(rho, tau)``: on the border of the set on the side
of the slip where a wheel slips across, anywhere in the set where it does not.  Over ``-1 < t < 1`` the border is ::

    rho = 2t/(1 + t^2),    tau = s min((1 - t^2)/(1 + t^2), kappa)

the open half circle, and between the corners of a cut one (rule ``roller``, rollers that turn) the straight side.  On
the circle the speed of the rim turns the force, on the straight side the rim does not slip.  A rim without friction
turns no force, however fast it runs: the force of such a wheel is all across, ``tau = s kappa``, at every t.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import TypeVar

from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.symbolic.constraints import Triple, inner, roll_row, scaled, side_row
from nonsmooth.symbolic.friction_set import FrictionSet
from nonsmooth.symbolic.scene import Scene

PRECISION = 256  # bits of balls
BITS = 50  # of proposed values
Coordinate = TypeVar("Coordinate", Fraction, arb)


@dataclass(frozen=True)
class WheelForces:
    """What one loaded wheel can contribute to the balance while the body moves with a twist.

    Attributes:
        index: number of the wheel.
        along: ``N alpha a``.
        across: ``N beta b``.
        side: sign of its side slip.
        limits: its friction set.
    """

    index: int
    along: Triple
    across: Triple
    side: int
    limits: FrictionSet

    @cached_property
    def cut(self) -> arb | None:
        """The cut of its friction set, as a ball; None where there is none."""
        with ctx.workprec(PRECISION):
            return self.limits.cut.ball() if self.limits.is_cut else None

    @property
    def grips_along(self) -> bool:
        """Whether the speed of the rim turns the force."""
        return bool(self.limits.along)

    def is_straight(self, t: arb) -> bool | None:
        """Whether the force at t is on the straight side; None where balls do not tell."""
        if not self.grips_along:
            return True
        if self.cut is None:
            return False
        _, height = on_circle(t, 1)
        return True if height > self.cut else False if height < self.cut else None

    def on_border(self, t: arb) -> tuple[arb, arb]:
        """``rho, tau``."""
        rho, tau = on_circle(t, self.side)
        return (rho, self.side * (arb(1) if self.cut is None else self.cut)) if self.is_straight(t) else (rho, tau)

    def border_slope(self, t: arb) -> tuple[arb, arb]:
        """Derivatives of rho and tau by t."""
        size = (1 + t * t) ** 2
        return 2 * (1 - t * t) / size, arb(0) if self.is_straight(t) else -4 * self.side * t / size

    def holds(self, rho: arb, tau: arb) -> bool:
        """Whether a force is inside the set."""
        return bool(rho * rho + tau * tau < 1) and (self.cut is None or bool(abs(tau) < self.cut))

    def slip_ratio(self, t: Fraction) -> float:
        """Slip along over slip across the rim at which the force is that of t.

        It is zero on the straight side, and of a rim without friction, whose speed does not count.
        """
        if not self.grips_along or (self.limits.is_cut and 1 - t * t > self.limits.cut * (1 + t * t)):
            return 0.0
        axes = float(self.limits.across / self.limits.along)
        return axes * float(2 * t / (1 - t * t)) * self.side

    @cached_property
    def balls(self) -> tuple[tuple[arb, ...], tuple[arb, ...]]:
        """The columns, as balls."""
        with ctx.workprec(PRECISION):
            return tuple(x.ball() for x in self.along), tuple(x.ball() for x in self.across)


def wheel_forces(scene: Scene, region: LoadRegion, twist: Triple) -> tuple[WheelForces, ...]:
    """The wheels that are loaded at the centred equilibrium, while the body moves with a twist."""
    found: list[WheelForces] = []
    rule = smooth_rule_of(scene)
    for wheel, form in zip(scene.wheels, region.forces, strict=True):
        if form[0]:
            roll, side = roll_row(wheel), side_row(wheel)
            limits = rule.friction_set(wheel.friction)
            along = scaled(roll.unit_normal, form[0] * limits.along)
            across = scaled(side.unit_normal, form[0] * limits.across)
            found.append(WheelForces(wheel.index, along, across, inner(side.normal, twist).sign(), limits))
    return tuple(found)


def on_circle(t: Coordinate, side: int) -> tuple[Coordinate, Coordinate]:
    """``rho, tau`` on the half circle."""
    size = 1 + t * t
    return 2 * t / size, side * (1 - t * t) / size


def ball_of(value: Fraction) -> arb:
    """The rational as a ball."""
    return arb(fmpq(value.numerator, value.denominator))


def rounded(value: float) -> Fraction:
    """A dyadic rational beside a float."""
    return Fraction(round(float(value) * 2**BITS), 2**BITS)
