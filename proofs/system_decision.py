"""The stability of a plain system in any number of states: one result, from the strategies that speak of it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from nonsmooth.proofs.kernel.cells import BeyondReachError
from nonsmooth.proofs.many_states.decision import SpacePoint
from nonsmooth.proofs.strategies import STRATEGIES
from nonsmooth.proofs.systems.findings import CheckedPoint, Finding, Known, Method, Reach, Strategy
from nonsmooth.proofs.systems.scalar_stability import LinePoint
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.notebook import html_table
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem, require_stated

POINTS: Mapping[int, Callable[[SwitchedSystem], CheckedPoint]] = {1: LinePoint, len(PLANE): PlanePoint}


@dataclass(frozen=True, repr=False)
class StabilityResult:
    """The stability of the checked point with everything that was found.

    Attributes:
        scene: the system; one that encloses its numbers where that is looked at in its place.
        equilibrium: whether 0 is in F.
        findings: in the order in which they were made; where nothing decides the last one says so.
        given: the scene's V on the first domain that was looked at, likewise; None where none was.
        reach: how far and how fast solutions come to the point.
    """

    scene: SwitchedSystem
    equilibrium: Equilibrium
    findings: tuple[Finding, ...]
    given: Any
    reach: Reach

    @property
    def deciding(self) -> Finding:
        """The finding that decides."""
        standing = Known(self.findings).standing
        if standing is None:
            raise ValueError("required a result with findings")
        return standing

    @property
    def verdict(self) -> Translation:
        """Strong stability."""
        return self.deciding.verdict

    @property
    def reason(self) -> str:
        """Why, in one sentence for people."""
        return self.deciding.reason

    @property
    def method(self) -> str:
        """The theorem that decides."""
        return self.deciding.theorem

    @property
    def function(self) -> Any:
        """The V that shows the verdict, an :class:`ExaminedFunction`; None where something else decides alone."""
        return self.deciding.function

    @property
    def exit_status(self) -> int:
        """0 stable, 1 unstable or no equilibrium, 3 undecided."""
        return {Translation.UNSTABLE: 1, Translation.UNDECIDED: 3}.get(self.verdict, 0)

    def by(self, theorem: str) -> Finding | None:
        """What a theorem shows; None where it shows nothing, or was not asked."""
        return next((own for own in self.findings if own.theorem is theorem), None)

    def __repr__(self) -> str:
        said = f"verdict={str(self.verdict)!r}, method={str(self.method)!r}, reason={self.reason!r}"
        return f"{type(self).__name__}({said}, findings=<{len(self.findings)} entries>)"

    def _repr_html_(self) -> str:
        rows = [(self.verdict, self.method, self.reason)]
        return html_table(f"{self.scene.name}: strong stability", ("verdict", "by", "reason"), rows)

    def check(self) -> bool:
        """Verify every V, what follows from it, and how far it carries; decide again what takes no search."""
        deciding = self.deciding
        others = {id(own): own for own in (self.given, *(f.function for f in self.findings)) if own is not None}
        others.pop(id(deciding.function), None)  # verified with the reach
        stated = self.given is None or self.given.formula == self.scene.check.lyapunov
        if not stated or not all(own.check(self.scene) for own in others.values()):
            return False
        point = checked_point(self.scene)
        known = _walk(point, self.findings)
        again = known.findings or (_open(point),)
        same = again == self.findings and _equilibrium(point, self.verdict) is self.equilibrium
        return same and point.verifies(self.reach, deciding)


def decide_system(system: SwitchedSystem) -> StabilityResult:
    """Decide the stability of the checked point.

    Raises:
        SceneError: for formulas that cannot be used, and for denominators that may vanish.
    """
    point = checked_point(system)
    findings = _walk(point, None).findings or (_open(point),)
    deciding = Known(findings).standing or findings[-1]
    equilibrium = _equilibrium(point, deciding.verdict)
    return StabilityResult(point.system, equilibrium, findings, point.given, point.reach(deciding))


def checked_point(system: SwitchedSystem) -> CheckedPoint:
    """The checked point with what strategies share.

    Raises:
        SceneError: for formulas that cannot be used, and for denominators that may vanish.
    """
    if len(system.states) > len(PLANE):
        require_stated(system)
    return POINTS.get(len(system.states), SpacePoint)(system)


def _walk(point: CheckedPoint, claimed: tuple[Finding, ...] | None) -> Known:
    """What the strategies find, one after the other, until one says that none says more.

    Args:
        point: with its system.
        claimed: the findings of a result that is checked: those of searches are verified, and not searched; None
            where everything is to be found.
    """
    known = Known()
    for strategy in STRATEGIES:
        if len(point.system.states) not in strategy.states:
            continue
        found = _asked(strategy, point, known, claimed)
        if found is not None:
            known = Known((*known.findings, found))
            if found.is_final:
                break
    return known


def _asked(
    strategy: Strategy, point: CheckedPoint, known: Known, claimed: tuple[Finding, ...] | None
) -> Finding | None:
    """What a strategy finds, or of one that searches what is claimed next, if that verifies."""
    try:
        if claimed is None or strategy.verify is None:
            return strategy.decide(point, known)
        following = next(iter(claimed[len(known.findings) :]), None)
        found = None if following is None else strategy.verify(point, known, following)
        return found if found == following else None
    except BeyondReachError:
        return None


def _open(point: CheckedPoint) -> Finding:
    """That nothing decides, and why."""
    return Finding(Method.NONE, Translation.UNDECIDED, point.open_reason)


def _equilibrium(point: CheckedPoint, verdict: Translation) -> Equilibrium:
    """Whether 0 is in F: it is where solutions stay near."""
    stays = verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE)
    return Equilibrium.HOLDS if stays else point.equilibrium
