"""Rule ``box`` under every load: the slopes of D at a spin about the point, which are linear in the loads.

At ``xi_0 = (0, 0, omega)`` let Z be the rows without residual, ``s_k`` the sign of the other residuals and ``b_k`` the
friction of a row per unit of load.  Along a direction m ::

    D'(xi_0; m) = sum_i N_i price_i(m),
    price_i(m) = sum_{k of i, in Z} b_k |a_k . m| + sum_{k of i, not in Z} b_k s_k a_k . m

which is linear on the cells that the planes ``a_k . m = 0``, k in Z, cut out of all m.  So, where the ``a_k`` span, D
falls along no m iff it falls along none of the rays ``+-a_k x a_l``, and ``min over loads of D' >= 0`` is a linear
program for each of them, solved at a corner of the set of loads.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import combinations

from nonsmooth.analysis.cells.box import build_box_partition
from nonsmooth.analysis.cells.filippov import filippov_twists
from nonsmooth.analysis.cells.load_sets import Loads, LoadSet, priced
from nonsmooth.analysis.cells.loads import LoadError
from nonsmooth.symbolic.constraints import Row, Triple, Twist, independent, inner, outer, rows_with_friction, scaled
from nonsmooth.symbolic.measured_loads import carried_table
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import separating_direction
from nonsmooth.symbolic.scene import Contact, Scene

HALVINGS = 12  # of the square in which a load is followed: at the point the loads are positive


def box_situation(scene: Scene, loads: LoadSet, omega: Number) -> Number | None:
    """The least slope of D at ``(0, 0, omega)``, over all loads and edges; None where the rows there do not span."""
    twist = Twist(scene.field.zero, scene.field.zero, omega)
    rows = rows_with_friction(scene)
    rays = _rays([row for row in rows if not row.residual(twist)])
    if rays is None:
        return None
    every = (prices_along(scene, rows, twist, ray) for ray in rays)
    return min(priced(prices, loads.bound.lowest(prices)) for prices in every)


def moving_loads(scene: Scene, loads: LoadSet) -> Iterator[Loads]:
    """Loads under which D falls from rest; every wheel carries under them."""
    reached = loads.reached
    yield reached.middle
    twist = Twist(scene.field.zero, scene.field.zero, scene.field.zero)
    rows = rows_with_friction(scene)
    for ray in _rays([row for row in rows if not row.residual(twist)]) or ():
        prices = prices_along(scene, rows, twist, ray)
        lowest = reached.lowest(prices)
        if priced(prices, lowest).sign() < 0:
            yield tuple((3 * a + b) / 4 for a, b in zip(lowest, reached.middle, strict=True))


def _rays(tight: Sequence[Row]) -> list[Triple] | None:
    """``+-a_k x a_l`` of the rows without residual; None where they do not span."""
    normals = [row.normal for row in tight]
    if len(independent(normals)) < 3:
        return None
    products = {outer(a, b): None for a, b in combinations(normals, 2)}
    return [scaled(ray, side) for ray in products if any(ray) for side in (1, -1)]


def prices_along(scene: Scene, rows: Sequence[Row], twist: Twist, ray: Triple) -> list[Number]:
    """``price_i(m)`` for every wheel."""
    prices = [scene.field.zero] * len(scene.wheels)
    for row in rows:
        residual, rate = row.residual(twist), inner(row.normal, ray)
        change = rate * residual.sign() if residual else abs(rate)
        prices[scene.places[row.wheel.index]] += row.friction * change / row.wheel.length
    return prices


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
