"""What every wheel adds to the slope and to the curvature of D, per unit of its load, about a spin at the point.

For ``D = sum N_i f_i`` about the twist ``xi_0 = (0, 0, omega)`` (centred scene)::

    grad f_i = pull_i,        Hess f_i = bend_i w_i w_i^T        (bend_i = 0 at a corner of the friction set)

as in :mod:`nonsmooth.proofs.clauses.at_point.linearization`.  Let one matrix B (3 x 2) give ``pull_i = B p_i`` for all
wheels.  Then at every centre of mass c and under *every* admissible load ``grad D(xi_0) = sum N_i B p_i = B c``: it
does not depend on how the wheels share the weight.  So ``xi_0`` minimizes D at c = 0 under every load, and to first
order the body moves with ``xi - xi_0 = -H(N)^-1 B c``, ``H(N) = sum N_i bend_i w_i w_i^T``.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import TypeAlias

from nonsmooth.analysis.cells.load_sets import Loads
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.cells.polygon import square
from nonsmooth.proofs.clauses.at_point.linearization import slips_at
from nonsmooth.symbolic.constraints import Triple, added, combine, scaled
from nonsmooth.symbolic.friction_set import BorderPiece
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector, cross
from nonsmooth.symbolic.scene import Scene

Slope: TypeAlias = tuple[Triple, Triple]  # the columns of B


@dataclass(frozen=True)
class WheelPull:
    """One wheel about a spin, per unit of its load; ``pull`` is ``grad f``, ``bend w w^T`` the Hessian of f."""

    position: Vector
    pull: Triple
    bend: Number
    w: Triple


def wheel_pulls(scene: Scene, omega: Number) -> tuple[WheelPull, ...] | None:
    """Every wheel about ``(0, 0, omega)``; None where a term of D has no two derivatives, or a wheel no friction."""
    slips = slips_at(scene, under_load(scene, (scene.field.one,) * len(scene.wheels)), omega)
    if len(slips) < len(scene.wheels) or not all(slip.is_smooth for slip in slips):
        return None
    found = []
    for wheel, slip in zip(scene.wheels, slips, strict=True):
        (a, b), (roll, side) = slip.rows, slip.squares
        bend, w = scene.field.zero, a
        if slip.piece is BorderPiece.ARC:
            w = added(scaled(a, slip.across), scaled(b, -slip.along))
            bend = roll * side / (slip.size * slip.squared_size)
        found.append(WheelPull(wheel.position, scaled(slip.pull, slip.size.inverse()), bend, w))
    return tuple(found)


def under_load(scene: Scene, loads: Loads) -> LoadRegion:
    """The loads at the point of a centred scene as the clauses at a point ask for them; how they change is left out."""
    zero = scene.field.zero
    domain = square(scene.check.equilibrium, scene.check.radius)
    loaded = frozenset(wheel.index for wheel, load in zip(scene.wheels, loads, strict=True) if load)
    return LoadRegion(domain, tuple((load, zero, zero) for load in loads), loaded)


def common_slope(pulls: Sequence[WheelPull]) -> Slope | None:
    """The B with ``pull_i = B p_i`` for every wheel; None where there is none."""
    pair = next(((p, q) for p, q in combinations(pulls, 2) if cross(p.position, q.position)), None)
    if pair is None:
        return None
    p, q = pair
    scale = cross(p.position, q.position).inverse()
    slope = (
        scaled(added(scaled(p.pull, q.position[1]), scaled(q.pull, -p.position[1])), scale),
        scaled(added(scaled(q.pull, p.position[0]), scaled(p.pull, -q.position[0])), scale),
    )
    return slope if has_slope(pulls, slope) else None


def has_slope(pulls: Sequence[WheelPull], slope: Slope) -> bool:
    """Whether ``pull_i = B p_i`` for every wheel."""
    return all(combine(wheel.position, slope) == wheel.pull for wheel in pulls)


def inward_pull(slope: Slope) -> Number | None:
    """``beta > 0`` where ``B c = (beta c, 0)``; None for any other B."""
    (a, b, m), (c, d, n) = slope
    return a if a == d and a.sign() > 0 and not (b or c or m or n) else None
