"""The search for the proofs of a theorem: the checker derives the claims, and each is shown as it is asked.

Which inequalities a theorem needs is written once, in :mod:`nonsmooth.proofs.checker`.  Here its function runs with
proofs that are looked for while it asks for them: what it shows then, it shows again from the evidence alone.  (So
calls go from here to the checker's theorem, and from there back to :class:`Search`.)  In two states a check
decides the signs of V by :mod:`nonsmooth.proofs.inequalities`, and nothing of that proof is used here.

Kinds of evidence are tried one after the other; the simplest, *mixtures*, is found here: nonnegative multiples of
guards that leave an affine polynomial without negative values.

*Samples*: claims that floats refute at points of the cube need not be searched; proposals that cannot be shown are left
before.
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import chain
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.proofs.checker.cells import Cell, Face, Inclusion, SurfaceSigns, System
from nonsmooth.proofs.checker.lyapunov import Lyapunov
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.positivity import Claim, Inequality, Proofs
from nonsmooth.proofs.checker.statements import THEOREMS
from nonsmooth.proofs.checker.theorems import Statement
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof, Undecided
from nonsmooth.proofs.kernel import simplices, squares
from nonsmooth.proofs.kernel.written import exact, hessian, slopes, twin, written_number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.plane_arrays import Floats, squared_norms
from nonsmooth.symbolic.numbers.polynomial import float_values, float_values_and_sizes

WORK = 20_000  # coefficients that the search for simplices may look at, for one claim
FLAT = 2  # variables up to which simplices are tried before sums of squares
MOST_BY_SIMPLICES = 3  # beyond, a cube consists of too many


Entry: TypeAlias = tuple[Record, list[Statement]]  # of a certificate, and what it shows


class NotShownError(ValueError):
    """A theorem of which a hypothesis is not shown, in one line."""


class Search(Proofs):
    """Proofs that are searched when they are asked for, and kept.

    Attributes:
        found: each claim that was shown, with its evidence, by name.
        used: the names of those that the last theorem asked for.
        missed: claims that were not shown, by name.
        known: evidence of claims by their names that need not be searched; the checker looks at it in the end.
    """

    def __init__(self, work: int = WORK, known: Mapping[str, Any] | None = None) -> None:
        super().__init__({})
        self.work, self.known = work, known or {}
        self.found: dict[str, tuple[Claim, Any]] = {}
        self.missed: dict[str, Claim] = {}
        self.used: list[str] = []

    def show(self, claim: Claim) -> None:
        """Find evidence of a claim.

        Raises:
            NotShownError: where none is found.
        """
        earlier = self.found.get(claim.name)
        if earlier is None or earlier[0] != claim:
            evidence = self._evidence(claim)
            if evidence is None:
                self.missed[claim.name] = claim
                raise NotShownError(f"no proof was found of {claim.name}")
            self.found[claim.name] = claim, evidence
        self.used.append(claim.name)
        self.note_form(claim)

    def _evidence(self, claim: Claim) -> Any:
        if self.missed.get(claim.name) == claim:
            return None
        evidence = self.known.get(claim.name)
        outcome = Proof(claim, evidence) if evidence else decide_claim(claim, self.work)
        return outcome.evidence if isinstance(outcome, Proof) else None

    def shows(self, claim: Claim) -> bool:
        """Find evidence of a claim that nothing needs, if there is any; whether it was found."""
        try:
            self.show(claim)
        except NotShownError:
            return False
        return True

    def entry(self, system: System, theorem: str, hypotheses: Record) -> Entry:
        """A theorem with its proofs as a certificate holds it, and what it shows.

        Args:
            system: the subject.
            theorem: its name.
            hypotheses: without proofs.  Claims that were shown before, under the same names, are not searched again.

        Raises:
            NotShownError: where a hypothesis is not shown.
        """
        self.used, self.are_forms = [], True
        try:
            statements = THEOREMS[theorem](system, hypotheses, self)
        except RejectedError as error:
            raise NotShownError(f"required {error}") from None
        proofs = {name: self.found[name][1] for name in self.used}
        return {"theorem": theorem, "hypotheses": hypotheses, "proofs": proofs}, statements

    def tried(self, system: System, theorem: str, hypotheses: Record) -> Entry | None:
        """The same, of hypotheses that no sample refutes; None where one is not shown."""
        with suppress(NotShownError):
            SampledProofs().entry(system, theorem, hypotheses)
            return self.entry(system, theorem, hypotheses)
        return None


def stability_hypotheses(cells: Record, function: Any, verdict: str, second: Record | None = None) -> Record:
    """Of theorem ``lyapunov``, with nothing stated beyond the verdict.

    Args:
        cells: as a certificate states them.
        function: V, likewise.
        verdict: stable, or asymptotically stable.
        second: further functions with bounds of their rates, where V does not fall everywhere.
    """
    stated = {"cells": cells, "function": function, "second": second, "verdict": verdict}
    return {**stated, "everywhere": False, "level": None, "below": False, "rate": None}


def instability_hypotheses(
    cells: Record, function: Any, direction: Iterable[object], second: Record | None = None
) -> Record:
    """Of theorem ``instability``.

    Args:
        cells: as a certificate states them.
        function: V, likewise.
        direction: in which V is negative near the point.
        second: further functions with bounds of their rates, where V does not fall everywhere.
    """
    return {"cells": cells, "function": function, "second": second, "direction": list(map(str, direction))}


DIRECTIONS = 200  # drawn in whole numbers, about each one that is thought of, and of any kind
FINE = 1 << 10  # denominator of the others


def directed_hypotheses(
    system: System,
    cells: Record,
    function: Any,
    search: Search,
    second: Record | None = None,
    *,
    near: Sequence[Floats] = (),
) -> Record:
    """The same with a direction that is found.

    Args:
        system: the subject.
        cells: as a certificate states them.
        function: V, likewise.
        search: keeps the proofs that are found.
        second: further functions with bounds of their rates, where V does not fall everywhere.
        near: directions in whose neighbourhood V is thought to be negative.

    Raises:
        NotShownError: where none is found, or the checker refuses the cells or V.
    """
    try:
        direction = negative_direction(
            Lyapunov(Inclusion(system, cells, [function], search, framed=True), search), near
        )
    except RejectedError as error:
        raise NotShownError(f"required {error}") from None
    if direction is None:
        raise NotShownError("no direction was found in which V is negative")
    return instability_hypotheses(cells, function, direction, second)


def negative_direction(stated: Lyapunov, near: Sequence[Floats] = ()) -> tuple[Fraction, ...] | None:
    """A direction into a cell in which V is negative near the point; None where none is found.

    Short ones are tried first, then those near given ones, and near those in which the quadratic part of a piece is
    least.
    """
    source, shape = np.random.default_rng(0), (DIRECTIONS, stated.count)
    least = (_least_directions(piece) for piece in dict.fromkeys(map(stated.potential, stated.inclusion.cells)))
    about = (vector / np.abs(vector).max() + _nearer(source.normal(size=shape)) for vector in chain(near, *least))
    for drawn in chain([source.integers(-9, 10, shape)], about, [source.normal(size=shape)]):
        for candidate in drawn:
            direction = tuple(Fraction(float(x)).limit_denominator(FINE) for x in candidate)
            if any(direction) and stated.is_negative_along(direction):
                return direction
    return None


def _least_directions(potential: Polynomial) -> Floats:
    """Both directions in which the quadratic part of a piece of V is least, in rows."""
    least = np.linalg.eigh(hessian(potential.terms, potential.count))[1][:, 0]
    return np.stack([least, -least])


def _nearer(steps: Floats) -> Floats:
    """Steps, the first of which is none, and the others of several sizes."""
    sizes = 2.0 ** -(2 + np.arange(len(steps)) % 8)
    return np.asarray(np.where(np.arange(len(steps)) == 0, 0.0, sizes)[:, None] * steps)


@dataclass(frozen=True)
class Kind:
    """A kind of evidence.

    Attributes:
        search: evidence of a claim, with some work, or a point that refutes it; None where neither is found.
        place: of the kind in the order for a claim, the lowest first; None where it is not tried.
    """

    search: Callable[[Claim, int], Record | Counterexample[Claim] | None]
    place: Callable[[Claim], int | None]


def _place_of_mixtures(claim: Claim) -> int | None:
    return 0 if all(inequality.value.degree <= 1 for inequality in claim.inequalities) else None


def _place_of_simplices(claim: Claim) -> int | None:
    return None if claim.count > MOST_BY_SIMPLICES else 1 if claim.count <= FLAT else 3


def _place_of_squares(claim: Claim) -> int | None:
    return 2 if claim.field is None else None  # their matrices are rational


SQUARES = Kind(lambda claim, work: squares.search(claim), _place_of_squares)

# A new kind of evidence is a line here, and one of KINDS in the checker.
KINDS = [
    Kind(lambda claim, work: search_mixture(claim), _place_of_mixtures),
    Kind(simplices.search, _place_of_simplices),
    SQUARES,
]


def decide_claim(
    claim: Claim, work: int = WORK, *, but: Kind | None = None
) -> Proof[Claim] | Counterexample[Claim] | Undecided[Claim]:
    """Decide a claim by the first kind of evidence that shows it, or meets a point at which it is false.

    Args:
        claim: as a theorem states it.
        work: coefficients that the search for simplices may look at.
        but: a kind that is not asked, because it was.
    """
    places = [(kind.place(claim), kind) for kind in KINDS if kind is not but]
    for _, kind in sorted(((place, kind) for place, kind in places if place is not None), key=lambda pair: pair[0]):
        outcome = kind.search(claim, work)
        if outcome is not None:
            return outcome if isinstance(outcome, Counterexample) else Proof(claim, outcome)
    return Undecided(claim)


def search_mixture(claim: Claim) -> Record | None:
    """Multipliers for each inequality of a claim about affine polynomials; None where there are none.

    Args:
        claim: any one; where a guard or p is not affine, or functions mu are asked for, nothing is found.
    """
    multipliers = [_multipliers(claim, inequality) for inequality in claim.inequalities]
    return None if None in multipliers else {"mixture": multipliers}


def _multipliers(claim: Claim, inequality: Inequality) -> dict[str, str] | None:
    """The least sum ``-p + sum lambda g`` over the domain as a linear program.

    In ``p = sum_g lambda_g g + sum_k a_k (1 - z_k) + b_k (1 + z_k) + rest`` the rest is made as large as it can be.
    """
    if inequality.pushes or inequality.value.degree > 1:
        return None
    named = {name: guard for name, guard in inequality.guards.items() if guard.degree == 1 and name[0] == "s"}
    field, count = NumberField() if claim.field is None else twin(claim.field), claim.count
    columns = [[field(exact(value)) for value in slopes(guard)] for guard in named.values()]
    prices = [field(exact(-guard.at_origin)) for guard in named.values()]
    for k in range(count if claim.bounded else 0):
        for side in (1, -1):
            columns.append([field(side * int(i == k)) for i in range(count)])
            prices.append(field(-1))
    target = [field(exact(value)) for value in slopes(inequality.value)]
    if not count or not columns:
        return {} if not any(slopes(inequality.value)) and _is_enough(claim, inequality.value.at_origin) else None
    try:
        mixture = best_mixture(columns, target, prices)
    except ValueError:  # unbounded: no point has all these signs
        return None
    if mixture is None:
        return None
    if not _is_enough(claim, mixture.value + exact(inequality.value.at_origin)):
        return None
    names = list(named)
    return {names[k]: written_number(weight) for k, weight in mixture.weights.items() if k < len(names)}


def _is_enough(claim: Claim, rest: Any) -> bool:
    return rest > 0 or (not claim.strict and not rest)


POINTS, SHRINK = 600, 4.0  # points of each claim; the exponential scale of their distances
SLACK = 2.0**-30  # of the largest term, below which a value counts as zero
STEPS, TINY = 8, 2.0**-100  # of Newton's method toward a surface; the least square of a slope


class SampledProofs(Search):
    """Accepts every claim that no sample refutes: what it accepts is not shown."""

    def show(self, claim: Claim) -> None:
        """Look at a claim in floats.

        Raises:
            NotShownError: where an inequality is false at a sample.
        """
        points = sample_points(claim.count, bounded=claim.bounded)
        if any(_is_refuted(claim, inequality, points) for inequality in claim.inequalities):
            raise NotShownError(f"a sample refutes {claim.name}")
        self.found[claim.name] = claim, None
        self.used.append(claim.name)


def sample_points(count: int, *, bounded: bool, seed: int = 0) -> Floats:
    """Random points of the cube, as many near the origin as far from it, and points of its diagonals and axes.

    Without the cube every second one is taken as far beyond its border as it was within: there the terms of the highest
    degree decide, which are small in the cube.
    """
    source = np.random.default_rng((count, seed))
    points = source.uniform(-1, 1, (POINTS, count)) * np.exp(-source.exponential(SHRINK, (POINTS, 1)))
    points[: POINTS // 2] = np.sign(points[: POINTS // 2]) * np.exp(-source.exponential(SHRINK, (POINTS // 2, count)))
    if not bounded:
        points[::2] /= np.abs(points[::2]).max(axis=1, keepdims=True, initial=0) ** 2
    return points


def _is_refuted(claim: Claim, inequality: Inequality, points: Floats) -> bool:
    """Whether an inequality without functions mu is false at a point where all guards are positive."""
    if inequality.pushes or inequality.zeros:
        return False
    guards = list(inequality.guards.values())
    zero = [guard for guard in guards if -guard in guards]
    points = moved_to(zero[0], points) if zero else points
    inside = (np.abs(points) <= 1).all(axis=1) if claim.bounded else np.ones(len(points), dtype=bool)
    for guard in guards:
        value, size = float_values_and_sizes(guard.terms, points)
        inside &= (np.abs(value) <= SLACK * size) if guard in zero else (value > SLACK * size)
    value, size = float_values_and_sizes(inequality.value.terms, points[inside])
    return bool((value < -SLACK * size).any()) or (claim.strict and bool(((size > 0) & (value < SLACK * size)).any()))


def moved_to(surface: Polynomial, points: Floats) -> Floats:
    """Points near these where a polynomial is zero, by Newton's method along its gradient."""
    for _ in range(STEPS):
        normals = gradient(surface, points)
        steps = float_values(surface.terms, points) / np.maximum(squared_norms(normals), TINY)
        points = points - steps[:, None] * normals
    return points


def gradient(function: Polynomial, points: Floats) -> Floats:
    """Of shape (m, n)."""
    return np.stack([float_values(function.derivative(k).terms, points) for k in range(function.count)], axis=1)


# ---- the claims about a function V of a plain system ---------------------------------------------
#
# Or about all functions of a basis, as the checker derives them.


class DeferredClaims(Proofs):
    """Claims that are noted when they are asked, and shown later."""

    def __init__(self) -> None:
        super().__init__({})
        self.claims: list[Claim] = []

    def show(self, claim: Claim) -> None:
        """Note a claim."""
        self.claims.append(claim)
        self.note_form(claim)


class Functions(Lyapunov):
    """The claims about each of some functions, on common cells and faces.

    Attributes:
        number: of the function that is V.
    """

    def __init__(
        self,
        system: System,
        cells: Record,
        functions: Sequence[str | list[list[str]]],
        search: Search | None = None,
    ) -> None:
        self.collected = DeferredClaims()
        super().__init__(Inclusion(system, cells, list(functions), search or self.collected), self.collected)
        self.number = 0
        self._known: dict[Hashable, Any] = {}  # of all functions: guards and pushes

    def listed(self, cell: Cell) -> Polynomial:
        """The function with the number, on a cell."""
        return cell.functions[self.number]

    def _guards(self, face: Face, signs: SurfaceSigns, cell: Cell) -> dict[str, Polynomial] | None:
        """The guards on a face, which are the same for all functions."""
        key = face.zero, tuple(signs.items()), self.below
        if key not in self._known:
            self._known[key] = super()._guards(face, signs, cell)
        guards: dict[str, Polynomial] | None = self._known[key]
        return guards

    def _pushes(self, face: Face, field: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
        """The pushes of a field of a cell on a face, which are the same for all functions."""
        key = face.zero, id(field)
        if key not in self._known:
            self._known[key] = super()._pushes(face, field)
        pushes: tuple[Polynomial, ...] = self._known[key]
        return pushes

    def claims(self, number: int = 0, *, positive: bool = True, strict: bool = True) -> list[Claim]:
        """What Lyapunov's theorem asks of a function: that it is positive, and that it falls."""
        self.number = number
        self.proofs = self.collected = DeferredClaims()
        if positive:
            self.show_positive()
        self.show_falls("", self.zero, strict=strict)
        return self.collected.claims

    def claims_on_cells(self, number: int) -> list[Claim]:
        """That a function falls on closed cells."""
        self.number = number
        self.proofs = self.collected = DeferredClaims()
        self.show_falls_on_cells("", self.zero, strict=True)
        return self.collected.claims

    def claims_by_square(self, speed: Fraction) -> list[Claim]:
        """That ``V' <= -speed V^2`` where V is not positive, of the first function."""
        self.number, self.below = 0, Fraction(0)
        self.proofs = self.collected = DeferredClaims()
        self.show_falls_by_square(speed)
        return self.collected.claims
