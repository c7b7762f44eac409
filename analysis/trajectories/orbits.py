"""Closed orbits of constant twists, followed for a finite time: one turn is computed, whole turns are taken at once.

A path that crosses an edge from the same cell at the same point as before repeats itself, with its heading turned by
the same angle each time.  So the state after any number of turns is a closed form, however many switches that are.
In floats the orbit has to close so well that all turns together move it by less than the slack of a point; else it is
followed turn by turn, until the largest number of motions ends it.  The search is Brent's: the entry after 1, 2, 4,
8, ... motions is remembered.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.trajectories.cell_motion import State
from nonsmooth.analysis.trajectories.result import Piece


@dataclass(frozen=True)
class ClosedOrbit:
    """One turn of a path that repeats itself.

    Attributes:
        start: time at which the turn began.
        period: how long it took.
        rotation: by which angle the heading changed.
        gap: by how much it fails to close (length; zero for exact numbers).
        pieces: the motions of the turn.
    """

    start: Any
    period: Any
    rotation: Any
    gap: float
    pieces: tuple[Piece, ...]

    def turns_within(self, time: Any) -> int:
        """Number of whole turns in a time."""
        turns = math.floor(float(time / self.period))
        return max(turns - 1 if turns * self.period > time else turns, 0)

    def state(self, time: Any) -> State:
        """``(x, y, theta)`` a time after the turn that was computed."""
        turns = self.turns_within(time)
        moment = self.start + (time - turns * self.period)
        piece = next((p for p in reversed(self.pieces) if p.start <= moment), self.pieces[0])
        x, y, theta = piece.state(moment - piece.start)
        return x, y, theta + (turns + 1) * self.rotation

    def piece(self, turns: int) -> Piece:
        """So many turns as one piece of a path that follows the turn itself; its first turn is sampled."""
        begin, end = self.start + self.period, self.start + (turns + 1) * self.period
        sampled = dict.fromkeys(t + self.period for piece in self.pieces for t in piece.times)
        places = dict.fromkeys(piece.place for piece in self.pieces)
        cells = dict.fromkeys(cell for piece in self.pieces for cell in piece.cells)
        times = tuple(sampled) if turns == 1 else (*sampled, end)
        return Piece(begin, end, " | ".join(places), tuple(cells), self.state, times)


@dataclass(frozen=True)
class _Entry:
    """Where a path crossed an edge: from which cell, at which point, when, with which heading, after which pieces."""

    crossing: tuple[int, tuple[int, ...]]
    point: Point
    time: Any
    theta: Any
    pieces: int


class OrbitMemory:
    """The crossing that a path is compared with."""

    def __init__(self, near: float) -> None:
        self.near = near  # length; zero for exact numbers
        self._crossings = 0
        self._anchor: _Entry | None = None

    def closes(
        self, crossing: tuple[int, tuple[int, ...]], point: Point, now: tuple[Any, Any], pieces: Sequence[Piece]
    ) -> ClosedOrbit | None:
        """Take note of a crossing at ``now = (time, heading)``; the orbit, if it closes here."""
        anchor, (time, theta) = self._anchor, now
        self._crossings += 1
        if anchor is not None and anchor.crossing == crossing:
            apart = [abs(a - b) for a, b in zip(anchor.point, point, strict=True)]
            if not any(apart) or (self.near and max(apart) <= self.near):
                turn = tuple(pieces[anchor.pieces :])
                gap = max(float(value) for value in apart)
                return ClosedOrbit(anchor.time, time - anchor.time, theta - anchor.theta, gap, turn)
        if self._crossings & (self._crossings - 1) == 0:
            self._anchor = _Entry(crossing, point, time, theta, len(pieces))
        return None
