"""A theorem, strategies and a kind of evidence that the product does not have.

*Theorem* ``still``: where all fields vanish on a cube about the point, it is stable.  Its claims are that the square of
the speed is not above zero; each is shown by the evidence ``constant``, that its polynomial is a number.
"""

from __future__ import annotations

from typing import Any

from nonsmooth.proofs.checker.cells import Inclusion, System
from nonsmooth.proofs.checker.polynomials import constant
from nonsmooth.proofs.checker.positivity import Claim, Inequality, Proofs
from nonsmooth.proofs.checker.theorems import STABLE, Statement
from nonsmooth.proofs.checker.work import require, take
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel.cells import adjoining, started, stated_cells
from nonsmooth.proofs.kernel.search import Entry, Kind
from nonsmooth.proofs.many_states.decision import SpacePoint
from nonsmooth.proofs.systems.findings import Finding, Strategy
from nonsmooth.proofs.theorem_searches import TheoremSearch
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


def show_still(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The theorem."""
    (cells,) = take(hypotheses, "cells")
    inclusion = Inclusion(system, cells, [], proofs)
    for cell in inclusion.cells:
        for number, field in cell.fields:
            speed = constant(inclusion.count, 0)
            for part in field:
                speed += part * part
            name = f"still {''.join('-+'[s > 0] for s in cell.signs)} field {number}"
            proofs.show(Claim(name, (Inequality(-speed, {}),), strict=False))
    return [{"stability": STABLE}]


def find_still(system: SwitchedSystem, verdict: str) -> Entry:
    """The search for its hypotheses."""
    subject, search = started(system)
    return search.entry(subject, "still", {"cells": stated_cells(system, system.check.radius).record})


STILL = TheoremSearch("no motion", find_still, (STABLE,))


def decide_still(point: SpacePoint) -> Finding | None:
    """The strategy that decides: no field moves on any cell near the point."""
    moves = any(map(any, (field for cell in adjoining(point.cells) for field in cell.velocities)))
    return None if moves else Finding("no motion", Translation.STABLE, "nothing moves there")


NO_MOTION = Strategy("no motion", range(3, 9), __name__, "decide_still")


def show_by_constants(claim: Claim, evidence: Any) -> None:
    """The kind of evidence, as the checker shows a claim by it."""
    take(evidence, "constant")
    for own in claim.inequalities:
        least = own.value.at_origin
        require(
            not own.value.degree and (least > 0 or (not claim.strict and not least)), "numbers that are large enough"
        )


def find_constants(claim: Claim, work: int) -> dict[str, Any] | None:
    """The same kind, as the kernel finds it."""
    values = [own.value for own in claim.inequalities]
    shown = not any(own.degree for own in values) and all(own.at_origin >= int(claim.strict) for own in values)
    return {"constant": True} if shown else None


CONSTANTS = Kind(find_constants, lambda claim: -1)
