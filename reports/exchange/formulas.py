"""The field of a plain system and the V that was found for it, as SymPy, CasADi, Python and C.

A formula is a tree of Python's grammar that was checked when the scene was read; it is walked, and each node is written
in the target's own way.  The field is that which was stated: with its fractions, sines and roots of states, and its
parameters at their values.  V is a function of the states, not of the displacement from the checked point.
"""

from __future__ import annotations

import ast
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import TYPE_CHECKING, Any, NamedTuple

from nonsmooth.reports.exchange.reading import Reading
from nonsmooth.symbolic.formulas.trees import Interpretation, formula_tree
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line

if TYPE_CHECKING:
    import sympy

    from nonsmooth.proofs.systems.findings import ExaminedFunction
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem


# ---- what is written -----------------------------------------------------------------------------


class SympyField(NamedTuple):
    """A system in SymPy: real symbols, one tuple of expressions for each right-hand side, and V or None."""

    states: tuple[sympy.Symbol, ...]
    fields: tuple[tuple[sympy.Expr, ...], ...]
    lyapunov: sympy.Expr | None


class CasadiField(NamedTuple):
    """A system in CasADi: one Function x -> dx for each right-hand side, and the Function x -> V or None."""

    fields: tuple[Any, ...]
    lyapunov: Any


@dataclass(frozen=True)
class FieldFormulas:
    """The stated right-hand sides of a system, and a V.

    Attributes:
        name: of the system.
        states: their names.
        fields: formulas by right-hand side (several under arbitrary switching) and state.
        lyapunov: V in the displacement, under the names of the states; None where none was found.
        point: the checked point, a formula for each state.
    """

    name: str
    states: tuple[str, ...]
    fields: tuple[tuple[str, ...], ...]
    lyapunov: str | None
    point: tuple[str, ...]

    def written(self, target: Interpretation, names: Sequence[Any]) -> tuple[list[list[Any]], Any]:
        """All fields, and V or None, in a target.

        Args:
            target: how formulas are written.
            names: what stands for each state.

        Raises:
            SceneError: for a formula with a number beyond the floats of a target of floats.
        """
        named = dict(zip(self.states, names, strict=True))
        fields = [[_formula(target, text, named) for text in field] for field in self.fields]
        if self.lyapunov is None:
            return fields, None
        moved = dict(named)
        for state, at in zip(self.states, self.point, strict=True):
            if at != "0":
                moved[state] = target.operators[ast.Sub](named[state], _formula(target, at, {}))
        return fields, _formula(target, self.lyapunov, moved)

    def sympy(self) -> SympyField:
        """In SymPy, with exact numbers."""
        import sympy

        functions = {"sgn": sympy.sign, **{name: getattr(sympy, name) for name in _NAMED}}
        states = tuple(sympy.Symbol(name, real=True) for name in self.states)
        target = Interpretation(lambda value: sympy.Rational(value.numerator, value.denominator), sympy.pi, functions)
        fields, lyapunov = self.written(target, states)
        return SympyField(states, tuple(tuple(map(sympy.sympify, field)) for field in fields), lyapunov)

    def casadi(self) -> CasadiField:
        """In CasADi, with doubles.

        Raises:
            SceneError: without CasADi.
        """
        casadi = Reading("casadi").library("casadi")
        functions = {"Abs": casadi.fabs, "Max": casadi.fmax, "Min": casadi.fmin, "sgn": casadi.sign}
        functions |= {name: getattr(casadi, name) for name in ("sqrt", *SMOOTH)}
        x = casadi.SX.sym("x", len(self.states))
        target = Interpretation(lambda value: casadi.SX(float(value)), casadi.SX(casadi.pi), functions)
        fields, lyapunov = self.written(target, x.elements())
        made = tuple(casadi.Function("field", [x], [casadi.vertcat(*sides)], ["x"], ["dx"]) for sides in fields)
        return CasadiField(made, None if lyapunov is None else casadi.Function("V", [x], [lyapunov], ["x"], ["V"]))

    def program(self, language: str) -> str:
        """The source of a program of its own, with doubles.

        Args:
            language: ``python`` or ``c``.

        Raises:
            ValueError: for another language.
        """
        if language not in PROGRAMS:
            raise ValueError(f"required a language of {', '.join(PROGRAMS)}, received {language!r}")
        return PROGRAMS[language](self)


SMOOTH = ("sin", "cos", "tanh", "atan", "exp")
_NAMED = ("Abs", "Max", "Min", "sqrt", *SMOOTH)


def _formula(target: Interpretation, text: str, names: Mapping[str, Any]) -> Any:
    try:
        return target.value(formula_tree(text), names)
    except OverflowError:
        raise SceneError(text, "", "numbers within the range of floats", StatedFact("another")) from None


# ---- programs, complete by themselves ------------------------------------------------------------


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


def _target(names: dict[str, str], pi: str, power: Callable[..., str]) -> Interpretation:
    functions = {name: f"{called}({{}})".format for name, called in names.items() if name not in ("Max", "Min")}
    functions |= {name: f"{names[name]}({{}}, {{}})".format for name in ("Max", "Min")}
    return Interpretation(_number, pi, functions, {**_OPERATORS, ast.Pow: power})


_SAME = {name: name for name in ("sgn", "sqrt", *SMOOTH)}
PYTHON = _target({**_SAME, "Abs": "abs", "Max": "max", "Min": "min"}, "pi", "({} ** {})".format)
C = _target({**_SAME, "Abs": "fabs", "Max": "fmax", "Min": "fmin"}, repr(math.pi), "pow({}, {})".format)


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


def _functions(formulas: FieldFormulas, target: Interpretation) -> tuple[list[tuple[str, list[str]]], str | None]:
    """The fields by their names, and V."""
    fields, lyapunov = formulas.written(target, [f"x[{k}]" for k in range(len(formulas.states))])
    names = ["field"] if len(fields) == 1 else [f"field_{k}" for k in range(1, len(fields) + 1)]
    return list(zip(names, fields, strict=True)), lyapunov


def python_program(formulas: FieldFormulas) -> str:
    """A module with ``field(x)``, a list, and ``lyapunov(x)``."""
    fields, lyapunov = _functions(formulas, PYTHON)
    used = [kind for kind in SMOOTH if any(f"{kind}(" in part for _, sides in fields for part in sides)]
    imported = ", ".join(sorted({"cos", "pi", "sin", "sqrt", *used}))
    lines = [f'"""{chr(10).join(_head(formulas))}"""', "", f"from math import {imported}  # noqa: F401"]
    lines += ["", "", "def sgn(a):", "    return float(a > 0) - float(a < 0)"]
    for name, sides in fields:
        lines += ["", "", f"def {name}(x):", "    return [", *(f"        {part}," for part in sides), "    ]"]
    lines += [] if lyapunov is None else ["", "", "def lyapunov(x):", f"    return {lyapunov}"]
    return "\n".join([*lines, ""])


def c_program(formulas: FieldFormulas) -> str:
    """A file with ``void field(const double x[], double dx[])`` and ``double lyapunov(const double x[])``."""
    fields, lyapunov = _functions(formulas, C)
    count = len(formulas.states)
    lines = [f"/* {f' */{chr(10)}/* '.join(_head(formulas))} */", "", "#include <math.h>", ""]
    if any("sgn(" in part for part in (lyapunov or "", *(part for _, sides in fields for part in sides))):
        lines += ["static double sgn(double a) { return (a > 0) - (a < 0); }"]
    for name, sides in fields:
        lines += ["", f"void {name}(const double x[{count}], double dx[{count}])", "{"]
        lines += [*(f"    dx[{k}] = {part};" for k, part in enumerate(sides)), "}"]
    if lyapunov is not None:
        lines += ["", f"double lyapunov(const double x[{count}])", "{", f"    return {lyapunov};", "}"]
    return "\n".join([*lines, ""])


PROGRAMS: dict[str, Callable[[FieldFormulas], str]] = {"python": python_program, "c": c_program}


# ---- from a system -------------------------------------------------------------------------------


def formulas_of(system: SwitchedSystem, function: ExaminedFunction | None = None) -> FieldFormulas:
    """The stated field of a system, with a V.

    Args:
        system: a plain system.
        function: the V that was found; none of a system that is seen by roots of its states.
    """
    lyapunov = None if function is None or system.by_roots is not None else function.formula.text
    point = tuple(map(str, system.check.equilibrium))
    if system.by_roots is not None:
        point = ("0",) * len(system.stated_states)  # V alone asks for it
    return FieldFormulas(system.name, system.stated_states, system.stated_lists, lyapunov, point)
