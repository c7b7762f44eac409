"""Rules with friction sets over a box of parameters: one equilibrium nearby for every array, which attracts.

With g the gradient of D in the twist (force and moment), an equilibrium is a zero of ``F(c, omega) = g(xi; c)`` at the
twist of a body that turns about its own centre, ``xi = (omega c_y, -omega c_x, omega)``.  Krawczyk's operator ::

    K(Z) = z_0 - Y F(z_0; Q) + (1 - Y F'(Z; Q))(Z - z_0)

maps the box Z into its interior only where, for every array of the box Q, Z holds exactly one zero.  About it, to first
order, ``c' = A c`` with ``A = V + omega J + (J c) w^T``, ``(V; w) = -(dg/dxi)^-1 dg/dc``.  Where dg/dxi is regular, and
so positive definite as D is convex, the trace of A negative and its determinant positive, all over Z and Q, each of
these equilibria attracts exponentially.

Per unit of weight, about the origin, with ``alpha, beta`` the half-axes of a wheel's friction set, r and s its slips
along the friction axis a and across it and ``f = |(alpha r, beta s)|``, its force is ``N_i (alpha^2 r a + beta^2 s J
a)/f``.  Over the box of its own parameters it is enclosed by the mean value theorem.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache, partial, reduce
from typing import Any, TypeAlias

import numpy as np
from flint import arb, arb_mat, ctx
from numpy.typing import NDArray

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.boxes.balanced_forces import LoadBox, Triple, load_box
from nonsmooth.proofs.boxes.enclosed_rest import Balance, EnclosedRest, isolated_rest
from nonsmooth.proofs.boxes.enclosures import UNIT, Jet, newton, parameters, turned_by, unit_vector
from nonsmooth.proofs.boxes.intervals import Intervals, cosine
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.robust.box import BoxWheel, box_wheels, half_widths
from nonsmooth.proofs.robust.level_sets import AnnulusPiece
from nonsmooth.proofs.robust.plane_minimum import PlaneMinima, PlaneMinimum
from nonsmooth.proofs.robust.rings import RingProof
from nonsmooth.symbolic.mechanics.rule import MIXED
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance, Wheel
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.plane import dot
from nonsmooth.symbolic.numbers.plane_arrays import Floats, Mask, even_angles

# ---- enclosures of friction forces over boxes of slips, for friction sets with a support function
#
# Per unit of load the force is a subgradient of the support function of the friction set at the slip ``(r, s)``:
#
# - rule ``ellipse``: ``(mu_R u_1, mu_S u_2)``, u the unit vector along ``(mu_R r, mu_S s)``;
# - rule ``roller``: ``f_S = mu_R u_2`` cut to ``|f_S| <= mu_S``, u the unit vector along ``(r, s)``, and ``f_R = +-
#   sqrt(mu_R^2 - f_S^2)`` with the sign of r.
#
# Where a slip may vanish, the enclosure holds the whole friction set, or the part of it that its sign allows: whatever
# subgradient acts, it is inside.  Wheels of a ``mixed`` array have the law of the rule that each of them names.


ForceLaw: TypeAlias = Callable[[Intervals, Intervals, Intervals, Intervals], tuple[Intervals, Intervals]]


def ellipse_force(roll: Intervals, side: Intervals, r: Intervals, s: Intervals) -> tuple[Intervals, Intervals]:
    """Along the friction axis and across it, per unit of load.

    Args:
        roll: mu_R.
        side: mu_S.
        r: slip along the axis.
        s: slip across it.
    """
    a, b = roll * r, side * s
    return roll * cosine(a, b), side * cosine(b, a)


def roller_force(roll: Intervals, side: Intervals, r: Intervals, s: Intervals) -> tuple[Intervals, Intervals]:
    """The same for wheels with passive rollers."""
    across = (roll * cosine(s, r)).within(side)
    size = (roll.square - across.square).sqrt()
    along = Intervals(
        np.where(r.low > 0, size.low, -size.high),
        np.where(r.high < 0, -size.low, size.high),
    )
    return along, across


def mixed_force(
    rolls: Mask, roll: Intervals, side: Intervals, r: Intervals, s: Intervals
) -> tuple[Intervals, Intervals]:
    """The same for wheels of which some have rollers: ``rolls`` says it of each, along the last axis."""
    pairs = zip(roller_force(roll, side, r, s), ellipse_force(roll, side, r, s), strict=True)
    along, across = (
        Intervals(np.where(rolls, of_roller.low, of_rim.low), np.where(rolls, of_roller.high, of_rim.high))
        for of_roller, of_rim in pairs
    )
    return along, across


# The rules whose forces are written here, and whether rollers cut the disc; another rule has no entry and is a fault.
HAS_ROLLERS = {"ellipse": False, "roller": True}
FOLLOWED = frozenset({*HAS_ROLLERS, MIXED})


def rollers(scene: Scene) -> list[bool]:
    """Of each wheel of a scene under one of the rules :data:`FOLLOWED`, whether rollers cut its friction disc."""
    return [HAS_ROLLERS[wheel.friction.rule or scene.contact.rule] for wheel in scene.wheels]


def force_law(scene: Scene) -> ForceLaw:
    """The force of each wheel of such a scene."""
    rolls = rollers(scene)
    if all(rolls):
        return roller_force
    return partial(mixed_force, np.array(rolls)) if any(rolls) else ellipse_force


# ---- of all wheels -------------------------------------------------------------------------------
#
# Forces and moments of all arrays of a box, for several quadrangles of places and several boxes of twists at once.
# Directions are those of the ray through the middle of a quadrangle: ``e_0`` along it, ``J e_0`` across it.


Pair: TypeAlias = tuple[Intervals, Intervals]

ROUNDED = arb(2) ** -40  # of a ray's angle: rays are rounded to doubles


@dataclass(frozen=True)
class ArrayBox:
    """All arrays of a box.

    Attributes:
        wheels: with their parameters over the box.
        loads: affine in the place of the body.
        law: the force of a wheel under the contact rule.
    """

    wheels: list[BoxWheel]
    loads: LoadBox
    law: ForceLaw


@dataclass(frozen=True)
class PieceForces:
    """For several quadrangles; arrays of shape (pieces, parts, wheels), or (pieces, parts) for sums over wheels.

    Attributes:
        law: the force of a wheel.
        speeds: of the rows of each wheel (wheels, 2).
        frictions: of its rows (wheels, 2).
        loads: in the middle of each quadrangle, and how they change along ``e_0`` and ``J e_0`` (pieces, 1, wheels, 3).
        rows: slips by unit velocities along ``e_0`` and ``J e_0``, and by a unit rotation (pieces, 1, wheels, 3, 2).
        frame: of a place, how far it is from the middle along ``e_0`` and ``J e_0``, and the cosine and the sine of
            its angle with ``e_0`` (pieces, 1, 4).
        length: mean distance of the wheels.
    """

    law: ForceLaw
    speeds: Intervals
    frictions: Intervals
    loads: Intervals
    rows: Intervals
    frame: Intervals
    length: float

    @classmethod
    def of(cls, bound: ArrayBox, pieces: Sequence[AnnulusPiece]) -> PieceForces:
        """Of all arrays of a box."""
        return cls._of(bound, [_frame(piece) for piece in pieces])

    @classmethod
    def at_point(cls, bound: ArrayBox) -> PieceForces:
        """With the body at the origin, as for one quadrangle; ``e_0`` is the x axis."""
        zero, one = arb(0), arb(1)
        return cls._of(bound, [((one, zero), zero, (zero, zero, one, zero))])

    @classmethod
    def _of(cls, bound: ArrayBox, frames: Sequence[tuple[tuple[arb, arb], arb, Sequence[arb]]]) -> PieceForces:
        """From rays ``e_0``, distances of the middles, and what is known of the places there."""
        wheels, zero, one = bound.wheels, arb(0), arb(1)
        loads, rows = [], []
        for (x, y), middle, _ in frames:
            forms = zip(bound.loads.at((middle * x, middle * y)), bound.loads.forms, strict=True)
            loads.append([(load, p * x + q * y, q * x - p * y) for load, (_, p, q) in forms])
            units = (x, y, zero), (-y, x, zero), (zero, zero, one)
            rows.append([[wheel.moved(unit) for unit in units] for wheel in wheels])
        places = [math.hypot(*(float(entry) for entry in wheel.place)) for wheel in wheels]
        return cls(
            law=bound.law,
            speeds=Intervals.about([wheel.speeds for wheel in wheels]),
            frictions=Intervals.about([[a * b for a, b in zip(w.nominal, w.shares, strict=True)] for w in wheels]),
            loads=Intervals.about(loads)[:, None],
            rows=Intervals.about(rows)[:, None],
            frame=Intervals.about([frame for *_, frame in frames])[:, None],
            length=sum(places) / len(places) or 1.0,
        )

    def at(self, chosen: NDArray[np.intp]) -> PieceForces:
        """Of some quadrangles."""
        return replace(self, loads=self.loads[chosen], rows=self.rows[chosen], frame=self.frame[chosen])

    @property
    def turn(self) -> Pair:
        """Cosine and sine of the angle between ``e_0`` and a place (pieces, 1)."""
        return self.frame[..., 2], self.frame[..., 3]

    def forces(self, twists: Triple) -> Pair:
        """Of each wheel along its friction axis and across it, per unit of load.

        Args:
            twists: velocities along ``e_0`` and ``J e_0``, and rotations (pieces, parts).
        """
        r, s = self._moved(twists)
        return self.law(self.frictions[:, 0], self.frictions[:, 1], r - self.speeds[:, 0], s - self.speeds[:, 1])

    def power(self, forces: Pair, twists: Triple) -> Intervals:
        """Of all wheels' forces in twists (pieces, parts), the loads those of any place of the quadrangle."""
        r, s = self._moved(twists)
        return self._weighed(forces[0] * r + forces[1] * s)

    def wrench(self, forces: Pair) -> Triple:
        """Force along ``e_0`` and ``J e_0``, and moment, of all wheels (pieces, parts)."""
        along, across, moment = (
            self._weighed(forces[0] * self.rows[..., k, 0] + forces[1] * self.rows[..., k, 1]) for k in range(3)
        )
        return along, across, moment

    def least_power(self, forces: Pair, directions: Floats) -> Floats:
        """About the lower end of the power in several directions, in floats.

        Args:
            forces: of each wheel (pieces, 1, wheels).
            directions: along ``e_0`` and ``J e_0``, and rotation (pieces, choices, 3).

        Returns:
            Shape (pieces, choices).
        """
        total: Any = 0.0
        rows, loads = self.rows.middle[:, 0], self.loads.middle[:, 0, :, 0]
        for side, force in enumerate(forces):
            side_rows = rows[..., side]
            moved = directions @ side_rows.swapaxes(-1, -2)
            middle, reach = ((entry[:, 0] * loads)[..., None] for entry in (force.middle, force.reach))
            total = total + directions @ (side_rows.swapaxes(-1, -2) @ middle) - np.abs(moved, out=moved) @ reach
        return total[..., 0]

    def _moved(self, twists: Triple) -> Pair:
        """Slips of each wheel by twists alone, without its speed."""
        x, y, spin = (entry[..., None] for entry in twists)
        r, s = (
            self.rows[..., 0, side] * x + self.rows[..., 1, side] * y + self.rows[..., 2, side] * spin
            for side in range(2)
        )
        return r, s

    def _weighed(self, powers: Intervals) -> Intervals:
        """Their sum over the wheels, with the loads of any place of the quadrangle."""
        middle, along, across = ((self.loads[..., k] * powers).sum(axis=-1) for k in range(3))
        return middle + self.frame[..., 0] * along + self.frame[..., 1] * across


def _frame(piece: AnnulusPiece) -> tuple[tuple[arb, arb], arb, Sequence[arb]]:
    """Of a quadrangle the middle ray, the distance of its middle, and the places there."""
    turn, angle = rational_ball(2 * piece.start + piece.width), rational_ball(piece.width) * arb.pi() + ROUNDED
    x, y = turn.cos_pi(), turn.sin_pi()
    corners = [(rational_ball(a), rational_ball(b)) for a, b in piece.corners]
    middle = rational_ball((piece.inner + piece.outer) / 2)
    along, across = [a * x + b * y - middle for a, b in corners], [b * x - a * y for a, b in corners]
    hulls = reduce(arb.union, along), reduce(arb.union, across)
    return (x, y), middle, (*hulls, (angle * UNIT).cos(), (angle * UNIT).sin())


# ---- rules with friction sets over a box ---------------------------------------------------------


PRECISION = 64  # bits of the balls
NEWTON_STEPS = 20  # to the middle of the box

TWIST = 3  # entries; then x, y, angle, speed and the two frictions of a wheel, and its load


def equilibrium_box(scene: Scene, box: Tolerance) -> EnclosedRest | None:
    """The equilibria of all arrays of a box about a centred scene, where they are proved to attract; else None."""
    with ctx.workprec(PRECISION):
        arrays, centre = ArrayBalance.of(scene, box), _centre(scene, box.times(Fraction(0)))
        rest = None if arrays is None or centre is None else isolated_rest(arrays, centre)
        return rest if rest is not None and rest.stability is Translation.ASYMPTOTICALLY_STABLE else None


@lru_cache(maxsize=8)  # many boxes about one scene are asked for
def _centre(scene: Scene, none: Tolerance) -> arb_mat | None:
    """About the equilibrium of the scene itself, without tolerances, from the spin at the point in floats."""
    nominal = ArrayBalance.of(scene, none)
    omega = float(minima_under(smooth_rule_of(scene), scene, np.zeros((1, 2))).twists[0, 2])
    if nominal is None or not np.isfinite(omega):
        return None
    return newton(nominal.at_rest, arb_mat([[arb(0)], [arb(0)], [arb(omega)]]), NEWTON_STEPS)


class ArrayBalance(Balance):
    """The equations of all arrays of a box, none of whose wheels is held.

    Their values are right to first order in the size of the box: those of the scene itself, and what the parameters of
    each wheel add by the mean value theorem.
    """

    def __init__(self, scene: Scene, box: Tolerance, loads: LoadBox, nominal: LoadBox) -> None:
        """From the loads of all arrays, and those of the scene."""
        super().__init__(scene, loads, {})
        wheels = zip(scene.wheels, rollers(scene), strict=True)
        self._wheels = [(wheel, rolls, half_widths(wheel, box)) for wheel, rolls in wheels]
        self._nominal = nominal

    @classmethod
    def of(cls, scene: Scene, box: Tolerance) -> ArrayBalance | None:
        """Those of a box about a centred scene; None where springs may not fix the loads."""
        loads, nominal = load_box(scene, box.position.ball()), load_box(scene, arb(0))
        return None if loads is None or nominal is None else cls(scene, box, loads, nominal)

    def at(self, unknowns: arb_mat, place: Sequence[arb]) -> tuple[arb_mat, arb_mat, arb_mat] | None:
        """As of one array; None where a wheel of some array may stick or lift off."""
        twist = unknowns.entries()
        loads, middles = self._loads.at(place), self._nominal.at(place)
        value, by_twist, by_place = arb_mat(3, 1), arb_mat(3, 3), arb_mat(3, 2)
        for (wheel, rolls, widths), load, middle, form in zip(
            self._wheels, loads, middles, self._loads.forms, strict=True
        ):
            at_middle = _wrench(wheel, [*twist, *[arb(0)] * len(widths), middle], has_rollers=rolls)
            over_box = _wrench(wheel, [*twist, *(size * UNIT for size in widths), load], has_rollers=rolls)
            if at_middle is None or over_box is None or not load > 0:
                return None
            sizes = [*widths, abs(load - middle)]
            for r, (centre, entry) in enumerate(zip(at_middle, over_box, strict=True)):
                value[r, 0] += Jet(entry.value, entry.slopes[TWIST:]).over(sizes, centre.value)
                for k in range(TWIST):
                    by_twist[r, k] += entry.slopes[k]
                for k in range(2):
                    by_place[r, k] += entry.slopes[-1] * form[k + 1]
        return value, by_twist, by_place


def _wrench(wheel: Wheel, values: Sequence[arb], *, has_rollers: bool) -> tuple[Jet, Jet, Jet] | None:
    """Force and moment of a wheel; None where it may stick, or its rollers may turn.

    Args:
        wheel: of a centred scene.
        values: of the twist, of what is added to the wheel's own parameters, and of its load.
        has_rollers: whether the friction set is the disc of mu_R cut by a strip of mu_S (rule ``roller``).
    """
    vx, vy, omega, x, y, angle, speed, roll, side, load = parameters(values)
    px, py = (shift + entry.ball() for shift, entry in zip((x, y), wheel.position, strict=True))
    first, second = (entry.ball() for entry in wheel.unit_grip)
    a, b = turned_by(first, second, angle)
    along, across = ((gain / wheel.grip_length).ball() for gain in wheel.gains)
    drive, at_x, at_y = speed + wheel.speed.ball(), vx - omega * py, vy + omega * px
    r, s = at_x * a + at_y * b - drive * along, at_y * a - at_x * b - drive * across
    mu_roll, mu_side = roll + wheel.friction.roll.ball(), side + wheel.friction.side.ball()
    mu_across = mu_roll if has_rollers else mu_side
    unit = unit_vector(mu_roll * r, mu_across * s)
    if unit is None or (has_rollers and not abs(unit[1].value) * mu_roll.value < mu_side.value):
        return None
    pull, push = mu_roll * unit[0], mu_across * unit[1]
    fx, fy = load * (pull * a - push * b), load * (pull * b + push * a)
    return fx, fy, px * fy - py * fx


# ---- rules ``ellipse`` and ``roller`` over a box of parameters: where every body comes nearer ----
#
# At a place c with ``e = c/|c|`` the body moves with a twist that minimizes D.  Look at D on the plane ``e . v =
# -kappa`` first.  At a least value there some subgradient is ``g = lambda (e, 0)``; where lambda is positive, ``D(xi')
# >= D + lambda (e . v' + kappa)`` for every twist xi', so that all minimizers of D have ``e . v < -kappa``.
#
# - *Where the least value is.* On the border of a square about a guess ``xi^`` let ``g . (xi - xi^) > 0`` for every
#   subgradient.  Then D increases outward there, and, being convex, has all its least values on the plane inside.
# - *The sign of lambda.* On each part of the square some direction zeta with ``zeta . (e, 0) > 0`` has ``g . zeta > 0``
#   for every subgradient of every array.  Where ``g = lambda (e, 0)``, that makes lambda positive.
#
# The directions come from floats; they may differ from part to part, and they are what makes the bound sharp: along one
# that no wheel's friction changes much, arrays differ little.  All places of a quadrangle and all arrays of the box are
# taken at once, in intervals.  Every parameter of a wheel enters its own force only, and forces are added with loads
# that are affine in c.  Twists are about the origin: ``c . v`` is the same for the velocity of the centre of mass.


SHARES = (0.4, 0.05)  # of the rate of the scene itself, tried one after the other
SQUARES = (1.2, 1.5, 2.0, 3.0)  # of the least square that may do
LEAST_SQUARE = 2.0**-40  # half-width of a square, in units in which D curves by one
AT_ONCE = 8  # quadrangles
SIDE_PARTS = 12  # of each side of the border
SQUARE_PARTS = 6  # of each side of the square, at first
DIVISIONS = 5  # of a part into four
MOST_PARTS = 1000  # of one square at a time
LEANINGS = (-2.5, -0.7, 0.0, 0.7, 2.5)  # of a direction, across e and by rotation
ANGLES = 12  # of directions nearly in the plane


class SmoothDisc(RingProof[ArrayBox]):
    """A centred scene under a rule with friction sets; what floats propose for it is kept for all boxes about it."""

    widest = Fraction(1, 5)
    growth = 2
    halvings = 3
    starts = (Fraction(1), Fraction(3, 4), Fraction(1, 2))
    sectors = 32
    depth = 1

    def __init__(self, scene: Scene) -> None:
        """For a scene whose loads are known."""
        self._scene = scene
        self._minima = PlaneMinima(scene)

    def over(self, box: Tolerance) -> ArrayBox | None:
        """The arrays of a box; None where springs may not fix the loads."""
        loads = load_box(self._scene, box.position.ball())
        return None if loads is None else ArrayBox(box_wheels(self._scene, box), loads, force_law(self._scene))

    def rates(self, bound: ArrayBox, pieces: Sequence[AnnulusPiece], *, at_any: bool) -> Iterator[arb | None]:
        """A few at a time: where one fails in the end, the others are not looked at."""
        shares = sorted(SHARES) if at_any else SHARES  # small ones are shown with less work
        for k in range(0, len(pieces), AT_ONCE):
            yield from self._rates(bound, pieces[k : k + AT_ONCE], shares)

    def _rates(self, bound: ArrayBox, pieces: Sequence[AnnulusPiece], shares: Sequence[float]) -> list[arb | None]:
        """The first share of the scene's own rate that is shown on each."""
        kappas: dict[AnnulusPiece, float] = {}
        nearer = zip(pieces, self._minima.radial(pieces), strict=True)
        open_ones = [piece for piece, rate in nearer if rate is not None and _is_carried(bound, piece)]
        for share in shares:
            guesses = [(piece, self._minima.on_plane(piece, share)) for piece in open_ones if piece not in kappas]
            pairs = [(piece, guess) for piece, guess in guesses if guess is not None]
            if pairs:
                are_nearer = _come_nearer(bound, [piece for piece, _ in pairs], [guess for _, guess in pairs])
                kappas |= {piece: guess.kappa for (piece, guess), near in zip(pairs, are_nearer, strict=True) if near}
        return [arb(kappas[piece]) if piece in kappas else None for piece in pieces]


def _is_carried(bound: ArrayBox, piece: AnnulusPiece) -> bool:
    """Whether every wheel of every array carries all over a quadrangle; loads are affine."""
    corners = [(rational_ball(x), rational_ball(y)) for x, y in piece.corners]
    return all(load > 0 for corner in corners for load in bound.loads.at(corner))


def _come_nearer(bound: ArrayBox, pieces: list[AnnulusPiece], guesses: list[PlaneMinimum]) -> Mask:
    """Whether all minimizers have ``e . v < -kappa`` on each of several quadrangles."""
    plan, forces = np.array(guesses), PieceForces.of(bound, pieces)
    nothing = Intervals.of(np.zeros((len(pieces), 1)))
    radial, across, moment = forces.wrench(forces.forces(_twists(plan, forces, nothing, nothing)))
    a, b, c, d = (Intervals.of(plan[:, k, None]) for k in range(3, 7))
    sideways = forces.turn[0] * across - forces.turn[1] * radial
    pull = ((a * sideways + c * moment).square + (b * sideways + d * moment).square).sqrt().high[:, 0]
    enclosed, sizes = np.zeros(len(pieces), dtype=bool), np.zeros(len(pieces))
    for inflation in SQUARES:
        indices = np.flatnonzero(~enclosed)
        if len(indices):
            size = inflation * pull[indices] + LEAST_SQUARE
            inside = _is_outward(plan[indices], forces.at(indices), size)
            enclosed[indices[inside]], sizes[indices[inside]] = True, size[inside]
    indices = np.flatnonzero(enclosed)
    nearer = np.zeros(len(pieces), dtype=bool)
    if len(indices):
        nearer[indices] = _is_positive(plan[indices], forces.at(indices), sizes[indices])
    return nearer


def _is_outward(plan: Floats, forces: PieceForces, size: Floats) -> Mask:
    """Whether D increases outward all along the border of each square."""
    ends = np.linspace(-1.0, 1.0, SIDE_PARTS + 1)
    part, one = Intervals(ends[:-1], ends[1:]), Intervals.of(np.ones(SIDE_PARTS))
    wide = Intervals.of(size[:, None])
    first, second = Intervals.joined([part, part, one, -one]) * wide, Intervals.joined([one, -one, part, part]) * wide
    lateral, spin = _offset(plan, first, second)
    middle = Intervals.of(lateral.middle), Intervals.of(spin.middle)
    pulls = forces.forces(_twists(plan, forces, first, second))
    radial, across, moment = forces.wrench(pulls)
    (cosine, sine), zero = forces.turn, Intervals.of(np.zeros((1, 1)))
    # forces nearly cancel: T z is split into its middle, the rest, and what turning it from e_0 to the place adds
    at_middle = forces.power(pulls, (zero, *middle))
    rest = (lateral - middle[0]) * across + (spin - middle[1]) * moment
    turned = lateral * ((cosine - Intervals.of(1.0)) * across - sine * radial)
    return np.asarray(((at_middle + rest + turned).low > 0).all(axis=1))


def _is_positive(plan: Floats, forces: PieceForces, size: Floats) -> Mask:
    """Whether on each part of each square ``g . zeta > 0``, with a direction zeta that serves; parts are divided."""
    count, grid = len(size), np.indices((SQUARE_PARTS, SQUARE_PARTS)).reshape(2, -1)
    middles = (2 * grid + 1 - SQUARE_PARTS) / SQUARE_PARTS
    owner = np.repeat(np.arange(count), len(middles[0]))
    first, second = np.tile(middles[0], count), np.tile(middles[1], count)
    half = 1 / SQUARE_PARTS
    for _ in range(DIVISIONS):
        positive = _are_positive(plan[owner], forces.at(owner), size[owner], (first, second), half)
        owner, first, second = owner[~positive], first[~positive], second[~positive]
        if not len(owner) or len(owner) > MOST_PARTS * count:
            break
        half /= 2
        owner = np.tile(owner, 4)
        first = np.concatenate([first + i * half for i in (-1, 1) for _ in range(2)])
        second = np.concatenate([second + j * half for _ in range(2) for j in (-1, 1)])
    all_positive = np.ones(count, dtype=bool)
    all_positive[owner] = False
    return all_positive


def _are_positive(plan: Floats, forces: PieceForces, size: Floats, middles: tuple[Floats, Floats], half: float) -> Mask:
    """The same for one part of each square."""
    wide = Intervals.of(size[:, None])
    first, second = (Intervals(entry - half, entry + half).widened[:, None] * wide for entry in middles)
    pulls = forces.forces(_twists(plan, forces, first, second))
    zeta = _directions(forces, pulls)
    along = dot(zeta, forces.turn)
    return ((along.low > 0) & (forces.power(pulls, zeta).low > 0))[:, 0]


def _directions(forces: PieceForces, pulls: Pair) -> tuple[Intervals, Intervals, Intervals]:
    """For each part the direction along which the least power is largest; (pieces, 1) each."""
    zeta = _candidates(2 * forces.turn[1].high[:, 0], forces.length)
    sizes = np.linalg.norm(zeta * (1.0, 1.0, forces.length), axis=-1)  # the same in every unit of length
    value = forces.least_power(pulls, zeta) / sizes
    best = np.take_along_axis(zeta, value.argmax(axis=1)[:, None, None], axis=1)
    first, second, third = (Intervals.of(best[..., k]) for k in range(3))
    return first, second, third


def _candidates(tilt: Floats, length: float) -> Floats:
    """Directions ``(along e, across e, rotation)``, (pieces, choices, 3); of the last ones ``tilt`` is along e."""
    leaning = [(1.0, across, turn / length) for across in LEANINGS for turn in LEANINGS]
    angles = even_angles(ANGLES)
    directions = np.zeros((len(tilt), len(leaning) + ANGLES, 3))
    directions[:, : len(leaning)] = leaning
    directions[:, len(leaning) :, 0] = tilt[:, None]
    directions[:, len(leaning) :, 1:] = np.column_stack([np.cos(angles), np.sin(angles) / length])
    return directions


# Guesses are columns: kappa, lateral velocity and spin of xi^, and T two by two; (pieces, 7).


def _offset(plan: Floats, first: Intervals, second: Intervals) -> tuple[Intervals, Intervals]:
    """``T z``: lateral velocity and spin."""
    a, b, c, d = (Intervals.of(plan[:, k, None]) for k in range(3, 7))
    return a * first + b * second, c * first + d * second


def _twists(plan: Floats, forces: PieceForces, first: Intervals, second: Intervals) -> Triple:
    """``xi^ + T z``, for every e of the quadrangle."""
    (lateral, spin), (cosine, sine) = _offset(plan, first, second), forces.turn
    kappa, at_lateral, at_spin = (Intervals.of(plan[:, k, None]) for k in range(3))
    lateral, spin = lateral + at_lateral, spin + at_spin
    return -(kappa * cosine) - lateral * sine, lateral * cosine - kappa * sine, spin
