"""An oracle: what a motion ``(0, 0, omega)`` of an array asks of the wheels, by forces and moments in the plane.

The verdicts under rules without cells are built from rows of constraints; here they are told from slips
``q = omega J p - u d``, forces ``F = N M q/f`` with ``M = alpha^2 d d^T + beta^2 n n^T`` and ``f^2 = q . M q``, and
their moments ``p x F``.  The Hessian of f is ``M/f - (M q)(M q)^T/f^3``.  Where ``M q/f`` would pass the cut of the
friction set, ``|y| > kappa``, the force is the corner instead, and the Hessian is zero.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.loads import Affine, LoadRegion
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.clauses.at_point.ellipse import EllipsePoint, HeldForce, Situation
from nonsmooth.symbolic.mechanics.contact_states import (
    Triple,
    cross_product,
    independent,
    inner,
    roll_row,
    scaled,
    total,
)
from nonsmooth.symbolic.mechanics.friction_set import FrictionSet
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import Vector, cross, dot, turned


@dataclass(frozen=True)
class _Slip:
    """A loaded wheel that slips.

    Attributes:
        load: N as an affine form of c.
        size: f.
        pull: ``M q`` with its moment.
        along: d with its moment, times ``alpha``.
        across: n with its moment, times ``beta``.
        bends: whether the force is off the corners, so that f has a curvature.
    """

    load: Affine
    size: Number
    pull: Triple
    along: Triple
    across: Triple
    bends: bool = True


def _wrench(force: Vector, wheel: Wheel) -> Triple:
    return *force, cross(wheel.position, force)


def _axis(wheel: Wheel) -> Vector:
    """The unit vector of the friction axis."""
    x, y, _ = roll_row(wheel).unit_normal
    return x, y


def _surface(wheel: Wheel) -> Vector:
    """``u d``, the velocity of the rim's surface, of unit rim direction d."""
    x, y = _axis(wheel) if wheel.axis is None else wheel.unit_direction
    return wheel.speed * x, wheel.speed * y


def _slips(scene: Scene, region: LoadRegion, omega: Number) -> list[_Slip] | None:
    """The loaded wheels that have friction; None where one of them sticks, or is between arc and corner."""
    slips: list[_Slip] = []
    rule = smooth_rule_of(scene)
    for wheel, load in zip(scene.wheels, region.forces, strict=True):
        limits = rule.friction_set(wheel.friction)
        if not any(load) or not (limits.along or limits.across):
            continue
        slip = _slip(wheel, load, limits, omega)
        if slip is None:
            return None
        slips.append(slip)
    return slips


def _slip(wheel: Wheel, load: Affine, limits: FrictionSet, omega: Number) -> _Slip | None:
    """One wheel that slips; None where it sticks, or is between arc and corner."""
    d, (x, y), (a, b) = _axis(wheel), wheel.position, _surface(wheel)
    slip = (-omega * y - a, omega * x - b)
    along, across = limits.along * dot(d, slip), limits.across * cross(d, slip)
    square = along * along + across * across
    if not square:
        return None
    rows = scaled(_wrench(d, wheel), limits.along), scaled(_wrench(turned(d), wheel), limits.across)
    passed = (across * across - limits.cut * limits.cut * square).sign() if limits.is_cut else -1
    if passed == 0 or (passed > 0 and not along):
        return None
    zero, one = omega.field.zero, omega.field.one
    if passed > 0:
        x, y = limits.corner * along.sign(), limits.cut * across.sign()
        return _Slip(load, one, total(zero, (scaled(rows[0], x), scaled(rows[1], y))), *rows, bends=False)
    pull = total(zero, (scaled(rows[0], along), scaled(rows[1], across)))
    return _Slip(load, square.sqrt(), pull, *rows)


def verifies(point: EllipsePoint) -> bool:
    """Whether forces and moments show what a point says; not that the body is driven away."""
    scene, region, twist, linear = point.scene, point.region, point.twist, point.linearization
    if linear is not None and not (point.situation is Situation.SMOOTH and solves(linear)):
        return False
    if twist is None:
        return point.situation in (Situation.MOVED, Situation.OPEN)
    if point.situation is Situation.CARRIED:
        return carries(scene, region, twist.velocity, twist.omega)
    if point.situation in (Situation.STICKING, Situation.HELD):
        spins = point.situation is Situation.HELD
        return (
            not any(twist.velocity) and spins == bool(twist.omega) and is_held(scene, region, twist.omega, point.held)
        )
    if point.situation is Situation.OPEN:
        return not any(twist.velocity) and balances(scene, region, twist.omega)
    return not any(twist.velocity) and is_smooth_minimum(scene, region, twist.omega, linear)


def solves(linear: Linearization) -> bool:
    """Whether ``H M + G = 0``."""
    return all(
        inner(row, column) + slope[r] == 0
        for column, slope in zip(linear.columns, linear.slope, strict=True)
        for r, row in enumerate(linear.hessian)
    )


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
        if not slip.bends:
            continue
        load = slip.load[0] / slip.size
        rows += [scaled(slip.along, load * slip.along[k]), scaled(slip.across, load * slip.across[k])]
        rows.append(scaled(slip.pull, -load * slip.pull[k] / (slip.size * slip.size)))
    return total(scene.field.zero, rows)


def _is_definite(rows: tuple[Triple, ...]) -> bool:
    """Whether a symmetric matrix is positive definite, by the minors from its last corner."""
    a, b, c = rows
    return c[2].sign() > 0 and (b[1] * c[2] - b[2] * c[1]).sign() > 0 and inner(a, cross_product(b, c)).sign() > 0


def is_held(scene: Scene, region: LoadRegion, omega: Number, held: Iterable[HeldForce]) -> bool:
    """Whether forces of wheels that a spin does not slip, or not along, answer those of the others, strictly inside."""
    by_wheel = {force.wheel: force for force in held}
    forces: list[Triple] = []
    spanned: list[Triple] = []
    rule = smooth_rule_of(scene)
    for wheel, form in zip(scene.wheels, region.forces, strict=True):
        load, limits, d, (x, y), (a, b) = form[0], rule.friction_set(wheel.friction), _axis(wheel), *_at(wheel)
        if wheel.index not in by_wheel:
            slip = _slip(wheel, form, limits, omega) if load and (limits.along or limits.across) else None
            if slip is not None:
                forces.append(scaled(slip.pull, -load / slip.size))
            elif load and (limits.along or limits.across):
                return False
            continue
        force, q = by_wheel[wheel.index], (-omega * y - a, omega * x - b)
        along, across = limits.along * dot(d, q), limits.across * cross(d, q)
        inside = force.along * force.along + force.across * force.across < 1
        on_side = force.rolls and across and force.across == limits.cut * across.sign()
        if along or not inside or not (on_side or (not across and -limits.cut < force.across < limits.cut)):
            return False
        rows = scaled(_wrench(d, wheel), load * limits.along), scaled(_wrench(turned(d), wheel), load * limits.across)
        forces += [scaled(rows[0], -force.along), scaled(rows[1], -force.across)]
        spanned += [row for row in rows[: 1 if force.rolls else 2] if any(row)]
    return not any(total(scene.field.zero, forces)) and len(independent(spanned)) == 3


def _at(wheel: Wheel) -> tuple[Vector, Vector]:
    return wheel.position, _surface(wheel)


def carries(scene: Scene, region: LoadRegion, velocity: Vector, omega: Number) -> bool:
    """Whether every wheel that rubs moves with its rim, and the loaded ones fix the motion."""
    loaded: list[Triple] = []
    rule = smooth_rule_of(scene)
    for wheel, (load, *_) in zip(scene.wheels, region.forces, strict=True):
        limits, d, (x, y), (a, b) = rule.friction_set(wheel.friction), _axis(wheel), wheel.position, _surface(wheel)
        slip = (velocity[0] - omega * y - a, velocity[1] + omega * x - b)
        rubbing = (limits.along, d), (limits.across, turned(d))
        if any(friction and dot(direction, slip) for friction, direction in rubbing):
            return False
        loaded += [_wrench(direction, wheel) for friction, direction in rubbing if friction and load]
    return len(independent(loaded)) == 3
