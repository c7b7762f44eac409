"""What is kept of one plain system of a sweep: its verdict, what decided, the V that proves it, its rate and region."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.reports.exact_record import exact_texts, floats
from nonsmooth.reports.sweeps.values import Entry
from nonsmooth.symbolic.files.key_paths import Path
from nonsmooth.symbolic.scene_error import SceneError, one_line

if TYPE_CHECKING:
    from nonsmooth.reports.sweeps.base import Base

REFUSED = "refused"  # the answer of a scene that cannot be checked; why stands beside it
SYSTEM_QUESTIONS = ("stability",)
# Numbers of a record: kappa of `V' <= -kappa V` and of `V' <= -kappa`, in the square of half-width `rate_within` (null:
# everywhere); every start with `V < level` in the square of half-width `within` arrives; in one state every start
# between `from` and `to` does.
SYSTEM_NUMBERS = ("rate", "fall", "rate_within", "level", "within", "from", "to")
SYSTEM_TEXTS = ("method", "V")
SYSTEM_COLUMNS = (*SYSTEM_QUESTIONS, *SYSTEM_TEXTS, *SYSTEM_NUMBERS)


def system_outcome(base: Base, paths: Sequence[Path], entries: Sequence[Entry]) -> Mapping[str, Any]:
    """Check one plain system of a sweep."""
    try:
        result = decide_system(base.system(paths, entries))
    except SceneError as error:
        return refused_system(without_file(error))
    numbers = _numbers(result)
    exact = {name: exact_texts(value) for name, value in numbers.items()}
    return {
        **_record(str(result.verdict), None),
        **_texts(result),
        **{name: floats(value) for name, value in numbers.items()},
        "exact": {name: text for name, text in exact.items() if text is not None},
    }


def refused_system(why: str) -> Mapping[str, Any]:
    """A system without an answer."""
    return _record(REFUSED, one_line(why))


def without_file(error: SceneError) -> str:
    """What is wrong, without the name of the file, which is that of the whole sweep."""
    return f"{error.key}: {str(error).partition(f'{error.key}: ')[2]}" if error.key else str(error)


def _record(stability: str, why: str | None) -> dict[str, Any]:
    """A record without texts and numbers."""
    return {**dict.fromkeys(SYSTEM_COLUMNS), SYSTEM_QUESTIONS[0]: stability, "exact": {}, "why": why}


def _texts(result: StabilityResult) -> dict[str, str | None]:
    function = result.function
    return {"method": str(result.method), "V": None if function is None else function.text}


def _numbers(result: StabilityResult) -> dict[str, Any]:
    found: dict[str, Any] = {}
    reach = result.reach
    if reach.rate is not None and reach.rate_domain is not None:
        found["rate" if reach.rate.decay is DecayKind.EXPONENTIAL else "fall"] = reach.rate.kappa
        found["rate_within"] = reach.rate_domain.radius
    if reach.region is not None:
        found |= {"level": reach.region.level, "within": reach.region.radius}
    intervals = (fact.value for fact in result.deciding.facts if fact.key == "region" and fact.value)
    for interval in intervals:  # of starts, in one state
        found |= {key: interval[key].value for key in ("from", "to")}
    return found
