"""Homogeneous systems, with weights of the states: what holds near the point holds everywhere, and who arrives in time.

F is homogeneous of degree d with weights ``r_k > 0`` if ``F(D x) = l^d D F(x)``, ``D = diag(l^r_1, ..., l^r_n)``,
for every l > 0 (x from the point): with x(t) also ``D x(l^d t)`` is a solution.  So a point that attracts attracts
everywhere; for d < 0 every solution arrives in finite time (Levant 2005; Bernuau, Efimov, Perruquetti and Polyakov
2014).  On each cell this asks of every term of the velocity of x_k that its weight is ``d + r_k``, and of all terms of
a surface that they have one weight: linear equations for weights and degree.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

import numpy as np

from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.kernel.cells import BeyondReachError, adjoining, build_cells, stated_cells
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

LARGEST = 64  # denominators of weights, of which the least is one

Row = tuple[int, ...]  # coefficients of the weights of the coordinates, and of the degree


@dataclass(frozen=True)
class Homogeneity:
    """Weights and degree of a homogeneous system.

    Attributes:
        weights: r of each state.
        orders: q of the root that stands for each state, of which the weight is r/q; 1 for a state itself.
        states: their names.
        degree: d.
    """

    weights: tuple[Fraction, ...]
    orders: tuple[int, ...]
    states: tuple[str, ...]
    degree: Fraction

    @property
    def arrives(self) -> bool:
        """Whether solutions of a point that attracts arrive in finite time."""
        return self.degree < 0

    def hypotheses(self, system: SwitchedSystem, entry: Record) -> Record:
        """Of theorem ``homogeneous``, with the entry of the theorem that shows that the point attracts.

        Raises:
            BeyondReachError: for too many cells.
        """
        weights = [str(weight / order) for weight, order in zip(self.weights, self.orders, strict=True)]
        cells = stated_cells(system, None, irrational=True)
        return {"cells": cells.record, "weights": weights, "entry": entry}

    def __str__(self) -> str:
        weights = ", ".join(f"{name}: {weight}" for name, weight in zip(self.states, self.weights, strict=True))
        return f"homogeneous of degree {self.degree} with the weights {weights}"


def homogeneity_of(system: SwitchedSystem, radius: Number | None = None) -> Homogeneity | None:
    """Weights with which the stated field is homogeneous about the point; None where there are none.

    Args:
        system: in any number of states; of roots of states the field in the time of the states counts.
        radius: half the side of a cube in which surfaces beside the point are left out; None for the whole space.
    """
    roots = () if system.by_roots is None else system.by_roots.roots.names.values()
    at = system.named(system.check.equilibrium)
    if system.rewriting.waves or system.rewriting.denominators or any(at[name] for name in roots):
        return None
    root_orders = {} if system.by_roots is None else system.by_roots.roots.order
    orders = tuple(root_orders.get(name, 1) for name in system.stated_states)
    try:
        rows = sorted(set(_rows(system, orders, radius)))
    except (BeyondReachError, SceneError):
        return None
    count = len(system.states)
    costs, bounds = [*[1.0] * count, 0.0], [*[(1.0, None)] * count, (None, None)]
    equations = np.array(rows, dtype=float).reshape(-1, count + 1)
    solution = solve_program(costs, A_eq=equations, b_eq=np.zeros(len(rows)), bounds=bounds)
    if solution.status != 0:
        return None
    *weights, degree = (Fraction(float(value)).limit_denominator(LARGEST) for value in solution.x)
    holds = all(sum(c * value for c, value in zip(row, (*weights, degree), strict=True)) == 0 for row in rows)
    if not holds or min(weights) <= 0:
        return None
    of_states = tuple(weight * order for weight, order in zip(weights, orders, strict=True))
    return Homogeneity(of_states, orders, system.stated_states, degree)


def _rows(system: SwitchedSystem, orders: Sequence[int], radius: Number | None) -> Iterator[Row]:
    """What weights of the coordinates, and the degree, must solve."""
    stated = system if system.by_roots is None else system.by_roots.unscaled
    cells = build_cells(stated, radius, irrational=True)
    for surface in cells.surfaces:
        if radius is not None and surface.at_origin:
            continue
        for first, second in pairwise(surface.terms):
            yield (*map(int.__sub__, first, second), 0)
    for cell in adjoining(cells) if radius is not None else cells.cells:
        for velocity in cell.velocities:
            for k, part in enumerate(velocity):
                for exponents in part.terms:
                    yield (*(e - orders[k] * (k == j) for j, e in enumerate(exponents)), -1)
