"""Clause 4: discontinuous feedback where the third row is a roll row (mu_S < mu_R).

In a cell with both rows of wheel i and the roll row of wheel j the inputs ``u_i, u_j`` act through the control vector
fields of module ``control_fields``.  So with ``V = |c|^2 + l^2 theta^2``: ``V'/2 = a u_i + b u_j``, ``b = (l^2 theta -
c . J p_i)/Delta``, ``a = c . d_i - (d_i . d_j) b``.  Both coefficients vanish iff ``c . d_i = 0`` and ``l^2 theta = c .
J p_i``.  Hence the L_gV law ``u = -k (a, b)`` (Jurdjevic and Quinn) makes ``V* < 0`` off the equilibrium iff no closed
cell holds a nonzero c with ``c . d_i = 0``; that is decided by the signs of ``c . d_i`` at the vertices.  Then:

- where this V fails, all ``c^T P c + w theta^2`` are searched (module ``control_fields``);
- what the law is certified for, at which rate, from where, with limited speeds and with doubt about the contact state:
  module ``gradient_law``, and :class:`InputMargin`;
- where no V of this form serves, a law that takes theta first may (module ``cascade_law``);
- with a side row third only ``u_i`` acts and V' vanishes on a plane.  That there is no such V refutes no other; but
  where all control fields at the equilibrium lie in one plane no static feedback does (module ``control_fields``).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias

from nonsmooth.analysis.cells.fan import CellCone
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.clause import Witness
from nonsmooth.proofs.clauses.feedback.control_fields import (
    SQUARES,
    ControlLyapunov,
    InputCell,
    RowInputs,
    find_shapes,
    lever,
    obstruction_text,
    shape_regions,
    side_friction_rules,
    sum_of_squares,
    why_not_followed,
)
from nonsmooth.proofs.clauses.feedback.gradient_law import (
    FeedbackRate,
    LevelRegion,
    LimitedRate,
    balanced,
    build_level_region,
    build_limited_rate,
    certified_rate,
    level_with_rate,
)
from nonsmooth.proofs.findings import Feedback
from nonsmooth.symbolic.mechanics.contact_states import Triple, independent
from nonsmooth.symbolic.mechanics.scene import Wheel
from nonsmooth.symbolic.numbers.lazy import divided
from nonsmooth.symbolic.numbers.number import Number, sign
from nonsmooth.symbolic.numbers.number_text import brief_text, float_text
from nonsmooth.symbolic.numbers.plane import around, cross, dot, turned
from nonsmooth.symbolic.numbers.rounded import either_way

if TYPE_CHECKING:
    from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw, TurnRegion

# ---- how far the contact state may be in doubt ---------------------------------------------------
#
# Up to which distance from a cell's side one common input still serves.
#
# Let V be a control Lyapunov function and let c be known to within ``sigma |c|``, so that any cell within this distance
# may be the true one.  A common input (one speed for each wheel) lowers V in several cells iff zero is not in the hull
# of their covectors ``alpha`` (``V'/2 = alpha . u``; Gordan).  Near the equilibrium all sets are cones, so one number
# sigma says it all: the law survives an error eps in c wherever ``|c| > eps/sigma``.
#
# Cells with one nearest wheel i never conflict: only (i, k) acts through wheel k, so zero in the hull needs b = 0, and
# then every alpha is ``P c . d_i`` times the input of wheel i.  Cells (i, j) and (j, i) hold both roll rows R_i, R_j.
# Mixtures of their twists satisfy these and a mixture of S_i and S_j, so the covectors of V that are orthogonal to all
# of them are mixtures ``lambda S_j(m) S_i + (1 - lambda) S_i(m) S_j``, with m the twist on which R_i and R_j vanish;
# ``S_i(m) S_j(m)`` has the sign of ``-Delta_ij Delta_ji``.  Hence a common input exists at c for every theta iff ::
#
#     (c^T P d_i) (c^T P d_j) Delta_ij Delta_ji < 0
#
# On the side's ray r it holds or not; from there it lasts until ``c^T P d_i`` or ``c^T P d_j`` vanishes, at the angle
# whose sine is ``|r^T P d|/(|r| |P d|)``: there the law of the neighbouring cell has no input left.  The same is true
# of all cells of two neighbouring wheels together, unless both have cells with the same third wheel; and where all rims
# point at one point, of all cells together: there m is one twist for all pairs, the speeds of a rigid motion ``xi``
# give ``V'/2 = (eta - (eta . m)/S_i(m) S_i) . xi`` in the cells of wheel i, with eta the covector of V, and some motion
# in the plane serves all of them iff ``c^T P d_i/S_i(m)`` has one sign.  So the least of these sines is the margin,
# exactly, unless three nearest wheels or two cells with the same third wheel come within reach before that and the rims
# do not meet: then what is reported is a lower bound.


DENOMINATOR = 10**4  # of a rational lower bound
NO_COMMON = "no common input lowers V in both cells at this c and theta (read c as a direction)"

Fan: TypeAlias = tuple[CellCone, ...]
Gap: TypeAlias = tuple[Point, Point]  # two directions, less than a half turn apart


class SideMargin(NamedTuple):
    """A side through the equilibrium between cells (i, j) and (j, i).

    Attributes:
        cones: the cells' cones, the clockwise one first.
        squared: square of the largest sine; 0 where already the side itself has no common input for some theta.
        witness: (c, theta) at that distance at which there is none.
    """

    cones: tuple[CellCone, CellCone]
    squared: Any
    witness: Witness

    @property
    def cells(self) -> tuple[int, int]:
        """Numbers of the cells."""
        return self.cones[0].cell.index, self.cones[1].cell.index


class InputMargin(NamedTuple):
    """The margin of a control Lyapunov function.

    Attributes:
        sides: every side at which the nearest wheel changes.
        squared: square of the margin sigma, or of a lower bound.
        is_exact: whether no larger sigma serves.
    """

    sides: tuple[SideMargin, ...]
    squared: Any
    is_exact: bool

    def __str__(self) -> str:
        if not self.squared:
            side = next(side for side in self.sides if not side.squared)
            return f"margin 0: on the side of the cells {side.cells[0]} and {side.cells[1]} no input serves both"
        bound, value = "" if self.is_exact else " at least", float_text(self.value, 4)
        return f"margin{bound} {value}: one input serves all cells within {value} |c| of c"

    @property
    def value(self) -> float:
        """Sigma, for reading."""
        return float(self.squared) ** 0.5


def build_margin(inputs: RowInputs, lyapunov: ControlLyapunov) -> InputMargin:
    """The margin for an array with two inputs in each cell at the equilibrium, and a V for it."""
    fan = inputs.fan
    turning = [pair for pair in around(fan) if _nearest(pair[0]) != _nearest(pair[1])]
    sides = tuple(_side_margin(cones, lyapunov) for cones in turning)
    with either_way(inputs.partition.scene.field):  # of margins that are as small any will do
        least = min(side.squared for side in sides)
    bounds = [] if _meet(fan) else [gap for gap in _conflicts(fan) if not _is_wider(gap, least)]
    if not bounds:
        return InputMargin(sides, least, is_exact=True)
    return InputMargin(sides, _lower_bound(bounds), is_exact=False)


# ---- one side --------------------------------------------------------------------------------------


def _side_margin(cones: tuple[CellCone, CellCone], lyapunov: ControlLyapunov) -> SideMargin:
    """The nearer of the two directions in which an input vanishes, or the side itself."""
    i, j = _nearest(cones[0]), _nearest(cones[1])
    ray = cones[0].end
    normals = [lyapunov.slope(wheel.direction) for wheel in (i, j)]
    if sign(dot(ray, normals[0])) * sign(dot(ray, normals[1])) * sign(lever(i, j)) * sign(lever(j, i)) >= 0:
        return SideMargin(cones, i.speed * 0, Witness(ray, _conflict(ray, i, j, lyapunov), NO_COMMON))
    sines = [_squared_sine(ray, normal) for normal in normals]
    k = 0 if sign(sines[0] - sines[1]) <= 0 else 1
    x, y = turned(normals[k])
    point = (x, y) if sign(dot(ray, (x, y))) >= 0 else (-x, -y)
    theta = lyapunov.stalling_theta(point, (i, j)[k].position)
    return SideMargin(cones, sines[k], Witness(point, theta, NO_COMMON))


def _squared_sine(ray: Point, normal: Point) -> Any:
    """Of the angle between a ray and the line at right angles to a normal (its cosine to the normal itself)."""
    along = dot(ray, normal)
    return divided(along * along, dot(ray, ray) * dot(normal, normal))


def _conflict(ray: Point, i: Wheel, j: Wheel, lyapunov: ControlLyapunov) -> Any:
    """The theta with ``(P c, w theta + P c . J c) = x S_i + y S_j`` on a side without a common input.

    ``P c = x J D_i + y J D_j`` gives x and y; ``S_i = (J D_i, D_i . p_i)``.  (Parallel rims never conflict.)
    """
    slope, both = lyapunov.slope(ray), cross(i.direction, j.direction)
    x, y = dot(slope, j.direction), -dot(slope, i.direction)
    turning = x * dot(i.direction, i.position) + y * dot(j.direction, j.position)
    return (divided(turning, both) - dot(slope, turned(ray))) / lyapunov.weight


# ---- what else comes within reach ------------------------------------------------------------------


def _meet(fan: Fan) -> bool:
    """Whether the rims of all wheels in the fan point at one point: their roll rows have rank two."""
    wheels = {wheel.index: wheel for cone in fan for wheel in (_nearest(cone), _second(cone))}.values()
    rows = [(*wheel.direction, dot(wheel.direction, turned(wheel.position))) for wheel in wheels]
    return len(independent(rows)) < 3


def _conflicts(fan: Fan) -> Iterator[Gap]:
    """Angles of which both ends in reach would bring in cells that the theorem leaves open.

    Between the cells of the wheels before and after a third one, and between (i, k) and (j, k).
    """
    for k, first in enumerate(fan):
        for step in range(2, len(fan)):
            second = fan[(k + step) % len(fan)]
            if sign(cross(first.end, second.start)) <= 0:
                break
            between = [_nearest(fan[(k + n) % len(fan)]) for n in range(step + 1)]
            changes = sum(a != b for a, b in pairwise(between))
            if changes > 1 or (changes and _second(first) == _second(second)):
                yield first.end, second.start
                break


def _is_wider(gap: Gap, squared: Any) -> bool:
    """Whether ``sin^2(gap/2) >= squared``: ``-a . b + (1 - 2 squared) |a| |b| >= 0``, without taking roots."""
    a, b = gap
    plain, factor, square = -dot(a, b), 1 - 2 * squared, dot(a, a) * dot(b, b)
    if sign(plain) * sign(factor) >= 0:
        return sign(plain) >= 0 and sign(factor) >= 0
    return sign(plain) * sign(plain * plain - factor * factor * square) >= 0


def _lower_bound(gaps: Sequence[Gap]) -> Fraction:
    """Square of a rational just below the smallest half sine."""
    cosines = [sign(dot(a, b)) * float(_squared_sine(a, b)) ** 0.5 for a, b in gaps]
    numerator = int(((1 - max(cosines)) / 2) ** 0.5 * DENOMINATOR)
    while not all(_is_wider(gap, Fraction(numerator, DENOMINATOR) ** 2) for gap in gaps):
        numerator -= 1
    return Fraction(numerator, DENOMINATOR) ** 2


def _nearest(cone: CellCone) -> Wheel:
    return cone.cell.states[0].rows[0].wheel


def _second(cone: CellCone) -> Wheel:
    return cone.cell.states[0].rows[2].wheel


# ---- the decision --------------------------------------------------------------------------------


BOTH_VANISH = "both input coefficients vanish at this c and theta"


@dataclass(frozen=True)
class FeedbackResult:
    """Verdict with its evidence.

    Attributes:
        verdict: see :class:`nonsmooth.proofs.findings.Feedback`.
        reason: one sentence for people.
        inputs: the cells about the checked point with their inputs.
        witness: a nonzero c with its theta (the value) at which no input changes V.
        lyapunov: V; the witness of a failure is about ``|c|^2 + l^2 theta^2``.
        none_serves: whether no ``c^T P c + w theta^2`` at all is a control Lyapunov function.
        obstruction: the normal m of a plane that holds every motion inputs can give at the equilibrium (no
            certificate): then no static feedback stabilizes.
        cascade: the law that takes theta first, where no quadratic V serves.
        rate: certified ``V' <= -2 k kappa V`` near the equilibrium (stabilizable).
    """

    verdict: Feedback
    reason: str
    inputs: RowInputs
    witness: Witness | None = None
    lyapunov: ControlLyapunov = SQUARES
    none_serves: bool = False
    obstruction: Triple | None = None
    cascade: CascadeLaw | None = None
    rate: FeedbackRate | None = None

    @property
    def partition(self) -> Partition:
        """The cells about the checked point."""
        return self.inputs.partition

    @cached_property
    def margin(self) -> InputMargin | None:
        """How far the contact state may be in doubt; None without a law by V."""
        return build_margin(self.inputs, self.lyapunov) if self.has_lyapunov else None

    @cached_property
    def region(self) -> LevelRegion | TurnRegion | None:
        """Starts from which the law brings the body home, under exact kinematics.

        None without a law, and where that is only known of starts near the equilibrium.
        """
        if self.cascade is None:
            return build_level_region(self.inputs, self.lyapunov) if self.has_lyapunov else None
        from nonsmooth.proofs.clauses.feedback.cascade_law import build_turn_region

        return build_turn_region(self.cascade, self.inputs)

    @cached_property
    def limited(self) -> LimitedRate | None:
        """How fast V falls where wheels have limits of speed; None without a law by V with a certified rate."""
        return build_limited_rate(self.inputs, self.rate, self.lyapunov) if self.has_lyapunov else None

    @property
    def cells(self) -> tuple[InputCell, ...]:
        """The data of the law in every cell; empty where nothing is said of one."""
        is_followed = self.verdict in (Feedback.STABILIZABLE, Feedback.NO_CERTIFICATE)
        return self.inputs.cells if is_followed else ()

    @property
    def holding(self) -> FeedbackResult:
        """Whether some law holds the pose: laws by rows are sought where Theorem 4 asks for one only."""
        return self

    @property
    def law(self) -> str | None:
        """The stabilizing law, where there is one."""
        if self.verdict is not Feedback.STABILIZABLE:
            return None
        return self.lyapunov.law if self.cascade is None else str(self.cascade)

    @property
    def must_know(self) -> tuple[str, ...]:
        """What the law must know to choose its inputs."""
        return "the position", "the heading", "which two wheels are nearest"

    @property
    def certified_kappa(self) -> Fraction | None:
        """Kappa with ``V' <= -2 k kappa V`` near the equilibrium, k the gain; None where no rate is certified."""
        return None if self.rate is None else self.rate.kappa

    @property
    def reach(self) -> Number | None:
        """The rate holds within this distance of c*, in the cells there; None where they alone bound it."""
        reach = None if self.rate is None else self.rate.reach
        return None if reach is None else self.partition.scene.field(reach)

    @property
    def rate_level(self) -> Fraction | None:
        """Below this level of V the error falls at the certified rate; None where none is known."""
        if self.rate is None or not isinstance(self.region, LevelRegion):
            return None
        return level_with_rate(self.inputs, self.rate, self.region)

    @property
    def position_error(self) -> float | None:
        """The error in c that one input still serves, as a part of |c|; None where it is not known."""
        return None if self.margin is None else self.margin.value

    @property
    def has_lyapunov(self) -> bool:
        """Whether ``lyapunov`` certifies the law: it stabilizes, and not by a cascade."""
        return self.verdict is Feedback.STABILIZABLE and self.cascade is None

    @property
    def printed_sign_fails(self) -> tuple[int, ...]:
        """Cells in which the paper's ``u_j = -k theta`` turns the body away from theta = 0."""
        return tuple(data.cell.index for data in self.cells if data.torque_sign < 0)

    @property
    def rim_signs(self) -> list[int]:
        """The sign of ``v = +-|c| d_i`` in each cell at the equilibrium with which c comes home while theta is held.

        Under a law by ``V = c^T P c + w theta^2`` it is that with ``c^T P v < 0``.
        """
        if self.cascade is None:
            return [-sign_condition.sign(self.lyapunov) for sign_condition in self.inputs.sign_conditions]
        signs = {wheel.index: s for wheel, s in zip(self.cascade.wheels, self.cascade.signs, strict=True)}
        return [signs[data.nearest.index] for data in self.inputs.local]

    def undecided(self, reason: str) -> FeedbackResult:
        """The same without a claim."""
        return FeedbackResult(Feedback.UNDECIDED, reason, self.inputs)


def decide_feedback(partition: Partition) -> FeedbackResult:
    """Decide the feedback clause for a centred partition of rule ``nearest``."""
    inputs = RowInputs(partition)
    squares = sum_of_squares(inputs.length)
    blocked, unfollowed = side_friction_rules(inputs.acting), why_not_followed(partition)
    if unfollowed is not None:
        verdict = Feedback.NOT_APPLICABLE if blocked else Feedback.UNDECIDED
        return FeedbackResult(verdict, blocked or unfollowed, inputs)
    single = next((data for data in inputs.local if data.lever is None), None)
    witness = None if single is None else single.idle_plane(squares)
    if blocked:
        return FeedbackResult(Feedback.NOT_APPLICABLE, blocked, inputs, witness, squares)
    if single is not None:
        reason = (
            f"exactly: the rim line of wheel {single.second.index} passes through wheel {single.nearest.index}, so "
            f"cell {single.cell.index} ({single.state.name}) holds a side row in third place and one input acts alone"
        )
        return _refused(inputs, reason, witness, squares)
    stalls = ((data, data.stall()) for data in inputs.local)
    stalling = next(((data, point) for data, point in stalls if point is not None), None)
    if stalling is None:
        reason = "c . d_i has one strict sign on every closed cell at the equilibrium, so u = -k (a, b) gives V* < 0"
        rate = certified_rate(inputs, squares)
        return FeedbackResult(Feedback.STABILIZABLE, reason, inputs, lyapunov=squares, rate=rate)
    rated = []
    for shape in find_shapes(inputs.sign_conditions):
        lyapunov = balanced(inputs, shape)
        rated.append((certified_rate(inputs, lyapunov), lyapunov))
    if not rated:
        return _by_cascade(inputs, *stalling, squares)
    rate, lyapunov = max(rated, key=lambda entry: 0 if entry[0] is None else entry[0].kappa)
    reason = (
        "c^T P d_i has one strict sign on every closed cell at the equilibrium, "
        f"while c . d_i vanishes in cell {stalling[0].cell.index}"
    )
    return FeedbackResult(Feedback.STABILIZABLE, reason, inputs, lyapunov=lyapunov, rate=rate)


def _by_cascade(inputs: RowInputs, stalling: InputCell, stall: Point, squares: ControlLyapunov) -> FeedbackResult:
    """The law that takes theta first where no such V was found, or why there is none of that form."""
    from nonsmooth.proofs.clauses.feedback.cascade_law import find_cascade

    none_serves = not shape_regions(inputs.sign_conditions)
    cascade = find_cascade(inputs.fan)
    if cascade is not None:
        none = "no c^T P c + w theta^2 serves" if none_serves else "no rounded c^T P c + w theta^2 serves"
        return FeedbackResult(
            Feedback.STABILIZABLE,
            f"{none} (c . d_i vanishes in cell {stalling.cell.index}), but {cascade.descent.reason}",
            inputs,
            lyapunov=squares,
            none_serves=none_serves,
            cascade=cascade,
        )
    theta = squares.stalling_theta(stall, stalling.nearest.position)
    x, y, turn = (brief_text(entry) for entry in (*stall, theta))
    reason = (
        f"in cell {stalling.cell.index} V' = 0 for every input at c = ({x}, {y}), theta = {turn}: "
        f"{squares} is no control Lyapunov function"
    ) + (", and no other c^T P c + w theta^2 is one" if none_serves else "")
    return _refused(inputs, reason, Witness(stall, theta, BOTH_VANISH), squares, none_serves=none_serves)


def _refused(
    inputs: RowInputs, reason: str, witness: Witness | None, squares: ControlLyapunov, *, none_serves: bool = False
) -> FeedbackResult:
    """No certificate; where all motions at the equilibrium keep to a plane of twists, for any feedback."""
    normal = inputs.obstruction
    if normal is not None:
        reason = f"{reason}; {obstruction_text(normal)}"
    return FeedbackResult(Feedback.NO_CERTIFICATE, reason, inputs, witness, squares, none_serves, obstruction=normal)
