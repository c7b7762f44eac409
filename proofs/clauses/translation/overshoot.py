"""The largest growth of the distance along a chain of cones, and where no factor bounds it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from nonsmooth.analysis.cells.fan import Cone, is_plane
from nonsmooth.analysis.cells.full_turns import cone_crossings, entry_and_exit, most_growth
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import cross, dot


def leaves_at_a_root(cone: Cone) -> bool:
    """Whether a start at distance eps inside the cone may leave it at a distance of order ``eps^(1/2)``.

    So it does where a motion bends out of the cone.
    """
    return not is_plane(cone) and any(cone.bends_out(twist) for twist in cone.twists)


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
    entry, exit_ray = entry_and_exit(cone, sense)
    return step.gain * step.gain * dot(exit_ray, exit_ray) / dot(entry, entry)


def _departure(cone: Cone, sense: int) -> Any | None:
    """Largest squared growth from a start anywhere in the cone to its exit; None where no path leaves that way.

    The path from e to the exit ray r' grows by ``|e x v| |r'|/|r' x v|`` for unit e: largest for e at right angles to v
    where the cone holds it, on a ray of the cone otherwise.  Where v = 0 the distance is kept.
    """
    best: Any | None = None
    _, exit_ray = entry_and_exit(cone, sense)
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
