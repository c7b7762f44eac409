"""What every wheel adds to the slope and to the curvature of D, per unit of its load, about a spin at the point.

For ``D = sum N_i f_i`` about the twist ``xi_0 = (0, 0, omega)`` (centred scene)::

    grad f_i = pull_i,        Hess f_i = bend_i w_i w_i^T        (bend_i = 0 at a corner of the friction set)

as in :mod:`nonsmooth.proofs.boxes.linearization`.  Let one matrix B (3 x 2) give ``pull_i = B p_i`` for all
wheels.  Then at every centre of mass c and under *every* admissible load ``grad D(xi_0) = sum N_i B p_i = B c``: it
does not depend on how the wheels share the weight.  So ``xi_0`` minimizes D at c = 0 under every load, and to first
order the body moves with ``xi - xi_0 = -H(N)^-1 B c``, ``H(N) = sum N_i bend_i w_i w_i^T``.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

from nonsmooth.analysis.cells.load_sets import Loads
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.analysis.cells.polygon import square
from nonsmooth.proofs.boxes.linearization import Slip, Slope, slips_at
from nonsmooth.symbolic.mechanics.constraints import added, combine, scaled
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import cross


def wheel_slips(scene: Scene, omega: Number) -> tuple[Slip[Number], ...] | None:
    """Every wheel about ``(0, 0, omega)``; None where a term of D has no two derivatives, or a wheel no friction."""
    slips = slips_at(scene, under_load(scene, (scene.field.one,) * len(scene.wheels)), omega)
    return slips if len(slips) == len(scene.wheels) and all(slip.is_smooth for slip in slips) else None


def under_load(scene: Scene, loads: Loads) -> LoadRegion:
    """The loads at the point of a centred scene as the clauses at a point ask for them; how they change is left out."""
    zero = scene.field.zero
    domain = square(scene.check.equilibrium, scene.check.radius)
    loaded = frozenset(wheel.index for wheel, load in zip(scene.wheels, loads, strict=True) if load)
    return LoadRegion(domain, tuple((load, zero, zero) for load in loads), loaded)


def common_slope(slips: Sequence[Slip[Number]]) -> Slope | None:
    """The B with ``pull_i = B p_i`` for every wheel; None where there is none."""
    pair = next(((p, q) for p, q in combinations(slips, 2) if cross(p.position, q.position)), None)
    if pair is None:
        return None
    p, q = pair
    scale = cross(p.position, q.position).inverse()
    slope = (
        scaled(added(scaled(p.pull, q.position[1]), scaled(q.pull, -p.position[1])), scale),
        scaled(added(scaled(q.pull, p.position[0]), scaled(p.pull, -q.position[0])), scale),
    )
    return slope if has_slope(slips, slope) else None


def has_slope(slips: Sequence[Slip[Number]], slope: Slope) -> bool:
    """Whether ``pull_i = B p_i`` for every wheel."""
    return all(combine(wheel.position, slope) == wheel.pull for wheel in slips)
