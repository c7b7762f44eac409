"""Headings at which a body rests with its centre of mass at one point, exactly.

The motion depends on the point and on the wheels under the outline, and on the heading through these alone.  So with
the centre of mass at c0, every heading between two that bring wheels under the edge has one verdict: the one decided
exactly, by the clauses of a check, at a rational heading between them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TypeAlias, cast

from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.clauses import registry
from nonsmooth.proofs.clauses.clause import ClauseResult
from nonsmooth.proofs.clauses.equilibrium.at_point import EllipseEquilibrium
from nonsmooth.proofs.clauses.rotation.on_cells import RotationResult
from nonsmooth.proofs.clauses.translation.clause import AnyTranslation
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.verdicts import Equilibrium, Rotation, Translation
from nonsmooth.symbolic.contact_set import standing, whole
from nonsmooth.symbolic.edge_headings import BallOutline, Gap, gaps, halved, places_of, seen
from nonsmooth.symbolic.numbers.enclosures import PRECISION
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import SceneError

NEEDED = ("equilibrium", "translation", "rotation")
UNITS = 400_000  # of exact arithmetic for one set of wheels: half a second or so
DENOMINATORS = tuple(10**k for k in range(16))  # of half tangents that are tried, simple ones first

Wheels: TypeAlias = tuple[int, ...]  # numbers, ascending
Results: TypeAlias = Mapping[str, ClauseResult]
Verdicts: TypeAlias = tuple[Translation, Rotation, bool]


@dataclass(frozen=True)
class RestInterval:
    """An open interval of headings at which the centre of mass stays at one point, on the same wheels.

    Attributes:
        scene: all wheels, with the body at the point, at the checked heading.
        gap: the interval, in radians from that heading.
        wheels: numbers of the wheels that carry.
        translation: whether the place attracts, while the same wheels carry.
        rotation: what the heading does there.
        rests: whether the body may stand still there; otherwise it turns on the spot.
    """

    scene: Scene
    gap: Gap
    wheels: Wheels
    translation: Translation
    rotation: Rotation
    rests: bool

    @property
    def ends(self) -> tuple[Wheels, Wheels]:
        """Numbers of the wheels under the edge at the lower and at the upper end."""
        below, above = (tuple(self.scene.wheels[k].index for k in ends) for ends in self.gap.ends)
        return below, above

    def check(self) -> bool:
        """Decide again, at another heading of the interval, which wheels carry and what they do."""
        with ctx.workprec(PRECISION):
            found = _direction_between((self.gap.low + 2 * self.gap.high) / 3, self.gap.high)
        if found is None:
            return False
        again = _verdicts_at(_turned(self.scene, found))
        return again == (self.wheels, (self.translation, self.rotation, self.rests))

    def repeats(self, other: RestInterval) -> bool:
        """Whether the same wheels carry in this interval, at the same point, as in another, with the same verdicts."""
        with ctx.workprec(PRECISION):
            here = HeadingsAt(self.scene, self.scene.check.equilibrium)
            wheels = here.carrying((2 * self.gap.low + self.gap.high) / 3)
        claims = [(one.wheels, one.translation, one.rotation, one.rests) for one in (self, other)]
        same_point = self.scene.check.equilibrium == other.scene.check.equilibrium
        return same_point and wheels == self.wheels and claims[0] == claims[1]


class HeadingsAt:
    """The intervals of headings at one point of one scene."""

    def __init__(self, scene: Scene, point: Vector) -> None:
        """For a scene with a body, at a point in its numbers.

        Raises:
            ValueError: for a scene without a body.
        """
        if scene.body is None:
            raise ValueError("required a scene with a body")
        self.scene = replace(whole(scene), check=replace(scene.check, equilibrium=point))
        with ctx.workprec(PRECISION):
            self._outline = BallOutline(scene.body)
            self._places = places_of([wheel.position for wheel in self.scene.wheels], point)
        self._decided: dict[Wheels, Verdicts | None] = {}

    def gaps(self) -> list[Gap]:
        """Between headings at which a wheel lies under the edge."""
        return gaps([edge for k, place in enumerate(self._places) for edge in self._outline.edge_headings(k, place)])

    def intervals(self, only: Wheels | None = None) -> Iterator[RestInterval]:
        """Those in which the centre of mass is proved to stay; the others tell nothing.

        Args:
            only: numbers of wheels; then the intervals in which these carry, and no others.
        """
        with ctx.workprec(PRECISION):
            for gap in self.gaps():
                found = self._interval(gap, only)
                if found is not None:
                    yield found

    def at(self, theta: arb) -> Gap | None:
        """The gap that certainly holds a heading."""
        with ctx.workprec(PRECISION):
            for gap in self.gaps():
                offset = halved(theta - (gap.low + gap.high) / 2)
                if abs(offset) < (gap.high - gap.low) / 2:
                    return gap
        return None

    def _interval(self, gap: Gap, only: Wheels | None) -> RestInterval | None:
        wheels = self.carrying((gap.low + gap.high) / 2)
        if wheels is None or only not in (None, wheels):
            return None
        if wheels not in self._decided:
            self._decided[wheels] = self._verdicts(gap, wheels)
        verdicts = self._decided[wheels]
        return None if verdicts is None else RestInterval(self.scene, gap, wheels, *verdicts)

    def carrying(self, theta: arb) -> Wheels | None:
        """Numbers of the wheels under the body at a heading; None where that is not certain."""
        theta = theta.mid()
        sides = [self._outline.side_of(seen(place, theta)) for place in self._places]
        if 0 in sides:
            return None
        return tuple(wheel.index for wheel, side in zip(self.scene.wheels, sides, strict=True) if side > 0)

    def _verdicts(self, gap: Gap, wheels: Wheels) -> Verdicts | None:
        """What happens in a gap, by the exact clauses at a rational heading in it."""
        direction = _direction_between(gap.low, gap.high)
        found = None if direction is None else _verdicts_at(_turned(self.scene, direction))
        return found[1] if found is not None and found[0] == wheels else None


def _verdicts_at(scene: Scene) -> tuple[Wheels, Verdicts] | None:
    """What happens at the checked pose of a scene; None where the body is not proved to stay, or that is much work."""
    try:
        with work_limit(scene.field, UNITS):
            stands = standing(scene)
            work = Workspace(stands, sample=False)
            for clause in registry.CLAUSES:
                if clause.name in NEEDED:
                    work.earlier[clause.name] = clause.decide(work)
            rests = _rests(work.earlier)
    except (RefusalError, WorkLimitError, SceneError):
        return None
    if rests is None or work.earlier["equilibrium"].verdict is not Equilibrium.HOLDS:
        return None
    translation = cast("AnyTranslation", work.earlier["translation"]).verdict
    rotation = cast("RotationResult", work.earlier["rotation"]).verdict
    return tuple(wheel.index for wheel in stands.wheels), (translation, rotation, rests)


def _rests(results: Results) -> bool | None:
    """Whether rest is among the motions at the point; None where that is not known."""
    equilibrium = results["equilibrium"]
    if isinstance(equilibrium, EllipseEquilibrium):
        twist = equilibrium.point.twist
        return None if twist is None else not any(twist)
    drift = cast("RotationResult", results["rotation"]).drift
    return None if drift is None else drift.interval[0] <= 0 <= drift.interval[1]


# ---- rational headings ---------------------------------------------------------------------------

Direction: TypeAlias = tuple[Fraction, Fraction]


def _direction_between(low: arb, high: arb) -> Direction | None:
    """A simple rational direction of length one whose angle lies certainly between two; None where none is found."""
    middle = (low + high) / 2
    if halved(middle + arb.pi()).overlaps(arb(0)):
        return Fraction(-1), Fraction(0)
    half = math.tan(float(halved(middle).mid()) / 2)
    for denominator in DENOMINATORS:
        found = _on_circle(Fraction(half).limit_denominator(denominator))
        offset = halved(_angle(found) - middle)
        if abs(offset) < (high - low) / 2:
            return found
    return None


def _on_circle(h: Fraction) -> Direction:
    size = 1 + h * h
    return (1 - h * h) / size, 2 * h / size


def _angle(direction: Direction) -> arb:
    c, s = (arb(fmpq(entry.numerator, entry.denominator)) for entry in direction)
    return arb.atan2(s, c)


def _turned(scene: Scene, direction: Direction) -> Scene:
    """The scene with its body turned by a direction."""
    body = scene.body
    if body is None:
        raise ValueError("required a scene with a body")
    (c, s), (x, y) = (scene.field(entry) for entry in direction), body.heading
    return replace(scene, body=replace(body, heading=(c * x - s * y, s * x + c * y)))
