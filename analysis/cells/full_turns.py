"""Crossing cones one after the other, all around a point: full turns, and what they do to small distances.

In a cone with twist ``(v, omega)`` the body moves on a circle (exact kinematics ``c' = v + omega J c``), along which

    H(c) = c x v + omega |c|^2 / 2

does not change.  So a path that enters at ``s r`` and leaves at ``s' r'`` obeys ``H(s r) = H(s' r')``, and for small s
(turning counterclockwise; clockwise with both signs changed)

    (r x v) s + (omega |r|^2 / 2) s^2 = (r' x v) s' + (omega |r'|^2 / 2) s'^2.

The first terms that do not vanish decide what the crossing does to small distances:

- both products positive: ``s' = (r x v)/(r' x v) s``, the *gain* of a crossing of order one;
- the entry's product zero and omega bends the path into the cone: ``s'`` is of order ``s^2``;
- the exit's product zero and omega bends the path out of it: ``s'`` is of order ``s^(1/2)``: a start at 1e-12 leaves
  the cone at about 1e-6;
- both zero, in a half-plane with v along its line, or where v = 0: ``H = omega |c|^2 / 2``, the distance is kept.

A full turn is of the product of these orders.  Below one the distances diverge, above one they vanish; at exactly one
the product of the gains decides where every crossing is of order one.  Several motions in a cone: the most growth
counts (``proofs.clauses.translation.fan_stability`` says why a mixture gains no more; that argument is for order one
only).

Over exact numbers or floats, as in :mod:`nonsmooth.analysis.cells.moves`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

from nonsmooth.analysis.cells.fan import Cone, is_plane
from nonsmooth.analysis.cells.moves import EXACT, Signs
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text
from nonsmooth.symbolic.numbers.plane import cross, dot


class Growth(Enum):
    """What full turns of one sense do to small distances."""

    DIVERGES = "diverges"
    CONTRACTS = "contracts"
    TIE = "tie"


@dataclass(frozen=True)
class ConeCrossing:
    """From ray to ray through a cone: ``s' = gain s^order`` to leading order, s in units of the rays' vectors.

    Attributes:
        order: 1/2, 1 or 2.
        gain: the factor of a crossing of order one; None for the others, and where the body turns about the
            equilibrium itself: there the distance is kept, whatever the lengths of the rays' vectors.
    """

    order: Fraction
    gain: Any | None


@dataclass(frozen=True)
class FullTurn:
    """A full turn about the equilibrium, one crossing to a cone.

    Attributes:
        sense: 1 counterclockwise, -1 clockwise.
        order: product of the orders of the crossings.
        gain: product of their gains, the factor of the distance; None where a crossing is not of order one.
        growth: what it does to small distances.
    """

    sense: int
    order: Fraction
    gain: Any | None
    growth: Growth

    def __str__(self) -> str:
        if self.gain is None:
            return f"a full turn takes a distance eps to the order of eps^({self.order})"
        if self.growth is Growth.CONTRACTS:
            return f"a full turn contracts by {brief_text(self.gain)}"
        return f"a full turn multiplies the distance by {brief_text(self.gain)} ~ {float_text(self.gain)}"


def full_turns(fan: Sequence[Cone]) -> tuple[FullTurn, ...]:
    """The full turns that exist, at most one for each sense."""
    found = (_full_turn(fan, sense) for sense in (1, -1))
    return tuple(turn for turn in found if turn is not None)


def _full_turn(fan: Sequence[Cone], sense: int) -> FullTurn | None:
    if len(fan) < 2:
        return None
    choices = [cone_crossings(cone, sense) for cone in fan]
    if not all(choices):
        return None
    steps = [most_growth(crossings) for crossings in choices]
    order = math.prod((step.order for step in steps), start=Fraction(1))
    gains = [step.gain for step in steps if step.gain is not None]
    gain = math.prod(gains[1:], start=gains[0]) if len(gains) == len(steps) else None
    tie_is_open = any(
        len(cone.twists) > 1 and any(step.gain is None for step in crossings)
        for cone, crossings in zip(fan, choices, strict=True)
    )
    return FullTurn(sense, order, gain, _growth(order, gain, tie_is_open=tie_is_open))


def _growth(order: Fraction, gain: Any | None, *, tie_is_open: bool) -> Growth:
    """What a turn does; one that contracts by the chosen motions of tied cones only is no proof."""
    if order != 1:
        growth = Growth.DIVERGES if order < 1 else Growth.CONTRACTS
    else:
        growth = Growth.TIE if gain is None else growth_of(gain)
    return Growth.TIE if tie_is_open and growth is Growth.CONTRACTS else growth


def growth_of(gain: Any, signs: Signs = EXACT) -> Growth:
    """What turns that multiply small distances by a gain do to them."""
    growing = signs(gain - 1, signs.gain_slack)
    return Growth.DIVERGES if growing > 0 else Growth.CONTRACTS if growing < 0 else Growth.TIE


def cone_crossings(cone: Cone, sense: int) -> list[ConeCrossing]:
    """The crossings of a cone in one sense, one for each motion that crosses it."""
    if is_plane(cone):
        return []
    found = (crossing(entry_and_exit(cone, sense), twist, sense) for twist in cone.twists)
    return [step for step in found if step is not None]


def most_growth(crossings: Sequence[ConeCrossing]) -> ConeCrossing:
    """The crossing after which small distances are largest: of the lowest order, then of the largest gain."""
    lowest = min(step.order for step in crossings)
    return max((step for step in crossings if step.order == lowest), key=lambda step: step.gain or 0)


def crossing(rays: tuple[Point, Point], twist: Twist, sense: int, signs: Signs = EXACT) -> ConeCrossing | None:
    """How a motion crosses a cone from its ray of entry to that of exit, in the given sense; None where it does not."""
    entry, exit_ray = rays
    entering, leaving = (sense * cross(ray, twist.velocity) for ray in rays)
    first, last = (signs(normal, signs.speed_slack) for normal in (entering, leaving))
    bend = sense * signs(twist.omega, signs.turn_slack)
    if first > 0 and last > 0:
        return ConeCrossing(Fraction(1), entering / leaving)
    if bend <= 0 or first < 0 or last < 0:
        return None
    if first > 0:
        return ConeCrossing(Fraction(1, 2), None)
    if last > 0:
        return ConeCrossing(Fraction(2), None)
    if any(twist.velocity):  # a half-plane with v along its line: the rays are opposite
        return ConeCrossing(Fraction(1), -dot(entry, exit_ray) / dot(exit_ray, exit_ray))
    return ConeCrossing(Fraction(1), None)


def entry_and_exit(cone: Cone, sense: int) -> tuple[Point, Point]:
    """The rays over which a cone is entered and left, turning counterclockwise (1) or clockwise (-1)."""
    return (cone.start, cone.end) if sense > 0 else (cone.end, cone.start)
