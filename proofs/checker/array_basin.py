"""A basin of an array as a mesh of triangles: W falls until bodies are in a convex polygon, which they do not leave.

The motion of the centre of mass is ``c' = v + omega J c`` with (v, omega) in the hull of the motions of all closed
cells that hold c (:mod:`.contact`): a switched system in the plane with affine velocities, whose cells are polygons.

*Theorem.*  Let the square ``|x|, |y| <= within`` lie in the support polygon and hold the mesh inside, let W fall on the
mesh as conditions 1 to 3 of :mod:`.basin` ask, and let the sides of its border on which W is not at least c form one
convex polygon K, with the mesh outside, such that on every closed side of K every velocity of every cell whose closure
meets it leads into K.  Then every solution from a point p of a triangle T with ``W_T(p) < c`` is in K after a finite
time, and stays there.  Where ``c . v < 0`` off the point, for all motions of all cells whose closures meet K, it tends
to the point.

*Proof.*  As in :mod:`.basin` the lift of a solution meets the border after a finite time with ``W < c``: on a side of
K.  K is an intersection of half planes, one for each side, and F is upper semicontinuous; so near a closed side the
distance from its line falls along every solution, and no solution leaves K there.  At last ``c . v`` is half the
derivative of ``|c|^2``, because ``c . J c = 0``; it is linear in c, so on a cell off the point it has one sign if it
has that at the corners other than the point; and on the compact set K it is less than a negative number off any
neighbourhood of the point.

*Enclosures.*  Corners of cells and twists are numbers of a field.  Here corners are enclosed by squares; a cell counts
as met unless a line is shown to part it from the triangle.  Twists are enclosed by boxes: an affine velocity of such a
box is, on the square, a mixture of the four of :meth:`ArrayPlane.fields`.  Both can only add velocities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property
from typing import Any, TypeAlias

from .basin import Field, Mesh, Place, show_falls
from .contact import Cells, Motion
from .outside import turn
from .plane import around, convex_hull
from .positivity import Proofs
from .theorems import Statement
from .tower import Number, cross
from .wheels import Array
from .work import BUDGET, rational, require, take

FINE = 24  # bits of a unit of the mesh, in which corners of cells are enclosed
BITS = 96  # of enclosures

Outline: TypeAlias = list[Place]  # a convex polygon, counterclockwise, in fine units
Box: TypeAlias = tuple[int, int, int, int]  # least x and y, largest x and y


class ArrayPlane:
    """The cells of an array in the places of a mesh; a cell is named by its number, as by a pattern of signs there.

    Attributes:
        has_borders: whether there may be several cells.
    """

    has_borders = True

    def __init__(self, cells: Cells, unit: Any) -> None:
        self.cells, self.unit = cells, rational(unit)
        require(self.unit > 0, "a positive unit")
        self._fields: dict[int, tuple[Field, ...]] = {}
        points = [self._enclosed(*point) for point in cells.points]
        self._outlines: list[Outline] = [[points[k] for k in cell.polygon] for cell in cells.listed]
        self._boxes = [bounds(outline) for outline in self._outlines]
        scaled = cells.array.radius * cells.rational(1 / self.unit)
        self.half = -(-scaled.enclosure(BITS)[1] >> BITS)  # of the square, in units, rounded up
        self._slack = 16 * (self.half + 2 << FINE) + 16  # errors of :func:`turn` where places are off by one

    def _enclosed(self, x: Number, y: Number, w: Number) -> Place:
        """A corner of cells in fine units: each coordinate is off by one at most."""
        low, high = w.enclosure(BITS)
        require(low > 0, "corners that are enclosed")
        coordinates = []
        for coordinate in (x, y):
            least, most = (coordinate * self.cells.rational(Fraction(2**FINE) / self.unit)).enclosure(BITS)
            bottom, top = least // (high if least > 0 else low), -(-most // (low if most > 0 else high))
            require(top - bottom <= 2, "corners that are enclosed")
            coordinates.append((bottom + top) // 2)
        return coordinates[0], coordinates[1]

    def fields(self, number: int, corners: Sequence[Place] = ()) -> tuple[Field, ...]:
        """Velocities of which, on the square, those of a cell are mixtures: four for each motion."""
        if number not in self._fields:
            motions = self.cells.listed[number].motions
            self._fields[number] = tuple(field for motion in motions for field in self._of_motion(motion))
        return self._fields[number]

    def _of_motion(self, motion: Motion) -> list[Field]:
        """``v + omega J c`` at the place ``c = (X, Y) unit``, times a positive number, for corners of a box of v.

        A rotation that is off by e adds at most ``e |Y|`` and ``e |X|`` to the parts of the velocity.
        """
        enclosed = [component.enclosure(BITS) for component in motion.twist[:3]]
        (a, b), (c, d), (low, high) = enclosed
        p, q = self.unit.numerator, self.unit.denominator
        push = (high - low) * p * self.half
        turn = low * p
        longest = max(abs(bound) for bound in (a * q, b * q, c * q, d * q, turn)) + push
        return [
            Field(({(0, 0): vx, (0, 1): -turn}, {(0, 0): vy, (1, 0): turn}), 1, longest.bit_length())
            for vx in (a * q - push, b * q + push)
            for vy in (c * q - push, d * q + push)
        ]

    def crossing(self, corners: Sequence[Place]) -> frozenset[int]:
        """The cells that may meet the inside of a triangle, whose corners are counterclockwise."""
        return self._not_parted(corners, lambda size: size <= 0)

    def touching(self, corners: Sequence[Place]) -> frozenset[int]:
        """The cells whose closures may meet a convex polygon, a side or a corner."""
        return self._not_parted(corners, lambda size: size < 0)

    def _not_parted(self, corners: Sequence[Place], is_beyond: Callable[[int], bool]) -> frozenset[int]:
        """The cells that no line of a side, of theirs or of the polygon, is shown to part from the polygon."""
        polygon = [(x << FINE, y << FINE) for x, y in corners]
        left, low, right, high = bounds(polygon)
        numbers = []
        BUDGET.spend(1 + len(self._boxes) // 4)
        for number, (cell_left, cell_low, cell_right, cell_high) in enumerate(self._boxes):
            gaps = (cell_left - 1 - right, left - cell_right - 1, cell_low - 1 - high, low - cell_high - 1)
            if any(is_beyond(-gap) for gap in gaps):
                continue
            outline = self._outlines[number]
            BUDGET.spend(2 * len(outline) * len(polygon))
            if not self._parts(outline, polygon, is_beyond) and not self._parts(polygon, outline, is_beyond):
                numbers.append(number)
        return frozenset(numbers)

    def _parts(self, outline: Sequence[Place], other: Sequence[Place], is_beyond: Callable[[int], bool]) -> bool:
        """Whether all corners of another polygon lie beyond one side; of two places each order is a side."""
        sides = around(outline) if len(outline) > 1 else []
        return any(all(is_beyond(turn(a, b, c) + self._slack) for c in other) for a, b in sides)


def bounds(outline: Sequence[Place]) -> Box:
    """Of some places."""
    across, up = [x for x, _ in outline], [y for _, y in outline]
    return min(across), min(up), max(across), max(up)


class Core:
    """The polygon K of a mesh: the sides of its border on which W is not at least the level.

    Attributes:
        sides: of K, counterclockwise, by their numbers of corners.
        places: its corners in that order.
    """

    def __init__(self, mesh: Mesh, level: int) -> None:
        below = [side for side in mesh.border if min(mesh.values[k] for k in side) < level]
        following = {b: a for a, b in below}  # the mesh lies to the left of its border, and K to the right
        chain = [below[0][1]]
        while following.get(chain[-1]) not in (None, chain[0]):
            require(len(chain) < len(below), "one polygon in which bodies end")
            chain.append(following[chain[-1]])
        closed = following.get(chain[-1]) == chain[0]
        require(closed and len(chain) == len(below), "one polygon in which bodies end")
        self.numbers, self.places = chain, mesh.corners(chain)

    @cached_property
    def sides(self) -> list[tuple[Place, Place]]:
        """The sides of K, counterclockwise."""
        return around(self.places)

    def show_kept(self, plane: ArrayPlane) -> None:
        """K is convex, and on every closed side all velocities lead into it."""
        constant = plane.cells.array.field.rational
        plane.cells.require_convex(
            "the polygon in which bodies end", [(constant(x), constant(y), constant(1)) for x, y in self.places]
        )
        for a, b in self.sides:
            outward = (b[1] - a[1], a[0] - b[0])
            for number in plane.touching([a, b]):
                for field in plane.fields(number):
                    require(max(field.along(outward).on([a, b])) < 0, f"velocities that lead inward at {a} {b}")

    def attracts(self, plane: ArrayPlane) -> bool:
        """Whether the distance from the point falls off the point in K."""
        cells = [plane.cells.listed[number] for number in plane.touching(self.places)]
        return all(max(motion.rates) < 0 for cell in cells for motion in cell.motions)

    def show_within(self, plane: ArrayPlane, squared_radius: Fraction) -> None:
        """K lies in a disc about the point."""
        largest = max(x * x + y * y for x, y in self.places)
        require(largest * plane.unit**2 <= squared_radius, "a polygon in the disc in which bodies end")


def show_array_basin(array: Array, hypotheses: Any, proofs: Proofs) -> list[Statement]:
    """Every start in a triangle at which W is below the level tends to the point, or ends in a disc about it.

    Hypotheses: ``within`` (half the side of the square), ``points`` and ``cells`` (as those of ``theorem 4``, on that
    square), ``mesh`` and ``below`` (as those of the theorem ``basin`` of systems), ``squared_radius`` of the disc.
    """
    within, points, cells_data, mesh_data, below, disc = take(
        hypotheses, "within points cells mesh below squared_radius"
    )
    wide = replace(array, radius=array.field.parse(within))
    show_stands(wide)
    mesh = Mesh(mesh_data)
    require(type(below) is int, "a level that is a whole number")
    plane = ArrayPlane(Cells(wide, points, cells_data), mesh.unit)
    reach = max(abs(coordinate) for place in mesh.places for coordinate in place)
    room = wide.radius - array.field.rational(reach * plane.unit)
    require(room.sign() > 0, "a mesh inside the square")
    show_falls(mesh, plane)
    core = Core(mesh, below)
    core.show_kept(plane)
    core.show_within(plane, rational(disc))
    conclusions: list[Statement] = [{"ends": {"mesh": mesh_data, "below": below, "squared_radius": disc}}]
    return [{"attracts": {"mesh": mesh_data, "below": below}}] if core.attracts(plane) else conclusions


def show_stands(array: Array) -> None:
    """The square lies in the support polygon, the convex hull of all wheels."""
    hull, half = convex_hull([wheel.place for wheel in array.wheels.values()]), array.radius
    corners = [(half, half), (-half, half), (-half, -half), (half, -half)]
    inside = all(
        cross((b[0] - a[0], b[1] - a[1]), (x - a[0], y - a[1])).sign() >= 0 for a, b in around(hull) for x, y in corners
    )
    require(len(hull) > 2 and inside, "a square in the support polygon")
