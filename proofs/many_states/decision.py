"""Strong stability of the checked point of a plain system in three states and more.

1. ``0`` must be in F at the point; otherwise every solution leaves it.
2. A velocity that leads from the point into a cell (:mod:`nonsmooth.proofs.many_states.escape`), a relay of relative
   degree three or more (:mod:`nonsmooth.proofs.many_states.relay_degree`), and the linearization, where there is one
   (:mod:`nonsmooth.proofs.many_states.linear_part`).
3. The V that the scene names, on the checked cube (:mod:`nonsmooth.proofs.many_states.examination`).
4. A V that is searched (:mod:`nonsmooth.proofs.many_states.lyapunov_search`); for a linearization whose eigenvalues all
   have negative real parts its own quadratic form on smaller cubes, if nothing else is proved.
5. A V that shows instability (:mod:`nonsmooth.proofs.many_states.instability`).
6. A V that does not increase: the point attracts where nothing else stays where V does not fall
   (:mod:`nonsmooth.proofs.many_states.invariance`); otherwise ``stable``, and whether it attracts is left open.

Rays, fans and leading terms are used for two states only.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass, replace

from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.proofs.kernel.sign_cells import BeyondReachError, SignCells, adjoining, build_cells
from nonsmooth.proofs.many_states.conclusion import ManyStateMethod, StabilityEvidence, conclude
from nonsmooth.proofs.many_states.decay import ProvedDecay, decay_rate
from nonsmooth.proofs.many_states.denominators import require_denominators
from nonsmooth.proofs.many_states.escape import escaping_rate, escaping_velocity
from nonsmooth.proofs.many_states.examination import examine
from nonsmooth.proofs.many_states.examined_lyapunov import ExaminedLyapunov, is_shown
from nonsmooth.proofs.many_states.instability import find_growth
from nonsmooth.proofs.many_states.linear_part import Spectrum, linear_part, quadratic_text, unstable_mixture
from nonsmooth.proofs.many_states.lyapunov_search import SCALES, find_lyapunov
from nonsmooth.proofs.many_states.relay_degree import RelayDegree, high_degree_relay
from nonsmooth.proofs.many_states.sublevel import SublevelSet, largest_sublevel
from nonsmooth.proofs.sums_of_squares.prove import Effort
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.proofs.systems.stability_result import StabilityResult
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.piecewise import parse_piecewise
from nonsmooth.symbolic.switched_system import SwitchedSystem


@dataclass(frozen=True, repr=False)
class ManyStateResult(StabilityResult):
    """Stability of the checked point with everything that was proved about it.

    Attributes:
        scene: the system.
        verdict: strong stability.
        reason: one sentence for people.
        method: what decided.
        evidence: what it follows from.
        region: starts that are certified to reach the point, of a V that falls on a cube; None where none is known.
        rate: how fast that V falls, where that is proved.
    """

    scene: SwitchedSystem
    verdict: Translation
    reason: str
    method: ManyStateMethod
    evidence: StabilityEvidence
    region: SublevelSet | None = None
    rate: ProvedDecay | None = None

    @property
    def proving(self) -> ExaminedLyapunov | None:
        """The V that shows stability, where the verdict is that or stronger."""
        stable = (Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE)
        return self.evidence.proving if self.verdict in stable else None

    @property
    def rate_radius(self) -> Number | None:
        """Half the side of the cube on which the rate holds; None without a rate, and where it holds everywhere."""
        if self.rate is None or self.proving is None or self.rate.scales(self.proving.examination):
            return None
        return self.proving.radius

    @property
    def everywhere(self) -> bool:
        """Whether asymptotic stability is proved for starts in the whole space."""
        strong = self.verdict is Translation.ASYMPTOTICALLY_STABLE
        linear = self.evidence.linear is not None and self.evidence.linear.is_whole
        return strong and (linear or (self.proving is not None and self.proving.examination.is_homogeneous))

    def check(self) -> bool:
        """Verify the evidence and the conclusion; decide equilibrium, linearization and what is beyond reach again."""
        evidence = self.evidence
        found = _begin(self.scene)
        known = evidence.equilibrium, evidence.linear, evidence.escape, evidence.ray_rate, evidence.relay
        if (found.equilibrium, found.linear, found.escape, found.ray_rate, found.relay) != known:
            return False
        if evidence.relay is not None and not _relay_holds(self.scene, evidence.relay):
            return False
        if found.beyond and found != evidence:
            return False
        if not all(own is None or own.check(self.scene) for own in (evidence.named, evidence.searched)):
            return False
        own = evidence.named is None or evidence.named.formula.text == self.scene.check.lyapunov.text
        own = own and (evidence.searched is None or evidence.searched.examination.verdict is Decrease.STRICT)
        own = own and self._attraction_is_shown()
        own = own and (evidence.growth is None or is_shown(self.scene, evidence.growth.entry, Translation.UNSTABLE))
        return own and conclude(evidence) == (self.verdict, self.reason, self.method) and self._reach_is_genuine()

    def _attraction_is_shown(self) -> bool:
        """Whether the checker accepts LaSalle's principle, where it was used, of the V that shows stability."""
        entry, proving = self.evidence.attraction, self.evidence.proving
        if entry is None:
            return True
        of_this = proving is not None and entry["hypotheses"]["function"] == proving.formula.text
        return of_this and is_shown(self.scene, entry, Translation.ASYMPTOTICALLY_STABLE)

    def _reach_is_genuine(self) -> bool:
        """Whether the checker accepts the region and the rate, of the V that proves asymptotic stability."""
        if self.region is None and self.rate is None:
            return True
        proving = self.proving
        if proving is None or proving.examination.verdict is not Decrease.STRICT or (self.rate and self.scene.scale):
            return False
        attracts = self.verdict is Translation.ASYMPTOTICALLY_STABLE
        return attracts and is_shown(self.scene, proving.entry(region=self.region, rate=self.rate), self.verdict)


def decide_many(scene: SwitchedSystem) -> ManyStateResult:
    """Decide the stability of the checked point of a system in three states and more.

    Irrational numbers are enclosed between rational ones: the result speaks of that system, and so of the stated one.

    Raises:
        SceneError: for formulas that cannot be used, and for denominators that may vanish.
    """
    require_denominators(scene)
    with suppress(NoEnclosureError):
        scene = enclose_numbers(scene)
    evidence = _begin(scene)
    if not evidence.beyond and conclude(evidence)[0] is not Translation.UNSTABLE:
        evidence = _with_functions(scene, evidence)
    verdict, reason, method = conclude(evidence)
    region, rate, proving = None, None, evidence.proving
    if proving is not None and proving.examination.verdict is Decrease.STRICT:
        region = largest_sublevel(proving.examination)
        rate = None if scene.scale else decay_rate(proving.examination)  # a scaled field has another rate
    return ManyStateResult(scene, verdict, reason, method, evidence, region, rate)


def _with_functions(scene: SwitchedSystem, evidence: StabilityEvidence) -> StabilityEvidence:
    """The V of the scene; then what is searched, as far as that leaves it open.

    A sum of squares that nobody named is asked at first with little work, and again where nothing else is found.
    """
    default = scene.check.is_default
    evidence = _with_named(scene, evidence, hasty=default)
    named, spectrum = evidence.proving, None if evidence.linear is None else evidence.linear.spectrum
    if spectrum is Spectrum.NEUTRAL or (named is not None and named.examination.verdict is Decrease.STRICT):
        return _with_named(scene, evidence, hasty=False) if default and named is None else evidence
    evidence = _with_searched(scene, evidence)
    if spectrum is Spectrum.HURWITZ or evidence.searched is not None:
        return evidence
    if default:
        evidence = _with_named(scene, evidence, hasty=False)
    return _with_invariance(scene, _with_growth(scene, evidence))


def _with_invariance(scene: SwitchedSystem, evidence: StabilityEvidence) -> StabilityEvidence:
    """Whether solutions leave where the V that shows stability does not fall."""
    proving = evidence.proving
    return evidence if proving is None else replace(evidence, attraction=proving.attraction(scene))


def _begin(scene: SwitchedSystem) -> StabilityEvidence:
    """The equilibrium and the linearization: what is so near the point, on the first cube that is looked at."""
    try:
        cells = first_cells(scene)
        linear = linear_part(cells) or unstable_mixture(scene, cells)
        escape = escaping_velocity(scene, cells)
        rate = None if linear is not None else escaping_rate(scene, cells)
        return StabilityEvidence(
            decide_equilibrium(scene, cells), linear, escape, rate, high_degree_relay(scene, cells)
        )
    except BeyondReachError as error:
        return StabilityEvidence(Equilibrium.UNDECIDED, beyond=str(error))


def first_cells(scene: SwitchedSystem) -> SignCells:
    """The cells of the checked cube, or of the first smaller one that is looked at.

    Raises:
        BeyondReachError: where none is, with what is said of the checked cube.
    """
    reasons = []
    for scale in SCALES:
        try:
            return build_cells(scene, scene.check.radius * scale)
        except BeyondReachError as error:
            reasons.append(error)
    raise reasons[0]


def _relay_holds(scene: SwitchedSystem, relay: RelayDegree) -> bool:
    """Whether the function of a relay rises on the cells of the first cube that is looked at."""
    try:
        return relay.check(first_cells(scene))
    except BeyondReachError:
        return False


def decide_equilibrium(scene: SwitchedSystem, cells: SignCells) -> Equilibrium:
    """Whether 0 is a mixture of the velocities at the point.

    Beside curved surfaces a pattern of signs may have no cell: then a mixture may be none of F, and nothing is claimed.
    Nor is it where numbers are enclosed, unless all velocities vanish.
    """
    zero = (0,) * len(cells.states)
    near = adjoining(cells)
    velocities = {tuple(scene.field(p.get(zero, 0)) for p in field) for cell in near for field in cell.velocities}
    columns, target = mixtures_to_zero(sorted(velocities, key=str))
    if best_mixture(columns, target, [scene.field.zero] * len(columns)) is None:
        return Equilibrium.FAILS
    at_rest = not any(map(any, velocities))
    certain = at_rest or (all(surface.degree == 1 for surface in cells.surfaces) and not scene.encloses_numbers)
    return Equilibrium.HOLDS if certain else Equilibrium.UNDECIDED


def _with_named(scene: SwitchedSystem, evidence: StabilityEvidence, *, hasty: bool) -> StabilityEvidence:
    """The V of the scene."""
    formula, radius = scene.check.lyapunov, scene.check.radius
    try:
        examined = examine(scene, formula, radius, effort=Effort.HASTY if hasty else Effort.FULL)
    except BeyondReachError:
        return evidence
    return replace(evidence, named=ExaminedLyapunov(formula, radius, examined))


def _with_searched(scene: SwitchedSystem, evidence: StabilityEvidence) -> StabilityEvidence:
    """A V that falls."""
    found = find_lyapunov(scene)
    if found is not None:
        return replace(evidence, searched=found)
    linear = evidence.linear
    if linear is None or linear.quadratic is None:
        return evidence
    formula = parse_piecewise(quadratic_text(linear.quadratic, scene.states), scene.states)
    for scale in SCALES:
        radius = scene.check.radius * scale
        try:
            examined = examine(scene, formula, radius, effort=Effort.STRICT)
        except BeyondReachError:
            continue
        if examined.verdict is Decrease.STRICT:
            return replace(evidence, searched=ExaminedLyapunov(formula, radius, examined))
    return evidence


def _with_growth(scene: SwitchedSystem, evidence: StabilityEvidence) -> StabilityEvidence:
    """A V that shows instability, unless the point is known to be stable."""
    return replace(evidence, growth=None if evidence.proving is not None else find_growth(scene))
