"""The tables of a scene file and the keys that each may hold."""

from __future__ import annotations

from fractions import Fraction
from itertools import combinations
from typing import Annotated, Literal

from pydantic import Field, PlainValidator, StrictStr

from nonsmooth.symbolic.files.layouts import AnyField, Grid, HeadingField, Ring, RuleName, WheelTable
from nonsmooth.symbolic.files.load_values import Loads
from nonsmooth.symbolic.files.scene_values import (
    PLANE,
    Angle,
    AngleField,
    Exact,
    ExactField,
    Name,
    Numbers,
    OptionalExact,
    PairField,
    TomlTable,
    read_pair,
)
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.mechanics.body import Body, BodyInertia, Disc, Footprint, PolygonShape, is_convex
from nonsmooth.symbolic.mechanics.rule import DEFAULT_RULE
from nonsmooth.symbolic.mechanics.scene import LoopErrors, Tolerance
from nonsmooth.symbolic.mechanics.units import AngleUnit, LengthUnit, SpeedUnit, Units
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import FLOAT_DIGITS, decimal_text, short_text
from nonsmooth.symbolic.numbers.plane import Vector, around, cross, dot, minus, same_direction

# ---- the body ------------------------------------------------------------------------------------
#
# ``[body]`` of a scene file: outline, heading, centre of mass and inertia of the body on the array.

MAX_VERTICES = 200  # every pair of sides is tested for crossing, exactly
STANDARD_GRAVITY = Fraction("9.80665")  # m/s^2
MOST_INERTIA = 1e30  # a quotient and a product of such numbers are floats that dynamics can take
OF_INERTIA = ("mass", "inertia", "gravity", "centre_height")
_KEYS = {"disc": ("radius",), "rectangle": ("width", "height"), "polygon": ("vertices",)}


def read_vertices(value: object) -> tuple[tuple[Exact, Exact], ...]:
    """Three or more points.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, list) or not 3 <= len(value) <= MAX_VERTICES:
        raise ValueError(f"required 3 to {MAX_VERTICES} points [[x, y], ...]")
    return tuple(read_pair(point) for point in value)


class BodyTable(TomlTable):
    """``[body]``: a disc, a rectangle (width along its own x axis) or a convex polygon.

    ``heading`` is the angle of the body's own frame at the checked pose, ``centre_of_mass`` a point of that frame: the
    centroid unless it is stated.  ``mass`` (kg), ``inertia`` about the centre of mass (kg length^2), ``gravity``
    (length/s^2) and ``centre_height``, of the centre of mass above the wheels, say how it moves where it is not slow;
    with these alone, and no shape, it covers all wheels at every pose.
    """

    shape: Literal["disc", "rectangle", "polygon"] | None = None
    radius: OptionalExact = None
    width: OptionalExact = None
    height: OptionalExact = None
    vertices: Annotated[tuple[tuple[Exact, Exact], ...] | None, PlainValidator(read_vertices)] = None
    heading: AngleField = Angle(Fraction(0))
    centre_of_mass: Annotated[tuple[Exact, Exact] | None, PlainValidator(read_pair)] = None
    mass: OptionalExact = None
    inertia: OptionalExact = None
    gravity: OptionalExact = None
    centre_height: OptionalExact = None

    @property
    def states_inertia(self) -> bool:
        """Whether anything is said of how heavy the body is."""
        return any(getattr(self, key) is not None for key in OF_INERTIA)


def build_inertia(table: BodyTable | None, metres: Fraction | None, numbers: Numbers) -> BodyInertia | None:
    """How heavy the body of a scene is; None where no unit of length says what gravity is.

    Args:
        table: ``[body]``, if there is one.
        metres: the scene's unit of length.
        numbers: of the scene.

    Raises:
        SceneError: for a number that is not positive, one without a unit of length, and an inertia without a mass.
    """
    stated = BodyTable() if table is None else table
    named = {key: getattr(stated, key) for key in OF_INERTIA}
    sizes = {key: _of_size(value, f"body.{key}", numbers) for key, value in named.items() if value is not None}
    if metres is None:
        if sizes:
            key = next(iter(sizes))
            raise SceneError(numbers.file, f"body.{key}", "units.length beside it", StatedFact("no unit of length"))
        return None
    if "inertia" in sizes and "mass" not in sizes:
        raise SceneError(numbers.file, "body.inertia", "body.mass beside it: I/m counts", StatedFact("no mass"))
    gravity = sizes["gravity"] if "gravity" in sizes else numbers.field.rational(STANDARD_GRAVITY / metres)
    radius = sizes["inertia"] / sizes["mass"] if "inertia" in sizes else None
    height, mass = sizes.get("centre_height"), sizes.get("mass")
    return BodyInertia(gravity, radius, height, is_stated=bool(sizes), mass=mass)


def _of_size(value: Exact, key: str, numbers: Numbers) -> Number:
    """A positive number, or a height of zero, of a size that dynamics, which are in floats, can take.

    Raises:
        SceneError: for another one.
    """
    number = numbers.at_least_zero(value, key) if key == "body.centre_height" else numbers.positive(value, key)
    if number and not 1 / MOST_INERTIA <= abs(float(number)) <= MOST_INERTIA:
        expected = f"a size of {1 / MOST_INERTIA:g} to {MOST_INERTIA:g}"
        raise SceneError(numbers.file, key, expected, StatedFact(decimal_text(number, FLOAT_DIGITS)))
    return number


def build_body(table: BodyTable, numbers: Numbers) -> Body | None:
    """The body of a scene; None where its table says only how heavy it is, so that all wheels carry it.

    Raises:
        SceneError: for keys that do not fit the shape or need one, polygons that are not convex, and a centre of mass
            that is not strictly inside the outline.
    """
    if table.shape is None:
        of_outline = table.model_fields_set.difference(OF_INERTIA)
        if of_outline or not table.states_inertia:
            received = StatedFact(f"none, beside {', '.join(sorted(of_outline))}" if of_outline else "none")
            raise SceneError(numbers.file, "body.shape", "'disc', 'rectangle' or 'polygon'", received)
        return None
    outline, centroid = _outline(table, numbers)
    centre = numbers.field.zero, numbers.field.zero
    if table.centre_of_mass is not None:
        key = "body.centre_of_mass"
        mass = numbers(table.centre_of_mass[0], key), numbers(table.centre_of_mass[1], key)
        centre = minus(centroid, mass)
    body = Body(outline, centre, numbers.direction(table.heading))
    if not _holds_its_centre_of_mass(body):
        raise SceneError(
            numbers.file, "body.centre_of_mass", "a point strictly inside the outline", StatedFact("another")
        )
    return body


def _holds_its_centre_of_mass(body: Body) -> bool:
    """Whether the centre of mass lies strictly inside the outline."""
    if isinstance(body.outline, Disc):
        return (body.outline.radius * body.outline.radius - dot(body.centre, body.centre)).sign() > 0
    return all(cross(a, b).sign() > 0 for a, b in around(body.vertices))


def _outline(table: BodyTable, numbers: Numbers) -> tuple[Footprint, Vector]:
    """The outline about its centroid, and the centroid in the frame of the file."""
    origin = numbers.field.zero, numbers.field.zero
    for key in ("radius", "width", "height", "vertices"):
        wanted, is_stated = key in _KEYS[table.shape or ""], getattr(table, key) is not None
        if wanted != is_stated:
            expected = f"{'a value' if wanted else 'no value'} for shape {table.shape}"
            raise SceneError(numbers.file, f"body.{key}", expected, StatedFact("one" if is_stated else "nothing"))
    if table.radius is not None:
        return Disc(numbers.positive(table.radius, "body.radius")), origin
    if table.width is not None and table.height is not None:
        width = numbers.positive(table.width, "body.width")
        return rectangle(width / 2, numbers.positive(table.height, "body.height") / 2), origin
    vertices = [
        (numbers(x, f"body.vertices[{k}]"), numbers(y, f"body.vertices[{k}]"))
        for k, (x, y) in enumerate(table.vertices or (), 1)
    ]
    return _polygon(vertices, numbers.file)


def rectangle(half_width: Number, half_height: Number) -> PolygonShape:
    """The rectangle ``|x| <= half_width, |y| <= half_height``."""
    a, b = half_width, half_height
    return PolygonShape(((-a, -b), (a, -b), (a, b), (-a, b)), "rectangle")


def _polygon(vertices: list[Vector], file: str) -> tuple[PolygonShape, Vector]:
    if not _is_simple(vertices):
        expected = "a polygon whose sides meet at its vertices only"
        raise SceneError(file, "body.vertices", expected, StatedFact("sides that cross or touch"))
    sides = around(vertices)
    crosses = [cross(a, b) for a, b in sides]
    twice = sum(crosses[1:], crosses[0])
    x, y = (
        sum(((a[k] + b[k]) * c for (a, b), c in zip(sides, crosses, strict=True)), twice * 0) / (3 * twice)
        for k in (0, 1)
    )
    ordered = vertices if twice.sign() > 0 else vertices[::-1]
    outline = PolygonShape(tuple((a - x, b - y) for a, b in ordered))
    if not is_convex(outline):
        raise SceneError(file, "body.vertices", "a convex polygon", StatedFact("one with a corner that turns inward"))
    return outline, (x, y)


def _is_simple(vertices: list[Vector]) -> bool:
    """Whether sides share nothing but the vertex between neighbours."""
    sides = around(vertices)
    if any(a == b for a, b in sides):
        return False
    for (i, first), (j, second) in combinations(enumerate(sides), 2):
        if j - i in (1, len(sides) - 1):
            shared = first[1] if j - i == 1 else first[0]
            ends = [p for p in (*first, *second) if p != shared]
            if len(ends) < 2 or _folds(shared, ends[0], ends[1]):
                return False
        elif _meet(first, second):
            return False
    return True


def _folds(corner: Vector, a: Vector, b: Vector) -> bool:
    """Whether two sides leave a corner in the same direction."""
    return same_direction(minus(a, corner), minus(b, corner))


def _meet(first: tuple[Vector, Vector], second: tuple[Vector, Vector]) -> bool:
    """Whether two segments have a point in common."""
    sides = [_side(*first, p) for p in second] + [_side(*second, p) for p in first]
    if not any(sides):  # on one line
        axis = 0 if first[0][0] != first[1][0] else 1
        return max(min(p[axis] for p in s) for s in (first, second)) <= min(
            max(p[axis] for p in s) for s in (first, second)
        )
    return sides[0] * sides[1] <= 0 and sides[2] * sides[3] <= 0


def _side(a: Vector, b: Vector, p: Vector) -> int:
    return cross(minus(b, a), minus(p, a)).sign()


# ---- the other tables ----------------------------------------------------------------------------


def read_lyapunov(value: object) -> PiecewiseExpression:
    """A formula in x and y, with ``sign``, ``Abs``, ``Max`` and ``Min``.

    Raises:
        ExpressionError: for anything else.
    """
    return parse_piecewise(value, PLANE)


class UnitsTable(TomlTable):
    """``[units]``: of lengths, of speeds (``length`` per second unless stated), and of angles that name no unit."""

    length: LengthUnit | None = None
    speed: SpeedUnit | None = None
    angle: AngleUnit | None = None

    @property
    def labels(self) -> Units:
        """What the numbers of the scene are in; speeds that are stated otherwise are converted.

        Angles are read in degrees, by people, where the scene states these, or a length and no radians.
        """
        in_degrees = self.angle is AngleUnit.DEGREE or (self.length is not None and self.angle is None)
        return Units(self.length or "", in_degrees)

    @property
    def speed_factor(self) -> Fraction:
        """How many lengths per second the file's unit of speed is."""
        if self.length is None or self.speed is None:
            return Fraction(1)
        return self.speed.length.metres / self.length.metres


class StatedUnits(TomlTable):
    """The one table of a scene file that is read before the others."""

    units: UnitsTable = UnitsTable()


class FrictionTable(TomlTable):
    """``[friction]``: Coulomb coefficients, and the direction of the larger one, of every wheel that names none.

    Without an axis that direction is the rim of each wheel.
    """

    mu_roll: OptionalExact = None
    mu_side: OptionalExact = None
    axis: HeadingField | None = None


class DriveTable(TomlTable):
    """``[drive]``: the largest speed of every wheel that names none; without it speeds are not limited."""

    speed_limit: OptionalExact = None


class WheelFile(TomlTable):
    """``[wheels]``: a CSV table, its path relative to the scene file and in the scene's folder or below it."""

    file: StrictStr


class ContactTable(TomlTable):
    """``[contact]``; ``table = [...]`` is short for ``loads = {table = [...]}``."""

    rule: RuleName = DEFAULT_RULE
    loads: Loads = None
    table: Loads = None


class CheckTable(TomlTable):
    """``[check]``: the equilibrium, the square's half-width, a Lyapunov function V, a length l, and an accuracy.

    Without a radius it comes from the array (:func:`nonsmooth.symbolic.mechanics.springs.radius_to_check`), and
    so does the length (:func:`nonsmooth.symbolic.mechanics.scene.default_length`), and the accuracy,
    how near a body must come (:attr:`nonsmooth.symbolic.mechanics.scene.Scene.accuracy`).
    """

    equilibrium: PairField = (Fraction(0), Fraction(0))
    radius: OptionalExact = None
    lyapunov: Annotated[PiecewiseExpression | None, PlainValidator(read_lyapunov)] = None
    length: OptionalExact = None
    accuracy: OptionalExact = None


# ---- feedback ------------------------------------------------------------------------------------


HALF_TURN = 1  # of pi: a heading that may be off by more is not known


class FeedbackTable(TomlTable):
    """``[feedback]``: a time, a length in the scene's unit, and an angle."""

    delay: ExactField = Fraction(0)
    position_error: ExactField = Fraction(0)
    heading_error: AngleField = Angle(Fraction(0))


def build_loop_errors(table: FeedbackTable, numbers: Numbers) -> LoopErrors:
    """The errors of a scene.

    Raises:
        SceneError: for negative entries, half a turn and more, and a table in which all are zero.
    """
    turn = table.heading_error.turn
    if not 0 <= turn < HALF_TURN:
        received = StatedFact(f"{decimal_text(numbers.field.rational(turn * 180), FLOAT_DIGITS)} deg")
        raise SceneError(numbers.file, "feedback.heading_error", "an angle of at least 0, below half a turn", received)
    errors = LoopErrors(
        numbers.at_least_zero(table.delay, "feedback.delay"),
        numbers.at_least_zero(table.position_error, "feedback.position_error"),
        turn,
    )
    if not (errors.delay or errors.position or errors.heading):
        raise SceneError(numbers.file, "feedback", "an entry that is not zero", StatedFact("none"))
    return errors


# ---- tolerances ----------------------------------------------------------------------------------


QUARTER = Fraction(1, 2)  # of pi: a rim that may turn farther has no direction


class ToleranceTable(TomlTable):
    """``[tolerance]``: lengths in the scene's unit, ``heading`` an angle, the others shares of the scene's values."""

    position: ExactField = Fraction(0)
    heading: AngleField = Angle(Fraction(0))
    speed: ExactField = Fraction(0)
    mu_roll: ExactField = Fraction(0)
    mu_side: ExactField = Fraction(0)
    centre_of_mass: ExactField = Fraction(0)


def build_tolerance(table: ToleranceTable, numbers: Numbers) -> Tolerance:
    """The box of a scene.

    Raises:
        SceneError: for negative entries, shares of one and more, a quarter turn and more, and a box of one point.
    """
    turn = table.heading.turn
    if not 0 <= turn < QUARTER:
        received = StatedFact(f"{decimal_text(numbers.field.rational(turn * 180), FLOAT_DIGITS)} deg")
        raise SceneError(numbers.file, "tolerance.heading", "an angle of at least 0, below a quarter turn", received)
    uncertainty = Tolerance(
        position=numbers.at_least_zero(table.position, "tolerance.position"),
        heading=turn,
        speed=_share(table.speed, "speed", numbers),
        mu_roll=_share(table.mu_roll, "mu_roll", numbers),
        mu_side=_share(table.mu_side, "mu_side", numbers),
        centre_of_mass=numbers.at_least_zero(table.centre_of_mass, "tolerance.centre_of_mass"),
    )
    if not uncertainty.names:
        raise SceneError(numbers.file, "tolerance", "an entry that is not zero", StatedFact("none"))
    return uncertainty


def _share(value: Exact, name: str, numbers: Numbers) -> Number:
    number = numbers.at_least_zero(value, f"tolerance.{name}")
    if (number - 1).sign() >= 0:
        received = StatedFact(short_text(number))
        raise SceneError(numbers.file, f"tolerance.{name}", "a share of at least 0 and below 1", received)
    return number


# ---- the whole file -------------------------------------------------------------------------------


class SceneDocument(TomlTable):
    """A whole scene file."""

    name: Name = None
    description: Name = None
    units: UnitsTable = UnitsTable()
    friction: FrictionTable = FrictionTable()
    drive: DriveTable = DriveTable()
    wheel: list[WheelTable] | None = None
    ring: Ring | None = None
    grid: Grid | None = None
    wheels: WheelFile | None = None
    field: AnyField | None = None
    body: BodyTable | None = None
    contact: ContactTable = ContactTable()
    check: CheckTable = CheckTable()
    feedback: FeedbackTable | None = None
    tolerances: Annotated[ToleranceTable | None, Field(alias="tolerance")] = None
