"""The study ``sweep``: many scenes that differ in a few numbers."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.document import Block
from nonsmooth.reports.output.entries import entry
from nonsmooth.reports.output.files import PICTURES, write_whole
from nonsmooth.reports.output.progress import notice
from nonsmooth.reports.output.refusals import OptionError, RefusedError, option_named
from nonsmooth.reports.output.study_options import Options, option
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.reports.sweeps.base import Base, base_of, with_wheels
from nonsmooth.reports.sweeps.sweep import Means, Sweep, run_sweep
from nonsmooth.reports.sweeps.sweep_plan import SweepError, SweepPlan, read_plan
from nonsmooth.reports.sweeps.table import counted, flat_rows, sweep_blocks, sweep_record
from nonsmooth.reports.sweeps.workers import processors
from nonsmooth.symbolic.files.scene_document import OF_INERTIA

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.reports.sweeps.borders import Border


@dataclass(frozen=True, kw_only=True)
class VaryOptions(Options):
    """What varies."""

    vary: list[str] | None = option(
        None,
        "A number of the scene, such as mu_side or wheel.1.heading, and its values: start:stop:count or a,b,c; "
        "several give every combination.",
        metavar="KEY=VALUES",
    )
    random: int | None = option(None, "N random scenes within ranges start:stop, instead of a grid.", metavar="N")
    seed: int = option(0, "Seed of --random: equal seeds give equal scenes.", metavar="S")

    @property
    def values(self) -> dict[str, str]:
        """The key paths, each with its values.

        Raises:
            RefusedError: for what is no pair of both, and for a path that is given twice.
        """
        found: dict[str, str] = {}
        for text in self.vary or ():
            name, sign, values = text.partition("=")
            if not sign or not name.strip() or not values.strip():
                raise RefusedError(f"--vary: required KEY=VALUES such as mu_side=0.05:1:40, received {text[:60]!r}")
            if name.strip() in found:
                raise RefusedError(f"--vary: required each number once, received {name.strip()[:60]!r} twice")
            found[name.strip()] = values.strip()
        return found


@dataclass(frozen=True, kw_only=True)
class SweepOptions(Means, VaryOptions):
    """What varies, and how it is run."""


@dataclass(frozen=True, repr=False)
class SweepResult(Result):
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

    def facts(self) -> Record:
        """The JSON record of ``nonsmooth sweep --json``."""
        return sweep_record(self.sweep)

    def dimensions(self) -> Sequence[str]:
        """The numbers that vary: each has a column with its exact text beside it."""
        columns = self.table().columns
        return [name for name in columns if f"{name} exact" in columns]

    def table(self) -> DataTable:
        """One line for each scene."""
        return DataTable.of_rows(list(flat_rows(self.sweep)))

    def blocks(self) -> Sequence[Block]:
        """The answers, and where they change."""
        return sweep_blocks(self.sweep)

    def summary(self) -> str:
        """How many scenes have which answers."""
        return counted(self.sweep)

    def figure(self) -> Figure:
        """Strips of answers with curves of rates over one number, or maps of answers over two.

        Raises:
            SweepError: for random draws, and more than two numbers.
        """
        from nonsmooth.reports.sweeps.figure import build_figure, require_picture

        require_picture(self.sweep.plan)
        return build_figure(self.sweep)

    def plot(self, ax: Axes | None = None) -> Any:
        """The figure, which lays out axes of its own."""
        return self.figure()

    def to_csv(self, file: str | Path) -> Path:
        """Write the rows, whatever the name of the file.

        Raises:
            OutputError: for a file that cannot be written.
        """
        path = Path(file)
        write_whole(path, self.content(".csv"))
        return path

    def __repr__(self) -> str:
        plan = self.sweep.plan
        varied = [(name, f"{count} values") for name, count in zip(plan.names, plan.counts, strict=True)]
        return short_lines(self.summary(), varied if plan.draws is None else [])


class SweepStudy(SceneStudy[SweepOptions]):
    """Many scenes that differ in a few numbers."""

    options = SweepOptions
    files = "Table: .csv, .parquet (needs pyarrow) or .json; picture over one or two numbers: .svg, .png or .pdf."

    changes = tuple(name for name in SceneStudy.changes if name != "exact")

    def load(self, scene: Any, options: SweepOptions, *, allow_outside: bool = False, **changes: Any) -> Base:
        """The scene before anything varies."""
        from nonsmooth.symbolic.files.documents import deep_nesting_refused, read_document

        with deep_nesting_refused(scene):
            return base_of(*read_document(scene, **changes), allow_outside=allow_outside)

    def settled(self, options: SweepOptions, path: Path | None) -> SweepOptions:
        """Without a number of workers one checks on each processor; a picture shows borders, one of cells has none."""
        is_picture = path is not None and path.suffix.lower() in PICTURES
        borders = options.borders or (is_picture and not options.certify)
        workers = processors() if options.workers is None else options.workers
        return replace(options, workers=workers, borders=borders)

    def refuse(self, asked: StudyRequest[SweepOptions], path: Path | None) -> None:
        """Refuse a picture of what has none, and one file for the rows and the store, before the work."""
        store = asked.options.store
        if path is not None and store is not None and Path(store).resolve() == path.resolve():
            raise OptionError(f"--store: required another file than that of -o, received {str(store)!r}")
        if path is not None and path.suffix.lower() in PICTURES:
            from nonsmooth.reports.sweeps.figure import require_picture

            with option_named(SweepError):
                require_picture(_plan(asked.scene, asked.options.values, asked.options.random, asked.options.seed)[1])

    def run(self, scene: Base, options: SweepOptions) -> SweepResult:
        """Check all."""
        with option_named(SweepError):
            return swept(scene, options.values, options, draws=options.random, seed=options.seed)


SWEEP = SweepStudy()
INERTIA = tuple(f"body.{name}" for name in OF_INERTIA)  # keys of which no answer in a row depends


def _plan(base: Base, vary: Mapping[str, str], draws: int | None, seed: int) -> tuple[Base, SweepPlan]:
    whole = with_wheels(base, vary)
    return whole, read_plan(vary, whole.document, whole.file, draws=draws, seed=seed)


def swept(base: Base, vary: Mapping[str, Any], means: Means, *, draws: int | None, seed: int) -> SweepResult:
    """Check all scenes; values are given as on the command line, or one by one.

    Raises:
        SceneError: for a key path that names no number.
        SweepError: for values and means that cannot be used.
    """
    from nonsmooth.reports.output.console import broken_pipes_raised
    from nonsmooth.reports.output.progress import progress

    whole, plan = _plan(base, {name: _text(values) for name, values in vary.items()}, draws, seed)
    of_inertia = [name for name in plan.names if name in INERTIA]
    if of_inertia:
        said = "rows tell of bodies without inertia; check says of one scene what it does"
        notice(whole.file, f"{' and '.join(of_inertia)}: {said}")
    with progress("sweep") as report, broken_pipes_raised():
        return SweepResult(run_sweep(whole, plan, means, report))


def _text(values: Any) -> str:
    """Values as the command line takes them."""
    if isinstance(values, str):
        return values
    return ",".join(str(entry(value)) for value in (values if isinstance(values, Iterable) else [values]))
