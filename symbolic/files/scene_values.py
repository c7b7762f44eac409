"""Values of scene files, in two steps: TOML to checked formulas, formulas to numbers of one field.

The field must hold every sine and cosine of the scene, so all angles are collected (:func:`angles`)
before the first number is evaluated (:class:`Numbers`).  Plain decimals skip the formula parser: a
wheel table holds tens of thousands of them.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, TypeAlias

from pydantic import BaseModel, ConfigDict, PlainValidator

from nonsmooth.symbolic.expression import Expression, ExpressionError, decimal_value, parse
from nonsmooth.symbolic.numbers.measured_angles import choose_angles
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.piecewise import PiecewiseExpression
from nonsmooth.symbolic.plane import Vector
from nonsmooth.symbolic.scene_error import SceneError, StatedFact, requirement

PLANE = ("x", "y")  # the variables of a formula in the plane
MAX_ROOTS = 64  # independent square roots in one file: each is proved new against all earlier ones,
MAX_ROOT_WORK = 2_048  # in a time that grows with their number times the degree of the base field
_PLAIN_DECIMAL = re.compile(r"[+-]?([0-9]{1,60}(\.[0-9]{0,60})?([eE][+-]?[0-9]{1,3})?|nan|inf(inity)?)", re.I)

Exact: TypeAlias = Expression | Fraction


class Table(BaseModel):
    """One TOML table: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, arbitrary_types_allowed=True)


@dataclass(frozen=True)
class Angle:
    """The angle ``pi * turn`` (radians)."""

    turn: Fraction


def read_exact(value: object, variables: Collection[str] = ()) -> Exact:
    """A number as the user wrote it.

    Raises:
        ExpressionError: for anything but an integer, a finite decimal or a formula.
    """
    if isinstance(value, str) and _PLAIN_DECIMAL.fullmatch(value):
        return decimal_value(value)
    return parse(value, variables)


def read_angle(value: object) -> Angle:
    """A rational multiple of pi, in radians.

    Raises:
        ExpressionError: for any other number.
    """
    return Angle(parse(value).turn())


def read_pair(value: object) -> tuple[Exact, Exact]:
    """Two numbers [a, b].

    Raises:
        ValueError: for anything but a list of two numbers.
    """
    if not isinstance(value, list) or len(value) != 2:
        raise ValueError("required two numbers [a, b]")
    return read_exact(value[0]), read_exact(value[1])


def read_in_plane(value: object) -> Expression:
    """A formula in x and y.

    Raises:
        ExpressionError: for anything else.
    """
    return parse(value, PLANE)


def _number(value: object) -> Exact:
    return read_exact(value)


ExactField = Annotated[Exact, PlainValidator(_number)]
OptionalExact = Annotated[Exact | None, PlainValidator(_number)]
AngleField = Annotated[Angle, PlainValidator(read_angle)]
PairField = Annotated[tuple[Exact, Exact], PlainValidator(read_pair)]
PlaneFormula = Annotated[Expression, PlainValidator(read_in_plane)]


def angles(value: object) -> Iterator[Fraction]:
    """Every turn ``t`` of an angle ``pi * t`` inside a table, list or formula."""
    match value:
        case Expression() | PiecewiseExpression():
            yield from value.turns()
        case Angle():
            yield value.turn
        case list() | tuple():
            for item in value:
                yield from angles(item)
        case Table():
            for _, item in value:
                yield from angles(item)


def field_of(turns: Iterable[Fraction]) -> NumberField:
    """The number field of a scene with these angles ``pi * turn``, exact or measured."""
    return choose_angles(turns).field


class Numbers:
    """Evaluates formulas in the one field of a scene; errors name the file and the key."""

    def __init__(self, file: str, field: NumberField) -> None:
        self.file, self.field = file, field
        self._directions: dict[Fraction, Vector] = {}

    def __call__(self, value: Exact, key: str) -> Number:
        """Exact number at a key.

        Raises:
            SceneError: on division by zero, negative square roots and numbers out of bounds.
        """
        if isinstance(value, Fraction):
            return self.field.rational(value)
        return self.formula(value, key, {})

    def formula(self, formula: Expression, key: str, values: Mapping[str, Number]) -> Number:
        """Exact value of a formula of the given variables; raises as above."""
        try:
            number = formula.value(self.field, values)
        except ExpressionError as error:
            raise SceneError(self.file, key, requirement(error), formula.text) from None
        roots = len(self.field.radicands)
        if roots > MAX_ROOTS or roots * self.field.base_degree > MAX_ROOT_WORK:
            raise SceneError(self.file, key, "fewer independent square roots in one scene", StatedFact(f"{roots}"))
        return number

    def positive(self, value: Exact, key: str) -> Number:
        """Exact number that must be positive.

        Raises:
            SceneError: where it is not.
        """
        number = self(value, key)
        if number.sign() <= 0:
            raise SceneError(self.file, key, "a positive number", StatedFact(short_number(number)))
        return number

    def direction(self, angle: Angle) -> Vector:
        """``(cos, sin)`` of an angle."""
        if angle.turn not in self._directions:
            self._directions[angle.turn] = self.field.cos_pi(angle.turn), self.field.sin_pi(angle.turn)
        return self._directions[angle.turn]


def short_number(number: Number) -> str:
    """Exact text where it is short, six digits otherwise."""
    text = str(number)
    return text if len(text) <= 24 else f"{float(number):.6g}"
