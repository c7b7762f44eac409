"""``nonsmooth simulate``: Filippov solutions, with events and what is not unique about them; maps of their ends."""

from __future__ import annotations

import math
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import Law, Method
from nonsmooth.reports.console import RefusedError, refusals_named, write, write_json, write_views
from nonsmooth.reports.options import At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.reports.settle_maps import GridRun
    from nonsmooth.reports.simulate import Run
    from nonsmooth.symbolic.scene import Scene
    from nonsmooth.symbolic.switched_equations import SwitchedEquations

UNTIL = 2.0  # last time of a single path, where none is given
NOT_MAPPED = ("start", "method", "width", "feedback", "law")  # parameters of one path
OF_ARRAYS = ("grid", "heading", "kinematics", "feedback", "law", "rule", "radius", "at")  # parameters of arrays
MAX_GRID = 500  # starts in a row: a quarter of a million paths, some 40 MB of JSON


def simulate(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    context: typer.Context,
    scene: SceneText,
    start: Annotated[
        str | None, typer.Option("--from", metavar="X,Y,THETA", help="Start, such as 0.2,0.4,0: one number per state.")
    ] = None,
    grid: Annotated[
        int | None, typer.Option("--grid", metavar="N", help="Map the ends of N x N starts instead of one path.")
    ] = None,
    until: Annotated[
        float | None, typer.Option("--until", metavar="T", help="Last time: 2; with --grid, until all have ended.")
    ] = None,
    heading: Annotated[float, typer.Option("--heading", metavar="THETA", help="Start heading, with --grid.")] = 0.0,
    kinematics: Annotated[Kinematics, typer.Option("--kinematics", help="Exact pose or leading order.")] = (
        Kinematics.EXACT
    ),
    method: Annotated[Method, typer.Option("--method", help="Events, or the paper's hysteresis.")] = (Method.EVENTS),
    width: Annotated[float, typer.Option("--width", help="Width of the hysteresis.")] = 1e-3,
    feedback: Annotated[bool, typer.Option("--feedback", help="Close the loop (rule nearest).")] = False,
    law: Annotated[Law, typer.Option("--law", help="Feedback law, with --feedback.")] = Law.CORRECTED,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help=".csv, .json, .svg, .png or .pdf")
    ] = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    json: Json = False,
) -> int:
    """Follow a Filippov solution event by event, or map where many of them end; say where they are not unique."""
    from nonsmooth.reports import simulate as views
    from nonsmooth.reports.files import PICTURES, output_path
    from nonsmooth.symbolic.files.equations_file import holds_system, load_equations
    from nonsmooth.symbolic.files.scene_file import load_scene

    if until is not None:
        _positive("--until", until)
    path = None if output is None else output_path(output, (".csv", ".json", *PICTURES))
    _positive("--width", width)
    if holds_system(scene):
        _refuse(context, OF_ARRAYS, "an array of wheels", "a plain switched system")
        equations = load_equations(scene)
        numbers = _start(start, equations.states)
        return _follow_system(equations, numbers, until or UNTIL, (method, width), path, json=json)
    if grid is not None:
        _refuse(context, NOT_MAPPED, "one path (maps are of the open loop, by events)", "--grid")
        map_run = _grid_run(grid, heading, until, kinematics)
        return _map(load_scene(scene, rule=rule, radius=radius, at=at), map_run, path, json=json)
    _refuse(context, ("heading",), "--grid", "none")
    x, y, theta = _start(start, views.POSE)
    run = views.Run((x, y, theta), until or UNTIL, kinematics, method, law if feedback else None, width)
    return _follow(load_scene(scene, rule=rule, radius=radius, at=at), run, path, json=json)


def _follow(loaded: Scene, run: Run, path: Path | None, *, json: bool) -> int:
    """One path of an array."""
    from nonsmooth.analysis.partitions.contact_partition import build_partition
    from nonsmooth.reports import simulate as views
    from nonsmooth.reports.files import write_whole

    with refusals_named(loaded):
        partition = build_partition(loaded)
    try:
        trajectory = views.follow(partition, run)
    except ValueError as error:
        raise RefusedError(f"{loaded.origin}: {error}") from None
    record = views.trajectory_record(partition, run, trajectory)
    if path is not None:
        write_whole(path, views.trajectory_bytes(path.suffix.lower(), partition, trajectory, record))
    if json:
        write_json(record)
    elif path is not None:
        write(f"{path}: {len(trajectory.events)} events, {trajectory.end.reason}\n")
    else:
        write_views([views.trajectory_view(partition, trajectory)])
    return 0


def _follow_system(
    equations: SwitchedEquations,
    start: tuple[float, ...],
    until: float,
    how: tuple[Method, float],
    path: Path | None,
    *,
    json: bool,
) -> int:
    """One path of a plain switched system."""
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.reports import system_paths as views
    from nonsmooth.reports.files import write_whole

    try:
        solution = views.follow_system(equations, start, until, *how)
    except (ValueError, TrajectoryError) as error:
        raise RefusedError(f"{equations.origin}: {error}") from None
    if path is not None:
        write_whole(path, views.system_path_bytes(path.suffix.lower(), solution))
    if json:
        write_json(views.system_path_record(solution))
    elif path is not None:
        write(f"{path}: {len(solution.trajectory.events)} events, {solution.trajectory.end.reason}\n")
    else:
        write_views([views.system_path_view(solution)])
    return 0


def _map(loaded: Scene, run: GridRun, path: Path | None, *, json: bool) -> int:
    """The ends of a grid of paths."""
    from nonsmooth.analysis.partitions.contact_partition import build_partition
    from nonsmooth.reports import settle_maps as views
    from nonsmooth.reports.files import write_whole

    with refusals_named(loaded):
        partition = build_partition(loaded)
    found = views.build_map(partition, run)
    if path is not None:
        write_whole(path, views.map_bytes(path.suffix.lower(), partition, run, found))
    if json:
        write_json(views.map_record(partition, run, found))
    elif path is not None:
        write(f"{path}: {len(found.starts)} starts, {len(found.ends)} kinds of ends\n")
    else:
        write_views([views.map_view(partition, run, found)])
    return 0


def _refuse(context: typer.Context, names: Collection[str], required: str, received: str) -> None:
    """Refuse the options of these parameters where they are given."""
    for parameter in context.command.params:
        source = context.get_parameter_source(parameter.name or "")
        if parameter.name in names and source is not None and source.name == "COMMANDLINE":
            raise RefusedError(f"{max(parameter.opts, key=len)}: required {required}, received {received}")


def _grid_run(count: int, heading: float, until: float | None, kinematics: Kinematics) -> GridRun:
    from nonsmooth.reports.settle_maps import GridRun

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
