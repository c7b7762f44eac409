"""Where each motion of rule ``box`` is possible under some load."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from nonsmooth.proofs.clauses.every_load.possible_twists import PossibleTwist
from nonsmooth.reports.document import Block, Paragraph, table
from nonsmooth.reports.exact_record import Record, with_exact
from nonsmooth.reports.result import DataTable, Result
from nonsmooth.symbolic.number_text import place_text, short_text
from nonsmooth.symbolic.numbers.measured_angles import angle_notes
from nonsmooth.symbolic.scene import Scene
from nonsmooth.symbolic.scene_error import one_line

DIGITS = 4  # of corners on a terminal
POSSIBLE_SCHEMA = "nonsmooth-possible-motions/1"
COLUMNS = ("rows held", "v_x", "v_y", "omega", "at the point", "possible where c lies within")


@dataclass(frozen=True, repr=False)
class PossibleMotions(Result):
    """The twists that are possible under some load.

    Attributes:
        scene: the array.
        twists: each with the corners of the area, segment or point on which it is possible.
    """

    scene: Scene
    twists: Sequence[PossibleTwist]

    @property
    def areas(self) -> Sequence[PossibleTwist]:
        """Those on an area; first those at the checked point."""
        point = self.scene.check.equilibrium
        return sorted((each for each in self.twists if len(each.corners) > 2), key=lambda each: not each.holds(point))

    def table(self) -> DataTable:
        """One line for each twist on an area."""
        lines = []
        for each in self.areas:
            corners = ", ".join(place_text([float(x) for x in corner], DIGITS) for corner in each.corners)
            here = "possible" if each.holds(self.scene.check.equilibrium) else ""
            lines.append((each.state.name, *map(short_text, each.state.twist), here, corners))
        return DataTable(COLUMNS, lines)

    def blocks(self) -> Sequence[Block]:
        """The table, and what it leaves out."""
        thin = len(self.twists) - len(self.areas)
        more = [f"{thin} more are possible along segments or at points only (--json)"] if thin else []
        notes = [
            *more,
            "every motion under any load on two wheels or more is one of these, or a mean of some",
            "the areas overlap; their corners are exact in --json",
            *(f"note: {note}" for note in angle_notes(self.scene.field)),
        ]
        rows = table(*self.table(), (1.0, 1.0, 1.0, 1.0, 1.0, 3.0))
        return [Paragraph((self.summary(),)), rows, *(Paragraph((note,)) for note in notes)]

    def summary(self) -> str:
        """How many there are."""
        at_point = sum(each.holds(self.scene.check.equilibrium) for each in self.twists)
        head = f"{one_line(self.scene.name)}: {len(self.areas)} motions under every load, rule box"
        return f"{head}; {at_point} possible at the point"

    def facts(self) -> Record:
        """All of them, with exact numbers."""
        point = self.scene.check.equilibrium
        return {
            "schema": POSSIBLE_SCHEMA,
            "scene": self.scene.name,
            "rule": "box",
            **with_exact({"at": point}),
            "motions": [
                {
                    **with_exact({"twist": each.state.twist, "polygon": each.corners}),
                    "rows": each.state.row_names,
                    "at_point": each.holds(point),
                }
                for each in self.twists
            ],
            "notes": list(angle_notes(self.scene.field)),
        }
