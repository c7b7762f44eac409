"""Vehicles against constants that vendors ship: isotropic friction, nothing fitted."""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.analysis.bodies.vehicles import turns, vehicle_motion
from nonsmooth.symbolic.files.documents import builtin_vehicles
from nonsmooth.symbolic.files.vehicle_file import load_vehicle
from nonsmooth.symbolic.numbers.number_text import float_text
from tests.evidence.comparison import Comparison, Verdict, measured

MULTIPLIER = "effective track over track"
OTHERS = (  # the same vehicles by other files and people: how far such constants scatter
    ("husky-a200", "indoors", 1.525, "a user's measurement with indoor wheels (issue 193 of husky/husky)"),
    ("rosbot", "later file", 1.36, "rosbot/controllers.yaml of husarion/rosbot_ros"),
    ("rosbot", "office floor", 1.3, "remark in diff_drive_controller.yaml of husarion/rosbot_ros: about right"),
    ("lynx-wh05", "earlier file", 1.37, "WH05_controller.yaml of husarion/husarion_ugv_ros at its commit db4e0a67"),
)
TREADS = "Mandow and others 2007 (cited from memory): the instant centres of treads hardly move with the curvature"


def vehicle_comparisons() -> Iterator[Comparison]:
    """A row for each built-in vehicle that states a constant, for what others say of them, and for treads."""
    for name in builtin_vehicles():
        vehicle = load_vehicle(name)
        if vehicle.measured is not None:
            yield measured(f"{MULTIPLIER}, {name}", vehicle.source, multiplier(name), float(vehicle.measured))
    for name, where, number, source in OTHERS:
        yield measured(f"{MULTIPLIER}, {name} {where}", source, multiplier(name), number)
    yield _treads()


def multiplier(name: str) -> float:
    """The effective track of a turn in place over the track, predicted of a built-in vehicle."""
    predicted = vehicle_motion(load_vehicle(name)).multiplier
    assert predicted is not None
    return predicted


def _treads() -> Comparison:
    """The effective track in a slight curve over that in place, of two treads."""
    found = [turn.multiplier for turn in turns(load_vehicle("tracked-base")) if turn.multiplier is not None]
    ratio = found[0] / found[-1]
    verdict = Verdict.AGREES if abs(ratio - 1) <= 1e-6 else Verdict.REFUTED
    witness = f"effective track {float_text(found[0])} in a slight curve, {float_text(found[-1])} in place"
    claim = "effective track of two treads in a slight curve over that in place, load in the middle"
    return Comparison(claim, TREADS, ratio, 1.0, verdict, ratio - 1, witness)
