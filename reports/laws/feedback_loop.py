"""The closed loop of an array under rule ``nearest``: the law that the feedback clause certifies, or another by name.

A path is never shown beside a verdict that it contradicts: under the certified law, and from a start in its certified
region, V may not rise and the body may not leave the checked square.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from nonsmooth.analysis.cells.contact_partition import build_partition
from nonsmooth.analysis.cells.contact_rule import contact_rule
from nonsmooth.analysis.cells.fan import build_fan
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.analysis.fields.constant_field import CellwiseField, Pose, Speeds, StateLaw, feedback_field
from nonsmooth.analysis.fields.feedback_laws import (
    CellLaw,
    cascade_law,
    corrected_law,
    gradient_law,
    printed_law,
    tangential_law,
)
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.motion.saturation import limited_law, with_saturation
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory
from nonsmooth.proofs.clauses.feedback.by_rows import FeedbackResult, decide_feedback
from nonsmooth.proofs.clauses.feedback.cascade_law import CascadeLaw, Descent, TurnRegion, find_cascade
from nonsmooth.proofs.clauses.feedback.gradient_law import LevelRegion
from nonsmooth.proofs.findings import Contradiction, ContradictionError, Feedback
from nonsmooth.reports.output.study_options import LawName
from nonsmooth.symbolic.mechanics.contact_states import ContactState
from nonsmooth.symbolic.numbers.plane import XY, pose_in_floats

GAIN = 1.0
# A rise of V that may be the integrator's own, relative to V at the start: steps err by 1e-12, events by rounding.
RISE_SLACK = 1e-7
ROUNDING = 1e-16  # of V at the equilibrium, relative to the level of the region
PAPER_LAW = "u_i = |u_j| + k |c|, u_j = {}k theta"
WEIGHED_PAPER_LAW = "u_i = |u_j| + k |c|, u_j = {}k l theta, l = {}"
_PAPER_LAWS = {LawName.CORRECTED: corrected_law, LawName.PRINTED: printed_law}


@dataclass(frozen=True, eq=False)
class FeedbackLoop:
    """A feedback law of an array; all poses are measured from the checked point.

    Attributes:
        partition: the cells about the checked point.
        feedback: what the feedback clause says of them.
        law: which law, by its own name.
        kinematics: exact pose or leading order.
        gain: k (1/time).
    """

    partition: Partition
    feedback: FeedbackResult
    law: LawName
    kinematics: Kinematics
    gain: float = GAIN

    @property
    def is_certified(self) -> bool:
        """Whether the law is the one that the feedback clause certifies, under these kinematics."""
        return self.law is certified_law(self.feedback) and not uncertified_kinematics(self.feedback, self.kinematics)

    @property
    def region(self) -> LevelRegion | TurnRegion | None:
        """Starts from which the body is proved to come home."""
        return self.feedback.region if self.is_certified else None

    @property
    def formula(self) -> str:
        """The law in plain text."""
        match self.law:
            case LawName.CORRECTED:
                return self._paper_formula("-sgn(d_j.J(p_j - p_i)) ")
            case LawName.PRINTED:
                return self._paper_formula("-")
            case LawName.CASCADE:
                return str(self.cascade)
            case _:
                return self.feedback.lyapunov.law

    def _paper_formula(self, sign: str) -> str:
        length = self.partition.scene.check.length
        return PAPER_LAW.format(sign) if length == 1 else WEIGHED_PAPER_LAW.format(sign, length)

    @property
    def status(self) -> str:
        """Whether the clause certifies the law, in words."""
        certified = certified_law(self.feedback)
        if self.is_certified:
            return "certified by the feedback clause"
        if certified is None:
            return f"not certified (the feedback clause: {self.feedback.verdict})"
        if certified is self.law:
            return f"not certified under {self.kinematics} kinematics"
        return f"not certified (the feedback clause certifies the {certified} law)"

    @property
    def name(self) -> str:
        """Of the law."""
        return str(self.law)

    @property
    def title(self) -> str:
        """Its name with what the clause says of it."""
        return f"{self.law} law, {self.status}"

    @property
    def region_text(self) -> str | None:
        """The certified region in words; None where there is none, or it is not known."""
        return None if self.region is None else str(self.region)

    def holds(self, pose: tuple[float, float, float]) -> bool | None:
        """Whether the certified region holds a start; None where there is none."""
        return None if self.region is None else self.region.contains(pose)

    def words(self, pose: tuple[float, float, float]) -> list[str]:
        """Lines about the law, for a path from this start."""
        lines = [f"feedback: {self.title}, k = {self.gain:g}", self.formula]
        if not self.is_certified:
            return lines
        if self.region is None:
            return [*lines, "certified near c*; how near is not known"]
        where = "inside" if self.holds(pose) else "outside"
        return [*lines, f"certified region: {self.region}; the start lies {where} it"]

    @property
    def turning_length(self) -> float:
        """The length of the law of slow turns: the half-width of the checked square."""
        return self.partition.scene.check.half_width

    @cached_property
    def cascade(self) -> CascadeLaw:
        """The law that takes theta first.

        Raises:
            ValueError: where there is none.
        """
        cascade = self.feedback.cascade or find_cascade(build_fan(self.partition))
        if cascade is None:
            raise ValueError("--law cascade: required an array with a law that takes theta first, received one without")
        return cascade

    @cached_property
    def speeds(self) -> StateLaw:
        """The speeds in every cell, within the limits of the wheels."""
        return limited_law(self.wanted, self.limits)

    @cached_property
    def limits(self) -> dict[int, float]:
        """The largest speeds of the wheels that have one."""
        return {index: float(limit) for index, limit in self.partition.scene.speed_limits.items()}

    @cached_property
    def wanted(self) -> CellLaw:
        """The speeds in every cell that the law asks for."""
        if self.law in _PAPER_LAWS:
            return _PAPER_LAWS[self.law](self.gain, float(self.partition.scene.check.length))
        if self.law is LawName.GRADIENT:
            (e, f), weight = self.feedback.lyapunov.shape, self.feedback.lyapunov.weight
            return gradient_law(self.gain, (float(e), float(f)), float(weight))
        if self.cascade.descent is Descent.SLOW_TURNS:
            return tangential_law(self.gain, self.turning_length)
        signs = zip(self.cascade.wheels, self.cascade.signs, strict=True)
        return cascade_law(self.gain, {wheel.index: side for wheel, side in signs})

    def field(self, partition: Partition) -> CellwiseField:
        """The field of the loop on the same cells in the scene's own coordinates."""
        return feedback_field(partition, self._law_in(partition, self.speeds), self.kinematics)

    def inputs(self, partition: Partition) -> list[Speeds]:
        """The speeds from the pose in each of the same cells, in the scene's own coordinates."""
        law = self._law_in(partition, self.speeds)
        return [law(cell.states[0]) for cell in partition.cells]

    def with_saturation(self, partition: Partition, path: Trajectory) -> Trajectory:
        """The path with the times at which wheels reach their largest speeds, and no longer run at them."""
        law = self._law_in(partition, self.wanted)
        wanted = {f"cell {cell.index}": law(cell.states[0]) for cell in partition.cells} if self.limits else {}
        return with_saturation(path, wanted, self.limits)

    def _law_in(self, partition: Partition, law_of_state: StateLaw) -> StateLaw:
        """A law of poses in the scene's own coordinates."""
        x, y = partition.scene.check.place
        centred = {state.name: state for cell in self.partition.cells for state in cell.states}

        def law(state: ContactState) -> Speeds:
            speeds = law_of_state(centred[state.name])

            def shifted(pose: Pose) -> Mapping[int, float]:
                return speeds((float(pose[0]) - x, float(pose[1]) - y, float(pose[2])))

            return shifted

        return law

    def refuse_contradiction(self, path: Trajectory, centre: XY = (0.0, 0.0)) -> None:
        """Compare a path with what is certified about its start; ``centre`` is the checked point in its coordinates.

        Within a region its function falls.  Without one the law is certified near the point only, and nothing is
        compared, but where theta decays by itself from every start: then theta^2 falls.

        Raises:
            ContradictionError: where V (or theta) rises along the path, or the body leaves the checked square.
        """
        region = self.region
        poses = [pose_in_floats(state) for state in path.array - (*centre, 0.0)]
        cascade = self.feedback.cascade
        decays = cascade is not None and cascade.descent is not Descent.SLOW_TURNS  # theta, whatever c does
        known = decays if region is None else region.contains(poses[0])
        if not (self.is_certified and known):
            return
        values = np.array([pose[2] ** 2 if region is None else region.value(pose) for pose in poses])
        rise = float((values - np.minimum.accumulate(values)).max())
        left = region is not None and path.end.reason is EndReason.OUTSIDE
        if left or rise > RISE_SLACK * values[0] + ROUNDING * (1.0 if region is None else float(region.level)):
            falling = "theta^2" if region is None else "V"
            seen = "leaves the checked square" if left else f"lets {falling} rise by {rise:.3g} from {values[0]:.3g}"
            start = ", ".join(f"{float(value):.6g}" for value in path.states[0])
            where = "" if region is None else f" where {region}"
            certified = f"the feedback clause certifies that {falling} falls under the {self.law} law{where}"
            path_seen = f"the path from ({start}), as it was computed, {seen}"
            raise ContradictionError(self.partition.scene.name, law_and_path(certified, path_seen))


def law_and_path(certified: str, seen: str) -> Contradiction:
    """What is certified of a law, and what a path under it shows."""
    return Contradiction("feedback law and path", (certified, seen), ("feedback",))


def certified_law(feedback: FeedbackResult) -> LawName | None:
    """The law that the clause certifies, by its name on the command line."""
    if feedback.verdict is not Feedback.STABILIZABLE:
        return None
    return LawName.GRADIENT if feedback.cascade is None else LawName.CASCADE


def uncertified_kinematics(feedback: FeedbackResult, kinematics: Kinematics) -> str:
    """Why the certified law is none under these kinematics; empty where it is.

    With leading-order kinematics c does not turn with the body: a V with ``c^T P J c = 0`` and the fan of translations
    do not see the difference, slow turns rest on it.
    """
    if kinematics is Kinematics.EXACT:
        return ""
    if feedback.cascade is not None:
        slow = feedback.cascade.descent is Descent.SLOW_TURNS
        return "the law of slow turns needs exact kinematics" if slow else ""
    return "V is certified under exact kinematics" if any(feedback.lyapunov.shape) else ""


def build_loop(
    partition: Partition,
    law: LawName,
    kinematics: Kinematics,
    feedback: FeedbackResult | None = None,
    gain: float = GAIN,
) -> FeedbackLoop:
    """The loop under a law by name, or under the one that the feedback clause certifies.

    Args:
        partition: the cells, in any coordinates.
        law: its name, or ``certified``.
        kinematics: exact pose or leading order.
        feedback: the verdict on the centred partition, where it is known already.
        gain: k (1/time).

    Raises:
        ValueError: for another rule than ``nearest``, and where no law is certified.
    """
    if not contact_rule(partition.rule).keeps_rows:
        raise ValueError(f"--feedback: required rule nearest, received {partition.rule}")
    scene = partition.scene
    centred = partition if scene.recentred() == scene else build_partition(scene.recentred())
    feedback = decide_feedback(centred) if feedback is None else feedback
    certified = certified_law(feedback)
    if law is not LawName.CERTIFIED:
        return FeedbackLoop(centred, feedback, law, kinematics, gain)
    required = "--feedback: required an array with a certified law, or one named by --law"
    if certified is None:
        raise ValueError(f"{required}; the feedback clause says {feedback.verdict}: {feedback.reason}")
    lacking = uncertified_kinematics(feedback, kinematics)
    if lacking:
        raise ValueError(f"{required}, received --kinematics {kinematics}: {lacking}")
    return FeedbackLoop(centred, feedback, certified, kinematics, gain)
