"""What a check answers when any one wheel fails: stopped (its rim stands still, its friction stays) or lifted.

A stopped wheel has speed zero and no drive.  Answers about position and heading are those of that array.  About the
pose: what holds with every drive to command may fail with one less, so *can be held* becomes *undecided*, while
*cannot be held* stays.  A lifted wheel carries nothing and touches nothing: the others carry the body, as far as it
stands on them and it is known what they carry (:meth:`nonsmooth.symbolic.mechanics.load_model.LoadModel.on`).
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace
from enum import StrEnum

from nonsmooth.analysis.cells.contact_rule import rule_of
from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.proofs.answers.answer import Heading, Pose, Position
from nonsmooth.proofs.answers.answers import answers_of
from nonsmooth.proofs.answers.contradictions import reconciled
from nonsmooth.proofs.findings import Theorem4
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.symbolic.mechanics.body import default_radius
from nonsmooth.symbolic.mechanics.contact_set import (
    NoLoadsError,
    TipsError,
    require_standing,
    standing,
    whole,
    with_only,
)
from nonsmooth.symbolic.mechanics.scene import Scene, Wheel
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.messages.under_way import part_of
from nonsmooth.symbolic.numbers.number import Number

NO_DRIVE = "a law may need the wheel that is stopped"
NO_TABLE = "the loads are a table for all wheels: what the others carry without it is not known"

# From the best to the worst, for what is worst; tipping is worse than leaving, since the body falls.
POSITIONS = (
    *(Position.COMES_HOME, Position.COMES_NEAR, Position.STAYS_NEAR),
    *(Position.UNDECIDED, Position.LEAVES, Position.TIPS),
)
HEADINGS = (Heading.KEEPS, Heading.UNDECIDED, Heading.DRIFTS)
POSES = (Pose.CAN_BE_HELD, Pose.UNDECIDED, Pose.CANNOT_BE_HELD)


class FailureKind(StrEnum):
    """What becomes of the wheel."""

    STOPPED = "stopped"
    LIFTED = "lifted"


@dataclass(frozen=True)
class Failure:
    """The answers with one wheel failed.

    Attributes:
        wheel: its number.
        kind: what became of it.
        position: where a body goes that starts near the point.
        heading: what its heading does.
        pose: whether feedback can hold both with the drives that are left.
        theorem4: the verdict of Theorem 4; of a stopped wheel undecided where it rests on feedback.
        why: what is to be said beside it: why the body tips, or why an answer is undecided; empty for nothing.
    """

    wheel: int
    kind: FailureKind
    position: Position
    heading: Heading
    pose: Pose
    theorem4: Theorem4
    why: str = ""

    @property
    def badness(self) -> tuple[int, int, int]:
        """The larger the worse: position before heading before pose."""
        return POSITIONS.index(self.position), HEADINGS.index(self.heading), POSES.index(self.pose)

    @property
    def name(self) -> str:
        """``wheel 2 lifted``."""
        return f"wheel {self.wheel} {self.kind}"


def failures_of(scene: Scene) -> tuple[Failure, ...]:
    """The answers with each wheel failed that carries at the checked pose, stopped and lifted; wheel by wheel.

    Raises:
        TipsError: where the body does not stand even on all wheels.
        SceneError: where a wheel lies exactly under its edge.
    """
    every = [(wheel, kind) for wheel in standing(scene).wheels for kind in FailureKind]
    failures = []
    for k, (wheel, kind) in enumerate(every):
        with part_of(k, len(every), f"failures, wheel {wheel.index} {kind}"):
            failures.append(_failure(scene, wheel, kind))
    return tuple(failures)


def worst_failure(failures: tuple[Failure, ...]) -> Failure:
    """The failure with the worst answers, the first of several."""
    return max(failures, key=lambda failure: failure.badness)


def _failure(scene: Scene, wheel: Wheel, kind: FailureKind) -> Failure:
    if kind is FailureKind.STOPPED:
        return _decided(stopped(scene, (wheel.index,)), wheel.index, kind)
    try:
        left = _lifted(scene, wheel)
    except NoLoadsError:
        return _undecided(wheel.index, kind, NO_TABLE)
    except TipsError as tipping:
        return Failure(
            wheel.index,
            kind,
            Position.TIPS,
            Heading.UNDECIDED,
            Pose.UNDECIDED,
            Theorem4.HYPOTHESES_NOT_MET,
            f"the body has {tipping.why}",
        )
    return _decided(left, wheel.index, kind)


def stopped(scene: Scene, failed: Collection[int]) -> Scene:
    """The array in which the rims of wheels, given by their numbers, stand still."""
    every = whole(scene)
    still = [replace(w, given_speed=scene.field.zero) if w.index in failed else w for w in every.wheels]
    return replace(every, wheels=tuple(still))


def without(scene: Scene, failed: Collection[int]) -> Scene:
    """The array without wheels, given by their numbers, in the square of the whole one.

    Raises:
        NoLoadsError: where it is not known what the others carry without them.
    """
    every = whole(scene)
    if not rule_of(scene).needs_loads:
        every = replace(every, contact=replace(every.contact, loads=None))
    return with_only(every, [wheel for wheel in every.wheels if wheel.index not in failed])


def _lifted(scene: Scene, failed: Wheel) -> Scene:
    """The array without a wheel, in a square that its support polygon holds.

    Raises:
        TipsError: where the body does not stand on the others.
        NoLoadsError: where it is not known what these carry without the wheel.
    """
    rest = without(scene, (failed.index,))
    point = scene.check.equilibrium
    carrying = standing(rest)
    require_standing(rest, carrying.wheels, point)
    room = default_radius(carrying.positions, point)
    return rest if (carrying.check.radius - room).sign() <= 0 else in_square(rest, room)


def in_square(scene: Scene, radius: Number) -> Scene:
    """The array, checked in a square of this half-width."""
    return replace(scene, check=replace(scene.check, radius=radius, has_default_radius=False))


def _decided(scene: Scene, number: int, kind: FailureKind) -> Failure:
    """The answers about what is left; where they are refused, undecided and why."""
    try:
        check, _ = reconciled(check_theorem4(scene, beside=False))
    except (RefusalError, SceneError) as error:
        return _undecided(number, kind, str(error))
    verdicts = {answer.name: answer.verdict for answer in answers_of(check)}
    position, heading, pose = (verdicts[name] for name in ("position", "heading", "pose"))
    why = check.reason if position is Position.UNDECIDED else ""
    failure = Failure(number, kind, Position(position), Heading(heading), Pose(pose), check.verdict, why)
    return failure if kind is FailureKind.LIFTED else _without_drive(failure)


def _without_drive(failure: Failure) -> Failure:
    """What is left of answers that may use the drive of the stopped wheel."""
    if failure.pose is not Pose.CAN_BE_HELD and failure.theorem4 is not Theorem4.HOLDS:
        return failure
    pose = Pose.UNDECIDED if failure.pose is Pose.CAN_BE_HELD else failure.pose
    theorem4 = Theorem4.UNDECIDED if failure.theorem4 is Theorem4.HOLDS else failure.theorem4
    return replace(failure, pose=pose, theorem4=theorem4, why=failure.why or NO_DRIVE)


def _undecided(number: int, kind: FailureKind, why: str) -> Failure:
    return Failure(number, kind, Position.UNDECIDED, Heading.UNDECIDED, Pose.UNDECIDED, Theorem4.UNDECIDED, why)
