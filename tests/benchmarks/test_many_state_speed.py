"""Four states: the exact verdict beside a plain sum-of-squares program in CVXPY on the same inequalities, in one run.

The program is what one writes with a modelling language: a quadratic V, a Gram matrix for V and for V' on every cell,
multipliers for the guards and the sides of the cube, floats in and floats out.  What is timed on our side is the whole
verdict: cells, search, rounding, exact proof, region and the verification of all of it.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations_with_replacement, product
from pathlib import Path
from typing import Any

import cvxpy as cp
import pytest

from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.files.system_builder import build_system
from tests.benchmarks.conftest import Stopwatch

COUNT = 4
STATES = ["a", "b", "c", "d"]
REQUIRED_SPEEDUP = 1.0
Terms = dict[tuple[int, ...], Any]  # floats, or affine expressions of CVXPY
Form = Sequence[float]


def unit(*which: int) -> tuple[int, ...]:
    return tuple(which.count(k) for k in range(COUNT))


def linear(form: Form) -> Terms:
    return {unit(k): float(c) for k, c in enumerate(form) if c}


def multiply(first: Terms, second: Terms) -> Terms:
    total: Terms = {}
    for a, c in first.items():
        for b, d in second.items():
            e = tuple(map(int.__add__, a, b))
            total[e] = total.get(e, 0) + c * d
    return total


def monomials(low: int, high: int) -> list[tuple[int, ...]]:
    degrees = range(low, high + 1)
    return [unit(*chosen) for degree in degrees for chosen in combinations_with_replacement(range(COUNT), degree)]


def squares(shapes: Sequence[tuple[int, ...]], constraints: list[Any]) -> Terms:
    gram = cp.Variable((len(shapes), len(shapes)), PSD=True) if len(shapes) > 1 else cp.Variable((1, 1), nonneg=True)
    constraints += []
    total: Terms = {}
    for i, a in enumerate(shapes):
        for j, b in enumerate(shapes):
            e = tuple(map(int.__add__, a, b))
            total[e] = total.get(e, 0) + gram[i, j]
    return total


def sos_program(cells: Sequence[tuple[Sequence[Form], Sequence[Terms]]], degree: int, radius: float) -> bool:
    """Whether CVXPY finds a quadratic V for cells of guards and fields."""
    constraints: list[Any] = []
    shapes = monomials(2, 2)
    potential: Terms = {e: cp.Variable() for e in shapes}
    half = max((degree + 2) // 2, 1)

    def positive(terms: Terms, guards: Sequence[Form]) -> None:
        margin = {unit(k, k): -1e-3 for k in range(COUNT)}
        least = min(map(sum, terms))
        total: Terms = {}
        parts = [squares(monomials(1, half), constraints)]
        parts += [multiply(linear(g), squares([unit()], constraints)) for g in guards if least == 1]
        parts += [
            multiply(multiply(linear(g), linear(h)), squares([unit()], constraints)) for g in guards for h in guards
        ]
        if half > 1:
            box = [{unit(): radius**2, unit(k, k): -1.0} for k in range(COUNT)]
            parts += [multiply(side, squares(monomials(1, half - 1), constraints)) for side in box]
        for part in parts:
            for e, c in part.items():
                total[e] = total.get(e, 0) + c
        for e in {*total, *terms, *margin}:
            constraints.append(terms.get(e, 0) + margin.get(e, 0) - total.get(e, 0) == 0)

    positive(potential, [])
    for guards, field in cells:
        rate: Terms = {}
        for k in range(COUNT):
            lowered = {tuple(x - (i == k) for i, x in enumerate(e)): -e[k] * c for e, c in potential.items() if e[k]}
            for e, c in multiply(lowered, field[k]).items():
                rate[e] = rate.get(e, 0) + c
        positive(rate, guards)
    problem = cp.Problem(cp.Minimize(0), constraints)
    problem.solve(solver=cp.CLARABEL)
    return bool(problem.status in (cp.OPTIMAL, cp.OPTIMAL_INACCURATE))


def smooth() -> tuple[list[str], bool]:
    """A damped oscillator with quadratic and cubic terms."""
    fields: list[Terms] = [
        {unit(1): 1.0},
        {unit(0): -1.0, unit(1): -1.0, unit(0, 0): 1.0},
        {unit(2): -1.0, unit(2, 2, 2): -1.0, unit(1, 3): 1.0},
        {unit(3): -1.0, unit(0, 2): 1.0},
    ]
    return ["b", "-a - b + a**2", "-c - c**3 + b*d", "-d + a*c"], sos_program([([], fields)], 3, 0.5)


def cones() -> tuple[list[str], bool]:
    """A ring with absolute values: sixteen cones."""
    cells = []
    for signs in product((1.0, -1.0), repeat=COUNT):
        guards = [[s * (i == k) for i in range(COUNT)] for k, s in enumerate(signs)]
        fields = [
            {unit(k): -1.0, unit((k + 1) % COUNT): signs[(k + 1) % COUNT] * (0.5 if k else 2.5)} for k in range(COUNT)
        ]
        cells.append((guards, fields))
    return ["-a + 5*Abs(b)/2", "-b + Abs(c)/2", "-c + Abs(d)/2", "-d + Abs(a)/2"], sos_program(cells, 1, 0.5)


def relays() -> tuple[list[str], bool]:
    """Four relays in a ring; one is pushed eight times as hard as it pushes."""
    cells = []
    for signs in product((1.0, -1.0), repeat=COUNT):
        guards = [[s * (i == k) for i in range(COUNT)] for k, s in enumerate(signs)]
        fields = [{unit(): -signs[k], unit(k): -1.0, unit((k + 1) % COUNT): 0.125 if k else 8.0} for k in range(COUNT)]
        cells.append((guards, fields))
    rhs = [f"-sgn({x}) - {x} + {y}*{g}" for x, y, g in zip(STATES, "bcda", ("8", *["1/8"] * 3), strict=True)]
    return rhs, sos_program(cells, 1, 0.5)


@pytest.mark.parametrize("family", [smooth, cones, relays])
def test_a_verdict_takes_no_longer_than_a_float_program(
    family: Callable[[], tuple[list[str], bool]], stopwatch: Stopwatch
) -> None:
    rhs, feasible = family()
    assert feasible
    system = build_system({"system": {"states": STATES, "rhs": rhs}}, "t", Path("t.toml"))
    assert decide_system(system).function is not None  # not the sum of squares of the states

    def verdict() -> None:
        result = decide_system(system)
        assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
        assert result.check()

    verdict()
    ours = stopwatch.best(verdict, 3)
    theirs = stopwatch.best(family, 3)
    stopwatch.report(
        f"n = 4, {family.__name__}: verdict {ours:.2f} s, CVXPY with Clarabel {theirs:.2f} s: {theirs / ours:.1f} times"
    )
    assert theirs >= REQUIRED_SPEEDUP * ours
