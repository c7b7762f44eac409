"""Regions of V that are reshaped: near the exact ones, accepted by the checker, and by paths every start comes home."""

from __future__ import annotations

import copy
from dataclasses import replace
from fractions import Fraction
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import pytest

from nonsmooth.proofs.checker.statements import refusal as refused
from nonsmooth.proofs.many_states.reshaped_region import EFFORTS, SearchEffort, TooMuchWorkError, _Iteration
from nonsmooth.proofs.system_certificates import certificate_of, certificate_text, find_region_of_another_function
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from tests.oracles.floats import Floats, sizes_after, value
from tests.plain import built
from tests.thorough import keep

NAMES = ("x", "y", "z", "u", "v", "w")
STARTS, STEP, STEPS = 400, 0.01, 3_000


class Found(NamedTuple):
    """What a check shows.

    Attributes:
        certificate: as it is written.
        values: V over its level, at places of shape (places, states).
        within: half the side of the cube.
    """

    certificate: dict[str, Any]
    values: Any
    within: float


def refusal(certificate: dict[str, Any]) -> str:
    """Why the checker rejects it."""
    return refused(certificate, len(certificate_text(certificate)))


def found(names: tuple[str, ...], rhs: tuple[str, ...]) -> Found:
    """A region as of ``--region fast``, without the tetrahedra beside it (reports/test_region_many_states.py)."""
    result = decide_system(built(rhs, states=names))
    reshaped = find_region_of_another_function(result, "fast", lambda *_: None)
    assert reshaped is not None
    formula, level = reshaped.formula.text, float(reshaped.region.level)

    def values(places: Floats) -> Floats:
        return np.asarray(value(formula, **dict(zip(names, places.T, strict=True))) / level)

    evidence = replace(result, reach=replace(result.reach, reshaped=reshaped))
    return Found(certificate_of(evidence), values, float(reshaped.region.radius))


def form(count: int) -> Floats:
    """A positive definite form with axes that differ by ten and more."""
    root = np.random.default_rng(1).integers(-2, 3, (count, count))
    return np.asarray(root @ root.T + np.eye(count, dtype=int), dtype=float)


@cache
def family(count: int) -> Found:
    """``x' = -x + (x' B x) x``, which attracts where ``x' B x < 1`` and nowhere else."""
    matrix, names = form(count), NAMES[:count]
    terms = []
    for i, a in enumerate(names):
        terms += [f"{int(matrix[i, j])}*{a}*{b}" for j, b in enumerate(names) if matrix[i, j]]
    square = " + ".join(terms)
    return found(names, tuple(f"-{name} + ({square})*{name}" for name in names))


def quadratic(region: Found, count: int) -> Floats:
    """P with ``V = x' P x``."""
    unit = np.eye(count)
    matrix = np.zeros((count, count))
    for i in range(count):
        for j in range(count):
            plus, minus = region.values(np.array([unit[i] + unit[j], unit[i] - unit[j]]))
            matrix[i, j] = (plus - minus) / 4
    return matrix


@pytest.mark.parametrize("count", keep(1, [3, 4, 6]))
def test_nine_tenths_of_the_exact_level(count: int) -> None:
    """The region holds ``x' B x < 9/10``, and nothing outside of ``x' B x < 1``."""
    region = family(count)
    ratios = np.linalg.eigvals(np.linalg.solve(form(count), quadratic(region, count))).real
    assert ratios.min() >= 1
    assert ratios.max() <= 1 / 0.9
    assert not refusal(region.certificate)


SYSTEMS: dict[str, tuple[tuple[str, ...], Any]] = {
    "relaxation": (
        ("-y", "-z", "-0.5*x + (1 - 0.5*x**2)*y - z"),
        lambda x, y, z: (-y, -z, -0.5 * x + (1 - 0.5 * x**2) * y - z),
    ),
    "between products": (
        ("-x + y*z**2", "-y + x*y", "-z"),
        lambda x, y, z: (-x + y * z**2, -y + x * y, -z),
    ),
    "switched": (
        ("-x - x*Max(z, 0)", "-y + x**2*y", "-z - sign(z)*z**2/4 + x*z**2"),
        lambda x, y, z: (
            -x - x * np.maximum(z, 0), -y + x**2 * y, -z - np.sign(z) * z**2 / 4 + x * z**2,
        ),
    ),
}  # fmt: skip


@cache
def known(name: str) -> Found:
    """A system in three states."""
    return found(NAMES[:3], SYSTEMS[name][0])


@pytest.mark.parametrize("name", keep(1, reversed(SYSTEMS)))
def test_every_start_comes_home(name: str) -> None:
    """From all over the region, most starts near its border."""
    region = known(name)
    assert not refusal(region.certificate)
    places = np.random.default_rng(2).uniform(-region.within, region.within, (60 * STARTS, 3))
    starts = places[region.values(places) < 1]
    outer = np.argsort(-region.values(starts))[:STARTS]
    assert len(outer) == STARTS
    assert (
        sizes_after(SYSTEMS[name][1], starts[outer], STEP, STEPS).max()
        < 1e-2 * np.linalg.norm(starts[outer], axis=1).max()
    )


@pytest.mark.parametrize("name", keep(1, reversed(SYSTEMS)))
@pytest.mark.parametrize("key", ["level", "function", "within", "proofs"])
def test_forged_regions_are_refused(name: str, key: str) -> None:
    """A higher level, a smaller V, a smaller cube, and evidence that is left out or changed."""
    forged = copy.deepcopy(known(name).certificate)
    entry = forged["evidence"][-1]
    hypotheses = entry["hypotheses"]
    claims = [claim["attracts"] for claim in forged["statement"]["claims"] if "attracts" in claim]
    claim = [c for c in claims if "function" in c][-1]
    assert claim["function"] == hypotheses["function"]
    if key == "level":
        hypotheses["level"] = claim["below"] = str(Fraction(hypotheses["level"]) * 2)
    elif key == "function":
        hypotheses["function"] = claim["function"] = f"({hypotheses['function']})/2"
    elif key == "within":
        hypotheses["cells"]["within"] = claim["within"] = "1/64"
    else:
        del entry["proofs"][next(iter(entry["proofs"]))]
    assert refusal(forged)


def coupled(count: int) -> _Iteration:
    """The iteration for states that turn about each other, with quadratic and cubic terms."""
    x = [f"x{k}" for k in range(count)]
    pairs = [(x[k], x[k - 1], x[k - 2]) for k in range(count)]
    rhs = [f"-{a} + {b}/2 - {c}/2 + {a}*{b} - {a}**3 + {a}**2*{c}" for a, b, c in pairs]
    system = built(rhs, states=x)
    return _Iteration(system, parse_piecewise(" + ".join(f"{name}**2" for name in x), x), None)


@pytest.mark.parametrize(("count", "further"), [(3, 25), (4, 25), (6, 0)])
def test_rounds_of_degree_4_are_bounded(count: int, further: int) -> None:
    """In six coupled states one program takes more than a minute."""
    search = coupled(count)
    assert EFFORTS["best"].affordable([search.work_of(2), search.work_of(4)]) == [25, further]


def test_eight_states_take_more_work_than_is_allowed_unasked() -> None:
    works = [coupled(count).work_of(2) for count in (6, 8)]
    assert EFFORTS["fast"].affordable(works[:1]) > [0]
    with pytest.raises(TooMuchWorkError):
        EFFORTS["fast"].affordable(works[1:])


def test_what_is_not_allowed() -> None:
    effort = SearchEffort((2, 4), 25, work=100, further=10)
    assert effort.affordable([10, 2]) == [9, 4]
    with pytest.raises(TooMuchWorkError):
        effort.affordable([51, 1])
