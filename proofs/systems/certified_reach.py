"""How far and how fast a planar system's asymptotic stability reaches: region, rate, gain, arrival in finite time."""

from __future__ import annotations

from collections.abc import Sequence

from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, square_regions
from nonsmooth.proofs.inequalities.effort import effort_of_its_own, shared_effort
from nonsmooth.proofs.systems.decay_rate import decay_rate, region_rate
from nonsmooth.proofs.systems.derivatives import EFFORT, Decrease, inhabited
from nonsmooth.proofs.systems.disturbance_gain import disturbance_gain
from nonsmooth.proofs.systems.domain import scene_cells
from nonsmooth.proofs.systems.findings import Reach
from nonsmooth.proofs.systems.lyapunov_search import searched_cells
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.proofs.systems.root_axes import arrives_in_time, axes_are_crossed_within
from nonsmooth.proofs.systems.search import PlaneFunction
from nonsmooth.proofs.systems.sublevel_region import SublevelRegion, largest_sublevel
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.switched_system import SwitchedSystem

MOST_DEGREE = 6  # of V' whose sign is asked for on sublevel sets of a searched V: beyond that it takes too long


def cells_of_square(scene: SwitchedSystem) -> tuple[LyapunovCell, ...]:
    """The cells of the checked square with the scene's V."""
    return scene_cells(scene, square_regions(scene.check.radius))


@shared_effort(EFFORT)
def certified_reach(scene: SwitchedSystem, function: PlaneFunction) -> Reach:
    """The reach of a V that is proved on a square; on the plane the region is the plane."""
    domain, cells = function.domain, function.result.cells
    if domain.radius is None or not axes_are_crossed_within(scene, scene.check.radius):
        return Reach()
    near = largest_sublevel(cells, domain.radius)
    far = _beyond(scene, function)
    region = near if far is None or (near is not None and near.level >= far.level) else far
    # a scaled field has another rate
    rate = None if scene.scale is not None or scene.by_roots is not None else decay_rate(cells)
    if rate is None:
        return Reach(near=near, region=region)
    gain = disturbance_gain(cells, domain.radius, rate, near)
    on_region = None
    if region is not None and region is not near:
        on_region = region_rate(cells_of_checked_square(scene, function), region)
    return Reach(near=near, region=region, rate=rate, rate_domain=domain, region_rate=on_region, gain=gain)


def cells_of_checked_square(scene: SwitchedSystem, function: PlaneFunction) -> tuple[LyapunovCell, ...]:
    """The cells of the checked square with V; none for one of pieces."""
    if function.is_given:
        return inhabited(cells_of_square(scene))
    return () if function.formula is None else searched_cells(scene, function.formula, scene.check.radius)


def _beyond(scene: SwitchedSystem, function: PlaneFunction) -> SublevelRegion | None:
    """The largest level in the checked square of a V that is proved to fall on a smaller one.

    None where V bends, and for a V that was searched where its derivative has a high degree, as that of enclosed sines.
    """
    if function.domain.radius == scene.check.radius or (not function.is_given and scene.waves):
        return None
    cells = cells_of_checked_square(scene, function)
    if function.is_given:
        return largest_sublevel(cells, scene.check.radius, falls=False)
    short = all(rate.degree <= MOST_DEGREE for cell in cells for rate in cell.rates)
    return largest_sublevel(cells, scene.check.radius, falls=False) if cells and short else None


@effort_of_its_own(EFFORT)
def arrives_in_finite_time(
    scene: SwitchedSystem, cells: Sequence[FieldCell], verdict: Translation, function: PlaneFunction | None
) -> bool:
    """Whether solutions of a system in roots of states are known to arrive in finite time."""
    if scene.by_roots is None or verdict is not Translation.ASYMPTOTICALLY_STABLE:
        return False
    if arrives_in_time(scene, cells, falls_exponentially=False):
        return True
    if function is None or function.decrease is not Decrease.STRICT or are_cones(function.result.cells):
        return False
    return decay_rate(function.result.cells) is not None and arrives_in_time(scene, cells, falls_exponentially=True)


def holds_everywhere(scene: SwitchedSystem, verdict: Translation, cells: Sequence[FieldCell]) -> bool:
    """Whether asymptotic stability extends to the plane: in cones with fields of one degree solutions scale."""
    if not axes_are_crossed_within(scene, None):
        return False
    degrees = {p.degree for cell in cells for v in cell.velocities for p in v if p}
    return verdict is Translation.ASYMPTOTICALLY_STABLE and are_cones(cells) and len(degrees) <= 1
