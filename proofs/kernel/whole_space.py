"""Evidence that every solution of the whole space comes to the point: a V that falls everywhere and is proper.

Conditions on a V that hold on a cube about the point are asked again without the cube, and beside them that
``V + 1 >= factor |x|^2``, so that the level sets of V are bounded.  Where V and the field are forms on cones, the
conditions on the cube say enough (:func:`nonsmooth.proofs.checker.lyapunov.Lyapunov.require_all_of_space`).
"""

from __future__ import annotations

from collections.abc import Iterable
from fractions import Fraction
from itertools import chain
from typing import Any

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.kernel.cells import BeyondReachError, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.global_function import global_functions
from nonsmooth.proofs.kernel.quotients import find_quotient
from nonsmooth.proofs.kernel.search import NotShownError, SampledProofs, Search, stability_hypotheses
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.systems.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

FACTORS = (Fraction(1, 4), Fraction(1, 64))  # tried in turn
WORK = 2_000  # coefficients looked at for one claim beside sums of squares


def find_global_attraction(
    system: SwitchedSystem, potentials: Iterable[PiecewiseExpression | None]
) -> dict[str, Any] | None:
    """The entry of a certificate that shows that every solution comes to the point; None where none is found.

    Args:
        system: in two states or more.  Right-hand sides that were rewritten, because of sines, fractions or roots, are
            those of the checked square: of these nothing is shown.
        potentials: V in the displacement, tried in turn, before others that are searched.
    """
    if system.waves or system.denominators or system.scale is not None or system.by_roots is not None:
        return None
    known = rational_subject(system)
    if known is None:
        return None
    system, subject = known
    asked = set[str]()
    for potential in chain(potentials, global_functions(system)):
        if potential is None or potential.text in asked:
            continue
        asked.add(potential.text)
        found = _shown(system, subject, potential)
        if found is not None:
            return found
    shown = find_quotient(system, everywhere=True)
    return None if shown is None else shown[0]


def rational_subject(system: SwitchedSystem) -> tuple[SwitchedSystem, System] | None:
    """A system in rational numbers that encloses one, and what a certificate is about; None where there is none."""
    try:
        enclosing = enclose_numbers(system)
        return enclosing, started(enclosing, None)[0]
    except (BeyondReachError, NoEnclosureError, NotShownError):  # among others an irrational point
        return None


def _shown(system: SwitchedSystem, subject: System, potential: PiecewiseExpression) -> dict[str, Any] | None:
    try:
        cells = stated_cells(system, None, surfaces_of(system, potential)).record
    except BeyondReachError:
        return None
    own = stability_hypotheses(cells, potential.text, ASYMPTOTICALLY_STABLE) | {"everywhere": True}
    for factor in FACTORS:
        hypotheses = {**own, "proper": str(factor)}
        try:
            SampledProofs().entry(subject, "lyapunov", hypotheses)
            return Search(WORK).entry(subject, "lyapunov", hypotheses)[0]
        except NotShownError:
            continue
    return None
