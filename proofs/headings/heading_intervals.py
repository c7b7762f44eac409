"""Headings at which a body rests with its centre of mass at one point, on the same wheels.

The motion depends on the point and on the wheels under the outline, and on the heading through these alone.  So with
the centre of mass at c0, every heading between two that bring wheels under the edge has one verdict.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TypeAlias

from flint import arb, ctx

from nonsmooth.proofs.headings.stay import Stay, Stays, StaysAt
from nonsmooth.symbolic.contact_set import whole
from nonsmooth.symbolic.edge_headings import BallOutline, Gap, HeadingCluster, clusters, gaps, places_of, seen
from nonsmooth.symbolic.numbers.enclosures import PRECISION
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene import Scene

Wheels: TypeAlias = tuple[int, ...]  # numbers, ascending


@dataclass(frozen=True)
class RestInterval:
    """An open interval of headings on the same wheels, with the centre of mass at one point.

    Attributes:
        scene: all wheels, with the body at the point, at the checked heading.
        gap: the interval, in radians from that heading.
        wheels: numbers of the wheels that carry; None where that is not certain.
        stay: what the body does there.
    """

    scene: Scene
    gap: Gap
    wheels: Wheels | None
    stay: Stay

    @property
    def ends(self) -> tuple[Wheels, Wheels]:
        """Numbers of the wheels under the edge at the lower and at the upper end."""
        below, above = (tuple(self.scene.wheels[k].index for k in ends) for ends in self.gap.ends)
        return below, above


class HeadingsAt:
    """The headings at one point of one scene."""

    def __init__(self, scene: Scene, point: Vector) -> None:
        """For a scene with a body, at a point in its numbers.

        Raises:
            ValueError: for a scene without a body.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        self.scene = replace(whole(scene), check=replace(scene.check, equilibrium=point))
        with ctx.workprec(PRECISION):
            self.outline = BallOutline(scene.body)
            self.places = places_of([wheel.position for wheel in self.scene.wheels], point)
            self.stays = StaysAt(self.scene)

    def clusters(self) -> list[HeadingCluster]:
        """Headings with wheels under the edge, in ascending order."""
        with ctx.workprec(PRECISION):
            return clusters([edge for k, at in enumerate(self.places) for edge in self.outline.edge_headings(k, at)])

    def sectors(self, only: Wheels | None = None) -> Iterator[RestInterval]:
        """All intervals between these headings, in ascending order.

        Args:
            only: numbers of wheels; then the intervals in which these carry, and no others.
        """
        with ctx.workprec(PRECISION):
            for gap in gaps(self.clusters()):
                wheels = self.carrying((gap.low + gap.high) / 2) if gap.low < gap.high else None
                if only in (None, wheels):
                    yield RestInterval(self.scene, gap, wheels, self._stay(wheels))

    def carrying(self, theta: arb) -> Wheels | None:
        """Numbers of the wheels under the body at a heading; None where that is not certain."""
        theta = theta.mid()
        sides = [self.outline.side_of(seen(place, theta)) for place in self.places]
        if 0 in sides:
            return None
        return tuple(wheel.index for wheel, side in zip(self.scene.wheels, sides, strict=True) if side > 0)

    def _stay(self, wheels: Wheels | None) -> Stay:
        if wheels is None:
            return Stay(Stays.UNDECIDED, reason="headings that balls do not tell apart")
        return self.stays.on(wheels)
