"""How the command line shows its help: Typer's plain layout, with a heading for every group of options.

Typer's boxes need Rich's Markdown, syntax and traceback modules, which take longer to import than everything else that
``nonsmooth --help`` does.  The words are the same.
"""

from __future__ import annotations

from typing import Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from nonsmooth.reports.commands.registry import COMMANDS, CommandsOnDemand, command_function

CONTEXT = {"help_option_names": ["-h", "--help"]}
UNWRAPPED = "\b\n"  # before a paragraph whose lines are kept: an example is there to be copied
ESCAPED_BRACKET = "\\["  # older versions of Typer write [default: 1] for Rich, also where it does not print it
ARGUMENTS, OPTIONS, LISTED = "Arguments", "Options", "Commands"


class PlainCommand(TyperCommand):
    """A command whose options are listed under the headings that they name."""

    def format_options(self, ctx: Any, formatter: Any) -> None:
        """Write arguments and options, those without a heading of their own first."""
        sections: dict[str, list[tuple[str, str]]] = {ARGUMENTS: [], OPTIONS: []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx)
            if record is not None:
                usual = ARGUMENTS if parameter.param_type_name == "argument" else OPTIONS
                heading = getattr(parameter, "rich_help_panel", None) or usual
                name, words = record
                sections.setdefault(heading, []).append((name, words.replace(ESCAPED_BRACKET, "[")))
        for heading, records in sections.items():
            if records:
                with formatter.section(heading):
                    formatter.write_dl(records)


class PlainGroup(TyperGroup):
    """All commands, listed from the registry and imported one at a time."""

    def __init__(self, **settings: Any) -> None:
        super().__init__(**{**settings, "commands": CommandsOnDemand(_made)})

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write every command with its summary."""
        with formatter.section(LISTED):
            formatter.write_dl([(name, entry.summary) for name, entry in COMMANDS.items()])


def _made(name: str) -> Any:
    """The command that Typer makes of a function."""
    alone = typer.Typer(add_completion=False, rich_markup_mode=None, context_settings=CONTEXT)
    example = f"{UNWRAPPED}Example: nonsmooth {COMMANDS[name].example}"
    alone.command(name, cls=PlainCommand, epilog=example)(command_function(name))
    return get_command(alone)
