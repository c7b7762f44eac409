"""What several files share: checks of built-in scenes, arrays under another rule, and what clauses say."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.theorem4 import CellCheck, check_cells, check_theorem4
from nonsmooth.symbolic.files.documents import builtin_systems
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number

# ---- Checks of built-in scenes that several files of tests read: each is made once in a process.


@cache
def checked(name: str, rule: str) -> CellCheck:
    """The check of a built-in scene under a rule with cells."""
    return check_cells(load_scene(name, rule=rule))


def whole_check(scene: Scene) -> CellCheck:
    """The check of an array under a rule with cells, nothing left out."""
    result = check_theorem4(scene, prune=False)
    assert isinstance(result, CellCheck)
    return result


@cache
def decided(name: str) -> StabilityResult:
    """What is decided of a built-in system."""
    return decide_system(load_system(name))


@cache
def planar_systems() -> tuple[str, ...]:
    """The names of the built-in systems in two states: what has cells, pictures and stress cases."""
    return tuple(name for name in builtin_systems() if len(load_system(name).states) == 2)


# ---- What the clauses of Theorem 4 say, in a form that tests compare -----------------------------


def verdicts(result: CellCheck) -> list[str]:
    """The conclusion and the verdicts of the four clauses."""
    clauses = (result, result.equilibrium, result.translation, result.rotation, result.feedback)
    return [clause.verdict.value for clause in clauses]


def drift(result: CellCheck) -> tuple[Number, ...]:
    """Both ends of the range of rotation rates at rest; empty where nothing rests."""
    return () if result.rotation.drift is None else result.rotation.drift.interval


# ---- An array under another contact rule ---------------------------------------------------------


def ruled(scene: Scene, rule: str) -> Scene:
    """The same array, loads and square."""
    return replace(scene, contact=replace(scene.contact, rule=rule))


def centred(scene: Scene, rule: str) -> Scene:
    """The same with the checked point for its origin."""
    return ruled(scene, rule).recentred()
