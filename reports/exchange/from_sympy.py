"""SymPy's expressions as formulas of a scene file.

``Piecewise`` takes the first condition that holds, as in SymPy; what is stated on a border itself is ignored, as
everywhere (Filippov 1988, sec. 4).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.reports.exchange.reading import Reading, fraction_text
from nonsmooth.symbolic.formulas.formula_text import (
    ONE,
    ZERO,
    complement,
    difference_text,
    disjunction,
    first_that_holds,
    indicator,
    product_text,
    sum_text,
)

if TYPE_CHECKING:
    import sympy

Names: TypeAlias = Mapping[Any, str]  # of symbols, and of functions of time such as x(t)

DOUBLE_BITS = 53
ALLOWED = "states, parameters, numbers, + - * /, powers, sqrt, sin, cos, tanh, atan, exp, Abs, sign, Max, "
ALLOWED += "Min, Heaviside and Piecewise"

FUNCTIONS: dict[str, Callable[..., str]] = {
    "sqrt": "sqrt({})".format,
    "sin": "sin({})".format,
    "cos": "cos({})".format,
    "tanh": "tanh({})".format,
    "atan": "atan({})".format,
    "exp": "exp({})".format,
    "Abs": "Abs({})".format,
    "sign": "sgn({})".format,
    "Heaviside": "((1 + sgn({}))/2)".format,
}  # of one argument, as formulas write them


def formulas_of_sympy(states: Sequence[Any], rhs: Any, parameters: Sequence[Any], reading: Reading) -> SympyFormulas:
    """The names of the states, and the right-hand sides as formulas in them.

    Args:
        states: symbols, functions of time such as ``x(t)``, or names.
        rhs: one expression for each state, or a matrix of them; or several lists (arbitrary switching).
        parameters: symbols or names of numbers that are named.
        reading: how numbers are read.

    Raises:
        SceneError: for an expression that is no formula of the states.
    """
    from sympy import MatrixBase

    names = {symbol: _name(symbol) for symbol in (*states, *parameters)}
    walker = SympyFormulas(names, reading)
    sides = list(rhs)
    if isinstance(rhs, MatrixBase) or not any(isinstance(side, Sequence | MatrixBase) for side in sides):
        return walker.read(sides)
    walker.written = [walker.read(list(side), f"rhs[{j}]").written for j, side in enumerate(sides, 1)]
    return walker


def _name(symbol: Any) -> str:
    """What a state or a parameter is called: ``x`` for ``Symbol("x")`` and for ``Function("x")(t)``."""
    name = getattr(symbol, "name", None) or getattr(getattr(symbol, "func", None), "__name__", None)
    return str(symbol if name is None else name)


class SympyFormulas:
    """Writes expressions as formulas in named states.

    Attributes:
        written: one formula for each state, or several lists of them.
    """

    def __init__(self, names: Names, reading: Reading) -> None:
        self.names, self.reading, self.key = names, reading, ""
        self.written: list[Any] = []
        self.seen: dict[str, Any] = {}  # the symbol behind each name

    def read(self, sides: Sequence[Any], key: str = "rhs") -> SympyFormulas:
        """Write one right-hand side."""
        self.written = [self.formula(side, f"{key}[{k}]") for k, side in enumerate(sides, 1)]
        return self

    def formula(self, expression: Any, key: str) -> str:
        """The text of one expression; a text is taken as it is.

        Raises:
            SceneError: for an expression that is no formula.
        """
        from sympy import Basic

        if isinstance(expression, str):
            return expression
        self.key = key
        if not isinstance(expression, Basic):
            return self.reading.number(expression, key)
        return self.reading.require_short(self._text(expression), key)

    def _text(self, node: sympy.Basic) -> str:
        import sympy

        match node:
            case sympy.Rational():
                return fraction_text(Fraction(int(node.p), int(node.q)))
            case sympy.Float():
                return fraction_text(self._exact_float(node))
            case sympy.Symbol() | sympy.core.function.AppliedUndef():
                return self._named(node)
            case sympy.Add():
                return sum_text([self._text(part) for part in node.args])
            case sympy.Mul():
                return product_text([self._text(part) for part in node.args])
            case sympy.Pow():
                return self._power(node)
            case sympy.Max() | sympy.Min():
                return f"{node.func.__name__}({', '.join(map(self._text, node.args))})"
            case sympy.Piecewise():
                return self._piecewise(node)
        if node is sympy.S.Pi:
            return "pi"
        name = type(node).__name__
        if name in FUNCTIONS and (len(node.args) == 1 or name == "Heaviside"):
            return FUNCTIONS[name](self._text(node.args[0]))
        raise self.reading.refused(self.key, ALLOWED, name)

    def _exact_float(self, node: sympy.Float) -> Fraction:
        """The binary number that it is, or its shortest decimal."""
        if self.reading.decimals:
            return Fraction(repr(float(node)) if node._prec <= DOUBLE_BITS else str(node))
        sign, mantissa, exponent, _ = node._mpf_
        return Fraction(-1 if sign else 1) * int(mantissa) * Fraction(2) ** int(exponent)

    def _named(self, node: Any) -> str:
        """The name of a state or parameter; two different symbols of one name are refused."""
        name = self.names.get(node) or self.names.get(_name(node))
        if name is None:
            raise self.reading.refused(self.key, f"symbols out of {', '.join(self.names.values())}", f"{node!s}")
        if self.seen.setdefault(name, node) != node:
            raise self.reading.refused(self.key, "one symbol of each name", f"two different ones named {name}")
        return name

    def _power(self, node: sympy.Pow) -> str:
        """Whole powers, their quotients, powers of square roots, and other powers that are rational."""
        exponent = node.exp
        if not exponent.is_Rational:
            raise self.reading.refused(self.key, "rational exponents", f"{exponent!s}")
        base, size, order = self._text(node.base), abs(int(exponent.p)), int(exponent.q)
        if order > 2:
            power = f"({base}**({size}/{order}))"
        else:
            root = base if order == 1 else f"sqrt({base})"
            power = root if size == 1 else f"({root}**{size})"
        return power if exponent.p > 0 else f"(1/{power})"

    # ---- conditions ------------------------------------------------------------------------------

    def _piecewise(self, node: sympy.Piecewise) -> str:
        """``1_1 f_1 + (1 - 1_1)(...)``, where some condition holds everywhere but on borders."""
        from sympy import Or, S

        *first, (last, condition) = node.args
        choices = [(self._truth(where), self._text(value)) for value, where in first]
        if Or(*(where for _, where in first), _with_border(condition)) is not S.true:
            raise self.reading.refused(self.key, "a Piecewise whose last condition is True", f"{condition!s}")
        return first_that_holds(choices, self._text(last))

    def _truth(self, condition: Any) -> str:
        """1 where a condition holds, else 0."""
        import sympy

        match condition:
            case sympy.Gt() | sympy.Ge() | sympy.Lt() | sympy.Le():
                guard = difference_text(self._text(condition.gts), self._text(condition.lts))
                return indicator(guard, strict=isinstance(condition, sympy.Gt | sympy.Lt))
            case sympy.And():
                return product_text([self._truth(part) for part in condition.args])
            case sympy.Or():
                return disjunction([self._truth(part) for part in condition.args])
            case sympy.Not():
                return complement(self._truth(condition.args[0]))
        if condition in (sympy.S.true, sympy.S.false):
            return ONE if condition is sympy.S.true else ZERO
        raise self.reading.refused(self.key, "conditions of < <= > >=, And, Or, Not", f"{condition!s}")


def _with_border(condition: Any) -> Any:
    """The condition ``g >= 0`` for ``g > 0``, where g is a polynomial that is not zero; any other as it is."""
    from sympy import Ge, Gt, Le, Lt, expand

    if not isinstance(condition, Gt | Lt):
        return condition
    guard = expand(condition.lhs - condition.rhs)
    if guard == 0 or not guard.is_polynomial(*guard.free_symbols):
        return condition  # it may be zero on whole cells
    return (Ge if isinstance(condition, Gt) else Le)(*condition.args)
