"""Germs of guarded cells at the origin, against arcs on which the signs of the guards are plain arithmetic."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise
from math import prod

import numpy as np
import pytest

from nonsmooth.analysis.cells.region import quadrants
from nonsmooth.proofs.findings.verdicts import Equilibrium, Translation
from nonsmooth.proofs.inequalities.curved_regions import Adherence, Extent, adherence, extent, ray_adherence
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.findings import Method
from nonsmooth.proofs.systems.ray_moves import conic_germ, decide_equilibrium
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial
from nonsmooth.symbolic.systems.switched_system import PLANE
from tests.proofs.conftest import Load
from tests.thorough import keep

FIELD = NumberField()
X, Y = (Polynomial.variable(FIELD, PLANE, name) for name in PLANE)
RAYS = [(1, 0), (0, 1), (-1, 0), (0, -1)]
WHOLE, PART, NONE = Extent.WHOLE, Extent.PART, Extent.NONE


def guard(text: str) -> Polynomial:
    return parse_piecewise(text, PLANE).polynomial(dict(zip(PLANE, (X, Y), strict=True)), lambda _: 1)


def in_quadrants(*texts: str) -> list[Extent]:
    guards = tuple(guard(text) for text in texts)
    rays = [(FIELD(x), FIELD(y)) for x, y in RAYS]
    return [extent(guards, a, b) for a, b in pairwise([*rays, rays[0]])]


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["x**3 - x**2 - y**2"], [NONE] * 4),  # zero at the origin, negative around it
        (["x**2 + y**2 - x**3"], [WHOLE] * 4),
        (["y + x**2 + 1"], [WHOLE] * 4),  # passes the origin far away
        (["-y - x**2 - 1"], [NONE] * 4),
        (["y - x**2"], [PART, PART, NONE, NONE]),
        (["x**2 - y"], [PART, PART, WHOLE, WHOLE]),
        (["y - x**2", "2*x**2 - y"], [PART, PART, NONE, NONE]),  # squeezed between tangent curves
        (["y - 2*x**2", "x**2 - y"], [NONE] * 4),  # an empty cell on one side
        (["y - x**2", "x**2 + x**4 - y"], [PART, PART, NONE, NONE]),
        (["y - x**2", "2*x**2 - y", "3*x**2 - y"], [PART, PART, NONE, NONE]),  # three tangent guards
        (["y - x**2", "x**3 - y"], [NONE] * 4),
        (["x**3 - y**2"], [PART, NONE, NONE, PART]),  # a cusp
        (["y**2 - x**3"], [PART, WHOLE, WHOLE, PART]),
        (["(y - x**2)*(y - 2*x**2)", "(y - x**2)*(3*x**2 - y)"], [PART, PART, NONE, NONE]),  # a common factor
        (["x**4 - x**2*y**2 + y**4"], [WHOLE] * 4),
        (["-x**4 + x**2*y**2 - y**4"], [NONE] * 4),
        (["y**2 + x**4 - 2*x**2*y"], [WHOLE] * 4),  # (y - x**2)**2: zero on a curve without area
        (["y - x**2/3", "x**2/3 - y + x**9"], [PART, NONE, NONE, NONE]),  # contact of high order
        (["x**2*y**2 - x**7 - y**7"], [PART, PART, WHOLE, PART]),
    ],
)
def test_known_germs(texts: list[str], expected: list[Extent]) -> None:
    assert in_quadrants(*texts) == expected


def test_irrational_guards_are_decided_by_their_lowest_forms_or_not_at_all() -> None:
    assert in_quadrants("sqrt(2) + y") == [WHOLE] * 4
    assert in_quadrants("-sqrt(2)*x**2 - y**2 + x**3") == [NONE] * 4
    assert set(in_quadrants("y - sqrt(2)*x**2")) == {Extent.UNDECIDED}


EXPONENTS = ((1, 1), (3, 2), (2, 1), (5, 2), (3, 1), (4, 1))
CURVES = [(a, p, q) for a in (Fraction(1), Fraction(2), Fraction(1, 3)) for p, q in EXPONENTS]
# between all factors a^(1/q) that occur: 1/3, 0.577, 1, 1.41, 2
FACTORS = [Fraction(1, 20), Fraction(1, 2), Fraction(3, 4), Fraction(6, 5), Fraction(3, 2), Fraction(20)]
ARCS = [(c, Fraction(r, 4)) for r in range(1, 20) for c in FACTORS]


@pytest.mark.parametrize("seed", range(60))
def test_random_germs_of_curves_that_are_powers(seed: int) -> None:
    """Guards are products of ``y^q - a x^p`` in the first quadrant; arcs ``y = c x^r`` pass between all of them."""
    rng = np.random.default_rng(seed)
    guards: list[Polynomial] = []
    factors: list[list[tuple[Fraction, int, int]]] = []
    signs = [int(rng.choice([-1, 1])) for _ in range(rng.integers(1, 4))]
    for side in signs:
        chosen = [CURVES[k] for k in rng.choice(len(CURVES), size=rng.integers(1, 4), replace=False)]
        factors.append(chosen)
        guards.append(prod((Y**q - X**p * a for a, p, q in chosen), start=Polynomial.constant(FIELD, PLANE, side)))
    x = Fraction(1, 2**400)  # a fourth power, so that the arcs have rational points
    root = Fraction(1, 2**100)
    filled = []
    for c, r in ARCS:
        y = c * root ** int(4 * r)
        values = [side * prod(y**q - a * x**p for a, p, q in own) for side, own in zip(signs, factors, strict=True)]
        filled.append(all(value > 0 for value in values))
    expected = WHOLE if all(filled) else PART if any(filled) else NONE
    one, zero = FIELD.one, FIELD.zero
    assert extent(guards, (one, zero), (zero, one)) is expected
    region = quadrants(one)[0]
    guarded = type(region)(region.generators, tuple(guards))
    assert (adherence(guarded) is Adherence.YES) is any(filled)


@pytest.mark.parametrize(
    ("texts", "ray", "expected"),
    [
        (["y + x**2 + 1"], (1, 0), Adherence.YES),
        (["-y - x**2 - 1"], (1, 0), Adherence.NO),
        (["y - x**2"], (1, 0), Adherence.NO),
        (["x**2 - y"], (1, 0), Adherence.YES),
        (["y - x**2"], (0, 1), Adherence.YES),
        (["y - x**2"], (1, -1), Adherence.NO),
        (["y*(x - 1)"], (1, 0), Adherence.UNDECIDED),  # a guard that vanishes along the ray is never met as a factor
    ],
)
def test_rays_beside_a_cell(texts: list[str], ray: tuple[int, int], expected: Adherence) -> None:
    region = quadrants(FIELD.one)[0]
    guarded = type(region)(region.generators, tuple(guard(text) for text in texts))
    assert ray_adherence(guarded, (FIELD(ray[0]), FIELD(ray[1]))) is expected


# ---- verdicts that hang on it ----------------------------------------------------------------------


def test_a_surface_that_passes_the_equilibrium_adds_no_rest(load: Load) -> None:
    """Near the origin it is ``x' = y, y' = -x - y``, whose eigenvalues have real part -1/2."""
    scene = load("y", "((-x-y)+x)/2 + sign(y+x**2+1)*((-x-y)-x)/2")
    result = decide_system(scene)
    assert result.check()
    assert result.verdict is Translation.ASYMPTOTICALLY_STABLE
    assert PlanePoint(scene).rays == ()
    assert not result.reach.everywhere  # beyond the parabola the field is another


@pytest.mark.parametrize(
    ("guard_text", "first"),
    [
        ("x**3 - x**2 - y**2", 1),
        ("-(x**3 - x**2 - y**2)", -1),
        ("x**4 - x**2*y**2 + y**4", -1),
        ("x**4 + y**4 - x**5", -1),
        ("(x**2 + y**2)*(x - 1)", 1),
        ("(x - y)**2*(y + 1)", -1),
        ("x**2 + y**2 + 2*x*y - x**4*(y - 1)", -1),
    ],
)
def test_a_cell_whose_guard_vanishes_at_an_isolated_point_is_not_there(load: Load, guard_text: str, first: int) -> None:
    """Near the origin the field is (+-1, -y): there 0 is not in F."""
    scene = load(f"-sign({guard_text})", "-y")
    result = decide_system(scene)
    assert result.check()
    assert result.equilibrium is Equilibrium.FAILS
    assert (result.verdict, result.method) == (Translation.UNSTABLE, Method.EQUILIBRIUM)
    near = conic_germ(plane_cells(scene))
    assert near is not None
    assert {cell.velocities[0][0].constant_value for cell in near} == {scene.field(first)}


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        ("-sign(y - x**2)", "-1/2", Equilibrium.FAILS),
        ("-sign(y - x**2)", "0", Equilibrium.HOLDS),
        # only between the parabolas the velocity is (-1, 0), and only it makes 0 a mixture
        ("sign(y - x**2)*sign(y - 2*x**2)", "0", Equilibrium.HOLDS),
        ("sign(y - x**2)*sign(y - x**2 - 1)", "0", Equilibrium.HOLDS),
        ("sign(y - x**2)*sign(y - x**2)", "0", Equilibrium.FAILS),
        ("-sign(y**2 - x**3)", "y", Equilibrium.HOLDS),  # the cusp is narrow, but there
        ("-sign(y**2 - x**3) - 1/2*sign(y - 1) + 1", "y", Equilibrium.FAILS),
        ("1 - sign(y**2 + x**2 - x**5)", "1", Equilibrium.FAILS),
    ],
)
def test_equilibria_beside_curves(load: Load, first: str, second: str, expected: Equilibrium) -> None:
    scene = load(first, second)
    assert decide_equilibrium(plane_cells(scene)) is expected


@pytest.mark.parametrize("is_checked", keep(1, [False, True]))
def test_a_guard_of_a_potential_that_vanishes_at_the_point_refutes_nothing(load: Load, is_checked: bool) -> None:
    """V = x^2 + y^2 near the origin: the bracket is zero except where the quartic is negative, that is nowhere."""
    text = "x**2 + y**2 + (1 - sign(x**4 - x**2*y**2 + y**4))"
    scene = load("-x", "-y", lyapunov=f'"{text}"')
    result = decide_system(scene)
    assert result.verdict is not Translation.UNSTABLE
    assert result.given is not None
    assert result.given.witness is None
    assert not is_checked or result.check()  # which looks for a proof with this V for long
