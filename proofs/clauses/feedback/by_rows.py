"""Clause 4: discontinuous feedback where the third row is a roll row (mu_S < mu_R).

In a cell with both rows of wheel i and the roll row of wheel j the inputs ``u_i, u_j`` act through the control vector
fields of module ``control_fields``.  So with ``V = |c|^2 + l^2 theta^2``: ``V'/2 = a u_i + b u_j``, ``b = (l^2 theta -
c . J p_i)/Delta``, ``a = c . d_i - (d_i . d_j) b``.  Both coefficients vanish iff ``c . d_i = 0`` and ``l^2 theta = c .
J p_i``.  Hence the L_gV law ``u = -k (a, b)`` (Jurdjevic and Quinn) makes ``V* < 0`` off the equilibrium iff no closed
cell holds a nonzero c with ``c . d_i = 0``; that is decided by the signs of ``c . d_i`` at the vertices.  Then:

- where this V fails, all ``c^T P c + w theta^2`` are searched (module ``control_lyapunov``);
- what the law is certified for, at which rate, from where, with limited speeds and with doubt about the contact state:
  modules ``gradient_law`` and ``input_margin``;
- where no V of this form serves, a law that takes theta first may (module ``cascade_law``);
- with a side row third only ``u_i`` acts and V' vanishes on a plane.  That there is no such V refutes no other; but
  where all control fields at the equilibrium lie in one plane no static feedback does (module ``obstruction``).
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.cells.polygon import Point
from nonsmooth.proofs.clauses.feedback.cascade_law import (
    CascadeLaw,
    Descent,
    TurnRegion,
    build_turn_region,
    find_cascade,
)
from nonsmooth.proofs.clauses.feedback.control_fields import (
    InputCell,
    RowInputs,
    side_friction_rules,
    why_not_followed,
)
from nonsmooth.proofs.clauses.feedback.control_lyapunov import (
    SQUARES,
    ControlLyapunov,
    find_shapes,
    shape_regions,
    sum_of_squares,
)
from nonsmooth.proofs.clauses.feedback.gradient_law import (
    FeedbackRate,
    LevelRegion,
    LimitedRate,
    balanced,
    build_level_region,
    build_limited_rate,
    certified_rate,
)
from nonsmooth.proofs.clauses.feedback.input_margin import InputMargin, build_margin
from nonsmooth.proofs.clauses.feedback.obstruction import obstruction_text
from nonsmooth.proofs.clauses.witness import Witness
from nonsmooth.proofs.findings.verdicts import Feedback
from nonsmooth.symbolic.mechanics.constraints import Triple
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text

BOTH_VANISH = "both input coefficients vanish at this c and theta"


@dataclass(frozen=True)
class FeedbackResult:
    """Verdict with its evidence.

    Attributes:
        verdict: see :class:`nonsmooth.proofs.findings.verdicts.Feedback`.
        reason: one sentence for people.
        partition: the cells about the checked point.
        witness: a nonzero c with its theta (the value) at which no input changes V.
        lyapunov: V; the witness of a failure is about ``|c|^2 + l^2 theta^2``.
        none_serves: whether no ``c^T P c + w theta^2`` at all is a control Lyapunov function.
        obstruction: the normal m of a plane that holds every motion inputs can give at the equilibrium (no
            certificate): then no static feedback stabilizes.
        cascade: the law that takes theta first, where no quadratic V serves.
        rate: certified ``V' <= -2 k kappa V`` near the equilibrium (stabilizable).
        margin: how far the contact state may be in doubt (stabilizable).
        region: starts from which the law brings the body home, under exact kinematics (stabilizable); None where
            that is only known of starts near the equilibrium.
        limited: how fast V falls where wheels have limits of speed (stabilizable, with a certified rate).
    """

    verdict: Feedback
    reason: str
    partition: Partition
    witness: Witness | None = None
    lyapunov: ControlLyapunov = SQUARES
    none_serves: bool = False
    obstruction: Triple | None = None
    cascade: CascadeLaw | None = None
    rate: FeedbackRate | None = None
    margin: InputMargin | None = None
    region: LevelRegion | TurnRegion | None = None
    limited: LimitedRate | None = None

    @cached_property
    def inputs(self) -> RowInputs:
        """The cells with their inputs."""
        return RowInputs(self.partition)

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
            return [-demand.sign(self.lyapunov) for demand in self.inputs.demands]
        signs = {wheel.index: s for wheel, s in zip(self.cascade.wheels, self.cascade.signs, strict=True)}
        return [signs[data.nearest.index] for data in self.inputs.local]

    def undecided(self, reason: str) -> FeedbackResult:
        """The same without a claim."""
        return FeedbackResult(Feedback.UNDECIDED, reason, self.partition)


def decide_feedback(partition: Partition) -> FeedbackResult:
    """Decide the feedback clause for a centred partition of rule ``nearest``."""
    inputs = RowInputs(partition)
    squares = sum_of_squares(inputs.length)
    blocked, unfollowed = side_friction_rules(inputs.acting), why_not_followed(partition)
    if unfollowed is not None:
        verdict = Feedback.NOT_APPLICABLE if blocked else Feedback.UNDECIDED
        return FeedbackResult(verdict, blocked or unfollowed, partition)
    single = next((data for data in inputs.local if data.lever is None), None)
    witness = None if single is None else single.idle_plane(squares)
    if blocked:
        return FeedbackResult(Feedback.NOT_APPLICABLE, blocked, partition, witness, squares)
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
        return _by_gradient(inputs, reason, certified_rate(inputs, squares), squares)
    found = []
    for shape in find_shapes(inputs.demands):
        lyapunov = balanced(inputs, shape)
        found.append((certified_rate(inputs, lyapunov), lyapunov))
    if not found:
        return _by_cascade(inputs, *stalling, squares)
    rate, lyapunov = max(found, key=lambda entry: 0 if entry[0] is None else entry[0].kappa)
    reason = (
        "c^T P d_i has one strict sign on every closed cell at the equilibrium, "
        f"while c . d_i vanishes in cell {stalling[0].cell.index}"
    )
    return _by_gradient(inputs, reason, rate, lyapunov)


def _by_gradient(
    inputs: RowInputs, reason: str, rate: FeedbackRate | None, lyapunov: ControlLyapunov
) -> FeedbackResult:
    """The law ``u = -k (a, b)`` by a V, with its margin and region."""
    return FeedbackResult(
        Feedback.STABILIZABLE,
        reason,
        inputs.partition,
        lyapunov=lyapunov,
        rate=rate,
        margin=build_margin(inputs, lyapunov),
        region=build_level_region(inputs, lyapunov),
        limited=build_limited_rate(inputs, rate, lyapunov),
    )


def _by_cascade(inputs: RowInputs, stalling: InputCell, stall: Point, squares: ControlLyapunov) -> FeedbackResult:
    """The law that takes theta first where no such V was found, or why there is none of that form."""
    none_serves = not shape_regions(inputs.demands)
    cascade = find_cascade(inputs.fan)
    if cascade is not None:
        none = "no c^T P c + w theta^2 serves" if none_serves else "no rounded c^T P c + w theta^2 serves"
        return FeedbackResult(
            Feedback.STABILIZABLE,
            f"{none} (c . d_i vanishes in cell {stalling.cell.index}), but {cascade.descent.reason}",
            inputs.partition,
            lyapunov=squares,
            none_serves=none_serves,
            cascade=cascade,
            region=build_turn_region(cascade, inputs) if cascade.descent is Descent.SLOW_TURNS else None,
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
    return FeedbackResult(
        Feedback.NO_CERTIFICATE, reason, inputs.partition, witness, squares, none_serves, obstruction=normal
    )
