"""The tables of a scene file and the keys that each may hold."""

from __future__ import annotations

from fractions import Fraction
from typing import Annotated

from pydantic import Field, PlainValidator, StrictStr

from nonsmooth.symbolic.files.body_table import BodyTable
from nonsmooth.symbolic.files.feedback_table import FeedbackTable
from nonsmooth.symbolic.files.layouts import Grid, Ring, RuleName, WheelTable
from nonsmooth.symbolic.files.load_values import Loads
from nonsmooth.symbolic.files.scene_values import (
    PLANE,
    AngleUnit,
    OptionalExact,
    PairField,
    TomlTable,
)
from nonsmooth.symbolic.files.tolerance_table import ToleranceTable
from nonsmooth.symbolic.files.velocity_fields import AnyField, HeadingField
from nonsmooth.symbolic.piecewise import PiecewiseExpression, parse_piecewise
from nonsmooth.symbolic.rule import DEFAULT_RULE
from nonsmooth.symbolic.units import LengthUnit, SpeedUnit, Units

MAX_NAME = 200  # characters


def read_lyapunov(value: object) -> PiecewiseExpression:
    """A formula in x and y, with ``sign``, ``Abs``, ``Max`` and ``Min``.

    Raises:
        ExpressionError: for anything else.
    """
    return parse_piecewise(value, PLANE)


def read_name(value: object) -> str:
    """A printable line.

    Raises:
        ValueError: for anything else.
    """
    if not isinstance(value, str) or not value.strip() or len(value) > MAX_NAME or not value.isprintable():
        raise ValueError(f"required a printable text of 1 to {MAX_NAME} characters")
    return value.strip()


Name = Annotated[str | None, PlainValidator(read_name)]


class UnitsTable(TomlTable):
    """``[units]``: of lengths, of speeds (``length`` per second unless stated), and of angles that name no unit."""

    length: LengthUnit | None = None
    speed: SpeedUnit | None = None
    angle: AngleUnit | None = None

    @property
    def labels(self) -> Units:
        """What the numbers of the scene are in; speeds that are stated otherwise are converted."""
        return Units(self.length or "")

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

    Without a radius it comes from the array (:func:`nonsmooth.symbolic.support_polygon.default_radius`), and so does
    the length (:func:`nonsmooth.symbolic.characteristic_length.default_length`), and the accuracy, how near a body must
    come (:attr:`nonsmooth.symbolic.scene.Scene.accuracy`).
    """

    equilibrium: PairField = (Fraction(0), Fraction(0))
    radius: OptionalExact = None
    lyapunov: Annotated[PiecewiseExpression | None, PlainValidator(read_lyapunov)] = None
    length: OptionalExact = None
    accuracy: OptionalExact = None


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
