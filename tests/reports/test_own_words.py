"""What is said in words: the user's own names, what is not certified, unknown loads, contradictions."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import pytest

import nonsmooth as ns
from nonsmooth.proofs import theorem4
from nonsmooth.proofs.findings import Theorem4, Translation
from nonsmooth.proofs.theorem4 import CellCheck, Check
from nonsmooth.reports.checks import subject
from nonsmooth.reports.designs.freedom import Freedom
from nonsmooth.reports.figures.wheels import wheel_labels
from nonsmooth.reports.output.entries import toml_text
from nonsmooth.reports.sweeps import outcome as outcomes
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.scene_file import load_scene, one_by_one
from nonsmooth.symbolic.formulas.surfaces import constant
from nonsmooth.symbolic.mechanics.scene import WheelNumber
from nonsmooth.symbolic.messages.scene_error import SceneError
from nonsmooth.symbolic.numbers.number_text import brief_text, numbers_text, short_text
from tests.proofs.forged import with_results
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

# ---- The user's own words: names of wheels, decimals and degrees wherever a table in millimetres is spoken of.

TABLE = "wheel,x,y\nA1,100,100\nA2,-100,100\nB1,-100,-100\nB2,100,-100.4\n"
SCENE = """
name = "small table"
units = { length = "mm" }
friction = { mu_roll = 0.62, mu_side = 0.31 }
contact = { rule = "ellipse" }
field = { kind = "radial", speed = 100 }
wheels = { file = "wheels.csv" }
"""


def write(folder: Path, table: str = TABLE, scene: str = SCENE) -> Path:
    (folder / "wheels.csv").write_text(table, encoding="utf-8")
    (folder / "table.toml").write_text(scene, encoding="utf-8")
    return folder / "table.toml"


def test_a_number_with_a_name_is_written_by_its_name_and_counts_as_a_number() -> None:
    named = WheelNumber(3, "A1")
    assert (f"wheel {named}", f"u_{named:d}", json.dumps([named])) == ("wheel A1", "u_3", "[3]")
    assert named == 3
    assert {3: "x"}[named] == "x"
    assert (str(WheelNumber(3)), numbers_text((1, 2, 3))) == ("3", "1-3")
    assert numbers_text((WheelNumber(1, "A"), WheelNumber(2, "B"), WheelNumber(3, "C"))) == "A, B, C"


def test_wheels_have_the_names_of_their_table(tmp_path: Path) -> None:
    scene = load_scene(write(tmp_path))
    assert [str(wheel.index) for wheel in scene.wheels] == ["A1", "A2", "B1", "B2"]
    assert not scene.field.remarks  # the column is read


@pytest.mark.parametrize(
    ("table", "line"),
    [
        ("name,x,y\nM1,1,1\nM2,-1,1\nM1,0,-1\n", "4.name: required each name once (it is that of wheels.csv:2)"),
        ("name,x,y\nM1,1,1\na|b,-1,1\n", "3.name: required a name of at most 30 letters"),
    ],
)
def test_equal_names_and_no_names_are_refused_in_one_line(tmp_path: Path, table: str, line: str) -> None:
    with pytest.raises(SceneError, match=re.escape(line)):
        load_scene(write(tmp_path, table))


def test_a_scene_with_units_writes_decimals_and_one_without_exact_forms(tmp_path: Path) -> None:
    field = load_scene(write(tmp_path)).field
    numbers = (field.rational(Fraction(31, 50)), field.rational(Fraction(1, 3)), field.sqrt(2))
    assert [short_text(number) for number in numbers] == ["0.62", "0.333333", "1.41421"]
    assert [brief_text(number) for number in numbers] == ["0.62", "0.333333", "1.41421"]
    plain = load_scene("four-wheel").field
    assert [short_text(plain.rational(Fraction(1, 3))), short_text(plain.sqrt(2))] == ["1/3", "sqrt(2)"]


def test_a_picture_writes_numbers_where_names_do_not_fit(tmp_path: Path) -> None:
    wheels = load_scene(write(tmp_path, TABLE.replace("A1", "front left of the belt"))).wheels
    assert [wheel_labels(wheels, gap)[1] for gap in (400, 40, 1)] == [[str(w.index) for w in wheels], list("1234"), []]


def test_a_chosen_radius_has_two_digits(tmp_path: Path) -> None:
    assert load_scene(write(tmp_path)).check.radius == 40  # of 200.4 mm/5 = 40.08 mm, not above it


@pytest.mark.parametrize(
    ("changed", "hint"),
    [
        ('length = "m"', '[units]: the wheels lie within 200.4 m: is length = "mm" meant?'),
        (
            'length = "mm", speed = "m/s"',
            "[units]: the fastest wheel runs at 1e+05 mm/s",
        ),
    ],
)
def test_sizes_a_thousand_times_off_are_told(tmp_path: Path, changed: str, hint: str) -> None:
    scene = load_scene(write(tmp_path, scene=SCENE.replace('length = "mm"', changed)))
    assert any(hint in remark for remark in scene.field.remarks)


SILENT = "no wheel states a speed"
OF_WHEEL = " (speed of a wheel is a key or column)"
OF_FIELD = " ([field] speed is that of wheels without a heading)"
TWO_SILENT = "no speed is stated of wheels A1, B2"


@pytest.mark.parametrize(
    ("units", "field", "columns", "hint"),
    [
        ('length = "mm"', 'kind = "radial", speed = 100', "", None),
        ('length = "mm"', 'kind = "radial"', "", f"{SILENT}: they run at 1 mm/s{OF_WHEEL}"),
        ('length = "mm", speed = "m/s"', 'kind = "saddle"', "", f"{SILENT}: they run at 1000 mm/s{OF_WHEEL}"),
        ('length = "mm"', 'kind = "radial", speed = 100', "heading", f"{TWO_SILENT}: they run at 1 mm/s{OF_FIELD}"),
        ('length = "mm"', 'kind = "radial"', "speed", f"{TWO_SILENT}: they run at 1 mm/s{OF_WHEEL}"),
        ('angle = "deg"', 'kind = "radial"', "", None),
    ],
)
def test_wheels_whose_speed_nothing_states_are_told(
    tmp_path: Path, units: str, field: str, columns: str, hint: str | None
) -> None:
    """A field's speed is that of the wheels whose headings it gives."""
    own = {"heading": ("90", "", "", "90"), "speed": ("", "50", "50", "")}.get(columns, ("",) * 4)
    rows = zip(TABLE.splitlines(), (columns or "note", *own), strict=True)
    table = "\n".join(f"{row},{entry}" for row, entry in rows)
    scene = SCENE.replace('kind = "radial", speed = 100', field).replace('length = "mm"', units)
    remarks = load_scene(write(tmp_path, table, scene)).field.remarks
    assert [remark for remark in remarks if remark.startswith("[units]")] == ([f"[units]: {hint}"] if hint else [])


@pytest.mark.parametrize("heading", [45, 1.5])
def test_radians_beyond_a_full_turn_are_told(tmp_path: Path, heading: float) -> None:
    table = TABLE.replace("x,y", "x,y,heading").replace("100\n", f"100,{heading}\n").replace(".4\n", f".4,{heading}\n")
    scene = load_scene(write(tmp_path, table, SCENE.replace('length = "mm"', 'length = "mm", angle = "rad"')))
    hints = [remark for remark in scene.field.remarks if "more than a full turn" in remark]
    assert hints == (['[units]: an angle is 45 rad, more than a full turn: is angle = "deg" meant?'] * (heading > 7))


def test_a_body_of_another_unit_than_its_wheels_is_told(tmp_path: Path) -> None:
    body = '[body]\nshape = "rectangle"\nwidth = 0.3\nheight = 0.3\n'
    assert any("[body]" in remark for remark in load_scene(write(tmp_path, scene=SCENE + body)).field.remarks)


def test_writing_a_number_decides_nothing(tmp_path: Path) -> None:
    """Numbers of measured angles count decisions that rounding made: one more, and verdicts would be `undecided`."""
    angles = (206, -26.3, 26.1, 154.7)
    rows = [f"{x},{y},{angle}" for (x, y), angle in zip(((2, 1), (-2, 1), (-2, -1), (2, -1)), angles, strict=True)]
    scene = load_scene(write(tmp_path, "\n".join(["x,y,heading", *rows])))
    direction = scene.wheels[1].unit_direction[0]
    before = scene.field.rounded_signs
    assert (brief_text(direction), short_text(-direction)) == ("0.896486", "-0.896486")
    assert constant(direction).latex(longest=30) == "0.896486"
    assert scene.field.rounded_signs == before


def test_a_table_that_is_written_wheel_by_wheel_keeps_its_names(tmp_path: Path) -> None:
    """As ``design`` writes it; equal places and directions, too."""
    scene = load_scene(file := write(tmp_path))
    other = tmp_path / "other.toml"
    other.write_text(toml_text(one_by_one(read_document(str(file))[0], scene)), encoding="utf-8")
    again = load_scene(other)
    assert [str(wheel.index) for wheel in again.wheels] == ["A1", "A2", "B1", "B2"]
    assert [str(wheel.position) for wheel in again.wheels] == [str(wheel.position) for wheel in scene.wheels]


def test_a_design_is_written_in_degrees_and_decimals_where_units_are_stated(tmp_path: Path) -> None:
    scene = load_scene(file := write(tmp_path))
    freedom = Freedom(("headings",))
    document = freedom.document(read_document(str(file))[0], scene, [0.5, 0.6, 0.4, 0.3])
    first, second, *_ = document["wheel"]
    assert first["position"] == [100, 100]
    assert document["wheel"][3]["position"] == [100, Decimal("-100.4")]
    assert [wheel["name"] for wheel in document["wheel"]] == ["A1", "A2", "B1", "B2"]
    assert first["heading"] == -135  # inward, as it was
    other = tmp_path / "other.toml"
    other.write_text(toml_text(document), encoding="utf-8")
    a, b = (float(part) for part in load_scene(other).wheels[1].unit_direction)
    assert math.degrees(math.atan2(b, a)) == pytest.approx(float(second["heading"]), abs=1e-9)


# ---- What no forces prove is said in words, in every view of a check under rule ``ellipse`` ------

INWARD = """
friction = { mu_roll = 1, mu_side = 0 }
wheel = [{ position = [1, 1] }, { position = [-1, 1] }, { position = [-1, -1] }, { position = [1, -1] }]
"""
CARRIED = """
friction = { mu_roll = 1, mu_side = 0 }
field = { kind = "spiral", angle = "pi/2" }
[ring]
count = 3
[check]
radius = "1/10"
"""
HUGE = re.compile(r"e\+\d\d")  # no length, speed or rate here is above 10


@pytest.fixture(params=keep(1, [INWARD, CARRIED]), ids=["inward", "carried"])
def free_scene(request: pytest.FixtureRequest, tmp_path: Path) -> str:
    (tmp_path / "free.toml").write_text(request.param, encoding="utf-8")
    return "free.toml"


SECTIONS = ("--only", "verdict,situation,derivative,theorem,feedback,rules")


@few(1)
@pytest.mark.parametrize(
    "views",
    [("check",), ("check", "--json"), ("derive", *SECTIONS), ("derive", *SECTIONS[:1], "theorem,feedback", "--json")],
    ids=["check", "check-json", "report", "report-json"],
)
def test_no_view_shows_a_number_that_is_none(invoke: Invoke, free_scene: str, views: tuple[str, ...]) -> None:
    command, *options = views
    outcome = invoke(command, free_scene, "--rule", "ellipse", *options)
    assert outcome.status in (0, 1, 3)
    assert not HUGE.search(outcome.out)
    assert "nan" not in re.findall(r"[a-z]+", outcome.out)
    if "--json" in options:
        json.loads(outcome.out)


# ---- What commands say of scenes whose loads are unknown: verdicts, or one line that names the key.

TEXT = '[friction]\nmu_roll = 1\nmu_side = "1/2"\n[ring]\ncount = 5\n[contact]\nrule = "{}"\nloads = {}\n'


@pytest.fixture(params=['"any"', '{kind = "elastic", height = 0.1}'])
def loads(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.mark.parametrize(("rows", "columns"), keep(1, [(2, 3), (3, 4)]))
def test_json_holds_the_load_that_refutes(tmp_path: Path, invoke: Invoke, rows: int, columns: int) -> None:
    path = tmp_path / "grid.toml"
    grid = f"[grid]\nrows = {rows}\ncolumns = {columns}"
    text = TEXT.replace("[ring]\ncount = 5", grid).format("ellipse", '"any"')
    path.write_text(text, encoding="utf-8")
    done = invoke("check", str(path), "--json")
    assert done.status == 1
    load = done.record["equilibrium"]["load"]
    assert len(load) == rows * columns
    assert sum(load) == pytest.approx(1)


@thorough  # the small one: test_json_holds_the_load_that_refutes
@pytest.mark.parametrize("rule", ["ellipse", "box"])
def test_reports_show_the_load_that_refutes_and_say_what_is_about_one_load(
    tmp_path: Path, invoke: Invoke, rule: str
) -> None:
    path = tmp_path / "grid.toml"
    text = TEXT.replace("[ring]\ncount = 5", "[grid]\nrows = 3\ncolumns = 4").format(rule, '"any"')
    path.write_text(text, encoding="utf-8")
    report = invoke("derive", str(path)).out
    assert re.search(r"under the load \(0\.\d+ on wheel \d+, ", report)
    left_out = report[report.index("What was left out") :]
    for section in ("cells", "derivative", "trajectories", "feedback"):
        assert f"Section {section}: the loads are not known, and this is about one load." in left_out
    assert invoke("derive", str(path), "-o", "grid.html").status == 0


# ---- A contradiction is undecided and said with both sides, wherever the verdict is written ------

BOTH_SIDES = ("translation unstable: V* < 0 at every nonzero vertex", "sampled starts near the point")

# Three rims at 67 degrees and its turns, rounded: under rule ellipse the body rests at the point, to every digit.
RING = """
name = "ring"
friction = { mu_roll = 1, mu_side = "1/2" }
check = { equilibrium = [0, 0], radius = "1/4" }
contact = { rule = "ellipse" }
wheel = [
    { position = [1, 0], heading = "187 deg", speed = 1 },
    { position = ["-1/2", "sqrt(3)/2"], heading = "307 deg", speed = 1 },
    { position = ["-1/2", "-sqrt(3)/2"], heading = "67 deg", speed = 1 },
]
"""


def wrong(check: Check) -> Check:
    """The four-wheel array, which attracts, as a point that bodies leave: a fault that no evidence shows."""
    assert isinstance(check, CellCheck)
    translation = replace(check.translation, verdict=Translation.UNSTABLE, fan=None)
    return replace(with_results(check, translation=translation), verdict=Theorem4.FAILS)


@pytest.fixture
def planted(monkeypatch: pytest.MonkeyPatch, few_paths: None, without_other_rules: None) -> None:
    """Such a fault behind every command."""
    truly = theorem4.check_theorem4
    for module in (theorem4, subject, outcomes):
        monkeypatch.setattr(module, "check_theorem4", lambda *given, **how: wrong(truly(*given, **how)))


@pytest.mark.usefixtures("planted")
def test_the_terminal_says_both_sides(invoke: Invoke) -> None:
    outcome = invoke("check", "four-wheel", "--require", "pose")
    assert outcome.status == 3
    text = " ".join(outcome.out.split())
    assert "contradiction between position and destinations: nobody may rely on either" in text
    for side in BOTH_SIDES:
        assert side in text


@pytest.mark.usefixtures("planted")
def test_json_says_both_sides(invoke: Invoke) -> None:
    outcome = invoke("check", "four-wheel", "--json")
    assert outcome.status == 3
    record = outcome.record
    found = record["contradictions"][0]
    assert found["between"] == "position and destinations"
    for side, words in zip(found["sides"], BOTH_SIDES, strict=True):
        assert words in side
    assert record["answers"]["position"]["verdict"] == "undecided"
    assert record["translation"]["verdict"] == record["theorem4"]["verdict"] == "undecided"
    assert "contradictions" in invoke("check", "four-wheel", "--rule", "nearest", "--json").record


@pytest.mark.usefixtures("planted")
def test_many_scenes_the_report_and_python_say_it(invoke: Invoke, tmp_path: Path) -> None:
    outcome = invoke("check", "four-wheel", "four-wheel", "--json")
    assert outcome.status == 3
    assert [check["theorem4"]["verdict"] for check in outcome.record["checks"]] == ["undecided"] * 2
    invoke("derive", "four-wheel", "--only", "answers,verdict", "-o", str(tmp_path / "report.md"))
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "contradiction between position and destinations" in text
    result = ns.load("four-wheel").check()
    assert isinstance(result, ns.CheckResult)
    assert (str(result.position.verdict), result.theorem4) == ("undecided", "undecided")
    assert result.contradictions
    assert "position and destinations contradict each other" in " ".join(repr(result).split())
    assert result.rows()[-1]["question"] == "contradiction"


@pytest.mark.usefixtures("planted")
def test_a_sweep_says_it(invoke: Invoke) -> None:
    command = ("sweep", "four-wheel", "--vary", "mu_side=1/4,1/2", "--workers", "1")
    for row in invoke(*command, "--json").record["rows"]:
        assert (row["position"], row["theorem4"]) == ("undecided", "undecided")
        assert row["why"].startswith("position and destinations contradict each other: ")
    said = " ".join(invoke(*command).out.split())
    assert "2 of 2 scenes are undecided for that (please report this): position and destinations contradict" in said


@pytest.mark.usefixtures("planted")
def test_no_certificate_and_no_law_are_written_of_it(invoke: Invoke, tmp_path: Path) -> None:
    file = tmp_path / "certificate.json"
    outcome = invoke("check", "four-wheel", "--certificate", str(file))
    assert outcome.status == 3
    assert "not written: what the check says contradicts itself" in outcome.err
    assert not file.exists()


@few(1)
@pytest.mark.usefixtures("without_other_rules")
@pytest.mark.parametrize("mu_side", ["1/2", "1"])
def test_a_rounded_ring_is_not_said_to_drive_away_what_rests_on_it(
    invoke: Invoke, tmp_path: Path, mu_side: str
) -> None:
    file = tmp_path / "ring.toml"
    file.write_text(RING.replace('1/2" }\ncheck', f'{mu_side}" }}\ncheck'), encoding="utf-8")
    outcome = invoke("check", str(file), "--json")
    assert outcome.status == 0, json.dumps(outcome.record["theorem4"])
    assert "only rounding tells from the point" in outcome.record["theorem4"]["reason"]
    assert outcome.record["answers"]["position"]["verdict"] == "comes home"
