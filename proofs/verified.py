"""The last check before a verdict is shown: evidence that does not verify is a fault of the program, no verdict."""

from __future__ import annotations

from typing import Protocol, TypeVar


class SelfChecking(Protocol):
    """A result that can verify itself."""

    def check(self) -> bool:
        """Whether the evidence verifies."""
        ...


class Evident(Protocol):
    """A result that can verify its evidence alone."""

    def evidence_holds(self) -> bool:
        """Whether the evidence verifies."""
        ...


Result = TypeVar("Result", bound=SelfChecking)
EvidentResult = TypeVar("EvidentResult", bound=Evident)


def verified(result: Result) -> Result:
    """The result, after its evidence has been checked once more.

    Raises:
        RuntimeError: if it does not verify.
    """
    _require(result.check())
    return result


def with_evidence(result: EvidentResult) -> EvidentResult:
    """The same for one of many results that were decided a moment ago: none of it is decided again.

    Raises:
        RuntimeError: if its evidence does not verify.
    """
    _require(result.evidence_holds())
    return result


def _require(holds: bool) -> None:
    if not holds:
        raise RuntimeError("required evidence that verifies, received evidence that does not: please report this")
