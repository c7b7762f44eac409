"""Matrices as formulas: linear, switched-linear, conewise-linear and piecewise-affine systems."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

from nonsmooth.reports.exchange.reading import Reading
from nonsmooth.symbolic.formulas.formula_text import first_that_holds, indicator, product_text, sum_text

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
        raise reading.refused("cones", expected, f"{['None' if own is None else 'a matrix' for own in listed]}")
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
