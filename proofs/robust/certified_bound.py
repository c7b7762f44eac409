"""What a certificate says about all arrays within tolerances under rule ``nearest``: bounds a little wider than found.

The stand-alone checker encloses with its own arithmetic, so that bounds to the last digit would be refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.proofs.robust.nearest import inner_radius, ultimate_bound, why_not_nearest
from nonsmooth.proofs.robust.ultimate_bound import root_above
from nonsmooth.symbolic.scene import Scene

WIDER = (1 + Fraction(1, 2**8), 1 + Fraction(1, 2**6), 1 + Fraction(1, 2**4), Fraction(5, 4))  # one after the other
PARTS = 2**24  # of the half-width of the square, to which bounds are rounded


@dataclass(frozen=True)
class CertifiedBound:
    """A claim for the checker.

    Attributes:
        radius: of the disc in which every body ends (length).
        start: radius of the disc of starts (length).
        rate: at which the distance falls between the two (length/time).
    """

    radius: Fraction
    start: Fraction
    rate: Fraction


def certified_bounds(scene: Scene) -> list[CertifiedBound]:
    """Claims from the strongest to the weakest; empty where none is proved, or the scene states no tolerances."""
    box = scene.tolerances
    if box is None or scene.contact.rule != "nearest" or scene.body is not None:
        return []
    centred = scene.recentred()
    found = None if why_not_nearest(centred) else ultimate_bound(centred, box)
    if found is None:
        return []
    start, unit = _fraction(inner_radius(centred)), _fraction(inner_radius(centred)) / PARTS
    least, rate = root_above(_fraction(found.squared)), _fraction(found.kappa)
    wider = [(unit * (1 + least * factor // unit), rate / factor) for factor in WIDER]
    return [CertifiedBound(radius, start, slower) for radius, slower in wider if radius < start]


def _fraction(value: object) -> Fraction:
    return Fraction(str(value))
