"""A family of solutions through a cell, from where it enters to where it leaves, enclosed by balls.

The family is a curve ``x(s)``, ``|s| <= reach``, with ``x(0)`` in a small box and ``x'(s)`` in another: so
``x(s) = x(0) + x'(.) s`` by the mean value theorem.  Enclosed are the solution from the middle of the small box and the
derivative Phi of all solutions by their starts.  On arrival at ``e = 0``, each at its own time, the derivative is
``Phi - f (grad e . Phi)/(grad e . f)``, which takes both boxes along.  Shown on the way: every guard of the cell is
positive between entry and arrival, and ``e`` falls through zero once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TypeAlias

from flint import arb

from nonsmooth.proofs.boxes.enclosures import UNIT, holds_on
from nonsmooth.proofs.orbits.ball_cell import BallCell, EndFunction, applied, dot
from nonsmooth.proofs.orbits.ball_steps import Ball, Box, EnclosedStep, Expansion, UnprovedError

MOST_STEPS = 400  # through one cell
PARTS = 7  # halvings of a step, in search of the sign of a guard on all of it
APPROACHES = 40  # steps that come nearer to an arrival by three quarters each
NEWTON = 8  # steps towards a time of arrival


@dataclass(frozen=True)
class Family:
    """A curve of states.

    Attributes:
        centre: exact point beside ``x(0)``.
        error: ``x(0)`` less the centre.
        slope: ``x'(s)`` for all s.
        reach: largest s in absolute value.
    """

    centre: Box
    error: Box
    slope: Box
    reach: Ball

    @property
    def box(self) -> Box:
        """A box of the whole curve."""
        return [x + v * self.reach * UNIT for x, v in zip(self.first, self.slope, strict=True)]

    @property
    def first(self) -> Box:
        """A box of ``x(0)``."""
        return [c + e for c, e in zip(self.centre, self.error, strict=True)]

    def moved(self, states: Box, derivative: Box) -> Family:
        """The family after the centre has come to a box, and derivatives to others."""
        centre = [x.mid() for x in states]
        errors = applied(derivative, self.error)
        error = [x - c + e for x, c, e in zip(states, centre, errors, strict=True)]
        return replace(self, centre=centre, error=error, slope=applied(derivative, self.slope))


# at the arrival, each at its own time; the field's own time until then, of all; and of the centre that of the steps
Passage: TypeAlias = tuple[Family, Ball, Ball]


def pass_cell(
    cell: BallCell,
    family: Family,
    end: EndFunction,
    lasts: Ball,
    *,
    entry: int | None = None,
    leaves: int | None = None,
    tangent: bool = False,
) -> Passage:
    """Take a family through a cell until ``end`` falls to zero.

    Args:
        cell: the cell.
        family: on the surface ``entry``, or inside the cell where that is None.
        end: what falls to zero at the arrival.
        lasts: about how long the centre takes.
        entry: number of the surface that it enters by.
        leaves: number of the surface that ``end`` is, if it is one.
        tangent: whether it departs from that surface along it, bending away.

    Raises:
        UnprovedError: for what cannot be shown.
    """
    way, approaches = _Crossing(cell, family, entry, tangent=tangent), 0
    for _ in range(MOST_STEPS):
        left = (lasts - way.time).mid()
        # no path can have arrived; that is asked late on the way only, as a section may be crossed before
        ahead = left > lasts / 64 or end.value(way.family.box) > 0
        if not left > 0 or approaches > APPROACHES or not ahead:
            break
        thin, wide = way.steps(2 * left)
        if wide.span >= 2 * left:
            found = way.arrive(thin, wide, end, leaves)
            if found is not None:
                return found
        if wide.span > left * 3 / 4:
            approaches += 1
            thin, wide = way.steps((left * 3 / 4).mid())
        way.advance(thin, wide)
    raise UnprovedError("the family of paths does not clearly reach the next surface")


class _Crossing:
    """A family while it passes a cell."""

    def __init__(self, cell: BallCell, family: Family, entry: int | None, *, tangent: bool) -> None:
        self.cell, self.family, self.time, self.elapsed = cell, family, arb(0), arb(0)
        self._recent = arb("inf")  # length of the last step
        self._series: tuple[Expansion, Expansion] | None = None
        box = family.box
        if not all(k == entry or guard.value(box) > 0 for k, guard in enumerate(cell.guards)):
            raise UnprovedError("a start of the return map may lie on another switching surface")
        # of each guard, which is positive or zero now: whether its slope is known to be
        self._rises = [tangent and k == entry for k in range(len(cell.guards))]
        if tangent and (entry is None or not cell.guards[entry].bend(box) > 0):
            raise UnprovedError("the orbit does not clearly bend away from the surface that it leaves")

    def steps(self, longest: Ball) -> tuple[EnclosedStep, EnclosedStep]:
        """The solution from the centre, and all solutions with their derivatives, over one time."""
        if self._series is None:
            self.cell.spend_step()
            one, zero = arb(1), arb(0)
            varied = Expansion(self.cell.varied_rates, [*self.family.box, one, zero, zero, one, zero])
            self._series = Expansion(self.cell.rates, self.family.centre), varied
        centre, whole = self._series
        thin = centre.step(min(longest, self._recent * 4 / 3))
        wide = whole.step(thin.span)
        if wide.span < thin.span:
            thin = centre.step(wide.span)
        if thin.span < wide.span:
            raise UnprovedError("no step of the path could be enclosed")
        return thin, wide

    def advance(self, thin: EnclosedStep, wide: EnclosedStep) -> None:
        """Take a step within the cell."""
        for k in range(len(self.cell.guards)):
            self._require_positive(k, wide, wide.span)
        *state, elapsed = wide.at(wide.span)
        self.family, self.elapsed = self.family.moved(thin.at(thin.span), state[2:]), self.elapsed + elapsed
        self.time, self._series, self._recent = self.time + thin.span, None, thin.span

    def _require_positive(self, number: int, step: EnclosedStep, until: Ball) -> None:
        """Show that a guard is positive all along a step until a time, but for a start at zero."""
        guard = self.cell.guards[number]

        def is_positive(times: Ball) -> bool:
            box = step.at(times)[:2]
            bends = self._rises[number] and bool(guard.bend(box) > 0)
            shown = bends or bool(guard.slope(box) > 0 or guard.value(box) > 0)
            self._rises[number] = bends if shown else self._rises[number]
            return shown

        if not holds_on(is_positive, arb(0), until, PARTS):
            raise UnprovedError("the path comes too near to a switching surface between its crossings")

    def arrive(self, thin: EnclosedStep, wide: EnclosedStep, end: EndFunction, leaves: int | None) -> Passage | None:
        """End at ``end = 0`` within a step, if that is clear."""
        late = wide.at(wide.span)[:2]
        if not (end.value(self.family.box) > 0 and end.value(late) < 0 and end.slope(wide.hull[:2]) < 0):
            return None
        when, centre_when = _falls_at(wide, end), _falls_at(thin, end)
        for k in range(len(self.cell.guards)):
            if k != leaves:
                self._require_positive(k, wide, when.upper())
        *state, elapsed = wide.at(when)
        box, derivative = state[:2], state[2:]
        rates, normal = self.cell.rates(box), [slope(box) for slope in end.gradient]
        across = [dot(normal, derivative[column::2]) / dot(normal, rates) for column in range(2)]
        moved = [derivative[2 * row + k] - rates[row] * across[k] for row in range(2) for k in range(2)]
        family = self.family.moved(thin.at(centre_when), moved)
        return family, self.elapsed + elapsed, self.time + centre_when


def _falls_at(step: EnclosedStep, end: EndFunction) -> Ball:
    """A ball of the times in a step at which a falling function is zero, by the interval Newton method."""
    when = arb(0).union(step.span)
    for _ in range(NEWTON):
        here = when.mid()
        slope = end.slope(step.at(when)[:2])
        following = here - end.value(step.at(here)[:2]) / slope
        low, high = max(when.lower(), following.lower()), min(when.upper(), following.upper())
        if not high >= low:
            break
        when = low.union(high)
    return when
