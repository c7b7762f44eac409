"""How many times larger a box of parameters may be, and which of its entries binds."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction

from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.tolerances import Tolerance

DOUBLINGS = 10  # of the factor: a thousand times the tolerances is as good as all
SMALLEST = Fraction(1, 2 ** (DOUBLINGS - 1))  # factor that is tried
HALVINGS = 6  # of the interval in which the largest factor lies
COARSE = 3  # the same where factors are only compared
LARGEST_SHARE = Fraction(99, 100)
LARGEST_TURN = Fraction(49, 100)  # of pi


def largest_factor(
    holds: Callable[[Tolerance], bool], box: Tolerance, known: Fraction = Fraction(0), halvings: int = HALVINGS
) -> Fraction:
    """Nearly the largest multiple of a box for which a statement is proved; 0 where none is.

    A statement about a box holds for every box inside it, so that any multiple found serves all smaller ones.

    Args:
        holds: whether the statement is proved for a box.
        box: the tolerances.
        known: a multiple for which it is.
        halvings: of the interval in which the largest one lies.
    """
    most = _largest_multiple(box)

    def proved(factor: Fraction) -> bool:
        return factor <= most and holds(box.times(factor))

    low, high = known, 2 * known or Fraction(1)
    for _ in range(DOUBLINGS):
        if proved(high):
            low, high = high, 2 * high
        elif low:
            break
        elif high == 1 and not proved(SMALLEST):
            return Fraction(0)  # nor is any larger one
        else:
            high /= 2
    for _ in range(halvings if low else 0):
        middle = (low + high) / 2
        low, high = (middle, high) if proved(middle) else (low, middle)
    return low


def _largest_multiple(box: Tolerance) -> Fraction:
    """Up to which shares stay below one and rims have a direction."""
    bounds = [Fraction(2**DOUBLINGS)]
    if box.heading:
        bounds.append(LARGEST_TURN / box.heading)
    for share in (box.speed, box.mu_roll, box.mu_side):
        if share:
            bounds.append(LARGEST_SHARE / -rational_below(-share.ball()))
    return min(bounds)


def binding_entry(holds: Callable[[Tolerance], bool], box: Tolerance, factor: Fraction) -> str | None:
    """The entry without which the factor grows most; None where none matters."""
    grown = {name: largest_factor(holds, box.without(name), factor, COARSE) for name in box.names}
    if not grown or max(grown.values()) <= factor:
        return None
    return max(grown, key=lambda name: grown[name])
