"""Up to which mass the verdict on (x, y) holds for a body with mass: the linearized full dynamics, in balls.

Let ``y = (w, omega)`` be the velocity of the centre of mass and the rotation rate beside that of the equilibrium, and
m the mass per unit of weight, 1/g, with the inertia ``m rho^2``.  With H and G of
:mod:`nonsmooth.proofs.boxes.linearization`, to first order ::

    c' = w,     diag(m, m, m rho^2) y' = -H y - K c,     K = G - omega_0 (H_1 H_2) J

since ``v = w - omega_0 J c``, and because force and moment vanish at the equilibrium their point of reference does not
matter.  Five eigenvalues decide, the zeros of the quintic ``det`` of the pencil.  As m goes to 0 three of them tend to
those of ``-H/m`` and two to those of A, so a body that is light enough behaves as the verdict says (Tikhonov's
theorem; Kokotović, Khalil and O'Reilly 1986).  As m grows, stability is lost where two zeros add to nought, that is, by
Orlando's formula, where the fourth Hurwitz determinant of the quintic ``sum p_k lambda^k`` vanishes ::

    (p_4 p_3 - p_5 p_2)(p_2 p_1 - p_3 p_0) - (p_4 p_1 - p_5 p_0)^2

a polynomial in m.  It is proved positive on an interval in balls of its parts, and negative at a mass beyond.

Where the centre of mass is at a height h above the wheels, loads are those at the centre of pressure
``q = c - h sum_i f_i`` (:mod:`nonsmooth.analysis.bodies.newton_euler`).  In G the place counts through the loads
alone, so to first order forces and moment f are ``-H y - K c + h G (f_x, f_y)``, and the masses of the pencil are ::

    (1 - h (G 0)) diag(m, m, m rho^2)

in place of the diagonal matrix.  That has to be regular with a positive determinant, as at h = 0.

Speeds count as the square root of m: with all speeds s times as large, H is divided by s, and in times s times as long
the same equations have the mass ``s^2 m``.

At a place of rest beside the origin, where only balls tell it, the twist is ``xi = T (w, omega)``, and with ``T^T`` for
moments about the place itself the same pencil has ``T^T H T`` for H and ``T^T K`` for K.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from flint import arb, arb_mat, arb_poly, ctx

from nonsmooth.proofs.boxes.enclosures import holds_on, is_positive_definite, linear_stability
from nonsmooth.proofs.boxes.linearization import Linearization
from nonsmooth.proofs.findings import Translation
from nonsmooth.symbolic.numbers.coefficients import rational_ball
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import lower_text, upper_text

STABLE = Translation.ASYMPTOTICALLY_STABLE
PRECISION = 256  # bits of the balls
DIGITS = 4  # of the masses between which stability is lost
REAL = 2.0**-23  # relative imaginary part below which a proposed root counts as real; a wrong one proves nothing
FAR = 6  # powers of ten beyond the mass at which friction damps critically: as far as is looked
HALVINGS = 80  # of the interval of masses, where the determinant is not shown to be positive
POWERS = 4  # of the mass in each coefficient of the quintic


@dataclass(frozen=True)
class MassLimit:
    """For which masses the equilibrium is exponentially stable under full dynamics.

    Attributes:
        linearization: of the quasi-static motion, Hurwitz.
        squared_radius: ``rho^2``, inertia over mass (length^2).
        stable_to: the body is stable for every mass per weight in ``(0, stable_to]``.
        unstable_at: a mass per weight a little above, at which it is unstable; None where ``stable_to`` is only as far
            as was looked.
    """

    linearization: Linearization
    squared_radius: Number
    stable_to: Fraction
    unstable_at: Fraction | None


@dataclass(frozen=True, eq=False)
class Pencil:
    """The linearized full dynamics, in balls: ``m M (w, omega)' = -C (w, omega) - K c``, ``c' = w``.

    Attributes:
        damping: C (3 x 3), positive definite where the motion is determined.
        stiffness: K (3 x 2).
        masses: M (3 x 3), per mass; ``diag(1, 1, rho^2)`` where the centre of mass is at the height of the wheels.
    """

    damping: arb_mat
    stiffness: arb_mat
    masses: arb_mat

    @classmethod
    def of(cls, linear: Linearization, squared_radius: Number) -> Pencil:
        """At the origin of a scene: ``C = H`` and ``K = G - omega_0 (H_1 H_2) J``."""
        damping = arb_mat([[entry.ball() for entry in row] for row in linear.hessian])
        slope = arb_mat([[column[row].ball() for column in linear.slope] for row in range(3)])
        return cls.about(damping, slope, (arb(0), arb(0)), linear.omega.ball(), squared_radius.ball())

    @classmethod
    def about(
        cls,
        bend: arb_mat,
        slope: arb_mat,
        place: tuple[arb, arb],
        spin: arb,
        squared_radius: arb,
        height: arb | None = None,
    ) -> Pencil:
        """At a place of rest, from H and G with their rows about the origin; h is 0 unless it is given."""
        x, y = place
        twists = arb_mat([[1, 0, y], [0, 1, -x], [0, 0, 1]])  # T: xi of (w, omega)
        turning = arb_mat([[0, spin], [-spin, 0], [0, 0]])  # of xi by the place, where w = 0
        moments = twists.transpose()
        masses = arb_mat([[1, 0, 0], [0, 1, 0], [0, 0, squared_radius]])
        if height is not None:
            by_place = moments * slope
            for row in range(3):
                for column in range(2):
                    masses[row, column] -= height * by_place[row, column]
        return cls(moments * bend * twists, moments * (slope + bend * turning), masses)

    def characteristic(self, mass: arb) -> list[arb]:
        """The coefficients of the quintic at one mass, constant term first."""
        return [arb_poly(powers)(mass) for powers in self.quintic]

    @cached_property
    def quintic(self) -> list[list[arb]]:
        """The coefficients, constant term first, each a polynomial in m by its own coefficients.

        With ``lambda = m^4`` the determinant is one polynomial in m.  Rows: balance of forces and of moments; columns:
        c, which moves at ``w = lambda c``, and omega.
        """
        rows, gap = [], [arb(0)] * (POWERS - 1)
        for r in range(3):
            damping, mass = ([matrix[r, k] for k in range(3)] for matrix in (self.damping, self.masses))
            entries = [arb_poly([self.stiffness[r, k], *gap, damping[k], *gap, arb(0), mass[k]]) for k in range(2)]
            rows.append((*entries, arb_poly([damping[2], *gap, arb(0), mass[2]])))
        powers = _determinant(rows).coeffs()
        return [powers[POWERS * k : POWERS * (k + 1)] for k in range(6)]

    def stability(self, mass: arb) -> Translation:
        """Whether all five eigenvalues have negative real parts (Hurwitz), or one has a positive one.

        Where no zero of a polynomial with a positive leading coefficient has a positive real part, none of its
        coefficients and none of its Hurwitz determinants is negative.
        """
        quintic = self.characteristic(mass)
        entries = [[quintic[5 - k] if 0 <= (k := 2 * j - i + 1) <= 5 else arb(0) for j in range(5)] for i in range(5)]
        minors = [arb_mat([row[:size] for row in entries[:size]]).det() for size in range(1, 6)]
        signs = [*quintic, *minors]
        if not quintic[5] > 0:
            return Translation.UNDECIDED
        if all(value > 0 for value in signs):
            return Translation.ASYMPTOTICALLY_STABLE
        return Translation.UNSTABLE if any(value < 0 for value in signs) else Translation.UNDECIDED


def _determinant(rows: Sequence[Sequence[arb_poly]]) -> arb_poly:
    (a, b, c), (d, e, f), (p, q, s) = rows
    return a * (e * s - f * q) - b * (d * s - f * p) + c * (d * q - e * p)


def decide_mass_limit(linearization: Linearization, squared_radius: Number) -> MassLimit | None:
    """The masses for which an equilibrium with a Hurwitz linearization is stable; None where it is not decided.

    Args:
        linearization: H positive definite, A Hurwitz.
        squared_radius: inertia over mass, positive.
    """
    is_hurwitz = linear_stability(linearization.translation) is Translation.ASYMPTOTICALLY_STABLE
    if not (is_hurwitz and is_positive_definite(linearization.hessian)):
        return None
    with ctx.workprec(PRECISION):
        limits = mass_limits(Pencil.of(linearization, squared_radius))
    return None if limits is None else MassLimit(linearization, squared_radius, *limits)


def mass_limits(pencil: Pencil) -> tuple[Fraction, Fraction | None] | None:
    """``stable_to`` and ``unstable_at`` of :class:`MassLimit`, for C positive definite and A Hurwitz; None where open.

    Between masses at which the determinant is positive no eigenvalue crosses the imaginary axis: none but zero could,
    and their product, ``det A`` by a positive factor, is not zero.  So one mass that is shown to be stable decides.
    To be called with the precision of its balls set.
    """
    determinant = hurwitz_determinant(pencil)
    end, root = _far(pencil), _least_positive_root(determinant)
    if root is None or root >= end:
        low, high = end, None
    else:
        low, high = (Fraction(text(Fraction(root), DIGITS)) for text in (lower_text, upper_text))
    is_shown = _is_confirmed(low, high, determinant) and pencil.stability(rational_ball(low)) is STABLE
    return (low, high) if is_shown else None


def _is_confirmed(stable_to: Fraction, unstable_at: Fraction | None, determinant: arb_poly) -> bool:
    """Whether the determinant is positive up to the lower mass, and negative at the upper one, in balls."""
    if stable_to <= 0 or not _is_positive_to(determinant, stable_to):
        return False
    return unstable_at is None or (unstable_at > stable_to and bool(determinant(rational_ball(unstable_at)) < 0))


def hurwitz_determinant(pencil: Pencil) -> arb_poly:
    """The fourth Hurwitz determinant as a polynomial in m, without its factor ``m^3``.

    To be called with the precision of its balls set.
    """
    mass = arb_poly([0, 1])
    # a power of lambda above the second comes with a power of m, which is left out
    p = [arb_poly(powers[max(0, k - 2) :]) for k, powers in enumerate(pencil.quintic)]
    first, second = p[4] * p[3] - p[5] * p[2], p[2] * p[1] - mass * p[3] * p[0]
    third = p[4] * p[1] - mass * p[5] * p[0]
    return first * second - mass * third * third


def _least_positive_root(determinant: arb_poly) -> float | None:
    """In floats: a proposal."""
    middles = [float(value.mid()) for value in determinant.coeffs()]
    size = max(map(abs, middles))
    if not (math.isfinite(size) and size):
        return None
    roots = np.roots([value / size for value in reversed(middles)])
    real = [root.real for root in roots if root.real > 0 and abs(root.imag) <= abs(root) * REAL]
    return min(real, default=None)


def _far(pencil: Pencil) -> Fraction:
    """A power of ten far above ``C_xx^2/|K|``, the order of the mass at which friction damps critically.

    K without moments, whose size depends on the unit of length.
    """
    pull = max(abs(float(pencil.stiffness[row, column].mid())) for row in range(2) for column in range(2))
    damping = float(pencil.damping[0, 0].mid())
    return Fraction(10) ** (round(math.log10(damping) * 2 - math.log10(pull)) + FAR)


def _is_positive_to(polynomial: arb_poly, end: Fraction) -> bool:
    """Whether it is positive on ``[0, end]``."""
    last = rational_ball(end)
    return bool(polynomial(last) > 0) and holds_on(lambda mass: bool(polynomial(mass) > 0), arb(0), last, HALVINGS)
