"""Answers that floats guess from the cells of an array, shown as guesses until the exact ones have come.

At the checked point ``c*`` every cell has the velocity ``v* = v + omega J c*``, and along it ``|c - c*|^2/2`` changes
at the rate ``(c - c*) . v*``, linear in c (the turning part of c' is normal to ``c - c*``).  So the largest rate of a
cell is that of a corner.  What is not clear beyond rounding is not guessed.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.proofs.answers.answer import Heading, Position
from nonsmooth.symbolic.plane import around, cross, dot, minus

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition

XY: TypeAlias = tuple[float, float]

CLEAR = 1e-9  # of the speeds and lengths at hand: what rounding makes of zero is well below
MOST_MEMBERS = 12  # motions that meet at the point, of which all triples are tried
TONES = {Position.COMES_HOME: "good", Position.STAYS_NEAR: "fair", Heading.KEEPS: "good", Heading.DRIFTS: "fair"}


def guessed_answers(partition: Partition) -> list[dict[str, Any]]:
    """Position and heading, as far as floats tell; each marked as provisional."""
    point = tuple(float(value) for value in partition.scene.check.equilibrium)
    radius = float(partition.scene.check.radius)
    velocities, rates, turns = [], [], []
    for cell in partition.cells:
        away = [(float(x) - point[0], float(y) - point[1]) for x, y in cell.polygon.vertices]
        far = [corner for corner in away if math.hypot(*corner) > CLEAR * radius]
        for twist in cell.twists:
            vx, vy, omega = (float(value) for value in twist)
            velocity = (vx - omega * point[1], vy + omega * point[0])
            rates.append(max(dot(corner, velocity) / math.hypot(*corner) for corner in far))
            if _holds(away, radius):
                velocities.append(velocity)
                turns.append(omega)
    return _answers(velocities, turns, max(rates))


def _holds(away: Sequence[XY], radius: float) -> bool:
    """Whether a counterclockwise polygon holds the origin, its border included."""
    for corner, following in around(away):
        along = minus(following, corner)
        if -cross(along, corner) < -CLEAR * radius * math.hypot(*along):
            return False
    return True


def _answers(velocities: Sequence[XY], turns: Sequence[float], worst: float) -> list[dict[str, Any]]:
    scale = max((math.hypot(*velocity) for velocity in velocities), default=0.0)
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
    clear = max(map(abs, drift)) > CLEAR * max(1.0, *map(abs, turns))
    guesses.append(("heading", Heading.DRIFTS if clear else Heading.KEEPS))
    return [_record(key, verdict) for key, verdict in guesses]


def _turns_at_rest(velocities: Sequence[XY], turns: Sequence[float], scale: float) -> list[float]:
    """Rates of rotation of mixtures of up to three motions whose velocities cancel; none away from an equilibrium."""
    motions = [((x / scale, y / scale), turn) for (x, y), turn in zip(velocities, turns, strict=True)]
    found = [turn for velocity, turn in motions if math.hypot(*velocity) <= CLEAR]
    for (a, turn), (b, other) in combinations(motions, 2):
        apart = math.hypot(*minus(a, b))
        if apart > CLEAR and abs(cross(a, b)) <= CLEAR * apart and dot(a, b) <= 0:  # the line through both meets zero
            share = dot(minus(a, b), a) / apart**2
            found.append(turn + share * (other - turn))
    for three in combinations(motions, 3):
        (a, *_), (b, *_), (c, *_) = three
        weights = cross(b, c), cross(c, a), cross(a, b)
        total = sum(weights)
        if abs(total) > CLEAR and all(weight / total >= -CLEAR for weight in weights):
            found.append(sum(weight * turn for weight, (_, turn) in zip(weights, three, strict=True)) / total)
    return found


def _record(key: str, verdict: Position | Heading) -> dict[str, Any]:
    return {"key": key, "answer": str(verdict), "tone": TONES[verdict], "provisional": True}
