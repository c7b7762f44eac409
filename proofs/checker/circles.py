"""Stability of systems with sines and cosines, judged on circles, where these are exact.

An *angle* is a state that stands in the right-hand sides under sines and cosines alone.  With ``s = sin x`` and
``c = cos x - 1`` for every angle x, sines and cosines of sums of whole multiples of angles are polynomials in these
(de Moivre), and

    s' = (1 + c) x',    c' = -s x'.

*Theorem.*  Let all angles be 0 at the point, and V a function of the other states and of s and c of all angles, on a
cube about the point in all of these coordinates, that is positive off it and does not rise along solutions there, also
along those that lie on no circle ``s^2 + (1 + c)^2 = 1``.  Then the point is stable.  *Proof.*  The coordinates of a
solution are a solution in the coordinates: their velocities are a linear image of x', so a mixture of velocities
becomes that mixture, and the cells of the states lie in those of the coordinates, because no switching expression holds
an angle.  There the point is stable (:mod:`.lyapunov`).  So s and c of every angle stay as small as one likes, and the
angle near a multiple of a full turn; it starts near 0 and is continuous, so it stays near 0.

An undamped pendulum ``x' = y, y' = -sin x`` has ``V = y^2 + s^2 + c^2``, which is ``y^2 + 2 (1 - cos x)``, constant
along solutions.  Enclosures of a sine show no such thing.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from .cells import MAX_STATES, Inclusion, System
from .formulas import ANGULAR, WAVES, Formula, SignOf, WaveAt, no_sign
from .lyapunov import Lyapunov
from .polynomials import Polynomial, constant, variable
from .positivity import Proofs
from .theorems import STABLE, Statement
from .work import items, require, take

MOST_TURNS = 8  # of one angle in the argument of a sine


@dataclass(frozen=True)
class CircleSystem(System):
    """A system in sines and cosines of some of its states.

    Attributes:
        angles: those.
    """

    angles: tuple[str, ...] = ()

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The states, but ``sin_x`` and ``cos_x`` (which stands for ``cos x - 1``) in place of an angle x."""
        pairs = ((f"sin_{name}", f"cos_{name}") if name in self.angles else (name,) for name in self.states)
        return tuple(coordinate for pair in pairs for coordinate in pair)

    @property
    def count(self) -> int:
        """The number of coordinates."""
        return len(self.coordinates)

    @property
    def origin(self) -> tuple[Any, ...]:
        """The point in the coordinates."""
        at = dict(zip(self.states, self.at, strict=True))
        return tuple(at.get(coordinate, Fraction(0)) for coordinate in self.coordinates)

    def fields(self, place: Mapping[str, Polynomial], wave: WaveAt | None = None) -> Sequence[Sequence[Formula]]:
        """The formulas of the velocities of the coordinates."""
        require(wave is None, "exact sines and cosines on circles")
        fields = []
        for side in self.rhs:
            field: list[Formula] = []
            for name, text in zip(self.states, side, strict=True):
                if name in self.angles:
                    sine, cosine = place[f"sin_{name}"], place[f"cos_{name}"]
                    factors = [cosine + constant(cosine.count, 1), -sine]
                else:
                    factors = [constant(next(iter(place.values())).count, 1)]
                field += [CircleFormula(text, place, self.angles, factor) for factor in factors]
            fields.append(field)
        return fields


class CircleFormula(Formula):
    """A right-hand side in the coordinates, times a polynomial."""

    def __init__(self, data: Any, place: Mapping[str, Polynomial], angles: Sequence[str], factor: Polynomial) -> None:
        self.angles, self.factor = angles, factor
        super().__init__(data, place, None)

    def on(self, sign_of: SignOf) -> Polynomial:
        """The polynomial on a cell."""
        return super().on(sign_of) * self.factor

    def _value(self, node: ast.expr, sign_of: SignOf, depth: int) -> Polynomial:
        match node:
            case ast.Name(id=name):
                require(name not in circle_names(self.angles), "formulas in the states")
            case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in WAVES:
                require(name in ANGULAR, "no other functions than sines and cosines on circles")
                sine, cosine = self._turned(argument)
                return sine if name == "sin" else cosine
        return super()._value(node, sign_of, depth)

    def _turned(self, argument: ast.expr) -> tuple[Polynomial, Polynomial]:
        """The sine and the cosine of a sum of whole multiples of angles."""
        angles = {name: variable(len(self.angles), k) for k, name in enumerate(self.angles)}
        v = Formula(ast.unparse(argument), angles).on(no_sign)
        require(v.degree <= 1 and not v.at_origin, "sines and cosines of sums of multiples of angles")
        one = constant(self.count, 1)
        sine, cosine = constant(self.count, 0), one
        for k, name in enumerate(self.angles):
            turns = v.slope(k)
            require(turns == int(turns) and abs(turns) <= MOST_TURNS, "whole multiples of angles")
            s, across = self.states[f"sin_{name}"], self.states[f"cos_{name}"] + one
            s = s if turns > 0 else -s
            for _ in range(abs(int(turns))):
                sine, cosine = sine * across + cosine * s, cosine * across - sine * s
        return sine, cosine


def circle_names(angles: Sequence[str]) -> set[str]:
    """The names of the coordinates of angles."""
    return {f"{kind}_{name}" for name in angles for kind in ANGULAR}


def show_on_circles(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The point is stable, by a V in sines and cosines of angles; see the head of this file.

    Hypotheses: ``angles`` (states), ``cells`` and ``function`` (those of theorem ``lyapunov``, in the coordinates).
    """
    listed, cells, function = take(hypotheses, "angles cells function")
    angles = tuple(items(listed, most=system.count))
    known = all(type(name) is str and name in system.states for name in angles)
    require(angles and known and len(set(angles)) == len(angles), "angles that are different states")
    require(system.coordinates == system.states, "no roots beside angles")
    at = dict(zip(system.states, system.at, strict=True))
    require(not any(at[name] for name in angles), "angles that are 0 at the point")
    circle_system = CircleSystem(system.states, system.rhs, system.at, system.numbers, angles=angles)
    names = (*circle_system.coordinates, *system.numbers)
    require(circle_system.count <= MAX_STATES and len(set(names)) == len(names), "different names of few coordinates")
    stated = Lyapunov(Inclusion(circle_system, cells, [function], proofs), proofs)
    stated.show_zero()
    stated.show_positive()
    stated.show_falls("", stated.zero, strict=False)
    return [{"stability": STABLE}]
