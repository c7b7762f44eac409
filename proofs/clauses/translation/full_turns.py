"""Crossing cones one after the other: full turns, and the largest growth of the distance on the way.

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
counts (module ``fan`` says why a mixture gains no more; that argument is for order one only).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum
from fractions import Fraction
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.translation.cones import Cone, is_plane
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.formulas import brief_text
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import cross, dot


class Growth(Enum):
    """What full turns of one sense do to small distances."""

    DIVERGES = "diverges"
    CONTRACTS = "contracts"
    TIE = "tie"


@dataclass(frozen=True)
class Crossing:
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
        return f"a full turn multiplies the distance by {brief_text(self.gain)} ~ {float(self.gain):.6g}"


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
        grows = order < 1
    elif gain is None or not sign(gain - 1):
        return Growth.TIE
    else:
        grows = sign(gain - 1) > 0
    if grows:
        return Growth.DIVERGES
    return Growth.TIE if tie_is_open else Growth.CONTRACTS


def cone_crossings(cone: Cone, sense: int) -> list[Crossing]:
    """The crossings of a cone in one sense, one for each motion that crosses it."""
    found = (crossing(cone, twist, sense) for twist in cone.twists)
    return [step for step in found if step is not None]


def most_growth(crossings: Sequence[Crossing]) -> Crossing:
    """The crossing after which small distances are largest: of the lowest order, then of the largest gain."""
    lowest = min(step.order for step in crossings)
    return max((step for step in crossings if step.order == lowest), key=lambda step: step.gain or 0)


def crossing(cone: Cone, twist: Twist, sense: int) -> Crossing | None:
    """How a motion crosses a cone from ray to ray, turning in the given sense; None where it does not."""
    if is_plane(cone):
        return None
    entry, exit_ray = _entry_and_exit(cone, sense)
    entering, leaving = sense * cross(entry, twist.velocity), sense * cross(exit_ray, twist.velocity)
    bend = sense * sign(twist.omega)
    first, last = sign(entering), sign(leaving)
    if first > 0 and last > 0:
        return Crossing(Fraction(1), entering / leaving)
    if bend <= 0 or first < 0 or last < 0:
        return None
    if first > 0:
        return Crossing(Fraction(1, 2), None)
    if last > 0:
        return Crossing(Fraction(2), None)
    if any(twist.velocity):  # a half-plane with v along its line: the rays are opposite
        return Crossing(Fraction(1), -dot(entry, exit_ray) / dot(exit_ray, exit_ray))
    return Crossing(Fraction(1), None)


def _entry_and_exit(cone: Cone, sense: int) -> tuple[Point, Point]:
    return (cone.start, cone.end) if sense > 0 else (cone.end, cone.start)


# ---- overshoot ---------------------------------------------------------------------------


def leaves_at_a_root(cone: Cone) -> bool:
    """Whether a start at distance eps inside the cone may leave it at a distance of order ``eps^(1/2)``.

    So it does where a velocity points along a ray of the cone, away from the equilibrium, and omega bends the path out
    of the cone there.
    """
    return any(_bends_out(cone, twist, sense) for twist in cone.twists for sense in (1, -1))


def _bends_out(cone: Cone, twist: Twist, sense: int) -> bool:
    if is_plane(cone) or sense * sign(twist.omega) <= 0:
        return False
    _, exit_ray = _entry_and_exit(cone, sense)
    return not cross(exit_ray, twist.velocity) and sign(dot(exit_ray, twist.velocity)) > 0


def squared_overshoot(fan: Sequence[Cone]) -> Any | None:
    """Square of the largest growth of the distance along a chain of cones, to first order; at least one.

    None where motions tie in a cone, and where a start at eps may leave a cone at the order of ``eps^(1/2)``: no factor
    bounds the growth there.
    """
    if any(len(cone.twists) > 1 or leaves_at_a_root(cone) for cone in fan):
        return None
    overshoot: Any = 1
    for sense in (1, -1):
        cones = fan if sense > 0 else fan[::-1]
        firsts = [_departure(cone, sense) for cone in cones]
        steps = [_squared_growth(cone, sense) for cone in cones]
        overshoot = max(overshoot, _largest_chain(firsts, steps))
    return overshoot


def _squared_growth(cone: Cone, sense: int) -> Any | None:
    """Squared growth of the length by crossing a cone, for small lengths; None where it cannot be crossed."""
    crossings = cone_crossings(cone, sense)
    if not crossings:
        return None
    step = most_growth(crossings)
    if step.order > 1:  # nothing is left of a small length
        return 0
    if step.gain is None:
        return 1
    entry, exit_ray = _entry_and_exit(cone, sense)
    return step.gain * step.gain * dot(exit_ray, exit_ray) / dot(entry, entry)


def _departure(cone: Cone, sense: int) -> Any | None:
    """Largest squared growth from a start anywhere in the cone to its exit; None where no path leaves that way.

    The path from e to the exit ray r' grows by ``|e x v| |r'|/|r' x v|`` for unit e: largest for e at right angles to v
    where the cone holds it, on a ray of the cone otherwise.  Where v = 0 the distance is kept.
    """
    best: Any | None = None
    _, exit_ray = _entry_and_exit(cone, sense)
    for twist in cone.twists:
        v = twist.velocity
        if not any(v) and sense * sign(twist.omega) > 0:
            best = 1 if best is None else max(best, 1)
            continue
        leaving = sense * cross(exit_ray, v)
        if is_plane(cone) or sign(leaving) <= 0:
            continue
        across = (sense * v[1], -sense * v[0])
        if cone.holds(across):
            reach = dot(v, v)
        else:
            starts = [r for r in (cone.start, cone.end) if sign(sense * cross(r, v)) > 0]
            reach = max(cross(r, v) * cross(r, v) / dot(r, r) for r in starts)
        growth = reach * dot(exit_ray, exit_ray) / (leaving * leaving)
        best = growth if best is None else max(best, growth)
    return best


def _largest_chain(firsts: Sequence[Any | None], steps: Sequence[Any | None]) -> Any:
    """Largest squared growth: out of one cone, then through consecutive ones, at most once around."""
    best: Any = 1
    for start, first in enumerate(firsts):
        total = first
        for offset in range(1, len(steps)):
            if total is None:
                break
            best = max(best, total)
            step = steps[(start + offset) % len(steps)]
            total = None if step is None else step * total
        if total is not None:
            best = max(best, total)
    return best
