"""Where bodies rest in the checked square, exactly, in the coordinates of the array."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.cells.equilibria import find_equilibria
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.contact_rule import CellRule, rule_of
from nonsmooth.proofs.judged_equilibria import JudgedEquilibrium, judge_equilibria
from nonsmooth.proofs.theorem4 import SEARCH_UNITS
from nonsmooth.reports.workbench.shapes import point
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.reports.interface.array import Array


def equilibria_record(array: Array) -> dict[str, Any]:
    """Every equilibrium as points (one, the ends of a segment, or the corners of an area) with its verdicts.

    ``searched`` is false where there was no search: under a rule without cells, and where it would take too long.
    """
    if not isinstance(rule_of(array.scene), CellRule):
        return {"searched": False, "equilibria": []}
    try:
        partition = array.partition
        scene = partition.scene
        with work_limit(scene.field, SEARCH_UNITS):
            judged = judge_equilibria(scene, find_equilibria(partition))
    except (WorkLimitError, RefusalError):
        return {"searched": False, "equilibria": []}
    return {"searched": True, "equilibria": [_record(equilibrium) for equilibrium in judged]}


def _record(equilibrium: JudgedEquilibrium) -> dict[str, Any]:
    found = equilibrium.found
    return {
        "place": str(found.place),
        "points": [point(vertex) for vertex in found.points],
        "translation": None if equilibrium.translation is None else str(equilibrium.translation),
        "rotation": None if equilibrium.rotation is None else str(equilibrium.rotation),
    }
