"""A solution of a planar system from a point, enclosed from the definition, with the logarithm of its expansion.

This is the second way to a periodic orbit, by which :mod:`nonsmooth.proofs.orbits.orbit_check` verifies the first: no
legs are given and no variational equation is solved.  In each cell ``x' = f(x)`` and ``L' = div f``; a step is a Taylor
polynomial whose remainder is taken over a box B with ``z + [0, h] F(B)`` inside B (Picard and Lindelof; Moore 1966).
Signs of the switching functions are read off on the whole step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from flint import arb, arb_poly, arb_series, ctx

from nonsmooth.proofs.orbits.ball_cell import BallCell
from nonsmooth.proofs.orbits.ball_steps import Ball, BallPolynomial, Box, UnprovedError, interval, lower, middle, upper

BITS, ORDER = 256, 26
REMAINDER = arb(2) ** -112  # of a step
ATTEMPTS = 4  # to find B for one length
SHORTEST = arb(2) ** -60
LONGEST = arb(2) ** -3
ROOT_BITS = 200  # halvings in search of the time at which a function vanishes

Rates = Callable[[Sequence[Any]], list[Any]]


@contextmanager
def double_precision() -> Iterator[None]:
    """More digits and longer series than the first proof has."""
    before = ctx.prec, ctx.cap
    ctx.prec, ctx.cap = BITS, ORDER + 1
    try:
        yield
    finally:
        ctx.prec, ctx.cap = before


@dataclass(frozen=True)
class SolutionStep:
    """Solutions from a box over a time: Taylor polynomials with ball coefficients, and a box of all of it."""

    span: Ball
    polynomials: tuple[Any, ...]
    hull: Box

    def at(self, time: Ball) -> Box:
        """Box of the states at the times of a ball within the step."""
        return [polynomial(time) for polynomial in self.polynomials]


def take_step(rates: Rates, start: Box, longest: Ball) -> SolutionStep:
    """A step as long as its remainder is small.

    Raises:
        UnprovedError: where even a short one cannot be enclosed.
    """
    series, span = _series(rates, start), middle(longest)
    while span > SHORTEST:
        hull = _picard(rates, start, span)
        if hull is not None:
            last = [entry[ORDER] for entry in _series(rates, hull)]
            if all(abs(c) * span**ORDER < REMAINDER for c in last):
                parts = zip(series, last, strict=True)
                return SolutionStep(span, tuple(arb_poly([*entry[:ORDER], c]) for entry, c in parts), hull)
        span = middle(span * 3 / 4)
    raise UnprovedError("no step of the solution could be enclosed")


def _picard(rates: Rates, start: Box, span: Ball) -> Box | None:
    """A box of all solutions from a box over a time; None where none is found."""
    times = interval(arb(0), span)
    hull = [x + times * f * 2 + arb(0, 2.0**-200) for x, f in zip(start, rates(start), strict=True)]
    for _ in range(ATTEMPTS):
        image = [x + times * f for x, f in zip(start, rates(hull), strict=True)]
        if not all(x.is_finite() for x in image):
            return None
        if all(box.contains(x) for box, x in zip(hull, image, strict=True)):
            return hull
        hull = [x + (x - middle(x)) / 4 + arb(0, 2.0**-200) for x in image]
    return None


def _series(rates: Rates, start: Box) -> list[list[Ball]]:
    """Taylor coefficients of the solutions from a box."""
    known: list[list[Ball]] = [[x] for x in start]
    for order in range(1, ORDER + 1):
        found = rates([arb_series(entry, prec=order) for entry in known])
        for entry, rate in zip(known, found, strict=True):
            entry.append(rate[order - 1] / order if isinstance(rate, arb_series) else rate * (order == 1))
    return known


def falls_at(step: SolutionStep, value: Callable[[Box], Ball]) -> Ball:
    """The times of a step before which a function is positive and after which it is negative.

    Raises:
        UnprovedError: where it does not fall from above zero to below.
    """
    low, high = arb(0), step.span
    if not value(step.at(high)) < 0:
        raise UnprovedError("a function does not fall through zero within a step")
    for _ in range(ROOT_BITS):
        half = middle((low + high) / 2)
        here = value(step.at(half))
        if here > 0:
            low = half
        elif here < 0:
            high = half
        else:
            break
    return _widened(step, value, low, high)


def _widened(step: SolutionStep, value: Callable[[Box], Ball], low: Ball, high: Ball) -> Ball:
    """Both ends, brought together as far as signs are clear."""
    for _ in range(ROOT_BITS):
        nearer = middle(low + (high - low) / 4)
        if not value(step.at(nearer)) > 0:
            break
        low = nearer
    for _ in range(ROOT_BITS):
        nearer = middle(high - (high - low) / 4)
        if not value(step.at(nearer)) < 0:
            break
        high = nearer
    return interval(lower(low), upper(high))


class Divergence:
    """``div f`` on a cell."""

    def __init__(self, cell: BallCell) -> None:
        first, second = cell.field
        x, y = first.variables
        self._parts = BallPolynomial(first.derivative(x)), BallPolynomial(second.derivative(y))

    def __call__(self, point: Sequence[Any]) -> Any:
        """The value."""
        return self._parts[0](point) + self._parts[1](point)
