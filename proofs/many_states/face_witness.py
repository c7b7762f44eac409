"""Points of faces at which V increases: where V bends, and solutions that slide raise it.

At a rational point of a face let ``l_j = 0`` for j in Z, with no other surface through it, and let f_i be the fields
of all cells that meet there.  A mixture with ``sum_i w_i grad l_j . f_i = 0`` for j in Z is a velocity along the face,
and V(c(t)) has the derivative ``sum_i w_i g . f_i`` with the gradient g of any one piece.  A linear program finds
the largest.  If it is positive, with as many positive weights as there are equations, then these weights depend
continuously on the place near the point: there is a solution along the face, and V rises along it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.proofs.kernel.sign_cells import RationalTerms, SignCell, SignCells, rational_terms
from nonsmooth.proofs.many_states.affine_faces import AffineFace, build_face, unit
from nonsmooth.proofs.many_states.samples import Point, exact_value
from nonsmooth.symbolic.numbers.polynomial import Exponents

POINTS = 80  # of one face, half of them at the largest distance
HALVINGS = 6  # of the distance from the point
FINE = 1 << 6  # denominator of a coordinate, in parts of its distance
EXTREME = 0.5  # the share of coordinates that are least or largest

Pieces = Mapping[tuple[int, ...], Sequence[RationalTerms]]


def rising_slide(cells: SignCells, pieces: Pieces, zero: Sequence[int]) -> tuple[Point, fmpq] | None:
    """A point of a face and a positive derivative of V along a solution from there; None where none is found.

    Args:
        cells: of a cube about the checked point; all of their fields may act.
        pieces: of every cell, V as its only polynomial.
        zero: the surfaces that vanish on the face.
    """
    surfaces = [rational_terms(surface) for surface in cells.surfaces]
    face = build_face([surfaces[j] for j in zero], len(cells.states))
    if face is None or not face.dimension:
        return None
    for point in _points(face, cells.radius):
        signs = [_sign(exact_value(surface, point)) for surface in surfaces]
        if not _is_clear(cells, surfaces, signs):
            continue
        around = [cell for cell in cells.cells if all(s in {0, c} for s, c in zip(signs, cell.signs, strict=True))]
        rise = _largest_rise(cells, [surfaces[j] for j, s in enumerate(signs) if not s], around, pieces, point)
        if rise is not None:
            return point, rise
    return None


def _points(face: AffineFace, radius: fmpq) -> Iterator[Point]:
    """Rational points of a face in the cube, nearer and farther; many of them near its border or near other faces."""
    rng = np.random.default_rng(0)
    for _ in range(POINTS):
        scale = radius / fmpq(FINE << max(0, int(rng.integers(-HALVINGS, HALVINGS))))
        inside = rng.integers(1, FINE, face.dimension)
        sizes = np.where(rng.random(face.dimension) < EXTREME, rng.choice((1, FINE), face.dimension), inside)
        free = [scale * int(k) for k in sizes * rng.choice((-1, 1), face.dimension)]
        point = tuple(exact_value(form, free) for form in face.coordinates)
        if any(point) and all(abs(x) <= radius for x in point):
            yield point


def _is_clear(cells: SignCells, surfaces: Sequence[RationalTerms], signs: Sequence[int]) -> bool:
    """Whether every listed cell with the signs of a point meets there.

    That is so if all surfaces are planes, for a segment from the point into such a cell keeps its signs; and if the
    surfaces through the point are planes in general position.
    """
    here = [j for j, s in enumerate(signs) if not s]
    if all(surface.degree == 1 for surface in cells.surfaces):
        return True
    count = len(cells.states)
    return all(cells.surfaces[j].degree == 1 for j in here) and _rank([surfaces[j] for j in here], count) == len(here)


def _rank(forms: Sequence[RationalTerms], count: int) -> int:
    rows = [[form.get(unit(count, k), fmpq(0)) for k in range(count)] for form in forms]
    return int(fmpq_mat(rows).rank())


def _largest_rise(
    cells: SignCells, through: Sequence[RationalTerms], around: Sequence[SignCell], pieces: Pieces, point: Point
) -> fmpq | None:
    """The largest derivative of V along the surfaces through a point, if a solution is shown to have it."""
    count, field = len(cells.states), cells.surfaces[0].field
    independent: list[RationalTerms] = []
    for form in through:
        if _rank([*independent, form], count) > len(independent):
            independent.append(form)
    gradient = [exact_value(_slope(pieces[around[0].signs][0], k), point) for k in range(count)] if around else []
    fields = list(dict.fromkeys(tuple(exact_value(f, point) for f in own) for c in around for own in c.velocities))
    normals = [[form.get(unit(count, k), fmpq(0)) for k in range(count)] for form in independent]
    if not fields:
        return None
    rises = [_dot(gradient, velocity) for velocity in fields]
    across = [tuple(_dot(normal, velocity) for normal in normals) for velocity in fields]
    if max(rises) <= 0 or any(min(speeds) > 0 or max(speeds) < 0 for speeds in zip(*across, strict=True)):
        return None  # V rises along none of them, or all leave a surface to one side: so do their mixtures
    columns = [(*map(field, speeds), field.one) for speeds in across]
    target = (*(field.zero for _ in normals), field.one)
    mixture = best_mixture(columns, target, [field(rise) for rise in rises])
    if mixture is None or mixture.value.sign() <= 0 or len(mixture.weights) <= len(normals):
        return None
    return mixture.value.as_rational()


def _slope(terms: Mapping[Exponents, fmpq], k: int) -> RationalTerms:
    """A partial derivative."""
    return {(*e[:k], e[k] - 1, *e[k + 1 :]): c * e[k] for e, c in terms.items() if e[k]}


def _dot(first: Sequence[fmpq], second: Sequence[fmpq]) -> fmpq:
    return sum((a * b for a, b in zip(first, second, strict=True)), fmpq(0))


def _sign(value: fmpq) -> int:
    return int(value > 0) - int(value < 0)


def as_fractions(point: Point) -> tuple[Fraction, ...]:
    """The same point."""
    return tuple(Fraction(int(x.p), int(x.q)) for x in point)
