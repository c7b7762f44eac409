"""A decided problem as an archive of KeYmaera X: a theorem of real arithmetic for each inequality, with tactic QE.

The form is that of the archives that are published with KeYmaera X 4.9 (LS-Lab/KeYmaeraX-projects): ``Theorem``,
``ProgramVariables``, ``Problem``, ``Tactic``, each ended by ``End.``
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from nonsmooth.reports.exchange.obligations import Obligation, Term
from nonsmooth.symbolic.messages.scene_error import one_line

_JOINTS = {"+": " + ", "*": "*", "and": " & ", "or": " | ", "=>": " -> ", ">=": " >= ", ">": " > ", "=": " = "}


def keymaerax_text(obligations: Sequence[Obligation], head: Sequence[str]) -> str:
    """The file.

    Args:
        obligations: what must be valid.
        head: lines of the comment at the top.
    """
    lines = ["/*", *(f" * {_comment(line)}".rstrip() for line in head)]
    lines += [" *", f" * {len(obligations)} theorems: the verdict is proved again where QE proves each.", " */"]
    for number, own in enumerate(obligations, 1):
        title = _comment(f"{number} of {len(obligations)}, {own.name}").replace('"', "'")
        lines += ["", f'Theorem "{title}"', "", "ProgramVariables"]
        lines += [f"  Real {name};" for name in own.variables]
        lines += ["End.", "", "Problem"]
        lines += ["  " + "\n  & ".join(map(kyx_term, own.hypotheses))] if own.hypotheses else ["  true"]
        lines += ["  ->", f"  {kyx_term(own.conclusion)}", "End.", ""]
        lines += [f'Tactic "{title}: Proof"', "  QE", "End.", "", "End."]
    return "\n".join([*lines, ""])


def kyx_term(term: Term) -> str:
    """A term or a formula, each part in parentheses."""
    match term:
        case Fraction():
            return str(term) if term >= 0 and term.denominator == 1 else f"({term})"
        case str():
            return term
        case ("^", base, exponent):
            return f"{kyx_term(base)}^{exponent}"
        case ("not", inner):
            return f"!{kyx_term(inner)}"
        case (operator, *parts):
            return f"({_JOINTS[operator].join(map(kyx_term, parts))})"
    raise TypeError(f"required a term, received {term!r}")


def _comment(line: str) -> str:
    """A line that neither ends nor begins a comment."""
    return one_line(line).replace("*/", "* /").replace("/*", "/ *")
