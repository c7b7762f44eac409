"""Strong stability of a plain planar system's equilibrium: the scene's V first, then what decides without it.

1. ``0`` must be in F at the point: otherwise every solution leaves it.  Only cells count there whose open parts have
   points arbitrarily near (:mod:`nonsmooth.proofs.systems.local_cells`).
2. The scene's V (:mod:`nonsmooth.proofs.systems.derivatives`): on the whole plane for a system of cones and a
   homogeneous V, otherwise on the checked square, or on a smaller one.
3. Fields that are constant near the equilibrium: the fan of cones, which is complete.
4. Systems of cones: a ray of escape is unstable; for linear fields a piecewise quadratic V is searched and proved, one
   that falls along every solution or, with time reversed, one that grows.  Where only the cells near the equilibrium
   are cones, their linear parts propose V, and it is proved for the true fields on a square.
5. A V that does not increase: stable, and not asymptotically where a ray of equilibria shows it.

``stable`` says that every solution stays near; whether it attracts is then refuted or left open, as the reason tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction

from nonsmooth.analysis.cells.region import Region, cone_region
from nonsmooth.analysis.cells.switched_cells import (
    FieldCell,
    LyapunovCell,
    lyapunov_cells,
    plane,
    square_regions,
    system_cells,
)
from nonsmooth.proofs.inequalities.strata import Refutation
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, examine, inhabited
from nonsmooth.proofs.systems.local_cells import conic_germ, decide_equilibrium
from nonsmooth.proofs.systems.piecewise_quadratic import (
    HALVINGS,
    find_near,
    find_piecewise_quadratic,
    linear_cones,
    linear_parts,
    restricted,
)
from nonsmooth.proofs.systems.ray_moves import (
    ConstantFan,
    RayKind,
    RayMove,
    are_cones,
    constant_cones,
    decide_constant_fan,
    ray_moves,
    resting_edges,
)
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.notebook import ShortRepr, html_table
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem

SHRINKING = Fraction(1, 16)  # of the checked square, where V fails on all of it
SEARCH_SCALES = (1, SHRINKING, SHRINKING**2, SHRINKING**3)  # of the checked square, for a V that is searched


@dataclass(frozen=True)
class Domain:
    """Where the conditions on a V are proved: the square ``|x|, |y| <= radius`` about the equilibrium, or the plane.

    Attributes:
        radius: half the side of the square; None for the plane.
    """

    radius: Number | None

    def __str__(self) -> str:
        return "the plane" if self.radius is None else f"abs(x), abs(y) <= {brief_text(self.radius)}"


class Method(StrEnum):
    """What decided."""

    EQUILIBRIUM = "no equilibrium"
    LYAPUNOV = "Lyapunov function"
    FAN = "fan of cones"
    RAY = "ray of escape"
    GROWTH = "function that grows"
    NONE = "nothing"


@dataclass(frozen=True, repr=False)
class SystemResult(ShortRepr):
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
        searched: whether that V was searched (otherwise it is the scene's).
        growth: a V that falls along every solution of the reversed system; None where none was needed or found.
        fan: the decision by the fan, where it was needed and the fields are constant.
        rays: rays of escape and rest of a system of cones, sides of rest of any other.
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
    searched: bool

    def _repr_html_(self) -> str:
        rows = [(self.verdict, self.method, self.reason)]
        return html_table(f"{self.scene.name}: strong stability", ("verdict", "by", "reason"), rows)

    @property
    def exit_status(self) -> int:
        """0 stable, 1 unstable or no equilibrium, 3 undecided."""
        return {Translation.UNSTABLE: 1, Translation.UNDECIDED: 3}.get(self.verdict, 0)

    @property
    def witness(self) -> Refutation | None:
        """Where the scene's V fails."""
        return self.lyapunov.witness

    @property
    def reported_domain(self) -> Domain:
        """Where the scene's V was looked at."""
        return domain_names(self.scene, self.scene.check.lyapunov)[0]

    @property
    def proving(self) -> LyapunovResult | None:
        """The V that decided; None where something else did, or nothing."""
        return {Method.LYAPUNOV: self.certificate, Method.GROWTH: self.growth}.get(self.method)

    def check(self) -> bool:
        """Verify the evidence, that it speaks of this system's cells, and the conclusion; decide the rest again."""
        cells = plane_cells(self.scene)
        known = [inhabited(scene_cells(self.scene, d)) for d in domains(self.scene, self.scene.check.lyapunov)]
        genuine = self.lyapunov.check() and self.lyapunov.cells == known[0]
        if self.certificate is not None:
            genuine = genuine and self._speaks_of(self.certificate, known, backwards=False) and self.certificate.check()
        if self.growth is not None:
            genuine = genuine and self._speaks_of(self.growth, [], backwards=True) and self.growth.check()
        if self.fan is not None:
            genuine = genuine and self.fan.fan.cones == constant_cones(cells) and self.fan.check()
        genuine = genuine and all(ray.check(conic_germ(cells) or ()) for ray in self.rays)
        concluded = conclude(self.equilibrium, self.certificate, self.growth, self.fan, self.rays)
        return genuine and concluded == (self.verdict, self.reason, self.method) and self.recompute(cells)

    def recompute(self, cells: Sequence[FieldCell]) -> bool:
        """Whether deciding again finds the same rays, equilibrium, reach and overshoot."""
        found = _rays(cells), decide_equilibrium(cells), _everywhere(self.verdict, cells)
        fan = self.fan is None or self.fan.fan.recompute()
        return fan and found == (self.rays, self.equilibrium, self.everywhere)

    def _speaks_of(self, found: LyapunovResult, known: Sequence[Sequence[LyapunovCell]], *, backwards: bool) -> bool:
        """Whether a V is one of the system (or of the reversed one) on the domain that is named."""
        if self.domain is None:
            return False
        if not self.searched:
            names = domain_names(self.scene, self.scene.check.lyapunov)
            return self.domain in names and found.cells == known[names.index(self.domain)]
        turned = reversed_cells if backwards else tuple
        cells = turned(plane_cells(self.scene))
        if self.domain.radius is None:
            return _are_the_cones(found.cells, cells)
        return _are_cut_by_cones(
            found.cells, cells, turned(system_cells(self.scene, square_regions(self.domain.radius)))
        )


def system_check(scene: SwitchedSystem) -> SystemResult:
    """Decide the stability of a plain system's equilibrium.

    Raises:
        SceneError: for formulas that cannot be used on some cell.
    """
    cells = plane_cells(scene)
    rays = _rays(cells)
    holds = decide_equilibrium(cells)
    regions = domains(scene, scene.check.lyapunov)
    reported = examine(scene_cells(scene, regions[0]))
    others = regions[1:] if holds is not Equilibrium.FAILS else []
    certificate, domain = _certificate(scene, reported, others)
    fan, growth, searched = None, None, False
    if certificate is None or certificate.verdict is not Decrease.STRICT:
        fan = decide_constant_fan(cells)
        if fan is None and not rays and holds is not Equilibrium.FAILS:
            found, where, grows = _searched(scene, cells, may_grow=certificate is None)
            if found is not None:
                domain, searched = where, True
                certificate, growth = (certificate, found) if grows else (found, growth)
    verdict, reason, method = conclude(holds, certificate, growth, fan, rays)
    everywhere = _everywhere(verdict, cells)
    evidence = holds, everywhere, reported, certificate, growth, fan, rays, domain, searched
    return SystemResult(scene, verdict, reason, method, *evidence)


def _searched(
    scene: SwitchedSystem, cells: Sequence[FieldCell], *, may_grow: bool
) -> tuple[LyapunovResult | None, Domain | None, bool]:
    """A piecewise quadratic V that is proved to fall, or else one that grows; with its domain, and whether it grows."""
    for turned, grows in ((tuple, False), (reversed_cells, True)) if may_grow else ((tuple, False),):
        if are_cones(cells):
            found = find_piecewise_quadratic(turned(cells))
            if found is not None:
                return found, Domain(None), grows
            continue
        near = conic_germ(cells)
        for scale in SEARCH_SCALES if near is not None else ():
            radius = scene.check.radius * scale
            found = find_near(turned(near or ()), turned(system_cells(scene, square_regions(radius))))
            if found is not None:
                return found, Domain(radius), grows
    return None, None, False


def conclude(
    equilibrium: Equilibrium,
    certificate: LyapunovResult | None,
    growth: LyapunovResult | None,
    fan: ConstantFan | None,
    rays: Sequence[RayMove],
) -> tuple[Translation, str, Method]:
    """Verdict, reason and what decided, from the evidence."""
    if equilibrium is Equilibrium.FAILS:
        more = f"; {fan.reason}" if fan is not None and fan.verdict is Translation.UNSTABLE else ""
        return Translation.UNSTABLE, f"0 is not in F there, so every solution leaves it{more}", Method.EQUILIBRIUM
    if certificate is not None and certificate.verdict is Decrease.STRICT:
        return Translation.ASYMPTOTICALLY_STABLE, certificate.reason, Method.LYAPUNOV
    if fan is not None and fan.verdict is not Translation.UNDECIDED:
        return fan.verdict, fan.reason, Method.FAN
    for escape in _of_kind(rays, RayKind.ESCAPE):
        return Translation.UNSTABLE, str(escape), Method.RAY
    if growth is not None and growth.verdict is Decrease.STRICT:
        return Translation.UNSTABLE, "a positive V grows along every solution", Method.GROWTH
    if certificate is not None:
        rests = _of_kind(rays, RayKind.REST)
        why = f"not asymptotically: {rests[0]}" if rests else "whether the equilibrium attracts is not decided by it"
        return Translation.STABLE, f"{certificate.reason}; {why}", Method.LYAPUNOV
    if equilibrium is Equilibrium.UNDECIDED:
        return Translation.UNDECIDED, "whether 0 is in F there hangs on a cell whose germ is not decided", Method.NONE
    return Translation.UNDECIDED, "no Lyapunov function was found, and no solution that leaves", Method.NONE


def domain_names(scene: SwitchedSystem, lyapunov: PiecewiseExpression) -> list[Domain]:
    """Where V is tried, in order; a system of cones with homogeneous V looks the same at every distance."""
    cells = lyapunov_cells(plane_cells(scene), lyapunov, scene.states, scene.origin)
    if are_cones(cells) and all(cell.potential.is_homogeneous for cell in cells):
        return [Domain(None)]
    return [Domain(scene.check.radius * factor) for factor in (1, SHRINKING)]


def domains(scene: SwitchedSystem, lyapunov: PiecewiseExpression) -> list[tuple[Region, ...]]:
    """The regions of :func:`domain_names`."""
    names = domain_names(scene, lyapunov)
    return [plane(scene) if d.radius is None else square_regions(d.radius) for d in names]


def plane_cells(scene: SwitchedSystem) -> tuple[FieldCell, ...]:
    """The cells of the whole plane."""
    return system_cells(scene, plane(scene))


def scene_cells(scene: SwitchedSystem, regions: Sequence[Region]) -> tuple[LyapunovCell, ...]:
    """The cells of some regions, cut further where the scene's V bends."""
    return lyapunov_cells(system_cells(scene, regions), scene.check.lyapunov, scene.states, scene.origin)


def reversed_cells(cells: Sequence[FieldCell]) -> tuple[FieldCell, ...]:
    """The system with time reversed."""
    return tuple(replace(cell, velocities=tuple((-f, -g) for f, g in cell.velocities)) for cell in cells)


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


def _rays(cells: Sequence[FieldCell]) -> tuple[RayMove, ...]:
    """Rays of escape and rest of a system that consists of cones near the origin, sides of rest of any other."""
    near = conic_germ(cells)
    return tuple(ray_moves(near) if near is not None and are_cones(near) else resting_edges(cells))


def _of_kind(rays: Sequence[RayMove], kind: RayKind) -> list[RayMove]:
    return [ray for ray in rays if ray.kind is kind]


def _everywhere(verdict: Translation, cells: Sequence[FieldCell]) -> bool:
    """Whether asymptotic stability extends to the plane: in cones with fields of one degree solutions scale."""
    degrees = {p.degree for cell in cells for v in cell.velocities for p in v if p}
    return verdict is Translation.ASYMPTOTICALLY_STABLE and are_cones(cells) and len(degrees) <= 1


def _are_the_cones(found: Sequence[LyapunovCell], cells: Sequence[FieldCell]) -> bool:
    """Whether cells of a searched V are the cones of the system, with its fields."""
    for halvings in HALVINGS:
        rays, cones = linear_cones(cells, halvings)
        known = [(cone_region(rays[cone.start], rays[cone.end]), (cone.velocity,)) for cone in cones]
        if known == [(cell.region, cell.velocities) for cell in found]:
            return True
    return False


def _are_cut_by_cones(found: Sequence[LyapunovCell], cells: Sequence[FieldCell], domain: Sequence[FieldCell]) -> bool:
    """Whether cells of a searched V are the cells of a domain cut along the cones near the origin."""
    near = conic_germ(cells)
    linear = linear_parts(near) if near is not None else None
    if linear is None:
        return False
    blank = Polynomial.constant(linear[0].velocities[0][0].field, PLANE, 0)
    for halvings in HALVINGS:
        rays, cones = linear_cones(linear, halvings)
        pieces = [LyapunovCell(cone_region(rays[c.start], rays[c.end]), (c.velocity,), blank) for c in cones]
        known = [(cell.region, cell.velocities) for cell in inhabited(restricted(pieces, domain))]
        if known == [(cell.region, cell.velocities) for cell in found]:
            return True
    return False
