"""Newton's method on a turn: a start x and a time T with ``phi_T(x) = x``.

``(M - 1) dx + f dT = -(phi_T(x) - x)`` with the monodromy matrix M, and ``f . dx = 0`` to fix the phase (Seydel 2010,
"Practical Bifurcation and Stability Analysis", ch. 7).  A surface that is held where the turn begins stays held.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.orbits.orbit import Orbit
from nonsmooth.analysis.orbits.orbit_error import OrbitError
from nonsmooth.analysis.orbits.variation import monodromy
from nonsmooth.analysis.trajectories.face_motion import largest
from nonsmooth.analysis.trajectories.legs import Leg
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.analysis.trajectories.smooth_path import follow_legs, onto

STEPS = 12  # of Newton's method; five are usual
CLOSED = 1e-9  # relative to the size of the states: a turn that closes no better is none
CLOSE = 1e-12  # and one that closes so well is not improved: the integrator errs as much
TRUST = 0.5  # of the orbit's extent and of its period: a longer step leaves what the derivative describes
SMALLEST = 1e-6  # relative to the size of the states: a smaller orbit is an equilibrium


@dataclass(frozen=True)
class SupposedPeriod:
    """A path over one supposed period.

    Attributes:
        path: the path.
        legs: its legs.
        gap: ``phi_T(x) - x``.
    """

    path: Trajectory
    legs: tuple[Leg, ...]
    gap: Vector

    @property
    def extent(self) -> float:
        """Largest side of the box around it."""
        return float(np.ptp(self.path.array, axis=0).max())


def shoot(field: SignField, x: Vector, period: float) -> Orbit:
    """The periodic orbit beside a turn that nearly closes.

    Args:
        field: the field.
        x: start, inside a leg.
        period: time of the turn, nearly.

    Raises:
        OrbitError: where Newton's method finds none, or the turn has no derivative.
        TrajectoryError: where a path cannot be followed.
    """
    turn = _turn(field, x, period)
    for _ in range(STEPS):
        if largest(turn.gap) <= CLOSE * field.size:
            break
        following = _improved(field, turn)
        if largest(following.gap) >= largest(turn.gap):
            break
        turn = following
    if turn.extent <= SMALLEST * field.size:
        raise OrbitError("the path comes to an equilibrium, not to a periodic orbit")
    if largest(turn.gap) > CLOSED * max(field.size, turn.extent):
        raise OrbitError(f"Newton's method leaves a gap of {largest(turn.gap):.3g} after one turn")
    return Orbit(field, turn.path, turn.legs, largest(turn.gap))


def _turn(field: SignField, x: Vector, period: float) -> SupposedPeriod:
    path, legs = follow_legs(field, tuple(x.tolist()), period)
    if not legs or legs[-1].end < period or sum(leg.end - leg.start for leg in legs) < period * (1 - CLOSED):
        raise OrbitError("the path ends within a turn, or its switches accumulate")
    return SupposedPeriod(path, legs, legs[-1].last - legs[0].first)


def _improved(field: SignField, turn: SupposedPeriod) -> SupposedPeriod:
    """After one step of Newton's method, cut to where its derivative can be trusted."""
    first = turn.legs[0]
    x, along = first.first, turn.legs[-1].motion(turn.legs[-1].end, turn.legs[-1].last)
    count, derivative = len(x), monodromy(field, turn.legs)
    system = np.zeros((count + 1, count + 1))
    system[:count, :count] = derivative - np.eye(count)
    system[:count, count] = along
    system[count, :count] = first.motion(0.0, x)
    move = np.linalg.lstsq(system, np.append(-turn.gap, 0.0), rcond=None)[0]
    lasted = float(turn.legs[-1].end)
    longer = float(move[count]) / lasted  # where an equilibrium is near, turns last ever longer
    wider = largest(move[:count]) / max(turn.extent, SMALLEST * field.size)
    share = min(1.0, TRUST / max(abs(longer), wider, TRUST))
    period = lasted * (1 + share * longer)
    start = onto(x + share * move[:count], first.motion.face.keep, field.size)
    return _turn(field, start, period)
