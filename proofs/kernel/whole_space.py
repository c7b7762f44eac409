"""Evidence that every solution of the whole space comes to the point: a V that falls everywhere and is proper.

Conditions on a V that hold on a cube about the point are asked again without the cube, and beside them that ``V + 1``
is at least a multiple of ``|x|^2``, or of each ``|x_k|``, so that the level sets of V are bounded.  Where V and the
field are forms on cones, the conditions on the cube say enough
(:func:`nonsmooth.proofs.checker.lyapunov.Lyapunov.require_all_of_space`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import suppress
from fractions import Fraction
from itertools import chain, product
from typing import Any

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE
from nonsmooth.proofs.kernel.cells import BeyondReachError, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.denominators import are_positive_everywhere
from nonsmooth.proofs.kernel.first_terms import first_terms_attract
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
    one level of it, and quotients last: these take longest.

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
    given = [own for own in potentials if own is not None]
    return next(filter(None, _attempts(*known, given, energies)), None)


def _attempts(
    system: SwitchedSystem,
    subject: System,
    given: Iterable[PiecewiseExpression],
    energies: Iterable[PiecewiseExpression],
) -> Iterator[dict[str, Any] | None]:
    """What each way shows, one after the other; None where it shows nothing."""
    space = WholeSpace(system, subject)
    for potential in chain(given, global_functions(system)):
        yield space.by_fall(potential)
    for potential, inside in logarithmic_functions(system):
        yield space.by_fall(potential, inside.text)
    for potential in chain(given, energies):
        yield space.by_rest(potential)
    if not first_terms_attract(system, subject):  # else a quadratic form serves near the point; quotients take longest
        quotient = find_quotient(system, everywhere=True)
        yield None if quotient is None else quotient[0]


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
        self.asked: set[tuple[str, str, str]] = set()

    def by_fall(self, potential: PiecewiseExpression, logarithm: str = "") -> dict[str, Any] | None:
        """The entry for a V that falls; None where it is not shown.

        Args:
            potential: V, or what is beside the logarithm.
            logarithm: P, where V holds ``ln(1 + P)``.
        """
        own = self._unrefuted(potential, ASYMPTOTICALLY_STABLE, logarithm)
        return None if own is None else self._bounded(own, Search(WORK))

    def by_rest(self, potential: PiecewiseExpression) -> dict[str, Any] | None:
        """The entry for a V that does not rise, with functions that show that nothing else stays where it is kept."""
        own = self._unrefuted(potential, STABLE)
        if own is None:
            return None
        search = Search(WORK)
        second = find_second(self.subject, own["cells"], potential.text, search)
        if second is None:
            return None
        return self._bounded({**own, "verdict": ASYMPTOTICALLY_STABLE, "second": second}, search)

    def _unrefuted(self, potential: PiecewiseExpression, verdict: str, logarithm: str = "") -> dict[str, Any] | None:
        """The hypotheses for a verdict, where V was not asked before and no sample refutes it."""
        if (potential.text, verdict, logarithm) in self.asked:
            return None
        self.asked.add((potential.text, verdict, logarithm))
        try:
            cells = stated_cells(self.system, None, surfaces_of(self.system, potential)).record
        except BeyondReachError:
            return None
        own = stability_hypotheses(cells, potential.text, verdict) | ({"logarithm": logarithm} if logarithm else {})
        try:
            SampledProofs().entry(self.subject, "lyapunov", own)
        except NotShownError:
            return None
        return own

    def _bounded(self, own: dict[str, Any], search: Search) -> dict[str, Any] | None:
        """The entry for hypotheses, with a bound that shows that level sets are bounded."""
        for bound, factor in product(BOUNDS, FACTORS):
            hypotheses = {**own, "everywhere": True, bound: str(factor)}
            with suppress(NotShownError):
                SampledProofs().entry(self.subject, "lyapunov", hypotheses)
                return search.entry(self.subject, "lyapunov", hypotheses)[0]
        return None
