"""Evidence that every solution of the whole space comes to the point: a V that falls everywhere and is proper.

Conditions on a V that hold on a cube about the point are asked again without the cube, and beside them that ``V + 1``
is at least a multiple of ``|x|^2``, or of each ``|x_k|``, so that the level sets of V are bounded.  Where V and the
field are forms on cones, the conditions on the cube say enough
(:func:`nonsmooth.proofs.checker.lyapunov.Lyapunov.require_all_of_space`).
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import suppress
from fractions import Fraction
from itertools import chain, product
from typing import Any

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE
from nonsmooth.proofs.kernel.cells import BeyondReachError, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.denominators import are_positive_everywhere
from nonsmooth.proofs.kernel.global_function import global_functions, logarithmic_functions
from nonsmooth.proofs.kernel.quotients import find_quotient
from nonsmooth.proofs.kernel.search import NotShownError, SampledProofs, Search, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.systems.enclosed_numbers import NoEnclosureError, enclose_numbers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

BOUNDS = ("proper", "growth")  # |x|^2, and |x_k| for every k, tried in turn
FACTORS = (Fraction(1, 4), Fraction(1, 64))  # of each
WORK = 2_000  # coefficients looked at for one claim beside sums of squares


def find_global_attraction(
    system: SwitchedSystem,
    potentials: Iterable[PiecewiseExpression | None],
    energies: Iterable[PiecewiseExpression] = (),
) -> dict[str, Any] | None:
    """The entry of a certificate that shows that every solution comes to the point; None where none is found.

    A V that falls is looked for first, then one that does not rise with functions that show that nothing else stays on
    one level of it.

    Args:
        system: in one state or more.  Right-hand sides that enclose sines are those of the checked square: of these
            nothing is shown, nor of those in roots of states, nor where a denominator is positive on the square alone.
        potentials: V in the displacement, tried in turn, before others that are searched.
        energies: further V, which need not fall.
    """
    if system.waves or system.by_roots is not None or not are_positive_everywhere(system):
        return None
    known = rational_subject(system)
    if known is None:
        return None
    space, given = WholeSpace(*known), [own for own in potentials if own is not None]
    for potential in chain(given, global_functions(known[0])):
        found = space.shown(potential, strict=True)
        if found is not None:
            return found
    quotient = find_quotient(known[0], everywhere=True)
    if quotient is not None:
        return quotient[0]
    for potential, inside in logarithmic_functions(known[0]):
        found = space.shown(potential, strict=True, logarithm=inside.text)
        if found is not None:
            return found
    for potential in chain(given, energies):
        found = space.shown(potential, strict=False)
        if found is not None:
            return found
    return None


def rational_subject(system: SwitchedSystem) -> tuple[SwitchedSystem, System] | None:
    """A system in rational numbers that encloses one, and what a certificate is about; None where there is none."""
    try:
        enclosing = enclose_numbers(system)
        return enclosing, started(enclosing, None)[0]
    except (BeyondReachError, NoEnclosureError, NotShownError):  # among others an irrational point
        return None


class WholeSpace:
    """What functions show without a cube; each is asked once.

    Args:
        system: in rational numbers.
        subject: what a certificate is about.
    """

    def __init__(self, system: SwitchedSystem, subject: System) -> None:
        self.system, self.subject = system, subject
        self.asked: set[tuple[str, bool, str]] = set()

    def shown(self, potential: PiecewiseExpression, *, strict: bool, logarithm: str = "") -> dict[str, Any] | None:
        """The entry for a V that falls; or for one that does not rise, with further functions.  None without one.

        Args:
            potential: V.
            strict: whether it is to fall.
            logarithm: P, where V has ``ln(1 + P)`` beside it.
        """
        if (potential.text, strict, logarithm) in self.asked:
            return None
        self.asked.add((potential.text, strict, logarithm))
        try:
            cells = stated_cells(self.system, None, surfaces_of(self.system, potential)).record
        except BeyondReachError:
            return None
        search = Search(WORK)
        own = stability_hypotheses(cells, potential.text, ASYMPTOTICALLY_STABLE if strict else STABLE)
        own |= {"logarithm": logarithm} if logarithm else {}
        try:
            SampledProofs().entry(self.subject, "lyapunov", own)
        except NotShownError:
            return None
        if not strict:
            second = find_second(self.subject, cells, potential.text, search)
            if second is None:
                return None
            own = stability_hypotheses(cells, potential.text, ASYMPTOTICALLY_STABLE, second)
        for bound, factor in product(BOUNDS, FACTORS):
            hypotheses = {**own, "everywhere": True, bound: str(factor)}
            with suppress(NotShownError):
                if strict:
                    SampledProofs().entry(self.subject, "lyapunov", hypotheses)
                return search.entry(self.subject, "lyapunov", hypotheses)[0]
        return None
