"""Systems and functions that tempt a proof: each must be refused, or said no stronger than it is."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from flint import fmpq
from numpy.typing import NDArray

from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.proofs.kernel.cells import build_cells, is_empty
from nonsmooth.proofs.many_states.decision import Spectrum, spectrum_of
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.decay_rate import DecayKind, SublevelRegion
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.reports.interface.system import System
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from tests.plain import built
from tests.proofs.forged import with_deciding, with_reach
from tests.thorough import few, keep, thorough

ATTRACTS, STAYS, LEAVES = Translation.ASYMPTOTICALLY_STABLE, Translation.STABLE, Translation.UNSTABLE
VALID, INVALID, OPEN = AuditVerdict.VALID, AuditVerdict.INVALID, AuditVerdict.UNDECIDED
SQUARES = "x**2 + y**2 + z**2"
CHAIN = ["-sgn(x) + y/2", "-sgn(y) + z/2", "-sgn(z) - x/2"]


@few(5)
@pytest.mark.parametrize(
    ("rhs", "lyapunov", "verdicts"),
    [
        (CHAIN, "Abs(x) + Abs(y) + Abs(z)", {VALID}),
        pytest.param(CHAIN, "Max(Abs(x), Abs(y), Abs(z))", {VALID}, marks=thorough),
        (CHAIN, "Abs(x) + Abs(y) - Abs(z)/8", {INVALID}),
        (CHAIN, "x**2 + y**2", {INVALID}),  # zero along an axis
        (CHAIN, "1 - x**2 - y**2 - z**2", {INVALID}),  # positive, but not zero at the point
        (CHAIN, f"{SQUARES} + sgn(x) + 1", {INVALID, OPEN}),  # jumps
        (CHAIN, "x**2 + y**2 + z**2 + z**2*(1 + sgn(y))", {OPEN}),  # jumps off the point
        (["-sgn(x)", "y", "-z"], "4*Abs(x) + y**2 + z**2", {INVALID, OPEN}),  # falls in cells, not along the slide
        (["-sgn(x)", "-sgn(y)", "z"], "4*Abs(x) + 4*Abs(y) + z**2", {INVALID, OPEN}),  # nor on an edge
        (["-sgn(x)", "-sgn(y)", "-z"], "4*Abs(x) + 4*Abs(y) + z**2", {VALID}),
        # nor on a line on which more surfaces vanish than there are states
        pytest.param(
            ["-3*sgn(x)", "-3*sgn(y)", "sgn(z)"],
            "Abs(x) + Abs(y) + Abs(x + y) + Abs(x - y) + Abs(z)",
            {INVALID, OPEN},
            marks=thorough,
        ),
        (["-sgn(x)", "-sgn(y)", "-z"], "Abs(x + y) + Abs(x - y) + z**2", {VALID}),
        (["sgn(x)", "-y", "-z"], SQUARES, {INVALID}),  # both sides leave a surface
        (["2 - sgn(x)", "-y", "-z"], SQUARES, {INVALID}),  # 0 is no mixture of the velocities
        (["-sgn(x) + 2*sgn(y)", "-sgn(y) - 2*sgn(x)", "-z"], "Abs(x) + Abs(y) + z**2", {VALID}),
        (["-x", "-y", "-z + Abs(x)"], "Abs(x) + Abs(y) + Abs(z)/2", {VALID}),  # bends where fields agree
        (["y", "-x", "-z"], SQUARES, {VALID}),
        (["y", "-x + y/1000", "-z"], SQUARES, {INVALID}),
        (["-x", "-y", "-z + 3*Abs(x*y - z)"], SQUARES, {INVALID, OPEN}),  # a curved surface
        (["-x", "-y", "-z + Abs(x*y - z)/2"], SQUARES, {VALID}),
        (["-x", "-y", "-z"], "x**2 + y**2 + z**2 + Abs(x*y - z) - Abs(z)", {VALID}),  # bends on a curve
        # on faces functions mu that are affine on parts, which no sum of squares shows
        (["-x + y*z", "-y - x*z + sat(x, -1/2, 1/2)/2", "-z + Abs(x)/2"], "Abs(x) + Abs(y) + Abs(z)", {VALID}),
    ],
)
def test_audits(rhs: list[str], lyapunov: str, verdicts: set[AuditVerdict]) -> None:
    result = audit(built(rhs), lyapunov)
    assert result.verdict in verdicts
    assert (result.proves is not None) == (result.verdict is VALID)


@pytest.mark.parametrize("rhs", [["y", "-x", "-z"], ["y", "-x", "-z**3"], ["0", "-y", "-z"], ["0", "0", "0"]])
def test_a_v_that_does_not_fall_somewhere_shows_stability_alone(rhs: list[str]) -> None:
    assert audit(built(rhs), SQUARES).proves is STAYS


def test_a_witness_is_a_point_at_which_v_fails() -> None:
    rhs = ["y", "z", "-x - 2*y - z - 2*sgn(x + y + z)"]
    found = audit(built(rhs), SQUARES).function
    assert found is not None
    assert found.failure is not None
    assert found.failure.value is not None
    x, y, z = found.failure.point
    value = 2 * (x * y + y * z + z * (-x - 2 * y - z - 2 * np.sign(float(x + y + z)).astype(int)))
    assert value == found.failure.value > 0


@few(6)
@pytest.mark.parametrize(
    ("rhs", "verdicts"),
    [
        (["-sgn(x)", "y", "-z"], {LEAVES}),
        (["sgn(x)", "-y", "-z"], {LEAVES}),
        (["2 - sgn(x)", "-y", "-z"], {LEAVES}),
        (["1", "-y", "-z"], {LEAVES}),
        ([["-x + 4*y", "-y", "-z"], ["-x", "-y + 4*x", "-z"]], {LEAVES}),  # a mixture does
        ([["-x", "-y", "-z"], ["x", "-y", "-z"]], {LEAVES}),
        (["-x", "-y", "0"], {STAYS}),
        (["y", "0", "-z"], {LEAVES}),
        (["y", "-x", "-z**3"], {STAYS, Translation.UNDECIDED}),
        (["x**2", "-y", "-z"], {LEAVES, Translation.UNDECIDED}),
        (["-sgn(x)", "-sgn(y)", "0"], {STAYS, Translation.UNDECIDED}),
        (["sqrt(2)*x", "-y", "-z"], {Translation.UNSTABLE}),
        (["-sqrt(2)*x + y", "-y", "-sign(z)/sqrt(3)"], {Translation.ASYMPTOTICALLY_STABLE}),
        (["-x - sign(x + sqrt(2)*y)", "-y", "-z"], {ATTRACTS}),  # two states and one, each by itself
        (["-x - sign(x + sqrt(2)*y)", "-y + z/9", "-z + x/9"], {Translation.UNDECIDED}),  # surfaces are not enclosed
        (["-x**16", "-y**15", "-z"], {Translation.UNDECIDED, LEAVES}),
    ],
)
def test_verdicts_are_never_too_strong(rhs: list[Any], verdicts: set[Translation]) -> None:
    result = decide_system(built(rhs))
    assert result.verdict in verdicts
    assert result.check()


def test_states_by_themselves_may_have_numbers_whose_powers_are_no_floats() -> None:
    """It ended in an error: cells are of no use here, and nothing but the states needs them."""
    assert decide_system(built(["-10**30*x", "-y", "-z"])).verdict is ATTRACTS
    assert decide_system(built(["-10**30*x + z", "-y + x", "-z + y"])).verdict is Translation.UNDECIDED


@pytest.mark.parametrize("third", keep(1, ["-z", "-z + sin(x)/2"]))
def test_a_pendulum_comes_to_rest(third: str) -> None:
    assert decide_system(built(["y", "-sin(x) - y", third])).verdict is ATTRACTS


def test_sines_fractions_and_intervals() -> None:
    assert decide_system(built(["y", "sin(x) - y", "-z"])).verdict is LEAVES
    result = decide_system(built(["-x/(1 + y)", "-y", "-z"]))
    assert result.verdict is ATTRACTS
    assert not result.reach.everywhere  # the denominator vanishes outside the cube
    with pytest.raises(SceneError, match="a smaller check"):
        decide_system(built(["-x/(1/4 + y)", "-y", "-z"]))
    assert decide_system(built(["-k*x + y", "-y", "-z"], {"k": [1, 2]})).verdict is ATTRACTS


def test_the_point_need_not_be_the_origin() -> None:
    result = decide_system(built(["-sgn(x - 1)", "-sgn(y - 2)", "-(z + 1)"], equilibrium=[1, 2, -1]))
    assert result.verdict is ATTRACTS
    assert result.method is Method.LYAPUNOV
    assert decide_system(built(["-sgn(x - 1)", "-y", "-z"])).equilibrium is Equilibrium.FAILS


def test_rays_that_leave() -> None:
    """``(1, 1, 1)`` grows at the rate 1/2 in its cone; with other signs no such ray lies in its own cone."""
    leaves = ["-x/2 + Abs(y)", "-y/2 + Abs(z)", "-z/2 + Abs(x)"]
    result = decide_system(built(leaves))
    assert result.method is Method.ESCAPE
    assert 0 < result.deciding.proofs <= 1 / 2
    assert result.check()
    assert decide_system(built(["-x/2 - Abs(y)/4", "-y/2 - Abs(z)/4", "-z/2 - Abs(x)/4"])).verdict is ATTRACTS


@cache
def decided_chain() -> StabilityResult:
    return decide_system(built(CHAIN, lyapunov="Abs(x) + Abs(y) + Abs(z)"))


def test_forged_results_are_refused() -> None:
    result = decided_chain()
    assert result.check()
    assert not with_deciding(result, verdict=STAYS).check()
    assert not replace(result, scene=built(["-sgn(x) + 9*y", *CHAIN[1:]])).check()
    reach = result.reach
    assert isinstance(reach.region, SublevelRegion)
    higher = replace(reach.region, level=reach.region.level * 2)
    assert not with_reach(result, near=higher, region=higher).check()
    assert reach.rate is not None
    assert not with_reach(result, rate=replace(reach.rate, kappa=reach.rate.kappa * 2)).check()


@pytest.mark.parametrize(
    ("matrix", "spectrum"),
    [
        ([[0, 1, 0], [-1, 0, 0], [0, 0, -1]], Spectrum.NEUTRAL),
        ([[0, 1, 0], [-1, 0, 0], [0, 0, 0]], Spectrum.NEUTRAL),
        ([[0, 1, 0], [0, 0, 0], [0, 0, -1]], Spectrum.GROWING),
        ([[0, 1, 0, 0], [-1, 0, 1, 0], [0, 0, 0, 1], [0, 0, -1, 0]], Spectrum.GROWING),
        ([[0, 1, 0, 0], [-1, 0, 0, 0], [0, 0, 0, 1], [0, 0, -1, 0]], Spectrum.NEUTRAL),
        ([[1, 0, 0], [0, -1, 0], [0, 0, -2]], Spectrum.UNSTABLE),
        ([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [-1, 0, -1, 0]], Spectrum.UNSTABLE),  # s^4 + s^2 + 1
        ([[0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 0, 1], [-4, 0, -5, 0]], Spectrum.NEUTRAL),  # (s^2 + 1)(s^2 + 4)
        ([[-1, 9, 9], [0, -1, 9], [0, 0, -1]], Spectrum.HURWITZ),
    ],
)
def test_spectra(matrix: list[list[int]], spectrum: Spectrum) -> None:
    exact = tuple(tuple(fmpq(value) for value in row) for row in matrix)
    assert spectrum_of(exact, linear=True) is spectrum


def _values(surface: Polynomial, points: NDArray[np.float64]) -> NDArray[np.float64]:
    total = np.zeros(len(points))
    for exponents, value in surface.terms.items():
        total += float(value) * np.prod(points**exponents, axis=1)
    return total


@few(1)
@pytest.mark.parametrize("seed", range(6))
def test_cells_are_those_that_points_are_in(seed: int) -> None:
    rng = np.random.default_rng(seed)
    forms = rng.integers(-3, 4, (4, 4))
    rhs = [
        " - ".join(f"sgn(({f[0]})*x + ({f[1]})*y + ({f[2]})*z + ({f[3]})/8)" for f in forms if f[:3].any())
        for _ in range(3)
    ]
    system = built(rhs)
    cells = build_cells(system, system.check.radius)
    points = rng.uniform(-0.5, 0.5, (60_000, 3))
    values = np.column_stack([_values(surface, points) for surface in cells.surfaces])
    seen = {tuple(int(v) for v in row) for row in np.sign(values) if row.all()}
    assert seen <= {cell.signs for cell in cells.cells}
    for cell in cells.cells:
        if cell.signs not in seen:  # a thin one: not proved to be empty
            guards = [s * e for s, e in zip(cells.surfaces, cell.signs, strict=True)]
            assert not is_empty(guards, system.check.radius)


def test_a_chain_of_relays_arrives_in_time() -> None:
    """``V = |x| + |y| + |z|``: the proved bound on the time of arrival is kept by a solution that slides twice."""
    rate = decided_chain().reach.rate
    assert rate is not None
    assert rate.decay is DecayKind.FINITE
    start = (0.2, -0.15, 0.1)
    path = System(["x", "y", "z"], CHAIN).simulate(start, 2.0).trajectory
    sizes = np.array([np.abs(np.asarray(place, dtype=float)).sum() for place in path.states])
    times = np.array([float(time) for time in path.times])
    assert (sizes <= np.maximum(sizes[0] - float(rate.kappa) * times, 0) + 1e-9).all()
