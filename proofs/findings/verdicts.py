"""What results say: facts with their words, and the closed sets of verdicts, each with what it means and what to do."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import Any, TypeAlias


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
    """Stability of (x, y), strong: of every Filippov solution."""

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


Record: TypeAlias = Mapping[str, Any]


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
