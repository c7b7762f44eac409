"""The clauses of Theorem 4 under rule ``ellipse``, as results of the same shape as those of the cell rules.

The situation at the equilibrium is exact (:mod:`nonsmooth.proofs.clauses.ellipse`).  V* over the square is exact only
where the lemma on inward rims covers it; otherwise it is sampled with the numerical minimizer and said to be sampled.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from nonsmooth.analysis.partitions.loads import load_regions
from nonsmooth.proofs.clauses.cocircular import CocircularArray, cocircular_array
from nonsmooth.proofs.clauses.ellipse import EllipsePoint, Situation, ellipse_point
from nonsmooth.proofs.clauses.rotation import RotationResult, drift_at_rest
from nonsmooth.proofs.clauses.witness import Witness
from nonsmooth.proofs.verdicts import Equilibrium, Rotation, Translation
from nonsmooth.symbolic.formulas import brief_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene

if TYPE_CHECKING:
    from nonsmooth.analysis.minimizers.sampling import SampledDerivative


@dataclass(frozen=True)
class EllipseEquilibrium:
    """Clause 1: whether the body rests (or spins) at the point."""

    point: EllipsePoint

    @property
    def verdict(self) -> Equilibrium:
        """Holds where the translation part of the exact minimizer vanishes."""
        return self.point.equilibrium

    @property
    def reason(self) -> str:
        """One sentence for people."""
        twist = self.point.twist
        if self.point.situation is Situation.OPEN and twist is not None:
            return f"the twist (0, 0, {brief_text(twist.omega)}) minimizes D"
        return _situation_text(self.point)

    def check(self) -> bool:
        """Re-decide the situation."""
        return self.point.check()


@dataclass(frozen=True)
class EllipseTranslation:
    """Clause 2: stability of (x, y) by exact linearization, or by rest.

    Attributes:
        point: the situation at the equilibrium.
        lemma: certificate of ``V* <= 0`` on the whole square, where the array meets its hypotheses.
        sampled: V* at random points of the square, where it is not known exactly.
    """

    point: EllipsePoint
    lemma: CocircularArray | None
    sampled: SampledDerivative | None
    witness: Witness | None = None
    region_radius: Number | None = None

    @property
    def verdict(self) -> Translation:
        """Strong stability of (x, y)."""
        return self.point.translation

    @property
    def worst_rate(self) -> Number | None:
        """Supremum of ``V*/|c|`` over the square: zero by the lemma (the field vanishes at the equilibrium)."""
        return self.point.scene.field.zero if self.lemma is not None else None

    @property
    def quadratic(self) -> None:
        """No other Lyapunov function is looked for."""

    @property
    def reason(self) -> str:
        """One sentence for people."""
        linear = self.point.linearization
        if self.verdict is Translation.UNDECIDED or linear is None:
            return _situation_text(self.point)
        abscissa = linear.spectral_abscissa
        return f"c' = A c to first order, and the eigenvalues of A have real parts up to {brief_text(abscissa)}"

    def check(self) -> bool:
        """Re-verify the situation and the lemma."""
        return self.point.check() and (self.lemma is None or self.lemma.check())


def _situation_text(point: EllipsePoint) -> str:
    """What the body does and why; where that is open the reason alone."""
    return point.reason if point.situation is Situation.OPEN else f"{point.situation}: {point.reason}"


def decide_ellipse(
    scene: Scene, *, samples: int, always: bool = False
) -> tuple[EllipseEquilibrium, EllipseTranslation, RotationResult]:
    """The first three clauses for a centred scene.

    Args:
        scene: the array.
        samples: random points at which V* is evaluated where the lemma does not apply; 0 for none.
        always: sample also where the lemma applies.

    Raises:
        nonsmooth.analysis.partitions.loads.LoadError: where the loads do not exist.
    """
    point = ellipse_point(scene, load_regions(scene, scene.check.equilibrium))
    lemma = cocircular_array(scene)
    sampled = None
    if samples and (lemma is None or always):
        from nonsmooth.analysis.minimizers.sampling import sample_ellipse_derivative

        sampled = sample_ellipse_derivative(scene, samples)
    return EllipseEquilibrium(point), EllipseTranslation(point, lemma, sampled), spin_of(point)


def spin_of(point: EllipsePoint) -> RotationResult:
    """Clause 3: a spin is drift; without one theta follows the translation and stays where it is left."""
    if point.situation is Situation.OPEN and point.equilibrium is Equilibrium.HOLDS:
        return RotationResult(Rotation.UNDECIDED, None, None, "the motion near the point is not determined")
    if point.equilibrium is not Equilibrium.HOLDS or point.twist is None:
        return RotationResult(Rotation.UNDECIDED, None, None, "no equilibrium is proved, so nothing rests there")
    drift = drift_at_rest((point.twist,))
    if point.twist.omega:
        reason = f"at the point the body turns at the rate {brief_text(point.twist.omega)} for ever"
        return RotationResult(Rotation.UNSTABLE, drift, None, reason)
    if point.situation in (Situation.HELD, Situation.CARRIED):
        reason = "near the point the body does not move at all"
        return RotationResult(Rotation.NEUTRAL, drift, None, reason)
    if point.translation is Translation.ASYMPTOTICALLY_STABLE and point.linearization is not None:
        x, y = point.linearization.rotation_map
        reason = f"theta_inf - theta_0 = ({brief_text(x)}) x_0 + ({brief_text(y)}) y_0 to first order"
        return RotationResult(Rotation.NEUTRAL, drift, None, reason)
    return RotationResult(Rotation.UNDECIDED, drift, None, "the drift is {0} and no decay bounds the rotation")
