"""Where a path can go from a point on an edge or at a corner: every Filippov continuation of a constant field.

Near a point only the cells whose closure holds it matter: a fan of cones separated by rays.  The continuations are

- *cross* into a cell whose velocity points into its own cone (by the turn of the velocity where it is tangent);
- *slide* along a ray on which the neighbours' normal speeds do not have the same sign, where the equivalent control
  moves away from the point (also between cells that both push away: one solution is enough);
- *rest*, where the hull of the velocities holds zero; theta may then drift at any rate in an interval, found from
  the basic solutions of ``sum l_k v_k = 0, sum l_k = 1, l >= 0``;
- *turn* away: a full turn around the corner that lengthens the distance admits outward spirals, infinitely many.

More than one, or a free rotation rate, means that the solution is not unique.  (Filippov 1988, sec. 4, 10, 16;
Piiroinen & Kuznetsov 2008 for the events on a single surface.)  The path drawn rests if it can, else slides if it
can, and drifts at the rate of smallest magnitude.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

from nonsmooth.analysis.cells.moves import Signs, departure_sign
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.trajectories.junction import Junction, Ray
from nonsmooth.analysis.trajectories.result import EventKind
from nonsmooth.analysis.trajectories.slides import Slide, slide_along
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import cross, dot


@dataclass(frozen=True)
class Choice:
    """One continuation: the kind of motion, the cells that take part and what defines it."""

    kind: EventKind
    cells: tuple[int, ...]
    weights: tuple[Any, ...] = ()
    ray: Ray | None = None
    slide: Slide | None = None
    rate: Any = None
    rates: tuple[Any, Any] | None = None
    free: bool = False


def choices_at(field: ConstantField, junction: Junction, theta: Any, signs: Signs) -> list[Choice]:
    """Every continuation: rest first, then slides, then crossings."""
    found = list(_rests(field, junction, signs))
    for ray in junction.rays:
        slide = slide_along(field, junction.point, theta, ray, signs)
        if slide is not None:
            weights = slide.weights(slide.position(0 * theta))
            found.append(Choice(EventKind.SLIDE, (ray.left, ray.right), weights, ray, slide, free=slide.free))
    for cell, sides in junction.cells:
        if enters(field, cell, sides, junction.point, signs):
            found.append(Choice(EventKind.CROSS, (cell,)))
    return found


def enters(field: ConstantField, cell: int, sides: Sequence[tuple[int, bool]], point: Point, signs: Signs) -> bool:
    """Whether a cell's velocity points into the cell; along the border of the domain it may also be tangent."""
    twist, polygon = field.flows[cell][0].about(point), field.cells.polygons[cell]
    if not any(signs(speed, signs.speed_slack) for speed in twist.velocity):
        return False
    outward = ((departure_sign(polygon.sides[side].normal, twist, signs), border) for side, border in sides)
    return all(sense < 0 or (sense == 0 and border) for sense, border in outward)


def _rests(field: ConstantField, junction: Junction, signs: Signs) -> Iterator[Choice]:
    """Rest, where the hull of the velocities holds zero, with the interval of rotation rates."""
    flows = [(cell, field.flows[cell][0]) for cell, _ in junction.cells]
    basic = list(zero_combinations([flow.velocity(junction.point) for _, flow in flows], signs))
    if not basic:
        return
    rates = [sum(w * flows[k][1].omega for k, w in combination.items()) for combination in basic]
    order = sorted(range(len(basic)), key=lambda i: rates[i])
    low, high = rates[order[0]], rates[order[-1]]
    lowest, highest = basic[order[0]], basic[order[-1]]
    zero = low * 0
    rate = min(max(zero, low), high)
    share = (rate - low) / (high - low) if signs(high - low, signs.rate_slack) else zero
    weights: dict[int, Any] = {}
    for combination, part in ((lowest, 1 - share), (highest, share)):
        for k, weight in combination.items():
            cell = flows[k][0]
            weights[cell] = weights.get(cell, zero) + part * weight
    kept = {cell: weight for cell, weight in weights.items() if weight}
    free = bool(share) or bool(signs(high - low, signs.rate_slack))
    yield Choice(EventKind.REST, tuple(kept), tuple(kept.values()), rate=rate, rates=(low, high), free=free)


def zero_combinations(vectors: Sequence[Point], signs: Signs) -> Iterator[dict[int, Any]]:
    """Basic solutions of ``sum l_k v_k = 0, sum l_k = 1, l >= 0``: one, two or three vectors each.

    By products only, so that exact numbers stay exact; ``basic_weights`` in floats serves any number of dimensions.
    """
    moving = []
    for k, (x, y) in enumerate(vectors):
        if signs(x, signs.speed_slack) or signs(y, signs.speed_slack):
            moving.append(k)
        else:
            yield {k: x * 0 + 1}
    turns = {(i, j): cross(vectors[i], vectors[j]) for i, j in combinations(moving, 2)}
    sense = {pair: signs(value, signs.product_slack) for pair, value in turns.items()}
    for i, j in turns:
        if not sense[i, j] and sign(dot(vectors[i], vectors[j])) < 0:
            a, b = dot(vectors[i], vectors[i]), -dot(vectors[i], vectors[j])
            yield {i: b / (a + b), j: a / (a + b)}
    for i, j, k in combinations(moving, 3):
        if sense[i, j] and sense[i, j] == sense[j, k] == -sense[i, k]:
            total = turns[i, j] + turns[j, k] - turns[i, k]
            yield {i: turns[j, k] / total, j: -turns[i, k] / total, k: turns[i, j] / total}
