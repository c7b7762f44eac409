"""The rate of the gradient law of section 3.3 of the paper beside Z3 on the same inequalities, in one run.

In a cone between two rays p and q the law gives ``V' = -2 k (a^2 + b^2)`` for ``V = |c|^2 + theta^2``, where a and b
are the slopes of V along the control fields of the two acting inputs.  So ``V' <= -2 k kappa V`` says that
``a^2 + b^2 >= kappa V`` at ``c = s p + t q`` for all ``s, t >= 0`` and theta.  Ours decides it by the Schur complement,
Z3 as nonlinear real arithmetic with a root of two.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import Any

import sympy as sp

from nonsmooth.analysis.cells.nearest import build_nearest_partition
from nonsmooth.proofs.clauses.feedback.control_fields import RowInputs
from nonsmooth.proofs.clauses.feedback.gradient_law import ConeRate, certified_rate
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.benchmarks.conftest import Stopwatch
from tests.oracles.solver_questions import Answer, Question, ask, polynomial, script, with_z3

REQUIRED_OVER_Z3 = 150
PATIENCE = 20.0  # seconds of Z3 for all cones
ROOT = sp.Symbol("root")


def four_wheel_cones() -> tuple[Fraction, tuple[ConeRate, ...]]:
    """The certified rate of the four-wheel array, and its cones."""
    rate = certified_rate(RowInputs(build_nearest_partition(load_scene("four-wheel"))))
    assert rate is not None
    return rate.kappa, rate.cones


def all_hold(cones: Sequence[ConeRate], kappa: Fraction) -> bool:
    """Whether the inequality holds on all cones, with nothing kept from an earlier call."""
    return all(replace(cone).holds(kappa) for cone in cones)


def questions_of(cones: Sequence[ConeRate], kappa: Fraction) -> list[Question]:
    """For each cone: is there a place at which the inequality fails?"""
    return [Question(f"cone {k}", _failure(cone, kappa)) for k, cone in enumerate(cones)]


def _failure(cone: ConeRate, kappa: Fraction) -> str:
    s, t, theta = symbols = sp.symbols("s t theta")
    (px, py), (qx, qy) = (tuple(map(_exact, ray)) for ray in cone.rays)
    x, y = s * px + t * qx, s * py + t * qy
    slopes = (x * _exact(fx) + y * _exact(fy) + theta * _exact(turn) for fx, fy, turn in cone.fields)
    gap = sum(slope**2 for slope in slopes) - sp.Rational(kappa) * (x**2 + y**2 + theta**2)
    known = [f"(>= {s} 0.0)", f"(>= {t} 0.0)", f"(> {ROOT} 0.0)", f"(= (* {ROOT} {ROOT}) 2.0)"]
    return script((*symbols, ROOT), [*known, f"(< {polynomial(sp.expand(gap), (*symbols, ROOT))} 0.0)"])


def _exact(value: Any) -> Any:
    return sp.sympify(str(value)).subs(sp.sqrt(2), ROOT)


def rate_beside_z3() -> tuple[Callable[[], bool], Callable[[], Answer]]:
    """Both, ready to be timed: they agree that the rate is certified, and that twice of it does not hold."""
    kappa, cones = four_wheel_cones()
    for asked, said in ((kappa, "proved"), (2 * kappa, "refuted")):
        assert all_hold(cones, asked) == (said == "proved")
        assert ask(with_z3, questions_of(cones, asked), PATIENCE).said == said
    questions = questions_of(cones, kappa)
    return lambda: all_hold(cones, kappa), lambda: ask(with_z3, questions, PATIENCE)


def test_rate_beside_z3(stopwatch: Stopwatch) -> None:
    ours, theirs = rate_beside_z3()
    slow, fast = stopwatch.in_turn(theirs, ours)
    stopwatch.report(f"eight cones: {1e3 * fast:.2f} ms, Z3 {1e3 * slow:.0f} ms: {slow / fast:.0f} times as long")
    assert slow >= REQUIRED_OVER_Z3 * fast
