"""The motion on one set of wheels in balls, under a rule without cells: forces, their slopes, and loads.

The spatial twist ``xi = (v, omega)`` minimizes ``D = sum_i N_i(c) f_i(r_i, s_i)`` with the slips ``r_i = a_i . xi - u_i``
and ``s_i = b_i . xi`` and the support functions f_i of the friction sets
(:mod:`nonsmooth.symbolic.friction_set`), so the centre of mass enters through the loads alone.  Where every loaded wheel
slips, ``G(xi, c) = sum_i N_i(c) (f_i,r a_i + f_i,s b_i) = 0`` determines it; D is convex, so a zero of G with a regular
Hessian is the only minimizer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.symbolic.constraints import roll_row, side_row
from nonsmooth.symbolic.edge_headings import ball_of
from nonsmooth.symbolic.friction_set import FrictionSet
from nonsmooth.symbolic.scene import Wheel

Pair = tuple[arb, arb]


class UnprovedError(Exception):
    """Balls that do not decide what is asked."""


@dataclass(frozen=True)
class BallWheel:
    """One wheel.

    Attributes:
        row: a and b as columns, shape (3, 2): unit rows on the spatial twist.
        speed: u.
        moment: ``(1, p)`` as a column.
        axes: squares of the half-axes of the friction set.
        cut: share of the half-axis across the rim at which it is cut; None of a whole ellipse.
        corner: the force at a corner of a cut set, for positive slips.
    """

    row: arb_mat
    speed: arb
    moment: arb_mat
    axes: Pair
    cut: arb | None
    corner: Pair

    @classmethod
    def of(cls, wheel: Wheel, limits: FrictionSet) -> BallWheel:
        """From exact numbers."""
        a, b = ([ball_of(x) for x in row(wheel).unit_normal] for row in (roll_row, side_row))
        x, y = (ball_of(entry) for entry in wheel.position)
        along, across, cut = (ball_of(entry) for entry in (limits.along, limits.across, limits.cut))
        corner = (along * (1 - cut * cut).sqrt(), across * cut) if limits.is_cut else (arb(0), arb(0))
        axes = (along * along, across * across)
        rows = arb_mat([[p, q] for p, q in zip(a, b, strict=True)])
        moment = arb_mat([[arb(1)], [x], [y]])
        return cls(rows, ball_of(wheel.speed), moment, axes, cut if limits.is_cut else None, corner)

    def force(self, twist: arb_mat) -> tuple[arb_mat, arb_mat]:
        """Gradient (2, 1) and Hessian (2, 2) of f at the slips of a twist (3, 1).

        Raises:
            UnprovedError: where they may not exist.
        """
        slips = self.row.transpose() * twist
        r, s = slips[0, 0] - self.speed, slips[1, 0]
        roll, side = self.axes
        square = roll * r * r + side * s * s
        if self.cut is not None:
            limit = self.cut * self.cut
            excess = (1 - limit) * side * s * s - limit * roll * r * r
            if excess > 0 and not r.contains(0):
                x, y = self.corner
                return arb_mat([[x if r > 0 else -x], [y if s > 0 else -y]]), arb_mat(2, 2)
            if not excess < 0:
                raise UnprovedError("a wheel at the seam of arc and corner")
        if not square > 0:
            raise UnprovedError("a wheel that may stick")
        size = square.sqrt()
        bend = roll * side / (size * square)
        hessian = arb_mat([[bend * s * s, -bend * r * s], [-bend * r * s, bend * r * r]])
        return arb_mat([[roll * r / size], [side * s / size]]), hessian

    @property
    def is_idle(self) -> bool:
        """Whether it has no friction, and so no force."""
        return self.axes[0].is_zero() and self.axes[1].is_zero()


@dataclass(frozen=True)
class Pull:
    """G and its slopes at one twist and one centre of mass.

    Attributes:
        force: G, shape (3, 1).
        hessian: its slope in the twist, (3, 3).
        slope: its slope in c, (3, 2).
    """

    force: arb_mat
    hessian: arb_mat
    slope: arb_mat


class BallMotion:
    """The motion of a body on a set of wheels, of which some are loaded."""

    def __init__(self, wheels: Sequence[Wheel], loaded: Sequence[bool], rule: SmoothRule) -> None:
        """Elastic loads, total weight 1, with a guess of which wheels they press.

        Raises:
            UnprovedError: where the loaded wheels may stand on one line.
        """
        self._wheels = [BallWheel.of(wheel, rule.friction_set(wheel.friction)) for wheel in wheels]
        self._loaded = tuple(loaded)
        stiffness = arb_mat(3, 3)
        for wheel, pressed in zip(self._wheels, self._loaded, strict=True):
            if pressed:
                stiffness += wheel.moment * wheel.moment.transpose()
        try:
            inverse = stiffness.inv()
        except ZeroDivisionError:
            raise UnprovedError("loaded wheels on one line") from None
        self._forms = [inverse * wheel.moment for wheel in self._wheels]

    def require_loads(self, centre: arb_mat) -> None:
        """Refuse a guess that is not certain at all centres of mass in a box: then the loads are affine around it.

        Raises:
            UnprovedError: where a loaded wheel may be free, or a free one pressed.
        """
        point = _with_one(centre)
        for form, pressed in zip(self._forms, self._loaded, strict=True):
            spring = (form.transpose() * point)[0, 0]
            if not (spring > 0 if pressed else spring < 0):
                raise UnprovedError("loads that change their form")

    def pull(self, twist: arb_mat, centre: arb_mat) -> Pull:
        """G and its slopes at a twist (3, 1) and a centre of mass (2, 1).

        Raises:
            UnprovedError: where a wheel may stick.
        """
        point = _with_one(centre)
        total, hessian, slope = arb_mat(3, 1), arb_mat(3, 3), arb_mat(3, 2)
        for wheel, form, pressed in zip(self._wheels, self._forms, self._loaded, strict=True):
            if not pressed or wheel.is_idle:
                continue
            load = (form.transpose() * point)[0, 0]
            gradient, bend = wheel.force(twist)
            way = wheel.row * gradient
            total += way * load
            hessian += (wheel.row * bend * wheel.row.transpose()) * load
            slope += way * arb_mat([[form[1, 0], form[2, 0]]])
        return Pull(total, hessian, slope)


def _with_one(centre: arb_mat) -> arb_mat:
    """``(1, c)``."""
    return arb_mat([[arb(1)], [centre[0, 0]], [centre[1, 0]]])
