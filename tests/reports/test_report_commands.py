"""Reports beside their derivation: commands of figures, brief ones, plain systems, and formulas."""

from __future__ import annotations

import json
import re
import shlex
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.answers import destinations
from nonsmooth.proofs.system_facts import rewriting_words
from nonsmooth.proofs.systems.border_motion import BorderKind, sliding_velocity
from nonsmooth.proofs.theorem4 import check_theorem4
from nonsmooth.reports.checks.phase_portrait import PhasePortrait
from nonsmooth.reports.checks.subject import ArraySubject, Invocation
from nonsmooth.reports.checks.system_subject import SystemSubject
from nonsmooth.reports.cli import app
from nonsmooth.reports.derivations.derivation import ReportResult, derive_report, render_report
from nonsmooth.reports.derivations.parts import brief_document, names_of
from nonsmooth.reports.output.console import run
from nonsmooth.reports.output.document import Bullets, Document, Math, Paragraph, Section, Table, plain_text
from nonsmooth.reports.output.prose import with_formulas
from nonsmooth.reports.sections.opening import answers_section
from nonsmooth.symbolic.files.documents import builtin_scenes
from nonsmooth.symbolic.files.scene_file import load_scene, load_system
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.formulas.trees import formula_tree, tidied, written
from nonsmooth.symbolic.messages.scene_kind import SceneKind
from nonsmooth.symbolic.numbers.polynomial import float_values
from tests.oracles.floats import value
from tests.thorough import but, few, keep, thorough

# ---- Every figure of a report names the command that draws it: the command runs, wherever the checked point lies.

TABLE = """name = "table"
[friction]
mu_roll = 0.8
mu_side = 0.2
[field]
kind = "expression"
x = "0.3 - x"
y = "-0.1 - y"
[check]
equilibrium = [0.3, -0.1]
radius = 0.1
"""
FEW_WHEELS, MANY_WHEELS = (0.2, 0.4), (0.0, 0.2, 0.4, 0.6)  # x of the wheels, in two rows
DRAWN = re.compile(r"Drawn by `([^`]*)`")
SECTIONS = "array,cells,derivative,trajectories,rules"


def write_table(places: tuple[float, ...]) -> None:
    wheels = [f"[[wheel]]\nposition = [{x}, {y}]\n" for x in places for y in (0.0, -0.2)]
    Path("table.toml").write_text(TABLE + "".join(wheels), encoding="utf-8")


@pytest.mark.parametrize(
    ("rule", "places"),
    keep(1, [("ellipse", FEW_WHEELS), *((rule, MANY_WHEELS) for rule in ("ellipse", "nearest", "box"))]),
)
def test_commands_of_figures_run(
    rule: str,
    places: tuple[float, ...],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.chdir(tmp_path)
    write_table(places)
    assert run(app, ["derive", "table.toml", "--rule", rule, "--only", SECTIONS]) == 0
    commands = DRAWN.findall(capsys.readouterr().out)
    assert len(commands) == {"nearest": 7, "box": 6, "ellipse": 2}[rule]
    for command in commands:
        program, *arguments = shlex.split(command)
        assert program == "nonsmooth"
        assert run(app, arguments) == 0, capsys.readouterr().err
        assert Path(arguments[-1]).stat().st_size > 0


@thorough  # the small one: test_commands_of_figures_run
def test_the_path_that_a_command_draws_is_that_of_the_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write_table(MANY_WHEELS)
    assert run(app, ["derive", "table.toml", "--only", "trajectories"]) == 0
    command = next(line for line in DRAWN.findall(capsys.readouterr().out) if "open-loop" in line)
    words = shlex.split(command)
    start = [float(value) for value in words[words.index("--from") + 1].split(",")]
    assert start == pytest.approx([0.3 + 0.04, -0.1 + 0.08, 0.0])


# ---- ``derive --brief``: two pages that say nothing but what the whole report says ---------------

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


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_what_is_open_stands_there_with_its_reason(tmp_path: Path) -> None:
    """Also where the point is no equilibrium, and of a pose that is late where the answer is good otherwise."""
    array = 'friction = { mu_roll = 1, mu_side = "1/2" }\nring = { count = 4, phase = "pi/4" }\n'
    errors = 'feedback = { delay = "1/50", position_error = "1/1000" }\n'
    (tmp_path / "late.toml").write_text(array + errors, encoding="utf-8")
    late = brief_document(
        ArraySubject(load_scene(tmp_path / "late.toml", rule="ellipse"), Invocation("late.toml"), ("answers",))
    )
    assert "pose that is late and wrong as [feedback] says: the law is certified near" in words(late, "Not decided")
    assert "at the point, from anywhere within" in words(late, "Where and when bodies end")
    bed = brief_document(ArraySubject(load_scene("roller-bed"), Invocation("roller-bed"), ("answers",)))
    assert "why: below" not in words(bed, "Not decided")
    assert "pose: no law was found, and none is excluded: " in words(bed, "Not decided")


@pytest.mark.usefixtures("without_other_rules")
def test_it_says_where_and_when_bodies_end(four_wheel: ArraySubject, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(destinations, "FEW_STARTS", 2)
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


# ---- The derivation report of plain systems: in every format, by name of section, and its sliding velocities.

RELAYS = ns.System(["x_1", "omega"], ["-sign(x_1) + omega/4", "-sign(omega) - x_1/4"], radius="1/2")
SEVERAL = ns.System(["x", "y"], [["-x", "-y"], ["-x + y/4", "-y"]])


def test_every_section_is_written_or_named_as_left_out() -> None:
    report = RELAYS.derive()
    text = report.text(".md")
    left_out = text.split("## What was left out, and why")[1].split("##")[0]
    assert len(report.sections) == len(names_of(SceneKind.SYSTEM)) - 2  # nobody misses parts
    assert "Section leading-terms: " in left_out
    assert report.verdict == "asymptotically stable"
    with pytest.raises(AttributeError, match="plain system"):
        _ = report.theorem4


def test_words_and_greek_letters_are_names_of_states() -> None:
    text = RELAYS.derive(only="cells").text(".tex")
    assert r"\tfrac{1}{4} \omega" in text or r"\frac{1}{4} \omega" in text
    assert "x_{1}" in text


def test_under_arbitrary_switching_the_rest_is_written() -> None:
    report = SEVERAL.derive(without="versions,references")
    text = report.text(".md")
    assert "Section borders: the field may switch at any time" in text
    assert json.loads(report.text(".json"))["phase_portrait"] is None
    assert "Phase portrait" not in report.sections


# Systems in other numbers of states, with roots and sines of these, and by parts; where V is told in each report, and
# sections that it has beside those of all.
ANY_STATES = {
    "one": (ns.System(["x"], ["-sign(x) - x**3"]), set()),
    "three": (ns.System(["x", "y", "z"], ["-sign(x) + y/2", "-sign(y) + z/2", "-sign(z) - x/2"]), {"lyapunov"}),
    "roots": (ns.System(["x", "y"], ["-2*sqrt(Abs(x))*sign(x) + y", "-sign(x)"]), {"lyapunov", "leading"}),
    "sines": (ns.System(["x", "y", "z"], ["y - x", "-sin(y)", "-z - sign(z)*Abs(x)"]), {"lyapunov"}),
    "parts": (
        ns.System(["a", "e", "w"], ["-a - sign(a + e)", "-3/2*sqrt(Abs(e))*sign(e) + w", "-11/10*sign(e)"]),
        {"parts"},
    ),
    "curves": (ns.System(["x", "y", "z"], ["-x + y*sign(y - z**2)", "-y", "-z"]), {"lyapunov"}),
}


# Cells of a system with sines: test_rows_of_cells_are_the_stated_field.
@pytest.mark.parametrize("name", but(["sines"], ANY_STATES))
def test_reports_are_of_any_number_of_states(name: str) -> None:
    system, more = ANY_STATES[name]
    report = system.derive(without="versions,references")
    assert report.verdict == "asymptotically stable"
    headings = {"lyapunov": "A Lyapunov function", "parts": "Parts", "leading": "Leading terms"}
    always = ["The verdict", "The system", "Cells", "The checked point", "Solutions"]
    told = [headings[own] for own in headings if own in more]
    assert sorted(report.sections) == sorted([*always, *told, "What was left out, and why"])
    assert "solution.pdf" in report.text(".tex")


@pytest.mark.parametrize("name", [name for name in ANY_STATES if name not in {"roots", "parts"}])
def test_rows_of_cells_are_the_stated_field(name: str) -> None:
    """At random places the row of their signs has the velocity that the formulas have."""
    system = ANY_STATES[name][0].system
    subject = SystemSubject(system, Invocation(system.origin), ())
    rows, names = dict(subject.fields()), system.states
    for place in np.random.default_rng(0).uniform(-0.5, 0.5, (20, len(names))):
        values = dict(zip(names, place.tolist(), strict=True))
        signs = [float_values(surface.terms, place[None])[0] > 0 for surface in subject.sign_cells.surfaces]
        (field,) = rows[" ".join("+" if sign else "-" for sign in signs)]
        assert [value(text, **values) for text in field.texts(names)] == pytest.approx(
            [value(text, **values) for text in system.stated_lists[0]]
        )


DIFFERENTIATOR = ["-2*Abs(x)**(2/3)*sign(x) + y", "-53/25*Abs(x)**(1/3)*sign(x) + z", "-11/10*sign(x)"]


@thorough  # its check is a golden row; cells of other systems: test_rows_of_cells_are_the_stated_field
def test_a_v_in_the_time_of_the_states_is_told_with_its_roots_and_cells() -> None:
    """No other time is spoken of, and the rows of the cells are the stated velocities in these roots."""
    system = ns.System(["x", "y", "z"], DIFFERENTIATOR)
    report = system.derive(only="verdict,system,cells,lyapunov")
    text = report.text(".md")
    assert report.sections == ("The verdict", "The system", "Cells", "A Lyapunov function")
    assert ("in the time of the states" in text, "slower" in text) == (True, False)
    assert "falls along the velocities of the states. Its derivative" in text
    assert system.check().to_dict()["roots"]["time_scale"] == "1"
    subject = SystemSubject(system.system, Invocation(system.system.origin), ())
    rows, surfaces = dict(subject.fields()), subject.sign_cells.surfaces
    assert len(rows) == 2
    for place in np.random.default_rng(0).uniform(-0.5, 0.5, (20, 3)):
        signs = [float_values(surface.terms, place[None])[0] > 0 for surface in surfaces]
        (field,) = rows[" ".join("+" if sign else "-" for sign in signs)]
        roots = dict(zip(("root_x", "root_y", "z"), place.tolist(), strict=True))
        states = dict(zip("xyz", (place * np.abs(place) ** np.array([2, 0, 0])).tolist(), strict=True))
        found = [value(own, **roots) for own in field.texts(tuple(roots))]
        assert found == pytest.approx([value(own, **states) for own in DIFFERENTIATOR])


def test_a_v_that_falls_where_it_is_not_positive_says_so() -> None:
    rhs = ["1/2*Abs(x)**(2/3)*sign(x) + y", "-Abs(x)**(1/3)*sign(x) + z", "-sign(x)"]
    report = ns.System(["x", "y", "z"], rhs).derive(only="lyapunov")
    assert report.verdict == "unstable"
    assert "falls along the velocities of the states where it is not positive." in report.text(".md")


def test_cells_beside_the_point_do_not_count_at_it() -> None:
    """Only those that touch it: x' is -6 beyond x = 1/4."""
    for states in (["x", "y"], ["x", "y", "z"]):
        rhs = ["-x - 3*(1 + sign(x - 1/4))", "-sign(y)", "-z"][: len(states)]
        text = ns.System(states, rhs).derive(only="point").text(".md")
        assert ("-1" in text, "-6" in text) == (True, False)


def test_leading_terms_stand_where_they_decide() -> None:
    report = derive_report(load_system("flower"), parts=("verdict", "leading-terms"))
    text = render_report(report, ".md")
    assert "## Leading terms" in text
    assert report.subject.headline == "asymptotically stable"


def test_sliding_velocities_are_limits_of_small_steps() -> None:
    """Euler steps that take the field of the side they are on chatter along the border with Filippov's velocity."""
    system = ns.System(["x", "y"], ["1 + y/2 - x", "-2*sign(y) + 1/3 + x/4"], radius=1).system
    sliding = [part for part in PhasePortrait(system).borders if part.kind is BorderKind.SLIDING]
    assert sliding
    step, count = 1e-5, 4_000
    for part in sliding:
        middle = tuple((a + b) / 2 for a, b in zip(part.start, part.end, strict=True))
        predicted = [float(v) for v in sliding_velocity(part, middle)]
        x, y = start = [float(v) for v in middle]
        for _ in range(count):
            x, y = x + step * (1 + y / 2 - x), y + step * (-2 * np.sign(y or 1e-12) + 1 / 3 + x / 4)
        walked = (np.array([x, y]) - start) / (step * count)
        assert walked == pytest.approx(predicted, abs=0.04)  # the field changes along the way


# ---- Formulas of systems that were rewritten: short in reports, and with the same values ---------

RATES = ["sin(x) - 2*sgn(x + y) - y", "1/4 - (1 - x)*cos(2*x - y) + Abs(y)", "-(x/2 + sin(y + pi/2)) + 10*sin(x)**2"]


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("(((1*((+ (x)) - (+ (x))**3/6 + 0*(+ (x))**5/120)) - (2*sgn(x + y))) - (y))", "x - x**3/6 - 2*sgn(x + y) - y"),
        ("(0 - x)*1 + 0/7", "-x"),
        ("x/(y*1)/2 - (x - (y - 0))", "x/y/2 - (x - y)"),
        ("-(0) + -x**2", "-x**2"),
        ("10*x + 0.5*(+y)", "10*x + 0.5*y"),
        ("(-1)**2*x", "(-1)**2*x"),
        ("1 + (x - (-1/2))**2", "1 + (x + 1/2)**2"),
        ("x - (-2)*y + (-3) - (y - -1)", "x + 2*y - 3 - (y + 1)"),
    ],
)
def test_what_changes_nothing_is_left_out(text: str, shown: str) -> None:
    assert written(tidied(formula_tree(text))) == shown


@pytest.mark.parametrize("rate", RATES)
def test_values_stay(rate: str) -> None:
    data = {"system": {"states": ["x", "y"], "rhs": ["y", rate]}, "check": {"equilibrium": ["0", "0"]}}
    x, y = np.random.default_rng(0).uniform(-2, 2, (2, 50))
    for member in build_system(data, "t", Path("t.toml")).members:
        text, shown = member.rhs[1].text, written(tidied(member.rhs[1].tree))
        assert len(shown) <= len(text)
        first, second = (value(formula, x=x, y=y) for formula in (text, shown))
        assert np.allclose(first, second, rtol=1e-12, atol=1e-12)


def test_the_factor_that_clears_fractions_is_tidied() -> None:
    data = {"system": {"states": ["x", "y"], "rhs": ["y", "-x/(1 + Abs(y))"]}}
    said = rewriting_words(build_system(data, "t", Path("t.toml")))
    assert said.startswith("multiplied by (1 + Abs(y))*(1 + Abs(y)), which is positive")


# ---- Sentences of the program with their formulas set as formulas --------------------------------


def plain(text: str) -> str:
    return "".join(part.plain if isinstance(part, Math) else str(part) for part in with_formulas(text))


@pytest.mark.parametrize(
    ("text", "latex"),
    [
        ("V* < 0 at every nonzero vertex", [r"\dot V^* < 0"]),
        ("at any rate in [-sqrt(2)/2, 3*sqrt(5)/7]", [r"-\tfrac{\sqrt{2}}{2}", r"\tfrac{3\sqrt{5}}{7}"]),
        ("by at most -3/8 |c_0|", [r"-\tfrac{3}{8}", r"\lvert c_0 \rvert"]),
        ("theta is stable", [r"\theta"]),
        ("a cell on the paper's page 3 of 12", []),
        ("V = 25*x**2/38 + y**2/2 and 2/3", [r"\tfrac{2}{3}"]),  # a square over 38, not a power of 2/38
        ("the file a/b and a date 2001/1988x", []),
    ],
)
def test_formulas_are_found(text: str, latex: list[str]) -> None:
    assert [part.latex for part in with_formulas(text) if isinstance(part, Math)] == latex


@few(8)
@pytest.mark.parametrize("rule", ["nearest", "box", "ellipse"])
@pytest.mark.parametrize("name", keep(6, builtin_scenes()))
def test_no_word_is_lost(name: str, rule: str) -> None:
    check = check_theorem4(load_scene(name, rule=rule))
    for reason in (check.reason, *(found.reason for _, found in check.clauses)):
        assert plain(reason) == reason
