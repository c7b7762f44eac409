"""The cells of a switched system at the origin, and what happens along single rays from there.

*Germs.*  The Filippov set at a point is the hull of the limits of the fields of the cells whose *open* parts have
points arbitrarily near; a guard that merely vanishes at the point adds nothing
(:mod:`nonsmooth.proofs.inequalities.curved_regions`).

*Rays.*  Where every cell is a cone, a velocity that is radial on a ray stays radial along it.  If F on the ray holds an
outward radial vector, one solution leaves along it: unstable.  If it holds zero, the ray consists of equilibria: the
one at the origin does not attract.  Inside a cone such rays are the roots of ``c x f(c)``; on a ray between cones the
hull of the fields beside it is looked at.

*Constant fans.*  Where the fields are constant near the equilibrium, the fan of cones decides completely
(:mod:`nonsmooth.proofs.clauses.translation.fan_stability`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from enum import StrEnum
from fractions import Fraction
from itertools import combinations
from typing import Any

from nonsmooth.analysis.cells.fan import Cone, by_angle
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import cone_region
from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, PlaneField, distinct, velocities_at
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, decide_cones
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.proofs.inequalities.curved_regions import Adherence, Extent, adherence, ray_adherence, sectors
from nonsmooth.proofs.inequalities.forms import directions
from nonsmooth.proofs.inequalities.kinks import mixtures
from nonsmooth.proofs.inequalities.real_roots import (
    RealRoot,
    between_rays,
    positive_roots,
    samples_between,
    value,
)
from nonsmooth.symbolic.mechanics.constraints import Twist
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane import around, dot, hull_holds_zero, turned
from nonsmooth.symbolic.numbers.polynomial import Polynomial


def decide_equilibrium(cells: Sequence[FieldCell]) -> Equilibrium:
    """Whether 0 is in F at the origin; undecided where that hangs on a cell of which it is not known if it counts."""
    by_adherence = [(adherence(cell.region), cell) for cell in cells]
    sure = [cell for found, cell in by_adherence if found is Adherence.YES]
    possible = [cell for found, cell in by_adherence if found is not Adherence.NO]
    if hull_holds_zero(values_at_origin(sure)):
        return Equilibrium.HOLDS
    return Equilibrium.UNDECIDED if hull_holds_zero(values_at_origin(possible)) else Equilibrium.FAILS


def values_at_origin(cells: Iterable[FieldCell]) -> tuple[Point, ...]:
    """The distinct values of the fields of some cells at the origin."""
    values = []
    for cell in cells:
        for f, g in cell.velocities:
            zero = f.field.zero
            values.append((f.terms.get((0, 0), zero), g.terms.get((0, 0), zero)))
    return distinct(values)


def conic_germ(cells: Iterable[FieldCell]) -> tuple[FieldCell, ...] | None:
    """The cells near the origin as whole cones; None where a curved side ends at the origin, or may.

    Guards that are positive near the origin bound nothing there, and cells that have no points near it are left out.
    """
    cones: list[FieldCell] = []
    for cell in cells:
        for sector in sectors(cell.region):
            if sector.extent is Extent.WHOLE:
                cones.append(replace(cell, region=cone_region(sector.start, sector.end)))
            elif sector.extent is not Extent.NONE:
                return None
    return tuple(cones)


class RayKind(StrEnum):
    """What a solution may do on a ray."""

    ESCAPE = "a solution leaves along {}"
    REST = "every point of {} near the equilibrium is an equilibrium"


@dataclass(frozen=True)
class RayMove:
    """A ray on which F holds an outward radial vector, or zero.

    Attributes:
        kind: which of the two.
        ray: a vector along it; where ``root`` is given, ``ray = first + t second`` only up to its bounds.
        value: ``c . f`` at that vector for the radial f; None where the ray has no name in the field.
    """

    kind: RayKind
    ray: Point
    value: Any | None

    def __str__(self) -> str:
        return self.kind.value.format(f"the ray through {place_text(self.ray)}")


def are_cones(cells: Sequence[FieldCell | LyapunovCell]) -> bool:
    """Whether all cells are whole cones at the origin, with homogeneous fields and no curved sides."""
    return all(
        not cell.region.guards
        and all(not g[2] or not any(g[:2]) for g in cell.region.generators)
        and all(part.is_homogeneous for velocity in cell.velocities for part in velocity)
        and all(f.degree == g.degree or not f or not g for f, g in cell.velocities)
        for cell in cells
    )


def ray_moves(cells: Sequence[FieldCell]) -> Iterator[RayMove]:
    """All rays of escape or rest of a system of cones; cells that rest or move radially throughout give one each."""
    for cell in cells:
        for first, second in directions(cell.region):
            yield from _boundary_moves(cells, (first[0], first[1]))
            yield from _boundary_moves(cells, (second[0], second[1]))
            for velocity in cell.velocities:
                yield from _inner_moves((first[0], first[1]), (second[0], second[1]), velocity)


def resting_edges(cells: Sequence[FieldCell], *, enclosing: bool = False) -> Iterator[RayMove]:
    """Sides that end at the origin and consist of equilibria near it, whatever the cells are.

    There the fields beside the side are opposed (or one of them is zero) all along: two polynomials in one variable.
    Beside it are the cells whose open parts have points near every point of the side near the origin.

    Args:
        cells: with the fields that act in each.
        enclosing: whether the fields of a cell only enclose the one that acts there.  Then every field of one cell
            must be opposed to every field of another: ``a x b`` and ``a . b`` are linear in either, so that all
            mixtures of the ones are opposed to all mixtures of the others.
    """
    for cell in cells:
        for g, h in cell.region.edges:
            origin, other = (g, h) if not any(g[:2]) else (h, g)
            if any(origin[:2]) or not origin[2]:
                continue
            ray = (other[0], other[1])
            beside = [c for c in cells if ray_adherence(c.region, ray) is Adherence.YES]
            if _all_oppose(beside, ray) if enclosing else _some_oppose(beside, ray):
                yield RayMove(RayKind.REST, ray, ray[0] - ray[0])


def _some_oppose(beside: Sequence[FieldCell], ray: Point) -> bool:
    """Whether some fields of some cells hold zero between them along a ray."""
    fields = [v for cell in beside for v in cell.velocities]
    return any(_rests_along(f, k, ray) for f in fields for k in fields)


def _all_oppose(beside: Sequence[FieldCell], ray: Point) -> bool:
    """Whether all fields of one cell hold zero between them and all fields of another along a ray."""
    return any(
        all(_rests_along(f, k, ray) for f in first.velocities for k in second.velocities)
        for first, second in combinations(beside, 2)
    )


def _rests_along(first: PlaneField, second: PlaneField, ray: Point) -> bool:
    """Whether two fields are opposed, or one vanishes, at all points ``t ray`` with small t > 0."""
    x, y = ray
    t = Polynomial.variable(first[0].field, ("t",), "t")
    (a, b), (c, d) = ([part.composed([t * x, t * y]) for part in field] for field in (first, second))
    if not a and not b:
        return True
    turn, along = a * d - b * c, a * c + b * d
    lowest = min((e[0] for e in along.terms), default=0)
    return not turn and bool(along) and along.terms[(lowest,)].sign() < 0


def _boundary_moves(cells: Sequence[FieldCell], ray: Point) -> Iterator[RayMove]:
    values = [dot(ray, f) for f in mixtures(velocities_at(cells, ray), turned(ray))]
    signs = [sign(speed) for speed in values]
    for speed, here in zip(values, signs, strict=True):
        if here >= 0:
            yield RayMove(RayKind.ESCAPE if here else RayKind.REST, ray, speed)
    if {1, -1} <= set(signs):
        yield RayMove(RayKind.REST, ray, values[0] - values[0])


def _inner_moves(first: Point, second: Point, velocity: tuple[Polynomial, Polynomial]) -> Iterator[RayMove]:
    """Rays ``first + t second`` inside the cone on which the field is radial, or one between any two if all are."""
    f, g = velocity
    x, y = (Polynomial.variable(f.field, f.variables, name) for name in f.variables)
    across, radial = between_rays(x * g - y * f, first, second), between_rays(x * f + y * g, first, second)
    places: list[Fraction | RealRoot] = list(positive_roots(across or radial)) if across or radial else []
    if not across:
        places += samples_between([place for place in places if isinstance(place, RealRoot)])
    for place in places:
        isolated = isinstance(place, RealRoot)
        here = place.sign_of(radial) if isinstance(place, RealRoot) else sign(value(radial, place))
        if here >= 0:
            exact = place.exact() if isinstance(place, RealRoot) else f.field(place)
            t: Any = place.low if isinstance(place, RealRoot) and exact is None else exact
            ray = (first[0] + second[0] * t, first[1] + second[1] * t)
            speed = None if isolated and exact is None else dot(ray, (f(ray), g(ray)))
            yield RayMove(RayKind.ESCAPE if here else RayKind.REST, ray, speed)


# ---- the constant fan ------------------------------------------------------------------------


@dataclass(frozen=True)
class ConstantFan:
    """Decision by the fan of a system whose fields are exactly constant near the equilibrium.

    Attributes:
        verdict: strong stability.
        reason: one sentence for people.
        fan: the decision with its evidence.
    """

    verdict: Translation
    reason: str
    fan: FanResult


def decide_constant_fan(cells: Sequence[FieldCell]) -> ConstantFan | None:
    """Decide by the fan; None where a field near the equilibrium is not constant."""
    cones = constant_cones(cells)
    if cones is None:
        return None
    fan = decide_cones(cones)
    return ConstantFan(*_with_closed_orbits(fan), fan)


def _with_closed_orbits(fan: FanResult) -> tuple[Translation, str]:
    """The fan's verdict; a gain of exactly one is no tie here, because there are no terms of higher order."""
    ties = [gain for gain in fan.gains.values() if not sign(gain - 1)]
    closed = fan.verdict is Translation.UNDECIDED and ties and len(ties) == len(fan.evidence)
    if closed and all(e.move is Move.TIE for e in fan.evidence):
        return Translation.STABLE, "a full turn has gain exactly one: closed orbits, stable and not asymptotically"
    return fan.verdict, fan.reason


def constant_cones(cells: Sequence[FieldCell]) -> tuple[Cone, ...] | None:
    """The cones at the origin, counterclockwise, neighbours sharing one vector per ray; None where there are others."""
    here = conic_germ(cells)
    if here is None or any(p.degree for cell in here for v in cell.velocities for p in v):
        return None
    zero = cells[0].velocities[0][0].field.zero
    pieces: list[tuple[Point, tuple[PlaneField, ...]]] = [
        ((a[0], a[1]), cell.velocities) for cell in here for a, _ in directions(cell.region)
    ]
    pieces.sort(key=lambda piece: by_angle(piece[0]))
    cones: list[Cone] = []
    for (start, velocities), (end, _) in around(pieces):
        motions = [Twist(f.terms.get((0, 0), zero), g.terms.get((0, 0), zero), zero) for f, g in velocities]
        cones.append(Cone(start, end, tuple(motions)))
    return tuple(cones)
