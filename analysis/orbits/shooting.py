"""Newton's method on a turn: a start x and a time T with ``phi_T(x) = x``.

``(M - 1) dx + f dT = -(phi_T(x) - x)`` with the monodromy matrix M, and ``f . dx = 0`` to fix the phase (Seydel 2010,
"Practical Bifurcation and Stability Analysis", ch. 7).  A surface that is held where the turn begins stays held.
"""

from __future__ import annotations

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.analysis.orbits.orbit import Orbit, follow_turn, newton_system
from nonsmooth.analysis.orbits.orbit_error import OrbitError
from nonsmooth.analysis.trajectories.face_motion import largest
from nonsmooth.analysis.trajectories.smooth_path import onto

STEPS = 12  # of Newton's method; five are usual
CLOSED = 1e-9  # relative to the size of the states: a turn that closes no better is none
CLOSE = 1e-12  # and one that closes so well is not improved: the integrator errs as much
TRUST = 0.5  # of the orbit's extent and of its period: a longer step leaves what the derivative describes
SMALLEST = 1e-6  # relative to the size of the states: a smaller orbit is an equilibrium


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
    turn = follow_turn(field, x, period)
    for _ in range(STEPS):
        if turn.gap <= CLOSE * field.size:
            break
        following = _improved(turn)
        if following.gap >= turn.gap:
            break
        turn = following
    if turn.extent <= SMALLEST * field.size:
        raise OrbitError("the path comes to an equilibrium, not to a periodic orbit")
    if turn.gap > CLOSED * max(field.size, turn.extent):
        raise OrbitError(f"Newton's method leaves a gap of {turn.gap:.3g} after one turn")
    return turn


def _improved(turn: Orbit) -> Orbit:
    """After one step of Newton's method, cut to where its derivative can be trusted."""
    x, smallest = turn.point, SMALLEST * turn.field.size
    system, speed = newton_system(turn)
    move = np.linalg.lstsq(system, np.append(x - turn.legs[-1].last, 0.0), rcond=None)[0]
    longer = float(move[-1]) / speed / turn.period  # where an equilibrium is near, turns last ever longer
    wider = largest(move[:-1]) / max(turn.extent, smallest)
    share = min(1.0, TRUST / max(abs(longer), wider, TRUST))
    start = onto(x + share * move[:-1], turn.legs[0].motion.face.keep, turn.field.size)
    return follow_turn(turn.field, start, turn.period * (1 + share * longer))
