"""The exact audit of a V beside Z3 and cvc5 on the same inequalities, in one run.

Each V is one that the search has found and proved, or one that must fail.  The solvers are asked for a refutation of
every inequality on cells, and of every convex combination of velocities that slides where V bends, as nonlinear real
arithmetic that an oracle builds from the formulas (tests/oracles/solver_questions.py).  They are a second opinion too:
what is proved here they may not refute, and a V with a witness they may not prove.  The time of the audit is that of
formula, cells and proofs; the solvers' is that of the questions alone, which are put together before.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

import pytest

from nonsmooth.proofs.many_states.examination import ExaminedLyapunov
from nonsmooth.proofs.system_audit import AuditResult, audit
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.derivatives import Decrease
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.benchmarks.conftest import Stopwatch
from tests.oracles.solver_questions import Answer, Question, Questions, ask_apart, read, with_cvc5, with_z3
from tests.proofs.system_families import families

PATIENCE = 20.0  # seconds of each solver for one V
RUNS = 3


class Case(NamedTuple):
    """A system, and a V; without one it is searched."""

    name: str
    states: str
    rhs: Sequence[str]
    potential: str | None = None
    at: Sequence[object] | None = None
    radius: str = "1/2"


PLANAR = [
    "relay, viscous 1",
    "relay and spring",
    "crossed relays, contracting",
    "sliding on x + y",
    "sliding with cubic spring",
    "twisting 2, 1",
    "twisting with drift",
    "twisting on skew lines",
    "buck converter",
    "boost converter, current control",
    "cubic friction",
    "van der Pol, reversed",
]
ABS = "Abs(x) + Abs(y) + Abs(z)"
MORE = [
    Case("cascade of relays", "x y z", ["-sgn(x) + y", "-2*sgn(y) + z", "-3*sgn(z)"]),
    Case("sliding control, Utkin", "x y z", ["y", "z", "-x - 2*y - z - 2*sgn(x + y + z)"]),
    Case("Lorenz, rho 1/2", "x y z", ["10*(y - x)", "x/2 - y - x*z", "x*y - 8*z/3"]),
    Case("three relays, V bends", "x y z", ["-sgn(x) + y/2", "-sgn(y) + z/2", "-sgn(z) - x/2"], ABS),
    Case("three relays, one strong, V bends", "x y z", ["-sgn(x) + y", "-sgn(y) + z/2", "-3*sgn(z) - x/2"], ABS),
    Case("ring of relays", "a b c d", ["-sgn(a) + b/2", "-sgn(b) + c/2", "-sgn(c) + d/2", "-sgn(d) - a/2"]),
    Case("cubic terms", "a b c d", ["b", "-a - b + a**2", "-c - c**3 + b*d", "-d + a*c"]),
]
FAILING = [
    Case("energy of a relay, weak", "x y", ["y", "-sign(x) - y**3"], "Abs(x) + y**2/2"),
    Case("relay, a kink too small", "x y", ["y", "-sign(x) - y"], "Abs(x)/8 + x**2 + x*y + y**2"),
    Case("twisting, no cross term", "x y", ["y", "-2*sign(x) + sign(y)/2"], "Abs(x) + y**2/4"),
    Case("sliding, wrong slope", "x y", ["y", "-2*sign(x + y) + x/2"], "Abs(x + y) - x**2 + x*y/2 + y**2/2"),
    Case("indefinite", "x y", ["-sign(x) + y/4", "-sign(y) - x/4"], "Abs(x) - Abs(y)/16 + x**2"),
    Case(
        "three relays, indefinite", "x y z", ["-sgn(x) + y/2", "-sgn(y)", "-sgn(z) - x"], "Abs(x) + Abs(y) - Abs(z)/4"
    ),
    Case("refuted on a face only", "x y z", ["-sgn(x) + y/2", "-sgn(y) + 3*z", "-sgn(z) - x"], ABS + "/16"),
]


def planar_cases() -> list[Case]:
    known = {k.name: k for k in families()}
    return [
        Case(name, "x y", known[name].rhs, None, known[name].check.get("equilibrium"))  # type: ignore[arg-type]
        for name in PLANAR
    ]


def system_of(case: Case, radius: str) -> SwitchedSystem:
    states = case.states.split()
    check = {"equilibrium": list(case.at or [0] * len(states)), "radius": radius}
    document = {"system": {"states": states, "rhs": list(case.rhs)}, "check": check}
    return build_system(document, case.name, Path("case.toml"))


def searched(case: Case) -> tuple[str, str]:
    """V and the half-width of the square or cube on which the search has proved it."""
    result = decide_system(system_of(case, case.radius))
    function = result.function
    assert function is not None
    assert function.formula is not None
    radius = function.radius if isinstance(function, ExaminedLyapunov) else function.domain.radius
    return function.formula.text, str(radius)


def decrease(audited: AuditResult) -> Decrease:
    assert audited.function is not None
    return audited.function.decrease


def text_of(answer: Answer, ours: float) -> str:
    if answer.said == "unknown":
        return f"gives up after {answer.seconds:.0f} s on {answer.about}"
    return f"{answer.said} in {answer.seconds:.3f} s ({answer.seconds / ours:.2f} times)"


def questions_of(case: Case, potential: str, radius: str, rises: str) -> list[Question]:
    states = case.states.split()
    return list(Questions(read(states, case.rhs, case.at or [0] * len(states), radius, potential), rises))


@pytest.mark.parametrize("family", [planar_cases, lambda: MORE, lambda: FAILING], ids=["planar", "more", "failing"])
def test_audits_beside_solvers(family: object, stopwatch: Stopwatch) -> None:
    pytest.importorskip("cvc5", reason="cvc5 is a dependency of the benchmarks only: pip install '.[bench]'")
    ratios: dict[str, list[float]] = {"Z3": [], "cvc5": []}
    assert callable(family)
    for case in family():
        potential, radius = searched(case) if case.potential is None else (case.potential, case.radius)
        system = system_of(case, radius)
        verdict = decrease(audit(system, potential))
        assert verdict is Decrease.STRICT or case.potential is not None
        ours = stopwatch.best(lambda s=system, v=potential: audit(s, v), RUNS)  # type: ignore[misc]
        questions = questions_of(case, potential, radius, ">=")
        said = []
        for name, solve in (("Z3", with_z3), ("cvc5", with_cvc5)):
            answer = ask_apart(solve, questions, PATIENCE)
            said.append(f"{name} {text_of(answer, ours)}")
            ratios[name].append(answer.seconds / ours)
            if verdict is Decrease.UNDECIDED:
                continue
            assert answer.said in (("proved" if verdict is Decrease.STRICT else "refuted"), "unknown"), (case, answer)
            if verdict is not Decrease.STRICT:
                weak = ask_apart(solve, questions_of(case, potential, radius, ">"), PATIENCE)
                wanted = "refuted" if verdict is Decrease.REFUTED else "proved"
                assert weak.said in (wanted, "unknown"), (case, weak)
        stopwatch.report(f"{case.name}: {verdict.name.lower()} in {ours:.3f} s; {'; '.join(said)}")
    for name, found in ratios.items():
        mean = math.exp(sum(map(math.log, found)) / len(found))
        stopwatch.report(
            f"{name} takes {mean:.2f} times as long (geometric mean; {min(found):.2f} to {max(found):.0f})"
        )
