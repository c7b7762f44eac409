"""Energies: candidates for a V that is a sum of functions of one state each, as of springs, masses and relays.

Where ``x_i`` acts upon all other states by one function, ``x_j' = ... + a_ji h_i(x_i)``, the sum
``V = sum_i c_i H_i(x_i)`` with ``H_i' = h_i`` changes by ``(c_i a_ij + c_j a_ji) h_i h_j`` for each pair of states, and
by what each damps by itself: with ``c_i a_ij = -c_j a_ji`` damping alone is left.  Of ``x' = v, v' = -g(x)`` it is
``G(x) + v^2/2``.  Where an h is a function of ``x_i + s x_j``, as under a saturated control, so may be its H.
Springs that join several masses have an energy of their own (:mod:`nonsmooth.proofs.systems.coupled_energy`).

``V + c v h(x)`` with a small c, and ``h = x`` or ``h = g``, falls where v is zero, too: where g jumps, as that of a
relay, terms of V' of lowest order must cancel exactly, and no linear program with a margin proposes such a V.

These are proposals, read off the right-hand sides at a few points; whoever takes one proves what it says.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import pairwise
from typing import TypeAlias

from flint import fmpq, fmpq_poly

from nonsmooth.proofs.kernel.bases import PiecewiseFunction, formula_text, monomial
from nonsmooth.proofs.systems.coupled_energy import coupled_energy
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, no_sign, parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SHARES = (Fraction(1, 4), Fraction(1, 16))  # of the cross term, tried in turn
NEAR = fmpq(1, 1 << 20)  # of the least distance between ends: where pieces are read off
MOST_DEGREE = 11  # of h

Term: TypeAlias = tuple[fmpq, PiecewiseFunction]


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
    def is_polynomial(self) -> bool:
        """Whether it is one on all sides."""
        return all(polynomial == self.polynomials[0] for polynomial in self.polynomials)

    @property
    def size(self) -> fmpq:
        """The leading coefficient just beyond zero; zero for what vanishes there."""
        beyond = self.polynomials[self.ends.index(fmpq(0)) + 1]
        return next((c for c in beyond.coeffs() if c), fmpq(0))

    def times(self, factor: fmpq) -> Pieces:
        """The multiple."""
        return Pieces(self.ends, tuple(polynomial * factor for polynomial in self.polynomials))

    @property
    def integral(self) -> Pieces:
        """The continuous one that is zero at 0."""
        integrals = [polynomial.integral() for polynomial in self.polynomials]
        for k, end in enumerate(self.ends):
            integrals[k + 1] += integrals[k](end) - integrals[k + 1](end)
        at_zero = integrals[self.ends.index(fmpq(0))](fmpq(0))
        return Pieces(self.ends, tuple(integral - at_zero for integral in integrals))

    def terms(self) -> Iterator[tuple[fmpq, int, fmpq | None]]:
        """A continuous function as a sum of ``c x^k``, and of ``c x^k |x - end|``: coefficient, power and end."""
        mean = (self.polynomials[0] + self.polynomials[-1]) / 2
        yield from ((c, k, None) for k, c in enumerate(mean.coeffs()))
        for end, left, right in self._sides():
            bend = (right - left) // fmpq_poly([-end, 1]) / 2
            yield from ((c, k, end) for k, c in enumerate(bend.coeffs()))


IDENTITY = Pieces((fmpq(0),), (fmpq_poly([0, 1]),) * 2)


# ---- how states act upon each other --------------------------------------------------------------


@dataclass(frozen=True)
class Actions:
    """How each state of a system acts upon the others, near the axes.

    Attributes:
        system: whose right-hand sides were read.
        shapes: h of each state; the state itself where it acts upon no other one.
        rates: a by numbers of states, that which acts last; no zeros.
    """

    system: SwitchedSystem
    shapes: tuple[Pieces, ...]
    rates: Mapping[tuple[int, int], fmpq]

    @property
    def factors(self) -> list[fmpq]:
        """The c of each state, from the last one on; 1 where nothing else is asked."""
        count, factors = len(self.shapes), dict[int, fmpq]()
        for last in reversed(range(count)):
            waiting = [] if last in factors else [last]
            factors.setdefault(last, fmpq(1))
            while waiting:
                i = waiting.pop()
                for j in set(range(count)) - set(factors):
                    there, back = self.rates.get((j, i), 0), self.rates.get((i, j), 0)
                    if there * back < 0:
                        factors[j] = -factors[i] * back / there
                        waiting.append(j)
        return [factors[k] for k in range(count)]

    def energy(self, slanted: int | None = None, line: Polynomial | None = None) -> list[Term]:
        """V; the H of one state may be that of a linear form."""
        terms: list[Term] = []
        for k, (factor, shape) in enumerate(zip(self.factors, self.shapes, strict=True)):
            at = line if k == slanted and line is not None else self.states[k]
            terms += self.product(factor, shape.integral, at, self.states[k] * 0 + 1)
        return terms

    def product(self, factor: fmpq, function: Pieces, at: Polynomial, times: Polynomial) -> list[Term]:
        """A continuous function of a linear form, times a factor and a monomial."""
        terms = []
        for c, k, end in function.terms():
            line, power = None if end is None else at - self.system.field(end), times
            for _ in range(k):
                power = power * at
            for exponents, coefficient in power.terms.items():
                rational = coefficient.as_rational()
                if rational is not None:
                    terms.append((c * factor * rational, _bent(monomial(self.system.states, exponents), line)))
        return terms

    def written(self, terms: Sequence[Term]) -> Iterator[PiecewiseExpression]:
        """The sum as a formula of the states; none where that is too long."""
        total: dict[PiecewiseFunction, fmpq] = {}
        for c, function in terms:
            total[function] = total.get(function, fmpq(0)) + c
        with suppress(ExpressionError):
            yield parse_piecewise(formula_text(list(total), list(total.values())), self.system.states)

    @property
    def states(self) -> tuple[Polynomial, ...]:
        """The states as polynomials in the displacement."""
        return self.system.coordinates()


def _bent(function: PiecewiseFunction, line: Polynomial | None) -> PiecewiseFunction:
    """A monomial, a constant one included, times the absolute value of a line where there is one."""
    if line is None:
        return replace(function, text=function.text or "1")
    text = f"Abs({line})"
    return PiecewiseFunction(f"{function.text}*{text}" if function.text else text, function.degree + line.degree)


def actions(system: SwitchedSystem, radius: Number | None) -> Actions | None:
    """How states act upon each other; None where a velocity near an axis is no rational polynomial of low degree.

    Args:
        system: in two states or more; of several right-hand sides the first is read.
        radius: half the side of the cube beyond which nothing is asked; None for the space.
    """
    shapes: list[Pieces] = []
    rates: dict[tuple[int, int], fmpq] = {}
    for i in range(len(system.states)):
        read = _along_axis(system, i, radius)
        if read is None:
            return None
        acting = {j: action for j, action in enumerate(read) if j != i and action.size}
        shape = next((action.times(1 / action.size) for action in acting.values()), IDENTITY)
        shapes.append(shape)
        rates.update({(j, i): action.size for j, action in acting.items() if action == shape.times(action.size)})
    return Actions(system, tuple(shapes), rates)


def _along_axis(system: SwitchedSystem, i: int, radius: Number | None) -> list[Pieces] | None:
    """Of each velocity what hangs on state i alone, the mean of both sides of its axis."""
    states, count = system.displaced(system.states), len(system.states)
    ends = _ends(system, i, radius)
    near = NEAR * min((right - left for left, right in pairwise(ends)), default=fmpq(1))
    off = near ** (1 + max((surface.degree for surface in system.surfaces(states)), default=1))  # less than curves bend
    pieces: list[list[fmpq_poly]] = [[] for _ in system.states]
    for beside in [*(end - near for end in ends if end <= 0), *(end + near for end in ends if end >= 0)]:
        total = [fmpq_poly() for _ in system.states]
        for side in (1, -1):
            aside = [side * off / (k + 1) for k in range(count)]
            at = [system.field(beside if k == i else offset) for k, offset in enumerate(aside)]
            read = _alone_near(system, states, i, at)
            if read is None:
                return None
            total = [polynomial + part / 2 for polynomial, part in zip(total, read, strict=True)]
        if max(polynomial.degree() for polynomial in total) > MOST_DEGREE:
            return None
        for polynomials, value in zip(pieces, total, strict=True):
            polynomials.append(value)
    return [Pieces(tuple(ends), tuple(polynomials)) for polynomials in pieces]


def _alone_near(
    system: SwitchedSystem, states: Sequence[Polynomial], i: int, at: Sequence[Number]
) -> list[fmpq_poly] | None:
    """Of each velocity in the cell of a place what hangs on state i alone; None where that is not rational.

    Fields that were multiplied by denominators are divided again where that leaves polynomials.
    """

    def sign_of(polynomial: Polynomial) -> int:
        return polynomial(at).sign()

    scale = None
    if system.rewriting.scale is not None and not system.rewriting.norms:
        scale = _alone(system.rewriting.scale.polynomial(system.named(states), sign_of), i)
    polynomials = []
    for part in system.members[0].velocity(sign_of, states):
        alone = _alone(part, i)
        if alone is None:
            return None
        quotient, rest = divmod(alone, scale or fmpq_poly([1]))
        polynomials.append(alone if rest else quotient)
    return polynomials


def _alone(value: Polynomial, i: int) -> fmpq_poly | None:
    """The terms that hang on variable i alone; None where one is not rational."""
    alone = {e[i]: c.as_rational() for e, c in value.terms.items() if e[i] == sum(e)}
    if None in alone.values():
        return None
    return fmpq_poly([alone.get(k) or fmpq(0) for k in range(max(alone, default=0) + 1)])


def _ends(system: SwitchedSystem, i: int, radius: Number | None) -> list[fmpq]:
    """Where the axis of a state meets switching surfaces at rational places, and 0; in ascending order."""
    ends = {fmpq(0)}
    for surface in system.surfaces(system.displaced(system.states)):
        coefficients = {e[i]: c for e, c in surface.terms.items() if e[i] == sum(e)}
        if set(coefficients) in ({0, 1}, {1}):
            end = -coefficients.get(0, system.field.zero) / coefficients[1]
            rational = end.as_rational()
            if rational is not None and (radius is None or abs(end) < radius):
                ends.add(rational)
    return sorted(ends)


# ---- candidates ------------------------------------------------------------------------------------


def energies_within(system: SwitchedSystem, radius: Number | None) -> Iterator[PiecewiseExpression]:
    """That of masses which springs join, and the sum of functions of one state each, on a cube of some half-width."""
    coupled, interaction = coupled_energy(system), actions(system, radius)
    if coupled is not None:
        yield coupled
    if interaction is not None:
        yield from interaction.written(interaction.energy())


def energies(system: SwitchedSystem) -> Iterator[PiecewiseExpression]:
    """Energies in the whole space, then those with an H of a linear form that switches."""
    yield from energies_within(system, None)
    interaction = actions(system, None)
    if interaction is None:
        return
    for surface in system.surfaces(system.displaced(system.states)):
        slopes = {e.index(1): c for e, c in surface.terms.items() if sum(e) == 1}
        for i in slopes if surface.degree == 1 and len(slopes) > 1 else ():
            if not interaction.shapes[i].is_polynomial:
                line = interaction.states[0] * 0
                for k, slope in slopes.items():
                    line = line + interaction.states[k] * (slope / slopes[i])
                yield from interaction.written(interaction.energy(i, line))


def falling_energies(system: SwitchedSystem, radius: Number) -> Iterator[PiecewiseExpression]:
    """Energies that may fall on a square of some half-width, in two states; with a cross term where ``x' = a v``."""
    interaction = actions(system, radius)
    if interaction is None:
        return
    yield from interaction.written(interaction.energy())
    for place, other in ((0, 1), (1, 0)):
        if not _is_multiple(system, place, other) or (other, place) not in interaction.rates:
            continue
        scale = 1 / interaction.factors[other]
        energy = [(c * scale, function) for c, function in interaction.energy()]
        force = interaction.shapes[place].times(-interaction.rates[other, place])
        side = fmpq(1) if interaction.rates[place, other] > 0 else fmpq(-1)
        shapes = [IDENTITY.times(side)]
        if force.is_continuous and force != shapes[0]:
            shapes.append(force)
        for share in SHARES:
            for shape in shapes:
                crossed = interaction.product(
                    as_fmpq(share), shape, interaction.states[place], interaction.states[other]
                )
                yield from interaction.written(energy + crossed)


def _is_multiple(system: SwitchedSystem, place: int, other: int) -> bool:
    """Whether the velocity of one state is a multiple of another state."""
    velocity = system.rhs[place]
    if velocity.switching_parts:
        return False
    values = system.named(system.displaced(system.states))
    return set(velocity.polynomial(values, no_sign).terms) == {
        tuple(int(k == other) for k in range(len(system.states)))
    }
