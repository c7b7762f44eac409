"""An array of driven wheels: made in a line, asked in a line."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from nonsmooth.reports.interface.entries import table
from nonsmooth.reports.interface.places import placed
from nonsmooth.reports.interface.wheel import Wheel

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.reports.interface.cells_result import CellsResult
    from nonsmooth.reports.interface.check_result import CheckResult
    from nonsmooth.reports.interface.comparison_result import ComparisonResult
    from nonsmooth.reports.interface.filippov_set import FilippovSet
    from nonsmooth.reports.interface.map_result import MapResult
    from nonsmooth.reports.interface.path_result import PathResult
    from nonsmooth.reports.interface.report_result import ReportResult
    from nonsmooth.symbolic.scene import Scene

AUTO = "auto"  # the best rest point of the square


@dataclass(frozen=True, init=False, repr=False)
class Array:
    """A planar array of driven wheels under a rigid body, with what is to be checked.

    Immutable: :meth:`with_` returns another array.  Numbers may be int, float (its shortest decimal: 0.1 is one tenth),
    Fraction, Decimal, SymPy numbers, or formulas as text.

    Args:
        wheels: the wheels.
        mu_roll: friction along the rims, or along the friction axes of wheels that name one.
        mu_side: friction across them.
        rule: contact rule; see ``nonsmooth rules``.
        at: the point to check.
        radius: half-width of the square about it that is checked.
        **more: other tables and keys of a scene file, see :meth:`with_`.

    Raises:
        SceneError: for whatever cannot be used, naming key, requirement and what was received.
    """

    document: Mapping[str, Any]
    folder: Path = field(compare=False)

    def __init__(
        self,
        wheels: Iterable[Wheel],
        *,
        mu_roll: Any = None,
        mu_side: Any = None,
        rule: str | None = None,
        at: Sequence[Any] | None = None,
        radius: Any = None,
        **more: Any,
    ) -> None:
        given = dict(mu_roll=mu_roll, mu_side=mu_side, rule=rule, at=at, radius=radius, **more)
        document = placed({"wheel": [wheel.table() for wheel in wheels]}, given)
        self._set(document, Path())

    def _set(self, document: Mapping[str, Any], folder: Path) -> None:
        object.__setattr__(self, "document", document)
        object.__setattr__(self, "folder", folder)
        _ = self.scene  # refuse what cannot be used at once

    # ---- making ----------------------------------------------------------------------------------

    @classmethod
    def of_document(cls, document: Mapping[str, Any], folder: Path | None = None) -> Self:
        """The array of a scene file's tables; a table of wheels lies in the folder.

        Raises:
            SceneError: for whatever cannot be used.
        """
        array = cls.__new__(cls)
        array._set(document, folder or Path())
        return array

    @classmethod
    def ring(cls, count: int, *, radius: Any = 1, phase: Any = 0, check_radius: Any = None, **more: Any) -> Self:
        """``count`` wheels evenly on a circle, rims to its centre unless a field says otherwise.

        Args:
            count: number of wheels.
            radius: of the circle.
            phase: angle of the first wheel, such as ``"pi/4"``.
            check_radius: half-width of the checked square.
            **more: as for :meth:`with_`, but for ``radius``.
        """
        layout = table({"count": count, "radius": radius, "phase": phase})
        return cls.of_document(placed({"ring": layout}, {**more, "radius": check_radius}))

    @classmethod
    def grid(cls, rows: int, columns: int, *, pitch: Any = 1, **more: Any) -> Self:
        """``rows x columns`` wheels, centred on the origin, rims to it unless a field says otherwise."""
        layout = table({"rows": rows, "columns": columns, "pitch": pitch})
        return cls.of_document(placed({"grid": layout}, more))

    @classmethod
    def from_csv(cls, file: str | Path, **more: Any) -> Self:
        """Wheels of a CSV table with columns x, y and optionally the other keywords of a :class:`Wheel`."""
        path = Path(file)
        return cls.of_document(placed({"wheels": {"file": path.name}}, more), path.parent)

    def with_(self, **changes: Any) -> Self:
        """Another array in which some keys are changed.

        Args:
            **changes: name, mu_roll, mu_side, axis, speed_limit, rule, loads, at, radius, lyapunov, length; field, body
                and units as tables.

        Raises:
            SceneError: for whatever cannot be used.
            TypeError: for a keyword that is none of these.
        """
        return self.of_document(placed(self.document, changes), self.folder)

    # ---- what it is ------------------------------------------------------------------------------

    @cached_property
    def scene(self) -> Scene:
        """The exact array: all numbers in one field."""
        from nonsmooth.symbolic.files.scene_file import build_scene, deep_nesting_refused

        name = self.document.get("name")
        label = name if isinstance(name, str) and name.strip() else "array"
        with deep_nesting_refused(label):
            return build_scene(dict(self.document), label, self.folder / f"{label}.toml")

    @cached_property
    def partition(self) -> Partition:
        """The exact cells of the checked square.

        Raises:
            RefusalError: where the motion is not determined, and under a rule without cells.
        """
        from nonsmooth.analysis.cells.contact_partition import build_partition

        return build_partition(self._standing)

    @property
    def _standing(self) -> Scene:
        """The array of the wheels that carry the body at the checked pose."""
        from nonsmooth.symbolic.contact_set import standing

        return standing(self.scene)

    def __repr__(self) -> str:
        from nonsmooth.symbolic.number_text import short_text

        scene = self.scene
        x, y = (short_text(entry) for entry in scene.check.equilibrium)
        square = f"checked at ({x}, {y}) within {short_text(scene.check.radius)}"
        return f"Array {scene.name!r}: {len(scene.wheels)} wheels, rule {scene.contact.rule}, {square}"

    def _repr_html_(self) -> str:
        from nonsmooth.reports.figures.array import array_figure

        return array_figure(self.scene, ".svg").decode()

    # ---- asking ----------------------------------------------------------------------------------

    def check(self, *, at: Sequence[Any] | str | None = None, prune: bool = True, **changes: Any) -> CheckResult:
        """Position, heading and pose, with the clauses of Theorem 4 behind them.

        Args:
            at: another point to check; ``"auto"`` for the best rest point of the square.
            prune: leave out what no verdict needs.
            **changes: as for :meth:`with_`, such as ``rule="ellipse"``.

        Raises:
            SceneError: for whatever cannot be used; a ``TipsError`` for a body that does not stand at the point.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.interface.check_result import check_scene

        array = self.with_(**changes) if changes else self
        if at is not None and at != AUTO:
            array = array.with_(at=at)
        return check_scene(array.scene, prune=prune, best=at == AUTO)

    def simulate(
        self,
        start: Sequence[float],
        until: float = 2.0,
        *,
        feedback: bool | str = False,
        method: str = "events",
        gain: float = 1.0,
        kinematics: str = "exact",
        width: float = 1e-3,
        **changes: Any,
    ) -> PathResult:
        """The path of a body from ``(x, y, theta)``, in the coordinates of the array.

        Args:
            start: position and heading (radian).
            until: last time.
            feedback: close the loop with the certified law, or with the one of this name; under rules with cells.
            method: ``events``, ``hysteresis`` or ``smoothed``.
            gain: of the law (1/time).
            kinematics: ``exact`` pose, or ``leading`` order as in the paper; under rules with cells.
            width: of hysteresis and smoothing, in units of the state.
            **changes: as for :meth:`with_`.

        Raises:
            ValueError: for a start outside the checked square, or a law that does not apply.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.interface.path_result import follow_array
        from nonsmooth.reports.interface.path_runs import path_run

        array = self.with_(**changes) if changes else self
        run = path_run(start, until, feedback=feedback, method=method, gain=gain, kinematics=kinematics, width=width)
        return follow_array(array.scene, run)

    def map(
        self, grid: int, *, heading: float = 0.0, until: float | None = None, kinematics: str = "exact"
    ) -> MapResult:
        """Where ``grid x grid`` starts all over the square end, in the open loop by events.

        A body with an outline is followed under a rule without cells, by explicit steps: where it ends is sampled.

        Args:
            grid: starts in a row and in a column.
            heading: of all starts (radian).
            until: time at which the map is taken; all are followed to their ends unless given.
            kinematics: ``exact`` or ``leading``.

        Raises:
            ValueError: for a grid, a heading or a last time that cannot be used.
            RefusalError: where the motion is not determined, and without a body under a rule without cells.
        """
        from nonsmooth.reports.interface.map_result import map_scene

        return map_scene(self.scene, grid, heading, until, kinematics)

    def filippov_set(self, point: Sequence[Any]) -> FilippovSet:
        """The velocities that meet at a point of the checked square, and the upper derivative of ``|c - c*|^2`` there.

        Args:
            point: ``(x, y)``, rational.

        Raises:
            ValueError: for a point outside the checked square, or one that is not rational.
            RefusalError: where the motion is not determined, and under a rule without cells.
        """
        from nonsmooth.reports.interface.filippov_set import filippov_set

        return filippov_set(self.partition, point)

    def plot(self, ax: Axes | None = None, *, show: str = "array") -> Axes:
        """Draw the wheels (``array``), the cells with their motions (``cells``) or V* over the cells (``rates``).

        Args:
            ax: where to draw; a new figure unless given, which shows the scale of V* too.
            show: what to draw.

        Returns:
            The axes.
        """
        from nonsmooth.reports.interface.plots import plot_array

        return plot_array(self, ax, show)

    def cells(self) -> CellsResult:
        """The exact cells of the checked square, as rows, JSON or pictures.

        Raises:
            RefusalError: where the motion is not determined, and under a rule without cells.
        """
        from nonsmooth.reports.interface.cells_result import CellsResult

        return CellsResult(self.partition)

    def compare(self) -> ComparisonResult:
        """The contact rules side by side on the checked square.

        Raises:
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.interface.comparison_result import compare_scene

        return compare_scene(self._standing)

    def derive(
        self, *, only: str | Sequence[str] | None = None, without: str | Sequence[str] | None = None
    ) -> ReportResult:
        """The derivation report, to be read as text or saved.

        Args:
            only: names of the sections to write, such as ``"verdict,cells"``; all unless given.
            without: names of sections to leave out.

        Raises:
            ValueError: for a name that is none; the error lists all.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.interface.report_result import derive_scene, named_parts

        return derive_scene(self._standing, named_parts(only, without))

    def report(
        self,
        file: str | Path,
        *,
        only: str | Sequence[str] | None = None,
        without: str | Sequence[str] | None = None,
    ) -> Path:
        """Write the derivation report: .html, .tex (with its figures in a folder beside it), .md or .json.

        Raises:
            ValueError: for a section that is none.
            OutputError: for a file that cannot be written.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.derivation import REPORT_FORMATS
        from nonsmooth.reports.files import output_path

        path = output_path(str(file), REPORT_FORMATS)  # refused before the work
        return self.derive(only=only, without=without).save(path)
