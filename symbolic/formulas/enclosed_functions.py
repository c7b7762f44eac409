"""Sines and cosines, tanh, atan and exp of states between polynomials: a formula as the hull of several without them.

For every real v the alternating series enclose, with some e between 0 and 1 that depends on v,

    sin v = v - v^3/6 + e v^5/120,    cos v = 1 - v^2/2 + v^4/24 - e v^6/720,
    tanh v = v - v^3/3 + e 2 v^5/15,  atan v = v - v^3/3 + e v^5/5,  and exp v = 1 + v + e v^2/2 for v <= 0.

(For v >= 0 integrate ``cos <= 1`` again and again from 0; sin is odd, cos is even.  Likewise integrate ``exp <= 1``,
and ``1/(1 + t^2)`` between sums of its geometric series.  And ``tanh v`` is the sum over odd k of ``8 v/(k^2 pi^2 + 4
v^2)``, each between sums of its geometric series.)  So they lie between later sums, too: the *order* says how many
further terms are taken, where the first ones cancel against others.  A formula of sums and products in which every one
of them stands alone is affine in each e, so its value lies in the hull of its values with all e at 0 or 1.  Equal sines
that are multiplied get an e each.  A system becomes one under arbitrary switching, whose solutions hold those of the
system: what is proved of all of them is proved of these.  Multiples of pi may be added to the argument of a sine or
cosine.  Where the argument switches, as in ``exp(-abs(v))``, all of this holds on every cell with the polynomial that
it is there.

In other files *sines* (or *waves*) stand for all five functions, unless turns or angles are spoken of.
"""

from __future__ import annotations

import ast
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cache
from itertools import product
from math import factorial

from nonsmooth.symbolic.formulas.expression import turn_of
from nonsmooth.symbolic.formulas.trees import (
    MAX_TEXT,
    ONE,
    OPERATIONS,
    ZERO,
    ExpressionError,
    called,
    minus,
    multiplied,
    names_of,
    number,
    parse_tree,
    plus,
    power,
    quotient,
    readable_tree,
    tidied,
    total,
    with_names,
    written,
)
from nonsmooth.symbolic.messages.scene_error import shown

TURNING = ("sin", "cos")
TERMS = {"sin": 3, "cos": 4, "tanh": 3, "atan": 3, "exp": 3}  # of the series, the last one times e
WAVES = tuple(TERMS)
ONE_AT_ZERO = ("cos", "exp")
MAX_WAVES = 5  # in one right-hand side: two to this power polynomials
_NUMBERS = {"pi", "sqrt", *WAVES}
# The kinds of a norm (:mod:`nonsmooth.symbolic.formulas.norms`), of one over it, and of an entry of a unit vector.
NORM, INVERSE, UNIT = "sqrt", "rsqrt", "unit"
LISTED = "sin, cos, tanh, atan and exp"


@dataclass(frozen=True)
class Wave:
    """A sine, or another function, that is enclosed; or a norm, the square root of a sum of squares.

    Attributes:
        kind: its name.
        argument: v, which must vanish at the checked point; but what a root is of.
        name: what stands for it in a formula; empty where a polynomial does.
    """

    kind: str
    argument: str
    name: str = ""


@dataclass
class Template:
    """Formulas in which sines and the like of states are polynomials with a name for each e.

    Attributes:
        waves: one for each e.
        order: further terms of each.
    """

    waves: list[Wave] = field(default_factory=list)
    order: int = 0

    def wave(self, kind: str, v: ast.expr) -> ast.expr:
        """A function of v with a new e, which weighs the last term of the series."""
        *terms, (last, coefficient) = series(kind, TERMS[kind] + self.order)
        weighed = _term(last, coefficient, v, ast.Name(_weight(len(self.waves))))
        self.waves.append(Wave(kind, written(v)))
        return total([*(_term(exponent, c, v) for exponent, c in terms), weighed])


def _term(exponent: int, coefficient: Fraction, v: ast.expr, weight: ast.expr = ONE) -> ast.expr:
    """A term of a series."""
    size = abs(coefficient)
    term = multiplied(weight, number(size.numerator), power(v, exponent) if exponent else ONE)
    term = quotient(term, number(size.denominator))
    return term if coefficient > 0 else minus(term)


def _weight(k: int) -> str:
    """The name of an e, which is none in any file."""
    return f"<{k}>"


@dataclass
class NamedTemplate(Template):
    """Formulas in which sines and the like of states are names, equal ones with one name.

    Attributes:
        taken: names that mean something else.
    """

    taken: frozenset[str] = frozenset()

    def wave(self, kind: str, v: ast.expr) -> ast.expr:
        """The name of a function of v."""
        argument = written(v)
        for wave in self.waves:
            if (wave.kind, wave.argument) == (kind, argument):
                return ast.Name(wave.name)
        name = f"{kind}_{len(self.waves) + 1}"
        while name in self.taken:
            name += "_"
        self.waves.append(Wave(kind, argument, name))
        return ast.Name(name)


@cache
def series(kind: str, count: int) -> tuple[tuple[int, Fraction], ...]:
    """The first terms of the series of a function: powers and coefficients.

    Those of tanh follow from ``tanh' = 1 - tanh^2``.
    """
    if kind == "exp":
        return tuple((k, Fraction(1, factorial(k))) for k in range(count))
    if kind == "tanh":
        coefficients = [Fraction(1)]
        for k in range(1, count):
            coefficients.append(
                -sum((coefficients[i] * coefficients[k - 1 - i] for i in range(k)), Fraction(0)) / (2 * k + 1)
            )
        return tuple((2 * k + 1, c) for k, c in enumerate(coefficients))
    first = 0 if kind == "cos" else 1
    powers = range(first, first + 2 * count, 2)
    return tuple(
        (power, Fraction((-1) ** k, power if kind == "atan" else factorial(power))) for k, power in enumerate(powers)
    )


def named_formulas(formulas: Sequence[object], taken: frozenset[str]) -> tuple[tuple[object, ...], tuple[Wave, ...]]:
    """Formulas with a name in place of each sine and the like of states, and what these names mean.

    Args:
        formulas: with a sine or the like of states in some of them.
        taken: names that mean something else.

    Raises:
        ExpressionError: as for :func:`enclosing_formulas`.
    """
    template = NamedTemplate(taken=taken)
    named = tuple(written(_template(formula, template)) if has_waves(formula) else formula for formula in formulas)
    return named, tuple(template.waves)


def kinds_text(waves: Iterable[Wave]) -> str:
    """What functions of states a system has, in words: of sines and cosines, which turn into each other, both."""
    kinds = {wave.kind for wave in waves}
    named = [kind for kind in WAVES if kind in kinds or (kind in TURNING and not kinds.isdisjoint(TURNING))]
    *first, last = [*named, *([] if kinds.isdisjoint((NORM, INVERSE)) else ["roots of sums of squares"])]
    return f"{', '.join(first)} and {last}" if first else last


def has_waves(formula: object) -> bool:
    """Whether a text holds a sine or the like of something with a name."""
    tree = readable_tree(formula) if isinstance(formula, str) else None
    return tree is not None and any(map(_is_wave, ast.walk(tree)))


def enclosing_formulas(formulas: Sequence[object], order: int = 0) -> tuple[list[tuple[object, ...]], tuple[Wave, ...]]:
    """Lists of formulas without sines and the like of states, whose hull holds the given one, and what is enclosed.

    The lists are in the order of the values of all e, 0 before 1, the last one fastest.

    Args:
        formulas: one for each state.
        order: further terms of each series.

    Raises:
        ExpressionError: for a sine or the like of states that does not stand in sums and products only, for one inside
            another, for exp of what may be positive, and for too many of them.
    """
    template = Template(order=order)
    templates = [_template(formula, template) if has_waves(formula) else formula for formula in formulas]
    count = len(template.waves)
    if count > MAX_WAVES:
        raise ExpressionError(f"required at most {MAX_WAVES} of {LISTED} of states, received {count}")
    lists = []
    for chosen in product((ZERO, ONE), repeat=count):
        weights = {_weight(k): weight for k, weight in enumerate(chosen)}
        lists.append(
            tuple(_filled(formula, weights) if isinstance(formula, ast.expr) else formula for formula in templates)
        )
    return lists, tuple(template.waves)


def _filled(template: ast.expr, weights: Mapping[str, ast.expr]) -> str:
    """A formula with a number in place of each e."""
    return written(tidied(with_names(template, weights)))


def _template(formula: object, template: Template) -> ast.expr:
    text, tree = parse_tree(formula, MAX_TEXT, "a formula")
    return _without_waves(tree, text, template)


def _without_waves(node: ast.expr, text: str, template: Template) -> ast.expr:
    """A part of a formula; parts without waves as they were."""
    if not any(map(_is_wave, ast.walk(node))):
        return node
    match node:
        case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
            inner = _without_waves(node.operand, text, template)
            return minus(inner) if isinstance(node.op, ast.USub) else inner
        case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(count))) if 1 <= count <= MAX_WAVES:
            return multiplied(*(_without_waves(node.left, text, template) for _ in range(count)))
        case ast.BinOp() if type(node.op) in OPERATIONS and not _divides_by_wave(node):
            left, right = (_without_waves(side, text, template) for side in (node.left, node.right))
            return ast.BinOp(left, node.op, right)
        case ast.Call(func=ast.Name(id=name), args=[argument]) if name in WAVES:
            if any(map(_is_wave, ast.walk(argument))):
                raise ExpressionError(f"required none of {LISTED} inside another, received {shown(text)}")
            if name in TURNING:
                return _turned(name, argument, text, template)
            if name == "exp" and _sign(argument) != -1:
                expected = "exp of minus a sum of even powers and absolute values, such as exp(-x**2)"
                raise ExpressionError(f"required {expected}, received {shown(text)}")
            return template.wave(name, argument)
    raise ExpressionError(f"required {LISTED} of states in sums and products only, received {shown(text)}")


def _sign(node: ast.expr) -> int:
    """1 where a formula is seen to have no negative value, -1 where it has no positive one; 0 where that is not seen.

    It is a sum, product or quotient of even powers, absolute values and numbers.
    """
    match node:
        case ast.Constant() | ast.Call(func=ast.Name(id="Abs")):
            return 1
        case ast.BinOp(op=ast.Pow(), right=ast.Constant(value=int(exponent))) if exponent % 2 == 0:
            return 1
        case ast.UnaryOp(op=ast.USub()):
            return -_sign(node.operand)
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            right = _sign(node.right) * (1 if isinstance(node.op, ast.Add) else -1)
            return right if right == _sign(node.left) else 0
        case ast.BinOp(op=ast.Mult() | ast.Div()):
            return _sign(node.left) * _sign(node.right)
    return 0


def _turned(name: str, argument: ast.expr, text: str, template: Template) -> ast.expr:
    """``sin(v + t pi)`` or ``cos(v + t pi)`` by the addition theorem; parts with coefficient zero are left out."""
    parts, turn = _parts(argument, text)
    v = total(parts)
    turn = turn if name == "sin" else turn + Fraction(1, 2)  # cos u = sin(u + pi/2)
    exact = {Fraction(0): (1, 0), Fraction(1, 2): (0, 1), Fraction(1): (-1, 0), Fraction(3, 2): (0, -1)}
    if turn % 2 in exact:
        along, across = exact[turn % 2]
        kind, side = ("sin", along) if along else ("cos", across)
        return template.wave(kind, v) if side > 0 else minus(template.wave(kind, v))
    angle = quotient(multiplied(number(turn.numerator), ast.Name("pi")), number(turn.denominator))
    along_sine = multiplied(called("cos", angle), template.wave("sin", v))
    return plus(along_sine, multiplied(called("sin", angle), template.wave("cos", v)))


def _parts(node: ast.expr, text: str, side: int = 1) -> tuple[list[ast.expr], Fraction]:
    """The terms of a sum without pi, with signs, and the multiple of pi of the others."""
    match node:
        case ast.BinOp(op=ast.Add() | ast.Sub()):
            left = _parts(node.left, text, side)
            right = _parts(node.right, text, side if isinstance(node.op, ast.Add) else -side)
            return left[0] + right[0], left[1] + right[1]
        case ast.UnaryOp(op=ast.USub()):
            return _parts(node.operand, text, -side)
    if _names(node) or not _holds_pi(node):
        return [node if side > 0 else minus(node)], Fraction(0)
    return [], turn_of(node, text) * side


def _holds_pi(node: ast.expr) -> bool:
    return "pi" in names_of(node)


def _is_wave(node: ast.AST) -> bool:
    """Whether a part is a sine or the like of something with a name."""
    named = isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in WAVES
    return named and isinstance(node, ast.Call) and any(_names(argument) for argument in node.args)


def _names(node: ast.expr) -> bool:
    return not names_of(node).issubset(_NUMBERS)


def _divides_by_wave(node: ast.BinOp) -> bool:
    return isinstance(node.op, ast.Div) and any(map(_is_wave, ast.walk(node.right)))
