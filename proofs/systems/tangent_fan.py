"""The fan of tangent cones of a switched system at a point, with the leading terms of its fields.

Near the point each switching surface through it is the zero set of its form of lowest degree, up to terms of higher
order; other surfaces have one sign there.  The lines of these forms cut the plane into cones, and on each cone all
signs, hence the field, are known.  The *leading* part of the fields is their part of the lowest degree that occurs in
any cone.

*Weights* (p, q) take x as of order p and y as of order q: with ``x = |z|^(p-1) z``, ``y = |w|^(q-1) w`` and time
scaled by ``p q |z|^(p-1) |w|^(q-1) > 0``, fields and surfaces are polynomials in (z, w) on each quadrant, and weighted
homogeneous terms become homogeneous (Bacciotti and Rosier 2005, sec. 5.3).  Twisting, ``x' = y``,
``y' = -a sign(x) - b sign(y)``, is a fan of cones with weights (2, 1).  Where a switching line is no axis, a *frame* of
two linear forms takes the place of x and y.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

from nonsmooth.analysis.cells.fan import Wedge, by_angle, rays_of
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.switched_cells import PlaneField
from nonsmooth.proofs.kernel.tangents import form_lines, lowest_form
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.plane import around, cross, dot
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE, SwitchedSystem, signs_by_factors

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
        straight = all(s.is_homogeneous for found in self.surfaces for s in found)
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
        surfaces = tuple(s for s in system.surfaces(states) if not s.terms.get((0, 0)))
        rays = _rays(system, surfaces, signs)
        if rays is None:
            return None
        first, last = _axes(system, signs)
        for a, b in zip([first, *rays], [*rays, last], strict=True):
            inner = (a[0] + b[0], a[1] + b[1])
            pieces.append(ConePiece(a, _field(system, states, inner, weights, frame, signs), surfaces))
    degree = min((sum(e) for piece in pieces for part in piece.field for e in part.terms), default=0)
    cones = tuple(
        TangentCone(p.start, q.start, p.field, (_part(p.field[0], degree), _part(p.field[1], degree)))
        for p, q in around(pieces)
    )
    touched = tuple(_touching(pieces, k) for k in range(len(pieces)))
    return TangentFan(frame, weights, degree, cones, touched)


def _touching(pieces: Sequence[ConePiece], k: int) -> tuple[Polynomial, ...]:
    """The surfaces that touch the first ray of a cone, on the side that sees more (quadrants may have their own)."""
    ray = pieces[k].start
    before, own = ([s for s in p.surfaces if not lowest_form(s)(ray)] for p in (pieces[k - 1], pieces[k]))
    return tuple(before if len(before) > len(own) else own)


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
    found: list[Point] = []
    for surface in surfaces:
        lines = form_lines(lowest_form(surface))
        if lines is None:
            return None
        for line in lines:
            zero = system.field.zero
            a, b = line.terms.get((1, 0), zero), line.terms.get((0, 1), zero)
            for ray in ((b, -a), (-b, a)):
                inside = sign(ray[0]) == signs[0] and sign(ray[1]) == signs[1]
                if inside and not any(not cross(ray, known) for known in found):
                    found.append(ray)
    return sorted(found, key=by_angle)


def _part(polynomial: Polynomial, degree: int) -> Polynomial:
    return replace(polynomial, terms={e: c for e, c in polynomial.terms.items() if sum(e) == degree})


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
    x, y = (Polynomial.variable(f.field, PLANE, name) for name in PLANE)
    return cross((x, y), (f, g)), dot((x, y), (f, g))
