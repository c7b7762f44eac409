"""What theorems show of the checked point of a plain system, in any number of states.

A :class:`Finding` is a theorem with what it shows; what it rests on is a small object of its strategy.  A V is an
:class:`ExaminedFunction`, however its conditions were decided.  How far a proved V carries is a :class:`Reach`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, field
from enum import StrEnum
from importlib import import_module
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.findings import Equilibrium, Fact, Record, Translation
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, Refutation, Supremum
from nonsmooth.proofs.systems.domain import (
    DecayRate,
    DisturbanceGain,
    Domain,
    RegionRate,
    ReshapedRegion,
    SublevelRegion,
)
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

if TYPE_CHECKING:
    from nonsmooth.proofs.kernel.arrival import Arrival
    from nonsmooth.proofs.kernel.homogeneity import Homogeneity
    from nonsmooth.proofs.systems.basin import CertifiedBasin

DERIVATIVES = {
    "naive": "naive",
    "shevitz_paden": "Shevitz-Paden",
    "bacciotti_ceragioli": "Bacciotti-Ceragioli",
}
NOT_ATTRACTING = "not asymptotically: "  # what the reason of a stable point says before why
KEPT = "solutions near the equilibrium keep V, as V' = 0"


class Method(StrEnum):
    """The theorem that decides."""

    EQUILIBRIUM = "no equilibrium"
    SIGNS = "signs on either side"
    STATES = "each state by itself"
    CASCADE = "cascade"
    SLIDING = "sliding surface"
    LYAPUNOV = "Lyapunov function"
    INVARIANCE = "invariance principle"
    LINEARIZATION = "linearization"
    CENTER = "centre manifold"
    FAN = "fan of cones"
    LEADING = "leading terms"
    ESCAPE = "solution that leaves"
    CHOICE = "choice among right-hand sides"
    RELAY = "relative degree of a relay"
    GROWTH = "function that grows"
    INSTABILITY = "function that shows instability"
    CIRCLES = "energy on circles"
    SYMMETRY = "reversing symmetry"
    INTEGRAL = "integral of motion"
    NONE = "nothing"


class ExaminedFunction(ABC):
    """A V in the displacement from the checked point, with its conditions on a domain."""

    formula: PiecewiseExpression

    @property
    @abstractmethod
    def domain(self) -> Domain:
        """Where its conditions are looked at."""

    @property
    def stated_on(self) -> Domain:
        """Where a certificate states them, which may be less: forms on a cube say as much as in the whole space."""
        return self.domain.rational

    @property
    @abstractmethod
    def decrease(self) -> Decrease:
        """What follows from them: of the reversed system for a V that grows."""

    @property
    @abstractmethod
    def reason(self) -> str:
        """The same as a sentence."""

    @property
    @abstractmethod
    def witness(self) -> Any:
        """Where one of them fails: point, value and meaning; None where none is known to."""

    @property
    def suprema(self) -> dict[str, Supremum]:
        """The largest values of its derivatives, by name; empty where they are not asked for."""
        return {}

    @property
    def grows(self) -> bool:
        """Whether V grows along every solution, where the conditions hold."""
        return False

    @property
    def is_kept(self) -> bool:
        """Whether V' = 0 near the point, of a V that is one polynomial there: then no solution comes to the point."""
        return False

    @property
    def text(self) -> str:
        """V as a formula."""
        return one_line(self.formula.text)

    def known_proofs(self, reach: Reach) -> Record:
        """The evidence that is known of its conditions and its reach, by the names of claims; empty where none is."""
        return {}


@dataclass(frozen=True)
class Finding:
    """What a theorem shows of the checked point.

    Attributes:
        theorem: its name.
        verdict: strong stability.
        reason: one sentence for people.
        function: the V that shows it, an :class:`ExaminedFunction` of its strategy; None where none does.
        proofs: what else it rests on, an object of its strategy.
        entry: the theorem with its evidence, as a certificate holds it, where that is known already.
        facts: what it says beyond the verdict.
        refutes: why the point, which is stable, does not attract; empty where that is not known.
        is_final: whether no other theorem is asked: none says more.
    """

    theorem: str
    verdict: Translation
    reason: str
    function: Any = None
    proofs: Any = None
    entry: Record | None = None
    facts: tuple[Fact, ...] = ()
    refutes: str = ""
    is_final: bool = True

    @property
    def is_global(self) -> bool:
        """Whether its evidence is of all starts of the whole space."""
        return self.entry is not None and self.entry["hypotheses"].get("everywhere") is True

    @property
    def is_weak(self) -> bool:
        """Whether it is a V that does not increase, and whether the point attracts is left open."""
        return self.theorem is Method.LYAPUNOV and self.verdict is Translation.STABLE and not self.refutes


def falling_finding(function: ExaminedFunction) -> Finding:
    """What a V shows that falls along every solution."""
    return Finding(Method.LYAPUNOV, Translation.ASYMPTOTICALLY_STABLE, function.reason, function)


def weak_finding(function: ExaminedFunction, refutes: str) -> Finding:
    """What a V shows that does not increase.

    Args:
        function: V.
        refutes: why the point does not attract; empty where that is not known.
    """
    why = f"{NOT_ATTRACTING}{refutes}" if refutes else "whether the equilibrium attracts is not decided by it"
    reason = f"{function.reason}; {why}"
    return Finding(Method.LYAPUNOV, Translation.STABLE, reason, function, refutes=refutes, is_final=False)


@dataclass(frozen=True)
class Findings:
    """The findings so far, in the order in which they were made."""

    findings: tuple[Finding, ...] = ()

    @property
    def standing(self) -> Finding | None:
        """The last one; a V that does not increase only where there is no other."""
        findings = [finding for finding in self.findings if not finding.is_weak] or self.findings
        return findings[-1] if findings else None

    @property
    def function(self) -> Any:
        """The last V that shows something; None without one."""
        return next((finding.function for finding in reversed(self.findings) if finding.function is not None), None)

    @property
    def attraction_is_refuted(self) -> bool:
        """Whether the point is known not to attract."""
        return any(finding.refutes for finding in self.findings)

    def is_silent(self) -> bool:
        """Whether nothing says something."""
        return self.standing is None

    def leaves_attraction_open(self) -> bool:
        """Whether nothing but a V that does not increase says something, or nothing at all."""
        return self.standing is None or self.standing.is_weak


@dataclass(frozen=True, repr=False)
class Reach(ShortRepr):
    """How far and how fast a proved verdict carries; None for what is not proved.

    Attributes:
        everywhere: whether every start of the whole space reaches the point.
        global_entry: the theorem that shows it by a V on the whole space, as a certificate holds it; None where forms
            on cones do.
        near: starts that stay where V is proved to fall, and reach the point.
        region: the most starts that are certified to reach the point: these, or more in the checked square.
        rate: of V where it is proved to fall, hence from the starts of ``near``.
        region_rate: of V on the region, where that is larger than ``near``.
        gain: of a disturbance.
        basin: triangles around the region of which every start reaches the point, where they were asked for.
        reshaped: a larger region of another V, in three states and more, where it was asked for.
        homogeneous: weights with which the field is homogeneous, where that shows that every start reaches the point,
            or arrives.
        in_finite_time: whether solutions near the point are known to arrive in finite time.
        arrival: a bound of that time, for all starts of the space.
        approach: of a point that is stable alone, the theorem that solutions approach the set of equilibria, as a
            certificate holds it.
    """

    everywhere: bool = False
    near: SublevelRegion | None = None
    region: SublevelRegion | None = None
    rate: DecayRate | None = None
    region_rate: RegionRate | None = None
    gain: DisturbanceGain | None = None
    in_finite_time: bool = False
    homogeneous: Homogeneity | None = None
    reshaped: ReshapedRegion | None = field(default=None, hash=False)
    global_entry: Record | None = field(default=None, hash=False)
    basin: CertifiedBasin | None = field(default=None, hash=False)
    arrival: Arrival | None = field(default=None, hash=False)
    approach: Record | None = field(default=None, hash=False)


@dataclass(frozen=True)
class DecidedSystem:
    """The stability of the checked point: every finding, and how far it carries.

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
        standing = Findings(self.findings).standing
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
    def is_in_time_of_states(self) -> bool:
        """Whether V is about roots of states, and falls along the velocities of the states, not of the roots."""
        entry = self.deciding.entry
        return entry is not None and entry["hypotheses"].get("roots") is not None

    @property
    def has_local_region(self) -> bool:
        """Whether a region by a V is known, so that a larger one may be."""
        return self.reach.region is not None and self.function is not None and not self.reach.everywhere

    def by(self, theorem: str) -> Finding | None:
        """What a theorem shows; None where it shows nothing, or was not asked."""
        return next((finding for finding in self.findings if finding.theorem is theorem), None)


class CheckedPoint(ABC):
    """The checked point of a system with what its strategies share; built anew for each decision.

    Attributes:
        system: the stated one, or the one that is looked at in its place.
        known: what strategies have found.
    """

    system: SwitchedSystem
    known = Findings()

    @property
    @abstractmethod
    def equilibrium(self) -> Equilibrium:
        """Whether 0 is in F."""

    @property
    @abstractmethod
    def given(self) -> ExaminedFunction | None:
        """The scene's V on the first domain that is looked at; None where it is not looked at."""

    @property
    @abstractmethod
    def open_reason(self) -> str:
        """What is said where nothing decides."""

    @property
    def is_covered(self) -> bool:
        """Of a system in roots of states, whether what is proved of the roots holds for the states; else true."""
        return True

    def is_covered_within(self, radius: Number | None) -> bool:
        """The same on a whole cube about it, or in the space (None)."""
        return True

    def reach(self, finding: Finding) -> Reach:
        """What is known of starts and times beside the V that decides."""
        return Reach()


@dataclass(frozen=True)
class Strategy:
    """A way to a theorem about systems in some number of states, imported when it is first asked.

    Attributes:
        name: for people.
        states: how many they have.
        module: that holds the function.
        function: its name; from a checked point to a finding.
        asked: whether it is asked beside what is known; always unless given.
    """

    name: str
    states: range
    module: str
    function: str
    asked: Callable[[Findings], bool] | None = None

    def decide(self, point: CheckedPoint) -> Finding | None:
        """What it finds at a point, beside what is known; None where that is nothing, or nothing more."""
        if len(point.system.states) not in self.states or (self.asked is not None and not self.asked(point.known)):
            return None
        decide: Callable[[CheckedPoint], Finding | None] = getattr(import_module(self.module), self.function)
        return decide(point)


# ---- A V of a system in two states with its conditions, and as people and other programs read it -


@dataclass(frozen=True)
class PlaneFunction(ExaminedFunction):
    """A V of a system in two states.

    Attributes:
        result: Lyapunov's conditions with their evidence.
        on: where they are looked at.
        formula: V.
        states: their names.
        grows: whether time was reversed.
        is_given: whether it is the scene's.
    """

    result: LyapunovResult
    on: Domain
    formula: PiecewiseExpression
    states: tuple[str, ...]
    grows: bool = False
    is_given: bool = False

    @property
    def domain(self) -> Domain:
        """The same."""
        return self.on

    @property
    def decrease(self) -> Decrease:
        """What follows from the conditions."""
        return self.result.verdict

    @property
    def reason(self) -> str:
        """The same as a sentence."""
        return self.result.reason

    @property
    def witness(self) -> Refutation | None:
        """Where one of them fails."""
        return self.result.witness

    @property
    def is_kept(self) -> bool:
        """Whether V, one polynomial near the point, has V' = 0 there: on all cells whose closure holds it."""
        zero = self.result.cells[0].potential.field.zero
        near = [cell for cell in self.result.cells if cell.region.contains((zero, zero))]
        return len({cell.potential for cell in near}) == 1 and not any(rate for cell in near for rate in cell.rates)

    @property
    def suprema(self) -> dict[str, Supremum]:
        """The largest values of the derivatives; none where other evidence shows the conditions."""
        return {name: self.result.supremum(name) for name in DERIVATIVES} if self.result.strata else {}
