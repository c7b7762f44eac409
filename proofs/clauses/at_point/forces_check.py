"""What a motion ``(0, 0, omega)`` of an array asks of the wheels, by forces and moments in the plane.

The verdicts under rule ``ellipse`` are built from rows of constraints; here they are verified from slips
``q = omega J p - u d``, forces ``F = N M q/f`` with ``M = mu_R^2 d d^T + mu_S^2 n n^T`` and ``f^2 = q . M q``, and
their moments ``p x F``.  The Hessian of f is ``M/f - (M q)(M q)^T/f^3``.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from nonsmooth.analysis.cells.loads import Affine, LoadRegion
from nonsmooth.proofs.clauses.at_point.balance import RestBalance
from nonsmooth.proofs.clauses.at_point.linearization import Linearization
from nonsmooth.symbolic.constraints import Triple, independent, inner, outer, roll_row, scaled, total
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.plane import Vector, cross, dot, turned
from nonsmooth.symbolic.scene import Scene, Wheel


@dataclass(frozen=True)
class _Slip:
    """A loaded wheel that slips.

    Attributes:
        load: N as an affine form of c.
        size: f.
        pull: ``M q`` with its moment.
        along: d with its moment, times ``mu_R``.
        across: n with its moment, times ``mu_S``.
    """

    load: Affine
    size: Number
    pull: Triple
    along: Triple
    across: Triple


def _wrench(force: Vector, wheel: Wheel) -> Triple:
    return *force, cross(wheel.position, force)


def _rim(wheel: Wheel) -> Vector:
    x, y, _ = roll_row(wheel).unit_normal
    return x, y


def _slips(scene: Scene, region: LoadRegion, omega: Number) -> list[_Slip] | None:
    """The loaded wheels that have friction; None where one of them sticks."""
    found: list[_Slip] = []
    for wheel, load in zip(scene.wheels, region.forces, strict=True):
        roll, side = wheel.friction.roll, wheel.friction.side
        if not any(load) or not (roll or side):
            continue
        d, (x, y) = _rim(wheel), wheel.position
        slip = (-omega * y - wheel.speed * d[0], omega * x - wheel.speed * d[1])
        along, across = roll * dot(d, slip), side * cross(d, slip)
        square = along * along + across * across
        if not square:
            return None
        own = scaled(_wrench(d, wheel), roll), scaled(_wrench(turned(d), wheel), side)
        pull = total(scene.field.zero, (scaled(own[0], along), scaled(own[1], across)))
        found.append(_Slip(load, square.sqrt(), pull, *own))
    return found


def is_smooth_minimum(scene: Scene, region: LoadRegion, omega: Number, linear: Linearization | None) -> bool:
    """Whether forces balance at a spin, D is strictly convex there, and a linearization, if any, is of this array."""
    slips = _slips(scene, region, omega)
    if slips is None or any(_weighted(scene, slips, 0)):
        return False
    hessian = tuple(_hessian_row(scene, slips, k) for k in range(3))
    if linear is None:
        return _is_definite(hessian)
    slopes = (_weighted(scene, slips, 1), _weighted(scene, slips, 2))
    return (linear.omega, linear.hessian, linear.slope) == (omega, hessian, slopes) and _is_definite(hessian)


def balances(scene: Scene, region: LoadRegion, omega: Number) -> bool:
    """Whether forces and moments balance at a spin at which every loaded wheel slips."""
    slips = _slips(scene, region, omega)
    return slips is not None and not any(_weighted(scene, slips, 0))


def _weighted(scene: Scene, slips: Iterable[_Slip], part: int) -> Triple:
    """Force and moment at the point (part 0), or their slopes by x and by y."""
    return total(scene.field.zero, (scaled(slip.pull, slip.load[part] / slip.size) for slip in slips))


def _hessian_row(scene: Scene, slips: Iterable[_Slip], k: int) -> Triple:
    rows = []
    for slip in slips:
        load = slip.load[0] / slip.size
        rows += [scaled(slip.along, load * slip.along[k]), scaled(slip.across, load * slip.across[k])]
        rows.append(scaled(slip.pull, -load * slip.pull[k] / (slip.size * slip.size)))
    return total(scene.field.zero, rows)


def _is_definite(rows: tuple[Triple, ...]) -> bool:
    """Whether a symmetric matrix is positive definite, by the minors from its last corner."""
    a, b, c = rows
    return c[2].sign() > 0 and (b[1] * c[2] - b[2] * c[1]).sign() > 0 and inner(a, outer(b, c)).sign() > 0


def is_held(scene: Scene, region: LoadRegion, balance: RestBalance) -> bool:
    """Whether forces of the wheels at rest, strictly inside their ellipses, answer those of the wheels that slip."""
    stuck = {force.wheel: force for force in balance.stuck or ()}
    forces: list[Triple] = []
    spanned: list[Triple] = []
    for wheel, (load, *_) in zip(scene.wheels, region.forces, strict=True):
        roll, side, d = wheel.friction.roll, wheel.friction.side, _rim(wheel)
        if wheel.index in stuck:
            own = stuck[wheel.index]
            if not own.along * own.along + own.across * own.across < 1 or (roll and wheel.scaled_speed):
                return False
            along, across = _wrench(d, wheel), _wrench(turned(d), wheel)
            forces += [scaled(along, -load * roll * own.along), scaled(across, -load * side * own.across)]
            free = ((along, load * roll * (not wheel.scaled_speed)), (across, load * side))
            spanned += [direction for direction, reach in free if reach]
        elif wheel.scaled_speed:
            forces.append(scaled(_wrench(d, wheel), load * roll * wheel.scaled_speed.sign()))
    return not any(total(scene.field.zero, forces)) and len(independent(spanned)) == 3


def carries(scene: Scene, region: LoadRegion, velocity: Vector, omega: Number) -> bool:
    """Whether every wheel that rubs moves with its rim, and the loaded ones fix the motion."""
    loaded: list[Triple] = []
    for wheel, (load, *_) in zip(scene.wheels, region.forces, strict=True):
        d, (x, y) = _rim(wheel), wheel.position
        here = (velocity[0] - omega * y, velocity[1] + omega * x)
        rubbing = (wheel.friction.roll, d, wheel.speed), (wheel.friction.side, turned(d), wheel.speed * 0)
        if any(friction and dot(direction, here) - speed for friction, direction, speed in rubbing):
            return False
        loaded += [_wrench(direction, wheel) for friction, direction, _ in rubbing if friction and load]
    return len(independent(loaded)) == 3
