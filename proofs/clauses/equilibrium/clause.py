"""Clause 1 of Theorem 4, an equilibrium at the checked point: on cells, without cells, and as the check asks it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import combinations
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation
from nonsmooth.proofs.clauses.at_point.every_load import EveryLoad, EveryLoadPoint, load_facts, witness_load
from nonsmooth.proofs.clauses.clause import CheckedArray, Clause
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Equilibrium, Fact, Quantity, Record, Theorem4
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text, place_text
from nonsmooth.symbolic.numbers.plane import Vector, cross, dot, separating_direction
from nonsmooth.symbolic.numbers.rounded import certain_sign

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.clause import JudgedEquilibrium


# ---- on cells ------------------------------------------------------------------------------------
#
# 0 in F(c*), by convex weights, or refuted by a direction in which every velocity points.
#
# At the equilibrium (the origin of the centred scene) the pose rate of a twist is its velocity v, so the question
# is whether the origin lies in the convex hull of finitely many plane vectors: an exact linear program.


@dataclass(frozen=True)
class EquilibriumResult:
    """Verdict with its evidence.

    Attributes:
        verdict: holds or fails; undecided where rounded numbers alone would say so.
        twists: the twists whose velocities span F at the point.
        weights: convex weights of the twists that give zero velocity (holds).
        separator: a direction with positive product against every velocity (fails).
        open: why it is undecided.
    """

    verdict: Equilibrium
    twists: tuple[Twist, ...]
    weights: dict[int, Number]
    separator: Vector | None
    open: str = ""

    @property
    def reason(self) -> str:
        """One sentence for people."""
        if self.open:
            return self.open
        if self.verdict is Equilibrium.HOLDS:
            return _at_rest(self.twists, len(self.weights))
        if len(self.twists) == 1:
            exact = f"({', '.join(map(brief_text, self.twists[0]))})"
            rounded = place_text(self.twists[0], 5)
            said = exact if exact == rounded else f"{exact} ~ {rounded}"
            return f"around it one constant twist drives the body: {said}"
        along = place_text(self.separator or (), 5)
        return f"all {len(self.twists)} velocities that meet there point into the half-plane along {along}"


def _at_rest(twists: tuple[Twist, ...], mixed: int) -> str:
    """Which of the velocities that meet at the point give zero."""
    if mixed > 1:
        return f"0 is a convex combination of {mixed} of the {len(twists)} velocities that meet there"
    if len(twists) > 1:
        return f"one of the {len(twists)} velocities that meet there is zero"
    return "the body turns about the point" if twists[0].omega else "the body is at rest in the cell about the point"


def decide_equilibrium(partition: Partition) -> EquilibriumResult:
    """Decide ``0 in F(0)`` for a centred partition."""
    zero = partition.scene.field.zero
    twists = filippov_twists(partition)
    velocities = [twist.velocity for twist in twists]
    before = zero.field.rounded_signs
    mixture = best_mixture(*mixtures_to_zero(velocities), [zero] * len(twists))
    certain = _certain_weights(velocities) if zero.field.rounded_signs > before else None
    if certain is not None:
        zero.field.rounded_signs = before
        return EquilibriumResult(Equilibrium.HOLDS, twists, certain, None)
    if mixture is not None:
        return EquilibriumResult(Equilibrium.HOLDS, twists, mixture.weights, None)
    separator = separating_direction(velocities)
    if separator is not None and zero.field.measured:
        for velocity in velocities:
            dot(separator, velocity).sign()  # counts where the rounded velocities alone point to one side
    return EquilibriumResult(Equilibrium.FAILS, twists, {}, separator)


def _certain_weights(velocities: Sequence[Vector]) -> dict[int, Number] | None:
    """Convex weights of the first three velocities whose triangle has zero inside, whatever rounding did to them."""
    for chosen in combinations(range(len(velocities)), 3):
        a, b, c = (velocities[k] for k in chosen)
        parts = cross(b, c), cross(c, a), cross(a, b)
        if abs(sum(certain_sign(part) for part in parts)) == len(parts):
            whole = parts[0] + parts[1] + parts[2]
            return {k: part / whole for k, part in zip(chosen, parts, strict=True)}
    return None


# ---- without cells: whether the body rests (or spins) at the point -------------------------------


@dataclass(frozen=True)
class EllipseEquilibrium:
    """Clause 1: whether the body rests (or spins) at the point."""

    point: EllipsePoint

    @property
    def rounding_distance(self) -> Fraction | None:
        """How far the place of rest is from the point at most, where only rounding tells them apart; else None."""
        return None if self.point.rest is None else self.point.rest.distance

    @property
    def verdict(self) -> Equilibrium:
        """Holds where the translation part of the exact minimizer vanishes: there, or beside it within rounding."""
        return self.point.equilibrium

    @property
    def reason(self) -> str:
        """One sentence for people."""
        twist = self.point.twist
        if self.point.situation is Situation.OPEN and twist is not None:
            return f"the twist (0, 0, {brief_text(twist.omega)}) minimizes D"
        return self.point.summary


# ---- loads that are unknown ----------------------------------------------------------------------


@dataclass(frozen=True)
class EveryLoadEquilibrium:
    """Clause 1: the same motion rests, or turns, at the point whatever the load; or a load drives the body away."""

    point: EveryLoadPoint

    @property
    def verdict(self) -> Equilibrium:
        """Holds where it holds under every load, fails where it fails under one."""
        return self.point.equilibrium

    @property
    def reason(self) -> str:
        """One sentence for people."""
        point = self.point
        plain = point.situation in (EveryLoad.OPEN, EveryLoad.MOVED)
        said = point.reason if plain else f"{point.situation}: {point.reason}"
        return f"{said} ({point.loads.remark})" if point.loads.remark else said


# ---- as the check asks it ------------------------------------------------------------------------


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
