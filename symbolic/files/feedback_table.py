"""``[feedback]`` of a scene file: how late and how wrong the pose is that a law acts on."""

from __future__ import annotations

from fractions import Fraction

from nonsmooth.symbolic.files.scene_values import Angle, AngleField, Exact, ExactField, Numbers, TomlTable
from nonsmooth.symbolic.loop_errors import LoopErrors
from nonsmooth.symbolic.number_text import short_text
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.scene_error import SceneError, StatedFact

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
        received = StatedFact(f"{float(turn * 180):g} deg")
        raise SceneError(numbers.file, "feedback.heading_error", "an angle of at least 0, below half a turn", received)
    found = LoopErrors(
        _size(table.delay, "delay", numbers), _size(table.position_error, "position_error", numbers), turn
    )
    if not (found.delay or found.position or found.heading):
        raise SceneError(numbers.file, "feedback", "an entry that is not zero", StatedFact("none"))
    return found


def _size(value: Exact, name: str, numbers: Numbers) -> Number:
    number = numbers(value, f"feedback.{name}")
    if number.sign() < 0:
        raise SceneError(numbers.file, f"feedback.{name}", "a number of at least 0", StatedFact(short_text(number)))
    return number
