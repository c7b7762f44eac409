"""What is known of all places of rest together: the stability of each, and where therefore nothing else rests.

A solution that rests does not come to another place.  So nothing else rests where every start is certified to come to
one place: boxes in which the search could not tell are dropped there, and a second place that it found there would
contradict the theorem.
"""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from math import prod
from typing import Any

from flint import arb, fmpq

from nonsmooth.proofs.findings import Contradiction, ContradictionError, Translation
from nonsmooth.proofs.rest_places import EnclosedEquilibria, EnclosedEquilibrium, at_place, rest_places
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.findings import DecidedSystem
from nonsmooth.symbolic.formulas.trees import OPERATIONS, Interpretation
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.messages.under_way import part_of
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

LINEARIZED = "linearization"
ROUNDED_DOWN = 1 - 2.0**-50  # of a float that is rounded to the nearest one


def _ball(value: Fraction) -> arb:
    return arb(fmpq(value.numerator, value.denominator))


def _sign(value: arb) -> arb:
    return arb(0, 1) if value.contains(0) else value.sgn()


def _power(base: arb, exponent: int) -> arb:
    return prod([base] * exponent, start=arb(1))  # flint's own is no number where the base may be zero


FUNCTIONS: dict[str, Callable[..., Any]] = {"Abs": abs, "Max": arb.max, "Min": arb.min, "sgn": _sign, "sqrt": arb.sqrt}
BALLS = Interpretation(_ball, arb.pi(), FUNCTIONS, {**OPERATIONS, ast.Pow: _power, ast.USub: operator.neg})


@dataclass(frozen=True)
class DecidedPlace:
    """A place of rest with what a theorem says of it.

    Attributes:
        place: where it is.
        stability: of it.
        theorem: which decides; empty where none does.
        result: of a check at the place; None where the linearization decides.
    """

    place: EnclosedEquilibrium
    stability: Translation
    theorem: str
    result: DecidedSystem | None = None

    def attracts_all(self, box: Sequence[arb]) -> bool:
        """Whether every start in a box, in coordinates of the states, is certified to come to the place."""
        result = self.result
        if result is None or result.verdict is not Translation.ASYMPTOTICALLY_STABLE:
            return False
        region, function = result.reach.region, result.function
        if result.reach.everywhere or region is None or function is None:
            return result.reach.everywhere
        system = result.scene
        away = [x - c.ball() for x, c in zip(box, system.check.equilibrium, strict=True)]
        half = arb(float(region.radius)) * ROUNDED_DOWN
        if not all(bool(abs(x) < half) for x in away):
            return False
        value = BALLS.value(function.formula.tree, dict(zip(system.states, away, strict=True)))
        return bool(value < _ball(region.level))


def decided_places(system: SwitchedSystem) -> tuple[EnclosedEquilibria, tuple[DecidedPlace, ...]]:
    """All places of rest of the checked cube, and what each of them is, in the same order.

    Raises:
        SceneError: as :func:`.rest_places`.
        ContradictionError: where a place rests although it is certified to be left.
    """
    enclosed = rest_places(system)
    decided = []
    for number, place in enumerate(enclosed.places):
        with part_of(number, len(enclosed.places), "places"):
            decided.append(_decided(system, place))
    _refuse_contradiction(system, enclosed, decided)
    left = [box for box in enclosed.left if not any(place.attracts_all(box) for place in decided)]
    return replace(enclosed, left=tuple(left)), tuple(decided)


def _decided(system: SwitchedSystem, place: EnclosedEquilibrium) -> DecidedPlace:
    """By its linearization; where that says nothing by the theorems of a check, if its coordinates are exact."""
    if place.stability is not Translation.UNDECIDED:
        return DecidedPlace(place, place.stability, LINEARIZED)
    unknown = DecidedPlace(place, Translation.UNDECIDED, "")
    moved = at_place(system, place)
    if moved is None:
        return unknown
    try:
        result = decide_system(moved)
    except SceneError:
        return unknown
    return DecidedPlace(place, result.verdict, str(result.method), result)


def _refuse_contradiction(
    system: SwitchedSystem, enclosed: EnclosedEquilibria, decided: Sequence[DecidedPlace]
) -> None:
    """Refuse a place that rests, and the end of a segment, if every start there is certified to come to another one."""
    centre = [c.ball() for c in system.check.equilibrium]
    ends = [end for polytope in enclosed.stretches for end in polytope.corners]
    resting = [tuple(x.ball() + c for x, c in zip(end, centre, strict=True)) for end in ends]
    for attractor in decided:
        others = (other.place.place for other in decided if other is not attractor)
        for other in filter(attractor.attracts_all, (*others, *resting)):
            here, there = (place_text([float(x) for x in place]) for place in (attractor.place.place, other))
            certified = f"every start near {here}, as {there}, is certified to come to it"
            sides = certified, f"what starts at {there} may rest there"
            raise ContradictionError(system.name, Contradiction("region and place of rest", sides))
