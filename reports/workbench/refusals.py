"""What is wrong with a request, as one message of stage ``error``."""

from __future__ import annotations

import sys
import traceback
from typing import Any

from nonsmooth.analysis.cells.partition import RefusalError
from nonsmooth.analysis.trajectories.result import TrajectoryError
from nonsmooth.reports.workbench.requests import RequestError
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError
from nonsmooth.symbolic.scene_error import SceneError, one_line

FAULT = "a fault of the program: the terminal of the workbench shows where"
TOO_LARGE = "required a scene that fits into memory, received a larger one"


def refusal(error: Exception) -> dict[str, Any]:
    """One clear line, and the key that it is about, if it is about one; a fault is written to the log."""
    match error:
        case SceneError():
            return _message(str(error), error.key.replace("[", ".").replace("]", "") or None)
        case RequestError():
            return _message(str(error), error.key)
        case RefusalError() | TrajectoryError() | WorkLimitError():
            return _message(str(error))
        case MemoryError():
            return _message(TOO_LARGE)
        case RecursionError():
            return _message("required fewer nested brackets")
    traceback.print_exception(error, file=sys.stderr)
    return _message(FAULT)


def _message(text: str, key: str | None = None) -> dict[str, Any]:
    return {"stage": "error", "message": one_line(text), "key": key}
