"""V that bends along curves: against the definition at sampled points, paths, and a corner at which solutions rest."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from nonsmooth.analysis.cells.region import Region
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.inequalities.forms import Sense
from nonsmooth.proofs.inequalities.prover import Proof, prove
from nonsmooth.proofs.system_audit import AuditVerdict, audit
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.lyapunov_search import find_lyapunov
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.proofs.conftest import Load
from tests.proofs.forged import with_reach
from tests.thorough import few

NAMES = {"sign": np.sign, "Abs": np.abs}
STEP, STEPS = 1e-3, 4000


def follow(system: SwitchedSystem, points: np.ndarray) -> np.ndarray:
    """Where Euler polygons end."""
    rhs = [compile(side.text, "rhs", "eval") for side in system.rhs]
    for _ in range(STEPS):
        values = {"x": points[0], "y": points[1], **NAMES}
        rates = [eval(side, values) for side in rhs]  # noqa: S307 - texts of this test
        points = points + STEP * np.array(np.broadcast_arrays(*rates))
    return points


@few(1)
@pytest.mark.parametrize(
    "relay",
    [
        "-3*sign(y + 2*x + x*y/4) - 3*x/4 - y/4",
        "-sign(x + y - 3*x**2/4)",
        "-2*sign(x + y*Abs(y)/4) + x/2 - y/4",
    ],
)
def test_relays_on_curves_are_decided_by_v_that_bends_there(load: Load, relay: str) -> None:
    system = load("y", relay)
    result = decide_system(system)
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.function is not None
    assert "Abs(" in result.function.text
    assert result.check()
    assert result.reach.region is not None
    angles = np.linspace(0, 2 * np.pi, 9)
    ends = follow(system, 0.1 * np.array([np.cos(angles), np.sin(angles)]))
    assert np.abs(ends).max() < 0.1


@few(1)
@pytest.mark.parametrize("relay", ["-2*sign(y - x - x**2/4)", "-sign(x + y**2) + y/2", "2*sign(x + y + x**2)"])
def test_relays_on_curves_that_repel_have_no_such_v(load: Load, relay: str) -> None:
    system = load("y", relay)
    assert find_lyapunov(system) is None
    assert decide_system(system).verdict is not Translation.ASYMPTOTICALLY_STABLE


@few(2)
@pytest.mark.parametrize(
    ("first", "second", "lyapunov", "verdict"),
    [
        ("-x", "-y - sign(y + x**2)", "Abs(y + x**2) + x**2", AuditVerdict.VALID),
        ("-x", "-y", "x**2 + y**2 + Abs(x**2 + y**2 - 1/8)*(x**2 + y**2)/100", AuditVerdict.VALID),
        ("x/4", "-4*sign(y + x**2)", "4*Abs(y + x**2) + x**2", AuditVerdict.UNDECIDED),  # V grows while it slides
        ("y", "sign(x + y - 3*x**2/4)", "4*Abs(x + y - 3*x**2/4) + x**2", AuditVerdict.INVALID),
        ("-x", "-y", "x**2 + y**2 + (x**2 + y**2)*sign(y + x**2)/4", AuditVerdict.UNDECIDED),  # V jumps
    ],
)
def test_audits_of_v_that_bends_along_a_curve(
    load: Load, first: str, second: str, lyapunov: str, verdict: AuditVerdict
) -> None:
    result = audit(load(first, second), lyapunov)
    assert result.verdict is verdict


def test_where_a_further_cell_meets_the_curve_solutions_may_rest(load: Load) -> None:
    """V falls in all cells and along the curve, but at (1/4, -1/16) four fields hold 0 in their hull."""
    system = load("4*x*(-1 + 4*sign(y + x**2)*sign(x - 1/4))", "-12*sign(y + x**2)")
    lyapunov = "4*Abs(y + x**2) + x**2 + y**2"
    assert audit(system, lyapunov).verdict is AuditVerdict.UNDECIDED
    near = load("4*x*(-1 + 4*sign(y + x**2)*sign(x - 1/4))", "-12*sign(y + x**2)", radius='"1/8"')
    assert audit(near, lyapunov).verdict is AuditVerdict.VALID


@few(1)
@pytest.mark.parametrize("seed", range(8))
def test_proved_v_falls_along_random_curves(load: Load, seed: int) -> None:
    """The sliding value at points of the curve, from the definition in floats."""
    rng = np.random.default_rng(seed)
    a, b, c, d, k, m = (int(v) for v in rng.integers(1, 5, size=6))
    s, t = (int(v) for v in rng.integers(-4, 5, size=2))
    curve = f"(x + {a}*y/2 + {s}*x**2/4 + {t}*x*y/4)"
    system = load(f"{rng.choice(['y', 'y - x/2', '-x + y/2'])}", f"-{b}*sign{curve} + ({s}*x - {d}*y)/4")
    result = audit(system, f"{k}*Abs{curve} + {c}*x**2/2 + y**2/{m}")
    if result.verdict is not AuditVerdict.VALID:
        return
    x = np.linspace(-0.4, 0.4, 41)
    y = -(x + s * x**2 / 4) / (a / 2 + t * x / 4)
    x, y = x[np.abs(y) < 0.5], y[np.abs(y) < 0.5]
    normal = np.array([1 + s * x / 2 + t * y / 4, a / 2 + t * x / 4])
    fields = []
    for side in (1, -1):
        values = {"x": x, "y": y, "Abs": np.abs, "sign": lambda _, side=side: side}
        fields.append(np.array(np.broadcast_arrays(*[eval(f.text, values) for f in system.rhs])))  # noqa: S307
    p, q = ((normal * field).sum(axis=0) for field in fields)
    sliding = (q * fields[0] - p * fields[1]) / (q - p)
    falls = (np.array([c * x, 2 * y / m]) * sliding).sum(axis=0)
    opposed = (p * q < 0) & (np.abs(x) > 1e-9)
    assert np.all(falls[opposed] < 0)


def beside_a_curve(load: Load) -> tuple[Region, list[Polynomial]]:
    """The part of a square where ``q = 2 y + x^2 >= 0``, and the coordinates."""
    field = load("-x", "-y").field
    x, y = (Polynomial.variable(field, ("x", "y"), name) for name in ("x", "y"))
    one, zero = field.one, field.zero
    square = Region(((zero, zero, one), (zero, -one, one), (one, -one, one), (one, one, one), (zero, one, one)))
    return replace(square, guards=(y * 2 + x * x,)), [x, y]


def test_multiples_of_guards_show_what_they_leave(load: Load) -> None:
    """``q + 2 x^2 > 0`` where ``q = 2 y + x^2 >= 0``: along the curve it vanishes to second order."""
    beside, (x, y) = beside_a_curve(load)
    enough = y * 2 + x * x * 3
    assert isinstance(prove(Sense.POSITIVE, enough, beside, except_origin=True), Proof)
    for less in (y * 2 + x * x, -y * 2 - x * x * 3):
        assert not isinstance(prove(Sense.POSITIVE, less, beside, except_origin=True), Proof)
    wider = replace(beside, guards=(enough,))
    assert not isinstance(prove(Sense.POSITIVE, enough, wider, except_origin=True), Proof)
    assert isinstance(prove(Sense.NONNEGATIVE, y * 2 + x * x, beside), Proof)


def test_what_follows_from_a_guard_holds_at_points(load: Load) -> None:
    """``c q`` and a form of higher order beside random curves: proofs against values, at points ever nearer."""
    rng = np.random.default_rng(3)
    beside, (x, y) = beside_a_curve(load)
    scales, proved, refuted = 0.5 ** np.arange(12), 0, 0
    for _ in range(24):
        a, b, c = (int(v) for v in rng.integers(-3, 4, 3))
        curve = y * 2 + x * x * a + x * y * b
        polynomial = curve * int(rng.integers(1, 4)) + x * x * c + y * y * int(rng.integers(-1, 3))
        outcome = prove(Sense.POSITIVE, polynomial, replace(beside, guards=(curve,)), except_origin=True)
        xs = np.concatenate([share * scales for share in np.linspace(0.25, 0.5, 16)])
        ys = np.concatenate([-a * xs**2 / (2 + b * xs) + above * xs**2 for above in (1e-6, 0.01, 0.3, 2.0)])
        xs = np.tile(xs, 4)
        inside = (np.abs(ys) <= xs) & (float(a) * xs**2 + b * xs * ys + 2 * ys >= 0)
        values = sum(float(v) * xs**i * ys**j for (i, j), v in polynomial.terms.items())[inside]
        if isinstance(outcome, Proof):
            assert np.all(values > 0)
            proved += 1
        refuted += bool((values < 0).any())
    assert proved >= 5
    assert refuted >= 5


def test_a_v_that_bends_along_a_curve_has_a_rate(load: Load) -> None:
    """``x' = -x`` and V = x**2 on the curve, where x stays: V' <= -2 V at best."""
    result = decide_system(load("-x", "-y - sign(y + x**2)", lyapunov='"Abs(y + x**2) + x**2 + y**2"'))
    rate = result.reach.rate
    assert rate is not None
    assert 0 < rate.kappa <= 2
    assert result.check()
    assert not with_reach(result, rate=replace(rate, kappa=rate.kappa + 2)).check()
