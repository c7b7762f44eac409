"""Failed wheels on every command, and tables of where bodies rest."""

from __future__ import annotations

import csv
import math
from dataclasses import replace
from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from matplotlib.patches import Circle

import nonsmooth as ns
from nonsmooth.analysis.bodies.mass_study import rule_path
from nonsmooth.analysis.bodies.sampled_tables import SampledTables, drawn_model, find_rest, nominal_model, sample_tables
from nonsmooth.analysis.trajectories.result import EndReason, Trajectory, TrajectoryError
from nonsmooth.proofs.answers.failures import stopped, without
from nonsmooth.proofs.robust.decide import decided_statement
from nonsmooth.reports.simulations.failed_paths import FailedPath, follow_failures
from nonsmooth.reports.simulations.sampled_tables import SampledTablesResult, draw_tables
from nonsmooth.reports.simulations.simulate_options import SimulateOptions
from nonsmooth.reports.studies.result import show
from nonsmooth.symbolic.files.scene_file import load_scene
from nonsmooth.symbolic.mechanics.scene import Scene
from nonsmooth.symbolic.numbers.plane import Pose
from nonsmooth.symbolic.numbers.plane_arrays import turned
from tests.oracles.measured_tables import MeasuredTable, SmallSteps
from tests.reports.conftest import Invoke
from tests.thorough import few, keep, thorough

# ---- ``simulate --fail``: paths with wheels failed, beside those of tables that are written down without them.

PLACES = ((1.0, 0.9), (-1.1, 1.0), (-0.9, -1.0), (1.0, -1.1), (0.0, 1.4))
START, UNTIL = "0.1,-0.05,0.2", "0.2"


def table(left_out: int | None = None, stopped: int | None = None, rule: str = "ellipse") -> str:
    """Five inward rims, as a scene file, without one of them or with one that stands still."""
    lines = [f'[contact]\nrule = "{rule}"\n[friction]\nmu_roll = 1\nmu_side = 0.5\n[check]\nradius = 0.25\n']
    for number, (x, y) in enumerate(PLACES, 1):
        if number != left_out:
            speed = 0 if number == stopped else 1
            lines.append(f"[[wheel]]\nposition = [{x}, {y}]\nheading = [{-x}, {-y}]\nspeed = {speed}\n")
    return "".join(lines)


def end_of(invoke: Invoke, folder: Path, text: str) -> list[float]:
    """Where a path ends, by ``simulate`` of a table as it stands."""
    (folder / "other.toml").write_text(text, encoding="utf-8")
    record = invoke("simulate", "other.toml", "--from", START, "--until", UNTIL, "--json").record
    end: list[float] = record["end"]["state"]
    return end


@pytest.mark.parametrize("rule", ["ellipse", *keep(0, ["box", "nearest"])])
def test_every_path_is_that_of_the_table_without_the_wheel(invoke: Invoke, tmp_path: Path, rule: str) -> None:
    (tmp_path / "table.toml").write_text(table(rule=rule), encoding="utf-8")
    found = invoke("simulate", "table.toml", "--from", START, "--until", UNTIL, "--fail", "any", "--json").record
    whole, *rows = found["rows"]
    assert whole["end"] == pytest.approx(end_of(invoke, tmp_path, table(rule=rule)), abs=1e-9)
    assert [(row["wheels"], row["kind"]) for row in rows] == [
        ([w], k) for w in range(1, 6) for k in ("stopped", "lifted")
    ]
    compared = 0
    for row in rows:
        (wheel,) = row["wheels"]
        text = table(stopped=wheel, rule=rule) if row["kind"] == "stopped" else table(left_out=wheel, rule=rule)
        if row["end"] is None:
            continue
        end = end_of(invoke, tmp_path, text)
        assert row["end"] == pytest.approx(end, abs=1e-9)
        assert row["moved"] == pytest.approx(math.dist(end[:2], whole["end"][:2]), abs=1e-9)
        assert row["turned"] == pytest.approx(end[2] - whole["end"][2], abs=1e-9)
        compared += 1
    assert compared >= 8


def test_small_steps_end_where_failed_tables_do(tmp_path: Path) -> None:
    """Bodies on a measured table with one wheel stopped or lifted, followed by the words of the rule alone."""
    table = MeasuredTable.random(4, "ellipse", off=6.0)
    (tmp_path / "table.toml").write_text(f"check = {{ radius = 40 }}\n{table.toml}", encoding="utf-8")
    scene = load_scene(tmp_path / "table.toml")
    found = follow_failures(scene, SimulateOptions(start="15,-10,0", until=0.25, fail="1"))
    x, y, heading, _ = table.rows[0]
    failed = [((x, y, heading, 0.0), *table.rows[1:]), table.rows[1:]]
    for path, rows in zip((*found.whole, *found.paths), [table.rows, *failed], strict=True):
        end, _ = SmallSteps(replace(table, rows=rows)).end(np.array([15.0, -10.0]), 0.25, 0.05)
        assert path.end is not None
        assert end == pytest.approx(path.end[:2], abs=0.01)


def test_a_body_that_may_go_on_is_not_home(tmp_path: Path, invoke: Invoke) -> None:
    """Without wheel 7 the point is unstable: small steps pass it and leave the square, the path drawn rests there."""
    table = MeasuredTable.random(5, "nearest", off=6.0)
    (tmp_path / "table.toml").write_text(f"check = {{ radius = 40 }}\n{table.toml}", encoding="utf-8")
    rows = tuple(row for number, row in enumerate(table.rows, 1) if number != 7)
    end, _ = SmallSteps(replace(table, rows=rows)).end(np.array([30.0, -20.0]), 1.0, 0.05)
    assert np.hypot(*end) > 40
    command = ("simulate", "table.toml", "--from", "30,-20,0", "--until", "1", "--fail", "7")
    found = invoke(*command, "--json").record["rows"]
    assert [row["home"] for row in found] == [True, True, False]
    said = invoke(*command).out
    assert "not unique" in said
    assert "of 1 of 2 paths it is not known where bodies end" in " ".join(said.split())


def test_a_lifted_wheel_leaves_a_smaller_square(tmp_path: Path) -> None:
    """The hull of the other wheels does not hold the checked square, of 40 mm: paths in what it holds are followed."""
    table = MeasuredTable.random(1, "box", off=6.0)
    (tmp_path / "table.toml").write_text(f"check = {{ radius = 40 }}\n{table.toml}", encoding="utf-8")
    found = follow_failures(load_scene(tmp_path / "table.toml"), SimulateOptions(start="30,-20,0", until=2.0, fail="4"))
    lifted_one = found.paths[1]
    assert lifted_one.end == pytest.approx((30, -20, 0), abs=1e-9)  # it rests where it is put down, as on all wheels


def test_wheels_that_never_carry_change_no_path() -> None:
    """The path of the table is taken for theirs; that of a wheel under the body is not."""
    scene = load_scene("carton-on-6x6", rule="ellipse")
    start, until = (0.15, 0.1, 0.08), 0.02
    far = follow_failures(scene, SimulateOptions(start="0.15,0.1,0.08", until=until, fail="1"))
    whole = far.whole[0].path
    assert whole is not None
    assert [one.path for one in far.paths] == [whole] * 2
    for array in (stopped(scene, (1,)), without(scene, (1,))):
        assert rule_path(array, "ellipse", start, until).end.state == whole.end.state
    near = follow_failures(scene, SimulateOptions(start="0.15,0.1,0.08", until=until, fail="22"))
    other = near.paths[0].path
    assert other is not None
    assert other.end.state != whole.end.state


def test_a_path_that_is_broken_off_says_nothing_of_where_it_ends(tmp_path: Path) -> None:
    """Of four paths of one wheel one ends too soon, in reach of the point or not: neither home nor lost."""
    (tmp_path / "table.toml").write_text(table(), encoding="utf-8")
    options = SimulateOptions(grid=2, until=0.2, fail="5")
    found = follow_failures(load_scene(tmp_path / "table.toml"), options)
    first, *others = found.paths
    assert first.path is not None
    broken = replace(first.path, end=replace(first.path.end, reason=EndReason.STEPS))
    cut = replace(found, paths=(replace(first, path=broken, near=False), *others))
    failed = cut.failures[0]
    assert (cut.unknown(failed), found.unknown(failed)) == (1, 0)
    assert cut.lost(failed) == found.lost(failed) - (found.whole[0].home and not first.home)
    assert cut.paths[0].end is None
    assert cut.facts()["failures"][0]["not_known"] == 1


@pytest.mark.parametrize("reason", [EndReason.STEPS, EndReason.EVENTS, EndReason.UNPROVED])
def test_a_path_that_is_broken_off_is_shown_as_far_as_it_goes(
    tmp_path: Path, reason: EndReason, capsys: pytest.CaptureFixture[str]
) -> None:
    """Nothing is counted of it: the words said that none comes home, and which wheel moves the end farthest."""
    (tmp_path / "table.toml").write_text(table(), encoding="utf-8")
    found = follow_failures(load_scene(tmp_path / "table.toml"), SimulateOptions(start=START, until=0.2, fail="5"))

    def cut(one: FailedPath) -> FailedPath:
        assert one.path is not None
        return replace(one, path=replace(one.path, end=replace(one.path.end, reason=reason)), near=False)

    broken = replace(found, whole=tuple(map(cut, found.whole)), paths=tuple(map(cut, found.paths)))
    show(broken, None, json=False)
    said = " ".join(capsys.readouterr().out.split())
    assert "all wheels: followed until t = 0.2, (0.0" in said
    assert "wheel 5 lifted: followed until t = 0.2, (0.0" in said
    assert str(reason) in said
    assert "with all wheels it is not known whether the body comes home" in said
    assert "moves the end farthest" not in said
    assert [path.end for path in (*broken.whole, *broken.paths)] == [None] * 3


def test_what_no_longer_comes_home_is_counted(invoke: Invoke, tmp_path: Path) -> None:
    command = ("simulate", "four-wheel", "--grid", "2", "--fail", "any")
    record = invoke(*command, "--json", "-o", "failed.csv").record
    assert record["home"] == 4
    homes = [row["home"] for row in record["rows"]]
    assert homes[:4] == [True] * 4
    for number, failure in enumerate(record["failures"]):
        own = record["rows"][4 * (number + 1) : 4 * (number + 2)]
        assert failure["no_longer_home"] == sum(not row["home"] for row in own)
        assert failure["kind"] == own[0]["kind"]
    out = invoke(*command).out
    assert "4 of 4 starts come home with all wheels" in out
    assert "the worst: wheel" in out
    nowhere = invoke("simulate", "four-wheel", "--from", "0.2,0.4,0", "--until", "0.01", "--fail", "1").out
    assert "with all wheels the body does not come home; wheel 1 stopped moves the end" in nowhere
    assert "the worst" not in nowhere
    one = " ".join(invoke("simulate", "four-wheel", "--from", "0.2,0.4,0", "--fail", "1").out.split())
    assert "the worst: wheel 1 lifted: the body no longer comes home; wheel 1 stopped moves an end farthest" in one
    with (tmp_path / "failed.csv").open(encoding="utf-8", newline="") as file:
        assert len(list(csv.DictReader(file))) == 4 * 9
    assert invoke(*command, "-o", "failed.svg").status == 0
    picture = (tmp_path / "failed.svg").read_text(encoding="utf-8")
    assert all(
        words in picture for words in ("wheel 1 stopped", "wheel 4 lifted", "start", "end", "tips", "checked square")
    )
    assert "other failures" not in picture  # all eight are named


def test_one_start_that_is_not_followed_spoils_no_others(monkeypatch: pytest.MonkeyPatch, invoke: Invoke) -> None:
    def followed(scene: Scene, rule: str, start: Pose, until: float) -> Trajectory:
        if (start[0] < 0 and start[1] < 0) or (start[0] == 0.3 and scene.wheels[0].speed == 0):
            raise TrajectoryError("required a certified motion, received none")
        return rule_path(scene, rule, start, until)

    monkeypatch.setattr("nonsmooth.reports.simulations.failed_paths.rule_path", followed)
    shown = invoke("simulate", "four-wheel", "--grid", "2", "--fail", "1")
    assert "3 of 4 starts come home with all wheels; of 1 that is not known" in shown.out
    assert invoke("simulate", "four-wheel", "--from=-0.1,-0.1,0", "--fail", "1").status == 2
    lines = invoke("simulate", "four-wheel", "--from", "0.3,0.1,0", "--fail", "1").out.splitlines()
    assert "wheel 1 stopped: not followed: required a certified motion, received none" in lines


def test_a_body_tips_where_a_check_says_so(invoke: Invoke) -> None:
    """At the middle of four wheels every lifted one leaves the centre of mass on the edge of the others."""
    rows = invoke("simulate", "four-wheel", "--from", "0.2,0.1,0", "--fail", "any", "--json").record["rows"]
    assert all(row["end"] is None and not row["home"] for row in rows if row["kind"] == "lifted")
    assert {row["kind"] for row in rows if row["end"] is not None} == {None, "stopped"}


@pytest.mark.parametrize("body", ["", 'body = { shape = "disc", radius = 1.4 }\n'])
@pytest.mark.parametrize("wheels", ["1,2,3,4", "1,2,3"])
def test_a_body_tips_on_too_few_wheels(invoke: Invoke, tmp_path: Path, body: str, wheels: str) -> None:
    (tmp_path / "few.toml").write_text(f"friction = {{ mu_roll = 1, mu_side = 0.4 }}\nring = {{ count = 4 }}\n{body}")
    shown = invoke("simulate", str(tmp_path / "few.toml"), "--from", "0.1,0,0", "--fail", wheels)
    assert any("lifted" in line and "tips" in line for line in shown.out.splitlines())
    assert "not followed" not in shown.out


def test_wheels_fail_together() -> None:
    found = ns.load("four-wheel").simulate((0.2, 0.1, 0.0), fail="1,2").to_dict()
    assert [failure["wheels"] for failure in found["failures"]] == [[1, 2], [1, 2]]


def test_wheels_with_names_fail_by_their_numbers_too(tmp_path: Path) -> None:
    """A name that is another wheel's number stands for the wheel of that name."""
    head = (
        'units = { length = "mm", speed = "m/s" }\nfriction = { mu_roll = 1, mu_side = 1 }\ncheck = { radius = 20 }\n'
    )
    rows = [("A", 100, 100), ("3", -100, 100), ("C", -100, -100), ("D", 100, -100)]
    wheels = [f'{{ name = "{n}", position = [{x}, {y}], heading = [{-x}, {-y}], speed = "1/10" }}' for n, x, y in rows]
    (tmp_path / "named.toml").write_text(f"{head}wheel = [{', '.join(wheels)}]\n", encoding="utf-8")
    scene = load_scene(tmp_path / "named.toml")

    def failing(text: str) -> list[tuple[str, ...]]:
        found = follow_failures(scene, SimulateOptions(start="5,2,0", until=0.1, fail=text))
        return [tuple(map(str, failed.wheels)) for failed in found.failures]

    assert failing("1,4") == failing("A,D") == [("A", "D")] * 2
    assert failing("3") == failing("2") == [("3",)] * 2


# ---- ``--fail 1`` on check and sweep -------------------------------------------------------------


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_check_lists_failures_and_names_the_worst(invoke: Invoke) -> None:
    done = invoke("check", "four-wheel", "--fail", "1")
    assert done.status == 0
    out = " ".join(done.out.split("with any one wheel")[1].split())
    assert "the worst: wheels 1-4 lifted: position tips, heading undecided, pose undecided (by what is proved: " in out
    assert out.count("stays near") == 1  # one line for all that answer alike
    assert "wheels 1-4 stopped: a law may need the wheel that is stopped" in out
    shown = invoke("check", "four-wheel", "--fail", "1", "--evidence").out.split("with any one wheel")[1]
    assert shown.count("stays near") == 4
    record = invoke("check", "four-wheel", "--fail", "any", "--json").record
    assert len(record["failures"]) == 8
    assert [failure["wheel"] for failure in record["failures"] if failure["worst"]] == [1]
    assert invoke("check", "four-wheel", "--json").record["failures"] is None


@thorough  # the small one: test_check_lists_failures_and_names_the_worst
def test_every_rule_has_its_own_failures(invoke: Invoke) -> None:
    checks = invoke("check", "four-wheel", "--rule", "all", "--fail", "1", "--json").record["checks"]
    assert [len(check["failures"]) for check in checks] == [8] * 4


def test_a_sweep_has_the_failures_of_every_scene(invoke: Invoke) -> None:
    command = ("sweep", "four-wheel", "--vary", "mu_side=1/2,2", "--fail", "1", "--workers", "1")
    rows = invoke(*command, "--json").record["rows"]
    one = invoke("check", "four-wheel", "--fail", "1", "--json").record
    assert rows[0]["failures"] == one["failures"]
    out = invoke(*command).out
    assert "worst failure" in out
    assert out.count("tips") == 2


# ---- ``simulate --tables``: places of rest against bodies that are followed to their ends by small steps.

TABLE = """
name = "table"
units = { length = "mm", speed = "m/s" }
friction = { mu_roll = 0.8, mu_side = 0.6 }
contact = { rule = "RULE" }
grid = { rows = 2, columns = 3, pitch = 100 }
field = { kind = "radial", speed = 0.1 }
tolerance = { position = 1, heading = "1 deg", mu_roll = "15/100", mu_side = "15/100" }
"""
OF_TWO = (("heading", np.nan), ("mu_roll", 1.0))  # tolerances: of the first no end is found


@pytest.fixture
def toleranced(tmp_path: Path) -> Path:
    file = tmp_path / "table.toml"
    file.write_text(TABLE.replace("RULE", "ellipse"), encoding="utf-8")
    return file


def scene_of(file: Path) -> Scene:
    return load_scene(str(file))


@few(1)
@pytest.mark.parametrize("rule", ["ellipse", "roller"])
def test_small_steps_end_where_the_sample_says(tmp_path: Path, rule: str) -> None:
    """Bodies on the same drawn tables, followed by the words of the rule alone, come to their places of rest."""
    nominal = MeasuredTable.random(2, rule, off=4.0)
    allowed = 'tolerance = { position = 1, heading = "1 deg", speed = 0.01, mu_roll = 0.15, mu_side = 0.15 }\n'
    (tmp_path / "table.toml").write_text(f"check = {{ radius = 40 }}\n{allowed}{nominal.toml}", encoding="utf-8")
    scene = scene_of(tmp_path / "table.toml")
    assert scene.tolerances is not None
    found, generator = sample_tables(scene, 2, 7), np.random.default_rng(7)
    for place in found.places:
        model = drawn_model(scene, scene.tolerances, generator)
        headings = np.degrees(np.arctan2(model.rims[:, 1], model.rims[:, 0]))
        rows = tuple(zip(*model.positions.T, headings, model.speeds, strict=True))
        roll, side = model.friction.reshape(-1, 2).T
        end, _ = SmallSteps(MeasuredTable(rows, roll, side * model.cuts, rule)).end(np.array([8.0, -6.0]), 8.0, 0.05)
        assert end == pytest.approx(place, abs=0.01)


def test_wheels_beside_the_body_carry_nothing(tmp_path: Path) -> None:
    """Two wheels that a body with an outline does not cover move no end, whatever their tolerances."""
    body = 'body = { shape = "rectangle", width = 230, height = 130, mass = 1 }\n'
    text = TABLE.replace("RULE", "ellipse").replace("columns = 3", "columns = 2")
    beside = text.replace("columns = 2", "columns = 4") + body
    found = []
    for name, table_text in (("four", text), ("eight", beside)):
        (tmp_path / f"{name}.toml").write_text(table_text.replace("grid =", "check = { radius = 10 }\ngrid ="))
        found.append(sample_tables(scene_of(tmp_path / f"{name}.toml"), 3, 5))
    assert found[1].places == pytest.approx(found[0].places, abs=1e-9)


def test_draws_stay_within_their_tolerances(toleranced: Path) -> None:
    scene = scene_of(toleranced)
    assert scene.tolerances is not None
    drawn, generator = nominal_model(scene), np.random.default_rng(1)
    models = [drawn_model(scene, scene.tolerances, generator) for _ in range(50)]
    positions = np.abs([model.positions - drawn.positions for model in models])
    across = turned(drawn.rims)
    turns = np.abs([(across * model.rims).sum(axis=1) for model in models])
    shares = np.abs([model.friction / drawn.friction - 1 for model in models])
    for values, bound in ((positions, 1.0), (turns, np.sin(np.pi / 180)), (shares, 0.15)):
        assert 0.9 * bound < values.max() <= bound * (1 + 1e-12)
    assert all((model.speeds == pytest.approx(drawn.speeds)) for model in models)
    slips = [model.slips(np.zeros(3))[:, 1] for model in models]  # the surface moves along the rim, wherever it points
    assert np.abs(slips).max() < 1e-9


def test_the_sample_lies_within_what_is_certified(toleranced: Path) -> None:
    scene = scene_of(toleranced)
    assert scene.tolerances is not None
    small = replace(scene, tolerances=scene.tolerances.times(Fraction(1, 8)))
    proved = decided_statement(small)
    radius = proved.equilibrium or proved.radius
    assert radius is not None
    assert sample_tables(small, 40, 3).within(1.0) <= float(radius)


def test_the_number_says_which_share_ends_within_it() -> None:
    places = np.array([[float(k), 0.0] for k in range(1, 20)] + [[np.nan, np.nan]])
    found = SampledTables(("heading",), places, np.zeros(2), np.zeros(2))
    assert (found.missing, found.within(0.95), found.within(0.5)) == (1, 19.0, 10.0)
    assert found.within(1.0) == np.inf


def test_a_table_that_carries_bodies_away_has_no_place_of_rest(toleranced: Path) -> None:
    toleranced.write_text(toleranced.read_text().replace('"radial", speed', '"expression", x = "x", y = "y", speed'))
    model = nominal_model(scene_of(toleranced))
    assert find_rest(model, np.array([0.1, 0.1]), 100.0) is None


def test_the_command_says_what_binds(toleranced: Path, invoke: Invoke) -> None:
    command = ("simulate", str(toleranced), "--tables", "3", "--seed", "3")
    record = invoke(*command, "--json").record
    assert (record["status"], record["tables"], record["certified"]) == ("sampled", 3, None)
    alone = {part["drawn"][0]: part["moved"] for part in record["parts"] if len(part["drawn"]) == 1}
    assert max(alone, key=lambda name: alone[name]) == record["binding"]
    shown = " ".join(invoke(*command).out.split())
    assert f"95 % of 3 tables end within {record['within']:.3g} mm (sampled, seed 3)" in shown
    assert "certified: not asked for (--certified)" in shown
    assert "(sampled ends; what binds the certified bound, and may be another, check says)" in shown
    near = sum(math.hypot(x, y) <= record["accuracy"] for x, y in record["rows"])  # of the checked point (0, 0)
    assert record["near"] == near
    assert f"{near} of 3 within the accuracy, {record['accuracy']:.3g} mm" in shown
    assert invoke(*command, "--json").record == record


def test_nothing_binds_where_ends_are_not_found(toleranced: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """``not known: mm``, and the first of the tolerances whose ends are not known was said to bind."""
    lost, kept = (SampledTables((name,), np.full((4, 2), x), np.zeros(2), np.zeros(2)) for name, x in OF_TWO)
    found = SampledTablesResult(scene_of(toleranced), 1, lost, (), (kept, lost), None)
    assert found.facts()["binding"] is None
    assert found.summary().startswith("of 4 of 4 tables no place of rest that attracts was found (sampled, seed 1); 0")
    labels = found.figure().axes[0].get_legend_handles_labels()[1]
    assert labels[0] == "ends of 0 of 4 (sampled)"
    found.to_terminal()
    shown = capsys.readouterr().out
    assert "which tolerance binds is not known" in shown
    assert "not known: mm" not in shown


def test_the_picture_draws_the_accuracy_and_its_legend_below(toleranced: Path) -> None:
    found = draw_tables(scene_of(toleranced), SimulateOptions(tables=4))
    figure = found.figure()
    assert [len(figure.legends), figure.axes[0].get_legend()] == [1, None]
    radii = [circle.get_radius() for circle in figure.axes[0].patches if isinstance(circle, Circle)]
    assert radii == [found.all.within(0.95), found.accuracy]
