"""What is kept of one plain system of a sweep: its verdict, what decided, the V that proves it, its rate and region."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from nonsmooth.proofs.many_states.decision import ManyStateResult
from nonsmooth.proofs.system_decision import DecidedSystem, decide_system
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.proofs.systems.scalar_stability import ScalarResult
from nonsmooth.proofs.systems.system_facts import proving_text
from nonsmooth.proofs.systems.system_stability import SystemResult
from nonsmooth.proofs.verdicts import Translation
from nonsmooth.proofs.verified import verified
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
        result = verified(decide_system(base.system(paths, entries)))
    except SceneError as error:
        return refused_system(without_file(error))
    numbers = _scalar_numbers(result) if isinstance(result, ScalarResult) else _numbers(result)
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


def _texts(result: DecidedSystem) -> dict[str, str | None]:
    if isinstance(result, ScalarResult):
        return {"method": result.method, "V": None}
    if isinstance(result, ManyStateResult):
        return {"method": str(result.method), "V": None if result.proving is None else result.proving.formula.text}
    return {"method": str(result.method), "V": None if result.proving is None else proving_text(result)}


def _numbers(result: SystemResult | ManyStateResult) -> dict[str, Any]:
    found: dict[str, Any] = {}
    if result.rate is not None:
        found["rate" if result.rate.decay is DecayKind.EXPONENTIAL else "fall"] = result.rate.kappa
        found["rate_within"] = result.rate_radius
    if result.region is not None:
        found |= {"level": result.region.level, "within": result.region.radius}
    return found


def _scalar_numbers(result: ScalarResult) -> dict[str, Any]:
    right, left, at = result.right.reach, result.left.reach, result.scene.check.equilibrium[0]
    if result.verdict is not Translation.ASYMPTOTICALLY_STABLE or right is None or left is None:
        return {}
    return {"from": at - left, "to": at + right}
