"""A relay whose sign shows late in the derivatives of its switching function: then the point is unstable.

Let s be a switching surface through the point, ``h_0 = s`` and ``h_i`` its derivatives along the field, the same
polynomial on all cells near the point for ``i < r``, while ``h_r`` at the point has the sign ``-e`` on every cell where
s has the sign e (or e on every one).  Along a solution ``s h_r`` can be integrated by parts::

    r = 2 m + 1:   B = sum_{i<m} (-1)^i h_i h_(2m-i) + (-1)^m h_m^2/2,    B' = s h_r
    r = 2 m:       B = sum_{i<m} (-1)^i h_i h_(2m-1-i),                   B' = s h_r - (-1)^m h_m^2

Near the point ``s h_r`` is ``-k abs(s)`` (or ``k abs(s)``) with k bounded away from zero, whatever else the field does.
Where the signs of both terms agree, always for odd r, ``W = -B`` or ``W = B`` never falls.  For ``r > 1`` it takes
positive values at all distances, as the gradients of ``h_0, ..., h_(r-1)`` are independent.  A solution that started
there and stayed near would have a limit set of solutions on which W is a positive constant: then ``s = 0`` all the
time, so all ``h_i = 0`` and ``W = 0``.  Of relays and integrators in a row this is known since Anosov (1959); here the
rest of the field is arbitrary.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from functools import reduce

from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.polynomials import unit
from nonsmooth.proofs.kernel.bounds import formula
from nonsmooth.proofs.kernel.cells import RationalTerms, SignCells, adjoining, rational_terms, started, stated_cells
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.written import as_checked
from nonsmooth.symbolic.numbers.polynomial import Exponents, add_terms, multiply_terms
from nonsmooth.symbolic.switched_system import SwitchedSystem

SHIFTS = (fmpq(0), fmpq(1, 64), fmpq(-1, 100))  # of a direction, off the other surfaces
RADII = (Fraction(1), Fraction(1, 4), Fraction(1, 16), Fraction(1, 64))  # half-widths of cubes, over that of the scene


@dataclass(frozen=True)
class RelayDegree:
    """A surface with its relative degree, and a function that shows instability.

    Attributes:
        surface: number of the surface s.
        degree: r, the first derivative of s that depends on its sign.
        rising: W, which never falls near the point, and rises where s is not zero.
        direction: d with ``W(t d) > 0`` for small t.
    """

    surface: int
    degree: int
    rising: RationalTerms
    direction: tuple[fmpq, ...]

    def check(self, cells: SignCells) -> bool:
        """Verify from W itself: its derivative on every cell, and its sign in the direction."""
        count = len(cells.states)
        linear = {k: self.direction[k] for k in range(count)}
        second = sum((c * _at(e, linear) for e, c in self.rising.items() if sum(e) == 2), fmpq(0))
        if any(sum(e) < 2 for e in self.rising) or not second > 0:
            return False
        surface = rational_terms(cells.surfaces[self.surface])
        ladder = _ladder(cells, surface)
        if len(ladder) != self.degree:
            return False
        square = multiply_terms(ladder[self.degree // 2], ladder[self.degree // 2]) if self.degree % 2 == 0 else {}
        for cell in adjoining(cells):
            for field in cell.velocities:
                rate, last = _along(self.rising, field), _along(ladder[-1], field)
                sense = cell.signs[self.surface] * last.get((0,) * count, fmpq(0))
                pushed = multiply_terms(surface, last)
                rest = add_terms(rate, _scaled(pushed, fmpq(-1 if sense > 0 else 1)))
                if sense == 0 or _cleaned(rest) != _cleaned(square):
                    return False
        return True


def high_degree_relay(system: SwitchedSystem, cells: SignCells) -> RelayDegree | None:
    """A surface that shows instability; None where none does.

    Args:
        system: right-hand sides that only enclose the field say nothing here.
        cells: of a cube about the point.
    """
    if system.only_encloses:
        return None
    return next(_found(cells), None)


def show_relay_of(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence that the point is unstable by W and by functions that rise where W is kept.

    Where ``s = h_0 = 0`` and W is kept, ``(h_0 h_1)' = h_1^2 + h_0 h_2`` is not negative, and zero where ``h_1 = 0``;
    there ``(h_1 h_2)' = h_2^2``, and so on up to ``h_(r-1)``.  Where all of these are zero W is zero, and points at
    which W is not positive do not count.

    Args:
        system: in any number of states.
        verdict: unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where no surface shows it, or no such functions are found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system, search)
    for share in RADII:
        stated = stated_cells(system, system.check.radius * share)
        relay = high_degree_relay(system, stated.cells)
        if relay is None:
            continue
        ladder = _ladder(stated.cells, rational_terms(stated.cells.surfaces[relay.surface]))
        function, *others = (
            formula(as_checked(own, len(system.states)), system.states)
            for own in (_scaled(relay.rising, fmpq(-1)), *map(multiply_terms, ladder, ladder[1:]))
        )
        second = find_second(subject, stated.record, function, search, below=Fraction(0), others=others)
        for shift in SHIFTS if second is not None else ():
            direction = [str(x + k * shift) for k, x in enumerate(relay.direction, 1)]
            hypotheses = {"cells": stated.record, "function": function, "second": second, "direction": direction}
            with suppress(NotShownError):
                return search.entry(subject, "instability", hypotheses)
    raise NotShownError("no relay was found whose relative degree shows it")


def _found(cells: SignCells) -> Iterator[RelayDegree]:
    count = len(cells.states)
    for number, polynomial in enumerate(cells.surfaces):
        ladder = _ladder(cells, rational_terms(polynomial))
        degree = len(ladder)
        sense = _sense(cells, number, ladder[-1]) if 2 <= degree <= count else 0
        if not sense or (degree % 2 == 0 and sense != -((-1) ** (degree // 2))):
            continue
        direction = _direction(ladder, sense, count)
        if direction is not None:
            yield RelayDegree(number, degree, _cleaned(_scaled(_by_parts(ladder), fmpq(sense))), direction)


def _ladder(cells: SignCells, surface: RationalTerms) -> list[RationalTerms]:
    """``h_0, ..., h_(r-1)``: as long as they vanish at the point and the next one is the same on all cells near it."""
    zero = (0,) * len(cells.states)
    ladder: list[RationalTerms] = []
    following = _cleaned(surface)
    while following and zero not in following and len(ladder) <= len(cells.states):
        ladder.append(following)
        seen = [_along(following, field) for cell in adjoining(cells) for field in cell.velocities]
        if any(other != seen[0] for other in seen):
            return ladder
        following = seen[0]
    return []


def _sense(cells: SignCells, number: int, last: RationalTerms) -> int:
    """Whether the field pushes s away from zero in its last derivative (1) or back (-1) on all cells; else 0."""
    zero = (0,) * len(cells.states)
    values = [
        cell.signs[number] * _along(last, field).get(zero, fmpq(0))
        for cell in adjoining(cells)
        for field in cell.velocities
    ]
    return 1 if all(v > 0 for v in values) else -1 if all(v < 0 for v in values) else 0


def _by_parts(ladder: Sequence[RationalTerms]) -> RationalTerms:
    """B."""
    top = len(ladder) - 1
    terms = [_scaled(multiply_terms(ladder[i], ladder[top - i]), fmpq((-1) ** i)) for i in range((top + 1) // 2)]
    if top % 2 == 0:
        middle = multiply_terms(ladder[top // 2], ladder[top // 2])
        terms.append(_scaled(middle, fmpq((-1) ** (top // 2), 2)))
    return reduce(add_terms, terms)


def _direction(ladder: Sequence[RationalTerms], sense: int, count: int) -> tuple[fmpq, ...] | None:
    """The d with ``grad h_0 . d = 1``, ``grad h_(r-1) . d = sense`` and zero between; None for dependent gradients."""
    rows = fmpq_mat([[h.get(unit(count, k), fmpq(0)) for k in range(count)] for h in ladder])
    gram = rows * rows.transpose()
    if not gram.det():
        return None
    wanted = [[fmpq(0)] for _ in ladder]
    wanted[0], wanted[-1] = [fmpq(1)], [fmpq(sense)]
    found = rows.transpose() * gram.inv() * fmpq_mat(wanted)
    return tuple(found[k, 0] for k in range(count))


def _along(function: Mapping[Exponents, fmpq], field: Sequence[RationalTerms]) -> RationalTerms:
    """``grad h . f``."""
    total: RationalTerms = {}
    for k, rate in enumerate(field):
        step = unit(len(field), k)
        slope = {tuple(map(int.__sub__, e, step)): c * e[k] for e, c in function.items() if e[k]}
        total = add_terms(total, multiply_terms(slope, rate))
    return _cleaned(total)


def _at(exponents: Exponents, values: Mapping[int, fmpq]) -> fmpq:
    return reduce(lambda total, k: total * values[k] ** exponents[k], range(len(exponents)), fmpq(1))


def _scaled(terms: Mapping[Exponents, fmpq], factor: fmpq) -> RationalTerms:
    return {e: c * factor for e, c in terms.items()}


def _cleaned(terms: Mapping[Exponents, fmpq]) -> RationalTerms:
    return {e: c for e, c in terms.items() if c}
