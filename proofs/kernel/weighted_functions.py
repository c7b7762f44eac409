"""A V whose fall is decided by terms of weight: beside a relay that keeps an energy to first order.

Let one state h have the weight 2 and the other one, l, the weight 1, as ``h' = l, l' = -c sign(h)`` has with the energy
``c |h| + l^2/2``, which it keeps.  V is a sum of ``|h|^a h^b l^c`` of weights 2 to q + 1; all terms of V' of weights
below q must vanish, which is a linear system, solved exactly, and those of weight q fall on both sides, which a linear
program proposes by samples.  So terms are found that make ``-2 l^4`` of an energy definite: ``h |h| l`` has
``2 |h| l^2 - c h^2`` as its derivative.  The checker's claims about V, on small squares, show what they propose.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from itertools import permutations
from typing import Any

import numpy as np
from flint import fmpq_mat

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.positivity import Claim
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.checker.work import RejectedError
from nonsmooth.proofs.findings.exact_json import Record
from nonsmooth.proofs.kernel.cells import BeyondReachError, started, stated_cells, surfaces_of
from nonsmooth.proofs.kernel.quotients import coefficients_of, flint, proposed, values_inside
from nonsmooth.proofs.kernel.search import Entry, Functions, NotShownError, SampledProofs, Search, stability_hypotheses
from nonsmooth.proofs.kernel.written import null_basis
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

WEIGHTS = (3, 4)  # q, tried in turn
SHARES = (Fraction(1), Fraction(1, 4), Fraction(1, 16))  # of the checked square
SMALL, ANGLES = 2.0**-8, 64  # size of l at samples, and how many there are in each half
WORK = 2_000  # coefficients looked at for one claim
DIRECTIONS = ("1", "9"), ("9", "1"), ("-1", "9"), ("-9", "1")


def find_weighted_function(system: SwitchedSystem) -> Entry | None:
    """The entry of a certificate that shows that the point attracts, or is unstable; None where neither is found.

    Args:
        system: in two states, with rational numbers.
    """
    if system.by_roots is not None:
        return None
    try:
        subject, _ = started(system, None)
        for heavy, light in permutations(system.states):
            for q in WEIGHTS:
                functions = _functions(heavy, light, q + 1)
                bent = surfaces_of(system, parse_piecewise(f"Abs({heavy})", system.states))
                squares = [stated_cells(system, system.check.radius * share, bent).record for share in SHARES]
                claims = _claims(subject, squares[0], functions)
                for function in _proposals(claims, functions, subject.states.index(heavy), q):
                    for cells in squares:
                        found = _shown(subject, cells, function)
                        if found is not None:
                            return found
    except (BeyondReachError, NotShownError, RejectedError, SceneError):
        return None
    return None


def _functions(heavy: str, light: str, most: int) -> list[str]:
    """Products of weights 2 to a largest one."""
    found = []
    for k in range(most // 2 + 1):
        power = f"*{heavy}**{k - 1}" if k > 1 else ""
        sides = [f"{heavy}{power}", f"Abs({heavy}){power}"] if k else [""]
        for left in range(max(2 - 2 * k, 0), most - 2 * k + 1):
            tail = [f"{light}**{left}"] if left else []
            found += ["*".join([*filter(None, [side]), *tail]) for side in sides]
    return found


def _claims(subject: System, cells: Record, functions: Sequence[str]) -> list[list[Claim]]:
    """That each function falls on each cell, in one order."""
    own = Functions(subject, {**cells, "empty": []}, functions)
    every = (own.claims(k, positive=False) for k in range(len(functions)))
    return [[claim for claim in claims if claim.name.startswith("cell")] for claims in every]


def _proposals(claims: Sequence[Sequence[Claim]], functions: Sequence[str], heavy: int, q: int) -> Iterator[str]:
    """Sums of the functions whose derivatives have no terms below a weight, and fall by those of it."""

    def part(terms: Any, low: int, high: int) -> dict[Any, Any]:
        return {e: c for e, c in terms.items() if low <= sum(e) + e[heavy] <= high}

    below = [[part(claim.inequalities[0].value.terms, 0, q - 1) for claim in own] for own in claims]
    places = sorted({(k, e) for own in below for k, terms in enumerate(own) for e in terms})
    table = [[flint(own[k].get(e, Fraction(0))) for own in below] for k, e in places]
    kept = null_basis(fmpq_mat(table)) if table else None
    if kept is None or not kept.ncols():
        return
    points = _samples(heavy)
    rows = [values_inside(same, 0, points, lambda terms: part(terms, q, q)) for same in zip(*claims, strict=True)]
    for chosen in proposed(np.vstack(rows) @ np.array(kept.tolist(), dtype=float)):
        pairs = zip(coefficients_of(kept, chosen), functions, strict=True)
        yield " + ".join(f"({c})*{own}" for c, own in pairs if c)


def _samples(heavy: int) -> Floats:
    """Small points in all directions of weight."""
    angles = np.linspace(0, 2 * np.pi, 2 * ANGLES, endpoint=False) + 0.01
    points = np.stack([np.cos(angles), np.sin(angles)], axis=1) * SMALL
    points[:, heavy] *= SMALL
    return points


def _shown(subject: System, cells: Record, function: str) -> Entry | None:
    """What a V shows: that the point attracts, or, where it is negative somewhere, that it is unstable."""
    attracts = stability_hypotheses(cells, function, ASYMPTOTICALLY_STABLE)
    leaves = {"cells": cells, "function": function, "second": None}
    ways = [("lyapunov", attracts), *(("instability", {**leaves, "direction": list(own)}) for own in DIRECTIONS)]
    for theorem, hypotheses in ways:
        with suppress(NotShownError):
            SampledProofs().entry(subject, theorem, hypotheses)
            return Search(WORK).entry(subject, theorem, hypotheses)
    return None
