"""Refusals, the shapes of JSON that a certificate may have, and a budget of work, charged by the bits of numbers.

*Work.*  A product or a sum of rational numbers with a and b bits costs ``1 + (a b) / 4096`` units; every function that
loops over data of a certificate charges its steps before it does them.  A certificate of N bytes may cost at most
``5e6 + 400 N`` units.  Hence no certificate keeps the checker busy for longer than a time that grows in proportion to
its length.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from typing import Any

MAX_BYTES = 64 << 20
MAX_DIGITS = 4_000  # of a numerator or a denominator
BASE_WORK, WORK_PER_BYTE = 5_000_000, 400
UNLIMITED = 1 << 62

RATIONAL = re.compile(rf"-?[0-9]{{1,{MAX_DIGITS}}}(/[0-9]{{1,{MAX_DIGITS}}})?")

# What data of another form than a certificate's raise while they are read.
MALFORMED = (
    KeyError,
    TypeError,
    ValueError,
    IndexError,
    AttributeError,
    ArithmeticError,
    RecursionError,
    MemoryError,  # of Python's parser, where brackets are nested too deeply
    SyntaxError,
)


class RejectedError(ValueError):
    """A claim that does not hold, is not shown, or is shown by too much work."""


class LimitError(RejectedError):
    """A certificate that asks for more than the checker looks at; what it says may be true."""


def limit(within: object, claim: str) -> None:
    """Reject the certificate unless it keeps to a limit.

    Raises:
        LimitError: with the limit.
    """
    if not within:
        raise LimitError(claim)


def require(holds: object, claim: str) -> None:
    """Reject the certificate unless something holds.

    Raises:
        RejectedError: with the claim.
    """
    if not holds:
        raise RejectedError(claim)


class Budget:
    """The units of work that are left; while no certificate is checked, more than there are."""

    def __init__(self) -> None:
        self.left = UNLIMITED

    @contextmanager
    def granted(self, size: int) -> Iterator[None]:
        """Check a certificate of a number of bytes, and no more after it."""
        self.left = BASE_WORK + WORK_PER_BYTE * size
        try:
            yield
        finally:
            self.left = UNLIMITED

    def spend(self, units: int) -> None:
        """Charge some units.

        Raises:
            LimitError: where fewer are left.
        """
        self.left -= units
        if self.left < 0:
            raise LimitError("a certificate that is checked within the limits of work")


BUDGET = Budget()


def bits(value: Any) -> int:
    """The length of a number: of a fraction, or of an irrational one as it says itself."""
    if hasattr(value, "numerator"):
        return value.numerator.bit_length() + value.denominator.bit_length()
    return value.bits


def product_cost(a: int, b: int) -> int:
    """The units of a product, or of a sum, of rational numbers with a and b bits."""
    return 1 + a * b // 4096


def longest(values: Iterable[Any]) -> int:
    """The length of the longest of some numbers."""
    return max(map(bits, values), default=1)


# ---- shapes of JSON ----------------------------------------------------------------------------


def take_once(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """An object of JSON in which no key stands twice.

    Raises:
        RejectedError: where one does.
    """
    entries = dict(pairs)
    require(len(entries) == len(pairs), "every key once")
    return entries


def take(data: Any, names: str, optional: str = "") -> list[Any]:
    """The values of an object by their keys, in the order of the names; None for an optional one that is missing.

    Raises:
        RejectedError: for data that are no object, and for keys that are missing or not known.
    """
    needed, allowed = names.split(), optional.split()
    known = type(data) is dict and set(needed) <= set(data) <= {*needed, *allowed}
    require(known, f"an object with the keys {' '.join([*needed, *allowed])}")
    return [data.get(key) for key in (*needed, *allowed)]


def items(data: Any, count: int | None = None, *, most: int | None = None) -> list[Any]:
    """The items of a list.

    Args:
        data: of the certificate.
        count: how many there must be; any number where None.
        most: how many there may be.

    Raises:
        RejectedError: for anything else.
    """
    require(type(data) is list and count in (None, len(data)), f"a list of {'some' if count is None else count} items")
    limit(most is None or len(data) <= most, f"a list of at most {most} items")
    return list(data)


def text(data: Any, most: int = 4_000) -> str:
    """A text of limited length.

    Raises:
        RejectedError: for anything else.
    """
    require(type(data) is str, "a text")
    limit(len(data) <= most, f"a text of at most {most} characters")
    return str(data)


def whole(data: Any, most: int) -> int:
    """A whole number from 0 to a largest one.

    Raises:
        RejectedError: for anything else; truth values are no numbers.
    """
    require(type(data) is int and 0 <= data <= most, f"a whole number from 0 to {most}")
    return int(data)


def rational(data: Any) -> Fraction:
    """A number that is written as a text such as ``-3/4``.

    Raises:
        RejectedError: for anything else.
    """
    known = type(data) is str and RATIONAL.fullmatch(data)
    limit(known or type(data) is not str or len(data) <= MAX_DIGITS, f"numbers of at most {MAX_DIGITS} digits")
    require(known, "rational numbers as texts such as '-3/4'")
    BUDGET.spend(1 + len(data) ** 2 // 4096)
    return Fraction(data)
