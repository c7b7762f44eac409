"""A fan of cones judged again, by other means than those of :mod:`nonsmooth.proofs.clauses.translation.fan_stability`.

- *Escape*: the closed cone holds the velocity, and where that lies along one of its rays omega does not bend the path
  out of it there.
- *Slide*: ``(r x v_1)(r . v_2) - (r x v_2)(r . v_1) = |r|^2 (v_2 x v_1)``, so the sign of a slide is that of the area
  of its two velocities, and where they are parallel that of ``omega_1 rho_2 - omega_2 rho_1``.
- *Crossing*: ``H = (r x v) s + (omega |r|^2/2) s^2`` is equal at entry and exit.  The powers of the first terms that do
  not vanish give the order, their signs tell whether the cone is crossed; gains are compared as products, undivided.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.fan import Cone, is_plane, rays_of
from nonsmooth.analysis.cells.full_turns import FullTurn, Growth
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import cross, dot

Step: TypeAlias = tuple[Fraction, tuple[Any, Any] | None]  # order of a crossing; its gain as numerator and denominator


def escapes(cone: Cone, twist: Twist) -> bool:
    """Whether the path of a motion from the point itself stays in its own closed cone."""
    stays = is_plane(cone) or (cone.holds(twist.velocity) and not cone.bends_out(twist))
    return any(twist.velocity) and stays


def slide_sign(ray: Point, first: Twist, second: Twist) -> int | None:
    """Sign of the radial speed of a slide near the point; None where the two do not press on the ray in this order."""
    pressing = [sign(cross(ray, t.velocity)) or sign(t.omega) for t in (first, second)]
    if pressing[0] < 0 or pressing[1] > 0:
        return None
    if pressing == [0, 0]:
        return sign(dot(ray, first.velocity))
    area = sign(cross(second.velocity, first.velocity))
    return area or sign(first.omega * dot(ray, second.velocity) - second.omega * dot(ray, first.velocity))


def slides(fan: Sequence[Cone]) -> Iterator[tuple[Point, Twist, Twist, int]]:
    """Every slide along a ray, by two motions beside it, with its sign."""
    for ray, before, after in rays_of(fan):
        for first, second in product({*before.twists, *after.twists}, repeat=2):
            found = slide_sign(ray, first, second)
            if found is not None:
                yield ray, first, second, found


def leads_out(fan: Sequence[Cone], turns: Sequence[FullTurn]) -> bool:
    """Whether any motion of the fan leaves the point."""
    fleeing = any(escapes(cone, twist) for cone in fan for twist in cone.twists)
    sliding = any(outward > 0 for *_, outward in slides(fan))
    return fleeing or sliding or any(turn.growth is Growth.DIVERGES for turn in turns)


def rests(fan: Sequence[Cone]) -> bool:
    """Whether a cone rests, or a ray consists of equilibria."""
    return any(not any(twist) for cone in fan for twist in cone.twists) or any(not s for *_, s in slides(fan))


def is_open(fan: Sequence[Cone], turns: Sequence[FullTurn]) -> bool:
    """Whether a cell turns the body about the point itself and is not just crossed, or a full turn does not tell."""
    pivots = [cone for cone in fan for t in cone.twists if t.omega and not any(t.velocity)]
    unclear = any(is_plane(cone) or len(cone.twists) > 1 for cone in pivots)
    return unclear or any(turn.growth is Growth.TIE for turn in turns)


# ---- full turns ----------------------------------------------------------------------------------


def are_the_turns(fan: Sequence[Cone], turns: Sequence[FullTurn]) -> bool:
    """Whether these are all full turns, with their orders, gains and what they do to small distances."""
    steps = {sense: [_steps(cone, sense) for cone in fan] for sense in (1, -1)}
    existing = [sense for sense in (1, -1) if len(fan) > 1 and all(steps[sense])]
    return [turn.sense for turn in turns] == existing and all(_is_turn(t, steps[t.sense]) for t in turns)


def _is_turn(turn: FullTurn, steps: Sequence[Sequence[Step]]) -> bool:
    chosen = [_farthest(own) for own in steps]
    gains = [gain for _, gain in chosen if gain is not None]
    order = math.prod((order for order, _ in chosen), start=Fraction(1))
    if turn.order != order or (turn.gain is None) == (len(gains) == len(chosen)):
        return False
    mixed = any(len(own) > 1 and any(gain is None for _, gain in own) for own in steps)
    if turn.gain is None:
        growing = None if order == 1 else 1 if order < 1 else -1
    else:
        above, below = math.prod(n for n, _ in gains), math.prod(d for _, d in gains)
        if sign(turn.gain * below - above):
            return False
        growing = sign(above - below)
    return turn.growth is _growth(growing, mixed=mixed)


def _growth(growing: int | None, *, mixed: bool) -> Growth:
    if growing is not None and growing > 0:
        return Growth.DIVERGES
    return Growth.TIE if mixed or not growing else Growth.CONTRACTS


def _steps(cone: Cone, sense: int) -> list[Step]:
    found = (_step(cone, twist, sense) for twist in cone.twists)
    return [] if is_plane(cone) else [step for step in found if step is not None]


def _step(cone: Cone, twist: Twist, sense: int) -> Step | None:
    """Order and gain of a crossing, by the first terms of H on both rays."""
    entry, exit_ray = (cone.start, cone.end) if sense > 0 else (cone.end, cone.start)
    powers, heads = zip(*(_head(ray, twist, sense) for ray in (entry, exit_ray)), strict=True)
    if any(sign(head) <= 0 for head in heads):
        return None
    order = Fraction(*powers)
    if powers == (1, 1):
        return order, heads
    if order == 1 and any(twist.velocity):  # along the line of a half-plane: the distance is kept
        return order, (-dot(entry, exit_ray), dot(exit_ray, exit_ray))
    return order, None


def _head(ray: Point, twist: Twist, sense: int) -> tuple[int, Any]:
    """Power of s and coefficient of the first term of H that does not vanish on a ray."""
    linear = sense * cross(ray, twist.velocity)
    return (1, linear) if linear else (2, sense * twist.omega * dot(ray, ray) / 2)


def _farthest(steps: Sequence[Step]) -> Step:
    """The crossing of the lowest order, and of these of the largest gain."""
    lowest = min(order for order, _ in steps)
    first, *others = [step for step in steps if step[0] == lowest]
    for step in others:
        if first[1] is None or (step[1] is not None and sign(cross(step[1], first[1])) > 0):
            first = step
    return first
