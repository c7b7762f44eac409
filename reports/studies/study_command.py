"""The command of a study, as Typer reads it: the study's options, a file, and what may be changed of a scene."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Iterable
from dataclasses import fields
from pathlib import Path
from typing import Annotated, Any

import typer

from nonsmooth.reports.output import study_options as shared
from nonsmooth.reports.output.study_options import OfferedOption, Options, SceneOptions, flag_of, options_of, types_of
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.messages.scene_error import is_meant, one_line

OUTPUTS = ("output", "certificate", "law", "report")  # options that name files, beside -o


def command(study: SceneStudy[Any], name: str, words: str) -> Callable[..., int]:
    """The function of a command.

    Args:
        study: what the command does.
        name: of the command.
        words: its help, as a docstring: a summary first, the exit statuses last.
    """

    def run_command(context: Any, scene: Any, **given: Any) -> int:
        return _run_command(study, context, scene, given)

    run_command.__name__, run_command.__doc__ = name, words
    parameters = _parameters(study)
    run_command.__signature__ = inspect.Signature(parameters, return_annotation=int)  # type: ignore[attr-defined]
    run_command.__annotations__ = {parameter.name: parameter.annotation for parameter in parameters}
    return run_command


def _run_command(study: SceneStudy[Any], context: Any, scene: Any, given: dict[str, Any]) -> int:
    """Refuse what cannot be used before the work; then do it and show the result."""
    from nonsmooth.reports.output.files import output_path
    from nonsmooth.reports.output.refusals import UnwrittenError, beyond_floats_named
    from nonsmooth.reports.studies.result import show

    json = given.pop("json")
    output = given.pop("output", None) if study.files else None
    offered_options = options_of(study.options)
    options = study.options(**{name: _meant(offered_options[name], given[name]) for name in offered_options})
    path = None if output is None else output_path(output, study.endings(options))
    options = study.settled(options, path)
    _require_other_files(scene, [output, *(given.get(name) for name in OUTPUTS)])
    loaded = study.load(scene, options, **{name: given[name] for name in study.changes})
    typed = [parameter.name for parameter in context.command.params if _is_typed(context, parameter.name)]
    study.refuse(StudyRequest(options, typed, loaded), path)
    if not json:
        _warn(loaded)
    with beyond_floats_named(loaded):
        try:
            result = study.run(loaded, options)
        except UnwrittenError as error:
            show(error.found, path, json=json)
            raise
        show(result, path, json=json)
        return result.exit_status


def _require_other_files(scene: Any, written: Iterable[str | None]) -> None:
    """Refuse to write over a file that a scene is read from.

    Raises:
        OutputError: for such a file.
    """
    from nonsmooth.reports.output.files import OutputError
    from nonsmooth.symbolic.files.documents import scene_files

    for path in map(Path, filter(None, written)):
        for text in scene if isinstance(scene, list) else [scene]:
            if path.exists() and any(file.exists() and path.samefile(file) for file in scene_files(text)):
                raise OutputError(path, "another file than the scene is read from", "one of these")


def _warn(scene: Any) -> None:
    """Print what of a scene may not be what was meant, above all that is said of it; of many scenes nothing."""
    from nonsmooth.reports.output.console import write
    from nonsmooth.symbolic.numbers.number_field import FirstRemark

    scenes = scene if isinstance(scene, list) else [scene]
    field = getattr(scenes[0], "field", None) if len(scenes) == 1 else None
    for note in getattr(field, "remarks", ()):
        if isinstance(note, FirstRemark):
            write(f"note: {one_line(note)}\n")


def _is_typed(context: Any, name: str) -> bool:
    """Whether a parameter was given on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


def _meant(option: OfferedOption, typed: Any) -> Any:
    """The value of an option that was typed: a flag that turns off is off where it is given."""
    return not typed if option.flag.startswith("--no-") else typed


# ---- what is offered -----------------------------------------------------------------------------


def _parameters(study: SceneStudy[Any]) -> list[inspect.Parameter]:
    """The parameters of a command: scene, options, file, what may be changed of the scene, and JSON."""
    found = [_parameter("context", typer.Context), _parameter("scene", study.argument), *_offered(study.options)]
    if study.files:
        output = typer.Option("-o", "--output", metavar="FILE", help=study.files)
        found.append(_parameter("output", Annotated[str | None, output], None))
    listed = options_of(study.options)
    found += [entry for entry in _offered(SceneOptions) if entry.name in study.changes and entry.name not in listed]
    return [*found, _parameter("json", shared.Json, False)]


def _offered(options: type[Options]) -> list[inspect.Parameter]:
    """A parameter for each option."""
    types, listed = types_of(options), options_of(options)
    defaults = {
        entry.name: _meant(listed[entry.name], entry.default) for entry in fields(options) if entry.name in listed
    }
    return [_parameter(name, Annotated[types[name], offered(options, name)], defaults[name]) for name in listed]


def offered(options: type[Options], name: str) -> Any:
    """An option as Typer reads it."""
    option = options_of(options)[name]
    reading = _among(option.names) if option.names else {"metavar": option.metavar, "autocompletion": option.complete}
    flags = option.flag.split() or [flag_of(name, option)]
    return typer.Option(*flags, rich_help_panel=option.heading or None, help=option.help, **reading)


def _among(names: Callable[[], Collection[str]]) -> dict[str, Any]:
    """How an option reads one of some names."""

    def read(text: str) -> str:
        if text not in names():
            known = names()
            raise typer.BadParameter(f"{text!r} is not one of {', '.join(map(repr, known))}{is_meant(text, known)}.")
        return text

    def begun(incomplete: str) -> list[str]:
        return [name for name in names() if name.startswith(incomplete)]

    return {"parser": read, "metavar": f"[{'|'.join(names())}]", "autocompletion": begun}


def _parameter(name: str, annotation: Any, default: Any = inspect.Parameter.empty) -> inspect.Parameter:
    return inspect.Parameter(name, inspect.Parameter.POSITIONAL_OR_KEYWORD, default=default, annotation=annotation)
