"""Rule ``box`` under every load: the slopes of D at a spin about the point, which are linear in the loads.

At ``xi_0 = (0, 0, omega)`` let Z be the rows without residual, ``s_k`` the sign of the other residuals and ``b_k`` the
friction of a row per unit of load.  Along a direction m ::

    D'(xi_0; m) = sum_i N_i price_i(m),
    price_i(m) = sum_{k of i, in Z} b_k |a_k . m| + sum_{k of i, not in Z} b_k s_k a_k . m

which is linear on the cells that the planes ``a_k . m = 0``, k in Z, cut out of all m.  So, where the ``a_k`` span, D
falls along no m iff it falls along none of the rays ``+-a_k x a_l``, and ``min over loads of D' >= 0`` is a linear
program for each of them, solved at a corner of the set of loads.

Twenty wheels have hundreds of rays and of corners: floats with a bound of their error leave out the slopes that are
certainly positive, and every other is computed exactly.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import combinations
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from nonsmooth.analysis.cells.arrangement import FLOAT_DOUBT
from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.load_sets import LoadPolytope, Loads, LoadSet, priced
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.proofs.clauses.every_load.float_loads import float_loads
from nonsmooth.symbolic.constraints import (
    Row,
    Triple,
    Twist,
    cross_product,
    independent,
    inner,
    rows_with_friction,
    scaled,
)
from nonsmooth.symbolic.measured_loads import carried_table
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import separating_direction
from nonsmooth.symbolic.scene import Contact, Scene

Floats: TypeAlias = NDArray[np.float64]

HALVINGS = 12  # of the square in which a load is followed: at the point the loads are positive
SUSPECTS = 4  # loads that are tried as witnesses: each takes the cells of a known load


@dataclass(frozen=True, eq=False)
class BoxSlopes:
    """The slopes of D at one twist.

    Attributes:
        scene: the array, centred.
        rows: those with friction.
        signs: of their residuals at the twist.
        rays: the directions that decide.
    """

    scene: Scene
    rows: tuple[Row, ...]
    signs: tuple[int, ...]
    rays: tuple[Triple, ...]

    def prices(self, k: int) -> list[Number]:
        """``price_i`` along a ray, exactly."""
        prices = [self.scene.field.zero] * len(self.scene.wheels)
        for row, side in zip(self.rows, self.signs, strict=True):
            rate = inner(row.normal, self.rays[k])
            change = rate * side if side else abs(rate)
            prices[self.scene.places[row.wheel.index]] += row.friction * change / row.wheel.length
        return prices

    @cached_property
    def float_prices(self) -> tuple[Floats, Floats]:
        """Rounded prices of all rays, shape (rays, wheels), and bounds of their errors."""
        normals = np.array([[float(x) for x in row.normal] for row in self.rows])
        weights = np.array([float(row.friction) / float(row.wheel.length) for row in self.rows])
        rays = np.array([[float(x) for x in ray] for ray in self.rays])
        signs, rates = np.array(self.signs), rays @ normals.T
        parts = np.where(signs == 0, np.abs(rates), rates * signs) * weights
        sizes = np.abs(rays) @ np.abs(normals).T * weights
        wheels = np.zeros((len(self.rows), len(self.scene.wheels)))
        wheels[np.arange(len(self.rows)), [self.scene.places[row.wheel.index] for row in self.rows]] = 1
        return parts @ wheels, sizes @ wheels * FLOAT_DOUBT

    def float_lowest(self, loads: LoadPolytope) -> tuple[Floats, Floats]:
        """The least slope along every ray over a set of loads, rounded, and bounds of the errors."""
        prices, doubts = self.float_prices
        floats = float_loads(loads)
        return floats.lowest(prices), doubts @ floats.sizes + floats.doubt(np.abs(prices))

    def least_sign(self, loads: LoadPolytope) -> int:
        """The sign of the least slope over all rays and loads."""
        values, doubt = self.float_lowest(loads)
        least = 1
        for k in np.argsort(values):
            if values[k] > doubt[k]:
                continue
            prices = self.prices(int(k))
            least = min(least, priced(prices, loads.lowest(prices)).sign())
            if least < 0:
                break
        return least


def build_slopes(scene: Scene, omega: Number) -> BoxSlopes | None:
    """The slopes at ``(0, 0, omega)``; None where the rows that hold there do not span."""
    twist = Twist(scene.field.zero, scene.field.zero, omega)
    rows = tuple(rows_with_friction(scene))
    signs = tuple(row.residual(twist).sign() for row in rows)
    rays = _rays([row for row, side in zip(rows, signs, strict=True) if not side])
    return None if rays is None else BoxSlopes(scene, rows, signs, rays)


def _rays(tight: Sequence[Row]) -> tuple[Triple, ...] | None:
    """``+-a_k x a_l`` of the rows without residual; None where they do not span."""
    normals = [row.normal for row in tight]
    if len(independent(normals)) < 3:
        return None
    products = {cross_product(a, b): None for a, b in combinations(normals, 2)}
    return tuple(scaled(ray, side) for ray in products if any(ray) for side in (1, -1))


def moving_loads(scene: Scene, loads: LoadSet) -> Iterator[Loads]:
    """Loads under which D falls from rest, the steepest first; every wheel carries under them."""
    reached = loads.reached
    yield reached.middle
    slopes = build_slopes(scene, scene.field.zero)
    if slopes is None:
        return
    values, _ = slopes.float_lowest(reached)
    for k in np.argsort(values)[:SUSPECTS]:
        prices = slopes.prices(int(k))
        lowest = reached.lowest(prices)
        if priced(prices, lowest).sign() < 0:
            yield tuple((3 * a + b) / 4 for a, b in zip(lowest, reached.middle, strict=True))


def is_driven_away(scene: Scene, load: Loads) -> bool:
    """Whether the point is no equilibrium under a load that is carried to its neighbourhood; every wheel carries."""
    table = carried_table(load, [wheel.position for wheel in scene.wheels])
    known = replace(scene, contact=Contact(scene.contact.rule, table))
    for _ in range(HALVINGS):
        try:
            partition = build_box_partition(known)
        except LoadError:
            known = replace(known, check=replace(known.check, radius=known.check.radius / 2))
            continue
        zero = scene.field.zero
        velocities = [twist.velocity for twist in filippov_twists(partition, (zero, zero))]
        return separating_direction(velocities) is not None
    return False
