"""Clause 1 of Theorem 4 as the check asks it, and what it says."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.proofs.clauses.clause import CheckedArray, Clause
from nonsmooth.proofs.clauses.equilibrium.at_point import EllipseEquilibrium, EveryLoadEquilibrium
from nonsmooth.proofs.clauses.equilibrium.on_cells import EquilibriumResult, decide_equilibrium
from nonsmooth.proofs.clauses.every_load.facts import load_facts, witness_load
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings.facts import Fact, Quantity, Record
from nonsmooth.proofs.findings.verdicts import Equilibrium, Theorem4

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.clause import JudgedEquilibrium

AnyEquilibrium: TypeAlias = EquilibriumResult | EllipseEquilibrium | EveryLoadEquilibrium

MOST_LISTED = 6  # equilibria that are named by place


class EquilibriumClause(Clause[AnyEquilibrium]):
    """Whether ``0`` belongs to the translation part of the Filippov set at the point."""

    name = "equilibrium"

    def decide(self, work: Workspace) -> AnyEquilibrium:
        """By convex weights of the velocities that meet there, or by the exact minimizer."""
        if work.leaves_loads_open:
            return EveryLoadEquilibrium(work.every_load)
        return EllipseEquilibrium(work.point) if work.partition is None else decide_equilibrium(work.partition)

    def undecided(self, result: AnyEquilibrium, reason: str) -> AnyEquilibrium:
        """Neither an equilibrium nor none."""
        if isinstance(result, EquilibriumResult):
            return EquilibriumResult(Equilibrium.UNDECIDED, (), {}, None, reason)
        if isinstance(result, EllipseEquilibrium):
            return EllipseEquilibrium(result.point.undecided(reason))
        return EveryLoadEquilibrium(result.point.undecided(reason))

    def settles(self, result: AnyEquilibrium) -> tuple[Theorem4, str] | None:
        """Without an equilibrium nothing is said of its stability."""
        if result.verdict is Equilibrium.FAILS:
            return Theorem4.HYPOTHESES_NOT_MET, f"the point is no equilibrium: {result.reason}"
        if result.verdict is Equilibrium.UNDECIDED:
            return Theorem4.UNDECIDED, f"equilibrium, undecided: {result.reason}"
        return None

    def proviso(self, result: AnyEquilibrium) -> str:
        """That it is an equilibrium within rounding."""
        beside = isinstance(result, EllipseEquilibrium) and result.rounding_distance is not None
        return "about a place of rest that only rounding tells from the point" if beside else ""

    def facts(self, result: AnyEquilibrium, check: CheckedArray) -> Iterator[Fact]:
        """Where, and the other equilibria of the square."""
        yield Fact("at", Quantity(check.scene.check.equilibrium))
        if isinstance(result, EllipseEquilibrium) and result.rounding_distance is not None:
            yield Fact("rounding_distance", Quantity(result.rounding_distance))
        yield from load_facts(check.scene)
        if isinstance(result, EveryLoadEquilibrium):
            yield witness_load(result.point.witness)
        others = check.other_equilibria
        if others is None:
            yield Fact("others")
            return
        words, shown = _listed(others)
        yield Fact(
            "others", [_record(other) for other in others], f"other equilibria in the square: {words}", shown, True
        )


def _listed(others: tuple[JudgedEquilibrium, ...]) -> tuple[str, tuple[object, ...]]:
    """The first few by place, with their verdicts: words with a ``{}`` for each coordinate, and the coordinates."""
    if not others:
        return "none", ()
    words: list[str] = []
    for other in others[:MOST_LISTED]:
        places = ", ".join("({}, {})" for _ in other.found.points)
        verdict = "" if other.translation is None else f" ({other.translation})"
        words.append(f"{other.found.place} at {places}{verdict}")
    if len(others) > MOST_LISTED:
        words.append(f"and {len(others) - MOST_LISTED} more")
    points = [point for other in others[:MOST_LISTED] for point in other.found.points]
    return "; ".join(words), tuple(entry for point in points for entry in point)


def _record(other: JudgedEquilibrium) -> Record:
    return {
        "place": str(other.found.place),
        "points": Quantity(other.found.points),
        "cells": list(other.found.cells),
        "translation": None if other.translation is None else str(other.translation),
        "rotation": None if other.rotation is None else str(other.rotation),
    }
