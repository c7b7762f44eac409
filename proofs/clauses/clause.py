"""What a clause of a check must offer.

A check decides the clauses of :data:`nonsmooth.proofs.clause_registry.CLAUSES` in their order, and concludes from
their results.  To add a clause, write one class on :class:`Clause` with a result on :class:`ClauseResult` in a folder
of its own here, and list it there.  Its verdict, reason and facts then appear on the terminal, in JSON, in the report
and in the conclusion.  (The stand-alone checker of certificates keeps its own written list on purpose.)
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Generic, Protocol, TypeVar

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.workspace import ClauseResult, Workspace
from nonsmooth.proofs.findings import Fact, Quantity, Record, Rotation, Theorem4, Translation
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number import Number

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.equilibria import RestPlace
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.proofs.clauses.authority import Authority
    from nonsmooth.symbolic.mechanics.scene import Scene


@dataclass(frozen=True, repr=False)
class JudgedEquilibrium(ShortRepr):
    """An equilibrium with its local verdicts; None where the point was not judged."""

    found: RestPlace
    translation: Translation | None = None
    rotation: Rotation | None = None


class CheckedArray(Protocol):
    """What a clause may speak of beside its own result: the array, and what was found outside the clauses.

    Its members are those of :class:`nonsmooth.proofs.theorem4.Theorem4Result`.
    """

    @property
    def scene(self) -> Scene:
        """The array as it was given."""
        ...

    @property
    def authority(self) -> Authority:
        """Rank of the roll rows at the checked point."""
        ...

    @property
    def partition(self) -> Partition | None:
        """The cells, about the checked point; None under a rule without cells."""
        ...

    @property
    def other_equilibria(self) -> tuple[JudgedEquilibrium, ...] | None:
        """Equilibria of the square beside the checked point; None where they were not searched for."""
        ...

    @property
    def theta_is_weakly_stable(self) -> bool | None:
        """Whether some solution keeps theta near its start; None where that is not decided."""
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

    def decided(self, work: Workspace) -> Result:
        """What the clause says; where rounded numbers alone say so, that nothing is decided.

        Raises:
            RefusalError: where the motion is not determined.
        """
        field = work.scene.field
        before = field.rounded_signs
        result = self.decide(work)
        if field.rounded_signs == before:
            return result
        work.distrust_parts()
        open_result = self.undecided(result, work.rounding_reason)
        if open_result is not result:
            work.by_rounding.add(self.name)
        return open_result

    def settles(self, result: Result) -> tuple[Theorem4, str] | None:
        """The theorem's verdict and its reason where this clause decides it alone, whatever the later ones say."""
        return None

    def is_open(self, result: Result) -> bool:
        """Whether the theorem stays undecided for want of this clause."""
        return False

    def applies(self, result: Result) -> bool:
        """Whether the hypotheses of the clause are met; one that does not apply leaves the theorem as it is."""
        return True

    def proviso(self, result: Result) -> str:
        """On which condition the clause holds, to be said where the theorem does; empty where there is none."""
        return ""

    def facts(self, result: Result, check: CheckedArray) -> Iterator[Fact]:
        """What else there is to say beside verdict and reason."""
        yield from ()


# ---- A point that shows why a clause says no more than it does -----------------------------------


@dataclass(frozen=True)
class Witness:
    """A point and the exact value that refutes or limits a claim there."""

    point: Point
    value: Number
    meaning: str


def witness_record(witness: Witness | None, value: str) -> Record | None:
    """A point with its value under the name ``value``, and what it means, as JSON holds it."""
    if witness is None:
        return None
    return {"point": Quantity(witness.point), value: Quantity(witness.value), "meaning": witness.meaning}
