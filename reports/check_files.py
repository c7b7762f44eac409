"""The files that ``nonsmooth check`` writes about one check: its certificate and its feedback law."""

from __future__ import annotations

import sys
from collections.abc import Collection
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.reports.files import output_path, write_whole
from nonsmooth.reports.progress import end_progress
from nonsmooth.reports.refusals import RefusedError

if TYPE_CHECKING:
    from nonsmooth.proofs.system_decision import StabilityResult
    from nonsmooth.proofs.theorem4_result import CellCheck, SmoothCheck
    from nonsmooth.reports.interface.check_result import CheckResult

CERTIFICATES, LAWS = (".json",), (".py", ".csv")  # what these files may end in


@dataclass(frozen=True)
class CheckFiles:
    """Where they go; None where nobody asked.

    Attributes:
        certificate: of ``--certificate``.
        law: of ``--law``.
    """

    certificate: Path | None
    law: Path | None

    @classmethod
    def asked(cls, certificate: str | None, law: str | None, rules: int) -> CheckFiles:
        """The files of the options, refused before any work.

        Raises:
            RefusedError: for several contact rules.
            OutputError: for a file that cannot be written.
        """
        return cls(
            None if certificate is None else _output("--certificate", certificate, CERTIFICATES, rules),
            None if law is None else _output("--law", law, LAWS, rules),
        )

    def write(self, result: CheckResult) -> CheckResult:
        """Write what was asked for; the result, compared with it.

        Nothing is written of a check that contradicts itself.

        Raises:
            RefusedError: for a check that has no certificate, or no certified law.
        """
        certificate = None if self.certificate is None else _certificate(result.evidence)
        if certificate is not None:
            result = _compared(result, certificate)
        if result.contradictions:
            for path in filter(None, (self.certificate, self.law)):
                print(f"{path}: not written: what the check says contradicts itself", file=sys.stderr)
            return result
        if self.certificate is not None and certificate is not None:
            _write_certificate(certificate, result.evidence, self.certificate)
        if self.law is not None:
            _write_law(result, self.law)
        return result


def _compared(result: CheckResult, certificate: dict[str, Any]) -> CheckResult:
    """The result without what its certificate contradicts."""
    from nonsmooth.proofs.answers.contradictions import contradictions_of_certificate

    found = tuple(contradictions_of_certificate(certificate, result.evidence))
    if not found:
        return result
    left = replace(result, elsewhere=(*result.elsewhere, *found))
    _ = left.answers
    return left


def _output(option: str, target: str, suffixes: Collection[str], rules: int) -> Path:
    """Where a file about one check goes, refused before any work."""
    if rules > 1:
        raise RefusedError(f"{option}: required one contact rule, received all")
    return output_path(target, suffixes)


def _write_law(result: CheckResult, path: Path) -> None:
    """The certified law of one check."""
    from nonsmooth.reports.law_table import NoLawError

    try:
        result.law().save(path)
    except NoLawError as error:
        raise RefusedError(f"{result.evidence.scene.origin}: --law: {error}") from None


def _certificate(result: CellCheck | SmoothCheck) -> dict[str, Any]:
    """The certificate of one check."""
    from nonsmooth.proofs.certificate import CertificateError, build_certificate

    try:
        return build_certificate(result)
    except CertificateError as error:
        raise RefusedError(f"{result.scene.origin}: {error}") from None


def _write_certificate(certificate: dict[str, Any], result: CellCheck | SmoothCheck, path: Path) -> None:
    from nonsmooth.proofs.certificate import certificate_text, stated_words

    write_whole(path, certificate_text(certificate).encode())
    if stated_words(certificate).get("feedback", "undecided") != result.feedback.verdict:
        end_progress()
        print(f"{path}: feedback stands as undecided: the checker follows no law by directions of c", file=sys.stderr)


def write_system_certificate(result: StabilityResult, path: Path) -> None:
    """The certificate of a plain system.

    Raises:
        RefusedError: for a verdict that has none.
    """
    from nonsmooth.proofs.kernel.subject import NoCertificateError
    from nonsmooth.proofs.system_certificates import certificate_of, certificate_text, left_out

    try:
        certificate = certificate_of(result)
    except NoCertificateError as error:
        raise RefusedError(f"{result.scene.origin}: {error}") from None
    write_whole(path, certificate_text(certificate).encode())
    for line in left_out(certificate):
        print(f"{path}: left out: {line}", file=sys.stderr)
