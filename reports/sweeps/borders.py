"""Borders between answers, along the edges of a grid of scenes: found by bisection, in exact rational numbers.

Where two neighbours answer differently, the scene half-way decides on which side the answer changes, until the two are
nearer than ``WITHIN``.  Borders are often simple fractions, so now and then two scenes close to the simplest one of the
gap are asked as well, which ends the search at once where it is there.  A third answer makes two borders of one.
Between neighbours that agree nothing is looked for: what lies there is sampled.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

from nonsmooth.reports.sweeps.outcome import QUESTIONS, Outcome, questions_of
from nonsmooth.reports.sweeps.sweep_plan import Point, Range, SweepPlan, Value, Values, WrittenValue
from nonsmooth.symbolic.numbers.rational_directions import simplest_between

WITHIN = Fraction(1, 10**9)  # of the axis: how near the two sides of a border come
MOST = 4  # borders that one edge of the grid is searched for
GUESSES = (2, 8, 16)  # rounds in which the simplest fraction is tried too

Said: TypeAlias = tuple[str, ...]  # the answers to QUESTIONS
Ask: TypeAlias = Callable[[Sequence[Point]], Sequence[Outcome]]


@dataclass(frozen=True)
class Border:
    """Where the answers change along one edge of the grid.

    Attributes:
        axis: along which, counted from 0.
        point: the values on it; that of the axis is the simplest fraction between the two sides.
        places: of the edge's lower end in the grid.
        below: the last value known on the lower side.
        above: the first value known on the upper side.
        before: the answers below.
        there: the answers at the point itself.
        after: the answers above.
        questions: that are answered.
    """

    axis: int
    point: Point
    places: tuple[int, ...]
    below: Value
    above: Value
    before: Said
    there: Said
    after: Said
    questions: tuple[str, ...] = QUESTIONS

    @property
    def changed(self) -> tuple[str, ...]:
        """The questions that are answered differently on both sides."""
        return tuple(name for name, a, b in zip(self.questions, self.before, self.after, strict=True) if a != b)


@dataclass(frozen=True)
class _Gap:
    """Two scenes on one edge with different answers."""

    axis: int
    places: tuple[int, ...]
    others: Point
    below: Value
    above: Value
    before: Said
    after: Said

    @property
    def width(self) -> Fraction:
        """Distance of the two sides along the axis."""
        return _distance(self.below, self.above)

    @property
    def half(self) -> Value:
        """The value half-way."""
        return self.below.between(self.above, Fraction(1, 2))

    @property
    def guesses(self) -> tuple[Value, ...]:
        """Two values on both sides of the simplest fraction between, less than ``WITHIN`` apart."""
        guess = _simplest_between(self.below, self.above)
        sides = (end for end in (self.below, self.above) if _distance(guess, end) > WITHIN)
        return tuple(guess.between(end, WITHIN / 2 / _distance(guess, end)) for end in sides)

    def at(self, value: Value) -> Point:
        """The scene of the edge with this value."""
        return (*self.others[: self.axis], value, *self.others[self.axis + 1 :])

    def parts(self, answers: Sequence[tuple[Value, Said]]) -> Iterator[_Gap]:
        """The parts between the given scenes in which the answers change."""
        known = [*answers, (self.below, self.before), (self.above, self.after)]
        known.sort(key=lambda answered: _distance(self.below, answered[0]))
        for (below, before), (above, after) in pairwise(known):
            if before != after:
                yield _Gap(self.axis, self.places, self.others, below, above, before, after)


def _distance(a: Value, b: Value) -> Fraction:
    """Distance of two values along their axis."""
    if a.multiple != b.multiple:
        return abs(Fraction(a.number) - Fraction(b.number))
    return abs(a.constant - b.constant)


def find_borders(plan: SweepPlan, outcomes: Sequence[Outcome], ask: Ask) -> tuple[Border, ...]:
    """All borders along the edges of a grid.

    Args:
        plan: a grid.
        outcomes: of its scenes, in their order.
        ask: checks more scenes.
    """
    open_gaps, closed, turn = list(_gaps(plan, outcomes)), list[_Gap](), 0
    while open_gaps:
        turn += 1
        asked = [(*(gap.guesses if turn in GUESSES else ()), gap.half) for gap in open_gaps]
        answers = iter(ask([gap.at(value) for gap, values in zip(open_gaps, asked, strict=True) for value in values]))
        narrower: list[_Gap] = []
        for gap, values in zip(open_gaps, asked, strict=True):
            narrower += gap.parts([(value, said(next(answers))) for value in values])
        kept = _few_on_each_edge(narrower, closed)
        open_gaps = [gap for gap in kept if gap.width > WITHIN]
        closed += [gap for gap in kept if gap.width <= WITHIN]
    return _borders(closed, ask)


def said(outcome: Outcome) -> Said:
    """The answers of an outcome."""
    return tuple(outcome[name] for name in questions_of(outcome))


def has_place(values: Values) -> bool:
    """Whether the values of an axis ascend along a line: then there is something between them."""
    if isinstance(values, Range):
        return True
    listed = values.values
    if any(isinstance(value, WrittenValue) for value in listed):
        return False
    numbers = [value.number or 0.0 for value in listed]
    return len({value.unit for value in listed if isinstance(value, Value)}) == 1 and all(
        a < b for a, b in pairwise(numbers)
    )


def _gaps(plan: SweepPlan, outcomes: Sequence[Outcome]) -> Iterator[_Gap]:
    """The edges of the grid whose ends answer differently."""
    for k, outcome in enumerate(outcomes):
        places = plan.places(k)
        for axis, count in enumerate(plan.counts):
            if places[axis] + 1 == count or not has_place(plan.axes[axis].values):
                continue
            further = (*places[:axis], places[axis] + 1, *places[axis + 1 :])
            before, after = said(outcome), said(outcomes[plan.index(further)])
            below, above = plan.at(places)[axis], plan.at(further)[axis]
            if before != after and isinstance(below, Value) and isinstance(above, Value):
                yield _Gap(axis, places, plan.at(places), below, above, before, after)


def _few_on_each_edge(narrower: Sequence[_Gap], closed: Sequence[_Gap]) -> list[_Gap]:
    """The gaps without those beyond :data:`MOST` on one edge of the grid."""
    counts = Counter((gap.axis, gap.places) for gap in closed)
    kept = []
    for gap in narrower:
        counts[gap.axis, gap.places] += 1
        if counts[gap.axis, gap.places] <= MOST:
            kept.append(gap)
    return kept


def _borders(gaps: Sequence[_Gap], ask: Ask) -> tuple[Border, ...]:
    """The borders of gaps that are narrow enough, in the order of the grid."""
    ordered = sorted(gaps, key=lambda gap: (gap.places, gap.axis, gap.below.number))
    points = [gap.at(_simplest_between(gap.below, gap.above)) for gap in ordered]
    found = ask(points)
    return tuple(
        Border(
            gap.axis,
            point,
            gap.places,
            gap.below,
            gap.above,
            gap.before,
            said(outcome),
            gap.after,
            questions_of(outcome),
        )
        for gap, point, outcome in zip(ordered, points, found, strict=True)
    )


def _simplest_between(below: Value, above: Value) -> Value:
    """The value with the smallest denominators; the lower end where both parts differ."""
    if below.multiple == above.multiple:
        return Value(simplest_fraction(below.constant, above.constant), below.multiple, below.unit)
    if below.constant == above.constant:
        return Value(below.constant, simplest_fraction(below.multiple, above.multiple), below.unit)
    return below


def simplest_fraction(low: Fraction, high: Fraction) -> Fraction:
    """The fraction with the smallest denominator in ``[low, high]``, which need not be positive."""
    if low <= 0 <= high:
        return Fraction(0)
    return simplest_between(low, high) if low > 0 else -simplest_between(-high, -low)
