"""What a certificate states, and whether its evidence shows it.

A certificate of version ``nonsmooth-certificate/2`` has three entries.  The *statement* names its subject and claims
about it.  The *evidence* is a list of theorems, each with what its hypotheses need.  Every theorem derives from the
subject which inequalities must be shown, so a forger cannot leave one out; what it shows is a list of claims.  The
certificate is valid if every claim of the statement is among those that were shown.

Exit status of the command: 0 valid, 1 rejected, 2 not readable.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable, Sequence
from typing import Any

from .cells import System, read_system
from .lyapunov import Statement, show_departure, show_instability, show_stability
from .work import BUDGET, MALFORMED, MAX_BYTES, RejectedError, items, require, take

VERSION = "nonsmooth-certificate/2"
MAX_THEOREMS = 20

THEOREMS: dict[str, Callable[[System, Any], list[Statement]]] = {
    "lyapunov": show_stability,
    "instability": show_instability,
    "departure": show_departure,
}


def check(data: Any, size: int) -> list[Statement]:
    """Show every claim of a certificate.

    Args:
        data: parsed JSON.
        size: its length in bytes, which limits the work.

    Returns:
        The claims of its statement.

    Raises:
        RejectedError: for a claim that is not shown.
    """
    BUDGET.grant(size)
    version, statement, evidence = take(data, "version statement evidence")
    require(version == VERSION, f"the version {VERSION}")
    subject, claims = take(statement, "subject claims")
    system = read_system(subject)
    shown: list[Statement] = []
    for entry in items(evidence, most=MAX_THEOREMS):
        theorem, hypotheses = take(entry, "theorem hypotheses")
        require(type(theorem) is str and theorem in THEOREMS, f"a theorem of {', '.join(THEOREMS)}")
        shown += THEOREMS[theorem](system, hypotheses)
    for claim in items(claims):
        require(claim in shown, f"evidence of the claim {json.dumps(claim)[:200]}")
    require(claims, "a claim")
    return list(claims)


def refusal(data: Any, size: int) -> str:
    """Why a certificate is rejected, in one line; empty where it is valid."""
    try:
        check(data, size)
    except RejectedError as error:
        return str(error)
    except MALFORMED as error:
        return f"well-formed data, not a {type(error).__name__}"
    return ""


def check_file(path: str) -> tuple[int, str]:
    """Exit status and what to print: 0 valid, 1 rejected, 2 not readable."""
    try:
        with open(path, "rb") as file:
            content = file.read(MAX_BYTES + 1)
        require(len(content) <= MAX_BYTES, f"at most {MAX_BYTES} bytes")
        data = json.loads(content)
    except (OSError, *MALFORMED) as error:
        return 2, f"unreadable: {error}"
    reason = refusal(data, len(content))
    if reason:
        return 1, f"rejected: required {reason}"
    lines = [json.dumps(claim) for claim in data["statement"]["claims"]]
    return 0, "\n".join(["valid", *lines])


def main(arguments: Sequence[str]) -> int:
    """Check one file."""
    if len(arguments) != 1:
        print("usage: python -I -S checker FILE")
        return 2
    status, line = check_file(arguments[0])
    print(line)
    return status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
