"""What the clauses of Theorem 4 say, in a form that tests compare."""

from __future__ import annotations

from nonsmooth.proofs.theorem4_result import CellCheck
from nonsmooth.symbolic.numbers.number import Number


def verdicts(result: CellCheck) -> list[str]:
    """The conclusion and the verdicts of the four clauses."""
    clauses = (result, result.equilibrium, result.translation, result.rotation, result.feedback)
    return [clause.verdict.value for clause in clauses]


def drift(result: CellCheck) -> tuple[Number, ...]:
    """Both ends of the range of rotation rates at rest; empty where nothing rests."""
    return () if result.rotation.drift is None else result.rotation.drift.interval
