"""Certificates of systems in one state: a function V of the displacement, on the intervals between switchings.

The point attracts with ``V = (x/a)^2`` left and ``(x/b)^2`` right of it, below the level 1 on ``(-a, b)``; it is
stable with ``V = x^2``; a solution leaves it where V falls and is negative, or along one field that leads away.  The
signs of the fields beside the point say which of these to write, and the checker shows it.  All is about the
displacement from the point, or about that of the signed root where the state has one.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.cells import System, pattern
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.proofs.kernel.cells import StatedCells, sharpened, stated_cells
from nonsmooth.proofs.kernel.search import Search, stability_hypotheses
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.systems.findings import DecidedSystem
from nonsmooth.proofs.systems.scalar_stability import clear_distance, within
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Theorem: TypeAlias = tuple[str, dict[str, Any]]  # its name, and its hypotheses


def scalar_theorem(result: DecidedSystem, system: System) -> Theorem:
    """The theorem that shows a verdict in one state, with its hypotheses.

    Args:
        result: of a check, not undecided.
        system: of the certificate.

    Raises:
        NoCertificateError: for a solution that leaves where right-hand sides only enclose the field.
        BeyondReachError: for too many surfaces or cells, and for numbers that are too large or too small.
    """
    (name,), scene = system.coordinates, result.scene
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE:
        return _attraction(result, system)
    radius = within(clear_distance(scene))
    stated = _cells(scene, system, radius)
    if result.verdict is Translation.STABLE:
        return "lyapunov", stability_hypotheses(stated.record, f"{name}**2", STABLE)
    if result.equilibrium is Equilibrium.FAILS:  # all velocities at the point have one sign
        upward = result.deciding.proofs.right.values[0].sign() > 0
        return "departure", {"cells": stated.record, "direction": ["1" if upward else "-1"]}
    return _leaving(result, name, stated, radius)


def _cells(scene: SwitchedSystem, system: System, radius: Fraction) -> StatedCells:
    """The cells of an interval about the point, which the point parts."""
    stated = stated_cells(scene, scene.field(radius), scene.coordinates(), irrational=True)
    return sharpened(stated, system, Search())


def _attraction(result: DecidedSystem, system: System) -> Theorem:
    """``V < 1`` exactly on the interval of starts that reach the point."""
    (name,) = system.coordinates
    sides = result.deciding.proofs
    right, left = (within(side.reach) for side in (sides.right, sides.left) if side.reach is not None)
    function = f"relu({name})**2/({right**2}) + relu(-{name})**2/({left**2})"
    if left == right:
        function = f"{name}**2/({right**2})"
    cells = _cells(result.scene, system, max(left, right)).record
    return "lyapunov", {**stability_hypotheses(cells, function, ASYMPTOTICALLY_STABLE), "level": "1", "below": True}


def _leaving(result: DecidedSystem, name: str, stated: StatedCells, radius: Fraction) -> Theorem:
    """Every solution that starts on one side leaves, or one solution does.

    Where all fields of each side have one sign, V is the distance on a side where they lead back, and minus it where
    they lead away: that holds for all that several right-hand sides may enclose.  Else one of them is followed.
    """
    cells, sides = stated.record, result.deciding.proofs
    left, right = sides.left.outward, sides.right.outward
    turn, outward = (1, right) if max(right) > 0 else (-1, left)
    if abs(sum(left)) == len(left) and abs(sum(right)) == len(right):
        function = f"-{name}" if sum(left) < sum(right) else name if sum(left) > sum(right) else f"-Abs({name})"
        return "instability", {"cells": cells, "function": function, "second": None, "direction": [str(turn)]}
    if result.scene.only_encloses:
        raise NoCertificateError("one solution of fields that are only enclosed says nothing of the stated one")
    signs = pattern(surface((turn * radius / 2,)).sign() for surface in stated.surfaces)
    field = [signs, outward.index(max(outward)), "1", [str(turn)]]
    start = {"within": str(radius), "surfaces": cells["surfaces"], "signs": signs, "direction": [str(turn)]}
    rising = name if turn > 0 else f"-{name}"
    return "escape", {**start, "along": [], "mixture": [field], "barriers": [], "function": rising}
