"""Signs of polynomials on cells as signs of forms on simplicial cones, read off their coefficients in the generators.

*Cells.*  A homogeneous polynomial has one sign along each ray from the origin, so only the directions of the cell
matter: a region gives cones of two rays.  (Not so an unbounded region without the origin: it tends to directions that
none of its points has.)  Any other polynomial is made a form by the variable w, and the region's triangles, seen from
the origin where the region holds it, give cones of generators ``(x, y, w)``.

*Coefficients.*  Written in the generators, ``F(sum lambda_i g_i) = sum c_e lambda^e``, a form is non-negative if all
``c_e`` are (Bernstein's form without the binomials), and then it vanishes on a face exactly if no monomial with a
positive coefficient lives on that face alone: strictness is read off.  Beside a curve ``g = 0`` it is enough that this
holds of ``F - c g`` with a number c >= 0.  Where some coefficient is negative the cone is cut in two
.

*Subdivision.*  The longest edge is halved, breadth first, so that a point that refutes the claim is met early and all
parts shrink: the search ends wherever the form is positive.  It does not end at a zero inside the cone or inside an
edge; then other ways (:mod:`nonsmooth.proofs.inequalities.prover`) prove it, or propose where to cut.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum, StrEnum
from fractions import Fraction
from functools import cached_property, lru_cache
from itertools import combinations, pairwise
from typing import Any, TypeAlias

from flint import fmpq

from nonsmooth.analysis.cells.region import Region, Triple
from nonsmooth.proofs.inequalities.effort import take_effort
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import (
    Polynomial,
    Terms,
    add_terms,
    in_generators,
    multiply_terms,
    with_mixture,
)
from nonsmooth.symbolic.plane import cross

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


Vector: TypeAlias = tuple[Any, ...]

LONG_BITS = 512  # of a rational coefficient that costs as much again as a short one
IRRATIONAL_WORK = 4  # a product of two irrational terms costs about this many rational ones


class Role(Enum):
    """What a generator is to the cell."""

    POINT = "a point of the cell"
    ORIGIN = "the origin"
    LIMIT = "a direction in which points of the cell lie, but no point itself"


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

    def role(self, generator: Vector) -> Role:
        """What a generator of a part of the cone is."""
        if not self.weighted:
            return Role.POINT
        if not generator[-1]:
            return Role.LIMIT
        return Role.POINT if any(generator[:-1]) else Role.ORIGIN

    def strict_faces(self, generators: Sequence[Vector], *, except_origin: bool) -> list[int]:
        """Smallest faces (bit masks of generators) whose inner points must not be zeros of a strict claim."""
        roles = [self.role(g) for g in generators]
        faces = [1 << k for k, role in enumerate(roles) if role is Role.POINT]
        for k, role in enumerate(roles):
            if role is Role.ORIGIN:
                faces += [1 << k | 1 << j for j, other in enumerate(roles) if other is Role.LIMIT]
                faces += [] if except_origin else [1 << k]
        return faces

    def part(self, generators: Sequence[Vector]) -> SubCone:
        """A part of the cone with the form and the guards in its generators, straight from the definition."""
        light = [tuple(simplest(x) for x in g) for g in generators]
        form, *guards = (
            in_generators({e: simplest(c) for e, c in own.terms.items()}, light) for own in (self.form, *self.guards)
        )
        count = len(generators)
        places = tuple(tuple(Fraction(int(i == k)) for i in range(count)) for k in range(count))
        return SubCone(tuple(generators), places, form, tuple(guards), 0)

    @cached_property
    def whole(self) -> SubCone:
        """The cone itself."""
        return self.part(self.generators)

    def settles(self, part: SubCone) -> bool:
        """Whether the coefficients prove the claim on a part of the cone."""
        generators, count = part.generators, len(part.generators)
        faces = self.strict_faces(generators, except_origin=self.except_origin) if self.strict else []
        if is_nonnegative(part.form) and all(has_positive(part.form, face) for face in faces):
            return True
        masks = [m for m in range(1 << count) if any(not face & ~m for face in faces)]
        return any(
            self._is_outside(part, guard) or follows_from(raised(part.form, part), raised(guard, part), masks)
            for guard in part.guards
        )

    def is_violated_at(self, point: Vector) -> bool:
        """Whether a vector is a point of the cell (inside all guards) at which the claim is false."""
        role = self.role(point)
        if role is Role.LIMIT or (role is Role.ORIGIN and self.except_origin):
            return False
        if any(sign(guard(point)) <= 0 for guard in self.guards):
            return False
        here = sign(self.form(point))
        return here < 0 or (self.strict and here == 0)

    def _is_outside(self, part: SubCone, guard: Terms) -> bool:
        """Whether a guard shows that the part meets the cell at most in corners, where the claim is tested."""
        negative = {e: -c for e, c in guard.items()}
        roles = [self.role(g) for g in part.generators]
        inside = [k for k, role in enumerate(roles) if role is not Role.LIMIT]
        edges = [1 << k | 1 << j for k in inside for j in range(len(roles)) if j != k]
        if not is_nonnegative(negative) or not all(has_positive(negative, edge) for edge in edges):
            return False
        left_out = [Role.ORIGIN] if self.except_origin else []
        touched = [k for k in inside if not has_positive(negative, 1 << k) and roles[k] not in left_out]
        return all(face_sign(part.form, 1 << k) >= int(self.strict) for k in touched)


@dataclass(frozen=True, slots=True)
class SubCone:
    """A part of the cone on its way to being proved.

    Attributes:
        generators: of the part.
        places: the generators in the root's barycentric coordinates (halvings only), which measure its size.
        form: the coefficients of the form in the generators.
        guards: those of the guards.
        depth: number of cuts above it.
    """

    generators: tuple[Vector, ...]
    places: tuple[Vector, ...]
    form: Terms
    guards: tuple[Terms, ...]
    depth: int

    @property
    def work(self) -> int:
        """What it costs to look at this part and cut it in two, in products of short rational coefficients."""
        return sum(_work_of(c) for terms in (self.form, *self.guards) for c in terms.values())

    def with_corner(self, kept: int, replaced: int, share: Any) -> SubCone:
        """The part in which ``(1 - share) g_kept + share g_replaced`` takes the place of ``g_replaced``."""

        def changed(terms: Terms) -> Terms:
            return with_mixture(terms, kept, replaced, 1 - share, share)

        return SubCone(
            _with_mixed(self.generators, kept, replaced, share),
            _with_mixed(self.places, kept, replaced, Fraction(1, 2)),
            changed(self.form),
            tuple(map(changed, self.guards)),
            self.depth + 1,
        )


def _with_mixed(vectors: Sequence[Vector], kept: int, replaced: int, share: Any) -> tuple[Vector, ...]:
    mixed = tuple(a * (1 - share) + b * share for a, b in zip(vectors[kept], vectors[replaced], strict=True))
    return (*vectors[:replaced], mixed, *vectors[replaced + 1 :])


def _work_of(coefficient: Any) -> int:
    """Of one coefficient: by its length, or by its number of irrational terms."""
    if isinstance(coefficient, Number):
        return IRRATIONAL_WORK * len(coefficient.terms) ** 2 or 1
    return 1 + (coefficient.height_bits() // LONG_BITS if isinstance(coefficient, fmpq) else 0)


def simplest(value: Any) -> Any:
    """A rational number without its field (its arithmetic is ten times faster); anything else as it is."""
    rational = value.as_rational() if isinstance(value, Number) else None
    return value if rational is None else rational


@lru_cache(maxsize=1 << 14)
def support(exponents: tuple[int, ...]) -> int:
    """The generators that occur in a monomial, as a bit mask."""
    return sum(1 << k for k, e in enumerate(exponents) if e)


def is_nonnegative(terms: Terms) -> bool:
    """Whether no coefficient is negative."""
    return all(sign(c) >= 0 for c in terms.values())


def has_positive(terms: Terms, face: int) -> bool:
    """Whether a monomial on the face alone has a positive coefficient."""
    return any(sign(c) > 0 for e, c in terms.items() if not support(e) & ~face)


def follows_from(form: Terms, guard: Terms, faces: Sequence[int]) -> bool:
    """Whether a form is ``>= 0`` where a guard of the same degree is, and ``> 0`` there inside some faces.

    In ``p = c g + r`` with c >= 0 no coefficient of r is negative.  Inside each face r is positive, or g is negative
    (no point of the cell lies there), or ``c g`` is positive.
    """
    factor = multiplier(form, guard)
    if factor is None:
        return False
    rest = add_terms(form, {e: -c * factor for e, c in guard.items()})
    telling = {-1, 1} if factor else {-1}
    return all(has_positive(rest, face) or one_sign(guard, face) in telling for face in faces)


def multiplier(form: Terms, taken: Terms, *, signed: bool = True) -> Any:
    """The middle of the numbers c for which no coefficient of ``form - c taken`` is negative; None without any.

    Args:
        form: a form.
        taken: another one, of the same degree.
        signed: whether c must not be negative.
    """
    taken = {e: c for e, c in taken.items() if sign(c)}
    if any(sign(c) < 0 and e not in taken for e, c in form.items()):
        return None
    ratios = [(sign(c), form.get(e, 0 * c) / c) for e, c in taken.items()]
    least = max((ratio for side, ratio in ratios if side < 0), default=None)
    most = min((ratio for side, ratio in ratios if side > 0), default=None)
    if signed and (least is None or sign(least) < 0):
        least = fmpq(0)
    if least is None:
        return None if most is None else most - 1
    if most is None:
        return least + 1
    return (least + most) / 2 if least <= most else None


def raised(terms: Terms, part: SubCone) -> Terms:
    """A form of a part times a power of w, so that it has the largest degree of the forms of the part."""
    top = max(sum(e) for own in (part.form, *part.guards) for e in own)
    weight = in_generators({(1,): 1}, [(g[-1],) for g in part.generators])
    while terms and sum(next(iter(terms))) < top:
        terms = multiply_terms(terms, weight)
    return terms


def one_sign(terms: Terms, face: int) -> int:
    """The sign that all coefficients of a form on a face share, and with them its values inside; 0 without one."""
    signs = {sign(c) for e, c in terms.items() if not support(e) & ~face}
    return signs.pop() if len(signs) == 1 else 0


def face_sign(form: Terms, face: int) -> int:
    """Sign of a form at the sum of a face's generators."""
    return sign(sum((c for e, c in form.items() if not support(e) & ~face), fmpq(0)))


def face_sum(generators: Sequence[Vector], face: int) -> Vector:
    """Sum of a face's generators."""
    chosen = [g for k, g in enumerate(generators) if face >> k & 1]
    return tuple(sum(column[1:], column[0]) for column in zip(*chosen, strict=True))


NEARBY_STEPS = 40  # distances 4^-k tried beside a corner that is no point of the claim


@dataclass(frozen=True)
class Stuck:
    """Generators of a part of the cone on which the sign was not found."""

    generators: tuple[Vector, ...]


@dataclass(frozen=True)
class Violation:
    """A point, in the form's variables, at which the claim is false."""

    point: Vector


Cut: TypeAlias = Callable[["SubCone"], "tuple[int, int, Any] | Violation | None"]


def subdivide(problem: Problem, budget: int, cut: Cut | None = None) -> Violation | Stuck | None:
    """Prove by coefficients, breadth first, within a budget; None where the claim is proved.

    Args:
        problem: the claim.
        budget: work that may be done, in coefficients (those of one part at least).
        cut: proposes where to split a part because the form touches zero on its edge.
    """
    waiting = deque([problem.whole])
    while waiting and budget > 0:
        part = waiting.popleft()
        work = part.work
        budget -= work
        take_effort(work)
        if problem.settles(part):
            continue
        violation = _violation(problem, part)
        if violation is not None:
            return violation
        split = cut(part) if cut is not None else None
        if isinstance(split, Violation):
            return split
        first, second, share = split or (*_edge_to_halve(part), fmpq(1, 2))
        waiting.append(part.with_corner(first, second, share))
        waiting.append(part.with_corner(second, first, 1 - share))
    return Stuck(waiting[0].generators) if waiting else None


def _edge_to_halve(part: SubCone) -> tuple[int, int]:
    """The longest edge as seen in the root's barycentric coordinates, so that all parts shrink.

    Near a corner where the form is zero its sign may depend on the direction alone, and halving the longest edge would
    give similar parts for ever: every second time only edges between other corners are looked at.
    """
    corners = range(len(part.generators))
    others = [k for k in corners if face_sign(part.form, 1 << k)] if part.depth % 2 else []
    if part.depth % 2 and len(others) < 2 and any(part.guards):
        # beside a curve that ends at the origin, and zero at another corner too: halving at the origin leads nowhere
        others = [k for k in corners if any(part.generators[k][:-1])]
    return max(
        combinations(others if len(others) > 1 else corners, 2),
        key=lambda edge: sum((a - b) ** 2 for a, b in zip(part.places[edge[0]], part.places[edge[1]], strict=True)),
    )


def _violation(problem: Problem, part: SubCone) -> Violation | None:
    """A point of the part where the claim is false, if a corner, a strict face or the middle shows one."""
    generators, count = part.generators, len(part.generators)
    faces = problem.strict_faces(generators, except_origin=problem.except_origin) if problem.strict else []
    for face in dict.fromkeys([*(1 << k for k in range(count)), (1 << count) - 1, *faces]):
        here = face_sign(part.form, face)
        if here < 0 or (here == 0 and face in faces):
            point = face_sum(generators, face)
            if problem.is_violated_at(point):
                return Violation(point)
            if here < 0 and not problem.guards and problem.role(point) is not Role.POINT:
                nearby = _towards(problem, point, generators)
                if nearby is not None:
                    return nearby
    return None


def _towards(problem: Problem, start: Vector, generators: Sequence[Vector]) -> Violation | None:
    """A violating point near a direction or the origin, which are no points of the claim themselves."""
    for k in range(NEARBY_STEPS):
        for other in generators:
            point = tuple(a + b * fmpq(1, 4**k) for a, b in zip(start, other, strict=True))
            if problem.is_violated_at(point):
                return Violation(point)
    return None
