"""LaSalle's invariance principle for a V that does not increase: whether anything but the origin stays where V' = 0.

For a Filippov inclusion every bounded solution tends to the largest weakly invariant set in the closure of Z, the set
of points at which some f in F has ``g . f = 0`` for all g in dV (Shevitz and Paden 1994; Ryan 1998; Bacciotti and
Ceragioli 1999, thm. 3).  On a limit set V has one value, so a solution there stays on one level of V for ever.  That
none does is shown by further functions that rise, one after the other, along all velocities that keep those before
(:mod:`nonsmooth.proofs.kernel.second_function`): a theorem of the checker, in any number of states, of the hull of all
fields that act.  Irrational numbers of the fields are enclosed first.

Where no such functions are found, what is plainly seen is said: cells in which a field keeps V, a curve on which V' = 0
along a level of V, or a place of rest.  Nothing follows from that.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum
from fractions import Fraction
from itertools import combinations

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import affine, common_edges
from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, velocities_at
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.prover import Proof, prove
from nonsmooth.proofs.inequalities.subdivision import effort_of_its_own
from nonsmooth.proofs.kernel.second_function import find_attraction
from nonsmooth.proofs.systems.derivatives import EFFORT
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.formulas.surfaces import divides, factorize
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import hull_holds_zero
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

ALONG = (Fraction(1, 64), Fraction(1, 2), Fraction(1))  # of a side, from its first end, where a rest is looked for


class Staying(StrEnum):
    """What is known of solutions that stay where V' = 0."""

    NONE = "no solution but the equilibrium stays where V' = 0"
    RESTS = "there are other equilibria where V' = 0"
    ARC = "V' = 0 on an arc of a level of V"
    CELLS = "V' = 0 on cells in which solutions may stay"
    UNDECIDED = "whether other solutions stay where V' = 0 is not decided"


def decide_staying(
    system: SwitchedSystem, formula: PiecewiseExpression | None, radius: Number, cells: Sequence[LyapunovCell]
) -> Staying:
    """Whether a solution other than the origin stays for ever on one level of V inside the domain.

    Args:
        system: in two states.
        formula: V in the displacement; None for one of pieces, for which no further functions are searched.
        radius: half the side of the square on which they are searched.
        cells: cover the domain; V is positive and does not increase on them.
    """
    place = resting_place(cells)
    if place is None and formula is not None and attracts(system, formula, radius):
        return Staying.NONE
    if not all(rate for cell in cells for rate in cell.rates):
        return Staying.CELLS
    if _holds_level_arc(cells):
        return Staying.ARC
    return Staying.UNDECIDED if place is None or system.only_encloses else Staying.RESTS


def attracts(system: SwitchedSystem, formula: PiecewiseExpression, radius: Number) -> bool:
    """Whether further functions show that a V that does not increase attracts."""
    try:
        return find_attraction(enclose_numbers(system), formula, radius) is not None
    except NoEnclosureError:
        return False


# ---- what is seen where attraction is not shown ----------------------------------------------------


@effort_of_its_own(EFFORT)
def _holds_level_arc(cells: Sequence[LyapunovCell]) -> bool:
    """Whether a rate vanishes on a curve along which V is constant.

    An irreducible factor q of the rate whose zero set holds an arc of a level divides the Jacobian of V and q.
    """
    for cell in cells:
        for rate in cell.rates:
            factored = factorize(rate * rate.terms[max(rate.terms)].inverse())
            curves = [] if factored is None else [curve for curve, _ in factored[1]]
            if any(_runs_along_level(curve, cell) and _has_points(curve, cell) for curve in curves):
                return True
    return False


def _runs_along_level(curve: Polynomial, cell: LyapunovCell) -> bool:
    a, b = cell.gradient
    return divides(curve, a * curve.derivative("y") - b * curve.derivative("x")) is True


def _has_points(curve: Polynomial, cell: LyapunovCell) -> bool:
    """Whether a curve may have a point in a cell but the origin."""
    senses = (Sense.POSITIVE, Sense.NEGATIVE)
    return not any(isinstance(prove(sense, curve, cell.region, except_origin=True), Proof) for sense in senses)


def resting_place(cells: Sequence[FieldCell]) -> Point | None:
    """A place other than the origin at which 0 is in F; None where none is seen inside cells and on their sides.

    Args:
        cells: cover a domain.  Beside curves nothing is looked at.
    """
    if any(cell.region.guards for cell in cells):
        return None
    return next((p for p in _places(cells) if any(map(sign, p)) and hull_holds_zero(velocities_at(cells, p))), None)


def _places(cells: Sequence[FieldCell]) -> Iterator[Point]:
    yield from (cell.region.inner_point for cell in cells)
    for first, second in combinations(cells, 2):
        for start, end in common_edges(first.region, second.region):
            for share in ALONG:
                place = [a * (1 - share) + b * share for a, b in zip(start, end, strict=True)]
                if place[2]:
                    yield affine(place)
