"""``nonsmooth partition``: the cells of the plane, listed, drawn or compared between the contact rules."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.clauses.at_point.possible_twists import PossibleTwist, possible_twists
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.facts import with_exact
from nonsmooth.reports.output.files import PICTURES
from nonsmooth.reports.output.progress import steps
from nonsmooth.reports.output.refusals import refusals_named
from nonsmooth.reports.output.study_options import Drawing, Options, option
from nonsmooth.reports.output.terminal import later_notes
from nonsmooth.reports.studies.result import DataTable, Result
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.number_field import angle_notes
from nonsmooth.symbolic.numbers.number_text import place_text, short_text

if TYPE_CHECKING:
    from pathlib import Path


@dataclass(frozen=True, kw_only=True)
class PartitionOptions(Options):
    """What is shown of the plane."""

    show: Drawing = option(
        Drawing.CELLS, "What -o draws: the cells, the array of wheels, or V* over the cells (rates)."
    )
    compare: bool = option(False, "Compare all contact rules on the square instead.")


class PartitionStudy(SceneStudy[PartitionOptions]):
    """The cells of an array or of a plain system, or a sampled field."""

    options = PartitionOptions
    files = "Draw them, instead of a table: .svg, .png or .pdf."

    def endings(self, options: PartitionOptions) -> Collection[str]:
        """Pictures."""
        return PICTURES

    def refuse(self, asked: StudyRequest[PartitionOptions], path: Path | None) -> None:
        """Refuse what an array alone has, and to show what is not drawn; cells that unknown loads leave open."""
        if asked.kind is SceneKind.SYSTEM:
            asked.refuse(("show", "compare", "rule"), "an array of wheels", "a plain system")
            return
        if path is None:
            asked.refuse(("show",), "-o FILE, which it draws", "none")
        if asked.options.compare:
            asked.refuse(("show",), "a picture of one contact rule", "--compare")
        elif path is not None and asked.options.show is not Drawing.ARRAY and _leaves_motions_open(asked.scene):
            from nonsmooth.reports.checks.cells import cells_of

            with refusals_named(asked.scene):
                cells_of(asked.scene)  # which says why there are none

    def run(self, scene: Any, options: PartitionOptions) -> Result:
        """Build them."""
        if scene.kind is SceneKind.SYSTEM:
            from nonsmooth.reports.checks.phase_portrait import PhasePortrait

            return PhasePortrait(scene)
        from nonsmooth.symbolic.mechanics.contact_set import TipsError, standing

        try:
            stands = standing(scene)
        except TipsError as tipping:
            if options.show is not Drawing.ARRAY or options.compare:
                raise
            from nonsmooth.reports.checks.check_results import TippedResult

            return TippedResult(scene, tipping, is_drawn=True)
        with refusals_named(stands):
            return _of_array(stands, options)


def _of_array(scene: Scene, options: PartitionOptions) -> Result:
    """The contact rules side by side, the wheels, the cells, or the field of a rule without cells."""
    from nonsmooth.analysis.cells.contact_rule import has_cells

    if options.compare:
        from nonsmooth.reports.checks.agreement import compare_scene

        with steps("comparison of the contact rules"):
            return compare_scene(scene)
    if options.show is Drawing.ARRAY:
        from nonsmooth.reports.checks.cells import WheelsResult

        return WheelsResult(scene)
    if _leaves_motions_open(scene):
        with steps("motions that unknown loads leave possible"):
            return PossibleMotions(scene, possible_twists(scene))
    if not has_cells(scene):
        from nonsmooth.reports.checks.cells import field_of

        with steps(f"field of rule {scene.contact.rule}"):
            return field_of(scene)
    from nonsmooth.reports.checks.cells import cells_of

    with steps(f"cells of rule {scene.contact.rule}"):
        return replace(cells_of(scene), show=options.show)


def _leaves_motions_open(scene: Scene) -> bool:
    """Whether all loads that carry the weight are meant under rule ``box``."""
    from nonsmooth.symbolic.mechanics.load_model import UnknownLoads

    return scene.contact.rule == "box" and scene.contact.loads == UnknownLoads()


PARTITION = PartitionStudy()


# ---- motions that are possible -------------------------------------------------------------------


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
            corners = ", ".join(place_text(corner, DIGITS) for corner in each.corners)
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
            *(f"note: {note}" for note in later_notes(self.scene.field)),
        ]
        rows = table(*self.table(), (1.0, 1.0, 1.0, 1.0, 1.0, 3.0))
        return [*sentences(self.summary()), rows, *sentences(*notes)]

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
