"""``nonsmooth partition``: the cells of the plane, listed, drawn or compared between the contact rules."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.choices import Drawing
from nonsmooth.reports.console import refusals_named, refuse_given, write, write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Json, Picture, Radius, RuleOption, SceneText

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.scene import Scene


def partition(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    context: typer.Context,
    scene: SceneText,
    output: Picture = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    show: Annotated[
        Drawing,
        typer.Option("--show", help="What -o draws: the cells, the array of wheels, or V* over the cells (rates)."),
    ] = Drawing.CELLS,
    compare: Annotated[
        bool, typer.Option("--compare", help="Compare all contact rules on the square instead.")
    ] = False,
    json: Json = False,
) -> int:
    """List or draw the cells of the plane, each with its contact state and twist.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.analysis.cells.contact_partition import build_partition
    from nonsmooth.reports.progress import steps
    from nonsmooth.symbolic.files.scene_file import load_scene

    if output is None:
        refuse_given(context, ("show",), "-o FILE, which it draws", "none")
    if compare:
        refuse_given(context, ("show",), "a picture of one contact rule", "--compare")
    loaded = load_scene(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside)
    path = None
    if output is not None:
        from nonsmooth.reports.files import PICTURES, output_path, write_whole

        path = output_path(output, PICTURES)
    if compare:
        return _compare(loaded, path, json=json)
    if path is not None and show is Drawing.ARRAY and not json:
        return _draw_array(loaded, path)
    with refusals_named(loaded), steps(f"cells of rule {loaded.contact.rule}"):
        cells = build_partition(loaded)
    if path is not None:
        write_whole(path, _drawn(cells, show, path.suffix.lower()))
    if json:
        from nonsmooth.reports.records import partition_record

        write_json(partition_record(cells))
    elif path is not None:
        write(f"{path}: {len(cells.cells)} cells\n")
    else:
        from nonsmooth.reports.terminal import partition_view

        write_views([partition_view(cells)])
    return 0


def _drawn(cells: Partition, show: Drawing, suffix: str) -> bytes:
    """The picture that was asked for."""
    match show:
        case Drawing.ARRAY:
            from nonsmooth.reports.figures.array import array_figure

            return array_figure(cells.scene, suffix)
        case Drawing.RATES:
            from nonsmooth.reports.figures.rate_map import rate_map

            return rate_map(cells, suffix)
        case Drawing.CELLS:
            from nonsmooth.reports.figures.cell_map import cell_map

            return cell_map(cells, suffix)


def _draw_array(scene: Scene, path: Path) -> int:
    """The wheels alone, under any contact rule."""
    from nonsmooth.reports.figures.array import array_figure
    from nonsmooth.reports.files import write_whole

    write_whole(path, array_figure(scene, path.suffix.lower()))
    write(f"{path}: {len(scene.wheels)} wheels\n")
    return 0


def _compare(scene: Scene, path: Path | None, *, json: bool) -> int:
    """The contact rules side by side."""
    from nonsmooth.analysis.minimizers.agreement import compare_rules
    from nonsmooth.reports.agreement_views import agreement_map, agreement_record, agreement_view
    from nonsmooth.reports.files import write_whole
    from nonsmooth.reports.progress import steps

    with refusals_named(scene), steps("comparison of the contact rules"):
        agreement = compare_rules(scene)
    if path is not None:
        write_whole(path, agreement_map(agreement, path.suffix.lower()))
    if json:
        write_json(agreement_record(agreement))
    elif path is not None:
        for (first, second), shared in agreement.shared.items():
            write(f"{path}: rules {first} and {second} agree on a share of {shared.share}\n")
    else:
        write_views([agreement_view(agreement)])
    return 0
