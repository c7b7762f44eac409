"""Systems with ``Abs(x)**(p/q)``, judged in the signed roots ``w = sign(x) Abs(x)**(1/q)`` of some states x.

Each of these states has its order ``q >= 2``; ``sqrt(Abs(x))`` is ``Abs(x)**(1/2)``.  With ``x = w Abs(w)**(q - 1)``
and ``Abs(x)**(p/q) = Abs(w)**p`` formulas are polynomials in w on each cell, and ``x' = f`` is
``q Abs(w)**(q - 1) w' = f``.  In the time s with ``dt = prod_j q_j Abs(w_j)**(q_j - 1) ds`` over all roots the root of
a state moves by f times the factors of the other roots, and any other state by its f times all factors: polynomials
again.  What a sine is of is a polynomial in w on each cell, too, so it is bounded as without roots (:mod:`.formulas`).

*Why this says something of the states.*  The roots are a homeomorphism, and off their zeros a diffeomorphism; there the
factors are positive, so solutions in t and in s are the same curves.  Where a root is zero, but at the point, all
velocities are shown to cross that zero in one sense (:func:`show_crossed`): x' is bounded away from zero near there, so
the times at which a solution has such a root are isolated until it meets the point; about one ``Abs(x)`` grows like t,
and the time s, like ``t**(1/q)``, goes on.  A function of the roots is
continuous along the solution, and what falls between these times falls over them.  A solution cannot leave the point
while a function that is zero there alone does not rise.  So stability, instability and starts that reach the point are
the same for states and roots, and limit sets are those of the states' inclusion.  Rates are not: they are in another
time.  One solution that leaves where no root is zero (:mod:`.escape`) needs no crossing: the factors ask the sign of
every root, so it is that of a surface, and on a subspace where it is zero they make the field zero.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from fractions import Fraction
from functools import partial
from itertools import combinations_with_replacement
from typing import Any, NamedTuple

from .cells import Domain, Face, Inclusion, System, read_system
from .formulas import Formula, SignOf, WaveAt, parts_without_calls
from .polynomials import Coefficient, Polynomial, constant, solve
from .positivity import Claim, Inequality
from .work import BUDGET, RejectedError, items, require, take, whole

MAX_ORDER = 8  # of a root


@dataclass(frozen=True)
class RootedSystem(System):
    """A system in the signed roots of some states.

    Attributes:
        roots: the states of which V and the domain are about the roots, each with the order of its root; that of x has
            the name ``root_x``.
        scaled: whether the velocities are those of the roots, in the time s, not those of the states.
    """

    roots: Mapping[str, int] = field(default_factory=dict)
    scaled: bool = True

    @property
    def coordinates(self) -> tuple[str, ...]:
        """The names of the roots, and of the other states."""
        return tuple(f"root_{name}" if name in self.roots else name for name in self.states)

    @property
    def meanings(self) -> list[str]:
        """What each root is, as a formula."""
        powers = {2: "sqrt(Abs({0}))"}
        sizes = {name: powers.get(order, f"Abs({{0}})**(1/{order})").format(name) for name, order in self.roots.items()}
        return [f"root_{name} = sign({name})*{sizes[name]}" for name in self.states if name in sizes]

    @property
    def origin(self) -> tuple[Coefficient, ...]:
        """The point in these."""
        pairs = zip(self.states, self.at, strict=True)
        return tuple(signed_root(value, self.roots[name]) if name in self.roots else value for name, value in pairs)

    @property
    def orders(self) -> tuple[int, ...]:
        """Of the root that stands for each state."""
        return tuple(self.roots.get(name, 1) for name in self.states)

    @property
    def in_time_of_states(self) -> bool:
        """Whether the velocities are those of the states."""
        return not self.scaled

    @property
    def stated(self) -> RootedSystem:
        """The same with the velocities of the states."""
        return replace(self, scaled=False)

    def fields(self, place: Mapping[str, Polynomial], wave: WaveAt | None = None) -> Sequence[Sequence[Formula]]:
        """The formulas of the velocities."""
        require(wave is None, "no roots where sines and cosines are bounded")
        return super().fields(place)

    def formula(
        self, state: str, data: str, place: Mapping[str, Polynomial], ends: Sequence[int], wave: WaveAt
    ) -> Formula:
        """The formula of the velocity of a state, or of its root."""
        roots = {name: Root(place[f"root_{name}"], order) for name, order in self.roots.items()}
        factors = [name for name in roots if name != state] if self.scaled else []
        return RootedFormula(data, place, ends, wave, roots, factors)

    def show_equivalent(self, inclusion: Inclusion) -> None:
        """Solutions cross all zeros of roots, where velocities are those of the roots."""
        for name in self.roots if self.scaled else ():
            show_crossed(inclusion, self.states.index(name), inclusion.domain.place[f"root_{name}"])

    def along(self, field: Sequence[Polynomial], function: Polynomial, domain: Domain, sign_of: SignOf) -> Polynomial:
        """The derivative on a cell; by the chain rule, where the velocities are those of the states.

        Raises:
            RejectedError: where a derivative by the root w of order q is no multiple of ``Abs(w)**(q - 1)``.
        """
        if self.scaled:
            return super().along(field, function, domain, sign_of)
        slopes = [function.derivative(k).times(domain.radius / width) for k, width in enumerate(domain.widths)]
        for name, order in self.roots.items():
            k, root = self.states.index(name), Root(domain.place[f"root_{name}"], order)
            slope = slopes[k].divided(root.speed(sign_of))
            require(slope is not None, f"a function with a derivative by {name}")
            slopes[k] = slope or constant(self.count, 0)
        return sum((slope * part for slope, part in zip(slopes, field, strict=True)), constant(self.count, 0))

    def across(self, field: Sequence[Polynomial], surface: Polynomial, domain: Domain) -> Polynomial:
        """How solutions cross a surface; the zero of a root they cross as the state does.

        Raises:
            RejectedError: for another surface that depends on a root, where the velocities are those of the states.
        """
        for name in () if self.scaled else self.roots:
            k = self.states.index(name)
            if surface.divided(domain.place[f"root_{name}"]) is not None and surface.degree == 1:
                return field[k]
            require(not surface.derivative(k), "surfaces that are zeros of roots, or about other states")
        scaled = [part.times(domain.radius / width) for part, width in zip(field, domain.widths, strict=True)]
        return super().across(scaled, surface, domain)

    def bends_at(self, surface: Polynomial, domain: Domain) -> bool:
        """Whether it is the zero of a root of even order w, as ``w**2`` is that of ``Abs(x)``."""
        even = [name for name, order in self.roots.items() if not (self.scaled or order % 2)]
        return any(surface.divided(domain.place[f"root_{name}"]) is not None for name in even)


def read_subject(data: Any) -> System:
    """The system that a certificate is about, with roots or without."""
    if type(data) is not dict or "roots" not in data:
        return read_system(data)
    states, rhs, at, listed, orders, numbers, order = take(data, "states rhs at roots", "orders numbers order")
    stated = {"states": states, "rhs": rhs, "at": at, "numbers": [] if numbers is None else numbers, "order": order}
    plain_system = read_system(stated)
    system = RootedSystem(**vars(plain_system), roots=read_roots(listed, orders, plain_system.states))
    require(order is not None or not any(map(any, system.waves)), "an order of sines and cosines beside roots")
    require(len(set(system.coordinates)) == system.count, "names of roots that are no states")
    require(not set(system.coordinates) & set(plain_system.numbers), "names of numbers that are no roots")
    return system


def read_roots(listed: Any, order_data: Any, states: Sequence[str]) -> dict[str, int]:
    """The states of which there are roots, each with the order of its root; two where none are given."""
    roots = tuple(items(listed, most=len(states)))
    known = all(type(name) is str and name in states for name in roots)
    require(roots and known and len(set(roots)) == len(roots), "roots of different states")
    squares = [2] * len(roots)
    orders = [whole(order, MAX_ORDER) for order in items(squares if order_data is None else order_data, len(roots))]
    require(min(orders) >= 2, "roots of an order of two at least")
    return dict(zip(roots, orders, strict=True))


def in_roots(system: System, data: Any) -> RootedSystem:
    """The same system, in its own time, for functions of the signed roots of some states, whose orders are given.

    Raises:
        RejectedError: for names of roots that mean something else.
    """
    require(type(data) is dict, "orders of roots by the names of states")
    roots = read_roots(list(data), list(data.values()), system.states)
    values = {attribute.name: getattr(system, attribute.name) for attribute in fields(System)}
    rooted_system = RootedSystem(**values, roots=roots, scaled=False)
    require(len(set(rooted_system.coordinates)) == rooted_system.count, "names of roots that are no states")
    require(not set(rooted_system.coordinates) & set(system.numbers), "names of numbers that are no roots")
    return rooted_system


def signed_root(value: Coefficient, order: int) -> Fraction:
    """``sign(x) Abs(x)**(1/q)``, which must be rational."""
    require(isinstance(value, Fraction), "a point whose roots are rational")
    root = Fraction(whole_root(abs(value.numerator), order), whole_root(value.denominator, order))
    require(root**order == abs(value), "a point whose roots are rational")
    return root if value > 0 else -root


def whole_root(value: int, order: int) -> int:
    """The largest whole number of which the power is not above the value, by halving."""
    low, high = 0, 1 << (value.bit_length() // order + 1)
    while high - low > 1:
        BUDGET.spend(1 + value.bit_length() ** 2 // 4096)
        middle = (low + high) // 2
        low, high = (middle, high) if middle**order <= value else (low, middle)
    return low


class Root(NamedTuple):
    """A signed root w as a polynomial, and its order."""

    value: Polynomial
    order: int

    def size(self, sign_of: SignOf) -> Polynomial:
        """``Abs(w)``, on a cell."""
        return self.value.times(sign_of(self.value))

    def speed(self, sign_of: SignOf) -> Polynomial:
        """``q Abs(w)**(q - 1)``."""
        return self.size(sign_of).power(self.order - 1).times(self.order)


class RootedFormula(Formula):
    """A right-hand side in the signed roots, times the factors ``q Abs(w)**(q - 1)`` of some of them."""

    def __init__(
        self,
        data: Any,
        place: Mapping[str, Polynomial],
        ends: Sequence[int],
        wave: WaveAt,
        roots: Mapping[str, Root],
        factors: Sequence[str],
    ) -> None:
        super().__init__(data, place, ends, wave)
        root_values = [root.value for root in roots.values()]
        self.states = {name: polynomial for name, polynomial in place.items() if polynomial not in root_values}
        self.roots, self.factors = roots, factors
        # a root is another polynomial on each side of zero
        self.smooth = parts_without_calls(self.tree, tuple(roots))

    def on(self, sign_of: SignOf) -> Polynomial:
        """The polynomial on a cell."""
        value = super().on(sign_of)
        for name in self.factors:
            value *= self.roots[name].speed(sign_of)
        return value

    def _value(self, node: ast.expr, sign_of: SignOf, depth: int) -> Polynomial:
        """The polynomial of a part, of which some are known of the roots."""
        match node:
            case ast.Name(id=name) if name in self.roots:
                root = self.roots[name]
                return root.value * root.size(sign_of).power(root.order - 1)
            case ast.Call(func=ast.Name(id="sqrt"), args=[inner], keywords=[]):
                return self._root_of(inner, Fraction(1, 2), sign_of)
            case ast.BinOp(left=inner, op=ast.Pow(), right=ast.BinOp(left=top, op=ast.Div(), right=bottom)):
                return self._root_of(inner, Fraction(self._whole(top), self._whole(bottom)), sign_of)
        return super()._value(node, sign_of, depth)

    def _whole(self, node: ast.expr) -> int:
        """A number in an exponent ``p/q``."""
        written = self.text[node.col_offset : node.end_col_offset]
        require(re.fullmatch("[1-9][0-9]?", written), "whole numbers in exponents p/q")
        return int(written)

    def _root_of(self, node: ast.expr, power: Fraction, sign_of: SignOf) -> Polynomial:
        """``Abs(x)**(p/q)``."""
        match node:
            case ast.Call(func=ast.Name(id="Abs"), args=[ast.Name(id=name)], keywords=[]) if name in self.roots:
                root = self.roots[name]
                whole_power = power * root.order
                require(whole_power.denominator == 1, "powers of the roots that are listed")
                return root.size(sign_of).power(int(whole_power))
            case ast.Call(func=ast.Name(id="Abs"), args=[ast.Name(id=name)], keywords=[]) if self._is_number(name):
                value = signed_root(self.states[name].at_origin, power.denominator)
                return constant(self.count, abs(value) ** power.numerator)
        raise RejectedError("roots of Abs of states that are listed")

    def _is_number(self, name: str) -> bool:
        """Whether a state is replaced by its coordinate of the point, as those are that drive a part."""
        return name in self.states and not self.states[name].degree


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
            cell_speeds = (formula.on(partial(surfaces.sign_on, cell.signs)) for formula in formulas)
            speeds.update(((tuple(guards.items()), zero.restricted(speed)), None) for speed in cell_speeds)
    for (i, (first, a)), (j, (second, b)) in combinations_with_replacement(enumerate(speeds), 2):
        both = {**dict(first), **{f"{name}'": guard for name, guard in second}}
        name = f"crosses {k} speeds {i} {j}"
        surfaces.proofs.show(Claim(name, (Inequality(a * b, both),), True, not zero.holds_origin, domain.bounded))
