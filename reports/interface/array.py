"""An array of driven wheels: how it is made in a line, and what can be asked of it in another."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from nonsmooth.reports.checks.check import ALL_RULES, AUTO, CHECK, CheckOptions
from nonsmooth.reports.designs.design import DESIGN, DesignOptions, GivenArray
from nonsmooth.reports.interface.scene import PythonScene
from nonsmooth.reports.output.entries import entry, table
from nonsmooth.reports.output.study_options import Drawing
from nonsmooth.reports.simulations.simulate_options import BODY, LOOP, MAP, PATH, UNTIL, SimulateOptions
from nonsmooth.reports.studies.study import takes
from nonsmooth.symbolic.files.documents import deep_nesting_refused, read_document, require_path
from nonsmooth.symbolic.messages.scene_error import SceneError

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.reports.checks.agreement import ComparisonResult
    from nonsmooth.reports.checks.cells import CellsResult, FieldResult
    from nonsmooth.reports.checks.check_results import CheckResult
    from nonsmooth.reports.designs.design import DesignResult
    from nonsmooth.reports.interface.filippov_set import FilippovSet
    from nonsmooth.reports.interface.system import System
    from nonsmooth.reports.simulations.maps import MapResult
    from nonsmooth.reports.simulations.masses import MassResult
    from nonsmooth.reports.simulations.paths import PathResult
    from nonsmooth.symbolic.mechanics.scene import Scene


# ---- one wheel -----------------------------------------------------------------------------------
#
# One driven wheel, as Python describes it.


@dataclass(frozen=True)
class Wheel:
    """One driven wheel.

    Attributes:
        position: ``(x, y)`` in the unit of length.
        heading: of the rim: ``"inward"``, ``"outward"``, an angle, or a direction ``(a, b)``; None for its field.
        speed: of the rim (length/second); None for 1, or for the array's field.
        mu_roll: friction along the friction axis; None for the array's.
        mu_side: friction across it; None for the array's.
        speed_limit: the largest speed of its drive (length/second); None for the array's.
        axis: the friction axis, as a heading is written; None for the array's, which is the rim unless it names one.
        contact: its contact rule, ``"ellipse"`` or ``"roller"``, in an array whose wheels differ; None for the array's.
    """

    position: Sequence[Any]
    heading: Any = None
    speed: Any = None
    mu_roll: Any = None
    mu_side: Any = None
    speed_limit: Any = None
    axis: Any = None
    contact: str | None = None

    def table(self) -> dict[str, Any]:
        """The ``[[wheel]]`` table of a scene file."""
        return table(vars(self))


def wheel_tables(wheels: Any, name: str) -> list[dict[str, Any]]:
    """The tables of wheels in the document of an array or a vehicle of that name.

    Raises:
        SceneError: for what are no wheels.
    """
    listed = list(wheels) if isinstance(wheels, Iterable) else [wheels]
    for wheel in listed:
        if not isinstance(wheel, Wheel):
            raise SceneError(str(name), "wheels", "ns.Wheel(position) for each", wheel)
    return [wheel.table() for wheel in listed]


# ---- arrays --------------------------------------------------------------------------------------

# Where a keyword of `with_` stands in a scene file.
_PLACES = {
    "name": (),
    "mu_roll": ("friction",),
    "mu_side": ("friction",),
    "axis": ("friction",),
    "speed_limit": ("drive",),
    "rule": ("contact",),
    "loads": ("contact",),
    "at": ("check",),
    "radius": ("check",),
    "length": ("check",),
    "accuracy": ("check",),
    "lyapunov": ("check",),
    "field": (),
    "body": (),
    "tolerance": (),
    "units": (),
}
_KEYS = {"at": "equilibrium"}


@dataclass(frozen=True, init=False, repr=False)
class Array(PythonScene):
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

    Attributes:
        document: the tables of a scene file.
        folder: what relative names of files in it, such as a CSV file of wheels, are relative to.

    Raises:
        SceneError: for whatever cannot be used, naming key, requirement and what was received.
    """

    document: Mapping[str, Any]
    folder: Path = field(compare=False)

    _nameless = "array"

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
        document = placed({"wheel": wheel_tables(wheels, more.get("name") or self._nameless)}, given)
        self._set(document, Path())

    def _set(self, document: Mapping[str, Any], folder: Path) -> None:
        object.__setattr__(self, "document", document)
        object.__setattr__(self, "folder", folder)
        _ = self.scene  # refuse what cannot be used at once

    # ---- making ----------------------------------------------------------------------------------

    @classmethod
    def of_document(cls, document: Mapping[str, Any], folder: Path | None = None) -> Self:
        """The array of a scene file's tables.

        Args:
            document: tables and keys as in a scene file.
            folder: in which a table of wheels lies.

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
        """``rows x columns`` wheels, centred on the origin, rims to it unless a field says otherwise.

        Args:
            rows: in y.
            columns: in x.
            pitch: distance of neighbours (length).
            **more: as for :meth:`with_`.
        """
        layout = table({"rows": rows, "columns": columns, "pitch": pitch})
        return cls.of_document(placed({"grid": layout}, more))

    @classmethod
    def from_csv(cls, file: str | Path, **more: Any) -> Self:
        """Wheels of a CSV table with columns x, y and optionally the other keywords of a :class:`Wheel`.

        Args:
            file: the table.
            **more: as for :meth:`with_`.

        Raises:
            SceneError: for whatever cannot be used, naming row and column.
        """
        require_path(file, "wheels.file", "a table")
        path = Path(file)
        return cls.of_document(placed({"wheels": {"file": path.name}}, more), path.parent)

    @classmethod
    def from_table(cls, table: Any, **more: Any) -> Self:
        """Wheels of a table of columns, read as those of a CSV file are: a data frame, or lists by name.

        Args:
            table: a data frame of pandas or polars, or a mapping from names of columns to their entries; columns x, y
                and optionally the others of :meth:`from_csv`. None and NaN are empty cells.
            **more: as for :meth:`with_`.

        Raises:
            SceneError: for whatever cannot be used, naming row and column.
        """
        from nonsmooth.symbolic.files.wheel_csv import wheels_of_table

        return cls.of_document(placed({"wheel": wheels_of_table(table)}, more))

    def with_(self, **changes: Any) -> Self:
        """Another array in which some keys are changed.

        Args:
            **changes: name, mu_roll, mu_side, axis, speed_limit, rule, loads, at, radius, lyapunov, length, accuracy;
                as tables field, body, tolerance and units.

        Raises:
            SceneError: for whatever cannot be used.
            TypeError: for a keyword that is none of these.
        """
        return self.of_document(placed(self.document, changes), self.folder)

    # ---- what it is ------------------------------------------------------------------------------

    @cached_property
    def scene(self) -> Scene:
        """The exact array: all numbers in one field."""
        from nonsmooth.symbolic.files.scene_file import build_scene

        label, file = self.origin
        with deep_nesting_refused(label):
            return build_scene(dict(self.document), label, file)

    @property
    def exact(self) -> Scene:
        """See ``scene``."""
        return self.scene

    @property
    def origin(self) -> tuple[str, Path]:
        """The name of the array in messages, and the scene file that it would have."""
        label, file = super().origin
        return label, self.folder / file

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
        from nonsmooth.symbolic.mechanics.contact_set import standing

        return standing(self.scene)

    # ---- what can be asked -----------------------------------------------------------------------

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
    def design(self, **options: Any) -> DesignResult[Self]:
        """Search for headings, speeds and positions of the wheels that meet requirements and do best.

        Every candidate is an exact array whose answers are proved; that none is better is not.

        Args:
            **options: keywords as below.

        Raises:
            SceneError: for a tolerance to maximize that the array does not state.
            ValueError: for other things that cannot be used.
        """
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
            ax: where to draw; a new figure unless given, which shows a legend, or the scale of V*, too.
            show: what to draw.

        Returns:
            The axes.
        """
        from matplotlib.figure import Figure

        from nonsmooth.reports.checks.cells import drawing
        from nonsmooth.reports.figures.cells import draw_cells, draw_rates, draw_scale, explain_cells
        from nonsmooth.reports.figures.wheels import draw_array
        from nonsmooth.reports.studies.result import own_axes

        chosen, axes = drawing(show), own_axes(ax)
        if chosen is Drawing.ARRAY:
            draw_array(axes, self.scene)
        elif chosen is Drawing.CELLS:
            kinds = draw_cells(axes, self.partition)
            if ax is None and isinstance(axes.figure, Figure):
                explain_cells(axes.figure, axes, self.partition, kinds)
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
        from nonsmooth.reports.checks.cells import CellsResult

        return CellsResult(self.partition)

    def field(self) -> FieldResult:
        """The field of a rule without cells at a grid of points: streamlines and V*, sampled.

        Raises:
            TypeError: for a rule with cells.
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.checks.cells import field_of

        return field_of(self._standing)

    def compare(self) -> ComparisonResult:
        """The contact rules side by side on the checked square.

        Raises:
            RefusalError: where the motion is not determined.
        """
        from nonsmooth.reports.checks.agreement import compare_scene

        return compare_scene(self._standing)

    # ---- how it shows itself ---------------------------------------------------------------------

    def __repr__(self) -> str:
        from nonsmooth.symbolic.numbers.number_text import exact_place, short_text

        scene = self.scene
        square = f"checked at {exact_place(scene.check.equilibrium)} within {short_text(scene.check.radius)}"
        return f"Array {scene.name!r}: {len(scene.wheels)} wheels, rule {scene.contact.rule}, {square}"

    def _repr_html_(self) -> str:
        from nonsmooth.reports.figures.style import drawn
        from nonsmooth.reports.figures.wheels import array_figure

        return drawn(array_figure, self.scene)(".svg").decode()


def placed(document: Mapping[str, Any], given: Mapping[str, Any]) -> dict[str, Any]:
    """The document with each keyword of :meth:`Array.with_` at its place; None leaves it as it is."""
    changed = dict(document)
    for name, value in given.items():
        if name not in _PLACES:
            raise TypeError(f"required a keyword among {', '.join(_PLACES)}, received {name!r}")
        if value is None:
            continue
        key = _KEYS.get(name, name)
        if not _PLACES[name]:
            changed[key] = entry(value)
            continue
        (section,) = _PLACES[name]
        changed[section] = {**changed.get(section, {}), key: entry(value)}
    return changed


# ---- reading -------------------------------------------------------------------------------------


def load(source: str | Path) -> Array | System:
    """An array or a plain system from a scene file (TOML) or a built-in name; see ``nonsmooth scenes``.

    Raises:
        SceneError: for whatever cannot be used.
    """
    from nonsmooth.reports.interface.system import System

    document, _, path = read_document(source)
    named = {"name": path.stem, **document}
    return System.of_document(named) if "system" in document else Array.of_document(named, path.parent)
