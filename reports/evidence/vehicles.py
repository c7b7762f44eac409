"""Vehicles against constants that vendors ship: isotropic friction, nothing fitted."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.analysis.vehicles.curvature import turns
from nonsmooth.analysis.vehicles.motion import vehicle_motion
from nonsmooth.reports.evidence.claim import Claim, ClaimKind, ClaimVerdict, measured_verdict
from nonsmooth.symbolic.files.vehicle_file import load_vehicle, measured_vehicles
from nonsmooth.symbolic.number_text import float_text

MULTIPLIER = "effective track over track"
OTHERS = (  # the same vehicles by other files and people: how far such constants scatter
    ("husky-a200", "indoors", 1.525, "a user's measurement with indoor wheels (issue 193 of husky/husky)"),
    ("rosbot", "later file", 1.36, "rosbot/controllers.yaml of husarion/rosbot_ros"),
    (
        "rosbot",
        "office floor",
        1.3,
        "remark in diff_drive_controller.yaml of husarion/rosbot_ros: about right",
    ),
    ("lynx-wh05", "earlier file", 1.37, "WH05_controller.yaml of husarion/husarion_ugv_ros at its commit db4e0a67"),
)
TREADS = "Mandow and others 2007 (cited from memory): the instant centres of treads hardly move with the curvature"


def vehicle_claims() -> Iterator[Claim]:
    """A row for each built-in vehicle that states a constant, for what others say of them, and for treads."""
    for name in measured_vehicles():
        vehicle = load_vehicle(name)
        predicted = vehicle_motion(vehicle).multiplier
        if vehicle.measured is None or predicted is None:
            continue
        measured = float(vehicle.measured.multiplier)
        yield _multiplier(f"{MULTIPLIER}, {name}", vehicle.measured.source, predicted, measured)
    for name, where, measured, source in OTHERS:
        predicted = vehicle_motion(load_vehicle(name)).multiplier
        if predicted is not None:
            yield _multiplier(f"{MULTIPLIER}, {name} {where}", source, predicted, measured)
    yield _treads()


def _multiplier(claim: str, source: str, predicted: float, measured: float) -> Claim:
    error = predicted / measured - 1
    return Claim(ClaimKind.VEHICLES, claim, source, predicted, measured, "", error, measured_verdict(error))


def _treads() -> Claim:
    """The effective track at a slight curve over that in place, of two treads."""
    found = [turn.multiplier for turn in turns(load_vehicle("tracked-base")) if turn.multiplier is not None]
    ratio = found[0] / found[-1]
    verdict = ClaimVerdict.AGREES if abs(ratio - 1) <= 1e-6 else ClaimVerdict.REFUTED
    witness = f"effective track {float_text(found[0])} in a slight curve, {float_text(found[-1])} in place"
    claim = "effective track of two treads in a slight curve over that in place, load in the middle"
    return Claim(ClaimKind.VEHICLES, claim, TREADS, ratio, 1.0, "", ratio - 1, verdict, witness)
