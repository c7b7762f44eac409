"""Reports as files: HTML without a browser, literal text, nothing from elsewhere; LaTeX that compiles and fits."""

from __future__ import annotations

import base64
import hashlib
import re
import shutil
import subprocess
from collections.abc import Iterator
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest
from hypothesis import given
from hypothesis import strategies as st

import nonsmooth as ns
from nonsmooth.reports.checks.subject import Invocation
from nonsmooth.reports.derivations.derivation import derive_report, render_report
from nonsmooth.reports.derivations.parts import chosen_parts
from nonsmooth.reports.formats.html import NAMESPACE, display_mathml, inline_mathml, render_html
from nonsmooth.reports.output.document import (
    Document,
    Figure,
    Frame,
    Math,
    Paragraph,
    Section,
    cell_mark,
    display,
    table,
)
from nonsmooth.reports.output.files import OutputError
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene
from tests.reports.derived import PART_NAMES, derived, derived_afresh, page
from tests.thorough import examples, few, keep, thorough

# ---- The HTML report without a browser: one file, nothing from elsewhere, links that lead somewhere, literal text.

HOSTILE = "<script>alert(1)</script> & \"q\" 'a' </p><img src=x onerror=y> {{ 7 * 7 }} {% raw %}"
MOST_BYTES = 2_000_000
VOID = {"meta", "input", "link", "br", "img", "hr"}
RANDOM = examples(60)


class Reader(HTMLParser):
    """Every element with its attributes; tags must nest."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.elements: list[tuple[str, dict[str, str]]] = []
        self.words: list[str] = []
        self.open: list[str] = []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.elements.append((tag, {name: value or "" for name, value in attrs}))

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        self.words.append(data)

    def values(self, name: str) -> Iterator[str]:
        return (attributes[name] for _, attributes in self.elements if name in attributes)


@pytest.fixture(scope="module", params=keep(1, ["four-wheel", "off-center", "ring-5"]))
def text(request: pytest.FixtureRequest) -> str:
    return page(request.param)


@few(1)
def test_the_page_stands_alone(text: str) -> None:
    page = Reader(text)
    assert len(text.encode()) <= MOST_BYTES
    assert {tag for tag, _ in page.elements}.isdisjoint({"img", "link", "iframe", "object", "embed", "base", "form"})
    assert list(page.values("src")) == []
    assert all(value.startswith("#") for value in page.values("href"))
    style = text.partition("<style>")[2].partition("</style>")[0]
    assert "url(" not in style
    assert "@import" not in style
    assert re.findall(r"https?://[^\s\"'<]+", text) == []


def test_links_lead_to_elements_and_ids_occur_once(text: str) -> None:
    page = Reader(text)
    ids = list(page.values("id"))
    assert len(ids) == len(set(ids))
    assert {value[1:] for value in page.values("href")} <= set(ids)
    values = [value for _, attributes in page.elements for value in attributes.values()]
    assert {name for value in values for name in re.findall(r"url\(#(.*?)\)", value)} <= set(ids)
    assert set(page.values("for")) <= set(ids)


def test_every_cell_links_to_its_equations_and_back(text: str) -> None:
    page = Reader(text)
    drawn = [attributes for tag, attributes in page.elements if tag == "g" and "data-about" in attributes]
    marks = {a["data-about"] for a in drawn if a["id"].startswith("cell-map-")}
    assert len(marks) >= 4
    for kind in ("section", "tr"):
        about = {mark for tag, a in page.elements if tag == kind for mark in a.get("data-about", "").split()}
        assert marks <= about
    assert {f"#cell-map-{mark}" for mark in marks} <= set(page.values("href"))


@few(1)
def test_only_the_pages_own_script_may_run(text: str) -> None:
    policy = next(a["content"] for tag, a in Reader(text).elements if a.get("http-equiv") == "Content-Security-Policy")
    (script,) = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in policy
    assert policy.startswith("default-src 'none'")
    assert not any(name.startswith("on") for _, attributes in Reader(text).elements for name in attributes)


def test_formulas_are_mathml(text: str) -> None:
    formulas = re.findall(r"<math.*?</math>", text, re.DOTALL)
    assert len(formulas) > 100
    assert all(ET.fromstring(formula) is not None for formula in set(formulas))
    outside = re.sub(r"<(style|script|svg|math).*?</\1>", "", text, flags=re.DOTALL)
    assert re.findall(r"\\[a-z]+", outside) == []


def one_page(text: str) -> str:
    figure = Figure("f", (text,), text, text, picture, (Frame("start-1", text),))
    blocks = (Paragraph((text,)), table((text,), [(text,)], (1,), [(cell_mark(1),)]), figure)
    return render_html(Document(text, (Section(text, blocks, marks=(cell_mark(1),)),)))


def picture(suffix: str = ".svg") -> bytes:
    shapes = '<g id="cell-1"><path d="M0 0"/></g><g id="start-1--path"/><g id="axes_1"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="9pt" height="9pt" viewBox="0 0 9 9">{shapes}</svg>'.encode()


def test_hostile_text_is_text() -> None:
    page = Reader(one_page(HOSTILE))
    assert {tag for tag, _ in page.elements}.isdisjoint({"img"})
    assert [tag for tag, _ in page.elements].count("script") == 1
    assert sum(HOSTILE in words for words in page.words) >= 6
    scene = replace(load_scene("ring-3"), name=HOSTILE)
    report = derive_report(scene, Invocation(HOSTILE), ("verdict", "array", "cells", "versions"))
    Reader(render_report(report, ".html"))


@RANDOM
@given(st.text(st.characters(exclude_categories=["Cs"]), max_size=40))
def test_any_text_keeps_the_page_well_formed(text: str) -> None:
    Reader(one_page(text))


def test_marked_pieces_become_links_and_frames() -> None:
    page = Reader(one_page("t"))
    pieces = {a["id"]: a for tag, a in page.elements if tag == "g" and "id" in a}
    assert set(pieces) == {"f-cell-1", "f-start-1--path"}
    assert pieces["f-start-1--path"]["data-frame"] == "0"
    assert "#f-cell-1" in set(page.values("href"))
    assert "#t" in set(page.values("href"))


@thorough
def test_equal_input_gives_equal_pages() -> None:
    assert page("ring-5") == render_report(derived_afresh("ring-5"), ".html")


# ---- formulas ------------------------------------------------------------------------------------


def test_formulas_are_cut_where_a_line_may_break() -> None:
    assert len(inline_mathml(r"(1,\allowbreak\ 2,\allowbreak\ 3)")) == 3
    assert len(inline_mathml(r"\left[1,\allowbreak\ 2\right]")) == 1
    assert len(display_mathml(r"a = b, \qquad c = d")) == 2
    assert len(display_mathml("\\begin{aligned}\na &= b \\\\\nc &= d\n\\end{aligned} \\qquad e")) == 2


def test_bars_and_named_operators_are_set_as_such() -> None:
    (bars,) = inline_mathml(r"\lvert x \rvert")
    assert bars.count('fence="true"') == 2
    (named,) = inline_mathml(r"\operatorname{sgn} x")
    assert "<mtext>sgn</mtext><mspace" in named
    (called,) = inline_mathml(r"\operatorname{sgn}(x)")
    assert "<mtext>sgn</mtext><mo" in called


def test_states_whose_names_are_words_are_set_as_such() -> None:
    """The report of a system with a state `x1` ended with a traceback."""
    (dotted,) = inline_mathml(r"\dot{\mathit{speed\_of\_mass}}")
    assert "<mtext>speed_of_mass</mtext>" in dotted
    report = ns.System(["x1", "speed_of_mass"], ["-x1 - sign(x1)", "-speed_of_mass"]).derive(only="cells")
    assert "<mtext>x1</mtext>" in report.text(".html")


@pytest.mark.parametrize("latex", [r"\nosuchcommand x", "a & b", r"\href{javascript:x}{y}"])
def test_latex_that_is_not_understood_is_refused(latex: str) -> None:
    with pytest.raises(ValueError, match="becomes MathML"):
        inline_mathml(latex)


@pytest.mark.parametrize(
    "latex", [r"\frac{1}{2}", r"\dot V^*", r"\sum_i N_i", r"\begin{pmatrix} 1 & 2 \\ 3 & 4 \end{pmatrix}"]
)
def test_formulas_become_mathml(latex: str) -> None:
    (markup,) = display_mathml(latex)
    assert 'display="block"' in markup
    assert NAMESPACE not in markup
    blocks = (display(latex, "x"), Paragraph((Math(latex, "x"), ".")))
    Reader(render_html(Document("t", (Section("s", blocks),))))


# ---- which sections ------------------------------------------------------------------------------


def test_sections_can_be_chosen() -> None:
    assert chosen_parts((), ()) == PART_NAMES
    assert chosen_parts(("versions", "verdict"), ()) == ("verdict", "versions")
    assert chosen_parts(("versions", "verdict"), ("verdict",)) == ("versions",)
    with pytest.raises(ValueError, match="without: required fewer"):
        chosen_parts(("verdict",), ("verdict",))
    with pytest.raises(ValueError, match="received 'verdicts'"):
        chosen_parts(("verdicts",), ())


@thorough  # the small one: test_sections_can_be_chosen
def test_sections_that_were_not_asked_for_are_not_computed(monkeypatch: pytest.MonkeyPatch) -> None:
    def forbidden(*arguments: object) -> None:
        raise AssertionError(arguments)

    monkeypatch.setattr("nonsmooth.reports.sections.trajectories.simulate", forbidden)
    monkeypatch.setattr("nonsmooth.reports.checks.subject.compare_rules", forbidden)
    parts = chosen_parts((), ("trajectories", "rules"))
    report = derive_report(load_scene("ring-3"), Invocation("ring-3"), parts)
    titles = [section.title for section in report.document.sections]
    assert "Trajectories" not in titles
    left_out = render_report(report, ".md").partition("## What was left out")[2]
    assert "Section trajectories: not asked for." in left_out


# ---- The LaTeX report compiles with plain pdflatex, for every built-in scene and for hostile text, and fits its
# page.

WIDEST = 5.0  # points by which a box may stick out: below a character, unseen on paper
HOSTILE_TO_LATEX = "a_b*c|d $x$ 50% #1 {e} \\f ^g ~h <i> `j` & [k](l) -- \u4e2d"

needs_latex = pytest.mark.skipif(
    shutil.which("pdflatex") is None,
    reason="pdflatex is not installed (Debian: texlive-latex-base, texlive-latex-extra; `make tools` tries)",
)


def compiled(folder: Path, source: str) -> str:
    """What pdflatex says while it compiles a report."""
    (folder / "r.tex").write_text(source, encoding="utf-8")
    line = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "r.tex"]
    done = subprocess.run(line, cwd=folder, capture_output=True, timeout=120, check=False)
    said = done.stdout.decode("latin-1")
    assert done.returncode == 0, said[-2000:]
    assert (folder / "r.pdf").stat().st_size > 10_000
    return said


def overfull(said: str) -> list[float]:
    """By how many points boxes stick out."""
    return [float(points) for points in re.findall(r"Overfull \\[hv]box \(([\d.]+)pt", said)]


KINDS = ("four-wheel", "elliptic", "carton-on-6x6", "ring-3")  # small, spiral, with an outline, odd


@needs_latex
@few(1)
@pytest.mark.parametrize("name", keep(2, dict.fromkeys((*KINDS, *builtin_scenes()))))
def test_every_built_in_scene_compiles_and_fits(tmp_path: Path, name: str) -> None:
    said = compiled(tmp_path, render_report(derived(name), ".tex"))
    assert max(overfull(said), default=0.0) <= WIDEST


@needs_latex
@few(1)
@pytest.mark.parametrize("rule", ["box", "ellipse"])
def test_the_other_rules_compile_and_fit(tmp_path: Path, rule: str) -> None:
    assert max(overfull(compiled(tmp_path, render_report(derived("four-wheel", rule), ".tex"))), default=0.0) <= WIDEST


@needs_latex
@pytest.mark.parametrize("extent", keep(1, ["short", "all"]))
def test_figures_lie_in_a_folder_beside_the_source(tmp_path: Path, extent: str) -> None:
    parts = ("array", "cells") if extent == "short" else PART_NAMES
    report = derive_report(load_scene("four-wheel"), parts=parts)
    report.save(tmp_path / "report.tex")
    files = {file.name for file in (tmp_path / "report-figures").iterdir()}
    assert files == {f"{figure.key}.pdf" for figure in report.document.figures}
    assert len(files) >= 2
    said = compiled(tmp_path, (tmp_path / "report.tex").read_text(encoding="utf-8"))
    unbroken = said.replace("\n", "")  # pdflatex breaks its lines at 79 characters
    assert all(f"report-figures/{name}" in unbroken for name in files)


def test_nothing_is_written_where_the_folder_of_the_figures_cannot_be(tmp_path: Path) -> None:
    (tmp_path / "report-figures").touch()
    line = "report-figures: required a folder that can be made, received file exists"
    with pytest.raises(OutputError, match=line):
        derive_report(load_scene("four-wheel"), parts=("array",)).save(tmp_path / "report.tex")
    assert [file.name for file in tmp_path.iterdir()] == ["report-figures"]


# The sections that write the scene's name, or a command that names it, without the long trajectories and precision.
NAMING = ("answers", "array", "cells", "derivative", "rules", "stress", "versions")


@needs_latex
@pytest.mark.parametrize(
    ("name", "parts"), keep(1, [("four-wheel-side", NAMING), ("four-wheel-side", PART_NAMES), ("ring-3", PART_NAMES)])
)
def test_hostile_names_compile(tmp_path: Path, name: str, parts: tuple[str, ...]) -> None:
    scene = replace(load_scene(name), name=HOSTILE_TO_LATEX)
    source = render_report(derive_report(scene, Invocation(HOSTILE_TO_LATEX), parts), ".tex")
    assert source.count("U+4E2D") > 2
    compiled(tmp_path, source)
