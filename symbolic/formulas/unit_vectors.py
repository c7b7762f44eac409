"""Entries of unit vectors, ``x/sqrt(x**2 + y**2)``, whose norm is zero elsewhere than at the checked point, too.

In unit control ``-sigma/abs(sigma)`` of several states (Gutman 1979, Utkin 1992) the norm s is zero on a line or more:
to divide it out would leave a field that rests there.  So the entries ``b_k/s``, with ``s^2 = sum_k c_k b_k^2``, are
put between constants on the sectors on which one of the m sizes ``sqrt(c_k) Abs(b_k)`` is the largest.  This one is at
least ``s/sqrt(m)`` and at most s, another one at most ``s/sqrt(2)``.  Nothing is divided out, and velocities are those
of the states.  What stands over s must be a sum of multiples of the b_k.  Where all b_k are zero, F holds what it holds
beside that place.
"""

from __future__ import annotations

import ast
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from fractions import Fraction

from flint import Ordering, fmpq, fmpq_mat, fmpq_mpoly, fmpq_mpoly_ctx

from nonsmooth.symbolic.formulas.enclosed_functions import INVERSE, NORM, UNIT, Wave
from nonsmooth.symbolic.formulas.norms import (
    Bounded,
    Norm,
    Square,
    affine_parts,
    exact_root,
    root_beside,
    squares_in,
    with_meanings,
)
from nonsmooth.symbolic.formulas.trees import (
    ONE,
    ZERO,
    ExpressionError,
    Interpretation,
    called,
    formula_tree,
    minus,
    multiplied,
    number,
    plus,
    quotient,
    replaced,
    tidied,
    total,
    written,
)

BESIDE = Fraction(1, 128)  # more than twice the error of the square of a ratio of roots


@dataclass(frozen=True)
class UnitEntry(Bounded):
    """An entry ``b_k/s`` of a unit vector.

    Attributes:
        weight: the number c_k.
        base: b_k.
        inverse: the name of ``1/s``.
    """

    weight: Fraction = Fraction(1)
    base: str = ""
    inverse: str = ""

    @property
    def stated(self) -> ast.expr:
        """As a formula of the states."""
        return quotient(formula_tree(self.base), called(NORM, formula_tree(self.argument)))

    @property
    def by_inverse(self) -> ast.expr:
        """By the name of ``1/s``."""
        return multiplied(formula_tree(self.base), ast.Name(self.inverse))

    def bounds(self, states: Collection[str], order: int = 0) -> tuple[ast.expr, ...]:
        """Constants on the sectors with the sign of b_k, or the one that it is: of a single square.

        Where roots of the c_k are irrational, sectors end a little beside those of the sizes.
        """
        squares = squares_in(formula_tree(self.argument), states) or []
        side, base = called("sign", formula_tree(self.base)), formula_tree(self.base)
        if len(squares) == 1:
            return (quotient(side, exact_root(self.weight)),)
        base_size, sizes = _size(self.weight, base), [_size(*square) for square in squares]
        is_largest = multiplied(*[_is_larger(base_size, size) for size in sizes if written(size) != written(base_size)])
        least = root_beside((1 - BESIDE) / (self.weight * len(squares)), is_above=False)
        second = root_beside((1 + BESIDE) / (self.weight * 2), is_above=True)
        most = root_beside(1 / self.weight, is_above=True)
        upper = plus(number(second), multiplied(number(most - second), is_largest))
        return multiplied(side, number(least), is_largest), multiplied(side, upper)


def _size(weight: Fraction, base: ast.expr) -> ast.expr:
    """About ``sqrt(c) Abs(b)``, with a rational number."""
    return multiplied(number(root_beside(weight, is_above=False)), called("Abs", base))


def _is_larger(first: ast.expr, second: ast.expr) -> ast.expr:
    """1 where a formula is larger than another one, 0 where it is smaller."""
    return quotient(plus(ONE, called("sign", plus(first, minus(second)))), number(2))


def with_unit_entries(
    lists: Sequence[Sequence[object]], norms: Sequence[Norm], states: Collection[str]
) -> tuple[list[list[object]], tuple[UnitEntry, ...]]:
    """Formulas with names in place of entries of unit vectors, and what these mean.

    Args:
        lists: of formulas of the states and of names of norms.
        norms: what these names mean.
        states: their names.
    """
    with_entries = [list(formulas) for formulas in lists]
    entries: list[UnitEntry] = []
    for norm in norms:
        squares = squares_in(formula_tree(norm.argument), states) or []
        is_sign = len(squares) == 1  # of one square the entry is exact
        if norm.square or not (is_sign or _is_zero_elsewhere(squares, states)):
            continue
        inverse = f"inverse_{norm.name}"
        unit_entries = [
            UnitEntry(UNIT, norm.argument, f"unit_{k}_{norm.name}", c, written(base), inverse)
            for k, (c, base) in enumerate(squares, 1)
        ]
        with_entries = [
            [_with_entries(formula, norm, squares, unit_entries, states) for formula in formulas]
            for formulas in with_entries
        ]
        entries += unit_entries
    return with_entries, tuple(entries)


def by_inverses(formulas: Sequence[object], norms: Sequence[Bounded]) -> tuple[list[object], tuple[Wave, ...]]:
    """Formulas with the names of ``1/s`` in place of those of entries, and what all names of roots mean."""
    entries = [norm for norm in norms if isinstance(norm, UnitEntry)]
    meanings = {entry.name: entry.by_inverse for entry in entries}
    inverses = {entry.inverse: Wave(INVERSE, entry.argument, entry.inverse) for entry in entries}
    roots = [norm for norm in norms if norm.kind == NORM]
    return [with_meanings(formula, meanings) for formula in formulas], (*roots, *inverses.values())


def _is_zero_elsewhere(squares: Sequence[Square], states: Collection[str]) -> bool:
    """Whether the zeros of a norm are known to be a line or more: all b are affine, and less than n are independent."""
    bases = [_polynomial(base, states) for _, base in squares]
    affine = [base for base in bases if base is not None and base.total_degree() == 1]
    slopes = [
        [base.derivative(k).coefficient(0) if base.derivative(k) else 0 for k in range(len(states))] for base in affine
    ]
    return len(affine) == len(bases) and fmpq_mat(slopes).rank() < len(states)


def _with_entries(
    formula: object, norm: Norm, squares: Sequence[Square], entries: Sequence[UnitEntry], states: Collection[str]
) -> object:
    """A formula with entries of a unit vector; as it is where something else is divided by the norm."""

    def change(node: ast.expr) -> ast.expr | None:
        match node:
            case ast.BinOp(left=left, op=ast.Div(), right=ast.Name(id=name)) if name == norm.name:
                return multiplied(replaced(left, change), ast.Name(entries[0].inverse))
        return None

    try:
        tree = replaced(formula_tree(formula), change)
        without, over = affine_parts(tree, entries[0].inverse, None, str(formula))
    except ExpressionError:
        return formula  # refused where fractions are cleared
    shares = None if over is ZERO else _shares(over, squares, states)
    if shares is None:
        return formula
    parts = [multiplied(share, ast.Name(entry.name)) for share, entry in zip(shares, entries, strict=True)]
    return written(tidied(total([without, *parts])))


def _shares(node: ast.expr, squares: Sequence[Square], states: Collection[str]) -> list[ast.expr] | None:
    """Formulas m_k of which a formula is ``sum_k m_k b_k``; None where that is not seen."""
    numbers = _combination(node, [base for _, base in squares], states)
    if numbers is not None:
        return [number(value) for value in numbers]
    match node:
        case ast.UnaryOp(op=ast.USub()):
            inner = _shares(node.operand, squares, states)
            return None if inner is None else list(map(minus, inner))
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            left, right = (_shares(side, squares, states) for side in (node.left, node.right))
            if left is None or right is None:
                return None
            signed = map(minus, right) if isinstance(node.op, ast.Sub) else right
            return [total(pair) for pair in zip(left, signed, strict=True)]
        case ast.BinOp(op=ast.Mult(), left=left_side, right=right_side):
            for operand, factor in ((left_side, right_side), (right_side, left_side)):
                inner = _shares(operand, squares, states)
                if inner is not None:
                    return [multiplied(share, factor) for share in inner]
        case ast.BinOp(op=ast.Div()):
            inner = _shares(node.left, squares, states)
            return None if inner is None else [quotient(share, node.right) for share in inner]
    return None


def _combination(node: ast.expr, bases: Sequence[ast.expr], states: Collection[str]) -> list[Fraction] | None:
    """Numbers by which a polynomial is a sum of multiples of some; None where there are none."""
    whole, *parts = (_polynomial(tree, states) for tree in (node, *bases))
    polynomials = [part for part in parts if part is not None]
    if whole is None or len(polynomials) < len(bases):
        return None
    monomials = sorted({exponents for polynomial in (whole, *polynomials) for exponents in polynomial.to_dict()})
    equations = fmpq_mat(
        [[polynomial.to_dict().get(e, fmpq(0)) for polynomial in (*polynomials, whole)] for e in monomials]
    )
    reduced, rank = equations.rref()
    solution = [fmpq(0)] * len(polynomials)
    for row in range(rank):
        leading = next(k for k in range(len(polynomials) + 1) if reduced[row, k])
        if leading == len(polynomials):
            return None
        solution[leading] = reduced[row, len(polynomials)]
    return [Fraction(int(value.p), int(value.q)) for value in solution]


def _polynomial(node: ast.expr, states: Collection[str]) -> fmpq_mpoly | None:
    """A formula as a polynomial in the states with rational coefficients; None for any other."""
    names = tuple(sorted(states))
    context = fmpq_mpoly_ctx.get(names, Ordering.lex)
    meant = Interpretation(lambda value: context.constant(fmpq(value.numerator, value.denominator)), None, {})
    try:
        polynomial = meant.value(node, dict(zip(names, context.gens(), strict=True)))
    except (KeyError, TypeError, ArithmeticError, ValueError):
        return None
    return polynomial if isinstance(polynomial, fmpq_mpoly) else None
