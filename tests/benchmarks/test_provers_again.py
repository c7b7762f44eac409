"""Thirty verdicts, exported and proved again by Z3 and cvc5: how many of the inequalities each shows, and how fast.

A solver may say ``unknown``, or run out of time; it must never say ``sat``.
"""

from __future__ import annotations

import resource
import time
from collections import Counter
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.reports.exchange.obligations import Obligation, obligations_of, smtlib_text
from tests.reports.exchange.exchanged import NAMES, system
from tests.reports.exchange.provers import z3_answers

VERDICTS = 30
CVC5_MILLISECONDS = 1_000
CVC5_SECONDS = 6  # of a processor for all queries of a verdict


def decided() -> list[tuple[str, list[Obligation]]]:
    """Thirty systems with their obligations: the twenty that are exchanged, then random switched linear ones."""
    found: list[tuple[str, list[Obligation]]] = []
    rng = np.random.default_rng(44)
    made = [(name, system(name)) for name in NAMES]
    for k in range(2 * VERDICTS):
        a = rng.integers(-5, 6, size=(2, 2, 2)) - 4 * np.eye(2, dtype=int)
        cones = [[rng.integers(-3, 4, size=2)], None] if k % 2 else None
        made.append((f"random {k}", ns.System.from_matrices(list(a), cones)))
    for name, own in made:
        try:
            found.append((name, obligations_of(own.check().certificate(), name)))
        except (NoCertificateError, ns.SceneError):
            continue  # undecided, or by numbers alone
        if len(found) == VERDICTS:
            return found
    raise AssertionError(f"only {len(found)} verdicts")


def cvc5_answers(file: Path) -> list[str]:
    """What cvc5 answers before its process is stopped: of some queries it does not keep its own limit of time."""
    pytest.importorskip("cvc5", reason="cvc5 is a dependency of the benchmarks only: pip install '.[bench]'")
    fork = get_context("fork")
    here, there = fork.Pipe(duplex=False)
    child = fork.Process(target=_send_answers, args=(file, there))
    child.start()
    there.close()
    found: list[str] = []
    with suppress(EOFError):
        while True:
            found.append(here.recv())
    child.join()
    return found


def _send_answers(file: Path, there: Connection) -> None:
    import cvc5

    most = int(resource.getrusage(resource.RUSAGE_SELF).ru_utime) + CVC5_SECONDS
    resource.setrlimit(resource.RLIMIT_CPU, (most, most))
    solver = cvc5.Solver()
    solver.setOption("incremental", "true")
    solver.setOption("tlimit-per", str(CVC5_MILLISECONDS))
    parser = cvc5.InputParser(solver)
    parser.setFileInput(cvc5.InputLanguage.SMT_LIB_2_6, str(file))
    while not (command := parser.nextCommand()).isNull():
        said = str(command.invoke(solver, parser.getSymbolManager())).strip()
        if said:
            there.send(said)


def test_thirty_verdicts_are_proved_again(tmp_path: Path) -> None:
    cases = decided()
    for solver, ask in (("Z3", z3_answers), ("cvc5", cvc5_answers)):
        counts: Counter[str] = Counter()
        whole, start = 0, time.perf_counter()
        for name, obligations in cases:
            file = tmp_path / "problem.smt2"
            file.write_text(smtlib_text(obligations, [name]), encoding="utf-8")
            found = ask(file)
            assert "sat" not in found, (solver, name, found)
            assert len(found) == len(obligations) or solver == "cvc5", (solver, name, found)
            counts.update(found)
            counts["stopped"] += len(obligations) - len(found)
            whole += found == ["unsat"] * len(obligations)
        seconds = time.perf_counter() - start
        print(f"{solver}: {whole} of {VERDICTS} verdicts, {dict(counts)}, {seconds:.0f} s")
        assert whole > VERDICTS * 3 // 4
