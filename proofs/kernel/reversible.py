"""The search for a reflection that reverses time, with a function W (:mod:`nonsmooth.proofs.checker.reversible`).

W is asked to change little in a turn.  Where first terms are those of an oscillator ``x' = b y, y' = -a x^k`` (for
``x > 0``, with another k and a for ``x < 0``), ``b y^2/2`` and the integral of ``a x^k`` make one that they keep; about
a centre of linear fields ``x^2 + y^2`` does as well.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction
from itertools import product

from nonsmooth.proofs.checker.cells import Cell, Inclusion, System
from nonsmooth.proofs.checker.lyapunov import sign_along
from nonsmooth.proofs.checker.reversible import Matrix, require_reversed
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.kernel.cells import build_inclusion, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import Entry, NotShownError, SampledProofs, Search
from nonsmooth.symbolic.piecewise import parse_piecewise
from nonsmooth.symbolic.switched_system import PLANE, SwitchedSystem

MIRRORS = ((1, 0, 0, -1), (-1, 0, 0, 1), (0, 1, 1, 0), (0, -1, -1, 0))
SHARES = (Fraction(1), Fraction(1, 4), Fraction(1, 16))  # of the checked square
FACTORS = (4, 64, -4, -64)  # K
WORK = 4_000  # coefficients looked at for one claim


def show_reversible_of(system: SwitchedSystem) -> Entry:
    """Evidence that the checked point is stable because a reflection reverses time.

    Args:
        system: in two states, with one right-hand side.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system, None)
    if len(system.states) != len(PLANE) or len(subject.rhs) > 1 or system.by_roots is not None:
        raise NotShownError("a reflection is looked for where one field acts on a plane")
    inclusion = build_inclusion(stated_cells(system, system.check.radius), subject, search)
    mirrors = [own for own in map(_rows, MIRRORS) if _is_reversed(subject, inclusion, own)]
    for mirror, function in product(mirrors, _functions(inclusion, subject.states) if mirrors else ()):
        bent = surfaces_of(system, parse_piecewise(function, system.states))
        for share, factor in product(SHARES, FACTORS):
            hypotheses = {
                "cells": stated_cells(system, system.check.radius * share, bent).record,
                "function": function,
                "mirror": [[str(value) for value in row] for row in mirror],
                "factor": str(factor),
            }
            try:
                SampledProofs().entry(subject, "reversible", hypotheses)
                return Search(WORK).entry(subject, "reversible", hypotheses)
            except NotShownError:
                continue
    raise NotShownError("no reflection was found that reverses time")


def reflection_text(mirror: Sequence[Sequence[str]], states: Sequence[str]) -> str:
    """The image of a place, as in ``(x, -y)``."""
    images = []
    for row in mirror:
        (k,) = (k for k, value in enumerate(row) if value != "0")
        images.append(states[k] if row[k] == "1" else f"-{states[k]}")
    return f"({', '.join(images)})"


def _rows(values: Sequence[int]) -> Matrix:
    a, b, c, d = map(Fraction, values)
    return [[a, b], [c, d]]


def _is_reversed(subject: System, inclusion: Inclusion, mirror: Matrix) -> bool:
    try:
        require_reversed(subject, inclusion, mirror)
    except RejectedError:
        return False
    return True


def _functions(inclusion: Inclusion, states: Sequence[str]) -> Iterator[str]:
    """Proposals of W."""
    for heavy in range(2):
        function = _energy(inclusion, states, heavy)
        if function is not None:
            yield function
    yield " + ".join(f"{name}**2" for name in states)


def _energy(inclusion: Inclusion, states: Sequence[str], heavy: int) -> str | None:
    """What the first terms of an oscillator keep; None where they are of another kind.

    Args:
        inclusion: the cells near the point.
        states: their names.
        heavy: the number of x in ``x' = b y``.
    """
    light = 1 - heavy
    radius = inclusion.domain.radius
    parts = []
    for side in (1, -1):
        ray = [Fraction(side) if k == heavy else Fraction(0) for k in range(2)]
        cell = next((own for own in inclusion.cells if _holds(inclusion, own, ray)), None)
        if cell is None:
            return None
        field = cell.fields[0][1]
        speed = field[heavy].slope(light) / radius
        forces = field[light].parts_at(ray)
        degree = min((own for own, value in forces.items() if value), default=None)
        if degree is None or side * speed * forces[degree] >= 0:
            return None
        force = abs(forces[degree]) / radius**degree
        name = states[heavy] if side > 0 else f"-{states[heavy]}"
        parts.append(f"{force / abs(speed) / (degree + 1)}*relu({name})**{degree + 1}")
    return f"{states[light]}**2/2 + {' + '.join(parts)}"


def _holds(inclusion: Inclusion, cell: Cell, ray: Sequence[Fraction]) -> bool:
    """Whether a cell holds a ray, or has it on its border."""
    surfaces = inclusion.surfaces
    return all(sign_along(surfaces.signed(j, sign), ray) >= 0 for j, sign in enumerate(cell.signs))
