"""Balanced twists: the motions that some speeds of the wheels impose under a rule without cells.

A twist xi minimizes D at c* for some speeds iff friction forces ``(rho_i, tau_i)``, in units of the half-axes of the
friction sets, balance there ::

    sum_i N_i (rho_i alpha_i a_i + tau_i beta_i b_i) = 0,     a_i = [d_i; d_i . J p_i],  b_i = [n_i; n_i . J p_i]

where a wheel with side slip ``b_i . xi != 0`` carries a force on that side of the border of its set (the speed of its
rim chooses which; module ``wheel_forces``), at -1 < t < 1, and one without any force in the set.  If the forces of the
wheels that stick are inside their sets, no other is at a corner, and three of the derivatives of the balance by t, rho
and tau are independent, then xi is the only minimizer: D grows along every direction that moves a sticking wheel, or
turns the slip of another.  (At a corner, where rollers turn and the rim slips, it need not: a force there stays one
when the slip turns.)  A minimizer that is unique depends continuously on c, so near c* the same speeds impose a motion
near xi.

Floats propose the forces.  An interval Newton step in balls, in three of the unknowns with independent derivatives,
proves that forces exist beside the proposal.  That there are none is proved by directions in which all admissible
forces add up to less than nothing (module ``exclusion``); then there are none near c* either.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from typing import TypeVar

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.minimizers.friction_search import RimDemand, search_forces
from nonsmooth.analysis.minimizers.many_forces import MANY, search_many_forces
from nonsmooth.proofs.clauses.feedback.exclusion import Exclusion, excludes, search_exclusion
from nonsmooth.proofs.clauses.feedback.wheel_forces import (
    PRECISION,
    WheelForces,
    ball_of,
    rounded,
    wheel_forces,
)
from nonsmooth.symbolic.constraints import Triple, inner, roll_row, side_row
from nonsmooth.symbolic.scene import Scene

Real = TypeVar("Real")

_RADIUS = arb(0, 2.0**-40)  # of the box in which forces are proved: far above the rounding of floats, far below room


@dataclass(frozen=True)
class BalancedTwist:
    """A twist with a proposal of forces, or a proof that there are none.

    Attributes:
        twist: xi.
        wheels: the loaded wheels.
        values: t of each wheel that slips across; rho, tau of each that does not; wheel by wheel.
        pivots: numbers of the three values that the Newton step solves for.
        exclusion: why there are no forces, where that is proved.
    """

    twist: Triple
    wheels: tuple[WheelForces, ...]
    values: tuple[Fraction, ...] = ()
    pivots: tuple[int, int, int] = (0, 0, 0)
    exclusion: Exclusion | None = None

    @cached_property
    def is_unique(self) -> bool:
        """Whether it is proved to be the only minimizer at c* for some speeds."""
        return bool(self.values) and self._is_enclosed()

    @cached_property
    def is_excluded(self) -> bool:
        """Whether it is proved to be no minimizer at c*, for any speeds."""
        return self.exclusion is not None and excludes(self.exclusion, self.wheels)

    @property
    def slip_ratios(self) -> dict[int, float]:
        """Slip along over slip across the rim, of each wheel that slips across, by its number."""
        return {wheel.index: wheel.slip_ratio(part[0]) for wheel, part in self._parts(self.values) if wheel.side}

    def _is_enclosed(self) -> bool:
        """Whether balls around the values hold forces in balance within their limits (interval Newton)."""
        with ctx.workprec(PRECISION):
            centre = [ball_of(value) for value in self.values]
            box = [x + _RADIUS if k in self.pivots else x for k, x in enumerate(centre)]
            rest = arb_mat([[entry] for entry in self._force(centre)])
            slopes = self.slopes(box)
            try:
                step = arb_mat([[slopes[k][r] for k in self.pivots] for r in range(3)]).solve(rest)
            except ZeroDivisionError:
                return False
            inside = all(_RADIUS.contains_interior(step[row, 0]) for row in range(3))
            return inside and self._is_admissible(box)

    def _parts(self, values: Sequence[Real]) -> Iterator[tuple[WheelForces, list[Real]]]:
        remaining = list(values)
        for wheel in self.wheels:
            count = 1 if wheel.side else 2
            yield wheel, remaining[:count]
            del remaining[:count]

    def _force(self, values: Sequence[arb]) -> list[arb]:
        total = [arb(0), arb(0), arb(0)]
        for wheel, part in self._parts(values):
            rho, tau = wheel.on_border(part[0]) if wheel.side else part
            for r, (a, b) in enumerate(zip(*wheel.balls, strict=True)):
                total[r] += rho * a + tau * b
        return total

    def slopes(self, values: Sequence[arb]) -> list[list[arb]]:
        """Derivative of the balance by each value."""
        columns: list[list[arb]] = []
        for wheel, part in self._parts(values):
            along, across = wheel.balls
            if wheel.side:
                rho, tau = wheel.border_slope(part[0])
                columns.append([rho * a + tau * b for a, b in zip(along, across, strict=True)])
            else:
                columns += [list(along), list(across)]
        return columns

    def _is_admissible(self, values: Sequence[arb]) -> bool:
        """Whether all forces of sticking wheels are inside their sets, those of others off the corners."""
        return all(_admits(wheel, part) for wheel, part in self._parts(values))


def balance_twist(scene: Scene, region: LoadRegion, twist: Triple) -> BalancedTwist:
    """The twist with forces that balance, where floats find any."""
    wheels = wheel_forces(scene, region, twist)
    if sum(1 if wheel.side else 2 for wheel in wheels) < 3:
        return BalancedTwist(twist, wheels)  # too few forces to fix a motion
    along = np.array([[float(x) for x in wheel.along] for wheel in wheels])
    across = np.array([[float(x) for x in wheel.across] for wheel in wheels])
    search = search_forces if len(wheels) <= MANY else search_many_forces
    cuts = np.array([float(wheel.limits.cut) for wheel in wheels])
    forces = search(along, across, np.array([wheel.side for wheel in wheels]), cuts, _demand(scene, wheels, twist))
    if forces is None:
        return BalancedTwist(twist, wheels)
    angles, sticking = iter(forces.angles), iter(forces.sticking)
    values = [
        x for wheel in wheels for x in ([np.tan(np.pi / 4 - next(angles) / 2)] if wheel.side else list(next(sticking)))
    ]
    proposal = BalancedTwist(twist, wheels, tuple(rounded(x) for x in values))
    return replace(proposal, pivots=_best_pivots(proposal))


def _demand(scene: Scene, wheels: Sequence[WheelForces], twist: Triple) -> RimDemand:
    """What speeds the forces ask of the rims while the body moves with a twist."""
    carrying = [scene.wheels[scene.places[wheel.index]] for wheel in wheels]
    rolling = [float(inner(roll_row(wheel).unit_normal, twist)) for wheel in carrying]
    across = [abs(float(inner(side_row(wheel).unit_normal, twist))) for wheel in carrying]
    axes = [float(wheel.limits.across / wheel.limits.along) if wheel.grips_along else 0 for wheel in wheels]
    return RimDemand(np.array(rolling), np.array(across) * np.array(axes))


def _best_pivots(trial: BalancedTwist) -> tuple[int, int, int]:
    """Three values whose derivatives of the balance are well conditioned (pivoted QR)."""
    from scipy.linalg import qr

    slopes = trial.slopes([ball_of(value) for value in trial.values])
    _, _, order = qr(np.array([[float(x) for x in column] for column in slopes]).T, pivoting=True)
    first, second, third = (int(k) for k in order[:3])
    return first, second, third


def exclude_twist(trial: BalancedTwist) -> BalancedTwist:
    """The twist with a proof that no forces balance, where there is one."""
    return replace(trial, exclusion=search_exclusion(trial.wheels))


def _admits(wheel: WheelForces, part: Sequence[arb]) -> bool:
    if wheel.side:
        (t,) = part
        return bool(t * t < 1) and wheel.is_straight(t) is not None
    rho, tau = part
    return wheel.holds(rho, tau)
