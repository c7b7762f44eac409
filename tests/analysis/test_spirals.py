"""A million switches and more: spirals that hardly contract, in floats, against the exact geometric series.

The cells of an array around its corner nearest to the checked point get motions that turn about it and lose a given
share of the distance per turn.  The limit of infinitely many turns is a geometric series; time and condition
(``1/(1 - gain)``) follow from one turn of the floats as they are, exactly.  Where the gain is not told from one, the
path must not be summed: it ends with the largest number of events, or is taken for a closed orbit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest

from nonsmooth.analysis.cells.cell_complex import AtCorner
from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.fields.constant_field import ConstantField, Flow, array_field
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.result import EndReason
from nonsmooth.analysis.trajectories.slides import Ray, junction_at
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.analysis.trajectories.turns import DRAWN_DISTANCE
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.plane import around

LOSSES = (1e-3, 1e-5, 1e-8, 1e-11)  # share of the distance lost per turn: some 1e5 to 1e13 switches
UNTOLD = 1e-14  # a loss that floats do not tell from none
ROUNDINGS = 256 * 2.0**-52  # of a turn: half a dozen quotients for each ray, and the series


@pytest.mark.parametrize("name", ["four-wheel", "ring-3", "ring-5", "spiral-30", "grid-4x4"])
def test_spirals_of_many_switches_end_where_the_series_does(name: str) -> None:
    field = array_field(build_partition(load_scene(name)), Kinematics.LEADING)
    corner = inner_corner(field)
    for loss in (*LOSSES, UNTOLD):
        turning, rays = turning_field(field, corner, loss)
        x, y = turning.cells.points[corner]
        distance = min(ray.reach for ray in rays) * DRAWN_DISTANCE / 4
        a, b = rays[0].direction
        end = simulate(turning, (x + distance * a, y + distance * b, 0.0), None).end
        gain, time = exact_turn(turning, rays, distance)
        if loss == UNTOLD:
            assert end.reason in {EndReason.EVENTS, EndReason.CIRCLES}
            continue
        error = max(abs(float(end.t) / float(time / (1 - gain)) - 1), abs(end.state[0] - x), abs(end.state[1] - y))
        assert error <= ROUNDINGS / float(1 - gain)


def inner_corner(field: ConstantField) -> int:
    """The corner nearest to the centre that no border of the domain meets and around which paths can turn."""
    x, y = field.centre
    found = []
    for k, (a, b) in enumerate(field.cells.points):
        junction = junction_at(field, AtCorner(k), (a, b))
        if not junction.border and len(junction.rays) > 2:
            found.append((math.hypot(a - x, b - y), k))
    return min(found)[1]


def turning_field(field: ConstantField, corner: int, loss: float) -> tuple[ConstantField, list[Ray]]:
    """Motions that turn counterclockwise about a corner, each along the chord of its cone, a little inward."""
    rays = list(junction_at(field, AtCorner(corner), field.cells.points[corner]).rays)
    rays.sort(key=lambda ray: math.atan2(ray.direction[1], ray.direction[0]))
    flows = list(field.flows)
    for ray, following in around(rays):
        a, b = np.array(ray.direction), np.array(following.direction)
        v = b - a - loss / len(rays) * b
        flows[ray.left] = (Flow(float(v[0]), float(v[1]), 0.0, 0.0),)
    return replace(field, flows=tuple(flows)), rays


def exact_turn(field: ConstantField, rays: Sequence[Ray], start: float) -> tuple[Fraction, Fraction]:
    """Gain and duration of one turn from a distance on the first ray, for the floats as they are."""
    distance, time = Fraction(start), Fraction(0)
    for ray, following in around(rays):
        flow = field.flows[ray.left][0]
        (a, b), (c, d) = (map(Fraction, pair) for pair in (ray.direction, following.direction))
        v, w = Fraction(flow.vx), Fraction(flow.vy)
        lasts = distance * (a * d - b * c) / (c * w - d * v)
        distance = ((distance * a + lasts * v) * c + (distance * b + lasts * w) * d) / (c * c + d * d)
        time += lasts
    return distance / Fraction(start), time
