"""A function V of two states where leading terms with weights decide: twisting, relays under inertia and the like.

Let F and G be linear forms, F of twice the weight of G: ``x' = y``, ``y' = -a sign(x) - b sign(y)`` has ``F = x`` and
``G = y``.  F may also be what a field switches by, such as ``x + y Abs(y)`` of a bang-bang law on a curved line.  A
linear program in floats finds ``V = c Abs(F) + d F + G**2`` that does not rise; better it cannot do where ``G = 0``,
because its derivative has a factor G there.  Further functions show that no solution stays where V is kept.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from itertools import permutations
from typing import Any

import numpy as np
from scipy.optimize import linprog

from nonsmooth.proofs.checker.cells import Inclusion
from nonsmooth.proofs.checker.polynomials import lie_derivative
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE
from nonsmooth.proofs.kernel.curved_cells import build_inclusion, sharpened, started
from nonsmooth.proofs.kernel.samples import Floats, sample_points, values_at
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.sign_cells import surfaces_of
from nonsmooth.proofs.kernel.stated_cells import scaled, stated_cells
from nonsmooth.proofs.kernel.tangents import form_lines, lowest_form
from nonsmooth.symbolic.piecewise import parse_piecewise
from nonsmooth.symbolic.switched_system import SwitchedSystem

RADII = (Fraction(1, 4), Fraction(1, 16))  # half-widths of cubes, over that of the scene
DENOMINATORS = (1 << 2, 1 << 5, 1 << 9)  # of the coefficients, tried in turn
LEAST, MOST = 1 / 16, 64.0  # of c over d, and of both
SLACK = 2.0**-20  # by which V may rise in floats
DIRECTION = ["3", "7"]  # in which V is negative near an unstable point


def show_by_weights(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence of a verdict by V and further functions, where one linear form has twice the weight of another.

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
    grows = verdict == UNSTABLE
    for heavy, light in _frames(system) if verdict != STABLE else ():
        basis = (f"Abs({heavy})", f"({heavy})", f"({light})**2")
        bent = surfaces_of(system, parse_piecewise(basis[0], system.states))
        for share in RADII:
            cells = stated_cells(system, system.check.radius * share, bent)
            if len(bent) == 1 and any(surface.degree > 1 for surface in cells.surfaces):
                continue  # V would have to bend on curves
            cells = sharpened(cells, subject, search)
            try:
                inclusion = build_inclusion(cells, subject, search, basis)
            except NotShownError:
                continue  # Abs(F) is not shown to be continuous
            for function in _proposals(inclusion, basis, grows=grows):
                below = Fraction(0) if grows else None
                second = find_second(subject, cells.record, function, search, below=below)
                if second is not None:
                    theorem = "instability" if grows else "lyapunov"
                    return search.entry(subject, theorem, _hypotheses(cells.record, function, second, grows=grows))
    raise NotShownError("no function was found for leading terms with weights")


def _hypotheses(cells: dict[str, Any], function: str, second: dict[str, Any], *, grows: bool) -> dict[str, Any]:
    if grows:
        return {"cells": cells, "function": function, "second": second, "direction": DIRECTION}
    return stability_hypotheses(cells, function, ASYMPTOTICALLY_STABLE, second)


def _proposals(inclusion: Inclusion, basis: Sequence[str], *, grows: bool) -> list[str]:
    """The function with coefficients that are rounded more and more finely, each once."""
    found = []
    values = _coefficients(inclusion, grows=grows)
    for denominator in DENOMINATORS if values else ():
        c, d = (Fraction(value).limit_denominator(denominator) for value in values)
        function = f"{c}*{basis[0]} + {d}*{basis[1]} + {basis[2]}"
        found.append(f"-({function})" if grows else function)
    return list(dict.fromkeys(found))


def _frames(system: SwitchedSystem) -> Iterator[tuple[str, str]]:
    """Pairs of F and G: what fields switch by, where that switches too; tangents of switching curves, and the axes."""
    states = system.displaced(system.states)
    lines = [own - centre for own, centre in zip(states, system.check.equilibrium, strict=True)]
    for surface in system.surfaces(states):
        if surface.degree and (0, 0) not in surface.terms:
            lines += [own for own in form_lines(lowest_form(surface)) or [] if scaled(own) not in map(scaled, lines)]
    for text in dict.fromkeys(_bent_lines(system)) if not any(system.check.equilibrium) else ():
        curves = surfaces_of(system, parse_piecewise(f"Abs({text})", system.states))
        tangents = [scaled(lowest_form(curve)) for curve in curves if curve.degree > 1]
        yield from ((text, str(own)) for own in lines if scaled(own) not in tangents)
    yield from permutations(map(str, lines), 2)


def _bent_lines(system: SwitchedSystem) -> Iterator[str]:
    """What right-hand sides take the sign of, where that itself switches."""
    for side in system.rhs:
        for part in side.switching_parts:
            call = part.tree
            if isinstance(call, ast.Call) and len(call.args) == 1:
                inner = replace(part, tree=call.args[0])
                if inner.switching_parts:
                    yield ast.unparse(inner.tree)


def _coefficients(inclusion: Inclusion, *, grows: bool) -> list[float]:
    """The c and d for which V falls most in the mean and rises at no sample, or none; in reversed time where it grows.

    Args:
        inclusion: with the functions ``Abs(F)``, F and ``G**2`` on its cells.
        grows: whether V must not fall.
    """
    rates = _rates(inclusion) * (-1.0 if grows else 1.0)
    sizes = np.maximum(np.abs(rates).max(axis=1), np.finfo(float).tiny)
    rows = rates / sizes[:, None]
    positive = np.array([[-1.0, 1.0], [-1.0, -1.0]])
    table = np.vstack([rows[:, :2], positive])
    limits = np.concatenate([SLACK - rows[:, 2], np.full(2, -LEAST)])
    found = linprog(rows[:, :2].mean(axis=0), table, limits, bounds=[(0, MOST), (-MOST, MOST)])
    return list(map(float, found.x)) if found.success else []


def _rates(inclusion: Inclusion) -> Floats:
    """The derivatives of the functions at points of the cells, one row for each point and field."""
    points = sample_points(inclusion.count, bounded=True)
    listed = inclusion.surfaces.listed
    signs = np.stack([values_at(own, points)[0] > 0 for own in listed], axis=1)
    found = []
    for cell in inclusion.cells:
        inside = points[(signs == (np.array(cell.signs) > 0)).all(axis=1)]
        for _, field in cell.fields:
            columns = [values_at(lie_derivative(own, field), inside)[0] for own in cell.functions]
            found.append(np.stack(columns, axis=1))
    return np.vstack(found)
