"""Systems with sqrt(Abs(x)): known truths, paths against closed forms, and where nothing may be said."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from mpmath import mp, mpf

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.findings.verdicts import Translation
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import require_stated
from tests.plain import built
from tests.thorough import few, keep, thorough

ATTRACTS, LEAVES, OPEN = Translation.ASYMPTOTICALLY_STABLE, Translation.UNSTABLE, Translation.UNDECIDED
ROOT = "sqrt(Abs(x))*sgn(x)"
NAMES = {"sqrt": np.sqrt, "Abs": np.abs, "sgn": np.sign}


def largest_end(rhs: list[str], size: float, until: float, step: float = 5e-4) -> float:
    """Where Euler polygons from a small curve end, ``max(sqrt|x|, |y|)`` over that of their starts."""
    angles = np.linspace(0.1, 6.2, 12)
    x, y = np.sign(np.cos(angles)) * (size * np.cos(angles)) ** 2, size * np.sin(angles)
    formulas = [compile(text, "rhs", "eval") for text in rhs]
    for _ in range(int(until / step)):
        f, g = (eval(formula, dict(NAMES), {"x": x, "y": y}) for formula in formulas)  # noqa: S307 - this file's
        x, y = np.clip(x + step * f, -9, 9), np.clip(y + step * g, -9, 9)
    return float(np.maximum(np.sqrt(np.abs(x)), np.abs(y)).max() / size)


KNOWN = [
    ([f"-3/2*{ROOT} + y", "-11/10*sgn(x)"], ATTRACTS, True),  # super-twisting
    ([f"-1/2*{ROOT} + y", "-3*sgn(x)"], ATTRACTS, True),
    ([f"-3/2*{ROOT} + y - x", "-11/10*sgn(x) - x"], ATTRACTS, True),  # with linear terms (Moreno 2009)
    ([f"-3/2*{ROOT} + y + 2*x + y**2", "-11/10*sgn(x) + x*y"], ATTRACTS, True),  # and with destabilizing ones
    ([f"1/2*{ROOT} + y", "-11/10*sgn(x)"], LEAVES, False),  # anti-damped
    ([f"-3/2*{ROOT} + y", "11/10*sgn(x)"], LEAVES, False),  # a saddle of the roots
    ([f"-3/2*{ROOT} + y", "-11/10*sgn(x) + 12/10*sgn(y)"], LEAVES, False),  # a relay that wins
    ([f"-3*{ROOT} + y", "-11/10*sgn(x) + 1/2*sgn(y)"], ATTRACTS, True),  # and one that does not
    (["y", "-2*sgn(y + sqrt(Abs(x))*sgn(x))"], ATTRACTS, None),  # a prescribed law of convergence (Levant 1993)
]


@few(2)
@pytest.mark.parametrize(("rhs", "truth", "in_time"), keep(5, KNOWN))
def test_known_systems_agree_with_their_polygons(rhs: list[str], truth: Translation, in_time: bool | None) -> None:
    result = decide_system(built(rhs))
    assert result.verdict is truth, result.reason
    assert result.check()
    assert in_time is None or result.reach.in_finite_time is in_time
    last = largest_end(rhs, 0.15, 2.0)
    assert last < 0.3 if truth is ATTRACTS else last > 2


def test_a_disturbance_within_the_gain_is_rejected_and_a_larger_one_is_not() -> None:
    """``|d| < k_2`` alone is not enough of k_1; here k_1 = 3 is large (Levant 1993)."""
    rhs = [f"-3*{ROOT} + y", "-11/10*sgn(x) + d"]
    found = decide_system(built(rhs, {"d": ["-1/2", "1/2"]}))
    assert found.verdict is ATTRACTS
    assert found.reach.in_finite_time
    assert found.check()
    assert decide_system(built(rhs, {"d": [-2, 2]})).verdict is not ATTRACTS


SLIDING = [
    ([f"-{ROOT} + x*y", "-y - x"], ATTRACTS),  # slides to the point along x = 0, which the roots do not see
    ([f"-{ROOT}", "y - x"], LEAVES),  # slides away
    (["-sgn(x) + y", f"-y - {ROOT}"], ATTRACTS),
]


@pytest.mark.parametrize(("rhs", "truth"), SLIDING)
def test_nothing_is_said_where_solutions_slide_on_a_zero_of_the_root(rhs: list[str], truth: Translation) -> None:
    result = decide_system(built(rhs))
    assert result.verdict in (truth, OPEN)
    assert result.verdict is OPEN
    assert "not every solution crosses" in result.reason
    assert result.check()


BY_THEMSELVES = [
    ([f"-{ROOT}", "1 - y"], [0, 1], ATTRACTS),
    ([f"-{ROOT}", "y - 1"], [0, 1], LEAVES),
    ([f"{ROOT}/2 - x", "-sqrt(Abs(y))*sgn(y) - x/(1 + y**2)"], [0, 0], LEAVES),
    ([f"-{ROOT} - sgn(x)", "-sin(y)"], [0, 0], ATTRACTS),
    ([f"-{ROOT}", "0"], [0, 0], Translation.STABLE),
    ([f"{ROOT}/2 - x", "1 - sqrt(Abs(y)) - x**2"], [0, 1], LEAVES),
    ([f"-{ROOT}", "2 - sqrt(Abs(y)) + x"], [0, 4], ATTRACTS),  # x drives y
    ([f"-{ROOT}", "-y - x"], [0, 0], ATTRACTS),  # x drives y
    ([f"-{ROOT}", f"{ROOT} - sqrt(Abs(y))*sgn(y)"], [0, 0], ATTRACTS),  # Torricelli's tanks, which run empty
]


@few(4)
@pytest.mark.parametrize(("rhs", "at", "truth"), BY_THEMSELVES)
def test_states_that_no_other_one_moves_are_decided_by_themselves(
    rhs: list[str], at: list[int], truth: Translation
) -> None:
    result = decide_system(built(rhs, equilibrium=at))
    drives = any("x" in own for own in rhs[1:]) and truth is ATTRACTS
    assert (result.verdict, result.deciding.theorem) == (truth, Method.CASCADE if drives else Method.STATES)
    assert result.check()


def test_no_equilibrium_is_said_of_the_stated_field() -> None:
    """The scaled field vanishes in y on the axis of the root; the stated one does not."""
    result = decide_system(built([f"-{ROOT} + y", "-1 - sgn(x)/2"]))
    assert result.verdict is LEAVES
    assert "0 is not in F" in result.reason
    assert result.check()


def test_an_equilibrium_off_the_zero_of_the_root_is_that_of_its_jacobian() -> None:
    """Torricelli's two tanks: x' = q - sqrt(x), y' = sqrt(x) - sqrt(y) rests at (q^2, q^2), a node."""
    rhs = ["1/2 - sqrt(Abs(x))", "sqrt(Abs(x)) - sqrt(Abs(y))"]
    result = decide_system(built(rhs, equilibrium=["1/4", "1/4"]))
    assert result.verdict is ATTRACTS
    assert not result.reach.everywhere
    assert not result.reach.in_finite_time
    assert result.check()
    turned = decide_system(built(["sqrt(Abs(x)) - 1/2", "sqrt(Abs(x)) - sqrt(Abs(y))"], equilibrium=["1/4", "1/4"]))
    assert turned.verdict is LEAVES


def test_one_state() -> None:
    result = decide_system(built([f"-{ROOT} + x"], radius=2))
    assert result.verdict is ATTRACTS
    assert result.check()
    assert decide_system(built([f"{ROOT} - x"])).verdict is LEAVES


def closed_form(k1: str, k2: str) -> tuple[list[tuple[mpf, mpf]], mpf]:
    """Times and y of super-twisting at its first crossings of x = 0 from (1, 0), and the time of arrival.

    Between crossings ``y`` falls at the rate k2, so times are differences of y; the linear flow of (z, y) in time s,
    ``z' = y - k1 z``, ``y' = -2 k2 z``, gives y at the crossings (eigenvalues ``a +- i w``).
    """
    with mp.workdps(40):
        a, k = -mpf(k1) / 2, mpf(k2)
        w = mp.sqrt(2 * k - a * a)
        first = mp.findroot(lambda s: mp.cos(w * s) + a / w * mp.sin(w * s), mpf(2) / w)
        y = -2 * k / w * mp.exp(a * first) * mp.sin(w * first)
        t, ratio, found = -y / k, -mp.exp(a * mp.pi / w), []
        for _ in range(6):
            found.append((t, y))
            t, y = t + abs(ratio * y - y) / k, ratio * y
        last, height = found[0]
        return found, last + abs(height) * (1 - ratio) / k / (1 + ratio)


@pytest.mark.parametrize(("k1", "k2"), [("1.5", "1.1"), pytest.param("0.8", "2", marks=thorough)])
def test_paths_meet_the_closed_form(k1: str, k2: str) -> None:
    system = built([f"-{Fraction(k1)}*{ROOT} + y", f"-{Fraction(k2)}*sgn(x)"])
    path = simulate(system_field(system, (1.0, 0.0)), (1.0, 0.0), 20.0)
    expected, arrival = closed_form(k1, k2)
    crossed = [e for e in path.events if not e.state[0] and e.state[1]]
    for event, (time, height) in zip(crossed, expected, strict=False):
        assert float(event.t) == pytest.approx(float(time), abs=1e-11)
        assert float(event.state[1]) == pytest.approx(float(height), abs=1e-11)
    assert len(crossed) >= len(expected)
    rest = [e for e in path.events if max(map(abs, e.state)) < 1e-12]
    assert float(rest[0].t) == pytest.approx(float(arrival), abs=1e-10)
    assert path.unique
    assert path.end.state == (0.0, 0.0)


def test_a_path_slides_on_a_zero_of_the_root_in_its_own_time() -> None:
    """x arrives at 2 sqrt(x_0) and y goes on like exp(-t)."""
    path = simulate(system_field(built([f"-{ROOT}", "-y"]), (0.25, 1.0)), (0.25, 1.0), 3.0)
    arrived = next(e for e in path.events if not e.state[0])
    assert float(arrived.t) == pytest.approx(1.0, abs=1e-6)  # the root is not smooth where it ends
    assert path.end.state[1] == pytest.approx(np.exp(-3), abs=1e-10)


@few(1)
@pytest.mark.parametrize("seed", range(20))
def test_random_gains_agree_with_eigenvalues(seed: int) -> None:
    """In roots super-twisting with a relay of y is conewise linear; without it the trace and determinant decide."""
    rng = np.random.default_rng(seed)
    a, b, c = (Fraction(int(k), 8) for k in rng.integers(-24, 25, 3))
    if not a or not b or b * 2 == c * c:
        return
    rhs = [f"({-a})*{ROOT} + y", f"({-b})*sgn(x) + ({c})*x"]
    truth = ATTRACTS if a > 0 and b > 0 else LEAVES
    result = decide_system(built(rhs))
    assert result.verdict is truth, (rhs, result.reason)
    assert result.check()


@few(1)
@pytest.mark.parametrize("seed", range(24))
def test_random_systems_agree_with_their_polygons(seed: int) -> None:
    """Super-twisting with random gains and one random term more; near the point, as asymptotic stability is local."""
    rng = np.random.default_rng(seed)
    a, b, c, d, e = (f"({k}/4)" for k in (*rng.integers(-12, 13, 4), rng.integers(-4, 5)))
    first, second = f"{a}*{ROOT} + 3/2*y", f"{b}*sgn(x)"
    first, second = (
        (f"{first} + {c}*x", f"{second} + {d}*y"),
        (first, f"{second} + {e}*sgn(y)"),
        (f"{first} + {e}*sqrt(Abs(x))", second),
        (first, f"{second} + {e}*sgn(y + {ROOT})"),
    )[seed % 4]
    result = decide_system(built([first, second]))
    assert result.check()
    last = largest_end([first, second], 0.01, 0.5, 1e-4)
    if result.verdict is ATTRACTS:
        assert last < 0.9
    elif result.verdict is LEAVES:
        assert last > 1.1


@pytest.mark.parametrize(
    "rhs", [[f"-2*{ROOT} - sat(x, -1, 1) + x/(1 + x**2)"], [f"-2*{ROOT} + x/(1 + x**2) + y", "-sgn(x)"]]
)
def test_a_certificate_beside_a_quotient(rhs: list[str]) -> None:
    """It speaks of the right-hand sides times the denominator."""
    certificate = certificate_of(decide_system(built(rhs)))
    assert "(1 + x**2)" in certificate["statement"]["subject"]["rhs"][0][0]


def test_what_no_certificate_shows_of_a_system_with_roots_is_said_in_a_sentence() -> None:
    """The search for a function that shows instability once took its subject for one without roots."""
    result = decide_system(built([f"3/4*{ROOT} + 3*x + 3/2*y", "-3/2*sgn(x) + 11/4*y"]))
    assert result.verdict is LEAVES
    with pytest.raises(NoCertificateError, match="no function was found that shows instability"):
        certificate_of(result)


BAD = [
    (["-sqrt(Abs(x + y))", "-y"], "sqrt"),
    (["-sqrt(x)", "-y"], "sqrt"),
    (["-sqrt(Abs(x))*sgn(x)", "-sqrt(1 + Abs(y))"], "sqrt"),
    (["-sqrt(Abs(x))*sgn(x) + sin(sqrt(Abs(x)))", "-y"], "sin and cos"),
    (["-sqrt(Abs(x), 2)", "-y"], "formula"),
    (["-sqrt(Abs(x))*sgn(x)", "-y + sin(x)"], "rhs[2]: required sin and cos of states without a square root"),
]


@pytest.mark.parametrize(("rhs", "word"), BAD)
def test_other_roots_are_refused_in_one_line(rhs: list[str], word: str) -> None:
    with pytest.raises(SceneError) as raised:
        built(rhs)
    assert word in str(raised.value)
    assert "\n" not in str(raised.value)


def test_an_interval_of_starts_is_that_of_the_state() -> None:
    """Half of the stated width is that of the root."""
    result = decide_system(built([f"-{ROOT}"]))
    assert result.deciding.facts[0].words == "every start with -1/4 < x < 1/4 reaches the equilibrium"


def test_a_refusal_names_the_formula_that_holds_the_root() -> None:
    system = built(["y", f"-{ROOT} - y"])
    with pytest.raises(SceneError, match=r"system\.rhs\[2\]: .* received '-sqrt\(Abs\(x\)\)\*sgn\(x\) - y'"):
        require_stated(system)
    with pytest.raises(SceneError, match=r"check\.lyapunov: required square roots of Abs of a state"):
        built(["y", "-x - y"], lyapunov="sqrt(1 + x**2) - 1 + y**2")
