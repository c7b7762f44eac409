"""Rule ``box`` where frictions balance exactly at c*: a law of imposed twists for each cone of directions of c.

A slope of D that vanishes at c* is linear in c beside it: between the rays on which one vanishes, or the loads change
their form, each twist is the only minimizer in all of the cone or nowhere in it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from itertools import pairwise

from nonsmooth.analysis.cells.fan import by_angle
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.box_twists import BoxTwist, Drives
from nonsmooth.proofs.clauses.feedback.driven_law import LawCone, best_three, between, rank_of
from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.plane import around, cross, dot
from nonsmooth.symbolic.scene import Scene


def law_by_direction(
    scene: Scene, regions: Sequence[LoadRegion], twists: Sequence[Triple]
) -> tuple[tuple[LawCone, ...], str]:
    """The cones of a law and a sentence; no cones, and why, where some directions have no three twists."""
    by_region = [[drives.examine(twist) for twist in twists] for drives in drives_in(scene, regions)]
    cones: list[LawCone] = []
    for start, end in _cones(scene, regions, by_region):
        middle = between(start, end)
        here = next(twists for region, twists in zip(regions, by_region, strict=True) if _points_into(region, middle))
        unique = [twist for twist in here if twist.is_unique_towards(middle)]
        if rank_of(unique) < 3:
            x, y = (brief_text(entry) for entry in middle)
            reason = (
                "exactly marginal: frictions balance at c* (a slope of D vanishes), and towards "
                f"({x}, {y}) speeds impose twists of rank {rank_of(unique)} only, as the only minimizers"
            )
            return (), reason
        cones.append(LawCone((start, end), best_three(scene, unique)))
    reason = (
        f"frictions balance exactly at c*, but in each of {len(cones)} cones of directions about it some speeds impose "
        "three independent twists, each as the only minimizer of D (Filippov solutions do not see the rays between)"
    )
    return tuple(cones), reason


def drives_in(scene: Scene, regions: Iterable[LoadRegion]) -> Iterator[Drives]:
    """What the wheels can impose, region by region."""
    return (Drives(scene, region) for region in regions)


def _cones(
    scene: Scene, regions: Sequence[LoadRegion], by_region: Sequence[Sequence[BoxTwist]]
) -> list[tuple[Point, Point]]:
    """Cones of directions inside which no slope that vanishes at c* changes its sign, nor the loads their form."""
    zero, one = scene.field.zero, scene.field.one
    lines: list[Point] = [(one, zero), (zero, one)]
    lines += [side.normal for region in regions for side in region.polygon.sides if not sign(side.offset)]
    lines += [(form[1], form[2]) for twists in by_region for twist in twists for form in twist.ties if any(form)]
    rays = sorted(((-b * s, a * s) for a, b in lines for s in (1, -1)), key=by_angle)
    rays = [rays[0], *(ray for last, ray in pairwise(rays) if cross(last, ray))]  # none is a half turn from the next
    return around(rays)


def _points_into(region: LoadRegion, direction: Point) -> bool:
    """Whether a direction leads from the equilibrium into a load region that holds it."""
    through = (side for side in region.polygon.sides if not sign(side.offset))
    return all(sign(dot(side.normal, direction)) < 0 for side in through)
