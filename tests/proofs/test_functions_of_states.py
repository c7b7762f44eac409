"""A V of states by forms in their roots: differentiators of second order, and others whose solutions touch axes."""

from __future__ import annotations

import random
from fractions import Fraction

import numpy as np
import pytest
from numpy.typing import NDArray

from nonsmooth.analysis.fields.system_field import system_field
from nonsmooth.analysis.trajectories.trajectory import simulate
from nonsmooth.proofs.findings import Translation
from nonsmooth.proofs.kernel.homogeneity import homogeneity_of
from nonsmooth.proofs.kernel.rooted_functions import seen_in_roots
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.plain import built, refused
from tests.thorough import few, keep, thorough

ATTRACTS, LEAVES, OPEN = Translation.ASYMPTOTICALLY_STABLE, Translation.UNSTABLE, Translation.UNDECIDED
STATES = ("x", "y", "z")
WEIGHTS = np.array([3, 2, 1])  # of the states
POWERS = {  # of each state, by its weight
    "x": {2: "Abs(x)**(2/3)*sign(x)", 1: "Abs(x)**(1/3)*sign(x)", 0: "sign(x)"},
    "y": {2: "y", 1: "sqrt(Abs(y))*sign(y)", 0: "sign(y)"},
    "z": {2: "z*Abs(z)", 1: "z", 0: "sign(z)"},
}
Matrix = list[list[Fraction]]


def homogeneous(gains: Matrix, parameters: dict[str, object] | None = None, more: str = "") -> SwitchedSystem:
    """``x' = sum of a_j [x_j]^(2/r_j)``, ``y'`` of ``1/r_j`` and ``z'`` of signs, r the weights; and more in ``z'``."""
    rhs = []
    for weight, row in zip((2, 1, 0), gains, strict=True):
        terms = [f"({c})*{POWERS[name][weight]}" for c, name in zip(row, STATES, strict=True) if c]
        rhs.append(" + ".join(terms) or "0")
    return built([*rhs[:2], rhs[2] + more], parameters, states=STATES)


def differentiator(*gains: str) -> Matrix:
    """Levant's, of second order, for errors: ``x' = -a [x]^(2/3) + y, y' = -b [x]^(1/3) + z, z' = -c sign(x)``."""
    a, b, c = map(Fraction, gains)
    one, no = Fraction(1), Fraction(0)
    return [[-a, one, no], [-b, no, one], [-c, no, no]]


def sizes_of_ends(gains: Matrix, disturbance: float = 0.0) -> tuple[float, float]:
    """Of Euler polygons in the states from the unit sphere of weights: the largest least size, and the largest one.

    Steps are in proportion to the size ``max |x_j|^(1/r_j)``, since the degree is -1; ``z'`` is disturbed by the worst
    of a few switching signals.
    """
    source, matrix = np.random.default_rng(0), np.array(gains, dtype=float)
    x = source.normal(size=(3, 40))
    x /= size_of(x) ** WEIGHTS[:, None]
    least, most = np.full(x.shape[1], np.inf), 0.0
    for step in range(40_000):
        size = size_of(x)
        least, most = np.minimum(least, size), max(most, float(size.max()))
        if (least < 0.05).all() or most > 30:
            break
        roots = np.sign(x) * np.abs(x) ** (1 / WEIGHTS[:, None])
        powers = [np.sign(roots) * np.abs(roots) ** weight for weight in (2, 1)]
        velocity = np.stack([matrix[0] @ powers[0], matrix[1] @ powers[1], matrix[2] @ np.sign(x)])
        velocity[2] += disturbance * (np.sign(x[0]) if step // 500 % 2 else np.sign(x[2]))
        x = x + 2e-3 * np.clip(size, 0.003, 50) * velocity
    return float(least.max()), most


def size_of(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """``max |x_j|^(1/r_j)``, of states in columns."""
    sizes: NDArray[np.float64] = (np.abs(x) ** (1 / WEIGHTS[:, None])).max(axis=0)
    return sizes


@thorough  # in the plane: test_no_path_takes_longer_than_the_time_of_arrival; in space the one with a wrong sign
@pytest.mark.parametrize("gains", [("2", "53/25", "11/10"), ("3", "3", "11/10"), ("5", "4", "11/10")])
def test_differentiators_of_second_order_arrive_from_everywhere(gains: tuple[str, str, str]) -> None:
    result = decide_system(homogeneous(differentiator(*gains)))
    assert result.verdict is ATTRACTS
    assert result.reach.everywhere
    assert result.reach.in_finite_time
    assert result.reach.arrival is not None
    certificate = certificate_of(result)
    assert refused(certificate) == ""
    assert {"arrives": "in finite time"} in certificate["statement"]["claims"]
    assert certificate["evidence"][0]["hypotheses"]["roots"] == {"x": 3, "y": 2}
    least, _ = sizes_of_ends(differentiator(*gains))
    assert least < 0.05


@thorough  # in the plane: test_square_roots.test_a_disturbance_within_the_gain_is_rejected_and_a_larger_one_is_not
def test_a_bounded_disturbance_is_rejected_and_a_large_one_is_not() -> None:
    gains = differentiator("2", "53/25", "11/10")
    disturbed = homogeneous(gains, {"d": ["-1/4", "1/4"]}, " + d")
    result = decide_system(disturbed)
    assert result.verdict is ATTRACTS
    assert result.scene.intervals == ("d",)
    assert refused(certificate_of(result)) == ""
    assert sizes_of_ends(gains, disturbance=0.25)[0] < 0.05
    assert decide_system(homogeneous(gains, {"d": [-2, 2]}, " + d")).verdict is not ATTRACTS


def test_a_differentiator_with_a_wrong_sign_leaves() -> None:
    gains = differentiator("-1/2", "1", "1")
    result = decide_system(homogeneous(gains))
    assert result.verdict is LEAVES
    assert refused(certificate_of(result)) == ""
    assert sizes_of_ends(gains)[1] > 30


@few(2)
@pytest.mark.parametrize("seed", range(40))
def test_random_systems_agree_with_their_polygons(seed: int) -> None:
    source = random.Random(seed)

    def gain(chance: float) -> Fraction:
        return Fraction(source.choice((-16, -12, -8, -6, -4, -2, -1, 1, 4)), 4) * (source.random() < chance)

    one = Fraction(1)
    gains = [[gain(0.9), one, gain(0.1)], [gain(0.9), gain(0.3), one], [gain(0.95), gain(0.3), gain(0.3)]]
    result = decide_system(homogeneous(gains))
    least, most = sizes_of_ends(gains)
    if result.verdict is ATTRACTS:
        assert least < 0.05, result.reason
    if result.verdict is LEAVES:
        assert max(least, most) > 0.9, result.reason
    assert result.check()


def test_roots_are_taken_with_the_weights_as_orders() -> None:
    for system, orders in (
        (homogeneous(differentiator("2", "2", "1")), (3, 2, 1)),
        (built(["y", "-2*sgn(x) - sgn(y)"]), (2, 1)),
        (built(["-Abs(x)**(2/3)*sgn(x)"]), (3,)),
    ):
        in_roots = seen_in_roots(system, homogeneity_of(system))
        assert in_roots is not None
        assert (in_roots.orders, in_roots.degree) == (orders, -1)
    for rhs in (["y", "-x - y"], ["y + x**2", "-sgn(x)"], ["-sgn(x)", "-sgn(y)"]):
        assert seen_in_roots(built(rhs), homogeneity_of(built(rhs))) is None


# ---- how long it takes


ONE_STATE = [
    ("-sqrt(Abs(x))*sgn(x)", Fraction(2), "2*sqrt(abs(x))"),
    ("-2*Abs(x)**(2/3)*sgn(x)", Fraction(3, 2), "1.5*abs(x)**(1/3)"),
]


@pytest.mark.parametrize(("rhs", "factor", "words"), ONE_STATE)
def test_the_time_of_one_state_is_exact(rhs: str, factor: Fraction, words: str) -> None:
    arrival = decide_system(built([rhs])).reach.arrival
    assert arrival is not None
    assert arrival.factor == factor
    assert arrival.words(("x",)) == words


def latest(rhs: list[str], start: tuple[float, ...], until: float) -> float:
    """When a path comes to the origin and rests."""
    path = simulate(system_field(built(rhs), start), start, until)
    assert max(map(abs, path.end.state)) < 1e-9
    return float(next(event.t for event in path.events if max(map(abs, event.state)) < 1e-9))


TWISTING = ["y", "-2*sgn(x) - sgn(y)"]
SUPER_TWISTING = ["-3/2*sqrt(Abs(x))*sgn(x) + y", "-11/10*sgn(x)"]
BHAT = ["y", "-Abs(x)**(1/3)*sgn(x) - sqrt(Abs(y))*sgn(y)"]
TERMINAL = ["y", "-2*sgn(y + sqrt(Abs(x))*sgn(x))"]


@pytest.mark.parametrize(("rhs", "loss"), keep(1, [(SUPER_TWISTING, 4), (TWISTING, 4), (TERMINAL, 6), (BHAT, 12)]))
def test_no_path_takes_longer_than_the_time_of_arrival(rhs: list[str], loss: float) -> None:
    """And some of them take at least a part of it: the bound is of use."""
    result = decide_system(built(rhs))
    arrival = result.reach.arrival
    assert arrival is not None
    shares = []
    for start in ((1.0, 0.0), (-0.3, 0.5), (0.2, -1.0), (2.0, 2.0), (-0.01, 0.3)):
        sizes = [float(c) * abs(x) ** (1 / q) for c, x, q in zip(arrival.size, start, arrival.orders, strict=True)]
        bound = float(arrival.factor) * sum(sizes) ** arrival.power
        shares.append(latest(rhs, start, 1.1 * bound) / bound)
    assert max(shares) <= 1
    assert max(shares) > 1 / loss
    certificate = certificate_of(result)
    assert refused(certificate) == ""
    (claim,) = [
        claim["arrives"] for claim in certificate["statement"]["claims"] if isinstance(claim.get("arrives"), dict)
    ]
    assert Fraction(claim["factor"]) == arrival.factor
    claim["factor"] = str(arrival.factor * Fraction(99, 100))
    assert refused(certificate).startswith("evidence of the claim")
    numbers = next(
        entry["hypotheses"]["arrival"] for entry in certificate["evidence"] if "arrival" in entry["hypotheses"]
    )
    for key, part in (("speed", Fraction(5, 4)), ("above", Fraction(1, 2))):
        stated = numbers[key]
        numbers[key] = str(Fraction(stated) * part)
        assert "for size " in refused(certificate) or "for arrival " in refused(certificate)
        numbers[key] = stated


def test_the_time_of_arrival_scales_as_time_does() -> None:
    """Twice as fast a field has half the time: the same V serves."""
    once, twice = (decide_system(built(rhs)).reach.arrival for rhs in (TWISTING, ["2*y", "-4*sgn(x) - 2*sgn(y)"]))
    assert once is not None
    assert twice is not None
    assert float(once.factor / twice.factor) == pytest.approx(2, rel=0.02)
    assert once.words(("x", "y")) == f"{float(once.factor):g}*(sqrt(abs(x)) + {float(once.size[1]):g}*abs(y))"


def test_a_path_of_a_differentiator_arrives_and_is_the_only_one() -> None:
    """Infinitely many switches accumulate where all states are zero at once, though two surfaces meet there alone."""
    start = (0.2, 0.4, 0.2)
    system = homogeneous(differentiator("2", "3/2", "11/10"))
    path = simulate(system_field(system, start), start, 5.0)
    assert path.end.t == 5
    assert path.end.state == (0.0, 0.0, 0.0)
    assert path.unique
    at_rest = simulate(system_field(system, (0.0, 0.0, 0.0)), (0.0, 0.0, 0.0), 1.0)
    assert at_rest.unique
