"""What a clause of a check must offer.

A check decides the clauses of :data:`nonsmooth.proofs.clauses.registry.CLAUSES` in their order, and concludes from
their results.  To add a clause, write one class on :class:`Clause` with a result on :class:`ClauseResult` in a folder
of its own here, and list it there.  Its verdict, reason and facts then appear on the terminal, in JSON, in the report
and in the conclusion.  (The stand-alone checker of certificates keeps its own written list on purpose.)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from enum import StrEnum
from typing import TYPE_CHECKING, ClassVar, Generic, Protocol, TypeVar

from nonsmooth.proofs.facts import Fact
from nonsmooth.proofs.verdicts import Theorem4

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.workspace import Workspace
    from nonsmooth.proofs.theorem4_result import Theorem4Result


class ClauseResult(Protocol):
    """Verdict, reason and evidence of one clause; frozen."""

    @property
    def verdict(self) -> StrEnum:
        """The answer, one of a closed set."""
        ...

    @property
    def reason(self) -> str:
        """Why, in one sentence for people."""
        ...


Result = TypeVar("Result", bound=ClauseResult)


class Clause(ABC, Generic[Result]):
    """One clause.

    Attributes:
        name: its key in JSON and its row on the terminal.
    """

    name: ClassVar[str]

    @abstractmethod
    def decide(self, work: Workspace) -> Result:
        """The verdict with its evidence.

        Raises:
            RefusalError: where the motion is not determined.
        """

    @abstractmethod
    def undecided(self, result: Result, reason: str) -> Result:
        """A result in place of the given one that claims nothing, for a reason."""

    def settles(self, result: Result) -> tuple[Theorem4, str] | None:
        """The theorem's verdict and its reason where this clause decides it alone, whatever the later ones say."""
        return None

    def is_open(self, result: Result) -> bool:
        """Whether the theorem stays undecided for want of this clause."""
        return False

    def applies(self, result: Result) -> bool:
        """Whether the hypotheses of the clause are met; one that does not apply leaves the theorem as it is."""
        return True

    def facts(self, result: Result, check: Theorem4Result) -> Iterator[Fact]:
        """What else there is to say beside verdict and reason."""
        yield from ()
