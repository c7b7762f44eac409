"""``python -m tests.evidence.measured_tables``: what is said of tables as they are measured, beside small steps.

Tables of 4 to 12 wheels in millimetres, whole degrees and speeds within two per cent, under every rule that is
followed, and tables that a half turn does not change.  Answers and bodies are written apart, a line of JSON each, into
the folder ``--into``: what stands there is not computed again, so that a study goes on where it was stopped, and bodies
that were followed once serve every later version of the answers (to ask anew, remove ``answers.jsonl``).

An answer is *wrong* where bodies contradict it, *open* where it is ``undecided`` though all bodies from within twice
the accuracy end within it, *not followed* where following bodies takes longer than ``--most`` seconds of a processor.
The study ends with status 1 where an answer is wrong.  A table takes about two seconds.
"""

from __future__ import annotations

import argparse
import json
import signal
import tempfile
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from nonsmooth.proofs import clause_registry
from nonsmooth.proofs.answers.answer import Answer
from nonsmooth.proofs.answers.position import position_answer
from nonsmooth.proofs.clauses.workspace import Workspace
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane_arrays import Floats
from tests.oracles.measured_tables import MeasuredTable, SmallSteps

OFF = (0.0, 3.0, 9.0)  # degrees by which headings are wrong
RULES = ("nearest", "box", "ellipse", "roller")
KINDS = ("measured", "symmetric")
STARTS = 12  # on the border of a disc
LONG, LONGEST = 12.0, 60.0  # seconds, after which bodies are taken to be where they end
LATER = (1.0, 1.2, 1.6, 2.4)  # of a time after which bodies are said to be somewhere, and to stay
CLOSE = 0.01  # accuracies: starts that are close by
# of a distance: steps across lines where the field jumps are a 25th of it, and bodies go to and fro over such a line
STEPS = {"nearest": 1.1, "box": 1.1, "ellipse": 1.001, "roller": 1.001}
MOST = 90.0  # seconds of a processor
FINER = 4.0  # times as small are steps where coarser ones do not confirm an answer
NUMBERS = ("accuracy", "ends_within", "within", "swings_out_to", "after", "stays_within")

Record = dict[str, Any]


@dataclass(frozen=True)
class Question:
    """One table under one rule."""

    kind: str
    seed: int
    rule: str

    @property
    def name(self) -> str:
        return f"{self.kind} {self.seed} {self.rule}"

    @property
    def table(self) -> MeasuredTable:
        if self.kind == "symmetric":
            return MeasuredTable.symmetric(self.seed, self.rule)
        return MeasuredTable.random(self.seed, self.rule, off=OFF[self.seed % len(OFF)])


def questions(seeds: range, kinds: list[str], *, in_turn: bool) -> Iterator[Question]:
    """Seed by seed, every table under all rules, or (in turn) the first under the first rule, the next under the next.

    Tables that a half turn does not change are asked about under the smooth rules: where two wheels are equally near
    none is the nearer one, and under rule ``box`` bodies stick.
    """
    for seed in seeds:
        for kind in kinds:
            rules = RULES if kind == "measured" else ("ellipse", "roller")
            for rule in (rules[seed % len(rules)],) if in_turn else rules:
                yield Question(kind, seed, rule)


class Lines:
    """A file of JSON, a line for each key; a line that was cut off is not read."""

    def __init__(self, file: Path) -> None:
        self._file = file
        self.known: dict[str, Record] = {}
        for line in file.read_text(encoding="utf-8").splitlines() if file.exists() else ():
            try:
                found = json.loads(line)
            except json.JSONDecodeError:
                continue
            self.known[found["key"]] = found

    def of(self, key: str, compute: Callable[[], Record]) -> Record:
        """What stands under a key, or is computed and written there."""
        if key not in self.known:
            begin = time.process_time()
            found = {"key": key, **compute(), "seconds": round(time.process_time() - begin, 2)}
            self.known[key] = found
            with self._file.open("a", encoding="utf-8") as lines:
                lines.write(json.dumps(found) + "\n")
        return self.known[key]


# ---- answers -------------------------------------------------------------------------------------


def position(scene: Scene) -> Answer:
    """The answer, from the clauses that it needs."""
    work = Workspace(scene, sample=False)
    for clause in clause_registry.CLAUSES:
        if clause.name in {"equilibrium", "translation"}:
            work.earlier[clause.name] = clause.decided(work)
    return position_answer(scene, work.earlier)


def answered(question: Question) -> Record:
    """The verdict, its numbers and its sentences."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "table.toml"
        file.write_text(question.table.toml, encoding="utf-8")
        answer = position(load_scene(str(file)))
    numbers = {name: answer[name] for name in NUMBERS}
    said = {name: None if value is None else float(value) for name, value in numbers.items()}
    return {"verdict": str(answer.verdict), **said, "words": repr(answer)}


# ---- bodies --------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Bodies:
    """Bodies on the table of a question, whose paths are written down."""

    question: Question
    lines: Lines

    @cached_property
    def _steps(self) -> SmallSteps:
        return SmallSteps(self.question.table)

    def from_border(self, radius: float, times: tuple[float, ...], near: float) -> tuple[float, float]:
        """How far those from the border of a disc and from its centre are at times at most, and were at most before.

        Args:
            radius: of the disc.
            times: increasing.
            near: a length that matters.
        """
        key = f"{self.question.name} {radius:.9g} {times} {near:.9g}"
        found = self.lines.of(key, lambda: self._followed(radius, times, near))
        return found["ends"], found["farthest"]

    def _followed(self, radius: float, times: tuple[float, ...], near: float) -> Record:
        angles = 2 * np.pi * np.arange(STARTS) / STARTS + 0.1
        starts: Floats = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        places, farthest = self._steps.paths(np.concatenate([starts, np.zeros((1, 2))]), times, near)
        return {"ends": float(np.hypot(places[..., 0], places[..., 1]).max()), "farthest": float(farthest.max())}


def judged(answer: Record, bodies: Bodies) -> str:
    """What bodies say to an answer: ``wrong``, ``open``, or empty where they say the same."""
    accuracy, verdict = answer["accuracy"], answer["verdict"]
    if verdict == "undecided":
        far, _ = bodies.from_border(2 * accuracy, (LONG,), accuracy)
        near, _ = bodies.from_border(accuracy, (LONG,), accuracy)
        return "open" if max(near, far) <= accuracy else ""
    return "" if any(_confirms(answer, bodies, finer) for finer in (1.0, FINER)) else "wrong"


def _confirms(answer: Record, bodies: Bodies, finer: float) -> bool:
    """Whether bodies do what an answer says of them, with steps so much smaller."""
    accuracy, most = answer["accuracy"], STEPS[bodies.question.rule]
    match answer["verdict"]:
        case "comes near":
            near, times = answer["ends_within"], tuple(answer["after"] * later for later in LATER)
            ends, farthest = bodies.from_border(answer["within"], times, near / finer)
            swing = answer.get("swings_out_to")  # lines of earlier versions have none
            return ends <= most * near and (swing is None or farthest <= most * swing)
        case "leaves":
            if bodies.from_border(CLOSE * accuracy, (LONG,), accuracy / finer)[1] > accuracy:
                return True
            return bodies.from_border(CLOSE * accuracy, (LONGEST,), accuracy / finer)[1] > accuracy
        case "stays near":
            stays = answer["stays_within"]
            return stays is None or bodies.from_border(stays, (LONG,), stays / finer)[1] <= most * stays
        case "comes home":
            return bodies.from_border(CLOSE * accuracy, (LONG,), accuracy / finer)[0] <= accuracy
    raise ValueError(answer["verdict"])


# ---- the study -----------------------------------------------------------------------------------


class TooLongError(RuntimeError):
    """Bodies take too long to follow."""


@contextmanager
def at_most(seconds: float) -> Iterator[None]:
    """Raise :class:`TooLongError` after some seconds of the processor."""

    def stop(*_: object) -> None:
        raise TooLongError

    before = signal.signal(signal.SIGVTALRM, stop)
    signal.setitimer(signal.ITIMER_VIRTUAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_VIRTUAL, 0)
        signal.signal(signal.SIGVTALRM, before)


def study(asked: Iterator[Question], folder: Path, most: float = MOST) -> int:
    """Print what is wrong, open or not followed, and the shares; how much is wrong."""
    folder.mkdir(parents=True, exist_ok=True)
    answers, bodies = Lines(folder / "answers.jsonl"), Lines(folder / "bodies.jsonl")
    counts: Counter[tuple[str, str, str]] = Counter()
    for question in asked:
        answer = answers.of(question.name, lambda asked=question: answered(asked))  # type: ignore[misc]
        try:
            with at_most(most):
                found = judged(answer, Bodies(question, bodies))
        except TooLongError:
            found = "not followed"
        counts[question.kind, question.rule, answer["verdict"]] += 1
        if found:
            counts[question.kind, question.rule, found] += 1
            print(f"{found}: {question.name}: {answer['words']}", flush=True)
    for (kind, rule, said), number in sorted(counts.items()):
        print(f"{kind:9}  {rule:8}  {said:10}  {number}")
    return sum(number for (_, _, said), number in counts.items() if said == "wrong")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", default="0,40", help="the first one, and the one behind the last")
    parser.add_argument("--kinds", default=",".join(KINDS), help="of tables, divided by commas")
    parser.add_argument("--in-turn", action="store_true", help="each table under one rule, in turn")
    parser.add_argument("--into", type=Path, default=Path("build/measured_tables"))
    parser.add_argument("--most", type=float, default=MOST, help="seconds for the bodies on one table")
    chosen = parser.parse_args()
    first, last = (int(part) for part in chosen.seeds.split(","))
    asked = questions(range(first, last), chosen.kinds.split(","), in_turn=chosen.in_turn)
    raise SystemExit(1 if study(asked, chosen.into, chosen.most) else 0)
