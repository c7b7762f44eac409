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

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from itertools import pairwise

from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.polynomials import Polynomial, constant, lie_derivative
from nonsmooth.proofs.kernel.bounds import formula
from nonsmooth.proofs.kernel.cells import SignCells, adjoining, rational_terms, started, stated_cells
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search, instability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.kernel.written import as_checked
from nonsmooth.symbolic.numbers.coefficients import as_fmpq, as_fraction
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SHIFTS = (Fraction(0), Fraction(1, 64), Fraction(-1, 100))  # of a direction, off the other surfaces
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
    rising: Polynomial
    direction: tuple[Fraction, ...]


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
        ladder = _ladder(stated.cells, relay.surface)
        products = (before * after for before, after in pairwise(ladder))
        function, *others = (formula(own, system.states) for own in (-relay.rising, *products))
        second = find_second(subject, stated.record, function, search, below=Fraction(0), others=others)
        for shift in SHIFTS if second is not None else ():
            direction = (x + k * shift for k, x in enumerate(relay.direction, 1))
            hypotheses = instability_hypotheses(stated.record, function, direction, second)
            with suppress(NotShownError):
                return search.entry(subject, "instability", hypotheses)
    raise NotShownError("no relay was found whose relative degree shows it")


def _found(cells: SignCells) -> Iterator[RelayDegree]:
    for number in range(len(cells.surfaces)):
        ladder = _ladder(cells, number)
        degree = len(ladder)
        sense = _sense(cells, number, ladder[-1]) if 2 <= degree <= len(cells.states) else 0
        if not sense or (degree % 2 == 0 and sense != -((-1) ** (degree // 2))):
            continue
        direction = _direction(ladder, sense)
        if direction is not None:
            yield RelayDegree(number, degree, _by_parts(ladder).times(sense), direction)


def _fields(cells: SignCells, number: int) -> Iterator[tuple[int, tuple[Polynomial, ...]]]:
    """The fields of all cells near the point, each with the sign of a surface there."""
    count = len(cells.states)
    for cell in adjoining(cells):
        for field in cell.velocities:
            yield cell.signs[number], tuple(as_checked(part, count) for part in field)


def _ladder(cells: SignCells, number: int) -> list[Polynomial]:
    """``h_0, ..., h_(r-1)``: as long as they vanish at the point and the next one is the same on all cells near it."""
    ladder: list[Polynomial] = []
    following = as_checked(rational_terms(cells.surfaces[number]), len(cells.states))
    while following and not following.at_origin and len(ladder) <= len(cells.states):
        ladder.append(following)
        first, *others = (lie_derivative(following, field) for _, field in _fields(cells, number))
        if any(other != first for other in others):
            return ladder
        following = first
    return []


def _sense(cells: SignCells, number: int, last: Polynomial) -> int:
    """Whether the field pushes s away from zero in its last derivative (1) or back (-1) on all cells; else 0."""
    values = [sign * lie_derivative(last, field).at_origin for sign, field in _fields(cells, number)]
    return 1 if all(v > 0 for v in values) else -1 if all(v < 0 for v in values) else 0


def _by_parts(ladder: Sequence[Polynomial]) -> Polynomial:
    """B."""
    top, total = len(ladder) - 1, constant(ladder[0].count, 0)
    for i in range((top + 1) // 2):
        total += (ladder[i] * ladder[top - i]).times((-1) ** i)
    if top % 2 == 0:
        total += ladder[top // 2].power(2).times(Fraction((-1) ** (top // 2), 2))
    return total


def _direction(ladder: Sequence[Polynomial], sense: int) -> tuple[Fraction, ...] | None:
    """The d with ``grad h_0 . d = 1``, ``grad h_(r-1) . d = sense`` and zero between; None for dependent gradients."""
    count = ladder[0].count
    slopes = [[h.slope(k) for k in range(count)] for h in ladder]
    rows = fmpq_mat([list(map(as_fmpq, row)) for row in slopes])
    gram = rows * rows.transpose()
    if not gram.det():
        return None
    wanted = [[fmpq(0)] for _ in ladder]
    wanted[0], wanted[-1] = [fmpq(1)], [fmpq(sense)]
    found = rows.transpose() * gram.inv() * fmpq_mat(wanted)
    return tuple(as_fraction(found[k, 0]) for k in range(count))
