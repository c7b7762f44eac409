"""CasADi's functions and expressions as formulas, by their graphs of instructions (extra ``nonsmooth[casadi]``).

A function of MX is expanded to SX, whose instructions are scalar.  ``if_else(a < b, f, g)`` is there
``if_else_zero(a < b, f) + if_else_zero(not a < b, g)``: factors of truth that multiply formulas.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

from nonsmooth.reports.exchange.from_matrices import state_names
from nonsmooth.reports.exchange.reading import Reading
from nonsmooth.symbolic.formulas.formula_text import (
    complement,
    difference_text,
    disjunction,
    indicator,
    product_text,
    sum_text,
)

# What an instruction writes, from the texts of its arguments.
INSTRUCTIONS: dict[str, Callable[..., str]] = {
    "OP_ASSIGN": "{}".format,
    "OP_ADD": lambda a, b: sum_text([a, b]),
    "OP_SUB": difference_text,
    "OP_MUL": lambda a, b: product_text([a, b]),
    "OP_DIV": "({}/{})".format,
    "OP_INV": "(1/{})".format,
    "OP_NEG": "(-{})".format,
    "OP_SQ": "({}**2)".format,
    "OP_TWICE": "(2*{})".format,
    "OP_SQRT": "sqrt({})".format,
    "OP_SIN": "sin({})".format,
    "OP_COS": "cos({})".format,
    "OP_FABS": "Abs({})".format,
    "OP_SIGN": "sgn({})".format,
    "OP_FMIN": "Min({}, {})".format,
    "OP_FMAX": "Max({}, {})".format,
    "OP_IF_ELSE_ZERO": lambda truth, a: product_text([truth, a]),
    "OP_LT": lambda a, b: indicator(difference_text(b, a)),
    "OP_LE": lambda a, b: indicator(difference_text(b, a), strict=False),
    "OP_NOT": complement,
    "OP_AND": lambda a, b: product_text([a, b]),
    "OP_OR": lambda a, b: disjunction([a, b]),
}
POWERS = ("OP_POW", "OP_CONSTPOW")


def formulas_of_casadi(
    function: Any, states: Any, inputs: Mapping[str, Any], reading: Reading
) -> tuple[list[str], list[str]]:
    """The names of the states, and one formula for each output of a function or expression.

    Args:
        function: a ``casadi.Function`` whose first input is the vector of states, or an expression.
        states: of a function, names, or None for x1, x2, ...; of an expression its symbols, in a vector or a list.
        inputs: a number, or a list of them, for each further input of a function, by its name.
        reading: how numbers are read.

    Raises:
        SceneError: without CasADi, for further inputs without numbers, and for instructions that formulas have not.
    """
    casadi = reading.library("casadi")
    if isinstance(function, casadi.Function):
        found = function
        names = state_names(found.numel_in(0) if found.n_in() else 0) if states is None else list(map(str, states))
    else:
        symbols = states if isinstance(states, list | tuple) else [states]
        names = [name for symbol in symbols for name in _names(casadi, symbol, reading)]
        found = _of_expression(casadi, function, symbols, reading)
    return names, written(casadi, _of_vector(casadi, found, len(names), inputs, reading), names, reading)


def _names(casadi: Any, symbol: Any, reading: Reading) -> list[str]:
    """The names of the entries of a symbol: ``q_0``, ``q_1``, ... as CasADi calls those of a vector of SX."""
    if not isinstance(symbol, casadi.SX | casadi.MX) or not symbol.is_valid_input():
        raise reading.refused("states", "the symbols of an expression of CasADi", symbol)
    if isinstance(symbol, casadi.SX):
        return [part.name() for part in symbol.elements()]
    return [symbol.name()] if symbol.numel() == 1 else [f"{symbol.name()}_{k}" for k in range(symbol.numel())]


def _of_expression(casadi: Any, expression: Any, symbols: Sequence[Any], reading: Reading) -> Any:
    """An expression, or a list of scalar ones, as a function of its symbols, joined into one vector.

    Raises:
        SceneError: for other symbols in it.
    """
    whole = casadi.vertcat(*expression) if isinstance(expression, list | tuple) else expression
    try:
        parts = casadi.Function("parts", list(symbols), [whole]).expand()
    except (RuntimeError, NotImplementedError):
        known = {name for symbol in symbols for name in _names(casadi, symbol, reading)}
        found = [symbol.name() for symbol in casadi.symvar(whole)] if hasattr(whole, "shape") else [str(whole)]
        raise reading.refused("expression", f"one in {', '.join(sorted(known))}", ", ".join(found)) from None
    x = casadi.SX.sym("x", sum(symbol.numel() for symbol in symbols))
    ends = [0]
    for symbol in symbols:
        ends.append(ends[-1] + symbol.numel())
    pieces = [x[a:b] for a, b in itertools.pairwise(ends)]
    return casadi.Function("field", [x], [parts(*pieces)])


def _of_vector(casadi: Any, function: Any, count: int, inputs: Mapping[str, Any], reading: Reading) -> Any:
    """The function of the states alone, in instructions of scalars, with a dense first output."""
    further = [function.name_in(k) for k in range(1, function.n_in())]
    if function.n_in() < 1 or function.numel_in(0) != count:
        received = function.numel_in(0) if function.n_in() else "no input"
        raise reading.refused("states", f"names of as many states as the first input has ({count})", received)
    if sorted(further) != sorted(inputs):
        wanted = ", ".join(further) or "none"
        raise reading.refused("inputs", f"numbers for each further input ({wanted})", sorted(inputs) or "none")
    x = casadi.SX.sym("x", count)
    try:
        outputs = function.expand().call([x, *(casadi.SX(inputs[name]) for name in further)])
    except (RuntimeError, NotImplementedError) as error:
        reason = str(error).strip().splitlines()[-1]
        raise reading.refused("function", "one of which CasADi can write out all instructions", reason) from None
    return casadi.Function("field", [x], [casadi.densify(outputs[0])])


def written(casadi: Any, function: Any, names: Sequence[str], reading: Reading) -> list[str]:
    """One formula for each entry of the output, column by column, by the instructions in their order.

    Raises:
        SceneError: for an instruction that formulas have not, and for formulas that are too long.
    """
    called = {getattr(casadi, name): name for name in dir(casadi) if name.startswith("OP_")}
    work: dict[int, str] = {}
    outputs: dict[int, str] = {}
    for k in range(function.n_instructions()):
        operation = called[function.instruction_id(k)]
        arguments, targets = function.instruction_input(k), function.instruction_output(k)
        if operation == "OP_CONST":
            work[targets[0]] = reading.number(function.instruction_constant(k), "constant")
        elif operation == "OP_INPUT":
            work[targets[0]] = names[arguments[1]]
        elif operation == "OP_OUTPUT":
            outputs[targets[1]] = work[arguments[0]]
        else:
            texts = [work[place] for place in arguments]
            work[targets[0]] = reading.require_short(_instruction(operation, texts, reading), "expression")
    return [outputs[k] for k in sorted(outputs)]


def _instruction(operation: str, texts: Sequence[str], reading: Reading) -> str:
    """The text that one instruction writes."""
    if operation in POWERS:
        return f"({texts[0]}**{_whole(texts[1], reading)})"
    if operation not in INSTRUCTIONS:
        known = ", ".join(name.removeprefix("OP_") for name in (*INSTRUCTIONS, *POWERS))
        raise reading.refused("expression", f"instructions out of {known}", operation.removeprefix("OP_"))
    return INSTRUCTIONS[operation](*texts)


def _whole(text: str, reading: Reading) -> str:
    """An exponent, which CasADi holds as a float."""
    if not text.isdecimal():
        raise reading.refused("expression", "whole exponents from 0", text)
    return text
