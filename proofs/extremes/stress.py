"""All stiff and extreme cases of one scene, one after the other.

A case that raises is a row too, and not ok: nothing that goes wrong is left out, and later cases still run.
"""

from __future__ import annotations

from collections.abc import Iterator

from nonsmooth.analysis.extremes.feedback_gain import feedback_rows
from nonsmooth.analysis.extremes.friction_ratio import friction_rows
from nonsmooth.analysis.extremes.hysteresis_width import hysteresis_rows
from nonsmooth.analysis.extremes.near_collinear import collinear_rows
from nonsmooth.analysis.extremes.row import Case, Rows, StressRow, refused
from nonsmooth.analysis.extremes.scales import array_scale_rows, system_scale_rows
from nonsmooth.analysis.extremes.starts import start_rows
from nonsmooth.analysis.extremes.subject import Subject, array_subject, system_subject
from nonsmooth.analysis.extremes.support_edge import scale_rows, support_rows
from nonsmooth.analysis.extremes.switches import long_rows, spiral_rows
from nonsmooth.analysis.fields.constant_field import ConstantField
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.system_field import constant_system
from nonsmooth.analysis.partitions.contact_partition import build_partition
from nonsmooth.analysis.partitions.partition import Partition, RefusalError
from nonsmooth.proofs.extremes.array_verdicts import array_verdict_rows
from nonsmooth.proofs.extremes.system_verdicts import system_verdict_rows
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.switched_system import SwitchedSystem, require_plane


def stress_cases(scene: Scene | SwitchedSystem) -> dict[str, Case]:
    """The families of cases by name, in the order in which they run.

    Raises:
        SceneError: for a system in another number of states than two.
    """
    if isinstance(scene, Scene):
        return _array_cases(scene)
    require_plane(scene)
    return _system_cases(scene)


def stress_rows(scene: Scene | SwitchedSystem) -> Iterator[StressRow]:
    """Every row of every family."""
    for name, case in stress_cases(scene).items():
        yield from guarded(name, case)


def guarded(name: str, case: Case) -> Rows:
    """The rows of a family; whatever it raises becomes a last row that is not ok."""
    try:
        yield from case()
    except Exception as fault:
        reason = f"{type(fault).__name__}: {' '.join(str(fault).split())}"
        yield StressRow(name, "", "fault", None, None, False, reason)


def _array_cases(scene: Scene) -> dict[str, Case]:
    def verdicts() -> Rows:
        return array_verdict_rows(scene)

    def minimizers() -> Rows:
        return friction_rows(scene)

    def loads() -> Rows:
        yield from support_rows(scene)
        yield from scale_rows(scene)

    def contact_states() -> Rows:
        return collinear_rows(scene)

    def paths() -> Rows:
        partition = _partition(scene)
        if isinstance(partition, Partition):
            yield from array_scale_rows(scene)
            leading = array_subject(partition, Kinematics.LEADING)
            exact = array_subject(partition, Kinematics.EXACT)
            yield from start_rows(leading, "start, leading order")
            yield from start_rows(exact, "start, exact pose")
            yield from hysteresis_rows(exact)
            yield from switch_rows(leading)
        else:
            yield refused("paths", f"rule {scene.contact.rule}", partition, expected=True)

    def feedback() -> Rows:
        partition = _partition(scene)
        if isinstance(partition, Partition):
            yield from feedback_rows(partition)
        else:
            yield refused("feedback gain", f"rule {scene.contact.rule}", partition, expected=True)

    return {
        "verdicts": verdicts,
        "minimizers": minimizers,
        "loads": loads,
        "contact states": contact_states,
        "paths": paths,
        "feedback": feedback,
    }


def _partition(scene: Scene) -> Partition | RefusalError:
    """The cells, or why there are none."""
    try:
        return build_partition(scene)
    except RefusalError as refusal:
        return refusal


def switch_rows(subject: Subject) -> Rows:
    """Many switches on the cells of a field of constant twists."""
    if isinstance(subject.field, ConstantField):
        yield from spiral_rows(subject.field)
    yield from long_rows(subject)


def _system_cases(scene: SwitchedSystem) -> dict[str, Case]:
    def verdicts() -> Rows:
        return system_verdict_rows(scene)

    def scales() -> Rows:
        return system_scale_rows(scene)

    def starts() -> Rows:
        return start_rows(system_subject(scene), "start")

    def hysteresis() -> Rows:
        return hysteresis_rows(system_subject(scene))

    def switches() -> Rows:
        constant = constant_system(scene)
        if constant is not None:
            yield from spiral_rows(constant)
        yield from long_rows(system_subject(scene))

    return {"verdicts": verdicts, "scales": scales, "starts": starts, "hysteresis": hysteresis, "switches": switches}
