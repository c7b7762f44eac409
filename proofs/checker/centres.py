"""Centres in two states: stability by orbits that close, because a reflection reverses time or an integral is kept.

*Turning.*  Let a, b > 0 be weights of x and y: a monomial ``x^i y^j`` has the weight ``a i + b j``, and the size of a
place is ``rho = (|x|^(2b) + |y|^(2a))^(1/(2ab))``.  On a cell let all terms of f_1 have at least the weight a + k,
and those of f_2 at least b + k, and let the part of weight a + b + k of

    a x f_2 - b y f_1

be positive on the closed cell off the point (or negative, on all cells).  There solutions turn: the angle on the
curve rho = 1 to which ``(r^a x, r^b y)`` leads from there grows at least like ``rho^k``, up to a factor, while ln rho
changes at most like ``rho^k``.  So ln rho changes by at most a constant times the angle.  Let switching surfaces be
lines through the point, axes where two weights are not equal: so cells hold their weighted rays.  Where solutions
cross axes the sizes in the cells on both sides are powers of each other, so *from near the point a full turn stays
near it, off the point, and is completed.*  Solutions cross lines at single instants, so off the point they are
unique.

Turning alone shows nothing: with ``x' = -x y - y r^2, y' = -y^2 + x r^2`` all solutions turn, but some run into the
point.  There the part of least weight is zero.

*A reflection* (theorem ``reversible``): ``R R = 1`` and ``det R = -1``, with ``f(R z) = -R f(z)``.  Between two
crossings p and q of the line ``R z = z`` lies a half turn z(t), 0 <= t <= T.  Then ``R z(T - t)`` is a solution too,
from q to p, so it is the other half: orbits near the point are closed, and the point is stable.

*An integral* (theorem ``integral``): let q_1, ..., q_m and g be continuous, polynomials on cells, with ``q_i != 0``
at the point, and on every cell

    div f + f . grad g + sum_i c_i (f . grad q_i)/q_i = 0.

Then ``M = exp(g) prod |q_i|^c_i`` is an integrating factor (Darboux 1878): ``div (M f) = 0``.  Let ``f . grad s`` be
the same on both sides of every line ``s = 0``.  Near the point M lies between positive numbers, so the flux of M f
through curves depends on their ends alone: a Lipschitz function V is zero at the point, with ``grad V = M (f_2,
-f_1)`` in cells.  Along a weighted ray its rate is M/r times ``a x f_2 - b y f_1``, which is positive near the point
(or negative).  So V (or -V) is positive off the point, and solutions keep it: its level sets are the orbits, closed
curves about the point.

*Sines and cosines.*  Fields are those of all ends of what these may be; where all turn, so do those between.  Where
the argument v of each has ``v(R z) = v(z)`` or ``v(R z) = -v(z)``, the stated field has the symmetry if the
polynomials at all ends have it, because the e of a wave is an even function of v (:mod:`.formulas`).  What is shown
is true of the stated field, not of all that is enclosed; so an integral is shown without sines and cosines only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from functools import partial
from itertools import combinations
from typing import Any, TypeAlias

from .cells import Cell, Inclusion, Matrix, System, applied, pattern, whole_domain
from .polynomials import Polynomial, constant, lie_derivative, variable
from .positivity import Claim, Inequality, Proofs
from .theorems import STABLE, Statement
from .work import items, rational, require, take

MOST_FACTORS = 8

Weights: TypeAlias = tuple[Fraction, Fraction]


def show_reversible(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The point is stable, by a reflection that reverses time; see the head of this file.

    Hypotheses: ``cells`` (those of theorem ``lyapunov``), ``mirror`` (the rows of R), ``weights`` (a and b for each
    cell, by its pattern) and ``sense`` (1 for fields that turn counterclockwise, -1 for others).
    """
    cells, mirror, weights, sense = take(hypotheses, "cells mirror weights sense")
    reflection = read_reflection(mirror)
    inclusion = _inclusion(system, cells, [], proofs)
    require_reversed(system, inclusion, reflection)
    show_turns(inclusion, weights, sense, proofs)
    return [{"stability": STABLE}]


def show_integral(system: System, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """The point is stable, as near it an integral of motion is kept; see the head of this file.

    Hypotheses: ``cells``, ``weights`` and ``sense`` as above, ``exponent`` (g), and ``factors`` (pairs of q_i and c_i).
    """
    cells, exponent, factors, weights, sense = take(hypotheses, "cells exponent factors weights sense")
    pairs = [items(pair, 2) for pair in items(factors, most=MOST_FACTORS)]
    powers = [rational(power) for _, power in pairs]
    inclusion = _inclusion(system, cells, [exponent, *(factor for factor, _ in pairs)], proofs)
    require(not any(system.waves[0]), "an integral without sines and cosines of states")
    for cell in inclusion.cells:
        require(all(factor.at_origin for factor in cell.functions[1:]), "factors that are not zero at the point")
        require(not excess(cell, powers), "an integrating factor")
    require_flux(inclusion)
    show_turns(inclusion, weights, sense, proofs)
    return [{"stability": STABLE}]


def _inclusion(system: System, cells: Any, functions: Sequence[Any], proofs: Proofs) -> Inclusion:
    plain = system.count == len(system.states) == 2 and system.coordinates == system.states
    require(plain and len(system.rhs) == 1, "one right-hand side in two states, without roots")
    inclusion = Inclusion(system, cells, functions, proofs)
    require(inclusion.domain.bounded, "a square")
    for j, s in enumerate(inclusion.surfaces.listed):
        beyond = all(s.at_origin * cell.signs[j] > 0 for cell in inclusion.cells)
        require(beyond or (s.degree == 1 and s.is_form), "lines through the point, and surfaces outside the square")
    return inclusion


# ---- turning ----------------------------------------------------------------------------------------


def show_turns(inclusion: Inclusion, weights: Any, sense: Any, proofs: Proofs) -> None:
    """All fields turn about the point in one sense, by their terms of least weight."""
    require(type(sense) is int and abs(sense) == 1, "a sense of 1 or -1")
    stated, space = read_weights(inclusion, weights), whole_domain(inclusion)
    for cell in inclusion.cells:
        guards = space.guards(dict(enumerate(cell.signs))) or {}
        for number, field in cell.fields:
            value = turning(field, stated[cell.signs]).times(sense)
            inequality = Inequality(value, guards, open=frozenset(guards))
            proofs.show(Claim(f"turns {pattern(cell.signs)} field {number}", (inequality,), strict=True, bounded=True))


def read_weights(inclusion: Inclusion, data: Any) -> Mapping[tuple[int, ...], Weights]:
    """The weights on every cell; equal ones unless all surfaces are axes."""
    names = [pattern(cell.signs) for cell in inclusion.cells]
    require(type(data) is dict and set(data) == set(names), "weights for each cell")
    pairs = [[rational(value) for value in items(data[name], 2)] for name in names]
    require(all(min(pair) > 0 for pair in pairs), "positive weights")
    axes = all(len(surface.terms) == 1 for surface in inclusion.surfaces.listed if not surface.at_origin)
    require(axes or all(a == b for a, b in pairs), "equal weights beside lines that are no axes")
    return {cell.signs: (a, b) for cell, (a, b) in zip(inclusion.cells, pairs, strict=True)}


def turning(field: Sequence[Polynomial], weights: Weights) -> Polynomial:
    """The part of ``a x f_2 - b y f_1`` of weight a + b + k; k is the least weight of f_1 less a, or of f_2 less b."""
    a, b = weights
    terms = [(a * i + b * j - weight) for weight, part in zip(weights, field, strict=True) for i, j in part.terms]
    whole = variable(2, 0, a) * field[1] - variable(2, 1, b) * field[0]
    least = a + b + min(terms, default=Fraction(0))
    return Polynomial(2, {(i, j): c for (i, j), c in whole.terms.items() if a * i + b * j == least})


# ---- a reflection -----------------------------------------------------------------------------------


def read_reflection(data: Any) -> Matrix:
    """The rows of a matrix that is its own inverse, and turns the plane over."""
    rows = [[rational(value) for value in items(row, 2)] for row in items(data, 2)]
    (a, b), (c, d) = rows
    require(a + d == 0 and a * a + b * c == 1, "a reflection")
    return rows


def require_reversed(system: System, inclusion: Inclusion, reflection: Matrix) -> None:
    """``f(R z) = -R f(z)`` on every cell, at all ends of sines and cosines."""
    mirrored = applied(reflection, [variable(2, k) for k in range(2)])
    place = inclusion.domain.place
    straight = system.fields(place)
    turned = system.fields({name: polynomial.on(mirrored, 2) for name, polynomial in place.items()})
    for formula, other in zip(straight[0], turned[0], strict=True):
        for (_, v), (_, w) in zip(formula.arguments(), other.arguments(), strict=True):
            require(w in (v, -v), "sines and cosines of what the reflection keeps, up to its sign")
    for cell in inclusion.cells:
        sign_of = partial(inclusion.surfaces.sign_on, cell.signs)
        for field, beyond in zip(straight, turned, strict=True):
            there = [formula.on(sign_of) for formula in beyond]
            back = applied(reflection, [formula.on(sign_of) for formula in field])
            require(not any(a + b for a, b in zip(there, back, strict=True)), "fields that the reflection reverses")


# ---- an integral ------------------------------------------------------------------------------------


def excess(cell: Cell, powers: Sequence[Fraction]) -> Polynomial:
    """``div (M f)/M`` on a cell, times all q_i; functions of the cell are g and the q_i."""
    ((_, field),), (exponent, *factors) = cell.fields, cell.functions
    value = field[0].derivative(0) + field[1].derivative(1) + lie_derivative(exponent, field)
    product = constant(2, 1)
    for factor, power in zip(factors, powers, strict=True):
        value = value * factor + lie_derivative(factor, field).times(power) * product
        product = product * factor
    return value


def require_flux(inclusion: Inclusion) -> None:
    """Through every line the flux is the same from both sides: cells that differ by the sign of one are compared."""
    for one, other in combinations(inclusion.cells, 2):
        between = [j for j, sign in enumerate(one.signs) if sign != other.signs[j]]
        if len(between) == 1:
            surface = inclusion.surfaces.listed[between[0]]
            gap = lie_derivative(surface, one.fields[0][1]) - lie_derivative(surface, other.fields[0][1])
            require(gap.divided(surface) is not None, "the same flux from both sides of a line")
