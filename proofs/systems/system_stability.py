"""Strong stability of a planar system's equilibrium: the scene's V first, then what decides without it.

1. ``0`` must be in F at the point: otherwise every solution leaves it.  Only cells count there whose open parts have
   points arbitrarily near (:mod:`nonsmooth.proofs.systems.ray_moves`).
2. The scene's V (:mod:`nonsmooth.proofs.systems.derivatives`): on the whole plane for a system of cones and a
   homogeneous V, otherwise on the checked square, or on a smaller one.
3. Fields that are constant near the equilibrium: the fan of cones, which is complete.
4. Otherwise the leading terms of the fields on tangent cones (:mod:`nonsmooth.proofs.systems.leading_terms`).
5. Otherwise a solution that leaves (:mod:`nonsmooth.proofs.kernel.escapes`).
6. Unless the equilibrium is known to be unstable, a V is searched and proved, one that falls along every solution or,
   where nothing else has decided, with time reversed one that grows (:mod:`.lyapunov_search`).
7. A V that does not increase, the scene's or a searched one: asymptotically stable where no other solution stays
   where V' = 0 (LaSalle, :mod:`nonsmooth.proofs.systems.derivatives`).
8. Otherwise such a V shows stability alone, and not asymptotic where a ray of equilibria shows it, or near the point
   V' = 0: solutions then keep V, which is positive off the point.

``stable`` says that every solution stays near; whether it attracts is then refuted or left open, as the reason tells.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cached_property
from typing import TYPE_CHECKING

from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.proofs.findings import Equilibrium, Record, Translation
from nonsmooth.proofs.inequalities.real_roots import dense, germ_sign, positive_roots
from nonsmooth.proofs.inequalities.subdivision import effort_of_its_own, shared_effort
from nonsmooth.proofs.kernel.cells import require_denominators
from nonsmooth.proofs.systems.derivatives import EFFORT, Decrease, InvariantMotion, attraction, examine
from nonsmooth.proofs.systems.domain import Domain, domains, given_cells, plane_cells
from nonsmooth.proofs.systems.findings import (
    KEPT,
    CheckedPoint,
    Finding,
    Method,
    PlaneFunction,
    Reach,
    falling_finding,
    weak_finding,
)
from nonsmooth.proofs.systems.ray_moves import (
    UNWEIGHTED,
    ConstantFan,
    RayOfRest,
    are_cones,
    build_tangent_fan,
    conic_germ,
    decide_constant_fan,
    decide_equilibrium,
    rays_of_rest,
    resting_edges,
)
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, signs_by_factors

if TYPE_CHECKING:
    from nonsmooth.proofs.systems.leading_terms import LeadingTerms


def holds_everywhere(cells: Sequence[FieldCell]) -> bool:
    """Whether asymptotic stability extends to the plane: in cones with fields of one degree solutions scale."""
    degrees = {p.degree for cell in cells for v in cell.velocities for p in v if p}
    return are_cones(cells) and len(degrees) <= 1


SEARCH_EFFORT = 2 * EFFORT  # for all candidates of a search together


class PlanePoint(CheckedPoint):
    """The checked point of a system in two states."""

    def __init__(self, system: SwitchedSystem) -> None:
        """Refuse denominators that may vanish.

        Raises:
            SceneError: for these, and for formulas that cannot be used on some cell.
        """
        require_denominators(system)
        self.system = system
        self._attractions: list[tuple[PlaneFunction, Record | None]] = []

    @cached_property
    def cells(self) -> tuple[FieldCell, ...]:
        """The cells of the plane."""
        return plane_cells(self.system)

    @cached_property
    def rays(self) -> tuple[RayOfRest, ...]:
        """Rays of rest of a system that consists of cones near the point, sides of rest of any other.

        Of right-hand sides that only enclose the field all must rest: what one of them allows, the field need not.
        """
        if self.system.only_encloses:
            return tuple(resting_edges(self.cells, enclosing=True)) if self.system.has_one_field else ()
        near = conic_germ(self.cells)
        return tuple(rays_of_rest(near) if near is not None and are_cones(near) else resting_edges(self.cells))

    @cached_property
    def equilibrium(self) -> Equilibrium:
        """Whether 0 is in F: of the stated fields, where roots of states scale them."""
        roots = self.system.by_roots
        return decide_equilibrium(self.cells if roots is None else plane_cells(roots.unscaled))

    @cached_property
    def is_covered(self) -> bool:
        """Whether solutions cross the axes of roots near the point."""
        return all(_is_crossed(self.system, axis, half) for axis in _axes(self.system) for half in (1, -1))

    @cached_property
    def fan(self) -> ConstantFan | None:
        """The fan; None where a field near the point is not constant."""
        return decide_constant_fan(self.cells)

    @cached_property
    def leading(self) -> LeadingTerms | None:
        """The leading terms, where they decide."""
        if self.equilibrium is not Equilibrium.HOLDS or self.fan is not None:
            return None
        from nonsmooth.proofs.systems.leading_terms import decide_leading_terms

        return decide_leading_terms(self.system)

    @cached_property
    def is_led_by_linear_parts(self) -> bool:
        """Whether the linear parts of the fields on the cones at the point decide."""
        near = conic_germ(self.cells)
        if near is None or self.system.others or self.leading is None or self.leading.weights != UNWEIGHTED:
            return False
        return not any(part.at_origin for cell in near for velocity in cell.velocities for part in velocity)

    @cached_property
    def _domains(self) -> list[Domain]:
        return domains(self.system, self.system.check.lyapunov, self.cells)

    @cached_property
    def given(self) -> PlaneFunction:
        """The scene's V on the checked square, or on the plane."""
        return self.given_on(self._domains[0])

    def given_on(self, domain: Domain) -> PlaneFunction:
        """The scene's V on a domain."""
        check = self.system.check
        result = examine(given_cells(self.system, domain.radius))
        return PlaneFunction(result, domain, check.lyapunov, self.system.states, is_given=True)

    def all_given(self) -> Iterator[PlaneFunction]:
        """The scene's V on each domain."""
        yield self.given
        for domain in self._domains[1:]:
            yield self.given_on(domain)

    def attraction(self, function: PlaneFunction) -> Record | None:
        """LaSalle's principle with its evidence, of a V that does not increase; searched once for each."""
        for other, entry in self._attractions:
            if other is function:
                return entry
        radius = function.domain.radius or self.system.check.radius
        entry = attraction(self.system, function.formula, radius, function.result.cells)
        self._attractions.append((function, entry))
        return entry

    @property
    def open_reason(self) -> str:
        """What is said where nothing decides."""
        if self.equilibrium is Equilibrium.UNDECIDED:
            return "whether 0 is in F there hangs on a cell whose germ is not decided"
        return "no Lyapunov function was found, and no solution that leaves"

    # ---- how far a finding carries ---------------------------------------------------------------

    def is_covered_within(self, radius: Number | None) -> bool:
        """Whether they do so on a whole square about it, or on the plane."""
        system = self.system
        if radius is None and any(system.check.equilibrium[place].sign() for place in _rooted_places(system)):
            return False
        within = (_keeps_sign(member, axis, radius) for member in _unscaled(system) for axis in _axes(system))
        return self.is_covered and all(within)

    def reach(self, finding: Finding) -> Reach:
        """Whether every start of the plane comes to the point, and those near it in time."""
        if finding.verdict is not Translation.ASYMPTOTICALLY_STABLE:
            return Reach()
        everywhere = self.is_covered_within(None) and holds_everywhere(self.cells)
        return Reach(everywhere=everywhere, in_finite_time=arrives_in_time(self.system, self.cells))


# ---- what shows itself near the point --------------------------------------------------------------


def decide_no_equilibrium(point: PlanePoint) -> Finding | None:
    """No mixture of the velocities at the point is zero."""
    if point.equilibrium is not Equilibrium.FAILS:
        return None
    fan = point.fan if point.is_covered else None
    more = f"; {fan.reason}" if fan is not None and fan.verdict is Translation.UNSTABLE else ""
    reason = f"0 is not in F there, so every solution leaves it{more}"
    return Finding(Method.EQUILIBRIUM, Translation.UNSTABLE, reason)


def decide_by_fan(point: PlanePoint) -> Finding | None:
    """The fan of constant fields; a V may show more of one that attracts."""
    fan = point.fan
    if fan is None or fan.verdict is Translation.UNDECIDED:
        return None
    final = fan.verdict is not Translation.ASYMPTOTICALLY_STABLE
    refutes = fan.reason if fan.verdict is Translation.STABLE else ""
    return Finding(Method.FAN, fan.verdict, fan.reason, proofs=fan, refutes=refutes, is_final=final)


def decide_by_leading_terms(point: PlanePoint) -> Finding | None:
    """The leading terms; functions show more."""
    leading = point.leading
    if leading is None:
        return None
    return Finding(Method.LEADING, leading.verdict, leading.reason(point.system.states), proofs=leading, is_final=False)


# ---- functions -------------------------------------------------------------------------------------


def decide_by_stated_function(point: PlanePoint) -> Finding | None:
    """The best of the scene's V on its domains: a strict one at once, the first weak one otherwise."""
    weak = None
    for function in point.all_given():
        finding = conclude_function(point, function)
        if finding is not None and finding.is_final:
            return finding
        weak = weak or finding
    return weak


@shared_effort(SEARCH_EFFORT)
def search_function(point: PlanePoint) -> Finding | None:
    """A V that falls, unless that is known to be impossible; else one that grows, unless that is, or is not needed."""
    fan, leading, may_grow = point.fan, point.leading, point.known.function is None
    if (
        point.known.attraction_is_refuted
        or point.rays
        or (fan is not None and fan.verdict is not Translation.ASYMPTOTICALLY_STABLE)
    ):
        return None
    from nonsmooth.proofs.systems.lyapunov_search import find_lyapunov

    system, is_linear = point.system, point.is_led_by_linear_parts
    if leading is not None and leading.verdict is Translation.UNSTABLE:
        cones = are_cones(point.cells) and not system.others
        spirals = leading.growth is not None and cones and may_grow
        function = find_lyapunov(system, grows=True, is_linear=is_linear) if spirals else None
    else:
        function = find_lyapunov(system, is_linear=is_linear)
        if function is None and may_grow and fan is None and leading is None:
            function = find_lyapunov(system, grows=True)
    return None if function is None else conclude_function(point, function)


def conclude_function(point: PlanePoint, function: PlaneFunction) -> Finding | None:
    """What follows from a V alone; None where its conditions are not shown."""
    if function.grows:
        if function.decrease is not Decrease.STRICT:
            return None
        return Finding(Method.GROWTH, Translation.UNSTABLE, "a positive V grows along every solution", function)
    if function.decrease is Decrease.STRICT:
        return falling_finding(function)
    if function.decrease is not Decrease.WEAK or not point.is_covered_within(function.domain.radius):
        return None
    rest = next(map(str, point.rays), "")
    refutes = rest or (KEPT if function.is_kept else "")
    return weak_finding(function, refutes)


# ---- LaSalle's principle ---------------------------------------------------------------------------


def decide_by_stated_invariance(point: PlanePoint) -> Finding | None:
    """By the V that the scene names, where curves cut the cells: beside these a search takes long."""
    system, known = point.system, point.known
    if known.function is None or system.check.is_default or known.attraction_is_refuted:
        return None
    from nonsmooth.proofs.systems.lyapunov_search import has_curves

    return attraction_by(point, known.function) if has_curves(system) and not point.rays else None


def attraction_by(point: PlanePoint, function: PlaneFunction) -> Finding | None:
    """Whether nothing but the point stays where V, which does not increase, is kept."""
    entry = point.attraction(function) if function.decrease is Decrease.WEAK else None
    if entry is None:
        return None
    reason = f"{function.reason}, and {InvariantMotion.NONE}"
    return Finding(Method.INVARIANCE, Translation.ASYMPTOTICALLY_STABLE, reason, function, proofs=entry)


# ---- axes of roots -------------------------------------------------------------------------------
#
# With ``x = z Abs(z)`` and ``dt = 2 Abs(z) ds`` (:mod:`nonsmooth.symbolic.formulas.signed_roots`) solutions off
# ``z = 0`` are the same curves: the change of coordinates is a diffeomorphism there, and the time scale is positive.
# On ``z = 0`` the scaled field has no part along the axis, so a solution that slides along ``x = 0`` would rest in
# time s.  What is required: at every point of the axis but the checked one all velocities have a part across it, of one
# sign.  Then every solution crosses at single instants, in both times (``|x|`` grows like t, so
# ``ds = dt/(2 sqrt(|x|))`` is integrable), and solutions correspond one to one until they meet the checked point.
# Near it that suffices for the verdict; for a region and for the plane it is required on all of it
# (docs/theory.md).  Where a V falls in the scaled field solutions cross: that field rests wherever one may stay on the
# axis.  A V that does not increase there may grow along one that stays: crossing is required where it is stated.


LINE = ("s",)


@effort_of_its_own(EFFORT)
def arrives_in_time(system: SwitchedSystem, cells: Sequence[FieldCell]) -> bool:
    """Whether solutions near an asymptotically stable point are known to arrive within a finite time t.

    Exponential decay in time s makes ``t``, the integral of ``2 Abs(z)`` over s, finite.  It follows of cones with
    fields of one degree up to one, and from leading terms of such a degree that alone decide.

    Args:
        system: in two states, whose point is asymptotically stable.
        cells: of the plane.
    """
    if not has_rooted_axis(system):
        return False
    degrees = {p.degree for cell in cells for v in cell.velocities for p in v if p}
    if are_cones(cells) and degrees in ({0}, {1}):
        return True
    from nonsmooth.proofs.systems.leading_terms import decide_fan_of_leading_terms, needs_no_other_terms

    fan = None if system.rewriting.waves or system.others else build_tangent_fan(system)
    if fan is None or fan.degree > 1 or not needs_no_other_terms(fan):
        return False
    decided = decide_fan_of_leading_terms(fan)
    return decided is not None and decided.verdict is Translation.ASYMPTOTICALLY_STABLE


def has_rooted_axis(system: SwitchedSystem) -> bool:
    """Whether a root of a state is zero at the point: then solutions that decay exponentially in time s arrive."""
    return bool(_axes(system))


def _rooted_places(system: SwitchedSystem) -> list[int]:
    by_roots = system.by_roots
    return [] if by_roots is None else [by_roots.roots.states.index(name) for name in by_roots.roots.rooted]


def _axes(system: SwitchedSystem) -> list[int]:
    """The places of the roots that are zero at the checked point."""
    return [place for place in _rooted_places(system) if not system.check.equilibrium[place]]


def _unscaled(system: SwitchedSystem) -> tuple[SwitchedSystem, ...]:
    return () if system.by_roots is None else system.by_roots.unscaled.members


def _is_crossed(system: SwitchedSystem, axis: int, half: int) -> bool:
    """Whether near the point all speeds across one half of an axis have one sign."""
    speeds = [speed for member in _unscaled(system) for _, speed in _speeds(member, axis, half)]
    return {germ_sign(speed) for speed in speeds} in ({1}, {-1})


def _keeps_sign(member: SwitchedSystem, axis: int, radius: Number | None) -> bool:
    """Whether nothing switches on the axis, and no speed across it vanishes, up to a distance."""
    for half in (1, -1):
        for deciding, speed in _speeds(member, axis, half):
            if any(_vanishes_within(p, radius) for p in (*deciding, speed)):
                return False
    return True


def _speeds(member: SwitchedSystem, axis: int, half: int) -> Iterator[tuple[list[Polynomial], Polynomial]]:
    """On both sides of a half axis what decides the signs there, and the speed across it, along the half axis."""
    values = member.displaced(member.states)
    for side in (1, -1):
        germs = {s: _beside(s, axis, half, side) for s in member.surfaces(values)}
        signs = {s: germ_sign(germ) for s, germ in germs.items()}
        speed = member.velocity(signs_by_factors(signs), values)[axis]
        yield list(germs.values()), _on_axis(speed, axis, half, 0)


def _beside(surface: Polynomial, axis: int, half: int, side: int) -> Polynomial:
    """What has the sign of a surface beside a half axis: its first part in powers of the distance that is not zero."""
    powers = sorted({exponents[axis] for exponents in surface.terms})
    parts = ((power, _on_axis(surface, axis, half, power)) for power in powers)
    power, part = next((power, part) for power, part in parts if part)
    return part * side**power


def _on_axis(polynomial: Polynomial, axis: int, half: int, power: int) -> Polynomial:
    """The coefficient of a power of the distance from an axis, along one half of it."""
    other = 1 - axis
    chosen = [(e[other], c) for e, c in polynomial.terms.items() if e[axis] == power]
    terms: dict[tuple[int, ...], Number] = {(k,): c * half**k for k, c in chosen}
    return Polynomial(polynomial.field, LINE, terms)


def _vanishes_within(polynomial: Polynomial, radius: Number | None) -> bool:
    """Whether a polynomial has a root at a positive distance up to the radius."""
    roots = positive_roots(dense(polynomial))
    if radius is None:
        return bool(roots)
    return any(root.sign_of([-radius, radius.field.one]) <= 0 for root in roots)
