"""Clause 3 under a rule without cells: a spin at the point, or the rotation that the way home leaves behind."""

from __future__ import annotations

from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, Situation
from nonsmooth.proofs.clauses.rotation.on_cells import RotationResult, drift_at_rest
from nonsmooth.proofs.verdicts import Equilibrium, Rotation, Translation
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.rounded import BY_ROUNDING


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
