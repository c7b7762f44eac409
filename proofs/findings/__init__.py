"""What is said of a subject: the closed sets of verdicts, each with what it means and what to do, facts with their
words, and exact numbers in JSON.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from typing import Any, NamedTuple, TypeAlias

from flint import fmpq, fmpz

from nonsmooth.symbolic.numbers.coefficients import Coefficient, as_fraction, bits
from nonsmooth.symbolic.numbers.lazy import Lazy
from nonsmooth.symbolic.numbers.number import Number, Tower

Record: TypeAlias = dict[str, Any]  # JSON


class Equilibrium(StrEnum):
    """Whether ``0`` belongs to the translation part of F at the requested point."""

    HOLDS = "holds"
    FAILS = "fails"
    UNDECIDED = "undecided"


class Certainty(StrEnum):
    """Whether a statement about every array within tolerances is proved."""

    CERTIFIED = "certified"
    UNDECIDED = "undecided"


class Translation(StrEnum):
    """Stability of a body's position, or of the checked point of a plain system; strong: of every Filippov solution."""

    ASYMPTOTICALLY_STABLE = "asymptotically stable"
    STABLE = "stable"
    UNSTABLE = "unstable"
    UNDECIDED = "undecided"


class Rotation(StrEnum):
    """Stability of theta; ``theta = 0`` is never attractive, because no twist depends on theta."""

    UNSTABLE = "unstable"
    NEUTRAL = "stable, not attractive"
    UNDECIDED = "undecided"


class Feedback(StrEnum):
    """Whether the discontinuous law of the feedback clause makes V decrease."""

    STABILIZABLE = "stabilizable"
    NO_CERTIFICATE = "no certificate"
    UNDECIDED = "undecided"
    NOT_APPLICABLE = "not applicable"


class Theorem4(StrEnum):
    """The four clauses together."""

    HOLDS = "holds"
    FAILS = "fails"
    HYPOTHESES_NOT_MET = "hypotheses not met"
    UNDECIDED = "undecided"

    @property
    def exit_status(self) -> int:
        """0 holds, 1 does not hold, 3 undecided."""
        return {"holds": 0, "undecided": 3}.get(self.value, 1)


# ---- facts: what a result says, once, for the terminal, JSON and reports -------------------------
#
# A fact is a number, a record or a sentence with its words.  Renderers (:mod:`nonsmooth.reports.output.facts`) write
# the value under its key into JSON, and the words, with the numbers they show, on the terminal and into the report.  So
# a new number in a result is one fact.


@dataclass(frozen=True)
class Quantity:
    """A number or nested tuples of numbers, exact or sampled; None where there is none.

    JSON holds them as floats, and beside them the exact text of those that are exact.
    """

    value: Any


@dataclass(frozen=True)
class Fact:
    """One thing that a result says.

    Attributes:
        key: in JSON; empty where it is only said in words.
        value: what JSON holds: :class:`Quantity`, texts, lists, nested records, None; a tuple of facts is a nested
            record whose facts may have words too.
        words: a sentence with ``{}`` for every number shown; empty where it is only data.
        shown: the numbers in the words: exact numbers, or texts.
        explained: whether the report explains it by formulas, tables or sentences of its own; then the words stand on
            the terminal only.
        row: the name of its row where every fact has a row of its own; empty where it has none.
    """

    key: str = ""
    value: Any = None
    words: str = ""
    shown: tuple[Any, ...] = ()
    explained: bool = False
    row: str = ""


def said(words: str, *shown: Any, explained: bool = False) -> Fact:
    """A fact in words only."""
    return Fact(words=words, shown=shown, explained=explained)


def number_fact(key: str, value: Any, words: str, *, explained: bool = False) -> Fact:
    """A number under a key, with words that show it where there is one."""
    if value is None:
        return Fact(key, Quantity(None))
    return Fact(key, Quantity(value), words, (value,), explained)


def text_fact(key: str, text: str, row: str) -> Fact:
    """A text under a key, which is also what its row says."""
    return Fact(key, text, text, row=row)


def row_fact(row: str, words: str, *shown: Any) -> Fact:
    """A row in words only."""
    return Fact(words=words, shown=shown, row=row)


def function_facts(formula: str, where: str) -> tuple[Fact, Fact]:
    """A V, and where it is looked at."""
    return row_fact("with", f"V = {formula}"), row_fact("on", where)


def unsaid(facts: Iterable[Fact]) -> tuple[Fact, ...]:
    """The same facts as data only."""
    return tuple(replace(fact, words="", shown=(), row="") for fact in facts)


# ---- numbers of a field as JSON, with the generators that occur and no others --------------------
#
# A rational is text, ``"-1/2"``; any other number is a list of products ``["3/2", 0, 1]`` of a rational and generators.
# The list of generators stands for the field: each is the only root above a bound of a monic polynomial, whose
# coefficients are numbers in the generators before it.  So ``sqrt(2)`` is the root above 0 of ``["-2", "0", "1"]``; the
# base generator ``2 cos(2 pi/N)`` has its minimal polynomial and a bound between its two largest roots.
# A point is ``[X, Y, W]``, W > 0, for ``(X/W, Y/W)``: no division over many square roots.


def encode(document: Record) -> Record:
    """The same document with text for its numbers and generators for its field."""
    generators = Generators(document)
    return {key: generators.encoded(value) for key, value in document.items()}


def homogeneous(values: Sequence[Number | Lazy]) -> tuple[Number, ...]:
    """Numerators of the values over a common positive denominator, which comes last; without rational factors."""
    quotients = [x.quotient() if isinstance(x, Lazy) else (x, x.field.one) for x in values]
    below = list(dict.fromkeys(d for _, d in quotients if d != 1))
    one = quotients[0][1].field.one
    scaled = [n * math.prod((d for d in below if d != denominator), start=one) for n, denominator in quotients]
    scaled.append(math.prod(below, start=one))
    if scaled[-1].sign() < 0:
        scaled = [-x for x in scaled]
    return tuple(x * _scale(scaled) for x in scaled) if below else tuple(scaled)


def _scale(numbers: Sequence[Number]) -> fmpq:
    """The positive rational that makes all coefficients whole and coprime."""
    top, bottom = fmpz(0), fmpz(1)
    for q in (q for number in numbers for c in number.terms.values() for q in _coefficients(c)):
        top, bottom = top.gcd(q.p), bottom.lcm(q.q)
    return fmpq(bottom, top)


class Generators:
    """Which generators a document needs, and its numbers in terms of them."""

    def __init__(self, document: Any) -> None:
        self.field: Tower | None = None
        masks, self.base = 0, False
        for number in _numbers(document):
            self.field = number.field
            masks |= self._needs(number)
        roots = bits(masks)
        self.numbering = {root: k + self.base for k, root in enumerate(roots)}

    def _needs(self, number: Number) -> int:
        """The square roots in a number, and in their radicands."""
        mask = 0
        for root in {i for m in number.terms for i in bits(m)}:
            mask |= 1 << root | self._needs(number.field.radicands[root])
        self.base |= any(len(_coefficients(c)) > 1 for c in number.terms.values())
        return mask

    def encoded(self, value: Any) -> Any:
        """A value with its numbers as text or lists."""
        if isinstance(value, Number):
            return self._number(value)
        if isinstance(value, Tower):
            return self.of_field(value)
        if isinstance(value, Fraction):
            return str(value)
        if isinstance(value, dict):
            return {key: self.encoded(item) for key, item in value.items()}
        if isinstance(value, list | tuple):
            return [self.encoded(item) for item in value]
        if value is None or isinstance(value, str | int):
            return value
        raise TypeError(f"required a number of the field, text, an integer or a container, received {type(value)}")

    def _number(self, number: Number) -> Any:
        rational = number.as_rational()
        if rational is not None:
            return str(rational)
        return [
            [str(q), *[0] * power, *(self.numbering[i] for i in bits(mask))]
            for mask, c in sorted(number.terms.items())
            for power, q in enumerate(_coefficients(c))
            if q
        ]

    def of_field(self, field: Tower) -> list[Record]:
        """The generators of a field that are needed, as polynomials with bounds of their roots."""
        base = [_base_generator(field)] if self.base else []
        return base + [
            {"polynomial": [self._number(-field.radicands[i]), "0", "1"], "above": "0"} for i in self.numbering
        ]


def _numbers(value: Any) -> Iterator[Number]:
    if isinstance(value, Number):
        yield value
    elif isinstance(value, dict | list | tuple):
        for item in value.values() if isinstance(value, dict) else value:
            yield from _numbers(item)


def _coefficients(c: Coefficient) -> list[fmpq]:
    """Rational coefficients of a base element, lowest power first."""
    return [c] if isinstance(c, fmpq) else c.coeffs()


def _base_generator(field: Tower) -> Record:
    """``2 cos(2 pi/N)``: a bound just below it, above which the minimal polynomial increases."""
    if field.modulus is None:
        raise ValueError("required a field with a cyclotomic base")
    coefficients = [as_fraction(c) for c in field.modulus.coeffs()]
    generator, size = 2 * math.cos(2 * math.pi / field.order), 1
    while True:
        above = Fraction(math.floor(generator * size), size)
        first, *others = _shifted(coefficients, above)
        if first < 0 <= min(others):
            return {"polynomial": [str(c) for c in coefficients], "above": str(above)}
        size *= 2


def _shifted(coefficients: list[Fraction], shift: Fraction) -> list[Fraction]:
    """Coefficients of ``p(x + shift)``."""
    shifted = list(coefficients)
    for i in range(len(shifted)):
        for j in reversed(range(i, len(shifted) - 1)):
            shifted[j] += shift * shifted[j + 1]
    return shifted


class Contradiction(NamedTuple):
    """Two statements of this program about one subject that cannot both be true.

    Attributes:
        between: what is compared, in a few words.
        sides: the two statements, a sentence each.
        clauses: names of the clauses that nobody may rely on.
    """

    between: str
    sides: tuple[str, str]
    clauses: tuple[str, ...] = ()

    @property
    def text(self) -> str:
        """Both sides in one sentence."""
        return f"{self.between} contradict each other: {self.sides[0]}; but {self.sides[1]}"


class ContradictionError(RuntimeError):
    """A contradiction about a subject of this name, of which nothing is said therefore.

    Attributes:
        found: both sides.
    """

    def __init__(self, name: str, found: Contradiction) -> None:
        self.found = found
        super().__init__(f"{name}: {found.text}; nobody may rely on either (please report this)")
