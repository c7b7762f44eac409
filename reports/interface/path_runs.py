"""What to simulate, from the keywords of a script."""

from __future__ import annotations

import math
from collections.abc import Sequence

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.reports.choices import LawName, PathMethod
from nonsmooth.reports.simulate import PathRun


def path_run(  # one keyword for each option of the command
    start: Sequence[float],
    until: float,
    *,
    feedback: bool | str = False,
    method: str = "events",
    gain: float = 1.0,
    kinematics: str = "exact",
    width: float = 1e-3,
) -> PathRun:
    """The run; see :meth:`nonsmooth.reports.interface.array.Array.simulate`.

    Raises:
        ValueError: for a start that is no pose, a gain that is not positive, unknown names, and what a method does not
            follow.
    """
    x, y, theta = (float(value) for value in start)
    if not (math.isfinite(gain) and gain > 0):
        raise ValueError(f"gain: required a positive number, received {gain}")
    law = None if feedback is False else LawName.CERTIFIED if feedback is True else LawName(feedback)
    run = PathRun((x, y, theta), until, Kinematics(kinematics), PathMethod(method), law, width, gain)
    if run.law is not None and run.method is PathMethod.DYNAMICS:
        raise ValueError(f"feedback: required method events, hysteresis or smoothed, received {run.method}")
    if run.kinematics is not Kinematics.EXACT and run.method is PathMethod.DYNAMICS:
        raise ValueError(f"kinematics: required exact with method dynamics, received {run.kinematics}")
    return run
