"""``nonsmooth derive``: the derivation report."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated

import typer

from nonsmooth.reports.console import refuse_given, write
from nonsmooth.reports.options import AllowOutside, At, Json, Radius, ReportFile, RuleOption, SceneText, complete_part
from nonsmooth.reports.refusals import RefusedError, refusals_named

if TYPE_CHECKING:
    from nonsmooth.reports.subject import Subject

Only = Annotated[
    str | None,
    typer.Option(
        "--only",
        metavar="NAMES",
        help="Only these sections, such as verdict,cells; a wrong name lists all.",
        autocompletion=complete_part,
    ),
]
Without = Annotated[
    str | None,
    typer.Option(
        "--without",
        metavar="NAMES",
        help="All sections but these, such as precision,stress.",
        autocompletion=complete_part,
    ),
]


def derive(  # noqa: PLR0913, PLR0917  # one parameter for each option of the command
    context: typer.Context,
    scene: SceneText,
    output: ReportFile = None,
    only: Only = None,
    without: Without = None,
    rule: RuleOption = None,
    radius: Radius = None,
    at: At = None,
    allow_outside: AllowOutside = False,
    json: Json = False,
) -> int:
    """Write the derivation report; without -o, as Markdown to standard output.

    Of a plain system in two states: its cells, borders, Lyapunov function or leading terms, and phase portrait.

    Exit status: 0 written, whatever the verdict; 2 bad input.
    """
    from nonsmooth.reports.derivation import REPORT_FORMATS
    from nonsmooth.reports.files import output_path
    from nonsmooth.reports.interface.report_result import derive_scene
    from nonsmooth.reports.progress import steps
    from nonsmooth.reports.subject import ArraySubject, Invocation, SystemSubject
    from nonsmooth.symbolic.contact_set import standing
    from nonsmooth.symbolic.files.scene_file import load_scene
    from nonsmooth.symbolic.files.system_file import holds_system, load_system
    from nonsmooth.symbolic.files.text_files import OUTSIDE_OPTION

    options = _given({"--rule": rule, "--radius": radius, "--at": at})
    options += (OUTSIDE_OPTION,) if allow_outside else ()
    invocation = Invocation(scene, options, _given({"--only": only, "--without": without, "-o": output}))
    if holds_system(scene):
        refuse_given(context, ("rule", "allow_outside"), "an array of wheels", "a plain system")
        parts = _parts(only, without, SystemSubject)
        system = load_system(scene, radius=radius, at=at)
        path = None if output is None else output_path(output, REPORT_FORMATS)
        with steps("derivation") as announce:
            result = derive_scene(system, parts, invocation=invocation, announce=announce)
    else:
        parts = _parts(only, without, ArraySubject)
        loaded = standing(load_scene(scene, rule=rule, radius=radius, at=at, allow_outside=allow_outside))
        path = None if output is None else output_path(output, REPORT_FORMATS)
        with refusals_named(loaded), steps("derivation") as announce:
            result = derive_scene(loaded, parts, invocation=invocation, announce=announce)
    if path is not None:
        result.save(path)
    if json:
        write(result.text(".json"))
    elif path is not None:
        write(f"{path}: {result.report.subject.headline}\n")
    else:
        write(result.text(".md"))
    return 0


def _given(options: dict[str, object]) -> tuple[str, ...]:
    """Name and value of the options that were given."""
    return tuple(part for name, value in options.items() if value is not None for part in (name, str(value)))


def _parts(only: str | None, without: str | None, kind: type[Subject]) -> tuple[str, ...]:
    from nonsmooth.reports.interface.report_result import named_parts

    try:
        return named_parts(only, without, kind)
    except ValueError as error:
        raise RefusedError(f"--{error}") from None
