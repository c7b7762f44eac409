"""A million switches and more: spirals that hardly contract, and paths followed for very long.

The cells of the scene around its corner nearest to the checked point get motions that turn about it and lose a given
share of the distance per turn.  The limit of infinitely many turns is a geometric series; time and condition
(``1/(1 - gain)``) follow at 60 digits from where the float motion carries one turn.  Where the gain is not told from
one, the path must not be summed: it ends with the largest number of events.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from flint import arb

from nonsmooth.analysis.cells.cell_complex import AtCorner
from nonsmooth.analysis.fields.constant_field import ConstantField, Flow
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.system_field import constant_system
from nonsmooth.analysis.measurements.cases.followed_field import START, FollowedField, followed_fields
from nonsmooth.analysis.measurements.harness import Case
from nonsmooth.analysis.measurements.references.taylor import Reached, precision
from nonsmooth.analysis.measurements.rows import EPSILON, Rows, asserted, counted, judged
from nonsmooth.analysis.trajectories.junction import Ray, junction_at
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.analysis.trajectories.turns import DRAWN_DISTANCE
from nonsmooth.symbolic.number_text import power_text
from nonsmooth.symbolic.plane import around, cross, dot
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import SwitchedSystem

SPIRAL, LONG = "spiral of many switches", "path followed for long"
LOSSES = (1e-3, 1e-5, 1e-8, 1e-11)  # share of the distance lost per turn
UNTOLD = 1e-14  # a loss that floats do not tell from none
TURNED_TO = 1e-12  # share of the distance to which switches are counted
ROUNDINGS = 256  # of a turn: half a dozen quotients for each ray, and the series
SPANS, SMOOTH_SPANS = 1e6, 1e2  # duration of long paths, in times that it takes to cross the square


def spiral_rows(field: ConstantField) -> Rows:
    """Spirals around the corner nearest to the centre; none for cells without an inner corner."""
    corner = _inner_corner(field)
    if corner is None:
        return
    for loss in (*LOSSES, UNTOLD):
        turning, rays = _turning(field, corner, loss)
        x, y = turning.cells.points[corner]
        distance = min(ray.reach for ray in rays) * DRAWN_DISTANCE / 4
        a, b = rays[0].direction
        path = simulate(turning, (x + distance * a, y + distance * b, 0.0), None)
        gain, time = _turn_at_60_digits(turning, rays, distance)
        lost = float((1 - gain).mid())
        count = len(rays) * math.log(TURNED_TO) / math.log1p(-lost) if lost > 0 else math.inf
        parameter, verdict = f"loss {power_text(loss)}", f"{count:.1e} switches: {path.end.reason}"
        if loss == UNTOLD:
            ok = path.end.reason in {EndReason.EVENTS, EndReason.CIRCLES}
            note = "a gain not told from one must not be summed"
            yield asserted(SPIRAL, parameter, verdict, note, ok=ok, condition=1 / abs(lost) if lost else None)
            continue
        limit = float((time / (1 - gain)).mid())
        error = max(abs(float(path.end.t) / limit - 1), abs(path.end.state[0] - x), abs(path.end.state[1] - y))
        bound = ROUNDINGS * EPSILON / lost
        yield judged(SPIRAL, parameter, verdict, error, bound, condition=1 / lost, why="rounding of a gain near one")


def long_rows(followed: FollowedField) -> Rows:
    """The scene's own path for a million crossings of the square, or as long as there are events left."""
    closed = isinstance(followed.field, ConstantField)
    spans = SPANS if closed else SMOOTH_SPANS
    start, until = followed.place(*START), spans * followed.span
    path = simulate(followed.field, start, until)
    verdict, parameter = f"{path.end.reason}, {counted(len(path.events), 'event')}", f"{power_text(spans)} crossings"
    if path.end.reason is EndReason.EVENTS:
        ok = all(math.isfinite(float(value)) for value in path.end.state)
        yield asserted(LONG, parameter, verdict, "a clear end: no endless loop, no invented limit", ok=ok)
        return
    reached, why = Reached(float(path.end.t), path.end.state), "it ends"
    if followed.reference.exact is not None:
        reached = followed.reference.reached(start, min(until, reached.time))
        why = "rounding of the time times the speed"
    growth = max(1.0, reached.time / followed.span)
    bound = 64 * EPSILON * growth + followed.slack / followed.radius + followed.step_error
    error = followed.distance(path.at(reached.time), reached.state)
    yield judged(LONG, parameter, verdict, error, bound, condition=growth, why=why)


def _inner_corner(field: ConstantField) -> int | None:
    """The corner nearest to the centre that no border of the domain meets and around which paths can turn."""
    x, y = field.centre
    found = []
    for k, (a, b) in enumerate(field.cells.points):
        junction = junction_at(field, AtCorner(k), (a, b))
        if not junction.border and len(junction.rays) > 2:
            found.append((math.hypot(a - x, b - y), k))
    return min(found)[1] if found else None


def _turning(field: ConstantField, corner: int, loss: float) -> tuple[ConstantField, list[Ray]]:
    """Motions that turn counterclockwise about a corner, each along the chord of its cone, a little inward."""
    rays = list(junction_at(field, AtCorner(corner), field.cells.points[corner]).rays)
    rays.sort(key=lambda ray: math.atan2(ray.direction[1], ray.direction[0]))
    flows = list(field.flows)
    for ray, following in around(rays):
        a, b = np.array(ray.direction), np.array(following.direction)
        chord, shrink = b - a, -loss / len(rays)
        v = chord + shrink * b
        flows[ray.left] = (Flow(float(v[0]), float(v[1]), 0.0, 0.0),)
    return replace(field, flows=tuple(flows)), rays


def _turn_at_60_digits(field: ConstantField, rays: Sequence[Ray], distance: float) -> tuple[Any, Any]:
    """Gain and duration of one turn from a distance on the first ray, for the floats as they are."""
    with precision():
        s, time = arb(distance), arb(0)
        for ray, following in around(rays):
            flow = field.flows[ray.left][0]
            a, b, v = (
                (arb(float(x)), arb(float(y))) for x, y in (ray.direction, following.direction, (flow.vx, flow.vy))
            )
            lasts = s * cross(a, b) / cross(b, v)
            s = dot((s * a[0] + lasts * v[0], s * a[1] + lasts * v[1]), b) / dot(b, b)
            time += lasts
        return (s / distance).mid(), time.mid()


def _scene_rows(scene: Scene | SwitchedSystem) -> Rows:
    for followed in followed_fields(scene, Kinematics.LEADING):
        field = constant_system(scene) if isinstance(scene, SwitchedSystem) else followed.field
        if isinstance(field, ConstantField):
            yield from spiral_rows(field)
        yield from long_rows(followed)


SWITCHES = Case("switches", array=_scene_rows, system=_scene_rows)
