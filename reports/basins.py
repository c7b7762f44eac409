"""A map of ends: which starts are followed, how many end in which way, and the kinds of ends that read the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from nonsmooth.analysis.fields.kinematics import Kinematics
from nonsmooth.analysis.trajectories.maps import SettleMap
from nonsmooth.analysis.trajectories.result import EndReason

MAX_GRID = 500  # starts in a row: a quarter of a million paths, some 40 MB of JSON
PLACED = (EndReason.REST, EndReason.TURNING, EndReason.APPROACH)  # ends whose place is where the body stays


@dataclass(frozen=True)
class GridRun:
    """What to map.

    Attributes:
        count: starts in a row and in a column.
        theta: heading at the start (radian).
        until: time at which the map is taken; None follows every start to its end.
        kinematics: exact pose or leading order.
    """

    count: int
    theta: float
    until: float | None
    kinematics: Kinematics


class Part(NamedTuple):
    """How many starts end in one way; the parts of a map add up to all its starts."""

    text: str
    starts: int


def parts_text(parts: Sequence[Part]) -> str:
    """``961 starts: 896 the body rests, 65 still moving at the last time``; the largest part first."""
    named = ", ".join(f"{part.starts} {part.text}" for part in sorted(parts, key=lambda part: -part.starts))
    return f"{sum(part.starts for part in parts)} starts: {named}"


def parts_record(parts: Sequence[Part]) -> list[dict[str, Any]]:
    """JSON of the parts."""
    return [{"end": part.text, "starts": part.starts} for part in parts]


@dataclass(frozen=True)
class Basin:
    """Kinds of ends that read the same: their numbers in the map, and the share of the starts that end so."""

    text: str
    kinds: tuple[int, ...]
    share: float


def map_parts(found: SettleMap) -> list[Part]:
    """How many starts end in each way, wherever that is."""
    reasons = [found.ends[k][0] for k in found.basin]
    return [Part(reason.value, reasons.count(reason)) for reason in dict.fromkeys(reasons)]


def basins(found: SettleMap) -> list[Basin]:
    """The ends, largest share first; told apart by place only where the body stays there."""
    kinds: dict[str, list[int]] = {}
    for k, (reason, place) in enumerate(found.ends):
        kinds.setdefault(f"{reason.value}: {place}" if reason in PLACED else reason.value, []).append(k)
    found_basins = [Basin(text, tuple(own), sum(found.shares[k] for k in own)) for text, own in kinds.items()]
    return sorted(found_basins, key=lambda basin: -basin.share)
