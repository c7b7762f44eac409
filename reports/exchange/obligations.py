"""What a verdict about a plain system rests on, as formulas of real arithmetic that other provers can decide.

The certificate of a verdict is read as the checker reads it (:mod:`nonsmooth.proofs.checker.statements`): its theorem
derives every inequality from the system, and each is noted here beside its evidence, which is not used.  So a prover
that shows all of them has proved the verdict again, by the theorem alone.

An inequality *is about* the closure of the points at which its open guards are positive.  Where it is not strict,
continuity lets us ask it at those points alone; where it is strict it is asked wherever the guards are at least zero,
which may be more: a prover that refutes that has not refuted the verdict.

A claim with functions mu, ``p_i + sum_j mu_j q_ij > 0`` for all i, is asked by its dual (Motzkin): weights
``w_i >= 0``, not all zero, with ``sum_i w_i q_ij = 0`` for all j have ``sum_i w_i p_i > 0``.  That is the claim itself:
V falls along every mixture of velocities that is tangent to the surface, Filippov's sliding velocities.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Inequality, Proofs
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import THEOREMS, is_of_array
from nonsmooth.proofs.checker.tower import Field, Number
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line

# A term or a formula: a number, a name, or an operator with its parts.  Operators are those of SMT-LIB:
# + * ^ (a whole exponent), >= > = , and or not =>.
Term: TypeAlias = Any

ZERO = Fraction(0)
MESH = "basin"  # the theorem whose conditions are about numbers at corners of triangles


@dataclass(frozen=True)
class Obligation:
    """A formula that must be valid: ``hypotheses => conclusion`` for all real numbers.

    Attributes:
        name: of the claim, with the theorem that asks it.
        variables: the coordinates z, in units of the half-width of the cube about the point; weights w; roots r.
        hypotheses: all of them.
        conclusion: what follows.
    """

    name: str
    variables: tuple[str, ...]
    hypotheses: tuple[Term, ...]
    conclusion: Term


class _RecordedClaims(Proofs):
    """Shows claims by their evidence, and keeps them."""

    def __init__(self, data: Any) -> None:
        super().__init__(data)
        self.own: list[Claim] = []
        self.parts: list[_RecordedClaims] = []

    def show(self, claim: Claim) -> None:
        """Show a claim by its evidence, and keep it."""
        super().show(claim)
        self.own.append(claim)

    def of_part(self, data: Any) -> _RecordedClaims:
        """The evidence of a theorem about a part, whose claims are kept too."""
        self.parts.append(_RecordedClaims(data))
        return self.parts[-1]

    @property
    def claims(self) -> list[Claim]:
        """All claims; those about parts say so in their names."""
        parts = enumerate(self.parts, 1)
        return self.own + [replace(claim, name=f"part {k}: {claim.name}") for k, part in parts for claim in part.claims]


def obligations_of(certificate: Mapping[str, Any], source: str) -> list[Obligation]:
    """The obligations of all theorems in the evidence of a certificate.

    Args:
        certificate: of a plain system.
        source: what messages call the system.

    Raises:
        SceneError: for an array and for a mesh of triangles, whose certificates rest on other arithmetic, and where
            nothing is left to prove.
    """
    data = json.loads(json.dumps(certificate))
    if is_of_array(data["statement"]["subject"]):
        raise SceneError(source, "", "a plain system", StatedFact("an array of wheels"))
    subject = read_subject(data["statement"]["subject"])
    found: list[Obligation] = []
    for number, entry in enumerate(data["evidence"], 1):
        if entry["theorem"] == MESH:
            raise SceneError(source, "", "a certificate without a mesh", StatedFact("one by the theorem basin"))
        proofs = _RecordedClaims(entry["proofs"])
        THEOREMS[entry["theorem"]](subject, entry["hypotheses"], proofs)
        theorem = f"{number} {entry['theorem']}"
        found += [obligation for claim in proofs.claims for obligation in _of_claim(claim, theorem)]
    if not found:
        expected = "a verdict that rests on inequalities between polynomials"
        theorems = ", ".join(entry["theorem"] for entry in data["evidence"])
        raise SceneError(source, "", expected, StatedFact(f"one by the theorem {theorems}, which rests on numbers"))
    return found


def _of_claim(claim: Claim, theorem: str) -> Iterator[Obligation]:
    """One obligation for all inequalities with common functions mu, or one for each; nothing is claimed at the origin
    alone.
    """
    if not claim.count and not claim.at_origin:
        return
    name = f"{theorem}: {claim.name}"
    if claim.inequalities[0].pushes:
        yield _with_weights(claim, name)
        return
    for number, inequality in enumerate(claim.inequalities, 1):
        hypotheses = _held(inequality, claim)
        marked = name if len(claim.inequalities) == 1 else f"{name} [{number}]"
        yield _obligation(claim, marked, (), hypotheses, term(inequality.value), _border([inequality], claim))


def _with_weights(claim: Claim, name: str) -> Obligation:
    """The dual of a claim with functions mu, in weights that add up to 1."""
    weights = [f"w{i}" for i in range(len(claim.inequalities))]
    hypotheses: list[Term] = [(">=", weight, ZERO) for weight in weights]
    hypotheses.append(("=", _joined("+", weights), Fraction(1)))
    for weight, inequality in zip(weights, claim.inequalities, strict=True):
        held = dict.fromkeys(_held(inequality, claim))
        if held:
            hypotheses.append(("or", ("=", weight, ZERO), _joined("and", held)))
    multiplied = [(*inequality.pushes, *inequality.weak) for inequality in claim.inequalities]  # by functions mu
    for column in zip(*multiplied, strict=True):
        hypotheses.append(("=", _mixed(weights, column), ZERO))
    total = _mixed(weights, [inequality.value for inequality in claim.inequalities])
    return _obligation(claim, name, weights, hypotheses, total, _border(claim.inequalities, claim))


def _mixed(weights: Sequence[str], values: Sequence[Polynomial]) -> Term:
    """``sum_i w_i p_i``."""
    return _joined("+", (("*", weight, term(value)) for weight, value in zip(weights, values, strict=True)))


def _held(inequality: Inequality, claim: Claim) -> list[Term]:
    """Guards, positive where they are open and nothing strict is claimed, else at least zero; and what is zero."""
    signs = (
        (">" if name in inequality.open and not claim.strict else ">=", guard)
        for name, guard in inequality.guards.items()
    )
    zeros = (("=", zero) for zero in inequality.zeros.values())
    return [(sign, term(polynomial), ZERO) for sign, polynomial in (*signs, *zeros)]


def _border(inequalities: Sequence[Inequality], claim: Claim) -> Term | None:
    """The guard whose zeros nothing strict is claimed at."""
    found = next(
        (inequality.guards[claim.border] for inequality in inequalities if claim.border in inequality.guards), None
    )
    return None if found is None else term(found)


def _obligation(
    claim: Claim, name: str, weights: Sequence[str], hypotheses: Sequence[Term], total: Term, border: Term | None
) -> Obligation:
    places = [f"z{k}" for k in range(claim.count)]
    domain: list[Term] = []
    if claim.bounded:
        for place in places:
            domain += [(">=", place, Fraction(-1)), (">=", Fraction(1), place)]
    if not claim.at_origin:
        domain.append(_joined("or", (("not", ("=", place, ZERO)) for place in places)))
    conclusion: Term = (">" if claim.strict else ">=", total, ZERO)
    if claim.strict and border is not None:
        conclusion = ("and", (">=", total, ZERO), ("=>", (">", border, ZERO), conclusion))
    roots, equations = ([], []) if claim.field is None else _roots(claim.field)
    stated = dict.fromkeys((*equations, *domain, *hypotheses))  # guards of the cube stand there more than once
    return Obligation(name, (*places, *weights, *roots), tuple(stated), conclusion)


def _roots(field: Field) -> tuple[list[str], list[Term]]:
    """A name for each irrational number, the only root of its polynomial above its bound."""
    names, equations = [], []
    for k, generator in enumerate(field.generators):
        name = f"r{k}"
        powers: list[Term] = [("^", name, generator.degree)]
        powers += [
            _product(_number(value), _power(name, power)) for power, value in enumerate(generator.lower) if value
        ]
        names.append(name)
        equations += [("=", _joined("+", powers), ZERO), (">", name, generator.above)]
    return names, equations


def _power(name: str, exponent: int) -> list[Term]:
    return [] if not exponent else [name] if exponent == 1 else [("^", name, exponent)]


def _number(value: Any) -> Term:
    """A rational number, or a sum of products of roots."""
    if not isinstance(value, Number):
        return Fraction(value)
    return _sum(
        _product(Fraction(factor, value.bottom), [f"r{k}" for k in monomial])
        for monomial, factor in value.terms.items()
    )


def term(value: Polynomial) -> Term:
    """A polynomial in z0, z1, ..."""
    return _sum(
        _product(_number(coefficient), [part for k, power in enumerate(exponents) for part in _power(f"z{k}", power)])
        for exponents, coefficient in value.terms.items()
    )


def _sum(parts: Iterable[Term]) -> Term:
    listed = list(parts)
    return _joined("+", listed) if listed else ZERO


def _product(number: Term, factors: Sequence[Term]) -> Term:
    if not factors:
        return number
    return _joined("*", factors if number == 1 else (number, *factors))


def _joined(operator: str, parts: Iterable[Term]) -> Term:
    """Parts under an operator, or the only part."""
    listed = list(parts)
    return listed[0] if len(listed) == 1 else (operator, *listed)


# ---- a decided problem as an archive of KeYmaera X -----------------------------------------------
#
# A theorem of real arithmetic for each inequality, with tactic QE.
#
# The form is that of the archives that are published with KeYmaera X 4.9 (LS-Lab/KeYmaeraX-projects): ``Theorem``,
# ``ProgramVariables``, ``Problem``, ``Tactic``, each ended by ``End.``


_JOINTS = {"+": " + ", "*": "*", "and": " & ", "or": " | ", "=>": " -> ", ">=": " >= ", ">": " > ", "=": " = "}


def keymaerax_text(obligations: Sequence[Obligation], head: Sequence[str]) -> str:
    """The file.

    Args:
        obligations: what must be valid.
        head: lines of the comment at the top.
    """
    lines = ["/*", *(f" * {_comment(line)}".rstrip() for line in head)]
    lines += [" *", f" * {len(obligations)} theorems: the verdict is proved again where QE proves each.", " */"]
    for number, obligation in enumerate(obligations, 1):
        title = _comment(f"{number} of {len(obligations)}, {obligation.name}").replace('"', "'")
        lines += ["", f'Theorem "{title}"', "", "ProgramVariables"]
        lines += [f"  Real {name};" for name in obligation.variables]
        lines += ["End.", "", "Problem"]
        lines += ["  " + "\n  & ".join(map(kyx_term, obligation.hypotheses))] if obligation.hypotheses else ["  true"]
        lines += ["  ->", f"  {kyx_term(obligation.conclusion)}", "End.", ""]
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


# ---- SMT-LIB 2: one query for each inequality that the verdict rests on, ``unsat`` if it holds ----
#
# The logic is QF_NRA, polynomial arithmetic over the reals; the form is that of the standard, version 2.6 (Barrett,
# Fontaine, Tinelli 2017).


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
    for number, obligation in enumerate(obligations, 1):
        lines += ["", f"; query {number}: {one_line(obligation.name)}", "(push 1)"]
        lines += [f"(declare-const {name} Real)" for name in obligation.variables]
        lines += [f"(assert {smt_term(hypothesis)})" for hypothesis in obligation.hypotheses]
        lines += [f"(assert (not {smt_term(obligation.conclusion)}))", "(check-sat)", "(pop 1)"]
    return "\n".join([*lines, "(exit)", ""])


def smt_term(term: Term) -> str:
    """A term or a formula; powers are products, since SMT-LIB has none."""
    match term:
        case Fraction():
            return _smt_number(term)
        case str():
            return term
        case ("^", base, exponent):
            return f"(* {' '.join([smt_term(base)] * int(exponent))})"
        case (operator, *parts):
            return f"({operator} {' '.join(map(smt_term, parts))})"
    raise TypeError(f"required a term, received {term!r}")


def _smt_number(value: Fraction) -> str:
    """A literal of the reals: negation and division are operators."""
    whole = f"{abs(value.numerator)}.0"
    size = whole if value.denominator == 1 else f"(/ {whole} {value.denominator}.0)"
    return f"(- {size})" if value < 0 else size
