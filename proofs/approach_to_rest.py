"""Evidence that solutions approach the set of equilibria: where a V that does not rise is kept nothing moves.

As :mod:`nonsmooth.proofs.checker.approach` states it.  It is asked of the V that shows that a point is stable, or of
energies: near the point first; where that is shown in the whole space, else on a cube, below the level that V has at
least on its border.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
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

LocalFunction: TypeAlias = tuple[PiecewiseExpression, Number]  # V in the displacement, and half the side of its cube


def find_approach(system: SwitchedSystem, known: LocalFunction | None = None) -> Record | None:
    """The entry of a certificate that shows that solutions approach the set of equilibria; None where it is not shown.

    Args:
        system: in two states or more.
        known: a V that is positive and does not rise on a cube; energies are tried too, and the V of the scene.
    """
    rational = None if system.by_roots is not None else rational_subject(system)
    if rational is None:
        return None
    seen_system, subject = rational
    radius = seen_system.check.radius
    functions = [] if known is None else [known]
    functions += [(v, radius) for v in (*energies_within(seen_system, radius), seen_system.check.lyapunov)]
    serving: list[LocalFunction] = []  # what holds on a cube holds on its half, which refutes most functions at once
    for potential, half in functions:
        if _first_shown(subject, _with_bounds(seen_system, subject, potential, half / 2)) is not None:
            serving.append((potential, half))
    if serving and not seen_system.rewriting.waves and are_positive_everywhere(seen_system):
        for potential, _ in serving:
            entry = _first_shown(subject, _in_whole_space(seen_system, subject, potential))
            if entry is not None:
                return entry
    for potential, half in serving[:1]:
        for cube in (half, half / 2):  # at the border of a largest cube V may be kept where something moves
            entry = _first_shown(subject, _on_cube(seen_system, subject, potential, cube))
            if entry is not None:
                return entry
    return None


def _first_shown(subject: System, several: Iterable[Record]) -> Record | None:
    """The entry of the first hypotheses that are shown; None where none are."""
    for hypotheses in several:
        shown = Search(WORK).tried(subject, "approach", hypotheses)
        if shown is not None:
            return shown[0]
    return None


def _in_whole_space(system: SwitchedSystem, subject: System, potential: PiecewiseExpression) -> Iterator[Record]:
    """A V whose level sets are bounded, by several bounds."""
    for hypotheses in _with_bounds(system, subject, potential, None):
        yield from ({**hypotheses, "proper": str(factor)} for factor in FACTORS)


def _on_cube(system: SwitchedSystem, subject: System, potential: PiecewiseExpression, half: Number) -> Iterator[Record]:
    """Below the level that V has at least on the border of a cube; then near the point."""
    for hypotheses in _with_bounds(system, subject, potential, half):
        falling = claims_about(system, potential, half)
        region = None if falling is None else falling.largest_sublevel()
        if region is not None:
            yield {**hypotheses, "level": str(region.level)}
        yield hypotheses


def _with_bounds(
    system: SwitchedSystem, subject: System, potential: PiecewiseExpression, half: Number | None
) -> Iterator[Record]:
    """The hypotheses with bounds of the rates of V; none where it rises."""
    with suppress(BeyondReachError, NotShownError, RejectedError):
        cells = stated_cells(system, half, surfaces_of(system, potential)).record
        zeros = Survey(subject, cells, potential.text, [], Search(WORK), None).zeros
        yield {"cells": cells, "function": potential.text, "zeros": zeros, "level": None, "proper": None}
