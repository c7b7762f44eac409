"""What a certificate is about: a switched system as the checker reads it."""

from __future__ import annotations

from typing import Any

from nonsmooth.proofs.systems.system_certificate import about
from nonsmooth.symbolic.switched_system import SwitchedSystem


def subject_of(system: SwitchedSystem) -> dict[str, Any]:
    """The subject of certificates: the stated formulas and point, and the states of which the roots are meant.

    Raises:
        NoCertificateError: for a point with irrational entries.
    """
    roots = {} if system.by_roots is None else {"roots": list(system.by_roots.roots.rooted)}
    return {**about(system), **roots}
