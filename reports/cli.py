"""The command line: ``nonsmooth`` and its commands, each in a file of ``reports/commands``.

Exit status: 0 holds, done or valid, 1 does not hold, 2 bad input (one line on standard error, nothing written),
3 undecided, 70 a fault of this program (with its traceback), 130 interrupted.  Each command imports what it needs
itself: ``nonsmooth --help`` loads no mathematics, ``check`` no SymPy or Matplotlib, and CVXPY only to search for V.
"""

from __future__ import annotations

import gc
import sys
from typing import Annotated

import typer

from nonsmooth.reports.commands.audit import audit
from nonsmooth.reports.commands.check import check
from nonsmooth.reports.commands.derive import derive
from nonsmooth.reports.commands.partition import partition
from nonsmooth.reports.commands.precision import precision
from nonsmooth.reports.commands.rules import rules
from nonsmooth.reports.commands.scenes import scenes
from nonsmooth.reports.commands.simulate import simulate
from nonsmooth.reports.commands.stress import stress
from nonsmooth.reports.commands.verify import verify
from nonsmooth.reports.console import PROGRAM, own_version, prepare_streams, run, write

# Objects between two searches for cycles: there are few cycles, and a hundred thousand wheels are millions of objects,
# which Python's own threshold of 700 searches again and again for as long as it takes to read them.
GARBAGE_THRESHOLD = 200_000

app = typer.Typer(
    epilog="Example: nonsmooth check four-wheel",
    pretty_exceptions_enable=False,
    context_settings={"help_option_names": ["-h", "--help"]},
)
app.command(epilog="Example: nonsmooth check four-wheel --radius 1/4 --json")(check)
app.command(epilog="Example: nonsmooth partition four-wheel -o cells.svg")(partition)
app.command(epilog="Example: nonsmooth derive four-wheel -o report.html")(derive)
app.command(epilog="Example: nonsmooth simulate four-wheel --from 0.2,0.4,0 --until 2 -o path.svg")(simulate)
app.command(epilog="Example: nonsmooth precision four-wheel --study trajectories -o precision.svg")(precision)
app.command(epilog="Example: nonsmooth verify four-wheel.json")(verify)
app.command(epilog='Example: nonsmooth audit four-wheel --lyapunov "x**2 + 3*y**2"')(audit)
app.command(epilog="Example: nonsmooth stress four-wheel -o stress.svg")(stress)
app.command(epilog="Example: nonsmooth scenes")(scenes)
app.command(epilog="Example: nonsmooth rules")(rules)


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
    prepare_streams()
    gc.set_threshold(GARBAGE_THRESHOLD)
    sys.exit(run(app, sys.argv[1:]))


if __name__ == "__main__":
    main()
