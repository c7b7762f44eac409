"""From polynomials on closed cells to forms on simplicial cones.

A homogeneous polynomial has one sign along each ray from the origin, so only the directions of the cell matter: a
region gives cones of two rays.  (Not so an unbounded region without the origin: it tends to directions that none of its
points has.)  Any other polynomial is made a form by the variable w, and the region's triangles, seen from the origin
where the region holds it, give cones of generators ``(x, y, w)``.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

from nonsmooth.analysis.cells.region import Region, Triple
from nonsmooth.proofs.inequalities.forms import Problem, Vector
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.plane import cross

PLANE = ("x", "y")


@dataclass(frozen=True)
class CellClaim:
    """``polynomial >= 0`` (or ``> 0``) on a closed region.

    Attributes:
        polynomial: in (x, y).
        region: the closed region of the plane.
        strict: whether > 0 is claimed.
        except_origin: whether a strict claim leaves the origin out.
    """

    polynomial: Polynomial
    region: Region
    strict: bool
    except_origin: bool = False

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


def build_parts(claim: CellClaim) -> Iterator[Problem]:
    """The claim on simplicial cones that cover the cell."""
    if claim.polynomial.is_homogeneous and claim.directions_are_attained:
        for rays in directions(claim.region):
            yield Problem(claim.polynomial, False, rays, claim.strict, claim.except_origin)
        return
    form, guards = claim.polynomial.homogenized(), tuple(guard.homogenized() for guard in claim.region.guards)
    for triangle in triangles(claim.region, holds_origin=claim.holds_origin):
        yield Problem(form, True, triangle, claim.strict, claim.except_origin, guards)


def place_of(vector: Vector, part: Problem, claim: CellClaim) -> Vector:
    """The point (x, y) of the cell that a vector in the variables of a part stands for."""
    field = claim.polynomial.field
    exact = [v if hasattr(v, "sign") else field(v) for v in vector]
    if part.weighted:
        *exact, scale = exact
        return tuple(v / scale for v in exact) if scale else tuple(exact)
    scale = claim.region.reach(exact[0], exact[1])
    return tuple(v * scale for v in exact)


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
