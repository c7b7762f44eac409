"""Solutions of polynomial differential equations, enclosed by balls: steps of Taylor series with a proved remainder.

For ``z' = F(z)`` let ``c_k(Z)`` be the Taylor coefficients of the solutions from a box Z.  A box B that holds
``sum_{k<p} c_k(Z) [0, h]^k + c_p(B) [0, h]^p`` holds all solutions from Z for ``0 <= t <= h``: it encloses them
(Corliss & Rihm 1996, "Validating an a priori enclosure using high-order Taylor series"; Moore 1966).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeAlias

from flint import arb, arb_poly, arb_series, ctx

from nonsmooth.proofs.boxes.enclosures import UNIT

BITS = 160  # of balls
ORDER = 20  # of a step
ACCURACY = -80  # binary digits of the last terms of a step, relative to the state
LOOSEST = 2.0**-56  # the last terms, enclosed over all of a step, may be much larger than at its start
ENCLOSURES = 2  # attempts to enclose a step, before it is shortened
INFLATION = 2.0**-16  # by which a box is larger than the solutions from it, relative
SHORTENINGS = 60  # of a step, before enclosing it is given up

Ball: TypeAlias = Any  # arb
Box: TypeAlias = list[Any]  # of arb
Rates: TypeAlias = Callable[[Sequence[Any]], list[Any]]  # of balls or series


class UnprovedError(Exception):
    """Balls that do not show what has to be shown; the message says what."""


@contextmanager
def precision() -> Iterator[None]:
    """Working precision and length of series."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = BITS, ORDER + 1
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


@dataclass(frozen=True)
class EnclosedStep:
    """All solutions from a box over a time: coefficients of their Taylor series, the last over all of the step.

    Attributes:
        span: its length.
        series: for each entry ORDER + 1 coefficients.
        hull: a box that holds the solutions over the whole step.
    """

    span: Ball
    series: tuple[tuple[Ball, ...], ...]
    hull: Box

    @cached_property
    def _polynomials(self) -> list[Any]:
        return [arb_poly(list(entry)) for entry in self.series]

    def at(self, time: Ball) -> Box:
        """Box of the states at the times of a ball within the step."""
        return [polynomial(time) for polynomial in self._polynomials]


class Expansion:
    """The Taylor series of all solutions from a box, from which steps of any length are taken.

    Args:
        rates: of the differential equation.
        start: the box.
    """

    def __init__(self, rates: Rates, start: Box) -> None:
        self._rates, self._series = rates, expanded(rates, start)
        self._suitable = _suitable(self._series, start)

    def step(self, longest: Ball) -> EnclosedStep:
        """A step of a length that suits the order, at most the longest one.

        Raises:
            UnprovedError: where even a short one cannot be enclosed.
        """
        span = min(self._suitable, longest)
        for _ in range(SHORTENINGS):
            step = _enclosed(self._rates, self._series, span)
            if step is not None and all(abs(entry[ORDER]) * span**ORDER < LOOSEST for entry in step.series):
                return step
            span = (span * 3 / 4).mid()
        raise UnprovedError("no step of the path could be enclosed")


def expanded(rates: Rates, start: Box) -> list[tuple[Ball, ...]]:
    """Coefficients 0 ... ORDER of the Taylor series: each iteration makes one more right."""
    known: list[list[Ball]] = [[x] for x in start]
    for order in range(1, ORDER + 1):
        found = rates([arb_series(entry, prec=order) for entry in known])
        for entry, rate in zip(known, found, strict=True):
            entry.append(rate[order - 1] / order if isinstance(rate, arb_series) else rate * (order == 1))
    return [tuple(entry) for entry in known]


def _suitable(series: Sequence[Sequence[Ball]], start: Box) -> Ball:
    """Length at which the last terms are as small as wanted; infinite for a polynomial solution."""
    size = max([abs(x.mid()) for x in start] + [arb(1)], key=float)
    wanted, span = size * arb(2) ** ACCURACY, arb("inf")
    for entry in series:
        for k in (ORDER - 1, ORDER):
            last = abs(entry[k].mid())
            if last > 0:
                span = min(span, ((wanted / last).log() / k).exp().mid())
    return span


def _enclosed(rates: Rates, series: Sequence[Sequence[Ball]], span: Ball) -> EnclosedStep | None:
    """The step over a span, if a box is found that shows its remainder."""
    times = arb(0).union(span)
    main = [arb_poly(list(entry[:ORDER]))(times) for entry in series]
    # radii of balls have 30 bits, so that a box has to be larger by more than they resolve
    radii = [4 * abs(entry[ORDER]) * span**ORDER + x.rad() * INFLATION for entry, x in zip(series, main, strict=True)]
    for _ in range(ENCLOSURES):
        hull = [x + r * UNIT for x, r in zip(main, radii, strict=True)]
        last = [over[ORDER] for over in expanded(rates, hull)]
        rest = [c * times**ORDER for c in last]
        if not all(x.is_finite() for x in rest):
            return None
        if all(box.contains(x + r) for box, x, r in zip(hull, main, rest, strict=True)):
            ends = zip(series, last, strict=True)
            return EnclosedStep(span, tuple((*first[:ORDER], c) for first, c in ends), hull)
        radii = [2 * abs(r).upper() + x.rad() * INFLATION for r, x in zip(rest, main, strict=True)]
    return None
