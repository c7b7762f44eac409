"""Cells of a switched system: convex regions with one smooth field each, or several where a contact rule ties.

Regions are cut only where a formula asks for a sign that the region does not have: no sign pattern is tried that is
not there, and lines through one point give cones.  A plain system is cut out of the plane or out of the checked
square, always through the equilibrium, so that it is a corner of every cell that holds it; a partition of a wheel
array brings its own polygons, with the exact pose rate ``c' = v + omega J c``.  The Filippov set-valued map is the
hull of the fields of all closed cells that hold a point; whatever a formula says on a surface itself is ignored.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias, TypeVar

from nonsmooth.analysis.cells.polygon import Point, clipped_by
from nonsmooth.analysis.cells.region import Region, Triple, polygon_region, quadrants
from nonsmooth.symbolic.formulas.expression import formula_refused
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, SignOf
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import (
    PLANE,
    SwitchedSystem,
    require_plane,
    require_single,
    sign_by_factors,
)

if TYPE_CHECKING:
    from nonsmooth.analysis.cells.partition import Partition

MAX_CELLS = 400

PlaneField: TypeAlias = tuple[Polynomial, Polynomial]  # the rates of x and y, or the slopes of V along them
Piece = TypeVar("Piece")


@dataclass(frozen=True)
class FieldCell:
    """A region with the fields that act inside (several where a rule ties, or under arbitrary switching)."""

    region: Region
    velocities: tuple[PlaneField, ...]


@dataclass(frozen=True)
class LyapunovCell(FieldCell):
    """A region on which the fields and V are smooth."""

    potential: Polynomial

    @property
    def gradient(self) -> PlaneField:
        """Of V."""
        return self.potential.derivative("x"), self.potential.derivative("y")

    @property
    def rates(self) -> tuple[Polynomial, ...]:
        """``grad V . f`` for each field."""
        a, b = self.gradient
        return tuple(a * f + b * g for f, g in self.velocities)


class SignChangingRegion(Exception):
    """A region on which a surface changes its sign."""

    def __init__(self, surface: Polynomial) -> None:
        super().__init__(surface)
        self.surface = surface


class TooManyCells(ValueError):
    """Formulas that cut the plane into more pieces than are looked at."""


def smooth_pieces(
    regions: Iterable[Region], evaluate: Callable[[SignOf], Piece], limit: int = MAX_CELLS
) -> list[tuple[Region, Piece]]:
    """Regions cut until the formulas are smooth on each, with their value there.

    All regions are cut once before one is cut again: each holds a cell at least, so there are too many cells as soon as
    there are too many regions.

    Raises:
        TooManyCells: beyond the limit.
    """
    parts: list[tuple[Region, Piece | None]] = [(region, None) for region in regions]
    while len(parts) <= limit:
        settled = [(region, piece) for region, piece in parts if piece is not None]
        if len(settled) == len(parts):
            return settled
        parts = [finer for region, piece in parts for finer in _cut_once(region, piece, evaluate)]
    raise TooManyCells("required formulas with fewer switching surfaces")


def _cut_once(
    region: Region, piece: Piece | None, evaluate: Callable[[SignOf], Piece]
) -> Iterator[tuple[Region, Piece | None]]:
    """A region with its value, or its parts on the sides of a surface that changes its sign on it."""
    if piece is not None:
        yield region, piece
        return
    try:
        yield region, evaluate(lambda surface: sign_on(region, surface))
    except SignChangingRegion as found:
        yield from ((part, None) for part in region.split(found.surface))


def sign_on(region: Region, surface: Polynomial) -> int:
    """Sign of a polynomial inside a region.

    Raises:
        SignChangingRegion: with a factor that changes its sign there.
    """

    def settled(factor: Polynomial) -> int:
        sign = region.sign_of(factor)
        if sign is None:
            raise SignChangingRegion(factor)
        return sign

    return sign_by_factors(surface, settled)


def plane(system: SwitchedSystem) -> tuple[Region, ...]:
    """The whole plane, as seen from the equilibrium."""
    return quadrants(system.field.one)


def square_regions(radius: Number) -> tuple[Region, ...]:
    """The square ``|x|, |y| <= radius``, as seen from its centre."""
    zero, one = radius.field.zero, radius.field.one
    lines: list[Triple] = [(one, zero, radius), (-one, zero, radius), (zero, one, radius), (zero, -one, radius)]
    clipped = (clipped_by(quadrant, lines) for quadrant in quadrants(one))
    return tuple(region for region in clipped if region is not None)


def system_cells(system: SwitchedSystem, regions: Iterable[Region]) -> tuple[FieldCell, ...]:
    """The cells of a planar system in the given regions.

    Raises:
        SceneError: for another number of states than two, and for formulas with too many surfaces, or that are no
            polynomials on some cell.
    """
    require_plane(system)
    states, members = system.displaced(PLANE), system.members

    def evaluate(sign_of: SignOf) -> tuple[PlaneField, ...]:
        fields = (member.velocity(sign_of, states) for member in members)
        return tuple((first, second) for first, second in fields)

    try:
        return tuple(FieldCell(region, fields) for region, fields in smooth_pieces(regions, evaluate))
    except TooManyCells:
        expected = f"formulas that cut the plane into at most {MAX_CELLS} cells"
        raise SceneError(system.origin, "system.rhs", expected, StatedFact("more")) from None


def fields_by_signs(system: SwitchedSystem) -> tuple[tuple[Polynomial, ...], dict[tuple[int, ...], PlaneField]]:
    """The switching surfaces of a planar system, and its field for each pattern of their signs that occurs.

    Every cell is cut by every surface.  Between lines, only patterns of open cells are met; beside a curve a pattern is
    kept unless the coefficients of its surfaces exclude it.  This is the slow literal definition of a switched system,
    with which the tests and the stress cases compare :func:`system_cells`; no verdict uses it.

    Raises:
        SceneError: as for :func:`system_cells`.
        TooManyCells: for formulas with very many surfaces.
    """
    require_plane(system)
    require_single(system)
    states = system.displaced(PLANE)
    surfaces = system.surfaces(states)

    def evaluate(sign_of: SignOf) -> tuple[tuple[int, ...], PlaneField]:
        first, second = system.velocity(sign_of, states)
        return tuple(map(sign_of, surfaces)), (first, second)

    return surfaces, dict(mode for _, mode in smooth_pieces(plane(system), evaluate))


def partition_cells(partition: Partition) -> tuple[FieldCell, ...]:
    """The cells of a centred partition with their pose rates."""
    field = partition.scene.field
    x, y = Polynomial.coordinates(field, PLANE)
    return tuple(
        FieldCell(
            polygon_region(cell.polygon),
            tuple((-y * t.omega + t.vx, x * t.omega + t.vy) for t in cell.twists),
        )
        for cell in partition.cells
    )


def lyapunov_cells(
    cells: Iterable[FieldCell],
    lyapunov: PiecewiseExpression,
    states: Sequence[str],
    file: str,
    key: str = "check.lyapunov",
) -> tuple[LyapunovCell, ...]:
    """The cells cut further until V is smooth on each.

    Raises:
        SceneError: for a V with too many kinks, or that is no polynomial on some cell.
    """
    found: list[LyapunovCell] = []
    for cell in cells:
        field = cell.velocities[0][0].field
        values = {name: Polynomial.variable(field, PLANE, axis) for name, axis in zip(states, PLANE, strict=True)}

        def evaluate(sign_of: SignOf, values: dict[str, Polynomial] = values) -> Polynomial:
            return lyapunov.polynomial(values, sign_of)

        try:
            with formula_refused(file, key, lyapunov.text):
                pieces = smooth_pieces([cell.region], evaluate, MAX_CELLS - len(found))
        except TooManyCells:
            expected = f"a V that cuts the plane into at most {MAX_CELLS} cells"
            raise SceneError(file, key, expected, StatedFact("more")) from None
        found += [LyapunovCell(region, cell.velocities, piece) for region, piece in pieces]
    return tuple(found)


def velocities_at(cells: Iterable[FieldCell], point: Point) -> tuple[Point, ...]:
    """The values at a point of the fields of all closed cells that hold it: their hull is the Filippov set."""
    return distinct((f(point), g(point)) for cell in cells if cell.region.contains(point) for f, g in cell.velocities)


def gradients_at(cells: Iterable[LyapunovCell], point: Point) -> tuple[Point, ...]:
    """The gradients of all pieces of V that hold a point: their hull is the Clarke gradient."""
    return distinct((a(point), b(point)) for cell in cells if cell.region.contains(point) for a, b in [cell.gradient])


def distinct(points: Iterable[Point]) -> tuple[Point, ...]:
    """Points without repetitions (lazy quotients have no hash)."""
    found: list[Point] = []
    for point in points:
        if not any(point[0] == x and point[1] == y for x, y in found):
            found.append(point)
    return tuple(found)
