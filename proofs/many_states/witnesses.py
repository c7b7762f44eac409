"""Points at which conditions on V fail: floats look for them, rational arithmetic decides.

*On cells*: a point at which an inequality is false.

*On faces*, where V bends, solutions that slide may raise V.  At a rational point of a face let ``l_j = 0`` for j in Z,
with no other surface through it, and let f_i be the fields of all cells that meet there.  A mixture with
``sum_i w_i grad l_j . f_i = 0`` for j in Z is a velocity along the face, and V(c(t)) has the derivative
``sum_i w_i g . f_i`` with the gradient g of any one piece.  A linear program finds the largest.  If it is positive,
with as many positive weights as there are equations, then these weights depend continuously on the place near the
point: there is a solution along the face, and V rises along it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from fractions import Fraction

import numpy as np
from flint import fmpq, fmpq_mat

from nonsmooth.proofs.checker.cells import Cell, Face, Inclusion
from nonsmooth.proofs.checker.polynomials import Polynomial
from nonsmooth.proofs.inequalities.linear_program import best_mixture
from nonsmooth.proofs.inequalities.subdivision import value_at
from nonsmooth.proofs.kernel.claims import Functions
from nonsmooth.proofs.kernel.written import terms_of
from nonsmooth.proofs.sums_of_squares.ansatz import Condition
from nonsmooth.symbolic.numbers.coefficients import as_fraction
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import float_values

POINTS = 1_500
HALVINGS = 10  # of the distance from the point
FINE = 1 << 10  # denominator of a point, in parts of its distance
TRIES = 6

Point = tuple[fmpq, ...]


def refuting_point(condition: Condition, *, strictly: bool) -> Point | None:
    """A point inside the guards at which p is negative (or zero, unless ``strictly``); None where none is found.

    Args:
        condition: without parameters.
        strictly: whether zero refutes nothing.
    """
    rng = np.random.default_rng(0)
    cloud = rng.uniform(-1, 1, (POINTS, condition.variables))
    axes = np.eye(condition.variables)
    cloud = np.vstack([axes, -axes, cloud])
    halved = 0.5 ** rng.integers(0, HALVINGS, len(cloud))
    points = cloud * halved[:, None]
    inside = np.ones(len(points), dtype=bool)
    for guard in condition.guards:
        inside &= float_values(guard, points) > 0
    points, halved = points[inside], halved[inside]
    if not len(points):
        return None
    order = min(map(sum, condition.constant), default=0)
    value = float_values(condition.constant, points) / halved**order
    for k in np.argsort(value)[:TRIES]:
        step = FINE * round(1 / float(halved[k]))
        point = tuple(fmpq(round(float(x) * step), step) for x in points[k])
        found = value_at(condition.constant, point)
        fails = found < 0 or (not found and not strictly and any(point))
        if fails and all(value_at(guard, point) > 0 for guard in condition.guards):
            return point
    return None


def as_fractions(point: Sequence[fmpq]) -> tuple[Fraction, ...]:
    """The same numbers."""
    return tuple(as_fraction(x) for x in point)


FACE_POINTS = 80  # of one face, half of them at the largest distance
FACE_HALVINGS = 6  # of the distance from the point
FACE_FINE = 1 << 6  # denominator of a coordinate, in parts of its distance
EXTREME = 0.5  # the share of coordinates that are least or largest


def rising_slide(conditions: Functions, zero: Sequence[int]) -> tuple[tuple[Fraction, ...], Fraction] | None:
    """A point of a face and a positive derivative of V along a solution from there; None where none is found.

    Args:
        conditions: on V; all fields of a cell may act.
        zero: the surfaces that vanish on the face.
    """
    inclusion = conditions.inclusion
    face = next((own for own in inclusion.faces() if own.zero == tuple(zero)), None)
    if face is None or face.curved or not face.dimension:
        return None
    radius = inclusion.domain.radius
    for point in _points(face):
        here = [_sign(_value(surface, point)) for surface in inclusion.surfaces.listed]
        if not _is_clear(inclusion, here):
            continue
        around = [cell for cell in inclusion.cells if all(s in {0, c} for s, c in zip(here, cell.signs, strict=True))]
        through = [surface for surface, s in zip(inclusion.surfaces.listed, here, strict=True) if not s]
        rise = _largest_rise(conditions, through, around, point)
        if rise is not None:
            return tuple(x * radius for x in as_fractions(point)), rise / radius
    return None


def _points(face: Face) -> Iterator[Point]:
    """Rational points of a face in the cube, nearer and farther; many of them near its border or near other faces."""
    rng = np.random.default_rng(0)
    for _ in range(FACE_POINTS):
        scale = fmpq(1, FACE_FINE << max(0, int(rng.integers(-FACE_HALVINGS, FACE_HALVINGS))))
        inside = rng.integers(1, FACE_FINE, face.dimension)
        sizes = np.where(rng.random(face.dimension) < EXTREME, rng.choice((1, FACE_FINE), face.dimension), inside)
        free = [scale * int(k) for k in sizes * rng.choice((-1, 1), face.dimension)]
        point = tuple(_value(form, free) for form in face.coordinates)
        if any(point) and all(abs(x) <= 1 for x in point):
            yield point


def _is_clear(inclusion: Inclusion, signs: Sequence[int]) -> bool:
    """Whether every listed cell with the signs of a point meets there.

    That is so if all surfaces are planes, for a segment from the point into such a cell keeps its signs; and if the
    surfaces through the point are planes in general position.
    """
    listed = inclusion.surfaces.listed
    if all(surface.degree == 1 for surface in listed):
        return True
    here = [surface for surface, s in zip(listed, signs, strict=True) if not s]
    return all(surface.degree == 1 for surface in here) and _rank([_slopes(own) for own in here]) == len(here)


def _largest_rise(
    conditions: Functions, through: Sequence[Polynomial], around: Sequence[Cell], point: Point
) -> Fraction | None:
    """The largest derivative of V along the surfaces through a point, if a solution is shown to have it."""
    normals: list[list[fmpq]] = []
    for form in through:
        if _rank([*normals, _slopes(form)]) > len(normals):
            normals.append(_slopes(form))
    if not around:
        return None
    potential = conditions.potential(around[0])
    gradient = [_value(potential.derivative(k), point) for k in range(potential.count)]
    fields = dict.fromkeys(tuple(_value(part, point) for part in own) for cell in around for _, own in cell.fields)
    rises = [_dot(gradient, velocity) for velocity in fields]
    across = [tuple(_dot(normal, velocity) for normal in normals) for velocity in fields]
    if max(rises) <= 0 or any(min(speeds) > 0 or max(speeds) < 0 for speeds in zip(*across, strict=True)):
        return None  # V rises along none of them, or all leave a surface to one side: so do their mixtures
    field = NumberField()
    columns = [(*map(field, speeds), field.one) for speeds in across]
    target = (*(field.zero for _ in normals), field.one)
    mixture = best_mixture(columns, target, [field(rise) for rise in rises])
    if mixture is None or mixture.value.sign() <= 0 or len(mixture.weights) <= len(normals):
        return None
    rise = mixture.value.as_rational()
    return None if rise is None else as_fractions([rise])[0]


def _value(polynomial: Polynomial, point: Sequence[fmpq]) -> fmpq:
    return fmpq(value_at(terms_of(polynomial), point))


def _slopes(form: Polynomial) -> list[fmpq]:
    terms = terms_of(form)
    return [sum((c for e, c in terms.items() if e[k]), fmpq(0)) for k in range(form.count)]


def _rank(rows: Sequence[Sequence[fmpq]]) -> int:
    return int(fmpq_mat([list(row) for row in rows]).rank()) if rows else 0


def _dot(first: Sequence[fmpq], second: Sequence[fmpq]) -> fmpq:
    return sum((a * b for a, b in zip(first, second, strict=True)), fmpq(0))


def _sign(value: fmpq) -> int:
    return int(value > 0) - int(value < 0)
