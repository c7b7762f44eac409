"""What ``nonsmooth simulate`` can do: its modes, each with the options that are its own.

A mode reads its options, refuses those of other modes in one line, and returns what is shown.  To add one, write a
class on :class:`SimulationMode` and name it in :func:`array_mode`, or in
:func:`nonsmooth.reports.system_simulations.system_mode`.
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, TypeAlias

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import LawName, PathMethod
from nonsmooth.reports.console import RefusedError, refusals_named

if TYPE_CHECKING:
    from nonsmooth.reports.shown import Shown
    from nonsmooth.reports.simulate import PathRun
    from nonsmooth.symbolic.scene import Scene

UNTIL = 2.0  # last time of a single path, where none is given

# Parameters of the command by the mode they belong to.
OF_LOOPS = ("feedback", "law", "gain")
OF_BODIES = ("mass", "inertia", "compare_masses")
OF_SCENES = ("rule", "radius", "at")

Refuse: TypeAlias = Callable[[Collection[str], str, str], None]  # parameters, what is required for them, what is given


@dataclass(frozen=True)
class Options:
    """The options of the command, as typed; None where an option has no value of its own.

    Attributes:
        start: numbers of ``--from``.
        grid, heading: of a map of many starts.
        until: last time.
        kinematics: exact pose or leading order.
        method, width: how a path is followed.
        law: feedback law; None for the open loop.
        gain: of the law.
        mass, inertia, compare_masses: of a body with mass.
        orbit: whether a periodic orbit of a plain system is looked for.
        refuse: refuses parameters that were given on the command line.
    """

    start: str | None
    grid: int | None
    heading: float
    until: float | None
    kinematics: Kinematics
    method: PathMethod
    width: float
    law: LawName | None
    gain: float
    mass: float | None
    inertia: float | None
    compare_masses: bool
    orbit: bool
    refuse: Refuse

    def check(self) -> None:
        """Refuse numbers that no mode takes.

        Raises:
            RefusedError: naming the option.
        """
        if self.until is not None:
            _require_positive("--until", self.until)
        _require_positive("--width", self.width)
        _require_positive("--gain", self.gain)
        if self.method not in (PathMethod.HYSTERESIS, PathMethod.SMOOTHED):
            self.refuse(("width",), "--method hysteresis or smoothed", f"--method {self.method}")


class SimulationMode(ABC):
    """One thing that the command does."""

    @abstractmethod
    def refuse_others(self, options: Options) -> None:
        """Refuse options that do nothing here.

        Raises:
            RefusedError: naming the option and what it is for.
        """

    @abstractmethod
    def shown(self, options: Options) -> Shown:
        """Compute.

        Raises:
            RefusedError: where the scene or the start does not allow it.
        """


class ArrayMode(SimulationMode):
    """A mode of an array of wheels."""

    def __init__(self, load: Callable[[], Scene]) -> None:
        self._load = load


class StartsMap(ArrayMode):
    """Where N x N starts end, in the open loop by events."""

    def refuse_others(self, options: Options) -> None:
        """All that is for one path."""
        of_paths = ("start", "method", "width", *OF_LOOPS, *OF_BODIES)
        options.refuse(of_paths, "one path (maps are of the open loop, by events)", "--grid")
        _refuse_system_options(options)

    def shown(self, options: Options) -> Shown:
        """The ends of a grid of paths."""
        from nonsmooth.reports.interface.argument_error import ArgumentError
        from nonsmooth.reports.interface.map_result import map_scene

        scene = self._load()
        try:
            with refusals_named(scene):
                return map_scene(scene, options.grid or 0, options.heading, options.until, options.kinematics).shown
        except ArgumentError as error:
            raise RefusedError(f"--{error}") from None


class ArrayPath(ArrayMode):
    """One path of an array, in the open or the closed loop."""

    def refuse_others(self, options: Options) -> None:
        """All that is for maps and bodies with mass, and laws of the open loop."""
        _refuse_map_options(options)
        options.refuse(OF_BODIES, "--method dynamics", f"--method {options.method}")

    def shown(self, options: Options) -> Shown:
        """By events, hysteresis or smoothing through the cells of the contact rule; where it has none, by itself."""
        from nonsmooth.analysis.contact_rule import CellRule, rule_of
        from nonsmooth.analysis.trajectories.result import TrajectoryError
        from nonsmooth.reports.interface.path_result import follow_array
        from nonsmooth.symbolic.scene_error import SceneError

        run = _pose_run(options)
        scene = self._load()
        try:
            with refusals_named(scene):
                return follow_array(scene, run).shown
        except SceneError:
            raise
        except (ValueError, TrajectoryError) as error:
            in_square = isinstance(rule_of(scene), CellRule) and not (scene.body and run.is_plain)
            outside = _outside(scene, run.start) if in_square else ""
            raise RefusedError(outside or f"{scene.origin}: {error}") from None


class MassMode(ArrayMode):
    """A body with mass under full dynamics, or its distance from the path of every contact rule."""

    def refuse_others(self, options: Options) -> None:
        """Maps, feedback, and anything but the exact pose."""
        _refuse_map_options(options)
        if options.law is not None:
            raise RefusedError("--feedback: required --method events or hysteresis, received --method dynamics")
        if options.kinematics is not Kinematics.EXACT:
            raise RefusedError(f"--kinematics: required exact with --method dynamics, received {options.kinematics}")

    def shown(self, options: Options) -> Shown:
        """One path, or a ladder of masses."""
        from nonsmooth.analysis.trajectories.result import TrajectoryError
        from nonsmooth.reports.interface.argument_error import ArgumentError
        from nonsmooth.reports.interface.mass_result import compare_masses
        from nonsmooth.reports.interface.path_result import follow_array
        from nonsmooth.symbolic.scene_error import SceneError

        run = _pose_run(options)
        scene = self._load()
        find = compare_masses if options.compare_masses else follow_array
        try:
            with refusals_named(scene):
                return find(scene, run).shown
        except ArgumentError as error:
            raise RefusedError(f"--{error}") from None
        except SceneError:
            raise
        except (ValueError, TrajectoryError) as error:
            raise RefusedError(f"{scene.origin}: {error}") from None


def array_mode(options: Options, load: Callable[[], Scene]) -> ArrayMode:
    """The mode of an array that the options ask for."""
    if options.grid is not None:
        return StartsMap(load)
    return MassMode(load) if options.method is PathMethod.DYNAMICS else ArrayPath(load)


def read_start(text: str | None, states: Sequence[str], angle: str = "") -> tuple[float, ...]:
    """A finite number or formula for each state, separated by commas; that of the state ``angle`` may hold pi.

    Raises:
        RefusedError: for anything else.
    """
    required = f"--from: required {len(states)} numbers {','.join(states)}"
    if text is None:
        raise RefusedError(f"{required}, received nothing")
    parts = text.split(",")
    if len(parts) != len(states):
        raise RefusedError(f"{required}, received {text[:60]!r}")
    return tuple(_start_value(name, part, is_angle=name == angle) for name, part in zip(states, parts, strict=True))


def _start_value(name: str, text: str, *, is_angle: bool) -> float:
    from nonsmooth.symbolic.files.start_values import read_start_angle, read_start_value
    from nonsmooth.symbolic.scene_error import requirement, shown

    try:
        value = read_start_angle(text) if is_angle else read_start_value(text)
    except OverflowError:
        value = math.inf
    except ValueError as error:
        raise RefusedError(f"--from: {name}: required {requirement(error)}, received {shown(text)}") from None
    if not math.isfinite(value):
        raise RefusedError(f"--from: {name}: required a number within the range of floats, received {shown(text)}")
    return value


def _refuse_system_options(options: Options) -> None:
    options.refuse(("orbit",), "a plain switched system", "an array of wheels")


def _refuse_map_options(options: Options) -> None:
    _refuse_system_options(options)
    options.refuse(("heading",), "--grid", "none")
    if options.law is None:
        options.refuse(("law", "gain"), "--feedback", "none")


def _pose_run(options: Options) -> PathRun:
    from nonsmooth.reports.simulate import POSE, PathRun

    x, y, theta = read_start(options.start, POSE, angle="theta")
    until = options.until or UNTIL
    run = PathRun((x, y, theta), until, options.kinematics, options.method, options.law, options.width)
    return replace(run, gain=options.gain, mass=options.mass, inertia=options.inertia)


def _outside(scene: Scene, start: Sequence[float]) -> str:
    """What is wrong with a start outside the checked square; empty for one inside."""
    radius = scene.check.radius
    sides = [(float(centre - radius), float(centre + radius)) for centre in scene.check.equilibrium]
    if all(low <= x <= high for (low, high), x in zip(sides, start, strict=False)):
        return ""
    square = " x ".join(f"[{low:g}, {high:g}]" for low, high in sides)
    required = f"--from: required a start in the checked square {square}"
    return f"{required}, received ({start[0]:g}, {start[1]:g}); --radius and --at set the square"


def _require_positive(option: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise RefusedError(f"{option}: required a positive number, received {value}")
