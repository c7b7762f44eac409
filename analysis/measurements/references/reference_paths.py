"""Exact trajectories to compare whole paths with: leading-order kinematics over the scene's own number field.

Between events such a path is a straight line, so state and event times are numbers of the field and every error is a
difference of exact numbers, rounded once.  A path is compared as long as it is the only solution: it ends shortly
before it stops being unique or leaves the square, and shortly after it has come to rest for good.  The starts are the
same shares of every square, so that no array is given one that suits it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import ConstantField, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason, Event, EventKind, State, Trajectory
from nonsmooth.analysis.trajectories.trajectory import simulate

# Starts in units of the half-width, from the checked point: in all directions, near and far, none on a symmetry axis.
STARTS = ((15, 10), (11, -3), (-5, 11), (-8, -13), (6, -14), (-13, 2), (3, 8), (-10, -4))
START_UNIT = Fraction(1, 16)
BEFORE, AFTER = Fraction(15, 16), Fraction(5, 4)  # of the time of what ends a path: not yet there, and well past it
COMPARED = 256  # states of a path that are compared, evenly spread over its samples
FIRST_CROSSINGS = {EventKind.CROSS, EventKind.SLIDE, EventKind.REST}  # events at which a surface is reached


@dataclass(frozen=True)
class ExactPath:
    """The exact solution from one start.

    Attributes:
        start: the start, a float that is read exactly.
        until: last time that is compared.
        path: the exact solution.
    """

    start: tuple[float, float, float]
    until: float
    path: Trajectory

    @property
    def events(self) -> tuple[Event, ...]:
        """What happens after the start and before the last time."""
        return tuple(e for e in self.path.events if 0 < e.t < Fraction(self.until))

    def path_error(self, times: Sequence[Any], states: Sequence[State]) -> float:
        """Largest difference of a coordinate over at most :data:`COMPARED` samples."""
        chosen = np.unique(np.linspace(0, len(times) - 1, COMPARED).astype(int))
        return max(self.error_at(times[k], states[k]) for k in chosen)

    def error_at(self, time: Any, state: State) -> float:
        """Largest difference of a coordinate at one time: exact, then rounded."""
        exact = self._at(_exact(time))
        return max(abs(float(mine - _exact(value))) for mine, value in zip(exact, state, strict=True))

    def _at(self, time: Any) -> State:
        """``path.at(time)``, by the lines."""
        zero = 0 * self._lines[0][0]
        time = zero + time  # read as a number of the field once
        start, end, state, rates = next((line for line in reversed(self._lines) if line[0] <= time), self._lines[0])
        if end is not None and time >= end:
            if end is self._lines[-1][1]:
                return self.path.end.state
            time = end
        since = max(time - start, zero)
        return tuple(x + rate * since for x, rate in zip(state, rates, strict=True))

    @cached_property
    def _lines(self) -> list[tuple[Any, Any | None, State, State]]:
        """The pieces, which are straight lines: first and last time, first state, and rates."""
        lines: list[tuple[Any, Any | None, State, State]] = []
        for piece in self.path.pieces:
            zero = 0 * piece.start
            first, later = piece.state(zero), piece.state(zero + 1)
            rates = tuple(b - a for a, b in zip(first, later, strict=True))
            lines.append((piece.start, piece.end, first, rates))
        return lines

    def event_error(self, events: Sequence[Event]) -> float | None:
        """Largest difference of the times at which a path first meets the same edges; None where it never does."""
        waiting, errors = list(events), []
        for mine in self.events:
            if mine.kind not in FIRST_CROSSINGS:
                continue
            place = _beside(mine)
            k = next((k for k, other in enumerate(waiting) if _beside(other) == place), None)
            if k is not None:
                errors.append(float(abs(mine.t - _exact(waiting[k].t))))
                del waiting[: k + 1]
        return max(errors, default=None)


def reference_paths(partition: Partition) -> tuple[ConstantField, tuple[ExactPath, ...]]:
    """The exact field of a partition and its exact solutions from all starts, without starts of more than one path."""
    field = array_field(partition, Kinematics.LEADING, exact=True)
    paths = [_reference_path(field, start) for start in _starts(partition)]
    return field, tuple(path for path in paths if path is not None)


def _starts(partition: Partition) -> Iterator[tuple[float, float, float]]:
    check = partition.scene.check
    x, y = check.equilibrium
    for a, b in STARTS:
        yield float(x + check.radius * a * START_UNIT), float(y + check.radius * b * START_UNIT), 0.0


def _reference_path(field: ConstantField, start: tuple[float, float, float]) -> ExactPath | None:
    """The path from a start as long as it is the only one; None where it never is."""
    path = simulate(field, start, None)
    branching = next((float(event.t) for event in path.events if event.kind is EventKind.NONUNIQUE), None)
    ends = float(path.end.t)
    if branching == 0:
        return None
    if branching is not None:
        until = float(BEFORE) * branching
    elif path.end.reason in {EndReason.REST, EndReason.TURNING} and ends > 0:
        until = float(AFTER) * ends
    else:
        until = float(BEFORE) * ends if 0 < ends < math.inf else 1.0
    return ExactPath(start, until, path)


def _exact(value: Any) -> Any:
    """A float as the binary fraction that it is."""
    return Fraction(float(value)) if isinstance(value, float | int) else value


def _beside(event: Event) -> frozenset[str]:
    """The cells whose common edge an event lies on."""
    return frozenset(event.surface.split(" | "))
