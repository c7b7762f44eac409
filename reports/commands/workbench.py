"""``nonsmooth workbench``: a local page on which an array is a thing in the hand."""

from __future__ import annotations

from contextlib import suppress
from typing import Annotated

import typer

from nonsmooth.reports.output.console import broken_pipes_raised, write
from nonsmooth.reports.output.refusals import RefusedError
from nonsmooth.reports.output.study_options import complete_scene

NEEDED = "workbench: required starlette and uvicorn (pip install 'nonsmooth[workbench]'), received a Python without"

Scene = Annotated[
    str | None,
    typer.Argument(metavar="[SCENE]", help="A scene file (TOML) or a built-in name.", autocompletion=complete_scene),
]
Port = Annotated[
    int | None, typer.Option("--port", metavar="N", min=0, max=65535, help="Port on this machine; 0 for any free one.")
]
NoBrowser = Annotated[bool, typer.Option("--no-browser", help="Do not open a browser; the address is printed.")]


def workbench(scene: Scene = None, port: Port = None, no_browser: NoBrowser = False) -> int:
    """Open the workbench: a local page to drag wheels, turn rims and slide friction, with answers within a blink.

    Exit status: 0 closed, 2 bad input.
    """
    try:
        from nonsmooth.reports.workbench.app import HOST, Settings, listening, own_token, run
    except ImportError:
        raise RefusedError(NEEDED) from None
    if scene is not None:
        _require_usable(scene)
    try:
        listener = listening(port)
    except OSError as error:
        raise RefusedError(f"--port: required a free port, received {port} ({error.strerror})") from None
    number, token = listener.getsockname()[1], own_token()
    address = f"http://{HOST}:{number}/?token={token}"
    write(f"{address}\n")
    _flush()
    if not no_browser:
        import webbrowser

        webbrowser.open(address)
    with broken_pipes_raised(), suppress(KeyboardInterrupt):  # Ctrl-C is how a user closes it
        run(listener, Settings(token, number, scene=scene))
    return 0


def _require_usable(scene: str) -> None:
    """Refuse a scene here, with one line.

    Raises:
        SceneError: for whatever cannot be used.
        RefusedError: for a vehicle, and for too many wheels.
    """
    from nonsmooth.reports.workbench.documents import document_of
    from nonsmooth.reports.workbench.requests import RequestError

    try:
        document_of(scene)
    except RequestError as error:
        raise RefusedError(f"{scene}: {error}") from None


def _flush() -> None:
    """Print the address now: whoever reads it through a pipe waits for it."""
    import sys

    if sys.stdout is not None:
        sys.stdout.flush()
