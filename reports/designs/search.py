"""The search for a design: all wheels alike, then differential evolution over exact scenes, then around the best.

Brent's line search, differential evolution (Storn and Price 1997) and Nelder and Mead's simplex (1965) are SciPy's.
Every candidate is an exact scene whose answers are proved, so what is found needs no confirmation; that nothing better
exists is not shown.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.answers.answer import Answer, Pose, Position
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.inertia import inertia_answer
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.robust.decide import certified_factor
from nonsmooth.proofs.theorem4 import Check, check_theorem4
from nonsmooth.reports.designs.freedom import Freedom
from nonsmooth.symbolic.files.scene_file import build_scene
from nonsmooth.symbolic.mechanics.contact_set import TipsError, standing
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

# ---- what is wanted ------------------------------------------------------------------------------
#
# What a design is judged by: the exact answers to a check of it.


HEADINGS = 36  # in a full turn, as of ``simulate --headings 36``
UNITS = 3_000_000  # of exact arithmetic for one candidate: a few seconds
UNMET = 1e6  # what a requirement that is not met costs
OPEN = 0.5  # of that, where the answer is undecided


@dataclass(frozen=True)
class Evaluation:
    """One candidate.

    Attributes:
        answers: position, heading and pose; empty where the scene is refused.
        unmet: names of requirements that do not hold.
        value: of the objective, larger is better; None where the requirements are not met, or it is not known.
        cost: what the search makes small.
        why_not: why the scene is refused, else empty.
        is_refuted: whether it is proved that the requirements are not met.
    """

    answers: tuple[Answer, ...]
    unmet: tuple[str, ...]
    value: float | None
    cost: float
    why_not: str = ""
    is_refuted: bool = False


Objective = Callable[[Check, Sequence[Answer]], float | None]


def _rate(check: Check, answers: Sequence[Answer]) -> float | None:
    """How fast a body comes home: length per time where it arrives, else the exponential rate (1/time).

    Where it comes near, at least the part of its way that is certified over the time that it takes.
    """
    position = answers[0].numbers
    if answers[0].verdict is Position.COMES_NEAR:
        return float((position["within"] - position["ends_within"]) / position["after"])
    seconds = position.get("seconds_per_distance")
    if seconds is not None:
        return 1 / float(seconds)
    rate = position.get("rate")
    return None if rate is None else float(rate)


def rate_unit(position: Answer) -> str:
    """The unit of how fast a body comes home: rates of arrival and exponential ones cannot be compared."""
    arrives = position.verdict is Position.COMES_NEAR or position.numbers.get("seconds_per_distance") is not None
    return "length per time" if arrives else "1/time"


def _held_rate(check: Check, answers: Sequence[Answer]) -> float | None:
    """Kappa: how fast feedback holds the pose, per unit of gain."""
    rate = answers[2].numbers.get("rate")
    return None if rate is None else float(rate)


def _margin(check: Check, answers: Sequence[Answer]) -> float | None:
    """The part of the distance to the point by which feedback may misjudge the position."""
    error = answers[2].numbers.get("position_error")
    return None if error is None else float(error)


def _basin(check: Check, answers: Sequence[Answer]) -> float | None:
    """Radius of the disc of starts that come home or near."""
    within = answers[0].numbers.get("within")
    return None if within is None or answers[0].exit_status else float(within)


def _tolerance(check: Check, answers: Sequence[Answer]) -> float | None:
    """The multiple of the scene's tolerances that is certified."""
    factor = certified_factor(check.scene)
    return float(factor) if factor else None


def _settling(check: Check, answers: Sequence[Answer]) -> float | None:
    """One over the time after which bodies with inertia keep within the accuracy of where they end (1/time): simulated.

    It is that of the ring of starts of a check, half the half-width of the checked square away.
    """
    found = inertia_answer(check.scene)
    after = None if found is None else found.numbers.get("settles_after")
    return 1 / float(after) if after else None


def _returning(check: Check, answers: Sequence[Answer]) -> float | None:
    """The widest arc of headings, in degrees, from which bodies at the checked point return to one of them: sampled."""
    from nonsmooth.reports.simulations.heading_maps import from_headings

    x, y = check.scene.check.place
    arcs = from_headings(check.scene, (x, y), HEADINGS).returning
    return max((math.degrees(arc.last - arc.first) for arc in arcs), default=0.0)


OBJECTIVES: dict[str, Objective] = {
    "rate": _rate,
    "gain": _held_rate,
    "margin": _margin,
    "basin": _basin,
    "tolerance": _tolerance,
    "settling": _settling,
    "heading": _returning,
}


def evaluate(scene: Scene, required: Sequence[str], objective: Objective) -> Evaluation:
    """Check a candidate and judge it."""
    try:
        with work_limit(scene.field, UNITS):
            check = check_theorem4(standing(scene))
            answers = answers_of(check)
    except TipsError as error:
        return Evaluation((), tuple(required), None, UNMET * (len(required) + 1), str(error), is_refuted=True)
    except (RefusalError, SceneError, WorkLimitError) as error:
        return Evaluation((), tuple(required), None, UNMET * (len(required) + 1), str(error))
    bad = [answer for answer in answers if answer.name in required and answer.exit_status]
    if bad:
        cost = sum(UNMET * (OPEN if answer.exit_status == 3 else 1) for answer in bad)
        unmet, refuted = tuple(answer.name for answer in bad), any(answer.exit_status == 1 for answer in bad)
        return Evaluation(answers, unmet, None, cost + _distance(check, answers), is_refuted=refuted)
    value = objective(check, answers)
    return Evaluation(answers, (), value, 0.0 if value is None else -value)


def _distance(check: Check, answers: Sequence[Answer]) -> float:
    """What guides the search where requirements are not met: how far V is from falling, and how fast the body turns."""
    rate, turns = getattr(check.results["translation"], "worst_rate", None), answers[1].numbers.get("largest_rate")
    falling = 1.0 if rate is None else 0.5 + math.atan(float(rate)) / math.pi
    return falling + (1.0 if turns is None else math.atan(float(turns)) / math.pi)


# ---- the search ----------------------------------------------------------------------------------


MEMBERS = 24  # of a generation, about
ALIKE = 0.25  # share of the checks in which all wheels change alike
LINE = 6  # checks along each line of them
WIDE = 0.6  # share of the checks before those around the best
STEP = 0.06  # of a range: where the search around the best begins

Told: TypeAlias = Callable[[int, int], None]  # candidates checked, and allowed


class SpentError(Exception):
    """All checks that are allowed are done."""


@dataclass(frozen=True)
class DesignGoal:
    """What is asked for.

    Attributes:
        required: names of the answers that must be good.
        maximize: name of the objective.
        checks: how many candidates are checked at most.
        seed: of the search.
    """

    required: tuple[str, ...]
    maximize: str
    checks: int = 300
    seed: int = 1


@dataclass(frozen=True)
class SmallestChoice:
    """What is known of the smallest choice of wheels.

    Attributes:
        count: of the wheels of the choice that was found; None where there is none.
        undecided: how many choices that were passed over are not refuted.
        all_checked: whether every smaller choice was checked.
        order: of the turns that every choice keeps.
    """

    count: int | None
    undecided: int
    all_checked: bool
    order: int


@dataclass(frozen=True)
class Design:
    """What was found.

    Attributes:
        document: the scene of the best candidate.
        scene: the same, read.
        best: its answers.
        base: those of the given scene.
        checks: how many candidates were checked.
        impossible: why no choice of the free values can meet the requirements; empty where that is not known.
        fewest: what is known of smaller choices, where wheels were chosen.
    """

    document: Record
    scene: Scene
    best: Evaluation
    base: Evaluation
    checks: int
    impossible: str = ""
    fewest: SmallestChoice | None = None

    @property
    def is_found(self) -> bool:
        """Whether every requirement is met."""
        return not self.best.unmet


class _Search:
    """The candidates of one search: each is built and judged once, however often the search comes back to it."""

    def __init__(self, base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, wish: DesignGoal) -> None:
        self._base, self._folder, self._scene, self._freedom, self._wish = base, folder, scene, freedom, wish
        self._known: dict[str, Evaluation] = {}
        self.best: tuple[Evaluation, Record, Scene] | None = None

    @property
    def checks(self) -> int:
        """How many were checked."""
        return len(self._known)

    def cost(self, vector: Sequence[float], told: Told) -> float:
        """What the search makes small, of the candidate that a vector names."""
        document = self._freedom.document(self._base, self._scene, vector)
        key = repr(document["wheel"])
        if key not in self._known:
            self._known[key] = self._judged(document)
            told(self.checks, self._wish.checks)
        return self._known[key].cost

    def _judged(self, document: Record) -> Evaluation:
        name = str(document.get("name") or self._scene.name)
        try:
            scene = build_scene(document, name, self._folder / f"{name}.toml")
        except SceneError as error:
            return Evaluation((), self._wish.required, None, float("inf"), str(error))
        found = evaluate(scene, self._wish.required, OBJECTIVES[self._wish.maximize])
        if self.best is None or found.cost < self.best[0].cost:
            self.best = found, document, scene
        return found


def find_design(
    base: Mapping[str, Any], folder: Path, scene: Scene, freedom: Freedom, wish: DesignGoal, told: Told
) -> Design:
    """Search for a design.

    Args:
        base: the document of the given scene.
        folder: where its files lie.
        scene: the same, read.
        freedom: what may change.
        wish: what is asked for.
        told: called with the candidates checked and allowed.
    """
    given = evaluate(scene, wish.required, OBJECTIVES[wish.maximize])
    impossible = _why_impossible(given, freedom, wish)
    search = _Search(base, folder, scene, freedom, wish)
    if not impossible:
        _evolve(search, scene, freedom, wish, told)
    if search.best is None or given.cost <= search.best[0].cost:  # nothing better than the scene itself
        return Design(dict(base), scene, given, given, search.checks, impossible)
    best, document, found = search.best
    return Design(document, found, best, given, search.checks)


def _why_impossible(given: Evaluation, freedom: Freedom, wish: DesignGoal) -> str:
    """What is proved of the given scene whatever the speeds are: which twists its wheels can impose."""
    if "pose" not in wish.required or freedom.kinds != ("speeds",) or not given.answers:
        return ""
    pose = given.answers[2]
    return pose.sentence if pose.verdict is Pose.CANNOT_BE_HELD else ""


def _evolve(search: _Search, scene: Scene, freedom: Freedom, wish: DesignGoal, told: Told) -> None:
    """Let costs fall: all wheels alike, then far and wide, then around the best, until all checks are done."""
    from scipy.optimize import differential_evolution, minimize, minimize_scalar

    tried = _SearchHistory(search, told, np.array(freedom.start(scene)))
    bounds = [(0.0, 1.0)] * len(tried.best)
    with suppress(SpentError):
        tried.limit = round(ALIKE * wish.checks)
        for direction in map(np.array, freedom.together(scene)):
            line = (tried.best, direction)
            minimize_scalar(
                tried.cost_along, args=line, bounds=(-1.0, 1.0), method="bounded", options={"maxiter": LINE}
            )
    with suppress(SpentError):
        tried.limit = round(WIDE * wish.checks)
        differential_evolution(
            tried.cost,
            bounds,
            x0=tried.best,
            popsize=max(1, round(MEMBERS / len(bounds))),
            maxiter=wish.checks,
            seed=wish.seed,
            init="sobol",
            polish=False,
            tol=0.0,
        )
    with suppress(SpentError):
        tried.limit = wish.checks
        corners = tried.best + STEP * np.where(tried.best > 0.5, -1.0, 1.0) * np.eye(len(bounds))
        simplex = np.vstack([tried.best, corners])
        minimize(tried.cost, tried.best, method="Nelder-Mead", bounds=bounds, options={"initial_simplex": simplex})


class _SearchHistory:
    """The costs of a search with the best vector so far, up to a limit of checks."""

    def __init__(self, search: _Search, told: Told, start: Floats) -> None:
        self._search, self._told = search, told
        self.limit, self._least, self.best = 0, math.inf, start

    def cost(self, vector: Floats) -> float:
        if self._search.checks >= self.limit:
            raise SpentError
        found = self._search.cost(vector.tolist(), self._told)
        if found < self._least:
            self._least, self.best = found, np.array(vector)
        return found

    def cost_along(self, step: float, start: Floats, direction: Floats) -> float:
        """That of a vector on a line, as far as the bounds let it lie there."""
        return self.cost(np.clip(start + step * direction, 0.0, 1.0))
