"""How far and how fast a planar system's asymptotic stability reaches: region, rate, gain, arrival in finite time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nonsmooth.analysis.cells.region import Region
from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    lyapunov_cells,
    square_regions,
    system_cells,
)
from nonsmooth.proofs.inequalities.effort import effort_of_its_own, shared_effort
from nonsmooth.proofs.systems.decay_rate import DecayRate, RegionRate, decay_rate, region_rate
from nonsmooth.proofs.systems.derivatives import EFFORT, Decrease, LyapunovResult, inhabited
from nonsmooth.proofs.systems.disturbance_gain import DisturbanceGain, disturbance_gain
from nonsmooth.proofs.systems.domain import Domain
from nonsmooth.proofs.systems.lyapunov_search import searched_cells
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.proofs.systems.root_axes import arrives_in_time, axes_are_crossed_within
from nonsmooth.proofs.systems.search import SearchedLyapunov
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion, largest_sublevel
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.switched_system import SwitchedSystem

MOST_DEGREE = 6  # of V' whose sign is asked for on sublevel sets of a searched V: beyond that it takes too long


def scene_cells(scene: SwitchedSystem, regions: Sequence[Region]) -> tuple[LyapunovCell, ...]:
    """The cells of some regions, cut further where the scene's V bends."""
    return lyapunov_cells(system_cells(scene, regions), scene.check.lyapunov, scene.states, scene.origin)


def cells_of_square(scene: SwitchedSystem) -> tuple[LyapunovCell, ...]:
    """The cells of the checked square with the scene's V."""
    return scene_cells(scene, square_regions(scene.check.radius))


@dataclass(frozen=True)
class Reach:
    """How far and how fast a proved V carries; None for what is not proved.

    Attributes:
        near: starts that stay in the square on which V is proved and reach the point.
        region: the most starts that are certified to reach the point: these, or more in the checked square.
        rate: of V on the square on which it is proved, hence from the starts of ``near``.
        region_rate: of V on the region, where that is larger than ``near``.
        gain: of a disturbance, on the square on which V is proved.
    """

    near: SublevelRegion | None = None
    region: SublevelRegion | None = None
    rate: DecayRate | None = None
    region_rate: RegionRate | None = None
    gain: DisturbanceGain | None = None


@shared_effort(EFFORT)
def certified_reach(
    scene: SwitchedSystem,
    certificate: LyapunovResult | None,
    domain: Domain | None,
    searched: SearchedLyapunov | None,
) -> Reach:
    """The reach of a V that is proved on a square; on the plane the region is the plane."""
    if certificate is None or domain is None or domain.radius is None:
        return Reach()
    if not axes_are_crossed_within(scene, scene.check.radius):
        return Reach()
    near = largest_sublevel(certificate.cells, domain.radius)
    far = _beyond(scene, domain, searched)
    region = near if far is None or (near is not None and near.level >= far.level) else far
    if scene.scale is not None or scene.by_roots is not None:  # a scaled field has another rate
        return Reach(near, region)
    rate = decay_rate(certificate.cells)
    if rate is None:
        return Reach(near, region)
    gain = disturbance_gain(certificate.cells, domain.radius, rate, near)
    if region is None or region is near:
        return Reach(near, region, rate, None, gain)
    return Reach(near, region, rate, region_rate(cells_of_checked_square(scene, searched), region), gain)


def cells_of_checked_square(scene: SwitchedSystem, searched: SearchedLyapunov | None) -> tuple[LyapunovCell, ...]:
    """The cells of the checked square with the V that was searched, or with the scene's; none for one of pieces."""
    if searched is None:
        return inhabited(cells_of_square(scene))
    return () if searched.formula is None else searched_cells(scene, searched.formula, scene.check.radius)


def _beyond(scene: SwitchedSystem, domain: Domain, searched: SearchedLyapunov | None) -> SublevelRegion | None:
    """The largest level in the checked square of a V that is proved to fall on a smaller one.

    None where V bends, and for a V that was searched where its derivative has a high degree, as that of enclosed sines.
    """
    if domain.radius == scene.check.radius or (searched is not None and scene.waves):
        return None
    cells = cells_of_checked_square(scene, searched)
    if searched is None:
        return largest_sublevel(cells, scene.check.radius, falls=False)
    short = all(rate.degree <= MOST_DEGREE for cell in cells for rate in cell.rates)
    return largest_sublevel(cells, scene.check.radius, falls=False) if cells and short else None


@effort_of_its_own(EFFORT)
def arrives_in_finite_time(
    scene: SwitchedSystem, cells: Sequence[FieldCell], verdict: Translation, certificate: LyapunovResult | None
) -> bool:
    """Whether solutions of a system in roots of states are known to arrive in finite time."""
    if scene.by_roots is None or verdict is not Translation.ASYMPTOTICALLY_STABLE:
        return False
    if arrives_in_time(scene, cells, falls_exponentially=False):
        return True
    strict = certificate is not None and certificate.verdict is Decrease.STRICT
    bounded = strict and certificate is not None and not are_cones(certificate.cells)
    fast = bounded and certificate is not None and decay_rate(certificate.cells) is not None
    return fast and arrives_in_time(scene, cells, falls_exponentially=True)


def holds_everywhere(scene: SwitchedSystem, verdict: Translation, cells: Sequence[FieldCell]) -> bool:
    """Whether asymptotic stability extends to the plane: in cones with fields of one degree solutions scale."""
    if not axes_are_crossed_within(scene, None):
        return False
    degrees = {p.degree for cell in cells for v in cell.velocities for p in v if p}
    return verdict is Translation.ASYMPTOTICALLY_STABLE and are_cones(cells) and len(degrees) <= 1
