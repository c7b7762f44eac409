"""Polynomials and fields of plain systems as formulas, with the names of the states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from nonsmooth.analysis.fields.stated_field import StatedField
from nonsmooth.reports.output.document import Math
from nonsmooth.symbolic.formulas.enclosed_functions import INVERSE, NORM
from nonsmooth.symbolic.formulas.surfaces import symbol_latex
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


def rates_header(states: Sequence[str]) -> list[Math]:
    """The names of the rates of all states."""
    return [Math(rf"\dot{{{state_latex(name)}}}", f"{name}'") for name in states]


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
    """The rate of each state, with its norms, sines and cosines."""
    latex = [_wave_latex(wave.kind, polynomial_math(wave.argument, states).latex) for wave in field.waves]
    return tuple(
        _polynomial_math(rate, field.names(states), [*map(state_latex, states), *latex]) for rate in field.rates
    )


def _wave_latex(kind: str, argument: str) -> str:
    if kind == INVERSE:
        return rf"\left({argument}\right)^{{-1/2}}"
    if kind == NORM:
        return rf"\sqrt{{{argument}}}"
    name = "arctan" if kind == "atan" else kind
    return rf"\{name}\left({argument}\right)"


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
