"""Matrices, state spaces of python-control and functions of CasADi as formulas of plain systems."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

from nonsmooth.reports.exchange.reading import Reading
from nonsmooth.symbolic.formulas.formula_text import (
    ZERO,
    complement,
    difference_text,
    disjunction,
    first_that_holds,
    indicator,
    product_text,
    sum_text,
)

Rows: TypeAlias = list[list[str]]  # texts of numbers


def state_names(count: int) -> list[str]:
    """x1, x2, ..."""
    return [f"x{k}" for k in range(1, count + 1)]


def matrix(value: Any, key: str, reading: Reading, shape: tuple[int | None, int | None] = (None, None)) -> Rows:
    """The rows of a matrix as texts of exact numbers.

    Args:
        value: an array of NumPy, a matrix of SymPy, or rows of numbers.
        key: its place, for messages.
        reading: how numbers are read.
        shape: rows and columns that it must have; None for any number.

    Raises:
        SceneError: for another shape, and for what is no number.
    """
    rows = [list(row) for row in _rows(value, key, reading)]
    widths = {len(row) for row in rows}
    fits = len(widths) == 1 and shape[0] in (None, len(rows)) and shape[1] in (None, *widths)
    if not fits:
        wanted = " x ".join("n" if size is None else str(size) for size in shape)
        received = f"{len(rows)} rows of {', '.join(map(str, sorted(widths))) or 'no'} numbers"
        raise reading.refused(key, f"a matrix of {wanted} numbers", received)
    return [
        [reading.number(_plain(entry), f"{key}[{i}][{j}]") for j, entry in enumerate(row, 1)]
        for i, row in enumerate(rows, 1)
    ]


def _rows(value: Any, key: str, reading: Reading) -> list[Any]:
    listed = value.tolist() if hasattr(value, "tolist") and hasattr(value, "free_symbols") else value
    try:
        rows = list(listed)
        return [list(row) for row in rows]
    except TypeError:
        raise reading.refused(key, "a matrix as rows of numbers", type(value).__name__) from None


def _plain(entry: Any) -> Any:
    """A number of SymPy as a text, which is read as a formula; any other number as it is."""
    if not hasattr(entry, "free_symbols"):
        return entry
    return float(entry) if entry.is_Float else str(entry)


def vector(value: Any, count: int, key: str, reading: Reading) -> list[str]:
    """The entries of a vector as texts of exact numbers.

    Raises:
        SceneError: for another number of entries, and for what is no number.
    """
    entries = list(value)
    if len(entries) != count:
        raise reading.refused(key, f"{count} numbers", len(entries))
    return [reading.number(_plain(entry), f"{key}[{k}]") for k, entry in enumerate(entries, 1)]


def times(rows: Rows, names: Sequence[str]) -> list[str]:
    """The entries of a matrix times named states."""
    return [sum_text([product_text([number, name]) for number, name in zip(row, names, strict=True)]) for row in rows]


def modes_of_matrices(matrices: Sequence[Any], offsets: Any, names: Sequence[str], reading: Reading) -> Rows:
    """The formulas ``A_i x + b_i`` of each mode.

    Raises:
        SceneError: for matrices and offsets of other shapes.
    """
    count = len(names)
    modes = [times(matrix(a, f"matrices[{i}]", reading, (count, count)), names) for i, a in enumerate(matrices, 1)]
    if offsets is None:
        return modes
    listed = list(offsets)
    if len(listed) != len(modes):
        raise reading.refused("offsets", f"{len(modes)}, one for each matrix", len(listed))
    shifts = [vector(b, count, f"offsets[{i}]", reading) for i, b in enumerate(listed, 1)]
    return [
        [sum_text([part, shift]) for part, shift in zip(mode, shifted, strict=True)]
        for mode, shifted in zip(modes, shifts, strict=True)
    ]


def on_cones(modes: Rows, cones: Any, names: Sequence[str], reading: Reading) -> list[str]:
    """One formula for each state: the first mode counts whose ``C_i (x, 1) > 0`` in every row.

    Args:
        modes: their formulas.
        cones: a matrix C_i for each mode, of as many columns as states, or one more for a constant; None for the last
            mode, which holds everywhere else.
        names: of the states.
        reading: how numbers are read.

    Raises:
        SceneError: for another number of cones, and where the last is not None.
    """
    listed = list(cones)
    if len(listed) != len(modes) or listed[-1] is not None or any(cone is None for cone in listed[:-1]):
        expected = f"{len(modes)} cones, one for each matrix, the last one None: it holds everywhere else"
        raise reading.refused("cones", expected, f"{['None' if cone is None else 'a matrix' for cone in listed]}")
    truths = []
    for i, cone in enumerate(listed[:-1], 1):
        rows = matrix(cone, f"cones[{i}]", reading)
        if len(rows[0]) not in (len(names), len(names) + 1):
            raise reading.refused(f"cones[{i}]", f"{len(names)} columns, or one more for a constant", len(rows[0]))
        guards = times(rows, [*names, "1"][: len(rows[0])])
        truths.append(product_text(list(map(indicator, guards))))
    return [
        first_that_holds(list(zip(truths, column[:-1], strict=True)), column[-1])
        for column in map(list, zip(*modes, strict=True))
    ]


def quadratic_form(value: Any, names: Sequence[str], reading: Reading) -> str | None:
    """The formula ``x' P x`` of a Lyapunov function; a formula, or None, is taken as it is."""
    if value is None or isinstance(value, str):
        return value
    rows = matrix(value, "lyapunov", reading, (len(names), len(names)))
    return sum_text(
        [
            product_text([number, a, b])
            for a, row in zip(names, rows, strict=True)
            for b, number in zip(names, row, strict=True)
        ]
    )


# ---- python-control's state spaces as Lur'e systems ----------------------------------------------
#
# Linear systems with a saturation, relay or dead zone in the loop (extra ``nonsmooth[control]``).
#
# ``x' = A x + B u``, ``y = C x``, ``u_i = sign phi_i(y_i)``, with -1 for a negative feedback.


PHI: dict[str, Callable[[str, str], str]] = {
    "saturation": "sat({0}, -{1}, {1})".format,
    "relay": lambda y, limit: product_text([limit, f"sgn({y})"]),
    "deadzone": lambda y, limit: difference_text(y, f"sat({y}, -{limit}, {limit})"),
}  # of an output and a positive number, by name
LIKE_A_NAME = 'one of "saturation", "relay", "deadzone", or None, for each output'


def formulas_of_control(
    plant: Any, nonlinearity: Any, limit: Any, sign: int, reading: Reading
) -> tuple[list[str], list[str]]:
    """The names of the states, and one formula for each.

    Args:
        plant: a ``control.StateSpace`` in continuous time.
        nonlinearity: a name of :data:`PHI` or None (a gain of one) for each output, or one for all; python-control's
            ``saturation_nonlinearity``, or its ``relay_hysteresis_nonlinearity`` without hysteresis. Without any of
            them the loop is open: ``x' = A x``.
        limit: positive number: of a saturation or relay its largest value, of a dead zone its half-width; or a list.
        sign: of the feedback, 1 or -1.
        reading: how numbers are read.

    Raises:
        SceneError: without python-control, for discrete time, feedthrough, and what is no such nonlinearity.
    """
    control = reading.library("control")
    if not isinstance(plant, control.StateSpace):
        hint = "a StateSpace (control.ss makes one, in floats, of a transfer function)"
        raise reading.refused("plant", hint, type(plant).__name__)
    if plant.dt not in (0, None):
        raise reading.refused("plant", "continuous time (dt = 0)", f"dt = {plant.dt}")
    if type(sign) is not int or sign not in (1, -1):
        raise reading.refused("sign", "1 or -1", sign)
    labels = [str(label) for label in plant.state_labels]
    names = labels if all(label.isidentifier() for label in labels) else state_names(plant.nstates)
    linear = times(matrix(plant.A, "A", reading), names)
    if nonlinearity is None:
        return names, linear
    feedback = _feedback(plant, nonlinearity, limit, names, reading)
    signed = feedback if sign == 1 else [f"(-{part})" for part in feedback]
    inputs: Rows = matrix(plant.B, "B", reading, (plant.nstates, len(signed)))
    return names, [sum_text([a, b]) for a, b in zip(linear, times(inputs, signed), strict=True)]


def _feedback(plant: Any, nonlinearity: Any, limit: Any, names: Sequence[str], reading: Reading) -> list[str]:
    """``phi_i(y_i)`` of each output."""
    if plant.D.any():
        raise reading.refused("D", "no feedthrough (D = 0): a relay of its own output need not have a value", "another")
    outputs = times(matrix(plant.C, "C", reading, (plant.ninputs, plant.nstates)), names)
    kinds = list(nonlinearity) if isinstance(nonlinearity, list | tuple) else [nonlinearity] * len(outputs)
    limits = list(limit) if isinstance(limit, list | tuple) else [limit] * len(outputs)
    if not len(kinds) == len(limits) == len(outputs):
        raise reading.refused("nonlinearity", f"{len(outputs)}, with their limits", f"{len(kinds)}, {len(limits)}")
    return [_phi(*loop, reading) for loop in zip(outputs, kinds, limits, strict=True)]


def _phi(output: str, kind: Any, limit: Any, reading: Reading) -> str:
    """One nonlinearity of one output."""
    if output == ZERO or kind is None:
        return output
    name, size = (kind, limit) if isinstance(kind, str) else _of_object(kind, reading)
    if name not in PHI:
        raise reading.refused("nonlinearity", LIKE_A_NAME, repr(name))
    if not isinstance(size, str) and not size > 0:
        raise reading.refused("limit", "a positive number", size)
    return PHI[name](output, reading.number(size, "limit"))


def _of_object(kind: Any, reading: Reading) -> tuple[str, Any]:
    """The name and the limit of one of python-control's own nonlinearities."""
    match type(kind).__name__:
        case "saturation_nonlinearity" if kind.lb == -kind.ub:
            return "saturation", kind.ub
        case "relay_hysteresis_nonlinearity" if kind.c == 0:
            return "relay", kind.b
        case "relay_hysteresis_nonlinearity":
            raise reading.refused("nonlinearity", "a relay without hysteresis (c = 0)", f"c = {kind.c}")
    raise reading.refused("nonlinearity", LIKE_A_NAME, type(kind).__name__)


# ---- CasADi's functions and expressions as formulas ----------------------------------------------
#
# By their graphs of instructions (extra ``nonsmooth[casadi]``).
#
# A function of MX is expanded to SX, whose instructions are scalar.  ``if_else(a < b, f, g)`` is there
# ``if_else_zero(a < b, f) + if_else_zero(not a < b, g)``: factors of truth that multiply formulas.


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
    "OP_TANH": "tanh({})".format,
    "OP_ATAN": "atan({})".format,
    "OP_EXP": "exp({})".format,
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
