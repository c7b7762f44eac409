"""``nonsmooth export``: a scene as a file for a physics engine, with what is predicted of it."""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated

import typer

from nonsmooth.reports.console import write
from nonsmooth.reports.options import SceneText
from nonsmooth.reports.refusals import RefusedError, refusals_named
from nonsmooth.reports.study_command import offered
from nonsmooth.reports.study_options import SceneOptions

Output = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="MJCF: .xml; standard output without.")
]
Place = Annotated[
    str | None,
    typer.Option("--from", metavar="X,Y", help="Centre of mass, such as 0,1/4; beside the checked point unless given."),
]


class ExportFrame(StrEnum):
    """In whose frame the file is written."""

    BODY = "body"
    WORLD = "world"


Frames = Annotated[
    ExportFrame,
    typer.Option(
        "--frame",
        help="body: the array rides on the body, any friction axis. world: the table stands, a free body lies on it, "
        "and its path is predicted (rule ellipse; friction axes at right angles).",
    ),
]


def export(
    scene: SceneText,
    output: Output = None,
    place: Place = None,
    frame: Frames = ExportFrame.BODY,
    rule: Annotated[str | None, offered(SceneOptions, "rule")] = None,
    allow_outside: Annotated[bool, offered(SceneOptions, "allow_outside")] = False,
) -> int:
    """Export a scene to MuJoCo's MJCF; comments state the predicted twist and motion, and a bound on creep.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.reports.files import output_path, write_whole
    from nonsmooth.reports.mjcf import export_scene
    from nonsmooth.reports.mjcf_world import export_world
    from nonsmooth.symbolic.files.scene_file import build_scene, deep_nesting_refused, read_document
    from nonsmooth.symbolic.files.vehicle_file import build_vehicle

    path = None if output is None else output_path(output, (".xml",))
    with deep_nesting_refused(scene):
        data, label, file = read_document(scene, at=place)
        is_vehicle = "vehicle" in data
        if is_vehicle and place is not None:
            raise RefusedError(f"{label}: --from: required none for a vehicle, which states its centre of mass")
        if is_vehicle:
            loaded = build_vehicle(data, label, file).scene
        else:
            loaded = build_scene(data, label, file, allow_outside=allow_outside)
        loaded = loaded if rule is None else loaded.under(rule)
    stated = place is not None or is_vehicle
    with refusals_named(loaded):
        start = loaded.check.equilibrium if stated else None
        exported = export_world(loaded, start) if frame is ExportFrame.WORLD else export_scene(loaded, start)
    if path is None:
        write(exported.text())
        return 0
    write_whole(path, exported.text().encode())
    write(f"{path}: {exported.summary}\n")
    return 0
