"""A V that begins with an energy which the first terms of the field keep, and of which the next terms decide.

Give the states weights: 1 and 1, or 2 and 1 as ``h' = l, l' = -c sign(h)`` has with the energy ``c |h| + l^2/2``.  V is
a sum of monomials, and of these times ``|s|``, s a surface through the point, of weights 2 to ``q + 1``.  All terms of
V' of weights below q must vanish, which is a linear system, solved exactly.  Those of weight q must fall on every cell,
which a linear program proposes by samples: then V' < 0 near the point.

*Weak foci.*  To first order in the amplitude the energy changes over a full turn by the integral of its rate over the
angle, which is the first focal value of the focus.  Further terms of V take from that rate what changes in a turn and
comes back; where the field has bends or jumps they bend too.  So of ``x' = -y - x |x|, y' = x + y |y|/2`` it is known
who wins.  Where V bends on the surfaces of the field alone, the pieces may be too stiff to follow the rate: then it
bends on the axes and diagonals, too.

The checker's claims about V, on small squares, show what is proposed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import partial
from itertools import chain
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.polynomials import Polynomial as CheckedPolynomial
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.kernel.bases import PiecewiseFunction, bent, formula_text, values
from nonsmooth.proofs.kernel.cells import BeyondReachError, monic, started, stated_cells
from nonsmooth.proofs.kernel.quotients import coefficients_of, proposed, values_inside
from nonsmooth.proofs.kernel.search import (
    Entry,
    Functions,
    NotShownError,
    Search,
    directed_hypotheses,
    stability_hypotheses,
)
from nonsmooth.proofs.kernel.written import vanishing_columns
from nonsmooth.proofs.sums_of_squares.ansatz import monomials_of
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane_arrays import Floats, unit_vectors
from nonsmooth.symbolic.numbers.polynomial import Exponents, Polynomial, written_powers
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Weights: TypeAlias = tuple[int, int]

WEIGHTS: tuple[Weights, ...] = ((1, 1), (2, 1), (1, 2))
DECIDING = (3, 4)  # q, tried in turn
SHARES = tuple(Fraction(1, 4**k) for k in range(4))  # of the checked square
ANGLES, SMALL = 256, 2.0**-8  # how many samples there are, and their size
WORK = 2_000  # coefficients looked at for one claim


class SuggestedEnergy(NamedTuple):
    """A V that falls near the point, as far as samples tell.

    Attributes:
        function: as a formula.
        positive: whether it is positive near the point; it is negative somewhere otherwise.
    """

    function: str
    positive: bool


def find_by_next_terms(system: SwitchedSystem) -> Entry | None:
    """The entry of a certificate that shows that the point attracts, or is unstable; None where neither is found.

    Args:
        system: in two states, with rational numbers.
    """
    if system.by_roots is not None:
        return None
    with suppress(BeyondReachError, NotShownError, RejectedError, SceneError):
        subject, _ = started(system)
        for weights in WEIGHTS:
            for bends in _bends(system, weights):
                first = stated_cells(system, system.check.radius, bends).record
                for energy in _proposals(subject, first, bends, weights):
                    squares = (stated_cells(system, system.check.radius * share, bends).record for share in SHARES)
                    entry = next(filter(None, (_shown(subject, cells, energy) for cells in squares)), None)
                    if entry is not None:
                        return entry
    return None


def _bends(system: SwitchedSystem, weights: Weights) -> Iterator[tuple[Polynomial, ...]]:
    """The surfaces on which V bends: those of the field through the point and a heavy axis, then more of weight one."""
    x, y = system.coordinates()
    surfaces = [surface for surface in system.surfaces(system.displaced(system.states)) if not surface.at_origin]
    heavy = [axis for axis, weight in zip((x, y), weights, strict=True) if weight > 1]
    yield _each_once([*surfaces, *heavy])
    if not heavy:
        yield _each_once([*surfaces, x, y, x + y, x - y])


def _each_once(surfaces: Sequence[Polynomial]) -> tuple[Polynomial, ...]:
    return tuple({monic(surface): surface for surface in surfaces}.values())


def _proposals(
    subject: System, cells: Record, bends: Sequence[Polynomial], weights: Weights
) -> Iterator[SuggestedEnergy]:
    """Sums whose derivatives have no terms below a weight, and fall by those of it."""
    points = _samples(weights)
    for q in DECIDING:
        basis = list(_basis(subject.states, bends, weights, q + 1))
        functions = Functions(subject, {**cells, "empty": []}, [function.text for function in basis])
        claims = [functions.claims_on_cells(k) for k in range(len(basis))]
        null_space = vanishing_columns([_terms_below(of_function, weights, q) for of_function in claims])
        if not null_space.ncols():
            continue
        deciding = partial(_part, weights=weights, wanted=range(q, q + 1))
        places = ((same, k) for same in zip(*claims, strict=True) for k in range(len(same[0].inequalities)))
        rows = np.vstack([values_inside(same, k, points, deciding) for same, k in places])
        for chosen in proposed(rows @ np.array(null_space.tolist(), dtype=float)):
            coefficients = coefficients_of(null_space, chosen)
            near = values(functions, lambda _: points)[1] @ np.array(coefficients, dtype=float)
            yield SuggestedEnergy(formula_text(basis, coefficients), positive=bool(near.min() > 0))


def _basis(
    states: Sequence[str], bends: Sequence[Polynomial], weights: Weights, most: int
) -> Iterator[PiecewiseFunction]:
    """Monomials, and these times the absolute values of surfaces, of weights 2 to a largest one."""
    factors = [(0, ""), *((min(_weight(exponents, weights) for exponents in s.terms), bent(s).text) for s in bends)]
    for least, factor in factors:
        for exponents in chain.from_iterable(monomials_of(len(states), degree) for degree in range(most + 1)):
            weight = least + _weight(exponents, weights)
            if 2 <= weight <= most:
                yield PiecewiseFunction("*".join(filter(None, [factor, *written_powers(states, exponents)])), weight)


def _weight(exponents: Exponents, weights: Weights) -> int:
    return sum(e * weight for e, weight in zip(exponents, weights, strict=True))


def _part(terms: Mapping[Exponents, Any], weights: Weights, wanted: range) -> dict[Exponents, Any]:
    """The terms of some weights."""
    return {exponents: c for exponents, c in terms.items() if _weight(exponents, weights) in wanted}


def _terms_below(claims: Sequence[Claim], weights: Weights, weight: int) -> list[CheckedPolynomial]:
    """Those of lower weight in the derivatives on all cells."""
    rates = [inequality.value for claim in claims for inequality in claim.inequalities]
    return [CheckedPolynomial(rate.count, _part(rate.terms, weights, range(weight))) for rate in rates]


def _samples(weights: Weights) -> Floats:
    """Small points in all directions of weight."""
    angles = np.linspace(0, 2 * np.pi, ANGLES, endpoint=False) + 0.01
    return unit_vectors(angles) * SMALL ** np.array(weights)


def _shown(subject: System, cells: Record, proposal: SuggestedEnergy) -> Entry | None:
    """What a V shows: that the point attracts, or, where it is negative somewhere, that it is unstable."""
    search = Search(WORK)
    if proposal.positive:
        hypotheses = stability_hypotheses(cells, proposal.function, ASYMPTOTICALLY_STABLE)
        return search.tried(subject, "lyapunov", hypotheses)
    with suppress(NotShownError):
        hypotheses = directed_hypotheses(subject, cells, proposal.function, search)
        return search.tried(subject, "instability", hypotheses)
    return None
