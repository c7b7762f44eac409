"""nosnoc's piecewise smooth systems ``x' = F(x) theta``: switching functions c, sign matrix S, fields F in columns.

Region i is where ``S_ij c_j(x) > 0`` for all j; an entry 0 says that c_j does not count. Several triples (c, S, F) are
independent, and their fields are added, as in nosnoc (Nurkanovic and Diehl 2022).
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import Any

from nonsmooth.reports.exchange.reading import Reading
from nonsmooth.symbolic.formulas.expression import ExpressionError
from nonsmooth.symbolic.formulas.formula_text import ONE, complement, in_parentheses, indicator, product_text, sum_text
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise

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
    for surfaces, own, columns in triples:
        names, switching = _formulas(states, surfaces, "c", reading)
        rows = [list(map(int, row)) for row in _checked_signs(own, len(switching), reading)]
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
