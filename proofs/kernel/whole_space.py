"""Evidence that every solution of the whole space comes to the point: a V that falls everywhere and is proper.

Conditions on a V that hold on a cube about the point are asked again without the cube, and beside them that ``V + 1``
is at least a multiple of ``|x|^2``, or of each ``|x_k|``, so that the level sets of V are bounded.  Where V and the
field are forms on cones, the conditions on the cube say enough
(:func:`nonsmooth.proofs.checker.lyapunov.Lyapunov.require_all_of_space`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction
from itertools import chain, combinations, product
from math import lcm

from flint import fmpq

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.cells import (
    BeyondReachError,
    are_positive_everywhere,
    rational_terms,
    started,
    stated_cells,
    surfaces_of,
    without_signs,
)
from nonsmooth.proofs.kernel.first_terms import first_terms_attract
from nonsmooth.proofs.kernel.quotients import find_quotient
from nonsmooth.proofs.kernel.search import NotShownError, SampledProofs, Search, stability_hypotheses
from nonsmooth.proofs.kernel.second_function import find_second
from nonsmooth.proofs.sums_of_squares.ansatz import (
    Condition,
    build_blocks,
    gram_entries,
    monomials_between,
    without_idle,
)
from nonsmooth.proofs.sums_of_squares.conic_program import Problem, round_parameters, solve_inside
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.polynomial import Exponents, Terms, add_terms, multiply_terms, written_powers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem, with_known_numbers

# ---- proposals for a V that is positive and falls in the whole space -----------------------------
#
# Polynomials, and logarithms, by sums of squares.
#
# With fields f that are polynomials, of one cell, both are asked without a domain,
#
#     V  a sum of squares,    -grad V . f  a sum of squares for every f,
#
# which is affine in the coefficients of V (Parrilo 2000).  So is ``-(1 + P) grad Q . f - w grad P . f`` in those of Q
# and in w, for ``V = Q + w ln(1 + P)`` with a P that is known, the sum of the squares of some states, and Q a sum of
# squares and fourth powers of the others.  A field with products of states may have such a V and none that is a
# polynomial (Ahmadi, Krstic and Parrilo 2011).  Floats propose; what they propose is
# shown, or is not.


FEW = 3  # states of which all choices are tried
DENOMINATORS = (1 << 3, 1 << 6, 1 << 10)  # of coefficients, which lie between -1 and 1
MOST_UNKNOWNS = 3_000  # entries of Gram matrices


def global_functions(system: SwitchedSystem) -> Iterator[PiecewiseExpression]:
    """V in the displacement, one after the other; none where something switches."""
    for exponents in _bases(len(system.states)):
        yield from _proposed(system, exponents, {})


def logarithmic_functions(system: SwitchedSystem) -> Iterator[tuple[PiecewiseExpression, PiecewiseExpression]]:
    """Q/w and P in the displacement, one after the other; none where something switches."""
    count = len(system.states)
    squares, fourths = ([tuple(power * int(j == k) for j in range(count)) for k in range(count)] for power in (2, 4))
    for size in range(1, count) if count <= FEW else ():
        for chosen in combinations(range(count), size):
            within = [squares[k] for k in chosen]
            inside: Terms = {square: fmpq(1) for square in within}
            for powers in (squares, squares + fourths):
                exponents = [power for power in powers if not any(power[k] for k in chosen)]
                for formula in _proposed(system, exponents, inside):
                    yield formula, _formula(system.states, within, [fmpq(1)] * size)


def _proposed(system: SwitchedSystem, exponents: Sequence[Exponents], inside: Terms) -> Iterator[PiecewiseExpression]:
    """The sum of some monomials with coefficients that a solver in floats finds, rounded in several ways.

    Args:
        system: whose velocities are polynomials; of others nothing is proposed.
        exponents: of the monomials.
        inside: P of a logarithm beside them, over whose weight the sum is taken; empty without one.
    """
    try:
        fields = _fields(system)
    except (BeyondReachError, SceneError):
        return
    problems = _problems(fields, exponents, inside)
    if sum(gram_entries(blocks) for _, blocks in problems) > 2 * MOST_UNKNOWNS:
        return
    solved = solve_inside(problems, len(exponents) + bool(inside), bounded=True)
    for denominator in DENOMINATORS if solved is not None else ():
        coefficients = None if solved is None else round_parameters(*solved, denominator)
        if coefficients is None or not any(coefficients[: len(exponents)]):
            continue
        weight = coefficients[-1] if inside else fmpq(1)
        if weight > 0:
            yield _formula(
                system.states, exponents, [coefficient / weight for coefficient in coefficients[: len(exponents)]]
            )


def _fields(system: SwitchedSystem) -> list[list[Terms]]:
    """The right-hand sides as polynomials in the displacement from the point.

    Raises:
        BeyondReachError: where something switches, and for irrational numbers.
        SceneError: for a piece that is no polynomial.
    """
    places = system.displaced(system.states)
    return [
        [rational_terms(component) for component in member.velocity(without_signs, places)] for member in system.members
    ]


def _bases(count: int) -> Iterator[list[Exponents]]:
    """The monomials of V, tried in turn.

    Fields of odd degree leave no room for some of them: where others must be zero no rounding survives.  So few come
    first: squares, quadratic forms, these with powers of four of some states, and all up to degree 4.
    """
    linear = monomials_between(count, 1, 1)
    squares, fourths = ([tuple(power * e for e in exponents) for exponents in linear] for power in (2, 4))
    quadratic = monomials_between(count, 2, 2)
    yield squares
    yield list(quadratic)
    for size in range(1, count + 1) if count <= FEW else ():
        for chosen in combinations(fourths, size):
            yield [*quadratic, *chosen]
    yield [*quadratic, *monomials_between(count, 3, 4)]


def _problems(fields: Sequence[Sequence[Terms]], exponents: Sequence[Exponents], inside: Terms) -> list[Problem]:
    """That the sum is positive, and V falls along every field; the weight of a logarithm is the last unknown."""
    count = len(exponents[0])
    factor = add_terms({(0,) * count: fmpq(1)}, inside)
    conditions = [Condition({}, {k: {monomial: fmpq(1)} for k, monomial in enumerate(exponents)}, (), (), count)]
    for field in fields:
        falls = [multiply_terms(factor, _fall(monomial, field)) for monomial in exponents]
        weighed: Terms = {}
        for monomial, c in inside.items():
            weighed = add_terms(weighed, {e: c * value for e, value in _fall(monomial, field).items()})
        conditions.append(Condition({}, {k: fall for k, fall in enumerate([*falls, weighed]) if fall}, (), (), count))
    return [(condition, without_idle(build_blocks(condition), condition.support)) for condition in conditions]


def _fall(exponents: Exponents, field: Sequence[Terms]) -> Terms:
    """``-grad m . f`` of a monomial m."""
    total: Terms = {}
    for k, velocity in enumerate(field):
        if exponents[k]:
            slope = {(*exponents[:k], exponents[k] - 1, *exponents[k + 1 :]): fmpq(-exponents[k])}
            total = add_terms(total, multiply_terms(slope, velocity))
    return total


def _formula(
    states: Sequence[str], exponents: Sequence[Exponents], coefficients: Sequence[fmpq]
) -> PiecewiseExpression:
    """A polynomial times the common denominator of its coefficients."""
    whole = lcm(*(int(coefficient.q) for coefficient in coefficients))
    terms = []
    for powers, coefficient in zip(exponents, coefficients, strict=True):
        if coefficient:
            factors = "*".join(written_powers(states, powers))
            size = abs(int(coefficient * whole))
            terms.append(("-" if coefficient < 0 else "+") + (factors if size == 1 else f"{size}*{factors}"))
    return parse_piecewise("".join(terms).removeprefix("+"), tuple(states))


# ---- evidence ------------------------------------------------------------------------------------


BOUNDS = ("proper", "growth")  # |x|^2, and |x_k| for every k, tried in turn
FACTORS = (Fraction(1, 4), Fraction(1, 64))  # of each
WORK = 2_000  # coefficients looked at for one claim beside sums of squares


def find_global_attraction(
    system: SwitchedSystem,
    potentials: Iterable[PiecewiseExpression | None],
    energies: Iterable[PiecewiseExpression] = (),
) -> Record | None:
    """The entry of a certificate that shows that every solution comes to the point; None where none is found.

    A V that falls is looked for first, then one that does not rise with functions that show that nothing else stays on
    one level of it, and quotients last: these take longest.

    Args:
        system: in one state or more.  Right-hand sides that enclose sines are those of the checked square: of these
            nothing is shown, nor of those in roots of states, nor where a denominator is positive on the square alone.
        potentials: V in the displacement, tried in turn, before others that are searched.
        energies: further V, which need not fall.
    """
    if system.rewriting.waves or system.by_roots is not None or not are_positive_everywhere(system):
        return None
    rational = rational_subject(system)
    if rational is None:
        return None
    stated = [potential for potential in potentials if potential is not None]
    return next(filter(None, _attempts(*rational, stated, energies)), None)


def _attempts(
    system: SwitchedSystem,
    subject: System,
    potentials: Iterable[PiecewiseExpression],
    energies: Iterable[PiecewiseExpression],
) -> Iterator[Record | None]:
    """What each way shows, one after the other; None where it shows nothing."""
    space = WholeSpace(system, subject)
    for potential in chain(potentials, global_functions(system)):
        yield space.by_fall(potential)
    for potential, inside in logarithmic_functions(system):
        yield space.by_fall(potential, inside.text)
    for potential in chain(potentials, energies):
        yield space.by_rest(potential)
    if not first_terms_attract(system, subject):  # else a quadratic form serves near the point; quotients take longest
        quotient = find_quotient(system, everywhere=True)
        yield None if quotient is None else quotient[0]


def rational_subject(system: SwitchedSystem) -> tuple[SwitchedSystem, System] | None:
    """A system in rational numbers that encloses one, and what a certificate is about; None where there is none."""
    try:
        enclosing = with_known_numbers(system)
        return enclosing, started(enclosing)[0]
    except (BeyondReachError, NotShownError):  # among others an irrational point
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

    def by_fall(self, potential: PiecewiseExpression, logarithm: str = "") -> Record | None:
        """The entry for a V that falls; None where it is not shown.

        Args:
            potential: V, or what is beside the logarithm.
            logarithm: P, where V holds ``ln(1 + P)``.
        """
        hypotheses = self._unrefuted(potential, ASYMPTOTICALLY_STABLE, logarithm)
        return None if hypotheses is None else self._bounded(hypotheses, Search(WORK))

    def by_rest(self, potential: PiecewiseExpression) -> Record | None:
        """The entry for a V that does not rise, with functions that show that nothing else stays where it is kept."""
        hypotheses = self._unrefuted(potential, STABLE)
        if hypotheses is None:
            return None
        search = Search(WORK)
        second = find_second(self.subject, hypotheses["cells"], potential.text, search)
        if second is None:
            return None
        return self._bounded({**hypotheses, "verdict": ASYMPTOTICALLY_STABLE, "second": second}, search)

    def _unrefuted(self, potential: PiecewiseExpression, verdict: str, logarithm: str = "") -> Record | None:
        """The hypotheses for a verdict, where V was not asked before and no sample refutes it."""
        if (potential.text, verdict, logarithm) in self.asked:
            return None
        self.asked.add((potential.text, verdict, logarithm))
        try:
            cells = stated_cells(self.system, None, surfaces_of(self.system, potential)).record
        except BeyondReachError:
            return None
        hypotheses = stability_hypotheses(cells, potential.text, verdict) | (
            {"logarithm": logarithm} if logarithm else {}
        )
        try:
            SampledProofs().entry(self.subject, "lyapunov", hypotheses)
        except NotShownError:
            return None
        return hypotheses

    def _bounded(self, stated: Record, search: Search) -> Record | None:
        """The entry for hypotheses, with a bound that shows that level sets are bounded."""
        for bound, factor in product(BOUNDS, FACTORS):
            hypotheses = {**stated, "everywhere": True, bound: str(factor)}
            entry = search.tried(self.subject, "lyapunov", hypotheses)
            if entry is not None:
                return entry[0]
        return None
