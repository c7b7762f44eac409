"""What the clauses of one check decide from, each part built once, and what was left out on the way."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from typing import Any, Protocol, TypeAlias, TypeVar

from nonsmooth.analysis.cells.contact_rule import CellRule, Rule, rule_of
from nonsmooth.analysis.cells.loads import load_regions
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.boxes.enclosed_rest import rest_at_point
from nonsmooth.proofs.clauses.at_point.cocircular import CocircularArray, cocircular_array
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, ellipse_point
from nonsmooth.proofs.clauses.at_point.every_load import EveryLoadPoint, every_load_point
from nonsmooth.proofs.findings import Equilibrium
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.rounded import PLACE_DECIDES, ROUNDING_DECIDES, Rounded, either_way

Announce: TypeAlias = Callable[[str], None]  # called with the name of each step before it begins
Part = TypeVar("Part")
LEMMA = "V* <= 0 by the lemma on inward rims on one circle"


def unheard(step: str) -> None:
    """Where nobody listens."""


class ClauseResult(Protocol):
    """Verdict, reason and evidence of one clause; frozen."""

    @property
    def verdict(self) -> StrEnum:
        """The answer, one of a closed set."""
        ...

    @property
    def reason(self) -> str:
        """Why, in one sentence for people."""
        ...


@dataclass(frozen=True)
class Skipped:
    """Work left out because no verdict needs it."""

    what: str
    count: int
    why: str


class Workspace:
    """One check under way.

    Attributes:
        given: the array as it was given.
        scene: the same, centred at the checked point.
        prune: whether to leave out what no verdict needs.
        sample: whether to evaluate at sampled points what is not known exactly; no verdict rests on it.
        earlier: the results of the clauses that are decided, by name.
        skipped: what was left out, and why.
        seconds: where the time went, by step.
        by_rounding: names of the clauses that are not the same, or not known to be, for all members of rounded numbers.

    Cells that were ``built`` before are taken where they are those of the centred scene, or have the same polygons.
    """

    def __init__(
        self,
        given: Scene,
        *,
        prune: bool = True,
        sample: bool = True,
        announce: Announce = unheard,
        built: Partition | None = None,
    ) -> None:
        self.given = given
        self.scene = given.recentred()
        self.prune = prune
        self.sample = sample
        self.earlier: dict[str, ClauseResult] = {}
        self.skipped: list[Skipped] = []
        self.seconds: dict[str, float] = {}
        self.by_rounding: set[str] = set()
        self._announce = announce
        self._built = built
        self._parts: dict[str, Any] = {}
        self._rounded_parts: set[str] = set()

    @property
    def rule(self) -> Rule:
        """The contact rule."""
        return rule_of(self.scene)

    def distrust_parts(self) -> None:
        """What was built so far may rest on rounding: from now on that counts again for whoever uses it."""
        self._rounded_parts |= self._parts.keys()

    @property
    def rounding_reason(self) -> str:
        """Why a clause claims nothing that rounded numbers alone decided: of the angles, or of the place."""
        return PLACE_DECIDES if isinstance(self.given.check.equilibrium[0], Rounded) else ROUNDING_DECIDES

    def _part(self, name: str, build: Callable[[], Part]) -> Part:
        """What the function gives, built once; what rounding decided of it counts at every use."""
        field = self.scene.field
        before = field.rounded_signs
        if name not in self._parts:
            self._parts[name] = build()
            if field.rounded_signs > before:
                self._rounded_parts.add(name)
        elif name in self._rounded_parts:
            field.rounded_signs += 1
        part: Part = self._parts[name]
        return part

    @property
    def lemma(self) -> CocircularArray | None:
        """The certificate of ``V* <= 0`` on the whole square, where the array meets its hypotheses."""
        return self._part("lemma", lambda: cocircular_array(self.scene))

    @property
    def leaves_loads_open(self) -> bool:
        """Whether the rule asks for loads and the scene names a set of them."""
        return self.rule.needs_loads and self.scene.contact.loads_are_unknown

    @property
    def every_load(self) -> EveryLoadPoint:
        """The motion at the point under every load of the scene.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where the loads do not exist.
        """
        return self._part("every load", lambda: every_load_point(self.scene))

    @property
    def partition(self) -> Partition | None:
        """The cells of the square, or where the lemma covers it only those of rest at the point; None without cells.

        Loads that are left open give no cells either: at one place one twist follows from one load.

        Raises:
            RefusalError: where the motion is not determined.
        """
        return self._part("partition", self._build_partition)

    def _build_partition(self) -> Partition | None:
        rule = self.rule
        if not isinstance(rule, CellRule) or self.leaves_loads_open:
            return None
        rest = rule.build_rest_partition(self.scene) if self.lemma is not None and self.prune else None
        if rest is not None:
            self.skip("cells away from the point", 1, f"{LEMMA}: no other cells are needed")
            return rest
        is_exact = not self.scene.field.measured  # else what rounding decided of those cells is not known any more
        built = self._built if self.prune else None
        if built is not None and built.scene is self.scene and is_exact:
            partition = built
        else:
            like = built and rule.partition_like(self.scene, built)
            partition = like or rule.build_partition(self.scene, prune=self.prune)
        idle = len(self.scene.wheels) - partition.wheels_considered
        if idle:
            in_pairs = all(state.is_of_a_pair for state in partition.states)
            where = "to be among the two nearest" if in_pairs else "for any of their rows to be taken"
            self.skip("wheels", idle, f"too far away {where} anywhere in the square")
        return partition

    @property
    def point(self) -> EllipsePoint:
        """The exact motion at the point under a rule without cells, or the place of rest that is it within rounding.

        Raises:
            nonsmooth.analysis.cells.loads.LoadError: where the loads do not exist.
        """
        return self._part("point", self._build_point)

    def _build_point(self) -> EllipsePoint:
        field = self.scene.field
        before = field.rounded_signs
        point = ellipse_point(self.scene, load_regions(self.scene, self.scene.check.equilibrium))
        if point.equilibrium is not Equilibrium.UNDECIDED and field.rounded_signs == before:
            return point
        with either_way(field):  # the enclosure holds for every member of what was rounded
            rest = rest_at_point(self.scene)
        if rest is None:
            return point
        field.rounded_signs = before  # nothing that is said of the enclosed place rests on them
        return point.resting(rest)

    def skip(self, what: str, count: int, why: str) -> None:
        """Say what is left out."""
        self.skipped.append(Skipped(what, count, why))

    @contextmanager
    def timed(self, step: str) -> Iterator[None]:
        """Say which step begins, and note the time that it takes."""
        self._announce(step)
        start = time.perf_counter()
        yield
        self.seconds[step] = time.perf_counter() - start
