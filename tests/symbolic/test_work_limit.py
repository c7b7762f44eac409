"""The limit on exact arithmetic: it counts, it ends, it nests, and what it ends is refused in one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from flint import arb, ctx

from nonsmooth.analysis.cells import box, nearest
from nonsmooth.proofs import theorem4
from nonsmooth.reports.cli import app
from nonsmooth.reports.output.console import run
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers import enclosures
from nonsmooth.symbolic.numbers.enclosures import MOST_BITS, rational_below, square_root
from nonsmooth.symbolic.numbers.number_field import NumberField
from nonsmooth.symbolic.numbers.number_text import real_text
from nonsmooth.symbolic.numbers.work_limit import WorkLimitError, watched, work_limit

FEW = 100


def test_products_are_counted_and_the_limit_ends_them() -> None:
    field = NumberField()
    three = field(3)
    with pytest.raises(WorkLimitError), work_limit(field, FEW):
        three ** (1 << FEW)
    assert field.meter is None
    assert three * three == 9


def test_what_is_spent_inside_counts_outside() -> None:
    field = NumberField()

    def spend() -> None:
        with work_limit(field, FEW):
            field(3) * field(5)

    with work_limit(field, FEW):
        for _ in range(FEW):
            spend()
        with pytest.raises(WorkLimitError):
            spend()


def test_long_products_count_more() -> None:
    field = NumberField()
    long = field(3) ** 10_000
    with pytest.raises(WorkLimitError), work_limit(field, 10):
        long * long


@pytest.mark.parametrize(("rule", "module"), [("nearest", nearest), ("box", box)])
def test_cells_beyond_the_limit_are_refused_in_one_line(
    rule: str, module: object, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "PARTITION_UNITS", FEW)
    for command in (["check", "off-center", "--rule", rule], ["partition", "off-center", "--rule", rule]):
        assert run(app, command) == 2
        printed = capsys.readouterr()
        assert not printed.out
        assert printed.err.startswith("nonsmooth: off-center: wheels: required an array with cells of rule")
        assert printed.err.count("\n") == 1


def test_a_check_beyond_the_limit_is_refused(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(theorem4, "CHECK_UNITS", FEW)
    assert run(app, ["check", "ring-5", "--rule", "ellipse"]) == 2
    assert "all clauses within" in capsys.readouterr().err


def test_the_search_for_other_equilibria_is_left_out_where_it_is_too_much(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(theorem4, "SEARCH_UNITS", FEW)
    result = theorem4.check_theorem4(load_scene("rectangle"))
    assert result.other_equilibria is None
    assert "search for other equilibria" in {skipped.what for skipped in result.skipped}
    assert result.check()
    assert result.verdict is theorem4.check_theorem4(load_scene("rectangle")).verdict


def test_a_number_of_very_many_digits_is_written_as_an_enclosure() -> None:
    """Python refuses to write integers of more than 4,300 digits: such an area ended in a traceback."""
    field = NumberField()
    number = field(3) ** 20_000 / field(7) ** 10_000
    assert number.size_bits > MOST_BITS
    assert real_text(number).startswith("[")
    assert real_text(field(2) / 3) == "2/3"


def test_the_root_of_a_long_number_is_a_ball_around_it() -> None:
    field = NumberField()
    root = square_root((field(3) ** 20_000 + 1) / field(7) ** 10_000)
    assert not field.radicands
    assert not hasattr(root, "field")
    low = rational_below(root)
    assert low > 0
    assert field(low) ** 2 < (field(3) ** 20_000 + 1) / field(7) ** 10_000
    assert square_root(field(8)) == 2 * field.sqrt(2)


def test_the_root_in_a_field_of_very_many_roots_is_a_ball_around_it(monkeypatch: pytest.MonkeyPatch) -> None:
    field = NumberField()
    number = 3 + 2 * field.sqrt(2)
    assert square_root(number) == 1 + field.sqrt(2)
    monkeypatch.setattr(enclosures, "MOST_ROOTS", 0)
    found = square_root(number)
    assert isinstance(found, arb)
    with ctx.workprec(512):
        assert found.contains((1 + field.sqrt(2)).ball())


def test_the_command_line_says_once_which_angles_are_measured(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "my.toml"
    field = '[field]\nkind = "spiral"\nangle = "pi/180"\n'
    path.write_text(f"[friction]\nmu_roll = 1\nmu_side = 0.5\n[ring]\ncount = 4\n{field}", encoding="utf-8")
    run(app, ["check", str(path), "--rule", "all", "--radius", "0.25"])
    words = " ".join(capsys.readouterr().out.split())
    assert words.count("angles taken as measured: 1/180*pi") == 1


def test_a_limit_of_few_units_ends_also_where_somebody_looks_on() -> None:
    """The meter that looks up now and then compares once for both: a limit below its step must not slip through."""
    field, looks = NumberField(), list[None]()
    three = field(3)
    with watched(field, lambda: looks.append(None)), work_limit(field, 5):
        for _ in range(5):
            _ = three * three
        with pytest.raises(WorkLimitError):
            _ = three * three
    assert not looks
    with watched(field, lambda: looks.append(None)):
        for _ in range(1000):
            _ = three * three
    assert len(looks) == 4
