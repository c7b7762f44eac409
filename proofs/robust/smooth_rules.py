"""Rules with friction sets over a box of parameters: one equilibrium nearby for every array, which attracts.

With g the gradient of D in the twist (force and moment), an equilibrium is a zero of ``F(c, omega) = g(xi; c)`` at the
twist of a body that turns about its own centre, ``xi = (omega c_y, -omega c_x, omega)``.  Krawczyk's operator ::

    K(Z) = z_0 - Y F(z_0; Q) + (1 - Y F'(Z; Q))(Z - z_0)

maps the box Z into its interior only where, for every array of the box Q, Z holds exactly one zero.  About it, to first
order, ``c' = A c`` with ``A = V + omega J + (J c) w^T``, ``(V; w) = -(dg/dxi)^-1 dg/dc``.  Where dg/dxi is positive
definite, the trace of A negative and its determinant positive, all over Z and Q, each of these equilibria attracts
exponentially.

Per unit of weight, about the origin, with ``alpha, beta`` the half-axes of a wheel's friction set, r and s its slips
along the friction axis a and across it and ``f = |(alpha r, beta s)|``, its force is ``N_i (alpha^2 r a + beta^2 s J
a)/f``.  Over the box of its own parameters it is enclosed by the mean value theorem.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache

import numpy as np
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.cells.contact_rule import smooth_rule_of
from nonsmooth.analysis.minimizers.ellipse_minimizer import minima_under
from nonsmooth.proofs.boxes.enclosures import (
    UNIT,
    Jet,
    approximate_inverse,
    is_positive_definite,
    krawczyk,
    lies_inside,
    linear_stability,
    newton,
    parameters,
    pose_rate_slope,
    turned_by,
    unit_vector,
)
from nonsmooth.proofs.boxes.load_box import LoadBox, load_box
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.robust.array_forces import rollers
from nonsmooth.proofs.robust.box import half_widths
from nonsmooth.symbolic.mechanics.scene import Scene, Tolerance, Wheel
from nonsmooth.symbolic.numbers.enclosures import rational_below

PRECISION = 64  # bits of the balls
INFLATIONS = 12  # of the box Z
GROWTH = 1.125  # of the image of the box, which is the next one
LEAST = 2.0**-50  # of its half-widths
NEWTON_STEPS = 20  # to the middle of the box

TWIST = 3  # entries; then x, y, angle, speed and the two frictions of a wheel, and its load


@dataclass(frozen=True)
class EquilibriumBox:
    """Where the equilibria of all arrays are.

    Attributes:
        squared: bound of ``|c|^2``.
        drift: bound of ``|omega|`` there (1/time).
    """

    squared: Fraction
    drift: Fraction


def equilibrium_box(scene: Scene, box: Tolerance) -> EquilibriumBox | None:
    """The equilibria of all arrays of a box about a centred scene, where they are proved to attract; else None."""
    with ctx.workprec(PRECISION):
        loads, nominal = load_box(scene, box.position.ball()), load_box(scene, arb(0))
        centre = _centre(scene, box.times(Fraction(0)))
        if loads is None or nominal is None or centre is None:
            return None
        return _proved(_Arrays(scene, box, loads, nominal), centre)


@lru_cache(maxsize=8)  # many boxes about one scene are asked for
def _centre(scene: Scene, none: Tolerance) -> arb_mat | None:
    """About the equilibrium of the scene itself, without tolerances, from the spin at the point in floats."""
    loads = load_box(scene, arb(0))
    omega = float(minima_under(smooth_rule_of(scene), scene, np.zeros((1, 2))).twists[0, 2])
    if loads is None or not np.isfinite(omega):
        return None
    nominal = _Arrays(scene, none, loads, loads)
    return newton(nominal.nominal_map, arb_mat([[arb(0)], [arb(0)], [arb(omega)]]), NEWTON_STEPS)


@dataclass(frozen=True)
class _Balance:
    """g over a box of places and spins.

    Attributes:
        value: g (3, 1).
        spread: what the parameters add to it (3, 1).
        by_twist: its slopes (3, 3).
        by_place: its slopes through the loads (3, 2).
        slope: ``F'``, by c and omega (3, 3).
    """

    value: arb_mat
    spread: arb_mat
    by_twist: arb_mat
    by_place: arb_mat
    slope: arb_mat


class _Arrays:
    """All arrays of a box."""

    def __init__(self, scene: Scene, box: Tolerance, loads: LoadBox, nominal: LoadBox) -> None:
        wheels = zip(scene.wheels, rollers(scene), strict=True)
        self._wheels = [(wheel, rolls, half_widths(wheel, box)) for wheel, rolls in wheels]
        self._loads, self._nominal = loads, nominal

    def nominal_map(self, z: arb_mat) -> tuple[arb_mat, arb_mat] | None:
        """F of the scene itself, and its Jacobian."""
        found = self.balance(z, whole=False)
        return None if found is None else (found.value, found.slope)

    def balance(self, z: arb_mat, *, whole: bool) -> _Balance | None:
        """At places and spins ``z = (c_x, c_y, omega)`` of all arrays, or of the scene; None where a wheel may stick
        or lift off.
        """
        x, y, omega = z.entries()
        loads, middles = self._loads.at((x, y)), self._nominal.at((x, y))
        value, spread, by_twist, by_place = arb_mat(3, 1), arb_mat(3, 1), arb_mat(3, 3), arb_mat(3, 2)
        for (wheel, rolls, own), load, middle, form in zip(
            self._wheels, loads, middles, self._loads.forms, strict=True
        ):
            shifts = [size * UNIT if whole else arb(0) for size in own]
            at = [omega * y, -omega * x, omega, *shifts, load if whole else middle]
            wrench = _wrench(wheel, at, has_rollers=rolls)
            if wrench is None or not load > 0:
                return None
            sizes = [*own, abs(load - middle)]
            for r, entry in enumerate(wrench):
                value[r, 0] += entry.value
                spread[r, 0] += Jet(arb(0), entry.slopes[TWIST:]).over(sizes, arb(0))
                for k in range(TWIST):
                    by_twist[r, k] += entry.slopes[k]
                for k in range(2):
                    by_place[r, k] += entry.slopes[-1] * form[k + 1]
        through = arb_mat([[arb(0), omega, y], [-omega, arb(0), -x], [arb(0), arb(0), arb(1)]])  # of the twist by z
        places = arb_mat([[arb(1), arb(0), arb(0)], [arb(0), arb(1), arb(0)]])
        return _Balance(value, spread, by_twist, by_place, by_twist * through + by_place * places)


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


def _proved(arrays: _Arrays, centre: arb_mat) -> EquilibriumBox | None:
    """Krawczyk's test, and the linearization, on a box that is inflated until it maps into itself."""
    at_centre, of_all = arrays.balance(centre, whole=False), arrays.balance(centre, whole=True)
    inverse = None if at_centre is None else approximate_inverse(at_centre.slope)
    if at_centre is None or of_all is None or inverse is None:
        return None
    value = at_centre.value + of_all.spread
    box = _inflated(centre, inverse * value)
    for _ in range(INFLATIONS):
        found = arrays.balance(box, whole=True)
        if found is None:
            return None
        image = krawczyk(centre, value, inverse, found.slope, box)
        if lies_inside(image, box):
            return _attracting(found, box)
        box = _inflated(centre, image - centre)
    return None


def _inflated(centre: arb_mat, offset: arb_mat) -> arb_mat:
    """A box about a point that holds offsets in both directions, and a little more."""
    pairs = zip(centre.entries(), offset.entries(), strict=True)
    return arb_mat([[entry + (GROWTH * abs(move).upper() + LEAST) * UNIT] for entry, move in pairs])


def _attracting(balance: _Balance, box: arb_mat) -> EquilibriumBox | None:
    """Bounds of the box, where A is Hurwitz all over it."""
    x, y, omega = box.entries()
    inverse = approximate_inverse(balance.by_twist)
    if inverse is None or not is_positive_definite(balance.by_twist.tolist()):
        return None
    try:
        response = -(inverse * balance.by_twist).solve(inverse * balance.by_place)  # (V; w)
    except ZeroDivisionError:
        return None
    motion = pose_rate_slope(arb_mat([[x], [y]]), omega, response)
    if linear_stability(motion.tolist()) is not Translation.ASYMPTOTICALLY_STABLE:
        return None
    return EquilibriumBox(-rational_below(-(x * x + y * y)), -rational_below(-abs(omega)))
