"""Gains of disturbances, against polygons whose disturbance does its worst, and in certificates."""

from __future__ import annotations

import json
from dataclasses import replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from nonsmooth.proofs.checker.cells import read_system
from nonsmooth.proofs.checker.descriptions import describe
from nonsmooth.proofs.kernel.search import NotShownError, Search
from nonsmooth.proofs.system_certificates import certificate_of
from nonsmooth.proofs.system_decision import StabilityResult, decide_system
from nonsmooth.proofs.system_facts import gain_words, rate_words
from nonsmooth.proofs.systems.domain import DecayKind
from tests.oracles.floats import value
from tests.oracles.mutants import Record
from tests.plain import built, refused
from tests.proofs.forged import with_reach
from tests.thorough import but, few, keep

# ---- The gain of a disturbance against polygons of the disturbed system, whose disturbance does its worst.

STEP = 1e-3
DIRECTIONS = np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0, 2 * np.pi, 24, endpoint=False)])

# Right-hand sides with a V that has a rate: smooth ones, bends along sliding edges (slanted fields too), crossings.
# The last ones are systems of cones, whose V is proved on the plane; their gain holds on the checked square.
SYSTEMS = [
    (("-x - x**3", "-y"), "x**2 + y**2"),
    (("-2*sgn(x) + y", "-3*sgn(y) + sgn(x) - x"), "x**2 + y**2"),
    (("-2*sgn(x) - x**3", "-sgn(y)"), "Abs(x) + Abs(y)"),
    (("-2*sgn(x) - x**3", "3*sgn(x) - 4*sgn(y)"), "4*Abs(x) + Abs(y)"),
    (("-2*sgn(x)", "3*sgn(x) - 4*sgn(y)"), "4*Abs(x) + Abs(y) + x*y/2"),
    (("-sgn(x) - 2*x", "sgn(x) - 2*y"), "2*Abs(x) + y**2"),
    (("-sgn(x) + sgn(y)/2 - x**3", "-sgn(y) - sgn(x)/2"), "Max(Abs(x), Abs(y))"),
    (("-sgn(x) + sgn(y)/2 - x**3", "-sgn(y) - sgn(x)/2"), "Abs(x) + Abs(y)"),
    (("y - 2*x", "-x - y - sgn(x + y)/4"), "x**2 + y**2 + Abs(x + y)/8"),
    (("-2*sgn(x) + sgn(y)/2", "-sgn(y) - sgn(x)/4"), "x**2 + y**2"),
    (("-2*sgn(x) + sgn(y)/2", "-sgn(y) - sgn(x)/4"), "Abs(x) + Abs(y)"),
    (("-x + Abs(y)/2", "-y - x/2"), "x**2 + y**2"),
]
FAR = np.random.default_rng(2).normal(size=(400, 2)) * 10.0 ** np.linspace(-3, 4, 400)[:, None]


def checked(rhs: tuple[str, str], lyapunov: str) -> StabilityResult:
    return decide_system(built(rhs, lyapunov=lyapunov))


def disturbed(rhs: tuple[str, str], lyapunov: str, starts: np.ndarray, delta: float, until: float) -> np.ndarray:
    """V along polygons of ``x' = f + d``, d in each step the one of 24 directions that leaves V largest."""
    x, y = starts.T
    values = [value(lyapunov, x=x, y=y)]
    for _ in range(int(until / STEP)):
        f, g = (value(text, x=x, y=y) for text in rhs)
        xs = x + STEP * (f + delta * DIRECTIONS[:, :1])
        ys = y + STEP * (g + delta * DIRECTIONS[:, 1:])
        best = np.argmax(value(lyapunov, x=xs, y=ys), axis=0)
        x, y = xs[best, np.arange(len(x))], ys[best, np.arange(len(x))]
        values.append(value(lyapunov, x=x, y=y))
    return np.array(values)


@pytest.mark.usefixtures("without_far_starts")
@few(1)
@pytest.mark.parametrize(("rhs", "lyapunov"), keep(2, SYSTEMS[::-1]))
@pytest.mark.parametrize(("share", "until"), keep(1, [(0.95, 1.5), (0.95, 3.0), (0.3, 3.0)]))
def test_no_disturbance_does_more(rhs: tuple[str, str], lyapunov: str, share: float, until: float) -> None:
    result = checked(rhs, lyapunov)
    gain = result.reach.gain
    assert gain is not None
    assert result.function is result.given
    assert result.check()
    assert gain.largest is not None
    assert gain.level is not None
    kappa, gamma, level = float(gain.rate.kappa), float(gain.gamma), float(gain.level)
    delta = share * float(gain.largest)
    radius = float(result.scene.check.radius)
    rng = np.random.default_rng(1)
    starts = rng.uniform(-radius, radius, (400, 2))
    starts = starts[value(lyapunov, x=starts[:, 0], y=starts[:, 1]) < level][:40]
    values = disturbed(rhs, lyapunov, starts, delta, until)
    speed = max(float(np.abs(value(text, x=starts[:, 0], y=starts[:, 1])).max()) for text in rhs) + delta
    slack = 4 * gamma * STEP * (speed + 1)  # what a step across an edge adds
    times = STEP * np.arange(len(values))[:, None]
    if gain.rate.decay is DecayKind.EXPONENTIAL:
        assert gain.ultimate == gain.gamma / gain.rate.kappa
        bound = np.exp(-kappa * times) * values[0] + gamma * delta / kappa * (1 - np.exp(-kappa * times))
    else:
        assert gain.ultimate is None
        bound = np.maximum(values[0] - (kappa - gamma * delta) * times, 0)
    assert np.all(values <= bound + slack)
    assert values.max() < level + slack


@pytest.mark.usefixtures("without_far_starts")
@pytest.mark.parametrize(("rhs", "lyapunov"), keep(2, SYSTEMS[3:] + SYSTEMS[:3]))
def test_gamma_is_above_every_gradient_and_close_to_the_largest(rhs: tuple[str, str], lyapunov: str) -> None:
    gain = checked(rhs, lyapunov).reach.gain
    assert gain is not None
    x, y = (np.linspace(-0.5, 0.5, 201)[:, None] + 1e-4), (np.linspace(-0.5, 0.5, 201)[None] + 1.3e-4)
    h = 1e-6
    slopes = [
        value(lyapunov, x=x + h, y=y) - value(lyapunov, x=x, y=y),
        value(lyapunov, x=x, y=y + h) - value(lyapunov, x=x, y=y),
    ]
    largest = np.hypot(*(s / h + np.zeros((201, 201)) for s in slopes))[:-1, :-1].max()
    assert largest <= float(gain.gamma) + 1e-3
    assert float(gain.gamma) <= 1.1 * largest + 0.05


@pytest.mark.usefixtures("without_far_starts")
def test_a_larger_disturbance_drives_solutions_out() -> None:
    """``x' = -2 sgn x + d``: beyond 2 nothing holds; V = Abs(x) + Abs(y) has kappa 1 at best, and gamma = sqrt(2)."""
    gain = checked(("-2*sgn(x) - x**3", "-sgn(y)"), "Abs(x) + Abs(y)").reach.gain
    assert gain is not None
    assert gain.largest is not None
    assert 0.5 < float(gain.largest) < 1 / np.sqrt(2)
    start = np.array([[0.05, 0.05]])
    values = disturbed(("-2*sgn(x)", "-sgn(y)"), "Abs(x) + Abs(y)", start, 1.5, 1.0)
    assert values[-1, 0] > values[0, 0]


@pytest.mark.usefixtures("without_far_starts")
def test_a_smaller_gamma_is_rejected() -> None:
    result = checked(SYSTEMS[1][0], SYSTEMS[1][1])
    gain = result.reach.gain
    assert gain is not None
    assert not with_reach(result, gain=replace(gain, gamma=gain.gamma * Fraction(3, 4))).check()


@pytest.mark.usefixtures("without_far_starts")
def test_a_corner_at_which_a_disturbance_may_hold_a_solution_counts() -> None:
    """Two relays meet at (1/4, 1/4), where F is a square: d holds a solution there at once."""
    rhs = ("-1 * sgn(x) - sgn(x - 1/4)/2", "-1 * sgn(y) - sgn(y - 1/4)/2")
    gain = checked(rhs, "Abs(x) + Abs(y)").reach.gain
    assert gain is not None
    kappa, gamma = float(gain.rate.kappa), float(gain.gamma)
    assert gain.rate.decay is DecayKind.FINITE
    least = np.hypot(0.5, 0.5)  # the shortest velocity there
    assert kappa <= gamma * least + 1e-12


@pytest.mark.parametrize(("rhs", "lyapunov"), SYSTEMS[-2:])
def test_rates_of_forms_hold_on_the_plane(rhs: tuple[str, str], lyapunov: str) -> None:
    """V' is at most ``-kappa``, or ``-kappa V``, far out and near the point; the gain holds on the checked square."""
    result = checked(rhs, lyapunov)
    rate, gain = result.reach.rate, result.reach.gain
    assert rate is not None
    assert rate.domain.radius is None
    assert gain is not None
    assert gain.domain.radius == result.scene.check.radius
    x, y = FAR.T
    step = 1e-7 * np.hypot(x, y)
    f, g = (value(text, x=x, y=y) for text in rhs)
    speed = np.hypot(f, g)
    rise = (value(lyapunov, x=x + step * f / speed, y=y + step * g / speed) - value(lyapunov, x=x, y=y)) * speed / step
    size = value(lyapunov, x=x, y=y) if rate.decay is DecayKind.EXPONENTIAL else 1.0
    assert (rise <= -float(rate.kappa) * size * (1 - 1e-5)).all()
    claims = certificate_of(result)["statement"]["claims"]
    assert any(claim.get("rate", {}).get("within", "") is None for claim in claims)
    assert any(claim.get("gain", {}).get("within") == str(gain.domain.radius) for claim in claims)


def test_a_quadratic_v_of_relays_has_a_rate_on_the_square() -> None:
    """V' has another degree than V: far out V falls more slowly than ``-kappa V``."""
    reach = checked(*SYSTEMS[-3]).reach
    assert reach.everywhere
    assert reach.rate is not None
    assert reach.gain is not None
    assert reach.rate.domain == reach.gain.domain
    assert reach.near is not None
    assert "every start with V < " in rate_words(reach, ("x", "y"))


def test_three_states() -> None:
    """``|grad V|`` stays below the gain on the cube and comes near it; the certificate states rate and gain."""
    result = decide_system(built(["-x + y - x**3", "-x - y", "-z - sign(z)"]))
    gain, half = result.reach.gain, float(result.scene.check.radius)
    assert gain is not None
    assert gain.domain == gain.rate.domain
    assert gain.largest is not None
    potential = result.function.text
    corners = np.array([[x, y, z] for x in (-half, half) for y in (-half, half) for z in (-half, half)])
    steps = 1e-6 * np.eye(3)
    slopes = [
        [(value3(potential, corner + step) - value3(potential, corner - step)) / 2e-6 for step in steps]
        for corner in corners
    ]
    steepest = np.linalg.norm(slopes, axis=1).max()
    assert steepest <= float(gain.gamma) < 1.1 * steepest
    claims = certificate_of(result)["statement"]["claims"]
    assert any(claim.get("gain", {}).get("gamma") == str(gain.gamma) for claim in claims)


def value3(text: str, point: np.ndarray) -> float:
    return float(value(text, **dict(zip("xyz", point, strict=True))))


ONE_STATE = {  # right-hand side: kind, whether everywhere, the largest kappa there is
    "-x": (DecayKind.EXPONENTIAL, True, 1.0),
    "-sign(x) - x": (DecayKind.FINITE, True, 1.0),
    "-x + x**2": (DecayKind.EXPONENTIAL, False, 0.5),
    "-2*x + Abs(x)/2 - x**3": (DecayKind.EXPONENTIAL, True, 1.5),
    "-3*x*(x - 1/4)**2 - x/8": (DecayKind.EXPONENTIAL, True, 0.125),
    "-sin(3*x)": (DecayKind.EXPONENTIAL, False, 2 * float(np.sin(1.5))),
}


@pytest.mark.parametrize("rhs", ONE_STATE)
def test_one_state(rhs: str) -> None:
    """The distance falls at least as fast as is said, which is nearly as fast as can be; the certificate states it."""
    decay, everywhere, largest = ONE_STATE[rhs]
    result = decide_system(built([rhs]))
    reach = result.reach
    assert reach.everywhere is everywhere
    assert reach.rate is not None
    assert reach.rate.decay is decay
    assert 0.7 * largest < float(reach.rate.kappa) <= largest
    assert rate_words(reach, ("x",)).startswith("V = abs(x): ")
    assert reach.gain is not None
    assert ("every start with V < " in gain_words(reach.gain, ("x",))) is not everywhere
    claims = certificate_of(result)["statement"]["claims"]
    assert ({"attracts": "everywhere"} in claims) is everywhere
    assert any(claim.get("gain", {}).get("gamma") == "1" for claim in claims)


PACES = [  # right-hand sides of every kind of rate; those of two states with a V of one formula, and of pieces
    ("-sign(x) - x",),
    ("-x",),
    ("-x**3",),
    ("y", "-x - y/5"),
    ("y", "-x - 4*Max(x, 0) - y/5"),
    ("-2*sgn(x) + sgn(y)/2 - x**3", "-sgn(y) - sgn(x)/4"),
    ("-x**3 + y**3", "-x**3 - y**3"),
    ("-x", "-3*y + Abs(x)", "-2*z"),
]


@few(4)
@pytest.mark.parametrize("rhs", but([PACES[4], PACES[6]], PACES))
def test_a_slower_system_has_a_slower_rate(rhs: tuple[str, ...]) -> None:
    """The unit of time decides nothing; the certificate states the rate."""
    rates = []
    for speed in (Fraction(1), Fraction(1, 100_000)):
        slower = [f"({speed})*({text})" for text in rhs]
        result = decide_system(built(slower))
        assert result.reach.rate is not None
        rates.append((result.reach.rate.decay, float(result.reach.rate.kappa / speed)))
        claims = certificate_of(result)["statement"]["claims"]
        assert any(claim.get("rate", {}).get("kappa") == str(result.reach.rate.kappa) for claim in claims)
    (kind, fast), (other, slow) = rates
    assert kind is other
    assert 0.8 < slow / fast < 1.25


def test_a_v_that_bends_has_a_rate_on_the_plane() -> None:
    """Along solutions of a spring that is stiffer on one side V falls at least as fast as is said."""
    result = decide_system(built(["y", "-x - 4*Max(x, 0) - y/5"]))
    reach = result.reach
    assert result.function is not None
    assert "Abs" in result.function.text
    assert reach.rate is not None
    assert reach.rate.domain.radius is None
    slowest = 0.2  # of V along solutions: twice the damping ratio at the least
    assert 0.02 < float(reach.rate.kappa) <= slowest
    assert reach.gain is not None
    assert reach.gain.domain.radius == result.scene.check.radius


SLOW = {  # the largest kappa in V' <= -kappa V**2 near the point, and whether it holds everywhere
    ("-x**3",): (2.0, True),
    ("-Max(x, x**3)",): (2.0, False),
    ("-x**5",): (4.0, True),
    ("-x*Abs(x) - x**3",): (1.0, True),
    ("-x**4*sign(x)/3",): (1.0, True),
    ("-x**3 + y**3", "-x**3 - y**3"): (1.0, True),
    ("-y - x**3", "x - y**3"): (1.0, False),
    ("-x**3 - z**3", "-y**3", "x**3 - z**3"): (2 / 3, True),
}


@few(5)
@pytest.mark.parametrize("rhs", SLOW)
def test_rates_of_higher_order(rhs: tuple[str, ...]) -> None:
    """Where linear terms are missing, or turn only, V is the square of the distance, and no gain is known."""
    largest, everywhere = SLOW[rhs]
    names = ["x", "y", "z"][: len(rhs)]
    result = decide_system(built(rhs))
    reach = result.reach
    assert reach.rate is not None
    assert reach.rate.decay is DecayKind.ALGEBRAIC
    assert 0.5 * largest < float(reach.rate.kappa) <= largest
    assert (reach.rate.domain.radius is None) is everywhere
    assert reach.gain is None
    assert "V0/(1 + " in rate_words(reach, names)
    claims = certificate_of(result)["statement"]["claims"]
    assert any(claim.get("rate", {}).get("kind") == "algebraic" for claim in claims)


FOUND = (
    "11*Abs(z)/96 + 21*Abs(y)/128 + 11*x**2/96 + 359*x*y/2304 - 11*x*z/192 + 27*y**2/32 - 13*y*z/256 + 3*z**2/64"
    " + x*Abs(z)/32 - 203*y*Abs(z)/768 - z*Abs(z)/64 - 11*x*Abs(y)/64 + 5*y*Abs(y)/64 + 7*z*Abs(y)/64 - 11*x*Abs(x)/192"
    " - 117*y*Abs(x)/256 - 5*z*Abs(x)/64 + 5*Abs(z)*Abs(y)/8 + 51*Abs(y)*Abs(x)/64"
)


@pytest.mark.usefixtures("without_far_starts")
def test_no_algebraic_rate_along_faces_of_higher_degree() -> None:
    """The functions mu that show that V falls along a face have fewer terms than those of ``V' + kappa V**2``.

    Of a V that was searched once.
    """
    rhs = ["-x + 3/2*y - sign(z)", "-3*sign(y) + 3*x", "-2*z - Abs(x) + 2*sign(y)"]
    decided = decide_system(built(rhs, lyapunov=FOUND))
    assert decided.function is decided.given is not None
    assert decided.reach.rate is None or decided.reach.rate.decay is not DecayKind.ALGEBRAIC


# ---- Gains in certificates: what an additive disturbance adds to the derivative of V, along disturbed polygons.


def gain_of(record: Record) -> Any:
    (gain,) = (claim["gain"] for claim in record["statement"]["claims"] if "gain" in claim)
    return gain


@pytest.mark.usefixtures("without_far_starts")
@pytest.mark.parametrize(("rhs", "function"), keep(2, SYSTEMS[3:] + SYSTEMS[:3]))
def test_the_gain_that_is_printed_is_stated_and_no_smaller_one(rhs: tuple[str, str], function: str) -> None:
    result = checked(rhs, function)
    assert result.reach.gain is not None
    record = certificate_of(result)
    gain = gain_of(record)
    assert (gain["gamma"], gain["kappa"]) == (str(result.reach.gain.gamma), str(result.reach.gain.rate.kappa))
    assert any(f"+ {gain['gamma']} |d|" in line for line in describe(record["statement"]))
    smaller = json.loads(json.dumps(record))
    hypotheses = next(entry["hypotheses"] for entry in smaller["evidence"] if "gain" in entry["hypotheses"])
    hypotheses["gain"] = gain_of(smaller)["gamma"] = str(result.reach.gain.gamma * Fraction(3, 4))
    assert "gradient" in refused(smaller)


@pytest.mark.parametrize(("rhs", "function"), [SYSTEMS[4], SYSTEMS[7]])
def test_no_disturbance_adds_more(rhs: tuple[str, str], function: str) -> None:
    """``V' <= -kappa + gamma |d|`` along ``f + d`` beside ``x = 0``, and along the mixture that stays on it.

    With a third of gamma it would be false.
    """
    gain = gain_of(certificate_of(checked(rhs, function)))
    kappa, gamma = float(Fraction(gain["kappa"])), float(Fraction(gain["gamma"]))
    assert gain["kind"] == "finite"
    rng = np.random.default_rng(5)
    d = rng.normal(size=(2, 4000)) * rng.uniform(0, 8, 4000)
    y = rng.uniform(0.01, 0.5, 4000) * rng.choice([-1, 1], 4000)
    right, left = (np.array([value(text, x=side * 1e-9, y=y) + np.zeros(4000) for text in rhs]) + d for side in (1, -1))
    share = right[0] / (right[0] - left[0])
    stays = (share > 0) & (share < 1)
    sliding = right + share * (left - right)
    risen = [
        _derivative(function, np.full(4000, 1e-6), y, right),
        _derivative(function, np.full(4000, -1e-6), y, left),
        np.where(stays, _derivative(function, np.zeros(4000), y, sliding), -np.inf),
    ]
    sizes = np.hypot(*d)
    assert stays.sum() > 400
    assert max((rise + kappa - gamma * sizes).max() for rise in risen) < 1e-4
    assert max((rise + kappa - gamma / 3 * sizes).max() for rise in risen) > 0.1


def _derivative(function: str, x: Any, y: Any, velocity: Any, h: float = 1e-9) -> Any:
    """Of V in floats, in the direction of a velocity."""
    return (value(function, x=x + h * velocity[0], y=y + h * velocity[1]) - value(function, x=x, y=y)) / h


def test_surfaces_that_meet_off_the_point_have_no_gain() -> None:
    """At (1/8, 0) V bends on two surfaces: a disturbance may hold solutions there, and nothing is said of them."""
    system = read_system({"states": ["x", "y"], "rhs": [["-sgn(x)", "-sgn(y)"]], "at": ["0", "0"]})
    for function, more in (("Abs(x) + Abs(y)", []), ("Abs(x) + Abs(y) + Max(x - 1/8, 0)", ["x - 1/8"])):
        hypotheses = {
            "cells": {"within": "1/2", "surfaces": ["x", "y", *more], "empty": ["-.+"] if more else []},
            "function": function,
            **{"second": None, "verdict": "asymptotically stable", "everywhere": False, "level": None, "below": False},
            "rate": {"kind": "finite", "kappa": "1/2"},
        }
        _, claims = Search().entry(system, "lyapunov", hypotheses)
        assert "rate" in claims[-1]
        if more:
            with pytest.raises(NotShownError, match="meet at the point alone"):
                Search().entry(system, "lyapunov", {**hypotheses, "gain": "3"})
        else:
            assert "gain" in Search().entry(system, "lyapunov", {**hypotheses, "gain": "3"})[1][-1]


def test_a_disturbance_has_a_letter_that_no_state_has() -> None:
    result = decide_system(built(("-2*d + w", "-w - sign(w)"), states=("d", "w")))
    assert result.reach.gain is not None
    words = gain_words(result.reach.gain, ["d", "w"])
    assert words.startswith("with x' in F + u: V' <= -4 V + 23/16 abs(u) on abs(d), abs")
    assert "where abs(u) <= delta" in words
    lines = describe(certificate_of(result)["statement"])
    assert any("with x' in F + u: V' <= -4 V + 23/16 |u| on abs(d)" in line for line in lines)
