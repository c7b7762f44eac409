"""A disc from which every body comes home under a rule without cells, by convexity of D.

About a smooth minimizer ``xi_0 = (0, 0, omega)`` at the point let the slope of D be ``G c = (beta c, 0)`` with beta
above zero.  The slips of ``xi_0`` do not depend on c: while the loads keep their affine forms, this is the slope of D
at ``xi_0`` for every c.  D is convex: every minimizer ``xi = (v, omega')`` obeys ::

    D(xi_0) >= D(xi) >= D(xi_0) + beta c . v,      so  c . v <= 0,

and equality would make ``xi_0`` a minimizer, whose slope is ``beta c``: so ``c . v < 0`` off the point.  Minimizers
depend on c upper semicontinuously, hence ``V = |c|^2`` falls strictly, and its level sets in that part are left inward.
"""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.proofs.boxes.linearization import Linearization, inward_pull
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import dot
from nonsmooth.symbolic.scene import Scene


def home_disc(scene: Scene, region: LoadRegion, linearization: Linearization | None) -> Number | None:
    """Radius of the disc about a centred scene's point; None where the slope does not point inward.

    Args:
        scene: the array.
        region: where the loads are affine; it holds the point.
        linearization: at the point.
    """
    if linearization is None or inward_pull(linearization.slope) is None:
        return None
    radius = scene.check.radius
    for side in region.polygon.sides:
        if (side.offset * side.offset - radius * radius * dot(side.normal, side.normal)).sign() < 0:
            radius = min(radius, _distance_below(scene, side))
    return radius if radius.sign() > 0 else None


def _distance_below(scene: Scene, side: HalfPlane) -> Number:
    """A rational number that is not above the distance of a line from the origin."""
    square = (side.offset * side.offset / dot(side.normal, side.normal)).ball()
    return scene.field.rational(max(rational_below(square.sqrt()), Fraction(0)))
