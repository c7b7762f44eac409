"""The value of a formula in floats, by walking its tree: nothing is evaluated as text, and floats only propose."""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping

from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.messages.scene_error import shown

_FUNCTIONS: dict[str, Callable[..., float]] = {
    "sin": math.sin,
    "cos": math.cos,
    "sqrt": math.sqrt,
    "Abs": abs,
    "Max": max,
    "max": max,
    "Min": min,
    "min": min,
    "sign": lambda a: float((a > 0) - (a < 0)),
    "sgn": lambda a: float((a > 0) - (a < 0)),
    "relu": lambda a: max(a, 0.0),
    "sat": lambda a, low, high: max(low, min(high, a)),
}
_OPERATORS: dict[type[ast.operator], Callable[[float, float], float]] = {
    ast.Add: lambda a, b: a + b,
    ast.Sub: lambda a, b: a - b,
    ast.Mult: lambda a, b: a * b,
    ast.Div: lambda a, b: a / b,
    ast.Pow: lambda a, b: float(a**b),
}


def float_value(node: ast.expr, values: Mapping[str, float], text: str) -> float:
    """The value of a part of a formula.

    Args:
        node: the part.
        values: of the states.
        text: the whole formula, for messages.

    Raises:
        ExpressionError: for anything that is no formula of the states, and where there is no finite value.
    """
    try:
        match node:
            case ast.Constant(value=int() | float() as number):
                return float(number)
            case ast.Name(id=name):
                return math.pi if name == "pi" else values[name]
            case ast.UnaryOp(op=ast.UAdd() | ast.USub()):
                inner = float_value(node.operand, values, text)
                return -inner if isinstance(node.op, ast.USub) else inner
            case ast.BinOp():
                sides = (float_value(side, values, text) for side in (node.left, node.right))
                return _OPERATORS[type(node.op)](*sides)
            case ast.Call(func=ast.Name(id=name), keywords=[]):
                return _FUNCTIONS[name](*(float_value(argument, values, text) for argument in node.args))
    except (KeyError, TypeError, ValueError, ArithmeticError):
        pass
    raise ExpressionError(f"required a formula of the states with a finite value, received {shown(text)}")
