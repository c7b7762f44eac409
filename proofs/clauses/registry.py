"""The clauses of a check, in the order in which they are decided, concluded from and shown."""

from __future__ import annotations

from typing import Any

from nonsmooth.proofs.clauses.clause import Clause
from nonsmooth.proofs.clauses.equilibrium.clause import EquilibriumClause
from nonsmooth.proofs.clauses.feedback.clause import FeedbackClause
from nonsmooth.proofs.clauses.rotation.clause import RotationClause
from nonsmooth.proofs.clauses.translation.clause import TranslationClause

CLAUSES: tuple[Clause[Any], ...] = (EquilibriumClause(), TranslationClause(), RotationClause(), FeedbackClause())
