"""Adversarial ties of plain systems at large: counts of verdicts, and no contradiction with the oracle."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from nonsmooth.proofs.findings import Equilibrium
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.ray_moves import decide_equilibrium
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.benchmarks.conftest import Stopwatch
from tests.proofs.plain_ties import Oracle, contradictions, random_tie

EQUILIBRIA, VERDICTS = 5_000, 300
FIRST = 10_000  # seeds apart from those of the tests


def load(folder: Path, seed: int) -> SwitchedSystem:
    first, second = random_tie(seed).rhs
    file = folder / "tie.toml"
    file.write_text(f'[system]\nstates = ["x", "y"]\nrhs = ["{first}", "{second}"]\n', encoding="utf-8")
    return load_system(file)


def test_equilibria_of_ties(tmp_path: Path, stopwatch: Stopwatch) -> None:
    seen: Counter[str] = Counter()
    wrong = []
    for seed in range(FIRST, FIRST + EQUILIBRIA):
        found = decide_equilibrium(plane_cells(load(tmp_path, seed)))
        seen[str(found)] += 1
        if (found is Equilibrium.HOLDS) != Oracle(random_tie(seed)).rests_at_origin():
            wrong.append(seed)
    stopwatch.report(f"{EQUILIBRIA} equilibria of tied systems: {dict(seen)}, contradictions {len(wrong)}")
    assert wrong == []
    assert not seen[str(Equilibrium.UNDECIDED)]


def test_verdicts_on_ties(tmp_path: Path, stopwatch: Stopwatch) -> None:
    seen: Counter[str] = Counter()
    against = {}
    for seed in range(FIRST, FIRST + VERDICTS):
        result = decide_system(load(tmp_path, seed))
        seen[str(result.verdict)] += 1
        found = contradictions(result, Oracle(random_tie(seed)))
        if found or not result.check():
            against[seed] = found
    share = seen["undecided"] / VERDICTS
    counts = f"{VERDICTS} tied systems: {dict(seen)} ({share:.0%} undecided), contradictions {len(against)}"
    stopwatch.report(counts)
    assert against == {}
