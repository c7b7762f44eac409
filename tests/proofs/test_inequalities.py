"""Signs of polynomials on closed cells: against sampling, against Z3, and in the cases where they are equal to zero."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from fractions import Fraction
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
import pytest
import z3
from flint import fmpq
from hypothesis import assume, given
from hypothesis import strategies as st

from nonsmooth.analysis.cells.polygon import square
from nonsmooth.analysis.cells.region import Region, cone_region, polygon_region, quadrants
from nonsmooth.proofs.inequalities.forms import PLANE, Question, Sense
from nonsmooth.proofs.inequalities.prover import (
    Counterexample,
    Outcome,
    Proof,
    Undecided,
    ZeroBetween,
    counterexample,
    line_of,
    prove,
)
from nonsmooth.proofs.inequalities.subdivision import multiplier
from nonsmooth.symbolic.formulas.piecewise import parse_piecewise
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.polynomial import Polynomial, in_generators
from tests.thorough import examples, few

RANDOM = examples(120)
FLOAT_ERROR = 1e-9  # of a float evaluation, relative to the sum of the absolute terms
SENSES = list(Sense)

Pair: TypeAlias = tuple[int, int]
Rational: TypeAlias = int | Fraction


def polynomial(text: str, field: NumberField | None = None) -> Polynomial:
    here = field or NumberField()
    values = {name: Polynomial.variable(here, PLANE, name) for name in PLANE}
    return parse_piecewise(text, PLANE).polynomial(values, no_switch)


def no_switch(surface: Polynomial) -> int:
    raise AssertionError(surface)


def cone(field: NumberField, start: Pair, end: Pair) -> Region:
    a, b = ((field(x), field(y)) for x, y in (start, end))
    return cone_region(a, b)


def box(field: NumberField, radius: Rational, centre: Pair = (0, 0)) -> Region:
    return polygon_region(square((field(centre[0]), field(centre[1])), field(radius)))


def decide(sense: str, text: str, region: Callable[[NumberField], Region], **options: bool) -> Outcome:
    """The outcome; samples must agree with a proof, and a point must refute."""
    field = NumberField()
    outcome = prove(sense, polynomial(text, field=field), region(field), **options)
    assert agrees(outcome)
    return outcome


def agrees(outcome: Outcome) -> bool:
    """Whether no sample refutes a proof, and a witness is a point of the cell at which the claim fails."""
    question = outcome.question
    if isinstance(outcome, Counterexample):
        return question.fails_at(outcome.point) and not outcome.value - question.polynomial(outcome.point)
    return not isinstance(outcome, Proof) or counterexample(question) is None


def quadrant(field: NumberField) -> Region:
    return cone(field, (1, 0), (0, 1))


def wide(field: NumberField) -> Region:
    """Nearly the upper half-plane."""
    return cone(field, (1, 0), (-99, 1))


def unit_square(field: NumberField) -> Region:
    return box(field, 1)


# ---- what is decided, and how ------------------------------------------------------------------


@few(3)
@pytest.mark.parametrize(
    ("sense", "text", "region", "kind"),
    [
        # extreme rays decide linear forms
        (">=0", "x + 2*y", quadrant, Proof),
        (">0", "x + 2*y", quadrant, Counterexample),  # zero at the apex
        (">=0", "x - y", quadrant, Counterexample),
        ("<=0", "-sqrt(2)*x - y", quadrant, Proof),
        ("<0", "x + y - 3", unit_square, Proof),
        ("<0", "x + y - 2", unit_square, Counterexample),
        # perfect squares with their zeros inside the cell
        (">=0", "(x - y)**2", quadrant, Proof),
        (">=0", "(x - sqrt(2)*y)**2", quadrant, Proof),
        (">0", "(x - sqrt(2)*y)**2", quadrant, Counterexample),
        (">=0", "(x - sqrt(2)*y)**2*(x**2 - x*y + y**2)", wide, Proof),
        (">=0", "(3*x - 7*y + 1/5)**2", unit_square, Proof),
        (">=0", "(x**2 - 2*y**2)**2*(x + 2)", unit_square, Proof),
        (">=0", "(x**3 - 3*x*y**2 + y**3)**2", wide, Proof),
        ("<=0", "(x - y)**2*(x + y)", wide, Counterexample),
        # isolated zeros inside, on a side, at a corner
        (">=0", "(x - 1/3)**2 + (y - 1/5)**2", unit_square, Proof),
        (">0", "(x - 1/3)**2 + (y - 1/5)**2", unit_square, Counterexample),
        (">0", "(x - 1/3)**2 + (y - 1/5)**2 + 1/1000000", unit_square, Proof),
        (">=0", "y + 1 + (x - 1/3)**2", unit_square, Proof),
        (">0", "y + 1 + (x - 1/3)**2", unit_square, Counterexample),
        (">=0", "y + 1 + (x**2 - 1/2)**2", unit_square, Proof),
        (">=0", "16*x**2*y**2 + (x/2 + y)**2", unit_square, Proof),
        (">=0", "x**4 + (x - 3*y)**2", unit_square, Proof),
        # unbounded cells and polynomials of mixed degree
        (">=0", "x**3 - 3*x + 2 + y", quadrant, Proof),
        (">=0", "x**3 - 3*x + 199/100 + y", quadrant, Counterexample),
        ("<=0", "x**3/100 - x**2 - y**2", quadrant, Counterexample),  # far away
    ],
)  # fmt: skip
def test_decided(sense: str, text: str, region: Callable[[NumberField], Region], kind: type) -> None:
    assert type(decide(sense, text, region)) is kind


@pytest.mark.parametrize(
    ("text", "region"),
    [
        ("x**2 + y**2", unit_square),
        ("x**2 + y**2 - x**3/2", unit_square),
        ("x + y + x*y", quadrant),
        ("(x - y)**2 + x**4", unit_square),
    ],
)
def test_strictness_leaves_out_the_origin_on_demand(text: str, region: Callable[[NumberField], Region]) -> None:
    strict = decide(">0", text, region)
    assert isinstance(strict, Counterexample)
    assert not any(strict.point)
    assert isinstance(decide(">0", text, region, except_origin=True), Proof)


def test_leaving_out_the_origin_leaves_out_nothing_else() -> None:
    for text, region in [("x*y", quadrant), ("x", wide), ("(x - 2*y)**2", quadrant), ("x**2", unit_square)]:
        outcome = decide(">0", text, region, except_origin=True)
        assert isinstance(outcome, Counterexample)
        assert any(outcome.point)


def test_limits_of_an_unbounded_region_are_no_points_of_it() -> None:
    """x = 1/n is positive on x >= 1, y >= 0 whatever its direction tends to."""
    field = NumberField()
    zero, one = field.zero, field.one
    region = Region(((one, zero, one), (one, zero, zero), (zero, one, zero)))
    assert isinstance(prove(">0", polynomial("x", field=field), region), Proof)
    assert isinstance(prove(">0", polynomial("x - 1", field=field), region), Counterexample)


def test_a_zero_without_a_name_is_isolated() -> None:
    """x^3 - 3 x y^2 + y^3 vanishes on three lines whose slopes are no square roots."""
    outcome = decide(">0", "(x**3 - 3*x*y**2 + y**3)**2", wide, except_origin=True)
    assert isinstance(outcome, ZeroBetween)
    value = outcome.question.polynomial(outcome.point)
    assert abs(float(value)) < 1  # close to the zero
    assert not outcome.zero.sign_of(line_of(outcome.part))


def test_motzkin_is_undecided_or_proved_but_never_refuted() -> None:
    outcome = decide(">=0", "x**4*y**2 + x**2*y**4 - 3*x**2*y**2 + 1", wide)
    assert not isinstance(outcome, Counterexample)
    if isinstance(outcome, Undecided):
        assert "corners" in outcome.reason
    assert isinstance(decide(">=0", "x**4*y**2 + x**2*y**4 - 301/100*x**2*y**2 + 1", wide), Counterexample)


def test_a_curved_cell_is_where_its_guards_are_positive() -> None:
    field = NumberField()
    disc = replace(box(field, 2), guards=(polynomial("1 - x**2 - y**2", field=field),))
    assert isinstance(prove("<0", polynomial("x - 11/10", field=field), disc), Proof)
    witness = prove("<0", polynomial("x - 9/10", field=field), disc)
    assert isinstance(witness, Counterexample)
    assert float(witness.point[0]) ** 2 + float(witness.point[1]) ** 2 < 1
    empty = replace(disc, guards=(*disc.guards, polynomial("x - 3/2", field=field)))
    assert isinstance(prove(">=0", polynomial("-1", field=field), empty), Proof)


# ---- random forms ------------------------------------------------------------------------------

# Drawn from a list, which is much faster than st.fractions: between -3 and 3, small sizes first.
VALUES = {Fraction(top, bottom) for bottom in (1, 2, 3) for top in range(-3 * bottom, 3 * bottom + 1)}
COEFFICIENTS = st.sampled_from(sorted(VALUES, key=lambda value: (abs(value), value.denominator, value)))
RAYS = st.tuples(st.integers(-6, 6), st.integers(-6, 6)).filter(any)


@st.composite
def forms(
    draw: st.DrawFn,
    degrees: tuple[int, ...],
    roots: bool = True,
    field: NumberField | None = None,
) -> Polynomial:
    """Homogeneous for one degree, mixed for several."""
    field = field or NumberField()
    root = field.sqrt(2)
    terms: dict[tuple[int, ...], Number] = {}
    for exponents in np.ndindex(*[max(degrees) + 1] * len(PLANE)):
        if sum(exponents) in degrees:
            c = field(draw(COEFFICIENTS)) + (root * draw(st.integers(-1, 1)) if roots else 0)
            if c:
                terms[exponents] = c
    return Polynomial(field, PLANE, terms)


@st.composite
def cones(draw: st.DrawFn, field: NumberField) -> Region:
    start, end = draw(RAYS), draw(RAYS)
    assume(start[0] * end[1] - start[1] * end[0] > 0)
    return cone(field, start, end)


@st.composite
def polygons(draw: st.DrawFn, field: NumberField) -> Region:
    region: Region | None = box(field, draw(st.integers(1, 2)), (draw(st.integers(-2, 2)), draw(st.integers(-2, 2))))
    for _ in range(draw(st.integers(0, 2))):
        line = tuple(field(draw(st.integers(-2, 2))) for _ in range(3))
        cut = region.clipped((line[0], line[1], line[2])) if region is not None else None
        region = cut or region
    assert region is not None
    return region


def samples(region: Region, count: int = 80) -> Iterator[tuple[float, float]]:
    """Points of a region, many of them near its corners and sides."""
    rng = np.random.default_rng(7)
    generators = np.array([[float(v) for v in g] for g in region.generators])
    for _ in range(count):
        weights = rng.random(len(generators)) ** rng.choice([1, 4]) * rng.integers(0, 2, len(generators))
        x, y, w = weights @ generators
        if w > 0:
            yield x / w, y / w


def float_value(form: Polynomial, point: tuple[float, ...]) -> tuple[float, float]:
    """Value and the scale of its error."""
    terms = [float(c) * math.prod(v**e for v, e in zip(point, es, strict=True)) for es, c in form.terms.items()]
    return sum(terms), FLOAT_ERROR * sum(map(abs, terms))


def holds(sense: Sense, value: float, error: float) -> bool:
    """Whether a float value does not contradict the claim."""
    return value < error if sense.factor < 0 else value > -error


def check_outcome(outcome: Outcome, points: list[tuple[float, ...]]) -> None:
    """A proof must hold at the points, a witness must refute the claim in independent arithmetic."""
    question = outcome.question
    if isinstance(outcome, Undecided):
        return
    assert agrees(outcome)
    if isinstance(outcome, Proof):
        for point in points:
            value, error = float_value(question.polynomial, point)
            assert holds(question.sense, value, error + 1e-300)
    elif isinstance(outcome, Counterexample):
        refutes(question, outcome)


def refutes(question: Question, witness: Counterexample[Question]) -> None:
    x, y = witness.point
    assert question.region.contains((x, y))
    point = (float(x), float(y))
    value, error = float_value(question.polynomial, point)
    assert value == pytest.approx(float(witness.value), rel=1e-9, abs=error + 1e-12)
    sign = witness.value.sign() * question.sense.factor
    assert sign < 0 or (sign == 0 and question.sense.strict)


@RANDOM
@given(st.data(), st.sampled_from(SENSES), st.integers(1, 5), st.booleans())
def test_forms_on_plane_cones_are_always_decided(data: st.DataObject, sense: Sense, degree: int, apex: bool) -> None:
    form = data.draw(forms((degree,)))
    region = data.draw(cones(form.field))
    outcome = prove(sense, form, region, except_origin=apex)
    assert not isinstance(outcome, Undecided)
    check_outcome(outcome, list(samples(region)))


@RANDOM
@given(st.data(), st.sampled_from(SENSES), st.booleans())
def test_squares_on_plane_cones_are_always_decided(data: st.DataObject, sense: Sense, apex: bool) -> None:
    form = data.draw(forms((2,)))
    region = data.draw(cones(form.field))
    outcome = prove(sense, form * form, region, except_origin=apex)
    assert not isinstance(outcome, Undecided)
    assert isinstance(outcome, Proof) or sense is not Sense.NONNEGATIVE
    check_outcome(outcome, list(samples(region)))


@RANDOM
@given(st.data(), st.sampled_from(SENSES), st.booleans(), st.booleans())
def test_polynomials_on_polygons_and_cones(data: st.DataObject, sense: Sense, apex: bool, bounded: bool) -> None:
    form = data.draw(forms((0, 1, 2, 3)))
    region = data.draw(polygons(form.field) if bounded else cones(form.field))
    check_outcome(prove(sense, form, region, except_origin=apex), list(samples(region)))


@examples(60)
@given(st.data(), st.sampled_from(SENSES))
def test_quadratics_on_polygons_are_always_decided(data: st.DataObject, sense: Sense) -> None:
    form = data.draw(forms((0, 1)))
    region = data.draw(polygons(form.field))
    for quadratic in (form * form, data.draw(forms((0, 1, 2), field=form.field))):
        outcome = prove(sense, quadratic, region)
        assert not isinstance(outcome, Undecided)
        check_outcome(outcome, list(samples(region)))


# ---- Z3 ----------------------------------------------------------------------------------------


@examples(50)
@given(st.data(), st.sampled_from(SENSES), st.booleans(), st.booleans())
def test_agrees_with_z3(data: st.DataObject, sense: Sense, apex: bool, bounded: bool) -> None:
    form = data.draw(forms((2, 3) if bounded else (3,), roots=False))
    region = data.draw(polygons(form.field) if bounded else cones(form.field))
    outcome = prove(sense, form, region, except_origin=apex)
    x, y = z3.Reals("x y")

    def rational(number: Any) -> Any:
        return z3.Q(int(number.as_rational().p), int(number.as_rational().q))

    value = sum((rational(c) * x ** e[0] * y ** e[1] for e, c in form.terms.items()), z3.RealVal(0))
    solver = z3.Solver()
    solver.set("timeout", 3_000)
    for a, b, c in region.sides:
        solver.add(rational(a) * x + rational(b) * y + rational(c) >= 0)
    if apex:
        solver.add(z3.Or(x != 0, y != 0) if sense.strict else z3.BoolVal(True))
    solver.add({"<0": value >= 0, "<=0": value > 0, ">0": value <= 0, ">=0": value < 0}[sense.value])
    answer = str(solver.check())
    if answer != "unknown" and not isinstance(outcome, Undecided):
        assert isinstance(outcome, Proof) == (answer == "unsat")


# ---- evidence ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "region"),
    [
        ("x + 2*y", quadrant),
        ("(x - y)**2 + y**2/10", quadrant),
        ("(x - sqrt(2)*y)**2", quadrant),
        ("(x - 1/3)**2 + (y - 1/5)**2", unit_square),
        ("(3*x - 7*y + 1/5)**2", unit_square),
        ("(x**2 - 2*y**2)**2*(x + 2)", unit_square),
        ("y + 1 + (x**2 - 1/2)**2", unit_square),
    ],
)
def test_the_opposite_and_less_are_not_proved(text: str, region: Callable[[NumberField], Region]) -> None:
    assert isinstance(decide(">=0", text, region), Proof)
    assert isinstance(decide(">=0", f"-({text})", region), Counterexample)
    assert isinstance(decide(">=0", f"{text} - 1", region), Counterexample)


@pytest.mark.parametrize(
    ("text", "region", "larger"),
    [
        ("x + 2*y", quadrant, wide),
        ("(x**2 - 2*y**2)**2*(x + 2)", unit_square, lambda field: box(field, 3)),
        ("y + 1 + (x**2 - 1/2)**2", unit_square, lambda field: box(field, 2)),
    ],
)
def test_a_larger_region_is_another_question(
    text: str, region: Callable[[NumberField], Region], larger: Callable[[NumberField], Region]
) -> None:
    assert isinstance(decide(">=0", text, region), Proof)
    assert isinstance(decide(">=0", text, larger), Counterexample)


def test_a_point_outside_the_cell_is_no_witness() -> None:
    witness = decide(">=0", "x - y", quadrant)
    assert isinstance(witness, Counterexample)
    field = witness.question.polynomial.field
    question = witness.question
    assert question.fails_at((field(1), field(2)))
    assert not question.fails_at((field(-2), field(-1)))
    assert not question.fails_at((field(2), field(1)))


# ---- regions -----------------------------------------------------------------------------------


def test_regions() -> None:
    field = NumberField()
    plane = quadrants(field.one)
    assert all(region.contains((field.zero, field.zero)) for region in plane)
    assert sum(region.contains((field(3), field(-2))) for region in plane) == 1
    strip = plane[0].clipped((field(-1), field(0), field(1)))  # x <= 1 in the first quadrant
    assert strip is not None
    assert strip.contains((field.one, field(10**6)))
    assert not strip.contains((field(2), field.one))
    assert plane[0].clipped((field(-1), field(-1), field(0))) is None
    for end in ((0, -1), (-1, 0), (2, 0)):
        with pytest.raises(ValueError, match="half turn"):
            cone(field, (1, 0), end)


@RANDOM
@given(st.data())
def test_clipping_keeps_exactly_one_side(data: st.DataObject) -> None:
    field = NumberField()
    region = data.draw(cones(field))
    a, b, c = (field(data.draw(st.integers(-3, 3))) for _ in range(3))
    assume(a or b)
    parts = [region.clipped((a, b, c)), region.clipped((-a, -b, -c))]
    assert any(parts)
    for x, y in samples(region, 20):
        point = (field(Fraction(x)), field(Fraction(y)))
        if not region.contains(point):
            continue  # rounded out of it
        side = (a * point[0] + b * point[1] + c).sign()
        expected = [side >= 0, side <= 0]
        for part, wanted in zip(parts, expected, strict=True):
            assert wanted == (part is not None and part.contains(point)) or (side == 0 and part is None)


def test_generators_of_a_polygon_run_counterclockwise() -> None:
    field = NumberField()
    for region in (box(field, 1), wide(field), quadrant(field)):
        points = [(float(x), float(y), float(w)) for x, y, w in region.generators]
        for g, h in pairwise([*points, points[0]]):
            middle = np.sum(points, axis=0)
            assert np.linalg.det(np.array([g, h, middle])) >= -FLOAT_ERROR


# ---- polynomials -------------------------------------------------------------------------------


@RANDOM
@given(forms((0, 1, 2, 3)), st.integers(-3, 3), st.integers(-3, 3))
def test_polynomials_against_their_values(form: Polynomial, a: int, b: int) -> None:
    field = form.field
    x, y = (Polynomial.variable(field, PLANE, name) for name in PLANE)
    point = (field(a), field(b))
    assert ((form + 1) * (form - x))(point) == (form(point) + 1) * (form(point) - a)
    assert form.homogenized()((*point, field.one)) == form(point)
    assert form.composed([y, x + 2])(point) == form((field(b), field(a + 2)))
    assert polynomial(str(form), field=field) == form  # the text is the polynomial
    generators = [point, (field(1), field(2))]
    homogeneous = Polynomial(field, PLANE, {e: c for e, c in form.terms.items() if sum(e) == 2})
    in_rays = in_generators(homogeneous.terms, generators)
    value = sum((c * 2 ** e[0] * 3 ** e[1] for e, c in in_rays.items()), field.zero)
    assert value == homogeneous((2 * point[0] + 3, 2 * point[1] + 6))


@RANDOM
@given(forms((0, 1, 2, 3)))
def test_derivatives_against_differences(form: Polynomial) -> None:
    field, h = form.field, Fraction(1, 10**12)
    point, ahead = (field(1), field(-2)), (field(1 + h), field(-2))
    difference = (form(ahead) - form(point)) / h
    assert abs(float(difference - form.derivative("x")(point))) < 1e-9


def test_terms_with_coefficient_zero_take_nothing_off() -> None:
    """Of ``x^2 - y^2 - c (x^2 + 0 y^2)`` a coefficient is negative for every c, of ``x^2 + y^2 - c x^2`` none is."""
    taken: dict[tuple[int, ...], Any] = {(2, 0): fmpq(1), (0, 2): fmpq(0)}
    assert multiplier({(2, 0): fmpq(1), (0, 2): fmpq(-1)}, taken) is None
    assert multiplier({(2, 0): fmpq(1), (0, 2): fmpq(1)}, taken) == fmpq(1, 2)


@RANDOM
@given(
    st.integers(1, 31), st.sampled_from((1, 3, 10)), st.sampled_from(("x**2 + 1", "3 - x**2 - y**2", "x + y**2 + 1"))
)
def test_a_zero_on_a_side_is_found_beside_guards_that_are_positive_there(k: int, steep: int, guard: str) -> None:
    """``(x - k/32)^2 + c y`` is zero at one point of the triangle, which cuts make a corner of the parts."""
    field = NumberField()
    region = Region(tuple((field(x), field(y), field(1)) for x, y in ((0, 0), (1, 0), (0, 1))))
    guarded = replace(region, guards=(polynomial(guard, field=field),))
    form = polynomial(f"(x - {k}/32)**2 + {steep}*y", field=field)
    outcome = prove(">0", form, guarded)
    assert not isinstance(outcome, Proof)
    assert agrees(outcome)
    assert isinstance(prove(">=0", form, guarded), Proof)
