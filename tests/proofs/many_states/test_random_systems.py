"""Random systems in three to six states against eigenvalues, sliding eigenvalues and simulations."""

from __future__ import annotations

from typing import Any

import mpmath
import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.decay_rate import DecayKind
from nonsmooth.reports.interface.system import System
from tests.oracles.floats import runge_kutta, value, velocity
from tests.plain import built
from tests.thorough import few

ATTRACTS, STAYS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE
NAMES = "abcdef"
Matrix = NDArray[Any]


def linear(row: Matrix, names: str = NAMES) -> str:
    return " + ".join(f"({int(c)})*{name}/4" for c, name in zip(row, names, strict=False) if c) or "0"


def random_matrix(rng: np.random.Generator, count: int) -> Matrix:
    matrix = rng.integers(-6, 7, (count, count)) - int(rng.integers(0, 12)) * np.eye(count, dtype=int)
    return np.asarray(matrix)


def largest_real_part(matrix: Matrix) -> float:
    with mpmath.workdps(30):
        values = mpmath.eig(mpmath.matrix(matrix.tolist()), left=False, right=False)
        return float(max(mpmath.re(value) for value in values))


@few(1)
@pytest.mark.parametrize("seed", range(30))
def test_linear_systems_against_eigenvalues(seed: int) -> None:
    rng = np.random.default_rng(seed)
    for _ in range(2):
        count = int(rng.integers(3, 7))
        matrix = random_matrix(rng, count)
        result = decide_system(built([linear(row) for row in matrix], states=NAMES))
        truth = largest_real_part(matrix)
        assert result.check()
        if abs(truth) > 1e-9:
            assert result.verdict is (ATTRACTS if truth < 0 else LEAVES)
            assert result.reach.everywhere is (truth < 0)
        else:
            assert result.verdict in (STAYS, LEAVES)


def relay(rng: np.random.Generator) -> tuple[int, list[str], float | None]:
    """``x' = A x - b sgn(c x)`` with the largest real part along its sliding surface, infinite where it repels."""
    count = int(rng.integers(3, 6))
    matrix, b, c = random_matrix(rng, count), rng.integers(-3, 4, count), rng.integers(-2, 3, count)
    rhs = [f"{linear(row)} - ({int(push)})*sgn({linear(c)})" for row, push in zip(matrix, b, strict=True)]
    push = float(b @ c) / 4
    if not push:
        return count, rhs, None
    if push < 0:
        return count, rhs, np.inf
    along = matrix / 4 - np.outer(b, c / 4 @ matrix / 4) / push
    basis = np.linalg.svd(c[None, :].astype(float))[2][1:]
    return count, rhs, float(np.linalg.eigvals(basis @ along @ basis.T).real.max())


@few(1)
@pytest.mark.parametrize("seed", [3, *(k for k in range(12) if k != 3)])
def test_relays_against_their_sliding_motion(seed: int) -> None:
    rng = np.random.default_rng(100 + seed)
    decided = 0
    for _ in range(2):
        _, rhs, slide = relay(rng)
        result = decide_system(built(rhs, states=NAMES))
        assert result.check()
        if slide is None or abs(slide) < 1e-6 or result.verdict is Translation.UNDECIDED:
            continue
        decided += 1
        assert result.verdict is (ATTRACTS if slide < 0 else LEAVES)
        if result.reach.region is not None and result.function is not None and decided == 1:
            _follow_inside(rhs, result, rng)
    assert decided >= 1


def _follow_inside(rhs: list[str], result: StabilityResult, rng: np.random.Generator) -> None:
    """A start of the certified region stays in it and comes nearer, as fast as the rate says."""
    assert result.function is not None
    assert result.reach.region is not None
    names, text = list(result.scene.states), result.function.text
    count, level = len(names), float(result.reach.region.level)

    def value(x: Matrix) -> float:
        return potential(text, names, x)

    direction = rng.normal(size=count)
    low, high = 0.0, 1.0
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (middle, high) if value(middle * direction) < 0.9 * level else (low, middle)
    start = low * direction
    path = System(names, rhs).simulate(start.tolist(), 10.0).trajectory
    values = np.array([value(np.asarray(place)) for place in path.states])
    times = np.array([float(time) for time in path.times])
    assert values[-1] < values[0]
    if result.reach.rate is None:
        bound = np.full(len(times), values[0])
    elif result.reach.rate.decay is DecayKind.EXPONENTIAL:
        bound = values[0] * np.exp(-float(result.reach.rate.kappa) * times)
    else:
        bound = np.maximum(values[0] - float(result.reach.rate.kappa) * times, 0)
    assert (values <= bound + 1e-6 * values[0]).all()


@few(2)
@pytest.mark.parametrize("seed", range(20))
def test_crossed_relays_against_small_steps(seed: int) -> None:
    """Two or three relays: solutions slide along lines and at the point; small steps tell where they go."""
    rng = np.random.default_rng(500 + seed)
    count = int(rng.integers(2, 4))
    a, b = rng.integers(-3, 4, (3, 3)), rng.integers(-1, 2, (3, count)) + 3 * np.eye(3, dtype=int)[:, :count]
    c = np.eye(3, dtype=int)[:count] if seed % 2 else rng.integers(-1, 2, (count, 3)) + np.eye(3, dtype=int)[:count]
    rhs = [
        linear(4 * row) + "".join(f" - ({int(push)})*sgn({linear(4 * c[j])})" for j, push in enumerate(pushes) if push)
        for row, pushes in zip(a, b, strict=True)
    ]
    result = decide_system(built(rhs, states=NAMES))
    assert result.check()
    x = rng.normal(size=(16, 3))
    x *= 0.02 / np.linalg.norm(x, axis=1)[:, None]
    for _ in range(15_000):
        x = np.clip(x + 8e-5 * (x @ a.T - np.sign(x @ c.T) @ b.T), -1, 1)
    sizes = np.linalg.norm(x, axis=1)
    assert result.verdict is not ATTRACTS or sizes.max() < 0.3
    assert result.verdict is not LEAVES or sizes.max() > 0.002


def growth_of_cones(a: Matrix, b: Matrix, rng: np.random.Generator) -> tuple[float, float]:
    """The least and largest exponent of ``x' = A x + B |x|`` from random starts."""
    x = rng.normal(size=(40, len(a)))
    total, step, steps = np.zeros(40), 0.01, 3000

    def field(x: Matrix) -> Matrix:
        return np.asarray(x @ a.T + np.abs(x) @ b.T)

    for k in range(steps):
        x = runge_kutta(field, x, step)
        size = np.linalg.norm(x, axis=1)
        total += np.log(size) * (k > steps // 4)
        x /= size[:, None]
    rates = total / (step * steps * 3 / 4)
    return float(rates.min()), float(rates.max())


@few(1)
@pytest.mark.parametrize("seed", range(12))
def test_cones_against_exponents(seed: int) -> None:
    rng = np.random.default_rng(200 + seed)
    count = int(rng.integers(3, 5))
    a = random_matrix(rng, count)
    b = rng.integers(-3, 4, (count, count)) * (rng.random((count, count)) < 0.3)
    rhs = [
        linear(row) + "".join(f" + ({int(c)})*Abs({NAMES[j]})/4" for j, c in enumerate(bent) if c)
        for row, bent in zip(a, b, strict=True)
    ]
    result = decide_system(built(rhs, states=NAMES))
    low, high = growth_of_cones(a / 4, b / 4, rng)
    assert result.check()
    if result.verdict is ATTRACTS:
        assert high < 0.01
    if result.verdict is LEAVES:
        assert high > -0.01
    if low > 0.05:
        assert result.verdict in (LEAVES, Translation.UNDECIDED)


@few(1)
@pytest.mark.parametrize("seed", range(24))
def test_sectors_against_frozen_and_switching_gains(seed: int) -> None:
    rng = np.random.default_rng(300 + seed)
    for _ in range(2):
        count = int(rng.integers(3, 6))
        a, b, c = random_matrix(rng, count), rng.integers(-3, 4, count), rng.integers(-2, 3, count)
        ends = [a, a + 4 * np.outer(b, c)]
        result = decide_system(built([[linear(row) for row in end] for end in ends], states=NAMES))
        assert result.check()
        gains = [largest_real_part(a + 4 * g * np.outer(b, c)) for g in np.linspace(0, 1, 6)]
        if result.verdict is ATTRACTS:
            assert max(gains) < 0
            x = rng.normal(size=count)
            first = np.linalg.norm(x)
            for _ in range(4000):
                x = x + 0.01 * (ends[int(rng.integers(0, 2))] / 4) @ x
            assert np.linalg.norm(x) < first
        if result.verdict is LEAVES:
            assert max(gains) > 0


@few(1)
@pytest.mark.parametrize("seed", range(12))
def test_mutated_functions_are_refused_or_still_true(seed: int) -> None:
    rng = np.random.default_rng(400 + seed)
    for _ in range(2):
        count, rhs, _ = relay(rng)
        system = built(rhs, states=NAMES)
        result = decide_system(system)
        if result.verdict is not ATTRACTS or result.function is None:
            continue
        names = list(NAMES[:count])
        first, second = rng.choice(names, 2)
        text = f"{result.function.text} + ({int(rng.integers(-8, 9))})*{first}*{second}/8"
        audited = audit(system, text)
        if audited.verdict is not AuditVerdict.VALID:
            continue
        radius = float(system.check.radius)
        for x in rng.uniform(-radius, radius, (200, count)):
            assert potential(text, names, x) > 0
            assert potential_rate(text, rhs, names, x) < 1e-9


def potential(text: str, names: list[str], x: Matrix) -> float:
    return float(value(text, **dict(zip(names, x, strict=True))))


def potential_rate(text: str, rhs: list[str], names: list[str], x: Matrix) -> float:
    """V' at a point off the surfaces, by central differences."""
    field, step = velocity(rhs, x, names), 1e-7
    return (potential(text, names, x + step * field) - potential(text, names, x - step * field)) / (2 * step)
