"""Running the command line as a well-behaved program: streams, one-line errors, exit status."""

from __future__ import annotations

import os
import re
import signal
import sys
import threading
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, TextIO

import typer

from nonsmooth.reports.output.files import OutputError
from nonsmooth.reports.output.progress import end_progress, steps
from nonsmooth.reports.output.refusals import RefusedError
from nonsmooth.symbolic.messages import removed
from nonsmooth.symbolic.messages.scene_error import SceneError, one_line

if TYPE_CHECKING:
    from rich.console import RenderableType


PROGRAM = "nonsmooth"
# Typer's own errors of usage; before Typer 0.27.3 they are Click's, the second base of this one.
USAGE_ERROR: Any = getattr(typer, "TyperException", typer.BadParameter.__mro__[2])
MAX_WORD = 200  # characters of what was typed that a line of usage repeats
BAD_INPUT, UNDECIDED, FAULT, INTERRUPTED = 2, 3, 70, 130
# What is required, by the kind of what cannot be read as one: as newer versions of Typer tell it, then as Click does.
WHOLE, ANY = "a whole number", "a number"
NUMBERS = {"int_parsing": WHOLE, "float_parsing": ANY, "integer": WHOLE, "float": ANY}
NO_NUMBER = re.compile(r"'(.*)' is not a valid (integer|float)\.?")  # Click's words


def prepare_streams() -> None:
    """Let a closed pipe end the program quietly, and print what the terminal's encoding cannot hold as ``?``."""
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_DFL)
    for stream in (sys.stdout, sys.stderr):
        if stream is not None and hasattr(stream, "reconfigure"):
            stream.reconfigure(errors="replace")


@contextmanager
def broken_pipes_raised() -> Iterator[None]:
    """Let a pipe to a process that died be an error of the call, while there are such processes.

    Only the main thread may say so; elsewhere, and in a Python that did not call :func:`prepare_streams`, it is so.
    """
    if not hasattr(signal, "SIGPIPE") or threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGPIPE, before)


def run(app: Callable[..., Any], arguments: Sequence[str]) -> int:
    """Run a Typer application and return the exit status; bad input is one line on standard error.

    Work that lasts shows a line of progress, which names the command.
    """
    try:
        with steps(arguments[0] if arguments else PROGRAM, log=True):
            status = app(args=list(arguments), prog_name=PROGRAM, standalone_mode=False)
        if sys.stdout is not None:
            sys.stdout.flush()
    except (SceneError, OutputError, RefusedError) as error:
        return _refuse(str(error))
    except USAGE_ERROR as error:
        return _refuse(_usage_line(error))
    except KeyboardInterrupt:
        return INTERRUPTED
    except OSError as error:
        _drop(sys.stdout)
        return _refuse(f"standard output: required a stream that can be written, received the error {error.strerror!r}")
    except Exception as error:
        return _report_fault(error)
    return status if isinstance(status, int) else 0


def _report_fault(error: Exception) -> int:
    """A traceback; of a law and a path that contradict each other both sides on one line: then nothing is decided."""
    from nonsmooth.proofs.findings import ContradictionError

    if isinstance(error, ContradictionError):
        print(f"{PROGRAM}: {one_line(str(error))}", file=sys.stderr)
        return UNDECIDED
    traceback.print_exception(error)
    return FAULT


def _refuse(message: str) -> int:
    """Say it on one line, where that can be written; the exit status says it anyhow."""
    try:
        print(f"{PROGRAM}: {one_line(message)}", file=sys.stderr, flush=True)
    except OSError:
        _drop(sys.stderr)
    return BAD_INPUT


def _usage_line(error: Any) -> str:
    """Typer's message on one line, with the place where help is; of what was removed, what to do without."""
    words = error.format_message().removesuffix(".").replace("Value error, ", "").split()
    message = " ".join(word if len(word) <= MAX_WORD else f"{word[:MAX_WORD]}..." for word in words)
    context = getattr(error, "ctx", None)
    instead = _instead(message, "" if context is None else context.info_name, getattr(error, "option_name", ""))
    if instead is not None:
        return instead
    misread = _misread(error)
    if misread is not None:
        return misread
    command = PROGRAM if context is None else context.command_path
    return f"{message}; see '{command} --help'"


def _misread(error: Any) -> str | None:
    """A value that is no number, in our own words where Typer leaves it to the words of a library."""
    found: list[Any] = getattr(error.__cause__, "errors", list)()
    worded, parameter = NO_NUMBER.fullmatch(str(getattr(error, "message", ""))), getattr(error, "param", None)
    kind, value = (found[0]["type"], str(found[0]["input"])) if found else ("", "")
    if worded is not None:
        value, kind = worded.groups()
    if kind not in NUMBERS or parameter is None:
        return None
    return f"{max(parameter.opts, key=len)}: required {NUMBERS[kind]}, received {value[:60]!r}"


def _instead(message: str, command: str, option: str) -> str | None:
    """What to do without a removed option, command or argument, if Typer did not take one."""
    if (command, option) in removed.OPTIONS:
        return f"{option} was removed: {removed.OPTIONS[command, option]}"
    if command in removed.ARGUMENTS and message.startswith(("Missing argument", "Got unexpected extra argument")):
        return f"{command}: required {removed.ARGUMENTS[command]}"
    unknown = (name for name in removed.COMMANDS if message.startswith(f"No such command '{name}'"))
    name = next(unknown, None)
    return None if name is None else f"the command {name} was removed: {removed.COMMANDS[name]}"


def _drop(stream: TextIO) -> None:
    """Send what is still buffered nowhere: writing it again at exit would fail again."""
    null = os.open(os.devnull, os.O_WRONLY)
    os.dup2(null, stream.fileno())
    os.close(null)


def write(text: str) -> None:
    """Write text to standard output as it is; the line of progress ends before it."""
    end_progress()
    sys.stdout.write(text)


def write_json(record: dict[str, Any]) -> None:
    """Write a record to standard output."""
    write(json_text(record))


def json_text(record: dict[str, Any]) -> str:
    """A record as indented JSON, ending in a newline; ASCII only, so that any terminal and file can hold it."""
    import json

    return json.dumps(record, indent=2, allow_nan=False) + "\n"


def write_views(views: Iterable[RenderableType]) -> None:
    """Print Rich views: as wide as the terminal, 80 columns elsewhere, colors on a terminal only."""
    from rich.console import Console

    end_progress()
    console = Console(markup=False, highlight=False, emoji=False)
    for k, view in enumerate(views):
        if k:
            console.print()
        console.print(view)


def own_version() -> str:
    """Version of the installed distribution."""
    from importlib.metadata import PackageNotFoundError, version

    try:
        return version(PROGRAM)
    except PackageNotFoundError:
        return "(not installed)"
