"""All contact states of the four-wheel array with symbolic inputs: the number field against SymPy's matrices."""

from __future__ import annotations

from itertools import combinations

import pytest
import sympy

from nonsmooth.symbolic.mechanics.contact_states import RowKind, Triple, regular_states
from tests.benchmarks.conftest import Stopwatch
from tests.conftest import Arrays

REQUIRED_SPEEDUP = 200
ROUNDING = 1e-12  # entries are of order 1

Field = tuple[tuple[str, ...], int]  # names of the three rows, wheel of the input


def by_number_field(arrays: Arrays) -> dict[Field, Triple]:
    """``g_w`` of every regular triple: from the scene's own numbers, nothing prepared."""
    states = regular_states(arrays.four_wheel())
    return {(tuple(r.name for r in s.rows), w): g for s in states for w, g in s.control_fields.items()}


def by_sympy() -> dict[Field, sympy.Matrix]:
    """The same by ``LUsolve`` and ``simplify`` on exact SymPy matrices; symbolic speeds u_1 .. u_4."""
    inputs = sympy.symbols("u1:5")
    rows: list[tuple[str, sympy.Matrix, sympy.Expr]] = []
    root = sympy.sqrt(2) / 2
    for k, (x, y) in enumerate(((1, 1), (-1, 1), (-1, -1), (1, -1)), 1):
        d = sympy.Matrix([-x * root, -y * root])
        n = sympy.Matrix([-d[1], d[0]])
        moved = sympy.Matrix([-y, x])
        rows.append((f"R{k}", sympy.Matrix([[d[0], d[1], d.dot(moved)]]), inputs[k - 1]))
        rows.append((f"S{k}", sympy.Matrix([[n[0], n[1], n.dot(moved)]]), sympy.Integer(0)))
    fields: dict[Field, sympy.Matrix] = {}
    for triple in combinations(rows, 3):
        matrix = sympy.Matrix.vstack(*(row for _, row, _ in triple))
        if sympy.simplify(matrix.det()) == 0:
            continue
        twist = sympy.simplify(matrix.LUsolve(sympy.Matrix([rhs for *_, rhs in triple])))
        for name, *_ in triple:
            if name.startswith(RowKind.ROLL):
                wheel = int(name[1:])
                fields[tuple(name for name, *_ in triple), wheel] = twist.diff(inputs[wheel - 1])
    return fields


def test_deriving_all_contact_states(arrays: Arrays, stopwatch: Stopwatch) -> None:
    ours, theirs = by_number_field(arrays), by_sympy()
    assert ours.keys() == theirs.keys()
    for key, field in ours.items():
        assert [float(x) for x in field] == pytest.approx([float(x) for x in theirs[key]], abs=ROUNDING)

    def with_cold_cache() -> None:
        sympy.core.cache.clear_cache()
        by_sympy()

    fast = stopwatch.best(lambda: by_number_field(arrays), runs=10)
    slow = min(stopwatch.best(with_cold_cache, runs=3), stopwatch.best(by_sympy, runs=3))
    stopwatch.report(
        f"40 regular of 56 triples with inputs u_1 .. u_4: {fast * 1e3:.1f} ms, SymPy LUsolve + simplify "
        f"{slow * 1e3:.0f} ms, ratio {slow / fast:.0f} (required {REQUIRED_SPEEDUP})"
    )
    assert slow >= REQUIRED_SPEEDUP * fast
