"""The cells of a contact rule on one set of carrying wheels, in floats, wherever the body stands on them.

A cell is bounded by lines of the plane.  Cells of different sets may share lines (bisectors under rule ``nearest``,
axes of symmetry), so all sets take them from one :class:`Lines`, where equal lines are one surface.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from nonsmooth.analysis.cells.contact_rule import CellRule
from nonsmooth.analysis.fields.constant_field import array_field
from nonsmooth.analysis.fields.contact_model import Floats
from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.fields.switched_field import Member, Surface, affine_surface
from nonsmooth.symbolic.mechanics.body import support_polygon
from nonsmooth.symbolic.mechanics.contact_set import with_only
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import numbers_text
from nonsmooth.symbolic.numbers.plane import around, cross
from nonsmooth.symbolic.numbers.plane_arrays import float_points

SAME_LINE = 1e-12  # unit normals, and offsets over the array's size, that differ by less are one line's

Side = tuple[Surface, int]  # a line and the side of it on which a cell lies


class Lines:
    """Lines of the plane of c, each of them one surface of poses."""

    def __init__(self, size: float) -> None:
        """For an array of that size (length)."""
        self._size = size
        self._known = np.zeros((0, 3))
        self._surfaces: list[Surface] = []

    def side(self, normal: Floats, offset: float) -> Side:
        """The line ``normal . c = offset`` and the side on which ``normal . c < offset``."""
        length = float(np.hypot(*normal))
        row = np.array([*normal / length, offset / length / self._size])
        for sign in (-1, 1):
            same = np.flatnonzero(np.abs(self._known + sign * row).max(axis=1, initial=0.0) <= SAME_LINE)
            if len(same):
                return self._surfaces[int(same[0])], sign
        surface = affine_surface("line", (row[0], row[1], 0.0), offset / length)
        self._known = np.vstack([self._known, row])
        self._surfaces.append(surface)
        return surface, -1


@dataclass(frozen=True, eq=False)
class SetCell:
    """One cell of one set.

    Attributes:
        number: its place among the cells of its set.
        name: what it is called among them.
        member: its motion, under a name among all cells of all sets.
        twist: ``(v_x, v_y, omega)``.
        sides: what bounds it.
        tied: whether several motions tie in it; the first is drawn.
    """

    number: int
    name: str
    member: Member
    twist: tuple[float, float, float]
    sides: tuple[Side, ...]
    tied: bool


class SetCells:
    """The cells on one set of wheels.

    Attributes:
        wheels: their numbers.
        borders: the sides of the wheels' hull, on the inside of which the body stands; none where it never does.
        cells: all of them.
    """

    def __init__(self, scene: Scene, rule: CellRule, lines: Lines) -> None:
        """For the wheels of a scene.

        Raises:
            RefusalError: where the motion on these wheels is not determined.
        """
        self.wheels = tuple(wheel.index for wheel in scene.wheels)
        self._scene, self._rule, self._lines = scene, rule, lines
        hull = support_polygon([wheel.position for wheel in scene.wheels])
        sides = around(hull) if len(hull) > 2 else ()
        self.borders = tuple(
            lines.side(np.array([float(b[1] - a[1]), float(a[0] - b[0])]), float(cross(a, b))) for a, b in sides
        )

    @cached_property
    def cells(self) -> tuple[SetCell, ...]:
        """Built where the body first stands on these wheels.

        Raises:
            RefusalError: where the motion on these wheels is not determined.
        """
        field = array_field(self._rule.build_standing_partition(self._scene), Kinematics.EXACT)
        found = []
        for k, polygon in enumerate(field.cells.polygons):
            name = f"{field.names[k]} of wheels {numbers_text(self.wheels)}"
            sides = tuple(self._lines.side(np.array(side.normal), float(side.offset)) for side in polygon.sides)
            flow, member = field.flows[k][0], Member(name, field.velocity(k))
            twist = (float(flow.vx), float(flow.vy), float(flow.omega))
            found.append(SetCell(k, field.names[k], member, twist, sides, field.tied(k)))
        return tuple(found)

    def stands(self, pose: Floats, slack: float) -> bool:
        """Whether the centre of mass is inside the hull of the wheels, or within the slack of it."""
        return bool(self.borders) and all(sign * line.value(pose) >= -slack for line, sign in self.borders)

    def holding(self, pose: Floats, slack: float) -> list[SetCell]:
        """The cells whose closure holds a place."""
        return [cell for cell in self.cells if all(sign * line.value(pose) >= -slack for line, sign in cell.sides)]


class CellsBySet:
    """The cells by set of carrying wheels; along a path few sets are met, each many times."""

    def __init__(self, scene: Scene, rule: CellRule) -> None:
        """For an array with all its wheels."""
        if not rule.needs_loads:
            scene = replace(scene, contact=replace(scene.contact, loads=None))
        self._scene, self._rule = scene, rule
        places = float_points(wheel.position for wheel in scene.wheels)
        self.size = float(np.abs(places).max())
        self._lines = Lines(self.size)
        self._known: dict[frozenset[int], SetCells] = {}

    def of(self, wheels: frozenset[int]) -> SetCells:
        """The cells of the wheels at these places in the scene's list."""
        if wheels not in self._known:
            chosen = [self._scene.wheels[k] for k in sorted(wheels)]
            self._known[wheels] = SetCells(with_only(self._scene, chosen), self._rule, self._lines)
        return self._known[wheels]


def agrees(sides: tuple[Side, ...], pattern: Mapping[Surface, int]) -> bool:
    """Whether a pattern of signs of the lines through a place lies on the inner side of all of them it names."""
    return all(pattern.get(line, sign) == sign for line, sign in sides)
