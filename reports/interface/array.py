"""An array of driven wheels, and what can be asked of it in a line."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from nonsmooth.reports.check import ALL_RULES, AUTO, CHECK, CheckOptions
from nonsmooth.reports.choices import Drawing
from nonsmooth.reports.design import DesignOptions
from nonsmooth.reports.interface.made_array import MadeArray
from nonsmooth.reports.simulate_options import BODY, LOOP, MAP, PATH, UNTIL, SimulateOptions
from nonsmooth.reports.study import takes

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.reports.agreement import ComparisonResult
    from nonsmooth.reports.cells import CellsResult
    from nonsmooth.reports.check_results import CheckResult
    from nonsmooth.reports.design import DesignResult
    from nonsmooth.reports.interface.filippov_set import FilippovSet
    from nonsmooth.reports.maps import MapResult
    from nonsmooth.reports.masses import MassResult
    from nonsmooth.reports.paths import PathResult
    from nonsmooth.reports.sampled_field import FieldResult


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

    @takes(CheckOptions)
    def check(self, *, at: Any = None, rule: str | None = None, accuracy: Any = None, **options: Any) -> CheckResult:
        """Position, heading and pose, with the clauses of Theorem 4 behind them.

        Args:
            at: another point to check; ``"auto"`` for the best rest point of the square.
            rule: another contact rule; ``"all"`` compares them all.
            accuracy: how near a body must come (length).
            **options: keywords as below.  Others as for :meth:`with_`.

        Raises:
            SceneError: for whatever cannot be used.
            RefusalError: where the motion is not determined.
        """
        words = {"at": AUTO} if at == AUTO else {}
        words |= {"rule": ALL_RULES} if rule == ALL_RULES else {}
        asked = {"at": at, "rule": rule, "accuracy": accuracy}
        changes = {name: value for name, value in asked.items() if name not in words}
        array = self if all(value is None for value in changes.values()) else self.with_(**changes)
        return array._studied(CHECK, **words, **options)

    @takes(SimulateOptions, PATH, LOOP)
    def simulate(self, start: Sequence[float], until: float = UNTIL, **options: Any) -> PathResult:
        """The path of a body from ``(x, y, theta)``, in the coordinates of the array.

        Args:
            start: position and heading (radian).
            until: last time.
            **options: keywords as below; ``feedback`` may also name a law.  Others as for :meth:`with_`.

        Raises:
            ValueError: for a start outside the checked square, and options that cannot be used.
            RefusalError: where the motion is not determined.
        """
        return self._simulated(start=start, until=until, **options)

    @takes(SimulateOptions, BODY)
    def dynamics(self, start: Sequence[float], until: float = UNTIL, **options: Any) -> PathResult:
        """The path of a body with mass from rest at ``(x, y, theta)``, under full dynamics.

        Args:
            start: position and heading (radian).
            until: last time.
            **options: keywords as below.  Others as for :meth:`with_`.

        Raises:
            ValueError: for a mass or an inertia that cannot be used, and a start beyond the support polygon.
        """
        return self._simulated(start=start, until=until, method="dynamics", **options)

    @takes(SimulateOptions, BODY)
    def compare_masses(self, start: Sequence[float], until: float = UNTIL, **options: Any) -> MassResult:
        """How far full dynamics goes from the path of every contact rule, for a mass and a tenth of it, four times.

        Args:
            start: position and heading (radian); bodies start at rest.
            until: last time.
            **options: keywords as below, of the heaviest body.  Others as for :meth:`with_`.

        Raises:
            ValueError: for a mass or an inertia that cannot be used.
            RefusalError: where the motion is not determined.
        """
        return self._simulated(start=start, until=until, method="dynamics", compare_masses=True, **options)

    @takes(SimulateOptions, MAP)
    def map(self, grid: int, **options: Any) -> MapResult:
        """Where ``grid x grid`` starts all over the square end, in the open loop by events.

        A body with an outline is followed under a rule without cells, by explicit steps: where it ends is sampled.

        Args:
            grid: starts in a row and in a column.
            **options: keywords as below; all starts are followed to their ends without ``until``.  Others as for
                :meth:`with_`.

        Raises:
            ValueError: for a grid, a heading or a last time that cannot be used.
            RefusalError: where the motion is not determined, and without a body under a rule without cells.
        """
        return self._simulated(grid=grid, **options)

    @takes(DesignOptions)
    def design(self, **options: Any) -> DesignResult:
        """Search for headings, speeds and positions of the wheels that meet requirements and do best.

        Every candidate is an exact array whose answers are proved; that none is better is not.

        Args:
            **options: keywords as below.

        Raises:
            SceneError: for a tolerance to maximize that the array does not state.
            ValueError: for other things that cannot be used.
        """
        from nonsmooth.reports.design import DESIGN, GivenArray

        found = DESIGN.of(GivenArray(self.document, self.folder, self.scene), **options)
        return replace(found, array=self.of_document(found.design.document, self.folder))

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
        from nonsmooth.reports.cells import drawing
        from nonsmooth.reports.figures.cells import draw_cells, draw_rates, draw_scale
        from nonsmooth.reports.figures.wheels import draw_array
        from nonsmooth.reports.result import own_axes

        chosen, axes = drawing(show), own_axes(ax)
        if chosen is Drawing.ARRAY:
            draw_array(axes, self.scene)
        elif chosen is Drawing.CELLS:
            draw_cells(axes, self.partition)
        else:
            levels = draw_rates(axes, self.partition)
            if ax is None:
                draw_scale(axes.figure, axes, self.scene, levels)
        return axes

    def cells(self) -> CellsResult:
        """The exact cells of the checked square, as rows, JSON or pictures.

        Raises:
            RefusalError: where the motion is not determined, and under a rule without cells.
        """
        from nonsmooth.reports.cells import CellsResult

        return CellsResult(self.partition)

    def field(self) -> FieldResult:
        """The field of a rule without cells at a grid of points: streamlines and V*, sampled.

        Raises:
            TypeError: for a rule with cells.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.sampled_field import field_of

        return field_of(self._standing)

    def compare(self) -> ComparisonResult:
        """The contact rules side by side on the checked square.

        Raises:
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.agreement import compare_scene

        return compare_scene(self._standing)
