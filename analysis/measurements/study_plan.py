"""A plan: methods at their settings, what they are compared with, and what theory says of their errors."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from nonsmooth.analysis.measurements.timing import Clock


class LeftOut(Exception):
    """A study that a scene does not allow; the message says why."""


@dataclass(frozen=True)
class Assessment:
    """What a result is worth.

    Attributes:
        error: distance from the reference, in the study's quantity; 0 only where they are equal exactly.
        details: other errors by name.
        work: counts of what was done, by name.
        note: what else there is to say.
    """

    error: float
    details: Mapping[str, float] = field(default_factory=dict)
    work: Mapping[str, int] = field(default_factory=dict)
    note: str = ""


@dataclass(frozen=True)
class Trial:
    """One method at one setting.

    Attributes:
        method: name of the method.
        work: what is timed; it looks at the clock where it loops, and leaves it alone where it does not.
        judge: the error of its result; not timed.
        parameter: what the setting is called; None for a method without one.
        setting: value of the parameter.
        repeats: how often ``work`` does the same thing; the time is divided by it.
    """

    method: str
    work: Callable[[Clock], Any]
    judge: Callable[[Any], Assessment]
    parameter: str | None = None
    setting: float | None = None
    repeats: int = 1

    @property
    def name(self) -> str:
        """For example ``hysteresis, width 0.001``."""
        return self.method if self.setting is None else f"{self.method}, {self.parameter} {self.setting:.3g}"


@dataclass(frozen=True)
class Order:
    """How a method's error depends on its setting.

    Attributes:
        expected: slope of log(error) over log(setting) that theory predicts; None where it predicts none.
        why: the reason, in one sentence.
    """

    expected: float | None
    why: str


@dataclass(frozen=True)
class StudyPlan:
    """What a study does for one scene.

    Attributes:
        reference: what results are compared with.
        trials: by method, settings from easy to hard.
        orders: what theory says of the methods that have a setting.
        note: what there is to say of the scene.
        rounding: errors below this are rounding, or beyond the digits of the reference, and tell no order.
    """

    reference: str = ""
    trials: tuple[Trial, ...] = ()
    orders: Mapping[str, Order] = field(default_factory=dict)
    note: str = ""
    rounding: float = 1e-13
