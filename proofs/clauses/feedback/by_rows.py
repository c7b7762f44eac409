"""Clause 4: discontinuous feedback where the third row is a roll row (mu_S < mu_R).

In a cell with both rows of wheel i and the roll row of wheel j the inputs ``u_i, u_j`` act through ::

    omega = (u_j - u_i d_i.d_j)/Delta,   v = u_i d_i - omega J p_i,   Delta = d_j . J(p_j - p_i)

so with ``V = |c|^2 + l^2 theta^2``: ``V'/2 = a u_i + b u_j``, ``b = (l^2 theta - c . J p_i)/Delta``,
``a = c . d_i - (d_i . d_j) b``.  Both coefficients vanish iff ``c . d_i = 0`` and ``l^2 theta = c . J p_i``.  Hence the
L_gV law ``u = -k (a, b)`` (Jurdjevic and Quinn) makes ``V* < 0`` off the equilibrium iff no closed cell holds a nonzero
c with ``c . d_i = 0``; that is decided by the signs of ``c . d_i`` at the vertices.  Where this V fails, all
``c^T P c + w theta^2`` are searched (module ``control_lyapunov``).  With a side row third only
``u_i`` acts and V' vanishes on a plane.  That there is no such V refutes no other; but where all control fields at the
equilibrium lie in one plane no static feedback does (:mod:`nonsmooth.proofs.clauses.feedback.obstruction`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction

from nonsmooth.analysis.cells.fan import build_fan
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.analysis.cells.support import limiting_support
from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw, Descent, find_cascade
from nonsmooth.proofs.clauses.feedback.control_lyapunov import (
    SQUARES,
    ControlLyapunov,
    find_shapes,
    shape_regions,
    sum_of_squares,
)
from nonsmooth.proofs.clauses.feedback.feedback_rate import FeedbackRate, balanced, certified_rate
from nonsmooth.proofs.clauses.feedback.gradient_law import gradient_text
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell, build_input_cell, is_local
from nonsmooth.proofs.clauses.feedback.input_margin import InputMargin, build_margin
from nonsmooth.proofs.clauses.feedback.level_region import (
    NEXT_BELOW,
    LevelRegion,
    build_level_region,
    is_above,
    least_level,
)
from nonsmooth.proofs.clauses.feedback.limited_rate import LimitedRate, build_limited_rate
from nonsmooth.proofs.clauses.feedback.obstruction import obstruction_text
from nonsmooth.proofs.clauses.feedback.row_hypotheses import (
    acting_wheels,
    obstruction_of,
    obstructs,
    side_friction_rules,
    single_input,
    why_not_followed,
)
from nonsmooth.proofs.clauses.feedback.turn_region import TurnRegion, build_turn_region
from nonsmooth.proofs.clauses.witness import Witness
from nonsmooth.proofs.verdicts import Feedback
from nonsmooth.symbolic.constraints import Triple
from nonsmooth.symbolic.number_text import brief_text
from nonsmooth.symbolic.plane import dot, turned

_TRIES = 20  # of levels, until one keeps to the support polygon


@dataclass(frozen=True)
class FeedbackResult:
    """Verdict with its evidence.

    Attributes:
        verdict: see :class:`nonsmooth.proofs.verdicts.Feedback`.
        cells: the data of the law in every cell (empty where not applicable).
        local: numbers of the cells whose closure holds the equilibrium; these decide.
        witness: a nonzero c with its theta (the value) at which no input changes V.
        reason: one sentence for people.
        rate: certified ``V' <= -2 k kappa V`` near the equilibrium (stabilizable).
        lyapunov: V; the witness of a failure is about ``|c|^2 + l^2 theta^2``.
        none_serves: whether no ``c^T P c + w theta^2`` at all is a control Lyapunov function.
        obstruction: the normal m of a plane that holds every motion inputs can give at the equilibrium (no
            certificate): then no static feedback stabilizes.
        cascade: the law that takes theta first, where no quadratic V serves.
        margin: how far the contact state may be in doubt (stabilizable).
        region: starts from which the law brings the body home, under exact kinematics (stabilizable); None where
            that is only known of starts near the equilibrium.
        limited: how fast V falls where wheels have limits of speed (stabilizable, with a certified rate).
    """

    verdict: Feedback
    cells: tuple[InputCell, ...]
    local: frozenset[int]
    witness: Witness | None
    reason: str
    rate: FeedbackRate | None = None
    lyapunov: ControlLyapunov = SQUARES
    none_serves: bool = False
    margin: InputMargin | None = None
    obstruction: Triple | None = None
    cascade: CascadeLaw | None = None
    region: LevelRegion | TurnRegion | None = None
    limited: LimitedRate | None = None

    @property
    def holding(self) -> FeedbackResult:
        """Whether some law holds the pose: laws by rows are sought where Theorem 4 asks for one only."""
        return self

    @property
    def law(self) -> str | None:
        """The stabilizing law, where there is one."""
        if self.verdict is not Feedback.STABILIZABLE:
            return None
        if self.cascade is not None:
            return str(self.cascade)
        return gradient_text(self.lyapunov)

    @property
    def must_know(self) -> tuple[str, ...]:
        """What the law must know to choose its inputs."""
        return "the position", "the heading", "which two wheels are nearest"

    @property
    def certified_kappa(self) -> Fraction | None:
        """Kappa with ``V' <= -2 k kappa V`` near the equilibrium, k the gain; None where no rate is certified."""
        return None if self.rate is None else self.rate.kappa

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

    def check(self) -> bool:
        """Re-verify the sign condition (stabilizable) or the witness (no certificate)."""
        if self.verdict in (Feedback.NOT_APPLICABLE, Feedback.UNDECIDED):
            return True
        local = [data for data in self.cells if is_local(data.cell)]
        genuine = bool(local) and all(data.check() for data in local)
        if self.verdict is Feedback.STABILIZABLE and not self._region_holds():
            return False
        if self.verdict is Feedback.STABILIZABLE and self.cascade is not None:
            about_it = genuine and {data.nearest for data in local} == set(self.cascade.wheels)
            if not about_it or any(data.lever is None for data in local):
                return False
            none = not shape_regions([data.demand for data in local])
            return self.none_serves == none and self.cascade.check()
        if self.verdict is Feedback.STABILIZABLE:
            signs = all(data.lever is not None and data.demand.sign(self.lyapunov) for data in local)
            decreasing = signs and self.lyapunov.is_positive
            sound = (self.margin is None or self.margin.check(self.lyapunov)) and self._limits_hold()
            return genuine and decreasing and sound and (self.rate is None or self.rate.check(self.lyapunov))
        if (
            not genuine
            or self.witness is None
            or not any(data.is_idle(self.witness, self.lyapunov.weight) for data in local)
        ):
            return False
        return obstructs(self.obstruction, local) and (
            not self.none_serves or not shape_regions([data.demand for data in local])
        )

    def _limits_hold(self) -> bool:
        """Whether what limits of speed leave of the rate, if there are any, verifies on these cells."""
        if self.limited is None:
            return True
        local = frozenset(data.cell.index for data in self.cells if is_local(data.cell))
        rate = self.rate
        return rate is not None and self.limited.check(self.cells, local, rate, self.lyapunov)

    def _region_holds(self) -> bool:
        """Whether the region, if there is one, is about this law and verifies on these cells."""
        if self.region is None:
            return True
        if isinstance(self.region, LevelRegion):
            about_it = self.cascade is None and self.region.lyapunov == self.lyapunov
        else:
            slow = self.cascade is not None and self.cascade.descent is Descent.SLOW_TURNS
            about_it = slow and self.region.cascade == self.cascade
        genuine = all(data.check() for data in self.cells)
        local = frozenset(data.cell.index for data in self.cells if is_local(data.cell))
        return about_it and genuine and self.region.check(self.cells, local)


def decide_feedback(partition: Partition) -> FeedbackResult:
    """Decide the feedback clause for a centred partition of rule ``nearest``."""
    squares = sum_of_squares(partition.scene.check.length)
    blocked = side_friction_rules(acting_wheels(partition))
    unfollowed = why_not_followed(partition)
    if unfollowed is not None:
        verdict = Feedback.NOT_APPLICABLE if blocked else Feedback.UNDECIDED
        return FeedbackResult(verdict, (), frozenset(), None, blocked or unfollowed)
    single = single_input(partition)
    witness = None if single is None else single.idle_plane(squares.weight)
    if blocked:
        return FeedbackResult(Feedback.NOT_APPLICABLE, (), frozenset(), witness, blocked, lyapunov=squares)
    cells = tuple(build_input_cell(cell, state) for cell in partition.cells for state in cell.states)
    local = frozenset(cell.index for cell in partition.cells if is_local(cell))
    if single is not None:
        reason = (
            f"exactly: the rim line of wheel {single.second.index} passes through wheel {single.nearest.index}, so "
            f"cell {single.cell.index} ({single.state.name}) holds a side row in third place and one input acts alone"
        )
        return _refused(cells, local, witness, reason, squares)
    for data in cells:
        stall = data.stall() if data.cell.index in local else None
        if stall is not None:
            return _shaped(partition, cells, local, data, stall)
    reason = "c . d_i has one strict sign on every closed cell at the equilibrium, so u = -k (a, b) gives V* < 0"
    return _gradient_result(partition, cells, local, reason, certified_rate(partition, squares), squares)


def _gradient_result(
    partition: Partition,
    cells: tuple[InputCell, ...],
    local: frozenset[int],
    reason: str,
    rate: FeedbackRate | None,
    lyapunov: ControlLyapunov,
) -> FeedbackResult:
    """The law ``u = -k (a, b)`` by a V, with its margin and region."""
    margin = build_margin(build_fan(partition), lyapunov)
    region = _supported_region(partition, cells, local, lyapunov)
    check = partition.scene.check
    limited = build_limited_rate(cells, local, check.radius, rate, lyapunov, check.length)
    return FeedbackResult(
        Feedback.STABILIZABLE,
        cells,
        local,
        None,
        reason,
        rate,
        lyapunov,
        margin=margin,
        region=region,
        limited=limited,
    )


def _supported_region(
    partition: Partition, cells: tuple[InputCell, ...], local: frozenset[int], lyapunov: ControlLyapunov
) -> LevelRegion | None:
    """The largest level of V on all cells of the square, lowered until the body does not tip in it."""
    check = partition.scene.check
    region = build_level_region(cells, local, check.radius, lyapunov, check.length)
    support = limiting_support(partition)
    if region is None or support is None:
        return region
    if not support.stands:
        return None
    level = min(region.level, least_level(support.sides, lyapunov, check.length))
    for _ in range(_TRIES):
        if all(is_above(side, lyapunov, level) for side in support.sides):
            return replace(region, level=level)
        level *= NEXT_BELOW
    return None


def _shaped(
    partition: Partition, cells: tuple[InputCell, ...], local: frozenset[int], data: InputCell, stall: Point
) -> FeedbackResult:
    """The best ``c^T P c + w theta^2`` where ``|c|^2 + l^2 theta^2`` stalls in a cell, or what there is instead."""
    demands = [data.demand for data in cells if data.cell.index in local]
    found = []
    for shape in find_shapes(demands):
        lyapunov = balanced(partition, shape)
        found.append((certified_rate(partition, lyapunov), lyapunov))
    if found:
        rate, lyapunov = max(found, key=lambda entry: 0 if entry[0] is None else entry[0].kappa)
        reason = (
            "c^T P d_i has one strict sign on every closed cell at the equilibrium, "
            f"while c . d_i vanishes in cell {data.cell.index}"
        )
        return _gradient_result(partition, cells, local, reason, rate, lyapunov)
    return _cascaded(partition, cells, local, data, stall)


def _cascaded(
    partition: Partition, cells: tuple[InputCell, ...], local: frozenset[int], data: InputCell, stall: Point
) -> FeedbackResult:
    """The law that takes theta first where no such V was found, or why there is none of that form."""
    none_serves = not shape_regions([data.demand for data in cells if data.cell.index in local])
    squares = sum_of_squares(partition.scene.check.length)
    cascade = find_cascade(build_fan(partition))
    if cascade is not None:
        none = "no c^T P c + w theta^2 serves" if none_serves else "no rounded c^T P c + w theta^2 serves"
        reason = f"{none} (c . d_i vanishes in cell {data.cell.index}), but {cascade.descent.reason}"
        slow = cascade.descent is Descent.SLOW_TURNS and limiting_support(partition) is None
        region = build_turn_region(cascade, cells, local, partition.scene.check.radius) if slow else None
        return FeedbackResult(
            Feedback.STABILIZABLE,
            cells,
            local,
            None,
            reason,
            lyapunov=squares,
            none_serves=none_serves,
            cascade=cascade,
            region=region,
        )
    theta = dot(stall, turned(data.nearest.position)) / squares.weight
    witness = Witness(stall, theta, "both input coefficients vanish at this c and theta")
    reason = (
        f"in cell {data.cell.index} V' = 0 for every input at c = "
        f"({brief_text(stall[0])}, {brief_text(stall[1])}), theta = {brief_text(theta)}: "
        f"{squares} is no control Lyapunov function"
    ) + (", and no other c^T P c + w theta^2 is one" if none_serves else "")
    return _refused(cells, local, witness, reason, squares, none_serves=none_serves)


def _refused(
    cells: tuple[InputCell, ...],
    local: frozenset[int],
    witness: Witness | None,
    reason: str,
    lyapunov: ControlLyapunov,
    *,
    none_serves: bool = False,
) -> FeedbackResult:
    """No certificate; where all motions at the equilibrium keep to a plane of twists, for any feedback."""
    normal = obstruction_of([data for data in cells if data.cell.index in local])
    if normal is not None:
        reason = f"{reason}; {obstruction_text(normal)}"
    return FeedbackResult(
        Feedback.NO_CERTIFICATE,
        cells,
        local,
        witness,
        reason,
        lyapunov=lyapunov,
        none_serves=none_serves,
        obstruction=normal,
    )


def rim_signs(feedback: FeedbackResult) -> list[int]:
    """The sign of ``v = +-|c| d_i`` in each cell at the equilibrium with which c comes home while theta is held.

    Under a law by ``V = c^T P c + w theta^2`` it is that with ``c^T P v < 0``.
    """
    local = [data for data in feedback.cells if data.cell.index in feedback.local]
    if feedback.cascade is None:
        return [-data.demand.sign(feedback.lyapunov) for data in local]
    signs = {wheel.index: s for wheel, s in zip(feedback.cascade.wheels, feedback.cascade.signs, strict=True)}
    return [signs[data.nearest.index] for data in local]
