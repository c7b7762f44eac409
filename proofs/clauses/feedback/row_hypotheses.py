"""What laws by rows need: one lever in each cell, rows of a pair of wheels, and less friction across the rims."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.proofs.clauses.feedback.input_cell import InputCell, build_input_cell, is_local
from nonsmooth.proofs.clauses.feedback.obstruction import common_normal
from nonsmooth.symbolic.constraints import Triple, inner
from nonsmooth.symbolic.scene import Wheel


def obstructs(normal: Triple | None, local: Sequence[InputCell]) -> bool:
    """Whether a nonzero normal, if there is one, is orthogonal to every control vector field at the equilibrium."""
    fields = [field for data in local for field in data.state.control_fields.values()]
    return normal is None or (any(normal) and not any(inner(normal, field) for field in fields))


def obstruction_of(local: Sequence[InputCell]) -> Triple | None:
    """The normal of a plane that holds every control vector field at the equilibrium, if there is one."""
    fields = [field for data in local for field in data.state.control_fields.values()]
    return common_normal(fields, local[0].state.twist.omega.field)


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


def single_input(partition: Partition) -> InputCell | None:
    """A closed cell at the equilibrium whose side row in third place leaves one input alone."""
    local = (build_input_cell(cell, state) for cell in partition.cells if is_local(cell) for state in cell.states)
    return next((data for data in local if data.lever is None), None)


def side_friction_rules(wheels: Iterable[Wheel]) -> str | None:
    """Why the clause does not apply, or None: it speaks of arrays with mu_S < mu_R."""
    for wheel in wheels:
        if wheel.friction.side >= wheel.friction.roll:
            return (
                f"mu_side < mu_roll is required, received mu_side = {wheel.friction.side}, "
                f"mu_roll = {wheel.friction.roll} at wheel {wheel.index}"
            )
    return None


def acting_wheels(partition: Partition) -> list[Wheel]:
    """The wheels whose rows are held at the equilibrium."""
    near = [state for cell in partition.cells if is_local(cell) for state in cell.states]
    held = {row.wheel.index for state in near for row in state.rows}
    return [wheel for wheel in partition.scene.wheels if wheel.index in held]
