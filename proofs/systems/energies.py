"""Energies of systems of second order: candidates for a V.

Where ``x' = a v`` with a number a, and ``v' = -g(x) - ...``, the energy ``G(x)/a + v^2/2`` with ``G' = g`` changes by
damping alone.  ``V = G(x)/a + v^2/2 + c v h(x)`` with a small c, and ``h = x`` or ``h = g``, falls where v is zero,
too: where g jumps, as that of a relay, terms of V' of lowest order must cancel exactly, and no linear program with a
margin proposes such a V.  Where the force is a function of ``x + s v`` alone, as under a saturated control, so is G.

Proposals, read off the right-hand sides at a few points; whoever takes one proves what it says.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise
from math import comb
from typing import TypeAlias

from flint import fmpq, fmpq_poly

from nonsmooth.proofs.systems.lyapunov_rows import BasisFunction, build_formula
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial, Terms
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem

SHARES = (Fraction(1, 4), Fraction(1, 16))  # of the cross term, tried in turn
NEAR = fmpq(1, 1 << 20)  # of the least distance between ends: where pieces are read off
MOST_DEGREE = 5  # of g

Term: TypeAlias = tuple[fmpq, BasisFunction]


@dataclass(frozen=True)
class Pieces:
    """A function of one variable: polynomials between ends in ascending order, of which 0 is one."""

    ends: tuple[fmpq, ...]
    polynomials: tuple[fmpq_poly, ...]

    @property
    def is_continuous(self) -> bool:
        """Whether it nowhere jumps."""
        return all(left(end) == right(end) for end, left, right in self._sides())

    def _sides(self) -> Iterator[tuple[fmpq, fmpq_poly, fmpq_poly]]:
        """Each end with the polynomials on its left and on its right."""
        return zip(self.ends, self.polynomials[:-1], self.polynomials[1:], strict=True)

    @property
    def integral(self) -> Pieces:
        """The continuous one that is zero at 0."""
        found = [own.integral() for own in self.polynomials]
        for k, end in enumerate(self.ends):
            found[k + 1] += found[k](end) - found[k + 1](end)
        at_zero = found[self.ends.index(fmpq(0))](fmpq(0))
        return Pieces(self.ends, tuple(own - at_zero for own in found))

    def terms(self) -> Iterator[tuple[fmpq, int, fmpq | None]]:
        """A continuous function as a sum of ``c x^k``, and of ``c x^k |x - end|``: coefficient, power and end."""
        mean = (self.polynomials[0] + self.polynomials[-1]) / 2
        yield from ((c, k, None) for k, c in enumerate(mean.coeffs()))
        for end, left, right in self._sides():
            bend = (right - left) // fmpq_poly([-end, 1]) / 2
            yield from ((c, k, end) for k, c in enumerate(bend.coeffs()))


@dataclass(frozen=True)
class SecondOrder:
    """A system with ``x' = a v`` and ``v' = -g(x) - ...``.

    Attributes:
        system: in two states.
        place: of x among the states.
        speed: a, which is not zero.
        force: g, the mean of both signs of v.
    """

    system: SwitchedSystem
    place: int
    speed: fmpq
    force: Pieces

    def energy(self, slant: fmpq) -> list[Term]:
        """``G(x + slant v)/a + v^2/2``."""
        return [(fmpq(1, 2), self._function(0, 2)), *self._sum(self.force.integral, 1 / self.speed, 0, slant)]

    def crossed(self, share: Fraction, shape: Pieces) -> list[Term]:
        """``share v h(x)``."""
        return self._sum(shape, as_fmpq(share), 1, fmpq(0))

    def _sum(self, function: Pieces, factor: fmpq, power: int, slant: fmpq) -> list[Term]:
        """A continuous function of ``x + slant v``, times a factor and a power of v."""
        found = []
        for c, k, end in function.terms():
            line = None if end is None else self._polynomial({(1, 0): fmpq(1), (0, 1): slant, (0, 0): -end})
            for j in range(k + 1 if slant else 1):  # of the binomial
                found.append((c * factor * comb(k, j) * slant**j, self._function(k - j, power + j, line)))
        return found

    def _function(self, k: int, power: int, line: Polynomial | None = None) -> BasisFunction:
        return BasisFunction(self._polynomial({(k, power): fmpq(1)}), line)

    def _polynomial(self, terms: dict[tuple[int, int], fmpq]) -> Polynomial:
        """By exponents of x and v."""
        field = self.system.field
        ordered: Terms = {
            (k, power) if not self.place else (power, k): field(c) for (k, power), c in terms.items() if c
        }
        return Polynomial(field, PLANE, ordered)

    def formula(self, terms: Sequence[Term]) -> PiecewiseExpression:
        """The sum as a formula of the states."""
        return build_formula([own for _, own in terms], [as_fraction(c) for c, _ in terms], self.system.states)


def energies(system: SwitchedSystem) -> Iterator[PiecewiseExpression]:
    """Energies in the whole plane, in x and in those ``x + s v`` that switch a system in two states."""
    lines = [own.terms for own in system.surfaces(system.displaced(PLANE)) if own.degree == 1]
    for place in (0, 1):
        found = second_order(system, place, None)
        if found is None:
            continue
        x, v = _units(place)
        slants = ((own[v] / own[x]).as_rational() for own in lines if x in own and v in own)
        for slant in dict.fromkeys((fmpq(0), *slants)):
            if slant is not None:
                yield found.formula(found.energy(slant))


def crossed_energies(system: SwitchedSystem, radius: Number) -> Iterator[PiecewiseExpression]:
    """Energies with a cross term on a square of some half-width, for a system in two states."""
    for place in (0, 1):
        found = second_order(system, place, radius)
        if found is None:
            continue
        side = 1 if found.speed > 0 else -1
        shapes = [Pieces((fmpq(0),), (fmpq_poly([0, side]),) * 2)]
        if found.force.is_continuous and found.force != shapes[0]:
            shapes.append(found.force)
        for share in SHARES:
            for shape in shapes:
                yield found.formula(found.energy(fmpq(0)) + found.crossed(share, shape))


def second_order(system: SwitchedSystem, place: int, radius: Number | None) -> SecondOrder | None:
    """A system as one of second order, where it is one with a rational g.

    Args:
        system: in two states.
        place: of x among them.
        radius: half the side of the square beyond which nothing is asked; None for the plane.
    """
    states, (x, v) = system.displaced(PLANE), _units(place)
    ends = {fmpq(0)}
    for surface in system.surfaces(states):
        own = {exponents: c for exponents, c in surface.terms.items() if not exponents[1 - place]}
        if set(own) <= {x, (0, 0)} and x in own:
            end = -own.get((0, 0), system.field.zero) / own[x]
            known = end.as_rational()
            if known is not None and (radius is None or abs(end) < radius):
                ends.add(known)
    ordered = sorted(ends)
    near = NEAR * min((right - left for left, right in pairwise(ordered)), default=fmpq(1))
    found = []
    for beside in [*(end - near for end in ordered if end <= 0), *(end + near for end in ordered if end >= 0)]:
        for up in (near * near, -near * near):
            at = [system.field(own) for own in ((beside, up) if place == 0 else (up, beside))]
            velocity = system.members[0].velocity(lambda own, at=at: own(at).sign(), states)  # type: ignore[misc]
            if set(velocity[place].terms) != {v}:
                return None
            force = {e[place]: c.as_rational() for e, c in velocity[1 - place].terms.items() if not e[1 - place]}
            found.append((velocity[place].terms[v].as_rational(), force))
    speed, forces = found[0][0], [force for _, force in found]
    if speed is None or any(own != speed for own, _ in found):
        return None
    if any(c is None or k > MOST_DEGREE for force in forces for k, c in force.items()):
        return None
    sides = [fmpq_poly([-(force.get(k) or fmpq(0)) for k in range(MOST_DEGREE + 1)]) for force in forces]
    means = tuple((above + below) / 2 for above, below in zip(sides[::2], sides[1::2], strict=True))
    return SecondOrder(system, place, speed, Pieces(tuple(ordered), means))


def _units(place: int) -> tuple[tuple[int, int], tuple[int, int]]:
    """The exponents of x and of v alone."""
    return ((1, 0), (0, 1)) if place == 0 else ((0, 1), (1, 0))
