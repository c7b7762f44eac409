"""Evidence by the first terms at the point, in any number of states: no equilibrium, and linearizations.

*No equilibrium*: a direction with which all velocities at the point have a positive product, by a linear program.
*Linearization*: where all fields vanish at the point with one Jacobian A, ``V = x^T P x`` with
``(A - mu I)^T P + P (A - mu I) = -I`` has ``V' = 2 mu V - |x|^2`` up to higher order.  For mu = 0 and a Hurwitz A it is
a Lyapunov function; for mu >= 0 between real parts of eigenvalues it falls where ``V <= 0``, which has inner points.
Floats propose, the theorem's own claims decide on a small cube.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from contextlib import suppress
from fractions import Fraction
from typing import TypeAlias

import numpy as np
from flint import fmpq_mat, fmpq_poly

from nonsmooth.proofs.checker.cells import System
from nonsmooth.proofs.checker.polynomials import Coefficient, Polynomial, constant, variable
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import least_sum
from nonsmooth.proofs.kernel.cells import (
    BeyondReachError,
    StatedCells,
    build_inclusion,
    sharpened,
    started,
    stated_cells,
)
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search, directed_hypotheses, stability_hypotheses
from nonsmooth.proofs.kernel.written import formula_text, null_basis, rational_slopes, slopes
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.plane_arrays import Floats, max_norm
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Field: TypeAlias = tuple[Polynomial, ...]

RADII = tuple(Fraction(1, 4**k) for k in range(7))  # half-widths of cubes, over that of the scene
DENOMINATORS = (1 << 5, 1 << 10, 1 << 20)  # of what floats propose, tried in turn
MIDDLE = 3 / 8  # where mu lies between real parts: in the middle itself two eigenvalues of A - mu I may add to zero
TIE, RELATIVE_TIE = 2.0**-20, 2.0**-32  # below which two eigenvalues of A - mu I add to zero; and times the norm of A


def show_departure_of(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence that the checked point is no equilibrium.

    Args:
        system: in any number of states.
        verdict: unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where 0 is a mixture of the velocities there, or that is not known.
        BeyondReachError: for too many surfaces or cells.
    """
    subject, search = started(system, search, irrational=True)
    for share in RADII:
        stated = _cells(system, share, subject, search)
        velocities = [[part.at_origin for part in field] for field in fields_around(stated, subject.stated, search)]
        direction = leading_direction(np.array(velocities, dtype=float))
        if direction is None:
            continue
        for denominator in DENOMINATORS:
            short = [str(Fraction(float(x)).limit_denominator(denominator)) for x in direction]
            try:
                return search.entry(subject, "departure", {"cells": stated.record, "direction": short})
            except NotShownError:
                continue
    raise NotShownError("no direction was found in which all velocities at the point lead")


def _cells(system: SwitchedSystem, share: Fraction, subject: System, search: Search) -> StatedCells:
    return sharpened(stated_cells(system, system.check.radius * share, irrational=True), subject, search)


def fields_around(stated: StatedCells, subject: System, search: Search) -> list[Field]:
    """The fields of all cells whose closures may hold the point."""
    inclusion = build_inclusion(stated, subject, search)
    return [field for cell in inclusion.around() for _, field in cell.fields]


def leading_direction(velocities: Floats) -> Floats | None:
    """The shortest n, by the sum of absolute values, with ``n . v >= 1`` for all velocities, over its largest entry.

    Args:
        velocities: one row for each.

    Returns:
        None where there is none in floats.
    """
    scaled = velocities / max(max_norm(velocities), np.finfo(float).tiny)
    direction = least_sum(-scaled, -np.ones(len(scaled)), np.ones(velocities.shape[1]), None)
    return None if direction is None else np.asarray(direction / np.abs(direction).max())


# ---- linearization -------------------------------------------------------------------------------


def show_linearization_of(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence of a verdict by a quadratic V, where all fields vanish at the point with one Jacobian.

    Args:
        system: in any number of states; its right-hand sides may enclose the field.
        verdict: asymptotically stable, or unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where there is no such V, or it is not shown.
        BeyondReachError: for too many surfaces or cells.
    """
    subject, search = started(system, search, irrational=True)
    for share in RADII:
        stated = _cells(system, share, subject, search)
        jacobian = common_jacobian(fields_around(stated, subject, search))
        if jacobian is None:
            continue
        matrix = np.array(jacobian, dtype=float)
        for quadratic in quadratics(matrix, attracts=verdict == ASYMPTOTICALLY_STABLE):
            function = formula_text(quadratic, subject.states)
            with suppress(NotShownError):
                entry = search.tried(subject, *_written(stated, function, verdict, subject, search))
                if entry is not None:
                    return entry
    raise NotShownError("no quadratic function was found that shows it near the point")


def _written(stated: StatedCells, function: str, verdict: str, subject: System, search: Search) -> tuple[str, Record]:
    if verdict == ASYMPTOTICALLY_STABLE:
        return "lyapunov", stability_hypotheses(stated.record, function, verdict)
    return "instability", directed_hypotheses(subject, stated.record, function, search)


def common_jacobian(fields: Sequence[Field]) -> tuple[tuple[Coefficient, ...], ...] | None:
    """The one Jacobian of fields that vanish at the point; None where there is none."""
    jacobians = {tuple(tuple(slopes(part)) for part in field) for field in fields}
    if len(jacobians) != 1 or any(part.at_origin for field in fields for part in field):
        return None
    return jacobians.pop()


def first_terms_attract(system: SwitchedSystem, subject: System) -> bool:
    """Whether all fields at the point have one Jacobian, whose eigenvalues all have negative real parts, in floats."""
    try:
        stated = stated_cells(system, system.check.radius, irrational=True)
        jacobian = common_jacobian(fields_around(stated, subject, Search()))
        values = () if jacobian is None else np.linalg.eigvals(np.array(jacobian, dtype=float)).real
    except (BeyondReachError, NotShownError, OverflowError):  # many cells, others than the checker has, huge numbers
        return False
    return max(values, default=0.0) < -TIE


def quadratics(matrix: Floats, *, attracts: bool) -> Iterator[Polynomial]:
    """Proposals of V."""
    size = len(matrix)
    for mu in _shifts(matrix, attracts=attracts):
        solution = lyapunov_solution(matrix, mu, np.eye(size))
        if solution is not None:
            yield from (quadratic_form(solution, denominator) for denominator in DENOMINATORS)


def lyapunov_solution(matrix: Floats, mu: float, weight: Floats) -> Floats | None:
    """P with ``(A - mu I)^T P + P (A - mu I) = -R``, over its largest entry; None where it is not unique.

    Args:
        matrix: A.
        mu: a shift.
        weight: R, symmetric.
    """
    from scipy.linalg import solve_continuous_lyapunov

    values = np.linalg.eigvals(matrix) - mu
    if np.abs(values[:, None] + values[None, :]).min() < max(TIE, RELATIVE_TIE * math.hypot(*matrix.flat)):
        return None
    with warnings.catch_warnings():
        warnings.simplefilter("error", RuntimeWarning)  # of eigenvalues that are one, which floats spread
        try:
            solution = solve_continuous_lyapunov((matrix - mu * np.eye(len(matrix))).T, -weight)
        except RuntimeWarning:
            return None
    return (solution + solution.T) / np.abs(solution + solution.T).max()


def _shifts(matrix: Floats, *, attracts: bool) -> list[float]:
    """Zero for an A that is thought to be Hurwitz; else mu between real parts, the largest one positive."""
    parts = sorted({round(float(value.real), 9) for value in np.linalg.eigvals(matrix)}, reverse=True)
    if attracts:
        return [0.0] if parts[0] < 0 else []
    lower = [max(below, 0.0) for below in [*parts[1:], 0.0]]
    return [low + MIDDLE * (high - low) for high, low in zip(parts, lower, strict=True) if high > low]


def quadratic_form(matrix: Floats, denominator: int) -> Polynomial:
    """``x^T M x`` with coefficients rounded to short fractions."""
    size = len(matrix)
    total = constant(size, 0)
    for i in range(size):
        for j in range(size):
            value = Fraction(float(matrix[i, j])).limit_denominator(denominator)
            total += variable(size, i) * variable(size, j, value)
    return total


def axis_factor(characteristic: fmpq_poly) -> fmpq_poly:
    """The factor with all roots of a characteristic polynomial whose opposites are roots, as of imaginary ones."""
    mirrored = fmpq_poly([c if k % 2 == 0 else -c for k, c in enumerate(characteristic.coeffs())])
    return characteristic.gcd(mirrored)


def neutral_subspace(field: Sequence[Polynomial]) -> tuple[Polynomial, ...] | None:
    """The states as forms of coordinates of the subspace of the imaginary eigenvalues; None without these."""
    count = len(field)
    matrix = fmpq_mat([rational_slopes(part) for part in field])
    on_axis = axis_factor(matrix.charpoly())
    if any(part.at_origin for part in field) or not on_axis.degree():
        return None
    value = fmpq_mat(count, count)
    for factor in reversed(on_axis.coeffs()):
        value = value * matrix + fmpq_mat([[factor * int(i == j) for j in range(count)] for i in range(count)])
    basis = null_basis(value)
    size, rows = basis.ncols(), [list(map(as_fraction, row)) for row in basis.tolist()]
    return tuple(sum((variable(size, j, x) for j, x in enumerate(row)), constant(size, 0)) for row in rows)
