"""From polynomials on closed cells to forms on simplicial cones.

A homogeneous polynomial has one sign along each ray from the origin, so only the directions of the cell matter: a
region gives cones of two rays, with a free theta two such cones for theta >= 0 and theta <= 0, and one more ray.  (Not
so an unbounded region without the origin: it tends to directions that none of its points has.)  Any other polynomial
is made a form by the variable w, and the region's triangles, seen from the origin where the region holds it, give
cones of generators ``(x, y, w)``.  ``|theta|`` is theta with the sign of its half.

Where a homogeneous polynomial holds both r and theta, half angles remove the root: ``x = p^2 - q^2``, ``y = 2 p q``,
``r = p^2 + q^2``, ``|theta| = t^2`` makes it a form in (p, q, t) on the cone of the half angles.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from typing import Any

from nonsmooth.analysis.cells.region import Region, Triple
from nonsmooth.proofs.inequalities.forms import Form, Problem, Vector
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial, Terms
from nonsmooth.symbolic.numbers.square_roots import NestingError
from nonsmooth.symbolic.plane import cross, dot

PLANE = ("x", "y")
EXTENDED = ("x", "y", "theta", "abs_theta", "r")
HALF_ANGLE = ("p", "q", "t")


@dataclass(frozen=True)
class CellClaim:
    """``polynomial >= 0`` (or ``> 0``) on a closed region, for every theta if the polynomial holds theta.

    Attributes:
        polynomial: in (x, y), or in (x, y, theta, abs_theta, r) with ``r = sqrt(x^2 + y^2)``.
        region: the closed region of the plane.
        strict: whether > 0 is claimed.
        except_origin: whether a strict claim leaves the origin out.
    """

    polynomial: Polynomial
    region: Region
    strict: bool
    except_origin: bool = False

    @property
    def free_theta(self) -> bool:
        """Whether the cell is region x line."""
        return self.polynomial.variables != PLANE

    @cached_property
    def holds_origin(self) -> bool:
        """Whether the region holds the origin."""
        zero = self.polynomial.field.zero
        return self.region.contains((zero, zero))

    @cached_property
    def directions_are_attained(self) -> bool:
        """Whether each direction of the region is that of one of its points, and no curve cuts it."""
        closed = self.holds_origin or all(g[2] for g in self.region.generators)
        return closed and not self.region.guards

    def value(self, point: Sequence[Any]) -> Any:
        """The polynomial at (x, y) or (x, y, theta); takes a square root where it holds r."""
        if not self.free_theta:
            return self.polynomial(point)
        x, y, theta = point
        holds_r = any(e[4] for e in self.polynomial.terms)
        r = (x * x + y * y).sqrt() if holds_r else x
        return self.polynomial((x, y, theta, abs(theta), r))


@dataclass(frozen=True)
class CellPart:
    """A simplicial part of the cell with the way back to its points.

    Attributes:
        problem: the claim on the part.
        side: sign of theta; 0 where the polynomial holds no theta.
        turn: 1 or -1 where the form is in half angles of ``turn (x, y)``; 0 where it is in x and y.
    """

    problem: Problem
    side: int
    turn: int = 0

    def point(self, vector: Vector, claim: CellClaim) -> Vector:
        """The point (x, y) or (x, y, theta) of the cell that a vector in the form's variables stands for."""
        field = claim.polynomial.field
        exact = [v if hasattr(v, "sign") else field(v) for v in vector]
        if self.problem.form.weighted:
            *exact, w = exact
            exact = [v / w for v in exact] if w else exact
        else:
            if self.turn:
                p, q, t = exact
                exact = [(p * p - q * q) * self.turn, 2 * p * q * self.turn, t * t]
            scale = claim.region.reach(exact[0], exact[1])
            exact = [v * scale for v in exact]
        theta = [exact[2] * self.side] if self.side else [field.zero] * claim.free_theta
        return (exact[0], exact[1], *theta)


def build_parts(claim: CellClaim) -> Iterator[CellPart]:
    """The claim on simplicial cones that cover the cell."""
    needs_theta = claim.free_theta and any(e[2] or e[3] for e in claim.polynomial.terms)
    for side in (1, -1) if needs_theta else (0,):
        plain, radial = _without_radius(claim.polynomial, side)
        same_degree = not plain or not radial or plain.degree == radial.degree + 1
        homogeneous = plain.is_homogeneous and radial.is_homogeneous and same_degree
        if not (homogeneous and claim.directions_are_attained):
            yield from _weighted_parts(claim, plain, radial, side)
            continue
        form = Form(plain, radial if radial else None, weighted=False)
        for rays in directions(claim.region):
            part = _half_angle_part(claim, side, rays) if side and radial else None
            yield part or _plain_part(claim, form, side, rays)


def _plain_part(claim: CellClaim, form: Form, side: int, rays: tuple[Vector, Vector]) -> CellPart:
    """Two rays, and the theta axis."""
    zero, one = claim.polynomial.field.zero, claim.polynomial.field.one
    generators = ((*rays[0], zero), (*rays[1], zero), (zero, zero, one)) if side else rays
    return CellPart(Problem(form, generators, claim.strict, claim.except_origin, claim.holds_origin), side)


def _half_angle_part(claim: CellClaim, side: int, rays: tuple[Vector, Vector]) -> CellPart | None:
    """The same in half angles; None where the lengths of the rays have no roots in the field.

    Angles are measured from the positive x axis, so a cone that holds the negative one inside is turned by pi first.
    """
    field = claim.polynomial.field
    (a, b), left = rays, (-field.one, field.zero)
    crosses = sign(cross(a, left)) > 0 and sign(cross(left, b)) > 0
    turn = -1 if crosses or (not a[1] and sign(a[0]) < 0) else 1
    p, q, t = (Polynomial.variable(field, HALF_ANGLE, name) for name in HALF_ANGLE)
    size = t * t
    values = [(p * p - q * q) * turn, 2 * p * q * turn, size * side, size, p * p + q * q]
    try:
        halves = [_half_angle((x * turn, y * turn)) for x, y in rays]
    except NestingError:
        return None
    form = Form(claim.polynomial.composed(values), None, weighted=False)
    generators = (*((*half, field.zero) for half in halves), (field.zero, field.zero, field.one))
    return CellPart(Problem(form, generators, claim.strict, claim.except_origin, claim.holds_origin), side, turn)


def _half_angle(ray: Vector) -> Vector:
    """A vector of half the angle, between -pi/2 and pi/2."""
    length = dot((ray[0], ray[1]), (ray[0], ray[1])).sqrt()
    if not ray[1] and sign(ray[0]) < 0:
        return ray[1], length
    return length + ray[0], ray[1]


def _weighted_parts(claim: CellClaim, plain: Polynomial, radial: Polynomial, side: int) -> Iterator[CellPart]:
    """Triangles of the region as cones of (x, y, w), with a free theta one generator more."""
    zero, one = claim.polynomial.field.zero, claim.polynomial.field.one
    degree = max(plain.degree, radial.degree + 1 if radial else 0)
    form = Form(plain.homogenized(degree), radial.homogenized(degree - 1) if radial else None, weighted=True)
    guards = tuple(_padded(guard, side).homogenized() for guard in claim.region.guards)
    for triangle in triangles(claim.region, holds_origin=claim.holds_origin):
        corners: tuple[Vector, ...] = triangle
        if side:
            corners = (*((x, y, zero, w) for x, y, w in triangle), (zero, zero, one, zero))
        yield CellPart(Problem(form, corners, claim.strict, claim.except_origin, guards=guards), side)


def directions(region: Region) -> Iterator[tuple[Vector, Vector]]:
    """Cones of two rays from the origin that hold exactly the directions of the region's points."""
    for g, h in pairwise([*region.generators, region.generators[0]]):
        if sign(cross(g[:2], h[:2])) > 0:
            yield g[:2], h[:2]


def triangles(region: Region, *, holds_origin: bool) -> Iterator[tuple[Triple, Triple, Triple]]:
    """Triangles that cover the region; from the origin where it belongs to it."""
    first = region.generators[0]
    if not holds_origin:
        for g, h in pairwise(region.generators[1:]):
            yield first, g, h
        return
    one = next(g[2] for g in region.generators if g[2])
    origin = (one - one, one - one, one / one)
    for g, h in pairwise([*region.generators, first]):
        if sign(cross(g[:2], h[:2])) > 0:
            yield origin, g, h


def _without_radius(polynomial: Polynomial, side: int) -> tuple[Polynomial, Polynomial]:
    """``(A, B)`` with ``polynomial = A + r B`` for theta of the given sign, in (x, y) or (x, y, |theta|)."""
    field = polynomial.field
    if polynomial.variables == PLANE:
        return polynomial, Polynomial(field, PLANE, {})
    variables = (*PLANE, "abs_theta") if side else PLANE
    x, y = (Polynomial.variable(field, variables, name) for name in PLANE)
    size = Polynomial.variable(field, variables, "abs_theta") if side else Polynomial.constant(field, variables, 0)
    parts: list[Polynomial] = []
    for odd in (0, 1):
        chosen: Terms = {(*e[:4], e[4] // 2): c for e, c in polynomial.terms.items() if e[4] % 2 == odd}
        parts.append(Polynomial(field, EXTENDED, chosen).composed([x, y, size * side, size, x * x + y * y]))
    return parts[0], parts[1]


def _padded(guard: Polynomial, side: int) -> Polynomial:
    """A guard in (x, y) as a polynomial in the form's variables."""
    if not side:
        return guard
    return Polynomial(guard.field, (*PLANE, "abs_theta"), {(*e, 0): c for e, c in guard.terms.items()})
