"""What is said of every array within tolerances."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from flint import arb

from nonsmooth.proofs.robust.ultimate_bound import root_above
from nonsmooth.proofs.verdicts import Certainty
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.tolerances import Tolerance


@dataclass(frozen=True)
class Robust:
    """What holds for every array within the tolerances.

    Attributes:
        verdict: whether a bound is proved.
        reason: why not, else empty.
        radius: of the disc about the point in which every body ends, or else in which every equilibrium is (length).
        start: radius of the disc of starts (length); None where only starts close by are meant.
        within: time after which every body is in the disc and stays there (time); None where none is known.
        turning: bound of the rotation on the way, in radian; None where it is not bounded.
        equilibrium: radius of a disc in which every array has one equilibrium that attracts (length); None where that
            is not shown.
        drift: bound of the rotation rate at the equilibrium (1/time); None where it is not bounded.
        rests: radius of a disc in which every body stays where it is (length); None where none is looked for.
        factor: a multiple of the tolerances for which a bound is proved too, nearly the largest one.
        binding: the tolerance without which that multiple would grow most.
    """

    verdict: Certainty
    reason: str = ""
    radius: Fraction | None = None
    start: Fraction | None = None
    within: Fraction | None = None
    turning: Fraction | None = None
    equilibrium: Fraction | None = None
    drift: Fraction | None = None
    rests: Fraction | None = None
    factor: Fraction | None = None
    binding: str | None = None


def beside(box: Tolerance) -> Fraction:
    """How far the true centre of mass may be from the nominal one."""
    return root_above(2 * above(box.centre_of_mass.ball()) ** 2)


def above(ball: arb) -> Fraction:
    """The upper end of a ball."""
    return -rational_below(-ball)
