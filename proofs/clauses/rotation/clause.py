"""Clause 3 of Theorem 4 as the check asks it, and what it says."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation
from nonsmooth.proofs.clauses.clause import CheckedArray, Clause
from nonsmooth.proofs.clauses.every_load.point import EveryLoad, load_text
from nonsmooth.proofs.clauses.rotation.on_cells import Drift, RotationResult, decide_rotation, drift_at_rest
from nonsmooth.proofs.clauses.translation.at_point import EllipseTranslation
from nonsmooth.proofs.clauses.translation.every_load import EveryLoadTranslation, decays_everywhere, soft_load_of
from nonsmooth.proofs.clauses.translation.on_cells import TranslationResult
from nonsmooth.proofs.clauses.workspace import ClauseResult, Workspace
from nonsmooth.proofs.findings.facts import Fact, Quantity, Record
from nonsmooth.proofs.findings.verdicts import Equilibrium, Rotation, Theorem4, Translation
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING


class RotationClause(Clause[RotationResult]):
    """Stability of theta: the range of omega that leaves c at rest."""

    name = "rotation"

    def decide(self, work: Workspace) -> RotationResult:
        """By two linear programs on cells; by the spin at the point without."""
        translation = work.earlier["translation"]
        if isinstance(translation, EllipseTranslation):
            return spin_of(work.point)
        return _rotation(translation, work.partition)

    def undecided(self, result: RotationResult, reason: str) -> RotationResult:
        """Neither a drift nor none."""
        return RotationResult(Rotation.UNDECIDED, None, None, reason)

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


def _rotation(translation: ClauseResult, partition: Partition | None) -> RotationResult:
    """The clause from that on translation, and the cells where there are any."""
    if isinstance(translation, EllipseTranslation):
        return spin_of(translation.point)
    if isinstance(translation, EveryLoadTranslation):
        return rotation_for_every_load(translation)
    if partition is None or not isinstance(translation, TranslationResult):
        raise TypeError("required cells for a clause on cells, received none")
    return decide_rotation(partition, translation)


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
        return RotationResult(Rotation.UNDECIDED, None, None, "the motion near the point is not determined")
    if point.equilibrium is not Equilibrium.HOLDS or point.twist is None:
        return RotationResult(Rotation.UNDECIDED, None, None, "no equilibrium is proved, so nothing rests there")
    drift = drift_at_rest((point.twist,))
    if point.twist.omega:
        reason = f"at the point the body turns at the rate {brief_text(point.twist.omega)} for ever"
        return RotationResult(Rotation.UNSTABLE, drift, None, reason)
    if point.situation in (Situation.STICKING, Situation.CARRIED):
        reason = "near the point the body does not move at all"
        return RotationResult(Rotation.NEUTRAL, drift, None, reason)
    if point.translation is Translation.ASYMPTOTICALLY_STABLE and point.linearization is not None:
        return RotationResult(Rotation.NEUTRAL, drift, None, _turn_on_the_way(point.linearization))
    return RotationResult(Rotation.UNDECIDED, drift, None, "the drift is {0} and no decay bounds the rotation")


def _enclosed_spin(rest: EnclosedRest) -> RotationResult:
    """A rate that vanishes for no member of what was rounded is drift of each."""
    low, high = rest.rates
    if low <= 0 <= high:
        reason = f"{BY_ROUNDING}the rate at which a body turns at the place of rest may be zero"
        return RotationResult(Rotation.UNDECIDED, None, None, reason, spin=(low, high))
    reason = f"at the place of rest the body turns at the rate {brief_text(rest.spin)} for ever"
    return RotationResult(Rotation.UNSTABLE, None, None, reason, spin=(low, high))


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
        return RotationResult(Rotation.UNDECIDED, None, None, NO_REST)
    drift = drift_at_rest((point.twist,))
    if point.twist.omega and point.situation is EveryLoad.TIED:
        rate = brief_text(point.twist.omega)
        return RotationResult(Rotation.UNSTABLE, drift, None, MAY_TURN.format(rate))
    if point.twist.omega:
        reason = f"at the point the body turns at the rate {brief_text(point.twist.omega)} for ever, whatever the load"
        return RotationResult(Rotation.UNSTABLE, drift, None, reason)
    if point.situation in (EveryLoad.UNIQUE, EveryLoad.CARRIED):
        return RotationResult(Rotation.NEUTRAL, drift, None, AT_REST)
    if point.situation is EveryLoad.TIED:
        return RotationResult(Rotation.UNDECIDED, drift, None, TIED)
    if decays_everywhere(translation):
        return RotationResult(Rotation.NEUTRAL, drift, None, LITTLE)
    soft = soft_load_of(translation)
    if soft is not None:
        reason = f"under the load {load_text(soft)} the motion near the point is not determined to first order"
        return RotationResult(Rotation.UNDECIDED, drift, None, reason)
    return RotationResult(Rotation.UNDECIDED, drift, None, "the drift is {0} and no decay bounds the rotation")
