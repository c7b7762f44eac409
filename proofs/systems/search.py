"""Every search for a V of a plain system, in order, and whether a V that was found speaks of the system.

Systems of cones with linear fields get a piecewise quadratic V on the whole plane.  For others a linear program
proposes sums of monomials and bent functions on a square; then the linear parts of the cones propose.  With time
reversed the same searches find a function that grows along every solution.

*Piecewise quadratic V.*  In the two rays a, b of a cone, ``c = s a + t b``, let ``V = v_a s^2 + 2 m s t + v_b t^2``:
one number for each ray and one for each cone, so V is continuous however they are rounded.  On the cone V and -V' are
positive if each is a positive definite form plus a product ``s t`` with a weight >= 0 (in two variables nothing is lost
by that): linear matrix inequalities (Johansson and Rantzer 1998).  Cells are cut into thinner cones where one piece
each is too stiff.  Floats propose; the solution is rounded and proved anew, sliding on the rays included; what the
rounding broke is tried again with longer fractions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import lru_cache
from typing import Any, TypeAlias

import numpy as np
from flint import fmpq

from nonsmooth.analysis.cells.polygon import Point, clipped_by
from nonsmooth.analysis.cells.region import cone_region
from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, PlaneField
from nonsmooth.proofs.inequalities.forms import directions
from nonsmooth.proofs.sums_of_squares.ansatz import Condition, build_blocks
from nonsmooth.proofs.sums_of_squares.conic_program import Problem, solve
from nonsmooth.proofs.systems.derivatives import Decrease, LyapunovResult, examine
from nonsmooth.proofs.systems.domain import SHRINKING, Domain
from nonsmooth.proofs.systems.findings import PlaneFunction
from nonsmooth.proofs.systems.lyapunov_search import (
    ENLARGING_WORK,
    enlarged,
    find_lyapunov,
    in_time,
    square_cells,
)
from nonsmooth.proofs.systems.ray_moves import are_cones, conic_germ
from nonsmooth.symbolic.numbers.coefficients import as_fmpq
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.plane import cross, plus, same_direction
from nonsmooth.symbolic.numbers.plane_arrays import Floats, are_finite
from nonsmooth.symbolic.numbers.polynomial import BEYOND_FLOATS, Polynomial, Terms, float_slopes
from nonsmooth.symbolic.numbers.work_limit import WorkMeter
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

Proposal: TypeAlias = tuple[Floats, Floats]  # values on rays, and mixed ones

DENOMINATORS = (1 << 6, 1 << 12, 1 << 24)  # of the rounded values, tried in turn
SS, ST, TT = (2, 0), (1, 1), (0, 2)  # powers of the coordinates in two rays
MIXED = fmpq(8)  # mixed values at most, over those on rays
HALVINGS = (0, 1, 2, 3)  # of each cell's cone, tried in turn: more pieces bend more


@dataclass(frozen=True)
class LinearCone:
    """A cone between two rays (given by their numbers) with a linear field."""

    start: int
    end: int
    velocity: PlaneField


def find_near(
    near: Sequence[FieldCell], domain: Sequence[FieldCell]
) -> tuple[tuple[LyapunovCell, ...], LyapunovResult] | None:
    """A V found for the linear parts of the cones at the origin, and its proof for the true fields of a domain.

    Args:
        near: the cells at the origin, cones (:func:`nonsmooth.proofs.systems.ray_moves.conic_germ`).
        domain: cells that cover a neighbourhood of the origin.
    """
    linear = linear_parts(near)
    for pieces, _ in _proved_on_cones(linear) if linear is not None else ():
        result = examine(restricted(pieces, domain))
        if result.verdict is Decrease.STRICT:
            return pieces, result
    return None


def linear_parts(cones: Sequence[FieldCell]) -> tuple[FieldCell, ...] | None:
    """The cones with the linear parts of their fields; None where a field does not vanish at the origin."""
    if any(part.at_origin for cell in cones for velocity in cell.velocities for part in velocity):
        return None
    return tuple(replace(cell, velocities=tuple((f.part(1), g.part(1)) for f, g in cell.velocities)) for cell in cones)


def restricted(pieces: Sequence[LyapunovCell], cells: Sequence[FieldCell]) -> tuple[LyapunovCell, ...]:
    """The cells of a domain cut along the cones of a V, with its pieces."""
    parts = ((cell, piece, clipped_by(cell.region, piece.region.sides)) for cell in cells for piece in pieces)
    return tuple(
        LyapunovCell(part, cell.velocities, piece.potential) for cell, piece, part in parts if part is not None
    )


def _proved_on_cones(cells: Sequence[FieldCell]) -> Iterator[tuple[tuple[LyapunovCell, ...], LyapunovResult]]:
    """Each V that is proved on the cones themselves, with the proof; none of fields that are not linear."""
    if any(not p.is_homogeneous or (p and p.degree != 1) for cell in cells for v in cell.velocities for p in v):
        return
    for halvings in HALVINGS:
        rays, cones = linear_cones(cells, halvings)
        proposal = solve_piecewise_quadratic(rays, cones)
        for denominator in DENOMINATORS if proposal is not None else ():
            on_rays, mixed = ([Fraction(x).limit_denominator(denominator) for x in part] for part in proposal or ())
            pieces = build_potential(rays, cones, on_rays, mixed)
            result = examine(pieces)
            if result.verdict is Decrease.STRICT:
                yield pieces, result


def linear_cones(cells: Sequence[FieldCell], halvings: int) -> tuple[list[Point], list[LinearCone]]:
    """All rays, and the cones between them (one for each field), each cell's cone halved a number of times."""
    rays: list[Point] = []

    def number(ray: Point) -> int:
        for k, known in enumerate(rays):
            if same_direction(known, ray):
                return k
        rays.append(ray)
        return len(rays) - 1

    cones = [
        LinearCone(number(a), number(b), velocity)
        for cell in cells
        for start, end in directions(cell.region)
        for a, b in _halved((start[0], start[1]), (end[0], end[1]), halvings)
        for velocity in cell.velocities
    ]
    return rays, cones


def _halved(start: Point, end: Point, times: int) -> list[tuple[Point, Point]]:
    """The cone between two rays as 2^times cones."""
    if not times:
        return [(start, end)]
    middle = plus(start, end)
    return _halved(start, middle, times - 1) + _halved(middle, end, times - 1)


def solve_piecewise_quadratic(rays: Sequence[Point], cones: Sequence[LinearCone]) -> Proposal | None:
    """Values on unit rays and mixed values, by a semidefinite program; None where there are none, or beyond floats.

    Beside the guard ``s t`` of each cone, V and -V' are sums of squares.  How fast a field is does not matter to the
    sign of a rate, so each is scaled to size one.
    """
    flows = [_scaled_flow(rays, cone) for cone in cones]
    if not are_finite(np.array(flows)):
        return None
    ends = tuple((cone.start, cone.end) for cone in cones)
    return _solve(len(rays), ends, tuple(tuple(map(as_fmpq, map(Fraction, flow.ravel().tolist()))) for flow in flows))


@lru_cache(maxsize=64)
def _solve(count: int, ends: tuple[tuple[int, int], ...], flows: tuple[tuple[fmpq, ...], ...]) -> Proposal | None:
    """The same of ``count`` rays; once, as the linear parts are those of every square."""
    problems: list[Problem] = []
    for mixed, ((first, second), (b11, b12, b21, b22)) in enumerate(zip(ends, flows, strict=True), count):
        positive: dict[int, Terms] = {first: {SS: fmpq(1)}, mixed: {ST: 2 * MIXED}, second: {TT: fmpq(1)}}
        falls: dict[int, Terms] = {
            first: {SS: -2 * b11, ST: -2 * b12},
            mixed: {SS: -2 * MIXED * b21, ST: -2 * MIXED * (b11 + b22), TT: -2 * MIXED * b12},
            second: {ST: -2 * b21, TT: -2 * b22},
        }
        for slopes in (positive, falls):
            condition = Condition({}, slopes, ({ST: fmpq(1)},), (), len(ST))
            problems.append((condition, build_blocks(condition)))
    found = solve(problems, count + len(ends), inner=0.0, bounded=True)
    return None if found is None else (found.parameters[:count], found.parameters[count:] * float(MIXED))


@BEYOND_FLOATS
def _scaled_flow(rays: Sequence[Point], cone: LinearCone) -> Floats:
    """The flow of a cone in its rays, of size one; no numbers beyond the range of floats."""
    flow = _flow_in_rays(rays, cone)
    if not are_finite(flow):
        return np.full((2, 2), np.nan)
    return flow / (np.abs(flow).max() or 1.0)


def _flow_in_rays(rays: Sequence[Point], cone: LinearCone) -> Floats:
    """``B`` with ``lambda' = B lambda`` for ``c = lambda_1 a + lambda_2 b``; no numbers where floats see one ray."""
    basis = np.array([[float(x) for x in rays[k]] for k in (cone.start, cone.end)]).T
    if not np.linalg.det(basis):
        return np.full((2, 2), np.nan)
    return np.linalg.solve(basis, float_slopes(cone.velocity) @ basis)


def build_potential(
    rays: Sequence[Point], cones: Sequence[LinearCone], on_rays: Sequence[Fraction], mixed: Sequence[Fraction]
) -> tuple[LyapunovCell, ...]:
    """V from its values on the rays and its mixed values, exactly."""
    cells: list[LyapunovCell] = []
    for cone, m in zip(cones, mixed, strict=True):
        first, second = rays[cone.start], rays[cone.end]
        like = cone.velocity[0]
        x, y = Polynomial.coordinates(like.field, like.variables)
        area: Any = cross(first, second)
        s = (x * second[1] - y * second[0]) * area.inverse()
        t = (y * first[0] - x * first[1]) * area.inverse()
        potential = s * s * on_rays[cone.start] + s * t * (2 * m) + t * t * on_rays[cone.end]
        cells.append(LyapunovCell(cone_region(first, second), (cone.velocity,), potential))
    return tuple(cells)


BISECTIONS = 4  # of the square of a V for the linear parts of cones, where that is not the checked one
SEARCH_SCALES = (Fraction(1), SHRINKING, SHRINKING**2, SHRINKING**3)  # of the checked square


def search_lyapunov(system: SwitchedSystem, cells: Sequence[FieldCell], *, grows: bool = False) -> PlaneFunction | None:
    """A V that is proved to fall along every solution (with time reversed: to grow); None where none is found.

    Args:
        system: in two states.
        cells: of the whole plane.
        grows: whether time is reversed.
    """
    if are_cones(cells) and not system.others:
        for _, found in _proved_on_cones(in_time(cells, grows=grows)):
            return PlaneFunction(found, Domain(None), None, system.states, grows)
    proposed = find_lyapunov(system, grows=grows)
    if proposed is not None:
        return proposed
    near = None if are_cones(cells) or system.others else conic_germ(cells)
    refused = None
    for scale in SEARCH_SCALES if near is not None else ():
        radius = system.check.radius * scale
        by_pieces = find_near(in_time(near or (), grows=grows), square_cells(system, radius, grows=grows))
        if by_pieces is not None:
            pieces, result = by_pieces
            here = PlaneFunction(result, Domain(radius), None, system.states, grows)
            return here if refused is None else enlarged_pieces(system, pieces, here, refused)
        refused = radius
    return None


def enlarged_pieces(
    system: SwitchedSystem, pieces: Sequence[LyapunovCell], found: PlaneFunction, refused: Number
) -> PlaneFunction:
    """The same V, of pieces on cones, on a larger square below one on which there is none."""

    def cells_on(radius: Number) -> tuple[LyapunovCell, ...]:
        return restricted(pieces, square_cells(system, radius, grows=found.grows))

    return enlarged(found, cells_on, refused, BISECTIONS, WorkMeter(BISECTIONS * ENLARGING_WORK))
