"""``nonsmooth partition``: the cells of the plane, listed, drawn or compared between the contact rules."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.choices import Drawing
from nonsmooth.reports.console import refuse_given, write, write_json, write_views
from nonsmooth.reports.options import AllowOutside, At, Json, Picture, Radius, RuleOption, SceneText
from nonsmooth.reports.refusals import refusals_named

if TYPE_CHECKING:
    from pathlib import Path

    from nonsmooth.reports.result import Result
    from nonsmooth.symbolic.scene import Scene


Show = Annotated[
    Drawing,
    typer.Option("--show", help="What -o draws: the cells, the array of wheels, or V* over the cells (rates)."),
]
Compare = Annotated[bool, typer.Option("--compare", help="Compare all contact rules on the square instead.")]


def partition(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    context: typer.Context,
    scene: SceneText,
    output: Picture = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    show: Show = Drawing.CELLS,
    compare: Compare = False,
    json: Json = False,
) -> int:
    """List or draw the cells of the plane, each with its contact state and twist, or a sampled field.

    Under rule box with loads = "any": where each motion is possible under some load.
    Of a plain system in two states: its cells, what solutions do on their borders, and with -o its phase portrait.

    Exit status: 0 done, 2 bad input.
    """
    from nonsmooth.reports.files import PICTURES, output_path
    from nonsmooth.reports.result import show as write_result
    from nonsmooth.symbolic.contact_set import standing
    from nonsmooth.symbolic.files.scene_file import load_scene
    from nonsmooth.symbolic.files.system_file import holds_system

    if holds_system(scene):
        refuse_given(context, ("show", "compare", "rule"), "an array of wheels", "a plain system")
        return _portray(scene, output, radius, at, json=json)
    if output is None:
        refuse_given(context, ("show",), "-o FILE, which it draws", "none")
    if compare:
        refuse_given(context, ("show",), "a picture of one contact rule", "--compare")
    loaded = standing(load_scene(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside))
    path = None if output is None else output_path(output, PICTURES)
    if path is None and not compare and _leaves_motions_open(loaded):
        return _possible(loaded, json=json)
    if path is not None and show is Drawing.ARRAY and not (json or compare):
        return _draw_array(loaded, path)
    with refusals_named(loaded):
        found = _found(loaded, show, compare=compare)
    write_result(found, path, json=json)
    return 0


def _found(scene: Scene, show: Drawing, *, compare: bool) -> Result:
    """The contact rules side by side, the cells, or the field of a rule without cells."""
    from nonsmooth.analysis.contact_rule import SmoothRule, rule_of
    from nonsmooth.reports.progress import steps

    if compare:
        from nonsmooth.reports.agreement import compare_scene

        with steps("comparison of the contact rules"):
            return compare_scene(scene)
    if isinstance(rule_of(scene), SmoothRule):
        from nonsmooth.reports.sampled_field import field_of

        with steps(f"field of rule {scene.contact.rule}"):
            return field_of(scene)
    from nonsmooth.reports.cells import cells_of

    with steps(f"cells of rule {scene.contact.rule}"):
        return replace(cells_of(scene), show=show)


def _portray(scene: str, output: str | None, radius: str | None, at: str | None, *, json: bool) -> int:
    """Cells, borders and phase portrait of a plain system."""
    from nonsmooth.reports.files import PICTURES, output_path
    from nonsmooth.reports.phase_portrait import PhasePortrait
    from nonsmooth.reports.result import show
    from nonsmooth.symbolic.files.system_file import load_system

    system = load_system(scene, radius=radius, at=at)
    path = None if output is None else output_path(output, PICTURES)
    show(PhasePortrait(system), path, json=json)
    return 0


def _leaves_motions_open(scene: Scene) -> bool:
    """Whether all loads that carry the weight are meant under rule ``box``."""
    from nonsmooth.symbolic.unknown_loads import UnknownLoads

    return scene.contact.rule == "box" and scene.contact.loads == UnknownLoads()


def _possible(scene: Scene, *, json: bool) -> int:
    """Where each motion is possible under some load."""
    from nonsmooth.reports.possible_motions import possible_record, possible_view
    from nonsmooth.reports.progress import steps

    with refusals_named(scene), steps("motions that unknown loads leave possible"):
        from nonsmooth.proofs.clauses.every_load.possible_twists import possible_twists

        found = possible_twists(scene)
    if json:
        write_json(possible_record(scene, found))
    else:
        write_views([possible_view(scene, found)])
    return 0


def _draw_array(scene: Scene, path: Path) -> int:
    """The wheels alone, under any contact rule."""
    from nonsmooth.reports.cells import drawn
    from nonsmooth.reports.files import write_whole

    write_whole(path, drawn(scene, path.suffix.lower(), Drawing.ARRAY))
    write(f"{path}: {len(scene.wheels)} wheels\n")
    return 0
