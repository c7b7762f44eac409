"""Reference paths at 60 digits: Taylor series on each piece, events isolated by ball arithmetic, then the next piece.

A field of polynomials is expanded about a state by Picard iteration on truncated series (python-flint), to an order
and step at which the remainder is below ``10**-DIGITS``.  The first root of a side within a step is isolated by
bisection: a ball that excludes zero, or a slope that does, settles an interval.  Only crossings are followed.  Where a
path would slide, meets a corner or touches a side without crossing it, the reference ends there and says so: what it
has computed until then is right, what comes later is not its business.  It shares no code with the integrators.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, TypeAlias

from flint import arb, arb_poly, arb_series, ctx

BITS = 320  # 96 digits: 60 remain after everything that follows
ORDER = 64  # terms of a series
DIGITS = 70  # decimal digits to which a step is accurate
MAX_STEPS = 400
HALVINGS = 260  # of an interval, in search of a root: beyond, it is a point of contact

Series: TypeAlias = Any  # arb_series
Ball: TypeAlias = Any  # arb
State: TypeAlias = list[Ball]
Form: TypeAlias = Callable[[Sequence[Series]], Series]
Velocity: TypeAlias = Callable[[Sequence[Series]], list[Series]]


@dataclass(frozen=True)
class ReferencePiece:
    """A piece: functions that are positive inside, and the velocity, both callable on series."""

    sides: tuple[Form, ...]
    velocity: Velocity


@dataclass(frozen=True)
class Reached:
    """Where a reference path ends: time, state, crossings passed, and why (empty: the time is over)."""

    time: float
    state: tuple[Any, ...]
    crossings: int = 0
    reason: str = ""


@contextmanager
def precision() -> Iterator[None]:
    """Working precision and length of series for the reference."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = BITS, ORDER
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


def follow_series(pieces: Sequence[ReferencePiece], start: Sequence[float], until: float) -> Reached:
    """Follow a path over crossings, in steps of Taylor series.

    Args:
        pieces: the field.
        start: initial state, read as the binary fractions that the floats are.
        until: last time.

    Raises:
        ValueError: for a start that is not inside one piece.
    """
    with precision():
        state, time, last = [arb(float(x)) for x in start], arb(0), arb(float(until))
        holders = _holding(pieces, state)
        if len(holders) != 1:
            raise ValueError(f"required a start inside one piece, received {list(start)} in {len(holders)}")
        piece, entered, crossings = holders[0], None, 0
        for _ in range(MAX_STEPS):
            series, left = _expand(piece, state), (last - time).mid()
            step = _step_size(series, left)
            met = _first_side(piece, series, step, entered)
            if met is None:
                state, time, entered = [_value(s, step) for s in series], (time + step).mid(), None
                if step is left:
                    return _path(last, state, crossings)
                continue
            side, root = met
            state, time = [_value(s, root) for s in series], (time + root).mid()
            following = None if side is None else _beyond(pieces, piece, side, state)
            if following is None:
                return _path(time, state, crossings, "the path slides, touches a surface or meets a corner")
            piece, entered, crossings = (*following, crossings + 1)
        return _path(time, state, crossings, f"{MAX_STEPS} steps")


def _path(time: Ball, state: State, crossings: int, reason: str = "") -> Reached:
    return Reached(float(time.mid()), tuple(float(x.mid()) for x in state), crossings, reason)


def _expand(piece: ReferencePiece, state: State) -> list[Series]:
    """Taylor series of the path from a state: each Picard iteration makes one more coefficient right."""
    start = [arb_series([x.mid()], prec=ORDER) for x in state]
    series = start
    for order in range(2, ORDER + 1):
        rates = piece.velocity([arb_series(list(s)[:order], prec=order) for s in series])
        series = [x + arb_series(list(rate), prec=ORDER - 1).integral() for x, rate in zip(start, rates, strict=True)]
    return [arb_series(list(s), prec=ORDER) for s in series]


def _step_size(series: Sequence[Series], left: Ball) -> Ball:
    """Largest step at which the last coefficients stay below the accuracy, relative to the state."""
    size = max((abs(s[0].mid()) for s in series), key=float)
    wanted = (size if size else arb(1)) * arb(10) ** -DIGITS
    step = left
    for s in series:
        for k in (ORDER - 2, ORDER - 3):
            last = abs(s[k].mid())
            if last:
                step = min(step, ((wanted / last).log() / k).exp().mid())
    return step


def _value(series: Series, time: Ball) -> Ball:
    """Value of a series, without its ball: errors are far below the 60 digits."""
    value: Any = arb_poly(list(series))(time)
    return value.mid()


def _first_side(
    piece: ReferencePiece, series: Sequence[Series], step: Ball, entered: int | None
) -> tuple[int | None, Ball] | None:
    """The side that is met first, with its time; None within the step for none, as side for a contact."""
    best: tuple[int | None, Ball] | None = None
    for k, side in enumerate(piece.sides):
        coefficients = list(side(series))
        if not any(c.mid() for c in coefficients[1:]):
            continue
        form = arb_poly([c.mid() for c in coefficients])
        if k == entered:  # the root at zero is where the path has come from
            form = arb_poly([c.mid() for c in coefficients[1:]])
        found = _first_root(form, step)
        if found is not None and (best is None or found[1] < best[1]):
            best = (k if found[0] else None, found[1])
    return best


def _first_root(form: Any, step: Ball) -> tuple[bool, Ball] | None:
    """First root in ``(0, step)`` of a polynomial that is positive at first; False with it for a mere contact."""
    slope, waiting = form.derivative(), [(arb(0), step, 0)]
    while waiting:
        low, high, depth = waiting.pop()
        whole = arb((low + high).mid() / 2, (high - low).mid() / 2)
        value = form(whole)
        if value > 0:
            continue
        if not slope(whole).contains(0):
            if form(high) < 0:
                return True, _root(form, low, high)
            if not form(high) > 0:  # zero as far as the digits go
                return False, low
            continue
        if depth > HALVINGS:
            return False, low
        middle = ((low + high) / 2).mid()
        waiting += [(middle, high, depth + 1), (low, middle, depth + 1)]
    return None


def _root(form: Any, low: Ball, high: Ball) -> Ball:
    """Bisection between values of opposite signs."""
    for _ in range(BITS):
        middle = ((low + high) / 2).mid()
        low, high = (middle, high) if form(middle).mid() > 0 else (low, middle)
    return ((low + high) / 2).mid()


def _constants(state: State, terms: int = 1) -> list[Series]:
    return [arb_series([x], prec=terms) for x in state]


def _holding(pieces: Sequence[ReferencePiece], state: State) -> list[ReferencePiece]:
    """Pieces whose interior holds a state."""
    at = _constants(state)
    return [piece for piece in pieces if all(side(at)[0] > 0 for side in piece.sides)]


def _beyond(
    pieces: Sequence[ReferencePiece], left: ReferencePiece, side: int, state: State
) -> tuple[ReferencePiece, int] | None:
    """The piece on the other side and its side that was entered by; None where it does not take the path on."""
    at, small = _constants(state), arb(10) ** -(DIGITS - 5)
    scale = max(abs(x.mid()) for x in state)
    around = [piece for piece in pieces if all(s(at)[0] > -small * (1 + scale) for s in piece.sides)]
    if len(around) != 2:
        return None
    other = around[0] if around[1] is left else around[1]
    tight = [k for k, s in enumerate(other.sides) if abs(s(at)[0]) < small * (1 + scale)]
    if len(tight) != 1:
        return None
    here, onward = _constants(state, 2), arb_series([0, 1], prec=2)
    moved = [x + v * onward for x, v in zip(here, other.velocity(here), strict=True)]
    rate = list(other.sides[tight[0]](moved))
    return (other, tight[0]) if len(rate) > 1 and rate[1] > 0 else None
