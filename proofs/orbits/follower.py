"""Following a solution of a planar system through its cells in balls, as the check of an orbit does.

It knows no list of cells beforehand: at every step it asks which surfaces may be met, and makes the step shorter until
at most one is.  Beside the state it carries L, the integral of the divergence and the logarithms of the jumps, by which
areas grow along the solution (:mod:`nonsmooth.proofs.orbits.orbit_check`).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from typing import Any

from flint import arb

from nonsmooth.proofs.orbits.ball_cell import BallCell, BallGuard, along, dot
from nonsmooth.proofs.orbits.ball_steps import Ball, BallPolynomial, Box, UnprovedError
from nonsmooth.proofs.orbits.solution_steps import LONGEST, SHORTEST, Divergence, SolutionStep, falls_at, take_step
from nonsmooth.symbolic.switched_system import SwitchedSystem

MOST_STEPS = 4_000


@dataclass
class SolutionPlace:
    """Where a solution is.

    Attributes:
        signs: of the cell.
        state: with L in third place.
        time: since the start.
        departs: number of the surface on which it starts, until it has left it.
        recent: length of the last step.
    """

    signs: tuple[int, ...]
    state: Box
    time: Ball
    departs: int | None = None
    recent: Ball = LONGEST


class Follower:
    """Solutions of a planar system.

    Args:
        system: the system.
    """

    def __init__(self, system: SwitchedSystem) -> None:
        self.surfaces = system.surfaces(system.coordinates())
        self.cell = cache(partial(BallCell, system, self.surfaces))
        self.divergence = cache(lambda signs: Divergence(self.cell(signs)))

    def signs_at(self, point: Box) -> tuple[int, ...]:
        """The cell of a point.

        Raises:
            UnprovedError: for a point on a switching surface.
        """
        values = [guard.value(point) for guard in self.cell((1,) * len(self.surfaces)).guards]
        if not all(value > 0 or value < 0 for value in values):
            raise UnprovedError("a point lies on a switching surface")
        return tuple(1 if value > 0 else -1 for value in values)

    def step(self, place: SolutionPlace, longest: Ball) -> tuple[SolutionStep, list[int]]:
        """A step, and the surfaces that the solution may meet in it."""
        cell, divergence = self.cell(place.signs), self.divergence(place.signs)
        span = min(longest, place.recent * 3 / 2)
        step = take_step(lambda z: [*cell.rates(z[:2]), divergence(z[:2])], place.state, span)
        place.recent = step.span
        return step, [k for k in range(len(cell.guards)) if not self._stays(cell, place, step, k)]

    def _stays(self, cell: BallCell, place: SolutionPlace, step: SolutionStep, number: int) -> bool:
        """Whether a guard is positive on a step, but for a start on its surface."""
        guard, hull = cell.guards[number], step.hull[:2]
        if guard.value(hull) > 0:
            return True
        if number == place.departs:
            return bool(guard.slope(hull) > 0 or (guard.bend(hull) > 0 and guard.slope(place.state[:2]).contains(0)))
        return bool(guard.value(place.state[:2]) > 0 and guard.slope(hull) > 0)

    def advance(self, place: SolutionPlace, longest: Ball) -> int | None:
        """Take a step, or a shorter one to the one surface that is met; its number, if one is met.

        Raises:
            UnprovedError: where that is not clear.
        """
        while longest > SHORTEST:
            step, met = self.step(place, longest)
            if not met:
                place.state, place.time = step.at(step.span), place.time + step.span
                self._departed(place)
                return None
            guard = self.cell(place.signs).guards[met[0]]
            clear = len(met) == 1 and guard.value(place.state[:2]) > 0 and guard.slope(step.hull[:2]) < 0
            if clear and guard.value(step.at(step.span)[:2]) < 0:
                when = falls_at(step, partial(_guard_at, guard))
                place.state, place.time = step.at(when), place.time + when
                return met[0]
            longest = step.span / 2
        raise UnprovedError("a solution comes too near to a switching surface")

    def _departed(self, place: SolutionPlace) -> None:
        guard = None if place.departs is None else self.cell(place.signs).guards[place.departs]
        if guard is not None and guard.value(place.state[:2]) > 0:
            place.departs = None

    def cross(self, place: SolutionPlace, number: int) -> bool:
        """Go on to the other side of a surface that was met; False, and nothing, where both sides push onto it.

        Raises:
            UnprovedError: where that is not clear.
        """
        beyond = tuple(-sign if k == number else sign for k, sign in enumerate(place.signs))
        point = place.state[:2]
        before, after = (self.cell(signs).guards[number].slope(point) for signs in (place.signs, beyond))
        if before < 0 and after < 0:
            return False
        if not (before < 0 and after > 0):
            raise UnprovedError("it is not clear whether a surface is crossed")
        place.state = [*point, place.state[2] + (after / -before).log()]
        place.signs, place.departs = beyond, number
        return True

    def slide(self, place: SolutionPlace, number: int) -> None:
        """Slide until one side's push ends, and depart to that side.

        Raises:
            UnprovedError: where that is not clear.
        """
        beyond = tuple(-sign if k == number else sign for k, sign in enumerate(place.signs))
        cells = [self.cell(place.signs), self.cell(beyond)]

        def pushes(point: Sequence[Any]) -> list[Any]:
            return [-cell.guards[number].slope(point) for cell in cells]

        def rates(point: Sequence[Any]) -> list[Any]:
            (p, q), (f, g) = pushes(point), (cell.rates(point) for cell in cells)
            return [(q * a + p * b) / (p + q) for a, b in zip(f, g, strict=True)]

        longest = LONGEST
        for _ in range(MOST_STEPS):
            step = take_step(rates, place.state[:2], longest)
            late = pushes(step.at(step.span))
            others = [guard.value(step.hull) for k, guard in enumerate(cells[0].guards) if k != number]
            if not (all(value > 0 for value in others) and all(push > 0 for push in pushes(place.state[:2]))):
                raise UnprovedError("it is not clear that both sides push onto a surface")
            ending = [k for k in (0, 1) if not pushes(step.hull)[k] > 0]
            if not ending:
                place.state, place.time = [*step.at(step.span), arb(0)], place.time + step.span
                longest = LONGEST
            elif len(ending) == 1 and late[ending[0]] < 0 and self._falls(ending[0], cells, step, number):
                when = falls_at(step, partial(_entry, pushes, ending[0]))
                place.state, place.time = [*step.at(when), arb(0)], place.time + when
                place.signs, place.departs = (place.signs, beyond)[ending[0]], number
                return
            else:
                longest = step.span / 2
            if not longest > SHORTEST:
                break
        raise UnprovedError("it is not clear how a slide ends")

    def _falls(self, side: int, cells: Sequence[BallCell], step: SolutionStep, number: int) -> bool:
        """Whether the push of a side falls along the sliding field on all of a step."""
        hull = step.hull
        p, q = (-cell.guards[number].slope(hull) for cell in cells)
        f, g = (cell.rates(hull) for cell in cells)
        sliding = [(q * a + p * b) / (p + q) for a, b in zip(f, g, strict=True)]
        return bool(dot(self.push_slopes(cells[side], number, hull), sliding) > 0)

    def push_slopes(self, cell: BallCell, number: int, point: Box) -> Box:
        """Gradient of the speed away from a surface into a cell."""
        speed = along(cell.field, self.surfaces[number] * cell.signs[number])
        return [BallPolynomial(speed.derivative(name))(point) for name in speed.variables]


def _guard_at(guard: BallGuard, state: Box) -> Ball:
    """A guard at a state with L."""
    return guard.value(state[:2])


def _entry(values: Callable[[Box], list[Any]], number: int, state: Box) -> Ball:
    """One of several values."""
    return values(state)[number]
