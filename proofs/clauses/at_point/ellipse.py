"""The clauses under rules without cells: what the body does at the equilibrium, and what follows near it.

Five situations are told apart, each by exact evidence:

- *carried*: one twist satisfies every row of every wheel, so D = 0 wherever the centre of mass lies: the body moves
  rigidly with the wheels (a rotation about the equilibrium is stable, not attractive);
- *smooth rest* and *smooth spin*: the gradient of D vanishes at ``(0, 0, omega)`` and H is positive definite there: the
  field is smooth, and the eigenvalues of its linearization decide (Hurwitz: exponentially stable);
- *sticking*: wheels that stick answer the balance strictly inside their friction sets: rest fills a neighbourhood;
- *held spin*: the same of a spin, at which some wheels stick, or rims do not slip while their rollers turn: near the
  point the body turns about it, wherever its centre of mass lies;
- *moved*: the best rotation about the point is enclosed between two rational rates, and over the enclosure the
  gradient of D in the translation directions stays away from zero (balls); or forces that balance a pull back bound the
  speed from below (:mod:`nonsmooth.proofs.boxes.balanced_forces`), wheels that stick and rollers included: no
  equilibrium;
- *at rest within rounding*: a place of rest is enclosed that no printed digit tells from the point
  (:mod:`nonsmooth.proofs.boxes.enclosed_rest`), and what follows holds at it for every member of the box;
- otherwise the point is not decided, and the reason says why.  So it is, under rule ``roller``, where rollers turn at
  the motion in question and leave the Hessian singular, or are about to turn.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from typing import NamedTuple

from flint import arb, arb_mat, ctx, fmpq

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.cells.loads import LoadRegion
from nonsmooth.proofs.boxes.balanced_forces import BalancedForces
from nonsmooth.proofs.boxes.enclosed_rest import EnclosedRest
from nonsmooth.proofs.boxes.enclosures import is_positive_definite, linear_stability, zero_of_rising
from nonsmooth.proofs.boxes.linearization import Linearization, Slip, gradient, linearize, slips_at, spin_candidates
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.symbolic.mechanics.contact_states import (
    Row,
    RowKind,
    Triple,
    Twist,
    cofactors,
    combine,
    gram,
    independent,
    inner,
    scaled,
    scene_rows,
    solve_rows,
    total,
)
from nonsmooth.symbolic.mechanics.friction_set import BorderPiece, FrictionSet
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.enclosures import enclosure
from nonsmooth.symbolic.numbers.lazy import divided
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text

# ---- wheels that are held ------------------------------------------------------------------------
#
# Wheels that are held, at rest or at a spin: forces inside their friction sets that balance the others, exactly.
#
# At the equilibrium (centred scene, c = 0) rest minimizes ``D = sum N_i f_i``, with the support functions f_i of the
# friction sets (:mod:`nonsmooth.symbolic.mechanics.friction_set`; rule ``ellipse``:
# ``f_i = sqrt(mu_R^2 r_i^2 + mu_S^2 s_i^2)``), iff ``0 in dD(0)``.  Where every loaded wheel slips at rest
# (``u_i != 0``), D is smooth there and that is the balance ::
#
#     sum_i N_i mu_R sgn(u_i) a_i = 0,      a_i = [d_i; d_i . J p_i],  b_i = [n_i; n_i . J p_i]
#
# because a slip along the rim alone is on the arc of every set: under rule ``roller`` the rollers stand.  A wheel whose
# friction axis is not its rim slips across the axis too; its force is that of its slip, wherever the set has one such
# force.  Wheels that stick at rest (``u_i = 0``) may carry any force in their set.  The least-norm forces that restore
# balance are tried: inside the sets they prove equilibrium, strictly inside (with rows of rank three) they prove that
# rest is the only minimizer in a neighbourhood: any other motion costs more, and so it stays while the loads change a
# little.
#
# The same holds of a spin ``(0, 0, omega)`` at which wheels stick.  A wheel whose rim does not slip while its rollers
# turn has its force on a straight side of its set, ``(x, kappa sgn s_i)`` with ``|x| < sqrt(1 - kappa^2)``, and is held
# along its rim alone.
#
# The slips of such a spin are the same wherever the centre of mass is.  So where loads are affine in it, forces
# ``N_k(c) f_k(c)`` that balance the others are affine too, and a disc in which they stay inside is known: there the
# body turns about the point, which it never comes nearer to nor farther from.


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


# ---- the situation -------------------------------------------------------------------------------


_PRECISION = 256
_FEW_BISECTIONS = 8  # mostly these suffice
_BISECTIONS = 120  # halvings of the bracket of the best rotation rate


class Situation(StrEnum):
    """What the body does at the equilibrium."""

    CARRIED = "carried by all wheels without slip"
    SMOOTH = "smooth minimizer"
    STICKING = "held at rest by sticking wheels"
    HELD = "turned by wheels that are held"
    MOVED = "driven away"
    ENCLOSED = "at rest within rounding"
    OPEN = "not decided"


@dataclass(frozen=True)
class EllipsePoint:
    """The situation at the equilibrium with its evidence.

    Attributes:
        scene: the array, centred.
        region: the load region that holds the equilibrium (the first, where several meet).
        situation: see :class:`Situation`.
        twist: the exact minimizer at the equilibrium, where it is known.
        held: forces of the wheels that the twist holds; at rest, where none is known.
        linearization: first-order motion (smooth minimizers whose loads are smooth too).
        reason: one sentence for people.
        rest: the place of rest that is the point within rounding, where no exact one is known.
    """

    scene: Scene
    region: LoadRegion
    situation: Situation
    twist: Twist | None
    held: tuple[HeldForce, ...]
    linearization: Linearization | None
    reason: str
    rest: EnclosedRest | None = None

    @property
    def summary(self) -> str:
        """What the body does and why; where that is open the reason alone."""
        return self.reason if self.situation is Situation.OPEN else f"{self.situation}: {self.reason}"

    @property
    def equilibrium(self) -> Equilibrium:
        """Whether the translation part of the motion vanishes at the point, or beside it within rounding."""
        if self.rest is not None:
            return Equilibrium.HOLDS
        if self.twist is not None:
            return Equilibrium.FAILS if any(self.twist.velocity) else Equilibrium.HOLDS
        return Equilibrium.FAILS if self.situation is Situation.MOVED else Equilibrium.UNDECIDED

    @property
    def turns_within(self) -> arb | None:
        """Within what radius bodies move with this twist, where wheels impose it and loads keep their affine forms."""
        if self.situation is Situation.CARRIED:
            return arb("inf")
        if self.situation not in (Situation.HELD, Situation.STICKING) or self.twist is None:
            return None
        return radius_of_turning(self.scene, self.region, self.twist.omega, self.held)

    @property
    def translation(self) -> Translation:
        """Strong stability of (x, y)."""
        if self.rest is not None:
            return self.rest.stability
        if self.equilibrium is not Equilibrium.HOLDS:
            return Translation.UNDECIDED
        if self.situation in (Situation.CARRIED, Situation.STICKING, Situation.HELD):
            return Translation.STABLE
        return Translation.UNDECIDED if self.linearization is None else linear_stability(self.linearization.translation)

    def undecided(self, reason: str) -> EllipsePoint:
        """The same point without a claim."""
        return replace(self, situation=Situation.OPEN, twist=None, linearization=None, reason=reason, rest=None)

    def resting(self, rest: EnclosedRest) -> EllipsePoint:
        """The same point with a place of rest that is it within rounding."""
        reason = (
            f"one place of rest lies within {float_text(rest.distance)} of it, and no other one nearby, for every "
            "member of what was rounded (Krawczyk's operator, in balls)"
        )
        return replace(self, situation=Situation.ENCLOSED, twist=None, linearization=None, reason=reason, rest=rest)


def ellipse_point(scene: Scene, regions: tuple[LoadRegion, ...]) -> EllipsePoint:
    """Decide the situation at the equilibrium of a centred scene."""
    zero = scene.field.zero
    here = [region for region in regions if region.polygon.contains((zero, zero))]
    region = here[0]
    carried = common_twist(scene, region)
    rates = dict.fromkeys((*spin_candidates(scene, region), *_held_rates(scene, region))) if carried is None else ()
    resting = _in_balls(scene, region)
    for twist in [carried] if carried is not None else [Twist(zero, zero, rate) for rate in rates]:
        point = None if _is_no_minimizer(resting, twist) else motion_with(scene, region, twist)
        if point is not None and point.linearization is not None and len(here) > 1:
            reason = f"{point.reason}; the loads change their form at the equilibrium, so there is no linearization"
            return replace(point, linearization=None, reason=reason)
        if point is not None:
            return point
    open_point = EllipsePoint(scene, region, Situation.OPEN, None, held_forces(scene, region, zero), None, "")
    if _is_moved(resting):
        reason = "the translation part of the gradient of D stays away from zero for every spin"
        return replace(open_point, situation=Situation.MOVED, reason=reason)
    forces = BalancedForces.of(scene)
    if forces is not None and forces.moves_from_the_origin:
        reason = "friction forces that balance a pull back bound its speed from below"
        return replace(open_point, situation=Situation.MOVED, reason=reason)
    reason = "wheels stick at the best motion, or its rotation rate is not a number of the scene"
    if any(slip.limits.is_cut for slip in resting):
        reason = (
            "wheels stick at the best motion, or rollers turn there with rims that do not slip, "
            "or its rotation rate is not a number of the scene"
        )
    return open_point.undecided(reason)


def motion_with(scene: Scene, region: LoadRegion, twist: Twist) -> EllipsePoint | None:
    """The situation in which the body moves with a twist at the point; None where it is not shown to."""
    zero = scene.field.zero
    held = held_forces(scene, region, zero if any(twist.velocity) else twist.omega)

    def point(situation: Situation, reason: str, linear: Linearization | None = None) -> EllipsePoint:
        return EllipsePoint(scene, region, situation, twist, held, linear, reason)

    if is_carried(scene, region, twist):
        text = f"({twist.vx}, {twist.vy}, {twist.omega})"
        return point(Situation.CARRIED, f"the twist {text} satisfies every row of every wheel")
    if not any(twist.velocity) and are_strict(held):
        what = "friction limits" if any(force.limits.is_cut for force in held) else "friction ellipses"
        which = "wheels that are held" if any(force.rolls for force in held) else "sticking wheels"
        situation = Situation.HELD if twist.omega else Situation.STICKING
        return point(situation, f"the {which} balance the others strictly inside their {what}")
    slips = slips_at(scene, region, twist.omega)
    if any(twist.velocity) or not all(slip.is_smooth for slip in slips) or any(gradient(zero, slips)):
        return None
    linear = linearize(scene, region, twist.omega)
    if linear is None or not is_positive_definite(linear.hessian):
        reason = (
            f"the twist (0, 0, {brief_text(twist.omega)}) minimizes D, but its Hessian is singular there: "
            "the motion near the point is not determined to first order"
        )
        return point(Situation.OPEN, reason)
    what = f"a spin at {twist.omega}" if twist.omega else "rest"
    return point(Situation.SMOOTH, f"the gradient of D vanishes at {what} and its Hessian is positive definite", linear)


def _held_rates(scene: Scene, region: LoadRegion) -> list[Number]:
    """The spins at which at least two rims of loaded wheels do not slip: ``omega a_3 = u``."""
    rims = [slip for slip in slips_at(scene, region, scene.field.zero) if slip.load[0] and slip.limits.along]
    levers = [(slip.along, slip.rows[0][2]) for slip in rims]
    rates = Counter(-along * lever / (lever * lever) for along, lever in levers if lever)  # of squares: without roots
    return [rate for rate, count in rates.items() if count > 1]


def common_twist(scene: Scene, region: LoadRegion) -> Twist | None:
    """The twist that satisfies every row with friction of every wheel, where the wheels loaded at the point fix it."""
    loaded = [row for row in _rubbing_rows(scene) if region.forces[scene.places[row.wheel.index]][0]]
    basis = independent([row.normal for row in loaded])
    state = solve_rows((loaded[basis[0]], loaded[basis[1]], loaded[basis[2]])) if len(basis) == 3 else None
    return state.twist if state is not None and is_carried(scene, region, state.twist) else None


def is_carried(scene: Scene, region: LoadRegion, twist: Twist) -> bool:
    """Whether a twist satisfies every row with friction of every wheel, and the loaded wheels fix it."""
    rows = _rubbing_rows(scene)
    if any(row.residual(twist) for row in rows):
        return False
    loaded = (row.normal for row in rows if region.forces[scene.places[row.wheel.index]][0])
    return len(independent(loaded)) == 3


def _rubbing_rows(scene: Scene) -> list[Row]:
    """The rows in which the friction set of the wheel has a width."""
    rule = smooth_rule_of(scene)
    limits = {wheel.index: rule.friction_set(wheel.friction) for wheel in scene.wheels}
    sizes = {(k, RowKind.ROLL): limit.along for k, limit in limits.items()}
    sizes |= {(k, RowKind.SIDE): limit.across for k, limit in limits.items()}
    return [row for row in scene_rows(scene) if sizes[row.wheel.index, row.kind]]


# ---- no equilibrium: enclosures ----------------------------------------------------------


def _in_balls(scene: Scene, region: LoadRegion) -> list[Slip[arb]]:
    """The loaded wheels at rest."""
    with ctx.workprec(_PRECISION):
        return [slip.map(lambda x: x.ball()) for slip in slips_at(scene, region, scene.field.zero) if slip.load[0]]


def _gradient_at(resting: Sequence[Slip[arb]], rate: arb) -> Sequence[arb] | None:
    """Enclosure of the gradient of D at ``(0, 0, rate)``; None where it may not exist."""
    slips = [slip.moved((arb(0), arb(0), rate)) for slip in resting]
    if any(slip.piece in (BorderPiece.KINK, BorderPiece.OPEN) for slip in slips):
        return None
    return gradient(arb(0), slips)


def _is_no_minimizer(resting: Sequence[Slip[arb]], twist: Twist) -> bool:
    """Whether balls tell so: the exact gradient takes the root of every wheel's slip into the scene's field."""
    with ctx.workprec(_PRECISION):
        pull = None if any(twist.velocity) else _gradient_at(resting, twist.omega.ball())
    return pull is not None and not all(entry.contains(0) for entry in pull)


def _is_moved(resting: Sequence[Slip[arb]]) -> bool:
    """Whether no ``(0, 0, omega)`` minimizes D: enclose the best omega, then the gradient over the enclosure."""

    def torque(rate: fmpq) -> arb:
        pull = _gradient_at(resting, arb(rate))
        return arb("nan") if pull is None else pull[2]

    with ctx.workprec(_PRECISION):
        for halvings in (_FEW_BISECTIONS, _BISECTIONS):
            bracket = zero_of_rising(torque, halvings)
            pull = None if bracket is None else _gradient_at(resting, arb(bracket[0]).union(arb(bracket[1])))
            if pull is not None and not (pull[0].contains(0) and pull[1].contains(0)):
                return True
    return False
