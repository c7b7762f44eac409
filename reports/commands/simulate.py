"""``nonsmooth simulate``: Filippov solutions, with events and what is not unique about them; maps of their ends."""

from __future__ import annotations

from nonsmooth.reports.simulations.simulate import SIMULATE
from nonsmooth.reports.studies.study_command import command

simulate = command(
    SIMULATE,
    "simulate",
    """Follow a Filippov solution or a body with mass, map where many starts end, or find a periodic orbit.

    Exit status: 0 done, 2 bad input, 3 where paths contradict what is proved.
    """,
)
