"""Plain systems through the command line: checks, audits, certificates, sines and cosines."""

from __future__ import annotations

import json
import math
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib.text import Text
from rich.console import Console

import nonsmooth as ns
from nonsmooth.proofs.checker.roots import read_subject
from nonsmooth.proofs.checker.statements import VERSION
from nonsmooth.proofs.findings import Fact, Quantity, Translation, row_fact, text_fact, unsaid
from nonsmooth.proofs.kernel.search import Search
from nonsmooth.proofs.kernel.subject import about, subjects_of
from nonsmooth.proofs.system_decision import decide_system
from nonsmooth.proofs.systems.border_motion import BorderKind, BorderPart, sliding_velocity
from nonsmooth.proofs.systems.domain import plane_cells
from nonsmooth.proofs.systems.ray_moves import resting_edges
from nonsmooth.proofs.systems.system_stability import PlanePoint
from nonsmooth.reports.checks.phase_portrait import PhasePortrait, sampled_rates
from nonsmooth.reports.checks.system_results import SystemCheckResult
from nonsmooth.reports.output.console import BAD_INPUT
from nonsmooth.reports.output.facts import fact_record, fact_rows
from nonsmooth.symbolic.files.scene_file import load_system
from nonsmooth.symbolic.files.system_builder import build_system
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.systems.switched_system import SwitchedSystem
from tests.oracles.floats import value
from tests.reports.conftest import Invoke
from tests.thorough import few, keep

# ---- Plain systems, audits and certificates through the command line -----------------------------


WHEELS = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[ring]\ncount = 4\nradius = "sqrt(2)"\nphase = "pi/4"\n'
SYSTEM = '[system]\nstates = ["p", "q"]\nrhs = ["-sign(p)", "-sign(q)"]\n'


@pytest.mark.parametrize(
    ("scene", "function", "expected"),
    [(WHEELS, "x**2 + 3*y**2", 0), (WHEELS, "Abs(x) - Abs(y)", 1), (SYSTEM, "Abs(p) + 2*Abs(q)", 0)],
)
def test_the_function_of_the_scene_is_audited_unless_one_is_given(
    scene: str, function: str, expected: int, tmp_path: Path, invoke: Invoke
) -> None:
    path = tmp_path / "scene.toml"
    path.write_text(f'{scene}[check]\nlyapunov = "{function}"\n')
    of_the_scene = invoke("audit", str(path), "--json")
    assert (of_the_scene.status, of_the_scene.record["V"]) == (expected, function)
    assert of_the_scene == invoke("audit", str(path), "--lyapunov", function, "--json")
    other = "-x**2" if scene == WHEELS else "-p**2"
    given = invoke("audit", str(path), "--lyapunov", other, "--json")
    assert (given.status, given.record["V"]) == (1, other)


@pytest.mark.parametrize("options", ["--rule all --certificate all.json", "--certificate four-wheel.txt"])
def test_bad_output_is_refused_before_the_work(invoke: Invoke, monkeypatch: pytest.MonkeyPatch, options: str) -> None:
    def work(*_: object, **__: object) -> None:
        raise AssertionError("the scene was checked")

    monkeypatch.setattr("nonsmooth.proofs.theorem4.check_theorem4", work)
    assert invoke("check", "four-wheel", *options.split()).status == BAD_INPUT


# ---- what proves a verdict is shown ---------------------------------------------------------------


def value_of(text: str, x: float, y: float) -> float:
    """A formula of a record at a point; its text is this program's own."""
    return float(value(text, x=x, y=y))


def flower_field(x: float, y: float) -> tuple[float, float]:
    """Johansson and Rantzer 1998."""
    a, b, c, d = (-0.1, 1, -5, -0.1) if abs(x) >= abs(y) else (-0.1, 5, -1, -0.1)
    return a * x + b * y, c * x + d * y


def test_the_flower_shows_the_function_that_proves_it(invoke: Invoke) -> None:
    """The V of the record is positive and falls along the field, at points off the lines on which it bends."""
    record = invoke("check", "flower", "--json").record
    found = record["lyapunov"]
    assert found["proves"]
    assert found["verdict"] == "strict"
    assert found["domain"]["kind"] == "plane"
    assert found["tried"]["V"] == "x**2 + y**2"
    assert found["tried"]["verdict"] == "refuted"
    for k in range(400):
        angle = 2 * math.pi * (k + 0.37) / 400
        x, y = math.cos(angle), math.sin(angle)
        f, g = flower_field(x, y)
        here, ahead = value_of(found["V"], x, y), value_of(found["V"], x + 1e-7 * f, y + 1e-7 * g)
        assert here > 0
        assert ahead < here


def test_nothing_is_proved_by_nothing(tmp_path: Path) -> None:
    scene = tmp_path / "my.toml"
    scene.write_text('[system]\nstates = ["x", "y"]\nrhs = ["x*y**2 - x**5", "-y*x**2 + y**5"]\n')
    result = decide_system(load_system(scene))
    console = Console(width=100, record=True, file=StringIO())
    found = SystemCheckResult(result, shows_evidence=True)
    console.print(*found.views())
    shown = console.export_text()
    assert "undecided" in shown
    assert "(nothing)" not in shown
    record = found.facts()
    assert not record["lyapunov"]["proves"]
    assert record["lyapunov"]["domain"]["radius"] == 0.5


@pytest.mark.parametrize(("states", "shape"), [(["x", "y"], "square"), (["x", "y", "z"], "cube")])
def test_what_a_larger_region_leaves_is_called_by_its_shape(
    invoke: Invoke, tmp_path: Path, states: list[str], shape: str
) -> None:
    """V' = -2 V + 2 x^2 y is negative on the domain: nothing but the border of that ends the region."""
    scene = tmp_path / "my.toml"
    rhs = ["-x + x*y", *(f"-{name}" for name in states[1:])]
    scene.write_text(f"[system]\nstates = {json.dumps(states)}\nrhs = {json.dumps(rhs)}\n")
    region = invoke("check", str(scene), "--region", "none", "--json").record["lyapunov"]["region"]
    assert f" leaves the {shape}, (" in region["text"]


# ---- phase portraits -----------------------------------------------------------------------------


def portrayed(tmp_path: Path, first: str, second: str) -> str:
    path = tmp_path / "portrait.toml"
    path.write_text(f'[system]\nstates = ["x", "y"]\nrhs = ["{first}", "{second}"]\n')
    return str(path)


def test_kinds_of_borders_against_the_field_beside_them(tmp_path: Path, invoke: Invoke) -> None:
    """On x = 0: x' = y - 1/4 - sign(x)(y + 1/8) slides above -1/8, changes at 3/16 and -1/8."""
    scene = portrayed(tmp_path, "y - 1/4 - sign(x)*(y + 1/8)", "-y")
    borders = invoke("partition", scene, "--json").record["borders"]
    for border in borders:
        height = (border["from"][1] + border["to"][1]) / 2
        right, left = (height - 0.25 - s * (height + 0.125) for s in (1, -1))
        expected = "sliding" if right < 0 < left else "repelling" if left < 0 < right else "crossing"
        assert border["kind"] == expected
    assert {border["kind"] for border in borders} == {"sliding", "crossing"}
    assert sum(abs(border["to"][1] - border["from"][1]) for border in borders) == pytest.approx(1.0)


# ---- certificates --------------------------------------------------------------------------------


@few(2)
@pytest.mark.parametrize(
    ("states", "rhs"),
    keep(3, [
        (["x"], ["-x + 8*x**3"]),
        (["x", "y"], ["y", "-x - y*Abs(y)"]),
        (["x", "y", "z"], ["-x", "-y + x", "-sgn(z)"]),
        (["x", "y"], ["y", "-x*Abs(x) - y**3"]),
    ]),
)  # fmt: skip
def test_certificates_of_one_state_of_damping_and_of_three(
    invoke: Invoke, tmp_path: Path, states: list[str], rhs: list[str]
) -> None:
    for name, formulas in (("own", rhs), ("other", [f"2*({rhs[0]})", *rhs[1:]])):
        table = f'name = "{name}"\n[system]\nstates = {json.dumps(states)}\nrhs = {json.dumps(formulas)}\n'
        (tmp_path / f"{name}.toml").write_text(table, encoding="utf-8")
    file, own, other = (str(tmp_path / name) for name in ("c.json", "own.toml", "other.toml"))
    assert invoke("check", own, "--certificate", file).status == 0
    accepted = invoke("verify", file, own)
    assert (accepted.status, accepted.out.splitlines()[0]) == (0, "valid")
    assert accepted.out.splitlines()[-1] == f"about {own}: the same states, formulas and point"
    refused = invoke("verify", file, other)
    assert (refused.status, refused.out.splitlines()[0]) == (
        1, f"rejected: required a certificate about {other}, received one with other rhs"
    )  # fmt: skip
    record = json.loads(Path(file).read_text(encoding="utf-8"))
    forged = {**record["statement"], "claims": [{"stability": "unstable"}]}
    Path(file).write_text(json.dumps({**record, "statement": forged}), encoding="utf-8")
    assert invoke("verify", file).status == 1


CUBE = {"within": "1", "surfaces": [], "empty": []}
VERDICT = {"verdict": "asymptotically stable", "everywhere": False, "below": False, "level": None}
FALLS = {"cells": CUBE, "function": "x**2", "second": None, **VERDICT}
GROWS = {"cells": CUBE, "function": "-x**2", "second": None, "direction": ["1"]}


@pytest.mark.parametrize(
    ("rhs", "number", "theorem", "hypotheses", "words"),
    [
        (  # V' is 200 times that of the stated right-hand side, which has no rate of 2
            "-x/(100 + x**2)", 0, "lyapunov",
            {**FALLS, "rate": {"kind": "exponential", "kappa": "2"}},
            "rates of right-hand sides without fractions",
        ),
        (  # the number is larger than sqrt(2), and less than what bounds that in the certificate
            "sqrt(2)*x - 1.41421356238*x", 1, "choice",
            {"choice": 1, "theorem": "instability", "hypotheses": GROWS},
            "other rhs",
        ),
    ],
)  # fmt: skip
def test_what_is_true_of_other_right_hand_sides_alone_is_not_about_a_scene(
    invoke: Invoke, tmp_path: Path, rhs: str, number: int, theorem: str, hypotheses: dict[str, Any], words: str
) -> None:
    """These stand for the stated ones: after fractions were cleared, and at both bounds of irrational numbers."""
    scene, file = tmp_path / "s.toml", tmp_path / "c.json"
    scene.write_text(f'[system]\nstates = ["x"]\nrhs = ["{rhs}"]\n', encoding="utf-8")
    subject = list(map(about, subjects_of(load_system(str(scene)))))[number]
    entry, shown = Search().entry(read_subject(subject), theorem, hypotheses)
    statement = {"subject": subject, "claims": shown}
    record = {"version": VERSION, "statement": statement, "evidence": [entry]}
    file.write_text(json.dumps(record), encoding="utf-8")
    assert invoke("verify", str(file)).status == 0
    compared = invoke("verify", str(file), str(scene))
    assert (compared.status, compared.out.splitlines()[0]) == (
        1, f"rejected: required a certificate about {scene}, received one with {words}"
    )  # fmt: skip
    if theorem == "lyapunov":  # without its rate it is about the scene
        del shown[1]
        file.write_text(json.dumps(record), encoding="utf-8")
        assert invoke("verify", str(file), str(scene)).status == 0


# ---- Facts of plain systems and audits: one list gives the rows of the terminal and the keys of JSON.


def test_a_nested_record_says_its_own_rows_in_their_place() -> None:
    inner = (text_fact("verdict", "stable", "stability"), Fact("gain", Quantity(0.5), "{}", ("1/2",), row="gain"))
    facts = [row_fact("first", "{} of {}", "1", "2"), Fact("outer", inner), Fact("last", "data only")]
    assert fact_rows(facts) == [("first", "1 of 2"), ("stability", "stable"), ("gain", "1/2")]
    assert fact_record(facts) == {
        "outer": {"verdict": "stable", "gain": 0.5, "exact": {}},
        "last": "data only",
    }


def test_facts_as_data_only_keep_their_record() -> None:
    facts = (text_fact("verdict", "stable", "stability"), Fact("gain", Quantity(0.5), "{}", ("1/2",), row="gain"))
    assert fact_rows(unsaid(facts)) == []
    assert fact_record(unsaid(facts)) == fact_record(facts)


# ---- Phase portraits, maps and reports of systems with sines and cosines of states, beside the formulas in NumPy.

NORMAL_STEP = 1e-9  # to either side of a border

SYSTEMS = [
    ("y", "-sin(x) - y - sgn(y)/4"),  # dry friction: slides where |sin(x)| < 1/4
    ("y", "sin(x) - 2*sgn(x + y)"),  # bang-bang: slides between -1 and 1
    ("y", "-sgn(x) - sin(y)"),  # a relay: crosses
    ("sin(y) - x/2", "-sin(2*x)*cos(y) - 3*sgn(y)/4"),
    ("y/(1 + x**2)", "sgn(y)*(1/8 - sin(x)**2)"),  # escapes near the point, slides farther out
    ("sin(x + pi) + y", "cos(x) - 1 - sgn(2*x - y)*cos(3*y)"),
    ("cos(x - pi/2) - sgn(x)", "sin(x*y) - y*Abs(sgn(x))"),
    ("y", "-4*x - (1 + cos(y)/2)*sgn(y)"),  # slides to x = 3/8, which halves of the border meet
    ("y", "-x - (1 + exp(-(2*y)**2)/2)*sgn(y) - atan(x)*tanh(y)"),
]


def built(rhs: Any, **check: Any) -> SwitchedSystem:
    data = {"system": {"states": ["x", "y"], "rhs": list(rhs)}, "check": {"radius": "3/2", **check}}
    return build_system(data, "t", Path("t.toml"))


def field_at(rhs: tuple[str, str], x: Any, y: Any) -> tuple[Any, Any]:
    """The formulas in NumPy."""
    first, second = (value(text, x=x, y=y) for text in rhs)
    return np.broadcast_to(first, np.shape(x)), np.broadcast_to(second, np.shape(x))


@pytest.mark.parametrize("rhs", SYSTEMS)
def test_rates_are_those_of_the_formulas(rhs: tuple[str, str]) -> None:
    portrait = PhasePortrait(built(rhs))
    xs, ys = np.random.default_rng(7).uniform(-1.5, 1.5, (2, 400))
    found, stated = np.array(sampled_rates(portrait.cells, portrait.fields, xs, ys)), np.array(field_at(rhs, xs, ys))
    scale = 1 + xs**2 if "/(1 + x**2)" in rhs[0] else 1.0  # fractions are cleared
    assert np.allclose(found, stated * scale, atol=1e-12)


@pytest.mark.parametrize("rhs", SYSTEMS)
def test_borders_agree_with_samples_beside_them(rhs: tuple[str, str]) -> None:
    parts = PhasePortrait(built(rhs)).borders
    assert parts
    for part in parts:
        assert {_sampled_kind(rhs, part, share) for share in np.linspace(0.001, 0.999, 57)} == {part.kind}


def test_borders_miss_nothing_but_roots() -> None:
    """The parts of each border follow each other, and together are as long as the border."""
    for rhs in (*SYSTEMS[:3], *SYSTEMS[-2:]):
        parts = PhasePortrait(built(rhs)).borders
        length = sum(math.dist(*(list(map(float, end)) for end in (part.start, part.end))) for part in parts)
        border = 3.0 if "x + y" not in rhs[1] else 3 * math.sqrt(2)
        assert math.isclose(length, border, rel_tol=1e-6)


def _sampled_kind(rhs: tuple[str, str], part: BorderPart, share: float) -> BorderKind:
    """From the formulas a little to both sides of a border."""
    start, end, normal = (np.array([float(v) for v in ends]) for ends in (part.start, part.end, part.normal))
    place, across = start + share * (end - start), normal / np.linalg.norm(normal)
    inner, outer = (
        float(np.dot(across, np.array(field_at(rhs, *(place + side * NORMAL_STEP * across))))) for side in (1, -1)
    )
    if min(abs(inner), abs(outer)) < 1e-7:
        return BorderKind.TOUCHED
    if inner * outer > 0:
        return BorderKind.CROSSING
    return BorderKind.SLIDING if inner < 0 else BorderKind.REPELLING


def test_an_end_of_a_slide_is_the_root_of_the_sine() -> None:
    slides = [part for part in PhasePortrait(built(SYSTEMS[0])).borders if part.kind is BorderKind.SLIDING]
    assert sorted(float(part.end[0] + part.start[0]) for part in slides) == pytest.approx(
        [-math.asin(0.25), math.asin(0.25)], abs=1e-11
    )
    assert not any(part.is_exact for part in slides)


def test_a_slide_is_the_mixture_that_is_tangent() -> None:
    (slide, _) = [part for part in PhasePortrait(built(SYSTEMS[1])).borders if part.kind is BorderKind.SLIDING]
    place = slide.start
    x, y = map(float, place)
    assert sliding_velocity(slide, place) == pytest.approx((y, -y))
    assert x == -y


def test_a_sign_that_is_not_found_is_called_undecided() -> None:
    """``sin^2 + cos^2 - 1`` is zero, which no ball shows."""
    (part, *_) = PhasePortrait(built(["x*sgn(y)", "(sin(x)**2 + cos(x)**2 - 1)*sgn(y)"])).borders
    assert part.kind is BorderKind.UNDECIDED


def test_dry_friction_rests_beside_the_hanging_pendulum() -> None:
    result = decide_system(built(["y", "-2*sin(x) - sgn(y)"]))
    assert result.verdict is Translation.STABLE
    assert PlanePoint(result.scene).rays
    assert "not asymptotically" in result.reason
    assert result.check()
    assert result.function is result.given  # there is no V that falls: none is searched


def test_a_rest_of_the_enclosing_fields_alone_is_none() -> None:
    """On y = 0 the fields are near ``x**5/240`` and three times that, while polynomials between which they lie rest."""
    for factor in ("1", "(2 + sgn(y))"):
        cells = plane_cells(built(["y", f"(sin(x) - x + x**3/6 - x**5/240)*{factor} - y"]))
        assert list(resting_edges(cells))
        assert not list(resting_edges(cells, enclosing=True))


def test_partition_map_and_report(tmp_path: Path, invoke: Invoke) -> None:
    scene = tmp_path / "pendulum.toml"
    rhs = '["y", "-sin(x) - y - sgn(y)/4"]'
    scene.write_text(f'[system]\nstates = ["x", "y"]\nrhs = {rhs}\n[check]\nradius = "1"\n', encoding="utf-8")
    listed = invoke("partition", str(scene))
    assert "-y - sin(x) - 1/4" in listed.out
    assert "(0.2527, 0)" in listed.out
    assert ns.load(scene).map(grid=3, until=1.0).to_dict()["shares"]["nearer"] > 0.5
    report = invoke("derive", str(scene))
    assert r"-y - \sin\left(x\right) - \frac{1}{4}" in report.out
    assert "(0.2527, 0)" in report.out


def test_arbitrary_switching_of_sines_has_no_portrait() -> None:
    with pytest.raises(SceneError, match="one right-hand side"):
        PhasePortrait(built([["y", "-sin(x) - y"], ["y", "-2*sin(x) - y"]]))


def test_a_portrait_names_all_that_it_draws() -> None:
    figures = [PhasePortrait(built(rhs)).figure() for rhs in (("x", "y"), ("-x - y", "x - y"))]
    (unstable,), (stable,) = (figure.legends for figure in figures)
    assert [text.get_text() for text in unstable.get_texts()] == ["checked point"]
    assert {"checked point", "level sets of V"} <= {text.get_text() for text in stable.get_texts()}
    shown = [" ".join(text.get_text() for text in figure.findobj(Text)) for figure in figures]
    assert ["from everywhere" in words for words in shown] == [False, True]
