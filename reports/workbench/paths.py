"""Paths from the start points of the page: samples, events with their words, and its end as ``simulate`` says it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.trajectories.result import Event, Trajectory, TrajectoryError
from nonsmooth.reports.workbench.requests import RequestError

if TYPE_CHECKING:
    from nonsmooth.reports.interface.array import Array
    from nonsmooth.reports.interface.system import System

Announce: TypeAlias = Callable[[str], None]

MAX_STARTS = 20
LONGEST = 1000.0  # seconds that a path is followed at most
UNTIL = 2.0  # seconds, unless the request says otherwise
SAMPLES = 160  # times at which a path is drawn
MOST_EVENTS = 60  # events of one path that are sent; accumulating switches have no end


def path_records(made: Array | System, request: Mapping[str, Any], announce: Announce) -> list[dict[str, Any]]:
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


def _followed(made: Array | System, start: list[float], until: float) -> dict[str, Any]:
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


def path_record(path: Trajectory, until: float) -> dict[str, Any]:
    """Times and states close enough together that curves look round; theta is zero for plain systems."""
    times, states = _dense(path, until)
    keep = np.isfinite(states).all(axis=1)
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


def _dense(path: Trajectory, until: float) -> tuple[Any, Any]:
    own = np.array([float(time) for time in path.times])
    if not path.pieces:
        return own, path.array
    last = min(float(own[-1]), until)
    finer = np.unique(np.concatenate([own[np.isfinite(own)], np.linspace(own[0], last, SAMPLES)]))
    return finer, path.sample(finer.tolist())


def _event_record(event: Event) -> dict[str, Any]:
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
