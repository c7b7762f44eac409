"""Paths of systems with modes: within a mode its own Filippov solution, until a guard is no longer negative.

A mode is left once its dwell time is over and one of its guards is positive, or reaches zero on its way up.  The state
is kept.  A guard that is zero on entry and falls does not count: a mode may begin where its own guard ends.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from nonsmooth.analysis.fields.sign_field import SignField
from nonsmooth.analysis.fields.switched_field import SURFACE_SLACK, Surface, length
from nonsmooth.analysis.fields.system_field import guarded_field, system_field
from nonsmooth.analysis.trajectories.legs import Leg
from nonsmooth.analysis.trajectories.result import (
    End,
    EndReason,
    Event,
    EventKind,
    Piece,
    Trajectory,
    TrajectoryError,
    samples,
)
from nonsmooth.analysis.trajectories.smooth_path import MAX_EVENTS, follow_legs
from nonsmooth.symbolic.mode_system import ModeSystem, OwnMode


@dataclass(frozen=True, eq=False)
class ModeField:
    """A mode in floats.

    Attributes:
        name: of the mode.
        own: its field.
        guarded: the same with its guards as surfaces.
        exits: each guard with the mode that follows.
        dwell: least time in the mode.
    """

    name: str
    own: SignField
    guarded: SignField
    exits: tuple[tuple[Surface, str], ...]
    dwell: float


@dataclass(frozen=True)
class ModePath:
    """A path with its modes.

    Attributes:
        trajectory: the path.
        modes: name, first and last time of each mode that it was in, in order.
    """

    trajectory: Trajectory
    modes: tuple[tuple[str, float, float], ...]


def mode_fields(system: ModeSystem, start: Sequence[float]) -> dict[str, ModeField]:
    """The modes of a system in floats, by name.

    Raises:
        SceneError: for formulas with too many switching surfaces.
    """
    return {mode.name: _mode_field(mode, start) for mode in system.modes}


def _mode_field(mode: OwnMode, start: Sequence[float]) -> ModeField:
    own = system_field(mode.system, start)
    guarded, surfaces = guarded_field(own, [way.guard for way in mode.exits])
    exits = tuple(zip(surfaces, (way.target for way in mode.exits), strict=True))
    return ModeField(mode.name, own, guarded, exits, float(mode.dwell))


def follow_modes(modes: Mapping[str, ModeField], first: str, start: Sequence[float], until: float) -> ModePath:
    """Follow a path from mode to mode.

    Args:
        modes: by name.
        first: the mode it begins in.
        start: initial state.
        until: last time.

    Raises:
        ValueError: for a guard without a gradient where it vanishes.
        TrajectoryError: where modes follow each other without end at one time, or a path cannot be followed.
    """
    run = _Run(modes, first, tuple(float(x) for x in start), until)
    while run.time < until and len(run.events) < MAX_EVENTS:
        run.stay()
    return run.result()


class _Run:
    """A path while it is being followed."""

    def __init__(self, modes: Mapping[str, ModeField], first: str, x: tuple[float, ...], until: float) -> None:
        self.modes, self.mode, self.x, self.until = modes, modes[first], x, until
        self.time = self.entered = 0.0
        self.events: list[Event] = []
        self.pieces: list[Piece] = []
        self.spans: list[tuple[str, float, float]] = []
        self.unique: bool | None = True
        self.at_once = 0

    def stay(self) -> None:
        """Stay in a mode until it is left, or the time is over."""
        mode = self.mode
        if mode.dwell:
            self._follow(mode.own, min(self.time + mode.dwell, self.until), ())
        way = self._reached()
        if way is None and self.time < self.until:
            way = self._follow(mode.guarded, self.until, mode.exits)
        if way is not None and self.time < self.until:
            self._switch(*way)

    def _reached(self) -> tuple[Surface, str] | None:
        """The first way out whose guard is positive here."""
        x = np.array(self.x)
        for surface, target in self.mode.exits:
            if surface.value(x) > SURFACE_SLACK * self.mode.own.size * length(surface.gradient(x)):
                return surface, target
        return None

    def _follow(
        self, field: SignField, until: float, exits: Sequence[tuple[Surface, str]]
    ) -> tuple[Surface, str] | None:
        """Follow the mode to a time or the first guard; the way out, if it was met."""
        if until <= self.time:
            return None
        path, legs = follow_legs(field, self.x, until - self.time, [surface for surface, _ in exits])
        rising = _rising(legs, exits)
        if rising is not None:
            return rising
        self._add(path)
        met = legs[-1].met if legs else ()
        return next(((surface, target) for surface, target in exits if surface in met), None)

    def _add(self, path: Trajectory) -> None:
        """A stretch of the path in one mode."""
        for piece in path.pieces:
            end = None if piece.end is None else piece.end + self.time
            times = tuple(t + self.time for t in piece.times)
            moved = replace(piece, start=piece.start + self.time, end=end, times=times, place=self._place(piece))
            self.pieces.append(moved)
        self.events += [replace(event, t=event.t + self.time) for event in path.events]
        if path.unique is not True and self.unique is not False:
            self.unique = path.unique
        self.at_once = 0
        self.time, self.x = self.time + float(path.end.t), tuple(float(v) for v in path.end.state)

    def _place(self, piece: Piece) -> str:
        return f"{self.mode.name}: {piece.place}" if self.mode.own.surfaces else self.mode.name

    def _switch(self, surface: Surface, target: str) -> None:
        """Enter another mode."""
        self.at_once += 1
        if self.at_once > len(self.modes):
            raise TrajectoryError(
                f"modes follow each other without end at t = {self.time:.6g}: required guards that overlap, or a "
                "dwell time; a Filippov system ([system] rhs) slides where neither is so"
            )
        self.spans.append((self.mode.name, self.entered, self.time))
        name = f"{self.mode.name} -> {target}"
        self.events.append(Event(self.time, self.x, EventKind.SWITCH, name, note=f"{surface.name} = 0"))
        self.mode, self.entered = self.modes[target], self.time

    def result(self) -> ModePath:
        """The whole path."""
        self.spans.append((self.mode.name, self.entered, self.time))
        reason = EndReason.TIME if self.time >= self.until else EndReason.EVENTS
        end = End(self.time, self.x, reason)
        times, states = samples(self.pieces, end)
        path = Trajectory("given", "events", times, states, tuple(self.events), end, self.unique, tuple(self.pieces))
        return ModePath(path, tuple(self.spans))


def _rising(legs: Sequence[Leg], exits: Sequence[tuple[Surface, str]]) -> tuple[Surface, str] | None:
    """The first way out whose guard is zero at the start of a path and rises from there."""
    if not legs:
        return None
    sides = {id(surface): side for surface, side in legs[0].motion.face.bounds}
    return next((way for way in exits if sides.get(id(way[0]), -1) > 0), None)
