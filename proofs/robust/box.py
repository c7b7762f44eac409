"""Rule ``box`` over a box of parameters: where every body stays at rest, and where every body comes nearer.

At rest no side row of any array slips, so that ``xi = 0`` is the only minimizer wherever forces within their limits,
those of the side rows not at them, balance those of the rims.  The places where they do are a convex set: corners
decide.

Outside a disc ``c . v <= -kappa |c|`` is shown on quadrangles, at their corners: |c| is convex, and the bound is a
mixture of those at the corners.  Then ``(c . c)' = 2 c . v`` as under rule ``nearest``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.proofs.boxes.balanced_forces import LoadBox, load_box
from nonsmooth.proofs.boxes.enclosures import UNIT
from nonsmooth.proofs.robust.level_sets import AnnulusPiece, Place, polygon_about
from nonsmooth.proofs.robust.plane_minimum import BoxCorners, Proposal
from nonsmooth.proofs.robust.rings import PRECISION, RingProof
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance, Wheel
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.plane import in_floats

# ---- one wheel of an array under rule ``box`` over a box of parameters ---------------------------
#
# Its slips, and the power of its forces.
#
# With the friction axis a, ``b = J a`` and the turn eta of the wheel within its tolerance, the slips of a twist are ::
#
#     s_R = cos(eta) a . v(p) + sin(eta) b . v(p) - u a . d,      s_S = cos(eta) b . v(p) - sin(eta) a . v(p) - u b . d.
#
# Each number of the wheel enters each formula once, so that balls lose little.


def half_widths(wheel: Wheel, box: Tolerance) -> list[arb]:
    """Of what is added to a wheel's x, y, angle, speed and the two frictions over a box."""
    step, speed = box.position.ball(), abs((wheel.speed * box.speed).ball())
    angle = rational_ball(box.heading) * arb.pi()
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
        turn = rational_ball(box.heading) * arb.pi() * UNIT
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
        fx, fy = roll * a - side * b, roll * b + side * a  # turned by eta, as the wheel is:
        turned = abs(self.cosine * fx - self.sine * fy) + abs(self.cosine * fy + self.sine * fx)
        spread = abs(omega) * self.step * turned * UNIT
        return self.cosine * (roll * along + side * across) + self.sine * (roll * across - side * along) + spread


def box_wheels(scene: Scene, box: Tolerance) -> list[BoxWheel]:
    """All wheels of a centred scene."""
    return [BoxWheel.of(wheel, box) for wheel in scene.wheels]


# ---- A bound of the motion under rule ``box``, for every array of a box of parameters at once ----
#
# Let the forces y be within their limits ``|y_k| <= mu_k N_k`` and balance a push: ``sum_k y_k row_k = G``.  With the
# slips s of any one twist ``xi^``, and every minimizer xi of D::
#
#     G . (xi - xi^) <= gap = sum_k (mu_k N_k |s_k| - y_k s_k),
#
# since ``D(xi) >= sum_k y_k s_k(xi) = G . (xi - xi^) + sum_k y_k s_k`` (Fenchel's inequality), and ``D(xi) <= D(xi^)``.
# Pushed along c with ``G = (lambda c, 0)`` that is a bound of ``c . v``.
#
# Loads are affine in the place of the body.  So forces at the corners of a polygon, mixed, are forces at each of its
# points: with one ``xi^`` and one lambda the corners decide about the polygon.
#
# For an array of the box the shares of the rows that are satisfied are corrected until they balance exactly: three
# linear equations, whose solution is enclosed.


Balls: TypeAlias = Sequence[arb]

KINDS = 2  # rows of each wheel


class BoxBound:
    """All wheels of an array over a box."""

    def __init__(self, wheels: Sequence[BoxWheel], loads: LoadBox, length: float) -> None:
        """Moments of the proposals are measured in ``length``."""
        self._wheels, self._loads, self._length = wheels, loads, arb(length)
        self._basis = [(arb(1), arb(0), arb(0)), (arb(0), arb(1), arb(0)), (arb(0), arb(0), 1 / self._length)]
        self._moved = [[wheel.moved(twist) for twist in self._basis] for wheel in wheels]

    def gap(self, proposal: Proposal, place: Balls, push: Balls, twist: Balls) -> arb | None:
        """The gap of a twist with the body at a place; None where no balanced forces are shown.

        Args:
            proposal: of forces at the middle of the box.
            place: c.
            push: G, by ``(v, omega)``.
            twist: ``xi^``.
        """
        loads = self._loads.at(place)
        if not all(load >= 0 for load in loads):
            return None
        shares = self._balanced(proposal, loads, push)
        return None if shares is None else self._gap(proposal, loads, shares, twist)

    def _balanced(self, proposal: Proposal, loads: Balls, push: Balls) -> dict[int, arb] | None:
        """Shares of the satisfied rows, of their limits at the middle of the box, for every array; else None."""
        forces = [self._forces(proposal, k) for k in range(len(self._wheels))]
        correction = self._correction(proposal, loads, forces, push)
        if correction is None:
            return None
        shares = {}
        for row in map(int, proposal.satisfied.nonzero()[0]):
            response = [arb(float(entry)) for entry in proposal.response[row]]
            first = self._unbalanced(loads, forces, push, self._twist(response))
            second = sum((response[k] * correction[k] for k in range(3)), arb(0))
            share = arb(float(proposal.shares[row])) - first - second
            if not abs(share) < self._wheels[row // KINDS].shares[row % KINDS]:
                return None
            shares[row] = share
        return shares

    def _correction(
        self, proposal: Proposal, loads: Balls, forces: Sequence[tuple[arb, arb]], push: Balls
    ) -> list[arb] | None:
        """``(M - 1) w`` with ``M w = -r``: M is what the responses give, r what is missing; None where singular."""
        matrix = [[arb(0)] * 3 for _ in range(3)]
        for row in map(int, proposal.satisfied.nonzero()[0]):
            wheel, kind = divmod(row, KINDS)
            limit = loads[wheel] * self._wheels[wheel].nominal[kind]
            for k in range(3):
                power = limit * self._moved[wheel][k][kind]
                for j in range(3):
                    matrix[k][j] += power * float(proposal.response[row, j])
        missing = [-self._unbalanced(loads, forces, push, twist) for twist in self._basis]
        try:
            solved = arb_mat(matrix).solve(arb_mat([[entry] for entry in missing]))
        except ZeroDivisionError:
            return None
        return [sum(((matrix[k][j] - int(j == k)) * solved[j, 0] for j in range(3)), arb(0)) for k in range(3)]

    def _forces(self, proposal: Proposal, k: int) -> tuple[arb, arb]:
        """Of wheel k along and across its axis, per unit of load: those of rows that slip over the box."""
        wheel, forces = self._wheels[k], []
        for kind in range(KINDS):
            row = KINDS * k + kind
            force = wheel.nominal[kind] * float(proposal.shares[row])
            forces.append(force if proposal.satisfied[row] else force * wheel.shares[kind])
        return forces[0], forces[1]

    def _unbalanced(self, loads: Balls, forces: Sequence[tuple[arb, arb]], push: Balls, twist: Balls) -> arb:
        """``(sum of the forces - G) . twist``."""
        total = -sum((a * b for a, b in zip(push, twist, strict=True)), arb(0))
        for wheel, load, force in zip(self._wheels, loads, forces, strict=True):
            total += load * wheel.power(force, twist)
        return total

    def _twist(self, coordinates: Balls) -> tuple[arb, arb, arb]:
        return coordinates[0], coordinates[1], coordinates[2] / self._length

    def _gap(self, proposal: Proposal, loads: Balls, shares: dict[int, arb], twist: Balls) -> arb:
        total = arb(0)
        for k, (wheel, load) in enumerate(zip(self._wheels, loads, strict=True)):
            for kind, slip in enumerate(wheel.slips(twist)):
                row, limit = KINDS * k + kind, load * wheel.nominal[kind]
                if row in shares:
                    total += limit * (wheel.shares[kind] * abs(slip) - shares[row] * slip)
                else:
                    against = (-float(proposal.shares[row]) * slip).upper()
                    if against > 0:
                        total += limit * wheel.shares[kind] * 2 * against
        return total


# ---- the verdict ---------------------------------------------------------------------------------


# of the friction of all wheels; strong ones serve large boxes
PUSHES = (0.75, 0.6, 0.45, 0.3, 0.2, 0.1, 0.05, 0.02)
REST_HALVINGS = 7


Plan: TypeAlias = tuple[tuple[float, float, float], list[float]]  # a twist, and strengths of pushes


class BoxRingProof(RingProof[BoxBound]):
    """A centred scene under rule ``box``; what floats propose for the scene is kept for all boxes about it."""

    def __init__(self, scene: Scene) -> None:
        """For a scene whose loads are known."""
        self._scene = scene
        self._corners = BoxCorners(scene)
        self._plans: dict[AnnulusPiece, Plan] = {}
        self._proposals: dict[tuple[AnnulusPiece, float], list[Proposal | None]] = {}

    # ---- rest

    def rest_radius(self, box: Tolerance, most: Fraction) -> Fraction:
        """Nearly the largest radius, up to ``most``, of a disc in which bodies stay at rest; 0 where there is none."""
        with ctx.workprec(PRECISION):
            bound = self.over(box)
            if bound is None:
                return Fraction(0)
            if self._rests(bound, most):
                return most
            low, high = Fraction(0), most
            for _ in range(REST_HALVINGS):
                middle = (low + high) / 2
                low, high = (middle, high) if self._rests(bound, middle) else (low, middle)
            return low

    def over(self, box: Tolerance) -> BoxBound | None:
        """The bounds of a box; None where its springs may not fix the loads."""
        loads = load_box(self._scene, box.position.ball())
        return None if loads is None else BoxBound(box_wheels(self._scene, box), loads, self._corners.length)

    def _rests(self, bound: BoxBound, radius: Fraction) -> bool:
        """Whether bodies rest all over a disc, by a polygon about it."""
        zero, still = np.zeros(3), [arb(0)] * 3
        for corner in polygon_about(radius):
            proposal = self._corners.proposal(in_floats(corner), zero, zero)
            gap = None if proposal is None else bound.gap(proposal, _balls(corner), still, still)
            if gap is None or not gap <= 0:
                return False
        return True

    # ---- coming nearer

    def rates(self, bound: BoxBound, pieces: Sequence[AnnulusPiece], *, at_any: bool) -> Iterator[arb | None]:
        """By the bounds at their corners, one after the other; the first push that proves a positive one, for both."""
        for piece in pieces:
            twist, strengths = self._plan(piece)
            rates = (self._proved(bound, piece, twist, strength) for strength in strengths)
            yield next((rate for rate in rates if rate is not None), None)

    def _proved(
        self, bound: BoxBound, piece: AnnulusPiece, twist: tuple[float, float, float], strength: float
    ) -> arb | None:
        """The rate that the bounds at the corners of a quadrangle prove; None where it is not positive."""
        key, xi, push, rates = (piece, strength), [arb(entry) for entry in twist], arb(strength), []
        if key not in self._proposals:
            self._proposals[key] = [self._proposal(in_floats(corner), strength) for corner in piece.corners]
        for corner, proposal in zip(piece.corners, self._proposals[key], strict=True):
            x, y = _balls(corner)
            gap = None if proposal is None else bound.gap(proposal, (x, y), [push * x, push * y, arb(0)], xi)
            if gap is None:
                return None
            rates.append(-((x * xi[0] + y * xi[1]) + gap / push) / (x * x + y * y).sqrt())
            if not rates[-1] > 0:
                return None
        return min(rates, key=rational_below)

    # ---- what floats propose

    def _plan(self, piece: AnnulusPiece) -> Plan:
        """The twist of the middle of a quadrangle, and the pushes that promise a negative rate."""
        if piece not in self._plans:
            corners = [in_floats(corner) for corner in piece.corners]
            middle = np.mean(corners, axis=0)
            twist, _ = self._corners.least(middle.tolist(), np.zeros(3))
            unit = float(self._corners.limits(middle.tolist()).sum()) / 2 / float(np.hypot(*middle))
            strengths = [share * unit for share in PUSHES]
            v_x, v_y, spin = twist.tolist()
            slow = [strength for strength in strengths if self._promise(corners, twist, strength) < 0]
            self._plans[piece] = (v_x, v_y, spin / self._corners.length), slow
        return self._plans[piece]

    def _promise(self, corners: list[tuple[float, float]], twist: np.ndarray, strength: float) -> float:
        """About the largest ``c . v/|c|`` that follows at the middle of the box."""
        rates = []
        for x, y in corners:
            _, value = self._corners.least((x, y), strength * np.array([x, y, 0.0]))
            rates.append((self._corners.dissipation((x, y), twist) - value) / strength / float(np.hypot(x, y)))
        return max(rates)

    def _proposal(self, place: tuple[float, float], strength: float) -> Proposal | None:
        push = strength * np.array([*place, 0.0])
        twist, _ = self._corners.least(place, push)
        return self._corners.proposal(place, push, twist)


def _balls(place: Place) -> list[arb]:
    return [rational_ball(entry) for entry in place]
