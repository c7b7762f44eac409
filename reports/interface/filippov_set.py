"""The Filippov set at one point of the plane, as a script or a notebook holds it."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.findings import Record
from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.reports.output.document import Block, sentences, table
from nonsmooth.reports.output.entries import entry
from nonsmooth.reports.studies.result import DataTable, Result, short_lines
from nonsmooth.symbolic.mechanics.body import support_polygon
from nonsmooth.symbolic.messages.scene_error import shown
from nonsmooth.symbolic.numbers.number import sign
from nonsmooth.symbolic.numbers.number_text import brief_text, exact_place, short_text
from nonsmooth.symbolic.numbers.plane import XY, dot, in_floats, minus

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.mechanics.contact_states import ContactState, Twist
    from nonsmooth.symbolic.numbers.number import Number
    from nonsmooth.symbolic.numbers.plane import Vector


@dataclass(frozen=True, repr=False)
class FilippovSet(Result):
    """``F(c) = co { c' of every cell whose closure holds c }``, exactly.

    Attributes:
        partition: the cells.
        point: c.
        members: for each velocity that spans F the index of its cell and its contact state.
    """

    partition: Partition
    point: Vector
    members: tuple[tuple[int, ContactState], ...]

    @property
    def twists(self) -> tuple[Twist, ...]:
        """The twist of each member."""
        return tuple(state.twist for _, state in self.members)

    @property
    def velocities(self) -> tuple[Vector, ...]:
        """``c' = v + omega J c`` of each member: F is their convex hull."""
        return tuple(twist.pose_rate(self.point) for twist in self.twists)

    @cached_property
    def weights(self) -> tuple[Number, ...] | None:
        """Convex weights of the members that give zero velocity; None where zero is not in F."""
        zero = self.partition.scene.field.zero
        mixture = best_mixture(*mixtures_to_zero(self.velocities), [zero] * len(self.members))
        return None if mixture is None else tuple(mixture.weights.get(k, zero) for k in range(len(self.members)))

    @property
    def holds_zero(self) -> bool:
        """Whether the point is an equilibrium: 0 in F(c)."""
        return self.weights is not None

    @property
    def rates(self) -> tuple[Number, ...]:
        """``2 (c - c*) . c'`` of each member: the derivative of ``V = |c - c*|^2`` along it."""
        away = minus(self.point, self.partition.scene.check.equilibrium)
        return tuple(2 * dot(away, velocity) for velocity in self.velocities)

    @property
    def upper_derivative(self) -> Number:
        """``V*(c)``, the largest of the rates."""
        return max(self.rates)

    def facts(self) -> Record:
        """The set as a record, exact numbers as texts."""
        weights = None if self.weights is None else [str(weight) for weight in self.weights]
        return {"point": [str(value) for value in self.point], "members": self.rows(), "weights": weights}

    def table(self) -> DataTable:
        """One line for each member: its cell, the rows it holds, its pose rate and its rate of V."""
        lines = [
            (str(cell), state.name, *map(brief_text, (*velocity, state.twist.omega, rate)))
            for (cell, state), velocity, rate in zip(self.members, self.velocities, self.rates, strict=True)
        ]
        return DataTable(("cell", "rows held", "x'", "y'", "theta'", "rate of V"), lines)

    def blocks(self) -> Sequence[Block]:
        """The members as a table."""
        return [*sentences(self.summary()), table(*self.table())]

    def draw(self, ax: Axes) -> None:
        """The velocities as arrows from zero, their hull, and the cell of each."""
        from nonsmooth.reports.figures.style import INK, PALETTE, TINT

        corners = [in_floats(velocity) for velocity in support_polygon(self.velocities) or self.velocities[:1]]
        ax.fill(*zip(*corners, strict=True), facecolor=PALETTE[0], alpha=TINT)
        ax.fill(*zip(*corners, strict=True), facecolor="none", edgecolor=PALETTE[5], linewidth=2)
        cells: dict[XY, list[str]] = {}
        for (cell, _), velocity in zip(self.members, self.velocities, strict=True):
            cells.setdefault(in_floats(velocity), []).append(str(cell))
        for tip, indices in cells.items():
            ax.annotate("", tip, (0, 0), arrowprops={"arrowstyle": "->", "color": INK, "shrinkA": 0, "shrinkB": 0})
            label = f"cell{'s' if len(indices) > 1 else ''} {', '.join(indices)}"
            across, up = sign(tip[0]), sign(tip[1])
            beyond: dict[str, Any] = {"ha": ("center", "left", "right")[across], "va": ("center", "bottom", "top")[up]}
            ax.annotate(label, tip, (4 * across, 4 * up), textcoords="offset points", color=INK, **beyond)
        ax.plot([0], [0], marker="+", color=INK, markersize=11)
        ax.set(xlabel="x'", ylabel="y'", title=f"F{exact_place(self.point)}")
        ax.axis("equal")
        ax.margins(0.35)

    def __repr__(self) -> str:
        said = [
            (f"cell {cell}", f"({', '.join(map(brief_text, velocity))})")
            for (cell, _), velocity in zip(self.members, self.velocities, strict=True)
        ]
        return short_lines(self.summary(), said)

    def summary(self) -> str:
        """Whether it holds zero."""
        name, holds = self.partition.scene.name, "holds" if self.holds_zero else "does not hold"
        return f"F{exact_place(self.point)} of {name} {holds} 0; V* = {short_text(self.upper_derivative)}"


def filippov_set(partition: Partition, point: Sequence[Any]) -> FilippovSet:
    """The Filippov set at a point of the checked square with rational coordinates.

    Raises:
        ValueError: for a point outside, or one that is not rational.
    """
    coordinates = list(point) if isinstance(point, Iterable) else []
    if len(coordinates) != 2:
        raise ValueError(f"required a point (x, y), received {shown(point)}")
    one = partition.scene.field.one
    x, y = (one * _rational(value) for value in coordinates)
    members = tuple((cell.index, state) for cell in partition.cells_at((x, y)) for state in cell.states)
    if not members:
        raise ValueError(f"required a point of the checked square, received ({short_text(x)}, {short_text(y)})")
    return FilippovSet(partition, (x, y), members)


def _rational(value: Any) -> Fraction:
    """A coordinate: a float means its shortest decimal."""
    given = entry(value)
    try:
        return Fraction(given if isinstance(given, int | str | Decimal) else str(given))
    except (ValueError, InvalidOperation, OverflowError, ZeroDivisionError):
        raise ValueError(f"required rational coordinates, received {value!r}") from None
