"""The clauses of a check, in the order in which they are decided, concluded from and shown."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from nonsmooth.proofs.clauses.clause import Clause
from nonsmooth.proofs.clauses.equilibrium.clause import EquilibriumClause
from nonsmooth.proofs.clauses.feedback.clause import FeedbackClause
from nonsmooth.proofs.clauses.rotation.clause import RotationClause
from nonsmooth.proofs.clauses.translation.clause import TranslationClause
from nonsmooth.proofs.clauses.workspace import ClauseResult, Workspace
from nonsmooth.proofs.findings import Theorem4

CLAUSES: tuple[Clause[Any], ...] = (EquilibriumClause(), TranslationClause(), RotationClause(), FeedbackClause())


def decide_clauses(work: Workspace, left_out: str = "") -> Mapping[str, ClauseResult]:
    """The results of all clauses but one by name, each decided from the earlier ones and what they share.

    Raises:
        RefusalError: where the motion is not determined.
    """
    for clause in (each for each in CLAUSES if each.name != left_out):
        with work.timed(clause.name):
            work.earlier[clause.name] = clause.decided(work)
    return work.earlier


def conclude(results: Mapping[str, ClauseResult]) -> tuple[Theorem4, str]:
    """The theorem's verdict from the clauses', and the clause that decided it."""
    for clause in CLAUSES:
        settled = clause.settles(results[clause.name])
        if settled is not None:
            return settled
    for clause in CLAUSES:
        result = results[clause.name]
        if clause.is_open(result):
            return Theorem4.UNDECIDED, f"{clause.name}, {result.verdict}: {result.reason}"
    provisos = [clause.proviso(results[clause.name]) for clause in CLAUSES]
    more = "".join(f"; {proviso}" for proviso in provisos if proviso)
    left = [clause.name for clause in CLAUSES if not clause.applies(results[clause.name])]
    if left:
        return Theorem4.HOLDS, f"every clause that applies holds; not applicable: {', '.join(left)}{more}"
    return Theorem4.HOLDS, f"every clause holds{more}"
