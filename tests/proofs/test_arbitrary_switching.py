"""Arbitrary switching: stable for every switching, and unstable by one law."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.proofs.checker.statements import refusal
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel.cells import started
from nonsmooth.proofs.kernel.subject import NoCertificateError
from nonsmooth.proofs.system_certificates import certificate_text
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.leading_terms import TurnGrowth, decide_leading_terms
from nonsmooth.proofs.theorem_searches import parallel_lines, show_choice_of
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.plain import built
from tests.thorough import but, few, keep, thorough

# ---- Arbitrary switching: the hull of several right-hand sides, against the worst switching by simulation.


def switching(*sides: tuple[str, str]) -> SwitchedSystem:
    return built([list(side) for side in sides])


def zelentsovsky(alpha: str) -> SwitchedSystem:
    """``x'' = -x' - (2 + u) x`` with any u between 0 and alpha: stable below about 6.985."""
    return switching(("y", "-2*x - y"), ("y", f"-(2 + {alpha})*x - y"))


def worst_factor(alpha: float) -> float:
    """Growth in a full turn where the field that grows most per angle is always chosen; by fine steps in the angle."""
    matrices = [np.array([[0.0, 1.0], [-2.0 - u, -1.0]]) for u in (0.0, alpha)]
    total, steps = 0.0, 20_000
    for angle in (np.arange(steps) + 0.5) * (2 * math.pi / steps):
        u = np.array([math.cos(angle), math.sin(angle)])
        rates = []
        for matrix in matrices:
            v = matrix @ u
            rates.append(float(u @ v) / abs(u[0] * v[1] - u[1] * v[0]))
        total += max(rates)
    return math.exp(total * 2 * math.pi / steps)


@few(1)
@pytest.mark.parametrize("alpha", ["3", "6"])
def test_certified_below_the_exact_limit(alpha: str) -> None:
    result = decide_system(zelentsovsky(alpha))
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert result.reach.everywhere
    assert result.check()


@few(2)
@pytest.mark.parametrize("alpha", ["3", "6.98", "6.99", "9"])
def test_the_worst_turn_against_fine_steps(alpha: str) -> None:
    found = decide_leading_terms(zelentsovsky(alpha))
    assert found is not None
    assert isinstance(found.growth, TurnGrowth)
    assert found.growth.is_worst
    measured = worst_factor(float(alpha))
    assert float(found.growth.low) == pytest.approx(measured, rel=1e-6)
    assert float(found.growth.high) == pytest.approx(measured, rel=1e-6)
    assert (found.verdict is Translation.UNSTABLE) == (measured > 1)


def test_three_fields_and_terms_of_higher_order() -> None:
    two = ("y", "-2*x - y + x**2"), ("y", "-5*x - y")
    for sides, expected in (((*two, ("y", "-4*x - y + y**3")), Translation.ASYMPTOTICALLY_STABLE),
                            ((*two, ("y", "-12*x - y")), Translation.UNSTABLE)):  # fmt: skip
        found = decide_leading_terms(switching(*sides))
        assert found is not None
        assert found.verdict is expected


@pytest.mark.parametrize(
    ("sides", "expected"),
    [
        ((("-x", "-y"), ("-2*x", "-y")), Translation.ASYMPTOTICALLY_STABLE),
        ((("-x", "-y"), ("x", "-y")), Translation.UNSTABLE),  # one of them alone
        ((("-sign(x)", "-sign(y)"), ("-2*sign(x)", "-sign(y)")), Translation.ASYMPTOTICALLY_STABLE),
    ],
)
def test_hulls(sides: tuple[tuple[str, str], ...], expected: Translation) -> None:
    assert decide_system(switching(*sides)).verdict is expected


def test_rest_by_mixtures_is_not_asymptotic() -> None:
    """0 lies between the two velocities everywhere."""
    assert decide_system(switching(("-1", "0"), ("1", "0"))).verdict is not Translation.ASYMPTOTICALLY_STABLE


def test_what_is_refused() -> None:
    with pytest.raises(SceneError, match=r"system\.rhs: required one right-hand side"):
        system_field(zelentsovsky("1"))
    with pytest.raises(SceneError, match=r"system\.rhs\[2\]: required 2 formulas"):
        switching(("x", "y"), ("x",))  # type: ignore[arg-type]
    with pytest.raises(SceneError, match=r"system\.rhs\[1\]\[2\]: required a formula"):
        switching(("x", "z"), ("x", "y"))


# ---- Arbitrary switching and disturbances that make the point unstable by one switching law ------

BEYOND: dict[str, Any] = {  # right-hand sides with a disturbance d, and its bound, beyond what the law can take
    "a push that a relay does not hold": (("y", "-2*sign(x) - sign(y) + d"), 4),
    "twisting, pushed along with its velocity": (("y", "-3*sign(x) - sign(y) + d"), "3/2"),
    "a first-order law": (("-x + y", "-sign(x) + d"), 2),
    "a push across a line where the first terms vanish": (("d*y**2 + y**3", "-3*Abs(x)"), 1),
    "super-twisting, pushed along with x'": (("-sqrt(Abs(x))*sign(x)/2 + y", "-sign(x) + d"), "9/10"),
}


def pushed(name: str) -> ns.System:
    rhs, bound = BEYOND[name]
    return ns.System(["x", "y"], list(rhs), parameters={"d": [f"-{bound}", f"{bound}"]})


@few(3)
@pytest.mark.parametrize("name", but([name for name in BEYOND if "along" in name], BEYOND))
def test_a_law_is_found_beyond_the_bound(name: str) -> None:
    _, claims = show_choice_of(pushed(name).system)
    assert claims == [{"stability": "unstable"}]


@few(1)
@pytest.mark.parametrize("name", BEYOND)
def test_a_disturbance_beyond_its_bound(name: str) -> None:
    result = pushed(name).check()
    method = "choice among right-hand sides" if "along" in name else "solution that leaves"
    assert (result.verdict, result.evidence.method) == ("unstable", method)
    assert result.evidence.equilibrium == "holds"
    certificate = result.certificate()
    assert certificate["statement"]["claims"] == [{"stability": "unstable"}]
    assert not refusal(certificate, len(certificate_text(certificate)))


@pytest.mark.usefixtures("without_reach")
def test_within_its_bound_nothing_is_said_to_leave() -> None:
    """Twisting with 3 and 1 takes disturbances below 1."""
    rhs = ["y", "-3*sign(x) - sign(y) + d"]
    assert ns.System(["x", "y"], rhs, parameters={"d": ["-9/10", "9/10"]}).check().verdict != "unstable"


WORST = {
    "about (1, -2)": [
        ["-(x - 1)/10 + (y + 2)", "-10*(x - 1) - (y + 2)/10"],
        ["-(x - 1)/10 + 10*(y + 2)", "-(x - 1) - (y + 2)/10"],
    ],
    "two fields": [["-x/10 + y", "-10*x - y/10"], ["-x/10 + 10*y", "-x - y/10"]],
    "three fields": [["-x - y", "x - y"], ["-x - 12*y", "x - y"], ["-x - y", "12*x - y"]],
}


@pytest.mark.usefixtures("without_reach")
@few(1)
@pytest.mark.parametrize("name", WORST)
def test_the_worst_switching_has_a_certificate(name: str) -> None:
    """A full turn under the worst switching makes distances larger: a law that changes on lines shows it."""
    result = ns.System(["x", "y"], WORST[name], at=[1, -2] if name.startswith("about") else [0, 0]).check()
    assert result.verdict == "unstable"
    certificate = result.certificate()
    assert certificate["evidence"][0]["theorem"] == "choice"
    assert not refusal(certificate, len(certificate_text(certificate)))


def factor_of_one_field() -> ns.System:
    return ns.System(["x", "y"], ["-k*y - k*x*y", "2*k*x + 2*k*x*y"], parameters={"k": [1, 2]})


def test_fields_that_are_parallel_everywhere() -> None:
    system = factor_of_one_field().system
    assert parallel_lines(system, *started(system)) == []


@thorough  # the test above asks for lines only
def test_a_factor_of_one_field_makes_nothing_unstable() -> None:
    """A factor between 1 and 2 leaves its orbits as they are."""
    assert factor_of_one_field().check().verdict == "undecided"


@pytest.mark.usefixtures("without_reach")
def test_fields_that_a_switch_cannot_make_unstable() -> None:
    """Neither field leaves, nor does any mixture: super-twisting is stable, and a gain of 3/2 holds half the push."""
    rhs = ["-3*sqrt(Abs(x))*sign(x)/2 + y", "-sign(x) + d"]
    assert ns.System(["x", "y"], rhs, parameters={"d": ["-1/2", "1/2"]}).check().verdict == "asymptotically stable"


def test_an_enclosed_field_has_no_choice() -> None:
    """Between the polynomials that enclose a sine some make the point unstable; the sine does not."""
    assert ns.System(["x", "y"], ["y", "-sin(x) - y**3"]).check().verdict != "unstable"


@pytest.mark.parametrize("sides", keep(1, [[["x**3"], ["-sin(x)"]], [["x**3", "-y"], ["-sin(x) + y", "-y"]]]))
def test_a_right_hand_side_without_sines_leaves_beside_an_enclosed_one(sides: list[list[str]]) -> None:
    result = ns.System(["x", "y"][: len(sides[0])], sides).check()
    assert (result.verdict, result.evidence.method) == ("unstable", "choice among right-hand sides")
    assert result.evidence.check()
    with pytest.raises(NoCertificateError, match="does not state right-hand sides without sines"):
        result.certificate()


def test_the_chosen_law_leaves_in_floats() -> None:
    """Twisting that is pushed along with its velocity: half turns from the axis get larger."""
    x, y, step, turns = 1.0, 0.0, 1e-4, []
    for _ in range(100_000):
        y += step * (-3 * np.sign(x) + np.sign(y) / 2)
        if x * (x + step * y) < 0:
            turns.append(abs(y))
        x += step * y
    assert len(turns) > 3
    assert all(after > 1.05 * before for before, after in pairwise(turns))
