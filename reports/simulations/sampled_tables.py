"""Tables drawn within the tolerances, beside what is proved for all of them: how far from the point bodies end.

``95 % of 200 tables end within 7.7 mm (sampled, seed 1); certified: within 9.4 mm``.  The places of rest are sampled
(:mod:`nonsmooth.analysis.bodies.sampled_tables`); what is certified is the answer about tolerances of a check
(:mod:`nonsmooth.proofs.robust.decide`), printed beside it and never mixed with it.  Each tolerance is drawn alone too,
with the same draws: that which moves the end farthest binds.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from nonsmooth.analysis.bodies.sampled_tables import SampledTables, sample_tables, why_not_sampled
from nonsmooth.proofs.answers.answer import at_least, at_most
from nonsmooth.proofs.answers.answers import WORDS
from nonsmooth.proofs.findings import Record
from nonsmooth.reports.figures.style import INK, figure_with_legend, length_label, title_axes
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.facts import floats
from nonsmooth.reports.output.progress import steps
from nonsmooth.reports.output.refusals import OptionError
from nonsmooth.reports.simulations.path_ends import accuracy_text, sampled_record
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.mechanics.contact_set import accuracy_at_point
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact, one_line
from nonsmooth.symbolic.numbers.number_text import float_text
from nonsmooth.symbolic.numbers.plane import in_floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.proofs.robust.decide import Robust

SCHEMA = "nonsmooth-tables/1"
SHARE = 0.95
MOST = 100_000
FRICTION, GEOMETRY = ("mu_roll", "mu_side"), ("position", "heading")


@dataclass(frozen=True, repr=False)
class SampledTablesResult(Result):
    """Where bodies end on tables within the tolerances.

    Attributes:
        scene: with tolerances.
        seed: of the draws.
        all: all tolerances at once.
        groups: friction and geometry, where several tolerances of a group are stated and others beside it.
        alone: each tolerance alone.
        certified: what is proved for every table; None where it is not asked for.
    """

    scene: Scene
    seed: int
    all: SampledTables
    groups: tuple[SampledTables, ...]
    alone: tuple[SampledTables, ...]
    certified: Robust | None

    @property
    def accuracy(self) -> float:
        """How near a body must come (length)."""
        return float(accuracy_at_point(self.scene))

    @property
    def near(self) -> int:
        """On how many tables bodies end within the accuracy, at a place of rest that attracts."""
        return int((self.all.distances <= self.accuracy).sum())

    @property
    def binding(self) -> str | None:
        """The tolerance that alone moves the end farthest (95 % of the tables); None where ends are not found."""
        farthest = max(self.alone, key=lambda one: one.moved(SHARE))
        return farthest.names[0] if math.isfinite(farthest.moved(SHARE)) else None

    def facts(self) -> Record:
        """JSON with stable keys; what is certified has a record of its own."""
        proved = self.certified
        radius = None if proved is None else proved.radius or proved.equilibrium
        certified = None if proved is None else {"verdict": str(proved.verdict), "radius": floats(radius)}
        return {
            **sampled_record(SCHEMA, self.scene),
            "seed": self.seed,
            "tables": len(self.all.places),
            "share": SHARE,
            "within": floats(self.all.within(SHARE)),
            "farthest": floats(self.all.within(1.0)),
            "missing": self.all.missing,
            "accuracy": self.accuracy,
            "near": self.near,
            "binding": self.binding,
            "parts": [_record(one) for one in (self.all, *self.groups, *self.alone)],
            "certified": certified,
            "rows": floats(self.all.places.tolist()),
        }

    def table(self) -> DataTable:
        """One line for each table: its place of rest and its distance from the point; None where there is none."""
        rows = np.column_stack([self.all.places, self.all.distances]).tolist()
        return DataTable(("x", "y", "distance"), floats(rows))

    def summary(self) -> str:
        """The sample, and what is certified."""
        count, unit = len(self.all.places), self.scene.units.after_length
        within = self.all.within(SHARE)
        head = f"{100 * SHARE:g} % of {count} tables end within {float_text(within, 3)}{unit}"
        if math.isinf(within):
            head = f"of {self.all.missing} of {count} tables no place of rest that attracts was found"
        head += f" (sampled, seed {self.seed})"
        counted = f"{self.near} of {count} within the accuracy, {accuracy_text(self.scene)}"
        return f"{head}; {counted}; {self._certified(unit)}"

    def _certified(self, unit: str) -> str:
        proved = self.certified
        if proved is None:
            return "certified: not asked for (--certified)"
        if proved.radius is not None and proved.start is not None:
            return (
                f"certified: within {at_most(proved.radius)}{unit}, from anywhere within {at_least(proved.start)}{unit}"
            )
        if proved.equilibrium is not None:
            return f"certified: one equilibrium within {at_most(proved.equilibrium)}{unit}, for starts close to it"
        return f"certified: nothing ({proved.reason or proved.verdict})"

    def blocks(self) -> Sequence[Block]:
        """The sentence, each tolerance alone, and what binds."""
        unit, count = self.scene.units.after_length, len(self.all.places)
        head = f"{one_line(self.scene.name)}, rule {self.scene.contact.rule}: {count} tables within the tolerances"
        how = "each number of each wheel evenly within its tolerance; bodies without inertia, at the checked heading"
        rows = []
        for one in (self.all, *self.groups, *self.alone):
            what = "all" if one is self.all else " and ".join(WORDS[name] for name in one.names)
            numbers = (one.moved(SHARE), one.within(SHARE), one.within(1.0))
            rows.append([what, *(_text(number, unit) for number in numbers), str(one.missing)])
        names = ("drawn", "end moves (95 %)", "from the point (95 %)", "farthest", "not found")
        lines = [f"{head} ({how})", self.summary()]
        shown = table(names, rows, (1.6, 1.0, 1.1, 0.9, 0.6))
        return [*sentences(*lines), shown, *sentences(self._binds())]

    def _binds(self) -> str:
        """Which tolerance binds, and how much farther it moves the end than the next."""
        if self.binding is None:
            return "which tolerance binds is not known: the ends of too many tables are not found"
        ordered = sorted(self.alone, key=lambda one: -one.moved(SHARE))
        said = f"the tolerance of {WORDS[self.binding]} binds"
        if len(ordered) > 1 and ordered[1].moved(SHARE) > 0:
            times = float_text(ordered[0].moved(SHARE) / ordered[1].moved(SHARE), 2)
            said += f": alone it moves the end {times} times as far as {WORDS[ordered[1].names[0]]} alone"
        return f"{said} (sampled ends; what binds the certified bound, and may be another, check says)"

    def draw(self, ax: Axes) -> None:
        """The places of rest about the checked point, the circle within which 95 % end, and that of the accuracy."""
        from matplotlib.patches import Circle

        unit, center = self.scene.units.after_length, in_floats(self.all.point)
        count, missing = len(self.all.places), self.all.missing
        ends = f"ends of {count - missing} of {count} (sampled)" if missing else "ends (sampled)"
        ax.plot(*self.all.places.T, ".", color="#0072B2", markersize=4, label=ends)
        ax.plot(*center, "+", color=INK, markersize=12, label="checked point")
        within = {"95 % of them": (self.all.within(SHARE), "#D55E00", "-"), "accuracy": (self.accuracy, INK, "--")}
        for what, (radius, color, dashes) in within.items():
            if math.isfinite(radius):
                label = f"{what}: within {float_text(radius, 3)}{unit}"
                ax.add_patch(Circle(center, radius, fill=False, color=color, linestyle=dashes, label=label))
        ax.set_aspect("equal", adjustable="datalim")
        ax.set_xlabel(length_label("x", self.scene.units))
        ax.set_ylabel(length_label("y", self.scene.units))
        title_axes(ax, f"{one_line(self.scene.name)}: {count} tables")

    def figure(self) -> Figure:
        """The same with a legend below, which covers no end."""
        return figure_with_legend(self.draw)

    def __repr__(self) -> str:
        parts = [(" and ".join(one.names), _text(one.moved(SHARE), "")) for one in self.alone]
        return short_lines(f"{self.scene.name}: {self.summary()}", parts)


def _record(one: SampledTables) -> Record:
    numbers = {"moved": one.moved(SHARE), "within": one.within(SHARE), "farthest": one.within(1.0)}
    return {"drawn": list(one.names), "missing": one.missing} | {key: floats(x) for key, x in numbers.items()}


def _text(value: float, unit: str) -> str:
    return f"{float_text(value, 3)}{unit}" if math.isfinite(value) else "not known"


def draw_tables(scene: Scene, options: SimulateOptions) -> SampledTablesResult:
    """Draw tables within the tolerances of a scene, all at once and each tolerance alone.

    Raises:
        OptionError: for a number of tables that cannot be drawn, and a seed that draws none.
        SceneError: for a scene without tolerances, and a rule or an entry that is not followed.
        ValueError: where no place of rest of the table as drawn is found.
    """
    count = options.tables or 0
    if not 1 <= count <= MOST:
        raise OptionError(f"--tables: required 1 to {MOST} tables, received {count}")
    if options.seed < 0:
        raise OptionError(f"--seed: required a number of at least 0, received {options.seed}")
    refused = why_not_sampled(scene)
    if refused or scene.tolerances is None:
        raise SceneError(
            scene.origin, "tolerance", "tolerances of wheels, under rule ellipse or roller", StatedFact(refused)
        )
    names = scene.tolerances.names
    groups = [
        members for group in (FRICTION, GEOMETRY) if len(members := [name for name in group if name in names]) > 1
    ]
    if any(len(members) == len(names) for members in groups):
        groups = []

    def drawn(chosen: Sequence[str]) -> SampledTables:
        with steps(" and ".join(WORDS[name] for name in chosen)):
            return sample_tables(scene, count, options.seed, chosen)

    found = drawn(names)
    parts, alone = tuple(map(drawn, groups)), tuple(drawn([name]) for name in names)
    certified = None
    if options.certified:
        from nonsmooth.proofs.robust.decide import decided_statement

        with steps("certified"):
            certified = decided_statement(scene)
    return SampledTablesResult(scene, options.seed, found, parts, alone, certified)
