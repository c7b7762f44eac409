"""Stability by a symmetry that reverses time, in two states: orbits near the point are closed.

Let R be a reflection, ``R R = 1`` and ``det R = -1``, with ``f(R z) = -R f(z)``; let switching surfaces be lines
through the point, and W a continuous function that is zero there and positive elsewhere.

*Theorem.*  If all fields turn about the point in one sense, ``z x f > 0`` or ``z x f < 0`` on closed cells off it, and

    |z|^2 |grad W . f| <= K |z x f| W,

then the point is stable, and near it all orbits are closed.  *Proof.*  The angle of a solution is strictly monotone,
so it crosses lines at single instants, and solutions are unique off the point.  ``|z x f|/|z|^2`` is the rate of the
angle: so ln W changes by at most K times the angle.  From small W a full turn stays in the square and off the point,
where the angle has a least rate, and so it is completed.  Between two crossings p and q of the line ``R z = z`` lies
a half turn z(t), 0 <= t <= T.  Then ``R z(T - t)`` is a solution too, from q to p, so it is the other half.

The bound is needed: with ``x' = -x y - y r^2, y' = -y^2 + x r^2`` all solutions turn, but some run into the point.

*Sines and cosines.*  Where the argument v of each has ``v(R z) = v(z)`` or ``v(R z) = -v(z)``, the stated field has the
symmetry if the polynomials at all ends have it, because the e of a wave is an even function of v (:mod:`.formulas`).
What is shown is true of the stated field, not of all that is enclosed.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import partial
from typing import Any, TypeAlias

from .cells import Inclusion, System, pattern, whole_domain
from .lyapunov import Lyapunov
from .polynomials import Polynomial, lie_derivative, variable
from .positivity import Claim, Inequality, Proofs
from .theorems import STABLE, Statement
from .work import items, rational, require, take

Matrix: TypeAlias = list[list[Fraction]]


def show_reversible(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The point is stable, by a reflection that reverses time; see the head of this file.

    Hypotheses: ``cells`` and ``function`` (those of theorem ``lyapunov``; the function is W), ``mirror`` (the rows of
    R) and ``factor`` (K, negative for fields that turn clockwise).
    """
    cells, function, mirror, factor = take(hypotheses, "cells function mirror factor")
    plain = system.count == len(system.states) == 2 and system.coordinates == system.states
    require(plain and len(system.rhs) == 1, "one right-hand side in two states, without roots")
    reflection, most = read_reflection(mirror), rational(factor)
    require(most, "a factor that is not zero")
    inclusion = Inclusion(system, cells, [function], proofs)
    lines = all(own.degree == 1 and own.is_form for own in inclusion.surfaces.listed)
    require(inclusion.domain.bounded and lines, "a square, and lines through the point")
    require_reversed(system, inclusion, reflection)
    positive = Lyapunov(inclusion, proofs)
    positive.show_zero()
    positive.show_positive()
    _show_turns(inclusion, most, proofs)
    return [{"stability": STABLE}]


def read_reflection(data: Any) -> Matrix:
    """The rows of a matrix that is its own inverse, and turns the plane over."""
    rows = [[rational(value) for value in items(row, 2)] for row in items(data, 2)]
    (a, b), (c, d) = rows
    require(a + d == 0 and a * a + b * c == 1, "a reflection")
    return rows


def require_reversed(system: System, inclusion: Inclusion, reflection: Matrix) -> None:
    """``f(R z) = -R f(z)`` on every cell, at all ends of sines and cosines."""
    mirrored = _applied(reflection, [variable(2, k) for k in range(2)])
    place = inclusion.domain.place
    straight = system.fields(place)
    turned = system.fields({name: own.on(mirrored, 2) for name, own in place.items()})
    for formula, other in zip(straight[0], turned[0], strict=True):
        for (_, v), (_, w) in zip(formula.arguments(), other.arguments(), strict=True):
            require(w in (v, -v), "sines and cosines of what the reflection keeps, up to its sign")
    for cell in inclusion.cells:
        sign_of = partial(inclusion.surfaces.sign_on, cell.signs)
        for field, beyond in zip(straight, turned, strict=True):
            there = [formula.on(sign_of) for formula in beyond]
            back = _applied(reflection, [formula.on(sign_of) for formula in field])
            require(not any(a + b for a, b in zip(there, back, strict=True)), "fields that the reflection reverses")


def _applied(matrix: Matrix, vector: Sequence[Polynomial]) -> list[Polynomial]:
    return [vector[0].times(a) + vector[1].times(b) for a, b in matrix]


def _show_turns(inclusion: Inclusion, factor: Fraction, proofs: Proofs) -> None:
    """All fields turn, and turning bounds how fast W changes."""
    x, y = variable(2, 0), variable(2, 1)
    space, sense = whole_domain(inclusion), 1 if factor > 0 else -1
    for cell in inclusion.cells:
        (function,) = cell.functions
        guards = space.guards(dict(enumerate(cell.signs))) or {}
        for number, field in cell.fields:
            turning = (x * field[1] - y * field[0]).times(sense)
            room = turning * function.times(abs(factor))
            change = (x * x + y * y) * lie_derivative(function, field)
            for name, value in (("turns", turning), ("rises", room - change), ("falls", room + change)):
                own = Inequality(value, guards, open=frozenset(guards))
                place = f"{name} {pattern(cell.signs)} field {number}"
                proofs.show(Claim(place, (own,), strict=name == "turns", bounded=True))
