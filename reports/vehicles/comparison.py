"""Many vehicles side by side: predicted and measured multipliers of an in-place turn."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.reports.exact_record import Record, exact_texts
from nonsmooth.reports.terminal import header_table
from nonsmooth.reports.vehicles.motion import VehicleReport
from nonsmooth.symbolic.number_text import float_text, percent_text
from nonsmooth.symbolic.scene_error import one_line

SCHEMA = "nonsmooth-vehicles/1"
REMARK = (
    "Nothing is fitted: friction is what each scene states, alike in all directions unless it says otherwise. "
    "What would explain the misses: mu_S/mu_R other than 1, tyres wide enough to resist turning on the spot, "
    "a centre of mass beside the middle, and constants that were rounded or tuned on one floor."
)


@dataclass(frozen=True)
class VehicleComparison:
    """The reports of several vehicles."""

    reports: tuple[VehicleReport, ...]

    def record(self) -> Record:
        """JSON with stable keys."""
        return {"schema": SCHEMA, "vehicles": [_row(report) for report in self.reports]}

    def lines(self) -> Iterator[tuple[object, ...]]:
        """One line for each vehicle."""
        names = ("vehicle", "rule", "track", "wheel_base", "multiplier", "measured", "error", "friction_ratio")
        yield names
        for report in self.reports:
            row = _row(report)
            yield tuple(row[name] for name in names)

    def picture(self, suffix: str) -> bytes:
        """Predicted over measured multipliers."""
        from nonsmooth.reports.figures.vehicle import comparison_figure

        return comparison_figure(self.reports, suffix)

    def summary(self) -> str:
        """One line."""
        errors = [report.error for report in self.reports if report.error is not None]
        if not errors:
            return f"{len(self.reports)} vehicles"
        return f"{len(self.reports)} vehicles, errors {percent_text(min(errors))} to {percent_text(max(errors))}"

    def view(self) -> RenderableType:
        """A table."""
        table = header_table("vehicle", "rule", "predicted", "measured", "error", "mu_S/mu_R met by")
        for report in self.reports:
            row = _row(report)
            cells = (row["multiplier"], row["measured"], row["error"], row["friction_ratio"])
            predicted, measured, error, ratio = (None if cell is None else float(cell) for cell in cells)
            table.add_row(
                one_line(report.vehicle.name),
                report.own.rule.name,
                _text(predicted),
                _text(measured),
                "-" if error is None else f"{100 * error:+.1f} %",
                _text(ratio),
            )
        return Group(Text("effective track multiplier of an in-place turn"), table, Text(REMARK, "dim"))


def _text(value: float | None) -> str:
    return "-" if value is None else float_text(value, 4)


def _row(report: VehicleReport) -> Record:
    measured = report.measured_record()
    vehicle, own = report.vehicle, report.own
    return {
        "vehicle": vehicle.name,
        "rule": own.rule.name,
        "track": None if vehicle.track is None else float(vehicle.track),
        "wheel_base": None if vehicle.wheel_base is None else float(vehicle.wheel_base),
        "multiplier": own.multiplier,
        "measured": None if measured is None else measured["multiplier"],
        "error": report.error,
        "friction_ratio": None if measured is None else measured["friction_ratio"],
        "source": None if measured is None else measured["source"],
        "exact": {"multiplier": exact_texts(own.exact_multiplier)},
    }
