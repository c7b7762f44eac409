"""The geometry of an array as JSON: wheels, body, checked square, cells and the edges on which the motion switches."""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.analysis.cells.loads import elastic_loads_at, value_at
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.fields.sliding_edges import switching_stretches
from nonsmooth.analysis.trajectories.result import Event, Trajectory, TrajectoryError
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.workbench.requests import RequestError
from nonsmooth.symbolic.mechanics.body import Disc
from nonsmooth.symbolic.mechanics.scene import LoadTable
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane_arrays import finite_rows

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Cell, Partition
    from nonsmooth.reports.interface.array import Array
    from nonsmooth.reports.interface.system import System
    from nonsmooth.symbolic.mechanics.body import Body
    from nonsmooth.symbolic.mechanics.contact_set import ContactSet
    from nonsmooth.symbolic.mechanics.scene import Scene, Wheel


EDGE_KINDS = {"sliding": "sliding", "resting": "resting", "repelling": "escaping"}
MOST_LOADED = 40  # wheels up to which elastic loads are shown: they take a moment
CORNERS = 96  # of the polygon that stands for a round body


def point(vector: Sequence[Any]) -> list[float]:
    """Exact coordinates as floats."""
    return [float(value) for value in vector]


def wheels_record(scene: Scene, unit: Fraction, carrying: Collection[int], loads: Mapping[int, float]) -> list[Record]:
    """Every wheel in its order: place, rim, speed, friction, load; exact texts beside what may be edited.

    ``unit`` is that in which the document states speeds, in lengths per second: so they are here, too.
    """
    wheels = sorted((*scene.wheels, *scene.idle), key=lambda wheel: wheel.index)
    return [
        _wheel_record(wheel, unit, wheel.index in carrying, loads.get(wheel.index))
        | {"rule": scene.rule_of_wheel(wheel)}
        for wheel in wheels
    ]


def loads_at_point(scene: Scene) -> dict[int, float]:
    """Shares of the weight by wheel, of a body at the checked point; none where they are unknown or do not exist."""
    loads, place = scene.contact.loads, scene.check.equilibrium
    try:
        if isinstance(loads, LoadTable):
            forces = [value_at(row, place) for row in loads.rows]
        elif loads is None and len(scene.wheels) <= MOST_LOADED:
            forces = list(elastic_loads_at(scene, place))
        else:
            return {}
    except RefusalError:
        return {}
    return {number: float(force) for number, force in zip(scene.numbers, forces, strict=True)}


def _wheel_record(wheel: Wheel, unit: Fraction, carries: bool, load: float | None) -> Record:
    x, y = point(wheel.position)
    speed = wheel.speed / unit
    return {
        "name": str(wheel.index),
        "x": x,
        "y": y,
        "rim": point(wheel.unit_direction),
        "axis": None if wheel.axis is None else point(wheel.unit_grip),
        "speed": float(speed),
        "mu_roll": float(wheel.friction.roll),
        "mu_side": float(wheel.friction.side),
        "carries": carries,
        "load": load,
        "exact": {
            "position": [brief_text(value) for value in wheel.position],
            "rim": [brief_text(value) for value in wheel.direction],
            "speed": brief_text(speed),
        },
    }


def body_record(scene: Scene) -> Record | None:
    """The outline about the checked point; None for a body that lies on every wheel."""
    if scene.body is None:
        return None
    x, y = point(scene.check.equilibrium)
    return {"outline": [[x + a, y + b] for a, b in _outline(scene.body)], "round": scene.body.is_round}


def _outline(body: Body) -> list[list[float]]:
    from math import cos, pi, sin

    if not isinstance(body.outline, Disc):
        return [point(corner) for corner in body.vertices]
    (x, y), radius = point(body.centroid), float(body.outline.radius)
    turns = [2 * pi * k / CORNERS for k in range(CORNERS)]
    return [[x + radius * cos(turn), y + radius * sin(turn)] for turn in turns]


def square_record(scene: Scene) -> Record:
    """The checked square and the characteristic length."""
    x, y = point(scene.check.equilibrium)
    check = scene.check
    exact = {"x": brief_text(check.equilibrium[0]), "y": brief_text(check.equilibrium[1])}
    return {
        "x": x,
        "y": y,
        "radius": float(check.radius),
        "length": float(check.length),
        "exact": {**exact, "radius": brief_text(check.radius), "length": str(check.length)},
    }


def contact_record(contact: ContactSet) -> Record:
    """Which wheels carry, and how far the body may move and turn before that changes."""
    return {
        "wheels": list(contact.wheels),
        "margin": None if contact.margin is None else float(contact.margin),
        "angle": None if contact.angle is None else float(contact.angle),
    }


def cells_record(partition: Partition) -> list[Record]:
    """Every cell with its motion about the world's origin; equal motions share a number, for their colour."""
    motions = list(dict.fromkeys(cell.twists for cell in partition.cells))
    return [_cell_record(cell, motions.index(cell.twists)) for cell in partition.cells]


def _cell_record(cell: Cell, motion: int) -> Record:
    twist = cell.twists[0]
    velocity = point(twist.pose_rate(cell.polygon.centre))
    return {
        "polygon": [point(vertex) for vertex in cell.polygon.vertices],
        "centre": point(cell.polygon.centre),
        "twist": point(twist),
        "velocity": velocity,
        "omega": float(twist.omega),
        "kind": "rest" if cell.rests else "tied" if len(cell.states) > 1 else "moving",
        "motion": motion,
        "wheels": list(cell.wheels),
        "rows": cell.states[0].name,
    }


def edges_record(partition: Partition) -> list[Record]:
    """The stretches of edges on which bodies slide or rest, or which they may leave to both sides."""
    return [
        {"from": list(part.start), "to": list(part.end), "kind": EDGE_KINDS[str(part.kind)]}
        for part in switching_stretches(partition)
    ]


# ---- paths from the start points of the page -----------------------------------------------------
#
# Samples, events with their words, and its end as ``simulate`` says it.


Announce: TypeAlias = Callable[[str], None]

MAX_STARTS = 20
LONGEST = 1000.0  # seconds that a path is followed at most
UNTIL = 2.0  # seconds, unless the request says otherwise
SAMPLES = 160  # times at which a path is drawn
MOST_EVENTS = 60  # events of one path that are sent; accumulating switches have no end


def path_records(made: Array | System, request: Mapping[str, Any], announce: Announce) -> list[Record]:
    """A record for each start; one that cannot be followed says why.

    Raises:
        RequestError: for starts or a last time that are no numbers.
    """
    starts, until = _starts(request.get("starts")), _until(request.get("until"))
    records = []
    for start in starts:
        announce("path")
        records.append({"start": start, **_followed(made, start, until)})
    return records


def _followed(made: Array | System, start: list[float], until: float) -> Record:
    try:
        path = made.simulate(start, until)
        said = [path.ending[1], *path.beside()]
        return {**path_record(path.trajectory, until), "sentences": [line.strip() for line in said]}
    except (ValueError, RefusalError, TrajectoryError) as error:
        return {
            "times": [],
            "x": [],
            "y": [],
            "theta": [],
            "events": [],
            "end": None,
            "sentences": [],
            "error": str(error),
        }


def path_record(path: Trajectory, until: float) -> Record:
    """Times and states close enough together that curves look round; theta is zero for plain systems."""
    times, states = path.dense(SAMPLES, until)
    keep = finite_rows(states)
    times, states = times[keep], states[keep]
    columns = [*states.T.tolist(), *([[0.0] * len(times)] * 3)][:3]
    return {
        "times": times.tolist(),
        **dict(zip(("x", "y", "theta"), columns, strict=True)),
        "states": states.tolist() if states.shape[1] > 3 else None,
        "events": [_event_record(event) for event in path.events[:MOST_EVENTS]],
        "more_events": max(0, len(path.events) - MOST_EVENTS),
        "end": str(path.end.reason),
        "end_time": float(path.end.t) if math.isfinite(float(path.end.t)) else None,
        "unique": path.unique,
        "method": path.method,
        "error": None,
    }


def _event_record(event: Event) -> Record:
    place = [float(value) for value in event.state]
    text = f"{event.kind}: {event.surface}" + (f"; {event.note}" if event.note else "")
    x, y = (*place, 0.0)[:2]
    return {"time": float(event.t), "x": x, "y": y, "state": place, "kind": str(event.kind), "text": text}


def _starts(given: object) -> list[list[float]]:
    """The start points.

    Raises:
        RequestError: for anything but a few lists of numbers.
    """
    if not isinstance(given, list) or len(given) > MAX_STARTS:
        raise RequestError(f"starts: required a list of at most {MAX_STARTS} starts", "starts")
    starts = []
    for start in given:
        if not isinstance(start, list) or not 1 <= len(start) <= 8:
            raise RequestError("starts: required numbers [x, y, theta]", "starts")
        starts.append([_finite(value, "starts") for value in start])
    return starts


def _until(given: object) -> float:
    until = UNTIL if given is None else _finite(given, "until")
    if not 0 < until <= LONGEST:
        raise RequestError(f"until: required a time between 0 and {LONGEST:g} s", "until")
    return until


def _finite(value: object, key: str) -> float:
    try:
        number = float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise RequestError(f"{key}: required numbers", key) from None
    if isinstance(value, bool) or not math.isfinite(number):
        raise RequestError(f"{key}: required finite numbers", key)
    return number
