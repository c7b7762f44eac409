"""Feedback laws whose wheels have largest speeds: all inputs of a cell are scaled by one common factor.

``sigma = min(1, min_w limit_w/|u_w|)`` over the wheels that act, and the law gives ``sigma u`` instead of u.
Under rule ``nearest`` the twist is linear in the inputs, ``xi = sum_w g_w u_w``, and nothing moves the body without
them; so the velocity of each cell is multiplied by ``sigma > 0`` and keeps its direction.  On an edge or at a corner
the scaled velocities span the same cone as the others, hence every Filippov solution of the limited loop runs along one
of the unlimited loop, more slowly, and the other way round: the same V falls along it, the same sets are not left, the
same edges are slid along.  (Scaling only the inputs that are too large would turn the velocity.)
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from nonsmooth.analysis.fields.cellwise_field import Speeds, StateLaw
from nonsmooth.analysis.fields.switched_field import Vector
from nonsmooth.symbolic.contact_states import ContactState


def demand(speeds: Mapping[int, float], limits: Mapping[int, float]) -> float:
    """``max_w |u_w|/limit_w``: above one where an input would exceed its limit; 0 where no wheel has one."""
    return max((abs(speed) / limits[wheel] for wheel, speed in speeds.items() if wheel in limits), default=0.0)


def limited_law(law: StateLaw, limits: Mapping[int, float]) -> StateLaw:
    """A law with all inputs of a cell scaled by one factor where one of them would exceed its limit.

    Args:
        law: any law.
        limits: the largest ``|u_w|`` by the number of the wheel (length/time); wheels without one are not limited.
    """
    if not limits:
        return law

    def prepare(state: ContactState) -> Speeds:
        wanted = law(state)

        def speeds(pose: Vector) -> Mapping[int, float]:
            given = wanted(pose)
            size = demand(given, limits)
            if size <= 1:
                return given
            return {wheel: _within(speed / size, limits.get(wheel)) for wheel, speed in given.items()}

        return speeds

    return prepare


def _within(speed: float, limit: float | None) -> float:
    """A scaled speed, without the rounding by which it may pass its limit."""
    return speed if limit is None or abs(speed) <= limit else math.copysign(limit, speed)
