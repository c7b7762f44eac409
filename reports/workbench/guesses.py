"""Answers that floats guess from the cells of an array, shown as guesses until the exact ones have come.

At the checked point ``c*`` every cell has the velocity ``v* = v + omega J c*``, and along it ``|c - c*|^2/2`` changes
at the rate ``(c - c*) . v*``, linear in c (the turning part of c' is normal to ``c - c*``).  So the largest rate of a
cell is that of a corner.  What is not clear beyond rounding is not guessed.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.proofs.answers.answer import Heading, Position

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition

Floats: TypeAlias = NDArray[np.float64]

CLEAR = 1e-9  # of the speeds and lengths at hand: what rounding makes of zero is well below
MOST_MEMBERS = 12  # motions that meet at the point, of which all triples are tried
TONES = {Position.COMES_HOME: "good", Position.STAYS_NEAR: "fair", Heading.KEEPS: "good", Heading.DRIFTS: "fair"}


def guessed_answers(partition: Partition) -> list[dict[str, Any]]:
    """Position and heading, as far as floats tell; each marked as provisional."""
    point = np.array([float(value) for value in partition.scene.check.equilibrium])
    radius = float(partition.scene.check.radius)
    velocities, rates, turns = [], [], []
    for cell in partition.cells:
        away = np.array([[float(x), float(y)] for x, y in cell.polygon.vertices]) - point
        distance = np.hypot(*away.T)
        for twist in cell.twists:
            vx, vy, omega = (float(value) for value in twist)
            velocity = np.array([vx - omega * point[1], vy + omega * point[0]])
            far = distance > CLEAR * radius
            rates.append(float((away[far] @ velocity / distance[far]).max()))
            if _holds(away, radius):
                velocities.append(velocity)
                turns.append(omega)
    return _answers(np.array(velocities), np.array(turns), max(rates))


def _holds(away: Floats, radius: float) -> bool:
    """Whether a counterclockwise polygon holds the origin, its border included."""
    along = np.roll(away, -1, axis=0) - away
    left = along[:, 0] * -away[:, 1] - along[:, 1] * -away[:, 0]
    return bool((left >= -CLEAR * radius * np.hypot(*along.T)).all())


def _answers(velocities: Floats, turns: Floats, worst: float) -> list[dict[str, Any]]:
    scale = float(np.hypot(*velocities.T).max(initial=0.0)) if len(velocities) else 0.0
    if not scale or len(velocities) > MOST_MEMBERS:
        return []
    drift = _turns_at_rest(velocities, turns, scale)
    if not drift:
        return []
    guesses: list[tuple[str, Position | Heading]] = []
    if worst < -CLEAR * scale:
        guesses.append(("position", Position.COMES_HOME))
    elif worst <= CLEAR * scale:
        guesses.append(("position", Position.STAYS_NEAR))
    clear = max(map(abs, drift)) > CLEAR * max(1.0, float(np.abs(turns).max()))
    guesses.append(("heading", Heading.DRIFTS if clear else Heading.KEEPS))
    return [_record(key, verdict) for key, verdict in guesses]


def _turns_at_rest(velocities: Floats, turns: Floats, scale: float) -> list[float]:
    """Rates of rotation of mixtures of up to three motions whose velocities cancel; none away from an equilibrium."""
    found = [float(turn) for v, turn in zip(velocities, turns, strict=True) if np.hypot(*v) <= CLEAR * scale]
    for members in _mixtures(len(velocities)):
        chosen = list(members)
        system = np.vstack([velocities[chosen].T, np.full(len(chosen), scale)])
        weights, *_ = np.linalg.lstsq(system, np.array([0.0, 0.0, scale]), rcond=None)
        left = float(np.abs(system @ weights - [0.0, 0.0, scale]).max())
        if left <= CLEAR * scale and float(weights.min()) >= -CLEAR:
            found.append(float(weights @ turns[chosen]))
    return found


def _mixtures(count: int) -> Sequence[tuple[int, ...]]:
    return [*combinations(range(count), 2), *combinations(range(count), 3)]


def _record(key: str, verdict: Position | Heading) -> dict[str, Any]:
    return {"key": key, "answer": str(verdict), "tone": TONES[verdict], "provisional": True}
