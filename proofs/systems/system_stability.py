"""Strong stability of a plain planar system's equilibrium: the scene's V first, then what decides without it.

1. ``0`` must be in F at the point: otherwise every solution leaves it.  Only cells count there whose open parts have
   points arbitrarily near (:mod:`nonsmooth.proofs.systems.local_cells`).
2. The scene's V (:mod:`nonsmooth.proofs.systems.derivatives`): on the whole plane for a system of cones and a
   homogeneous V, otherwise on the checked square, or on a smaller one.
3. Fields that are constant near the equilibrium: the fan of cones, which is complete.
4. Otherwise the leading terms of the fields on tangent cones (:mod:`nonsmooth.proofs.systems.leading_terms`).
5. Unless the equilibrium is known to be unstable, a V is searched and proved, one that falls along every solution or,
   where nothing else has decided, with time reversed one that grows (:mod:`nonsmooth.proofs.systems.search`).
6. In systems of cones a ray of escape is unstable.
7. A V that does not increase, the scene's or a searched one: asymptotically stable where no other solution stays
   where V' = 0 (LaSalle, :mod:`nonsmooth.proofs.systems.invariance`).
8. Otherwise such a V shows stability alone, and not asymptotic where a ray of equilibria shows it.

``stable`` says that every solution stays near; whether it attracts is then refuted or left open, as the reason tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    square_regions,
)
from nonsmooth.proofs.inequalities.effort import shared_effort
from nonsmooth.proofs.inequalities.strata import Refutation
from nonsmooth.proofs.systems.certified_reach import (
    Reach,
    arrives_in_finite_time,
    cells_of_checked_square,
    certified_reach,
    holds_everywhere,
    scene_cells,
)
from nonsmooth.proofs.systems.conclusion import Method, conclude, conclude_uncovered
from nonsmooth.proofs.systems.decay_rate import DecayRate, RegionRate
from nonsmooth.proofs.systems.denominators import require_denominators
from nonsmooth.proofs.systems.derivatives import EFFORT, Decrease, LyapunovResult, examine, inhabited
from nonsmooth.proofs.systems.disturbance_gain import DisturbanceGain
from nonsmooth.proofs.systems.domain import SHRINKING, Domain, domain_names, domains, plane_cells
from nonsmooth.proofs.systems.invariance import Staying, decide_staying
from nonsmooth.proofs.systems.leading_terms import LeadingTerms, decide_leading_terms
from nonsmooth.proofs.systems.local_cells import conic_germ, decide_equilibrium
from nonsmooth.proofs.systems.lyapunov_search import has_curves
from nonsmooth.proofs.systems.ray_moves import (
    ConstantFan,
    RayMove,
    are_cones,
    constant_cones,
    decide_constant_fan,
    ray_moves,
    resting_edges,
)
from nonsmooth.proofs.systems.root_axes import axes_are_crossed
from nonsmooth.proofs.systems.search import SearchedLyapunov, search_lyapunov, search_weak_lyapunov
from nonsmooth.proofs.systems.stability_result import StabilityResult
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.switched_system import SwitchedSystem

SEARCH_EFFORT = 2 * EFFORT  # for all candidates of a search together


@dataclass(frozen=True, repr=False)
class SystemResult(StabilityResult):
    """Stability of the equilibrium with everything that was proved about it.

    Attributes:
        scene: the system.
        verdict: strong stability.
        reason: one sentence for people.
        method: what decided.
        equilibrium: whether 0 is in F.
        everywhere: whether asymptotic stability is proved for starts in the whole plane.
        lyapunov: the scene's V, on the checked square (on the plane for a system of cones).
        certificate: the V that shows stability, on its own domain; None where none does.
        domain: where the V that decides (the certificate, or the one that grows) is proved; None without one.
        searched: that V, where it was searched; None where it is the scene's, or there is none.
        growth: a V that falls along every solution of the reversed system; None where none was needed or found.
        fan: the decision by the fan, where it was needed and the fields are constant.
        rays: rays of escape and rest of a system of cones, sides of rest of any other.
        leading: the decision by leading terms, where the scene's V and the constant fan leave it open and they decide.
        region: starts that are certified to reach the equilibrium, of a V on a square.
        rate: how fast that V falls on the square on which it is proved, where that is proved.
        staying: of a V that does not increase, what stays where V' = 0; None where that was not asked.
        gain: what an additive disturbance does there, where such a V has a rate and that is proved.
        near: the starts that stay in the square on which V is proved; the region may be larger.
        region_rate: how fast V falls on a larger region, where that is proved.
        covered: of a system in roots of states, whether what is proved of the roots holds for the states; else true.
        finite_time: of such a system, whether solutions near the equilibrium are known to arrive in finite time.
    """

    scene: SwitchedSystem
    verdict: Translation
    reason: str
    method: Method
    equilibrium: Equilibrium
    everywhere: bool
    lyapunov: LyapunovResult
    certificate: LyapunovResult | None
    growth: LyapunovResult | None
    fan: ConstantFan | None
    rays: tuple[RayMove, ...]
    domain: Domain | None
    searched: SearchedLyapunov | None
    leading: LeadingTerms | None
    region: SublevelRegion | None = None
    rate: DecayRate | None = None
    staying: Staying | None = None
    gain: DisturbanceGain | None = None
    near: SublevelRegion | None = None
    region_rate: RegionRate | None = None
    covered: bool = True
    finite_time: bool = False

    @property
    def witness(self) -> Refutation | None:
        """Where the scene's V fails."""
        return self.lyapunov.witness

    @property
    def reported_domain(self) -> Domain:
        """Where the scene's V was looked at."""
        return domain_names(self.scene, self.scene.check.lyapunov)[0]

    @property
    def rate_radius(self) -> Number | None:
        """Half the side of the square on which the rate and the gain hold; None without a rate."""
        return None if self.rate is None or self.domain is None else self.domain.radius

    @property
    def proving(self) -> LyapunovResult | None:
        """The V that decided; None where something else did, or nothing."""
        falling = {Method.LYAPUNOV: self.certificate, Method.INVARIANCE: self.certificate}
        return {**falling, Method.GROWTH: self.growth}.get(self.method)

    def check(self) -> bool:
        """Verify the evidence, that it speaks of this system's cells, and the conclusion; decide the rest again."""
        cells = plane_cells(self.scene)
        known = [inhabited(scene_cells(self.scene, d)) for d in domains(self.scene, self.scene.check.lyapunov)]
        genuine = self.lyapunov.check() and self.lyapunov.cells == known[0]
        if self.certificate is not None:
            genuine = genuine and self._speaks_of(self.certificate, known, grows=False) and self.certificate.check()
        if self.growth is not None:
            genuine = genuine and self._speaks_of(self.growth, [], grows=True) and self.growth.check()
        if self.fan is not None:
            genuine = genuine and self.fan.fan.cones == constant_cones(cells) and self.fan.check()
        genuine = genuine and all(ray.check(conic_germ(cells) or ()) for ray in self.rays)
        genuine = genuine and self._region_is_genuine()
        evidence = self.equilibrium, self.certificate, self.growth, self.fan, self.rays, self.leading
        concluded = conclude(*evidence, self.staying) if self.covered else conclude_uncovered(self.equilibrium)
        genuine = genuine and self.covered is axes_are_crossed(self.scene)
        genuine = genuine and self.finite_time is arrives_in_finite_time(
            self.scene, cells, self.verdict, self.certificate
        )
        by = self.certificate, self.domain, self.searched
        genuine = genuine and (self.staying is None or self.staying is _staying(self.scene, *by))
        return genuine and concluded == (self.verdict, self.reason, self.method) and self.recompute(cells)

    def _region_is_genuine(self) -> bool:
        """Whether the regions, the rates and the gain are those of the V that proves asymptotic stability."""
        if (self.region, self.rate, self.near, self.region_rate, self.gain) == (None,) * 5:
            return True
        proving = self.proving
        if proving is None or self.domain is None or self.verdict is not Translation.ASYMPTOTICALLY_STABLE:
            return False
        near, cells = self.near, proving.cells
        if near is not None and not (near.falls and near.radius == self.domain.radius and near.check(cells)):
            return False
        if self.rate is not None and not self.rate.check(cells):
            return False
        if self.gain is not None and not self._gain_is_genuine(self.gain, cells, self.domain):
            return False
        return self._far_region_is_genuine()

    def _far_region_is_genuine(self) -> bool:
        """Whether a region that reaches beyond the square on which V is proved holds, and its rate."""
        region, rate = self.region, self.region_rate
        if region is None or region == self.near:
            return rate is None and region == self.near
        cells = cells_of_checked_square(self.scene, self.searched)
        own = bool(cells) and not region.falls and region.radius == self.scene.check.radius
        return own and region.check(cells) and (rate is None or rate.check(cells, region))

    def _gain_is_genuine(self, gain: DisturbanceGain, cells: Sequence[LyapunovCell], domain: Domain) -> bool:
        """Whether the gain is one of the V, its rate and its region."""
        level = None if self.near is None else self.near.level
        same = gain.rate == self.rate and gain.level == level
        return same and domain.radius is not None and gain.check(cells, domain.radius)

    def recompute(self, cells: Sequence[FieldCell]) -> bool:
        """Whether deciding again finds the same rays, equilibrium, reach, overshoot and leading terms."""
        everywhere = holds_everywhere(self.scene, self.verdict, cells)
        found = _rays(self.scene, cells), _equilibrium(self.scene, cells), everywhere
        fan = self.fan is None or self.fan.fan.recompute()
        leading = self.leading is None or self.leading == decide_leading_terms(self.scene)
        return fan and leading and found == (self.rays, self.equilibrium, self.everywhere)

    def _speaks_of(self, found: LyapunovResult, known: Sequence[Sequence[LyapunovCell]], *, grows: bool) -> bool:
        """Whether a V is one of the system (or of the reversed one) on the domain that is named."""
        if self.domain is None:
            return False
        if self.searched is None:
            names = domain_names(self.scene, self.scene.check.lyapunov)
            return self.domain in names and found.cells == known[names.index(self.domain)]
        own = self.searched.result is found and self.searched.domain == self.domain and self.searched.grows is grows
        return own and self.searched.speaks_of(self.scene)


def system_check(scene: SwitchedSystem) -> SystemResult:
    """Decide the stability of a plain system's equilibrium.

    Raises:
        SceneError: for formulas that cannot be used on some cell, and for denominators that may vanish.
    """
    require_denominators(scene)
    cells = plane_cells(scene)
    rays = _rays(scene, cells)
    holds, covered = _equilibrium(scene, cells), axes_are_crossed(scene)
    regions = domains(scene, scene.check.lyapunov)
    reported = examine(scene_cells(scene, regions[0]))
    if not covered:
        return _uncovered(scene, holds, reported, rays)
    others = regions[1:] if holds is not Equilibrium.FAILS else []
    certificate, domain = _certificate(scene, reported, others)
    fan, growth, searched, leading, staying = None, None, None, None, None
    if has_curves(scene) and not (scene.check.is_default or rays):
        staying = _staying(
            scene, certificate, domain, None
        )  # of the V that the scene names: beside curves a search takes long
    if staying is not Staying.NONE and (certificate is None or certificate.verdict is not Decrease.STRICT):
        fan = decide_constant_fan(cells)
        if holds is Equilibrium.HOLDS and fan is None:
            leading = decide_leading_terms(scene)
        if holds is not Equilibrium.FAILS:
            searched = _searched(scene, cells, rays, fan, leading, may_grow=certificate is None)
        if searched is not None:
            domain = searched.domain
            certificate, growth = (certificate, searched.result) if searched.grows else (searched.result, growth)
    if staying is not Staying.NONE:
        concluded = conclude(holds, certificate, growth, fan, rays, leading)
        known = certificate, domain, searched
        certificate, domain, searched, staying = _by_invariance(scene, rays, concluded, known)
    verdict, reason, method = conclude(holds, certificate, growth, fan, rays, leading, staying)
    everywhere = holds_everywhere(scene, verdict, cells)
    reach = Reach()
    if method in (Method.LYAPUNOV, Method.INVARIANCE) and verdict is Translation.ASYMPTOTICALLY_STABLE:
        reach = certified_reach(scene, certificate, domain, searched)
    evidence = (
        holds,
        everywhere,
        reported,
        certificate,
        growth,
        fan,
        rays,
        domain,
        searched,
        leading,
        reach.region,
        reach.rate,
        staying,
        reach.gain,
        reach.near,
        reach.region_rate,
    )
    arrives = arrives_in_finite_time(scene, cells, verdict, certificate)
    return SystemResult(scene, verdict, reason, method, *evidence, finite_time=arrives)


def _uncovered(
    scene: SwitchedSystem, holds: Equilibrium, reported: LyapunovResult, rays: tuple[RayMove, ...]
) -> SystemResult:
    """The result for a system in roots of states where what is proved of these says nothing about the states."""
    concluded = conclude_uncovered(holds)
    return SystemResult(
        scene, *concluded, holds, False, reported, None, None, None, rays, None, None, None, covered=False
    )


@shared_effort(SEARCH_EFFORT)
def _searched(
    scene: SwitchedSystem,
    cells: Sequence[FieldCell],
    rays: Sequence[RayMove],
    fan: ConstantFan | None,
    leading: LeadingTerms | None,
    *,
    may_grow: bool,
) -> SearchedLyapunov | None:
    """A V that falls, unless that is known to be impossible; else one that grows, unless that is, or is not needed."""
    decided = next((known.verdict for known in (fan, leading) if known is not None), Translation.UNDECIDED)
    if rays or (fan is not None and decided is not Translation.ASYMPTOTICALLY_STABLE):
        return None
    if decided is Translation.UNSTABLE:
        spirals = leading is not None and leading.growth is not None and are_cones(cells) and not scene.others
        return search_lyapunov(scene, cells, grows=True) if spirals and may_grow else None
    found = search_lyapunov(scene, cells)
    if found is None and may_grow and decided is Translation.UNDECIDED:
        found = search_lyapunov(scene, cells, grows=True)
    return found


Known: TypeAlias = tuple[LyapunovResult | None, Domain | None, SearchedLyapunov | None]


@shared_effort(EFFORT)
def _by_invariance(
    scene: SwitchedSystem, rays: Sequence[RayMove], concluded: tuple[Translation, str, Method], known: Known
) -> tuple[LyapunovResult | None, Domain | None, SearchedLyapunov | None, Staying | None]:
    """What LaSalle's principle adds where nothing else decides whether solutions attract.

    The scene's V is asked on the checked square and on the smaller one; then a V that does not increase is searched.
    """
    verdict, _, method = concluded
    weak = method is Method.LYAPUNOV and verdict is Translation.STABLE
    if not (weak or method is Method.NONE) or (weak and rays):
        return *known, None
    staying = _staying(scene, *known)
    if staying is Staying.NONE:
        return *known, staying
    if weak and known[1] is not None and known[1].radius == scene.check.radius:
        smaller = Domain(scene.check.radius * SHRINKING)
        result = examine(scene_cells(scene, square_regions(smaller.radius or scene.check.radius)))
        if _staying(scene, result, smaller, None) is Staying.NONE:
            return result, smaller, None, Staying.NONE
    found = search_weak_lyapunov(scene, may_attract=not rays)
    if found is None:
        return *known, staying
    own = None if rays else _staying(scene, found.result, found.domain, found)
    return (*known, staying) if weak and own is not Staying.NONE else (found.result, found.domain, found, own)


def _staying(
    scene: SwitchedSystem,
    certificate: LyapunovResult | None,
    domain: Domain | None,
    searched: SearchedLyapunov | None,
) -> Staying | None:
    """What stays where V' = 0, of a V that does not increase; None for any other."""
    if certificate is None or certificate.verdict is not Decrease.WEAK or domain is None:
        return None
    formula = scene.check.lyapunov if searched is None else searched.formula
    return decide_staying(scene, formula, domain.radius or scene.check.radius, certificate.cells)


def _certificate(
    scene: SwitchedSystem, reported: LyapunovResult, others: Sequence[Sequence[Region]]
) -> tuple[LyapunovResult | None, Domain | None]:
    """The best of the scene's V on the given domains: a strict one at once, the first weak one otherwise."""
    weak: tuple[LyapunovResult | None, Domain | None] = None, None
    names = domain_names(scene, scene.check.lyapunov)
    for result, name in zip(_examined(scene, reported, others), names, strict=False):
        if result.verdict is Decrease.STRICT:
            return result, name
        if result.verdict is Decrease.WEAK and weak[0] is None:
            weak = result, name
    return weak


def _examined(
    scene: SwitchedSystem, reported: LyapunovResult, others: Sequence[Sequence[Region]]
) -> Iterator[LyapunovResult]:
    yield reported
    for regions in others:
        yield examine(scene_cells(scene, regions))


def _rays(scene: SwitchedSystem, cells: Sequence[FieldCell]) -> tuple[RayMove, ...]:
    """Rays of escape and rest of a system that consists of cones near the origin, sides of rest of any other.

    Of right-hand sides that only enclose the field all must rest: what one of them allows, the field need not.
    """
    if scene.waves:
        return tuple(resting_edges(cells, enclosing=True)) if scene.has_one_field else ()
    near = conic_germ(cells)
    return tuple(ray_moves(near) if near is not None and are_cones(near) else resting_edges(cells))


def _equilibrium(scene: SwitchedSystem, cells: Sequence[FieldCell]) -> Equilibrium:
    """Whether 0 is in F at the point: of the stated fields, where roots of states scale them."""
    return decide_equilibrium(cells if scene.by_roots is None else plane_cells(scene.by_roots.unscaled))
