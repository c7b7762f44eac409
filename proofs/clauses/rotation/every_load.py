"""Clause 3 where loads are unknown: a spin at the point, or the rotation that the way home leaves behind."""

from __future__ import annotations

from nonsmooth.proofs.clauses.every_load.point import EveryLoad, load_text
from nonsmooth.proofs.clauses.rotation.on_cells import RotationResult, drift_at_rest
from nonsmooth.proofs.clauses.translation.every_load import EveryLoadTranslation, decays_everywhere, soft_load_of
from nonsmooth.proofs.verdicts import Equilibrium, Rotation
from nonsmooth.symbolic.number_text import brief_text

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
