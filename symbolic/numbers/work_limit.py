"""A limit on the exact arithmetic of one field, so that no scene keeps the machine busy for ever.

Operations are counted, not seconds: equal input ends equally, however fast the machine is.  One unit is about the
work of one product of short rationals, a microsecond or two with what surrounds it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Protocol


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

    def within(self, units: int) -> WorkMeter:
        """A meter of a smaller limit inside this one."""
        return WorkMeter(min(units, self.left))


class WatchedMeter(WorkMeter):
    """Counts down, and every so often calls a function, which may end the work by an exception.

    Args:
        units: what may be spent.
        look_up: the function.
    """

    STEP = 200  # units between two calls: some milliseconds, with what surrounds the arithmetic

    def __init__(self, units: int, look_up: Callable[[], None]) -> None:
        super().__init__(units)
        self._look_up, self._next = look_up, max(0, units - self.STEP)  # never below zero: see spend

    def spend(self, units: int) -> None:
        """See :class:`WorkMeter`; almost every product ends at the first comparison."""
        self.left -= units
        if self.left >= self._next:
            return
        if self.left < 0:
            raise WorkLimitError(self.units)
        self._next = max(0, self.left - self.STEP)
        self._look_up()

    def within(self, units: int) -> WorkMeter:
        """See :class:`WorkMeter`."""
        return WatchedMeter(min(units, self.left), self._look_up)


class Metered(Protocol):
    """What counts its arithmetic while it has a meter: a number field."""

    meter: WorkMeter | None


UNLIMITED = 1 << 62  # units: more than any machine does


@contextmanager
def watched(field: Metered, look_up: Callable[[], None]) -> Iterator[None]:
    """Call a function every so often while a field is computed in; it ends the work by raising an exception."""
    outer = field.meter
    field.meter = WatchedMeter(UNLIMITED, look_up)
    try:
        yield
    finally:
        field.meter = outer


@contextmanager
def work_limit(field: Metered, units: int) -> Iterator[None]:
    """Limit the arithmetic of a field inside a block; within another limit, what is spent counts for both.

    Raises:
        WorkLimitError: at the operation that goes beyond the limit.
    """
    outer = field.meter
    inner = WorkMeter(units) if outer is None else outer.within(units)
    field.meter = inner
    try:
        yield
    finally:
        field.meter = outer
        if outer is not None:
            outer.left -= inner.units - max(inner.left, 0)
