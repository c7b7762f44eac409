"""Many scenes that differ in a few numbers, as a script or a notebook holds them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.reports.files import write_whole
from nonsmooth.reports.interface.entries import entry
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.reports.sweep_files import sweep_bytes, sweep_path
from nonsmooth.reports.sweeps.base import base_of, with_wheels
from nonsmooth.reports.sweeps.borders import Border
from nonsmooth.reports.sweeps.sweep import Means, Sweep, run_sweep
from nonsmooth.reports.sweeps.sweep_plan import read_plan
from nonsmooth.reports.sweeps.table import counted, flat_rows, sweep_record
from nonsmooth.symbolic.notebook import html_table

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from nonsmooth.reports.interface.made_array import MadeArray
    from nonsmooth.reports.interface.system import System

MOST_SHOWN = 40  # scenes that a notebook lists


@dataclass(frozen=True, repr=False)
class SweepResult(Tabular):
    """What a sweep found.

    Attributes:
        sweep: the plan, the outcome of every scene, and the borders.
    """

    sweep: Sweep

    @property
    def borders(self) -> tuple[Border, ...] | None:
        """Where answers change along the grid, within 1e-9; None where they were not looked for."""
        return self.sweep.borders

    @property
    def checked(self) -> int:
        """How many scenes were computed; the others were in the store, or equal to another one."""
        return self.sweep.checked

    def to_dict(self) -> dict[str, Any]:
        """The JSON record of ``nonsmooth sweep --json``."""
        return sweep_record(self.sweep)

    def rows(self) -> list[dict[str, Any]]:
        """One row for each scene, as in the CSV file of the command."""
        return list(flat_rows(self.sweep))

    def save(self, file: str | Path) -> Path:
        """Write it: .csv, .json, .parquet (with pyarrow) or a picture (.svg, .png, .pdf).

        Raises:
            OutputError: for another ending, and for a file that cannot be written.
            SweepError: for a picture of random draws, or of more than two numbers.
        """
        path = sweep_path(str(file))
        write_whole(path, sweep_bytes(self.sweep, path.suffix.lower()))
        return path

    def to_csv(self, file: str | Path) -> Path:
        """Write the rows, whatever the name of the file.

        Raises:
            OutputError: for a file that cannot be written.
        """
        path = Path(file)
        write_whole(path, sweep_bytes(self.sweep, ".csv"))
        return path

    def plot(self) -> Figure:
        """Strips of answers with curves of rates over one number, or maps of answers over two.

        Raises:
            SweepError: for random draws, and more than two numbers.
        """
        from nonsmooth.reports.figures.sweep import build_figure, require_picture

        require_picture(self.sweep.plan)
        return build_figure(self.sweep)

    def __repr__(self) -> str:
        varied = [(name, f"{count} values") for name, count in zip(self._names, self.sweep.plan.counts, strict=True)]
        return short_lines(counted(self.sweep), varied if self.sweep.plan.draws is None else [])

    def _repr_html_(self) -> str:
        shown = self.rows()[:MOST_SHOWN]
        header = [*(f"{name} exact" for name in self._names), *self.sweep.questions]
        lines = [[row[name] for name in header] for row in shown]
        return html_table(counted(self.sweep), [*self._names, *self.sweep.questions], lines)

    @property
    def _names(self) -> tuple[str, ...]:
        return self.sweep.plan.names


def sweep_array(
    array: MadeArray | System, vary: Mapping[str, Any], means: Means, *, draws: int | None = None, seed: int = 0
) -> SweepResult:
    """Check an array or a system many times; see :meth:`nonsmooth.reports.interface.array.Array.sweep`.

    Raises:
        SceneError: for a key path that names no number.
        SweepError: for values and means that cannot be used.
    """
    base = with_wheels(base_of(array.document, *array.origin), vary)
    plan = read_plan({name: _text(values) for name, values in vary.items()}, base.document, base.file, draws, seed)
    return SweepResult(run_sweep(base, plan, means))


def _text(values: Any) -> str:
    """Values as the command line takes them."""
    if isinstance(values, str):
        return values
    listed = values if isinstance(values, Sequence) else list(values)
    return ",".join(str(entry(value)) for value in listed)
