"""Clause 3 of Theorem 4: stability of the heading theta, on cells and as the check asks it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from nonsmooth.analysis.cells.filippov import CellDerivative, filippov_twists
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation
from nonsmooth.proofs.clauses.at_point.every_load import EveryLoad, load_text
from nonsmooth.proofs.clauses.clause import CheckedArray, Clause
from nonsmooth.proofs.clauses.translation.at_point import (
    EllipseTranslation,
    EveryLoadTranslation,
    decays_everywhere,
    soft_load_of,
)
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Equilibrium, Fact, Quantity, Record, Rotation, Theorem4, Translation
from nonsmooth.proofs.inequalities.linear_program import Column, Mixture, best_mixture, mixtures_to_zero
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.numbers.enclosures import rational_below
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING, either_way

# ---- clause 3: theta.  Invariance rules out attraction; drift proves instability -----------------
#
# (a) No twist depends on theta, so ``theta = 0`` is never asymptotically stable.  (b) The drift is the range of
# omega over ``{f in F(c*): translation part 0}``.  If it holds a nonzero rate, the body may spin in place for
# ever: theta is strongly unstable.  The convex weights are the witness, the multipliers prove the range.
# (c) If the drift is {0} and ``V* <= -kappa |c|`` where the body moves, it comes to rest within ``2 |c_0|/kappa`` and
# theta turns by at most ``2 max|omega| |c_0|/kappa``: stable, not attractive.  Where no cell of the square turns the
# body, theta does not change while it stays there; that bounds it for all time only where the translation is stable.
# (d) If F(c*) = {0}, every cell at the equilibrium is at rest: a neighbourhood of it does not move at all.  (e) If the
# drift is {0}, ``|omega| <= K |v|`` on the polytope F(c*) (Hoffman); where the fan of cones shows that every path leads
# inward or to rest, its length tends to zero with |c_0|, hence so does the rotation.  (Where motions tie and the point
# only rests, the body might run to and fro between two opposite ones for ever: that is left out.)


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
    reason: str
    drift: Drift | None = None
    rotation_per_distance: Number | None = None
    fan: FanResult | None = None
    spin: tuple[Fraction, Fraction] | None = None

    @property
    def turns_on(self) -> bool:
        """Whether a body at rest turns all the time."""
        if self.drift is None:
            return self.verdict is Rotation.UNSTABLE and self.spin is not None
        low, high = self.drift.interval
        return low.sign() > 0 or high.sign() < 0


def drift_at_rest(twists: tuple[Twist, ...]) -> Drift | None:
    """The drift of a hull of twists; None where the hull holds no zero velocity."""
    columns, target, omegas = _program(twists)
    highest = best_mixture(columns, target, omegas, counts=False)  # of ends that are as good any will do
    lowest = best_mixture(columns, target, [-w for w in omegas], counts=False)
    if highest is None or lowest is None:
        return None
    for end in (highest, lowest) if target[0].field.measured else ():
        end.reaches(columns, target)  # counts where that is so of the rounded numbers alone
    return Drift(twists, lowest, highest)


def decide_rotation(partition: Partition, translation: TranslationResult) -> RotationResult:
    """Decide the rotation clause for a centred partition."""
    zero = partition.scene.field.zero
    drift = drift_at_rest(filippov_twists(partition))
    if drift is None:
        return RotationResult(Rotation.UNDECIDED, "no equilibrium at the point, so nothing rests there")
    low, high = drift.interval
    if low or high:
        reason = f"the body may rest in (x, y) and turn at any rate in [{brief_text(low)}, {brief_text(high)}]"
        return RotationResult(Rotation.UNSTABLE, reason, drift)
    if zero.field.measured:
        drift.check()  # that no other weights turn the body: counts where that is so of the rounded numbers alone
    per_distance = rotation_bound(partition, translation)
    if per_distance is not None and not per_distance:
        return RotationResult(Rotation.NEUTRAL, "no cell of the square turns the body", drift, per_distance)
    if not any(map(any, drift.twists)):
        reason = "every cell at the point is at rest: near it the body does not move at all"
        if per_distance is not None:
            reason += f"; from elsewhere in the square theta turns by at most {brief_text(per_distance)} |c_0|"
        return RotationResult(Rotation.NEUTRAL, reason, drift, per_distance)
    fan = translation.fan
    if per_distance is None and fan is not None and _has_short_paths(fan):
        reason = "the drift is {0}, so |omega| <= K |v| in F(c*), and every path leads inward or to rest"
        return RotationResult(Rotation.NEUTRAL, reason, drift, fan=fan)
    if per_distance is None:
        return RotationResult(Rotation.UNDECIDED, _why_open(translation.verdict), drift)
    reason = f"the drift is {{0}} and theta turns by at most {brief_text(per_distance)} |c_0|"
    return RotationResult(Rotation.NEUTRAL, reason, drift, per_distance)


def _why_open(translation: Translation) -> str:
    """Why a drift of {0} does not bound the rotation."""
    if translation in STABLE_TRANSLATIONS:
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
        fastest = max(abs(derivative.twist.omega) for derivative in moving)
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


def _program(twists: tuple[Twist, ...]) -> tuple[list[Column], Column, list[Number]]:
    """Columns and target of convex weights that rest in (x, y), and the rates that they mix."""
    return *mixtures_to_zero([t.velocity for t in twists]), [t.omega for t in twists]


# ---- as the check asks it ------------------------------------------------------------------------


class RotationClause(Clause[RotationResult]):
    """Stability of theta: the range of omega that leaves c at rest."""

    name = "rotation"

    def decide(self, work: Workspace) -> RotationResult:
        """By two linear programs on cells; by the spin at the point without."""
        translation = work.earlier["translation"]
        if isinstance(translation, EllipseTranslation):
            return spin_of(work.point)
        partition = work.partition
        if isinstance(translation, EveryLoadTranslation):
            return rotation_for_every_load(translation)
        if partition is None or not isinstance(translation, TranslationResult):
            raise TypeError("required cells for a clause on cells, received none")
        return decide_rotation(partition, translation)

    def undecided(self, result: RotationResult, reason: str) -> RotationResult:
        """Neither a drift nor none."""
        return RotationResult(Rotation.UNDECIDED, reason)

    def settles(self, result: RotationResult) -> tuple[Theorem4, str] | None:
        """The theorem says that theta is unstable."""
        if result.verdict is Rotation.NEUTRAL:
            return Theorem4.FAILS, f"theta is stable: {result.reason}"
        return None

    def is_open(self, result: RotationResult) -> bool:
        """Whether theta drifts is not known."""
        return result.verdict is Rotation.UNDECIDED

    def facts(self, result: RotationResult, check: CheckedArray) -> Iterator[Fact]:
        """The drift at rest with the weights that attain it, and what some solution can keep."""
        yield Fact("weakly_stable", check.theta_is_weakly_stable)
        drift = result.drift
        if drift is None:
            yield from (Fact("drift", Quantity(result.spin)), Fact("weights"))
            return
        ends = tuple(map(float_text, drift.interval))
        yield Fact("drift", Quantity(drift.interval), "drift at rest: [{}, {}]", ends, explained=True)
        yield Fact("weights", _weights(drift))


def _weights(drift: Drift) -> Record:
    """The convex weights that rest in (x, y) and turn at the lowest and highest rate."""
    return {
        end: [{"twist": Quantity(drift.twists[k]), "weight": Quantity(w)} for k, w in mixture.weights.items()]
        for end, mixture in (("lowest", drift.lowest), ("highest", drift.highest))
    }


# ---- rules without cells -------------------------------------------------------------------------


def spin_of(point: EllipsePoint) -> RotationResult:
    """Clause 3: a spin is drift; without one theta follows the translation and stays where it is left."""
    if point.rest is not None:
        return _enclosed_spin(point.rest)
    if point.situation is Situation.OPEN and point.equilibrium is Equilibrium.HOLDS:
        return RotationResult(Rotation.UNDECIDED, "the motion near the point is not determined")
    if point.equilibrium is not Equilibrium.HOLDS or point.twist is None:
        return RotationResult(Rotation.UNDECIDED, "no equilibrium is proved, so nothing rests there")
    drift = drift_at_rest((point.twist,))
    if point.twist.omega:
        reason = f"at the point the body turns at the rate {brief_text(point.twist.omega)} for ever"
        return RotationResult(Rotation.UNSTABLE, reason, drift)
    if point.situation in (Situation.STICKING, Situation.CARRIED):
        reason = "near the point the body does not move at all"
        return RotationResult(Rotation.NEUTRAL, reason, drift)
    if point.translation is Translation.ASYMPTOTICALLY_STABLE and point.linearization is not None:
        return RotationResult(Rotation.NEUTRAL, _turn_on_the_way(point.linearization), drift)
    return RotationResult(Rotation.UNDECIDED, _why_open(point.translation), drift)


def _enclosed_spin(rest: EnclosedRest) -> RotationResult:
    """A rate that vanishes for no member of what was rounded is drift of each."""
    low, high = rest.rates
    if low <= 0 <= high:
        reason = f"{BY_ROUNDING}the rate at which a body turns at the place of rest may be zero"
        return RotationResult(Rotation.UNDECIDED, reason, spin=(low, high))
    reason = f"at the place of rest the body turns at the rate {brief_text(rest.spin)} for ever"
    return RotationResult(Rotation.UNSTABLE, reason, spin=(low, high))


def _turn_on_the_way(linear: Linearization) -> str:
    """How far the way home turns the body, to first order in its start."""
    terms = [(entry, name) for entry, name in zip(linear.rotation_map, ("x_0", "y_0"), strict=True) if entry]
    if not terms:
        return "to first order the way home does not turn the body"
    total = " + ".join(f"({brief_text(entry)}) {name}" for entry, name in terms)
    return f"theta_inf - theta_0 = {total} to first order"


# ---- loads that are unknown ----------------------------------------------------------------------


NO_REST = "no equilibrium is proved under every load, so nothing rests there"
AT_REST = "near the point the body does not move at all, whatever the load"
MAY_TURN = "at the point the body may turn at the rate {} for ever, whatever the load; under some loads it need not"
LITTLE = "the twist is of the order of the distance under every load, and the distance decays exponentially"
TIED = "the drift is {0} at rest, but under some loads other motions minimize D as well"


def rotation_for_every_load(translation: EveryLoadTranslation) -> RotationResult:
    """Clause 3 from the situation at the point and the decay of (x, y)."""
    point = translation.point
    if point.equilibrium is not Equilibrium.HOLDS or point.twist is None:
        return RotationResult(Rotation.UNDECIDED, NO_REST)
    drift = drift_at_rest((point.twist,))
    if point.twist.omega and point.situation is EveryLoad.TIED:
        rate = brief_text(point.twist.omega)
        return RotationResult(Rotation.UNSTABLE, MAY_TURN.format(rate), drift)
    if point.twist.omega:
        reason = f"at the point the body turns at the rate {brief_text(point.twist.omega)} for ever, whatever the load"
        return RotationResult(Rotation.UNSTABLE, reason, drift)
    if point.situation in (EveryLoad.UNIQUE, EveryLoad.CARRIED):
        return RotationResult(Rotation.NEUTRAL, AT_REST, drift)
    if point.situation is EveryLoad.TIED:
        return RotationResult(Rotation.UNDECIDED, TIED, drift)
    if decays_everywhere(translation):
        return RotationResult(Rotation.NEUTRAL, LITTLE, drift)
    soft = soft_load_of(translation)
    if soft is not None:
        reason = f"under the load {load_text(soft)} the motion near the point is not determined to first order"
        return RotationResult(Rotation.UNDECIDED, reason, drift)
    return RotationResult(Rotation.UNDECIDED, _why_open(translation.verdict), drift)
