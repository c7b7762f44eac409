"""A family of solutions through a cell, from where it enters to where it leaves, enclosed by balls.

The family is a curve ``x(s)``, ``|s| <= reach``, with ``x(0)`` in a small box and ``x'(s)`` in another: so
``x(s) = x(0) + x'(.) s`` by the mean value theorem.  Enclosed are the solution from the middle of the small box and the
derivative Phi of all solutions by their starts.  On arrival at ``e = 0``, each at its own time, the derivative is
``Phi - f (grad e . Phi)/(grad e . f)``, which takes both boxes along.  Shown on the way: every guard of the cell is
positive between entry and arrival, and ``e`` falls through zero once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

from flint import arb

from nonsmooth.proofs.orbits.ball_cell import BallCell, BallGuard, applied, dot
from nonsmooth.proofs.orbits.ball_steps import (
    Ball,
    Box,
    EnclosedStep,
    Expansion,
    UnprovedError,
    interval,
    lower,
    middle,
    upper,
)

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
        s = interval(-self.reach, self.reach)
        return [c + e + v * s for c, e, v in zip(self.centre, self.error, self.slope, strict=True)]

    @property
    def first(self) -> Box:
        """A box of ``x(0)``."""
        return [c + e for c, e in zip(self.centre, self.error, strict=True)]


@dataclass(frozen=True)
class Passage:
    """A family at its arrival.

    Attributes:
        family: the states, each at its own time.
        time: of all passages.
        middle_time: of that of the centre.
        arrival: a box of the states.
    """

    family: Family
    time: Ball
    middle_time: Ball

    @property
    def arrival(self) -> Box:
        """A box of the states."""
        return self.family.box


@dataclass
class _Signs:
    """What is known of a guard at a moment: that it is positive or zero, and perhaps that its slope is."""

    rises: bool = False


class _Crossing:
    """A family while it passes a cell."""

    def __init__(self, cell: BallCell, family: Family, entry: int | None, *, tangent: bool) -> None:
        self.cell, self.family, self.time = cell, family, arb(0)
        self._recent = arb("inf")  # length of the last step
        self._series: tuple[Expansion, Expansion] | None = None
        box = family.box
        for k, guard in enumerate(cell.guards):
            if k != entry and not guard.value(box) > 0:
                raise UnprovedError("a start of the return map may lie on another switching surface")
        self.known = [_Signs(rises=tangent and k == entry) for k in range(len(cell.guards))]
        if tangent and (entry is None or not cell.guards[entry].bend(box) > 0):
            raise UnprovedError("the orbit does not clearly bend away from the surface that it leaves")

    def steps(self, longest: Ball) -> tuple[EnclosedStep, EnclosedStep]:
        """The solution from the centre, and all solutions with their derivatives, over one time."""
        if self._series is None:
            self.cell.spend_step()
            one, zero = arb(1), arb(0)
            varied = Expansion(self.cell.varied_rates, [*self.family.box, one, zero, zero, one])
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
            self.require_positive(k, wide, wide.span)
        states, derivative = thin.at(thin.span), wide.at(wide.span)[2:]
        self.family = _moved(self.family, states, derivative)
        self.time, self._series, self._recent = self.time + thin.span, None, thin.span

    def require_positive(self, number: int, step: EnclosedStep, until: Ball) -> None:
        """Show that a guard is positive all along a step until a time, but for a start at zero."""
        waiting = [(arb(0), until, 0)]
        guard, known = self.cell.guards[number], self.known[number]
        while waiting:
            low, high, depth = waiting.pop()
            box = step.at(interval(low, high))[:2]
            bends = known.rises and guard.bend(box) > 0
            if bends or guard.slope(box) > 0 or guard.value(box) > 0:
                known.rises = bends
                continue
            if depth >= PARTS:
                raise UnprovedError("the path comes too near to a switching surface between its crossings")
            half = middle((low + high) / 2)
            waiting += [(half, high, depth + 1), (low, half, depth + 1)]

    def arrive(self, thin: EnclosedStep, wide: EnclosedStep, end: BallGuard, leaves: int | None) -> Passage | None:
        """End at ``end = 0`` within a step, if that is clear."""
        late = wide.at(wide.span)[:2]
        if not (end.value(self.family.box) > 0 and end.value(late) < 0):
            return None
        if not end.slope(wide.hull[:2]) < 0:
            return None
        when, centre_when = _falls_at(wide, end), _falls_at(thin, end)
        for k in range(len(self.cell.guards)):
            if k != leaves:
                self.require_positive(k, wide, upper(when))
        state = wide.at(when)
        box, derivative = state[:2], state[2:]
        rates, normal = self.cell.rates(box), [slope(box) for slope in end.gradient]
        speed = dot(normal, rates)
        moved = []
        for row, rate in enumerate(rates):
            for column in range(2):
                across = normal[0] * derivative[column] + normal[1] * derivative[2 + column]
                moved.append(derivative[2 * row + column] - rate * across / speed)
        family = _moved(self.family, thin.at(centre_when), moved)
        return Passage(family, self.time + when, self.time + centre_when)


def pass_cell(
    cell: BallCell,
    family: Family,
    end: BallGuard,
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
        left = middle(lasts - way.time)
        if not left > 0 or approaches > APPROACHES or not _is_ahead(end, way, left, lasts):
            break
        thin, wide = way.steps(2 * left)
        if wide.span >= 2 * left:
            found = way.arrive(thin, wide, end, leaves)
            if found is not None:
                return found
        if wide.span > left * 3 / 4:
            approaches += 1
            thin, wide = way.steps(middle(left * 3 / 4))
        way.advance(thin, wide)
    raise UnprovedError("the family of paths does not clearly reach the next surface")


def _is_ahead(end: BallGuard, way: _Crossing, left: Ball, lasts: Ball) -> bool:
    """Whether no path of the family can have arrived; late on the way only, as a section may be crossed before."""
    return bool(left > lasts / 64 or end.value(way.family.box) > 0)


def _moved(family: Family, states: Box, derivative: Box) -> Family:
    """A family after the centre has come to a box, and derivatives to others."""
    centre = [middle(x) for x in states]
    errors = applied(derivative, family.error)
    error = [x - c + e for x, c, e in zip(states, centre, errors, strict=True)]
    return replace(family, centre=centre, error=error, slope=applied(derivative, family.slope))


def _falls_at(step: EnclosedStep, end: BallGuard) -> Ball:
    """A ball of the times in a step at which a falling function is zero, by the interval Newton method."""
    when = interval(arb(0), step.span)
    for _ in range(NEWTON):
        here = middle(when)
        slope = end.slope(step.at(when)[:2])
        following = here - end.value(step.at(here)[:2]) / slope
        low, high = max(lower(when), lower(following)), min(upper(when), upper(following))
        if not high >= low:
            break
        when = interval(low, high)
    return when
