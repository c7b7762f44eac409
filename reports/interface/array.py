"""An array of driven wheels, and what can be asked of it in a line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.reports.interface.made_array import MadeArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.reports.interface.cells_result import CellsResult
    from nonsmooth.reports.interface.check_result import CheckResult
    from nonsmooth.reports.interface.comparison_result import ComparisonResult
    from nonsmooth.reports.interface.design_result import DesignResult
    from nonsmooth.reports.interface.field_result import FieldResult
    from nonsmooth.reports.interface.filippov_set import FilippovSet
    from nonsmooth.reports.interface.map_result import MapResult
    from nonsmooth.reports.interface.mass_result import MassResult
    from nonsmooth.reports.interface.path_result import PathResult
    from nonsmooth.reports.interface.report_result import ReportResult
    from nonsmooth.reports.interface.sweep_result import SweepResult
    from nonsmooth.reports.sweeps.sweep import Means

AUTO = "auto"  # the best rest point of the square


@dataclass(frozen=True, init=False, repr=False)
class Array(MadeArray):
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

    def check(
        self, *, at: Sequence[Any] | str | None = None, prune: bool = True, headings: bool = False, **changes: Any
    ) -> CheckResult:
        """Position, heading and pose, with the clauses of Theorem 4 behind them.

        Args:
            at: another point to check; ``"auto"`` for the best rest point of the square.
            prune: leave out what no verdict needs.
            headings: look for headings at which the body rests around the point too.
            **changes: as for :meth:`with_`, such as ``rule="ellipse"``.

        Raises:
            SceneError: for whatever cannot be used; a ``TipsError`` for a body that does not stand at the point.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.interface.check_result import check_scene

        array = self.with_(**changes) if changes else self
        if at is not None and at != AUTO:
            array = array.with_(at=at)
        return check_scene(array.scene, prune=prune, best=at == AUTO, around=headings)

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
            method: ``events``, ``hysteresis`` or ``smoothed``; bodies with mass: :meth:`dynamics`.
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

    def dynamics(
        self,
        start: Sequence[float],
        until: float = 2.0,
        *,
        mass: float | None = None,
        inertia: float | None = None,
    ) -> PathResult:
        """The path of a body with mass from rest at ``(x, y, theta)``, under full dynamics.

        Args:
            start: position and heading (radian).
            until: last time.
            mass: per weight (1/g), that of standard gravity in the scene's units unless given; 0.1 without units.
            inertia: per weight; unless given that of a plate of the outline, or of a disc as large as the array.

        Raises:
            ValueError: for a mass or an inertia that cannot be used, and a start beyond the support polygon.
        """
        from nonsmooth.reports.interface.path_result import follow_array
        from nonsmooth.reports.interface.path_runs import path_run

        run = path_run(start, until, method="dynamics")
        return follow_array(self.scene, replace(run, mass=mass, inertia=inertia))

    def compare_masses(
        self,
        start: Sequence[float],
        until: float = 2.0,
        *,
        mass: float | None = None,
        inertia: float | None = None,
    ) -> MassResult:
        """How far full dynamics goes from the path of every contact rule, for a mass and a tenth of it, four times.

        Args:
            start: position and heading (radian); bodies start at rest.
            until: last time.
            mass: of the heaviest body, per weight (1/g), that of standard gravity unless given; 0.1 without units.
            inertia: of that body, per weight; unless given that of a disc as large as the array.

        Raises:
            ValueError: for a mass or an inertia that cannot be used.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.interface.mass_result import compare_masses
        from nonsmooth.reports.interface.path_runs import path_run

        run = path_run(start, until, method="dynamics")
        return compare_masses(self.scene, replace(run, mass=mass, inertia=inertia))

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

    def sweep(
        self,
        values: Mapping[str, Any] | None = None,
        *,
        random: int | None = None,
        seed: int = 0,
        means: Means | None = None,
        **more: Any,
    ) -> SweepResult:
        """Check many arrays that differ from this one in a few numbers.

        Args:
            values: by key path, such as ``{"wheel.1.heading": "40:50:11"}``: a range ``start:stop:count``, a list
                ``a,b,c``, or any numbers one by one.  Several give every combination.
            random: how many random draws within ranges ``start:stop``, instead of a grid.
            seed: of the draws.
            means: how it is run: workers, store, borders, failures (:class:`nonsmooth.Means`).  More than one worker
                is a process each: a script then needs ``if __name__ == "__main__":`` around what it does.
            **more: values of numbers that only one table has, such as ``mu_side="0.05:1:40"``.

        Raises:
            SceneError: for a key path that names no number of the array.
            ValueError: for values and means that cannot be used.
        """
        from nonsmooth.reports.interface.sweep_result import sweep_array
        from nonsmooth.reports.sweeps.sweep import Means

        return sweep_array(self, {**(values or {}), **more}, means or Means(), draws=random, seed=seed)

    def design(
        self,
        *,
        free: str = "headings",
        require: str = "position",
        maximize: str = "rate",
        move: Any = None,
        symmetry: int | None = None,
        checks: int = 300,
        seed: int = 1,
    ) -> DesignResult:
        """Search for headings, speeds and positions of the wheels that meet requirements and do best.

        Every candidate is an exact array whose answers are proved; that none is better is not.

        Args:
            free: what may change: names among ``headings,speeds,positions``, or which ``wheels`` there are.
            require: answers that must be good: names among ``position,heading,pose``.
            maximize: ``rate`` at which bodies come home, ``gain`` or ``margin`` of feedback, ``basin`` whence they come
                home, or ``tolerance``, the multiple of the tolerances that is certified.
            move: how far a wheel may move in x and y; None for a quarter of the side of the checked square.
            symmetry: turns that leave the array as it is, 1, 2 or 4; None for the most that it has.
            checks: how many arrays are checked at most.
            seed: of the search, which is repeatable.

        Raises:
            SceneError: for a tolerance to maximize that the array does not state.
            ValueError: for other things that cannot be used.
        """
        from nonsmooth.reports.interface.design_result import design_array

        return design_array(
            self,
            free=free,
            require=require,
            maximize=maximize,
            move=move,
            symmetry=symmetry,
            checks=checks,
            seed=seed,
        )

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

    def field(self) -> FieldResult:
        """The field of a rule without cells at a grid of points: streamlines and V*, sampled.

        Raises:
            TypeError: for a rule with cells.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.interface.field_result import field_of

        return field_of(self._standing)

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
