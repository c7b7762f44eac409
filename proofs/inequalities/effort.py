"""How much work the inequalities of one question may take together: counted, so that no machine's speed matters.

Each inequality has limits of its own (:mod:`nonsmooth.proofs.inequalities.prover`); many that are all hard still take
minutes.  Inside :func:`shared_effort` they draw on one meter, in coefficients looked at.  What it no longer pays for is
left undecided, after a little work on each inequality still; nothing that is shown depends on it.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar

from nonsmooth.symbolic.numbers.work_limit import UNLIMITED, WorkMeter

_meter: ContextVar[WorkMeter | None] = ContextVar("effort", default=None)


def effort_left() -> int:
    """The work that may still be done."""
    meter = _meter.get()
    return UNLIMITED if meter is None else max(meter.left, 0)


def take_effort(units: int) -> None:
    """Note work that is done."""
    meter = _meter.get()
    if meter is not None:
        meter.left -= units


def require_effort(units: int) -> None:
    """Take work that nothing can be said without.

    Raises:
        WorkLimitError: where none is left.
    """
    meter = _meter.get()
    if meter is not None:
        meter.spend(units)


@contextmanager
def shared_effort(units: int) -> Iterator[None]:
    """Limit the work inside a block; within another block, what is done counts for both."""
    outer = _meter.get()
    inner = WorkMeter(units) if outer is None else outer.within(units)
    token = _meter.set(inner)
    try:
        yield
    finally:
        _meter.reset(token)
        take_effort(inner.units - inner.left)


@contextmanager
def effort_of_its_own(units: int) -> Iterator[None]:
    """The same apart from all others: for what is decided again later and must come out equal."""
    token = _meter.set(WorkMeter(units))
    try:
        yield
    finally:
        _meter.reset(token)
