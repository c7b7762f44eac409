"""Piecewise linear functions V of two states where the first terms of the fields decide.

Lines through the point, among them the tangents of all switching curves, cut the plane into cones; V is linear on each,
so its values on the rays give it.  That it falls along the first terms f of the fields is linear in these values:
``grad V . f(u) < 0`` at directions u of each closed cone, and ``rho V(r) < 0`` on each ray r along which a mixture of
fields from both sides has the radial velocity ``rho r``.  A linear program in floats proposes the values; terms of
higher order change little on a small cube, on which the theorem's own claims decide.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, TypeAlias

import numpy as np

from nonsmooth.proofs.checker.cells import Cell, Inclusion, System, pattern
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.checker.theorems import STABLE, UNSTABLE
from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import solve_program
from nonsmooth.proofs.inequalities.real_roots import form_lines, lowest_form
from nonsmooth.proofs.kernel.cells import StatedCells, build_inclusion, monic, sharpened, started, stated_cells
from nonsmooth.proofs.kernel.search import Entry, NotShownError, Search, directed_hypotheses, stability_hypotheses
from nonsmooth.proofs.kernel.written import coefficient_text, part_of, roundings
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import plus
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, float_values
from nonsmooth.symbolic.numbers.polynomial import Polynomial as Form
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Ray: TypeAlias = tuple[Any, Any]  # fractions, or numbers of the checker or of the program

RADII = tuple(Fraction(1, 4**k) for k in range(1, 7))  # half-widths of cubes, over that of the scene
MOST_LINES = 12
DENOMINATORS = (1 << 4, 1 << 8, 1 << 14)  # of the values on the rays, tried in turn
PLACES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of the directions of a cone at which V is asked to fall
LEAST = 2.0**-23  # by which it falls in floats, over the speed


@dataclass(frozen=True)
class FanCone:
    """A cone between two rays, with what acts there.

    Attributes:
        start: its first ray, counterclockwise.
        end: its last ray.
        mark: the signs of the lines through the point, as a text.
        cells: those that lie in it.
    """

    start: Ray
    end: Ray
    mark: str
    cells: tuple[Cell, ...]


def show_by_fan(system: SwitchedSystem, verdict: str, search: Search | None = None) -> Entry:
    """Evidence of a verdict by a piecewise linear V.

    Args:
        system: in two states.
        verdict: of the checked point.
        search: with what was shown before.

    Returns:
        The entry of a certificate, and what it shows.

    Raises:
        NotShownError: where none is found.
        BeyondReachError: for too many surfaces or cells.
    """
    subject, search = started(system, search, irrational=True)

    def cells(lines: Sequence[Form], share: Fraction) -> StatedCells:
        return sharpened(stated_cells(system, system.check.radius * share, lines, irrational=True), subject, search)

    def shown(stated: StatedCells, cones: Sequence[FanCone], values: Sequence[Fraction]) -> Entry | None:
        """The entry of a certificate; None where it is not shown."""
        with suppress(NotShownError):
            return search.tried(subject, *_written(stated, cones, values, verdict, subject, search))
        return None

    for lines in line_sets(system):
        smallest = cells(lines, RADII[-1])
        cones = build_cones(build_inclusion(smallest, subject, search))
        values = falling_values(cones, verdict)
        if values is None:
            continue
        rounded = list(roundings(values, DENOMINATORS))
        least = shown(smallest, cones, rounded[-1])  # without which there is none on a larger square
        if least is not None:
            squares = (*(cells(lines, share) for share in RADII[:-1]), smallest)
            return next(
                filter(None, (shown(stated, cones, candidate) for stated in squares for candidate in rounded)), least
            )
    raise NotShownError("no piecewise linear function was found that shows it")


# ---- lines and cones -----------------------------------------------------------------------------


def line_sets(system: SwitchedSystem) -> Iterator[list[Form]]:
    """The tangents of all switching curves at the point, then with lines inside wide cones, closer and closer.

    Each list is in the order of directions.

    Raises:
        NotShownError: where a tangent has no name in the field.
    """
    x, y = system.displaced(system.states)
    x, y = (coordinate - centre for coordinate, centre in zip((x, y), system.check.equilibrium, strict=True))
    lines: list[Form] = []
    for surface in system.surfaces(system.displaced(system.states)):
        if surface.degree and not surface.at_origin:
            tangents = form_lines(lowest_form(surface))
            if tangents is None:
                raise NotShownError("a switching curve has a tangent without a rational name")
            lines += [tangent for tangent in tangents if monic(tangent) not in map(monic, lines)]
    directions = sorted({_direction(line) for line in lines}, key=_angle)
    if len(directions) < 2:
        directions = sorted({(Fraction(1), Fraction(0)), (Fraction(0), Fraction(1)), *directions}, key=_angle)
    while len(directions) <= MOST_LINES:
        yield [y * d[0] - x * d[1] for d in directions]
        directions = sorted({*directions, *_between(directions)}, key=_angle)


def _direction(line: Form) -> Ray:
    """A vector along a line in the upper half plane, with short entries."""
    return _upper((_short_number(line.slope(1)), _short_number(-line.slope(0))))


def _short_number(value: Number) -> Any:
    """A fraction, if it is one."""
    rational = value.as_rational()
    return value if rational is None else as_fraction(rational)


def _upper(vector: Ray) -> Ray:
    size = max(abs(vector[0]), abs(vector[1]))
    sign = 1 if (vector[1], vector[0]) > (Fraction(0), Fraction(0)) else -1
    return vector[0] / size * sign, vector[1] / size * sign


def _angle(ray: Ray) -> float:
    return float(np.arctan2(float(ray[1]), float(ray[0])))


def _between(directions: Sequence[Ray]) -> Iterator[Ray]:
    """A short direction near the middle between each two neighbours that floats tell apart."""
    turned = [*directions[1:], (-directions[0][0], -directions[0][1])]
    for (a, b), (c, d) in zip(directions, turned, strict=True):
        p, q = np.hypot(float(a), float(b)), np.hypot(float(c), float(d))
        middle = (float(a) / p + float(c) / q, float(b) / p + float(d) / q)
        size = max(map(abs, middle))
        if size:
            x, y = (Fraction(part / size).limit_denominator(16) for part in middle)
            yield _upper((x, y))


def build_cones(inclusion: Inclusion) -> list[FanCone]:
    """The cones between the lines through the point among the surfaces, counterclockwise, with the cells in each."""
    listed = inclusion.surfaces.listed
    lines = [j for j, surface in enumerate(listed) if surface.degree == 1 and not surface.at_origin]
    upper = {_upper((listed[j].slope(1), -listed[j].slope(0))) for j in lines}
    rays = sorted({*upper, *((-a, -b) for a, b in upper)}, key=_angle)
    cones = []
    for start, end in zip(rays, [*rays[1:], rays[0]], strict=True):
        inner = plus(start, end)
        signs = {j: listed[j].slope(0) * inner[0] + listed[j].slope(1) * inner[1] > 0 for j in lines}
        cells = tuple(
            c for c in inclusion.cells if all((c.signs[j] > 0) == is_positive for j, is_positive in signs.items())
        )
        mark = pattern(2 * signs[j] - 1 if j in signs else None for j in range(len(listed)))
        cones.append(FanCone(start, end, mark, cells))
    return cones


# ---- the linear program --------------------------------------------------------------------------


@BEYOND_FLOATS
def falling_values(cones: Sequence[FanCone], verdict: str) -> Floats | None:
    """Values of V on the first rays of all cones, with which V falls as fast as it can; None where it does not.

    For a stable point that need not attract V does not rise, and for an unstable one it is negative on some ray.
    Floats that do not tell the rays of a cone apart, or hold no velocity, propose nothing.
    """
    if not all(np.linalg.det(np.stack([_floats(cone.start), _floats(cone.end)])) for cone in cones):
        return None
    degree = min((sum(e) for cone in cones for c in cone.cells for _, f in c.fields for p in f for e in p.terms))
    rows = [*_rows_of_cones(cones, degree), *_rows_of_rays(cones, degree)]
    count = len(cones)
    speeds = np.array([speed for _, speed in rows])
    slopes = np.array([row for row, _ in rows])
    if verdict == STABLE:
        # The least value is as large as it can be.
        above, bounds = np.zeros(len(rows)), [(0.0, 1.0)] * (count + 1)
    else:
        above, bounds = speeds, [(-1.0, 1.0)] * count + [(0.0, 1.0)]
    table = np.column_stack([slopes, above])
    if not are_finite(table):
        return None
    if verdict != UNSTABLE:
        table = np.vstack([table, np.column_stack([-np.eye(count), np.ones(count)])])
    solution = solve_program(np.append(np.zeros(count), -1.0), A_ub=table, b_ub=np.zeros(len(table)), bounds=bounds)
    if not solution.success or solution.x[-1] < LEAST or (verdict == UNSTABLE and solution.x[:-1].min() >= 0):
        return None
    return np.asarray(solution.x[:-1])


def _rows_of_cones(cones: Sequence[FanCone], degree: int) -> Iterator[tuple[Floats, float]]:
    """``grad V . f(u)`` as a linear function of the values, with the speed ``abs(f(u))``.

    Where the first terms are zero at u the next ones count; where all are, V cannot fall.
    """
    count = len(cones)
    for k, cone in enumerate(cones):
        start, end = _floats(cone.start), _floats(cone.end)
        inverse = np.linalg.inv(np.stack([start, end]))  # of (V(start), V(end)) = rays . grad V
        for place in PLACES:
            direction = (1 - place) * start + place * end
            for terms in _terms(cone.cells, degree, direction):
                velocity = next((term for term in terms if term.any()), None)
                row = np.zeros(count)
                row[[k, (k + 1) % count]] = np.zeros(2) if velocity is None else velocity @ inverse
                yield row, 1.0 if velocity is None else float(np.linalg.norm(velocity))


def _rows_of_rays(cones: Sequence[FanCone], degree: int) -> Iterator[tuple[Floats, float]]:
    """``rho V(r)`` for the mixtures of velocities on both sides of a ray r that are radial there."""
    for k, cone in enumerate(cones):
        ray = _floats(cone.start)
        normal = np.array([-ray[1], ray[0]])
        for f in _velocities(cones[k - 1].cells, degree, ray):
            for g in _velocities(cone.cells, degree, ray):
                a, b = float(normal @ f), float(normal @ g)
                if a * b < 0:
                    mixed = (abs(b) * f + abs(a) * g) / (abs(a) + abs(b))
                    row = np.zeros(len(cones))
                    row[k] = float(mixed @ ray) / float(ray @ ray)
                    yield row, float(np.linalg.norm(mixed))


def _velocities(cells: Sequence[Cell], degree: int, place: Floats) -> list[Floats]:
    """The first terms of all fields of some cells at a direction."""
    return [next(terms) for terms in _terms(cells, degree, place)]


def _terms(cells: Sequence[Cell], degree: int, place: Floats) -> Iterator[Iterator[Floats]]:
    """The terms of one degree after the other of each field of some cells, at a direction."""
    for cell in cells:
        for _, field in cell.fields:
            degrees = range(degree, max(degree, *(component.degree for component in field)) + 1)
            yield (np.array([_value(component, k, place) for component in field]) for k in degrees)


def _value(polynomial: Polynomial, degree: int, place: Floats) -> float:
    """Of its terms of a degree."""
    return float(float_values(part_of(polynomial, degree).terms, place[None, :])[0])


def _floats(ray: Ray) -> Floats:
    return np.array([float(ray[0]), float(ray[1])])


# ---- the theorem ---------------------------------------------------------------------------------


def _written(
    stated: StatedCells,
    cones: Sequence[FanCone],
    values: Sequence[Fraction],
    verdict: str,
    subject: System,
    search: Search,
) -> tuple[str, Record]:
    """The theorem's name, and its hypotheses with V as linear pieces."""
    pieces = []
    for cone, value, after in zip(cones, values, [*values[1:], values[0]], strict=True):
        slopes = map(coefficient_text, _gradient(cone, value, after))
        formula = " + ".join(f"{slope}*{name}" for slope, name in zip(slopes, subject.states, strict=True))
        pieces.append([cone.mark, formula])
    if verdict != UNSTABLE:
        return "lyapunov", stability_hypotheses(stated.record, pieces, verdict)
    lowest = _floats(cones[values.index(min(values))].start)
    return "instability", directed_hypotheses(subject, stated.record, pieces, search, near=[lowest])


def _gradient(cone: FanCone, value: Fraction, after: Fraction) -> Ray:
    """The gradient of the linear function with given values on both rays of a cone."""
    (a, b), (c, d) = cone.start, cone.end
    area = a * d - b * c
    return (value * d - after * b) / area, (after * a - value * c) / area
