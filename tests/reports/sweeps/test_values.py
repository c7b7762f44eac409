"""What a user writes after ``--vary``: exact values, grids, draws, and what is refused."""

from __future__ import annotations

from fractions import Fraction
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from nonsmooth.reports.sweeps.borders import simplest_fraction
from nonsmooth.reports.sweeps.sweep_plan import SweepPlan, read_plan
from nonsmooth.reports.sweeps.values import Range, SweepError, read_values
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.key_paths import find_path, numeric_paths, path_text, with_value
from nonsmooth.symbolic.messages.scene_error import SceneError


def entries(text: str) -> list[int | str]:
    values = read_values(text, "vary")
    return [values.value(k).entry for k in range(values.count or 0)]


def plan_of(vary: dict[str, str], draws: int | None = None, seed: int = 0) -> SweepPlan:
    document, file, _ = read_document("four-wheel")
    return read_plan(vary, document, file, draws, seed)


def test_ranges_are_exact_and_end_at_both_ends() -> None:
    assert entries("0.05:1:3") == ["1/20", "21/40", 1]
    assert entries("-1:1:3") == [-1, 0, 1]
    assert entries("0:pi/2:3") == [0, "1/4*pi", "1/2*pi"]
    assert entries("0 deg:45 deg:3") == ["0 deg", "45/2 deg", "45 deg"]
    assert entries("10+pi:20+pi:2") == ["10 + 1*pi", "20 + 1*pi"]


def test_lists_hold_formulas_as_they_were_written() -> None:
    assert entries("1/3, sqrt(2)/2, 0.25") == ["1/3", "sqrt(2)/2", "1/4"]


@given(st.fractions(max_denominator=999), st.fractions(max_denominator=999), st.integers(2, 50))
def test_ranges_ascend_in_equal_steps(a: Fraction, b: Fraction, count: int) -> None:
    if a == b:
        return
    values = read_values(f"{min(a, b)}:{max(a, b)}:{count}", "vary")
    assert isinstance(values, Range)
    numbers = [values.value(k).constant for k in range(count)]
    assert (numbers[0], numbers[-1]) == (min(a, b), max(a, b))
    assert {y - x for x, y in pairwise(numbers)} == {(numbers[-1] - numbers[0]) / (count - 1)}


@pytest.mark.parametrize(
    "text",
    [
        "1:1:3",
        "2:1:3",
        "0:1:0",
        "0:1:1",
        "0:1:-2",
        "0:1:2.5",
        "0:1:1e3",
        f"0:1:{'9' * 5000}",
        "0:1:2:3",
        ":1:3",
        "nan:1:3",
        "0:inf:3",
        "0:sqrt(2):3",
        "0:90 deg:3",
        "",
        "a",
        "1,,2",
        "__import__('os')",
        "1/0:2:3",
    ],
)
def test_what_is_no_value_is_refused_in_one_line(text: str) -> None:
    with pytest.raises(SweepError, match=r"^vary x: required .*, received ") as refusal:
        read_values(text, "vary x")
    assert "\n" not in str(refusal.value)
    assert len(str(refusal.value)) < 250


def test_a_grid_holds_every_combination_with_the_last_number_fastest() -> None:
    plan = plan_of({"mu_side": "1:2:2", "mu_roll": "3,4,5"})
    assert plan.size == 6
    assert [tuple(value.entry for value in plan.point(k)) for k in range(6)] == [
        (1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5)
    ]  # fmt: skip
    assert [plan.index(plan.places(k)) for k in range(6)] == list(range(6))


def test_draws_are_exact_within_their_range_and_reproducible() -> None:
    vary = {"mu_side": "1/3:2/3", "mu_roll": "1,2"}
    short, long = (plan_of(vary, n, seed=7) for n in (20, 50))
    drawn = [short.point(k) for k in range(20)]
    assert drawn == [long.point(k) for k in range(20)]
    assert len({point[0].entry for point in drawn}) == 20
    assert all(1 / 3 <= (point[0].number or 0) <= 2 / 3 for point in drawn)
    assert {point[1].entry for point in drawn} == {1, 2}
    assert drawn != [plan_of(vary, 20, seed=8).point(k) for k in range(20)]


def test_a_plan_of_any_size_costs_nothing() -> None:
    plan = plan_of({"mu_side": "1:2:1000000", "mu_roll": "1:2:1000000", "check.radius": "1:2:1000000"})
    assert plan.size == 10**18
    assert plan.places(plan.size - 1) == (999_999,) * 3


@pytest.mark.parametrize("name", ["four-wheel", "ring-6", "grid-4x4", "spiral-30", "carton-on-6x6", "omni-3"])
def test_every_path_names_its_own_number(name: str) -> None:
    document, file, _ = read_document(name)
    paths = list(numeric_paths(document))
    assert len({path_text(path, document) for path in paths}) == len(paths)
    for path in paths:
        assert find_path(path_text(path, document), document, file) == path
        changed = with_value(document, path, 17)
        inner: object = changed
        for step in path:
            inner = inner[step]  # type: ignore[index]
        assert inner == 17


def test_paths_inside_lists_have_names_or_are_counted_as_messages_count() -> None:
    document = {
        "wheel": [{"position": [0, 1]}, {"position": [2, 3]}],
        "contact": {"loads": {"kind": "measured", "values": [1, 2]}},
        "body": {"shape": "polygon", "vertices": [[0, 0], [1, 0], [0, 1]]},
    }
    assert find_path("wheel.2.position.x", document, "f") == ("wheel", 1, "position", 0)
    assert find_path("wheel.2.heading", document, "f") == ("wheel", 1, "heading")
    assert find_path("body.vertices.3.y", document, "f") == ("body", "vertices", 2, 1)
    assert find_path("contact.loads.values.2", document, "f") == ("contact", "loads", "values", 1)
    rows = {"contact": {"loads": [[1, 0, 0], [1, "1/9", 0]]}}
    assert find_path("contact.loads.2.cx", rows, "f") == ("contact", "loads", 1, 1)
    system = {"states": ["x", "v"], "rhs": ["v", "-x - k*v"], "parameters": {"k": [1, 2]}}
    plain = {"system": system, "check": {"equilibrium": [0, 0]}}
    assert find_path("k.high", plain, "f") == ("system", "parameters", "k", 1)
    assert find_path("check.equilibrium.v", plain, "f") == ("check", "equilibrium", 1)


def test_a_coordinate_that_is_counted_is_refused_with_its_name() -> None:
    document = {"wheel": [{"position": [0, 1]}, {"position": [2, 3]}]}
    with pytest.raises(SceneError, match=r"wheel\.1\.position\.x"):
        find_path("wheel.1.position.1", document, "f")


@pytest.mark.parametrize(
    ("path", "near"),
    [
        ("mu_sid", "mu_side"),
        ("wheel.1.headin", "wheel.1.heading"),
        ("friction.mu_sides", "friction.mu_side"),
        ("wheel.9.heading", "wheel.4.heading"),
        ("name", ""),
        ("contact.rule", ""),
        ("x" * 10_000, ""),
    ],
)
def test_an_unknown_path_is_refused_with_near_ones(path: str, near: str) -> None:
    document, file, _ = read_document("four-wheel")
    with pytest.raises(SceneError, match=r"^four-wheel: required the key path of a number, such as ") as refusal:
        find_path(path, document, file)
    assert near in str(refusal.value)
    assert len(str(refusal.value)) < 250


def test_a_key_of_two_tables_must_say_which() -> None:
    document, file, _ = read_document("ring-6")
    with pytest.raises(SceneError, match=r"such as ring\.radius or check\.radius, received 'radius'"):
        find_path("radius", document, file)


@given(st.fractions(max_denominator=50), st.fractions(min_value=0, max_denominator=50))
def test_the_simplest_fraction_has_the_smallest_denominator(low: Fraction, width: Fraction) -> None:
    found = simplest_fraction(low, low + width)
    assert low <= found <= low + width
    for denominator in range(1, found.denominator):
        assert (
            -(-low * denominator // 1) > (low + width) * denominator
        )  # no whole multiple of 1/denominator lies between
