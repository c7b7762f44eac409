"""Verdicts on plain systems held against the oracle of :mod:`tests.proofs.plain_ties`."""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.proofs.system_decision import StabilityResult
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.proofs.systems.ray_moves import RayKind, RayMove
from nonsmooth.proofs.systems.system_stability import PlanePoint
from tests.proofs.plain_ties import Oracle

STARTS = (1e-2, 1e-5)  # distances; paths that begin nearer stay below the larger bound of the two
FAR, STEPS, FINENESS = 0.2, 3000, 2e-3
LEFT_BEHIND = 50.0  # growth of the distance that no stable equilibrium of the generator shows
NEAR = Fraction(1, 2**12)  # distance at which rays are looked at: beyond it guards of higher degree may switch


def contradictions(result: StabilityResult, oracle: Oracle) -> list[str]:
    """What the oracle says against a verdict; nothing where it agrees or does not know."""
    found = []
    if result.equilibrium is not Equilibrium.UNDECIDED:
        claimed = result.equilibrium is Equilibrium.HOLDS
        found += ["0 in F at the origin"] if claimed is not oracle.rests_at_origin() else []
    found += [f"{ray}" for ray in PlanePoint(result.scene).rays if _is_refuted(ray, oracle)]
    stable = result.verdict in (Translation.STABLE, Translation.ASYMPTOTICALLY_STABLE)
    if stable and oracle.spread(STARTS[1], FAR, STEPS, FINENESS)[0] > LEFT_BEHIND:
        found.append("a path leaves")
    if result.verdict is Translation.ASYMPTOTICALLY_STABLE and oracle.equilibria_nearby():
        found.append(f"equilibria nearby: {oracle.equilibria_nearby()[:2]}")
    if result.method in (Method.GROWTH, Method.EQUILIBRIUM):
        growth = max(oracle.spread(start, FAR, STEPS, FINENESS)[0] for start in STARTS)
        found += ["no path leaves"] if growth < 1.5 else []
    return found


def _is_refuted(ray: RayMove, oracle: Oracle) -> bool:
    """Whether a ray of rest or escape is none at a point near the origin (rational rays only)."""
    point = _rational(ray.ray)
    if point is None or ray.value is None:
        return False
    size = max(abs(point[0]), abs(point[1])) / NEAR
    x, y = point[0] / size, point[1] / size
    return not (oracle.rests_at(x, y) if ray.kind is RayKind.REST else oracle.escapes_at(x, y))


def _rational(point: Point) -> tuple[Fraction, Fraction] | None:
    known = [Fraction(str(q)) for v in point if (q := v.as_rational()) is not None]
    return (known[0], known[1]) if len(known) == len(point) else None
