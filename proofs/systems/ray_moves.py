"""The cells of a switched system at the origin, and rays of rest from there.

*Germs.*  The Filippov set at a point is the hull of the limits of the fields of the cells whose *open* parts have
points arbitrarily near; a guard that merely vanishes at the point adds nothing
(:mod:`nonsmooth.proofs.inequalities.curved_regions`).

*Rays of rest.*  Where every cell is a cone and F holds zero on a ray, the ray consists of equilibria: the one at the
origin does not attract.  Inside a cone such rays are common roots of ``c x f(c)`` and ``c . f(c)``; on a ray between
cones the hull of the fields beside it is looked at.

*Constant fans.*  Where the fields are constant near the equilibrium, the fan of cones decides completely
(:mod:`nonsmooth.proofs.clauses.translation.fan_stability`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any, TypeAlias

from nonsmooth.analysis.cells.fan import Cone, Wedge, by_angle, rays_of
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.region import cone_region
from nonsmooth.analysis.cells.switched_cells import FieldCell, LyapunovCell, PlaneField, distinct, velocities_at
from nonsmooth.proofs.clauses.translation.fan_stability import FanResult, Move, decide_cones
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.inequalities.curved_regions import (
    ClosureMembership,
    Extent,
    closure_membership,
    ray_closure_membership,
    sectors,
)
from nonsmooth.proofs.inequalities.forms import directions
from nonsmooth.proofs.inequalities.kinks import mixtures
from nonsmooth.proofs.inequalities.real_roots import (
    along_ray,
    between_rays,
    form_lines,
    germ_sign,
    lowest_form,
    positive_roots,
)
from nonsmooth.symbolic.mechanics.contact_states import Twist
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import place_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, hull_holds_zero, plus, turned
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem, signs_by_factors


def decide_equilibrium(cells: Sequence[FieldCell]) -> Equilibrium:
    """Whether 0 is in F at the origin; undecided where that hangs on a cell of which it is not known if it counts."""
    by_membership = [(closure_membership(cell.region), cell) for cell in cells]
    sure = [cell for status, cell in by_membership if status is ClosureMembership.YES]
    possible = [cell for status, cell in by_membership if status is not ClosureMembership.NO]
    if hull_holds_zero(values_at_origin(sure)):
        return Equilibrium.HOLDS
    return Equilibrium.UNDECIDED if hull_holds_zero(values_at_origin(possible)) else Equilibrium.FAILS


def values_at_origin(cells: Iterable[FieldCell]) -> tuple[Point, ...]:
    """The distinct values of the fields of some cells at the origin."""
    return distinct((f.at_origin, g.at_origin) for cell in cells for f, g in cell.velocities)


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


@dataclass(frozen=True)
class RayOfRest:
    """A ray of equilibria near the origin.

    Attributes:
        place: a point of it.
        is_exact: whether it is, and not only near one: not every root has a name in the field.
    """

    place: Point
    is_exact: bool = True

    def __str__(self) -> str:
        return f"every point of the ray through {place_text(self.place)} near the equilibrium is an equilibrium"


def are_cones(cells: Sequence[FieldCell | LyapunovCell]) -> bool:
    """Whether all cells are whole cones at the origin, with homogeneous fields and no curved sides."""
    return all(
        not cell.region.guards
        and all(not g[2] or not any(g[:2]) for g in cell.region.generators)
        and all(part.is_homogeneous for velocity in cell.velocities for part in velocity)
        and all(f.degree == g.degree or not f or not g for f, g in cell.velocities)
        for cell in cells
    )


def rays_of_rest(cells: Sequence[FieldCell]) -> Iterator[RayOfRest]:
    """All rays of rest of a system of cones; cells that rest throughout give one each."""
    for cell in cells:
        for (a, b, *_), (c, d, *_) in directions(cell.region):
            yield from (RayOfRest(ray) for ray in ((a, b), (c, d)) if _holds_zero(cells, ray))
            for velocity in cell.velocities:
                yield from _inside((a, b), (c, d), velocity)


def resting_edges(cells: Sequence[FieldCell], *, enclosing: bool = False) -> Iterator[RayOfRest]:
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
            beside = [c for c in cells if ray_closure_membership(c.region, ray) is ClosureMembership.YES]
            if _all_oppose(beside, ray) if enclosing else _some_oppose(beside, ray):
                yield RayOfRest(ray)


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
    (a, b), (c, d) = ([along_ray(part, ray) for part in field] for field in (first, second))
    return (not a and not b) or (not a * d - b * c and germ_sign(a * c + b * d) < 0)


def _holds_zero(cells: Sequence[FieldCell], ray: Point) -> bool:
    """Whether F holds zero at a point of a ray between cones."""
    signs = {sign(dot(ray, f)) for f in mixtures(velocities_at(cells, ray), turned(ray))}
    return 0 in signs or len(signs) > 1


def _inside(first: Point, second: Point, velocity: PlaneField) -> Iterator[RayOfRest]:
    """Rays ``first + t second`` inside a cone on which the field vanishes, or one of them where it vanishes on all."""
    across, radial = (between_rays(form, first, second) for form in turning(velocity))
    if not across and not radial:
        yield RayOfRest(plus(first, second))
        return
    for root in positive_roots(across or radial):
        if not root.sign_of(radial):
            exact = root.exact()
            t: Any = root.low if exact is None else exact
            yield RayOfRest((first[0] + second[0] * t, first[1] + second[1] * t), exact is not None)


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
        motions = [Twist(f.at_origin, g.at_origin, zero) for f, g in velocities]
        cones.append(Cone(start, end, tuple(motions)))
    return tuple(cones)


# ---- the fan of tangent cones of a switched system at a point ------------------------------------
#
# With the leading terms of its fields.
#
# Near the point each switching surface through it is the zero set of its form of lowest degree, up to terms of higher
# order; other surfaces have one sign there.  The lines of these forms cut the plane into cones, and on each cone all
# signs, hence the field, are known.  The *leading* part of the fields is their part of the lowest degree that occurs in
# any cone.
#
# *Weights* (p, q) take x as of order p and y as of order q: with ``x = |z|^(p-1) z``, ``y = |w|^(q-1) w`` and time
# scaled by ``p q |z|^(p-1) |w|^(q-1) > 0``, fields and surfaces are polynomials in (z, w) on each quadrant, and
# weighted homogeneous terms become homogeneous (Bacciotti and Rosier 2005, sec. 5.3).  Twisting, ``x' = y``, ``y' = -a
# sign(x) - b sign(y)``, is a fan of cones with weights (2, 1).  Where a switching line is no axis, a *frame* of two
# linear forms takes the place of x and y.


Weights: TypeAlias = tuple[int, int]
Frame: TypeAlias = tuple[Point, Point]  # coefficients of the two linear forms that take the place of x and y

UNWEIGHTED: Weights = (1, 1)
QUADRANTS = ((1, 1), (-1, 1), (-1, -1), (1, -1))  # the signs of x and y, counterclockwise


@dataclass(frozen=True)
class TangentCone(Wedge):
    """A wedge of less than a half turn with the field that acts near the point inside it.

    Attributes:
        field: the whole field in the coordinates of the weights.
        leading: its part of the fan's degree.
    """

    field: PlaneField
    leading: PlaneField


@dataclass(frozen=True)
class TangentFan:
    """All cones at the point, counterclockwise, neighbours sharing their ray.

    Attributes:
        frame: the forms that take the place of x and y.
        weights: of these.
        degree: of the leading terms.
        cones: at least four.
        surfaces: for each cone, the surfaces that touch its first ray.
    """

    frame: Frame
    weights: Weights
    degree: int
    cones: tuple[TangentCone, ...]
    surfaces: tuple[tuple[Polynomial, ...], ...]

    @property
    def is_exact(self) -> bool:
        """Whether there are no terms of higher order: cones with homogeneous fields."""
        straight = all(s.is_homogeneous for surfaces in self.surfaces for s in surfaces)
        return straight and all(cone.field == cone.leading for cone in self.cones)


@dataclass(frozen=True)
class ConePiece:
    """A cone by its first ray, with its field and all surfaces through the point as its quadrant sees them."""

    start: Point
    field: PlaneField
    surfaces: tuple[Polynomial, ...]


def build_tangent_fan(
    system: SwitchedSystem, weights: Weights = UNWEIGHTED, frame: Frame | None = None
) -> TangentFan | None:
    """The fan at the checked point of a planar system.

    Args:
        system: in two states.
        weights: of the forms of the frame.
        frame: independent linear forms; x and y unless given.

    Returns:
        None where a surface has a singular point there whose tangents have no names in the field, where a formula
        cannot be used on some cone, and under arbitrary switching.
    """
    if system.others:
        return None
    try:
        return _fan(system, weights, axes_frame(system) if frame is None else frame)
    except SceneError:
        return None


def axes_frame(system: SwitchedSystem) -> Frame:
    """The frame of x and y themselves."""
    zero, one = system.field.zero, system.field.one
    return (one, zero), (zero, one)


def _fan(system: SwitchedSystem, weights: Weights, frame: Frame) -> TangentFan | None:
    pieces: list[ConePiece] = []
    for signs in QUADRANTS:
        states = _chart(system, weights, frame, signs)
        surfaces = tuple(s for s in system.surfaces(states) if not s.at_origin)
        rays = _rays(system, surfaces, signs)
        if rays is None:
            return None
        first, last = _axes(system, signs)
        for a, b in zip([first, *rays], [*rays, last], strict=True):
            inner = plus(a, b)
            pieces.append(ConePiece(a, _field(system, states, inner, weights, frame, signs), surfaces))
    degree = min((sum(e) for piece in pieces for part in piece.field for e in part.terms), default=0)
    cones = tuple(
        TangentCone(p.start, q.start, p.field, (p.field[0].part(degree), p.field[1].part(degree)))
        for p, q in around(pieces)
    )
    touched = tuple(_touching(pieces, k) for k in range(len(pieces)))
    return TangentFan(frame, weights, degree, cones, touched)


def _touching(pieces: Sequence[ConePiece], k: int) -> tuple[Polynomial, ...]:
    """The surfaces that touch the first ray of a cone, on the side that sees more (quadrants may have their own)."""
    ray = pieces[k].start
    before, after = ([s for s in p.surfaces if not lowest_form(s)(ray)] for p in (pieces[k - 1], pieces[k]))
    return tuple(before if len(before) > len(after) else after)


def _chart(system: SwitchedSystem, weights: Weights, frame: Frame, signs: tuple[int, int]) -> tuple[Polynomial, ...]:
    """The states as polynomials in (z, w) on a quadrant: ``s (s z)^p`` for a form that has the sign s there."""
    forms = []
    for name, weight, side in zip(PLANE, weights, signs, strict=True):
        variable = Polynomial.variable(system.field, PLANE, name)
        forms.append((variable * side) ** weight * side)
    (a, b), (c, d) = frame
    scale = (a * d - b * c).inverse()
    x, y = forms[0] * (d * scale) - forms[1] * (b * scale), forms[1] * (a * scale) - forms[0] * (c * scale)
    return tuple(part + centre for part, centre in zip((x, y), system.check.equilibrium, strict=True))


def _axes(system: SwitchedSystem, signs: tuple[int, int]) -> tuple[Point, Point]:
    """The two half axes that bound a quadrant, counterclockwise."""
    zero, one = system.field.zero, system.field.one
    horizontal, vertical = (one * signs[0], zero), (zero, one * signs[1])
    return (horizontal, vertical) if signs[0] == signs[1] else (vertical, horizontal)


def _rays(system: SwitchedSystem, surfaces: Sequence[Polynomial], signs: tuple[int, int]) -> list[Point] | None:
    """The tangents of all surfaces inside a quadrant, counterclockwise; None where one has no name."""
    rays: list[Point] = []
    for surface in surfaces:
        lines = form_lines(lowest_form(surface))
        if lines is None:
            return None
        for line in lines:
            a, b = line.slope(0), line.slope(1)
            for ray in ((b, -a), (-b, a)):
                inside = sign(ray[0]) == signs[0] and sign(ray[1]) == signs[1]
                if inside and not any(not cross(ray, other) for other in rays):
                    rays.append(ray)
    return sorted(rays, key=by_angle)


def _field(
    system: SwitchedSystem,
    states: Sequence[Polynomial],
    inner: Point,
    weights: Weights,
    frame: Frame,
    signs: tuple[int, int],
) -> PlaneField:
    """The field near the point in the cone around a direction, in (z, w) and scaled time."""
    surfaces = {s: _sign_near(s, inner) for s in system.surfaces(states)}
    first, second = system.velocity(signs_by_factors(surfaces), states)
    scales = [
        (Polynomial.variable(system.field, PLANE, name) * side) ** (weight - 1) * weight
        for name, weight, side in zip(PLANE, weights, signs, strict=True)
    ]
    (a, b), (c, d) = frame
    return (first * a + second * b) * scales[1], (first * c + second * d) * scales[0]


def _sign_near(surface: Polynomial, inner: Point) -> int:
    """The sign near the point, in a direction in which the lowest form does not vanish."""
    return sign(lowest_form(surface)(inner))


def is_simple(surfaces: Sequence[Polynomial], ray: Point) -> bool:
    """Whether at most one surface touches a ray, in a single smooth branch: then no thin cell hides beside it."""
    if len(surfaces) > 1:
        return False
    forms = [lowest_form(surface) for surface in surfaces]
    return all(any(form.derivative(name)(ray) for name in PLANE) for form in forms)


def rays_between(fan: TangentFan) -> Iterator[tuple[TangentCone, TangentCone, tuple[Polynomial, ...]]]:
    """The cone before and the cone after each ray, with the surfaces that touch the ray."""
    for (_, before, after), touched in zip(rays_of(fan.cones), fan.surfaces, strict=True):
        yield before, after, touched


def turning(field: PlaneField) -> tuple[Polynomial, Polynomial]:
    """``c x f`` and ``c . f`` as polynomials in c."""
    f, g = field
    x, y = Polynomial.coordinates(f.field, PLANE)
    return cross((x, y), (f, g)), dot((x, y), (f, g))
