"""A bound of the motion under rule ``box``, for every array of a box of parameters at once.

Let the forces y be within their limits ``|y_k| <= mu_k N_k`` and balance a push: ``sum_k y_k row_k = G``.  With the
slips s of any one twist ``xi^``, and every minimizer xi of D::

    G . (xi - xi^) <= gap = sum_k (mu_k N_k |s_k| - y_k s_k),

since ``D(xi) >= sum_k y_k s_k(xi) = G . (xi - xi^) + sum_k y_k s_k`` (Fenchel's inequality), and ``D(xi) <= D(xi^)``.
Pushed along c with ``G = (lambda c, 0)`` that is a bound of ``c . v``.

Loads are affine in the place of the body.  So forces at the corners of a polygon, mixed, are forces at each of its
points: with one ``xi^`` and one lambda the corners decide about the polygon.

For an array of the box the shares of the rows that are satisfied are corrected until they balance exactly: three linear
equations, whose solution is enclosed.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from flint import arb, arb_mat

from nonsmooth.proofs.boxes.load_box import LoadBox
from nonsmooth.proofs.robust.box_corners import Proposal
from nonsmooth.proofs.robust.box_wheel import BoxWheel

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
        wheel, found = self._wheels[k], []
        for kind in range(KINDS):
            row = KINDS * k + kind
            force = wheel.nominal[kind] * float(proposal.shares[row])
            found.append(force if proposal.satisfied[row] else force * wheel.shares[kind])
        return found[0], found[1]

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
