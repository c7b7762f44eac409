"""A V of the states, by forms in their signed roots, of homogeneous fields that no V in the time of the roots serves.

Let a field be homogeneous, with weights of the states that are whole multiples q of one number.  In the roots
``w = sign(x) Abs(x)**(1/q)`` every weight is one: on each of the orthants that the signs of all roots bound, velocities
of states are forms.  The derivative of a V, in the time of the states, is
``V' = sum_k (dV/dw_k) f_k/(q_k Abs(w_k)**(q_k - 1))``, again a form if V is one in which a root of order q stands with
the power q at least, or not at all.  So V is a sum of products of powers ``w^e`` and ``w^(e - 1) Abs(w)``, which is
continuous and has derivatives by the states on each orthant; a linear program proposes it by samples, and the theorem
``lyapunov``, told of the roots, shows it.

That serves where solutions touch the zero of a root without crossing it, so that time in the roots ends there:
differentiators of second order have such a V of degree five, as those of order n - 1 have of degree 2 n - 1 (Levant
2003; Cruz-Zavala and Moreno 2019).
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import lru_cache
from itertools import islice, product
from math import lcm, log2, prod
from operator import mod
from typing import NamedTuple

import numpy as np

from nonsmooth.proofs.checker.cells import Inclusion, System
from nonsmooth.proofs.checker.positivity import Claim, pairs
from nonsmooth.proofs.checker.roots import RootedSystem, in_roots
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import with_margin
from nonsmooth.proofs.kernel.cells import BeyondReachError, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.homogeneity import Homogeneity, homogeneity_of
from nonsmooth.proofs.kernel.quotients import values_inside
from nonsmooth.proofs.kernel.search import (
    DeferredClaims,
    Entry,
    Functions,
    NotShownError,
    Search,
    instability_hypotheses,
    sample_points,
    stability_hypotheses,
)
from nonsmooth.proofs.kernel.written import roundings
from nonsmooth.symbolic.files.system_builder import with_roots
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.formulas.signed_roots import MAX_ORDER
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norms
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

STATES = range(1, 4)  # cubes of more are cut into too many simplices
FEW_SEEDS, SEEDS = tuple(range(3)), tuple(range(16))  # of samples: at first, and of all at which a V must fall
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
            rest = exponent - turned
            parts += [root if rest == 1 else f"{root}**{rest}"] if rest else []
        return "*".join(parts)

    def unit(self, units: Sequence[Fraction]) -> Fraction:
        """Its value where every root is its unit."""
        return prod((s**e for s, e in zip(units, self.powers, strict=True)), start=Fraction(1))

    def at_places(self, places: Floats) -> Floats:
        """Its values at places of shape (places, roots)."""
        signs = np.where(places < 0, -1.0, 1.0)
        return np.asarray(np.prod(places ** np.array(self.powers) * signs ** np.array(self.turned, dtype=int), axis=1))


Function = list[tuple[Fraction, Product]]
Kept = Callable[[Iterable[Claim]], Iterator[Claim]]


class InRoots(NamedTuple):
    """A homogeneous system as functions of roots see it, in which all states have one weight.

    Attributes:
        subject: of a certificate.
        roots: the orders of the roots that have one, as hypotheses name them.
        orders: q of each state.
        cells: as a certificate holds them: a box, with every zero of a root or a state among the surfaces.
        degree: by how much the weight of velocities is larger than that of their states; below zero solutions arrive.
        units: half the sides of the box, powers of two: in these units of the roots velocities are alike.
    """

    subject: System
    roots: dict[str, int]
    orders: tuple[int, ...]
    cells: Record
    degree: int
    units: tuple[Fraction, ...]

    @property
    def seen(self) -> RootedSystem:
        """The system in these roots, with the velocities of the states."""
        return in_roots(self.subject, self.roots)

    def hypotheses(self, stated: Record) -> Record:
        """Those of a theorem about such functions."""
        return {**stated, "roots": self.roots}


def seen_in_roots(system: SwitchedSystem, homogeneity: Homogeneity | None) -> InRoots | None:
    """A homogeneous system with roots of which the weights are all one; None where there are no such roots.

    Raises:
        BeyondReachError, NotShownError: for systems that no certificate can name, and too many cells.
    """
    if homogeneity is None or len(system.states) not in STATES or any(system.check.equilibrium):
        return None
    unit = min(homogeneity.weights)
    shared = lcm(*((value / unit).denominator for value in (*homogeneity.weights, homogeneity.degree)))
    *orders, degree = (int(value / unit * shared) for value in (*homogeneity.weights, homogeneity.degree))
    if max(orders) > MAX_ORDER or any(map(mod, orders, homogeneity.orders)):
        return None
    roots = {name: order for name, order in zip(system.stated_states, orders, strict=True) if order > 1}
    if not roots:
        return None
    subject, _ = started(system)
    rooted = with_roots(system, orders)
    axes = surfaces_of(rooted, parse_piecewise(" + ".join(f"Abs({w})" for w in rooted.states), rooted.states))
    cells = stated_cells(rooted, rooted.check.radius, axes).record
    inclusion = Inclusion(in_roots(subject, roots), {**cells, "empty": []}, ["0"], DeferredClaims())
    units = balanced_units(inclusion, orders)
    return InRoots(subject, roots, tuple(orders), {**cells, "within": list(map(str, units))}, degree, units)


def balanced_units(inclusion: Inclusion, orders: Sequence[int]) -> tuple[Fraction, ...]:
    """Units of roots in which the coefficients of all velocities are alike, by least squares of their logarithms.

    With ``w_k = s_k v_k`` a term ``c w^e`` of the velocity of a state has the size ``c s^e/s_k^q_k`` in units of these.
    """
    rows, sizes = list[list[int]](), list[float]()
    for field in {field for cell in inclusion.cells for _, field in cell.fields}:
        for k, part in enumerate(field):
            for exponents, coefficient in part.terms.items():
                rows.append([*(e - orders[k] * (j == k) for j, e in enumerate(exponents)), -1])  # and the unit of time
                sizes.append(-log2(abs(coefficient)))
    logarithms = np.linalg.lstsq(np.array(rows, dtype=float), np.array(sizes))[0]
    return tuple(Fraction(2) ** round(float(logarithm)) for logarithm in logarithms[:-1])


def find_function_of_states(system: SwitchedSystem) -> Entry | None:
    """The entry of a certificate that shows that the point attracts, or is unstable; None where neither is found.

    A V that falls is positive if the point attracts, and negative somewhere if not: one search serves both.

    Args:
        system: with rational numbers.
    """
    with suppress(BeyondReachError, NotShownError, RejectedError, SceneError):
        about = seen_in_roots(system, homogeneity_of(system))
        if about is None:
            return None
        for function in islice(_proposals(about), MOST_TRIED):
            with suppress(NotShownError):
                return _shown(about, function)
    return None


def _shown(about: InRoots, function: Function) -> Entry:
    """What a V that falls shows: instability where it is negative in some direction, else attraction.

    Raises:
        NotShownError: where the claims are not shown.
    """
    directions, text = np.array(list(product((1, -1, 3, -3), repeat=len(about.units)))), text_of(about, function)
    places = directions * np.array(about.units, dtype=float)
    values = sum(float(coefficient) * term.at_places(places) for coefficient, term in function)
    if np.min(values) < 0:
        stated = instability_hypotheses(about.cells, text, directions[np.argmin(values)].tolist())
        return Search().entry(about.subject, "instability", about.hypotheses(stated))
    stated = stability_hypotheses(about.cells, text, ASYMPTOTICALLY_STABLE) | {"everywhere": True}
    return Search().entry(about.subject, "lyapunov", about.hypotheses(stated))


def text_of(about: InRoots, function: Function) -> str:
    """A sum of products as a formula."""
    parts = []
    for coefficient, term in function:
        size = "" if abs(coefficient) == 1 else f"{abs(coefficient)}*"
        parts.append(f"{'-' if coefficient < 0 else '+'} {size}{term.text(about.seen.coordinates)}")
    text = " ".join(parts)
    return f"-{text[2:]}" if text.startswith("-") else text[2:]


def _proposals(about: InRoots) -> Iterator[Function]:
    """Sums that fall at all samples, of the lowest degrees first, in the shortest numbers.

    One that is positive at all samples is chosen again with a margin of this, too.  Where none falls along mixtures of
    two fields, too, these are left out: of an unstable point V may rise along some where it is positive.
    """
    highest = 2 * max(about.orders) + BEYOND
    for degree in range(max(about.orders) + 1, highest + 1):
        listed = list(products(about.orders, degree))
        functions, units = functions_of(about, listed), units_of(about, listed)
        claims = [functions.claims(k) for k in range(len(listed))]
        few, every = _rows(claims, _that_are_positive, units)
        for select in (of_two_fields, _of_cells):
            some, falls = _rows(claims, select, units)
            chosen = _positive(some, falls)
            if chosen is None:
                continue
            if (every @ chosen > 0).all():
                better = _positive(np.vstack([some, few]), np.vstack([falls, every]))
                chosen = chosen if better is None else better
            rounded = _rounded(chosen, falls)
            if rounded is not None:
                yield in_units(rounded, listed, about)
            break


def functions_of(about: InRoots, listed: Sequence[Product]) -> Functions:
    """Products as functions of which claims are asked."""
    texts = [term.text(about.seen.coordinates) for term in listed]
    return Functions(about.seen, {**about.cells, "empty": []}, texts)


def units_of(about: InRoots, listed: Sequence[Product]) -> Floats:
    """The values of products at the corner of the box where all roots are positive."""
    return np.array([float(term.unit(about.units)) for term in listed])


def _positive(rows: Floats, every: Floats) -> Floats | None:
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


def _that_are_positive(claims: Iterable[Claim]) -> Iterator[Claim]:
    """Those that V is positive."""
    return (claim for claim in claims if claim.name.startswith("V "))


def _of_cells(claims: Iterable[Claim]) -> Iterator[Claim]:
    """Those that V falls on closed cells."""
    return (claim for claim in claims if claim.name.startswith("cell "))


def of_two_fields(claims: Iterable[Claim]) -> Iterator[Claim]:
    """The same, and that it falls along mixtures of two fields along which one surface is kept."""
    for claim in claims:
        count = len(claim.inequalities[0].pushes)
        if claim.name.startswith("cell ") or count == 1:
            yield from pairs(claim) if count else [claim]


def _rows(claims: Sequence[Sequence[Claim]], select: Kept, units: Floats) -> tuple[Floats, Floats]:
    """The values at few and at more samples that must be positive, over their sizes, a column for each function."""
    few, every = (
        at_samples([list(select(of_function)) for of_function in claims], seeds) / units for seeds in (FEW_SEEDS, SEEDS)
    )
    return _normalized(few), _normalized(every)


def _normalized(rows: Floats) -> Floats:
    """Rows over their largest entries."""
    sizes = np.abs(rows).max(axis=1, keepdims=True)
    return np.asarray(rows / np.where(sizes > 0, sizes, 1))


def at_samples(claims: Sequence[Sequence[Claim]], seeds: tuple[int, ...]) -> Floats:
    """The values of inequalities at random points, a column for each list of claims."""
    blocks = [values_inside(same, 0, samples(same[0].count, seeds)) for same in zip(*claims, strict=True)]
    return np.vstack(blocks)


@lru_cache(maxsize=16)
def samples(count: int, seeds: tuple[int, ...]) -> Floats:
    """Random points of the border of the box, in its units: the claims are about forms."""
    points = np.vstack([sample_points(count, bounded=True, seed=seed) for seed in seeds])
    return np.asarray(points / max_norms(points)[:, None])


def _rounded(chosen: Floats, rows: Floats) -> list[Fraction] | None:
    """Coefficients in the shortest numbers with which all rows stay positive; None where those are too long."""
    served = (
        coefficients
        for coefficients in roundings(chosen, DENOMINATORS)
        if (rows @ np.array(coefficients, dtype=float) > 0).all()
    )
    return next(served, None)


def in_units(chosen: Sequence[Fraction], listed: Sequence[Product], about: InRoots) -> Function:
    """A sum of products whose coefficients are given in the units of roots."""
    return [(c / term.unit(about.units), term) for c, term in zip(chosen, listed, strict=True) if c]


def products(orders: Sequence[int], degree: int) -> Iterator[Product]:
    """Those of one degree that are even in all roots together, and have derivatives by the states."""
    for powers in product(range(degree + 1), repeat=len(orders)):
        if sum(powers) == degree and all(e >= q for e, q in zip(powers, orders, strict=True) if e):
            for turned in product(*[(False, True) if e else (False,) for e in powers]):
                if (degree + sum(turned)) % 2 == 0:
                    yield Product(powers, turned)
