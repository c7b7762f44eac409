"""One row of a stress test: what was asked, what came out, how far off it is, and whether that is good enough."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

EPSILON = 2.0**-52  # relative spacing of doubles
REFUSED = "refused"


@dataclass(frozen=True)
class StressRow:
    """One case at one parameter.

    Attributes:
        case: what is stressed.
        parameter: how hard, as text.
        verdict: what came out: a verdict, the end of a path, or ``refused``.
        error: relative, against exact or 60-digit arithmetic; None where nothing was computed.
        condition: factor by which rounding of the input is amplified; None where no system is solved.
        ok: whether the case's criterion holds.
        note: the criterion, or the refusal.
    """

    case: str
    parameter: str
    verdict: str
    error: float | None
    condition: float | None
    ok: bool
    note: str

    def record(self) -> dict[str, Any]:
        """JSON-ready: ``case, parameter, verdict, error, condition, ok, note``."""
        return {
            "case": self.case,
            "parameter": self.parameter,
            "verdict": self.verdict,
            "error": _finite(self.error),
            "condition": _finite(self.condition),
            "ok": self.ok,
            "note": self.note,
        }


Rows: TypeAlias = Iterator[StressRow]
Case: TypeAlias = Callable[[], Rows]


def measured(
    case: str, parameter: str, verdict: str, error: float, bound: float, *, condition: float | None = None, why: str
) -> StressRow:
    """A row that is ok iff its error is a number within a bound; ``why`` says where the bound comes from."""
    ok = math.isfinite(error) and error <= bound
    return StressRow(case, parameter, verdict, error, condition, ok, f"error <= {bound:.2g}: {why}")


def refused(case: str, parameter: str, message: object, *, expected: bool) -> StressRow:
    """A refusal; ok where the case asks for one."""
    return StressRow(case, parameter, REFUSED, None, None, expected, " ".join(str(message).split()))


def brief(value: float) -> str:
    """A power of ten as people write it: ``1e-9``."""
    return f"{value:.0e}".replace("e-0", "e-").replace("e+0", "e").replace("e+", "e")


def counted(number: int, what: str) -> str:
    """``1 event``, ``2 events``, ``2 switches``."""
    plural = "es" if what.endswith("ch") else "s"
    return f"{number} {what}{'' if number == 1 else plural}"


def _finite(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
