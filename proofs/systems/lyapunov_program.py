"""Linear programs that propose the coefficients of a V from rows ``r . c > 0``.

A program maximizes the margin m with ``r . c >= m`` for every row (rows have size one) and ``|c_k| <= 1``.  Functions
with small coefficients are then left out and the program is solved again, so that what V does not need is exactly zero
and the formula is short; rows are scaled anew, because what is left out no longer counts for their size.  (HiGHS; what
comes out is a proposal.)
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np

from nonsmooth.proofs.systems.lyapunov_rows import Floats, normalized

DENOMINATORS = (2, 8, 64, 4096)  # of the rounded coefficients, tried in turn
LEAST_MARGIN = 2.0**-24  # below that nothing is proposed: floats could not tell it from zero
NEGLIGIBLE = (2.0**-2, 2.0**-4, 2.0**-6)  # of the largest coefficient: what is left out, at first more

Coefficients = tuple[Fraction, ...]


def propose(rows: Floats) -> Iterator[Coefficients]:
    """Rounded coefficients that satisfy all rows in floats, short sums first; nothing where there are none."""
    everything = list(range(rows.shape[1]))
    widest = _kept_margin(rows, everything)
    if widest is None:
        return
    seen: set[Coefficients] = set()
    for chosen in (*(_pruned(rows, widest, share) for share in NEGLIGIBLE), widest):
        rounded = None if chosen is None else _rounded(rows, chosen)
        if rounded is not None and rounded not in seen:
            seen.add(rounded)
            yield rounded


def _pruned(rows: Floats, coefficients: Floats, share: float) -> Floats | None:
    """The best coefficients without the small ones, again and again; None where none are left that serve."""
    while True:
        kept = np.flatnonzero(np.abs(coefficients) >= share * np.abs(coefficients).max())
        if len(kept) == np.count_nonzero(coefficients):
            return coefficients
        found = _kept_margin(rows, kept.tolist())
        if found is None:
            return None
        coefficients = found


def _kept_margin(rows: Floats, kept: Sequence[int]) -> Floats | None:
    """The coefficients of the functions that are kept, zero for the others; None without a margin, or beyond floats."""
    used = normalized(rows[:, kept])
    if len(used) < len(rows) or not len(rows):
        return None  # where all functions vanish, so does V or its derivative
    found = largest_margin(used, used[:0], LEAST_MARGIN)
    if found is None:
        return None
    coefficients = np.zeros(rows.shape[1])
    coefficients[list(kept)] = found
    return coefficients


def largest_margin(positive: Floats, weak: Floats, least: float) -> Floats | None:
    """Coefficients c, at most 1 in size, with the largest m such that ``r . c >= m`` for some rows, >= 0 for others.

    Args:
        positive: the rows with the margin.
        weak: those without.
        least: a margin below which nothing is proposed.

    Returns:
        None without such a margin, and for rows beyond floats.
    """
    from scipy.optimize import linprog

    if not (np.isfinite(positive).all() and np.isfinite(weak).all()):
        return None
    count = positive.shape[1]
    costs = np.zeros(count + 1)
    costs[-1] = -1.0
    system = np.hstack([-np.vstack([positive, weak]), np.repeat([[1.0], [0.0]], [len(positive), len(weak)], axis=0)])
    bounds = [(-1, 1)] * count + [(0, 1)]
    found = linprog(costs, A_ub=system, b_ub=np.zeros(len(system)), bounds=bounds, method="highs")
    return np.asarray(found.x[:-1]) if found.status == 0 and found.x[-1] > least else None


def _rounded(rows: Floats, coefficients: Floats) -> Coefficients | None:
    """Coefficients over the largest of them, with the first denominators that keep all rows."""
    scaled = coefficients / np.abs(coefficients).max()
    for denominator in DENOMINATORS:
        rounded = tuple(Fraction(float(c)).limit_denominator(denominator) for c in scaled)
        if np.all(rows @ np.array([float(c) for c in rounded]) > 0):
            return rounded
    return None
