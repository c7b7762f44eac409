"""Programs with the field of a system and its V: Python and C, each complete by itself."""

from __future__ import annotations

import ast
from collections.abc import Callable
from fractions import Fraction

from nonsmooth.reports.exchange.formulas import FieldFormulas, Target
from nonsmooth.symbolic.scene_error import one_line

LARGEST_WHOLE = 2**53  # up to which whole numbers are doubles

_OPERATORS: dict[type, Callable[..., str]] = {
    ast.Add: "({} + {})".format,
    ast.Sub: "({} - {})".format,
    ast.Mult: "({} * {})".format,
    ast.Div: "({} / {})".format,
    ast.USub: "(-{})".format,
}


def _number(value: Fraction) -> str:
    """A double: a quotient of whole numbers where both are doubles, else the nearest."""
    if float(value) == value or max(abs(value.numerator), value.denominator) > LARGEST_WHOLE:
        return repr(float(value)) if value >= 0 else f"({float(value)!r})"
    return f"({value.numerator}.0 / {value.denominator}.0)"


def _target(names: dict[str, str], pi: str, power: Callable[..., str]) -> Target:
    functions = {name: f"{called}({{}})".format for name, called in names.items() if name not in ("Max", "Min")}
    functions |= {name: f"{names[name]}({{}}, {{}})".format for name in ("Max", "Min")}
    return Target(_number, pi, functions, {**_OPERATORS, ast.Pow: power})


PYTHON = _target(
    {"sgn": "sgn", "Abs": "abs", "sqrt": "sqrt", "sin": "sin", "cos": "cos", "Max": "max", "Min": "min"},
    "pi",
    "({} ** {})".format,
)
C = _target(
    {"sgn": "sgn", "Abs": "fabs", "sqrt": "sqrt", "sin": "sin", "cos": "cos", "Max": "fmax", "Min": "fmin"},
    repr(3.141592653589793),
    "pow({}, {})".format,
)


def _head(formulas: FieldFormulas) -> list[str]:
    """What the program is, on lines without quotes, backslashes and the ends of comments."""
    states = ", ".join(f"x[{k}] = {name}" for k, name in enumerate(formulas.states))
    name = one_line(formulas.name).replace("\\", "/").replace('"', "'").replace("*/", "* /")
    said = [f"The field of {name}, x' = f(x), with {states}. Written by nonsmooth; numbers are doubles."]
    said.append("On the surfaces where f jumps its value is one of many: solutions are Filippov's.")
    if len(formulas.fields) > 1:
        said.append(f"The system may switch between {len(formulas.fields)} fields at any time.")
    if formulas.lyapunov is not None:
        said.append("lyapunov is the V of the verdict, zero at the checked point.")
    return said


def _functions(formulas: FieldFormulas, target: Target) -> tuple[list[tuple[str, list[str]]], str | None]:
    """The fields by their names, and V."""
    fields, lyapunov = formulas.written(target, [f"x[{k}]" for k in range(len(formulas.states))])
    names = ["field"] if len(fields) == 1 else [f"field_{k}" for k in range(1, len(fields) + 1)]
    return list(zip(names, fields, strict=True)), lyapunov


def python_program(formulas: FieldFormulas) -> str:
    """A module with ``field(x)``, a list, and ``lyapunov(x)``."""
    fields, lyapunov = _functions(formulas, PYTHON)
    lines = [f'"""{chr(10).join(_head(formulas))}"""', "", "from math import cos, pi, sin, sqrt  # noqa: F401"]
    lines += ["", "", "def sgn(a):", "    return float(a > 0) - float(a < 0)"]
    for name, own in fields:
        lines += ["", "", f"def {name}(x):", "    return [", *(f"        {part}," for part in own), "    ]"]
    lines += [] if lyapunov is None else ["", "", "def lyapunov(x):", f"    return {lyapunov}"]
    return "\n".join([*lines, ""])


def c_program(formulas: FieldFormulas) -> str:
    """A file with ``void field(const double x[], double dx[])`` and ``double lyapunov(const double x[])``."""
    fields, lyapunov = _functions(formulas, C)
    count = len(formulas.states)
    lines = [f"/* {f' */{chr(10)}/* '.join(_head(formulas))} */", "", "#include <math.h>", ""]
    lines += ["static double sgn(double a) { return (a > 0) - (a < 0); }"]
    for name, own in fields:
        lines += ["", f"void {name}(const double x[{count}], double dx[{count}])", "{"]
        lines += [*(f"    dx[{k}] = {part};" for k, part in enumerate(own)), "}"]
    if lyapunov is not None:
        lines += ["", f"double lyapunov(const double x[{count}])", "{", f"    return {lyapunov};", "}"]
    return "\n".join([*lines, ""])


PROGRAMS: dict[str, Callable[[FieldFormulas], str]] = {"python": python_program, "c": c_program}
