"""``nonsmooth equilibria``: all places of rest of a plain system in the checked square, and what each of them is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from shlex import quote
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.decided_places import decided_places
from nonsmooth.proofs.findings import Record, Translation
from nonsmooth.proofs.rest_places import EnclosedEquilibria, EnclosedEquilibrium
from nonsmooth.proofs.rest_polytopes import RestKind, RestPolytope
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.facts import floats, with_exact
from nonsmooth.reports.output.refusals import RefusedError, refusals_named
from nonsmooth.reports.output.study_options import Options
from nonsmooth.reports.studies.result import DataTable, Result
from nonsmooth.reports.studies.study import SceneStudy, StudyRequest
from nonsmooth.symbolic.messages.scene_error import one_line
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.number_text import exact_place, place_text

if TYPE_CHECKING:
    from pathlib import Path

    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from nonsmooth.symbolic.systems.switched_system import SwitchedSystem

SCHEMA = "nonsmooth-equilibria/1"
SIZE = 6.4  # inches
STRETCHES = {
    RestKind.CELL: "every place of it rests",
    RestKind.SLIDING: "every place of it rests, and both fields lead to it",
    RestKind.REPELLING: "every place of it rests, and both fields lead away from it",
    RestKind.BOUNDARY: "every place of it rests, on a surface",
    RestKind.CORNER: "every place of it rests, where surfaces meet",
}
MARKERS: dict[Translation, Record] = {
    Translation.ASYMPTOTICALLY_STABLE: {"marker": "o", "color": "black", "label": "asymptotically stable"},
    Translation.STABLE: {"marker": "o", "color": "black", "fillstyle": "bottom", "label": "stable"},
    Translation.UNSTABLE: {"marker": "o", "color": "black", "fillstyle": "none", "label": "unstable"},
    Translation.UNDECIDED: {"marker": "x", "color": "black", "label": "undecided"},
}


@dataclass(frozen=True, repr=False)
class EquilibriaResult(Result):
    """The places of rest of a plain system.

    Attributes:
        system: the system.
        found: the places.
        verdicts: the stability of each, and the theorem that decides it.
    """

    system: SwitchedSystem
    found: EnclosedEquilibria
    verdicts: tuple[tuple[Translation, str], ...]

    def facts(self) -> Record:
        """The JSON record."""
        head = {"schema": SCHEMA, "scene": self.system.name, "states": list(self.system.states)}
        about = with_exact({"at": self.system.check.equilibrium, "radius": self.system.check.radius})
        stretches = [
            {**dict(zip(("from", "to"), self._corners(part), strict=True)), "kind": part.kind.name.lower()}
            for part in self._segments
        ]
        polytopes = [{"corners": self._corners(part), "kind": part.kind.name.lower()} for part in self._polytopes]
        left = [[floats((x.lower(), x.upper())) for x in box] for box in self.found.left]
        more = {"polytopes": polytopes} if polytopes else {}
        return {**head, **about, "places": self.rows(), "stretches": stretches, **more, "left": left}

    @property
    def _segments(self) -> list[RestPolytope]:
        return [part for part in self.found.stretches if part.dimension == 1]

    @property
    def _polytopes(self) -> list[RestPolytope]:
        return [part for part in self.found.stretches if part.dimension > 1]

    def _corners(self, part: RestPolytope) -> list[list[float]]:
        return list(map(self._stated, part.corners))

    def _stated(self, displacement: Sequence[Any]) -> list[float]:
        """A displacement as a place."""
        return [float(a + c) for a, c in zip(displacement, self.system.check.equilibrium, strict=True)]

    def table(self) -> DataTable:
        """A line for each place."""
        lines = []
        for place, (stability, by) in zip(self.found.places, self.verdicts, strict=True):
            exact = None if place.exact is None else exact_place(place.exact)
            error = max(float(x.rad()) for x in place.place)
            what = place.shape or None
            numbers = [float(x) for x in place.exact or place.place]
            on = "; ".join(place.surfaces) or None
            lines.append((*numbers, error, exact, str(place.kind), on, what, str(stability), by or None))
        names = ("error", "exact", "where", "surfaces", "shape", "stability", "by")
        return DataTable((*self.system.states, *names), lines)

    def blocks(self) -> Sequence[Block]:
        """The places, stretches, and what is left."""
        return [*sentences(self._head()), *self._tables(), *sentences(*self._open(), *self._undecided())]

    def _head(self) -> str:
        return f"{one_line(self.system.name)}: plain switched system in {', '.join(self.system.states)}"

    def _tables(self) -> list[Block]:
        rows = [
            (_place(place), " ".join(filter(None, (place.shape, _where(place)))), f"{stability}", by)
            for place, (stability, by) in zip(self.found.places, self.verdicts, strict=True)
        ]
        blocks: list[Block] = [table(("place of rest", "what", "stability", "by"), rows)] if rows else []
        lines = [
            (*(place_text(corner, 6) for corner in self._corners(part)), STRETCHES[part.kind])
            for part in self._segments
        ]
        blocks += [table(("from", "to", "segment"), lines)] if lines else []
        areas = [
            (", ".join(place_text(corner, 6) for corner in self._corners(part)), STRETCHES[part.kind])
            for part in self._polytopes
        ]
        return [*blocks, table(("corners", "polytope"), areas)] if areas else blocks

    def _open(self) -> list[str]:
        """How much is known to be all."""
        half = float(self.system.check.radius)
        square = f"within {half:.6g} of {place_text(self.system.check.place)} in each state"
        said = "No other place rests" if self.found.places or self.found.stretches else "No place rests"
        if not self.found.left:
            return [f"{said} {square}."]
        first = self.found.left[0]
        near, count = place_text([float(x) for x in first], 4), len(self.found.left)
        where = f"a small box about {near}" if count == 1 else f"{count} small boxes, one of them about {near}"
        return [f"{said} {square} outside of {where}, of which that is not known."]

    def _undecided(self) -> list[str]:
        """What can be asked about the first place whose stability is open."""
        open_places = (
            place
            for place, (stability, _) in zip(self.found.places, self.verdicts, strict=True)
            if stability is Translation.UNDECIDED
        )
        for place in open_places:
            if place.exact is None:
                return [
                    f"Undecided {_place(place)}: its coordinates are not simple, so only its linearization is asked."
                ]
            at = _place(place).strip("()").replace(" ", "")
            return [f"Undecided {_place(place)}: nonsmooth check {quote(self.system.origin)} --at {at} says more."]
        return []

    def summary(self) -> str:
        """How many places."""
        count, stretches, left = map(len, (self.found.places, self._segments, self.found.left))
        said = [f"{count} place{'s' * (count != 1)} of rest"]
        said += [f"{stretches} stretch{'es' * (stretches != 1)}"] * bool(stretches)
        areas = len(self._polytopes)
        said += [f"{areas} polytope{'s' * (areas != 1)}"] * bool(areas)
        return ", ".join([*said, *[f"{left} boxes left open"] * bool(left)])

    @property
    def exit_status(self) -> int:
        """0, or 3 where boxes are left."""
        return 3 if self.found.left else 0

    def draw(self, ax: Axes) -> None:
        """The places over the field.

        Raises:
            TypeError: for more than two states.
        """
        if not self.system.is_planar:
            raise TypeError("required two states, to draw places of rest")
        import numpy as np
        from scipy.spatial import ConvexHull

        from nonsmooth.reports.checks.phase_portrait import PhasePortrait

        PhasePortrait(self.system).draw_field(ax)
        centre = self.system.check.place
        for axis, middle in zip((ax.xaxis, ax.yaxis), centre, strict=True):  # the field is drawn from the checked point
            axis.set_major_formatter(partial(_moved, middle))
        for number, part in enumerate(self._polytopes):
            corners = np.array([[float(coordinate) for coordinate in corner] for corner in part.corners])
            label = "_" if number else "area of rest"
            ax.fill(*corners[ConvexHull(corners).vertices].T, color="black", alpha=0.4, zorder=4, label=label)
        for number, part in enumerate(self._segments):
            ends = [[float(end[k]) for end in part.corners] for k in (0, 1)]
            label = "_" if number else "stretch of rest"
            ax.plot(*ends, color="black", linewidth=5, solid_capstyle="round", zorder=5, label=label)
        shown = set[Translation]()
        for place, (stability, _) in zip(self.found.places, self.verdicts, strict=True):
            x, y = (float(a) - c for a, c in zip(place.place, centre, strict=True))
            style = {**MARKERS[stability], "label": "_"} if stability in shown else MARKERS[stability]
            ax.plot([x], [y], **style, linestyle="none", zorder=6)
            shown.add(stability)

    def figure(self) -> Figure:
        """The picture with a legend."""
        from nonsmooth.reports.figures.style import legend_below, new_figure, title_figure

        figure = new_figure(SIZE, SIZE * 1.12)
        self.draw(figure.add_subplot())
        legend_below(figure, columns=3, fontsize="small")
        title_figure(figure, f"{one_line(self.system.name)}: {self.summary()}")
        return figure


def _moved(middle: float, value: float, _: int | None) -> str:
    """The label of a displacement, as a coordinate."""
    return f"{middle + value:.4g}"


def _place(place: EnclosedEquilibrium) -> str:
    """Coordinates, exact where they are simple."""
    if place.exact is not None:
        return exact_place(place.exact)
    return place_text([float(x) for x in place.place], 9)


def _where(place: EnclosedEquilibrium) -> str:
    return f"{place.kind}{': ' * bool(place.surfaces)}{', '.join(place.surfaces)}"


class Equilibria(SceneStudy[Options]):
    """Finds all places of rest of a plain system in the square, or cube, about the checked point."""

    options = Options
    files = "Write them: .csv, .json, .parquet, or of two states a picture, .svg, .png or .pdf."

    def refuse(self, asked: StudyRequest[Options], path: Path | None) -> None:
        """Refuse arrays, whose places of rest a check lists."""
        if asked.kind is not SceneKind.SYSTEM:
            raise RefusedError(
                f"{asked.scene.source}: required a plain system, received another scene; of arrays check lists other "
                "places of rest, and check --at auto chooses one"
            )

    def run(self, scene: Any, options: Options) -> Result:
        """Find them."""
        with refusals_named(scene):
            found, decided = decided_places(scene)
        return EquilibriaResult(scene, found, tuple((place.stability, place.theorem) for place in decided))


EQUILIBRIA = Equilibria()
