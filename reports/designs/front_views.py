"""A Pareto front as a table of a terminal, as JSON and as CSV."""

from __future__ import annotations

import csv
import io
from typing import TYPE_CHECKING

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.reports.designs.named import named_document
from nonsmooth.reports.designs.views import WHAT
from nonsmooth.reports.exact_record import Record
from nonsmooth.reports.terminal import header_table
from nonsmooth.symbolic.number_text import float_text
from nonsmooth.symbolic.scene_error import one_line

if TYPE_CHECKING:
    from nonsmooth.reports.designs.front import Front, FrontPoint
    from nonsmooth.reports.designs.search import Wish
    from nonsmooth.symbolic.scene import Scene

SCHEMA = "nonsmooth-design-front/1"
HOW = "on the front of rate against tolerance"


def front_view(front: Front, scene: Scene) -> RenderableType:
    """The points of the front beside the given array."""
    table = header_table("array", WHAT["rate"], WHAT["tolerance"])
    if front.given is not None:
        table.add_row("given", *_texts(front.given))
    for number, point in enumerate(front.points, 1):
        table.add_row(str(number), *_texts(point))
    return Group(
        Text(front_headline(front, scene)), table, Text("both numbers are proved; that no array is beyond is not")
    )


def front_headline(front: Front, scene: Scene) -> str:
    """What was found, in a line."""
    return f"{one_line(scene.name)}: {len(front.points)} arrays on the front, of {front.checks} checked"


def _texts(point: FrontPoint) -> list[str]:
    return [float_text(point.rate, 4), float_text(point.tolerance, 4)]


def front_record(front: Front, scene: Scene, wish: Wish) -> Record:
    """JSON with the scene of every point."""
    given = None if front.given is None else {"rate": front.given.rate, "tolerance": front.given.tolerance}
    points = [
        {"rate": point.rate, "tolerance": point.tolerance, "scene": named_document(point.document, scene, HOW)}
        for point in front.points
    ]
    return {
        "schema": SCHEMA,
        "required": list(wish.required),
        "seed": wish.seed,
        "checks": front.checks,
        "given": given,
        "points": points,
    }


def front_csv(front: Front) -> bytes:
    """One row for each point, the given array first."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(("array", "rate", "tolerance"))
    if front.given is not None:
        writer.writerow(("given", front.given.rate, front.given.tolerance))
    writer.writerows((number, point.rate, point.tolerance) for number, point in enumerate(front.points, 1))
    return stream.getvalue().encode()
