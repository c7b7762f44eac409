"""The sampled field of an array under a rule without cells, as a script or a notebook holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.minimizers.sampling import SampledField, sample_field
from nonsmooth.reports.output.document import Block, Paragraph, findings
from nonsmooth.reports.output.facts import floats
from nonsmooth.reports.studies.result import DataTable, Record, Result, short_lines
from nonsmooth.symbolic.numbers.number_text import float_text, percent_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.symbolic.mechanics.scene import Scene

SCHEMA = "nonsmooth-field/1"
COUNT = 41  # points in a row: an odd number, so that the checked point is one of them
COLUMNS = ("x", "y", "x_rate", "y_rate", "theta_rate", "upper_derivative")


@dataclass(frozen=True, repr=False, eq=False)
class FieldResult(Result):
    """Velocities at the points of a grid; all numbers are sampled.

    Attributes:
        field: the points with their velocities.
    """

    field: SampledField

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth partition --json`` under a rule without cells."""
        scene = self.field.scene
        head = {"schema": SCHEMA, "scene": scene.name, "rule": scene.contact.rule, "status": "sampled"}
        return {**head, "grid": self.field.count, "rows": self.rows()}

    def table(self) -> DataTable:
        """One line for each point; None where the motion is not determined."""
        field = self.field
        numbers = np.column_stack([field.points, field.velocities, field.rates, field.upper_derivative])
        return DataTable(COLUMNS, [floats(line) for line in numbers.tolist()])

    def dimensions(self) -> Sequence[str]:
        """The two coordinates of the points."""
        return self.table().columns[:2]

    def draw(self, ax: Axes) -> None:
        """Streamlines over V*."""
        from nonsmooth.reports.figures.cells import draw_field

        draw_field(ax, self.field)

    def figure(self) -> Figure:
        """The same with the scale of V*."""
        from nonsmooth.reports.figures.cells import field_figure

        return field_figure(self.field)

    def blocks(self) -> Sequence[Block]:
        """What the samples say."""
        return [Paragraph((self.headline,)), findings(self.said)]

    def summary(self) -> str:
        """What is drawn, and of how many samples."""
        head = f"rule {self.field.scene.contact.rule} has no cells, so --show cells and rates draw one picture"
        return f"{head}: streamlines over V*, {len(self.field.points)} sampled points"

    @property
    def said(self) -> list[tuple[str, str]]:
        """What the samples say, with names."""
        field = self.field
        rests, unknown = float(field.rests.mean()), float((~field.is_determined).mean())
        return [
            ("fastest", float_text(float(np.nanmax(field.speeds, initial=0.0)))),
            ("largest V*", float_text(float(np.nanmax(field.upper_derivative, initial=-np.inf)))),
            ("the body rests at", percent_text(rests)),
            ("not determined at", percent_text(unknown)),
        ]

    @property
    def headline(self) -> str:
        """What was sampled."""
        scene, count = self.field.scene, self.field.count
        return f"{scene.name}: rule {scene.contact.rule} has no cells; its field at {count} x {count} points, sampled"

    def __repr__(self) -> str:
        return short_lines(self.headline, self.said)


def field_of(scene: Scene) -> FieldResult:
    """Sample the field of an array over its checked square.

    Raises:
        TypeError: for a rule with cells.
        RefusalError: where some motion meets no friction, and where the square leaves the support polygon.
    """
    return FieldResult(sample_field(scene, COUNT))
