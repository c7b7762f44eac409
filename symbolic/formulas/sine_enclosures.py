"""Sines and cosines of states between polynomials: a formula as the hull of several without them.

For every real v the alternating series enclose, with some e between 0 and 1 that depends on v,

    sin v = v - v^3/6 + e v^5/120,    cos v = 1 - v^2/2 + v^4/24 - e v^6/720.

(For v >= 0 integrate ``cos <= 1`` again and again from 0; sin is odd, cos is even.)  So they lie between later sums,
too: the *order* says how many further terms are taken, where the first ones cancel against others.  A formula of sums
and products in which every sine and cosine stands alone is affine in each e, so its value lies in the hull of its
values with all e at 0 or 1.  Equal sines that are multiplied get an e each.  A system becomes one under arbitrary
switching, whose solutions hold those of the system: what is proved of all of them is proved of these.  Multiples of pi
may be added to v.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from math import factorial

from nonsmooth.symbolic.formulas.expression import ExpressionError, parse_tree, turn_of
from nonsmooth.symbolic.formulas.piecewise import MAX_TEXT
from nonsmooth.symbolic.messages.scene_error import shown

WAVES = ("sin", "cos")
MAX_WAVES = 5  # in one right-hand side: two to this power polynomials
_OPERATORS: dict[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}
_NUMBERS = {"pi", "sqrt", *WAVES}


@dataclass(frozen=True)
class Wave:
    """A sine or cosine that is enclosed.

    Attributes:
        kind: which of the two.
        argument: v, which must vanish at the checked point.
        name: what stands for it in a formula; empty where a polynomial does.
    """

    kind: str
    argument: str
    name: str = ""


@dataclass
class Template:
    """Formulas in which sines and cosines of states are written as polynomials with a place for each e.

    Attributes:
        waves: one for each e.
        order: further terms of each.
    """

    waves: list[Wave] = field(default_factory=list)
    order: int = 0

    def sine(self, v: str) -> str:
        """``sin v`` with a new e."""
        return self._alternating("sin", v, [v], 1, 2)

    def cosine(self, v: str) -> str:
        """``cos v`` with a new e."""
        return self._alternating("cos", v, ["1"], 0, 3)

    def _alternating(self, kind: str, v: str, terms: list[str], first: int, last: int) -> str:
        """The sum up to a number of terms beyond the first, the last one times e."""
        for k in range(1, last + self.order + 1):
            weight = f"{self._place(kind, v)}*" if k == last + self.order else ""
            power = first + 2 * k
            terms += ["-" if k % 2 else "+", f"{weight}{v}**{power}/{factorial(power)}"]
        return f"({' '.join(terms)})"

    def _place(self, kind: str, v: str) -> str:
        self.waves.append(Wave(kind, v))
        return f"<{len(self.waves) - 1}>"


@dataclass
class NamedTemplate(Template):
    """Formulas in which sines and cosines of states are names, equal ones with one name.

    Attributes:
        taken: names that mean something else.
    """

    taken: frozenset[str] = frozenset()

    def sine(self, v: str) -> str:
        """The name of ``sin v``."""
        return self._named("sin", v)

    def cosine(self, v: str) -> str:
        """The name of ``cos v``."""
        return self._named("cos", v)

    def _named(self, kind: str, v: str) -> str:
        for wave in self.waves:
            if (wave.kind, wave.argument) == (kind, v):
                return wave.name
        name = f"{kind}_{len(self.waves) + 1}"
        while name in self.taken:
            name += "_"
        self.waves.append(Wave(kind, v, name))
        return name


def named_formulas(formulas: Sequence[object], taken: frozenset[str]) -> tuple[tuple[object, ...], tuple[Wave, ...]]:
    """Formulas with a name in place of each sine and cosine of states, and what these names mean.

    Args:
        formulas: with a sine or cosine of states in some of them.
        taken: names that mean something else.

    Raises:
        ExpressionError: as for :func:`enclosing_formulas`.
    """
    template = NamedTemplate(taken=taken)
    written = tuple(_template(formula, template) if has_waves(formula) else formula for formula in formulas)
    return written, tuple(template.waves)


def in_place_of_names(formula: str, meanings: Mapping[str, str]) -> str:
    """A formula with texts in place of the names of its sines and cosines."""
    named = re.compile(rf"\b({'|'.join(map(re.escape, meanings))})\b")
    return named.sub(lambda own: meanings[own[0]], formula)


def has_waves(formula: object) -> bool:
    """Whether a text holds a sine or cosine of something with a name."""
    if not isinstance(formula, str):
        return False
    try:
        tree = parse_tree(formula, MAX_TEXT, "a formula")[1]
    except ExpressionError:
        return False
    return any(map(_is_wave, ast.walk(tree)))


def enclosing_formulas(formulas: Sequence[object], order: int = 0) -> tuple[list[tuple[object, ...]], tuple[Wave, ...]]:
    """Lists of formulas without sines and cosines of states, whose hull holds the given one, and what is enclosed.

    The lists are in the order of the values of all e, 0 before 1, the last one fastest.

    Args:
        formulas: one for each state.
        order: further terms of each sine and cosine.

    Raises:
        ExpressionError: for a sine or cosine of states that does not stand in sums and products only, for one inside
            another, and for too many of them.
    """
    template = Template(order=order)
    written = [_template(formula, template) if has_waves(formula) else formula for formula in formulas]
    count = len(template.waves)
    if count > MAX_WAVES:
        raise ExpressionError(f"required at most {MAX_WAVES} sines and cosines of states, received {count}")
    return [tuple(_filled(w, e) for w in written) for e in product("01", repeat=count)], tuple(template.waves)


def _filled(formula: object, values: Sequence[str]) -> object:
    if not isinstance(formula, str):
        return formula
    for k, value in enumerate(values):
        formula = formula.replace(f"<{k}>", value)
    return formula


def _template(formula: object, template: Template) -> str:
    text, tree = parse_tree(formula, MAX_TEXT, "a formula")
    return _written(tree, text, template)


def _written(node: ast.expr, text: str, template: Template) -> str:
    """A part of a formula as text; parts without waves as they were."""
    if not any(map(_is_wave, ast.walk(node))):
        return f"({ast.get_source_segment(text, node)})"
    match node:
        case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
            return f"({'-' if isinstance(node.op, ast.USub) else ''}{_written(node.operand, text, template)})"
        case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(count))) if 1 <= count <= MAX_WAVES:
            return "(" + "*".join(_written(node.left, text, template) for _ in range(count)) + ")"
        case ast.BinOp() if type(node.op) in _OPERATORS and not _divides_by_wave(node):
            left, right = (_written(side, text, template) for side in (node.left, node.right))
            return f"({left} {_OPERATORS[type(node.op)]} {right})"
        case ast.Call(func=ast.Name(id=name), args=[argument]) if name in WAVES:
            if any(map(_is_wave, ast.walk(argument))):
                raise ExpressionError(f"required no sine or cosine inside another, received {shown(text)}")
            return _wave(name, argument, text, template)
    raise ExpressionError(f"required sin and cos of states in sums and products only, received {shown(text)}")


def _wave(name: str, argument: ast.expr, text: str, template: Template) -> str:
    """``sin(v + t pi)`` or ``cos(v + t pi)`` by the addition theorem; parts with coefficient zero are left out."""
    parts, turn = _parts(argument, text)
    v = f"({' '.join(parts)})"
    turn = turn if name == "sin" else turn + Fraction(1, 2)  # cos u = sin(u + pi/2)
    exact = {Fraction(0): (1, 0), Fraction(1, 2): (0, 1), Fraction(1): (-1, 0), Fraction(3, 2): (0, -1)}
    along: object
    across: object
    if turn % 2 in exact:
        along, across = exact[turn % 2]
    else:
        along, across = (f"{f}({turn.numerator}*pi/{turn.denominator})" for f in ("cos", "sin"))
    terms = [f"{c}*{wave}" for c, wave in _waves(v, along, across, template)]
    return f"({' + '.join(terms)})"


def _waves(v: str, along: object, across: object, template: Template) -> list[tuple[object, str]]:
    found = []
    if along:
        found.append((along, template.sine(v)))
    if across:
        found.append((across, template.cosine(v)))
    return found


def _parts(node: ast.expr, text: str, side: str = "+") -> tuple[list[str], Fraction]:
    """The terms of a sum without pi, with signs, and the multiple of pi of the others."""
    other = "-" if side == "+" else "+"
    match node:
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            left = _parts(node.left, text, side)
            right = _parts(node.right, text, side if isinstance(node.op, ast.Add) else other)
            return left[0] + right[0], left[1] + right[1]
        case ast.UnaryOp(op=ast.USub()):
            return _parts(node.operand, text, other)
    if _names(node) or not _holds_pi(node):
        return [f"{side} ({ast.get_source_segment(text, node)})"], Fraction(0)
    turn = turn_of(node, text)
    return [], turn if side == "+" else -turn


def _holds_pi(node: ast.expr) -> bool:
    return any(isinstance(part, ast.Name) and part.id == "pi" for part in ast.walk(node))


def _is_wave(node: ast.AST) -> bool:
    """Whether a part is a sine or cosine of something with a name."""
    named = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in WAVES
    return named and isinstance(node, ast.Call) and any(_names(argument) for argument in node.args)


def _names(node: ast.expr) -> bool:
    return any(isinstance(part, ast.Name) and part.id not in _NUMBERS for part in ast.walk(node))


def _divides_by_wave(node: ast.BinOp) -> bool:
    return isinstance(node.op, ast.Div) and any(map(_is_wave, ast.walk(node.right)))
