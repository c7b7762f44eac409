"""The command line: ``nonsmooth`` and its commands, each in a file of ``reports/commands``.

Exit status: 0 holds, done or valid, 1 does not hold, 2 bad input (one line on standard error, nothing written),
3 undecided, 70 a fault of this program (with its traceback), 130 interrupted.  Commands are imported when they run
(:mod:`nonsmooth.reports.commands.registry`), and each imports what it needs itself: ``nonsmooth --help`` loads no
command, ``check`` no SymPy or Matplotlib, and CVXPY only to search for V.
"""

from __future__ import annotations

import gc
import os
import sys
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_command

from nonsmooth.reports.commands.registry import COMMANDS, CommandsOnDemand, command_function
from nonsmooth.reports.output.console import PROGRAM, own_version, prepare_streams, run, write

# ---- how help is shown ---------------------------------------------------------------------------
#
# How the command line shows its help: Typer's plain layout, with a heading for every group of options.
#
# Typer's boxes need Rich's Markdown, syntax and traceback modules, which take longer to import than everything else
# that ``nonsmooth --help`` does. The words are the same.


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


# ---- the program ---------------------------------------------------------------------------------


# Objects between two searches for cycles: there are few cycles, and a hundred thousand wheels are millions of objects,
# which Python's own threshold of 700 searches again and again for as long as it takes to read them.
GARBAGE_THRESHOLD = 200_000

app = typer.Typer(
    cls=PlainGroup,
    epilog="Example: nonsmooth check four-wheel",
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
    context_settings=CONTEXT,
)


def _show_version(wanted: bool) -> None:
    if wanted:
        write(f"{PROGRAM} {own_version()}\n")
        raise typer.Exit(0)


@app.callback()
def options(
    version: Annotated[
        bool, typer.Option("--version", callback=_show_version, is_eager=True, help="Show the version and exit.")
    ] = False,
) -> None:
    """Stability of planar arrays of driven wheels and of switched systems, with exact certificates or witnesses.

    Exit status: 0 holds or done, 1 does not hold, 2 bad input, 3 undecided.
    """


def main() -> None:
    """Entry point of the ``nonsmooth`` command."""
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # read when NumPy is loaded: our matrices are too small for more
    # We use no plugins of Pydantic, and it would read the metadata of all installed packages to look for some.
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")
    prepare_streams()
    gc.set_threshold(GARBAGE_THRESHOLD)
    try:
        sys.exit(run(app, sys.argv[1:]))
    finally:
        gc.freeze()  # what the process leaves behind is not searched for cycles: that takes a sixth of a whole check


if __name__ == "__main__":
    main()
