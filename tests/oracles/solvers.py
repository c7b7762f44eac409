"""Z3 and cvc5 on questions in nonlinear real arithmetic, with a time limit that holds."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection
from typing import NamedTuple, TypeAlias

import z3

Solve: TypeAlias = Callable[[str, float], str]  # from a script and seconds to sat, unsat or unknown

RUNS = 3  # of quick questions, the shortest of which counts
QUICK = 2.0  # seconds
STARTS = 20.0  # seconds that a process may take beside the questions


class Question(NamedTuple):
    """A script, and what an answer to it would refute."""

    about: str
    text: str


class Answer(NamedTuple):
    """What a solver says of a V: ``proved``, ``refuted`` or ``unknown``, about what, and after how many seconds."""

    said: str
    about: str
    seconds: float


def with_z3(text: str, seconds: float) -> str:
    """Z3, by its procedure for nonlinear real arithmetic."""
    solver = z3.SolverFor("QF_NRA")
    solver.set("timeout", max(1, int(seconds * 1000)))
    solver.from_string(text)
    return str(solver.check())


def with_cvc5(text: str, seconds: float) -> str:
    """cvc5, by cylindrical algebraic coverings."""
    import cvc5  # a dependency of the benchmarks only

    manager = cvc5.TermManager()
    solver = cvc5.Solver(manager)
    solver.setOption("nl-cov", "true")
    solver.setOption("tlimit-per", str(max(1, int(seconds * 1000))))
    symbols = cvc5.SymbolManager(manager)
    parser = cvc5.InputParser(solver, symbols)
    parser.setStringInput(cvc5.InputLanguage.SMT_LIB_2_6, text, "question")
    answer = ""
    while not (command := parser.nextCommand()).isNull():
        answer = str(command.invoke(solver, symbols)).strip() or answer
    return answer


def ask(solve: Solve, questions: Sequence[Question], patience: float) -> Answer:
    """All questions until one is answered, or time is over."""
    begin, left_open = time.perf_counter(), ""
    for question in questions:
        left = patience - (time.perf_counter() - begin)
        said = solve(question.text, left) if left > 0 else "unknown"
        if said == "sat":
            return Answer("refuted", question.about, time.perf_counter() - begin)
        if said != "unsat":
            left_open = left_open or question.about
    return Answer("unknown" if left_open else "proved", left_open, time.perf_counter() - begin)


def ask_apart(solve: Solve, questions: Sequence[Question], patience: float) -> Answer:
    """The same in a process that is ended when time is over: within coverings cvc5 does not look at the clock."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_answer, args=(theirs, solve, list(questions), patience))
    process.start()
    found: Answer | None = ours.recv() if ours.poll(patience + STARTS) else None
    process.kill()
    process.join()
    return found or Answer("unknown", "a question that was not ended in time", patience)


def _answer(channel: Connection, solve: Solve, questions: Sequence[Question], patience: float) -> None:
    solve("(set-logic QF_NRA)(declare-const x Real)(assert (> (* x x) 2.0))(check-sat)", 1)  # loads the library
    found = ask(solve, questions, patience)
    if found.seconds < QUICK:
        found = min((found, *(ask(solve, questions, patience) for _ in range(RUNS - 1))), key=lambda a: a.seconds)
    channel.send(found)
