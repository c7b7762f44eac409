"""A limit on the exact arithmetic of one field, so that no scene keeps the machine busy for ever.

Operations are counted, not seconds: equal input ends equally, however fast the machine is.  One unit is about the
work of one product of short rationals, a microsecond or two with what surrounds it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from nonsmooth.symbolic.numbers.number_field import NumberField


class WorkLimitError(Exception):
    """More exact arithmetic than is allowed.

    Attributes:
        units: the limit.
    """

    def __init__(self, units: int) -> None:
        super().__init__(f"required exact arithmetic within {units} operations")
        self.units = units


class WorkMeter:
    """Counts down.

    Args:
        units: what may be spent.
    """

    def __init__(self, units: int) -> None:
        self.units, self.left = units, units

    def spend(self, units: int) -> None:
        """Take units.

        Raises:
            WorkLimitError: once none are left.
        """
        self.left -= units
        if self.left < 0:
            raise WorkLimitError(self.units)


@contextmanager
def work_limit(field: NumberField, units: int) -> Iterator[None]:
    """Limit the arithmetic of a field inside a block; within another limit, what is spent counts for both.

    Raises:
        WorkLimitError: at the operation that goes beyond the limit.
    """
    outer = field.meter
    inner = WorkMeter(units if outer is None else min(units, outer.left))
    field.meter = inner
    try:
        yield
    finally:
        field.meter = outer
        if outer is not None:
            outer.left -= inner.units - max(inner.left, 0)
