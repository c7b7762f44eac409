"""How an array of driven wheels is made in a line: wheel by wheel, as a ring, a grid or a table of wheels."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from nonsmooth.reports.entries import table
from nonsmooth.reports.interface.places import placed
from nonsmooth.reports.interface.scene import PythonScene
from nonsmooth.reports.interface.wheel import Wheel

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.scene import Scene


@dataclass(frozen=True, init=False, repr=False)
class MadeArray(PythonScene):
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
        from nonsmooth.symbolic.files.scene_file import build_scene, deep_nesting_refused

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
        name = self.document.get("name")
        label = name if isinstance(name, str) and name.strip() else "array"
        return label, self.folder / f"{label}.toml"

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
        from nonsmooth.reports.figures.style import drawn
        from nonsmooth.reports.figures.wheels import array_figure

        return drawn(array_figure, self.scene)(".svg").decode()
