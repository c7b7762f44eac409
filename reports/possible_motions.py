"""Where each motion of rule ``box`` is possible under some load, for the terminal and as JSON."""

from __future__ import annotations

from collections.abc import Sequence

from rich.console import Group, RenderableType
from rich.text import Text

from nonsmooth.proofs.clauses.every_load.possible_twists import PossibleTwist
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.terminal import header_table, notes_lines
from nonsmooth.symbolic.number_text import place_text, short_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

DIGITS = 4  # of corners on a terminal
POSSIBLE_SCHEMA = "nonsmooth-possible-motions/1"


def possible_view(scene: Scene, twists: Sequence[PossibleTwist]) -> RenderableType:
    """The twists that are possible on an area, each with the corners of that area; first those at the point."""
    point = scene.check.equilibrium
    areas = [each for each in twists if len(each.corners) > 2]
    areas.sort(key=lambda each: not each.holds(point))
    table = header_table("rows held", "v_x", "v_y", "omega", "at the point", "possible where c lies within")
    for each in areas:
        twist = [Text(short_text(entry)) for entry in each.state.twist]
        corners = ", ".join(place_text([float(x) for x in corner], DIGITS) for corner in each.corners)
        here = "possible" if each.holds(point) else ""
        table.add_row(Text(each.state.name), *twist, Text(here), Text(corners))
    at_point = sum(each.holds(point) for each in twists)
    head = f"{one_line(scene.name)}: {len(areas)} motions under every load, rule box; {at_point} possible at the point"
    thin = len(twists) - len(areas)
    return Group(
        Text(head),
        table,
        *([Text(f"{thin} more are possible along segments or at points only (--json)")] if thin else []),
        Text("every motion under any load on two wheels or more is one of these, or a mean of some"),
        Text("the areas overlap; their corners are exact in --json"),
        *notes_lines(scene.field),
    )


def possible_record(scene: Scene, twists: Sequence[PossibleTwist]) -> Record:
    """The same, with exact numbers, and those that are possible along segments or at points too."""
    point = scene.check.equilibrium
    return {
        "schema": POSSIBLE_SCHEMA,
        "scene": scene.name,
        "rule": "box",
        **with_exact({"at": point}),
        "motions": [
            {
                **with_exact({"twist": each.state.twist, "polygon": each.corners}),
                "rows": each.state.row_names,
                "at_point": each.holds(point),
            }
            for each in twists
        ],
        "notes": list(angle_notes(scene.field)),
    }
