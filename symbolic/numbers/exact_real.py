"""What exact numbers and polynomials share: differences, mirrored operations and the order follow from a few."""

from __future__ import annotations

from abc import abstractmethod
from typing import Any, Self


class ExactRing:
    """Commutative ring: the derived operations, from ``+``, ``-x``, ``*`` and the reading of an operand."""

    __slots__ = ()

    @abstractmethod
    def _operand(self, value: Any) -> Self | None:
        """The value as an element of this ring; None where it is not one."""

    @abstractmethod
    def __add__(self, value: Any) -> Self: ...

    @abstractmethod
    def __neg__(self) -> Self: ...

    @abstractmethod
    def __mul__(self, value: Any) -> Self: ...

    def __radd__(self, value: Any) -> Self:
        return self + value

    def __rmul__(self, value: Any) -> Self:
        return self * value

    def __pow__(self, exponent: int) -> Self:
        if not isinstance(exponent, int):
            return NotImplemented
        result, base, power = self * 0 + 1, self, exponent
        while power > 0:
            result = result * base if power & 1 else result
            power >>= 1
            base = base * base if power else base
        return result

    def __pos__(self) -> Self:
        return self

    def __sub__(self, value: Any) -> Self:
        other = self._operand(value)
        return NotImplemented if other is None else self + (-other)

    def __rsub__(self, value: Any) -> Self:
        return -self + value


class ExactReal(ExactRing):  # noqa: PLW1641  # classes with a canonical form give a hash
    """Real number with a certified sign, from which the order follows.

    It has no hash, unless a class gives it one: equality needs arithmetic.
    """

    __slots__ = ()

    @abstractmethod
    def sign(self) -> int:
        """Certified sign: -1, 0 or 1."""

    def __abs__(self) -> Self:
        return -self if self.sign() < 0 else self

    def _compare(self, value: Any) -> int | None:
        """Sign of the difference; None where the value is no number of the field."""
        other = self._operand(value)
        if other is None:
            return None
        return 0 if other is self else (self - other).sign()

    def __bool__(self) -> bool:
        return self.sign() != 0

    def __eq__(self, value: object) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order == 0

    def __lt__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order < 0

    def __le__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order <= 0

    def __gt__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order > 0

    def __ge__(self, value: Any) -> bool:
        order = self._compare(value)
        return NotImplemented if order is None else order >= 0
