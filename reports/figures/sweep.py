"""A sweep as a picture: strips of answers with curves of rates over one number, or maps of answers over two."""

from __future__ import annotations

from typing import TYPE_CHECKING

from nonsmooth.reports.figures.sweep_cells import build_cells
from nonsmooth.reports.figures.sweep_map import build_map
from nonsmooth.reports.figures.sweep_strips import build_strips
from nonsmooth.reports.sweeps.borders import has_place
from nonsmooth.reports.sweeps.sweep_error import SweepError
from nonsmooth.reports.sweeps.sweep_plan import SweepPlan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nonsmooth.reports.sweeps.sweep import Sweep


def require_picture(plan: SweepPlan) -> None:
    """Refuse what has no picture.

    Raises:
        SweepError: for random draws, more than two numbers, and values that do not ascend.
    """
    if plan.draws is not None:
        raise SweepError("output: required .csv, .json or .parquet for random draws, received a picture")
    if len(plan.axes) > 2:
        raise SweepError(f"output: required one or two numbers that vary for a picture, received {len(plan.axes)}")
    for axis in plan.axes:
        if not has_place(axis.values) or (axis.values.count or 0) < 2:
            required = "two or more rational values that ascend for a picture"
            raise SweepError(f"vary {axis.name}: required {required}, received others")


def build_figure(sweep: Sweep) -> Figure:
    """The picture as a Matplotlib figure."""
    if sweep.cells is not None:
        return build_cells(sweep, sweep.cells)
    return build_strips(sweep) if len(sweep.plan.axes) == 1 else build_map(sweep)
