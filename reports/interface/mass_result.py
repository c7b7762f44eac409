"""A body with mass over an array, and how far it goes from the paths of the contact rules."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from nonsmooth.analysis.bodies.mass_study import body_path, mass_ladder, mass_study
from nonsmooth.analysis.dynamics.newton_euler import RigidBody
from nonsmooth.analysis.fields.contact_model import contact_model
from nonsmooth.reports.dynamics import ShownMasses, ShownPath, chosen_body
from nonsmooth.reports.interface.argument_error import ArgumentError
from nonsmooth.reports.interface.short_text import short_lines
from nonsmooth.reports.interface.shown_result import ShownResult
from nonsmooth.reports.simulate import PathRun
from nonsmooth.symbolic.contact_set import whole
from nonsmooth.symbolic.number_text import float_text
from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True, repr=False)
class MassResult(ShownResult):
    """Distances of bodies under full dynamics from the path of every contact rule, by mass.

    Attributes:
        shown: the study in every form that the command ``simulate --compare-masses`` offers.
    """

    shown: ShownMasses

    def __repr__(self) -> str:
        head = f"full dynamics over {self.shown.scene.name}, by mass: {self.shown.summary()}"
        return short_lines(head, [_line(row) for row in self.rows()])

    def _repr_html_(self) -> str:
        return self.shown.study._repr_html_()


def follow_body(scene: Scene, run: PathRun) -> ShownPath:
    """The path of a body with mass under full dynamics, from rest.

    Raises:
        ArgumentError: for a mass or an inertia that cannot be used.
        ValueError: for a start at which a body with an outline tips.
        SceneError: for a table of loads beside an outline.
        TrajectoryError: where the path cannot be followed.
    """
    array = whole(scene)
    return ShownPath(array, body_path(array, _body(array, run), run.start, run.until))


def compare_masses(scene: Scene, run: PathRun) -> MassResult:
    """The distance of bodies of one shape, each a tenth as heavy as the one before, from every rule's path.

    Raises:
        ArgumentError: for a mass or an inertia that cannot be used.
        SceneError: for a table of loads beside an outline.
        RefusalError: where the motion is not determined.
        TrajectoryError: where a path cannot be followed.
    """
    array = whole(scene)
    try:
        bodies = mass_ladder(_body(array, run))
    except ValueError as error:  # the lightest of them
        raise ArgumentError(str(error)) from None
    return MassResult(ShownMasses(array, mass_study(array, bodies, run.start, run.until)))


def _body(scene: Scene, run: PathRun) -> RigidBody:
    try:
        return chosen_body(scene, contact_model(scene), run.mass, run.inertia)
    except ValueError as error:
        raise ArgumentError(str(error)) from None


def _line(row: dict[str, Any]) -> tuple[str, str]:
    position, rotation = (float_text(row[name], 3) for name in ("position", "rotation"))
    return f"{row['mass']:g}, {row['rule']}:", f"{position} apart, {rotation} rad"
