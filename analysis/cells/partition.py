"""Cells of the plane with one motion each, and the partition of the checked square they form."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from itertools import tee
from typing import TYPE_CHECKING

from flint import arb

from nonsmooth.analysis.cells.polygon import Point, Polygon
from nonsmooth.symbolic.mechanics.contact_states import ContactState, Row, Twist, free_text, independent, kernel
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr, html_table
from nonsmooth.symbolic.numbers.lazy import Lazy, evaluated
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import brief_text
from nonsmooth.symbolic.numbers.rounded import counted
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, work_limit

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.cell_complex import CellComplex

# An exact area divides by sums of up to 2^4 terms for each vertex; with more square roots that takes minutes.
AREA_ROOTS = 4
PARTITION_UNITS = 10_000_000  # of exact arithmetic for the cells: half a minute or so


class RefusalError(ValueError):
    """A scene that is not followed further: its motion is not determined, or the work would be too much.

    The message names key, requirement and what was received.
    """


@contextmanager
def affordable(scene: Scene, units: int, step: str) -> Iterator[None]:
    """Limit the exact arithmetic of a step.

    Raises:
        RefusalError: where the step goes beyond it.
    """
    try:
        with work_limit(scene.field, units):
            yield
    except WorkLimitError:
        roots = len(scene.field.radicands)
        raise RefusalError(
            f"wheels: required an array with {step} within {units // 1_000_000} million exact operations, "
            f"received one beyond that: {len(scene.wheels)} wheels, numbers over {roots} square roots "
            "(a smaller --radius takes fewer)"
        ) from None


@dataclass(frozen=True, repr=False)
class Cell(ShortRepr):
    """A convex polygon of centres of mass that share their contact state.

    Where the rule ties (mu_R = mu_S for rule ``nearest``) there are several states and the motion is
    any convex combination of their twists.
    """

    index: int
    polygon: Polygon
    states: tuple[ContactState, ...]

    @property
    def twists(self) -> tuple[Twist, ...]:
        """The twist of each state: the vertices of the cell's hull."""
        return tuple(state.twist for state in self.states)

    @property
    def rests(self) -> bool:
        """Whether rest is one of its motions."""
        return any(not any(twist) for twist in self.twists)

    @property
    def wheels(self) -> tuple[int, ...]:
        """Indices of the wheels whose rows are held, in the rule's order."""
        return tuple(dict.fromkeys(row.wheel.index for row in self.states[0].rows))


@dataclass(frozen=True, repr=False)
class Partition(ShortRepr):
    """Cells that cover the checked square.

    Attributes:
        scene: the array, in the coordinates of the cells.
        rule: the name of the contact rule.
        domain: the checked square.
        cells: convex, with disjoint interiors.
        wheels_considered: how many wheels could matter in the square.
        complete: whether the cells cover the square; otherwise they are those at the equilibrium only.
        like: the partition of another scene whose polygons these are, over the field of this one.
    """

    scene: Scene
    rule: str
    domain: Polygon
    cells: tuple[Cell, ...]
    wheels_considered: int
    complete: bool = True
    like: Partition | None = field(default=None, compare=False, repr=False)

    @cached_property
    def complex(self) -> CellComplex:
        """Corners, edges and cells with their incidences, exactly."""
        from nonsmooth.analysis.cells.cell_complex import build_complex

        return build_complex([cell.polygon for cell in self.cells], self.size)

    @property
    def size(self) -> float:
        """Half-width of the checked square plus the largest coordinate of its centre (length)."""
        return self.scene.check.half_width + max(map(abs, self.scene.check.place))

    @cached_property
    def area_error(self) -> Number | arb:
        """Domain area minus the cells' areas: exactly zero when they tile.

        Over a field of too many square roots for exact quotients the difference is a ball around zero.
        """
        total: Number | Lazy = self.domain.area
        for cell in self.cells:
            total = total - (cell.polygon.area if len(self.scene.field.radicands) > AREA_ROOTS else _exact_area(cell))
        return total.ball if isinstance(total, Lazy) else total

    @cached_property
    def tiles(self) -> bool:
        """Whether the cells cover the square exactly once, by their boundaries."""
        from nonsmooth.analysis.cells.cell_complex import tile

        return tile([cell.polygon for cell in self.cells], self.domain, self.size)

    @cached_property
    def states(self) -> tuple[ContactState, ...]:
        """Distinct contact states that own a cell, in cell order."""
        by_rows = {frozenset(row.name for row in s.rows): s for cell in self.cells for s in cell.states}
        return tuple(by_rows.values())

    def _repr_html_(self) -> str:
        rows = [
            (cell.index, state.name, *(brief_text(entry) for entry in state.twist))
            for cell in self.cells
            for state in cell.states
        ]
        head = f"{self.scene.name}: {len(self.cells)} cells, rule {self.rule}"
        return html_table(head, ("cell", "rows held", "v_x", "v_y", "omega"), rows)

    @property
    def meeting(self) -> tuple[Cell, ...]:
        """The cells of a centred partition that meet at its point; that rounding decides which counts at every use."""
        places, rounded = self._meeting
        self.scene.field.rounded_signs += rounded
        return tuple(self.cells[k] for k in places)

    @cached_property
    def _meeting(self) -> tuple[list[int], int]:
        """Their places among all cells, and how many signs on the way rounding decides."""
        if self.like is not None:
            return self.like._meeting
        numbers = self.scene.field
        origin = numbers.zero, numbers.zero
        return counted(numbers, lambda: [k for k, cell in enumerate(self.cells) if cell.polygon.contains(origin)])

    def cells_at(self, point: Point) -> tuple[Cell, ...]:
        """The cells whose closure holds the point."""
        return tuple(cell for cell in self.cells if cell.polygon.contains(point))


def require_rank(rows: Iterable[Row], required: str) -> None:
    """Refuse rows that leave a motion free.

    Raises:
        RefusalError: saying what was required, how many independent rows there are, and which motions are free.
    """
    first, again = tee(rows)  # most often three or four of them tell
    rank = len(independent(row.normal for row in first))
    if rank < 3:
        free = f": {free_text(kernel(again))}" if rank else ""
        raise RefusalError(
            f"{required} with friction in three independent directions, received {rank}: "
            f"the motion is not determined{free}"
        )


def _exact_area(cell: Cell) -> Number:
    """Area with every vertex as a field element."""
    exact = tuple((evaluated(x), evaluated(y)) for x, y in cell.polygon.vertices)
    area: Number = Polygon(exact, cell.polygon.sides).area
    return area
