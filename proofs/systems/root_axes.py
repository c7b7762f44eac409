"""Where verdicts in signed roots of states hold for the states themselves.

With ``x = z Abs(z)`` and ``dt = 2 Abs(z) ds`` (:mod:`nonsmooth.symbolic.signed_roots`) solutions off ``z = 0`` are the
same curves: the change of coordinates is a diffeomorphism there, and the time scale is positive.  On ``z = 0`` the
scaled field has no part along the axis, so a solution that slides along ``x = 0`` would rest in time s.  What is
required: at every point of the axis but the checked one all velocities have a part across it, of one sign.  Then every
solution crosses at single instants, in both times (``|x|`` grows like t, so ``ds = dt/(2 sqrt(|x|))`` is integrable),
and solutions correspond one to one until they meet the checked point.  Near it that suffices for the verdict; for a
region and for the plane it is required on all of it (docs/theory.md).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from nonsmooth.analysis.cells.switched_cells import FieldCell
from nonsmooth.proofs.inequalities.real_roots import dense, germ_sign, positive_roots
from nonsmooth.proofs.systems.leading_terms import decide_fan_of_leading_terms, needs_no_other_terms
from nonsmooth.proofs.systems.ray_moves import are_cones
from nonsmooth.proofs.systems.tangent_fan import build_tangent_fan
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.switched_system import SwitchedSystem, signs_by_factors

LINE = ("s",)


def axes_are_crossed(system: SwitchedSystem) -> bool:
    """Whether near the checked point solutions cross every axis on which the root of a state is zero."""
    return all(_is_crossed(system, axis, half) for axis in _axes(system) for half in (1, -1))


def axes_are_crossed_within(system: SwitchedSystem, radius: Number | None) -> bool:
    """Whether they do so on a whole square about it, or on the plane (None)."""
    if system.by_roots is None:
        return True
    if any(system.check.equilibrium[place].sign() for place in _rooted_places(system)) and radius is None:
        return False
    within = (_keeps_sign(member, axis, radius) for member in _unscaled(system) for axis in _axes(system))
    return axes_are_crossed(system) and all(within)


def arrives_in_time(system: SwitchedSystem, cells: Sequence[FieldCell], *, falls_exponentially: bool) -> bool:
    """Whether solutions near an asymptotically stable point are known to arrive within a finite time t.

    Exponential decay in time s makes ``t``, the integral of ``2 Abs(z)`` over s, finite.  It follows from a V with a
    rate, of cones with fields of one degree up to one, and from leading terms of such a degree that alone decide.

    Args:
        system: in two states, whose point is asymptotically stable.
        cells: of the plane.
        falls_exponentially: whether a V with a rate in time s is known.
    """
    if not _axes(system):
        return False
    degrees = {p.degree for cell in cells for v in cell.velocities for p in v if p}
    if falls_exponentially or (are_cones(cells) and degrees in ({0}, {1})):
        return True
    fan = None if system.waves or system.others else build_tangent_fan(system)
    if fan is None or fan.degree > 1 or not needs_no_other_terms(fan):
        return False
    decided = decide_fan_of_leading_terms(fan)
    return decided is not None and decided.verdict is Translation.ASYMPTOTICALLY_STABLE


def _rooted_places(system: SwitchedSystem) -> list[int]:
    known = system.by_roots
    return [] if known is None else [known.roots.states.index(name) for name in known.roots.rooted]


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
        known = {s: _beside(s, axis, half, side) for s in member.surfaces(values)}
        signs = {s: germ_sign(germ) for s, germ in known.items()}
        speed = member.velocity(signs_by_factors(signs), values)[axis]
        yield list(known.values()), _on_axis(speed, axis, half, 0)


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
