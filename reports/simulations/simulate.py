"""The study ``simulate``: a path of an array, of a body with mass or of a plain system, a map of starts, an orbit."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.output.files import FILMS
from nonsmooth.reports.output.refusals import OptionError, RefusedError, bad_input, require_resolved
from nonsmooth.reports.output.study_options import PathMethod
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.messages.scene_kind import SceneKind

if TYPE_CHECKING:
    from nonsmooth.reports.studies.result import Result
    from nonsmooth.symbolic.mechanics.scene import Scene
    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

OF_LOOPS = ("feedback", "law", "gain")
OF_BODIES = ("mass", "inertia", "compare_masses")
OF_TABLES = ("seed", "certified")
OF_ARRAYS = (
    "fail",
    "tables",
    *OF_TABLES,
    "heading",
    "headings",
    "kinematics",
    *OF_LOOPS,
    "rule",
    "radius",
    "at",
    *OF_BODIES,
)


class Simulate(SceneStudy[SimulateOptions]):
    """Filippov solutions of arrays and of plain systems, one by one or many."""

    options = SimulateOptions
    files = (
        "Samples: .csv or .json; picture: .svg, .png or .pdf; of one path of an array also the motion itself: .html (a "
        "page with a slider) or .gif."
    )

    def endings(self, options: SimulateOptions) -> Collection[str]:
        """A table or a picture; of one path a film too."""
        from nonsmooth.reports.studies.result import FORMATS

        asked = (options.grid, options.headings, options.tables, options.fail)
        is_path = not options.compare_masses and all(other is None for other in asked)
        return (*FORMATS, *(FILMS if is_path else ()))

    def refuse(self, asked: StudyRequest[SimulateOptions], path: Path | None) -> None:
        """Refuse options that do nothing in what is asked for, and films of what has no wheels."""
        options = asked.options
        options.require_numbers()
        if options.method not in {PathMethod.HYSTERESIS, PathMethod.SMOOTHED}:
            asked.refuse(("width",), "--method hysteresis or smoothed", f"--method {options.method}")
        if asked.kind is SceneKind.SYSTEM:
            _refuse_of_system(asked)
        else:
            _refuse_of_array(asked)
        ending = "" if path is None else path.suffix.lower()
        if ending in FILMS and asked.kind is SceneKind.SYSTEM:
            raise RefusedError(f"{path}: required {SceneKind.ARRAY} for {ending}, received {SceneKind.SYSTEM}")
        if ending in FILMS and options.feedback:
            from nonsmooth.analysis.cells.contact_rule import rule_of
            from nonsmooth.reports.simulations.closed_paths import NO_FILM

            if not rule_of(asked.scene).keeps_rows:
                raise OptionError(NO_FILM)

    def run(self, scene: Scene | SwitchedSystem, options: SimulateOptions) -> Result:
        """A path, a map, an orbit, or distances by mass."""
        return _run_system(scene, options) if scene.kind is SceneKind.SYSTEM else _run_array(scene, options)


SIMULATE = Simulate()


def _refuse_of_system(asked: StudyRequest[SimulateOptions]) -> None:
    """What is for arrays, and for another of paths, maps and orbits."""
    asked.refuse(OF_ARRAYS, SceneKind.ARRAY, SceneKind.SYSTEM)
    if asked.options.orbit:
        asked.refuse(("grid", "method", "width"), "one path or a map (orbits are found by events)", "--orbit")
    elif asked.options.grid is not None:
        asked.refuse(("start", "method", "width"), "one path (maps are by events, from starts of their own)", "--grid")
    elif asked.options.method is PathMethod.DYNAMICS:
        raise OptionError(f"--method dynamics: required {SceneKind.ARRAY}, received {SceneKind.SYSTEM}")


def _refuse_of_array(asked: StudyRequest[SimulateOptions]) -> None:
    """What is for plain systems, and for another of paths, maps and bodies with mass."""
    options = asked.options
    if options.grid is not None:
        of_paths = ("start", "method", "width", *OF_LOOPS, *OF_BODIES)
        asked.refuse(of_paths, "one path (maps are of the open loop, by events, from starts of their own)", "--grid")
    asked.refuse(("orbit",), SceneKind.SYSTEM, SceneKind.ARRAY)
    if options.tables is not None:
        of_paths = ("start", "until", "grid", "headings", "heading", "fail", "kinematics", "method", "width")
        asked.refuse((*of_paths, *OF_LOOPS, *OF_BODIES), "one path or a map", "--tables")
        return
    asked.refuse(OF_TABLES, "--tables", "none")
    if options.headings is not None:
        others = ("grid", "heading", "fail", "kinematics", "method", "width", *OF_LOOPS, *OF_BODIES)
        asked.refuse(others, "one path or a map of places", "--headings")
        return
    if options.fail is not None:
        open_loop = ("kinematics", "method", "width", *OF_LOOPS, *OF_BODIES)
        asked.refuse(open_loop, "the open loop by events with exact kinematics", "--fail")
    if options.grid is not None:
        return
    asked.refuse(("heading",), "--grid", "none")
    if not options.feedback:
        asked.refuse(("law", "gain"), "--feedback", "none")
    if options.method is not PathMethod.DYNAMICS:
        asked.refuse(OF_BODIES, "--method dynamics", f"--method {options.method}")
        return
    if options.feedback:
        raise OptionError("--feedback: required --method events, hysteresis or smoothed, received --method dynamics")
    if options.kinematics is not Kinematics.EXACT:
        raise OptionError(f"--kinematics: required exact with --method dynamics, received {options.kinematics}")


def _run_system(system: Any, options: SimulateOptions) -> Result:
    from nonsmooth.analysis.trajectories.result import TrajectoryError

    if options.grid is not None and not options.orbit:
        from nonsmooth.reports.simulations.system_maps import build_system_map

        return build_system_map(system, options)
    from nonsmooth.reports.simulations.orbits import find_system_orbit
    from nonsmooth.reports.simulations.paths import follow_system

    with bad_input(system, ValueError, TrajectoryError):
        return find_system_orbit(system, options) if options.orbit else follow_system(system, options)


def _run_array(scene: Any, options: SimulateOptions) -> Result:
    from nonsmooth.analysis.cells.partition import RefusalError
    from nonsmooth.analysis.trajectories.result import TrajectoryError

    options = options.read_for(scene)
    require_resolved(scene)
    if options.tables is not None:
        from nonsmooth.reports.simulations.sampled_tables import draw_tables

        with bad_input(scene, ValueError):
            return draw_tables(scene, options)
    if options.headings is not None:
        from nonsmooth.reports.simulations.heading_maps import follow_headings

        with bad_input(scene, RefusalError):
            return follow_headings(scene, options)
    if options.fail is not None:
        from nonsmooth.reports.simulations.failed_paths import follow_failures

        with bad_input(scene, RefusalError, ValueError, TrajectoryError):
            return follow_failures(scene, options)
    if options.grid is not None:
        with bad_input(scene, RefusalError):
            return _map(scene, options)
    start = options.pose
    try:
        with bad_input(scene, ValueError, TrajectoryError):
            return _path(scene, options)
    except RefusedError as refused:
        error = refused.__cause__
        outside = "" if error is None or isinstance(error, RefusalError) else _outside(scene, options, start)
        raise (OptionError(outside) if outside else refused) from error


def _map(scene: Scene, options: SimulateOptions) -> Result:
    from nonsmooth.analysis.cells.contact_rule import has_cells

    if scene.body is not None or not has_cells(scene):
        from nonsmooth.reports.simulations.body_maps import build_body_map

        return build_body_map(scene, options)
    from nonsmooth.reports.simulations.maps import build_settle_map

    return build_settle_map(scene, options)


def _path(scene: Scene, options: SimulateOptions) -> Result:
    if options.method is PathMethod.DYNAMICS:
        from nonsmooth.reports.simulations.masses import compare_masses, follow_body

        return compare_masses(scene, options) if options.compare_masses else follow_body(scene, options)
    if options.closed_by is not None:
        from nonsmooth.reports.simulations.closed_paths import follow_closed

        return follow_closed(scene, options, options.closed_by)
    from nonsmooth.reports.simulations.paths import follow_array

    return follow_array(scene, options)


def _outside(scene: Scene, options: SimulateOptions, start: Sequence[float]) -> str:
    """What is wrong with a start outside the checked square of paths through cells; empty where that is not it."""
    from nonsmooth.analysis.cells.contact_rule import has_cells

    without_cells = not has_cells(scene) or (scene.body is not None and options.is_plain)
    if without_cells or options.method is PathMethod.DYNAMICS:
        return ""
    radius = scene.check.radius
    sides = [(float(centre - radius), float(centre + radius)) for centre in scene.check.equilibrium]
    if all(low <= x <= high for (low, high), x in zip(sides, start, strict=False)):
        return ""
    square = " x ".join(f"[{low:g}, {high:g}]" for low, high in sides)
    required = f"--from: required a start in the checked square {square}"
    return f"{required}, received ({start[0]:g}, {start[1]:g}); --radius and --at set the square"
