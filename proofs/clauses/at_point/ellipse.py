"""The clauses under rules without cells: what the body does at the equilibrium, and what follows near it.

Five situations are told apart, each by exact evidence:

- *carried*: one twist satisfies every row of every wheel, so D = 0 wherever the centre of mass lies: the body moves
  rigidly with the wheels (a rotation about the equilibrium is stable, not attractive);
- *smooth rest* and *smooth spin*: the gradient of D vanishes at ``(0, 0, omega)`` and H is positive definite there: the
  field is smooth, and the eigenvalues of its linearization decide (Hurwitz: exponentially stable);
- *sticking*: wheels that stick answer the balance strictly inside their friction sets: rest fills a neighbourhood;
- *moved*: the best rotation about the point is enclosed between two rational rates, and over the enclosure the
  gradient of D in the translation directions stays away from zero (balls): no equilibrium;
- otherwise the point is not decided, and the reason says why.  So it is, under rule ``roller``, where rollers turn at
  the motion in question and leave the Hessian singular, or are about to turn, or rims do not slip.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import StrEnum

from flint import arb, ctx, fmpq

from nonsmooth.analysis.cells.loads import LoadRegion, load_regions
from nonsmooth.analysis.contact_rule import smooth_rule_of
from nonsmooth.proofs.clauses.at_point.balance import RestBalance, rest_balance
from nonsmooth.proofs.clauses.at_point.forces_check import balances, carries, is_smooth_minimum, rests_by_sticking
from nonsmooth.proofs.clauses.at_point.linearization import (
    Linearization,
    Slip,
    gradient,
    linearize,
    slips_at,
    spin_candidates,
)
from nonsmooth.proofs.verdicts import Equilibrium, Translation
from nonsmooth.symbolic.constraints import Row, RowKind, Twist, independent, scene_rows
from nonsmooth.symbolic.contact_states import solve_rows
from nonsmooth.symbolic.friction_set import FrictionSet
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene

_PRECISION = 256
_BISECTIONS = 120  # halvings of the bracket of the best rotation rate
_DOUBLINGS = 80


class Situation(StrEnum):
    """What the body does at the equilibrium."""

    CARRIED = "carried by all wheels without slip"
    SMOOTH = "smooth minimizer"
    STICKING = "held at rest by sticking wheels"
    MOVED = "driven away"
    OPEN = "not decided"


@dataclass(frozen=True)
class EllipsePoint:
    """The situation at the equilibrium with its evidence.

    Attributes:
        scene: the array, centred.
        region: the load region that holds the equilibrium (the first, where several meet).
        situation: see :class:`Situation`.
        twist: the exact minimizer at the equilibrium, where it is known.
        balance: forces at rest.
        linearization: first-order motion (smooth minimizers whose loads are smooth too).
        reason: one sentence for people.
    """

    scene: Scene
    region: LoadRegion
    situation: Situation
    twist: Twist | None
    balance: RestBalance
    linearization: Linearization | None
    reason: str

    @property
    def summary(self) -> str:
        """What the body does and why; where that is open the reason alone."""
        return self.reason if self.situation is Situation.OPEN else f"{self.situation}: {self.reason}"

    @property
    def equilibrium(self) -> Equilibrium:
        """Whether the translation part of the motion vanishes at the point."""
        if self.twist is not None:
            return Equilibrium.FAILS if any(self.twist.velocity) else Equilibrium.HOLDS
        return Equilibrium.FAILS if self.situation is Situation.MOVED else Equilibrium.UNDECIDED

    @property
    def translation(self) -> Translation:
        """Strong stability of (x, y)."""
        if self.equilibrium is not Equilibrium.HOLDS:
            return Translation.UNDECIDED
        if self.situation in (Situation.CARRIED, Situation.STICKING):
            return Translation.STABLE
        if self.linearization is None:
            return Translation.UNDECIDED
        trace, det = self.linearization.trace.sign(), self.linearization.determinant.sign()
        if trace < 0 < det:
            return Translation.ASYMPTOTICALLY_STABLE
        return Translation.UNSTABLE if det < 0 or trace > 0 else Translation.UNDECIDED

    def undecided(self, reason: str) -> EllipsePoint:
        """The same point without a claim."""
        return replace(self, situation=Situation.OPEN, twist=None, linearization=None, reason=reason)

    def check(self) -> bool:
        """Verify by forces and moments what the body does (module ``forces_check``); not that it is driven away."""
        scene, region, twist, linear = self.scene, self.region, self.twist, self.linearization
        zero = scene.field.zero
        if not region.polygon.contains((zero, zero)) or not (linear is None or linear.check()):
            return False
        if linear is not None and self.situation is not Situation.SMOOTH:
            return False
        if self.situation is Situation.MOVED or twist is None:
            return twist is None and self.situation in (Situation.MOVED, Situation.OPEN)
        if self.situation is Situation.CARRIED:
            return carries(scene, region, twist.velocity, twist.omega)
        if self.situation is Situation.STICKING:
            return not any(twist) and rests_by_sticking(scene, region, self.balance)
        spins = not any(twist.velocity)
        if self.situation is Situation.OPEN:
            return spins and balances(scene, region, twist.omega)
        return spins and is_smooth_minimum(scene, region, twist.omega, linear)

    def recompute(self) -> bool:
        """Whether deciding again gives the same."""
        return self == ellipse_point(self.scene, load_regions(self.scene, self.scene.check.equilibrium))


def ellipse_point(scene: Scene, regions: tuple[LoadRegion, ...]) -> EllipsePoint:
    """Decide the situation at the equilibrium of a centred scene."""
    zero = scene.field.zero
    here = [region for region in regions if region.polygon.contains((zero, zero))]
    region, balance = here[0], rest_balance(scene, here[0])

    def point(situation: Situation, reason: str, twist: Twist | None = None) -> EllipsePoint:
        return EllipsePoint(scene, region, situation, twist, balance, None, reason)

    carried = common_twist(scene, region)
    if carried is not None:
        return point(Situation.CARRIED, f"the twist {_text(carried)} satisfies every row of every wheel", carried)
    if balance.strict and balance.holds:
        what = "friction limits" if any(force.limits.is_cut for force in balance.stuck or ()) else "friction ellipses"
        reason = f"the sticking wheels balance the others strictly inside their {what}"
        return point(Situation.STICKING, reason, Twist(zero, zero, zero))
    rates = [zero, *(rate for rate in spin_candidates(scene, region) if rate)]
    resting = _resting_slips(scene, region)
    for rate in rates:
        if _is_smooth_minimizer(scene, region, rate, resting):
            return _smooth_point(scene, region, balance, rate, kinked=len(here) > 1)
    if _is_moved(resting):
        return point(Situation.MOVED, "the translation part of the gradient of D stays away from zero for every spin")
    reason = "wheels stick at the best motion, or its rotation rate is not a number of the scene"
    if any(slip.limits.is_cut for slip in slips_at(scene, region, zero)):
        reason = (
            "wheels stick at the best motion, or rollers turn there with rims that do not slip, "
            "or its rotation rate is not a number of the scene"
        )
    return point(Situation.OPEN, reason)


def _is_smooth_minimizer(scene: Scene, region: LoadRegion, rate: Number, resting: Sequence[_SlipBalls]) -> bool:
    """Whether the gradient of D exists and vanishes at ``(0, 0, rate)``; balls tell most that do not.

    The exact gradient takes the root of every wheel's slip into the scene's field.
    """
    with ctx.workprec(_PRECISION):
        pull = _gradient_ball(resting, rate.ball())
    if pull is not None and not all(entry.contains(0) for entry in pull):
        return False
    slips = slips_at(scene, region, rate)
    return all(slip.is_smooth for slip in slips) and not any(gradient(scene, slips))


def _smooth_point(
    scene: Scene, region: LoadRegion, balance: RestBalance, rate: Number, *, kinked: bool
) -> EllipsePoint:
    linear = linearize(scene, region, rate)
    zero = scene.field.zero
    if linear is None or not linear.is_positive_definite:
        reason = (
            f"the twist (0, 0, {brief_text(rate)}) minimizes D, but its Hessian is singular there: "
            "the motion near the point is not determined to first order"
        )
        return EllipsePoint(scene, region, Situation.OPEN, Twist(zero, zero, rate), balance, None, reason)
    what = f"a spin at {rate}" if rate else "rest"
    reason = f"the gradient of D vanishes at {what} and its Hessian is positive definite"
    if kinked:
        reason += "; the loads change their form at the equilibrium, so there is no linearization"
    return EllipsePoint(
        scene, region, Situation.SMOOTH, Twist(zero, zero, rate), balance, None if kinked else linear, reason
    )


def common_twist(scene: Scene, region: LoadRegion) -> Twist | None:
    """The twist that satisfies every row with friction of every wheel, where the wheels loaded at the point fix it."""
    rule = smooth_rule_of(scene)
    limits = {wheel.index: rule.friction_set(wheel.friction) for wheel in scene.wheels}
    rows = [row for row in scene_rows(scene) if _half_axis(row, limits[row.wheel.index])]
    loaded = [row for row in rows if region.forces[scene.places[row.wheel.index]][0]]
    basis = independent([row.normal for row in loaded])
    if len(basis) < 3:
        return None
    state = solve_rows((loaded[basis[0]], loaded[basis[1]], loaded[basis[2]]))
    if state is None or any(row.residual(state.twist) for row in rows):
        return None
    return state.twist


def _half_axis(row: Row, limits: FrictionSet) -> Number:
    """Of the friction set, along the row."""
    return limits.along if row.kind is RowKind.ROLL else limits.across


def _text(twist: Twist) -> str:
    return f"({twist.vx}, {twist.vy}, {twist.omega})"


# ---- no equilibrium: enclosures ----------------------------------------------------------


@dataclass(frozen=True)
class _SlipBalls:
    """A loaded wheel at rest, in balls: see :class:`nonsmooth.proofs.clauses.at_point.linearization.Slip`."""

    rows: tuple[tuple[arb, ...], tuple[arb, ...]]
    squares: tuple[arb, arb]
    slip: tuple[arb, arb]
    force: arb
    cut: arb | None


def _resting_slips(scene: Scene, region: LoadRegion) -> list[_SlipBalls]:
    slips = [slip for slip in slips_at(scene, region, scene.field.zero) if slip.force[0]]
    with ctx.workprec(_PRECISION):
        return [_slip_balls(slip) for slip in slips]


def _slip_balls(slip: Slip) -> _SlipBalls:
    a, b = (tuple(x.ball() for x in row) for row in slip.rows)
    roll, side = (x.ball() for x in slip.squares)
    cut = slip.limits.cut.ball() if slip.limits.is_cut else None
    return _SlipBalls((a, b), (roll, side), (slip.along.ball(), slip.across.ball()), slip.force[0].ball(), cut)


def _is_moved(slips: Sequence[_SlipBalls]) -> bool:
    """Whether no ``(0, 0, omega)`` minimizes D: enclose the best omega, then the gradient over the enclosure."""
    with ctx.workprec(_PRECISION):
        bracket = _best_rate(slips)
        if bracket is None:
            return False
        lower, upper = bracket
        pull = _gradient_ball(slips, arb(lower).union(arb(upper)))
    return pull is not None and (not pull[0].contains(0) or not pull[1].contains(0))


def _best_rate(slips: Sequence[_SlipBalls]) -> tuple[fmpq, fmpq] | None:
    """Rational bracket of the zero of dD/domega along pure rotations; None where its sign is not certain."""
    bound = fmpq(1)
    for _ in range(_DOUBLINGS):
        ends = [_torque_sign(slips, sign * bound) for sign in (-1, 1)]
        if ends == [-1, 1]:
            break
        bound *= 2
    else:
        return None
    lower, upper = -bound, bound
    for _ in range(_BISECTIONS):
        for share in (fmpq(3, 8), fmpq(1, 2), fmpq(5, 8)):  # a zero at the middle leaves its sign open
            rate = lower + (upper - lower) * share
            side = _torque_sign(slips, rate)
            lower, upper = (rate, upper) if side == -1 else (lower, rate) if side == 1 else (lower, upper)
    return lower, upper


def _torque_sign(slips: Sequence[_SlipBalls], rate: fmpq) -> int | None:
    pull = _gradient_ball(slips, arb(rate))
    if pull is None or pull[2].contains(0):
        return None
    return 1 if pull[2] > 0 else -1


def _gradient_ball(slips: Sequence[_SlipBalls], rate: arb) -> tuple[arb, arb, arb] | None:
    """Enclosure of the gradient of D at ``(0, 0, rate)``; None where a wheel may stick, or its rim not slip."""
    total = [arb(0), arb(0), arb(0)]
    for slip in slips:
        (a, b), (roll, side) = slip.rows, slip.squares
        r, s = a[2] * rate + slip.slip[0], b[2] * rate + slip.slip[1]
        square = roll * r * r + side * s * s
        if not square > 0 or (slip.cut is not None and r.contains(0)):
            return None
        scale = slip.force / square.sqrt()
        along, across = scale * roll * r, scale * side * s
        if slip.cut is not None and not side * s * s < slip.cut * slip.cut * square:
            along, across = _cut_force(slip, slip.cut, r, across)
        for k in range(3):
            total[k] += along * a[k] + across * b[k]
    return total[0], total[1], total[2]


def _cut_force(slip: _SlipBalls, cut: arb, r: arb, across: arb) -> tuple[arb, arb]:
    """The force of a slip whose force on the ellipse may pass the cut: held at the cut, the rest along the rim."""
    roll, side = slip.squares
    limit = slip.force * side.sqrt() * cut
    held = across.min(limit).max(-limit)
    share = (held / (slip.force * side.sqrt())) ** 2
    along = slip.force * (roll * (1 - share)).sqrt()
    return (along if r > 0 else -along), held
