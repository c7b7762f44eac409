"""The motion on one set of wheels in balls, under a rule without cells: forces, their slopes, and loads.

The spatial twist ``xi = (v, omega)`` minimizes ``D = sum_i N_i(c) f_i(r_i, s_i)`` with the slips
``(r_i, s_i) = (a_i . xi, b_i . xi) - w_i`` along and across the friction axis (``w_i = (u_i, 0)`` where that is the
rim) and the support functions f_i of the friction sets (:mod:`nonsmooth.symbolic.friction_set`), so the centre of mass
enters through the loads alone.  Where every loaded wheel slips,
``G(xi, c) = sum_i N_i(c) (f_i,r a_i + f_i,s b_i) = 0`` determines it.  A wheel that sticks adds two equations, no
slip, and two unknowns, its force in units of the half-axes.  D is convex, so a zero of G with forces inside the
friction sets and a regular Jacobian is the only minimizer, and smooth in c.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from nonsmooth.analysis.contact_rule import SmoothRule
from nonsmooth.symbolic.constraints import roll_row, side_row
from nonsmooth.symbolic.edge_headings import ball_of
from nonsmooth.symbolic.friction_set import BorderPiece, CutEllipse, FrictionSet
from nonsmooth.symbolic.scene import Wheel


class UndecidedMotionError(Exception):
    """Balls that do not decide what is asked."""


@dataclass(frozen=True)
class BallWheel:
    """One wheel.

    Attributes:
        row: a and b as columns, shape (3, 2): unit rows on the spatial twist.
        speed: w as a column, (2, 1): of the surface along the friction axis and across it.
        moment: ``(1, p)`` as a column.
        limits: its friction set.
    """

    row: arb_mat
    speed: arb_mat
    moment: arb_mat
    limits: CutEllipse[arb]

    @classmethod
    def of(cls, wheel: Wheel, limits: FrictionSet) -> BallWheel:
        """From exact numbers."""
        a, b = ([ball_of(x) for x in row(wheel).unit_normal] for row in (roll_row, side_row))
        x, y = (ball_of(entry) for entry in wheel.position)
        rows = arb_mat([[p, q] for p, q in zip(a, b, strict=True)])
        moment = arb_mat([[arb(1)], [x], [y]])
        speed = arb_mat([[ball_of(entry)] for entry in wheel.slip_speeds])
        return cls(rows, speed, moment, limits.map(ball_of))

    def force(self, twist: arb_mat) -> tuple[arb_mat, arb_mat]:
        """Gradient (2, 1) and Hessian (2, 2) of f at the slips of a twist (3, 1).

        Raises:
            UndecidedMotionError: where they may not exist.
        """
        slips = self.row.transpose() * twist - self.speed
        r, s = slips.entries()
        if self.limits.piece(r, s) not in (BorderPiece.ARC, BorderPiece.CORNER):
            raise UndecidedMotionError("a wheel that may stick, or is at the seam of arc and corner")
        along, across = self.limits.gradient(r, s)
        rr, rs, ss = self.limits.hessian(r, s)
        return arb_mat([[along], [across]]), arb_mat([[rr, rs], [rs, ss]])

    @property
    def is_idle(self) -> bool:
        """Whether it has no friction, and so no force."""
        return self.limits.along.is_zero() and self.limits.across.is_zero()

    @property
    def grip(self) -> arb_mat:
        """What forces in units of the half-axes do, shape (3, 2)."""
        return self.row * arb_mat([[self.limits.along, arb(0)], [arb(0), self.limits.across]])


@dataclass(frozen=True)
class Pull:
    """The equations of a motion and their slopes, at one state ``(xi, f)`` and one centre of mass.

    Attributes:
        values: G and the slips of the z wheels that stick, shape (3 + 2 z, 1).
        state: their slopes in the state, (3 + 2 z, 3 + 2 z).
        centre: their slopes in c, (3 + 2 z, 2).
    """

    values: arb_mat
    state: arb_mat
    centre: arb_mat

    def twist_slope(self) -> arb_mat:
        """The slope of the spatial twist in c, (3, 2).

        Raises:
            ZeroDivisionError: where the slopes may be singular.
        """
        moved = self.state.inv() * self.centre * arb(-1)
        return arb_mat([[moved[r, k] for k in range(2)] for r in range(3)])


class BallMotion:
    """The motion of a body on a set of wheels, of which some are loaded, and some of these stick."""

    def __init__(
        self, wheels: Sequence[Wheel], loaded: Sequence[bool], stuck: Sequence[bool], rule: SmoothRule
    ) -> None:
        """Elastic loads, total weight 1, with a guess of which wheels they press, and which stick.

        Raises:
            UndecidedMotionError: where the loaded wheels may stand on one line.
        """
        self._wheels = [BallWheel.of(wheel, rule.friction_set(wheel.friction)) for wheel in wheels]
        self._loaded = tuple(loaded)
        holding = zip(self._wheels, loaded, stuck, strict=True)
        self._stuck = [pressed and sticks and not wheel.is_idle for wheel, pressed, sticks in holding]
        self.forces = 2 * sum(self._stuck)
        stiffness = arb_mat(3, 3)
        for wheel, pressed in zip(self._wheels, self._loaded, strict=True):
            if pressed:
                stiffness += wheel.moment * wheel.moment.transpose()
        try:
            inverse = stiffness.inv()
        except ZeroDivisionError:
            raise UndecidedMotionError("loaded wheels on one line") from None
        self._forms = [inverse * wheel.moment for wheel in self._wheels]

    def require_certain(self, centre: arb_mat, forces: arb_mat) -> None:
        """Refuse guesses that are not certain: then loads are affine around, and what sticks goes on sticking.

        Raises:
            UndecidedMotionError: where a loaded wheel may be free, a free one pressed, or one that sticks may slip.
        """
        point = _with_one(centre)
        for form, pressed in zip(self._forms, self._loaded, strict=True):
            spring = (form.transpose() * point)[0, 0]
            if not (spring > 0 if pressed else spring < 0):
                raise UndecidedMotionError("loads that change their form")
        sticking = [wheel for wheel, stuck in zip(self._wheels, self._stuck, strict=True) if stuck]
        for k, wheel in enumerate(sticking):
            if not wheel.limits.holds_strictly(forces[2 * k, 0], forces[2 * k + 1, 0]):
                raise UndecidedMotionError("a wheel that sticks at its limit")

    def pull(self, twist: arb_mat, forces: arb_mat, centre: arb_mat) -> Pull:
        """The equations at a twist (3, 1), forces (2 z, 1) of the wheels that stick, and a centre of mass (2, 1).

        Raises:
            UndecidedMotionError: where another wheel may stick.
        """
        point, size = _with_one(centre), 3 + self.forces
        values, state, slope = arb_mat(size, 1), arb_mat(size, size), arb_mat(size, 2)
        row = 3
        for wheel, form, pressed, stuck in zip(self._wheels, self._forms, self._loaded, self._stuck, strict=True):
            if not pressed or wheel.is_idle:
                continue
            load = (form.transpose() * point)[0, 0]
            if stuck:
                force = arb_mat([[forces[row - 3, 0]], [forces[row - 2, 0]]])
                way, rows = wheel.grip * force, wheel.row.transpose()
                _add(values, row, 0, rows * twist - wheel.speed)
                _add(state, row, 0, rows)
                _add(state, 0, row, wheel.grip * load)
                row += 2
            else:
                gradient, bend = wheel.force(twist)
                way = wheel.row * gradient
                _add(state, 0, 0, (wheel.row * bend * wheel.row.transpose()) * load)
            _add(values, 0, 0, way * load)
            _add(slope, 0, 0, way * arb_mat([[form[1, 0], form[2, 0]]]))
        return Pull(values, state, slope)


def _add(matrix: arb_mat, row: int, column: int, block: arb_mat) -> None:
    """Add a block to a part of a matrix, in place."""
    for r in range(block.nrows()):
        for k in range(block.ncols()):
            matrix[row + r, column + k] = matrix[row + r, column + k] + block[r, k]


def _with_one(centre: arb_mat) -> arb_mat:
    """``(1, c)``."""
    return arb_mat([[arb(1)], [centre[0, 0]], [centre[1, 0]]])
