"""Smaller systems with the same answers: without shifts that change no velocity, and without sums that are conserved.

*Translations.*  Where ``f(x + s e) = f(x)`` for every number s, equilibria form lines along e, and no point attracts.
With ``e_p = 1`` the differences ``y_i = x_i - e_i x_p`` have a field of their own,

    y_i' = f_i(y) - e_i f_p(y),    f at the place whose x_p is zero,

and a point attracts y where the line of it along e attracts x.  The map is linear and onto, and surfaces are the same
along e as f is, so that Filippov's sets are mapped onto those of the smaller field.  Agents that agree, and oscillators
that synchronize, are seen by their differences.

*Conserved sums.*  Where ``w . f = 0`` every plane ``w . x = c`` is invariant, and on that of the checked point x_p
follows from the other states.  Filippov's set at a place of the plane is that of the whole space if all cells next to
the place are met by the plane there.  So it is where shifts e with ``w . e != 0`` are along all surfaces on which f
jumps: points of a cell are shifted onto the plane and stay in the cell.  Reactions and compartments that lose nothing
are seen this way.

Both are found by linear algebra: a formula is a polynomial in the states and in values of functions, such as
``sgn(b - a)``, which count as further unknowns.  What is found holds exactly; relations between values of functions,
such as ``sin(x)**2 + cos(x)**2 = 1``, are not looked for.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

from flint import Ordering, fmpq, fmpq_mat, fmpq_mpoly, fmpq_mpoly_ctx

from nonsmooth.symbolic.formulas.trees import (
    ONE,
    OPERATIONS,
    ZERO,
    Interpretation,
    formula_tree,
    literal_value,
    multiplied,
    number,
    tidied,
    total,
    with_names,
    written,
)
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polytopes import Vector, solutions
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Trees: TypeAlias = tuple[ast.expr, ...]

REDUCIBLE = "a field that is the same along a line, or that conserves a weighted sum of states, in two states or more"


@dataclass(frozen=True)
class ReducedSystem:
    """A smaller system, and what its states are.

    Attributes:
        states: their names, each that of a state of the larger system.
        lists: the right-hand sides; several under arbitrary switching.
        point: the checked point.
        meaning: a sentence for each step.
    """

    states: tuple[str, ...]
    lists: tuple[Trees, ...]
    point: tuple[Number, ...]
    meaning: tuple[str, ...] = ()

    def document(self, name: str, radius: Number) -> dict[str, Any]:
        """The tables of a scene file, with the half-width of what is checked."""
        lists = [list(map(_text, sides)) for sides in self.lists]
        stated = {"states": list(self.states), "rhs": lists if len(lists) > 1 else lists[0]}
        check = {"equilibrium": list(map(str, self.point)), "radius": str(radius)}
        return {"name": name, "description": "; ".join(self.meaning), "system": stated, "check": check}


def reduce_system(system: SwitchedSystem) -> ReducedSystem:
    """The smaller system without translations and conserved sums.

    Raises:
        SceneError: where there are neither, nothing would be left, or formulas are too long.
    """
    lists = tuple(tuple(map(formula_tree, sides)) for sides in system.stated_lists)
    whole = reduced = ReducedSystem(system.stated_states, lists, system.stated_point)
    try:
        while (smaller := _without_translations(reduced) or _without_sums(reduced)) is not None:
            reduced = smaller
    except _TooLongError:
        raise SceneError(system.origin, "system.rhs", "shorter formulas", StatedFact("products of many sums")) from None
    if reduced is whole:
        raise SceneError(system.origin, "system.rhs", REDUCIBLE, StatedFact("another"))
    return reduced


def _without_translations(system: ReducedSystem) -> ReducedSystem | None:
    """The system of differences; None where every shift changes a velocity, or none does."""
    field, count = _Field(system), len(system.states)
    shifts = field.shifts(*field.velocities, *field.arguments.values())
    if len(shifts) in (0, count):
        return None
    removed = {_last(e): e for e in shifts}
    kept = [i for i in range(count) if i not in removed]

    def difference(i: int, values: Sequence[ast.expr]) -> ast.expr:
        return _collected(total([values[i], *(_times(-e[i], values[p]) for p, e in removed.items())]))

    zeros = {system.states[p]: ZERO for p in removed}
    at_zero = [[tidied(with_names(side, zeros)) for side in sides] for sides in system.lists]
    lists = tuple(tuple(difference(i, sides) for i in kept) for sides in at_zero)
    points = [
        sum((system.point[p] * as_fraction(-e[i]) for p, e in removed.items()), start=system.point[i]) for i in kept
    ]
    names = [ast.Name(name) for name in system.states]
    meanings = [
        f"{system.states[i]} stands for {_text(difference(i, names))}" for i in kept if any(e[i] for e in shifts)
    ]
    meanings += [f"{system.states[p]} is left out" for p, e in removed.items() if sum(map(bool, e)) == 1]
    along = " and ".join(f"({', '.join(map(str, e))})" for e in shifts)
    sentence = f"velocities are the same along {along}: {', '.join(meanings)}"
    return ReducedSystem(tuple(system.states[i] for i in kept), lists, tuple(points), (*system.meaning, sentence))


def _without_sums(system: ReducedSystem) -> ReducedSystem | None:
    """The system on the planes of the checked point; None where no sum is conserved, or all states are."""
    field, count = _Field(system), len(system.states)
    sums = field.conserved()
    if len(sums) == count:
        return None
    shifts = field.shifts(*field.jumping())
    chosen: list[Vector] = []
    for weights in sums:
        if _rank([*chosen, weights], shifts) > len(chosen):
            chosen.append(weights)
    if not chosen:
        return None
    meanings, sentences = dict[str, ast.expr](), []
    for weights in chosen:
        p = _last(weights)
        products = [_times(w, ast.Name(name)) for w, name in zip(weights, system.states, strict=True)]
        value = sum((x * as_fraction(w) for w, x in zip(weights, system.point, strict=True)), system.point[p] * 0)
        others = [_times(-w, ast.Name(name)) for w, name in zip(weights[:p], system.states[:p], strict=True)]
        last = system.states[p]
        meanings[last] = total([formula_tree(str(value)), *others])
        sentences.append(f"{_text(total(products))} is conserved: {last} is {_text(meanings[last])}")
    kept = [i for i, name in enumerate(system.states) if name not in meanings]
    lists = tuple(tuple(with_names(sides[i], meanings) for i in kept) for sides in system.lists)
    states, point = tuple(system.states[i] for i in kept), tuple(system.point[i] for i in kept)
    return ReducedSystem(states, lists, point, (*system.meaning, *sentences))


def _last(vector: Vector) -> int:
    """The number of the last entry that is not zero."""
    return max(i for i, entry in enumerate(vector) if entry)


def _rank(rows: Sequence[Vector], columns: Sequence[Vector]) -> int:
    """That of the products of rows and columns."""
    products = [[sum((a * b for a, b in zip(row, column, strict=True)), fmpq(0)) for column in columns] for row in rows]
    return int(fmpq_mat(products).rank()) if columns else 0


def _times(factor: fmpq, tree: ast.expr) -> ast.expr:
    return multiplied(number(as_fraction(factor)), tree)


def _text(tree: ast.expr) -> str:
    return written(tidied(tree))


def _collected(tree: ast.expr) -> ast.expr:
    """A sum in which equal terms stand once: ``b - a + s - b`` is ``s - a``."""
    factors, terms = dict[str, Fraction](), dict[str, ast.expr]()
    for factor, term in _terms(tree, Fraction(1)):
        text = written(term)
        factors[text], terms[text] = factors.get(text, Fraction(0)) + factor, term
    positive_first = sorted(factors, key=lambda text: factors[text] < 0)
    return total(multiplied(number(factors[text]), terms[text]) for text in positive_first)


def _terms(tree: ast.expr, factor: Fraction) -> Iterator[tuple[Fraction, ast.expr]]:
    """The terms of a sum, with their factors."""
    match tree:
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            yield from _terms(tree.left, factor)
            yield from _terms(tree.right, factor if isinstance(tree.op, ast.Add) else -factor)
        case ast.UnaryOp(op=ast.USub()):
            yield from _terms(tree.operand, -factor)
        case ast.BinOp(left=ast.Constant() as multiple, op=ast.Mult()):
            yield from _terms(tree.right, factor * literal_value(multiple))
        case ast.BinOp(op=ast.Div(), right=ast.Constant() as divisor):
            yield from _terms(tree.left, factor / literal_value(divisor))
        case ast.Constant():
            yield factor * literal_value(tree), ONE
        case _:
            yield factor, tree


# ---- polynomials in the states and in values of functions ----------------------------------------


MOST_TERMS = 20_000  # of a product, before equal ones are added up
JUMPING = ("sgn", "1/", "**")  # all other functions are continuous


class _TooLongError(Exception):
    """Formulas whose products have too many terms."""


class _Field:
    """All right-hand sides of a system as polynomials.

    Attributes:
        velocities: one polynomial for each right-hand side and state.
        arguments: of each function that they hold, by the number of its unknown.
    """

    def __init__(self, system: ReducedSystem) -> None:
        sides = [side for sides in system.lists for side in sides]
        parts = [node for side in sides for node in ast.walk(side) if isinstance(node, ast.Call | ast.BinOp)]
        distinct = {written(node): node for node in parts}.values()
        most = sum(len(node.args) if isinstance(node, ast.Call) else 1 for node in distinct)
        names = (*system.states, *(f"#{k}" for k in range(most + 1)))  # the last one is pi
        context = fmpq_mpoly_ctx.get(names, Ordering.lex)
        self._count, self._unknowns = len(system.states), context.gens()
        self._numbers: dict[tuple[str, str], int] = {}
        self._names: dict[int, str] = {}
        self.arguments: dict[int, fmpq_mpoly] = {}
        meaning = Interpretation(
            lambda value: context.constant(as_fmpq(value)),
            self._unknowns[-1],
            {
                **{name: self._named(name) for name in ("sin", "cos", "tanh", "atan", "exp", "sqrt")},
                "sgn": self._sign,
                "Abs": lambda a: 2 * self._positive_part(a) - a,
                "Max": lambda a, b: b + self._positive_part(a - b),
                "Min": lambda a, b: a - self._positive_part(a - b),
            },
            {
                **OPERATIONS,
                ast.Mult: _product,
                ast.Div: lambda a, b: _product(a, self._inverse(b)),
                ast.Pow: self._power,
                ast.USub: lambda a: -a,
            },
        )
        states = dict(zip(system.states, self._unknowns, strict=False))
        self.velocities: list[fmpq_mpoly] = [meaning.value(side, states) for side in sides]

    # ---- linear equations --------------------------------------------------------------------------

    def shifts(self, *polynomials: fmpq_mpoly) -> list[Vector]:
        """Directions that span all e with ``e . grad p = 0`` for these polynomials, in which functions are constant."""
        rows: list[list[fmpq]] = []
        for polynomial in polynomials:
            rows += _coefficients([polynomial.derivative(i) for i in range(self._count)])
        return _null_space(rows, self._count)

    def conserved(self) -> list[Vector]:
        """Weights w that span all with ``w . f = 0`` for each right-hand side."""
        rows: list[list[fmpq]] = []
        for first in range(0, len(self.velocities), self._count):
            rows += _coefficients(self.velocities[first : first + self._count])
        return _null_space(rows, self._count)

    def jumping(self) -> list[fmpq_mpoly]:
        """The arguments of all functions that jump, and of the functions in these."""
        waiting, jumping = [k for k, name in self._names.items() if name.startswith(JUMPING)], set[int]()
        while waiting:
            k = waiting.pop()
            if k not in jumping:
                jumping.add(k)
                waiting += [j for j in self.arguments if self.arguments[k].derivative(self._count + j)]
        return [self.arguments[k] for k in jumping]

    # ---- values of functions -----------------------------------------------------------------------
    #
    # Arguments have a positive first coefficient, of one where factors can be taken out: sgn(2*b - 2*a) is -sgn(a - b).

    def _value(self, name: str, argument: fmpq_mpoly) -> fmpq_mpoly:
        k = self._numbers.setdefault((name, str(argument)), len(self._numbers))
        self._names[k], self.arguments[k] = name, argument
        return self._unknowns[self._count + k]

    def _named(self, name: str) -> Callable[[fmpq_mpoly], fmpq_mpoly]:
        def value(argument: fmpq_mpoly) -> fmpq_mpoly:
            if name in ("exp", "sqrt") or argument.leading_coefficient() >= 0:
                return self._value(name, argument)
            return self._value(name, -argument) * (1 if name == "cos" else -1)

        return value

    def _sign(self, argument: fmpq_mpoly) -> fmpq_mpoly:
        first = argument.leading_coefficient()
        if argument.is_constant():
            return argument * 0 + (first > 0) - (first < 0)
        return self._value("sgn", argument / first) * (1 if first > 0 else -1)

    def _positive_part(self, argument: fmpq_mpoly) -> fmpq_mpoly:
        """``max(a, 0)``, which is ``a + max(-a, 0)``."""
        first = argument.leading_coefficient()
        if argument.is_constant():
            return argument * (first > 0)
        part = self._value("max", argument / first) * abs(first)
        return part if first > 0 else part + argument

    def _inverse(self, argument: fmpq_mpoly) -> fmpq_mpoly:
        first = argument.leading_coefficient()
        if argument.is_constant():
            return argument * 0 + 1 / first
        return self._value("1/", argument / first) / first

    def _power(self, base: fmpq_mpoly, exponent: int | fmpq_mpoly) -> fmpq_mpoly:
        if isinstance(exponent, int):
            if len(base) ** exponent > MOST_TERMS and len(base) > 1:
                raise _TooLongError
            return base**exponent
        value = exponent.leading_coefficient()
        if value.q == 1:
            return self._power(base if value >= 0 else self._inverse(base), abs(int(value)))
        return self._value(f"**{value}", base)


def _product(left: fmpq_mpoly, right: fmpq_mpoly) -> fmpq_mpoly:
    """Raises _TooLongError for too many terms."""
    if len(left) * len(right) > MOST_TERMS:
        raise _TooLongError
    return left * right


def _coefficients(polynomials: Sequence[fmpq_mpoly]) -> list[list[fmpq]]:
    """A row for each monomial: its coefficients in all polynomials."""
    terms = [polynomial.to_dict() for polynomial in polynomials]
    monomials = dict.fromkeys(exponents for one in terms for exponents in one)
    return [[one.get(exponents, fmpq(0)) for one in terms] for exponents in monomials]


def _null_space(rows: Iterable[list[fmpq]], count: int) -> list[Vector]:
    """Vectors that span all x with ``row . x = 0``; in the place of its last entry, a one, all others are zero."""
    solved = solutions([[*row, fmpq(0)] for row in rows], count)
    return solved[1] if solved else []
