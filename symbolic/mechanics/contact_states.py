"""Contact states: the Pfaffian constraints of the wheels, rows of Omega_i, and three of them held without slip.

Wheel i acts on the spatial twist ``xi = (v, omega)`` through two rows (Murphey & Burdick, eq. 2, written for
inward headings and drive ``+u``)::

    roll   d_i . v + (d_i . J p_i) omega = u_i
    side   n_i . v + (n_i . J p_i) omega = 0        n_i = J d_i

A wheel with a friction axis a_i apart from its rim has ``a_i`` and ``J a_i`` for ``d_i`` and ``n_i``, and the right
sides ``u_i a_i . d_i`` and ``u_i J a_i . d_i``.

A :class:`Row` is kept multiplied by ``|D_i|`` (``|A_i|`` where there is an axis): then its left side holds no square
root, and only the right side does.  Scaling changes neither rank nor solution.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cached_property, reduce
from itertools import combinations
from math import comb
from typing import Any, NamedTuple, TypeAlias

from nonsmooth.symbolic.mechanics.load_model import Three, X
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane import Vector

Triple: TypeAlias = tuple[Number, Number, Number]


class RowKind(StrEnum):
    """Roll row (along the friction axis, most often the rim, R) or side row (across it, S)."""

    ROLL = "R"
    SIDE = "S"


class Twist(NamedTuple):
    """Spatial twist: velocity ``(vx, vy)`` of the body point at the world origin, rotation rate ``omega``."""

    vx: Number
    vy: Number
    omega: Number

    @property
    def velocity(self) -> Vector:
        """``v``."""
        return self.vx, self.vy

    def pose_rate(self, point: Vector) -> Vector:
        """Exact kinematics ``c' = v + omega J c`` at centre of mass ``point``."""
        return self.vx - self.omega * point[1], self.vy + self.omega * point[0]


class Row(NamedTuple):
    """One scaled constraint ``normal . (vx, vy, omega) = rhs`` of a wheel.

    Attributes:
        wheel: whose it is.
        kind: whether of its rolling or of its side slip.
        normal: a direction d with the moment ``d . J p`` of its place p (1, 1, length), times the grip length.
        rhs: the speed that is asked for (length/time), times the same.
    """

    wheel: Wheel
    kind: RowKind
    normal: Triple
    rhs: Number

    @property
    def name(self) -> str:
        """``R3`` is the roll row of wheel 3, ``S3`` its side row."""
        return f"{self.kind}{self.wheel.index:d}"

    @property
    def unit_normal(self) -> Triple:
        """``(d_i, d_i . J p_i)`` or ``(n_i, n_i . J p_i)``, of a unit direction."""
        return self.wheel.unit_normals[0 if self.kind is RowKind.ROLL else 1]

    @property
    def gain(self) -> Number:
        """The right side for each unit of speed: ``rhs = gain u_i``."""
        return self.wheel.gains[0 if self.kind is RowKind.ROLL else 1]

    @property
    def friction(self) -> Number:
        """Coulomb coefficient: mu_R along the friction axis, mu_S across it."""
        return self.wheel.friction.roll if self.kind is RowKind.ROLL else self.wheel.friction.side

    def residual(self, twist: Twist) -> Number:
        """``|A_i|`` times the slip ``d_i . v(p_i) - u_i`` or ``n_i . v(p_i)``."""
        a, b, m = self.normal
        return a * twist.vx + b * twist.vy + m * twist.omega - self.rhs


def roll_row(wheel: Wheel) -> Row:
    """``(A, A . J p | u A . d)``, which is ``(D, D . J p | |D| u)`` where the friction axis is the rim."""
    return Row(wheel, RowKind.ROLL, wheel.normals[0], wheel.scaled_speed)


def side_row(wheel: Wheel) -> Row:
    """``(N, N . J p | u N . d)`` with ``N = J A``; the right side is zero where the friction axis is the rim."""
    return Row(wheel, RowKind.SIDE, wheel.normals[1], wheel.scaled_side_speed)


def wheel_rows(wheel: Wheel) -> tuple[Row, Row]:
    """Roll row and side row."""
    return roll_row(wheel), side_row(wheel)


def scene_rows(scene: Scene) -> tuple[Row, ...]:
    """All 2n rows, wheel by wheel: R1, S1, R2, S2, ..."""
    return tuple(row for wheel in scene.wheels for row in wheel_rows(wheel))


def rows_with_friction(scene: Scene) -> Iterator[Row]:
    """The rows that can hold at all, one after the other: without friction a row limits nothing."""
    return (row for wheel in scene.wheels for row in wheel_rows(wheel) if row.friction)


def constraint_matrix(wheel: Wheel) -> tuple[tuple[Number, ...], tuple[Number, ...]]:
    """``Omega_i``: the two unit-length rows acting on ``(xi, 1)``, eq. (2)."""
    first, second = (
        (*(entry / wheel.grip_length for entry in row.normal), -row.rhs / wheel.grip_length)
        for row in wheel_rows(wheel)
    )
    return first, second


def cross_product(a: Three[X], b: Three[X]) -> Three[X]:
    """Cross product in three dimensions, in any arithmetic."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def total(zero: X, vectors: Iterable[Three[X]]) -> Three[X]:
    """Sum of vectors, zero where there are none; in any arithmetic."""
    start: Three[X] = (zero, zero, zero)
    return reduce(added, vectors, start)


def inner(a: Sequence[X], b: Sequence[X]) -> X:
    """Inner product in three dimensions, in any arithmetic."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cofactors(a: Triple, b: Triple, c: Triple) -> tuple[Triple, Triple, Triple]:
    """Columns of ``det(M) M^-1`` for the matrix M with rows a, b, c: ``b x c, c x a, a x b``."""
    return cross_product(b, c), cross_product(c, a), cross_product(a, b)


def gram(columns: Sequence[Three[X]]) -> tuple[Three[X], Three[X], Three[X]]:
    """``sum_k c_k c_k^T``, a symmetric matrix by its rows, in any arithmetic."""

    def entry(r: int, s: int) -> Any:
        return sum((c[r] * c[s] for c in columns), columns[0][0] * 0)

    xx, xy, xz, yy, yz, zz = (entry(r, s) for r, s in ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)))
    return (xx, xy, xz), (xy, yy, yz), (xz, yz, zz)


def added(a: Three[X], b: Three[X]) -> Three[X]:
    """``a + b``, in any arithmetic."""
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


def subtracted(a: Triple, b: Triple) -> Triple:
    """``a - b``."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(vector: Three[X], factor: X | int) -> Three[X]:
    """``factor * vector``, in any arithmetic."""
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


def leading_one(vector: Triple) -> Triple:
    """The multiple of a nonzero vector whose last nonzero entry is one: the same for all vectors of a line."""
    return scaled(vector, next(x for x in reversed(vector) if x).inverse())


def combine(weights: Iterable[Number], columns: Iterable[Triple]) -> Triple:
    """``sum_k weights[k] columns[k]``, skipping zero weights."""
    total: list[Number] | None = None
    zero: Number | None = None
    for weight, column in zip(weights, columns, strict=True):
        if weight:
            part = [weight * entry for entry in column]
            total = part if total is None else [s + t for s, t in zip(total, part, strict=True)]
        elif zero is None:
            zero = weight * column[0]
    if total is not None:
        return total[0], total[1], total[2]
    if zero is None:
        raise ValueError("required at least one column, received none")
    return zero, zero, zero


def complement(basis: Sequence[Triple]) -> tuple[Triple, ...]:
    """Independent vectors orthogonal to one, two or three independent ones."""
    if len(basis) == 1:
        one = basis[0][0].field.one
        zero = one - one
        crossed = [cross_product(basis[0], axis) for axis in ((one, zero, zero), (zero, one, zero), (zero, zero, one))]
        return tuple(leading_one(crossed[k]) for k in independent(crossed))
    return (leading_one(cross_product(basis[0], basis[1])),) if len(basis) == 2 else ()


def independent(vectors: Iterable[Triple]) -> tuple[int, ...]:
    """Positions of the first linearly independent vectors: a basis of their span, at most three.

    No more vectors are looked at than it takes.
    """
    return tuple(k for k, _ in _first_independent(vectors))


def basis_of(vectors: Iterable[Triple]) -> tuple[Triple, ...]:
    """The first linearly independent vectors themselves."""
    return tuple(vector for _, vector in _first_independent(vectors))


def _first_independent(vectors: Iterable[Triple]) -> Iterator[tuple[int, Triple]]:
    first: Triple | None = None
    normal: Triple | None = None
    for k, vector in enumerate(vectors):
        if first is None:
            if any(vector):
                first = vector
                yield k, vector
        elif normal is None:
            crossed = cross_product(first, vector)
            if any(crossed):
                normal = crossed
                yield k, vector
        elif inner(normal, vector):
            yield k, vector
            return


# ---- contact states ------------------------------------------------------------------------------
#
# Their twist and control vector fields: the annihilator of the stacked rows (null vector of the 3 x 4 matrix, last
# entry 1) is the twist; with symbolic speeds it is ``xi = sum_w g_w u_w`` (Murphey & Burdick, Definition 2 and eq. 6).
# Both come from the cofactors of one 3 x 3 matrix over the scene's field: no elimination, no simplification.


Solution: TypeAlias = tuple[tuple[Triple, Triple, Triple], Number]  # in plain rationals where all normals are rational


@dataclass(frozen=True, repr=False)
class ContactState(ShortRepr):
    """Rows of rank three and what follows from them.

    Attributes:
        rows: the rows held without slip, in the order the rule chose them: three for rule ``nearest``, all that
            the twist satisfies for rule ``box``.
        twist: the annihilator ``xi`` for the scene's speeds.
        solution: cofactors and the inverse of the determinant of three rows, where they are known already.
    """

    rows: tuple[Row, ...]
    twist: Twist
    solution: Solution | None = field(default=None, repr=False, compare=False)

    @property
    def name(self) -> str:
        """For example ``R1 S1 R4``."""
        return " ".join(self.row_names)

    @property
    def row_names(self) -> list[str]:
        """For example ``["R1", "S1", "R4"]``."""
        return [row.name for row in self.rows]

    @property
    def is_of_a_pair(self) -> bool:
        """Whether it holds both rows of one wheel, roll row first, and then one row of another."""
        wheels = [row.wheel.index for row in self.rows]
        return len(wheels) == 3 and wheels[0] == wheels[1] != wheels[2]

    @cached_property
    def control_fields(self) -> dict[int, Triple]:
        """``g_w`` by wheel index: ``xi = sum_w g_w u_w``; side rows carry no input, unless the wheel has an axis.

        Raises:
            ValueError: for more than three rows, which hold together for these speeds only.
        """
        if len(self.rows) != 3:
            raise ValueError(f"required three rows, received {self.name}")
        columns, inverse = self.solution or _solution((self.rows[0], self.rows[1], self.rows[2]))
        fields: dict[int, Triple] = {}
        for row, column in zip(self.rows, columns, strict=True):
            if row.gain:
                control_field, index = scaled(column, row.gain * inverse), row.wheel.index
                fields[index] = added(fields[index], control_field) if index in fields else control_field
        return fields


def _solution(rows: tuple[Row, Row, Row]) -> Solution:
    """Of independent rows."""
    columns = cofactors(*(row.normal for row in rows))
    return columns, inner(rows[0].normal, columns[0]).inverse()


def solve_rows(rows: tuple[Row, Row, Row]) -> ContactState | None:
    """The contact state of three rows, or None where they are dependent."""
    columns = cofactors(*(row.normal for row in rows))
    determinant = inner(rows[0].normal, columns[0])
    if not determinant:
        return None
    inverse = determinant.inverse()
    return ContactState(rows, _twist(rows, columns, inverse), (columns, inverse))


def _twist(rows: tuple[Row, Row, Row], columns: tuple[Triple, Triple, Triple], inverse: Number) -> Twist:
    """``sum_k (rhs_k/det) column_k``; most rows say zero, so that they take no part."""
    return Twist(*combine([row.rhs * inverse for row in rows], columns))


class ContactCensus(NamedTuple):
    """Count of all row triples of an array.

    Attributes:
        possible: C(m, 3) of m rows with friction; C(2n, 3) where every row has some.
        singular: triples of dependent rows; None where they were not counted.
        distinct_twists: different twists among the regular triples; None where not counted.
    """

    possible: int
    singular: int | None = None
    distinct_twists: int | None = None

    @property
    def regular(self) -> int | None:
        """Triples that determine a twist."""
        return None if self.singular is None else self.possible - self.singular


def possible_triples(wheel_count: int) -> int:
    """C(2n, 3) row triples of n wheels."""
    return comb(2 * wheel_count, 3)


def triples_with_friction(scene: Scene) -> int:
    """C(m, 3) triples of the m rows with friction: a row without friction holds nothing."""
    rows = sum(bool(wheel.friction.roll) + bool(wheel.friction.side) for wheel in scene.wheels)
    return comb(rows, 3)


def regular_states(scene: Scene) -> list[ContactState]:
    """Every regular triple of rows with friction, in lexicographic order."""
    rows = list(rows_with_friction(scene))
    normals = [in_rationals(row.normal) for row in rows]
    crosses = {(i, j): cross_product(normals[i], normals[j]) for i, j in combinations(range(len(rows)), 2)}
    crosses |= {(j, i): (-x, -y, -z) for (i, j), (x, y, z) in crosses.items()}
    states: list[ContactState] = []
    for i, j, k in combinations(range(len(rows)), 3):
        determinant = inner(normals[i], crosses[j, k])
        if not determinant:
            continue
        inverse = determinant.inverse() if isinstance(determinant, Number) else 1 / determinant
        triple, columns = (rows[i], rows[j], rows[k]), (crosses[j, k], crosses[k, i], crosses[i, j])
        states.append(ContactState(triple, _twist(triple, columns, inverse), (columns, inverse)))
    return states


def in_rationals(vector: Triple) -> Any:
    """The same vector in plain rationals, with which one computes fast, where it has no other entry."""
    entries = [entry.as_rational() if type(entry) is Number else None for entry in vector]
    return vector if None in entries else tuple(entries)


def take_census(scene: Scene) -> ContactCensus:
    """Count possible and singular triples and distinct twists."""
    states = regular_states(scene)
    possible = triples_with_friction(scene)
    return ContactCensus(possible, possible - len(states), len({state.twist for state in states}))


# ---- wheels whose rollers are free ---------------------------------------------------------------
#
# Wheels on rollers that turn freely, as wheels without rollers; and motions that nothing resists.
#
# A wheel with a friction axis ``a_i`` and no friction across it constrains ``a_i . v(p_i) = u_i a_i . d_i`` and nothing
# else.  So does a wheel whose rim points along ``a_i`` and runs at ``u_i a_i . d_i``: a mecanum wheel is an omniwheel
# whose rim stands along the axes of its rollers and whose speed is that of the drive times the cosine of their angle.
# Where the cosine is not zero, each speed of the one is a speed of the other, so that both can be driven alike.


def askew_wheels(scene: Scene) -> tuple[Wheel, ...]:
    """The wheels whose friction axis is not their rim."""
    return tuple(wheel for wheel in scene.wheels if wheel.axis is not None)


def with_rims_along_axes(scene: Scene) -> Scene | None:
    """The same array with rims along the friction axes.

    None where a wheel that has an axis of its own also has friction across it, or is driven at right angles to it.
    """
    if not askew_wheels(scene):
        return scene
    wheels = [_along_axis(wheel) for wheel in scene.wheels]
    aligned = tuple(wheel for wheel in wheels if wheel is not None)
    return replace(scene, wheels=aligned) if len(aligned) == len(wheels) else None


def _along_axis(wheel: Wheel) -> Wheel | None:
    if wheel.axis is None:
        return wheel
    along, _ = wheel.gains
    if wheel.friction.side or not along:
        return None
    cosine, limit = along / wheel.grip_length, wheel.speed_limit
    return replace(
        wheel,
        direction=wheel.axis,
        axis=None,
        given_speed=wheel.speed * cosine,
        speed_limit=None if limit is None else limit * cosine,
    )


# ---- free motions: the twists that no row with friction resists, exactly -------------------------
#
# A row with friction resists a twist xi unless ``a_k . xi = 0``.  So the free twists are the kernel of the rows with
# friction, and along each of them D is constant: if xi minimizes D, so does xi plus any free twist.  Free rollers with
# all their axes through one point, for example, leave the rotation about it free.


def free_twists(scene: Scene) -> tuple[Triple, ...]:
    """A basis of the twists that no row with friction of any wheel resists; empty where every motion is resisted."""
    return kernel(rows_with_friction(scene))


def kernel(rows: Iterable[Row]) -> tuple[Triple, ...]:
    """A basis of the twists that satisfy ``a_k . xi = 0`` for rows of which at least one is there."""
    return complement(basis_of(row.normal for row in rows))


def free_text(twists: Sequence[Triple]) -> str:
    """In words, that these motions are free; empty where there are none."""
    if not twists:
        return ""
    listed = ", ".join(f"({', '.join(brief_text(entry) for entry in twist)})" for twist in twists)
    return f"no row with friction resists the motion{'s' if len(twists) > 1 else ''} xi = {listed}"
