"""The command of a study, as Typer reads it: the study's options, a file, and what may be changed of a scene."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import fields
from typing import Annotated, Any

import typer

from nonsmooth.reports import options as shared
from nonsmooth.reports.study import OfferedOption, SceneKind, SceneStudy, StudyRequest

SCENE_OPTIONS = ("rule", "radius", "at", "allow_outside")


def command(study: SceneStudy[Any], name: str, words: str) -> Callable[..., int]:
    """The function of a command.

    Args:
        study: what the command does.
        name: of the command.
        words: its help, as a docstring: a summary first, the exit statuses last.
    """

    def run_command(context: Any, scene: str, **given: Any) -> int:
        return _run_command(study, context, scene, given)

    run_command.__name__, run_command.__doc__ = name, words
    parameters = _parameters(study)
    run_command.__signature__ = inspect.Signature(parameters, return_annotation=int)  # type: ignore[attr-defined]
    run_command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run_command


def _run_command(study: SceneStudy[Any], context: Any, scene: str, given: dict[str, Any]) -> int:
    """Refuse what cannot be used before the work; then do it and show the result."""
    from nonsmooth.reports.files import output_path
    from nonsmooth.reports.result import show
    from nonsmooth.symbolic.files.scene_file import load_scene
    from nonsmooth.symbolic.files.system_file import holds_system, load_system

    output, json = given.pop("output"), given.pop("json")
    of_scene = {name: given.pop(name) for name in SCENE_OPTIONS}
    options = study.options(**given)
    path = None if output is None else output_path(output, study.endings(options))
    kind = SceneKind.SYSTEM if holds_system(scene) else SceneKind.ARRAY
    typed = [parameter.name for parameter in context.command.params if _is_typed(context, parameter.name)]
    study.refuse(StudyRequest(options, typed, kind), path)
    result = study.run(load_system(scene) if kind is SceneKind.SYSTEM else load_scene(scene, **of_scene), options)
    show(result, path, json=json)
    return result.exit_status


def _is_typed(context: Any, name: str) -> bool:
    """Whether a parameter was given on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def _parameters(study: SceneStudy[Any]) -> list[inspect.Parameter]:
    """The parameters of a command."""
    output = typer.Option("-o", "--output", metavar="FILE", help=study.files)
    parameters = [_parameter("context", typer.Context), _parameter("scene", shared.SceneText)]
    for entry in fields(study.options):
        own: OfferedOption = entry.metadata["option"]
        flag = own.flag or f"--{entry.name.replace('_', '-')}"
        offered = typer.Option(flag, rich_help_panel=own.heading or None, metavar=own.metavar, help=own.help)
        parameters.append(_parameter(entry.name, Annotated[own.typed, offered], entry.default))
    parameters.append(_parameter("output", Annotated[str | None, output], None))
    for name, annotation in (("rule", shared.RuleOption), ("radius", shared.Radius), ("at", shared.At)):
        parameters.append(_parameter(name, annotation, None))
    parameters.append(_parameter("allow_outside", shared.AllowOutside, False))
    return [*parameters, _parameter("json", shared.Json, False)]


def _parameter(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=default, annotation=annotation)
