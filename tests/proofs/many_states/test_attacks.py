"""Systems and functions in many states that tempt a proof, on faces, beside rest, and relays of high degree."""

from __future__ import annotations

import itertools
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cache
from itertools import product
from math import comb
from random import Random
from typing import Any

import numpy as np
import pytest
import sympy as sp
from flint import fmpq, fmpq_mat
from numpy.typing import NDArray
from scipy.optimize import linprog, nnls

import nonsmooth as ns
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.checker.polynomials import Polynomial as Checked
from nonsmooth.proofs.findings import Equilibrium, Translation
from nonsmooth.proofs.kernel import second_function
from nonsmooth.proofs.kernel.bases import PiecewiseFunction, families
from nonsmooth.proofs.kernel.cells import SignCells, build_cells, is_empty
from nonsmooth.proofs.many_states import lyapunov_search
from nonsmooth.proofs.many_states.decision import Spectrum, escaping_rate, first_cells, spectrum_of
from nonsmooth.proofs.many_states.examination import SLIDES_UP, conditions_on, find_slide
from nonsmooth.proofs.many_states.lyapunov_search import high_degree_relay, proposals
from nonsmooth.proofs.many_states.rest_beside import ray_of_rest
from nonsmooth.proofs.many_states.weak_functions import find_weak_lyapunov
from nonsmooth.proofs.sums_of_squares.ansatz import gram_entries
from nonsmooth.proofs.system_audit import AuditResult, AuditVerdict, audit
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.systems.derivatives import Decrease, Refutation
from nonsmooth.proofs.systems.domain import DecayKind, SublevelRegion
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.reports.interface.system import System
from nonsmooth.symbolic.files.system_builder import parse_lyapunov
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.certificates.inclusion import FloatInclusion, contradiction
from tests.oracles.floats import Floats, velocity
from tests.oracles.solver_questions import Questions, read, with_z3
from tests.plain import built, decided
from tests.proofs.forged import with_deciding, with_reach
from tests.thorough import but, few, keep, thorough

# ---- Systems and functions that tempt a proof: each must be refused, or said no stronger than it is.

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


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize("third", keep(1, ["-z", "-z + sin(x)/2"]))
def test_a_pendulum_comes_to_rest(third: str) -> None:
    assert decide_system(built(["y", "-sin(x) - y", third])).verdict is ATTRACTS


DAMPING = {"cubic": "{0}**3", "quadratic": "Abs({0})*{0}", "of a joint": "{0}**3 + ({0} - {1})**3"}


@pytest.mark.parametrize("friction", but(["quadratic"], DAMPING))
def test_the_energy_of_masses_and_springs_is_found(friction: str) -> None:
    """Of three masses between walls, whose modes have irrational frequencies: no sum of functions of one state each."""
    x, z, u, y, w, v = sp.symbols("x z u y w v")
    energy = y**2 + w**2 + v**2 + x**2 + (x - z) ** 2 + (z - u) ** 2 + u**2
    pairs = [("y", "w"), ("w", "y"), ("v", "v")]
    forces = [
        f"{-sp.diff(energy, q) / 2} - ({DAMPING[friction].format(*pair)})"
        for q, pair in zip((x, z, u), pairs, strict=True)
    ]
    rhs = [entry for pair in zip("ywv", forces, strict=True) for entry in pair]
    found = find_weak_lyapunov(system(list("xyzwuv"), rhs))
    assert found is not None
    assert found.decrease is Decrease.WEAK
    assert sp.simplify(sp.sympify(found.formula.text) / energy).is_constant()


def test_sines_fractions_and_intervals() -> None:
    assert decide_system(built(["y", "sin(x) - y", "-z"])).verdict is LEAVES
    result = decide_system(built(["-x/(1 + y)", "-y", "-z"]))
    assert result.verdict is ATTRACTS
    assert not result.reach.everywhere  # the denominator vanishes outside the cube
    with pytest.raises(SceneError, match="a smaller check"):
        decide_system(built(["-x/(1/4 + y)", "-y", "-z"]))
    assert decide_system(built(["-k*x + y", "-y", "-z"], {"k": [1, 2]})).verdict is ATTRACTS


@pytest.mark.usefixtures("without_reach")
def test_the_point_need_not_be_the_origin() -> None:
    result = decide_system(built(["-sgn(x - 1)", "-sgn(y - 2)", "-(z + 1)"], equilibrium=[1, 2, -1]))
    assert result.verdict is ATTRACTS
    assert result.method is Method.LYAPUNOV
    assert decide_system(built(["-sgn(x - 1)", "-y", "-z"])).equilibrium is Equilibrium.FAILS


def test_rays_that_leave() -> None:
    """``(1, 1, 1)`` grows at the rate 1/2 in its cone; with other signs no such ray lies in its own cone."""
    leaves = built(["-x/2 + Abs(y)", "-y/2 + Abs(z)", "-z/2 + Abs(x)"])
    rate = escaping_rate(leaves, first_cells(leaves))
    assert rate is not None
    assert 0 < rate <= 1 / 2
    result = decide_system(leaves)
    assert result.method is Method.ESCAPE
    assert result.check()
    irrational = decide_system(built(["0", "z/2 - y - 9*Abs(z)", "-3*x - y - 3*z + Abs(x/2 + z/4)/4"]))
    assert (irrational.verdict, irrational.method) == (LEAVES, Method.ESCAPE)
    assert irrational.deciding.entry is None  # no certificate: its direction is irrational
    assert decide_system(built(["-x/2 - Abs(y)/4", "-y/2 - Abs(z)/4", "-z/2 - Abs(x)/4"])).verdict is ATTRACTS


@cache
def decided_chain() -> StabilityResult:
    return decide_system(built(CHAIN, lyapunov="Abs(x) + Abs(y) + Abs(z)"))


@pytest.mark.usefixtures("without_far_starts")
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
    assert spectrum_of(fmpq_mat(matrix), linear=True) is spectrum


# Matrices by their eigenvalues: on the left of the imaginary axis, on it, and on the right, some very near to it.
TINY = Fraction(1, 10**30)
LEFT = ([[-1]], [[-TINY]], [[-TINY, 1], [-1, -TINY]])
ON_AXIS = ([[0]], [[0, 1], [-1, 0]], [[0, TINY], [-TINY, 0]])
GROWING = ([[0, 1], [0, 0]], [[0, 1, 1, 0], [-1, 0, 0, 1], [0, 0, 0, 1], [0, 0, -1, 0]])
RIGHT = ([[1]], [[TINY]], [[TINY, 1], [-1, TINY]])


@pytest.mark.parametrize("seed", range(12))
def test_spectra_by_their_eigenvalues(seed: int) -> None:
    """Blocks of each kind, in a random basis, which is not orthogonal."""
    random = Random(seed)
    kinds = [random.choice((LEFT, LEFT, ON_AXIS, GROWING, RIGHT)) for _ in range(random.randint(1, 3))]
    blocks = sp.diag(*(sp.Matrix(random.choice(kind)) for kind in kinds))
    basis = sp.eye(blocks.rows)
    for _ in range(2 * blocks.rows):  # shears, whose product is regular
        i, j = random.randrange(blocks.rows), random.randrange(blocks.rows)
        basis = basis if i == j else basis.elementary_row_op("n->n+km", k=random.choice((-2, 1, 3)), row1=i, row2=j)
    mixed = basis * blocks * basis.inv()
    matrix = fmpq_mat([[fmpq(int(value.p), int(value.q)) for value in mixed.row(k)] for k in range(mixed.rows)])
    if RIGHT in kinds:
        expected = Spectrum.UNSTABLE
    elif GROWING in kinds:
        expected = Spectrum.GROWING
    else:
        expected = Spectrum.NEUTRAL if ON_AXIS in kinds else Spectrum.HURWITZ
    assert spectrum_of(matrix, linear=True) is expected
    on_axis = expected in (Spectrum.NEUTRAL, Spectrum.GROWING)
    assert spectrum_of(matrix, linear=False) is (Spectrum.UNDECIDED if on_axis else expected)


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
    patterns = {tuple(int(v) for v in row) for row in np.sign(values) if row.all()}
    assert patterns <= {cell.signs for cell in cells.cells}
    for cell in cells.cells:
        if cell.signs not in patterns:  # a thin one: not proved to be empty
            guards = [s * e for s, e in zip(cells.surfaces, cell.signs, strict=True)]
            assert not is_empty(guards, system.check.radius)


@pytest.mark.usefixtures("without_far_starts")
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


# ---- A V that is wrong on a face only: points that refute it, beside paths, floats and Z3 --------

ON_A_FACE = [
    (["-sgn(x) + y/2", "-sgn(y) + 3*z", "-sgn(z) - x"], (16, 16, 1)),
    (["-sgn(x) + y/2", "-sgn(y) + z", "-sgn(z) + 5*x"], (1, 4, 1)),
    (["-sgn(x)", "-sgn(y) + 8*z", "-sgn(z) + x"], (6, 1, 1)),
]


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
        fields.append(velocity(rhs, beside))
    columns = np.array(fields).T
    gradient = np.array(weights) * np.sign(point)
    equal, right = np.vstack([columns[zero], np.ones(len(fields))]), [0.0] * len(zero) + [1.0]
    solution = linprog(-gradient @ columns, A_eq=equal, b_eq=right, bounds=(0, None), method="highs")
    return -float(solution.fun)


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
    failures = (find_slide(system, conditions, claim) for claim in conditions.claims())
    return [failure for failure in failures if failure is not None]


@thorough  # test_a_face_that_solutions_leave_at_once_refutes_nothing
@pytest.mark.parametrize(("count", "sought"), keep(1, [(3, 1), (5, 2), (14, 2)]))
def test_random_functions_that_are_proved_are_not_refuted(count: int, sought: int) -> None:
    rng = np.random.default_rng(2)
    counts: Counter[str] = Counter()
    for _ in range(count):
        a, c = rng.integers(1, 4, 3), rng.integers(1, 5, 3)
        coupled = rng.integers(-6, 7, 3)
        rhs = [f"-{a[k]}*sgn({'xyz'[k]}) + {coupled[k]}*{'yzx'[k]}" for k in range(3)]
        audited = audit(built(rhs), bent(c.tolist()))
        assert audited.function is not None
        function = audited.function
        counts[function.decrease] += 1
        if function.decrease is Decrease.STRICT and counts[Decrease.STRICT] <= sought:
            assert not slides(rhs, c.tolist())
        if function.reason == SLIDES_UP:
            counts[SLIDES_UP] += 1
            point, value = witness(audited)
            assert largest_slide(rhs, c.tolist(), [float(v) for v in point]) == pytest.approx(float(value), abs=1e-6)
    assert counts[Decrease.STRICT] >= count // 5
    assert counts[SLIDES_UP] >= 1


# ---- Points beside which others of rest lie: friction and relays, and points that attract --------

AGREE = ["sign(y - x) + sign(z - x)", "sign(x - y) + sign(z - y)", "sign(x - z) + sign(y - z)"]
FRICTION = ["u", "v", "-2*x + y - sign(u)/2", "x - 2*y - sign(v)/2"]
MOTOR = (["w", "i", "e"], ["3*i - 3/2*w - 3/2*sign(w)", "-i - 3*w + e", "-w"])  # it sticks under a small current
RESTS = [
    (["x", "y", "z"], AGREE),
    (["x", "y", "u", "v"], FRICTION),
    MOTOR,
    (["x", "y", "u", "v"], ["u", "v", "-2*x + y - sign(u)/2", "x - 2*y - v"]),  # one mass sticks, the other comes to it
    (["x", "u", "y", "v"], ["u", "relu(-x) - 2*relu(x) - u/4 - 2*(x - y)", "v", "-3*y/2 + 3*(x - y) - sign(v)"]),
    (["x", "y", "z"], ["-x*z**2", "-y", "-z"]),
]
MOVES = [
    (["x", "y", "z"], ["-sign(x)", "-sign(y)", "-sign(z)"]),
    (["x", "y", "u", "v"], ["u", "v", "-2*x + y - sign(u)/2", "x - 2*y - v + u + x*y"]),  # a curve of rest, no ray
    (["x", "y", "z"], ["-1 - sign(y) - x**2", "-y", "-z"]),  # 0 is at the border of the mixtures at the point alone
    (["x", "y", "z"], ["-sign(x*y - z)", "-y", "-z"]),  # a curved surface: its cells are not known to have points
]


def system(states: Sequence[str], rhs: Sequence[str]) -> SwitchedSystem:
    return ns.System(list(states), list(rhs)).system


def test_no_function_that_falls_is_proposed_beside_places_of_rest() -> None:
    """Both searches took 45 s of a processor here, and could find nothing."""
    switched_system = system("xyz", ["-2*x + 3*x*sin(z)/2", "-2*x - x*y", "-z + 2*x*sign(y)"])
    assert not any(True for positive in (True, False) for _ in proposals(switched_system, positive=positive))


@pytest.mark.parametrize(
    "rhs", [CHAIN, ["y - sgn(x)", "-y - Abs(x - y)", "-z + Max(y, 0)"], ["-x + z*Abs(y)", "-y", "-z"]]
)
def test_a_family_that_holds_another_has_the_larger_program(rhs: list[str]) -> None:
    switched_system = system("xyz", rhs)
    cells = build_cells(switched_system, switched_system.check.radius)
    bases = list(families(cells))
    assert len(bases) > 1
    sizes = [program_size(switched_system, cells, basis) for basis in bases]
    for (small, size), (large, other) in itertools.permutations(zip(bases, sizes, strict=True), 2):
        assert size <= other or not set(small) <= set(large)


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize(("count", "most"), keep(1, [(4, 1000), (6, second_function.MOST_MIXTURES)]))
def test_relays_are_decided_though_their_mixtures_are_not_looked_at(
    monkeypatch: pytest.MonkeyPatch, count: int, most: int
) -> None:
    """A face on which five of six slide has 32 fields and a million sets of them: the check did not end.

    One on which three of four slide has 16 fields and 2516 sets of them, more than are allowed here.
    """
    states, looked_at = list("abcdef"[:count]), second_function.extreme_velocities

    def few_looked_at(fields: Any, normals: Any) -> Any:
        assert sum(comb(len(fields), size) for size in range(1, len(normals) + 2)) <= second_function.MOST_MIXTURES
        return looked_at(fields, normals)

    monkeypatch.setattr(second_function, "MOST_MIXTURES", most)
    monkeypatch.setattr(second_function, "extreme_velocities", few_looked_at)
    rhs = ["-2*sgn(a) - a", *(f"-2*sgn({state}) + sgn({before})/2" for before, state in itertools.pairwise(states))]
    assert decide_system(system(states, rhs)).verdict is ATTRACTS


def program_size(switched_system: SwitchedSystem, cells: SignCells, basis: Sequence[PiecewiseFunction]) -> int:
    above, falling, _ = lyapunov_search._problems(switched_system, cells.radius, tuple(basis))
    return sum(gram_entries(blocks) for _, blocks in [*above, *falling])


def test_programs_that_hold_one_that_is_too_large_are_not_built(monkeypatch: pytest.MonkeyPatch) -> None:
    """In eight states with nine switching surfaces they took more than five minutes, and were thrown away."""
    switched_system, sizes, build = system("xyz", CHAIN), list[int](), lyapunov_search._problems

    def counted(*arguments: Any, **named: Any) -> Any:
        sizes.append(len(arguments[2]))
        return build(*arguments, **named)

    monkeypatch.setattr(lyapunov_search, "_problems", counted)
    assert not list(proposals(switched_system, positive=True, entries=range(1)))
    assert set(sizes) == {len(next(families(build_cells(switched_system, switched_system.check.radius))))}


@pytest.mark.parametrize(("states", "rhs"), RESTS)
def test_places_of_the_ray_are_equilibria(states: list[str], rhs: list[str]) -> None:
    ray = ray_of_rest(system(states, rhs))
    assert ray is not None
    inclusion = FloatInclusion({"states": states, "rhs": [rhs], "at": ["0"] * len(states)}, 1)
    for distance in (0.1, 0.01):
        places = distance * np.tile(np.array(ray, dtype=float), (200, 1))
        values = inclusion.corners(places, np.full(200, 1e-9)).reshape(-1, len(states))
        _, rest = nnls(np.vstack([values.T, np.ones(len(values))]), np.append(np.zeros(len(states)), 1.0))
        assert rest < 1e-6


@few(3)
@pytest.mark.parametrize(("states", "rhs"), RESTS[:-1])
def test_the_point_is_said_not_to_attract(states: list[str], rhs: list[str]) -> None:
    result = decide_system(system(states, rhs))
    assert result.verdict is Translation.STABLE
    assert "not asymptotically: every point of the ray through" in result.reason


@pytest.mark.parametrize(("states", "rhs"), MOVES)
def test_no_ray_is_found_of_others(states: list[str], rhs: list[str]) -> None:
    assert ray_of_rest(system(states, rhs)) is None


# ---- Relays of high relative degree are unstable: against paths of fine steps, and forged evidence.

STEP, START, FAR = 1 / 512, 1e-3, 30.0


@few(3)
@pytest.mark.parametrize(
    ("rhs", "degree"),
    keep(
        5,
        [
            (["y", "z", "-sgn(x)"], 3),
            (["y", "z", "sgn(x) - x - y - z"], 3),
            (["y", "z", "-sgn(x) - 100*x - 50*y - 20*z - z**3"], 3),
            (["y", "z", "u", "v", "-sgn(x)"], 5),
            (["y", "z", "-sgn(x) + u", "-u + x"], 3),
            (["y", "z + x**2", "-2*sgn(x) - sgn(y) - z"], 3),
            (["y", "sgn(x) - y", "-z + x"], 2),
            (["y", "z", "u", "-sgn(x) - u"], 4),
        ],
    ),
)
def test_known_degrees(rhs: list[str], degree: int) -> None:
    result = decided(rhs)
    assert result.verdict is Translation.UNSTABLE
    assert result.check()
    if result.method is Method.RELAY:
        assert result.deciding.proofs.degree == degree
    else:
        assert result.method is Method.ESCAPE


@few(2)
@pytest.mark.parametrize(
    "rhs",
    [
        ["y", "z", "-sgn(x)"],
        ["y", "z + x**2", "-2*sgn(x) - sgn(y) - z"],
        ["y", "z", "u", "v", "-sgn(x)"],
        ["y", "z", "-sgn(x) + u", "-u + x"],
    ],
)
def test_the_function_of_a_relay_is_certified(rhs: list[str]) -> None:
    """Products of neighbouring derivatives rise one after the other where it is kept."""
    certificate = certificate_of(decided(rhs))
    (entry,) = certificate["evidence"]
    assert entry["theorem"] == "instability"
    assert entry["hypotheses"]["second"]["functions"]
    assert not contradiction(certificate["statement"], 1 / 16)


@thorough  # the small ones: test_solutions_that_leave_are_certified_and_followed
def test_one_solution_is_certified_where_a_relay_pushes_out() -> None:
    certificate = certificate_of(decided(["y", "z", "sgn(x) - x - y - z"]))
    (entry,) = certificate["evidence"]
    assert entry["theorem"] == "escape"
    assert not contradiction(certificate["statement"], 1 / 16)


@pytest.mark.parametrize(
    "rhs",
    [
        ["y", "z", "u", "v", "w", "-sgn(x)"],  # degree 6: terms of both signs
        ["y", "-sgn(x) - y", "-z"],  # degree 2, pushed back: stable
        ["y", "z", "-x - y - z - sgn(x + y + z)"],  # degree 1
        ["y", "z", "-sgn(x) - 2*sgn(y)"],  # the sign of s does not decide that of its third derivative
        ["y + sgn(z)", "z", "-sgn(x)"],  # another relay acts in the first derivative
        ["y", "z", "-x*sgn(x) - y - z"],  # the field does not jump at the point
    ],
)
@pytest.mark.parametrize("whole", keep(1, [False, True]), ids=["relay", "whole check"])
def test_other_relays_are_left_to_others(rhs: list[str], whole: bool) -> None:
    system = ns.System(list("xyzuvw"[: len(rhs)]), rhs).system
    found = decided(rhs).by(Method.RELAY) if whole else high_degree_relay(system, first_cells(system))
    assert found is None


def test_the_function_of_a_relay_never_falls_near_the_point() -> None:
    """W along the field at random points, and on the way from the point in its direction."""
    relay = decided(["y", "z", "-sgn(x) - z"]).deciding.proofs

    def value(polynomial: Checked, place: Floats) -> float:
        return sum(float(c) * float(np.prod(place ** np.array(e))) for e, c in polynomial.terms.items())

    slopes = [relay.rising.derivative(k) for k in range(3)]
    for x, y, z in np.random.default_rng(0).uniform(-1 / 8, 1 / 8, (400, 3)):
        rate = (y, z, -np.sign(x) - z)
        assert sum(value(slope, np.array([x, y, z])) * v for slope, v in zip(slopes, rate, strict=True)) >= -1e-12
    direction = np.array([float(d) for d in relay.direction])
    assert all(value(relay.rising, direction * 0.5**k) > 0 for k in range(4, 20))


# ---- against paths -------------------------------------------------------------------------------


def random_relay(seed: int) -> tuple[list[str], Callable[[Floats], Floats]]:
    """Integrators in a row with a relay and random linear terms, perhaps a further state, in other coordinates."""
    rng = np.random.default_rng(seed)
    degree, more = int(rng.integers(3, 5)), int(rng.integers(0, 2))
    count = degree + more
    matrix = np.zeros((count, count), dtype=int)
    matrix[np.arange(degree - 1), np.arange(1, degree)] = 1
    matrix[degree - 1 :] = rng.integers(-3, 2, (count - degree + 1, count))
    push = np.zeros(count, dtype=int)
    push[degree - 1] = -int(rng.integers(1, 4))
    turn = np.eye(count, dtype=int)
    for i, j in itertools.permutations(range(count), 2):
        turn[i] += int(rng.integers(-1, 2)) * turn[j]
    old = sp.Matrix(turn.tolist()).inv()
    moved, pushed, output = sp.Matrix(turn.tolist()) * sp.Matrix(matrix.tolist()) * old, turn @ push, old.row(0)
    names = sp.symbols("x y z u v")[:count]
    surface = sum(a * b for a, b in zip(output, names, strict=True))
    rows = [sum(moved[k, i] * names[i] for i in range(count)) for k in range(count)]
    rhs = [f"{row} + ({p})*sgn({surface})" for row, p in zip(rows, pushed, strict=True)]
    a, b, c = np.array(moved.tolist(), dtype=float), pushed.astype(float), np.array(output.tolist()[0], dtype=float)
    return rhs, lambda point: a @ point + b * np.sign(c @ point)


def leaves(field: Callable[[Floats], Floats], start: Floats) -> bool:
    """Whether a path of fine steps comes many times as far as it began."""
    point, size = start.copy(), float(np.abs(start).max())
    for _ in range(40_000):
        point = point + STEP * size ** (1 / 3) * field(point + STEP * size ** (1 / 3) / 2 * field(point))
        if np.abs(point).max() > FAR * size:
            return True
    return False


@pytest.mark.parametrize("seed", range(8))
def test_paths_leave(seed: int) -> None:
    rhs, field = random_relay(seed)
    result = decided(rhs)
    assert result.verdict is Translation.UNSTABLE
    assert result.check()
    relay = high_degree_relay(result.scene, first_cells(result.scene))
    assert relay is not None
    direction = np.array([float(d) for d in relay.direction])
    assert leaves(field, START * direction / np.abs(direction).max())
