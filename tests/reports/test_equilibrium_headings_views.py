"""Headings of rest on the terminal, in JSON, in Python and in the report."""

from __future__ import annotations

from io import StringIO

import pytest
from rich.console import Console

from nonsmooth.reports.checks.answers import answers_view
from nonsmooth.reports.checks.check import check_scene
from nonsmooth.reports.checks.check_results import CheckResult
from nonsmooth.reports.formats.markdown import render_markdown
from nonsmooth.reports.output.document import Document, Section
from nonsmooth.reports.sections.answers import _headings
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.thorough import thorough

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
    return check_scene(load_scene(file), ask_others=False)


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
    assert check_scene(load_scene("four-wheel"), ask_others=False).equilibrium_headings is None
