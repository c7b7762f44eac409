"""A system with modes as a script or a notebook holds it: hysteresis and dwell times, followed in time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

from nonsmooth.reports.interface.entries import entry, table
from nonsmooth.reports.interface.made_system import MadeSystem

if TYPE_CHECKING:
    from nonsmooth.reports.interface.path_result import PathResult
    from nonsmooth.symbolic.mode_system import ModeSystem

UNTIL = 10.0


@dataclass(frozen=True, init=False, repr=False)
class Modes(MadeSystem):
    """Modes with their own right-hand sides, each left for another where a guard is no longer negative.

    The state is kept.  Verdicts are about Filippov systems (:class:`System`); modes are for simulation.

    Args:
        states: names, such as ``["T"]``.
        modes: one mapping for each, with ``name``, ``rhs``, ``leave`` (guards by the mode that follows) and perhaps
            ``dwell`` (least time in it).
        name: what it is called in results.
        parameters: numbers that stand in the formulas by name.

    Raises:
        SceneError: for whatever cannot be used, naming key, requirement and what was received.
    """

    document: Mapping[str, Any]

    def __init__(
        self,
        states: Sequence[str],
        modes: Sequence[Mapping[str, Any]],
        *,
        name: str | None = None,
        parameters: Mapping[str, Any] | None = None,
    ) -> None:
        system: dict[str, Any] = {"states": list(states)}
        if parameters is not None:
            system["parameters"] = table(parameters)
        document: dict[str, Any] = {"system": system, "mode": [_mode_entry(mode) for mode in modes]}
        if name is not None:
            document["name"] = name
        self._set(document)

    @classmethod
    def load(cls, source: str | Path) -> Self:
        """From a scene file (TOML) with ``[[mode]]`` tables, or the built-in ``thermostat``.

        Raises:
            SceneError: for whatever cannot be used.
        """
        from nonsmooth.symbolic.files.scene_file import read_document

        document, _, path = read_document(source)
        return cls.of_document({"name": path.stem, **document})

    @cached_property
    def system(self) -> ModeSystem:
        """The exact system."""
        from nonsmooth.symbolic.files.mode_file import build_modes

        return self._read(build_modes, "modes")

    def __repr__(self) -> str:
        return f"Modes of {', '.join(self.system.states)}: {', '.join(mode.name for mode in self.system.modes)}"

    def simulate(self, start: Sequence[float], until: float = UNTIL, *, mode: str | None = None) -> PathResult:
        """A path from a start; ``to_dict()["modes"]`` says when it was in which mode.

        Args:
            start: one number for each state.
            until: last time.
            mode: the one it begins in; the first unless given.

        Raises:
            ValueError: for a name that is no mode's, and a guard without a gradient where it vanishes.
            TrajectoryError: where modes follow each other without end at one time.
        """
        from nonsmooth.reports.interface.path_result import PathResult
        from nonsmooth.reports.mode_paths import follow_mode_system

        path = follow_mode_system(self.system, tuple(float(value) for value in start), until, mode)
        return PathResult(self.system.name, self.system.states, path)


def _mode_entry(mode: Mapping[str, Any]) -> dict[str, Any]:
    """One ``[[mode]]``, with numbers of any kind as scene files hold them."""
    entries = dict(mode)
    for key, value in entries.items():
        entries[key] = table(value) if isinstance(value, Mapping) else entry(value)
    return entries
