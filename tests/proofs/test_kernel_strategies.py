"""What the kernel decides where the theory of the plane leaves it open: verdicts, witnesses, quotients, weights."""

from __future__ import annotations

import copy
import math
from collections.abc import Callable
from copy import deepcopy
from fractions import Fraction
from functools import cache
from itertools import pairwise, product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.proofs.checker.polynomials import Polynomial, variable
from nonsmooth.proofs.checker.positivity import Claim, Inequality, cube_guards, identity, show
from nonsmooth.proofs.checker.statements import VERSION, refusal
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.inequalities.prover import Counterexample, Proof
from nonsmooth.proofs.kernel import simplices
from nonsmooth.proofs.kernel.quotients import find_quotient, proposed
from nonsmooth.proofs.kernel.search import decide_claim
from nonsmooth.proofs.kernel.subject import about
from nonsmooth.proofs.kernel_strategies import decide_by_kept_energy, decide_by_quotient
from nonsmooth.proofs.many_states.lyapunov_search import find_growing_product
from nonsmooth.proofs.system_certificates import certificate_of, certificate_text
from nonsmooth.proofs.system_decision import StabilityResult, checked_point, decide_system
from nonsmooth.proofs.systems.findings import Method
from tests.certificates.inclusion import contradiction
from tests.oracles.floats import midpoint
from tests.thorough import examples, few, keep, thorough

# ---- What the theory of the plane leaves open and the kernel decides: verdicts, certificates, forged ones.

SIZE = 1 << 20  # of a file, for which there is enough work


def decided(*rhs: str) -> StabilityResult:
    return decide_system(ns.System(list("xyzuv"[: len(rhs)]), list(rhs)).system)


@pytest.mark.parametrize(
    "rhs",
    keep(
        2,
        [
            "x + y**2; -y**3",
            "x*y; x**2 + y**2",
            "y; sign(x) - sign(y)",  # in one quadrant, where the relays cancel
            "y; -2*sign(x) + y**3",  # energy grows, and nothing stays where it does not
            "y; -sign(x) + y/2; -z",  # the same energy beside a third state
        ],
    ),
)
def test_instability(rhs: str) -> None:
    result = decided(*rhs.split("; "))
    assert result.verdict is Translation.UNSTABLE
    assert not contradiction(certificate_of(result)["statement"])


@pytest.mark.parametrize("form", ["x**2 + y**2", "x**2", "(x - y)**2"])
def test_signs_that_change_nowhere_bound_no_cells(form: str) -> None:
    """The formula asks for a sign, and no surface says where it changes: almost everywhere the field is ``-x, -y``."""
    assert decided(f"-x*sign({form})", "-y").verdict is Translation.ASYMPTOTICALLY_STABLE
    assert decided(f"x*sign({form})", "-y").verdict is Translation.UNSTABLE


@pytest.mark.usefixtures("without_reach")
def test_a_definite_form_that_a_curve_is_multiplied_by_is_a_surface_of_the_certificate() -> None:
    """``x**3 - y**3`` changes its sign where ``x - y`` does; a certificate lists both factors."""
    result = decided("-sign(x**3 - y**3)", "-y")
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert "x**2 + x*y + y**2" in certificate_of(result)["evidence"][0]["hypotheses"]["cells"]["surfaces"]


def test_a_center_manifold_has_a_rate_where_its_v_falls_everywhere() -> None:
    """``u' = -u^3`` on it, so V falls as ``1/t`` and no faster; the certificate says so with the V."""
    result = decided("y", "-x**3 - y")
    rate, near = result.reach.rate, result.reach.near
    assert (result.method, result.reach.everywhere) == (Method.CENTER, True)
    assert rate is not None
    assert near is not None
    assert (rate.decay.name, rate.function != "") == ("ALGEBRAIC", True)
    statement = certificate_of(result)["statement"]
    stated = [claim["rate"] for claim in statement["claims"] if "rate" in claim]
    assert [(record["kappa"], record["function"]) for record in stated] == [(str(rate.kappa), rate.function)]
    assert not contradiction(statement)


def test_a_solution_in_a_thin_cell() -> None:
    """For ``0 < y < x^2`` the field is ``x^2, -y``: x = 1 / (1 / x_0 - t) grows while y falls, so it stays there."""
    result = decided("(1 + sign(y)*sign(x**2 - y))*x**2/2 - x*(1 - sign(y)*sign(x**2 - y))", "-y")
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.ESCAPE)
    assert result.check()


def test_a_mixture_of_stable_systems_may_leave() -> None:
    """Under arbitrary switching: both are Hurwitz, and half of each has the eigenvalue 3/2."""
    system = ns.System(["x", "y"], [["-x + 5*y", "-y"], ["-x", "5*x - y"]]).system
    result = decide_system(system)
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.ESCAPE)
    assert result.check()
    calm = ns.System(["x", "y"], [["-x + y", "-y"], ["-x", "y*0 + x - y"]]).system
    assert decide_system(calm).verdict is Translation.ASYMPTOTICALLY_STABLE


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize(
    "rhs", keep(1, [["y", "-sign(x) - y/2 + z", "-z"], ["y - x", "-sign(x) + z", "-z - y"]]), ids="; ".join
)
def test_energies_of_three_states(rhs: list[str]) -> None:
    result = decided(*rhs)
    assert (result.verdict, result.method) == (Translation.ASYMPTOTICALLY_STABLE, Method.INVARIANCE)
    assert result.check()


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize("rhs", keep(1, ["-x**5; x*y**2", "-x**3; x**2", "-x**5; x**3", "-y**2; x**3", "y**3; -x**2"]))
def test_a_product_falls_in_a_quadrant(rhs: str) -> None:
    """Where all terms of a degree vanish on an axis: no solution runs outward along a curve to leading order."""
    result = decided(*rhs.split("; "))
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.INSTABILITY)
    assert result.check()


@pytest.mark.usefixtures("without_reach")
@pytest.mark.parametrize(
    "rhs", keep(2, ["0; -y", "-x*y**2; x**3", "-x*y; -y + x**2", "y; -sign(x) - sign(y)", "y; -2*sign(x) - y**3"])
)
def test_what_stays_near_is_not_called_unstable(rhs: str) -> None:
    """Beside points from which solutions leave: with another sign, and where only some move."""
    system = ns.System(["x", "y"], rhs.split("; ")).system
    assert decide_system(system).verdict is not Translation.UNSTABLE


@pytest.fixture(scope="module")
def by_factors() -> dict[str, Any]:
    system = ns.System(["x", "y"], ["y", "sign(x) - sign(y)"]).system
    entry = find_growing_product(system)
    assert entry is not None
    statement = {"subject": about(system), "claims": [{"stability": "unstable"}]}
    certificate = {"version": VERSION, "statement": statement, "evidence": [entry]}
    assert not refusal(certificate, SIZE)
    return certificate


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("speed", "0"),
        ("speed", "-1/16"),
        ("speed", "1000000"),
        ("speed", None),
        ("second", {"functions": [], "zeros": {}}),
        ("function", "x*y"),
        ("function", "-(x*y) - x"),
        ("direction", ["1", "-1"]),
    ],
)
def test_forged_products_are_rejected(key: str, value: object, by_factors: dict[str, Any]) -> None:
    forged = deepcopy(by_factors)
    forged["evidence"][0]["hypotheses"][key] = value
    assert refusal(forged, SIZE)


def test_functions_that_do_not_change_are_not_proposed() -> None:
    assert not list(proposed(np.zeros((3, 2))))


# ---- Claims of certificates end in a proof that the checker takes, in a point that refutes them, or open.

WORK = 400
STEPS = [Fraction(k, 4) for k in range(-4, 5)]  # of a grid in the cube

# a polynomial by its coefficients, a guard likewise
Terms = dict[tuple[int, ...], int]


def terms(count: int, degree: int) -> st.SearchStrategy[Terms]:
    exponents = [e for e in product(range(degree + 1), repeat=count) if sum(e) <= degree]
    return st.dictionaries(st.sampled_from(exponents), st.integers(-4, 6), min_size=1, max_size=6)


def value(terms: Terms, point: tuple[Fraction, ...]) -> Fraction:
    total = Fraction(0)
    for exponents, coefficient in terms.items():
        term = Fraction(coefficient)
        for x, e in zip(point, exponents, strict=True):
            term *= x**e
        total += term
    return total


def claim_of(count: int, polynomial: Terms, guard: Terms, *, strict: bool) -> Claim:
    surface = Polynomial(count, {e: Fraction(c) for e, c in guard.items()})
    inequality = Inequality(
        Polynomial(count, {e: Fraction(c) for e, c in polynomial.items()}),
        {"s0": surface, **cube_guards(identity(count), count)},
    )
    return Claim("random", (inequality,), strict=strict)


@examples(40)
@given(st.data(), st.sampled_from((1, 2, 3)), st.booleans())
def test_outcomes_against_values_on_a_grid(data: st.DataObject, count: int, strict: bool) -> None:
    polynomial, guard = data.draw(terms(count, 3)), data.draw(terms(count, 1))
    claim = claim_of(count, polynomial, guard, strict=strict)
    outcome = decide_claim(claim, WORK)

    def fails_at(point: tuple[Fraction, ...]) -> bool:
        here = value(polynomial, point)
        return any(point) and value(guard, point) > 0 and (here < 0 or (strict and not here))

    if isinstance(outcome, Proof):
        show(claim, outcome.evidence)
        assert not any(map(fails_at, product(STEPS, repeat=count)))
    elif isinstance(outcome, Counterexample):
        point = tuple(Fraction(int(x.p), int(x.q)) for x in outcome.point)
        assert fails_at(point)
        assert max(map(abs, point)) <= 1
        assert value(polynomial, point) == Fraction(int(outcome.value.p), int(outcome.value.q))


def test_a_pair_of_fields_is_refuted_where_no_mixture_falls() -> None:
    """``p_1 + mu q_1 > 0`` and ``p_2 + mu q_2 > 0`` with q_1 = 1 and q_2 = -1 ask for ``p_1 + p_2 > 0``."""
    x = variable(1, 0)
    one = Polynomial(1, {(0,): Fraction(1)})
    guards = cube_guards(identity(1), 1)
    up, down = Inequality(x, guards, (one,), side=(1,)), Inequality(x - one.times(1), guards, (-one,), side=(-1,))
    outcome = decide_claim(Claim("face", (up, down), strict=True), WORK)
    assert isinstance(outcome, Counterexample)
    (place,) = outcome.point
    assert 2 * place - 1 <= 0


@pytest.mark.parametrize("at_origin", [False, True])
@pytest.mark.parametrize("number", [-1, 0, 1])
def test_claims_about_one_point(number: int, at_origin: bool) -> None:
    """In no variables there is the origin alone, at which something is claimed or not."""
    claim = Claim("point", (Inequality(Polynomial(0, {(): Fraction(number)}), {}),), strict=True, at_origin=at_origin)
    found = simplices.search(claim, WORK)
    assert isinstance(found, Counterexample) == (at_origin and number <= 0)
    if isinstance(found, dict):
        show(claim, found)


# ---- A V that is a quotient: where no polynomial serves, and what the checker refuses of one -----

TURN = "-x**4 + 2*x**2*y**2 + y**4", "x**4 + 2*x**2*y**2 - y**4"  # gradient of V, times |x|^4/2, over x and y
NO_POLYNOMIAL = [  # Ahmadi and El Khadir 2018: no polynomial V at all
    f"-2*y*({TURN[0]}) - 2*x*(x**2 + y**2)*({TURN[1]})",
    f"2*x*({TURN[1]}) - 2*y*(x**2 + y**2)*({TURN[0]})",
]
GROWING = [
    f"-2*y*({TURN[0]}) + 2*x*(x**2 + y**2)*({TURN[1]})",
    f"2*x*({TURN[1]}) + 2*y*(x**2 + y**2)*({TURN[0]})",
]
V = "(x**4 + y**4)/(x**2 + y**2)"


@cache
def checked(rhs: tuple[str, ...], lyapunov: str | None = None) -> Any:
    return ns.System(["x", "y", "z"][: len(rhs)], list(rhs), lyapunov=lyapunov).check()


@cache
def certificate() -> dict[str, Any]:
    record: dict[str, Any] = checked(tuple(NO_POLYNOMIAL), V).certificate()
    return record


def refused(changed: dict[str, Any]) -> str:
    record = copy.deepcopy(certificate())
    record["evidence"][0]["hypotheses"].update(changed)
    return refusal(record, len(certificate_text(record)))


@pytest.mark.parametrize("stated", keep(1, [V, None]))
def test_no_polynomial_serves(stated: str | None) -> None:
    """The stated quotient is taken, and the same is found without it; all starts come to the point."""
    result = checked(tuple(NO_POLYNOMIAL), stated)
    assert result.verdict == "asymptotically stable"
    assert result.evidence.reach.everywhere
    claims = result.certificate()["statement"]["claims"]
    assert claims == [{"stability": "asymptotically stable"}, {"attracts": "everywhere"}]


def test_a_quotient_is_found() -> None:
    found = decide_by_quotient(checked_point(ns.System(["x", "y"], NO_POLYNOMIAL).system))
    assert found is not None
    assert found.verdict is Translation.ASYMPTOTICALLY_STABLE


def test_floats_come_nearer() -> None:
    """By steps of Runge and Kutta of the literal formulas, in a time in which the field has the size of x."""

    def field(place: np.ndarray) -> np.ndarray:
        x, y = place
        first, second = -(x**4) + 2 * x**2 * y**2 + y**4, x**4 + 2 * x**2 * y**2 - y**4
        square = x**2 + y**2
        numerator = [-2 * y * first - 2 * x * square * second, 2 * x * second - 2 * y * square * first]
        return np.stack(numerator) / square**2

    x = np.random.default_rng(0).uniform(-1, 1, (2, 50))
    start = np.linalg.norm(x, axis=0)
    for _ in range(4_000):
        x = midpoint(field, x, 0.01)
    assert (np.linalg.norm(x, axis=0) < 0.9 * start).mean() > 0.8


@thorough  # forged ones: test_false_quotients_are_refused
def test_a_stated_quotient_that_grows_shows_nothing() -> None:
    result = checked(tuple(GROWING), V)
    assert result.verdict != "asymptotically stable"
    assert "tried: V = (x**4 + y**4)/(x**2 + y**2)" in str(result.facts()) + str(result)


@pytest.mark.parametrize(
    "changed",
    [
        {"denominator": "x**2 - y**2"},
        {"denominator": "-(x**2 + y**2)", "function": "-(x**4 + y**4)"},
        {"denominator": "x**2"},
        {"denominator": "x**4 + y**4"},  # V = 1
        {"denominator": "(x**2 + y**2)**3"},  # V is not bounded at the point
        {"denominator": "x**2 + y**2 + x**4"},  # neither a form nor positive at the point
        {"denominator": "Abs(x) + Abs(y)"},
        {"denominator": None},
        {"rate": {"kind": "exponential", "kappa": "1/1000000"}},
        {"second": {"functions": ["x"], "zeros": {}}},
    ],
)
def test_false_quotients_are_refused(changed: dict[str, Any]) -> None:
    assert refused(changed)


def test_a_mesh_beside_a_quotient_is_refused() -> None:
    """Its level set is that of the quotient, not of the numerator."""
    record = copy.deepcopy(certificate())
    entry = record["evidence"][0]
    corners = ["-1 -1 0", "1 -1 0", "0 1 0"]
    mesh = {"unit": "1/8", "corners": corners, "triangles": ["0 1 2"]}
    entry["hypotheses"] = {"local": entry["hypotheses"], "surfaces": [], "mesh": mesh, "below": 1}
    entry["theorem"] = "basin"
    assert "denominator" in refusal(record, len(certificate_text(record)))


@pytest.mark.parametrize(
    "text", ["1/x", "x**3/(x + y)", "x**4/(x**2 + y**3)", "x**2/(y**2 - 1)", "(x**2 + y**2)/(1 + Abs(x))", "x**2/(1/y)"]
)
def test_other_divisions_are_refused_in_one_line(text: str) -> None:
    with pytest.raises(ns.SceneError, match=r"check\.lyapunov"):
        ns.System(["x", "y"], ["-x", "-y"], lyapunov=text)


def test_simplex_steps_that_go_round_in_circles_come_to_an_end() -> None:
    rhs = ["-3*x/(1 + x**2) - z*x**2/2", "-3*y + x/(2*(1 + y**2)) + y*x**2", "-2*z + 2*z**2"]
    assert find_quotient(ns.System(["x", "y", "z"], rhs).system, everywhere=True) is None


# ---- Relay oscillators that an energy leaves open: terms of higher weight decide, and half turns of polygons agree.

Force = Callable[[float, float], float]
GROWS, FALLS = "unstable", "asymptotically stable"


def sign_of(x: float) -> float:
    """Of a number that is not zero, as a number of Python, which is fast."""
    return math.copysign(1, x)


FORCES: dict[str, tuple[str, Force]] = {  # y' of x' = y
    "-3*sign(x) + 2*y**3 + x**2": (GROWS, lambda x, y: -3 * sign_of(x) + 2 * y**3 + x**2),
    "-3*sign(x) - 2*y**3 + x**2": (FALLS, lambda x, y: -3 * sign_of(x) - 2 * y**3 + x**2),
    "-2*sign(x) + y**2*x + y**3": (GROWS, lambda x, y: -2 * sign_of(x) + y**2 * x + y**3),
    "-3*sign(x) - 2*y**3 - x**2*y + x*y": (FALLS, lambda x, y: -3 * sign_of(x) - 2 * y**3 - x**2 * y + x * y),
}
CENTRE = "-sign(x) + x*y"  # turned by (x, t) -> (-x, -t) into itself: all orbits near the point are closed


def half_turns(force: Force, y: float = 0.3, step: float = 1e-4) -> list[float]:
    """The speeds at which x passes 0, by the midpoint rule on each side of it."""
    x, speeds = 0.0, list[float]()
    for _ in range(200_000):
        if abs(y) > 1:
            break
        side = sign_of(x) if x else sign_of(y)
        middle = x + step / 2 * y, y + step / 2 * force(side * max(abs(x), 1e-12), y)
        after = x + step * middle[1], y + step * force(side * max(side * middle[0], 1e-12), middle[1])
        if after[0] * side < 0:
            speeds.append(abs(after[1]))
            after = 0.0, after[1]
        x, y = after
    return speeds


def verdict_by_weights(force: str) -> str:
    """What terms of higher weight say, and nothing else."""
    found = decide_by_kept_energy(checked_point(ns.System(["x", "y"], ["y", force]).system))
    return "nothing" if found is None else str(found.verdict)


@pytest.mark.parametrize("force", keep(2, FORCES))
def test_terms_of_higher_weight_are_found(force: str) -> None:
    verdict, _ = FORCES[force]
    assert verdict_by_weights(force) == verdict


@thorough  # how it is decided: the test above; certificates of all theorems: checker/test_corpus.py
@pytest.mark.parametrize("force", FORCES)
def test_terms_of_higher_weight_decide(force: str) -> None:
    verdict, _ = FORCES[force]
    result = ns.System(["x", "y"], ["y", force]).check()
    assert result.verdict == verdict
    certificate = result.certificate()
    assert {"stability": verdict} in certificate["statement"]["claims"]
    assert not refusal(certificate, len(certificate_text(certificate)))


@few(1)  # of the force whose certificate is looked at
@pytest.mark.parametrize("force", FORCES)
def test_half_turns_agree(force: str) -> None:
    verdict, acceleration = FORCES[force]
    turns = half_turns(acceleration)
    every_other = turns[::2]
    assert len(every_other) > 5
    signs = {after > before for before, after in pairwise(every_other)}
    assert signs == {verdict == GROWS}


def test_a_centre_is_neither() -> None:
    """Its half turns come back after two."""
    turns = half_turns(lambda x, y: -sign_of(x) + x * y)
    assert turns[20] == pytest.approx(turns[0], rel=1e-2)
    assert verdict_by_weights(CENTRE) == "nothing"


@thorough  # the test above asks for one theorem
def test_no_theorem_decides_a_centre() -> None:
    assert ns.System(["x", "y"], ["y", CENTRE]).check().verdict not in (GROWS, FALLS)
