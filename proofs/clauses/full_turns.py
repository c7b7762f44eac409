"""Crossing cones one after the other: gains of full turns, and the largest growth of the distance on the way.

Turning through a cone from ray r to ray r' multiplies lengths by ``(r x v)/(r' x v)``; of several motions in a cone the
largest gain counts (:mod:`nonsmooth.proofs.clauses.fan` says why a mixture gains no more).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nonsmooth.proofs.clauses.cones import Cone, is_plane
from nonsmooth.symbolic.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.scene import cross, dot


def full_turns(fan: Sequence[Cone]) -> tuple[dict[int, Any], Any]:
    """Gain of a full turn by sense, and the squared overshoot."""
    gains: dict[int, Any] = {}
    overshoot: Any = 1
    for sense in (1, -1):
        steps = [_step(cone, sense) for cone in (fan if sense > 0 else fan[::-1])]
        known = [step for step in steps if step is not None]
        if len(fan) > 1 and len(known) == len(fan):
            gain: Any = 1
            for step in known:
                gain = step[0] * gain
            gains[sense] = gain
        firsts = [_departure(cone, sense) for cone in (fan if sense > 0 else fan[::-1])]
        overshoot = max(overshoot, _largest_chain(firsts, steps))
    return gains, None if any(len(cone.twists) > 1 for cone in fan) else overshoot


def _may_cross(cone: Cone, twist: Twist, sense: int) -> bool:
    """Whether a path can enter the cone at one ray and leave it at the other, turning in the given sense."""
    velocity = twist.velocity
    return (
        not is_plane(cone)
        and sense * sign(cross(cone.start, velocity)) > 0
        and sense * sign(cross(cone.end, velocity)) > 0
    )


def _gain(cone: Cone, twist: Twist, sense: int) -> Any:
    """``s'/s`` for entry at ``s r`` and exit at ``s' r'``: distances in units of the rays' vectors."""
    at_start, at_end = cross(cone.start, twist.velocity), cross(cone.end, twist.velocity)
    return at_start / at_end if sense > 0 else at_end / at_start


def _step(cone: Cone, sense: int) -> tuple[Any, Any] | None:
    """Largest gain of crossing a cone, in the rays' units and squared in length; None where it cannot be crossed."""
    gains = [_gain(cone, twist, sense) for twist in cone.twists if _may_cross(cone, twist, sense)]
    if not gains:
        return None
    gain = max(gains)
    lengths = dot(cone.end, cone.end) / dot(cone.start, cone.start)
    return gain, gain * gain * (lengths if sense > 0 else 1 / lengths)


def _departure(cone: Cone, sense: int) -> Any | None:
    """Largest squared growth from a start anywhere in the cone to its exit; None where no path leaves that way.

    The path from e to the exit ray r' grows by ``|e x v| |r'|/|r' x v|`` for unit e: largest for e at right angles to v
    where the cone holds it, on a ray of the cone otherwise.
    """
    best: Any | None = None
    exit_ray = cone.end if sense > 0 else cone.start
    for twist in cone.twists:
        v = twist.velocity
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


def _largest_chain(firsts: Sequence[Any | None], steps: Sequence[tuple[Any, Any] | None]) -> Any:
    """Largest squared growth: out of one cone, then through consecutive ones, at most once around."""
    best: Any = 1
    for start, first in enumerate(firsts):
        total = first
        for offset in range(1, len(steps)):
            if total is None:
                break
            best = max(best, total)
            step = steps[(start + offset) % len(steps)]
            total = None if step is None else step[1] * total
        if total is not None:
            best = max(best, total)
    return best
