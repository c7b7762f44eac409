"""``nonsmooth simulate``: Filippov solutions, with events and what is not unique about them; maps of their ends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Annotated, NamedTuple

import typer

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import LawName, Method
from nonsmooth.reports.console import RefusedError, refusals_named, refuse_given
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.reports.basins import GridRun
    from nonsmooth.reports.simulate import PathRun
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_system import SwitchedSystem

UNTIL = 2.0  # last time of a single path, where none is given
OF_BODIES = ("mass", "inertia", "compare_masses")  # parameters of full dynamics
NOT_MAPPED = ("start", "method", "width", "feedback", "law", *OF_BODIES)  # parameters of one path
# Parameters of arrays.
OF_ARRAYS = ("grid", "heading", "kinematics", "feedback", "law", "rule", "radius", "at", *OF_BODIES)
MAX_GRID = 500  # starts in a row: a quarter of a million paths, some 40 MB of JSON


def simulate(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    context: typer.Context,
    scene: SceneText,
    start: Annotated[
        str | None,
        typer.Option(
            "--from", metavar="X,Y,THETA", help="Start in world coordinates, such as 0.2,0.4,0: one number per state."
        ),
    ] = None,
    grid: Annotated[
        int | None,
        typer.Option("--grid", metavar="N", help="Map where N x N starts in the square end, instead of one path."),
    ] = None,
    until: Annotated[
        float | None,
        typer.Option("--until", metavar="T", help="Last time; 2 unless given, with --grid until all have ended."),
    ] = None,
    heading: Annotated[
        float, typer.Option("--heading", metavar="THETA", help="Heading of all starts in radians, with --grid.")
    ] = 0.0,
    kinematics: Annotated[
        Kinematics, typer.Option("--kinematics", help="Exact pose, or leading order as in the paper.")
    ] = (Kinematics.EXACT),
    method: Annotated[
        Method, typer.Option("--method", help="Events, the paper's hysteresis, smoothing, or full dynamics.")
    ] = Method.EVENTS,
    width: Annotated[
        float, typer.Option("--width", help="Width of --method hysteresis or smoothed, in units of the state.")
    ] = 1e-3,
    feedback: Annotated[
        bool,
        typer.Option("--feedback", help="Close the loop with gain 1 by the law that check certifies (rule nearest)."),
    ] = False,
    law: Annotated[
        LawName,
        typer.Option(
            "--law",
            help="Another feedback law, with --feedback, certified or not: printed is the paper's, cascade takes theta "
            "first (tangential rims: its length l is the checked radius).",
        ),
    ] = LawName.CERTIFIED,
    mass: Annotated[
        float | None,
        typer.Option("--mass", metavar="M", help="With --method dynamics: mass per weight, 1/g; 0.1 unless given."),
    ] = None,
    inertia: Annotated[
        float | None,
        typer.Option(
            "--inertia",
            metavar="I",
            help="With --method dynamics: inertia per weight; that of a disc as large as the array unless given.",
        ),
    ] = None,
    compare_masses: Annotated[
        bool,
        typer.Option(
            "--compare-masses",
            help="With --method dynamics: its distance from each rule's path, for M, M/10, ..., M/10000.",
        ),
    ] = False,
    output: Annotated[
        str | None,
        typer.Option("-o", "--output", metavar="FILE", help="Samples: .csv or .json; picture: .svg, .png or .pdf."),
    ] = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Follow a Filippov solution, or a body with mass, or map where many starts end; say what is not unique.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.reports import simulate as views
    from nonsmooth.reports.files import PICTURES, output_path
    from nonsmooth.symbolic.files.scene_file import load_scene
    from nonsmooth.symbolic.files.system_file import holds_system, load_system

    if until is not None:
        _positive("--until", until)
    path = None if output is None else output_path(output, (".csv", ".json", *PICTURES))
    _positive("--width", width)
    if method not in (Method.HYSTERESIS, Method.SMOOTHED):
        refuse_given(context, ("width",), "--method hysteresis or smoothed", f"--method {method}")
    if holds_system(scene):
        refuse_given(context, OF_ARRAYS, "an array of wheels", "a plain switched system")
        if method is Method.DYNAMICS:
            raise RefusedError("--method dynamics: required an array of wheels, received a plain switched system")
        system = load_system(scene)
        numbers = _start(start, system.states)
        return _follow_system(system, numbers, until or UNTIL, (method, width), path, json=json)
    if grid is not None:
        refuse_given(context, NOT_MAPPED, "one path (maps are of the open loop, by events)", "--grid")
        map_run = _grid_run(grid, heading, until, kinematics)
        return _map(
            load_scene(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside), map_run, path, json=json
        )
    refuse_given(context, ("heading",), "--grid", "none")
    if not feedback:
        refuse_given(context, ("law",), "--feedback", "none")
    x, y, theta = _start(start, views.POSE)
    run = views.Run((x, y, theta), until or UNTIL, kinematics, method, law if feedback else None, width)
    dynamics = _dynamics_options(run, mass, inertia, compare_masses=compare_masses)
    loaded = load_scene(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside)
    if dynamics is not None:
        return _simulate_dynamics(loaded, run, dynamics, path, json=json)
    return _follow(loaded, run, path, json=json)


def _follow(loaded: Scene, run: PathRun, path: Path | None, *, json: bool) -> int:
    """One path of an array."""
    from nonsmooth.analysis.cells.contact_partition import build_partition
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.reports import simulate as views
    from nonsmooth.reports.shown import show

    with refusals_named(loaded):
        partition = build_partition(loaded)
    try:
        loop = views.loop_of(partition, run)
        trajectory = views.follow(partition, run, loop)
    except (ValueError, TrajectoryError) as error:
        raise RefusedError(_outside(loaded, run.start) or f"{loaded.origin}: {error}") from None
    show(views.ShownTrajectory(partition, run, trajectory, loop), path, json=json)
    return 0


def _outside(scene: Scene, start: Sequence[float]) -> str:
    """What is wrong with a start outside the checked square; empty for one inside."""
    radius = scene.check.radius
    sides = [(float(centre - radius), float(centre + radius)) for centre in scene.check.equilibrium]
    if all(low <= x <= high for (low, high), x in zip(sides, start, strict=False)):
        return ""
    square = " x ".join(f"[{low:g}, {high:g}]" for low, high in sides)
    required = f"--from: required a start in the checked square {square}"
    return f"{required}, received ({start[0]:g}, {start[1]:g}); --radius and --at set the square"


def _follow_system(
    system: SwitchedSystem,
    start: tuple[float, ...],
    until: float,
    how: tuple[Method, float],
    path: Path | None,
    *,
    json: bool,
) -> int:
    """One path of a plain switched system."""
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.reports.shown import show
    from nonsmooth.reports.system_paths import follow_system
    from nonsmooth.symbolic.scene_error import SceneError

    try:
        solution = follow_system(system, start, until, *how)
    except SceneError:
        raise
    except (ValueError, TrajectoryError) as error:
        raise RefusedError(f"{system.origin}: {error}") from None
    show(solution, path, json=json)
    return 0


def _map(loaded: Scene, run: GridRun, path: Path | None, *, json: bool) -> int:
    """The ends of a grid of paths."""
    from nonsmooth.analysis.cells.contact_partition import build_partition
    from nonsmooth.reports.settle_maps import ShownMap, build_map
    from nonsmooth.reports.shown import show

    with refusals_named(loaded):
        partition = build_partition(loaded)
    show(ShownMap(partition, run, build_map(partition, run)), path, json=json)
    return 0


def _grid_run(count: int, heading: float, until: float | None, kinematics: Kinematics) -> GridRun:
    from nonsmooth.reports.basins import GridRun

    if not 2 <= count <= MAX_GRID:
        raise RefusedError(f"--grid: required 2 to {MAX_GRID} starts in a row, received {count}")
    if not math.isfinite(heading):
        raise RefusedError(f"--heading: required a finite number (radian), received {heading}")
    return GridRun(count, heading, until, kinematics)


def _start(text: str | None, states: Sequence[str]) -> tuple[float, ...]:
    """A finite number for each state."""
    required = f"--from: required {len(states)} numbers {','.join(states)}"
    if text is None:
        raise RefusedError(f"{required}, received nothing")
    try:
        values = tuple(float(part) for part in text.split(","))
    except ValueError:
        values = ()
    if len(values) != len(states) or not all(math.isfinite(value) for value in values):
        raise RefusedError(f"{required}, received {text[:60]!r}")
    return values


def _positive(option: str, value: float) -> None:
    if not (math.isfinite(value) and value > 0):
        raise RefusedError(f"{option}: required a positive number, received {value}")


class _Dynamics(NamedTuple):
    """Options of full dynamics; None stands for the default."""

    mass: float | None
    inertia: float | None
    compare_masses: bool


def _dynamics_options(
    run: PathRun, mass: float | None, inertia: float | None, *, compare_masses: bool
) -> _Dynamics | None:
    """The options of full dynamics, or None where another method was chosen."""
    given = {"--mass": mass is not None, "--inertia": inertia is not None, "--compare-masses": compare_masses}
    if run.method is not Method.DYNAMICS:
        for option in (option for option, used in given.items() if used):
            raise RefusedError(f"{option}: required --method dynamics, received --method {run.method}")
        return None
    if run.law is not None:
        raise RefusedError("--feedback: required --method events or hysteresis, received --method dynamics")
    if run.kinematics is not Kinematics.EXACT:
        raise RefusedError(f"--kinematics: required exact with --method dynamics, received {run.kinematics}")
    return _Dynamics(mass, inertia, compare_masses)


def _simulate_dynamics(scene: Scene, run: PathRun, options: _Dynamics, path: Path | None, *, json: bool) -> int:
    """Full dynamics: one path, or a ladder of masses."""
    from nonsmooth.analysis.dynamics.mass_study import mass_ladder, mass_study
    from nonsmooth.analysis.dynamics.newton_euler import simulate_dynamics
    from nonsmooth.analysis.fields.contact_model import contact_model
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.reports import dynamics as views
    from nonsmooth.reports.shown import Shown, show

    model = contact_model(scene)
    try:
        body = views.chosen_body(model, options.mass, options.inertia)
        bodies = mass_ladder(body) if options.compare_masses else ()
    except ValueError as error:
        raise RefusedError(f"--{error}") from None
    shown: Shown
    try:
        with refusals_named(scene):
            if bodies:
                shown = views.ShownMasses(scene, mass_study(scene, bodies, run.start, run.until))
            else:
                shown = views.ShownPath(scene, simulate_dynamics(model, body, run.start, run.until))
    except TrajectoryError as error:
        raise RefusedError(f"{scene.origin}: {error}") from None
    show(shown, path, json=json)
    return 0
