"""Contact states: three independent rows held without slip, their twist and control vector fields.

The annihilator of the stacked rows (null vector of the 3 x 4 matrix, last entry 1) is the twist; with
symbolic speeds it is ``xi = sum_w g_w u_w`` (Murphey & Burdick, Definition 2 and eq. 6).  Both come from the
cofactors of one 3 x 3 matrix over the scene's field: no elimination, no simplification.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from itertools import combinations
from math import comb
from typing import Any, NamedTuple, TypeAlias

from nonsmooth.symbolic.mechanics.constraints import (
    Row,
    Triple,
    Twist,
    added,
    cofactors,
    combine,
    cross_product,
    inner,
    rows_with_friction,
    scaled,
)
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.messages.notebook import ShortRepr
from nonsmooth.symbolic.numbers.number import Number

Solution: TypeAlias = tuple[tuple[Triple, Triple, Triple], Number]  # in plain rationals where all normals are rational


@dataclass(frozen=True, repr=False)
class ContactState(ShortRepr):
    """Rows of rank three and what follows from them.

    Attributes:
        rows: the rows held without slip, in the order the rule chose them: three for rule ``nearest``, all that
            the twist satisfies for rule ``box``.
        twist: the annihilator ``xi`` for the scene's speeds.
        solution: cofactors and the inverse of the determinant of three rows, where they are known already.
    """

    rows: tuple[Row, ...]
    twist: Twist
    solution: Solution | None = field(default=None, repr=False, compare=False)

    @property
    def name(self) -> str:
        """For example ``R1 S1 R4``."""
        return " ".join(self.row_names)

    @property
    def row_names(self) -> list[str]:
        """For example ``["R1", "S1", "R4"]``."""
        return [row.name for row in self.rows]

    @property
    def is_of_a_pair(self) -> bool:
        """Whether it holds both rows of one wheel, roll row first, and then one row of another."""
        wheels = [row.wheel.index for row in self.rows]
        return len(wheels) == 3 and wheels[0] == wheels[1] != wheels[2]

    @cached_property
    def control_fields(self) -> dict[int, Triple]:
        """``g_w`` by wheel index: ``xi = sum_w g_w u_w``; side rows carry no input, unless the wheel has an axis.

        Raises:
            ValueError: for more than three rows, which hold together for these speeds only.
        """
        if len(self.rows) != 3:
            raise ValueError(f"required three rows, received {self.name}")
        columns, inverse = self.solution or _solution((self.rows[0], self.rows[1], self.rows[2]))
        fields: dict[int, Triple] = {}
        for row, column in zip(self.rows, columns, strict=True):
            if row.gain:
                own, index = scaled(column, row.gain * inverse), row.wheel.index
                fields[index] = added(fields[index], own) if index in fields else own
        return fields


def _solution(rows: tuple[Row, Row, Row]) -> Solution:
    """Of independent rows."""
    columns = cofactors(*(row.normal for row in rows))
    return columns, inner(rows[0].normal, columns[0]).inverse()


def solve_rows(rows: tuple[Row, Row, Row]) -> ContactState | None:
    """The contact state of three rows, or None where they are dependent."""
    columns = cofactors(*(row.normal for row in rows))
    determinant = inner(rows[0].normal, columns[0])
    if not determinant:
        return None
    inverse = determinant.inverse()
    return ContactState(rows, _twist(rows, columns, inverse), (columns, inverse))


def _twist(rows: tuple[Row, Row, Row], columns: tuple[Triple, Triple, Triple], inverse: Number) -> Twist:
    """``sum_k (rhs_k/det) column_k``; most rows say zero, so that they take no part."""
    return Twist(*combine([row.rhs * inverse for row in rows], columns))


class ContactCensus(NamedTuple):
    """Count of all row triples of an array.

    Attributes:
        possible: C(m, 3) of m rows with friction; C(2n, 3) where every row has some.
        singular: triples of dependent rows; None where they were not counted.
        distinct_twists: different twists among the regular triples; None where not counted.
    """

    possible: int
    singular: int | None = None
    distinct_twists: int | None = None

    @property
    def regular(self) -> int | None:
        """Triples that determine a twist."""
        return None if self.singular is None else self.possible - self.singular


def possible_triples(wheel_count: int) -> int:
    """C(2n, 3) row triples of n wheels."""
    return comb(2 * wheel_count, 3)


def triples_with_friction(scene: Scene) -> int:
    """C(m, 3) triples of the m rows with friction: a row without friction holds nothing."""
    rows = sum(bool(wheel.friction.roll) + bool(wheel.friction.side) for wheel in scene.wheels)
    return comb(rows, 3)


def regular_states(scene: Scene) -> list[ContactState]:
    """Every regular triple of rows with friction, in lexicographic order."""
    rows = list(rows_with_friction(scene))
    normals = [_rational(row.normal) for row in rows]
    crosses = {(i, j): cross_product(normals[i], normals[j]) for i, j in combinations(range(len(rows)), 2)}
    crosses |= {(j, i): (-x, -y, -z) for (i, j), (x, y, z) in crosses.items()}
    states: list[ContactState] = []
    for i, j, k in combinations(range(len(rows)), 3):
        determinant = inner(normals[i], crosses[j, k])
        if not determinant:
            continue
        inverse = determinant.inverse() if isinstance(determinant, Number) else 1 / determinant
        own, columns = (rows[i], rows[j], rows[k]), (crosses[j, k], crosses[k, i], crosses[i, j])
        states.append(ContactState(own, _twist(own, columns, inverse), (columns, inverse)))
    return states


def _rational(vector: Triple) -> Any:
    """The same vector in plain rationals, with which one computes fast, where it has no other entry."""
    entries = [entry.as_rational() if type(entry) is Number else None for entry in vector]
    return vector if None in entries else tuple(entries)


def take_census(scene: Scene) -> ContactCensus:
    """Count possible and singular triples and distinct twists."""
    states = regular_states(scene)
    possible = triples_with_friction(scene)
    return ContactCensus(possible, possible - len(states), len({state.twist for state in states}))
