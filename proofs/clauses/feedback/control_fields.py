"""The inputs of an array under a rule that keeps rows: what the speeds of the wheels do in each cell.

In a cell with both rows of wheel i and the roll row of wheel j the inputs ``u_i, u_j`` act through ::

    omega = (u_j - u_i d_i.d_j)/Delta,   v = u_i d_i - omega J p_i,   Delta = d_j . J(p_j - p_i)

its *control vector fields* g_i and g_j span the motions that inputs can give: rank 2.  With a side row in third place
u_i acts alone: rank 1 (the paper's "not locally controllable").  On a side, and at the equilibrium, Filippov mixtures
of the neighbours' fields are available too.  Which control Lyapunov functions serve all of them is decided below.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import isqrt
from typing import Any, NamedTuple, SupportsFloat, TypeAlias

from nonsmooth.analysis.cells.fan import CellCone, build_fan
from nonsmooth.analysis.cells.partition import Cell, Partition
from nonsmooth.analysis.cells.polygon import HalfPlane, Point, Polygon, clipped_by, square
from nonsmooth.analysis.cells.support import Support, limiting_support
from nonsmooth.proofs.clauses.clause import Witness
from nonsmooth.proofs.clauses.feedback.rational_bounds import late
from nonsmooth.proofs.clauses.translation.quadratic import propose_shape, root_above, shaped
from nonsmooth.symbolic.mechanics.contact_states import (
    ContactState,
    RowKind,
    Triple,
    cross_product,
    independent,
    leading_one,
)
from nonsmooth.symbolic.mechanics.scene import Wheel
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.plane import Vector, around, between, dot, minus, squared_distance, turned

# ---- why no static feedback stabilizes -----------------------------------------------------------
#
# Every motion that inputs give near the equilibrium keeps to a plane of twists.
#
# Let ``m . xi = 0`` for all of them, m nonzero.  Whatever the feedback, the Filippov set at a pose near the equilibrium
# is a part of that plane, turned into pose rates: ``c' = v + omega J c``, ``theta' = omega``.  The planes of poses near
# the equilibrium differ little, so all velocities together miss the small multiples of m.  Brockett's condition asks
# that they fill a neighbourhood of zero; it is necessary for the asymptotic stability of upper semicontinuous
# inclusions with convex values too (Ryan, SIAM J. Control Optim. 32, 1994), hence for discontinuous feedback in the
# sense of Filippov. Feedback that depends on time (Coron 1992) or acts on samples (Clarke, Ledyaev, Sontag and Subbotin
# 1997) is another matter: a unicycle can be parked.
#
# For ``m = (0, 0, 1)`` the plane is ``omega = 0``: theta is a constant of every motion.


def common_normal(twists: Sequence[Triple], field: NumberField) -> Triple | None:
    """A nonzero vector orthogonal to all twists; None where they span."""
    zero, one = field.zero, field.one
    basis = [twists[k] for k in independent(twists)]
    if len(basis) == 3:
        return None
    span = [*basis, (zero, zero, one), (one, zero, zero), (zero, one, zero)]
    first, second = (span[k] for k in independent(span)[:2])
    return leading_one(cross_product(first, second))


def obstruction_text(normal: Triple) -> str:
    """One sentence for people."""
    if any(normal[:2]):
        entries = ", ".join(brief_text(entry) for entry in normal)
        plane = f"m . xi = 0 with m = ({entries})"
    else:
        plane = "omega = 0"
    return f"no static feedback stabilizes (Brockett's condition): every motion that inputs give near c* obeys {plane}"


# ---- the inputs ----------------------------------------------------------------------------------


ONE_INPUT = "only one input acts: V' = a u_i vanishes on a plane through this c and theta"


@dataclass(frozen=True)
class InputCell:
    """One closed cell in one of its contact states, of three rows, both of the first wheel among them."""

    cell: Cell
    state: ContactState

    @property
    def nearest(self) -> Wheel:
        """Wheel i, both rows held."""
        return self.state.rows[0].wheel

    @property
    def second(self) -> Wheel:
        """Wheel j, one row held."""
        return self.state.rows[2].wheel

    @property
    def fields(self) -> tuple[Triple, ...]:
        """The control vector fields."""
        return tuple(self.state.control_fields.values())

    @cached_property
    def lever(self) -> Number | None:
        """``d_j . J(p_j - p_i)`` scaled by ``|D_j|``, or None where the third row is a side row."""
        return lever(self.nearest, self.second) if self.state.rows[2].kind is RowKind.ROLL else None

    @property
    def torque_sign(self) -> int:
        """Sign of the coefficient of ``u_j`` in omega: the paper's ``u_j = -k theta`` needs it positive."""
        return 0 if self.lever is None else self.lever.sign()

    @cached_property
    def sign_condition(self) -> StrictSignCondition:
        """What a control Lyapunov function must satisfy in the cell."""
        vertices = tuple(vertex for vertex in self.cell.polygon.vertices if any(vertex))
        return StrictSignCondition(vertices, self.nearest.direction)

    def stall(self) -> Point | None:
        """A nonzero point of the closed cell with ``c . d_i = 0``, where there is one."""
        touches = [(vertex, dot(vertex, self.nearest.direction)) for vertex in self.cell.polygon.vertices]
        for (p, here), (q, after) in around(touches):
            if not here and any(p):
                return p
            if here.sign() * after.sign() < 0:
                point = between(p, q, here / (here - after))
                if any(point):
                    return point
        return None

    def idle_plane(self, lyapunov: ControlLyapunov) -> Witness:
        """Where one input acts alone: a nonzero (c, theta) of the closed cell at which it cannot change V.

        With ``xi = g u_i`` and ``V'/2 = (c . g_v + w theta g_omega) u_i`` that is the cell's centre (a vertex, where
        the centre is the equilibrium) with ``theta = -c . g_v/(w g_omega)``, or the equilibrium with any theta where
        ``g_omega = 0``.
        """
        ((x, y, turn),) = self.fields
        if not turn:
            return Witness((turn, turn), turn.field.one, ONE_INPUT)
        polygon = self.cell.polygon
        point = polygon.centre if any(polygon.centre) else polygon.vertices[0]
        return Witness(point, -dot(point, (x, y)) / (turn * lyapunov.weight), ONE_INPUT)


def lever(first: Wheel, second: Wheel) -> Number:
    """``Delta_ij = D_j . J(p_j - p_i)`` for wheels i, j."""
    return dot(second.direction, turned(minus(second.position, first.position)))


@dataclass(frozen=True)
class RowInputs:
    """All cells of a centred partition with their inputs; what is asked of them, each built once."""

    partition: Partition

    @property
    def length(self) -> Fraction:
        """The characteristic length l of ``V = |c|^2 + l^2 theta^2``."""
        return self.partition.scene.check.length

    @property
    def radius(self) -> Number:
        """Half-width of the checked square."""
        return self.partition.scene.check.radius

    @cached_property
    def cells(self) -> tuple[InputCell, ...]:
        """Every cell in each of its states."""
        return tuple(InputCell(cell, state) for cell in self.partition.cells for state in cell.states)

    @cached_property
    def local(self) -> tuple[InputCell, ...]:
        """Those whose closure holds the equilibrium; these decide."""
        meeting = self.partition.meeting
        return tuple(data for data in self.cells if data.cell in meeting)

    @cached_property
    def away(self) -> tuple[InputCell, ...]:
        """The others."""
        return tuple(data for data in self.cells if data not in self.local)

    @property
    def sign_conditions(self) -> list[StrictSignCondition]:
        """What a control Lyapunov function must satisfy near the equilibrium."""
        return [data.sign_condition for data in self.local]

    @property
    def acting(self) -> list[Wheel]:
        """The wheels whose rows are held at the equilibrium."""
        held = {row.wheel.index for data in self.local for row in data.state.rows}
        return [wheel for wheel in self.partition.scene.wheels if wheel.index in held]

    @cached_property
    def fan(self) -> tuple[CellCone, ...]:
        """The cones at the equilibrium."""
        return build_fan(self.partition)

    @cached_property
    def support(self) -> Support | None:
        """The support polygon, where the checked square leaves it."""
        return limiting_support(self.partition)

    @property
    def obstruction(self) -> Triple | None:
        """The normal of a plane that holds every control vector field at the equilibrium, if there is one."""
        return common_normal([field for data in self.local for field in data.fields], self.partition.scene.field)


# ---- what laws by rows need ------------------------------------------------------------------------


def why_not_followed(partition: Partition) -> str | None:
    """Why cells are not followed: rows that are not those of a pair of wheels, or not along a rim; None without."""
    held = {row.wheel.index: row.wheel for cell in partition.cells for state in cell.states for row in state.rows}
    if any(wheel.axis is not None for wheel in held.values()):
        return askew_reason(held.values())
    for cell in partition.cells:
        for state in cell.states:
            if not state.is_of_a_pair:
                return (
                    f"rows without friction are left out, so cell {cell.index} holds {state.name}; "
                    "only both rows of one wheel with one row of another are followed"
                )
    return None


def askew_reason(wheels: Iterable[Wheel]) -> str:
    """Why no law is sought for wheels of which one has a friction axis that is not its rim."""
    index = next(wheel.index for wheel in wheels if wheel.axis is not None)
    return (
        f"the friction axis of wheel {index} is not its rim; laws are sought for such wheels only under rules that "
        "minimize D, without friction across the axis, and not for a drive at right angles to it"
    )


def side_friction_rules(wheels: Iterable[Wheel]) -> str | None:
    """Why the clause does not apply, or None: it speaks of arrays with mu_S < mu_R."""
    for wheel in wheels:
        if wheel.friction.side >= wheel.friction.roll:
            return (
                f"mu_side < mu_roll is required, received mu_side = {brief_text(wheel.friction.side)}, "
                f"mu_roll = {brief_text(wheel.friction.roll)} at wheel {wheel.index}"
            )
    return None


# ---- how many independent inputs act ---------------------------------------------------------------


class InputRanks(NamedTuple):
    """Ranks of the control vector fields.

    Attributes:
        cells: rank by number of the cell.
        sides: rank by pair of neighbouring cells.
        equilibrium: rank of all fields that meet at the checked point.
    """

    cells: dict[int, int]
    sides: dict[tuple[int, int], int]
    equilibrium: int


def input_ranks(partition: Partition) -> InputRanks:
    """Ranks for a centred partition of a rule that keeps rows."""
    from nonsmooth.analysis.cells.equilibria import shared_sides

    cells = {cell.index: _rank(cell) for cell in partition.cells}
    sides = {(s.first.index, s.second.index): _rank(s.first, s.second) for s in shared_sides(partition)}
    return InputRanks(cells, sides, _rank(*partition.meeting))


def _rank(*cells: Cell) -> int:
    fields = [field for cell in cells for state in cell.states for field in state.control_fields.values()]
    return len(independent(fields))


# ---- control Lyapunov functions ------------------------------------------------------------------
#
# Which P of ``V = c^T P c + w theta^2`` serve, decided completely.
#
# Under exact kinematics ``c' = v + omega J c``, and with both rows of wheel i and the roll row of wheel j ::
#
#     V'/2 = a u_i + b u_j,   b = (w theta - P c . J(p_i - c))/Delta,   a = P c . d_i - (d_i . d_j) b
#
# Theta is free, so both vanish off the equilibrium iff ``P c . d_i = 0`` at a nonzero c of the cell, with w theta = P c
# . J(p_i - c): the criterion asks for one strict sign of ``c^T P d_i`` on every closed cell, for any w > 0 and any
# kinematics.  With ``P = [[1 + e, f], [f, 1 - e]]`` (a factor of V changes nothing) it is linear in (e, f) at each
# vertex; so the P that serve, for each choice of the cells' signs, fill a convex polygon in the disc ``e^2 + f^2 < 1``
# of positive definite P.  Cutting a square cell by cell, once for each sign, finds all of these polygons exactly; where
# none is left there is no such V.  In each a conic program (CVXPY) proposes the P whose worst vertex is farthest from
# zero, which is rounded and verified exactly.


Shape: TypeAlias = tuple[Fraction, Fraction]

DENOMINATORS = (2**6, 2**12, 2**24)  # of e and f: the first that verifies

LAW = "u_i = -k a, u_j = -k b with b = (theta - c.J p_i)/(d_j.J(p_j - p_i)), a = c.d_i - (d_i.d_j) b"
WEIGHED_LAW = (
    "u_i = -k a, u_j = -k b with b = (l^2 theta - c.J p_i)/(d_j.J(p_j - p_i)), a = c.d_i - (d_i.d_j) b, l = {}"
)
SHAPED_LAW = (
    "u_i = -k a, u_j = -k b with b = (w theta - P c.J(p_i - c))/(d_j.J(p_j - p_i)), a = P c.d_i - (d_i.d_j) b, "
    "P = [[{}, {}], [{}, {}]], w = {}"
)


@dataclass(frozen=True)
class ControlLyapunov:
    """``V = c^T P c + w theta^2`` with ``P = [[1 + e, f], [f, 1 - e]]``.

    Attributes:
        shape: (e, f).
        weight: w.
    """

    shape: Shape = (Fraction(0), Fraction(0))
    weight: Fraction = Fraction(1)

    def __str__(self) -> str:
        e, f = self.shape
        if self.length is not None:
            return "|c|^2 + theta^2" if self.length == 1 else f"|c|^2 + l^2 theta^2 with l = {self.length}"
        mixed = f" {'-' if f < 0 else '+'} ({abs(2 * f)}) x y" if f else ""
        return f"({1 + e}) x^2{mixed} + ({1 - e}) y^2 + ({self.weight}) theta^2"

    @cached_property
    def lightness(self) -> Fraction:
        """``1/w``, which every cone asks for."""
        return 1 / self.weight

    @property
    def length(self) -> Fraction | None:
        """The length l with ``V = |c|^2 + l^2 theta^2``; None where there is no such rational."""
        top, bottom = isqrt(max(self.weight.numerator, 0)), isqrt(self.weight.denominator)
        length = Fraction(top, bottom)
        return length if not any(self.shape) and length * length == self.weight else None

    @property
    def law(self) -> str:
        """The law ``u = -k (a, b)`` (Jurdjevic and Quinn) by V, under exact kinematics."""
        if self.length is not None:
            return LAW if self == SQUARES else WEIGHED_LAW.format(self.length)
        (e, f), w = self.shape, self.weight
        return SHAPED_LAW.format(1 + e, f, f, 1 - e, w)

    @property
    def eccentricity(self) -> Fraction:
        """A rational from ``rho = sqrt(e^2 + f^2)`` up to one: ``(1 - rho) |c|^2 <= c^T P c <= (1 + rho) |c|^2``."""
        e, f = self.shape
        return root_above(e * e + f * f) if e or f else Fraction(0)

    @property
    def is_positive(self) -> bool:
        """Whether V is positive definite."""
        e, f = self.shape
        return e * e + f * f < 1 and self.weight > 0

    def slope(self, c: Point) -> Vector:
        """``P c``: half the gradient in c."""
        return shaped(self.shape, c) if any(self.shape) else c

    def coefficients(self, fields: Sequence[Sequence[Any]], c: Point, theta: Any) -> tuple[Any, ...]:
        """Coefficient of each input in ``V'/2 = P c . (v + omega J c) + w theta omega``, from the control fields."""
        slope = self.slope(c)
        turning = theta * self.weight + dot(slope, turned(c))
        return tuple(slope[0] * x + slope[1] * y + turning * turn for x, y, turn in fields)

    def value(self, pose: Sequence[SupportsFloat]) -> float:
        """V at ``(x, y, theta)``, in floats."""
        (e, f), w = (float(entry) for entry in self.shape), float(self.weight)
        x, y, theta = map(float, pose)
        return (1 + e) * x * x + 2 * f * x * y + (1 - e) * y * y + w * theta * theta

    def squared_norm(self, twist: Sequence[Any]) -> Any:
        """``v^T P v + w omega^2``: the square of a twist in the metric of V."""
        v, turn = (twist[0], twist[1]), twist[2]
        return dot(self.slope(v), v) + turn * turn * self.weight

    def stalling_theta(self, c: Point, position: Point) -> Any:
        """The theta at which both coefficients vanish where ``P c . d_i = 0``: ``P c . J(p_i - c)/w``."""
        arm = minus(position, c)
        return dot(self.slope(c), turned(arm)) / self.weight


SQUARES = ControlLyapunov()


def sum_of_squares(length: Fraction) -> ControlLyapunov:
    """``V = |c|^2 + l^2 theta^2``."""
    return ControlLyapunov(weight=length * length)


@dataclass(frozen=True)
class StrictSignCondition:
    """``c^T P d_i`` is to have one strict sign at the nonzero vertices of a closed cell at the equilibrium.

    Attributes:
        vertices: of the cell, without the equilibrium.
        direction: a positive multiple of ``d_i``.
    """

    vertices: tuple[Point, ...]
    direction: Vector

    def sign(self, lyapunov: ControlLyapunov) -> int:
        """The one strict sign; 0 where there is none."""
        signs = {sign(dot(lyapunov.slope(vertex), self.direction)) for vertex in self.vertices}
        return signs.pop() if signs in ({1}, {-1}) else 0

    def half_planes(self, side: int) -> Iterator[HalfPlane]:
        """The (e, f) with ``side c^T P d_i >= 0`` at each vertex."""
        p, q = self.direction
        for x, y in self.vertices:
            values = (x * p + y * q, x * p - y * q, x * q + y * p)
            constant, along, across = (late(value * side) for value in values)
            yield HalfPlane((-along, -across), constant)


def shape_regions(sign_conditions: Sequence[StrictSignCondition]) -> list[tuple[tuple[int, ...], Polygon]]:
    """All polygons of (e, f) that meet the unit disc and on whose inside every sign_condition has one strict sign.

    The signs of the sign_conditions stand beside each.
    """
    zero = sign_conditions[0].direction[0].field.zero
    start = square((zero, zero), zero + 1)
    regions: list[tuple[tuple[int, ...], Polygon]] = [((), start)]
    for sign_condition in sign_conditions:
        before, regions = regions, []
        for signs, polygon in before:
            for side in (1, -1):
                part = clipped_by(polygon, sign_condition.half_planes(side))
                if part is not None and _meets_disc(part):
                    regions.append(((*signs, side), part))
    return regions


def find_shapes(sign_conditions: Sequence[StrictSignCondition]) -> Iterator[Shape]:
    """One rational (e, f) for each region, verified exactly; none where rounding leaves a thin region."""
    for signs, _ in shape_regions(sign_conditions):
        falling = [
            (vertex, (sign_condition.direction[0] * -side, sign_condition.direction[1] * -side))
            for sign_condition, side in zip(sign_conditions, signs, strict=True)
            for vertex in sign_condition.vertices
        ]
        proposal = propose_shape(falling)
        if proposal is None:
            continue
        for denominator in DENOMINATORS:
            e, f = (Fraction(round(x * denominator), denominator) for x in proposal)
            trial = ControlLyapunov((e, f))
            if trial.is_positive and all(sign_condition.sign(trial) for sign_condition in sign_conditions):
                yield e, f
                break


def _meets_disc(polygon: Polygon) -> bool:
    """Whether a polygon of positive area has points in the open unit disc."""
    zero = polygon.vertices[0][0] * 0
    return polygon.contains((zero, zero)) or any(
        sign(1 - squared_distance(*side)) > 0 for side in around(polygon.vertices)
    )
