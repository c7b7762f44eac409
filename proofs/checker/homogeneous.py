"""Homogeneous inclusions: a point that attracts attracts everywhere, and solutions may arrive in finite time.

The coordinates z, from the point, have positive weights ``w_k``, and each state the weight ``r_k``, which is w_k, or
``q w_k`` where z_k is its root of order q.  Let D multiply the displacement of each state by ``l^r_k``, for l > 0.  On
every cell each term of the velocity of the k-th state has the weight ``d + r_k``, and all terms of a surface have one
weight.  Then D maps cells to cells, so ``F(D x) = l^d D F(x)``, also for the limits and mixtures of velocities, and
with x(t) also ``D x(l^d t)`` is a solution.  (A root that is not zero at the point, beside which its state is no power
of it, is a surface whose terms have two weights, if a formula holds it; if none does the point does not attract.)

*Theorem.*  If the point attracts, every solution tends to it; and if ``d < 0`` each is there after a finite time
(Bhat and Bernstein 2005; Levant 2005; Bernuau, Efimov, Perruquetti and Polyakov 2014).  *Proof.*  A small l brings any
start near the point, from where solutions tend to it.  Let N be the largest ``|x_k|^(1/r_k)``, which D multiplies by l.
Solutions that start with ``N <= b`` keep to ``N < 1/2``, for a ``b > 0``.  Those that start with ``N <= 1`` have
``N <= b`` before a common time T: otherwise some have not until arbitrarily late times, and as F is upper
semicontinuous with compact convex values, and they all are bounded, some solution never has, which does not tend to the
point.  So after T they have ``N < 1/2``, and from ``N <= 2^-k`` solutions come to ``N < 2^-(k+1)`` within
``T 2^(k d)``.  For ``d < 0`` the sum of these times is finite.  At the point solutions stay, as it is stable.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

from .cells import Inclusion, System
from .polynomials import Exponents
from .positivity import Proofs
from .theorems import ASYMPTOTICALLY_STABLE, Statement
from .work import BUDGET, items, rational, require


def show_homogeneous(system: System, cells: Any, weights: Any, proofs: Proofs, verdict: str) -> list[Statement]:
    """What follows from a verdict that is shown; see the head of this file."""
    fractions = [rational(weight) for weight in items(weights, system.count)]
    require(min(fractions) > 0, "positive weights")
    require(verdict == ASYMPTOTICALLY_STABLE, "a point that attracts")
    inclusion = Inclusion(system.stated, cells, ["0"], proofs)
    require(not inclusion.domain.bounded, "the whole space")
    degree = degree_of(inclusion, fractions)
    conclusions: list[Statement] = [{"stability": verdict}, {"attracts": "everywhere"}]
    return [*conclusions, {"arrives": "in finite time"}] if degree < 0 else conclusions


def degree_of(inclusion: Inclusion, weights: Sequence[Fraction]) -> Fraction:
    """The d with which an inclusion is homogeneous.

    Raises:
        RejectedError: where it is not.
    """
    for surface in inclusion.surfaces.listed:
        require(len({weight_of(e, weights) for e in surface.terms}) == 1, "surfaces whose terms have one weight")
    degrees = set()
    for cell in inclusion.cells:
        for _, field in cell.fields:
            for order, weight, part in zip(inclusion.domain.system.orders, weights, field, strict=True):
                degrees |= {weight_of(e, weights) - order * weight for e in part.terms}
    require(len(degrees) == 1, "velocities whose terms have the weights of one degree")
    return degrees.pop()


def weight_of(exponents: Exponents, weights: Sequence[Fraction]) -> Fraction:
    """Of a product of powers."""
    BUDGET.spend(len(weights))
    return sum((e * weight for e, weight in zip(exponents, weights, strict=True)), Fraction(0))
