"""The one verification of a verdict: what the stand-alone checker says of the text of its certificate.

Evidence is confirmed exactly, or in balls, where it is found.  This asks somebody else: the text of the certificate is
read as ``nonsmooth verify`` reads a file, and the checker derives from the subject what the claims need.
"""

from __future__ import annotations

from collections.abc import Callable

from nonsmooth.proofs.checker.files import parse
from nonsmooth.proofs.checker.statements import not_among, show_evidence
from nonsmooth.proofs.checker.work import MALFORMED, LimitError, RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.subject import NoCertificateError


class UnverifiedError(RuntimeError):
    """A verdict that the checker rejects: a fault of this program, never shown as a verdict."""

    def __init__(self, why: str) -> None:
        expected = "required a verdict that the checker accepts, received one that it rejects: please report this"
        super().__init__(f"{expected} (required {why})")


def verified(certificate: Record, text: Callable[[Record], str]) -> Record:
    """The certificate as the checker accepts it: without claims of kinds that its theorems leave open.

    Args:
        certificate: with all that is claimed.
        text: what is written of it.

    Raises:
        NoCertificateError: where nothing is left, and beyond the limits of the checker.
        UnverifiedError: where the checker rejects evidence, or shows another claim of the same kind.
    """
    try:
        claims, shown = show_evidence(*parse(text(certificate).encode()))
    except LimitError as error:
        raise NoCertificateError(f"certificate: required {error}") from None
    except (RejectedError, *MALFORMED) as error:
        raise UnverifiedError(str(error)) from error
    kinds = {kind for statement in shown for kind in statement}
    spoken_of = [claim for claim in claims if not kinds.isdisjoint(claim)]
    if not spoken_of:
        raise NoCertificateError(f"certificate: the stand-alone checker shows none of {claims}")
    for claim in not_among(shown, spoken_of):
        raise UnverifiedError(f"evidence of the claim {str(claim)[:200]}")
    return {**certificate, "statement": {**certificate["statement"], "claims": spoken_of}}
