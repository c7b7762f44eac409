"""The last check before a verdict is shown: evidence that does not verify is a fault of the program, no verdict."""

from __future__ import annotations

from typing import Protocol, TypeVar


class SelfChecking(Protocol):
    """A result that can verify its own evidence."""

    def check(self) -> bool:
        """Whether the evidence verifies."""
        ...


Result = TypeVar("Result", bound=SelfChecking)


def verified(result: Result) -> Result:
    """The result, after its evidence has been checked once more.

    Raises:
        RuntimeError: if it does not verify.
    """
    if not result.check():
        raise RuntimeError("required evidence that verifies, received evidence that does not: please report this")
    return result
