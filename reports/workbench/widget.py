"""``nonsmooth.widget``: the view of the workbench in a notebook, where the package for widgets is there."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from nonsmooth.reports.interface.array import load
from nonsmooth.reports.interface.scene import PythonScene

if TYPE_CHECKING:
    from nonsmooth.reports.interface.array import Array
    from nonsmooth.reports.interface.system import System
    from nonsmooth.reports.workbench.notebook_view import NotebookView

NEEDED = "widget: required anywidget (pip install 'nonsmooth[notebook]'), received a Python without"


def widget(scene: Array | System | str | Path, *, start: tuple[float, ...] | None = None) -> NotebookView:
    """The view of the workbench in a notebook: drag wheels, and cells, answers and paths follow.

    ``.made`` of what it returns is the array as it was dragged, to go on with in Python.

    Args:
        scene: an array or a plain system, the name of a built-in one, or a scene file.
        start: from where a path is followed, ``(x, y, theta)``; more are added by hand.

    Raises:
        ImportError: without the extra ``nonsmooth[notebook]``.
        SceneError: for a scene that cannot be used.
        TypeError: for a vehicle.
    """
    try:
        from nonsmooth.reports.workbench.notebook_view import NotebookView
    except ImportError:
        raise ImportError(NEEDED) from None
    made = load(scene) if isinstance(scene, str | Path) else scene
    if not isinstance(made, PythonScene):
        raise TypeError(f"widget: required an array or a plain system, received {type(made).__name__}")
    return NotebookView(made, starts=[] if start is None else [list(start)])
