"""A watch on every simulated piece: V may not rise faster than the certified bound on V'.

For ``V = |c - c*|^2`` the rate ``2 (c - c*) . c'`` equals ``2 (c - c*) . f(c*)`` on a cell, for both kinematics,
because ``c . J c = 0`` removes the turning term.  It is linear in c, so its largest value on the closed cell is found
at a vertex (:mod:`nonsmooth.analysis.cells.filippov`), and on an edge or a corner at one of the cells that meet
there.  The watch compares what the integrator did, states and times, with that bound; it does not know how that was
computed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.result import Piece
from nonsmooth.symbolic.numbers.plane import dot, minus

# Relative to the largest V: states and times err by a few 2^-53 per event, and V doubles that.
RISE_SLACK = 1e-12


class LyapunovViolationError(RuntimeError):
    """V rose faster than its certified bound: the path or the bound is wrong, which is a fault of this program."""

    def __init__(self, place: str, rise: float, allowed: float, duration: float) -> None:
        super().__init__(
            f"required V to rise by at most {allowed:.6g} within {duration:.6g} on {place}, received {rise:.6g}: "
            "the path contradicts the certified bound on V'; please report this"
        )
        self.place, self.rise, self.allowed, self.duration = place, rise, allowed, duration


@dataclass(frozen=True)
class LyapunovWatch:
    """Certified bounds on V' by cell.

    Attributes:
        value: V of a state.
        bounds: largest V' by cell name (V/time).
        slack: rise that is rounding (zero for exact numbers).
    """

    value: Callable[[Sequence[Any]], Any]
    bounds: dict[str, Any]
    slack: float = 0

    def check(self, piece: Piece) -> None:
        """Compare every stretch between two samples of a piece with the bound of its cells.

        Raises:
            LyapunovViolationError: where V rises faster than any of the cells allows.
        """
        known = [self.bounds[name] for name in piece.cells if name in self.bounds]
        if not known or len(piece.times) < 2:
            return
        bound = max(known)
        values = [self.value(piece.state(time - piece.start)) for time in piece.times]
        for k in range(1, len(values)):
            lasted = piece.times[k] - piece.times[k - 1]
            rise, allowed = values[k] - values[k - 1], bound * lasted
            if rise > allowed + self.slack:
                raise LyapunovViolationError(piece.place, float(rise), float(allowed), float(lasted))


def distance_watch(field: ConstantField) -> LyapunovWatch:
    """The watch on ``V = |c - c*|^2`` of a field that is constant on cells."""
    bounds = {
        name: max(_rates(field, cell, flow.velocity(field.centre)))
        for cell, name in enumerate(field.names)
        for flow in field.flows[cell][:1]
    }

    def value(state: Sequence[Any]) -> Any:
        away = minus((state[0], state[1]), field.centre)
        return dot(away, away)

    slack = 0 if field.exact else RISE_SLACK * (2 * field.cells.size) ** 2
    return LyapunovWatch(value, bounds, slack)


def _rates(field: ConstantField, cell: int, velocity: Point) -> Iterable[Any]:
    for vertex in field.cells.polygons[cell].vertices:
        yield 2 * dot(minus(vertex, field.centre), velocity)
