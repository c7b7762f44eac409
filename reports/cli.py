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
from typing import Annotated

import typer

from nonsmooth.reports.help import CONTEXT, PlainGroup
from nonsmooth.reports.output.console import PROGRAM, own_version, prepare_streams, run, write

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
