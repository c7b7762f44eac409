"""Empty and thin cells between curves, against cells that are empty or hold a point because of how they are made."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest

from nonsmooth.analysis.cells.switched_cells import square_regions
from nonsmooth.proofs.inequalities.curved_regions import is_empty
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.symbolic.files.system_file import load_system
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE
from tests.thorough import few

FIELD = NumberField()
X, Y = (Polynomial.variable(FIELD, PLANE, name) for name in PLANE)
SQUARE = square_regions(FIELD(1))  # quadrant by quadrant, from the first one on
RANDOM = 12  # cells of each kind


def guard(text: str) -> Polynomial:
    return parse_piecewise(text, PLANE).polynomial(dict(zip(PLANE, (X, Y), strict=True)), lambda _: 1)


def emptied(*texts: str) -> list[bool | None]:
    """For each quadrant of the square."""
    guards = tuple(map(guard, texts))
    return [is_empty(replace(quadrant, guards=guards)) for quadrant in SQUARE]


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["x**2*y - x**4 - y**2", "y"], [True] * 4),  # touches zero at the origin alone: x^4 - 4 x^4 < 0
        (["-(y - x**2)*(y - 2*x**2)"], [False, False, True, True]),  # between tangent parabolas
        (["y - x**2", "x**2 - y"], [True] * 4),
        (["y - x**2", "x**2*(1 + 1/10**9) - y"], [False, False, True, True]),
        (["y - 2*x**2", "x**2 - y"], [True] * 4),  # tangent parabolas the other way round
        (["x**3 - x**2 - y**2"], [True] * 4),  # an isolated point, and a curve far away
        (["-(y - x**2)**2"], [True] * 4),  # zero along a curve without area
        (["1/10**12 - (x - 1/3)**2 - (y + 1/4)**2"], [True, True, True, False]),  # a tiny oval
        (["1/10 - x**2 - y**2", "x**2 + 2*y**2 - 3/10"], [True] * 4),  # nested ovals: 2/10 at most
        (["1/10 - x**2 - y**2", "x**2 + 4*y**2 - 3/10"], [False] * 4),
        (["y**2 - x**3", "x**3 - 2*y**2"], [True] * 4),  # cusps
        (["2*y**2 - x**3", "x**3 - y**2"], [False, True, True, False]),
    ],
)
def test_known_cells(texts: list[str], expected: list[bool]) -> None:
    assert emptied(*texts) == expected


def random_polynomial(rng: np.random.Generator, degree: int) -> Polynomial:
    exponents = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    values = rng.integers(-5, 6, len(exponents))
    return Polynomial(FIELD, PLANE, {e: FIELD(int(v)) for e, v in zip(exponents, values, strict=True) if v})


def test_random_cells_that_are_empty() -> None:
    """``p > 0`` and ``-p (1 + q^2) > r^2`` exclude each other."""
    rng = np.random.default_rng(1)
    for _ in range(RANDOM):
        p, q, r = (random_polynomial(rng, degree) for degree in (3, 1, 2))
        guards = (p, -p * (q * q + 1) - r * r)
        assert all(is_empty(replace(quadrant, guards=guards)) for quadrant in SQUARE)


def test_random_cells_that_hold_a_small_disc() -> None:
    """Each guard, of degree four, is positive at a known point; a disc about it is the only place of the first one."""
    rng = np.random.default_rng(2)
    for _ in range(RANDOM):
        x, y = (Fraction(int(k), 97) for k in rng.integers(1, 96, 2))
        near = guard(f"1/10**{rng.integers(2, 10)} - (x - {x})**2 - (y - {y})**2")
        p = random_polynomial(rng, 4)
        here = p((FIELD(x), FIELD(y)))
        p = p if here.sign() > 0 else -p
        if here:
            assert [is_empty(replace(quadrant, guards=(near, p))) for quadrant in SQUARE] == [False, True, True, True]


def test_random_cells_in_which_no_sample_lies_if_they_are_empty() -> None:
    """Points at all scales from 1 down to 10^-6, evaluated in floats with a margin for rounding."""
    rng = np.random.default_rng(3)
    radius, angle = 10 ** rng.uniform(-6, 0, 20_000), rng.uniform(0, np.pi / 2, 20_000)
    x, y = radius * np.cos(angle), radius * np.sin(angle)
    seen = 0
    for _ in range(2 * RANDOM):
        a, b, c = (Fraction(int(k), 4) for k in rng.integers(-6, 7, 3))
        texts = f"(y - {a}*x**2)*(y - {b}*x**2 - {c}*x**3)", f"{c}*x*y**2 - x**4 - {abs(a)}*y**3 + x**2*y"
        inside = np.ones_like(x, dtype=bool)
        for text in texts:
            terms = [(float(v), i, j) for (i, j), v in guard(text).terms.items()]
            value = sum(v * x**i * y**j for v, i, j in terms)
            size = sum(abs(v) * x**i * y**j for v, i, j in terms)
            inside &= value > 1e-12 * size
        seen += bool(inside.any())
        assert not (inside.any() and emptied(*texts)[0])
    assert seen > RANDOM / 2


def test_irrational_and_huge_guards_are_left_open() -> None:
    assert emptied("y - sqrt(2)*x**2") == [None] * 4
    assert emptied("(x + y + 1/7)**15*y - x**16*2 - 1/3") == [None] * 4


SCENE = """[system]
states = ["x", "y"]
{regions}[[region]]
rhs = {rhs}
"""
EMPTY = '["x**2*y - x**4 - y**2 > 0", "y > 0"]', '"(y - x**2)**2*(1 + y**2) + x**2*y**4 < 0"'


@few(2)
@pytest.mark.parametrize("where", EMPTY, ids=["by products", "by squares"])
@pytest.mark.parametrize("rhs", ['["-x", "-y"]', '["-x + y", "-x - y**3"]', '["-sign(x) + y", "-2*sign(y) - x"]'])
def test_a_region_without_points_changes_nothing(tmp_path: Path, where: str, rhs: str) -> None:
    """By definition: fields on a set without area are ignored; these led straight out, and took over a minute."""
    verdicts = []
    for regions in ("", f'[[region]]\nwhere = {where}\nrhs = ["1", "x"]\n'):
        file = tmp_path / "scene.toml"
        file.write_text(SCENE.format(regions=regions, rhs=rhs))
        result = decide_system(load_system(str(file)))
        verdicts.append((result.verdict, result.equilibrium))
    assert verdicts[0] == verdicts[1]
