"""Checks of built-in scenes that several files of tests read: each is made once in a process."""

from __future__ import annotations

from functools import cache

from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.symbolic.files.documents import builtin_systems
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.files.system_file import load_system


@cache
def checked(name: str, rule: str) -> CellCheck:
    """The check of a built-in scene under a rule with cells."""
    return check_cells(load_scene(name, rule=rule))


@cache
def decided(name: str) -> StabilityResult:
    """What is decided of a built-in system."""
    return decide_system(load_system(name))


@cache
def planar_systems() -> tuple[str, ...]:
    """The names of the built-in systems in two states: what has cells, pictures and stress cases."""
    return tuple(name for name in builtin_systems() if len(load_system(name).states) == 2)
