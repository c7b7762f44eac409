"""A place of rest near a point under a rule without cells, enclosed in balls.

With ``G(xi, c)`` the gradient of D in the twist, a body that rests at c, and may turn there, has the twist
``xi = omega (c_y, -c_x, 1)``; Krawczyk's operator encloses the zero ``(c, omega)`` of G and shows that it is the only
one nearby.  Where D bends in every direction the twist is smooth in c, and ``c' = A (c - c_0)`` to first order ::

    A = V + omega J + (J c) w,    (V; w) = -(dG/dxi)^-1 dG/dc.

Where D has an edge, held wheels keep it: a rim that does not slip while its rollers turn, or a wheel without any slip.
Their forces, inside the friction sets, are unknowns beside the twist, and their slips stay zero (:class:`Balance`).
Three rows that are held fix the twist: near the place of rest the body turns about it wherever its centre of mass is.

All numbers of the scene are boxes, zero wide where they are exact.  So each member of what was rounded has a place of
rest in the box, and what is true of A all over the box is true of each.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.contact_rule import has_cells, smooth_rule_of
from nonsmooth.proofs.boxes.balanced_forces import BalancedForces, LoadBox, load_box
from nonsmooth.proofs.boxes.enclosures import (
    UNIT,
    isolated_zero,
    linear_stability,
    newton,
    slope_of_pose_rate,
)
from nonsmooth.proofs.boxes.linearization import Slip, slip_at_rest
from nonsmooth.proofs.findings import Translation
from nonsmooth.symbolic.mechanics.contact_states import added, scaled
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.enclosures import rational_above, rational_below
from nonsmooth.symbolic.numbers.number_text import upper_text

PRECISION = 128  # bits
NEWTON_STEPS = 6
CENTRED = 2.0**-30  # of twist and forces: Newton's step in the middle of a box after which no better one is needed
DIGITS = 4  # of a bound of its distance from the point
SPIN_DECIMALS = 15  # of the bounds of a rotation rate
ROUNDING = Fraction(1, 10**11)  # of the accuracy: a place of rest so near is the point, to all printed digits
# Of the fastest rim: a slip so slow is taken to be held; where that is refuted, only one that is rounding of floats.
HELD = 2.0**-16, 2.0**-36
PARTS = 8  # of a side of a square in which wheels are held


class Balance:
    """G with its derivatives, in balls, where some wheels are held.

    The force of a held wheel, unknown too, is inside a straight side of its friction set where its rollers turn, or
    inside the set.  The unknowns are ``y = (xi, f)``, f the forces of the held rows per unit of load ::

        G(xi, c) + sum_k N_k f_k row_k = 0,     row_k . xi = u_k.

    Where this has a regular Jacobian, with forces strictly inside, D has no other minimizer than xi: D bends, or has an
    edge, in every direction.
    """

    def __init__(self, scene: Scene, loads: LoadBox, held: Mapping[int, int]) -> None:
        """For a number of held rows, one or two, of some wheels: at most three in all."""
        from nonsmooth.symbolic.mechanics.edge_headings import ball_of

        rule, zero = smooth_rule_of(scene), scene.field.zero
        self._slips = [slip_at_rest(wheel, (zero, zero, zero), rule).map(ball_of) for wheel in scene.wheels]
        self._loads, self._held = loads, held
        self.size = 3 + sum(held.values())
        self.fixes_twist = self.size == 6

    def at(self, unknowns: arb_mat, place: Sequence[arb]) -> tuple[arb_mat, arb_mat, arb_mat] | None:
        """The equations (n, 1), by the unknowns (n, n) and by the place (n, 2).

        None where another wheel may stick, one that is held may slip, or one may lift off.
        """
        value, bend, by_place = arb_mat(self.size, 1), arb_mat(self.size, self.size), arb_mat(self.size, 2)
        twist, row = unknowns.entries()[:3], 3
        loads = self._loads.at(place)
        for k, (slip, load, (_, *load_slope)) in enumerate(zip(self._slips, loads, self._loads.forms, strict=True)):
            now, count = slip.moved(twist), self._held.get(k, 0)
            forces = unknowns.entries()[row : row + count]
            pull = self._held_pull(now, forces) if count else now.pull if now.is_smooth else None
            if pull is None or not load > 0:
                return None
            for i in range(3):
                value[i, 0] += load * pull[i]
                for j in range(2):
                    by_place[i, j] += pull[i] * load_slope[j]
                if not count:
                    for j in range(3):
                        bend[i, j] += load * now.bend * now.w[i] * now.w[j]
            for held_row, speed in list(zip(now.rows, (now.along, now.across), strict=True))[:count]:
                value[row, 0] = speed
                for i in range(3):
                    bend[i, row], bend[row, i] = load * held_row[i], held_row[i]
                row += 1
        return value, bend, by_place

    def at_rest(self, z: arb_mat) -> tuple[arb_mat, arb_mat] | None:
        """The equations for a body that rests, and their derivative by ``z = (c_x, c_y, omega, f)``."""
        x, y, omega, *_ = z.entries()
        equations = self.at(unknowns_at_rest(z), (x, y))
        if equations is None:
            return None
        value, bend, by_place = equations
        through = arb_mat(self.size, self.size, bend.entries())
        for k in range(self.size):
            by_vx, by_vy, by_omega = (bend[k, j] for j in range(3))
            through[k, 0] = by_place[k, 0] - omega * by_vy
            through[k, 1] = by_place[k, 1] + omega * by_vx
            through[k, 2] = y * by_vx - x * by_vy + by_omega
        return value, through

    def _held_pull(self, slip: Slip[arb], forces: Sequence[arb]) -> tuple[arb, arb, arb] | None:
        """The force of a wheel that is held, along its rim alone or across it too; None where it may begin to slip."""
        limits, (a, b) = slip.limits, slip.rows
        if len(forces) == 2:
            along, across = forces
            inside = limits.holds_strictly(along / limits.along, across / limits.across)
        else:
            (along,), turning = forces, limits.across * slip.across
            push = limits.across * limits.cut
            # the straight side ends at the corners, and the rollers turn one way, or the twist does not ask how they do
            inside = limits.is_cut and bool(abs(along) < limits.along * limits.corner)
            inside = inside and (bool(turning != 0) or self.fixes_twist)
            across = push if turning > 0 else -push if turning < 0 else push * arb(0, 1)
        return added(scaled(a, along), scaled(b, across)) if inside else None


def unknowns_at_rest(z: arb_mat) -> arb_mat:
    """Twist and held forces (n, 1) of a body that turns on the spot, from ``z = (c_x, c_y, omega, f)``."""
    x, y, omega, *forces = z.entries()
    return arb_mat([[entry] for entry in (omega * y, -omega * x, omega, *forces)])


@dataclass(frozen=True, eq=False)
class EnclosedRest:
    """A place of rest, the only one in a box about it; by a member of what was rounded.

    Attributes:
        place: from the origin of the scene (length).
        spin: omega there (1/time).
        slope: A there, (2, 2).
        balance: the equations of a body nearby.
        zero: about where they hold at rest, by place, rotation rate and forces of wheels that are held, (n, 1).
    """

    place: tuple[arb, arb]
    spin: arb
    slope: arb_mat
    balance: Balance
    zero: arb_mat

    @property
    def _balls(self) -> list[arb]:
        entries = (*self.place, self.spin, *self.slope.entries())
        return [part for entry in entries for part in (entry.mid(), entry.rad())]

    def __eq__(self, other: object) -> bool:
        """Whether all balls are the same: balls themselves are equal where no member of them differs."""
        return isinstance(other, EnclosedRest) and self._balls == other._balls

    def __hash__(self) -> int:
        return hash(float(self.spin))

    @property
    def squared(self) -> Fraction:
        """An upper bound of the square of its distance from the origin."""
        x, y = self.place
        return rational_above(x * x + y * y)

    @property
    def distance(self) -> Fraction:
        """An upper bound of its distance from the origin, of a few digits."""
        x, y = (abs(entry).upper() for entry in self.place)
        with ctx.workprec(PRECISION):
            return Fraction(upper_text(rational_above((x * x + y * y).sqrt()), DIGITS))

    @property
    def rates(self) -> tuple[Fraction, Fraction]:
        """A lower and an upper bound of the spin."""
        unit = Fraction(1, 10**SPIN_DECIMALS)
        low, high = rational_below(self.spin), rational_above(self.spin)
        return low // unit * unit, -(-high // unit) * unit

    @property
    def stability(self) -> Translation:
        """By the trace and the determinant of A; stable where the twist is fixed, so that bodies turn about it."""
        if self.balance.fixes_twist:
            return Translation.STABLE
        return linear_stability([list(row) for row in self.slope.tolist()])

    @property
    def spectral_abscissa(self) -> arb:
        """The largest real part of the eigenvalues of A."""
        (a, b), (c, d) = self.slope.tolist()
        with ctx.workprec(PRECISION):
            square = (a - d) * (a - d) / 4 + b * c
            root = arb(0) if square < 0 else arb(0).union(abs(square).upper().sqrt())
            return (a + d) / 2 + (square.sqrt() if square > 0 else root)


def rest_at_point(scene: Scene) -> EnclosedRest | None:
    """The place of rest of a centred scene that is its point, to all printed digits; None where none is enclosed."""
    rest = enclosed_rest(scene)
    return rest if rest is not None and rest.distance <= ROUNDING * scene.accuracy else None


def enclosed_rest(scene: Scene) -> EnclosedRest | None:
    """The place of rest at or beside the point of a centred scene; None where none is enclosed."""
    with ctx.workprec(PRECISION):
        return next((rest for guess in _guesses(scene) if (rest := _enclosed(*guess)) is not None), None)


def _enclosed(balance: Balance, start: arb_mat) -> EnclosedRest | None:
    """The place of rest for some wheels that are held, from about where it is."""
    centre = newton(balance.at_rest, start, NEWTON_STEPS)
    return None if centre is None else isolated_rest(balance, centre)


def isolated_rest(balance: Balance, centre: arb_mat) -> EnclosedRest | None:
    """The only place of rest near an approximate one, by place, rotation rate and held forces; None if not shown."""
    box = isolated_zero(balance.at_rest, centre)
    if box is None:
        return None
    x, y, omega, *_ = box.entries()
    equations = balance.at(unknowns_at_rest(box), (x, y))
    slope = None if equations is None else slope_of_pose_rate(equations[1], equations[2], (x, y), omega)
    return None if slope is None else EnclosedRest((x, y), omega, slope, balance, box.mid())


def _guesses(scene: Scene) -> Iterator[tuple[Balance, arb_mat]]:
    """The equations for the wheels that floats take to be held, and about their solution at the point.

    None under rules with cells, for loads that are not known, and for a wheel with a row without friction.
    """
    if has_cells(scene) or scene.contact.loads_are_unknown:
        return
    loads, forces = load_box(scene, arb(0)), BalancedForces.of(scene)
    if loads is None or forces is None:
        return
    twist, pulls = forces.against(np.zeros((1, 2)), np.zeros((1, 3)))
    slips = [np.abs(slip[0]) / forces.fastest for slip in forces.slips(twist)]
    tried: list[dict[int, int]] = []
    for slowest in HELD:
        along, across = (slip < slowest for slip in slips)
        turns = forces.sets.cut < 1  # where its rim does not slip its rollers may turn
        held = {k: 2 if across[k] else 1 for k in np.flatnonzero(along & (across | turns)).tolist()}
        if sum(held.values()) > 3 == len(held):  # of rims that fix the twist alone
            held = dict.fromkeys(held, 1)
        if held not in tried and sum(held.values()) <= 3:
            tried.append(held)
            vx, vy, omega = twist[0, 0], twist[0, 1], twist[0, 2] / forces.length
            about = [-vy / omega, vx / omega] if sum(held.values()) == 3 and omega else [0.0, 0.0]  # of a fixed twist
            start = [*map(float, about), float(omega)]
            start += [float(pulls[kind][0, k]) for k, count in held.items() for kind in range(count)]
            yield Balance(scene, loads, held), arb_mat([[arb(entry)] for entry in start])


def enclosed_motion(balance: Balance, near: arb_mat, place: Sequence[arb]) -> tuple[arb_mat, arb_mat] | None:
    """Twist and held forces (n, 1) all over a box of places, and the hull of A there; None where they are not enclosed.

    Args:
        balance: the equations.
        near: about these unknowns in the middle of the box, where Newton's method begins.
        place: the box.
    """

    def equations(unknowns: arb_mat, there: Sequence[arb]) -> tuple[arb_mat, arb_mat] | None:
        enclosed = balance.at(unknowns, there)
        return None if enclosed is None else enclosed[:2]

    middle = [entry.mid() for entry in place]
    start = newton(lambda unknowns: equations(unknowns, middle), near, NEWTON_STEPS, last=CENTRED)
    unknowns = None if start is None else isolated_zero(lambda unknowns: equations(unknowns, place), start)
    enclosed = None if unknowns is None else balance.at(unknowns, place)
    if unknowns is None or enclosed is None:
        return None
    slope = slope_of_pose_rate(enclosed[1], enclosed[2], place, unknowns[2, 0])
    return None if slope is None else (unknowns, slope)


def turns_all_over(rest: EnclosedRest, reach: Fraction) -> bool:
    """Whether bodies turn about a place wherever their centre of mass is in a square: the twist that is fixed stays so.

    Args:
        rest: the place of rest; rows that do not slip fix its twist.
        reach: half the side of the square about the origin.
    """
    half, near = Fraction(reach, PARTS), rest.zero
    middles = [half * (2 * k + 1 - PARTS) for k in range(PARTS)]
    with ctx.workprec(PRECISION):
        unknowns = unknowns_at_rest(near).mid()
        sides = [rational_ball(middle) + rational_ball(half) * UNIT for middle in middles]
        return all(enclosed_motion(rest.balance, unknowns, place) is not None for place in product(sides, sides))
