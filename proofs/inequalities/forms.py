"""Signs of polynomials on cells of the plane as signs of forms on simplicial cones.

*Cells.*  A homogeneous polynomial has one sign along each ray from the origin, so only the directions of the cell
matter: a region gives cones of two rays.  (Not so an unbounded region without the origin: it tends to directions that
none of its points has.)  Any other polynomial is made a form by the variable w, and the region's triangles, seen from
the origin where the region holds it, give cones of generators ``(x, y, w)``.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from enum import StrEnum
from functools import cached_property
from itertools import pairwise
from typing import Any

from nonsmooth.analysis.cells.region import Region, Triple
from nonsmooth.proofs.inequalities.subdivision import (
    FormsClaim,
    Proposal,
    Role,
    SubCone,
    UndecidedCorners,
    Vector,
    Violation,
    root_part,
    shown_by,
    subdivide,
)
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.plane import cross
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators

PLANE = ("x", "y")


class Sense(StrEnum):
    """What is claimed of a polynomial."""

    NEGATIVE = "<0"
    NONPOSITIVE = "<=0"
    POSITIVE = ">0"
    NONNEGATIVE = ">=0"

    @property
    def strict(self) -> bool:
        """Whether zero is excluded."""
        return self in (Sense.NEGATIVE, Sense.POSITIVE)

    @property
    def factor(self) -> int:
        """By which the polynomial is multiplied to make the claim ``>= 0`` or ``> 0``."""
        return -1 if self in (Sense.NEGATIVE, Sense.NONPOSITIVE) else 1


@dataclass(frozen=True)
class Question:
    """What is to be proved of a polynomial on a closed region of the plane.

    Attributes:
        sense: the sign that is claimed.
        polynomial: in (x, y).
        region: closed.
        except_origin: whether a strict claim leaves the origin out.
    """

    sense: Sense
    polynomial: Polynomial
    region: Region
    except_origin: bool

    @cached_property
    def claimed(self) -> Polynomial:
        """What is claimed to be ``>= 0``, or ``> 0``."""
        return self.polynomial * self.sense.factor

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

    def fails_at(self, point: Vector) -> bool:
        """Whether a point of the cell, strictly inside all guards, refutes the claim."""
        if self.except_origin and not any(point):
            return False
        place = (point[0], point[1])
        if not self.region.contains(place) or any(sign(guard(place)) <= 0 for guard in self.region.guards):
            return False
        here = sign(self.claimed(place))
        return here < 0 or (here == 0 and self.sense.strict)


def build_parts(question: Question) -> Iterator[Problem]:
    """The claim on simplicial cones that cover the cell."""
    claimed, region, strict = question.claimed, question.region, question.sense.strict
    if claimed.is_homogeneous and question.directions_are_attained:
        for rays in directions(region):
            yield Problem(claimed, False, rays, strict, question.except_origin)
        return
    form, guards = claimed.homogenized(), tuple(guard.homogenized() for guard in region.guards)
    for triangle in triangles(region, holds_origin=question.holds_origin):
        yield Problem(form, True, triangle, strict, question.except_origin, guards)


def place_of(vector: Vector, part: Problem, question: Question) -> Vector:
    """The point (x, y) of the cell that a vector in the variables of a part stands for."""
    field = question.polynomial.field
    exact = [v if hasattr(v, "sign") else field(v) for v in vector]
    if part.weighted:
        *exact, scale = exact
        return tuple(v / scale for v in exact) if scale else tuple(exact)
    scale = question.region.reach(exact[0], exact[1])
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


@dataclass(frozen=True)
class Problem:
    """``form >= 0`` (or ``> 0``) on the closed cone of independent generators.

    Attributes:
        form: homogeneous in (x, y[, w]).
        weighted: whether the last variable is w, so that generators with ``w = 0`` are no points.
        generators: of the cone, in the form's variables.
        strict: whether > 0 is claimed at the points of the cell.
        except_origin: whether the origin is left out of a strict claim.
        guards: forms; the cell is the closure of the part of the cone where all are positive.
    """

    form: Polynomial
    weighted: bool
    generators: tuple[Vector, ...]
    strict: bool
    except_origin: bool
    guards: tuple[Polynomial, ...] = ()

    @cached_property
    def sought(self) -> FormsClaim:
        """What is claimed, without the forms."""
        return FormsClaim(self.strict, not self.except_origin, self.weighted, by_sides=True)

    def role(self, generator: Vector) -> Role:
        """What a vector is to the cell."""
        return self.sought.role(generator)

    def part(self, generators: Sequence[Vector]) -> SubCone:
        """A part of the cone with the form and the guards in its generators, straight from the definition."""
        light = [tuple(simplest(x) for x in g) for g in generators]
        form, *guards = (
            in_generators({e: simplest(c) for e, c in polynomial.terms.items()}, light)
            for polynomial in (self.form, *self.guards)
        )
        return root_part(generators, [[form]], [{str(k): guard for k, guard in enumerate(guards)}])

    @cached_property
    def whole(self) -> SubCone:
        """The cone itself."""
        return self.part(self.generators)

    def is_violated_at(self, point: Vector) -> bool:
        """Whether a vector is a point of the cell (inside all guards) at which the claim is false."""
        if not self.sought.is_about(point) or any(sign(guard(point)) <= 0 for guard in self.guards):
            return False
        here = sign(self.form(point))
        return here < 0 or (self.strict and here == 0)

    def subdivided(self, work: int, propose: Proposal | None = None) -> Violation | UndecidedCorners | None:
        """What stands against the claim after some work of cutting; None where it is proved.

        Args:
            work: coefficients that may be looked at.
            propose: where to cut a part because the form touches zero on its edge.
        """
        return subdivide([self.whole], self.sought, work, lambda part: shown_by(part, self.sought, 0), propose)


def simplest(value: Any) -> Any:
    """A rational number without its field (its arithmetic is ten times faster); anything else as it is."""
    rational = value.as_rational() if isinstance(value, Number) else None
    return value if rational is None else rational
