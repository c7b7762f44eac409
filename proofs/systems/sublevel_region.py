"""The largest sublevel set ``V < c`` of a square that is certified to be a region of attraction, by bisection in c.

Solutions that start where ``V < c`` stay there and reach the equilibrium if V is at least c on the border of the square
and falls where ``V < c``.  On each side of the border V is a polynomial in one variable, which is decided exactly.  A V
that falls on the whole square needs nothing else.  For a V without bends that falls near the equilibrium only, the rate
is proved negative with the guard ``c - V``, factor by factor over Q; or along rays, where V is a quadratic form and the
rate has two homogeneous parts f and g: with ``f < 0``, and ``f + g <= 0`` on ``V = c``, it is negative where ``V < c``.

Just above the largest certified c a point refutes: on the border with V below it, or inside with ``V' >= 0``.  Floats
look for the latter on rays from the equilibrium, then on finer and finer grids about the best; exact arithmetic
confirms it.  One such point bounds all levels that can be certified, and spares the exact prover the search.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction
from typing import Any

import numpy as np
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import Region, Segment
from nonsmooth.analysis.cells.switched_cells import LyapunovCell
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof, prove
from nonsmooth.proofs.inequalities.real_roots import along_edge, positive_roots, samples_between, separated, trimmed
from nonsmooth.proofs.systems.lyapunov_rows import Floats, values_at
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression
from nonsmooth.symbolic.formulas.surfaces import factorize
from nonsmooth.symbolic.numbers.enclosures import DIGITS, short_below
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial

BISECTIONS = 12  # after the first one: the level is the largest up to a part in four thousand
SMALLEST = Fraction(1, 2**40)  # level that is looked for, of V's least value at ends of edges of the border
MOST_OPEN = 2  # levels that are neither certified nor refuted, before the bisection ends
SIMPLE = 64  # denominators of levels that are preferred within that part
JUST_BELOW = (Fraction(4095, 4096), Fraction(255, 256), Fraction(15, 16))  # of a level that a point refutes


@dataclass(frozen=True)
class SublevelRegion:
    """Starts that stay in the square and reach the equilibrium.

    Attributes:
        level: every solution from ``V < level`` stays there.
        refuted: a larger level for which that is not shown; None where none was looked at.
        point: a point with V at most the refuted level, on the border or with a V that does not fall; None where the
            larger level is merely undecided.
        radius: half the side of the square, a number of the system's field, or rational in many states.
        falls: whether V is proved to fall on all of the square.
        proofs: the evidence by the names of the checker's claims, where it is found in that form.
    """

    level: Fraction
    refuted: Fraction | None
    point: Point | None
    radius: Any
    falls: bool
    proofs: Mapping[str, Any] = field(default_factory=dict, hash=False)

    def __str__(self) -> str:
        return f"V < {self.level}"


@dataclass(frozen=True)
class ReshapedRegion:
    """Another V, whose region reaches farther than that of the V that decided.

    Attributes:
        formula: V, in the displacement under the states' names.
        region: every start with V below its level in the cube reaches the point.
        hypotheses: of theorem ``lyapunov``, whose evidence the region holds.
    """

    formula: PiecewiseExpression
    region: SublevelRegion
    hypotheses: dict[str, Any]


@dataclass(frozen=True)
class LevelViolation:
    """Why a level is not certified, with a point where that is known."""

    point: Point | None


def largest_sublevel(cells: Sequence[LyapunovCell], radius: Number) -> SublevelRegion | None:
    """The largest certified level of V on a square, up to bisection; None where no level is certified.

    Args:
        cells: cover the square; V is positive on it, and has no bends.
        radius: half its side.
    """
    high = None if _bends(cells) else _level_on_border(cells, radius)
    if high is None:
        return None
    rise = first_rise(cells, radius)
    if rise is None or rise[0] >= high:
        return _between(cells, radius, high)
    return _below_a_rise(cells, radius, *rise)


def _bends(cells: Sequence[LyapunovCell]) -> bool:
    """Whether V is not one polynomial."""
    return any(cell.potential - cells[0].potential for cell in cells)


def _below_a_rise(cells: Sequence[LyapunovCell], radius: Number, high: Fraction, point: Point) -> SublevelRegion | None:
    """The largest level certified below one that a point refutes."""
    for share in JUST_BELOW:
        low = short_below(high * share)
        if _violation(cells, radius, low) is None:
            return SublevelRegion(_simplified(cells, radius, low, high), high, point, radius, False)
    return _between(cells, radius, high * JUST_BELOW[-1])


def _between(cells: Sequence[LyapunovCell], radius: Number, high: Fraction) -> SublevelRegion | None:
    """A level below another one by bisection; None where none is certified."""
    low, left_open = Fraction(0), 0
    for _ in range(BISECTIONS):
        middle = (low + high) / 2
        found = _violation(cells, radius, middle)
        low, high = (middle, high) if found is None else (low, middle)
        left_open += found is not None and found.point is None
        if left_open == MOST_OPEN:
            break
    low = _simplified(cells, radius, low, high)
    found = _violation(cells, radius, high)
    point = None if found is None else found.point
    return SublevelRegion(low, high, point, radius, False) if low else None


def _simplified(cells: Sequence[LyapunovCell], radius: Number, low: Fraction, high: Fraction) -> Fraction:
    """A level of small denominator between two, if it is certified; else the lower one."""
    simple = _simple_between(low, high)
    return low if simple is None or _violation(cells, radius, simple) is not None else simple


def _level_on_border(cells: Sequence[LyapunovCell], radius: Number) -> Fraction | None:
    """A power of two above the least value of V on the border; None where that is not clearly positive.

    It is looked for from near V's least value at the ends of the border's edges, so that units do not count.
    """
    edges = [(cell, edge) for cell in cells for edge in border_edges(cell, radius)]
    values = [cell.potential((x / w, y / w)).as_rational() for cell, edge in edges for x, y, w in edge]
    least = min((v for v in values if v is not None and v > 0), default=fmpq(1))
    high = Fraction(2) ** (int(least.p).bit_length() - int(least.q).bit_length())
    smallest = high * SMALLEST
    while _point_on_border(cells, radius, high) is None:
        high *= 2
    while _point_on_border(cells, radius, high / 2) is not None:
        high /= 2
        if high < smallest:
            return None
    return high


def _simple_between(low: Fraction, high: Fraction) -> Fraction | None:
    """The fraction of least denominator above one number and below another."""
    for denominator in range(1, SIMPLE + 1):
        candidate = Fraction(int(low * denominator) + 1, denominator)
        if candidate < high:
            return candidate
    return None


def _violation(cells: Sequence[LyapunovCell], radius: Number, level: Fraction) -> LevelViolation | None:
    """Why a level is not certified; None where it is."""
    found = _point_on_border(cells, radius, level)
    if found is not None:
        return LevelViolation(found)
    rises = (_rise_below(rate, cell, level) for cell in cells for rate in cell.rates)
    return next((rise for rise in rises if rise is not None), None)


def _point_on_border(cells: Sequence[LyapunovCell], radius: Number, level: Fraction) -> Point | None:
    """A point of the border of the square with V below a level."""
    edges = ((cell, edge) for cell in cells for edge in border_edges(cell, radius))
    found = (_point_below(cell.potential - level, edge, cell.region.guards) for cell, edge in edges)
    return next((point for point in found if point is not None), None)


def _below(cell: LyapunovCell, level: Fraction) -> Region:
    """The part of a closed cell where ``V <= level``."""
    return replace(cell.region, guards=(*cell.region.guards, -cell.potential + level))


def _rise_below(rate: Polynomial, cell: LyapunovCell, level: Fraction) -> LevelViolation | None:
    """Why a polynomial is not shown to be negative, off the point, where ``V < level``; None where it is shown."""
    if _falls_along_rays(rate, cell.potential, level, cell.region):
        return None
    outcome = prove(Sense.NEGATIVE, rate, _below(cell, level), except_origin=True)
    if isinstance(outcome, Counterexample):
        return LevelViolation((outcome.point[0], outcome.point[1]))
    shown = isinstance(outcome, Proof) or _falls_by_factors(rate, _below(cell, level))
    return None if shown else LevelViolation(None)


def _falls_along_rays(rate: Polynomial, potential: Polynomial, level: Fraction, region: Region) -> bool:
    """Whether a sum of two forms f and g is negative where a quadratic form V is below a level: homogeneous claims.

    On ``V = c``, ``f + g <= 0`` is ``f (V/c)^(d/2) + g <= 0`` for degrees that differ by an even d; for an odd d
    ``g^2 <= f^2 (V/c)^d`` is enough.
    """
    degrees = sorted({sum(e) for e in rate.terms})
    if len(degrees) != 2 or not potential.is_homogeneous or potential.degree != 2:
        return False
    f, g = (replace(rate, terms={e: c for e, c in rate.terms.items() if sum(e) == d}) for d in degrees)
    d, plain = degrees[1] - degrees[0], Region(region.generators)
    if d % 2:
        on_level = g * g * level**d - f * f * potential**d
    else:
        on_level = f * potential ** (d // 2) + g * level ** (d // 2)
    return isinstance(prove(Sense.NEGATIVE, f, plain, except_origin=True), Proof) and isinstance(
        prove(Sense.NONPOSITIVE, on_level, plain), Proof
    )


def _falls_by_factors(rate: Polynomial, region: Region) -> bool:
    """Whether a product of factors with proved signs is negative; each is tried without the guards first."""
    factored = factorize(rate)
    if factored is None:
        return False
    total = sign(factored[0])
    for factor, exponent in factored[1]:
        here = _sign_of_factor(factor, region)
        if not here:
            return False
        total *= here if exponent % 2 else 1
    return total < 0


def _sign_of_factor(factor: Polynomial, region: Region) -> int:
    """The strict sign of a factor on a region without the origin; 0 where none is proved."""
    for part in (Region(region.generators), region):
        for sense, side in ((Sense.POSITIVE, 1), (Sense.NEGATIVE, -1)):
            if isinstance(prove(sense, factor, part, except_origin=True), Proof):
                return side
    return 0


def border_edges(cell: LyapunovCell, radius: Number) -> Iterator[Segment]:
    """The sides of a cell that lie on the border of the square."""
    for g, h in cell.region.edges:
        for axis in (0, 1):
            ends = [end[axis] / end[2] for end in (g, h)]
            if ends[0] == ends[1] and abs(ends[0]) == radius:
                yield g, h


def _point_below(polynomial: Polynomial, edge: Segment, guards: Sequence[Polynomial] = ()) -> Point | None:
    """A point of an edge at which a polynomial is negative and no guard is; None where there is none."""
    curves = [along for along in (trimmed(along_edge(p, edge)) for p in (polynomial, *guards)) if along]
    roots = separated(root for along in curves for root in positive_roots(along))
    places = [(x / w, y / w) for x, y, w in edge]
    for t in samples_between(roots):
        x, y, w = (a + b * t for a, b in zip(*edge, strict=True))
        places.append((x / w, y / w))
    for place in places:
        if sign(polynomial(place)) < 0 and all(sign(guard(place)) >= 0 for guard in guards):
            return place
    return None


ANGLES, DISTANCES = 360, 160  # of the first points
WIDEST, FINER, ZOOMS, ACROSS = 1 / 40, 0.5, 24, 21  # grids: the first against the square, each against the one before


def first_rise(cells: Sequence[LyapunovCell], radius: Number) -> tuple[Fraction, Point] | None:
    """A level and a point where V is no larger and does not fall; None where none is seen.

    Args:
        cells: cover the square, with one polynomial V.
        radius: half its side.
    """
    found = [rise for cell in cells for rate in cell.rates for rise in _rises(cell, rate, float(radius))]
    return min(found, key=lambda rise: rise[0], default=None)


def _rises(cell: LyapunovCell, rate: Polynomial, radius: float) -> Iterator[tuple[Fraction, Point]]:
    """The last of finer and finer grids whose best point is confirmed."""
    best: list[Floats] = []
    points, step = _on_rays(radius), radius * WIDEST
    for _ in range(ZOOMS):
        lowest = _lowest(cell, rate, points, radius)
        if lowest is None:
            break
        best.append(lowest)
        line = np.linspace(-step, step, ACROSS)
        points = lowest + np.stack(np.meshgrid(line, line), axis=-1).reshape(-1, 2)
        step *= FINER
    for place in reversed(best):
        point = cell.potential.field(Fraction(float(place[0]))), cell.potential.field(Fraction(float(place[1])))
        if cell.region.contains(point) and sign(rate(point)) >= 0 and any(map(sign, point)):
            yield _level_above(cell.potential(point)), point
            return


def _on_rays(radius: float) -> Floats:
    angles = np.linspace(-np.pi, np.pi, ANGLES, endpoint=False)
    units = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    units *= radius / np.abs(units).max(axis=1, keepdims=True)
    shares = np.arange(1, DISTANCES + 1) / DISTANCES
    return np.asarray((shares[:, None, None] * units).reshape(-1, 2))


def _lowest(cell: LyapunovCell, rate: Polynomial, points: Floats, radius: float) -> Floats | None:
    """The point of least V among those of a cell at which V does not fall."""
    inside = where_inside(cell.region, points) & (np.abs(points).max(axis=1) <= radius)
    kept = points[inside & (values_at(rate, points) >= 0)]
    return kept[np.argmin(values_at(cell.potential, kept))] if len(kept) else None


def where_inside(region: Region, points: Floats) -> NDArray[np.bool_]:
    """Which points a closed region holds, in floats."""
    kept = np.ones(len(points), dtype=bool)
    for a, b, c in (map(float, side) for side in region.sides):
        kept &= a * points[:, 0] + b * points[:, 1] + c >= 0
    for guard in region.guards:
        kept &= values_at(guard, points) >= 0
    return kept


def _level_above(value: Number) -> Fraction:
    """A short fraction that is no smaller."""
    unit = Fraction(2) ** (math.frexp(float(value))[1] - DIGITS)
    level = unit * (int(float(value) / unit) + 1)
    while sign(value - level) > 0:
        level += unit
    return level
