"""A function V of two states where leading terms with weights decide: twisting, relays under inertia and the like.

Let F and G be linear forms, F of twice the weight of G: ``x' = y``, ``y' = -a sign(x) - b sign(y)`` has ``F = x`` and
``G = y``.  A linear program in floats finds ``V = c Abs(F) + d F + G**2`` that does not rise; better it cannot do where
``G = 0``, because its derivative has a factor G there.  Further functions show that no solution stays where V is kept.
"""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import permutations
from typing import Any

import numpy as np
from scipy.optimize import linprog

from nonsmooth.proofs.checker.cells import Inclusion
from nonsmooth.proofs.checker.polynomials import lie_derivative
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE, Statement
from nonsmooth.proofs.kernel.curved_cells import build_inclusion, started
from nonsmooth.proofs.kernel.samples import Floats, sample_points, values_at
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.stated_cells import scaled, stated_cells
from nonsmooth.proofs.systems.tangent_fan import form_lines, lowest_form
from nonsmooth.symbolic.numbers.polynomial import Polynomial as Form
from nonsmooth.symbolic.switched_system import SwitchedSystem

RADII = (Fraction(1, 4), Fraction(1, 16))  # half-widths of cubes, over that of the scene
DENOMINATORS = (1 << 2, 1 << 5, 1 << 9)  # of the coefficients, tried in turn
LEAST, MOST = 1 / 16, 64.0  # of c over d, and of both
SLACK = 2.0**-20  # by which V may rise in floats
DIRECTION = ["3", "7"]  # in which V is negative near an unstable point


def show_by_weights(
    system: SwitchedSystem, verdict: str, search: Search | None = None
) -> tuple[dict[str, Any], list[Statement]]:
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
        for share in RADII:
            cells = stated_cells(system, system.check.radius * share, [heavy])
            if any(surface.degree > 1 for surface in cells.surfaces):
                continue  # V would have to bend on curves
            found = _coefficients(build_inclusion(cells, subject, search, basis), grows=grows)
            for denominator in DENOMINATORS if found else ():
                c, d = (Fraction(value).limit_denominator(denominator) for value in found)
                function = f"{c}*{basis[0]} + {d}*{basis[1]} + {basis[2]}"
                function = f"-({function})" if grows else function
                below = Fraction(0) if grows else None
                second = find_second(subject, cells.record, function, search, below=below)
                if second is not None:
                    common = {"cells": cells.record, "function": function, "second": second}
                    return search.entry(subject, *_theorem(common, grows=grows))
    raise NotShownError("no function was found for leading terms with weights")


def _theorem(common: dict[str, Any], *, grows: bool) -> tuple[str, dict[str, Any]]:
    if grows:
        return "instability", {**common, "direction": DIRECTION}
    options = {"everywhere": False, "level": None, "below": False, "rate": None}
    return "lyapunov", {**common, "verdict": ASYMPTOTICALLY_STABLE, **options}


def _frames(system: SwitchedSystem) -> Iterator[tuple[Form, Form]]:
    """Pairs of lines through the point: tangents of switching curves, and the axes."""
    states = system.displaced(system.states)
    lines = [own - centre for own, centre in zip(states, system.check.equilibrium, strict=True)]
    for surface in system.surfaces(states):
        if surface.degree and (0, 0) not in surface.terms:
            lines += [own for own in form_lines(lowest_form(surface)) or [] if scaled(own) not in map(scaled, lines)]
    yield from permutations(lines, 2)


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
