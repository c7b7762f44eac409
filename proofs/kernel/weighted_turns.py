"""Functions V and W of two states where leading terms with weights decide: twisting, relays under inertia and the like.

Let F and G be linear forms, F of twice the weight of G: ``x' = y``, ``y' = -a sign(x) - b sign(y)`` has ``F = x`` and
``G = y``.  On every cell V is a combination of F and ``G**2``, and W one of ``F G`` and ``G**3``, continuous across the
surfaces.  Linear programs in floats find a V that does not rise, which it cannot do better where ``G = 0``, because its
derivative has a factor G there; and then a W that rises where V does not fall, so that no solution stays there.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import permutations
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq, fmpq_mat
from scipy.optimize import linprog

from nonsmooth.proofs.checker.cells import Inclusion, pattern
from nonsmooth.proofs.checker.polynomials import lie_derivative
from nonsmooth.proofs.checker.theorems import ASYMPTOTICALLY_STABLE, STABLE, UNSTABLE, Statement
from nonsmooth.proofs.kernel.curved_cells import build_inclusion, sharpened, started
from nonsmooth.proofs.kernel.samples import Floats, values_at
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.kernel.second_function import Chains
from nonsmooth.proofs.kernel.sign_cells import rational
from nonsmooth.proofs.kernel.stated_cells import StatedCells, scaled, stated_cells
from nonsmooth.proofs.systems.tangent_fan import form_lines, lowest_form
from nonsmooth.symbolic.numbers.polynomial import Polynomial as Form
from nonsmooth.symbolic.switched_system import SwitchedSystem

Record: TypeAlias = dict[str, Any]

RADII = tuple(Fraction(1, 4**k) for k in range(1, 4))  # half-widths of cubes, over that of the scene
DENOMINATORS = (1 << 2, 1 << 5, 1 << 9)  # of the coefficients, tried in turn
ANGLES, DISTANCES = 96, (0.7, 0.4, 0.15, 0.05)  # of the points at which the functions are looked at, with weights
LEAST = 1 / 16  # of V at these points, over its largest term there
MOST_FALL = 8.0  # the largest kappa
SLACK = 2.0**-23  # by which V may rise in floats, over its largest term there


@dataclass(frozen=True)
class WeightedFrame:
    """Two linear forms, and cells on which functions are taken.

    Attributes:
        heavy: F.
        light: G.
        stated: the cells of a cube.
        inclusion: the same as the checker has them, with the functions F, G^2, F G and G^3.
    """

    heavy: Form
    light: Form
    stated: StatedCells
    inclusion: Inclusion

    @property
    def count(self) -> int:
        """The number of coefficients of a function: two on each cell."""
        return 2 * len(self.inclusion.cells)

    @property
    def rests(self) -> bool:
        """Whether F has the derivative zero at the point along all fields."""
        around = self.inclusion.around()
        return not any(lie_derivative(c.functions[0], field).at_origin for c in around for _, field in c.fields)


def show_by_weights(
    system: SwitchedSystem, verdict: str, search: Search | None = None
) -> tuple[Record, list[Statement]]:
    """Evidence of a verdict by V and W, where one linear form has twice the weight of another.

    Args:
        system: in two states.
        verdict: asymptotically stable, or unstable.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for irrational numbers, and for too many surfaces or cells.
    """
    subject, search = started(system, search)
    for heavy, light in _frames(system) if verdict != STABLE else ():
        texts = (f"({heavy})", f"({light})**2", f"({heavy})*({light})", f"({light})**3")
        for share in RADII:
            stated = stated_cells(system, system.check.radius * share, (heavy, light))
            stated = sharpened(stated, subject, search)
            frame = WeightedFrame(heavy, light, stated, build_inclusion(stated, subject, search, texts))
            functions = _functions(frame, verdict) if frame.rests else None
            if functions is None:
                break
            for denominator in DENOMINATORS:
                first = _written(frame, _rounded(frame, functions[0], denominator, second=False), texts[:2])
                second = _written(frame, _rounded(frame, functions[1], denominator, second=True), texts[2:])
                below = Fraction(0) if verdict == UNSTABLE else None
                rising = Chains(subject, stated.record, first, search, below).extended([second])
                if rising is None:
                    continue
                try:
                    return search.entry(subject, *_hypotheses(stated, first, rising, verdict))
                except NotShownError:
                    continue
    raise NotShownError("no pair of functions was found for leading terms with weights")


def _frames(system: SwitchedSystem) -> Iterator[tuple[Form, Form]]:
    """Pairs of lines through the point: tangents of switching curves, and the axes."""
    states = system.displaced(system.states)
    lines = [own - centre for own, centre in zip(states, system.check.equilibrium, strict=True)]
    for surface in system.surfaces(states):
        if surface.degree and (0, 0) not in surface.terms:
            lines += [own for own in form_lines(lowest_form(surface)) or [] if scaled(own) not in map(scaled, lines)]
    yield from permutations(lines, 2)


# ---- the linear programs -------------------------------------------------------------------------


def _functions(frame: WeightedFrame, verdict: str) -> tuple[Floats, Floats] | None:
    """Coefficients of V, positive or, for an unstable point, negative, and of W; None where there are none."""
    places = _points(frame)
    above, falling, rising, sizes = _rows(frame, places)
    side = -1.0 if verdict == UNSTABLE else 1.0
    ties = _floats(frame, second=False)
    limits = np.concatenate([np.full(len(above), -LEAST), np.zeros(len(falling))])
    table = np.vstack([-side * _relative(above), _relative(falling)])
    margin = np.concatenate([np.zeros(len(above)), np.ones(len(falling))])
    mean = _relative(falling).mean(axis=0)
    first = _solved(np.column_stack([table, margin]), limits, ties, mean, low=-SLACK)
    if first is None:
        return None
    # W' >= kappa V' r + margin: nothing is asked of W where V falls.
    size = np.abs(rising).max(axis=1)
    table = np.column_stack([-rising, falling @ first * sizes, size])
    ties = _floats(frame, second=True)
    second = _solved(table, np.zeros(len(table)), ties, np.zeros(frame.count), low=SLACK, free=1)
    return None if second is None else (first, second)


def _floats(frame: WeightedFrame, *, second: bool) -> Floats:
    return np.array([list(map(float, row)) for row in _ties(frame, second=second)]).reshape(-1, frame.count)


def _solved(table: Floats, limits: Floats, ties: Floats, prices: Floats, *, low: float, free: int = 0) -> Floats | None:
    """Coefficients with the largest margin, the last variable, over the largest of them; None where there are none.

    Args:
        table: rows of coefficients, further positive variables, and the margin.
        limits: upper bounds of the rows.
        ties: rows of coefficients that add to zero.
        prices: of the coefficients; the margin is worth one.
        low: the least margin.
        free: how many further variables there are.
    """
    count = table.shape[1] - 1 - free
    bounds = [(-1.0, 1.0)] * count + [(0.0, MOST_FALL)] * free + [(low, 1.0)]
    padded = np.column_stack([ties, np.zeros((len(ties), free + 1))])
    price = np.concatenate([prices, np.zeros(free), [-1.0]])
    found = linprog(price, table, limits, padded, np.zeros(len(ties)), bounds=bounds)
    if not found.success or not np.abs(found.x[:count]).max() > SLACK:
        return None
    return np.asarray(found.x[:count] / np.abs(found.x[:count]).max())


def _rows(frame: WeightedFrame, points: Floats) -> tuple[Floats, Floats, Floats, Floats]:
    """Values of V and V', W' as linear functions of the coefficients, one row for each point of a cell and its field.

    The last column is the distance of the point by weights.
    """
    above: list[Floats] = []
    falling: list[Floats] = []
    rising: list[Floats] = []
    sizes: list[Floats] = []
    listed = frame.inclusion.surfaces.listed
    signs = np.stack([values_at(own, points)[0] > 0 for own in listed], axis=1)
    for k, cell in enumerate(frame.inclusion.cells):
        inside = points[(signs == (np.array(cell.signs) > 0)).all(axis=1)]
        values = [values_at(own, inside)[0] for own in cell.functions]
        for _, field in cell.fields:
            rates = [values_at(lie_derivative(own, field), inside)[0] for own in cell.functions]
            for rows, columns in ((above, values[:2]), (falling, rates[:2]), (rising, rates[2:])):
                row = np.zeros((len(inside), frame.count))
                row[:, 2 * k : 2 * k + 2] = np.stack(columns, axis=1)
                rows.append(row)
            sizes.append(np.sqrt(np.abs(values[0]) + values[1]))
    return np.vstack(above), np.vstack(falling), np.vstack(rising), np.concatenate(sizes)


def _points(frame: WeightedFrame) -> Floats:
    """Points of the cube on weighted circles ``F = r^2 cos, G = r sin``, in units of its half-width."""
    half = float(frame.inclusion.domain.radius)
    matrix = np.array([[float(own.slope(k)) for k in range(2)] for own in _lines(frame)]) / half
    angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False) + 2.0**-10
    circles = []
    for distance in DISTANCES:
        radius = distance * half
        circles.append(np.stack([radius**2 * np.cos(angles), radius * np.sin(angles)], axis=1))
    points = np.vstack(circles) @ np.linalg.inv(matrix).T / half
    return np.asarray(points[(np.abs(points) <= 1).all(axis=1)])


def _lines(frame: WeightedFrame) -> Sequence[Any]:
    """F and G as the checker has them, up to a factor."""
    listed = frame.inclusion.surfaces.listed
    texts = list(map(scaled, frame.stated.surfaces))
    return [listed[texts.index(scaled(own))] for own in (frame.heavy, frame.light)]


def _ties(frame: WeightedFrame, *, second: bool) -> Iterator[list[fmpq]]:
    """Rows of coefficients that add to zero: functions of cells with one other sign agree on that surface.

    ``a F + b G^2`` is a multiple of ``k F + c G^2`` where ``c a = k b``, and of G where ``a = 0``; times G always.
    """
    places = {cell.signs: k for k, cell in enumerate(frame.inclusion.cells)}
    for signs, k in places.items():
        for j, surface in enumerate(frame.stated.surfaces):
            other = places.get((*signs[:j], -signs[j], *signs[j + 1 :]))
            if signs[j] < 0 or other is None:
                continue
            for a, b in _relations(frame, surface, second=second):
                row = [fmpq(0)] * frame.count
                row[2 * k : 2 * k + 2], row[2 * other : 2 * other + 2] = [a, b], [-a, -b]
                yield row


def _relations(frame: WeightedFrame, surface: Form, *, second: bool) -> list[tuple[fmpq, fmpq]]:
    """Factors of a and b that add to zero where ``a F + b G^2``, for W times G, is a multiple of a surface."""
    if scaled(surface) == scaled(frame.light):
        return [] if second else [(fmpq(1), fmpq(0))]
    square, line = frame.light * frame.light, lowest_form(surface)
    rest, key, top = surface - line, max(square.terms), max(frame.heavy.terms)
    k, c = (own.terms.get(at, own.field.zero) * form.terms[at].inverse()
            for own, at, form in ((line, top, frame.heavy), (rest, key, square)))  # fmt: skip
    if (0, 0) not in surface.terms and line == frame.heavy * k and rest == square * c:
        return [(rational(c), -rational(k))]
    return [(fmpq(1), fmpq(0)), (fmpq(0), fmpq(1))]


def _relative(rows: Floats) -> Floats:
    """Each row divided by its largest entry."""
    return np.asarray(rows / np.maximum(np.abs(rows).max(axis=1, keepdims=True), np.finfo(float).tiny))


# ---- the theorem ---------------------------------------------------------------------------------


def _written(frame: WeightedFrame, coefficients: Sequence[fmpq], texts: Sequence[str]) -> list[list[str]]:
    """A function as a formula for each cell."""
    pieces = []
    for k, cell in enumerate(frame.inclusion.cells):
        own = coefficients[2 * k : 2 * k + 2]
        pieces.append([pattern(cell.signs), " + ".join(f"{c}*{text}" for c, text in zip(own, texts, strict=True))])
    return pieces


def _rounded(frame: WeightedFrame, values: Floats, denominator: int, *, second: bool) -> list[fmpq]:
    """Short fractions near the coefficients of a function that is continuous: some are rounded, the others follow."""
    short = [Fraction(float(value)).limit_denominator(denominator) for value in values]
    found = [fmpq(value.numerator, value.denominator) for value in short]
    rows = list(_ties(frame, second=second))
    if not rows:
        return found
    reduced, rank = fmpq_mat(rows).rref()
    for i in range(rank):
        row = [reduced[i, j] for j in range(frame.count)]
        pivot = next(j for j, value in enumerate(row) if value)
        found[pivot] = -sum((row[j] * found[j] for j in range(pivot + 1, frame.count)), fmpq(0))
    return found


def _hypotheses(stated: StatedCells, first: Any, second: Record, verdict: str) -> tuple[str, Record]:
    common = {"cells": stated.record, "function": first, "second": second}
    if verdict == ASYMPTOTICALLY_STABLE:
        more = {"verdict": verdict, "everywhere": False, "level": None, "below": False, "rate": None}
        return "lyapunov", {**common, **more}
    return "instability", {**common, "direction": ["3", "7"]}
