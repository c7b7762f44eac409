"""A V that is wrong on a face only: points that refute it, beside paths, floats and Z3."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from fractions import Fraction
from itertools import product

import numpy as np
import pytest
from scipy.optimize import linprog

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.many_states.examination import SLIDES_UP, conditions_on, find_slide
from nonsmooth.proofs.system_audit import AuditResult, AuditVerdict, audit
from nonsmooth.proofs.systems.derivatives import Decrease, Refutation
from nonsmooth.symbolic.files.system_builder import parse_lyapunov
from tests.oracles.solver_questions import Questions, read
from tests.oracles.solvers import with_z3
from tests.plain import built
from tests.thorough import few, keep, thorough

ON_A_FACE = [
    (["-sgn(x) + y/2", "-sgn(y) + 3*z", "-sgn(z) - x"], (16, 16, 1)),
    (["-sgn(x) + y/2", "-sgn(y) + z", "-sgn(z) + 5*x"], (1, 4, 1)),
    (["-sgn(x)", "-sgn(y) + 8*z", "-sgn(z) + x"], (6, 1, 1)),
]
GREEK = {"sgn": np.sign, "Abs": np.abs}


def bent(weights: Sequence[int]) -> str:
    return " + ".join(f"{c}*Abs({name})" for c, name in zip(weights, "xyz", strict=True))


def witness(audited: AuditResult) -> tuple[list[Fraction], Fraction]:
    assert audited.function is not None
    failure = audited.function.failure
    assert failure is not None
    assert failure.value is not None
    return list(failure.point), failure.value


def largest_slide(rhs: Sequence[str], weights: Sequence[int], point: Sequence[float]) -> float:
    """The largest derivative of V along all mixtures of fields beside a point that keep its zeros, in floats."""
    zero = [k for k in range(3) if not point[k]]
    fields = []
    for sides in product((-1e-9, 1e-9), repeat=len(zero)):
        beside = np.array(point, dtype=float)
        beside[zero] = sides
        places = dict(zip("xyz", beside, strict=True))
        fields.append([float(eval(text, dict(GREEK), places)) for text in rhs])  # noqa: S307 - this file's formulas
    columns = np.array(fields).T
    gradient = np.array(weights) * np.sign(point)
    equal, right = np.vstack([columns[zero], np.ones(len(fields))]), [0.0] * len(zero) + [1.0]
    found = linprog(-gradient @ columns, A_eq=equal, b_eq=right, bounds=(0, None), method="highs")
    return -float(found.fun)


@few(1)
@pytest.mark.parametrize(("rhs", "weights"), ON_A_FACE)
def test_a_point_of_the_face_refutes(rhs: list[str], weights: tuple[int, ...]) -> None:
    system = built(rhs)
    audited = audit(system, bent(weights))
    assert audited.verdict is AuditVerdict.INVALID
    assert audited.reason == SLIDES_UP
    point, value = witness(audited)
    assert value > 0
    assert 0 in point
    floats = [float(v) for v in point]
    assert largest_slide(rhs, weights, floats) == pytest.approx(float(value), abs=1e-6)
    end = simulate(system_field(system, floats), tuple(floats), 0.01).end
    assert np.dot(weights, np.abs(end.state)) > np.dot(weights, np.abs(floats)) + 0.005 * float(value)


def test_z3_finds_such_points_too() -> None:
    pytest.importorskip("z3")
    rhs, weights = ON_A_FACE[0]
    questions = Questions(read(list("xyz"), rhs, [0, 0, 0], "1/2", bent(weights)), ">")
    assert any(with_z3(question.text, 20) == "sat" for question in questions)


def test_a_face_that_solutions_leave_at_once_refutes_nothing() -> None:
    """Solutions cross x = 0; the gradient of one side and the field of the other would let V rise."""
    found = slides(["1", "-(7/4 + 5*sgn(x)/4)*sgn(y)", "-sgn(z)/4"], (1, 1, 1))
    assert not [failure.point for failure in found if not failure.point[0]]
    assert not slides(["-sgn(x)", "-sgn(y)", "-sgn(z)"], (1, 1, 1))


def test_without_surfaces_there_is_no_face_to_refute_on() -> None:
    """Claims about a smooth system have no signs in their names; an audit that could not prove one asks here."""
    system = built(["-x", "-y", "-z"])
    formula = parse_lyapunov("x**2 + y**2 + z**2", system.states, "t", "lyapunov")
    _, conditions = conditions_on(system, formula, system.check.radius)
    claims = conditions.claims()
    assert claims
    assert [find_slide(system, conditions, claim) for claim in claims] == [None] * len(claims)


def slides(rhs: Sequence[str], weights: Sequence[int]) -> list[Refutation]:
    system = built(rhs)
    formula = parse_lyapunov(bent(weights), system.states, "t", "lyapunov")
    _, conditions = conditions_on(system, formula, system.check.radius)
    found = (find_slide(system, conditions, claim) for claim in conditions.claims())
    return [failure for failure in found if failure is not None]


@thorough  # test_a_face_that_solutions_leave_at_once_refutes_nothing
@pytest.mark.parametrize(("count", "sought"), keep(1, [(3, 1), (5, 2), (14, 2)]))
def test_random_functions_that_are_proved_are_not_refuted(count: int, sought: int) -> None:
    rng = np.random.default_rng(2)
    known: Counter[str] = Counter()
    for _ in range(count):
        a, c = rng.integers(1, 4, 3), rng.integers(1, 5, 3)
        coupled = rng.integers(-6, 7, 3)
        rhs = [f"-{a[k]}*sgn({'xyz'[k]}) + {coupled[k]}*{'yzx'[k]}" for k in range(3)]
        audited = audit(built(rhs), bent(c.tolist()))
        assert audited.function is not None
        function = audited.function
        known[function.decrease] += 1
        if function.decrease is Decrease.STRICT and known[Decrease.STRICT] <= sought:
            assert not slides(rhs, c.tolist())
        if function.reason == SLIDES_UP:
            known[SLIDES_UP] += 1
            point, value = witness(audited)
            assert largest_slide(rhs, c.tolist(), [float(v) for v in point]) == pytest.approx(float(value), abs=1e-6)
    assert known[Decrease.STRICT] >= count // 5
    assert known[SLIDES_UP] >= 1
