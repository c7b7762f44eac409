"""``python -m tests.evidence.measured_tables``: what is said of tables as they are measured, beside small steps.

Tables of 4 to 12 wheels in millimetres, whole degrees and speeds within two per cent, and tables that a half turn does
not change, under every rule that is followed.  A line for each answer that is wrong, or open though all bodies from
within twice the accuracy come near; at the end the shares.  It ends with status 1 where an answer is wrong.
``--seeds 0,20`` takes some; a table takes some seconds.
"""

from __future__ import annotations

import argparse
import math
import tempfile
from collections import Counter
from pathlib import Path

import numpy as np

from nonsmooth.proofs.answers.answer import Answer
from nonsmooth.proofs.answers.position import position_answer
from nonsmooth.proofs.clauses import registry
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.scene import Scene
from tests.oracles.measured_tables import MeasuredTable, SmallSteps

OFF = (0.0, 3.0, 9.0)  # degrees by which headings are wrong
RULES = ("nearest", "ellipse", "roller")
STARTS = 4
LONG = 12.0  # seconds, after which bodies are taken to be where they end
STEPS = 1.1  # of a distance: what small steps across a line where the field jumps may leave of it


def position(scene: Scene) -> Answer:
    """The answer, from the clauses that it needs."""
    work = Workspace(scene, sample=False)
    for clause in registry.CLAUSES:
        if clause.name in {"equilibrium", "translation"}:
            work.earlier[clause.name] = work.decided(clause)
    return position_answer(scene, work.earlier)


def reached(body: SmallSteps, radius: float, seconds: float, near: float) -> tuple[float, float]:
    """How far bodies from the border of a disc are after a time, and were at most."""
    angles = 2 * math.pi * np.arange(STARTS) / STARTS + 0.1
    ends = [body.end(radius * np.array([math.cos(a), math.sin(a)]), seconds, near) for a in angles]
    return max(float(np.hypot(*end)) for end, _ in ends), max(farthest for _, farthest in ends)


def judged(table: MeasuredTable, answer: Answer) -> str:
    """Whether small steps say the same: ``wrong``, ``open`` where they alone decide, else empty."""
    body, accuracy = SmallSteps(table), float(answer["accuracy"])
    if answer.verdict == "comes near":
        near = float(answer["ends_within"])
        return (
            "" if reached(body, float(answer["within"]), float(answer["after"]), near)[0] <= STEPS * near else "wrong"
        )
    if answer.verdict == "leaves":
        return "" if reached(body, accuracy / 100, 5 * LONG, accuracy)[1] > accuracy else "wrong"
    if answer.verdict == "undecided":
        return "open" if reached(body, 2 * accuracy, LONG, accuracy)[0] <= accuracy else ""
    return "" if reached(body, accuracy / 100, LONG, accuracy)[0] <= accuracy else "wrong"


def study(seeds: range, kinds: list[str]) -> int:
    """Print what is wrong or open, and the shares; how much is wrong."""
    wrong = 0
    for kind in kinds:
        for rule in RULES:
            if kind == "symmetric" and rule == "nearest":
                continue  # of two wheels equally near none is the nearer one
            verdicts, open_ones = Counter[str](), 0
            for seed in seeds:
                measured = MeasuredTable.random(seed, rule, off=OFF[seed % len(OFF)])
                table = measured if kind == "measured" else MeasuredTable.symmetric(seed, rule)
                with tempfile.TemporaryDirectory() as folder:
                    file = Path(folder) / "table.toml"
                    file.write_text(table.toml, encoding="utf-8")
                    answer = position(load_scene(str(file)))
                found = judged(table, answer)
                wrong, open_ones = wrong + (found == "wrong"), open_ones + (found == "open")
                verdicts[str(answer.verdict)] += 1
                if found:
                    print(f"{found}: {kind} table {seed}, rule {rule}: {answer!r}", flush=True)
            counts = ", ".join(f"{verdict} {number}" for verdict, number in sorted(verdicts.items()))
            print(f"{kind:9}  {rule:8}  {counts}; open though all come near: {open_ones}", flush=True)
    return wrong


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", default="0,40")
    parser.add_argument("--kinds", default="measured,symmetric")
    asked = parser.parse_args()
    first, last = (int(part) for part in asked.seeds.split(","))
    raise SystemExit(1 if study(range(first, last), asked.kinds.split(",")) else 0)
