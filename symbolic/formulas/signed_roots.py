"""Square roots of states, ``sqrt(Abs(x))``: formulas in the signed root ``z = sgn(x) sqrt(Abs(x))`` instead of x.

With ``x = z Abs(z)`` and ``sqrt(Abs(x)) = Abs(z)`` formulas are polynomials in z on each cell, and ``x' = f`` is
``2 Abs(z) z' = f``.  In the time s with ``dt = 2 Abs(z) ds`` super-twisting, ``x' = -a sqrt(Abs(x)) sgn(x) + y``,
``y' = -b sgn(x)``, is linear: ``dz/ds = y - a z``, ``dy/ds = -2 b z``.  Where this is sound:
:mod:`nonsmooth.proofs.systems.system_stability`.  Formulas are rewritten as text, part by part of their trees.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

from nonsmooth.symbolic.formulas.expression import ExpressionError, parse_tree
from nonsmooth.symbolic.formulas.piecewise import MAX_TEXT
from nonsmooth.symbolic.formulas.sine_enclosures import has_waves
from nonsmooth.symbolic.messages.scene_error import shown


@dataclass(frozen=True)
class SignedRoots:
    """Which states stand under a square root.

    Attributes:
        states: the names of all.
        rooted: the others' names left out, in their order.
    """

    states: tuple[str, ...]
    rooted: tuple[str, ...]

    @property
    def names(self) -> dict[str, str]:
        """The name of the root of each rooted state."""
        return {name: f"root_{name}" for name in self.rooted}

    @property
    def seen_states(self) -> tuple[str, ...]:
        """The states with roots in place of what is rooted."""
        return tuple(self.names.get(name, name) for name in self.states)

    @property
    def meanings(self) -> tuple[str, ...]:
        """What each root is."""
        return tuple(f"{root} = sgn({name})*sqrt(Abs({name}))" for name, root in self.names.items())

    @property
    def time_scale(self) -> str:
        """The factor by which time passes slower, ``dt`` over ``ds``."""
        return "*".join(f"2*Abs({root})" for root in self.names.values())

    def seen(self, formula: object) -> object:
        """A formula in the roots; what is no text stays as it is."""
        return self._rewritten(formula, lambda x: f"({x}*Abs({x}))", lambda x: f"Abs({x})")

    def seen_field(self, formula: object, place: int) -> object:
        """The right-hand side of a state in the roots and in the time s."""
        others = [f"*(2*Abs({root}))" for name, root in self.names.items() if name != self.states[place]]
        return f"({self.seen(formula)}){''.join(others)}" if isinstance(formula, str) or others else formula

    def extended(self, formula: object) -> object:
        """A formula in which each ``sqrt(Abs(x))`` is a further state, for solutions to be followed."""
        return self._rewritten(formula, None, lambda x: x)

    def restored(self, text: str) -> str:
        """An extended formula as it was stated."""
        for name, root in self.names.items():
            text = re.sub(rf"\b{re.escape(root)}\b", f"sqrt(Abs({name}))", text)
        return text

    def _rewritten(self, formula: object, state: Callable[[str], str] | None, root: Callable[[str], str]) -> object:
        """A formula with rooted states and their roots replaced, by what stands for each."""
        if not isinstance(formula, str):
            return formula
        text, tree = parse_tree(formula, MAX_TEXT, "a formula")
        data, end, written = text.encode(), len(text.encode()), b""
        for node, name, is_root in sorted(_places(tree, self.rooted), key=lambda p: -_offset(text, p[0])):
            replaced = root(self.names[name]) if is_root else state(self.names[name]) if state else name
            first, last = _offset(text, node), _end(text, node)
            written, end = replaced.encode() + data[last:end] + written, first
        return (data[:end] + written).decode()


def rooted_in(formula: object, states: Sequence[str]) -> set[str]:
    """The states that stand under a square root in a formula.

    Raises:
        ExpressionError: for a square root of anything else that holds a state.
    """
    try:
        text, tree = parse_tree(formula, MAX_TEXT, "a formula")
    except ExpressionError:
        return set()  # refused where formulas are read
    found: set[str] = set()
    for node in ast.walk(tree):
        if _is_call(node, "sqrt") and _names(node) & set(states):
            name = _under_root(node)
            if name not in states:
                expected = f"square roots of Abs of a state, such as sqrt(Abs({states[0]}))"
                raise ExpressionError(f"required {expected}, received {shown(text)}")
            found.add(str(name))
    return found


def refuse_waves_of_rooted(formula: object, rooted: Sequence[str]) -> None:
    """Refuse sines and cosines of states that stand under a root: they are no polynomials of it on both sides of zero.

    Raises:
        ExpressionError: for such a formula.
    """
    if not has_waves(formula):
        return
    text, tree = parse_tree(formula, MAX_TEXT, "a formula")
    for node in ast.walk(tree):
        if (_is_call(node, "sin") or _is_call(node, "cos")) and _names(node) & set(rooted):
            expected = f"sin and cos of states without a square root, as {', '.join(rooted)} stands under sqrt(Abs())"
            raise ExpressionError(f"required {expected}, received {shown(text)}")


def _places(tree: ast.AST, rooted: Sequence[str]) -> Iterator[tuple[ast.expr, str, bool]]:
    """Every rooted state outside of its root, and every root, with the state's name."""
    waiting = [tree]
    while waiting:
        node = waiting.pop()
        name = _under_root(node)
        if isinstance(node, ast.Call) and name in rooted:
            yield node, str(name), True
        elif isinstance(node, ast.Name) and node.id in rooted:
            yield node, node.id, False
        else:
            waiting += ast.iter_child_nodes(node)


def _under_root(node: ast.AST) -> str | None:
    """The state under a root, x of ``sqrt(Abs(x))``; None for anything else."""
    if not (isinstance(node, ast.Call) and _is_call(node, "sqrt")):
        return None
    inner = node.args[0]
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
