"""Full dynamics of a body with an outline against the paths of the contact rules, by mass.

Both sides follow the wheels that enter and leave: the body with mass by :class:`MassPath`, the contact rules by the
path of the outline (:mod:`nonsmooth.analysis.bodies.path`, :mod:`nonsmooth.analysis.bodies.cell_path`).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from nonsmooth.analysis.bodies.cell_path import CellPath
from nonsmooth.analysis.bodies.mass_path import MassPath
from nonsmooth.analysis.contact_rule import CellRule, SmoothRule, contact_rule
from nonsmooth.analysis.dynamics.mass_study import MassStudy, mass_study
from nonsmooth.analysis.dynamics.newton_euler import DynamicPath, RigidBody
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.analysis.trajectories.result import Trajectory
from nonsmooth.symbolic.contact_set import whole
from nonsmooth.symbolic.scene import Scene


def outline_mass_study(scene: Scene, bodies: Sequence[RigidBody], start: Sequence[float], until: float) -> MassStudy:
    """As :func:`nonsmooth.analysis.dynamics.mass_study.mass_study`, for a scene with an outline.

    Raises:
        ValueError: for a start at which the body tips.
        SceneError: for a table of loads beside an outline.
        nonsmooth.analysis.trajectories.result.TrajectoryError: where a path cannot be followed.
    """
    return mass_study(scene, bodies, start, until, outline_rule_path, outline_body_path)


def outline_rule_path(scene: Scene, rule: str, start: Sequence[float], until: float) -> Trajectory:
    """The quasi-static path of a contact rule.

    Raises:
        RefusalError: where the motion is not determined.
        TrajectoryError: where the path cannot be followed.
    """
    chosen = replace(scene, contact=replace(scene.contact, rule=rule))
    own = contact_rule(rule)
    if isinstance(own, SmoothRule):
        return own.path(chosen, start, until)
    if not isinstance(own, CellRule):
        raise TypeError(f"required a rule with or without cells, received {own.name}")
    return CellPath(whole(chosen), own).follow(start, until)


def outline_body_path(scene: Scene, body: RigidBody, start: Sequence[float], until: float) -> DynamicPath:
    """The path of a body with mass, from rest."""
    array = whole(scene)
    return MassPath(array, contact_model(array), body).follow(start, until)
