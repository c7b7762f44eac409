"""Equilibrium headings of a body with an outline: where it rests for a range of headings, and where for one.

At the checked point every range of headings is decided or named as undecided, under every contact rule.  Under a rule
without cells rest is also looked for around that point, in floats; on one set of wheels what is found is decided
exactly.  That search may miss poses, among them all off the point with several wheels under the edge.  What is not
proved, among it every single heading with wheels under the edge, is called sampled.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from fractions import Fraction
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.cells.contact_rule import SmoothRule, rule_of
from nonsmooth.analysis.cells.loads import LoadRegion, load_regions
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.boxes.linearization import gradient, slips_at
from nonsmooth.proofs.headings.at_point import (
    EquilibriumHeadings,
    HeadingsAt,
    RestInterval,
    SampledRest,
    point_headings,
)
from nonsmooth.symbolic.mechanics.contact_set import whole
from nonsmooth.symbolic.mechanics.continuum import Disc
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane import Vector, around, cross
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.bodies.edge_rests import SeenRest

MOST_POINTS = 24  # points of rest on one set of wheels that are decided, the nearest first
UNITS = 400_000  # of exact arithmetic for one of them
UNDER_THE_EDGE = "rest with a wheel under the edge is seen in floats, not proved"
TOO_MUCH = "its exact point takes too much arithmetic, or is none"
NEAR = 10**6  # denominator of a rational point beside a sampled one: the same wheels are loaded there


def heading_matters(scene: Scene) -> bool:
    """Whether the wheels under the body at the checked point, or close by, depend on its heading."""
    body = scene.body
    if body is None or body.is_round:
        return False
    if isinstance(body.outline, Disc):
        offset = math.hypot(*(float(entry) for entry in body.centroid))
        radius = float(body.outline.radius)
        inner, outer = radius - offset, radius + offset
    else:
        corners = [(float(x), float(y)) for x, y in body.vertices]
        inner = min(cross(a, b) / float(np.hypot(b[0] - a[0], b[1] - a[1])) for a, b in around(corners))
        outer = max(float(np.hypot(*corner)) for corner in corners)
    x, y = (float(entry) for entry in scene.check.equilibrium)
    wheels = [(float(wheel.position[0]) - x, float(wheel.position[1]) - y) for wheel in whole(scene).wheels]
    distances = np.array([np.hypot(*wheel) for wheel in wheels])
    close = outer - inner  # how far from the point a wheel may be met under the edge and still count as close by
    return bool(((distances > inner - close) & (distances < outer + close)).any())


def equilibrium_headings(scene: Scene, *, around: bool = False) -> EquilibriumHeadings | None:
    """Headings at which the body of a scene rests; None where the heading does not matter, and for unknown loads.

    Args:
        scene: with the body at the checked pose.
        around: search around the checked point too, under a rule without cells and with elastic loads.
    """
    rule = rule_of(scene)
    if not heading_matters(scene) or (rule.needs_loads and scene.contact.loads_are_unknown):
        return None
    at_point = point_headings(HeadingsAt(scene, scene.check.equilibrium))
    if not around or not isinstance(rule, SmoothRule) or not can_search(scene):
        return at_point
    return _with_surroundings(at_point, whole(scene), rule)


def can_search(scene: Scene) -> bool:
    """Whether the surroundings of the checked point can be searched: under a rule without cells, on elastic loads."""
    return isinstance(rule_of(scene), SmoothRule) and scene.contact.loads is None


def _with_surroundings(at_point: EquilibriumHeadings, every: Scene, rule: SmoothRule) -> EquilibriumHeadings:
    """What is found around the point beside what is known at it."""
    from nonsmooth.analysis.bodies.edge_rests import RestSearch  # SciPy: only a search loads it

    search = RestSearch(every, rule)
    met = search.meet()
    intervals, sampled = list(at_point.intervals), list(at_point.sampled)
    sampled += [_sampled(every, seen, UNDER_THE_EDGE) for seen in search.under_the_edge(met)]
    elsewhere = search.on_one_set(met)
    for seen in elsewhere[:MOST_POINTS]:
        proved = _intervals_of(every, seen)
        intervals += proved
        if not proved:
            sampled.append(_sampled(every, seen, TOO_MUCH))
    left_out = max(len(elsewhere) - MOST_POINTS, 0)
    return replace(at_point, intervals=tuple(intervals), sampled=tuple(sampled), reach=search.reach, left_out=left_out)


def _sampled(scene: Scene, seen: SeenRest, reason: str) -> SampledRest:
    wheels, edge = (tuple(scene.wheels[k].index for k in some) for some in (seen.wheels, seen.edge))
    return SampledRest(seen.place, seen.theta, wheels, edge, reason)


def _intervals_of(scene: Scene, found: SeenRest) -> list[RestInterval]:
    """The intervals of one candidate: its exact point, and the headings at which its wheels carry."""
    try:
        with work_limit(scene.field, UNITS):
            points = list(_exact_points(scene, found))
    except (RefusalError, SceneError, WorkLimitError):
        return []
    wheels = tuple(scene.wheels[k].index for k in found.wheels)
    sectors = [sector for point in points[:1] for sector in HeadingsAt(scene, point).sectors(wheels)]
    return [sector for sector in sectors if sector.stay.is_equilibrium]


def _exact_points(scene: Scene, found: SeenRest) -> Iterator[Vector]:
    """Where forces balance on these wheels, for each form that the loads have near the sampled point."""
    if any(scene.wheels[k].axis is not None for k in found.wheels):
        return  # forces along friction axes are no numbers of the scene
    near = tuple(scene.field(Fraction(value).limit_denominator(NEAR)) for value in found.place)
    wheels = tuple(replace(scene.wheels[k], index=number) for number, k in enumerate(found.wheels, 1))
    there = replace(scene, wheels=wheels, body=None, check=replace(scene.check, equilibrium=(near[0], near[1])))
    small = replace(there.check, radius=scene.field(Fraction(1, NEAR)))
    for region in load_regions(replace(there, check=small), there.check.equilibrium):
        point = _balance(there, region)
        if point is not None:
            yield point


def _balance(scene: Scene, region: LoadRegion) -> Vector | None:
    """``c`` at which the forces of the wheels that slip at rest balance; None where that is no point."""
    zero = scene.field.zero
    slips = [slip for slip in slips_at(scene, region, zero) if slip.piece is not BorderPiece.KINK]
    (p, q, _), (a, c, _), (b, d, _) = (gradient(zero, slips, part) for part in range(3))
    determinant = a * d - b * c
    if not determinant:
        return None
    inverse = determinant.inverse()
    return (b * q - d * p) * inverse, (c * p - a * q) * inverse
