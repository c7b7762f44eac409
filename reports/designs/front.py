"""The Pareto front of rate against tolerance: arrays of which none that was checked is better in both.

Three searches share their candidates: for the rate, for the multiple of the tolerances that is certified, and for their
product.  Both numbers of every candidate are proved; that the front cannot be passed is not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nonsmooth.proofs.answers.answer import Answer
from nonsmooth.proofs.theorem4_result import Check
from nonsmooth.reports.designs.candidates import Candidates, Told
from nonsmooth.reports.designs.freedom import Freedom
from nonsmooth.reports.designs.objective import OBJECTIVES, UNMET, evaluate
from nonsmooth.reports.designs.search import Wish, evolve
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import SceneError

WEIGHTS = (0.5, 1.0, 0.0)  # of the rate, against the tolerances


@dataclass(frozen=True)
class FrontPoint:
    """One array.

    Attributes:
        rate: how fast bodies come home.
        tolerance: the multiple of the tolerances that is certified.
        document: its scene.
    """

    rate: float
    tolerance: float
    document: dict[str, Any]

    def beats(self, other: FrontPoint) -> bool:
        """Whether it is no worse in both, and better in one."""
        pair, theirs = (self.rate, self.tolerance), (other.rate, other.tolerance)
        return pair != theirs and all(a >= b for a, b in zip(pair, theirs, strict=True))


@dataclass(frozen=True)
class Front:
    """What a search found.

    Attributes:
        points: of the front, by their rates.
        others: arrays that meet the requirements and are beaten.
        given: the given array, where it has both numbers.
        checks: how many arrays were checked.
    """

    points: tuple[FrontPoint, ...]
    others: tuple[FrontPoint, ...]
    given: FrontPoint | None
    checks: int


class _Candidates(Candidates[tuple[FrontPoint | None, float]]):
    """All candidates that were checked, and what each is worth."""

    def __init__(self, base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, wish: Wish) -> None:
        super().__init__(base, folder, scene, freedom, wish.checks)
        self._wish = wish
        self.weight = WEIGHTS[0]

    @property
    def points(self) -> list[FrontPoint]:
        """Of all that have both numbers."""
        return [point for point, _ in self._known.values() if point is not None]

    def cost(self, vector: Sequence[float], told: Told) -> float:
        """What the search makes small: less the weighted sum of both logarithms."""
        point, unmet = self.worth(vector, told)
        if point is None:
            return unmet
        return -(self.weight * math.log(point.rate) + (1 - self.weight) * math.log(point.tolerance))

    def _refused(self, error: SceneError) -> tuple[FrontPoint | None, float]:
        return None, float("inf")

    def _judge(self, scene: Scene, document: dict[str, Any]) -> tuple[FrontPoint | None, float]:
        return judged(scene, document, self._wish)


def judged(scene: Scene, document: dict[str, Any], wish: Wish) -> tuple[FrontPoint | None, float]:
    """Both numbers of an array; without them what it costs."""
    pair: list[float | None] = []

    def both(check: Check, answers: Sequence[Answer]) -> float | None:
        pair.extend(OBJECTIVES[name](check, answers) for name in ("rate", "tolerance"))
        return None

    found = evaluate(scene, wish.required, both)
    if found.unmet or len(pair) < 2 or not all(pair):
        return None, found.cost + UNMET / 4
    rate, tolerance = pair
    return (None, UNMET) if rate is None or tolerance is None else (FrontPoint(rate, tolerance, document), 0.0)


def find_front(base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, wish: Wish, told: Told) -> Front:
    """Search for the front; arguments as for :func:`nonsmooth.reports.designs.search.find_design`."""
    candidates = _Candidates(base, folder, scene, freedom, wish)
    for number, weight in enumerate(WEIGHTS, 1):
        candidates.weight = weight
        evolve(candidates, scene, freedom, wish, told, wish.checks * number // len(WEIGHTS) - candidates.checks)
    points = candidates.points
    best = [point for point in points if not any(other.beats(point) for other in points)]
    unique = {(point.rate, point.tolerance): point for point in best}
    given, _ = judged(scene, dict(base), wish)
    rest = tuple(point for point in points if point not in best)
    ordered = tuple(sorted(unique.values(), key=lambda point: point.rate))
    return Front(ordered, rest, given, candidates.checks)
