"""The sampled field of an array under a rule without cells, as a script or a notebook holds it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from nonsmooth.analysis.minimizers.sampled_field import SampledField, sample_field
from nonsmooth.reports.exact_record import floats
from nonsmooth.reports.files import PICTURES, output_path, write_whole
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.number_text import float_text, percent_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.symbolic.scene import Scene

SCHEMA = "nonsmooth-field/1"
COUNT = 41  # points in a row: an odd number, so that the checked point is one of them
COLUMNS = ("x", "y", "x_rate", "y_rate", "theta_rate", "upper_derivative")


@dataclass(frozen=True, repr=False, eq=False)
class FieldResult(Tabular):
    """Velocities at the points of a grid; all numbers are sampled.

    Attributes:
        field: the points with their velocities.
    """

    field: SampledField

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth partition --json`` under a rule without cells."""
        scene = self.field.scene
        head = {"schema": SCHEMA, "scene": scene.name, "rule": scene.contact.rule, "status": "sampled"}
        return {**head, "grid": self.field.count, "rows": self.rows()}

    def rows(self) -> list[dict[str, float | None]]:
        """One row for each point; None where the motion is not determined."""
        field = self.field
        table = np.column_stack([field.points, field.velocities, field.rates, field.upper_derivative])
        return [dict(zip(COLUMNS, floats(line), strict=True)) for line in table.tolist()]

    def save(self, file: str | Path) -> Path:
        """Draw streamlines over V* into a file: .svg, .png or .pdf.

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
        """
        from nonsmooth.reports.figures.field_map import field_map

        path = output_path(str(file), PICTURES)
        write_whole(path, field_map(self.field, path.suffix.lower()))
        return path

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw streamlines over V*."""
        from nonsmooth.reports.figures.field_map import draw_field
        from nonsmooth.reports.result import own_axes

        axes = own_axes(ax)
        draw_field(axes, self.field)
        return axes

    @property
    def summary(self) -> list[tuple[str, str]]:
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
        return short_lines(self.headline, self.summary)


def field_of(scene: Scene) -> FieldResult:
    """Sample the field of an array over its checked square.

    Raises:
        TypeError: for a rule with cells.
        RefusalError: where some motion meets no friction, and where the square leaves the support polygon.
    """
    return FieldResult(sample_field(scene, COUNT))
