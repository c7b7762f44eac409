"""``nonsmooth simulate``: Filippov solutions, with events and what is not unique about them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import Law, Method
from nonsmooth.reports.console import RefusedError, json_text, refusals_named, write, write_json, write_views
from nonsmooth.reports.options import At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.analysis.partitions.partition import Partition
    from nonsmooth.analysis.trajectories.result import Trajectory
    from nonsmooth.reports.simulate import Run
    from nonsmooth.symbolic.scene import Scene


def simulate(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    start: Annotated[str, typer.Option("--from", metavar="X,Y,THETA", help="Start, such as 0.2,0.4,0.")],
    until: Annotated[float, typer.Option("--until", metavar="T", help="Last time.")] = 2.0,
    kinematics: Annotated[Kinematics, typer.Option("--kinematics", help="Exact pose or leading order.")] = (
        Kinematics.EXACT
    ),
    method: Annotated[
        Method, typer.Option("--method", help="Events, the paper's hysteresis, smoothing, or full dynamics.")
    ] = Method.EVENTS,
    width: Annotated[float, typer.Option("--width", help="Width of hysteresis or smoothing.")] = 1e-3,
    feedback: Annotated[bool, typer.Option("--feedback", help="Close the loop (rule nearest).")] = False,
    law: Annotated[Law, typer.Option("--law", help="Feedback law, with --feedback.")] = Law.CORRECTED,
    mass: Annotated[
        float | None,
        typer.Option("--mass", metavar="M", help="With --method dynamics: mass per weight, 1/g; 0.1 unless given."),
    ] = None,
    inertia: Annotated[
        float | None,
        typer.Option(
            "--inertia", metavar="I", help="Inertia per weight; that of a disc as large as the array unless given."
        ),
    ] = None,
    compare_masses: Annotated[
        bool,
        typer.Option("--compare-masses", help="Distance of full dynamics from each rule, for M, M/10, ..., M/10000."),
    ] = False,
    output: Annotated[
        str | None, typer.Option("-o", "--output", metavar="FILE", help=".csv, .json, .svg, .png or .pdf")
    ] = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    json: Json = False,
) -> int:
    """Follow a Filippov solution event by event, or a body with mass; say where a solution is not unique."""
    from nonsmooth.analysis.partitions.contact_partition import build_partition
    from nonsmooth.reports import simulate as views
    from nonsmooth.reports.files import PICTURES, output_path, write_whole
    from nonsmooth.symbolic.files.scene_file import load_scene

    run = views.Run(
        _start(start),
        _positive("--until", until),
        kinematics,
        method,
        law if feedback else None,
        _positive("--width", width),
    )
    dynamics = _dynamics_options(run, mass, inertia, compare_masses=compare_masses)
    path = None if output is None else output_path(output, (".csv", ".json", *PICTURES))
    loaded = load_scene(scene, rule=rule, radius=radius, at=at)
    if dynamics is not None:
        return _simulate_dynamics(loaded, run, dynamics, path, json=json)
    with refusals_named(loaded):
        partition = build_partition(loaded)
    try:
        trajectory = views.follow(partition, run)
    except ValueError as error:
        raise RefusedError(f"{loaded.origin}: {error}") from None
    record = views.trajectory_record(partition, run, trajectory)
    if path is not None:
        write_whole(path, _trajectory_bytes(path, partition, trajectory, record))
    if json:
        write_json(record)
    elif path is not None:
        write(f"{path}: {len(trajectory.events)} events, {trajectory.end.reason}\n")
    else:
        write_views([views.trajectory_view(partition, trajectory)])
    return 0


def _start(text: str) -> tuple[float, float, float]:
    """Three finite numbers from ``x,y,theta``."""
    parts = text.split(",")
    try:
        x, y, theta = (float(part) for part in parts)
    except ValueError:
        x = y = theta = math.nan
    if not all(math.isfinite(value) for value in (x, y, theta)):
        raise RefusedError(f"--from: required three numbers x,y,theta, received {text[:60]!r}")
    return x, y, theta


def _positive(option: str, value: float) -> float:
    if not (math.isfinite(value) and value > 0):
        raise RefusedError(f"{option}: required a positive number, received {value}")
    return value


class _Dynamics(NamedTuple):
    """Options of full dynamics; None stands for the default."""

    mass: float | None
    inertia: float | None
    compare_masses: bool


def _dynamics_options(run: Run, mass: float | None, inertia: float | None, *, compare_masses: bool) -> _Dynamics | None:
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


def _simulate_dynamics(scene: Scene, run: Run, options: _Dynamics, path: Path | None, *, json: bool) -> int:
    """Full dynamics: one path, or a ladder of masses."""
    from nonsmooth.analysis.dynamics.mass_study import mass_ladder, mass_study
    from nonsmooth.analysis.dynamics.newton_euler import simulate_dynamics
    from nonsmooth.analysis.fields.contact_model import contact_model
    from nonsmooth.analysis.trajectories.result import TrajectoryError
    from nonsmooth.reports import dynamics as views
    from nonsmooth.reports.files import write_whole

    model = contact_model(scene)
    try:
        body = views.chosen_body(model, options.mass, options.inertia)
        bodies = mass_ladder(body) if options.compare_masses else ()
    except ValueError as error:
        raise RefusedError(f"--{error}") from None
    shown: views.Shown
    try:
        with refusals_named(scene):
            if bodies:
                shown = views.ShownMasses(scene, mass_study(scene, bodies, run.start, run.until))
            else:
                shown = views.ShownPath(scene, simulate_dynamics(model, body, run.start, run.until))
    except TrajectoryError as error:
        raise RefusedError(f"{scene.origin}: {error}") from None
    if path is not None:
        write_whole(path, views.file_bytes(shown, path.suffix.lower()))
    if json:
        write_json(shown.record())
    elif path is not None:
        write(f"{path}: {shown.summary()}\n")
    else:
        write_views([shown.view()])
    return 0


def _trajectory_bytes(path: Path, partition: Partition, trajectory: Trajectory, record: dict[str, Any]) -> bytes:
    from nonsmooth.reports.simulate import trajectory_table

    match path.suffix.lower():
        case ".csv":
            return trajectory_table(trajectory)
        case ".json":
            return json_text(record).encode()
        case suffix:
            from nonsmooth.reports.figures.trajectory import trajectory_figure

            return trajectory_figure(partition, trajectory, suffix)
