"""``derive --brief``: two pages that say nothing but what the whole report says."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path

import pytest

from nonsmooth.proofs.answers import destinations
from nonsmooth.reports.checks.subject import ArraySubject, Invocation
from nonsmooth.reports.derivations.brief import brief_document
from nonsmooth.reports.derivations.derivation import ReportResult, render_report
from nonsmooth.reports.output.document import Bullets, Document, Paragraph, Section, Table, plain_text
from nonsmooth.reports.sections.answers import answers_section
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.reports.conftest import Invoke

PAGES = 2


@pytest.fixture(scope="module")
def four_wheel() -> ArraySubject:
    return ArraySubject(load_scene("four-wheel"), Invocation("four-wheel"), ("answers",))


def words(document: Document, title: str) -> str:
    """All paragraphs and items of a section."""
    (section,) = [section for section in document.sections if section.title == title]
    said = []
    for block in section.blocks:
        if isinstance(block, Paragraph):
            said.append(plain_text(block.text))
        elif isinstance(block, Bullets):
            said += [plain_text(item) for item in block.items]
    return "\n".join(said)


def table_of(section: Section) -> Table:
    return next(block for block in section.blocks if isinstance(block, Table))


def test_the_answers_are_those_of_the_whole_report(four_wheel: ArraySubject) -> None:
    short = brief_document(four_wheel)
    assert table_of(short.sections[0]).rows == table_of(answers_section(four_wheel)).rows
    assert len(short.figures) == 1
    titles = ["Answers", "Where and when bodies end", "What binds", "Law", "Not decided"]
    assert [section.title for section in short.sections] == titles


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_it_says_what_binds_and_names_the_law_and_what_is_open(four_wheel: ArraySubject) -> None:
    document = brief_document(four_wheel)
    assert "tolerances: none are stated" in words(document, "What binds").lower()
    assert "nonsmooth check four-wheel --law law.st" in words(document, "Law")
    assert "nonsmooth derive four-wheel -o report.html" in words(document, "Not decided")
    undecided = ArraySubject(load_scene("saddle", rule="ellipse"), Invocation("saddle"), ("answers",))
    assert "position: " in words(brief_document(undecided), "Not decided")


@pytest.mark.usefixtures("without_other_rules")
def test_it_says_where_and_when_bodies_end(four_wheel: ArraySubject, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(destinations, "FEW_STARTS", 3)
    ends = "Where and when bodies end"
    assert "at the point, after at most 0.5 s, from anywhere within 0.5 of it (proved)" in words(
        brief_document(four_wheel), ends
    )
    beside = ArraySubject(load_scene("off-center", rule="ellipse"), Invocation("off-center"), ("answers",))
    document, position = brief_document(beside), beside.answers.answers[0].numbers
    assert f"after at most {float(position['after']):.4g}" in words(document, ends)
    (section,) = [section for section in document.sections if section.title == ends]
    assert "the body ..." in str(table_of(section).header)


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="pdflatex is not installed (`make tools` tries)")
def test_it_has_two_pages(four_wheel: ArraySubject, tmp_path: Path) -> None:
    report = ReportResult(brief_document(four_wheel), four_wheel)
    (tmp_path / "r.tex").write_text(render_report(report, ".tex"), encoding="utf-8")
    line = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "r.tex"]
    done = subprocess.run(line, cwd=tmp_path, capture_output=True, timeout=120, check=False)
    found = re.search(r"\((\d+) pages?", done.stdout.decode("latin-1"))
    assert found is not None
    assert int(found[1]) <= PAGES


def test_the_command_says_the_answers_in_a_line(invoke: Invoke) -> None:
    done = invoke("derive", "four-wheel", "--brief", "-o", "brief.md")
    assert "brief.md: position comes home, heading drifts, pose can be held" in " ".join(done.out.split())
    assert Path("brief.md").read_text(encoding="utf-8").startswith("# In brief: four-wheel")


def test_what_does_nothing_with_it_is_refused(invoke: Invoke) -> None:
    plain = invoke("derive", "relay-oscillator-damped", "--brief")
    assert (plain.status, "--brief: required an array of wheels" in plain.err) == (2, True)
    chosen = invoke("derive", "four-wheel", "--brief", "--only", "verdict")
    assert (chosen.status, "--only: required a report of all sections" in chosen.err) == (2, True)
