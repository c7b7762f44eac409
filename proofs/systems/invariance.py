"""LaSalle's invariance principle for a V that does not increase: whether anything but the origin stays where V' = 0.

For a Filippov inclusion every bounded solution tends to the largest weakly invariant set in the closure of Z, the set
of points at which some f in F has ``g . f = 0`` for all g in dV (Shevitz and Paden 1994; Ryan 1998; Bacciotti and
Ceragioli 1999, thm. 3).  On a limit set V has one value, so a solution there stays on one level of V for ever.  Z lies
in the zero sets of ``grad V . f`` on closed cells and in the edges on which V bends.  In the plane it is enough that

1. no arc of these zero sets or edges lies on a level of V, but in cells where ``grad V . f`` vanishes altogether: then
   a solution on one level either does not move or stays in such cells;
2. in these cells all fields turn in one sense, and the cells leave a direction free: then none stays in them;
3. no other point rests (:mod:`nonsmooth.proofs.systems.rest_points`): then none does not move.

Then every solution from a sublevel set of V inside the domain tends to the origin.  Where several fields act in a cell
(arbitrary switching), F is their hull.  None of them lets V rise, so a mixture keeps V only if all fields that it mixes
do: 1 and 2 are asked of each field in each cell, 3 of all mixtures, for two fields that each move may rest together.
Fields are not asked one after the other: one may keep V where another does not, and a signal may always take the first.
Condition 1 is exact over Q: an irreducible factor q of the rate whose zero set holds an arc of a level divides the
Jacobian of V and q.

Where 1 to 3 leave it open, as beside curves on which V bends, further functions are searched that rise where V is kept
(:mod:`nonsmooth.proofs.kernel.second_function`).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from enum import StrEnum
from itertools import combinations

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Region, common_edges
from nonsmooth.analysis.cells.switched_cells import LyapunovCell, PlaneField
from nonsmooth.proofs.inequalities.cell_forms import directions
from nonsmooth.proofs.inequalities.effort import effort_of_its_own
from nonsmooth.proofs.inequalities.prover import Proof, Sense, prove
from nonsmooth.proofs.inequalities.strata import bends_along_a_curve
from nonsmooth.proofs.kernel.second_function import find_attraction
from nonsmooth.proofs.systems.border_motion import along_edge
from nonsmooth.proofs.systems.derivatives import EFFORT, Decrease, LyapunovResult
from nonsmooth.proofs.systems.rest_points import Rests, find_rests
from nonsmooth.symbolic.numbers.lazy import evaluated
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.plane import cross
from nonsmooth.symbolic.surfaces import divides, factorize
from nonsmooth.symbolic.switched_system import SwitchedSystem


class Staying(StrEnum):
    """What is known of solutions that stay where V' = 0."""

    NONE = "no solution but the equilibrium stays where V' = 0"
    RESTS = "there are other equilibria where V' = 0"
    ARC = "V' = 0 on an arc of a level of V"
    CELLS = "V' = 0 on cells in which solutions may stay"
    UNDECIDED = "whether other solutions stay where V' = 0 is not decided"


@effort_of_its_own(EFFORT)
def decide_staying(cells: Sequence[LyapunovCell]) -> Staying:
    """Whether a solution other than the origin stays for ever on one level of V inside the domain.

    Args:
        cells: cover the domain; V is positive and does not increase on them.
    """
    if bends_along_a_curve(cells):
        return Staying.UNDECIDED
    still = [cell for cell in cells if not all(cell.rates)]
    if still and not _all_leave(cells, still):
        return Staying.CELLS
    if any(_holds_level_arc(cell, rate) for cell in cells for rate in cell.rates if rate):
        return Staying.ARC
    if not all(_changes_along_edges(first, second) for first, second in combinations(cells, 2)):
        return Staying.ARC
    rests = find_rests(cells)
    return {Rests.NONE: Staying.NONE, Rests.SOME: Staying.RESTS}.get(rests, Staying.UNDECIDED)


# ---- zero sets of the rate -----------------------------------------------------------------------


def _holds_level_arc(cell: LyapunovCell, rate: Polynomial) -> bool:
    """Whether a curve on which a rate vanishes may run along a level of V."""
    leading = rate.terms[max(rate.terms)]
    factored = factorize(rate * leading.inverse())
    if factored is None:
        return True
    return any(_runs_along_level(q, cell) and not _is_definite(q, cell.region) for q, _ in factored[1])


def _runs_along_level(curve: Polynomial, cell: LyapunovCell) -> bool:
    a, b = cell.gradient
    jacobian = a * curve.derivative("y") - b * curve.derivative("x")
    return divides(curve, jacobian) is not False


def _is_definite(curve: Polynomial, region: Region) -> bool:
    """Whether a curve has no point in the region but the origin."""
    senses = (Sense.POSITIVE, Sense.NEGATIVE)
    return any(isinstance(prove(sense, curve, region, except_origin=True), Proof) for sense in senses)


# ---- edges ---------------------------------------------------------------------------------------


def _changes_along_edges(first: LyapunovCell, second: LyapunovCell) -> bool:
    """Whether V is constant on no part of the edges between two cells on which V bends, or beside a still cell."""
    bends = bool(first.potential - second.potential)
    if not bends and all(first.rates) and all(second.rates):
        return True
    a, b = first.gradient
    for start, end in common_edges(first.region, second.region):
        (x, y, w), (s, t, u) = edge = (tuple(map(evaluated, start)), tuple(map(evaluated, end)))
        if not along_edge(a * (s * w - x * u) + b * (t * w - y * u), edge):
            return False
    return True


# ---- cells in which the rate vanishes ------------------------------------------------------------


def _all_leave(cells: Sequence[LyapunovCell], still: Sequence[LyapunovCell]) -> bool:
    """Whether no solution stays in the closed cells where V does not change: all turn, and not all the way round."""
    if any(cell.region.guards for cell in cells):
        return False
    turns = {
        _sense_of_turning(cell, field)
        for cell in still
        for field, rate in zip(cell.velocities, cell.rates, strict=True)
        if not rate
    }
    free = any(not any(_in_cone(ray, a, b) for a, b in _cones(still)) for ray in _middles(cells))
    return free and len(turns) == 1 and 0 not in turns


def _sense_of_turning(cell: LyapunovCell, field: PlaneField) -> int:
    """The strict sign of ``c x f`` on a closed cell but the origin; 0 where none is proved."""
    f, g = field
    x, y = (Polynomial.variable(f.field, f.variables, name) for name in f.variables)
    across = x * g - y * f
    for sense, turn in ((Sense.POSITIVE, 1), (Sense.NEGATIVE, -1)):
        if isinstance(prove(sense, across, cell.region, except_origin=True), Proof):
            return turn
    return 0


def _cones(cells: Sequence[LyapunovCell]) -> Iterator[tuple[Point, Point]]:
    for cell in cells:
        for g, h in directions(cell.region):
            yield (g[0], g[1]), (h[0], h[1])


def _middles(cells: Sequence[LyapunovCell]) -> Iterator[Point]:
    """A direction inside each cone of the directions of the cells."""
    return ((a[0] + b[0], a[1] + b[1]) for a, b in _cones(cells))


def _in_cone(ray: Point, start: Point, end: Point) -> bool:
    return sign(cross(start, ray)) >= 0 and sign(cross(ray, end)) >= 0


def decide_staying_of(
    system: SwitchedSystem, formula: PiecewiseExpression | None, radius: Number, cells: Sequence[LyapunovCell]
) -> Staying:
    """The same; where the zero sets leave it open, further functions are searched that rise where V is kept.

    Args:
        system: in two states.
        formula: V in the displacement; None for one of pieces, for which none are searched.
        radius: half the side of the square on which they are searched.
        cells: cover the domain; V is positive and does not increase on them.
    """
    found = decide_staying(cells)
    if found in (Staying.NONE, Staying.RESTS) or formula is None or system.by_roots is not None:
        return found
    return found if find_attraction(system, formula, radius) is None else Staying.NONE


def staying_of(certificate: LyapunovResult | None) -> Staying | None:
    """What stays where V' = 0, of a V that does not increase; None for any other."""
    weak = certificate is not None and certificate.verdict is Decrease.WEAK
    return decide_staying(certificate.cells) if certificate is not None and weak else None
