"""Formulas as texts: sums, products and cases, put together from texts of formulas.

A condition ``g > 0`` is the factor ``relu(sgn(g))``: 1 where it holds, 0 where it does not.  The factor
``(1 + sgn(g))/2`` would be one half wherever g is zero, and a g with absolute values may be zero on whole cells.
"""

from __future__ import annotations

from collections.abc import Sequence

ZERO, ONE, MINUS_ONE = "0", "1", "(-1)"


def in_parentheses(text: str) -> str:
    """A formula as a factor."""
    return text if text.isalnum() else f"({text})"


def sum_text(terms: Sequence[str]) -> str:
    """A sum as a factor, without terms that are zero; nested like a balanced tree, since depth is limited."""
    return _balanced([term for term in terms if term != ZERO], " + ", ZERO)


def product_text(factors: Sequence[str]) -> str:
    """A product as a factor: zero where one factor is, without factors that are one."""
    if ZERO in factors:
        return ZERO
    others = [factor for factor in factors if factor not in (ONE, MINUS_ONE)]
    text = _balanced(others, "*", ONE)
    return f"(-{text})" if factors.count(MINUS_ONE) % 2 else text


def difference_text(left: str, right: str) -> str:
    """``left - right`` as a factor."""
    return left if right == ZERO else f"({left} - {right})"


def indicator(guard: str, *, strict: bool = True) -> str:
    """1 where a formula is positive (or where it is not negative), else 0, as a factor."""
    return f"relu(sgn({guard}))" if strict else complement(indicator(f"-{in_parentheses(guard)}"))


def complement(truth: str) -> str:
    """1 where a factor of truth is 0, and 0 where it is 1."""
    return {ZERO: ONE, ONE: ZERO}.get(truth, f"(1 - {truth})")


def disjunction(truths: Sequence[str]) -> str:
    """1 where one of some factors of truth is 1."""
    return complement(product_text([complement(truth) for truth in truths]))


def first_that_holds(choices: Sequence[tuple[str, str]], otherwise: str) -> str:
    """The formula of the first choice whose factor of truth is 1, and another formula where none is.

    ``1_1 f_1 + (1 - 1_1) (1_2 f_2 + (1 - 1_2) (...))``.
    """
    formula = otherwise
    for truth, chosen in reversed(choices):
        if chosen != formula:
            rest = product_text([complement(truth), formula])
            formula = sum_text([product_text([truth, chosen]), rest])
    return formula


def _balanced(parts: Sequence[str], joint: str, empty: str) -> str:
    if len(parts) <= 1:
        return parts[0] if parts else empty
    middle = len(parts) // 2
    return f"({_balanced(parts[:middle], joint, empty)}{joint}{_balanced(parts[middle:], joint, empty)})"
