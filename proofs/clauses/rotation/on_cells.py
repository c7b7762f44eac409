"""Clause 3: theta.  Invariance rules out attraction; drift proves instability.

(a) No twist depends on theta, so ``theta = 0`` is never asymptotically stable.  (b) The drift is the range of
omega over ``{f in F(c*): translation part 0}``.  If it holds a nonzero rate, the body may spin in place for
ever: theta is strongly unstable.  The convex weights are the witness, the multipliers prove the range.
(c) If the drift is {0} and ``V* <= -kappa |c|`` where the body moves, it comes to rest within ``2 |c_0|/kappa`` and
theta turns by at most ``2 max|omega| |c_0|/kappa``: stable, not attractive.  Where no cell of the square turns the
body, theta does not change while it stays there; that bounds it for all time only where the translation is stable.
(d) If F(c*) = {0}, every cell at the equilibrium is at rest: a neighbourhood of it does not move at all.  (e) If the
drift is {0}, ``|omega| <= K |v|`` on the polytope F(c*) (Hoffman); where the fan of cones shows that every path leads
inward or to rest, its length tends to zero with |c_0|, hence so does the rotation.  (Where motions tie and the point
only rests, the body might run to and fro between two opposite ones for ever: that is left out.)
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.analysis.cells.filippov import CellDerivative, filippov_twists
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.findings.verdicts import Rotation, Translation
from nonsmooth.proofs.inequalities.linear_program import Column, Mixture, best_mixture, mixtures_to_zero
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.rounded import either_way

STABLE_TRANSLATIONS = (Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE)


@dataclass(frozen=True)
class Drift:
    """Exact range of the rotation rate at rest, with the weights and multipliers that prove both ends."""

    twists: tuple[Twist, ...]
    lowest: Mixture
    highest: Mixture

    @property
    def interval(self) -> tuple[Number, Number]:
        """``[omega-, omega+]``."""
        return -self.lowest.value, self.highest.value

    def check(self) -> bool:
        """Re-verify both linear programs."""
        columns, target, omegas = _program(self.twists)
        return self.highest.check(columns, target, omegas) and self.lowest.check(columns, target, [-w for w in omegas])


@dataclass(frozen=True)
class RotationResult:
    """Verdict, drift, and where theta is stable a bound on rotation per unit of |c_0|, or the fan that shows one.

    Of a place of rest that is only enclosed ``spin`` bounds the rate there from both sides, and there is no drift.
    """

    verdict: Rotation
    drift: Drift | None
    rotation_per_distance: Number | None
    reason: str
    fan: FanResult | None = None
    spin: tuple[Fraction, Fraction] | None = None


def drift_at_rest(twists: tuple[Twist, ...]) -> Drift | None:
    """The drift of a hull of twists; None where the hull holds no zero velocity."""
    columns, target, omegas = _program(twists)
    with either_way(target[0].field):  # of ends that are as good any will do
        highest = best_mixture(columns, target, omegas)
        lowest = best_mixture(columns, target, [-w for w in omegas])
    if highest is None or lowest is None:
        return None
    for end in (highest, lowest) if target[0].field.measured else ():
        end.reaches(columns, target)  # counts where that is so of the rounded numbers alone
    return Drift(twists, lowest, highest)


def decide_rotation(partition: Partition, translation: TranslationResult) -> RotationResult:
    """Decide the rotation clause for a centred partition."""
    zero = partition.scene.field.zero
    drift = drift_at_rest(filippov_twists(partition, (zero, zero)))
    if drift is None:
        return RotationResult(Rotation.UNDECIDED, None, None, "no equilibrium at the point, so nothing rests there")
    low, high = drift.interval
    if low or high:
        reason = f"the body may rest in (x, y) and turn at any rate in [{brief_text(low)}, {brief_text(high)}]"
        return RotationResult(Rotation.UNSTABLE, drift, None, reason)
    if zero.field.measured:
        drift.check()  # that no other weights turn the body: counts where that is so of the rounded numbers alone
    per_distance = rotation_bound(partition, translation)
    if per_distance is not None and not per_distance:
        return RotationResult(Rotation.NEUTRAL, drift, per_distance, "no cell of the square turns the body")
    if not any(map(any, drift.twists)):
        reason = "every cell at the point is at rest: near it the body does not move at all"
        if per_distance is not None:
            reason += f"; from elsewhere in the square theta turns by at most {brief_text(per_distance)} |c_0|"
        return RotationResult(Rotation.NEUTRAL, drift, per_distance, reason)
    fan = translation.fan
    if per_distance is None and fan is not None and _has_short_paths(fan):
        reason = "the drift is {0}, so |omega| <= K |v| in F(c*), and every path leads inward or to rest"
        return RotationResult(Rotation.NEUTRAL, drift, None, reason, fan)
    if per_distance is None:
        return RotationResult(Rotation.UNDECIDED, drift, None, _why_open(translation))
    reason = f"the drift is {{0}} and theta turns by at most {brief_text(per_distance)} |c_0|"
    return RotationResult(Rotation.NEUTRAL, drift, per_distance, reason)


def _why_open(translation: TranslationResult) -> str:
    """Why a drift of {0} does not bound the rotation."""
    if translation.verdict in STABLE_TRANSLATIONS:
        return "the drift is {0} and no decay rate bounds the rotation"
    return "the drift is {0}, but (x, y) is not shown to be stable: a body that leaves may turn elsewhere"


def _has_short_paths(fan: FanResult) -> bool:
    """Whether the length of all paths tends to zero with |c_0|."""
    single = all(len(cone.twists) == 1 for cone in fan.cones)
    resting = single and fan.verdict is Translation.STABLE
    return resting or fan.verdict is Translation.ASYMPTOTICALLY_STABLE


def rotation_bound(partition: Partition, translation: TranslationResult) -> Number | None:
    """``2 max|omega|/kappa``: total rotation per unit of |c_0|; None where no decay rate is proved.

    kappa is the decay rate on the cells that move: the body stops turning when it comes to rest.  Where its exact form
    is out of reach, a rational below it serves.
    """
    moving = _moving(translation)
    if not moving or not partition.complete:
        return None
    if not any(derivative.twist.omega for derivative in moving):
        # a body that leaves the square may turn beyond it
        return partition.scene.field.zero if translation.verdict in STABLE_TRANSLATIONS else None
    with either_way(partition.scene.field):  # of bounds that are as large any will do
        slope = max(derivative.relative() for derivative in moving)
        fastest = _fastest(moving)
    if slope.sign() < 0:
        decay = -slope.value
        kappa = decay if isinstance(decay, Number) else rational_below(decay)
        return 2 * fastest / kappa if kappa > 0 else None
    if translation.quadratic is None:
        return None
    near = [abs(t.omega) for cone in translation.quadratic.cones for t in cone.twists]
    return max(near) * translation.quadratic.arrival_per_distance  # from starts in its region


def _moving(translation: TranslationResult) -> list[CellDerivative]:
    return [derivative for derivative in translation.derivatives if any(derivative.twist)]


def _fastest(moving: list[CellDerivative]) -> Number:
    return max(abs(derivative.twist.omega) for derivative in moving)


def _program(twists: tuple[Twist, ...]) -> tuple[list[Column], Column, list[Number]]:
    """Columns and target of convex weights that rest in (x, y), and the rates that they mix."""
    return *mixtures_to_zero([t.velocity for t in twists]), [t.omega for t in twists]
