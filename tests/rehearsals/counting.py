"""A toy study with a result and a command: it counts the wheels of an array, or the states of a plain system."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from nonsmooth.proofs.findings import Record
from nonsmooth.reports.output.document import Block, Paragraph, findings
from nonsmooth.reports.output.study_options import Options, option
from nonsmooth.reports.studies.result import FORMATS, DataTable, Result
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.reports.studies.study_command import command
from nonsmooth.symbolic.messages.scene_kind import SceneKind

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes


@dataclass(frozen=True, kw_only=True)
class CountOptions(Options):
    times: int = option(1, "How often each is counted, with --twice no more.", int, metavar="N")
    twice: bool = option(False, "Count twice.", bool, heading="Of arrays")


@dataclass(frozen=True, repr=False)
class CountResult(Result):
    name: str
    count: int

    def facts(self) -> Record:
        return {"schema": "toy-count/1", "scene": self.name, "count": self.count}

    def table(self) -> DataTable:
        return DataTable(("scene", "count", "half"), [(self.name, self.count, None)])

    def draw(self, ax: Axes) -> None:
        ax.bar([self.name], [self.count])

    def blocks(self) -> Sequence[Block]:
        return [Paragraph((f"{self.name}: counted",)), findings([("count", str(self.count))])]

    def summary(self) -> str:
        return f"{self.count} counted"


class Count(SceneStudy[CountOptions]):
    options: ClassVar[type[Any]] = CountOptions
    files: ClassVar[str] = "Where the count goes."

    def endings(self, options: CountOptions) -> Collection[str]:
        return FORMATS

    def refuse(self, asked: StudyRequest[CountOptions], path: Path | None) -> None:
        if asked.kind is SceneKind.SYSTEM:
            asked.refuse(("twice",), SceneKind.ARRAY, SceneKind.SYSTEM)
        if asked.options.twice:
            asked.refuse(("times",), "no --twice", "--twice")

    def run(self, scene: Any, options: CountOptions) -> Result:
        counted = scene.wheels if scene.kind is SceneKind.ARRAY else scene.states
        return CountResult(scene.name, len(counted) * (2 if options.twice else options.times))


count = command(Count(), "count", "Count something.\n\nExit status: 0 done, 2 bad input.")
