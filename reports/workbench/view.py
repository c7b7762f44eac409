"""The view of a scene in stages: first what shows, then what is proved, then paths, tolerances and the other rules."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from nonsmooth.reports.interface.array import Array
from nonsmooth.reports.workbench.array_view import array_stages
from nonsmooth.reports.workbench.documents import opened
from nonsmooth.reports.workbench.requests import RequestError, read_request
from nonsmooth.reports.workbench.system_view import system_stages

MAX_STARTS = 20


def view(body: bytes, announce: Callable[[str], None]) -> Iterator[dict[str, Any]]:
    """The stages of one request, in the order of the wish: fast, exact, paths, tolerance, comparison, done.

    Raises:
        RequestError: for a request that lacks something, or has it in another form.
        SceneError: for a scene that cannot be used.
        RefusalError: where the motion is not determined.
    """
    request = read_request(body)
    sequence, document = request.get("sequence"), request.get("document")
    if not isinstance(sequence, int) or not isinstance(document, dict):
        raise RequestError("request: required the keys sequence (an integer) and document (a table)")
    made = opened(document)
    stages = array_stages if isinstance(made, Array) else system_stages
    for stage in stages(made, request, announce):  # type: ignore[operator]
        yield {"sequence": sequence, **stage}
        announce("")
    yield {"sequence": sequence, "stage": "done"}
