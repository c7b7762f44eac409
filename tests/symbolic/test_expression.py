"""User formulas: exact values against independent arithmetic, round trips, and what is refused."""

from __future__ import annotations

import time
import warnings
from decimal import Decimal
from fractions import Fraction
from typing import Any, TypeAlias

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mpmath import mp, mpf

from nonsmooth.symbolic.formulas.expression import parse, turn_of
from nonsmooth.symbolic.formulas.trees import MAX_LENGTH, ExpressionError, decimal_value, parse_tree
from nonsmooth.symbolic.numbers.number import Number
from nonsmooth.symbolic.numbers.number_field import NumberField, base_order
from tests.thorough import examples, few

RANDOM = settings(max_examples=200)
DIGITS = 40


def exact(text: object) -> Number:
    formula = parse(text)
    return formula.value(NumberField(base_order(formula.turns())))


# ---- values ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "value"),
    [
        (7, Fraction(7)),
        (Decimal("0.1"), Fraction(1, 10)),
        ("0.1", Fraction(1, 10)),
        (0.5, Fraction(1, 2)),
        ("1e-3", Fraction(1, 1000)),
        (".5", Fraction(1, 2)),
        ("1_000.5", Fraction(2001, 2)),
        ("-2**2", Fraction(-4)),
        ("2**-2", Fraction(1, 4)),
        ("2**+2", Fraction(4)),
        ("2 - 3*4/5", Fraction(-2, 5)),
        ("-(1 - +2)", Fraction(1)),
        ("sqrt(2)*sqrt(8)", Fraction(4)),
        ("cos(pi/3) + sin(-pi/6)", Fraction(0)),
        ("cos(0) + sin(pi) + cos(7*pi)", Fraction(0)),
        ("sin(pi/2 - pi*2/3 + 0.5*pi)*2", None),
        ("4*cos(pi/5) - 1 - sqrt(5)", Fraction(0)),
        ("1/(sqrt(2) - 1) - sqrt(2)", Fraction(1)),
        (" 3 ", Fraction(3)),
    ],
)
def test_values(text: object, value: Fraction | None) -> None:
    if value is None:
        assert exact(text) ** 2 == 3
    else:
        assert exact(text) == value


def test_a_tab_is_a_blank() -> None:
    """Messages write it with a backslash, which is no formula."""
    assert parse_tree("0.25*\tx", MAX_LENGTH, "a formula")[0] == "0.25* x"


def test_variables() -> None:
    field = NumberField()
    formula = parse("x**2 - y/2 + sqrt(x)", ("x", "y", "z"))
    assert formula.names == {"x", "y"}
    assert formula.value(field, {"x": field(4), "y": field(6)}) == 15


@pytest.mark.parametrize(
    ("text", "turn"),
    [
        ("pi/3", Fraction(1, 3)),
        ("-2*pi/5", Fraction(-2, 5)),
        ("0.25*pi + pi/2", Fraction(3, 4)),
        ("(1/2 - 1/3)*pi", Fraction(1, 6)),
        (0, Fraction(0)),
    ],
)
def test_angles(text: object, turn: Fraction) -> None:
    assert turn_of(parse(text).tree, str(text)) == turn


@pytest.mark.parametrize(
    ("text", "constant", "multiple"),
    [
        ("1/2 + 3*pi/7 - 2", "-3/2", "3/7"),
        ("pi/361", "0", "1/361"),
        ("-0.25", "-1/4", "0"),
        ("2*(1 + pi)/4", "1/2", "1/2"),
    ],
)
def test_rational_parts_in_pi(text: str, constant: str, multiple: str) -> None:
    assert parse(text).parts_in_pi() == (Fraction(constant), Fraction(multiple))


def test_turns_of_a_formula() -> None:
    assert sorted(parse("cos(pi/5)*x + sin(2*pi/7) + sqrt(2)", ("x",)).turns()) == [
        Fraction(1, 5),
        Fraction(2, 7),
    ]


Tree: TypeAlias = tuple[str, Any, Any]  # text, value by mpmath (None if undefined), magnitude of the terms


def leaf(value: Fraction) -> Tree:
    with mp.workdps(DIGITS):
        return f"({value})", mpf(value.numerator) / value.denominator, 1


def angle(turn: Fraction) -> Tree:
    with mp.workdps(DIGITS):
        return (
            f"cos({turn.numerator}*pi/{turn.denominator})",
            mp.cos(mp.pi * turn.numerator / turn.denominator),
            1,
        )


def root(inner: Tree) -> Tree:
    with mp.workdps(DIGITS):
        return f"sqrt(({inner[0]})**2 + 1)", mp.sqrt(inner[1] ** 2 + 1), inner[2] ** 2 + 1


def combined(operator: str, a: Tree, b: Tree) -> Tree:
    with mp.workdps(DIGITS):
        value = {"+": a[1] + b[1], "-": a[1] - b[1], "*": a[1] * b[1]}[operator]
    return f"({a[0]} {operator} {b[0]})", value, a[2] + b[2]


LEAVES = st.one_of(
    st.fractions(min_value=-5, max_value=5, max_denominator=6).map(leaf),
    st.sampled_from([Fraction(1, 5), Fraction(2, 5), Fraction(1, 4), Fraction(1, 3), Fraction(7, 10)]).map(angle),
    st.sampled_from([Fraction(1), Fraction(2), Fraction(1, 2)]).map(leaf).map(root),
)
TREES = st.recursive(LEAVES, lambda t: st.builds(combined, st.sampled_from("+-*"), t, t), max_leaves=5)


@examples(200)
@given(TREES)
def test_random_formulas_agree_with_mpmath_and_come_back_from_their_text(tree: Tree) -> None:
    text, value, _ = tree
    number = exact(text)
    assert float(number) == pytest.approx(float(value), rel=1e-14, abs=1e-30)
    assert isinstance(number.field, NumberField)
    again = parse(str(number))
    assert again.value(number.field) == number  # the same number of the same field
    assert float(exact(str(number))) == float(number)  # and of a new one


def test_text_of_nested_roots_comes_back() -> None:
    field = NumberField()
    number = field.sqrt(2 + field.sqrt(2)) / 3 - 5 * field.sqrt(6)
    assert parse(str(number)).value(field) == number


# ---- what is refused ---------------------------------------------------------------------------

REFUSED = [
    "", " ", "x", "e", "1 +", "1 2", "1j", "True", "None", "'a'", "f'{1}'", "()", "(1, 2)", "[1]", "{1}",
    "{1: 2}", "1 if 1 else 2", "lambda: 1", "1 // 2", "1 % 2", "1 @ 2", "1 << 2", "1 | 2", "~1", "not 1",
    "1 < 2", "1 and 2", "await x", "yield", "0b12",
    "a.b", "(1).real", "x[0]", "abs(1)", "exp(1)", "sqrt", "sqrt()", "sqrt(1, 2)", "sqrt(x=1)", "sqrt(*[1])",
    "__import__('os').system('true')", "(y := 1)", "1; 2", "1\n2", "\x00", "\ud800", "1if 2else 3", "1_",
    "2**0.5", "2**x", "2**(1 + 1)", "2**True", "2**~3", "2**(not 3)", "2**65", "2**-65", "2**2**2", "sin(1)",
    "cos(sqrt(2))", "cos(cos(0))", "cos(pi*pi)", "cos(pi/0)", "cos(1/pi)", "sin(x)", "sin(pi/361)",
    "cos(pi/7) + cos(pi/360)", "nan", "inf", "1e401", "1e-402", "(" * 300, "-" * MAX_LENGTH + "1",
    True, None, [], {}, (1,), b"1", float("nan"), float("-inf"), Decimal("NaN"), Decimal("Infinity"),
    Decimal("1e500"), 10**500, 1 << 20_000, [1 << 20_000],
]  # fmt: skip


@pytest.mark.parametrize("value", REFUSED, ids=range(len(REFUSED)))
def test_refused_text(value: object) -> None:
    with warnings.catch_warnings(record=True) as advice:
        warnings.simplefilter("always")
        with pytest.raises(ExpressionError, match=r"(?s)^required .+"):
            parse(value)
    assert advice == []  # Python's own remarks about such text do not reach the user


@pytest.mark.parametrize("text", ["0x10", "2*0B1", "sqrt(0o7)"])
def test_digits_to_other_bases_are_refused(text: str) -> None:
    with pytest.raises(ExpressionError, match="required decimal numbers"):
        parse(text)


def test_powers_are_written_as_in_python() -> None:
    with pytest.raises(ExpressionError, match=r"required \*\* for powers, as in x\*\*2, received 'sqrt\(2\)\^2'"):
        parse("sqrt(2)^2")


@pytest.mark.parametrize(
    "text", ["1/0", "0**-1", "1/(sqrt(8) - 2*sqrt(2))", "sqrt(-1)", "sqrt(1 - sqrt(2))", "pi", "2*pi"]
)
def test_refused_values(text: str) -> None:
    with pytest.raises(ExpressionError, match=r"^required .+, received .+"):
        exact(text)


@pytest.mark.parametrize("text", ["pi**2", "1 + pi", "sqrt(2)*pi", "pi/361", "1", "pi/0"])
def test_refused_angles(text: str) -> None:
    with pytest.raises(ExpressionError, match=r"^required a .*multiple of pi"):
        turn_of(parse(text).tree, text)


@few(2)
@pytest.mark.parametrize(
    "text",
    [
        "((9**64)**64)**64",
        "(((2*cos(pi/5))**64)**64)**64",
        "((1/3 + sqrt(2))**-64)**64",
        "1e400**64",
        "sqrt(" * 60 + "2" + ")" * 60,
        "1/(" + " + ".join(f"sqrt({p})" for p in (2, 3, 5, 7, 11, 13, 17)) + ")",
        "1/(sqrt(2) + sqrt(3) + sqrt(5) + sqrt(7) + sqrt(11) + cos(pi/59))",
    ],
)
def test_no_text_keeps_the_machine_busy(text: str) -> None:
    start = time.process_time()
    with pytest.raises(ExpressionError):
        exact(text)
    assert time.process_time() - start < 10  # seconds; measured: at most 1.2


def test_random_text_is_refused_or_a_number_that_its_own_text_gives_back() -> None:
    read = refused = 0
    tokens = st.sampled_from(["1", "2", "0.5", "+", "-", "*", "/", "(", ")", "sqrt(3)", "pi", "cos(pi/5)"])

    @RANDOM
    @given(st.text(max_size=30) | st.text(alphabet="0123456789+-*/() .", max_size=12) | st.lists(tokens).map("".join))
    def sample(text: str) -> None:
        nonlocal read, refused
        try:
            number = exact(text)
        except ExpressionError:
            refused += 1
            return
        read += 1
        assert isinstance(number.field, NumberField)
        assert parse(str(number)).value(number.field) == number

    sample()
    assert min(read, refused) > 10


# ---- decimals ----------------------------------------------------------------------------------


@examples(200)
@given(st.decimals(allow_nan=False, allow_infinity=False, min_value=-(10**20), max_value=10**20, places=9))
def test_decimals_are_exact(value: Decimal) -> None:
    assert decimal_value(str(value)) == Fraction(value)
    assert exact(value) == Fraction(value)


@pytest.mark.parametrize("text", ["nan", "inf", "1e401", "one", ""])
def test_refused_decimals(text: str) -> None:
    with pytest.raises(ExpressionError, match=r"^required a"):
        decimal_value(text)
