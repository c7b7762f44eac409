"""Clause 3 of Theorem 4 as the check asks it, and what it says."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.clause import CheckedArray, Clause
from nonsmooth.proofs.clauses.rotation.at_point import spin_of
from nonsmooth.proofs.clauses.rotation.every_load import rotation_for_every_load
from nonsmooth.proofs.clauses.rotation.on_cells import Drift, RotationResult, decide_rotation
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.clauses.translation.every_load import EveryLoadTranslation
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.clauses.workspace import ClauseResult, Workspace
from nonsmooth.proofs.facts import Fact, Quantity, Record
from nonsmooth.proofs.verdicts import Rotation, Theorem4
from nonsmooth.symbolic.number_text import float_text


class RotationClause(Clause[RotationResult]):
    """Stability of theta: the range of omega that leaves c at rest."""

    name = "rotation"

    def decide(self, work: Workspace) -> RotationResult:
        """By two linear programs on cells; by the spin at the point without."""
        translation = work.earlier["translation"]
        if isinstance(translation, EllipseTranslation):
            return spin_of(work.point)
        return _rotation(translation, work.partition)

    def undecided(self, result: RotationResult, reason: str) -> RotationResult:
        """Neither a drift nor none."""
        return RotationResult(Rotation.UNDECIDED, None, None, reason)

    def settles(self, result: RotationResult) -> tuple[Theorem4, str] | None:
        """The theorem says that theta is unstable."""
        if result.verdict is Rotation.NEUTRAL:
            return Theorem4.FAILS, f"theta is stable: {result.reason}"
        return None

    def is_open(self, result: RotationResult) -> bool:
        """Whether theta drifts is not known."""
        return result.verdict is Rotation.UNDECIDED

    def facts(self, result: RotationResult, check: CheckedArray) -> Iterator[Fact]:
        """The drift at rest with the weights that attain it, and what some solution can keep."""
        yield Fact("weakly_stable", check.theta_is_weakly_stable)
        drift = result.drift
        if drift is None:
            yield from (Fact("drift", Quantity(result.spin)), Fact("weights"))
            return
        ends = tuple(map(float_text, drift.interval))
        yield Fact("drift", Quantity(drift.interval), "drift at rest: [{}, {}]", ends, explained=True)
        yield Fact("weights", _weights(drift))


def _rotation(translation: ClauseResult, partition: Partition | None) -> RotationResult:
    """The clause from that on translation, and the cells where there are any."""
    if isinstance(translation, EllipseTranslation):
        return spin_of(translation.point)
    if isinstance(translation, EveryLoadTranslation):
        return rotation_for_every_load(translation)
    if partition is None or not isinstance(translation, TranslationResult):
        raise TypeError("required cells for a clause on cells, received none")
    return decide_rotation(partition, translation)


def _weights(drift: Drift) -> Record:
    """The convex weights that rest in (x, y) and turn at the lowest and highest rate."""
    return {
        end: [{"twist": Quantity(drift.twists[k]), "weight": Quantity(w)} for k, w in mixture.weights.items()]
        for end, mixture in (("lowest", drift.lowest), ("highest", drift.highest))
    }
