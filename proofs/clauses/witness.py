"""A point that shows why a clause says no more than it does."""

from __future__ import annotations

from dataclasses import dataclass

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.findings.facts import Quantity, Record
from nonsmooth.symbolic.numbers.number import Number


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
