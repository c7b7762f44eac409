"""What a certificate states, and whether its evidence shows it.

A certificate of version ``nonsmooth-certificate/2`` has three entries, and notes that nobody reads.  The *statement*
names its subject, a plain system or an array of driven wheels, and claims about it.  The *evidence* is a list of
theorems, each with its hypotheses and, by name, the proofs of what these need.  Every theorem derives from the subject
what that is, so a forger cannot leave anything out; what it shows is a list of claims.  The certificate is valid if
every claim of the statement is among those that were shown.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, TypeAlias

from .approach import show_approach
from .array_basin import show_array_basin
from .basin import show_basin
from .cells import System
from .circles import show_on_circles
from .outside import show_outside
from .parts import ABOUT_PARTS, show_scaled
from .positivity import Proofs
from .roots import read_subject
from .theorem4 import show_theorem4
from .theorems import Statement
from .tolerances import show_tolerances
from .wheels import Array, read_array
from .work import BUDGET, MALFORMED, RejectedError, items, require, take

VERSION = "nonsmooth-certificate/2"
MAX_THEOREMS = 20

Theorem: TypeAlias = Callable[[Any, Any, Proofs], list[Statement]]  # of a subject and hypotheses: what it shows

THEOREMS: dict[str, Theorem] = {  # of systems
    **ABOUT_PARTS,
    "homogeneous": show_scaled,
    "approach": show_approach,
    "basin": show_basin,
    "circles": show_on_circles,
    "outside": show_outside,
}
OF_ARRAYS: dict[str, Theorem] = {
    "theorem 4": show_theorem4,
    "tolerances": show_tolerances,
    "basin": show_array_basin,
}


def is_of_array(subject: Any) -> bool:
    """Whether a subject is an array of driven wheels; else it is a plain system."""
    return type(subject) is dict and "wheels" in subject


def show_claims(data: Any, size: int) -> list[Statement]:
    """Show every claim of a certificate.

    Args:
        data: parsed JSON.
        size: its length in bytes, which limits the work.

    Returns:
        The claims of its statement.

    Raises:
        RejectedError: for a claim that is not shown.
    """
    claims, conclusions = show_evidence(data, size)
    for claim in not_among(conclusions, claims):
        require(False, f"evidence of the claim {json.dumps(claim)[:200]}")
    require(claims, "a claim")
    return claims


def show_evidence(data: Any, size: int) -> tuple[list[Statement], list[Statement]]:
    """What a certificate claims, and what its evidence shows of its subject, whatever it claims.

    Raises:
        RejectedError: for a hypothesis that is not shown.
    """
    with BUDGET.granted(size):
        version, statement, evidence, _ = take(data, "version statement evidence", "notes")
        require(version == VERSION, f"the version {VERSION}")
        about, claims = take(statement, "subject claims")
        subject = read_array(about) if is_of_array(about) else read_subject(about)
        conclusions: list[Statement] = []
        for entry in items(evidence, most=MAX_THEOREMS):
            conclusions += show_entry(subject, entry)
        return items(claims), conclusions


def not_among(conclusions: list[Statement], claims: list[Statement]) -> list[Statement]:
    """The claims that are not among what was shown."""
    texts = {json.dumps(statement, sort_keys=True) for statement in conclusions}  # which tell truth values from numbers
    return [claim for claim in claims if json.dumps(claim, sort_keys=True) not in texts]


def show_entry(subject: System | Array, entry: Any) -> list[Statement]:
    """What one theorem shows of a subject by its proofs.

    Raises:
        RejectedError: for a hypothesis that is not shown, and for proofs of what is not asked.
    """
    theorem, hypotheses, data = take(entry, "theorem hypotheses proofs")
    theorems = OF_ARRAYS if isinstance(subject, Array) else THEOREMS
    require(type(theorem) is str and theorem in theorems, f"a theorem of {', '.join(theorems)}")
    proofs = Proofs(data)
    conclusions = theorems[theorem](subject, hypotheses, proofs)
    proofs.require_used()
    return conclusions


def refusal(data: Any, size: int) -> str:
    """Why a certificate is rejected, in one line; empty where it is valid."""
    try:
        show_claims(data, size)
    except RejectedError as error:
        return str(error)
    except MALFORMED as error:
        return f"well-formed data, not a {type(error).__name__}"
    return ""
