"""Instability by a function that does not rise: with time reversed, it is a weak Lyapunov function of the system.

A relay that gains energy, ``x' = y, y' = -sign(x) + a y``, has ``V = -(abs(x) + y^2/2)`` with ``V' = -a y^2``.  The
function W that shows that nothing stays where ``V' = 0`` is :mod:`nonsmooth.proofs.kernel.second_function`'s.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

from nonsmooth.proofs.checker.cells import Inclusion, read_system
from nonsmooth.proofs.checker.lyapunov import Lyapunov
from nonsmooth.proofs.kernel.search import Search
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.sign_cells import surfaces_of
from nonsmooth.proofs.kernel.stated_cells import stated_cells
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.systems.lyapunov_search import find_weak_lyapunov
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.switched_system import SwitchedSystem

DIRECTIONS = ((1, 1), (-1, 1), (2, 5), (7, -3), (-5, 11))  # one of them is inside a cell


def find_weak_growth(system: SwitchedSystem, search: Search | None = None) -> dict[str, Any] | None:
    """Hypotheses of the theorem ``instability`` by a V that does not rise and further functions.

    Args:
        system: in two states, with rational numbers.
        search: keeps the proofs that are found.

    Returns:
        The hypotheses; None where nothing was found.
    """
    proofs = Search() if search is None else search
    found = find_weak_lyapunov(reversed_system(system))
    if found is None:
        return None
    function, subject = f"-({found.formula.text})", read_system(about(system))
    cells = stated_cells(system, found.radius, surfaces_of(system, found.formula)).record
    second = find_second(subject, cells, function, proofs)
    if second is None:
        return None
    stated = Lyapunov(Inclusion(subject, cells, [function], proofs), proofs)
    leading = (own for own in DIRECTIONS if stated.is_negative_along(list(map(Fraction, own))))
    direction = next(leading, None)
    if direction is None:
        return None
    return {"cells": cells, "function": function, "second": second, "direction": list(map(str, direction))}


def reversed_system(system: SwitchedSystem) -> SwitchedSystem:
    """The system with time reversed."""

    def negated(sides: Sequence[PiecewiseExpression]) -> tuple[PiecewiseExpression, ...]:
        return tuple(parse_piecewise(f"-({side.text})", system.states) for side in sides)

    return replace(system, rhs=negated(system.rhs), others=tuple(map(negated, system.others)))
