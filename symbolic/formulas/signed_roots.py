"""Roots of states, ``sqrt(Abs(x))`` and ``Abs(x)**(p/q)``: formulas in the signed root ``z = sgn(x) Abs(x)**(1/q)``.

The *order* q of a state is the least common denominator of the powers of ``Abs(x)``.  With ``x = z Abs(z)**(q - 1)``
and ``Abs(x)**(p/q) = Abs(z)**p`` formulas are polynomials in z on each cell, and ``x' = f`` is
``q Abs(z)**(q - 1) z' = f``.  In the time s with ``dt = q Abs(z)**(q - 1) ds`` super-twisting,
``x' = -a sqrt(Abs(x)) sgn(x) + y``, ``y' = -b sgn(x)``, is linear: ``dz/ds = y - a z``, ``dy/ds = -2 b z``.  Where
this is sound: :mod:`nonsmooth.proofs.systems.system_stability`.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any

from flint import fmpz

from nonsmooth.symbolic.formulas.expression import parse
from nonsmooth.symbolic.formulas.trees import (
    MAX_TEXT,
    ExpressionError,
    called,
    formula_tree,
    is_call,
    multiplied,
    names_of,
    number,
    parse_tree,
    power,
    replaced,
    with_names,
    written,
)
from nonsmooth.symbolic.messages.scene_error import shown

MAX_ORDER = 8  # of a root: states are polynomials of that degree in it


@dataclass(frozen=True)
class SignedRoots:
    """Which states stand under a root.

    Attributes:
        states: the names of all.
        rooted: the others' names left out, in their order.
        orders: the order of the root of each of these.
        parameters: what is known of names in exponents, as formulas.
    """

    states: tuple[str, ...]
    rooted: tuple[str, ...]
    orders: tuple[int, ...]
    parameters: tuple[tuple[str, str], ...] = ()

    @property
    def names(self) -> dict[str, str]:
        """The name of the root of each rooted state."""
        return {name: f"root_{name}" for name in self.rooted}

    @property
    def order(self) -> dict[str, int]:
        """The order of the root of each rooted state."""
        return dict(zip(self.rooted, self.orders, strict=True))

    @property
    def seen_states(self) -> tuple[str, ...]:
        """The states with roots in place of what is rooted."""
        return tuple(self.names.get(name, name) for name in self.states)

    @property
    def meanings(self) -> tuple[str, ...]:
        """What each root is."""
        return tuple(f"{root} = sgn({name})*{self.root_text(name)}" for name, root in self.names.items())

    def root_of(self, name: str, whole: int = 1) -> ast.expr:
        """A power of the size of a root as a formula of its state."""
        exponent, size = Fraction(whole, self.order[name]), called("Abs", ast.Name(name))
        return called("sqrt", size) if exponent == Fraction(1, 2) else power(size, exponent)

    def root_text(self, name: str) -> str:
        """The size of a root as a formula of its state."""
        return written(self.root_of(name))

    def stated(self, name: str, value: Any) -> Any:
        """The value of a state, of which the root is known where it stands under one: ``z Abs(z)**(q - 1)``."""
        return value * abs(value) ** (self.order[name] - 1) if name in self.rooted else value

    @property
    def time_scale(self) -> str:
        """The factor by which time passes slower, ``dt`` over ``ds``."""
        return written(multiplied(*self._speeds(self.rooted)))

    def _speeds(self, names: Iterable[str]) -> Iterator[ast.expr]:
        """The factors of ``q Abs(z)**(q - 1)`` of some roots: how fast a state moves beside its root."""
        for name in names:
            yield number(self.order[name])
            yield power(self._size(name), self.order[name] - 1)

    def _size(self, name: str) -> ast.expr:
        return called("Abs", ast.Name(self.names[name]))

    def seen(self, formula: object) -> object:
        """A formula in the roots; what is no text stays as it is."""

        def in_roots(state: str, exponent: Fraction | None) -> ast.expr:
            order = self.order[state]
            if exponent is None:
                return multiplied(ast.Name(self.names[state]), power(self._size(state), order - 1))
            return power(self._size(state), int(exponent * order))

        return self._rewritten(formula, in_roots)

    def seen_field(self, formula: object, place: int) -> object:
        """The right-hand side of a state in the roots and in the time s."""
        others = list(self._speeds(name for name in self.rooted if name != self.states[place]))
        side = self.seen(formula)
        with suppress(ExpressionError):  # refused where formulas are read
            return written(multiplied(*others, formula_tree(side))) if others else side
        return side

    def extended(self, formula: object) -> object:
        """A formula in which the size of each root is a further state, for solutions to be followed."""

        def with_sizes(state: str, exponent: Fraction | None) -> ast.expr:
            if exponent is None:
                return ast.Name(state)
            return power(ast.Name(self.names[state]), int(exponent * self.order[state]))

        return self._rewritten(formula, with_sizes)

    def restored(self, text: str) -> str:
        """An extended formula as it was stated."""
        states = {root: name for name, root in self.names.items()}

        def change(node: ast.expr) -> ast.expr | None:
            match node:
                case ast.BinOp(left=ast.Name(id=root), op=ast.Pow(), right=ast.Constant(value=int(whole))):
                    return self.root_of(states[root], whole) if root in states else None
                case ast.Name(id=root) if root in states:
                    return self.root_of(states[root])
            return None

        return written(replaced(formula_tree(text), change))

    def _rewritten(self, formula: object, meaning: Callable[[str, Fraction | None], ast.expr]) -> object:
        """A formula with other trees for each rooted state, and for each power of its size.

        What cannot be read stays as it is, for who reads it to refuse.
        """
        if not isinstance(formula, str):
            return formula
        parameters = dict(self.parameters)

        def change(node: ast.expr) -> ast.expr | None:
            exponent, state = _fractional_power(node, parameters), _state_of(node)
            if exponent is not None and state in self.rooted:
                return meaning(state, exponent)
            return meaning(node.id, None) if isinstance(node, ast.Name) and node.id in self.rooted else None

        with suppress(ExpressionError):
            return written(replaced(formula_tree(formula), change))
        return formula


def signed_root(value: Fraction, order: int) -> Fraction:
    """``sgn(a) Abs(a)**(1/q)``.

    Raises:
        ValueError: where that is not rational.
    """
    size = abs(value)
    root = Fraction(int(fmpz(size.numerator).root(order)), int(fmpz(size.denominator).root(order)))
    if root**order != size:
        raise ValueError(f"required a number with a rational root of order {order}, received {value}")
    return root if value > 0 else -root


def orders_in(formula: object, states: Sequence[str], parameters: Mapping[str, str]) -> dict[str, int]:
    """The states that stand under a root in a formula, each with the least common denominator of its powers.

    Raises:
        ExpressionError: for a root of anything else that holds a state, and for powers that are not positive or have
            large denominators.
    """
    try:
        text, tree = parse_tree(formula, MAX_TEXT, "a formula")
    except ExpressionError:
        return {}  # refused where formulas are read
    orders: dict[str, int] = {}
    for node in ast.walk(tree):
        exponent = _fractional_power(node, parameters)
        if exponent is None or names_of(node).isdisjoint(states):
            continue
        name = _state_of(node)
        if name not in states:
            from nonsmooth.symbolic.formulas.norms import squares_in

            values = {parameter: formula_tree(value) for parameter, value in parameters.items()}
            if exponent.denominator == 2 and squares_in(with_names(_radicand(node), values), states):
                continue  # a norm (:mod:`nonsmooth.symbolic.formulas.norms`)
            kind = "square roots" if is_call(node, "sqrt") else "roots"
            example = f"sqrt(Abs({states[0]}))" if is_call(node, "sqrt") else f"Abs({states[0]})**({exponent})"
            squares = [f"{state}**2" for state in states[:2]] if len(states) > 1 else ["1", f"{states[0]}**2"]
            norm = f"sqrt({' + '.join(squares)})"
            expected = f"{kind} of Abs of a state, such as {example}, or of a sum of squares, such as {norm}"
            raise ExpressionError(f"required {expected}, received {shown(text)}")
        order = lcm(orders.get(name, 1), exponent.denominator)
        if exponent <= 0 or order > MAX_ORDER:
            expected = f"powers of Abs({name}) above 0, with a common denominator up to {MAX_ORDER}"
            raise ExpressionError(f"required {expected}, received {shown(text)}")
        orders[name] = order
    return orders


def _fractional_power(node: ast.AST, parameters: Mapping[str, str]) -> Fraction | None:
    """The exponent of a square root, or of a power that is not whole; None for anything else."""
    if is_call(node, "sqrt"):
        return Fraction(1, 2)
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)):
        return None
    try:
        values = {name: formula_tree(parameters[name]) for name in names_of(node.right) & parameters.keys()}
        exponent, in_pi = parse(written(with_names(node.right, values))).parts_in_pi()
    except ExpressionError:
        return None  # refused where formulas are read
    return None if in_pi or exponent.denominator == 1 else exponent


def _radicand(node: ast.AST) -> ast.expr:
    """What a root is of."""
    match node:
        case ast.Call(args=[inner]) | ast.BinOp(left=inner):
            return inner
    raise TypeError(f"required a root, received {ast.dump(node)}")


def _state_of(node: ast.AST) -> str:
    """The state of ``sqrt(Abs(x))`` or ``Abs(x)**(p/q)``; empty for anything else."""
    match node:
        case (
            ast.Call(args=[ast.Call(func=ast.Name(id="Abs"), args=[ast.Name(id=name)], keywords=[])])
            | ast.BinOp(left=ast.Call(func=ast.Name(id="Abs"), args=[ast.Name(id=name)], keywords=[]))
        ):
            return name
    return ""
