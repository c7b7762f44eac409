"""Twists at the corners of D under rule ``box``, in floats: what balances a push.  No proof rests on them.

``D - G . xi`` is convex and linear in pieces, so that where it has a least value one is at a corner, a twist that
satisfies three independent rows.  Which twists are corners depends neither on the loads nor on the push G.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.inequalities.float_programs import solve_program
from nonsmooth.proofs.robust.array_rows import ArrayRows

Floats: TypeAlias = NDArray[np.float64]

MAX_WHEELS = 30  # 34,220 triples of rows
REGULAR = 2.0**-30  # volume of three unit rows below which they count as dependent
SATISFIED = 2.0**-30  # of the fastest wheel's speed: a smaller slip is rounding
LARGEST_SHARE = 0.999  # largest share of a limit that is proposed for a row that is satisfied


@dataclass(frozen=True)
class Proposal:
    """Friction forces that balance a push at one place of the body.

    Attributes:
        shares: of each row's limit; ``+-1`` where it slips (2n).
        satisfied: rows that are satisfied (2n).
        response: how these shares change with the force that is missing, zero elsewhere (2n, 3).
    """

    shares: Floats
    satisfied: NDArray[np.bool_]
    response: Floats


class BoxCorners(ArrayRows):
    """The rows of a centred scene and the corners of its D."""

    @cached_property
    def twists(self) -> Floats:
        """All corners, (m, 3), with ``length omega`` last."""
        able = np.flatnonzero(self.friction > 0)
        triples = np.array(list(combinations(able, 3)))
        matrices, right = self.rows[triples], self.speeds[triples]
        sizes = np.linalg.norm(matrices, axis=2).prod(axis=1)
        regular = np.abs(np.linalg.det(matrices)) > REGULAR * sizes
        return np.linalg.solve(matrices[regular], right[regular][..., None])[..., 0]

    @cached_property
    def _slips(self) -> Floats:
        return np.abs(self.twists @ self.rows.T - self.speeds)

    def least(self, place: Sequence[float], push: Floats) -> tuple[Floats, float]:
        """The corner at which ``D - push . xi`` is least, and that value."""
        values = self._slips @ self.limits(place) - self.twists @ push
        best = int(np.argmin(values))
        return self.twists[best], float(values[best])

    def dissipation(self, place: Sequence[float], twist: Floats) -> float:
        """D."""
        return float(np.abs(self.rows @ twist - self.speeds) @ self.limits(place))

    def proposal(self, place: Sequence[float], push: Floats, twist: Floats) -> Proposal | None:
        """Forces that balance a push while the body moves with a twist at which ``D - push . xi`` is least."""
        limits, slips = self.limits(place), self.rows @ twist - self.speeds
        satisfied = (np.abs(slips) <= SATISFIED * (self.fastest or 1.0)) & (self.friction > 0)
        if (limits[satisfied] <= 0).any():
            return None
        shares = np.where(satisfied | (self.friction <= 0), 0.0, np.sign(slips))
        missing = push - self.rows.T @ (limits * shares)
        columns = self.rows[satisfied] * limits[satisfied][:, None]
        square = columns.T @ columns
        if np.linalg.matrix_rank(square) < 3:
            return None
        response = np.zeros((len(limits), 3))
        response[satisfied] = columns @ np.linalg.inv(square)
        shares[satisfied] = _within(columns, missing, response[satisfied] @ missing)
        return Proposal(shares, satisfied, response) if np.abs(shares[satisfied]).max() < LARGEST_SHARE else None


def _within(columns: Floats, missing: Floats, shares: Floats) -> Floats:
    """Shares of least square, or where one is too large those whose largest is least, by a linear program."""
    if np.abs(shares).max() < LARGEST_SHARE or len(shares) == 3:
        return shares
    count = len(shares)
    ones = np.ones((count, 1))
    found = solve_program(
        np.r_[np.zeros(count), 1.0],
        A_ub=np.block([[np.eye(count), -ones], [-np.eye(count), -ones]]),
        b_ub=np.zeros(2 * count),
        A_eq=np.column_stack([columns.T, np.zeros(3)]),
        b_eq=missing,
        bounds=[(None, None)] * count + [(0, None)],
    )
    return np.asarray(found.x)[:count] if found.success else shares
