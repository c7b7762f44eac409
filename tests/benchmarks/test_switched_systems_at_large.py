"""Plain switched systems at large: the known families with their times, and 1,000 random systems of two kinds."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.benchmarks.conftest import Stopwatch
from tests.proofs.switched_oracle import Judge, Switched, leaves, random_conewise, random_relay
from tests.proofs.system_families import families

COUNT = 1_000
FIRST = 50_000  # seeds apart from those of the tests
MOST_UNDECIDED = 0.02


def system_of(rhs: tuple[str, ...], check: Mapping[str, object] | None = None) -> SwitchedSystem:
    return build_system(
        {"system": {"states": ["x", "y"], "rhs": list(rhs)}, "check": dict(check or {})}, "large", Path("l.toml")
    )


def test_all_families(stopwatch: Stopwatch) -> None:
    wrong, undecided, spent = [], [], []
    for known in families():
        began = time.perf_counter()
        found = str(decide_system(system_of(known.rhs, known.check)).verdict)
        spent.append(time.perf_counter() - began)
        stopwatch.report(f"{known.name:36} {known.truth:22} {found:22} {spent[-1]:6.2f} s  ({known.source})")
        if found == "undecided":
            undecided.append(known.name)
        elif found != known.truth:
            wrong.append(known.name)
    mean = sum(spent) / len(spent)
    stopwatch.report(f"{len(spent)} known systems: wrong {wrong}, undecided {undecided}, mean {mean:.2f} s")
    assert wrong == []
    assert len(undecided) <= len(spent) // 20


@pytest.mark.parametrize("generate", [random_relay, random_conewise])
def test_random_systems(stopwatch: Stopwatch, generate: Callable[[int], Switched]) -> None:
    seen: Counter[str] = Counter()
    against, slowest, began = {}, 0.0, time.perf_counter()
    for seed in range(FIRST, FIRST + COUNT):
        system, here = generate(seed), time.perf_counter()
        found = str(decide_system(system_of(system.rhs)).verdict)
        slowest = max(slowest, time.perf_counter() - here)
        seen[found] += 1
        known = Judge(system).verdict()
        if found != "undecided" and known is not None and found != known:
            against[seed] = (found, known)
        elif found == "asymptotically stable" and leaves(system):
            against[seed] = (found, "a path leaves")
    spent = time.perf_counter() - began
    stopwatch.report(
        f"{COUNT} of {generate.__name__}: {dict(seen)}, wrong {against}, {spent:.0f} s, slowest {slowest:.1f} s"
    )
    assert against == {}
    assert seen["undecided"] <= MOST_UNDECIDED * COUNT
