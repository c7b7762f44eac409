"""Which integrator a stretch of a smooth path takes: DOP853 while accuracy rules its step, Radau once stability does.

Where a motion decays fast towards a slow one (feedback of high gain), the step of an explicit method is held at the
border of its region of stability, however little happens: the number of steps grows with the gain.  So every
``PROBED`` steps the fastest decay is measured, ``rate = -min Re eig(df/dx)`` by forward differences.  If it holds the
step (``h rate >= HELD``; DOP853 is stable up to about 6) and many more such steps lie ahead, the rest of the stretch
is integrated by Radau IIA of order 5, which is implicit and damps at every step (Hairer & Wanner 1996, sec. IV.2 and
IV.8).  Oscillations without decay never count as stiff: an implicit method would not gain there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from nonsmooth.analysis.fields.switched_field import Vector, Velocity

PROBED = 50  # steps from one measurement to the next: four evaluations each, against 12 per step of DOP853
# Step times rate: what is stable is 6, but two may cost steps that the fast motion spoils; at 1e-12 accuracy alone
# keeps it well below.
HELD = 1.5
MANY = 500  # steps still to go at the present size: fewer are cheaper than an implicit method
DIFFERENCE = 1e-8  # step of the differences, relative to the states: half the digits, plenty for a rate
# Step of the differences for Radau, relative to the size of the states, however small a state is: SciPy's own shrinks
# with each state, and finds but rounding once one of them is zero and others are not.
JACOBIAN_STEP = 1e-11
EXPLICIT, IMPLICIT = "events", "events, implicit (Radau) where stiff"


def decay_rate(velocity: Velocity, t: float, x: Vector, size: float) -> float:
    """``-min Re eig(df/dx)``, 1/time; ``size`` is the unit of the states.

    Zero where nothing decays or the field is not finite beside the state.
    """
    return max(0.0, -float(_rates(velocity, t, x, DIFFERENCE * np.maximum(np.abs(x), DIFFERENCE * size)).min()))


def comes_to_rest(velocity: Velocity, solver: Any, until: float, size: float, atol: float) -> bool:
    """Whether what is left moves the state by less than the tolerance, and nothing beside it grows until the end.

    Below the tolerance the field is rounding, on which an implicit method would take tiny steps for ever.
    """
    left = until - float(solver.t)
    if float(np.abs(velocity(float(solver.t), solver.y)).max()) * left > atol:
        return False
    rates = _rates(velocity, float(solver.t), solver.y, np.full(len(solver.y), DIFFERENCE * size))
    return float(rates.max()) * left <= 1


def jacobian_of(velocity: Velocity, size: float) -> Callable[[float, Vector], Vector]:
    """``df/dx`` for an implicit solver, as a function of time and state."""

    def jacobian(t: float, x: Vector) -> Vector:
        return _differences(velocity, t, x, JACOBIAN_STEP * np.maximum(np.abs(x), size))

    return jacobian


def _rates(velocity: Velocity, t: float, x: Vector, steps: Vector) -> Vector:
    """Real parts of the eigenvalues of ``df/dx`` by forward differences; zeros where the field is not finite."""
    jacobian = _differences(velocity, t, x, steps)
    if not np.isfinite(jacobian).all():
        return np.zeros(len(x))
    return np.asarray(np.linalg.eigvals(jacobian).real)


def _differences(velocity: Velocity, t: float, x: Vector, steps: Vector) -> Vector:
    """``df/dx`` by forward differences."""
    here = velocity(t, x)
    with np.errstate(invalid="ignore", over="ignore"):
        return np.column_stack([(velocity(t, x + move) - here) / move[k] for k, move in enumerate(np.diag(steps))])


def holds_the_step(velocity: Velocity, solver: Any, until: float, size: float) -> bool:
    """Whether stability, not accuracy, rules the step of an explicit solver, with many steps to go."""
    step = float(solver.step_size)
    if until - solver.t <= MANY * step:
        return False
    return decay_rate(velocity, float(solver.t), solver.y, size) * step >= HELD
