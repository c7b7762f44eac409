"""Enclosures by balls, and what is read off them: definite and stable matrices, zeros, signs on intervals.

Numbers are those of any ordered arithmetic where nothing else is said: exact ones, or balls of python-flint, of which a
comparison holds only where it holds for every number inside.

*Zeros.*  With an approximate zero m of a smooth map F, an approximate inverse Y of its Jacobian there and the Jacobian
J(X) over a box X about m, ``K = m - Y F(m) + (1 - Y J(X)) (X - m)``.  If K lies in the interior of X, F has exactly one
zero in X, it lies in K, and every matrix in J(X) is regular (Krawczyk 1969; Neumaier 1990, theorem 5.1.8).  So it is
for every member of a family of maps at once, where F(m) and J(X) enclose those of all.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

from flint import arb, arb_mat, fmpq

from nonsmooth.proofs.findings import Translation

# A map and its Jacobian, (n, 1) and (n, n), over a box (n, 1); None where they are not known.
Map: TypeAlias = Callable[[arb_mat], tuple[arb_mat, arb_mat] | None]

UNIT = arb(0, 1)  # the ball [-1, 1]
INFLATIONS = 20
GROWTH = 1.0625  # of the image of a box, which is the next one
LEAST = 2.0**-100  # of its half-widths, beside one
DOUBLINGS = 80  # of the bracket in which a zero is looked for


def is_positive_definite(rows: Sequence[Sequence[Any]]) -> bool:
    """Whether a symmetric matrix (3, 3) is positive definite, in balls every one (Sylvester's criterion)."""
    (a, b, c), (_, d, e), (_, _, f) = rows
    minor = a * d - b * b
    return bool(a > 0) and bool(minor > 0) and bool(minor * f - e * (a * e - b * c) + c * (b * e - d * c) > 0)


def linear_stability(matrix: Sequence[Sequence[Any]]) -> Translation:
    """What ``c' = A c`` to first order says of the origin, for a matrix (2, 2): by its trace and determinant."""
    (a, b), (c, d) = matrix
    trace, determinant = a + d, a * d - b * c
    if trace < 0 and determinant > 0:
        return Translation.ASYMPTOTICALLY_STABLE
    return Translation.UNSTABLE if trace > 0 or determinant < 0 else Translation.UNDECIDED


def holds_on(is_true: Callable[[arb], bool], low: arb, high: arb, halvings: int) -> bool:
    """Whether something is shown of all numbers from one to another, on parts that are halved while it is not shown."""
    waiting = [(low, high, halvings)]
    while waiting:
        low, high, left = waiting.pop()
        if is_true(low.union(high)):
            continue
        if not left:
            return False
        middle = ((low + high) / 2).mid()
        waiting += [(middle, high, left - 1), (low, middle, left - 1)]
    return True


def zero_of_rising(function: Callable[[fmpq], arb], halvings: int) -> tuple[fmpq, fmpq] | None:
    """Rational bracket of the zero of a rising function; None where its signs are not certain."""
    bounds = (fmpq(2) ** k for k in range(DOUBLINGS))
    bound = next((bound for bound in bounds if function(-bound) < 0 < function(bound)), None)
    if bound is None:
        return None
    lower, upper = -bound, bound
    for _ in range(halvings):
        for share in (fmpq(3, 8), fmpq(1, 2), fmpq(5, 8)):  # a zero at the middle leaves its sign open
            rate = lower + (upper - lower) * share
            value = function(rate)
            lower, upper = (rate, upper) if value < 0 else (lower, rate) if value > 0 else (lower, upper)
    return lower, upper


def approximate_inverse(matrix: arb_mat) -> arb_mat | None:
    """Of the middle of a matrix, without an error bound; None where it may be singular."""
    try:
        return matrix.mid().inv().mid()
    except ZeroDivisionError:
        return None


def newton(equations: Map, point: arb_mat, steps: int, *, last: float = 0.0) -> arb_mat | None:
    """A point (n, 1) about a zero; None where the map is not known on the way, or its Jacobian singular.

    Args:
        equations: the map with its Jacobian.
        point: where the search begins.
        steps: that are made at most.
        last: a step that is shorter than this share of the point is the last.
    """
    for _ in range(steps):
        value_and_slope = equations(point)
        inverse = None if value_and_slope is None else approximate_inverse(value_and_slope[1])
        if value_and_slope is None or inverse is None:
            return None
        step = inverse * value_and_slope[0]
        point = (point - step).mid()
        if last and max(map(abs, map(float, step.entries()))) < last * max(map(abs, map(float, point.entries()))):
            break
    return point


def krawczyk(centre: arb_mat, value: arb_mat, inverse: arb_mat, slope: arb_mat, box: arb_mat) -> arb_mat:
    """Krawczyk's operator on a box (n, 1) about a point, from F there, Y, and the Jacobian over the box."""
    size = box.nrows()
    identity = arb_mat(size, size, [arb(int(k // size == k % size)) for k in range(size * size)])
    return centre - inverse * value + (identity - inverse * slope) * (box - centre)


def lies_inside(inner: arb_mat, outer: arb_mat) -> bool:
    """Whether a box lies in the interior of another."""
    return all(b.contains_interior(a) for a, b in zip(inner.entries(), outer.entries(), strict=True))


def isolated_zero(equations: Map, centre: arb_mat) -> arb_mat | None:
    """A box (n, 1) that holds one zero, the only one in a box about it; by a member of what the map encloses.

    Args:
        equations: the map with its Jacobian.
        centre: an approximate zero.
    """
    value_and_slope = equations(centre)
    inverse = None if value_and_slope is None else approximate_inverse(value_and_slope[1])
    if value_and_slope is None or inverse is None:
        return None
    origin, image = arb_mat(centre.nrows(), 1), inverse * value_and_slope[0] * arb(-1)
    for _ in range(INFLATIONS):
        box = arb_mat([[(GROWTH * abs(entry).upper() + LEAST) * UNIT] for entry in image.entries()])
        over = equations(centre + box)
        if over is None:
            return None
        image = krawczyk(origin, value_and_slope[0], inverse, over[1], box)
        if lies_inside(image, box):
            return centre + image
    return None


def slope_of_pose_rate(bend: arb_mat, by_place: arb_mat, place: Sequence[arb], omega: arb) -> arb_mat | None:
    """The slope (2, 2) of ``c' = v + omega J c`` by c; None where the twist may not be smooth in it.

    Args:
        bend: the slopes (n, n) of equations by the twist ``(v, omega)``, and what else they determine.
        by_place: their slopes (n, 2) by c.
        place: c.
        omega: the rotation rate.
    """
    inverse = approximate_inverse(bend)  # so that balls that belong together are not told apart by elimination
    if inverse is None:
        return None
    try:
        response = (inverse * bend).solve(inverse * by_place * arb(-1))
    except ZeroDivisionError:
        return None
    x, y = place
    moved = arb_mat([[arb(1), arb(0), -y], [arb(0), arb(1), x]])
    return moved * arb_mat(3, 2, response.entries()[:6]) + arb_mat([[arb(0), -omega], [omega, arb(0)]])


# ---- functions over boxes of parameters --------------------------------------------------------


@dataclass(frozen=True)
class Jet:
    """A value and its partial derivatives by some parameters, all balls.

    With q0 in the box Q and partial derivatives enclosed over all of Q, the mean value theorem gives
    ``f(q) in f(q0) + sum_k f_k(Q) (q_k - q0_k)``, which is right to first order in the size of the box.
    """

    value: arb
    slopes: tuple[arb, ...]

    def _operand(self, value: Jet | arb) -> Jet:
        return value if isinstance(value, Jet) else Jet(value, (arb(0),) * len(self.slopes))

    def __add__(self, value: Jet | arb) -> Jet:
        other = self._operand(value)
        return Jet(self.value + other.value, tuple(a + b for a, b in zip(self.slopes, other.slopes, strict=True)))

    def __neg__(self) -> Jet:
        return Jet(-self.value, tuple(-slope for slope in self.slopes))

    def __sub__(self, value: Jet | arb) -> Jet:
        return self + (-value)

    def __mul__(self, value: Jet | arb) -> Jet:
        other = self._operand(value)
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(self.value * other.value, tuple(a * other.value + self.value * b for a, b in pairs))

    def __truediv__(self, other: Jet) -> Jet:
        """The quotient; the divisor's ball must not hold zero."""
        quotient = self.value / other.value
        pairs = zip(self.slopes, other.slopes, strict=True)
        return Jet(quotient, tuple((a - quotient * b) / other.value for a, b in pairs))

    def over(self, sizes: Sequence[arb], middle: arb) -> arb:
        """An enclosure over a box of half-widths ``sizes``, where this is the jet, from the value at its middle."""
        return sum((slope * size * UNIT for slope, size in zip(self.slopes, sizes, strict=True)), middle)


def parameters(values: Sequence[arb]) -> list[Jet]:
    """The parameters themselves, at some values."""
    count = range(len(values))
    return [Jet(value, tuple(arb(int(k == j)) for j in count)) for k, value in enumerate(values)]


def turned_by(x: arb, y: arb, angle: Jet) -> tuple[Jet, Jet]:
    """A vector turned counterclockwise."""
    cosine, sine = angle.value.cos(), angle.value.sin()
    first = Jet(cosine, tuple(-sine * slope for slope in angle.slopes))
    second = Jet(sine, tuple(cosine * slope for slope in angle.slopes))
    return first * x - second * y, first * y + second * x


def unit_vector(first: Jet, second: Jet) -> tuple[Jet, Jet] | None:
    """The unit vector e along ``w = (first, second)``; None where w may vanish.

    Written so that little is lost where w is known in proportion: ``e = (1, t)/sqrt(1 + t^2)`` with the ratio t of the
    smaller to the larger entry, and ``e' = (-e_2, e_1) (e_1 w_2' - e_2 w_1')/|w|``.
    """
    a, b = first.value, second.value
    square = a * a + b * b
    if not square > 0:
        return None
    size = square.sqrt()
    e, f = a / size, b / size
    if abs(a) > abs(b):
        e, f = _unit(a, b)
    elif abs(b) > abs(a):
        f, e = _unit(b, a)
    turns = [(e * q - f * p) / size for p, q in zip(first.slopes, second.slopes, strict=True)]
    return Jet(e, tuple(-f * turn for turn in turns)), Jet(f, tuple(e * turn for turn in turns))


def _unit(larger: arb, smaller: arb) -> tuple[arb, arb]:
    """``(larger, smaller)`` divided by its length."""
    ratio = smaller / abs(larger)
    size = (1 + ratio * ratio).sqrt()
    return (1 if larger > 0 else -1) / size, ratio / size
