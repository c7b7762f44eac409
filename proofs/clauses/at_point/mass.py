"""Up to which mass the verdict on (x, y) holds for a body with mass: the linearized full dynamics, in balls.

Let ``y = (w, omega)`` be the velocity of the centre of mass and the rotation rate beside that of the equilibrium, and
m the mass per unit of weight, 1/g, with the inertia ``m rho^2``.  With H and G of
:mod:`nonsmooth.proofs.clauses.at_point.linearization`, to first order ::

    c' = w,     diag(m, m, m rho^2) y' = -H y - K c,     K = G - omega_0 (H_1 H_2) J

since ``v = w - omega_0 J c``, and because force and moment vanish at the equilibrium their point of reference does not
matter.  Five eigenvalues decide, the zeros of the quintic ``det`` of the pencil.  As m goes to 0 three of them tend to
those of ``-H/m`` and two to those of A, so a body that is light enough behaves as the verdict says (Tikhonov's
theorem; Kokotović, Khalil and O'Reilly 1986).  As m grows, stability is lost where two zeros add to nought, that is, by
Orlando's formula, where the fourth Hurwitz determinant vanishes: a polynomial in m.  It is proved positive on an
interval by the signs of Bernstein coefficients, and negative at a mass beyond.

Speeds count as the square root of m: with all speeds s times as large, H is divided by s, and in times s times as long
the same equations have the mass ``s^2 m``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise, permutations
from typing import TypeAlias

import numpy as np
from flint import arb, arb_poly, ctx, fmpq

from nonsmooth.proofs.clauses.at_point.linearization import Linearization
from nonsmooth.symbolic.number_text import lower_text, upper_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene import Scene

PRECISION = 256  # bits of the balls
DIGITS = 4  # of the masses between which stability is lost
REAL = 2.0**-23  # relative imaginary part below which a proposed root counts as real; a wrong one proves nothing
FAR = 6  # powers of ten beyond the mass at which friction damps critically: as far as is looked
HALVINGS = 30  # of an interval until the coefficients of every part have one sign

Pencil: TypeAlias = list[arb_poly]  # coefficients of the powers of lambda, polynomials in m


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

    def check(self) -> bool:
        """Verify both masses from H, G and the radius."""
        with ctx.workprec(PRECISION):
            determinant = hurwitz_determinant(self.linearization, self.squared_radius)
            if determinant is None or self.stable_to <= 0 or not _is_positive_to(determinant, self.stable_to):
                return False
            if self.unstable_at is None:
                return True
            return self.unstable_at > self.stable_to and bool(determinant(_ball(self.unstable_at)) < 0)


def squared_radius_of_disc(scene: Scene) -> Number:
    """``rho^2`` of a uniform disc as large as the array.

    That is half the mean squared distance of the wheels from their middle, as the full dynamics takes it unless told
    otherwise (:func:`nonsmooth.analysis.dynamics.newton_euler.disc`).
    """
    count, zero = len(scene.wheels), scene.field.zero
    places = [wheel.position for wheel in scene.wheels]
    middle = [sum((place[axis] for place in places), zero) / count for axis in range(2)]
    offsets = [(x - middle[0], y - middle[1]) for x, y in places]
    return sum((x * x + y * y for x, y in offsets), zero) / (2 * count)


def decide_mass_limit(linearization: Linearization, squared_radius: Number) -> MassLimit | None:
    """The masses for which an equilibrium with a Hurwitz linearization is stable; None where it is not decided.

    Args:
        linearization: H positive definite, A Hurwitz.
        squared_radius: inertia over mass, positive.
    """
    if not (linearization.is_positive_definite and linearization.trace.sign() < 0 < linearization.determinant.sign()):
        return None
    with ctx.workprec(PRECISION):
        determinant = hurwitz_determinant(linearization, squared_radius)
    if determinant is None:
        return None
    end, root = _far(linearization), _least_positive_root(determinant)
    if root is None or root >= end:
        found = MassLimit(linearization, squared_radius, end, None)
    else:
        low, high = (Fraction(text(Fraction(root), DIGITS)) for text in (lower_text, upper_text))
        found = MassLimit(linearization, squared_radius, low, high)
    return found if found.check() else None


def hurwitz_determinant(linearization: Linearization, squared_radius: Number) -> arb_poly | None:
    """The fourth Hurwitz determinant as a polynomial in m, without its factor ``m^k``.

    To be called with the precision of its balls set.

    Returns:
        None where its sign near m = 0 is not known.
    """
    p = _characteristic(linearization, squared_radius.ball())
    zero = arb_poly([])
    rows = [[p[4], p[2], p[0], zero], [p[5], p[3], p[1], zero], [zero, p[4], p[2], p[0]], [zero, p[5], p[3], p[1]]]
    coefficients = _determinant(rows).coeffs()
    lowest = next((k for k, value in enumerate(coefficients) if not _is_zero(value)), None)
    if lowest is None or not coefficients[lowest] > 0:
        return None
    return arb_poly(coefficients[lowest:])


def _characteristic(linear: Linearization, squared_radius: arb) -> list[arb_poly]:
    """The coefficients of the quintic in lambda, each a polynomial in m.

    Rows: balance of forces and of moments; columns: c, which moves at ``w = lambda c``, and omega.
    """
    hessian = [[entry.ball() for entry in row] for row in linear.hessian]
    rate = linear.omega.ball()
    masses = (arb(1), arb(1), squared_radius)
    entries: list[list[Pencil]] = []
    for r, row in enumerate(hessian):
        x, y = (column[r].ball() for column in linear.slope)
        stiffness = (x - rate * row[1], y + rate * row[0])  # K = G - omega_0 (H_1 H_2) J
        inertia = [arb_poly([0, masses[r] if r == column else 0]) for column in range(3)]
        places = [[arb_poly([stiffness[k]]), arb_poly([row[k]]), inertia[k]] for k in range(2)]
        entries.append([*places, [arb_poly([row[2]]), inertia[2]]])
    found = [arb_poly([]) for _ in range(6)]
    for order in permutations(range(3)):
        term = [arb_poly([_parity(order)])]
        for r, column in enumerate(order):
            term = _times(term, entries[r][column])
        for k, value in enumerate(term):
            found[k] = found[k] + value
    return found


def _times(first: Pencil, second: Pencil) -> Pencil:
    """The product of two polynomials in lambda."""
    found = [arb_poly([]) for _ in range(len(first) + len(second) - 1)]
    for i, a in enumerate(first):
        for j, b in enumerate(second):
            found[i + j] = found[i + j] + a * b
    return found


def _determinant(rows: Sequence[Sequence[arb_poly]]) -> arb_poly:
    """By its definition."""
    total = arb_poly([])
    for order in permutations(range(len(rows))):
        term = arb_poly([_parity(order)])
        for r, column in enumerate(order):
            term = term * rows[r][column]
        total = total + term
    return total


def _parity(order: Sequence[int]) -> int:
    inversions = sum(order[i] > order[j] for j in range(len(order)) for i in range(j))
    return -1 if inversions % 2 else 1


def _is_zero(value: arb) -> bool:
    """Whether it is nought exactly, as a coefficient is that no term contributes to."""
    return bool(value.is_zero())


def _least_positive_root(determinant: arb_poly) -> float | None:
    """In floats: a proposal."""
    middles = [float(value.mid()) for value in determinant.coeffs()]
    size = max(map(abs, middles))
    if not (math.isfinite(size) and size):
        return None
    roots = np.roots([value / size for value in reversed(middles)])
    real = [root.real for root in roots if root.real > 0 and abs(root.imag) <= abs(root) * REAL]
    return min(real, default=None)


def _far(linear: Linearization) -> Fraction:
    """A power of ten far above ``H_xx^2/|K|``, the order of the mass at which friction damps critically."""
    damping, pull = float(linear.hessian[0][0]), max(abs(float(entry)) for column in linear.slope for entry in column)
    return Fraction(10) ** (round(math.log10(damping) * 2 - math.log10(pull)) + FAR)


def _is_positive_to(polynomial: arb_poly, end: Fraction) -> bool:
    """Whether it is positive on ``[0, end]``."""
    stretched = polynomial(arb_poly([0, _ball(end)]))
    return _is_positive_on_unit(stretched.coeffs(), HALVINGS)


def _is_positive_on_unit(coefficients: Sequence[arb], halvings: int) -> bool:
    """By the Bernstein coefficients of ever smaller parts of ``[0, 1]``."""
    degree = len(coefficients) - 1
    bernstein = [
        sum((coefficients[i] * fmpq(math.comb(k, i), math.comb(degree, i)) for i in range(k + 1)), arb(0))
        for k in range(degree + 1)
    ]
    return _all_positive(bernstein, halvings)


def _all_positive(bernstein: list[arb], halvings: int) -> bool:
    """Bernstein coefficients of both halves, by de Casteljau, until all are positive or an end is not."""
    if all(value > 0 for value in bernstein):
        return True
    if not halvings or not (bernstein[0] > 0 and bernstein[-1] > 0):
        return False
    left, right, row = [bernstein[0]], [bernstein[-1]], bernstein
    while len(row) > 1:
        row = [(a + b) / 2 for a, b in pairwise(row)]
        left.append(row[0])
        right.append(row[-1])
    return _all_positive(left, halvings - 1) and _all_positive(right[::-1], halvings - 1)


def _ball(value: Fraction) -> arb:
    return arb(fmpq(value.numerator, value.denominator))
