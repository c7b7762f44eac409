"""Signs of forms on simplicial cones, read off their coefficients in the generators.

A polynomial on a polygon or a cone is a form on cones of linearly independent generators
(:mod:`nonsmooth.proofs.inequalities.cell_forms`).  Written in the generators, ``F(sum lambda_i g_i) = sum c_e
lambda^e``, it is non-negative if all ``c_e`` are (Bernstein's form without the binomials), and then it vanishes on a
face exactly if no monomial with a positive coefficient lives on that face alone: strictness is read off.  Beside a
curve ``g = 0`` it is enough that this holds of ``F - c g`` with a number c >= 0.  Where some coefficient is negative
the cone is cut in two (:mod:`nonsmooth.proofs.inequalities.subdivision`).
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

    @cached_property
    def coefficients(self) -> Pieces:
        """The form and the guards, in the generators."""
        return self.pieces(self.generators)

    def pieces(self, generators: Sequence[Vector]) -> Pieces:
        """The form and the guards in the generators of a part of the cone, straight from the definition."""
        light = [tuple(simplest(x) for x in g) for g in generators]
        form, *guards = (
            in_generators({e: simplest(c) for e, c in part.terms.items()}, light) for part in (self.form, *self.guards)
        )
        return Pieces(form, tuple(guards))

    def settles(self, generators: Sequence[Vector], pieces: Pieces) -> bool:
        """Whether the coefficients prove the claim on a part of the cone."""
        faces = self.strict_faces(generators, except_origin=self.except_origin) if self.strict else []
        if is_nonnegative(pieces.form) and all(has_positive(pieces.form, face) for face in faces):
            return True
        count = len(generators)
        masks = [m for m in range(1 << count) if any(not face & ~m for face in faces)]
        return any(
            self._is_outside(generators, pieces, guard)
            or follows_from(raised(pieces.form, pieces, generators), raised(guard, pieces, generators), masks)
            for guard in pieces.guards
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
        return all(face_sign(pieces, 1 << k) >= int(self.strict) for k in touched)


@dataclass(frozen=True)
class Pieces:
    """Coefficients in the generators of a part of the cone."""

    form: Terms
    guards: tuple[Terms, ...]

    @cached_property
    def work(self) -> int:
        """What it costs to look at this part and cut it in two, in products of short rational coefficients."""
        return sum(_work_of(c) for terms in (self.form, *self.guards) for c in terms.values())

    def mapped(self, change: Callable[[Terms], Terms]) -> Pieces:
        """Every part changed in the same way."""
        return Pieces(change(self.form), tuple(change(guard) for guard in self.guards))


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

    In ``p = c g + r`` with c >= 0 no coefficient of r is negative; inside each face r is positive, or g has one sign.
    """
    factor = multiplier(form, guard)
    if factor is None:
        return False
    rest = add_terms(form, {e: -c * factor for e, c in guard.items()})
    return all(has_positive(rest, face) or has_one_sign(guard, face) for face in faces)


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


def raised(terms: Terms, pieces: Pieces, generators: Sequence[Vector]) -> Terms:
    """A form of a part times a power of w, so that it has the largest degree of the forms of the part."""
    top = max(sum(e) for own in (pieces.form, *pieces.guards) for e in own)
    weight = in_generators({(1,): 1}, [(g[-1],) for g in generators])
    while terms and sum(next(iter(terms))) < top:
        terms = multiply_terms(terms, weight)
    return terms


def has_one_sign(terms: Terms, face: int) -> bool:
    """Whether the coefficients of a form on a face have one sign, and not all are zero."""
    return {sign(c) for e, c in terms.items() if not support(e) & ~face} in ({1}, {-1})


def face_sign(pieces: Pieces, face: int) -> int:
    """Sign of the form at the sum of a face's generators."""
    return sign(sum((c for e, c in pieces.form.items() if not support(e) & ~face), fmpq(0)))


def face_sum(generators: Sequence[Vector], face: int) -> Vector:
    """Sum of a face's generators."""
    chosen = [g for k, g in enumerate(generators) if face >> k & 1]
    return tuple(sum(column[1:], column[0]) for column in zip(*chosen, strict=True))
