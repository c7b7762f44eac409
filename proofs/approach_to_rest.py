"""Evidence that solutions approach the set of equilibria: where a V that does not rise is kept nothing moves.

As :mod:`nonsmooth.proofs.checker.approach` states it.  It is asked of the V that shows that a point is stable, or of
energies: in the whole space where that is shown, else on a cube, below the level that V has at least on its border.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import TypeAlias

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.falling_function import claims_about
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.cells import BeyondReachError, are_positive_everywhere, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.second_function import Survey
from nonsmooth.proofs.kernel.whole_space import FACTORS, rational_subject
from nonsmooth.proofs.systems.energies import energies_within
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

WORK = 2_000  # coefficients looked at for one claim beside sums of squares

Known: TypeAlias = tuple[PiecewiseExpression, Number]  # V in the displacement, and half the side of its cube


def find_approach(system: SwitchedSystem, known: Known | None = None) -> Record | None:
    """The entry of a certificate that shows that solutions approach the set of equilibria; None where it is not shown.

    Args:
        system: in two states or more.
        known: a V that is positive and does not rise on a cube; energies are tried too, and the V of the scene.
    """
    rational = None if system.by_roots is not None else rational_subject(system)
    if rational is None:
        return None
    radius = rational[0].check.radius
    functions = [] if known is None else [known]
    functions += [(own, radius) for own in (*energies_within(rational[0], radius), rational[0].check.lyapunov)]
    for hypotheses in _hypotheses(*rational, functions):
        found = Search(WORK).tried(rational[1], "approach", hypotheses)
        if found is not None:
            return found[0]
    return None


def _hypotheses(system: SwitchedSystem, subject: System, functions: Sequence[Known]) -> Iterator[Record]:
    """What is tried: each V in the whole space, then on its cube, and on half of it.

    At the border of a largest cube V may be kept where something moves.
    """
    if not system.rewriting.waves and are_positive_everywhere(system):
        for potential, _ in functions:
            for own in _with_bounds(system, subject, potential, None):
                yield from ({**own, "proper": str(factor)} for factor in FACTORS)
    for potential, radius in functions:
        for half in (radius, radius / 2):
            for own in _with_bounds(system, subject, potential, half):
                falling = claims_about(system, potential, half)
                region = None if falling is None else falling.largest_sublevel()
                if region is not None:
                    yield {**own, "level": str(region.level)}
                yield own


def _with_bounds(
    system: SwitchedSystem, subject: System, potential: PiecewiseExpression, half: Number | None
) -> Iterator[Record]:
    """The hypotheses with bounds of the rates of V; none where it rises."""
    with suppress(BeyondReachError, NotShownError, RejectedError):
        cells = stated_cells(system, half, surfaces_of(system, potential)).record
        zeros = Survey(subject, cells, potential.text, [], Search(WORK), None).zeros
        yield {"cells": cells, "function": potential.text, "zeros": zeros, "level": None, "proper": None}
