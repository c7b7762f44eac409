"""One row of a measurement: what was measured, what came out, and how far that is from its reference."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import TypeAlias

EPSILON = 2.0**-52  # relative spacing of doubles


class Outcome(StrEnum):
    """How a result came about; a row of a stress case may also say it in words, such as a verdict."""

    DONE = "done"
    TIME_OUT = "time-out"
    FAILED = "failed"
    REFUSED = "refused"
    FAULT = "fault"


@dataclass(frozen=True)
class ResultRow:
    """One result beside its reference.

    Attributes:
        name: the study, or what a stress case stresses.
        method: the method that a study measures.
        parameter: what is varied: the name of the setting in a study, its value as text in a case.
        setting: value of the parameter in a study.
        outcome: an :class:`Outcome`, a verdict, or the end of a path.
        error: distance from the reference, 0 only where they are equal exactly; None where nothing was computed.
        condition: factor by which rounding of the input is amplified; None where no system is solved.
        ok: whether the criterion holds: for a study, that there is a result.
        seconds: processor time of a study's method.
        reference: what a study compares with.
        note: the criterion, the refusal, or what else there is to say.
        details: other errors by name.
        work: counts of what was done, by name.
    """

    name: str
    method: str = ""
    parameter: str | None = None
    setting: float | None = None
    outcome: str = Outcome.DONE
    error: float | None = None
    condition: float | None = None
    ok: bool = True
    seconds: float | None = None
    reference: str = ""
    note: str = ""
    details: Mapping[str, float] = field(default_factory=dict)
    work: Mapping[str, int] = field(default_factory=dict)


Rows: TypeAlias = Iterator[ResultRow]


def judged(
    case: str, parameter: str, outcome: str, error: float, bound: float, *, condition: float | None = None, why: str
) -> ResultRow:
    """A row that is ok iff its error is a number within a bound; ``why`` says where the bound comes from."""
    ok = math.isfinite(error) and error <= bound
    criterion = f"error <= {bound:.2g}: {why}"
    return asserted(case, parameter, outcome, criterion, ok=ok, error=error, condition=condition)


def asserted(
    case: str,
    parameter: str,
    outcome: str,
    criterion: str,
    *,
    ok: bool,
    error: float | None = None,
    condition: float | None = None,
) -> ResultRow:
    """A row whose criterion need not be a bound on its error."""
    known = ResultRow(case, parameter=parameter, outcome=outcome, ok=ok, note=criterion)
    return replace(known, error=error, condition=condition)


def refused(case: str, parameter: str, message: object, *, expected: bool) -> ResultRow:
    """A refusal; ok where the case asks for one."""
    return asserted(case, parameter, Outcome.REFUSED, " ".join(str(message).split()), ok=expected)


def counted(number: int, what: str) -> str:
    """``1 event``, ``2 events``, ``2 switches``."""
    plural = "es" if what.endswith("ch") else "s"
    return f"{number} {what}{'' if number == 1 else plural}"
