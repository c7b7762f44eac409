"""``nonsmooth verify``: a certificate, re-checked by the stand-alone checker."""

from __future__ import annotations

from typing import Annotated

import typer

from nonsmooth.reports.console import BAD_INPUT, RefusedError, write


def verify(
    file: Annotated[str, typer.Argument(metavar="CERTIFICATE", help="A file written by check --certificate.")],
) -> int:
    """Re-check a certificate with the stand-alone checker, which trusts nothing else of this program.

    Exit status: 0 accepted, 1 rejected, 2 no certificate.
    """
    from nonsmooth.proofs.checker import check_file

    status, message = check_file(file)
    if status == BAD_INPUT:
        raise RefusedError(f"{file}: required a certificate, received a file that is {message}")
    write(f"{message}\n")
    return status
