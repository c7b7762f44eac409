"""A decided problem in SMT-LIB 2: one query for each inequality that the verdict rests on, each ``unsat`` if it holds.

The logic is QF_NRA, polynomial arithmetic over the reals; the form is that of the standard, version 2.6 (Barrett,
Fontaine, Tinelli 2017).
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from nonsmooth.reports.exchange.obligations import Obligation, Term
from nonsmooth.symbolic.messages.scene_error import one_line


def smtlib_text(obligations: Sequence[Obligation], head: Sequence[str]) -> str:
    """The file.

    Args:
        obligations: what must be valid.
        head: lines of the comment at the top.
    """
    lines = [f"; {one_line(line)}".rstrip() for line in head]
    lines += [
        ";",
        f"; {len(obligations)} queries: the verdict is proved again where each answer is unsat.",
        "; z3 FILE; cvc5 --incremental FILE",
        "(set-logic QF_NRA)",
    ]
    for number, own in enumerate(obligations, 1):
        lines += ["", f"; query {number}: {one_line(own.name)}", "(push 1)"]
        lines += [f"(declare-const {name} Real)" for name in own.variables]
        lines += [f"(assert {smt_term(hypothesis)})" for hypothesis in own.hypotheses]
        lines += [f"(assert (not {smt_term(own.conclusion)}))", "(check-sat)", "(pop 1)"]
    return "\n".join([*lines, "(exit)", ""])


def smt_term(term: Term) -> str:
    """A term or a formula; powers are products, since SMT-LIB has none."""
    match term:
        case Fraction():
            return _number(term)
        case str():
            return term
        case ("^", base, exponent):
            return f"(* {' '.join([smt_term(base)] * int(exponent))})"
        case (operator, *parts):
            return f"({operator} {' '.join(map(smt_term, parts))})"
    raise TypeError(f"required a term, received {term!r}")


def _number(value: Fraction) -> str:
    """A literal of the reals: negation and division are operators."""
    whole = f"{abs(value.numerator)}.0"
    size = whole if value.denominator == 1 else f"(/ {whole} {value.denominator}.0)"
    return f"(- {size})" if value < 0 else size
