"""Deriving contact states: the twists of row triples, against the exact ones.

The program solves three rows by cofactors over the scene's own number field.  Written down naively the same is SymPy's
``LUsolve`` with ``simplify``; in ball arithmetic (python-flint) it is a solve at a number of bits, each of which halves
the radius: slope 1 in ``2^-bits``; in floats it is NumPy's.  Floats and balls cannot tell a singular triple from a
nearly singular one, so only triples that are known to be regular are solved here.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import combinations, islice
from typing import Any, TypeAlias

import numpy as np
import sympy
from flint import arb, arb_mat, ctx

from nonsmooth.analysis.measurements.harness import Study
from nonsmooth.analysis.measurements.study_plan import Assessment, LeftOut, Order, StudyPlan, Trial
from nonsmooth.analysis.measurements.timing import Clock
from nonsmooth.symbolic.constraints import Row, scene_rows
from nonsmooth.symbolic.contact_states import ContactState, solve_rows
from nonsmooth.symbolic.scene import Scene

RowTriple: TypeAlias = tuple[Row, Row, Row]
Exact: TypeAlias = tuple[Any, ...]

TRIPLES = 40  # of an array, evenly spread over all of them: four wheels have no more regular ones
BITS = (53, 80, 107, 134, 161)
PRECISION = 320  # bits of the reference, 96 digits
DIGITS = 60  # of SymPy's answers; they are compared with the exact ones to as many
SAME = arb(10) ** -DIGITS
HALVED = Order(1.0, "every bit halves the radius of the balls")


def build_derivation(scene: Scene) -> StudyPlan:
    """The plan for a sample of the array's regular triples.

    Raises:
        LeftOut: for an array without regular triples.
    """
    sample = _sample(scene)
    if not sample:
        raise LeftOut("no three rows of the array are independent")
    triples = [triple for triple, _ in sample]
    with ctx.workprec(PRECISION):
        exact = [tuple(entry.ball() for entry in state.twist) for _, state in sample]
    trials = [
        Trial("number field, cofactors", partial(_by_field, triples), partial(_judge_residuals, triples)),
        Trial("SymPy, LUsolve and simplify", partial(_by_sympy, triples), partial(_judge_symbols, exact)),
        Trial("NumPy, floats", partial(_by_numpy, triples), partial(_judge, exact)),
    ]
    for bits in BITS:
        work = partial(_by_balls, triples, bits)
        trials.append(Trial("balls", work, partial(_judge, exact), "unit roundoff", 2.0**-bits))
    reference = f"exact twists of {len(triples)} regular row triples, each put back into its rows"
    return StudyPlan(reference, tuple(trials), {"balls": HALVED}, rounding=10.0**-DIGITS)


DERIVATION = Study(
    "derivation", "derivation: largest error of a twist", "twist error [length/time, rad/time]", build_derivation
)


def _sample(scene: Scene) -> list[tuple[RowTriple, ContactState]]:
    """Regular triples, evenly spread over all in lexicographic order."""
    rows = scene_rows(scene)
    total = len(rows) * (len(rows) - 1) * (len(rows) - 2) // 6
    every = max(1, total // (3 * TRIPLES // 2))  # a third of them may be singular
    solved = ((triple, solve_rows(triple)) for triple in islice(combinations(rows, 3), 0, None, every))
    return list(islice(((triple, state) for triple, state in solved if state is not None), TRIPLES))


# ---- methods -------------------------------------------------------------------------------------


def _by_field(triples: Sequence[RowTriple], clock: Clock) -> list[ContactState | None]:
    return [solve_rows(rows) for rows in triples]


def _by_sympy(triples: Sequence[RowTriple], clock: Clock) -> list[sympy.Matrix]:
    sympy.core.cache.clear_cache()  # every run pays for itself
    found = []
    for rows in triples:
        clock.check()
        matrix = sympy.Matrix([[entry.to_sympy() for entry in row.normal] for row in rows])
        found.append(sympy.simplify(matrix.LUsolve(sympy.Matrix([row.rhs.to_sympy() for row in rows]))))
    return found


def _by_numpy(triples: Sequence[RowTriple], clock: Clock) -> list[list[float]]:
    matrices = np.array([[[float(entry) for entry in row.normal] for row in rows] for rows in triples])
    right = np.array([[float(row.rhs) for row in rows] for rows in triples])
    found: list[list[float]] = np.linalg.solve(matrices, right[..., None])[..., 0].tolist()
    return found


def _by_balls(triples: Sequence[RowTriple], bits: int, clock: Clock) -> list[Exact]:
    found: list[Exact] = []
    with ctx.workprec(bits):
        for rows in triples:
            matrix = arb_mat([[entry.ball() for entry in row.normal] for row in rows])
            found.append(tuple(matrix.solve(arb_mat([[row.rhs.ball()] for row in rows])).entries()))
    return found


# ---- errors --------------------------------------------------------------------------------------


def _judge(exact: Sequence[Exact], found: Sequence[Exact]) -> Assessment:
    """Largest distance of an entry's middle from the exact value."""
    with ctx.workprec(PRECISION):
        gaps = [
            abs(a - (b.mid() if isinstance(b, arb) else arb(b)))
            for right, mine in zip(exact, found, strict=True)
            for a, b in zip(right, mine, strict=True)
        ]
        return Assessment(max(float(gap.mid()) for gap in gaps), work={"triples": len(found)})


def _judge_symbols(exact: Sequence[Exact], found: Sequence[sympy.Matrix]) -> Assessment:
    """SymPy's answers are exact or wrong: what agrees to :data:`DIGITS` digits is called equal."""
    with ctx.workprec(PRECISION):
        gaps = [
            abs(a - arb(str(b.evalf(DIGITS + 10))))
            for right, mine in zip(exact, found, strict=True)
            for a, b in zip(right, mine, strict=True)
        ]
        error = max(0.0 if gap < SAME else float(gap.mid()) for gap in gaps)
    return Assessment(error, work={"triples": len(found)}, note=f"compared to {DIGITS} digits")


def _judge_residuals(triples: Sequence[RowTriple], found: Sequence[ContactState | None]) -> Assessment:
    """The twists put back into their rows: exactly zero, or wrong."""
    residuals = [
        abs(float(row.residual(state.twist)))
        for rows, state in zip(triples, found, strict=True)
        if state is not None
        for row in rows
    ]
    return Assessment(max(residuals), work={"triples": len(found)}, note="put back into their rows, exactly")
