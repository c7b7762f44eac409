"""Functions V and W of two states where leading terms with weights decide: twisting, relays under inertia and the like.

Let F and G be linear forms, F of twice the weight of G: ``x' = y``, ``y' = -a sign(x) - b sign(y)`` has ``F = x`` and
``G = y``.  Functions of the weight of F are F, its absolute value, ``G**2`` and ``G abs(G)``; a linear program in
floats finds a combination V that does not rise.  It cannot fall where ``G = 0``, because its derivative has a factor G
there; the second function ``W = F G`` or ``-F G`` shows that no solution stays on this line.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import permutations
from typing import Any, TypeAlias

import numpy as np
from scipy.optimize import linprog

from nonsmooth.proofs.checker.cells import Inclusion
from nonsmooth.proofs.checker.polynomials import lie_derivative
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE, Statement
from nonsmooth.proofs.kernel.curved_cells import build_inclusion, sharpened, started
from nonsmooth.proofs.kernel.samples import Floats, SampledProofs, values_at
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.stated_cells import StatedCells, scaled, stated_cells
from nonsmooth.proofs.systems.tangent_fan import form_lines, lowest_form
from nonsmooth.symbolic.numbers.polynomial import Polynomial as Form
from nonsmooth.symbolic.switched_system import SwitchedSystem

Record: TypeAlias = dict[str, Any]

RADII = tuple(Fraction(1, 4**k) for k in range(1, 5))  # half-widths of cubes, over that of the scene
DENOMINATORS = (1 << 2, 1 << 5, 1 << 9)  # of the coefficients of V, tried in turn
ANGLES, DISTANCES = 160, (1.0, 0.6, 0.3)  # of the points at which V is asked to fall
LEAST = 1 / 16  # of V at samples, over its largest term there
SLACK = 2.0**-23  # by which V may rise in floats, over its largest term there


def show_by_weights(
    system: SwitchedSystem, verdict: str, search: Search | None = None
) -> tuple[Record, list[Statement]]:
    """Evidence of a verdict by V and W, where one linear form has twice the weight of another.

    Args:
        system: in two states.
        verdict: asymptotically stable, or unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system, search)
    for heavy, light in _frames(system) if verdict != STABLE else ():
        basis = [f"({heavy})", f"Abs({heavy})", f"({light})**2", f"({light})*Abs({light})"]
        for share in RADII:
            stated = stated_cells(system, system.check.radius * share, (heavy, light))
            stated = sharpened(stated, subject, search)
            inclusion = build_inclusion(stated, subject, search, basis)
            coefficients = _weak_function(inclusion, verdict) if _rests(inclusion) else None
            if coefficients is None:
                break
            for denominator in DENOMINATORS:
                function = _combined(coefficients, basis, denominator)
                for sign in ("-1", "1"):
                    theorem, hypotheses = _written(stated, function, f"{sign}*({heavy})*({light})", verdict)
                    try:
                        SampledProofs().entry(subject, theorem, hypotheses)
                        return search.entry(subject, theorem, hypotheses)
                    except NotShownError:
                        continue
    raise NotShownError("no pair of functions was found for leading terms with weights")


def _frames(system: SwitchedSystem) -> Iterator[tuple[Form, Form]]:
    """Pairs of lines through the point: tangents of switching curves, and the axes."""
    states = system.displaced(system.states)
    lines = [own - centre for own, centre in zip(states, system.check.equilibrium, strict=True)]
    for surface in system.surfaces(states):
        if surface.degree and (0, 0) not in surface.terms:
            lines += [own for own in form_lines(lowest_form(surface)) or [] if scaled(own) not in map(scaled, lines)]
    yield from permutations(lines, 2)


def _rests(inclusion: Inclusion) -> bool:
    """Whether the heavy form, the first of the functions, has the derivative zero at the point along all fields."""
    around = inclusion.around()
    return not any(lie_derivative(cell.functions[0], field).at_origin for cell in around for _, field in cell.fields)


def _weak_function(inclusion: Inclusion, verdict: str) -> Floats | None:
    """Coefficients of functions whose combination V does not rise at samples; None where there are none.

    For an unstable point V is negative, as -V may then be taken for a function that does not fall.
    """
    count = len(inclusion.cells[0].functions)
    above, below = [np.zeros((0, count))], [np.zeros((0, count))]
    for points in _points():
        signs = np.stack([values_at(own, points)[0] > 0 for own in inclusion.surfaces.listed], axis=1)
        for cell in inclusion.cells:
            inside = points[(signs == (np.array(cell.signs) > 0)).all(axis=1)]
            if len(inside):
                above.append(_relative([values_at(own, inside)[0] for own in cell.functions]))
                for _, field in cell.fields:
                    rates = [lie_derivative(own, field) for own in cell.functions]
                    below.append(_relative([values_at(own, inside)[0] for own in rates]))
    positive, falling = np.vstack(above), np.vstack(below)
    side = -1.0 if verdict == UNSTABLE else 1.0
    table = np.vstack([np.column_stack([-side * positive, np.zeros(len(positive))]),
                       np.column_stack([falling, np.ones(len(falling))])])  # fmt: skip
    limits = np.concatenate([np.full(len(positive), -LEAST), np.zeros(len(falling))])
    found = linprog(np.append(np.zeros(count), -1.0), A_ub=table, b_ub=limits, bounds=[(-1, 1)] * count + [(-SLACK, 1)])
    return np.asarray(found.x[:-1] / np.abs(found.x[:-1]).max()) if found.success else None


def _points() -> Iterator[Floats]:
    """Points of the cube, beside the axes as near as weights bring them."""
    angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False) + 2.0**-10
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    for distance in DISTANCES:
        yield circle * distance
        for power in (2, 4):
            yield np.sign(circle) * np.abs(circle) ** power * distance


def _relative(columns: Sequence[Floats]) -> Floats:
    """One row for each point, divided by its largest entry."""
    table = np.stack(columns, axis=1)
    return np.asarray(table / np.maximum(np.abs(table).max(axis=1, keepdims=True), 2.0**-1000))


def _combined(coefficients: Floats, basis: Sequence[str], denominator: int) -> str:
    short = [Fraction(float(value)).limit_denominator(denominator) for value in coefficients]
    return " + ".join(f"{value}*{own}" for value, own in zip(short, basis, strict=True) if value) or "0"


def _written(stated: StatedCells, function: str, second: str, verdict: str) -> tuple[str, Record]:
    common = {"cells": stated.record, "function": function, "second": second}
    if verdict == ASYMPTOTICALLY_STABLE:
        more = {"verdict": verdict, "everywhere": False, "level": None, "below": False, "rate": None}
        return "lyapunov", {**common, **more}
    return "instability", {**common, "direction": ["3", "7"]}
