"""Checks of built-in scenes that several files of tests read: each is made once in a process."""

from __future__ import annotations

from functools import cache

from nonsmooth.proofs.theorem4 import check_cells
from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.symbolic.files.scene_file import load_scene


@cache
def checked(name: str, rule: str) -> CellCheck:
    """The check of a built-in scene under a rule with cells."""
    return check_cells(load_scene(name, rule=rule))
