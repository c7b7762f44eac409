"""The Filippov set at one point of the plane, as a script or a notebook holds it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from fractions import Fraction
from functools import cached_property
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.inequalities.linear_program import best_mixture, mixtures_to_zero
from nonsmooth.reports.entries import entry
from nonsmooth.reports.result import Tabular
from nonsmooth.reports.short_text import short_lines
from nonsmooth.symbolic.notebook import html_table
from nonsmooth.symbolic.number_text import brief_text, short_text
from nonsmooth.symbolic.plane import dot, minus

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from nonsmooth.analysis.cells.partition import Partition
    from nonsmooth.symbolic.constraints import Twist
    from nonsmooth.symbolic.contact_states import ContactState
    from nonsmooth.symbolic.numbers.number import Number
    from nonsmooth.symbolic.plane import Vector


@dataclass(frozen=True, repr=False)
class FilippovSet(Tabular):
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

    def rows(self) -> list[dict[str, str]]:
        """One row for each member: its cell, the rows it holds, its pose rate and its rate of V."""
        return [
            {
                "cell": str(cell),
                "rows held": state.name,
                **dict(zip(("x'", "y'"), map(brief_text, velocity), strict=True)),
                "theta'": brief_text(state.twist.omega),
                "rate of V": brief_text(rate),
            }
            for (cell, state), velocity, rate in zip(self.members, self.velocities, self.rates, strict=True)
        ]

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the velocities as arrows from zero, their hull, and the cell of each."""
        from nonsmooth.reports.interface.plots import plot_filippov_set

        return plot_filippov_set(self, ax)

    def __repr__(self) -> str:
        said = [
            (f"cell {cell}", f"({', '.join(map(brief_text, velocity))})")
            for (cell, _), velocity in zip(self.members, self.velocities, strict=True)
        ]
        return short_lines(self._head(), said)

    def _repr_html_(self) -> str:
        rows = self.rows()
        return html_table(self._head(), tuple(rows[0]), [tuple(row.values()) for row in rows])

    def _head(self) -> str:
        x, y = (short_text(value) for value in self.point)
        holds = "holds" if self.holds_zero else "does not hold"
        return f"F({x}, {y}) of {self.partition.scene.name} {holds} 0; V* = {short_text(self.upper_derivative)}"


def filippov_set(partition: Partition, point: Sequence[Any]) -> FilippovSet:
    """The Filippov set at a point of the checked square with rational coordinates.

    Raises:
        ValueError: for a point outside, or one that is not rational.
    """
    one = partition.scene.field.one
    x, y = (one * _rational(value) for value in point)
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
