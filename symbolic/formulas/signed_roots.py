"""Roots of states, ``sqrt(Abs(x))`` and ``Abs(x)**(p/q)``: formulas in the signed root ``z = sgn(x) Abs(x)**(1/q)``.

The *order* q of a state is the least common denominator of the powers of ``Abs(x)``.  With ``x = z Abs(z)**(q - 1)``
and ``Abs(x)**(p/q) = Abs(z)**p`` formulas are polynomials in z on each cell, and ``x' = f`` is
``q Abs(z)**(q - 1) z' = f``.  In the time s with ``dt = q Abs(z)**(q - 1) ds`` super-twisting,
``x' = -a sqrt(Abs(x)) sgn(x) + y``, ``y' = -b sgn(x)``, is linear: ``dz/ds = y - a z``, ``dy/ds = -2 b z``.  Where
this is sound: :mod:`nonsmooth.proofs.systems.system_stability`.  Formulas are rewritten as text, part by part of their
trees.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import lcm
from typing import Any, NamedTuple

from flint import fmpz

from nonsmooth.symbolic.formulas.expression import ExpressionError, parse, parse_tree
from nonsmooth.symbolic.formulas.piecewise import MAX_TEXT
from nonsmooth.symbolic.messages.scene_error import shown

MAX_ORDER = 8  # of a root: states are polynomials of that degree in it
_NAME = re.compile(r"\b[A-Za-z]\w*")


class StatePower(NamedTuple):
    """A part ``Abs(x)**power`` of a formula; x itself, where there is no power."""

    node: ast.expr
    state: str
    power: Fraction | None


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

    def root_text(self, name: str, power: int = 1) -> str:
        """A power of the size of a root as a formula of its state."""
        exponent = Fraction(power, self.order[name])
        if exponent == Fraction(1, 2):
            return f"sqrt(Abs({name}))"
        if exponent.denominator == 1:
            return f"Abs({name})**{exponent}"
        return f"Abs({name})**({exponent})"

    def stated(self, name: str, value: Any) -> Any:
        """The value of a state, of which the root is known where it stands under one: ``z Abs(z)**(q - 1)``."""
        return value * abs(value) ** (self.order[name] - 1) if name in self.rooted else value

    @property
    def time_scale(self) -> str:
        """The factor by which time passes slower, ``dt`` over ``ds``."""
        return "*".join(map(self._speed, self.rooted))

    def _speed(self, name: str) -> str:
        """``q Abs(z)**(q - 1)``: how fast a state moves beside its root."""
        return f"{self.order[name]}*{_power(f'Abs({self.names[name]})', self.order[name] - 1)}"

    def seen(self, formula: object) -> object:
        """A formula in the roots; what is no text stays as it is."""
        return self._rewritten(formula, self._in_roots)

    def _in_roots(self, part: StatePower) -> str:
        size, order = f"Abs({self.names[part.state]})", self.order[part.state]
        if part.power is None:
            return f"({self.names[part.state]}*{_power(size, order - 1)})"
        whole = int(part.power * order)
        return size if whole == 1 else f"({size}**{whole})"

    def seen_field(self, formula: object, place: int) -> object:
        """The right-hand side of a state in the roots and in the time s."""
        others = [f"*({self._speed(name)})" for name in self.rooted if name != self.states[place]]
        return f"({self.seen(formula)}){''.join(others)}" if isinstance(formula, str) or others else formula

    def extended(self, formula: object) -> object:
        """A formula in which the size of each root is a further state, for solutions to be followed."""
        return self._rewritten(formula, self._with_sizes)

    def _with_sizes(self, part: StatePower) -> str:
        if part.power is None:
            return part.state
        whole = int(part.power * self.order[part.state])
        return self.names[part.state] if whole == 1 else f"({self.names[part.state]}**{whole})"

    def restored(self, text: str) -> str:
        """An extended formula as it was stated."""
        for name, root in self.names.items():
            sizes = re.compile(rf"\({root}\*\*([0-9]+)\)|\b{root}\b(?: *\*\* *([0-9]+))?")
            text = sizes.sub(lambda found, name=name: self.root_text(name, int(found[1] or found[2] or 1)), text)  # type: ignore[misc]
        return text

    def _rewritten(self, formula: object, replaced: Callable[[StatePower], str]) -> object:
        """A formula with rooted states and powers of their sizes replaced."""
        if not isinstance(formula, str):
            return formula
        text, tree = parse_tree(formula, MAX_TEXT, "a formula")
        data, end, written = text.encode(), len(text.encode()), b""
        places = _places(tree, text, self.rooted, dict(self.parameters))
        for part in sorted(places, key=lambda own: -_offset(text, own.node)):
            first, last = _offset(text, part.node), _end(text, part.node)
            written, end = replaced(part).encode() + data[last:end] + written, first
        return (data[:end] + written).decode()


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


def _power(base: str, exponent: int) -> str:
    return base if exponent == 1 else f"{base}**{exponent}"


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
    found: dict[str, int] = {}
    for node in ast.walk(tree):
        power = _fractional_power(node, text, parameters)
        if power is None or not _names(node) & set(states):
            continue
        name = _state_of(node)
        if name not in states:
            kind = "square roots" if _is_call(node, "sqrt") else "roots"
            example = f"sqrt(Abs({states[0]}))" if _is_call(node, "sqrt") else f"Abs({states[0]})**({power})"
            raise ExpressionError(f"required {kind} of Abs of a state, such as {example}, received {shown(text)}")
        order = lcm(found.get(str(name), 1), power.denominator)
        if power <= 0 or order > MAX_ORDER:
            expected = f"powers of Abs({name}) above 0, with a common denominator up to {MAX_ORDER}"
            raise ExpressionError(f"required {expected}, received {shown(text)}")
        found[str(name)] = order
    return found


def _places(tree: ast.AST, text: str, rooted: Sequence[str], parameters: Mapping[str, str]) -> Iterator[StatePower]:
    """Every rooted state outside of its roots, and every root."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        power = _fractional_power(node, text, parameters)
        if isinstance(node, ast.expr) and power is not None and _state_of(node) in rooted:
            yield StatePower(node, str(_state_of(node)), power)
        elif isinstance(node, ast.Name) and node.id in rooted:
            yield StatePower(node, node.id, None)
        else:
            waiting += ast.iter_child_nodes(node)


def _fractional_power(node: ast.AST, text: str, parameters: Mapping[str, str]) -> Fraction | None:
    """The exponent of a square root, or of a power that is not whole; None for anything else."""
    if _is_call(node, "sqrt"):
        return Fraction(1, 2)
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow)):
        return None
    written = ast.get_source_segment(text, node.right) or ""
    if written.isdecimal():
        return None
    known = _NAME.sub(lambda name: f"({parameters.get(name[0], name[0])})", written)
    try:
        exponent, in_pi = parse(known).parts_in_pi()
    except ExpressionError:
        return None  # refused where formulas are read
    return None if in_pi or exponent.denominator == 1 else exponent


def _state_of(node: ast.AST) -> str | None:
    """The state of ``sqrt(Abs(x))`` or ``Abs(x)**(p/q)``; None for anything else."""
    inner = node.args[0] if isinstance(node, ast.Call) else node.left if isinstance(node, ast.BinOp) else None
    if not (isinstance(inner, ast.Call) and _is_call(inner, "Abs") and isinstance(inner.args[0], ast.Name)):
        return None
    return inner.args[0].id


def _is_call(node: ast.AST, name: str) -> bool:
    """Whether a part is a function of that name with one argument."""
    if not (isinstance(node, ast.Call) and isinstance(node.func, ast.Name)):
        return False
    return node.func.id == name and len(node.args) == 1 and not node.keywords


def _names(node: ast.AST) -> set[str]:
    return {part.id for part in ast.walk(node) if isinstance(part, ast.Name)}


def _offset(text: str, node: ast.expr) -> int:
    """Where a part begins, in bytes."""
    return _bytes_before(text, node.lineno) + node.col_offset


def _end(text: str, node: ast.expr) -> int:
    return _bytes_before(text, node.end_lineno or node.lineno) + (node.end_col_offset or 0)


def _bytes_before(text: str, line: int) -> int:
    return sum(len(part.encode()) for part in text.splitlines(keepends=True)[: line - 1])
