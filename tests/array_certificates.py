"""The parts of certificates of arrays, for tests that look at them or change them."""

from __future__ import annotations

import json
from typing import Any, TypeAlias

from nonsmooth.proofs.checker.statements import refusal

Record: TypeAlias = dict[str, Any]


def check_certificate(certificate: Any) -> str:
    """The claim that the checker does not show; empty for a valid certificate."""
    return refusal(certificate, len(json.dumps(certificate)))


def subject(certificate: Record) -> Record:
    """The array: wheels, rule, loads, point, radius, and the field of its numbers."""
    own: Record = certificate["statement"]["subject"]
    return own


def evidence(certificate: Record) -> Record:
    """Points, cells and disc of theorem 4."""
    own: Record = certificate["evidence"][0]["hypotheses"]
    return own


def proofs(certificate: Record) -> Record:
    """The evidence of the clauses, by name."""
    own: Record = certificate["evidence"][0]["proofs"]
    return own


def said(certificate: Record) -> Record:
    """What is claimed, by kind."""
    return {kind: about for claim in certificate["statement"]["claims"] for kind, about in claim.items()}


def say(certificate: Record, **changes: Any) -> None:
    """Claim something else of some kinds, or nothing where None is given; ``theorem4`` stands for ``theorem 4``."""
    own = {**said(certificate), **{kind.replace("theorem4", "theorem 4"): about for kind, about in changes.items()}}
    certificate["statement"]["claims"] = [{kind: about} for kind, about in own.items() if about is not None]


def claim_rate(certificate: Record, rate: Any) -> None:
    """Claim that bodies from the disc arrive at another rate; at none where None is given."""
    evidence(certificate)["rate"] = rate
    arrival = {"squared_radius": evidence(certificate)["disc"], "rate": rate}
    say(certificate, arrival=None if rate is None else arrival)


def claim_disc(certificate: Record, squared_radius: Any) -> None:
    """Claim a disc of another size, and the same of V* on it, and the same rate if there is a disc."""
    evidence(certificate)["disc"] = squared_radius
    if "rate" in evidence(certificate):
        claim_rate(certificate, None if squared_radius is None else evidence(certificate)["rate"])
    say(
        certificate, disc={**said(certificate).get("disc", {"decreases": "strictly"}), "squared_radius": squared_radius}
    )
