"""What ``nonsmooth simulate`` can do with plain switched systems: paths, maps, periodic orbits."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from nonsmooth.reports.choices import PathMethod
from nonsmooth.reports.console import RefusedError
from nonsmooth.reports.simulation_modes import (
    OF_BODIES,
    OF_LOOPS,
    OF_SCENES,
    UNTIL,
    Options,
    SimulationMode,
    read_start,
)

if TYPE_CHECKING:
    from nonsmooth.reports.shown import Shown
    from nonsmooth.symbolic.switched_system import SwitchedSystem

OF_ARRAYS = ("heading", "kinematics", *OF_LOOPS, *OF_SCENES, *OF_BODIES)
SYSTEM_UNTIL = 10.0  # last time of the paths of a map


class SystemPathMode(SimulationMode):
    """One path of a plain switched system in any number of states."""

    def __init__(self, load: Callable[[], SwitchedSystem]) -> None:
        self._load = load

    def refuse_others(self, options: Options) -> None:
        """All that is for arrays."""
        options.refuse(OF_ARRAYS, "an array of wheels", "a plain switched system")
        if options.method is PathMethod.DYNAMICS:
            raise RefusedError("--method dynamics: required an array of wheels, received a plain switched system")

    def shown(self, options: Options) -> Shown:
        """By events, hysteresis or smoothing."""
        from nonsmooth.analysis.trajectories.result import TrajectoryError
        from nonsmooth.reports.system_paths import follow_system
        from nonsmooth.symbolic.scene_error import SceneError

        system = self._load()
        start = read_start(options.start, system.stated_states)
        try:
            return follow_system(system, start, options.until or UNTIL, options.method, options.width)
        except SceneError:
            raise
        except (ValueError, TrajectoryError) as error:
            raise RefusedError(f"{system.origin}: {error}") from None


class SystemOrbitMode(SimulationMode):
    """A periodic orbit of a plain switched system."""

    def __init__(self, load: Callable[[], SwitchedSystem]) -> None:
        self._load = load

    def refuse_others(self, options: Options) -> None:
        """All that is for arrays, for maps, and for paths that are followed otherwise than by events."""
        options.refuse(OF_ARRAYS, "an array of wheels", "a plain switched system")
        options.refuse(("grid", "method", "width"), "one path or a map (orbits are found by events)", "--orbit")

    def shown(self, options: Options) -> Shown:
        """The orbit that the start is near, or that its path approaches."""
        from nonsmooth.analysis.orbits.orbit_error import OrbitError
        from nonsmooth.reports.system_orbits import UNTIL as ORBIT_UNTIL
        from nonsmooth.reports.system_orbits import find_system_orbit
        from nonsmooth.symbolic.scene_error import SceneError

        system = self._load()
        start = read_start(options.start, system.stated_states)
        try:
            return find_system_orbit(system, start, options.until or ORBIT_UNTIL)
        except OrbitError as error:
            required = "--from: required a start from which a periodic orbit is found"
            raise RefusedError(f"{required}, received {options.start}: {error}") from None
        except SceneError:
            raise
        except ValueError as error:
            raise RefusedError(f"{system.origin}: {error}") from None


class SystemStartsMap(SimulationMode):
    """Where N x N starts of a plain switched system in two states have come to, by events."""

    def __init__(self, load: Callable[[], SwitchedSystem]) -> None:
        self._load = load

    def refuse_others(self, options: Options) -> None:
        """All that is for arrays, and for one path."""
        options.refuse(OF_ARRAYS, "an array of wheels", "a plain switched system")
        options.refuse(("start", "method", "width"), "one path (maps are by events)", "--grid")

    def shown(self, options: Options) -> Shown:
        """The last places of a grid of paths."""
        from nonsmooth.reports.interface.argument_error import ArgumentError
        from nonsmooth.reports.interface.map_result import map_system

        try:
            return map_system(self._load(), options.grid or 0, options.until or SYSTEM_UNTIL).shown
        except ArgumentError as error:
            raise RefusedError(f"--{error}") from None


def system_mode(options: Options, load: Callable[[], SwitchedSystem]) -> SimulationMode:
    """The mode for a plain system."""
    if options.orbit:
        return SystemOrbitMode(load)
    return SystemPathMode(load) if options.grid is None else SystemStartsMap(load)
