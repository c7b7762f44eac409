"""Formulas of plain systems in a report: polynomials, names of states, and right-hand sides that the program wrote."""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import replace

from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.reports.document import Math
from nonsmooth.symbolic.formulas import symbol_latex
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.numbers.printing import Summand, latex_sum, number_summands

GREEK = frozenset({
    "alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda", "mu", "nu", "xi",
    "rho", "sigma", "tau", "phi", "chi", "psi", "omega",
})  # fmt: skip


def state_latex(name: str) -> str:
    """A state's name: one letter or a Greek one as a symbol with its index, a word as a word."""
    stem, _, index = name.partition("_")
    if stem in GREEK:
        stem = rf"\{stem}"
    elif len(stem) != 1:
        word = name.replace("_", r"\_")
        return rf"\mathit{{{word}}}"
    return symbol_latex(f"{stem}_{index}") if index else stem


def polynomial_math(polynomial: Polynomial, states: Sequence[str]) -> Math:
    """A polynomial in the displacement, whose entries are called like the states.

    Args:
        polynomial: in as many variables as there are states.
        states: their names.
    """
    return _polynomial_math(polynomial, states, list(map(state_latex, states)))


def _polynomial_math(polynomial: Polynomial, names: Sequence[str], symbols: Sequence[str]) -> Math:
    """A polynomial by the plain names of its variables and by their symbols in LaTeX."""
    named = replace(polynomial, variables=tuple(names))
    summands: list[Summand] = []
    for exponents, coefficient in sorted(polynomial.terms.items(), key=lambda term: (-sum(term[0]), term[0][::-1])):
        powers = [_power(symbol, k) for symbol, k in zip(symbols, exponents, strict=True) if k]
        summands.append(_term(number_summands(coefficient), powers))
    return Math(latex_sum(summands) if summands else "0", str(named))


def stated_math(field: StatedField, states: Sequence[str]) -> tuple[Math, ...]:
    """The rate of each state, with its sines and cosines."""
    waves = [polynomial_math(wave.argument, states) for wave in field.waves]
    latex = [rf"\{wave.kind}\left({math.latex}\right)" for wave, math in zip(field.waves, waves, strict=True)]
    return tuple(
        _polynomial_math(rate, field.names(states), [*map(state_latex, states), *latex]) for rate in field.rates
    )


def rate_name(state: str) -> Math:
    """``x'``."""
    return Math(rf"\dot{{{state_latex(state)}}}", f"{state}'")


def _power(symbol: str, exponent: int) -> str:
    return symbol if exponent == 1 else rf"{symbol}^{{{exponent}}}"


def _term(coefficients: list[Summand], powers: list[str]) -> Summand:
    """A coefficient times powers; a sum as a coefficient stands in parentheses."""
    if len(coefficients) > 1:
        text = latex_sum(coefficients)
        return Summand(False, "", " ".join([rf"\left({text}\right)", *powers]) if powers else text)
    (only,) = coefficients
    shown = [only.latex] * (only.latex != "1" or not powers)
    return Summand(only.negative, "", " ".join([*shown, *powers]))


# ---- right-hand sides that the program wrote -----------------------------------------------------


def tidied(text: str) -> str:
    """A formula without signs, parentheses, factors and summands that change nothing.

    ``(((1*((+ (v)) - (+ (v))**3/6 + 0*(+ (v))**5/120)) - (w)))`` becomes ``v - v**3/6 - w``.

    Args:
        text: a formula that was accepted before; it is read as Python's grammar reads it, and not evaluated.
    """
    tree = _Tidier().visit(ast.parse(text.strip(), mode="eval"))
    shown = ast.unparse(tree)
    for operator in ("**", "*", "/"):
        shown = shown.replace(f" {operator} ", operator)
    return shown


class _Tidier(ast.NodeTransformer):
    """Leaves out ``+v``, ``1*v``, ``0*v`` and zeros that are added."""

    def visit_UnaryOp(self, node: ast.UnaryOp) -> ast.AST:
        self.generic_visit(node)
        if isinstance(node.op, ast.UAdd) or _is(node.operand, 0):
            return node.operand
        return node

    def visit_BinOp(self, node: ast.BinOp) -> ast.AST:
        self.generic_visit(node)
        left, right = node.left, node.right
        match node.op:
            case ast.Mult() if _is(left, 0) or _is(right, 0):
                return ast.Constant(0)
            case ast.Mult() if _is(left, 1):
                return right
            case ast.Mult() | ast.Div() if _is(right, 1):
                return left
            case ast.Div() if _is(left, 0):
                return left
            case ast.Add() if _is(left, 0):
                return right
            case ast.Add() | ast.Sub() if _is(right, 0):
                return left
            case ast.Sub() if _is(left, 0):
                return ast.UnaryOp(ast.USub(), right)
        return node


def _is(node: ast.expr, value: int) -> bool:
    return isinstance(node, ast.Constant) and node.value == value and not isinstance(node.value, bool)
