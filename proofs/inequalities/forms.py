"""Signs of forms on simplicial cones, read off their coefficients in the generators.

A polynomial on a polygon, a cone or a cone x line is a form on cones of linearly independent generators
(:mod:`nonsmooth.proofs.inequalities.cell_forms`).  Written in the generators, ``F(sum lambda_i g_i) = sum c_e
lambda^e``, it is non-negative if all ``c_e`` are (Bernstein's form without the binomials), and then it vanishes on a
face exactly if no monomial with a positive coefficient lives on that face alone: strictness is read off.  Where some
coefficient is negative the cone is cut in two (:mod:`nonsmooth.proofs.inequalities.subdivision`).

F may hold the distance: ``F = A + r B`` with ``r = sqrt(x^2 + y^2)``.  Then ``A, B >= 0``, or ``A >= 0`` and
``A^2 >= r^2 B^2``, or ``B >= 0`` and ``r^2 B^2 >= A^2`` prove it; where F > 0 one of the three holds strictly nearby.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, lru_cache
from typing import Any, TypeAlias

from flint import fmpq

from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.polynomial import Polynomial, Terms, add_terms, in_generators, multiply_terms

Vector: TypeAlias = tuple[Any, ...]

IRRATIONAL_WORK = 4  # a product of two irrational terms costs about this many rational ones


class Role(Enum):
    """What a generator is to the cell."""

    POINT = "a point of the cell"
    ORIGIN = "the origin"
    LIMIT = "a direction in which points of the cell lie, but no point itself"


@dataclass(frozen=True)
class Form:
    """``plain + r * radial``, homogeneous in (x, y[, theta][, w]).

    Attributes:
        plain: the part without r.
        radial: the factor of r, of one degree less; None where there is none.
        weighted: whether the last variable is w, so that generators with ``w = 0`` are no points.
    """

    plain: Polynomial
    radial: Polynomial | None
    weighted: bool

    @property
    def degree(self) -> int:
        """Of the whole form."""
        return self.plain.degree if self.plain or self.radial is None else self.radial.degree + 1


@dataclass(frozen=True)
class Problem:
    """``form >= 0`` (or ``> 0``) on the closed cone of independent generators.

    Attributes:
        form: the form.
        generators: of the cone, in the form's variables.
        strict: whether > 0 is claimed at the points of the cell.
        except_origin: whether the origin is left out of a strict claim.
        holds_axis: whether the theta axis belongs to the cell (it is a mere limit otherwise).
        guards: forms; the cell is the closure of the part of the cone where all are positive.
    """

    form: Form
    generators: tuple[Vector, ...]
    strict: bool
    except_origin: bool
    holds_axis: bool = True
    guards: tuple[Polynomial, ...] = ()

    def role(self, generator: Vector) -> Role:
        """What a generator of a part of the cone is."""
        if not self.form.weighted:
            return Role.POINT if self.holds_axis or any(generator[:2]) else Role.LIMIT
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

    @cached_property
    def coefficients(self) -> Pieces:
        """The form's parts and the guards, in the generators."""
        return self.pieces(self.generators)

    def pieces(self, generators: Sequence[Vector]) -> Pieces:
        """The form's parts and the guards in the generators of a part of the cone, straight from the definition."""
        light = [tuple(simplest(x) for x in g) for g in generators]
        parts = [self.form.plain, *([] if self.form.radial is None else [self.form.radial]), *self.guards]
        terms = [in_generators({e: simplest(c) for e, c in part.terms.items()}, light) for part in parts]
        first_guard = len(parts) - len(self.guards)
        return Pieces(terms[0], terms[1] if first_guard == 2 else None, tuple(terms[first_guard:]))

    def square_of_distance(self, generators: Sequence[Vector]) -> Terms:
        """``x^2 + y^2`` in the generators."""
        return in_generators(
            {tuple(2 * int(k == axis) for k in range(len(generators[0]))): 1 for axis in (0, 1)},
            [tuple(simplest(x) for x in g) for g in generators],
        )

    def settles(self, generators: Sequence[Vector], pieces: Pieces) -> bool:
        """Whether the coefficients prove the claim on a part of the cone."""
        faces = self.strict_faces(generators, except_origin=self.except_origin) if self.strict else []
        if self._form_settles(generators, pieces, faces):
            return True
        return any(self._is_outside(generators, pieces, guard) for guard in pieces.guards)

    def is_violated_at(self, point: Vector) -> bool:
        """Whether a vector is a point of the cell (inside all guards) at which the claim is false."""
        role = self.role(point)
        if role is Role.LIMIT or (role is Role.ORIGIN and self.except_origin):
            return False
        if any(sign(guard(point)) <= 0 for guard in self.guards):
            return False
        radial = 0 if self.form.radial is None else self.form.radial(point)
        here = surd_sign(self.form.plain(point), radial, point[0] * point[0] + point[1] * point[1])
        return here < 0 or (self.strict and here == 0)

    def _form_settles(self, generators: Sequence[Vector], pieces: Pieces, faces: list[int]) -> bool:
        plain, radial = pieces.plain, pieces.radial
        if radial is None:
            return is_nonnegative(plain) and all(has_positive(plain, face) for face in faces)
        off_axis = sum(1 << k for k, g in enumerate(generators) if any(g[:2]))
        if is_nonnegative(plain) and is_nonnegative(radial):
            return all(has_positive(plain, f) or (f & off_axis and has_positive(radial, f)) for f in faces)
        for larger in (plain, radial):
            if is_nonnegative(larger):
                difference = self._difference_of_squares(generators, pieces)
                difference = difference if larger is plain else {e: -c for e, c in difference.items()}
                return is_nonnegative(difference) and all(has_positive(difference, face) for face in faces)
        return False

    def _difference_of_squares(self, generators: Sequence[Vector], pieces: Pieces) -> Terms:
        """``A^2 - r^2 B^2``."""
        radial = pieces.radial or {}
        square = multiply_terms(self.square_of_distance(generators), multiply_terms(radial, radial))
        return add_terms(multiply_terms(pieces.plain, pieces.plain), {e: -c for e, c in square.items()})

    def _is_outside(self, generators: Sequence[Vector], pieces: Pieces, guard: Terms) -> bool:
        """Whether a guard shows that the part meets the cell at most in corners, where the claim is tested."""
        negative = {e: -c for e, c in guard.items()}
        roles = [self.role(g) for g in generators]
        inside = [k for k, role in enumerate(roles) if role is not Role.LIMIT]
        edges = [1 << k | 1 << j for k in inside for j in range(len(roles)) if j != k]
        if not is_nonnegative(negative) or not all(has_positive(negative, edge) for edge in edges):
            return False
        left_out = [Role.ORIGIN] if self.except_origin else []
        touched = [k for k in inside if not has_positive(negative, 1 << k) and roles[k] not in left_out]
        return all(face_sign(pieces, generators, 1 << k) >= int(self.strict) for k in touched)


@dataclass(frozen=True)
class Pieces:
    """Coefficients in the generators of a part of the cone."""

    plain: Terms
    radial: Terms | None
    guards: tuple[Terms, ...]

    @cached_property
    def work(self) -> int:
        """What it costs to look at this part and cut it in two, in products of rational coefficients."""
        parts = (self.plain, self.radial or {}, *self.guards)
        sizes = [len(c.terms) if isinstance(c, Number) else 0 for t in parts for c in t.values()]
        squares = len(self.plain) + len(self.radial) if self.radial else 1  # A^2 - r^2 B^2
        return squares * sum(IRRATIONAL_WORK * size**2 if size else 1 for size in sizes)

    def mapped(self, change: Callable[[Terms], Terms]) -> Pieces:
        """Every part changed in the same way."""
        radial = None if self.radial is None else change(self.radial)
        return Pieces(change(self.plain), radial, tuple(change(guard) for guard in self.guards))


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


def surd_sign(plain: Any, radial: Any, square: Any) -> int:
    """Sign of ``plain + radial sqrt(square)``."""
    first, second = sign(plain), sign(radial) * sign(square)
    if first * second >= 0:
        return first or second
    return first * sign(plain * plain - radial * radial * square)


def face_sign(pieces: Pieces, generators: Sequence[Vector], face: int) -> int:
    """Sign of the form at the sum of a face's generators."""
    plain, radial = (
        sum((c for e, c in t.items() if not support(e) & ~face), fmpq(0)) for t in (pieces.plain, pieces.radial or {})
    )
    if not radial:
        return sign(plain)
    x, y = (simplest(v) for v in face_sum(generators, face)[:2])
    return surd_sign(plain, radial, x * x + y * y)


def face_sum(generators: Sequence[Vector], face: int) -> Vector:
    """Sum of a face's generators."""
    chosen = [g for k, g in enumerate(generators) if face >> k & 1]
    return tuple(sum(column[1:], column[0]) for column in zip(*chosen, strict=True))
