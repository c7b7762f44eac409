"""A clause that the product does not have: whether the wheels lie symmetrically about the checked point."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum

from nonsmooth.proofs.clauses.clause import CheckedArray, Clause
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.proofs.findings import Fact, Theorem4, number_fact
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import Vector, dot


class Mirror(StrEnum):
    """Whether every wheel has a counterpart."""

    YES = "symmetric"
    NO = "not symmetric"


@dataclass(frozen=True)
class MirrorResult:
    """The places without a counterpart."""

    scene: Scene
    alone: tuple[Vector, ...]

    @property
    def verdict(self) -> Mirror:
        """Symmetric where none is alone."""
        return Mirror.NO if self.alone else Mirror.YES

    @property
    def reason(self) -> str:
        """How many are alone."""
        return f"{len(self.alone)} wheels have no counterpart across the point"


def find_mirror(scene: Scene) -> MirrorResult:
    """Look for a wheel at the opposite place of every wheel of a centred scene."""
    places = [wheel.position for wheel in scene.wheels]
    return MirrorResult(scene, tuple((x, y) for x, y in places if (-x, -y) not in places))


class MirrorClause(Clause[MirrorResult]):
    """The wheels lie symmetrically about the point."""

    name = "mirror"

    def decide(self, work: Workspace) -> MirrorResult:
        """By looking."""
        return find_mirror(work.scene)

    def undecided(self, result: MirrorResult, reason: str) -> MirrorResult:
        """Places are compared exactly: they are as they are."""
        return result

    def settles(self, result: MirrorResult) -> tuple[Theorem4, str] | None:
        """An array that is not symmetric fails, for the sake of the rehearsal."""
        return (Theorem4.FAILS, result.reason) if result.alone else None

    def facts(self, result: MirrorResult, check: CheckedArray) -> Iterator[Fact]:
        """How far the farthest wheel is."""
        farthest = max(dot(wheel.position, wheel.position) for wheel in result.scene.wheels)
        yield number_fact("farthest", farthest, "the farthest wheel has |p|^2 = {}")
