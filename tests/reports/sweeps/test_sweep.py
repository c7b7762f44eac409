"""Sweeps against checks one by one, and borders against closed forms."""

from __future__ import annotations

import csv
import json
import math
import tomllib
from collections.abc import Hashable, Sequence
from fractions import Fraction
from importlib.util import find_spec
from itertools import product
from pathlib import Path
from typing import Any

import pytest

import nonsmooth as ns
from nonsmooth.analysis.cells import nearest
from nonsmooth.analysis.cells.partition import Partition
from nonsmooth.reports.output.document import Table, plain_text
from nonsmooth.reports.output.entries import toml_text
from nonsmooth.reports.sweeps import outcome as outcome_module
from nonsmooth.reports.sweeps.base import Base, base_of, with_wheels
from nonsmooth.reports.sweeps.borders import Border, find_borders, said
from nonsmooth.reports.sweeps.figure import axis_label, build_figure
from nonsmooth.reports.sweeps.outcome import QUESTIONS, Outcome, outcomes_of
from nonsmooth.reports.sweeps.sweep import Means, Sweep, run_sweep
from nonsmooth.reports.sweeps.sweep_plan import LARGE, Entry, Point, SweepPlan, read_plan
from nonsmooth.reports.sweeps.table import flat_rows, sweep_blocks
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.key_paths import Path as KeyPath
from nonsmooth.symbolic.files.scene_file import load_scene, one_by_one
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.number_text import float_text
from tests.oracles.measured_tables import MeasuredTable
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

WITHIN = Fraction(1, 10**9)


def based(scene: str, vary: dict[str, str], **given: str) -> tuple[Base, SweepPlan]:
    base = base_of(*read_document(scene, **given))
    return base, read_plan(vary, base.document, base.file)


def swept(scene: str, vary: dict[str, str], means: Means | None = None, **given: str) -> Sweep:
    return run_sweep(*based(scene, vary, **given), means or Means())


def outcome_of(base: Base, paths: Sequence[KeyPath], entries: Sequence[Entry], *, failures: bool = False) -> Outcome:
    """Of a scene that is checked alone."""
    (outcome,) = outcomes_of(base, paths, [entries], failures=failures)
    return outcome


def values(border: Border) -> list[Any]:
    return [value.entry for value in border.point]


# ---- answers -------------------------------------------------------------------------------------


@few(1)
@pytest.mark.usefixtures("without_paths", "without_other_rules")
@pytest.mark.parametrize("rule", ["nearest", "box", "ellipse"])
def test_a_grid_answers_as_checks_one_by_one(rule: str) -> None:
    found = swept("four-wheel", {"mu_side": "1/2,3/2", "equilibrium.x": "0:1/4:2"}, rule=rule)
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    scenes = product(("1/2", "3/2"), (0, "1/4"))
    for outcome, (side, x) in zip(found.outcomes, scenes, strict=True):
        one = array.with_(mu_side=side, at=(x, 0), rule=rule).check()
        record = one.to_dict()
        assert said(outcome) == (one.position.verdict, one.heading.verdict, one.pose.verdict, one.theorem4)
        for clause in ("equilibrium", "translation", "rotation", "feedback"):
            assert outcome[clause] == record[clause]["verdict"]
        for name, place in {"within": "position", "rate": "position", "largest_rate": "heading"}.items():
            assert outcome[name] == record["answers"][place][name]
        assert outcome["kappa"] == record["answers"]["pose"]["rate"]
        if rule != "ellipse":
            assert outcome["worst_rate"] == record["translation"]["worst_rate"]
            assert outcome["exact"]["worst_rate"] == record["translation"]["exact"]["worst_rate"]


def test_tolerances_vary_and_say_what_is_left_of_them(tmp_path: Path) -> None:
    """Twice the tolerances have half the factor, and bodies end farther away."""
    file = tmp_path / "table.toml"
    built_in = Path(__file__).parents[3] / "symbolic" / "scenes" / "four-wheel.toml"
    box = '\n[tolerance]\nposition = "1/50"\n'
    file.write_text(built_in.read_text(encoding="utf-8") + box, encoding="utf-8")
    found = swept(str(file), {"tolerance.position": "1/50,1/25"})
    one, two = found.outcomes
    (shown,) = [block for block in sweep_blocks(found) if isinstance(block, Table)]
    assert [plain_text(entry) for entry in shown.header][-2:] == ["all end within", "certified, times"]
    assert plain_text(shown.rows[0][-1]) == float_text(one["tolerance_factor"], 4)
    array = ns.load(file)
    assert isinstance(array, ns.Array)
    robust = array.check().tolerances
    assert robust is not None
    assert one["tolerance_factor"] == float(robust["factor"])
    assert one["tolerance_radius"] == float(robust["radius"])
    assert one["tolerance_radius"] < two["tolerance_radius"]
    assert one["tolerance_factor"] == pytest.approx(2 * two["tolerance_factor"], rel=0.05)
    assert swept("four-wheel", {"mu_side": "1/2"}).outcomes[0]["tolerance_factor"] is None


def test_a_table_that_was_measured_says_how_near_bodies_come(tmp_path: Path) -> None:
    """The numbers of the position are those of a check, wheel by wheel, in rows, in CSV files and on a terminal."""
    file, table = tmp_path / "table.toml", MeasuredTable.random(1, "nearest")
    file.write_text(table.toml, encoding="utf-8")
    sweep = swept(str(file), {"wheel.1.speed": "97,98"})
    for outcome, row, speed in zip(sweep.outcomes, flat_rows(sweep), (97, 98), strict=True):
        file.write_text(table.toml.replace("speed = 98.3", f"speed = {speed}"), encoding="utf-8")
        array = ns.load(file)
        assert isinstance(array, ns.Array)
        position = array.check().position
        assert outcome["position"] == "comes near"
        for name in ("accuracy", "ends_within", "within", "after"):
            assert outcome[name] == row[name] == float(position[name]) > 0
    shown = next(block for block in sweep_blocks(sweep) if isinstance(block, Table))
    assert {"ends_within", "within", "after"} <= {title[0] for title in shown.header}


def test_sampled_rates_are_left_out() -> None:
    (outcome,) = swept("four-wheel", {"mu_side": "1/2"}, rule="ellipse").outcomes
    assert outcome["worst_rate"] is None


def test_whole_numbers_and_angles_vary_too() -> None:
    assert [row["position"] for row in swept("ring-6", {"ring.count": "5:6:2"}).outcomes] == ["comes home"] * 2
    rows = swept("four-wheel", {"wheel.1.heading": "225,225 deg,5*pi/4,sqrt(2)"}).outcomes
    assert said(rows[0]) == said(rows[1]) == said(rows[2])
    assert rows[3]["position"] == "refused"


def test_masses_vary_with_a_word_on_what_that_changes(invoke: Invoke, tmp_path: Path) -> None:
    """No answer of a row is about a body with inertia."""
    scene = tmp_path / "s.toml"
    text = '[friction]\nmu_roll = 1\nmu_side = 0.5\n[units]\nlength = "m"\n[body]\nmass = 2\n'
    scene.write_text(f"{text}[ring]\ncount = 4\nradius = 1\n", encoding="utf-8")
    done = invoke("sweep", str(scene), "--vary", "body.mass=1,2")
    assert done.status == 0
    assert "body.mass: rows tell of bodies without inertia; check says of one scene what it does" in done.err
    assert "inertia" not in invoke("sweep", str(scene), "--vary", "mu_side=1/2,1").err


def test_a_table_of_wheels_is_read_once(tmp_path: Path) -> None:
    table = tmp_path / "w.csv"
    table.write_text("x,y,heading\n1,1,inward\n-1,1,inward\n-1,-1,inward\n1,-1,inward\n", encoding="utf-8")
    scene = tmp_path / "s.toml"
    scene.write_text('[friction]\nmu_roll = 1\nmu_side = 0.5\n[wheels]\nfile = "w.csv"\n', encoding="utf-8")
    base, plan = based(str(scene), {"mu_side": "1/2,2"})
    key = base.key((), (), "")
    table.unlink()
    assert [row["position"] for row in run_sweep(base, plan, Means()).outcomes] == ["comes home", "stays near"]
    table.write_text("x,y,heading\n2,1,inward\n-1,1,inward\n-1,-1,inward\n1,-1,inward\n", encoding="utf-8")
    assert based(str(scene), {"mu_side": "1/2"})[0].key((), (), "") != key


def test_keys_of_scenes_follow_their_numbers_and_nothing_else() -> None:
    base, plan = based("four-wheel", {"mu_side": "1/2,3/4"})
    paths = tuple(axis.path for axis in plan.axes)
    keys = [base.key(paths, (entry,), "answers") for entry in ("1/2", "0.50", "3/4")]
    assert keys[0] == keys[1] != keys[2]
    assert keys[0] == base.key((), (), "answers") != base.key((), (), "answers, failures of one wheel")
    renamed = base_of({**base.document, "name": "other", "description": "another"}, base.file, base.path)
    assert renamed.key((), (), "answers") == keys[0]
    other = base_of(*read_document("four-wheel", rule="box"))
    assert other.key((), (), "answers") != keys[0]


# ---- borders -------------------------------------------------------------------------------------


@few(2)
@pytest.mark.parametrize(("rule", "question"), [("nearest", "position"), ("nearest", "pose"), ("box", "pose")])
def test_answers_change_where_friction_is_equal(rule: str, question: str) -> None:
    """Four wheels: with ``mu_side >= mu_roll`` the side rows win (nearest), and no speeds move the body (box)."""
    found = swept("four-wheel", {"mu_roll": "2", "mu_side": "1/3:4:3"}, Means(borders=True), rule=rule)
    changed = [border for border in found.borders or () if question in border.changed]
    assert changed
    for border in changed:
        assert values(border) == [2, 2]
        assert border.above.constant - border.below.constant <= WITHIN
        assert border.below.constant <= 2 <= border.above.constant


@thorough  # the small one: test_answers_change_where_friction_is_equal
def test_rest_ends_where_the_theory_says() -> None:
    """Rule box: the point (x, y) is an equilibrium iff ``|x| + |y| <= mu_S/mu_R``."""
    vary = {"equilibrium.x": "-7/10:3/5:2", "equilibrium.y": "1/10", "mu_side": "1/2"}
    found = swept("four-wheel", vary, Means(borders=True), rule="box", radius="1/20")
    assert [outcome["equilibrium"] for outcome in found.outcomes] == ["fails", "fails"]
    assert found.borders == ()  # both ends answer alike: what lies between them is not looked for
    found = swept("four-wheel", {**vary, "equilibrium.x": "0:3/5:2"}, Means(borders=True), rule="box", radius="1/20")
    border, farther = found.borders or ()
    assert values(border) == ["2/5", "1/10", "1/2"]
    assert border.before[0] == border.there[0] == "stays near"
    assert border.after[0] == "undecided"  # from just outside bodies go to the edge, which is within any accuracy
    assert (farther.before[0], farther.after[0]) == ("undecided", "leaves")
    away = float(Fraction(values(farther)[0]))
    accuracy = 0.03 * math.sqrt(2 + away**2 + 0.01)  # of the distances of the wheels
    assert (away - 0.4) / math.sqrt(2) > accuracy  # so far away is the edge


def answered(law: Any, point: Point) -> Outcome:
    numbers = [value.number for value in point]
    return dict(zip(QUESTIONS, law(*numbers), strict=True))


def bordered(law: Any, vary: dict[str, str]) -> tuple[Border, ...]:
    """Borders of made-up answers."""
    _, plan = based("four-wheel", vary)

    def ask(points: Sequence[Point]) -> list[Outcome]:
        return [answered(law, point) for point in points]

    return find_borders(plan, ask([plan.point(k) for k in range(plan.size)]), ask)


def test_a_third_answer_between_makes_two_borders() -> None:
    def law(x: float) -> tuple[str, ...]:
        return ("a" if x < 1 / 3 else "b" if x <= 0.7 else "c", "", "", "")

    first, second = bordered(law, {"mu_side": "0:1:2"})
    assert (first.before[0], first.there[0], first.after[0]) == ("a", "b", "b")
    assert abs((first.point[0].number or 0) - 1 / 3) < 1e-9
    assert (second.before[0], second.there[0], second.after[0]) == ("b", "b", "c")
    assert values(second) == ["7/10"]


def test_an_answer_at_one_point_alone_is_found_on_the_grid() -> None:
    borders = bordered(lambda x: ("here" if x == 1 else "a" if x < 1 else "b", "", "", ""), {"mu_side": "0:2:3"})
    assert [(border.before[0], border.after[0]) for border in borders] == [("a", "here"), ("here", "b")]
    assert all(values(border) == [1] for border in borders)


def test_answers_like_noise_end() -> None:
    borders = bordered(lambda x: (str(hash(x)), "", "", ""), {"mu_side": "0:1:2"})
    assert 1 <= len(borders) <= 4


def test_borders_follow_a_curve_along_both_edges() -> None:
    def inside(x: float, y: float) -> tuple[str, ...]:
        return ("in" if x * x + y * y < 1 else "out", "", "", "")

    borders = bordered(inside, {"mu_roll": "0:2:6", "mu_side": "0:2:6"})
    assert len(borders) == 6
    for border in borders:
        x, y = (value.number or 0.0 for value in border.point)
        assert abs(x * x + y * y - 1) < 4e-9


# ---- the command ---------------------------------------------------------------------------------


def test_tables_files_and_python_say_the_same(invoke: Invoke, tmp_path: Path) -> None:
    command = ("sweep", "four-wheel", "--vary", "mu_side=0.05:2:4", "--workers", "1", "--borders")
    out = invoke(*command).out
    assert "friction.mu_side = 1" in out
    assert "4 scenes; position: 2 comes home, 2 stays near" in out
    record = invoke(*command, "--json", "-o", "t.csv").record
    assert [row["values"]["friction.mu_side"] for row in record["rows"]] == [0.05, 0.7, 1.35, 2.0]
    assert record["borders"][0]["exact"]["values"] == {"friction.mu_side": "1"}
    with (tmp_path / "t.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["position"] for row in rows] == [row["position"] for row in record["rows"]]
    assert [row["friction.mu_side exact"] for row in rows] == ["1/20", "7/10", "27/20", "2"]
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    result = array.sweep(mu_side=["1/20", 0.7, Fraction(27, 20), 2], means=ns.Means(borders=True))
    assert [row["position"] for row in result.rows()] == [row["position"] for row in rows]
    assert result.to_dict()["borders"] == record["borders"]
    assert result.to_csv(tmp_path / "same").read_bytes() == (tmp_path / "t.csv").read_bytes()
    assert json.loads(result.save(tmp_path / "t.json").read_text(encoding="utf-8"))["rows"] == record["rows"]


@thorough  # the small one: test_tables_files_and_python_say_the_same
def test_pictures_hold_strips_and_maps(invoke: Invoke, tmp_path: Path) -> None:
    store = ("--store", "r.sqlite", "--workers", "1")
    assert invoke("sweep", "four-wheel", "--vary", "mu_side=1/2:3/2:2", "-o", "a.svg", *store).status == 0
    two = ("--vary", "equilibrium.x=0:1/4:2", "--vary", "mu_side=0.1:0.3:2", "--rule", "box", "--radius", "1/20")
    assert invoke("sweep", "four-wheel", *two, "-o", "b.svg", *store).status == 0
    before = (tmp_path / "b.svg").read_bytes()
    assert invoke("sweep", "four-wheel", *two, "-o", "b.svg", *store).status == 0  # all from the store
    assert (tmp_path / "b.svg").read_bytes() == before
    for name, colors in {"a.svg": ("#009e73", "#f0e442"), "b.svg": ("#f0e442", "#d55e00", "#cc79a7")}.items():
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert all(color in text for color in colors)


@pytest.mark.skipif(find_spec("pyarrow") is None, reason="pyarrow is optional")
def test_parquet_holds_the_rows_of_the_csv_file(tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    array = ns.load("four-wheel")
    assert isinstance(array, ns.Array)
    result = array.sweep(mu_side="1/2,2")
    assert parquet.read_table(result.save(tmp_path / "t.parquet")).to_pylist() == result.rows()


def test_parquet_without_its_library_is_refused(invoke: Invoke, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(__import__("sys").modules, "pyarrow.parquet", None)
    done = invoke("sweep", "four-wheel", "--vary", "mu_side=0:1:2", "-o", "t.parquet")
    assert (done.status, done.out) == (2, "")
    assert "required the package pyarrow" in done.err


def test_large_plans_ask_first_and_say_how_long(invoke: Invoke) -> None:
    done = invoke("sweep", "four-wheel", "--vary", "mu_side=0:1:1000000", "--vary", "mu_roll=1:2:1000000")
    assert done.status == 2
    assert f"--yes: required for more than {LARGE} scenes, received 1000000000000: about" in done.err
    assert "years" in done.err


def test_a_record_may_be_made_twice() -> None:
    base, plan = based("four-wheel", {"mu_side": "1/2"})
    paths = tuple(axis.path for axis in plan.axes)
    assert outcome_of(base, paths, ("1/2",)) == outcome_of(base, paths, ("1/2",))


@few(1)
@pytest.mark.parametrize("name", ["four-wheel", "spiral-30"])
def test_scenes_that_are_checked_together_have_the_outcomes_of_each(name: str) -> None:
    """Friction that is decided, refused and beyond floats in one job: the paths of all are followed at once."""
    base, plan = based(name, {"mu_side": "1/2", "wheel.1.position.x": "1"})
    paths = tuple(axis.path for axis in plan.axes)
    scenes = [(side, x) for side in ("1/2", "-1", "0", "1e200") for x in ("3/4", "7", "1e-180")]
    assert outcomes_of(base, paths, scenes) == [outcome_of(base, paths, scene) for scene in scenes]


@pytest.mark.parametrize(
    ("varied", "values", "shared"),
    [
        (("speed",), ("1", "3/4", "-2", "sqrt(5)"), 3),
        (("heading",), ("225", "230 deg", "7 deg", "1", "240 deg"), 4),  # exact and measured ones
        (("mu_side",), ("1/2", "0", "2", "1"), 1),  # a row without friction has other cells
        (("position", "x"), ("3/4", "sqrt(3)/2", "1.1", "1.1"), 0),
        (("position", "y"), ("1.1", "7/5"), 0),
    ],
    ids=["speeds", "headings", "friction", "places", "a place beside the given one"],
)
def test_scenes_whose_wheels_stand_alike_share_their_cells(
    varied: Sequence[str], values: Sequence[Entry], shared: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What one scene takes from another one changes no outcome; and where places differ it takes nothing."""
    base = with_wheels(base_of(*read_document("four-wheel")), ["wheel.1.speed"])
    paths = (read_plan({".".join(("wheel.1", *varied)): "1"}, base.document, base.file).axes[0].path,)
    scenes = [(value,) for value in values]
    alone = [outcome_of(base, paths, scene) for scene in scenes]
    taken: list[Partition] = []
    take = nearest.nearest_partition_like

    def counted(scene: Scene, known: Partition) -> Partition | None:
        found = take(scene, known)
        taken.extend([found] if found else [])
        return found

    monkeypatch.setattr(nearest, "nearest_partition_like", counted)
    assert outcomes_of(base, paths, scenes) == alone
    assert len(taken) == shared
    for partition in taken:
        own = nearest.build_nearest_partition(partition.scene)
        assert partition == own
        assert partition.meeting == own.meeting
        assert partition.complex.floats.points == own.complex.floats.points


TOLERANCES = """
[tolerance]
mu_roll = "1/5"
mu_side = "1/5"
"""


# Tables with tolerances in sweeps: test_tolerances_vary_and_say_what_is_left_of_them.
@pytest.mark.parametrize(
    ("tables", "rule", "rolls", "checks"),
    keep(2, [("", "nearest", (1, "0.2"), 5), ("", "ellipse", (1,), 3), (TOLERANCES, "nearest", (1,), 3)]),
    ids=["nearest", "ellipse", "tolerances"],
)
def test_of_friction_counts_what_the_rule_sees(
    tables: str, rule: str, rolls: Sequence[Entry], checks: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """`nearest` sees which coefficient of each wheel is larger and which are zero: scenes alike in that are checked
    once, with the answers that each has alone; with tolerances, and under other rules, every scene is checked.
    """
    text = toml_text({**read_document("four-wheel", rule=rule)[0]}) + tables
    base = with_wheels(base_of(tomllib.loads(text), "four.toml", Path("four.toml")), ["wheel.2.mu_side"])
    paths = (("friction", "mu_roll"), ("wheel", 1, "mu_side"))
    sides: tuple[Entry, ...] = ("0.1", "0.8", 0)
    scenes = list(product(rolls, sides))
    failures = rule == "nearest"
    alone = [outcome_of(base, paths, scene, failures=failures) for scene in scenes]
    checked: list[Scene] = []
    decide = vars(outcome_module)["_decided"]

    def counted(scene: Scene, **asked: Any) -> Any:
        checked.append(scene)
        return decide(scene, **asked)

    monkeypatch.setattr(outcome_module, "_decided", counted)
    assert outcomes_of(base, paths, scenes, failures=failures) == alone
    assert len(checked) == checks
    earlier: dict[Hashable, Any] = {}  # of one job after the other
    jobs = [outcomes_of(base, paths, [scene], failures=failures, earlier=earlier) for scene in scenes]
    assert [outcome for job in jobs for outcome in job] == alone
    assert len(checked) == 2 * checks
    monkeypatch.setattr(outcome_module, "KEPT", 1)  # the last one alone
    assert outcomes_of(base, paths, scenes[-1:], failures=failures, earlier=earlier) == alone[-1:]
    assert len(earlier) == 1


@thorough  # the small one: test_a_wheel_of_a_table_varies_on_its_own
@pytest.mark.parametrize("name", ["ring-6", "grid-4x4"])
def test_a_wheel_of_a_layout_varies_on_its_own(invoke: Invoke, tmp_path: Path, name: str) -> None:
    """As in the scene whose wheels are written one by one; the others stay where they are."""
    own = invoke("check", name, "--json").record
    third = load_scene(name).wheels[2]
    heading = f"{math.degrees(math.atan2(float(third.unit_direction[1]), float(third.unit_direction[0]))):.0f}"
    record = invoke("sweep", name, "--vary", f"wheel.3.heading={heading},100", "--workers", "1", "--json").record
    first, second = record["rows"]
    assert first["position"] == own["answers"]["position"]["verdict"]
    assert first["worst_rate"] == pytest.approx(own["translation"]["worst_rate"])
    written = {**read_document(name)[0]}
    entries = one_by_one(written, load_scene(name))
    entries["wheel"][2]["heading"] = 100
    file = tmp_path / "changed.toml"
    file.write_text(toml_text(entries), encoding="utf-8")
    changed = invoke("check", str(file), "--json").record
    assert second["position"] == changed["answers"]["position"]["verdict"]
    assert second["worst_rate"] == changed["translation"]["worst_rate"]


@few(1)
@pytest.mark.parametrize("rule", ["nearest", "ellipse"])
def test_what_a_scene_says_of_all_wheels_varies_beside_one_wheel(invoke: Invoke, rule: str) -> None:
    """Wheel 1 stays where the ring has it, so that the answers are those of the ring with another friction."""
    vary = ("--vary", "mu_side=1/2,3/2", "--vary", "wheel.1.position.x=1,1")
    rows = invoke("sweep", "ring-3", "--rule", rule, *vary, "--workers", "1", "--json").record["rows"]
    ring = ns.load("ring-3")
    assert isinstance(ring, ns.Array)
    for row, side in zip(rows, ("1/2", "1/2", "3/2", "3/2"), strict=True):
        one = ring.with_(mu_side=side, rule=rule).check()
        answers = (one.position.verdict, one.heading.verdict, one.pose.verdict, one.theorem4)
        assert (row["position"], row["heading"], row["pose"], row["theorem4"]) == answers
    assert {row["pose"] for row in rows} != {rows[0]["pose"]} or rule == "ellipse"


def test_one_wheel_varies_where_speeds_have_a_unit(invoke: Invoke, tmp_path: Path) -> None:
    """The wheels that were written one by one run as fast as those of the ring."""
    ring = """
units = { length = "mm", speed = "m/s" }
friction = { mu_roll = 1, mu_side = "1/2" }
ring = { count = 4, radius = 100 }
field = { kind = "radial", speed = "1/10" }
drive = { speed_limit = "3/10" }
check = { radius = 50 }
contact = { rule = "ellipse" }
"""
    (tmp_path / "ring.toml").write_text(ring, encoding="utf-8")
    own = invoke("check", "ring.toml", "--json").record["answers"]["position"]
    vary = ("--vary", "wheel.1.position.x=100", "--workers", "1")
    (row,) = invoke("sweep", "ring.toml", *vary, "--json").record["rows"]
    assert own["rate"] == pytest.approx(row["rate"])


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_a_wheel_of_a_table_varies_on_its_own(invoke: Invoke, tmp_path: Path) -> None:
    (tmp_path / "wheels.csv").write_text("x,y,heading\n1,1,225\n-1,1,315\n-1,-1,45\n1,-1,135\n", encoding="utf-8")
    (tmp_path / "table.toml").write_text(
        'wheels = { file = "wheels.csv" }\nfriction = { mu_roll = 1, mu_side = "1/2" }\n', encoding="utf-8"
    )
    options = ("--vary", "wheel.4.heading=135,45", "--workers", "1", "--json")
    record = invoke("sweep", "table.toml", *options).record
    wheels = tmp_path / "wheels.csv"
    wheels.write_text(wheels.read_text(encoding="utf-8").replace("135", "45"), encoding="utf-8")
    changed = invoke("check", "table.toml", "--json").record
    said = ["comes home", changed["answers"]["position"]["verdict"]]
    assert said[0] != said[1]
    assert [row["position"] for row in record["rows"]] == said
    refused = invoke("sweep", "table.toml", "--vary", "wheel.5.heading=1,2")
    assert refused.status == 2
    assert "wheel.4.heading" in refused.err


def test_curves_of_lengths_name_the_unit(tmp_path: Path) -> None:
    table = 'units = { length = "mm" }\ngrid = { rows = 2, columns = 2, pitch = 200 }\n'
    wheels = 'friction = { mu_roll = 1, mu_side = 0.5 }\nfield = { kind = "radial", speed = 100 }\n'
    tolerance = 'tolerance = { heading = "1 deg" }\n'
    (tmp_path / "a.toml").write_text(table + wheels + tolerance, encoding="utf-8")
    figure = build_figure(swept(str(tmp_path / "a.toml"), {"check.radius": "30:60:2"}))
    assert "comes from within [mm]" in [axes.get_ylabel() for axes in figure.axes]
    assert figure.axes[-1].get_xlabel() == "check.radius [mm]"
    varied = {"field.speed": "mm/s", "grid.pitch": "mm", "friction.mu_side": "", "tolerance.heading": "deg"}
    base, plan = based(str(tmp_path / "a.toml"), dict.fromkeys(varied, "1,2"))
    for axis, unit in zip(plan.axes, varied.values(), strict=True):
        assert axis_label(axis, base.document) == (f"{axis.name} [{unit}]" if unit else axis.name)
