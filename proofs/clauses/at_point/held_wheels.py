"""Wheels that are held, at rest or at a spin: forces inside their friction sets that balance the others, exactly.

At the equilibrium (centred scene, c = 0) rest minimizes ``D = sum N_i f_i``, with the support functions f_i of the
friction sets (:mod:`nonsmooth.symbolic.mechanics.friction_set`; rule ``ellipse``:
``f_i = sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``), iff ``0 in dD(0)``.  Where every loaded wheel slips at rest
(``u_i != 0``), D is smooth there and that is the balance ::

    sum_i N_i mu_R sgn(u_i) a_i = 0,      a_i = [d_i; d_i . J p_i],  b_i = [n_i; n_i . J p_i]

because a slip along the rim alone is on the arc of every set: under rule ``roller`` the rollers stand.  A wheel whose
friction axis is not its rim slips across the axis too; its force is that of its slip, wherever the set has one such
force.  Wheels that stick at rest (``u_i = 0``) may carry any force in their set.  The least-norm forces that restore
balance are tried: inside the sets they prove equilibrium, strictly inside (with rows of rank three) they prove that
rest is the only minimizer in a neighbourhood: any other motion costs more, and so it stays while the loads change a
little.

The same holds of a spin ``(0, 0, omega)`` at which wheels stick.  A wheel whose rim does not slip while its rollers
turn has its force on a straight side of its set, ``(x, kappa sgn s_i)`` with ``|x| < sqrt(1 - kappa^2)``, and is held
along its rim alone.

The slips of such a spin are the same wherever the centre of mass is.  So where loads are affine in it, forces
``N_k(c) f_k(c)`` that balance the others are affine too, and a disc in which they stay inside is known: there the body
turns about the point, which it never comes nearer to nor farther from.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.proofs.boxes.linearization import Slip, gradient, slips_at
from nonsmooth.symbolic.mechanics.contact_states import Triple, cofactors, combine, gram, inner, scaled, total
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece, FrictionSet
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import enclosure
from nonsmooth.symbolic.numbers.lazy import divided
from nonsmooth.symbolic.numbers.number import Number

PRECISION = 128  # bits


class HeldForce(NamedTuple):
    """Force of a wheel that is held, in units of the half-axes of its friction set.

    Attributes:
        wheel: its number.
        along, across: the force.
        limits: the friction set.
        rolls: whether its rollers turn, so that it is held along its rim alone.
    """

    wheel: int
    along: Number
    across: Number
    limits: FrictionSet
    rolls: bool

    @property
    def squared(self) -> Number:
        """``|f|^2``; admissible up to one."""
        return self.along * self.along + self.across * self.across

    @property
    def is_strict(self) -> bool:
        """Whether it lies inside the set, or inside the straight side of it on which it is while rollers turn."""
        return bool(self.squared < 1) if self.rolls else self.limits.holds_strictly(self.along, self.across)


def are_strict(held: Sequence[HeldForce]) -> bool:
    """Whether forces show that a spin is the only minimizer at the equilibrium, and in a neighbourhood of it."""
    return bool(held) and all(force.is_strict for force in held)


def held_forces(scene: Scene, region: LoadRegion, omega: Number) -> tuple[HeldForce, ...]:
    """Forces of the wheels that a spin about the equilibrium of a centred scene holds, which balance the others.

    They are of least norm.  None where none are determined: the rows that are held have a rank below three.

    Args:
        scene: the array.
        region: whose loads hold at the equilibrium.
        omega: the rotation rate.
    """
    zero = scene.field.zero
    slips = [slip for slip in slips_at(scene, region, omega) if slip.load[0]]
    held = [slip for slip in slips if _is_held(slip)]
    rows = [(slip, axis, scaled(row, slip.load[0])) for slip in held for axis, row in _held_rows(slip)]
    if len(rows) < 3:
        return ()
    answer = _least_norm([row for _, _, row in rows], _missing(zero, slips, 0))
    if answer is None:
        return ()
    shares = {(slip.wheel, axis): share for (slip, axis, _), share in zip(rows, answer, strict=True)}

    def force(slip: Slip[Number]) -> HeldForce:
        along, across = shares.get((slip.wheel, 0), zero), shares.get((slip.wheel, 1), _push(slip))
        return HeldForce(slip.wheel, along, across, slip.limits, bool(slip.across))

    return tuple(map(force, held))


def _is_held(slip: Slip[Number]) -> bool:
    """Whether a wheel does not slip along its friction axis, so that no gradient tells its force."""
    return slip.piece is BorderPiece.KINK


def _push(slip: Slip[Number]) -> Number:
    """The force across of a wheel that is held, as far as its slip tells it: of rollers that turn."""
    return slip.limits.cut * (slip.limits.across * slip.across).sign()


def _held_rows(slip: Slip[Number]) -> Iterator[tuple[int, Triple]]:
    """Axes along which a wheel is held, and force with moment of its half-axis there, per unit of load."""
    free = slip.limits.along, slip.limits.across * (not _push(slip))
    return ((axis, scaled(slip.rows[axis], size)) for axis, size in enumerate(free) if size)


def _missing(zero: Number, slips: Sequence[Slip[Number]], part: int) -> Triple:
    """What the wheels that are held have to add to balance: at c = 0, or (parts 1 and 2) its change along x and y."""
    slipping = gradient(zero, (slip for slip in slips if not _is_held(slip)), part)
    held = (slip for slip in slips if _is_held(slip))
    turning = (scaled(slip.rows[1], slip.load[part] * slip.limits.across * _push(slip)) for slip in held)
    return scaled(total(zero, (slipping, *turning)), -1)


def radius_of_turning(scene: Scene, region: LoadRegion, omega: Number, forces: Sequence[HeldForce]) -> arb:
    """A radius about the equilibrium within which strict forces of a spin stay strictly inside; loads are affine there.

    ``P(c) = N(c) f(c) = P_0 + P' c`` of a wheel may grow until ``|P| = N``, or to the end of a straight side.  A wheel
    without load at the point has no part in it: what it does elsewhere the others balance.
    """
    slips = slips_at(scene, region, omega)
    held = [slip for slip in slips if slip.load[0] and _is_held(slip)]
    rows = [(slip.wheel, axis, row) for slip in held for axis, row in _held_rows(slip)]
    with ctx.workprec(PRECISION):
        columns = arb_mat([[enclosure(entry) for entry in row] for _, _, row in rows]).transpose()
        inverse = columns.transpose() * (columns * columns.transpose()).inv()
        missing = [_missing(scene.field.zero, slips, part) for part in (1, 2)]
        by_x, by_y = (inverse * arb_mat([[enclosure(entry)] for entry in change]) for change in missing)
        steep = {(wheel, axis): _length(by_x[k, 0], by_y[k, 0]) for k, (wheel, axis, _) in enumerate(rows)}
        radii = [
            radius
            for slip, force in zip(held, forces, strict=True)
            for radius in _reaches(slip, force, *(steep.get((slip.wheel, axis), arb(0)) for axis in (0, 1)))
        ]
        return min(radii, key=lambda radius: radius.lower())


def _reaches(slip: Slip[Number], force: HeldForce, along: arb, across: arb) -> Iterator[arb]:
    """How far from the point the force of a wheel, of parts as steep as that, may come to the border of its set."""
    load, by_x, by_y = map(enclosure, slip.load)
    x, y, cut = (abs(enclosure(number)) for number in (force.along, force.across, slip.limits.cut))
    growth = _length(by_x, by_y)
    if force.rolls:
        corner = ((1 - cut) * (1 + cut)).sqrt()
        yield _reach(load * (corner - x), corner * growth + along)
        return
    yield _reach(load * (1 - _length(x, y)), growth + _length(along, across))
    if slip.limits.is_cut:
        yield _reach(load * (cut - y), cut * growth + across)


def _reach(room: arb, steepness: arb) -> arb:
    """A lower bound of the distance after which something so steep may have used up its room."""
    steepest = steepness.upper()
    return room.lower() / steepest if steepest > 0 else arb("inf")


def _length(x: arb, y: arb) -> arb:
    return (x * x + y * y).sqrt()


def _least_norm(columns: Sequence[Triple], target: Triple) -> list[Number] | None:
    """Least-norm f with ``sum f_k columns_k = target``; None where the columns have a rank below three."""
    rows = gram(columns)
    adjugate = cofactors(*rows)
    determinant = inner(rows[0], adjugate[0])
    if not determinant:
        return None
    multiplier = scaled(combine(target, adjugate), divided(determinant.field.one, determinant))
    return [inner(column, multiplier) for column in columns]
