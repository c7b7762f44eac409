"""SymPy's expressions as formulas of a scene file.

``Piecewise`` takes the first condition that holds, as in SymPy; what is stated on a border itself is ignored, as
everywhere (Filippov 1988, sec. 4).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fractions import Fraction
from itertools import product
from typing import TYPE_CHECKING, Any, TypeAlias

from nonsmooth.reports.exchange.reading import Reading, fraction_text
from nonsmooth.symbolic.formulas.formula_text import (
    ONE,
    ZERO,
    complement,
    difference_text,
    disjunction,
    first_that_holds,
    in_parentheses,
    indicator,
    product_text,
    sum_text,
)
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.formulas.trees import ExpressionError

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
    lists = [side for side in sides if isinstance(side, Sequence | MatrixBase) and not isinstance(side, str)]
    if isinstance(rhs, MatrixBase) or not lists:
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


# ---- systems of nosnoc ---------------------------------------------------------------------------
#
# nosnoc's piecewise smooth systems ``x' = F(x) theta``: switching functions c, sign matrix S, fields F in columns.
#
# Region i is where ``S_ij c_j(x) > 0`` for all j; an entry 0 says that c_j does not count. Several triples (c, S, F)
# are independent, and their fields are added, as in nosnoc (Nurkanovic and Diehl 2022).


MAX_SURFACES = 12  # of one S, which has a row for each of at most 2^12 patterns of signs


def formulas_of_nosnoc(states: Any, c: Any, signs: Any, fields: Any, reading: Reading) -> tuple[list[str], list[str]]:
    """The names of the states, and one formula for each.

    Args:
        states: names, symbols of SymPy, or a vector of CasADi's symbols; c and F are in them.
        c: switching functions; or a list of such lists.
        signs: S, a row of -1, 0, 1 for each mode; or a list of such matrices.
        fields: F, a row for each state with a formula for each mode; or a list of such matrices.
        reading: how numbers are read.

    Raises:
        SceneError: for shapes that do not fit, and where the rows of S do not meet each pattern of signs exactly once.
    """
    several = _depth(signs) > 2
    triples = list(zip(c, signs, fields, strict=True)) if several else [(c, signs, fields)]
    names: list[str] = []
    sums: list[list[str]] = []
    for surfaces, sign_rows, columns in triples:
        names, switching = _formulas(states, surfaces, "c", reading)
        rows = [list(map(int, row)) for row in _checked_signs(sign_rows, len(switching), reading)]
        flat, count = _flat(columns, len(names), len(rows), reading)
        _, written = _formulas(states, flat, "F", reading)
        table = [written[k * count : (k + 1) * count] for k in range(len(names))]
        _require_smooth(switching, names, reading)
        sums.append(_mixed(switching, rows, table))
    return names, [sum_text(list(parts)) for parts in zip(*sums, strict=True)]


def _depth(value: Any) -> int:
    """How deep lists are nested: two for a matrix."""
    return 1 + _depth(value[0]) if hasattr(value, "__len__") and len(value) and not isinstance(value, str) else 0


def _formulas(states: Any, expressions: Any, key: str, reading: Reading) -> tuple[list[str], list[str]]:
    """Names and formulas, by the door of the library that the states come from."""
    if type(states).__module__.startswith("casadi"):
        from nonsmooth.reports.exchange.from_matrices import formulas_of_casadi

        return formulas_of_casadi(expressions, states, {}, reading)
    from nonsmooth.reports.exchange.from_sympy import SympyFormulas

    walker = SympyFormulas({state: getattr(state, "name", str(state)) for state in states}, reading)
    return list(walker.names.values()), walker.read(list(expressions), key).written


def _flat(columns: Any, states: int, modes: int, reading: Reading) -> tuple[Any, int]:
    """The entries of F row by row, and how many a row has."""
    shape = getattr(columns, "shape", None) or (len(columns), len(columns[0]))
    if tuple(shape) != (states, modes):
        expected = f"{states} rows and {modes} columns, a state and a row of S each"
        raise reading.refused("F", expected, f"{shape[0]} x {shape[1]}")
    if type(columns).__module__.startswith("casadi"):
        return columns.T.reshape((states * modes, 1)), modes
    if any(len(row) != modes for row in (columns.tolist() if hasattr(columns, "tolist") else columns)):
        raise reading.refused("F", f"{modes} entries in each row", "rows of other lengths")
    rows = columns.tolist() if hasattr(columns, "tolist") else columns
    return [entry for row in rows for entry in row], modes


def _checked_signs(signs: Any, surfaces: int, reading: Reading) -> list[list[Any]]:
    """The rows of S, of which exactly one holds for each pattern of signs."""
    rows = [list(row) for row in signs]
    if surfaces > MAX_SURFACES or any(len(row) != surfaces for row in rows):
        expected = f"a column for each of the {surfaces} switching functions (at most {MAX_SURFACES})"
        raise reading.refused("S", expected, f"rows of {sorted({len(row) for row in rows})}")
    if any(value not in (-1, 0, 1) for row in rows for value in row):
        raise reading.refused("S", "entries -1, 0 or 1", rows)
    for pattern in product((1, -1), repeat=surfaces):
        held = sum(all(s in (0, p) for s, p in zip(row, pattern, strict=True)) for row in rows)
        if held != 1:
            expected = "rows of which exactly one holds for each pattern of signs"
            raise reading.refused("S", expected, f"{held} for the signs {list(pattern)}")
    return rows


def _require_smooth(switching: Sequence[str], names: Sequence[str], reading: Reading) -> None:
    """Refuse switching functions that switch themselves: one could be zero on a whole cell, where no region is."""
    for k, text in enumerate(switching, 1):
        try:
            parsed = parse_piecewise(text, names)
        except ExpressionError as error:
            raise reading.refused(
                f"c[{k}]", "a formula of the states", str(error).partition(", received ")[2]
            ) from None
        if parsed.switching_parts:
            raise reading.refused(f"c[{k}]", "a switching function without sign, Abs, Max and Min", text)


def _mixed(switching: Sequence[str], rows: Sequence[Sequence[int]], table: Sequence[Sequence[str]]) -> list[str]:
    """``sum_i theta_i F_ki`` for each state k, theta_i a product of factors of truth."""
    positive = [indicator(in_parentheses(surface)) for surface in switching]
    truths = []
    for row in rows:
        factors = [{1: truth, -1: complement(truth), 0: ONE}[s] for s, truth in zip(row, positive, strict=True)]
        truths.append(product_text(factors))
    return [
        sum_text([product_text([truth, in_parentheses(field)]) for truth, field in zip(truths, row, strict=True)])
        for row in table
    ]
