"""``nonsmooth simulate``: Filippov solutions, with events and what is not unique about them."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any

import typer

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import Law, Method
from nonsmooth.reports.console import RefusedError, json_text, refusals_named, write, write_json, write_views
from nonsmooth.reports.options import At, Json, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.analysis.partitions.partition import Partition
    from nonsmooth.analysis.trajectories.result import Trajectory


def simulate(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    scene: SceneText,
    start: Annotated[str, typer.Option("--from", metavar="X,Y,THETA", help="Start, such as 0.2,0.4,0.")],
    until: Annotated[float, typer.Option("--until", metavar="T", help="Last time.")] = 2.0,
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
    """Follow a Filippov solution event by event; say where it is not unique."""
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
    path = None if output is None else output_path(output, (".csv", ".json", *PICTURES))
    loaded = load_scene(scene, rule=rule, radius=radius, at=at)
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
