"""A V of the states, by forms in their signed roots, of homogeneous fields that no V in the time of the roots serves.

Let a field be homogeneous, with weights of the states that are whole multiples q of one number.  In the roots
``w = sign(x) Abs(x)**(1/q)`` every weight is one: on each of the orthants that the signs of all roots bound, velocities
of states are forms.  The derivative of a V, in the time of the states, is
``V' = sum_k (dV/dw_k) f_k/(q_k Abs(w_k)**(q_k - 1))``, again a form if V is one in which a root of order q stands with
the power q at least, or not at all.  So V is a sum of products of powers ``w^e`` and ``w^(e - 1) Abs(w)``, which is
continuous and has derivatives by the states on each orthant; a linear program proposes it by samples, and the theorem
``lyapunov``, told that time is that of the states, shows it.

That serves where solutions touch the zero of a root without crossing it, so that time in the roots ends there:
differentiators of second order have such a V of degree five, as those of order n - 1 have of degree 2 n - 1 (Levant
2003; Cruz-Zavala and Moreno 2019).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import islice, product
from math import prod
from typing import NamedTuple

import numpy as np

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.positivity import Claim, pairs
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import with_margin
from nonsmooth.proofs.kernel.cells import BeyondReachError, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.homogeneity import homogeneity_of
from nonsmooth.proofs.kernel.quotients import values_inside
from nonsmooth.proofs.kernel.search import (
    Entry,
    Functions,
    NotShownError,
    Search,
    instability_hypotheses,
    sample_points,
    stability_hypotheses,
)
from nonsmooth.symbolic.files.system_builder import with_roots
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.formulas.signed_roots import MAX_ORDER
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norms
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

STATES = range(2, 4)  # cubes of more are cut into too many simplices
FEW_SEEDS, SEEDS = range(3), range(16)  # of samples: at first, and of all at which a V must fall
ROUNDS, MOST_ADDED = 6, 400  # of programs, each with more samples at which the last V rises
BEYOND = 2  # degrees of V that are tried beyond twice the largest order
DENOMINATORS = (16, 64, 256, 1024)  # of the coefficients over the largest, tried in turn
MOST_TRIED = 3  # functions that no sample refutes: what is shown is shown of the first ones


class Product(NamedTuple):
    """Powers of roots, of which some are turned where the root is negative: ``w^e``, or ``w^(e - 1) Abs(w)``.

    Attributes:
        powers: e of each root.
        turned: whether it is turned by the sign of this root.
    """

    powers: tuple[int, ...]
    turned: tuple[bool, ...]

    def text(self, roots: Sequence[str]) -> str:
        """As a formula."""
        parts = []
        for root, exponent, turned in zip(roots, self.powers, self.turned, strict=True):
            parts += [f"Abs({root})"] if turned else []
            left = exponent - turned
            parts += [root if left == 1 else f"{root}**{left}"] if left else []
        return "*".join(parts)

    def at(self, place: Sequence[int]) -> int:
        """Its value."""
        signs = [(-1) ** (turned and x < 0) for x, turned in zip(place, self.turned, strict=True)]
        return prod(map(pow, place, self.powers)) * prod(signs)


Function = list[tuple[Fraction, Product]]


def in_roots_of_weights(system: SwitchedSystem) -> SwitchedSystem | None:
    """A homogeneous system in roots of which all have one weight; None of others, and where it is in these already.

    Args:
        system: checked at the origin.
    """
    known = homogeneity_of(system) if len(system.states) in STATES else None
    if known is None or any(system.check.equilibrium) or not system.check.is_default:
        return None
    unit = min(known.weights)
    orders = [weight / unit for weight in known.weights]
    shared = np.lcm.reduce([order.denominator for order in orders])
    whole = tuple(int(order * shared) for order in orders)
    if whole == known.orders or max(whole) > MAX_ORDER or any(a % b for a, b in zip(whole, known.orders, strict=True)):
        return None
    try:
        return with_roots(system, whole)
    except SceneError:
        return None


def find_function_of_states(system: SwitchedSystem) -> Entry | None:
    """The entry of a certificate that shows that the point attracts, or is unstable; None where neither is found.

    A V that falls is positive if the point attracts, so nothing but its fall is asked of samples.

    Args:
        system: with rational numbers, homogeneous, and all weights one in its roots.
    """
    known = homogeneity_of(system) if system.by_roots is not None and len(system.states) in STATES else None
    if known is None or len({weight / order for weight, order in zip(known.weights, known.orders, strict=True)}) > 1:
        return None
    try:
        subject, _ = started(system)
        axes = surfaces_of(system, parse_piecewise(" + ".join(f"Abs({w})" for w in system.states), system.states))
        cells = stated_cells(system, system.check.radius, axes).record
        for function in islice(_proposals(subject, cells, known.orders), MOST_TRIED):
            with suppress(NotShownError):
                return _shown(subject, cells, function)
    except (BeyondReachError, NotShownError, RejectedError, SceneError):
        pass
    return None


def _shown(subject: System, cells: Record, function: Function) -> Entry:
    """What a V that falls shows: instability where it is negative in some direction, else attraction.

    Raises:
        NotShownError: where the claims are not shown.
    """
    directions = product((1, -1, 3, -3), repeat=subject.count)
    lowest = min(directions, key=lambda place: sum(c * own.at(place) for c, own in function))
    text = " + ".join(f"({coefficient})*{own.text(subject.coordinates)}" for coefficient, own in function)
    if sum(c * own.at(lowest) for c, own in function) < 0:
        stated = instability_hypotheses(cells, text, lowest)
        return Search().entry(subject, "instability", {**stated, "time": "states"})
    stated = stability_hypotheses(cells, text, ASYMPTOTICALLY_STABLE)
    return Search().entry(subject, "lyapunov", {**stated, "everywhere": True, "time": "states"})


def _proposals(subject: System, cells: Record, orders: Sequence[int]) -> Iterator[Function]:
    """Sums that fall at all samples, of the lowest degrees first, in the shortest numbers.

    Where none falls along mixtures of two fields, too, these are left out: of an unstable point V may rise along some
    where it is positive.
    """
    for degree in range(max(orders) + 1, 2 * max(orders) + BEYOND + 1):
        listed = list(_products(orders, degree))
        known = Functions(subject.stated, {**cells, "empty": []}, [own.text(subject.coordinates) for own in listed])
        claims = [known.claims(k, positive=False) for k in range(len(listed))]
        for kept in (_of_two_fields, _of_cells):
            asked = [list(kept(own)) for own in claims]
            chosen = _falling(_rows(asked, FEW_SEEDS), every := _rows(asked, SEEDS))
            if chosen is not None:
                yield from _rounded(chosen, every, listed)
                break


def _falling(rows: Floats, every: Floats) -> Floats | None:
    """Coefficients with which all rows are positive, by some of them and those that the last ones make negative.

    Where a row is zero none falls: something rests there, or every function is kept.
    """
    if not every.any(axis=1).all():
        return None
    for _ in range(ROUNDS):
        chosen = with_margin(rows, np.ones(rows.shape[1]))
        if chosen is None:
            return None
        rising = every @ chosen <= 0
        if not rising.any():
            return chosen
        rows = np.vstack([rows, every[rising][:MOST_ADDED]])
    return None


def _of_cells(claims: Iterable[Claim]) -> Iterator[Claim]:
    """Those about closed cells."""
    return (claim for claim in claims if not claim.inequalities[0].pushes)


def _of_two_fields(claims: Iterable[Claim]) -> Iterator[Claim]:
    """The same, and those about mixtures of two fields along which one surface is kept."""
    for claim in claims:
        count = len(claim.inequalities[0].pushes)
        if count < 2:
            yield from pairs(claim) if count else [claim]


def _rows(claims: Sequence[Sequence[Claim]], seeds: Iterable[int]) -> Floats:
    """The values at samples that must be positive, over the largest of each row, a column for each function."""
    points = {own.count: _samples(own.count, seeds) for own in claims[0]}
    rows = np.vstack([values_inside(same, 0, points[same[0].count]) for same in zip(*claims, strict=True)])
    sizes = np.abs(rows).max(axis=1, keepdims=True)
    return np.asarray(rows / np.where(sizes > 0, sizes, 1))


def _samples(count: int, seeds: Iterable[int]) -> Floats:
    """Random points of the border of the cube: the claims are about forms."""
    points = np.vstack([sample_points(count, bounded=True, seed=seed) for seed in seeds])
    return np.asarray(points / max_norms(points)[:, None])


def _rounded(chosen: Floats, rows: Floats, listed: Sequence[Product]) -> Iterator[Function]:
    """Coefficients in the shortest numbers with which all rows stay positive."""
    for denominator in DENOMINATORS:
        own = [Fraction(float(c)).limit_denominator(denominator) for c in chosen / np.abs(chosen).max()]
        if (rows @ np.array(own, dtype=float) > 0).all():
            yield [(coefficient, one) for coefficient, one in zip(own, listed, strict=True) if coefficient]
            return


def _products(orders: Sequence[int], degree: int) -> Iterator[Product]:
    """Those of one degree that are even in all roots together, and have derivatives by the states."""
    for powers in product(range(degree + 1), repeat=len(orders)):
        if sum(powers) == degree and all(e >= q for e, q in zip(powers, orders, strict=True) if e):
            for turned in product(*[(False, True) if e else (False,) for e in powers]):
                if (degree + sum(turned)) % 2 == 0:
                    yield Product(powers, turned)
