"""The tables of a scene file and the keys that each may hold."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated

from pydantic import Field, PlainValidator, StrictStr

from nonsmooth.symbolic.files.body_table import BodyTable
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
)
from nonsmooth.symbolic.formulas.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.mechanics.rule import DEFAULT_RULE
from nonsmooth.symbolic.mechanics.scene import LoopErrors, Tolerance
from nonsmooth.symbolic.mechanics.units import AngleUnit, LengthUnit, SpeedUnit, Units
from nonsmooth.symbolic.messages.scene_error import SceneError, StatedFact
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_text import FLOAT_DIGITS, decimal_text, short_text


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
    found = LoopErrors(
        numbers.at_least_zero(table.delay, "feedback.delay"),
        numbers.at_least_zero(table.position_error, "feedback.position_error"),
        turn,
    )
    if not (found.delay or found.position or found.heading):
        raise SceneError(numbers.file, "feedback", "an entry that is not zero", StatedFact("none"))
    return found


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
    found = Tolerance(
        position=numbers.at_least_zero(table.position, "tolerance.position"),
        heading=turn,
        speed=_share(table.speed, "speed", numbers),
        mu_roll=_share(table.mu_roll, "mu_roll", numbers),
        mu_side=_share(table.mu_side, "mu_side", numbers),
        centre_of_mass=numbers.at_least_zero(table.centre_of_mass, "tolerance.centre_of_mass"),
    )
    if not found.names:
        raise SceneError(numbers.file, "tolerance", "an entry that is not zero", StatedFact("none"))
    return found


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
