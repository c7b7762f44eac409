"""What a check shows beside its verdicts: feedback, headings of rest, the continuum, other rules."""

from __future__ import annotations

import json
import math
from fractions import Fraction
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console

from nonsmooth.reports.checks.agreement import compare_scene
from nonsmooth.reports.checks.answers import answers_view
from nonsmooth.reports.checks.check import check_array
from nonsmooth.reports.checks.check_results import CheckResult
from nonsmooth.reports.derivations.derivation import REPORT_FORMATS, derive_report, render_report
from nonsmooth.reports.formats.markdown import render_markdown
from nonsmooth.reports.output.document import Document, Section
from nonsmooth.reports.sections.opening import _headings
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.numbers.number_text import lower_text
from tests.reports.conftest import Invoke
from tests.reports.derived import derived
from tests.thorough import few, keep, thorough

# ---- The feedback clause as a user meets it: on the terminal, in JSON, in reports, in simulations and certificates.

START = ("--from", "0.1,0.05,0.3")


# ---- what is certified is shown from below -------------------------------------------------------


@pytest.mark.parametrize("digits", [1, 3, 4])
def test_a_shown_bound_is_not_above_the_exact_one(digits: int) -> None:
    field = load_scene("four-wheel").field
    for value in (Fraction(18398, 100_000), Fraction(2, 3), Fraction(1), Fraction(999_999, 10**6), Fraction(3, 10**20)):
        for number in (value, field(value), field(value) * field.sqrt(2)):
            exact = float(number)
            shown = Fraction(lower_text(number, digits))
            assert not number < shown if isinstance(number, Fraction) else (number - shown).sign() >= 0
            assert exact * (1 - 2 * 10.0 ** (1 - digits)) <= float(shown) <= exact * (1 + 1e-15)


@few(1)
@pytest.mark.parametrize(("name", "rule"), [("rectangle", "ellipse"), ("grid-4x4", "box"), ("spiral-30", "box")])
def test_rates_and_reaches_on_the_terminal_are_true(invoke: Invoke, name: str, rule: str) -> None:
    record = invoke("check", name, "--rule", rule, "--json").record["feedback"]
    text = " ".join(invoke("check", name, "--rule", rule, "--evidence").out.replace("│", " ").split())
    rate = Fraction(text.split("V' <= -")[1].split(" k V")[0])
    assert rate <= Fraction(record["exact"]["rate"])
    assert Fraction(text.split("V' <= -")[1].split(" k V")[0]) > 0
    if rule == "box":
        assert float(text.split("|x|, |y| < ")[1].split(":")[0]) <= record["rate_reach"]


# ---- simulate ------------------------------------------------------------------------------------


def test_the_cascade_is_followed(invoke: Invoke) -> None:
    common = ("simulate", "conveyor-3", *START, "--until", "60", "--feedback", "--json")
    slow = invoke(*common, "--law", "cascade").record
    assert slow["feedback"] == "cascade"
    assert max(map(abs, slow["end"]["state"])) < 0.02
    stuck = invoke(*common, "--law", "gradient").record
    assert abs(stuck["end"]["state"][0]) > 0.1


# ---- Headings of rest on the terminal, in JSON, in Python and in the report ----------------------

SWIRL = """
name = "swirl"
friction = { mu_roll = 1, mu_side = 1 }
grid = { rows = 4, columns = 5 }
contact = { rule = "ellipse" }
body = { shape = "rectangle", width = 2.1, height = 1.7 }
[field]
kind = "expression"
x = "-x - 8/7*y + x*x*y/4"
y = "-x - y/2 - y*y*x/28 - 3/28*x*x*x"
"""


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> CheckResult:
    file = tmp_path_factory.mktemp("bodies") / "swirl.toml"
    file.write_text(SWIRL, encoding="utf-8")
    return check_array(load_scene(file), ask_others=False)


@thorough  # the small one: test_python_offers_the_list
def test_the_record_lists_single_headings_first(result: CheckResult) -> None:
    record = result.to_dict()["answers"]["equilibrium_headings"]
    assert record["searched_within"] is None
    assert record["left_out"] == 0
    first = record["found"][0]
    assert (first["kind"], first["verdict"], first["position"]) == ("isolated", "undecided", "undecided")
    assert (first["wheels"], first["edge"], first["status"]) == ([7, 8, 13, 14], [9, 12], "sampled")
    assert first["heading"] == pytest.approx(-0.112994464)
    assert first["reason"].startswith("the body turns to it from both sides")
    assert first["exact"] == {}  # what is sampled has no exact text
    kinds = [entry["kind"] for entry in record["found"]]
    assert kinds == ["isolated"] * 2 + ["turning"] * 10
    assert all(one["from"] == pytest.approx(one["to"]) and one["edge"] and one["reason"] for one in record["undecided"])


@pytest.mark.usefixtures("without_paths")
def test_the_terminal_says_what_is_proved_of_other_headings(result: CheckResult) -> None:
    console = Console(width=100, record=True, file=StringIO())
    console.print(answers_view(result.evidence, result.answers))
    words = " ".join(console.export_text().split())
    assert "equilibrium headings at the checked point" in words
    assert "the body is proved to rest, without turning, at no heading but those listed" in words
    headings = result.answers.headings
    assert headings is not None
    count = len(headings.undecided)
    assert count > 4
    assert f"not decided at the checked point: {count} single headings (--json lists them): " in words
    assert "; simulate --headings 36 samples which return" in words
    assert "(--headings does)" in words


def test_the_report_has_a_table_of_them(result: CheckResult) -> None:
    page = result_page(result)
    assert "Equilibrium headings at the checked point" in page
    assert "under the edge 9, 12" in page


def result_page(result: CheckResult) -> str:
    """The section of the report as Markdown."""
    section = Section("Answers", tuple(_headings(result.answers.headings)))
    return render_markdown(Document("swirl", (section,)))


def test_python_offers_the_list(result: CheckResult) -> None:
    found = result.equilibrium_headings
    assert found is not None
    assert [entry.edge for entry in found.found if not entry.proved] == [(9, 12), (9, 12)]
    assert check_array(load_scene("four-wheel"), ask_others=False).equilibrium_headings is None


# ---- ``check --continuum``: the continuous idealization beside the verdicts, and where there is none.


HEADING = 1e-12


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("units", ["", 'units = { length = "mm" }'])
def test_its_headings_are_said_in_the_unit_of_the_scene(
    units: str, invoke: Invoke, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("COLUMNS", "300")
    field = 'grid = { rows = 2, columns = 4 }\nfield = { kind = "elliptic", a = 1, b = 3, speed = 2 }\n'
    (tmp_path / "cilia.toml").write_text(f"{units}\nfriction = {{ mu_roll = 1, mu_side = 1 }}\n{field}")
    done = invoke("check", "cilia.toml", "--continuum").out
    assert ("theta = 90 deg unstable" in done, "theta = 1.5708 unstable" in done) == (bool(units), not units)
    drift = invoke("check", "cilia.toml", "--json").record["rotation"]["drift"]
    ends = [f"{math.degrees(end):.6g} deg/s" if units else f"{end:.6g}" for end in drift]
    assert f"drift at rest [{', '.join(ends)}]" in done


def test_verdicts_do_not_depend_on_it(invoke: Invoke) -> None:
    done = [invoke("check", "four-wheel", "--json", *option) for option in (("--continuum",), ())]
    with_it, without = (outcome.record for outcome in done)
    assert without["continuum"] is None
    for record in (with_it, without):
        del record["continuum"], record["seconds"]
    assert (done[0].status, with_it) == (done[1].status, without)


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_an_object_of_the_scene(tmp_path: Path, invoke: Invoke) -> None:
    file = tmp_path / "my.toml"
    wheels = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[grid]\nrows = 2\ncolumns = 2\n'
    law = '[field]\nkind = "elliptic"\na = 2\nb = 1\nspeed = "magnitude"\n'
    file.write_text(f'{wheels}{law}[body]\nshape = "polygon"\nvertices = [[0, 0], [30, 0], [0, 10]]\n')
    record = invoke("check", str(file), "--continuum", "--json").record
    (triangle,) = record["continuum"]["objects"]
    assert record["continuum"]["given"] is True
    assert triangle["exact"]["vertices"][0] == ["-10", "-10/3"]
    axis = math.atan2(-2 * 9 / 72, 27 / 36 - 3 / 36) / 2  # of the long principal axis; the weaker pull is along y
    stable = next(heading["theta"] for heading in triangle["headings"] if heading["stable"])
    assert stable == pytest.approx(math.pi / 2 - axis, abs=HEADING)


@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("extent", keep(1, ["short", "all"]))
def test_the_derivation_has_a_section(extent: str) -> None:
    """That it is in a report of all sections, tests/reports/test_derivation.py shows for another scene."""
    short = ("verdict", "continuum")
    report = derived("elliptic") if extent == "all" else derive_report(load_scene("elliptic"), parts=short)
    for suffix in REPORT_FORMATS:
        text = render_report(report, suffix)
        assert "The continuous idealization" in text
        assert "turns to certain headings" in text


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_no_section_without_a_field(tmp_path: Path) -> None:
    file = tmp_path / "my.toml"
    file.write_text(
        '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[grid]\nrows = 2\ncolumns = 2\n[field]\nkind = "squeeze"\n'
    )
    titles = [
        section.title for section in derive_report(load_scene(file), parts=("continuum", "left-out")).document.sections
    ]
    assert "The continuous idealization" not in titles
    assert "What was left out, and why" in titles


# ---- ``nonsmooth partition SCENE --compare``: table, JSON and picture ----------------------------


def test_record_holds_exact_shares() -> None:
    record = compare_scene(load_scene("ring-6")).facts()["agreement"]
    assert Fraction(record["nearest_box"]["exact"]["share"]) == Fraction(1, 2)
    assert record["nearest_box"]["share"] == 0.5
    assert len(record["nearest_box"]["shared_twists"]) == 12
    for other in ("ellipse_nearest", "ellipse_box"):
        assert 0 < record[other]["mean"] <= record[other]["largest"]
    json.dumps(record, allow_nan=False)


def test_pictures_are_reproducible_vectors() -> None:
    compared = compare_scene(load_scene("four-wheel"))
    first, second = (compared.content(".svg") for _ in range(2))
    assert first == second
    assert first.startswith(b"<?xml")
