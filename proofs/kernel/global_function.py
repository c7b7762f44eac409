"""Proposals for a V that is positive and falls in the whole space: polynomials, and logarithms, by sums of squares.

With fields f that are polynomials, of one cell, both are asked without a domain,

    V  a sum of squares,    -grad V . f  a sum of squares for every f,

which is affine in the coefficients of V (Parrilo 2000).  So is ``-(1 + P) grad Q . f - w grad P . f`` in those of Q
and in w, for ``V = Q + w ln(1 + P)`` with a P that is known, the sum of the squares of some states, and Q a sum of
squares and fourth powers of the others.  A field with products of states may have such a V and none that is a
polynomial (Ahmadi, Krstic and Parrilo 2011).  Floats propose; :mod:`nonsmooth.proofs.kernel.whole_space` shows what
they propose, or does not.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import combinations
from math import lcm

from flint import fmpq

from nonsmooth.proofs.kernel.cells import BeyondReachError, rational_terms
from nonsmooth.proofs.sums_of_squares.ansatz import (
    Condition,
    build_blocks,
    gram_entries,
    monomials_between,
    without_idle,
)
from nonsmooth.proofs.sums_of_squares.conic_program import Problem, solve_inside
from nonsmooth.proofs.sums_of_squares.rounding import round_parameters
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

FEW = 3  # states of which all choices are tried
DENOMINATORS = (1 << 3, 1 << 6, 1 << 10)  # of coefficients, which lie between -1 and 1
MOST_UNKNOWNS = 3_000  # entries of Gram matrices


def global_functions(system: SwitchedSystem) -> Iterator[PiecewiseExpression]:
    """V in the displacement, one after the other; none where something switches."""
    for exponents in _bases(len(system.states)):
        yield from _proposed(system, exponents, {})


def logarithmic_functions(system: SwitchedSystem) -> Iterator[tuple[PiecewiseExpression, PiecewiseExpression]]:
    """Q/w and P in the displacement, one after the other; none where something switches."""
    count = len(system.states)
    squares, fourths = ([tuple(power * int(j == k) for j in range(count)) for k in range(count)] for power in (2, 4))
    for size in range(1, count) if count <= FEW else ():
        for chosen in combinations(range(count), size):
            within = [squares[k] for k in chosen]
            inside: Terms = {own: fmpq(1) for own in within}
            for powers in (squares, squares + fourths):
                exponents = [own for own in powers if not any(own[k] for k in chosen)]
                for formula in _proposed(system, exponents, inside):
                    yield formula, _formula(system.states, within, [fmpq(1)] * size)


def _proposed(system: SwitchedSystem, exponents: Sequence[Exponents], inside: Terms) -> Iterator[PiecewiseExpression]:
    """The sum of some monomials with coefficients that a solver in floats finds, rounded in several ways.

    Args:
        system: whose velocities are polynomials; of others nothing is proposed.
        exponents: of the monomials.
        inside: P of a logarithm beside them, over whose weight the sum is taken; empty without one.
    """
    try:
        fields = _fields(system)
    except (BeyondReachError, SceneError):
        return
    problems = _problems(fields, exponents, inside)
    if sum(gram_entries(blocks) for _, blocks in problems) > 2 * MOST_UNKNOWNS:
        return
    solved = solve_inside(problems, len(exponents) + bool(inside), bounded=True)
    for denominator in DENOMINATORS if solved is not None else ():
        found = None if solved is None else round_parameters(*solved, denominator)
        if found is None or not any(found):
            continue
        weight = found[-1] if inside else fmpq(1)
        if weight > 0:
            yield _formula(system.states, exponents, [own / weight for own in found[: len(exponents)]])


def _fields(system: SwitchedSystem) -> list[list[Terms]]:
    """The right-hand sides as polynomials in the displacement from the point.

    Raises:
        BeyondReachError: where something switches, and for irrational numbers.
        SceneError: for a piece that is no polynomial.
    """
    places = system.displaced(system.states)
    return [[rational_terms(own) for own in member.velocity(_no_sign, places)] for member in system.members]


def _no_sign(surface: object) -> int:
    raise BeyondReachError("a field that switches")


def _bases(count: int) -> Iterator[list[Exponents]]:
    """The monomials of V, tried in turn.

    Fields of odd degree leave no room for some of them: where others must be zero no rounding survives.  So few come
    first: squares, quadratic forms, these with powers of four of some states, and all up to degree 4.
    """
    units = [tuple(int(j == k) for j in range(count)) for k in range(count)]
    squares, fourths = ([tuple(power * e for e in own) for own in units] for power in (2, 4))
    quadratic = monomials_between(count, 2, 2)
    yield squares
    yield list(quadratic)
    for size in range(1, count + 1) if count <= FEW else ():
        for chosen in combinations(fourths, size):
            yield [*quadratic, *chosen]
    yield [*quadratic, *monomials_between(count, 3, 4)]


def _problems(fields: Sequence[Sequence[Terms]], exponents: Sequence[Exponents], inside: Terms) -> list[Problem]:
    """That the sum is positive, and V falls along every field; the weight of a logarithm is the last unknown."""
    count = len(exponents[0])
    factor = add_terms({(0,) * count: fmpq(1)}, inside)
    asked = [Condition({}, {k: {own: fmpq(1)} for k, own in enumerate(exponents)}, (), (), count)]
    for field in fields:
        falls = [multiply_terms(factor, _fall(own, field)) for own in exponents]
        weighed: Terms = {}
        for own, c in inside.items():
            weighed = add_terms(weighed, {e: c * value for e, value in _fall(own, field).items()})
        asked.append(Condition({}, {k: fall for k, fall in enumerate([*falls, weighed]) if fall}, (), (), count))
    return [(own, without_idle(build_blocks(own), own.support)) for own in asked]


def _fall(exponents: Exponents, field: Sequence[Terms]) -> Terms:
    """``-grad m . f`` of a monomial m."""
    total: Terms = {}
    for k, velocity in enumerate(field):
        if exponents[k]:
            slope = {(*exponents[:k], exponents[k] - 1, *exponents[k + 1 :]): fmpq(-exponents[k])}
            total = add_terms(total, multiply_terms(slope, velocity))
    return total


def _formula(
    states: Sequence[str], exponents: Sequence[Exponents], coefficients: Sequence[fmpq]
) -> PiecewiseExpression:
    """A polynomial times the common denominator of its coefficients."""
    whole = lcm(*(int(own.q) for own in coefficients))
    terms = []
    for powers, own in zip(exponents, coefficients, strict=True):
        if own:
            factors = "*".join(x if e == 1 else f"{x}**{e}" for x, e in zip(states, powers, strict=True) if e)
            size = abs(int(own * whole))
            terms.append(("-" if own < 0 else "+") + (factors if size == 1 else f"{size}*{factors}"))
    return parse_piecewise("".join(terms).removeprefix("+"), tuple(states))
