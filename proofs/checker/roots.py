"""Systems with ``sqrt(Abs(x))``, judged in the signed roots ``w = sign(x) sqrt(Abs(x))`` of some states x.

With ``x = w Abs(w)`` and ``sqrt(Abs(x)) = Abs(w)`` formulas are polynomials in w on each cell, and ``x' = f`` is
``2 Abs(w) w' = f``.  In the time s with ``dt = prod_j 2 Abs(w_j) ds`` over all roots the root of a state moves by f
times the factors of the other roots, and any other state by its f times all factors: polynomials again.

*Why this says something of the states.*  The roots are a homeomorphism, and off their zeros a diffeomorphism; there the
factors are positive, so solutions in t and in s are the same curves.  Where a root is zero, but at the point, all
velocities are shown to cross that zero in one sense (:func:`show_crossed`): x' is bounded away from zero near there, so
the times at which a solution has such a root are isolated until it meets the point.  A function of the roots is
continuous along the solution, and what falls between these times falls over them.  A solution cannot leave the point
while a function that is zero there alone does not rise.  So stability, instability and starts that reach the point are
the same for states and roots, and limit sets are those of the states' inclusion.  Rates are not: they are in another
time.  One solution that leaves where no root is zero (:mod:`.escape`) needs no crossing: the factors ask the sign of
every root, so it is that of a surface, and on a subspace where it is zero they make the field zero.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from itertools import combinations_with_replacement
from math import isqrt
from typing import Any

from .cells import Face, Inclusion, System, read_system
from .formulas import Formula, SignOf, WaveAt, parts_without_calls
from .polynomials import Polynomial, solve
from .positivity import Claim, Inequality
from .work import items, require, take


@dataclass(frozen=True)
class RootedSystem(System):
    """A system in the signed roots of some states.

    Attributes:
        roots: the states of which V and the domain are about the roots; that of x has the name ``root_x``.
        scaled: whether the velocities are those of the roots, in the time s, not those of the states.
    """

    roots: tuple[str, ...] = ()
    scaled: bool = True

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the roots, and of the other states."""
        return tuple(f"root_{name}" if name in self.roots else name for name in self.states)

    @property
    def origin(self) -> tuple[Fraction, ...]:
        """The point in these."""
        pairs = zip(self.states, self.at, strict=True)
        return tuple(signed_root(value) if name in self.roots else value for name, value in pairs)

    @property
    def stated(self) -> RootedSystem:
        """The same with the velocities of the states."""
        return replace(self, scaled=False)

    def fields(self, place: Mapping[str, Polynomial], wave: WaveAt | None = None) -> Sequence[Sequence[Formula]]:
        """The formulas of the velocities, without sines and cosines."""
        require(wave is None, "no roots where sines and cosines are bounded")
        own = {name: place[f"root_{name}"] for name in self.roots}
        found = []
        for side in self.rhs:
            factors = ([name for name in self.roots if name != state] if self.scaled else [] for state in self.states)
            found.append([RootedFormula(text, place, own, names) for text, names in zip(side, factors, strict=True)])
        return found

    def show_equivalent(self, inclusion: Inclusion) -> None:
        """Solutions cross all zeros of roots, where velocities are those of the roots."""
        for name in self.roots if self.scaled else ():
            show_crossed(inclusion, self.states.index(name), inclusion.domain.place[f"root_{name}"])


def read_subject(data: Any) -> System:
    """The system that a certificate is about, with roots or without."""
    if type(data) is not dict or "roots" not in data:
        return read_system(data)
    states, rhs, at, listed = take(data, "states rhs at roots")
    own = read_system({"states": states, "rhs": rhs, "at": at})
    roots = tuple(items(listed, most=len(own.states)))
    known = all(type(name) is str and name in own.states for name in roots)
    require(roots and known and len(set(roots)) == len(roots), "roots of different states")
    system = RootedSystem(own.states, own.rhs, own.at, roots=roots)
    require(len(set(system.coordinates)) == system.count, "names of roots that are no states")
    return system


def signed_root(value: Fraction) -> Fraction:
    """``sign(x) sqrt(Abs(x))``, which must be rational."""
    root = Fraction(isqrt(abs(value.numerator)), isqrt(value.denominator))
    require(root * root == abs(value), "a point whose roots are rational")
    return root if value > 0 else -root


class RootedFormula(Formula):
    """A right-hand side in the signed roots, times the factors ``2 Abs(w)`` of some of them."""

    def __init__(
        self, data: Any, place: Mapping[str, Polynomial], roots: Mapping[str, Polynomial], factors: Sequence[str]
    ) -> None:
        super().__init__(data, place)
        self.states = {name: own for name, own in place.items() if own not in roots.values()}
        self.roots, self.factors = roots, factors
        self.smooth = parts_without_calls(self.tree, roots)  # such a state is another polynomial on each side of zero

    def on(self, sign_of: SignOf) -> Polynomial:
        """The polynomial on a cell."""
        value = super().on(sign_of)
        for name in self.factors:
            value *= self._size(name, sign_of).times(2)
        return value

    def _size(self, name: str, sign_of: SignOf) -> Polynomial:
        """``sqrt(Abs(x)) = Abs(w)``."""
        return self.roots[name].times(sign_of(self.roots[name]))

    def _value(self, node: ast.expr, sign_of: SignOf, depth: int) -> Polynomial:
        match node:
            case ast.Name(id=name) if name in self.roots:
                return self.roots[name] * self._size(name, sign_of)
            case ast.Call(func=ast.Name(id="sqrt"), args=[ast.Call() as inner], keywords=[]):
                match inner:
                    case ast.Call(func=ast.Name(id="Abs"), args=[ast.Name(id=name)], keywords=[]) if name in self.roots:
                        return self._size(name, sign_of)
        return super()._value(node, sign_of, depth)


def show_crossed(inclusion: Inclusion, k: int, root: Polynomial) -> None:
    """Where the root of the k-th state is zero, but at the point, any two speeds across it have one sign."""
    domain, surfaces = inclusion.domain, inclusion.surfaces
    zero = Face(inclusion, (), (), solve([root], inclusion.count) or (), inclusion.count - 1)
    if zero.is_outside:
        return
    formulas = [side[k] for side in domain.system.stated.fields(domain.place)]
    speeds: dict[tuple[tuple[tuple[str, Polynomial], ...], Polynomial], None] = {}  # each with its guards
    for cell in inclusion.cells:
        guards = zero.guards(dict(enumerate(cell.signs)))
        if guards is not None:
            own = (formula.on(partial(surfaces.sign_on, cell.signs)) for formula in formulas)
            speeds.update(((tuple(guards.items()), zero.restricted(speed)), None) for speed in own)
    for (i, (first, a)), (j, (second, b)) in combinations_with_replacement(enumerate(speeds), 2):
        both = {**dict(first), **{f"{name}'": own for name, own in second}}
        name = f"crosses {k} speeds {i} {j}"
        surfaces.proofs.show(Claim(name, (Inequality(a * b, both),), True, not zero.holds_origin, domain.bounded))
