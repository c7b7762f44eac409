"""A body on supports of its own that a tip pushes, as a script or a notebook holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.pushes.contacts import Contacts, push
from nonsmooth.analysis.pushes.supports import support_loads

if TYPE_CHECKING:
    from nonsmooth.analysis.pushes.contacts import Push


@dataclass(frozen=True, init=False, repr=False)
class PushedBody:
    """A body that rests on points of its own over ground with one friction in all directions.

    Args:
        supports: points under the body, from its centre of mass.
        loads: what they carry; by statics where there are three and none are given.

    Raises:
        ValueError: for loads that are missing, negative, or of another number, and supports that do not carry the body.
    """

    contacts: Contacts

    def __init__(self, supports: Sequence[Sequence[float]], loads: Sequence[float] | None = None) -> None:
        points = np.array(supports, float)
        if points.ndim != 2 or points.shape[1] != 2 or not np.isfinite(points).all():
            raise ValueError(f"required supports [[x, y], ...], received {supports!r}")
        if loads is None and len(points) != 3:
            raise ValueError(f"required the loads of {len(points)} supports, received none: statics determines three")
        carried = support_loads(points) if loads is None else np.array(loads, float)
        if carried.shape != (len(points),) or not np.isfinite(carried).all() or carried.min() < 0 or not carried.any():
            raise ValueError(f"required {len(points)} loads of at least 0, received {loads!r}")
        object.__setattr__(self, "contacts", Contacts.isotropic(points, carried / carried.sum()))

    def push(
        self, point: Sequence[float], normal: Sequence[float], velocity: Sequence[float], friction: float = 0.0
    ) -> Push:
        """The motion that a tip causes at one point, and the force on the body.

        Args:
            point: where it touches, from the centre of mass.
            normal: into the body there, of any length.
            velocity: of the tip.
            friction: of the tip on the body.

        Raises:
            ValueError: for a normal without direction, a negative friction, or numbers that are not finite.
        """
        direction = np.array(normal, float)
        size = float(np.linalg.norm(direction))
        if not (np.isfinite(size) and size > 0):
            raise ValueError(f"required a normal of nonzero length, received {normal!r}")
        tip = np.array(point, float), direction / size, np.array(velocity, float)
        return push(self.contacts, *tip, friction)

    def wrench(self, twist: Sequence[float]) -> tuple[float, float, float]:
        """The force and the moment that keep the body in a motion, in units of friction coefficient times weight."""
        fx, fy, moment = self.contacts.wrenches(np.array([twist], float))[0]
        return float(fx), float(fy), float(moment)

    def __repr__(self) -> str:
        return f"PushedBody on {len(self.contacts.points)} supports"
