"""Clause 2 under a rule without cells: exact linearization at the point, or rest.

V* over the square is exact only where the lemma on inward rims covers it; otherwise it is sampled with the numerical
minimizer and said to be sampled.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction
from typing import TYPE_CHECKING

from flint import arb

from nonsmooth.analysis.bodies.gyration import squared_radius_of_disc
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.cells.polygon import HalfPlane
from nonsmooth.proofs.boxes.linearization import Linearization, inward_pull
from nonsmooth.proofs.clauses.at_point.cocircular import CocircularArray
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint
from nonsmooth.proofs.clauses.at_point.mass import MassLimit, decide_mass_limit
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import Real, brief_text
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING, either_way

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampling import SampledDerivative


class WithoutCells:
    """What a result of clause 2 without cells does not have, and what follows of the disc that it has."""

    region_radius: Number | None

    @property
    def quadratic(self) -> None:
        """No other Lyapunov function is looked for."""

    @property
    def witness(self) -> None:
        """None: no single point refutes."""

    @property
    def support_note(self) -> str:
        """Empty: a square that leaves the support polygon is refused under rules that need loads."""
        return ""

    @property
    def arrival_per_distance(self) -> None:
        """None: the point is approached, and not reached in finite time."""

    @property
    def home_radius(self) -> Number | None:
        """Radius of a disc of starts that come home; None where only starts close by are known to."""
        return self.region_radius

    @property
    def swing_radius(self) -> Number | None:
        """Largest distance of bodies from within ``home_radius``: that radius, for the distance does not grow there."""
        return self.home_radius


@dataclass(frozen=True)
class EllipseTranslation(WithoutCells):
    """Clause 2: stability of (x, y) by exact linearization, or by rest.

    Attributes:
        point: the situation at the equilibrium.
        lemma: certificate of ``V* <= 0`` on the whole square, where the array meets its hypotheses.
        sampled: V* at random points of the square, where it is not known exactly.
        mass: up to which mass a body is attracted under full dynamics; None where the point does not attract, or
            where that is not decided.
        region_radius: of a disc in which the distance falls strictly, so that every body comes home from it; or of one
            in which bodies turn about the point, or rest.
    """

    point: EllipsePoint
    lemma: CocircularArray | None
    sampled: SampledDerivative | None = field(compare=False)
    mass: MassLimit | None = None
    region_radius: Number | None = None

    @property
    def verdict(self) -> Translation:
        """Strong stability of (x, y)."""
        return self.point.translation

    @property
    def home_radius(self) -> Number | None:
        """Radius of a disc of starts that come home; None where only starts close by are known to."""
        return self.region_radius if self.verdict is Translation.ASYMPTOTICALLY_STABLE else None

    @property
    def worst_rate(self) -> Number | None:
        """Supremum of ``V*/|c|`` over the square: zero by the lemma (the field vanishes at the equilibrium)."""
        return self.point.scene.field.zero if self.lemma is not None else None

    @property
    def exponential_rate(self) -> Real | None:
        """``-max Re lambda(A)`` where the point attracts: close by, |c| shrinks at any rate below it."""
        linear = self.point.linearization or self.point.rest
        attracts = self.verdict is Translation.ASYMPTOTICALLY_STABLE
        return -linear.spectral_abscissa if attracts and linear is not None else None

    @property
    def reason(self) -> str:
        """One sentence for people."""
        linear, rest = self.point.linearization, self.point.rest
        if rest is not None:
            if self.verdict is Translation.UNDECIDED:
                return f"{BY_ROUNDING}in c' = A (c - c_0) A may have eigenvalues on either side of zero"
            top = brief_text(rest.spectral_abscissa)
            return (
                "c' = A (c - c_0) to first order about the place of rest, and the eigenvalues of A have real parts up "
                f"to {top} (in balls)"
            )
        if self.verdict is Translation.UNDECIDED or linear is None:
            return self.point.summary
        abscissa = linear.spectral_abscissa
        return f"c' = A c to first order, and the eigenvalues of A have real parts up to {brief_text(abscissa)}"


def decide_translation_at(
    point: EllipsePoint, lemma: CocircularArray | None, *, samples: int = 0, always: bool = False
) -> EllipseTranslation:
    """Decide the clause from the motion at the point.

    Args:
        point: the exact motion there.
        lemma: the certificate of ``V* <= 0`` on the square, where the array meets its hypotheses.
        samples: random points at which V* is evaluated where the lemma does not apply; 0 for none.
        always: sample also where the lemma applies.
    """
    sampled = None
    if samples and (lemma is None or always):
        from nonsmooth.analysis.minimizers.sampling import sample_smooth_derivative

        with either_way(point.scene.field):  # no sample decides anything
            sampled = sample_smooth_derivative(point.scene, samples)
    linear, mass = point.linearization, None
    if point.translation is Translation.ASYMPTOTICALLY_STABLE and linear is not None:
        mass = decide_mass_limit(linear, squared_radius_of_disc(point.scene))
    disc = home_disc(point.scene, point.region, linear) if mass is not None else None
    if point.equilibrium is Equilibrium.HOLDS and point.turns_within is not None:
        disc = turning_disc(point, point.turns_within)
    inertia = point.scene.inertia
    if inertia is not None and inertia.centre_height is not None:
        mass = None  # it is that of a body whose centre of mass is at the wheels; the answer on inertia says more
    return EllipseTranslation(point, lemma, sampled, mass, region_radius=disc)


# ---- a disc by convexity -------------------------------------------------------------------------
#
# About a smooth minimizer ``xi_0 = (0, 0, omega)`` at the point let the slope of D be ``G c = (beta c, 0)`` with beta
# above zero.  The slips of ``xi_0`` do not depend on c: while the loads keep their affine forms, this is the slope of D
# at ``xi_0`` for every c.  D is convex: every minimizer ``xi = (v, omega')`` obeys ::
#
#     D(xi_0) >= D(xi) >= D(xi_0) + beta c . v,      so  c . v <= 0,
#
# and equality would make ``xi_0`` a minimizer, whose slope is ``beta c``: so ``c . v < 0`` off the point.  Minimizers
# depend on c upper semicontinuously, hence ``V = |c|^2`` falls strictly, and its level sets in that part are left
# inward.


def home_disc(scene: Scene, region: LoadRegion, linearization: Linearization | None) -> Number | None:
    """Radius of the disc about a centred scene's point; None where the slope does not point inward.

    Args:
        scene: the array.
        region: where the loads are affine; it holds the point.
        linearization: at the point.
    """
    if linearization is None or inward_pull(linearization.slope) is None:
        return None
    radius = _disc_of_loads(scene, region)
    return radius if radius.sign() > 0 else None


def _disc_of_loads(scene: Scene, region: LoadRegion) -> Number:
    """Radius of a disc about the point in the square, in which loads are affine; zero where there is none."""
    radius = scene.check.radius
    for side in region.polygon.sides:
        if (side.offset * side.offset - radius * radius * dot(side.normal, side.normal)).sign() < 0:
            radius = min(radius, _distance_below(scene, side))
    return radius


def turning_disc(point: EllipsePoint, within: arb) -> Number | None:
    """Radius of the disc in which wheels impose a spin, or rest; None where there is none.

    Args:
        point: at which they do.
        within: a radius within which the forces of the wheels allow it.
    """
    radius = _disc_of_loads(point.scene, point.region)
    if not within.lower() >= radius.ball():
        radius = min(radius, point.scene.field.rational(max(rational_below(within), Fraction(0))))
    return radius if radius.sign() > 0 else None


def _distance_below(scene: Scene, side: HalfPlane) -> Number:
    """A rational number that is not above the distance of a line from the origin."""
    square = (side.offset * side.offset / dot(side.normal, side.normal)).ball()
    return scene.field.rational(max(rational_below(square.sqrt()), Fraction(0)))
