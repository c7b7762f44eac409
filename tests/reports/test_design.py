"""``nonsmooth design``: what is found is confirmed by a check of the file, keeps its symmetry, and is repeatable."""

from __future__ import annotations

import math
import tomllib
from decimal import Decimal
from fractions import Fraction
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import nonsmooth as ns
from nonsmooth.proofs.answers.answer import Answer, Position
from nonsmooth.proofs.findings import Fact, Quantity
from nonsmooth.reports.designs.design import DesignError, DesignResult, read_freedom
from nonsmooth.reports.designs.freedom import Freedom, largest_symmetry, orbits_of
from nonsmooth.reports.designs.search import OBJECTIVES
from nonsmooth.reports.output.entries import toml_text
from nonsmooth.symbolic.files.documents import read_document
from nonsmooth.symbolic.files.scene_file import build_scene, load_scene
from nonsmooth.symbolic.mechanics.scene import Wheel
from tests.oracles.measured_tables import MeasuredTable
from tests.reports.conftest import Invoke
from tests.thorough import keep, thorough


@pytest.mark.parametrize("checks", keep(1, [4, 40]))
def test_a_saddle_becomes_an_array_that_brings_bodies_home(invoke: Invoke, tmp_path: Path, checks: int) -> None:
    """The file alone says the same to a check, and bodies of its paths come home."""
    outcome = invoke("design", "saddle", "--checks", str(checks), "-o", "found.toml", "--json")
    assert outcome.status == 0
    record = outcome.record
    assert record["given"]["answers"]["position"]["verdict"] == "leaves"
    assert record["best"]["answers"]["position"]["verdict"] == "comes home"
    array = ns.load(tmp_path / "found.toml")
    assert isinstance(array, ns.Array)
    assert array.check().position.verdict == "comes home"
    for start in ((0.3, 0.1, 0.0), (-0.2, 0.25, 1.0)):
        end = array.simulate(start, 10 / record["best"]["value"]).state[-1]
        assert np.hypot(*end[:2]) < 1e-6


def test_a_table_that_was_measured_meets_the_requirement_where_bodies_come_near(invoke: Invoke, tmp_path: Path) -> None:
    """Its rate is the part of the way that is certified over the time that it takes."""
    (tmp_path / "table.toml").write_text(MeasuredTable.random(1, "nearest").toml, encoding="utf-8")
    record = invoke("design", "table.toml", "--free", "speeds", "--checks", "2", "--json").record
    position = record["given"]["answers"]["position"]
    assert (record["given"]["unmet"], position["verdict"]) == ([], "comes near")
    way = position["within"] - position["ends_within"]
    assert record["given"]["value"] == pytest.approx(way / position["after"], rel=1e-12)
    assert record["best"]["value"] >= record["given"]["value"]


@thorough  # the small one: test_a_saddle_becomes_an_array_that_brings_bodies_home
def test_a_design_is_no_worse_and_repeatable(invoke: Invoke) -> None:
    arguments = ("design", "rectangle", "--free", "headings,speeds", "--checks", "6", "--json")
    first, again = (invoke(*arguments).record for _ in range(2))
    assert first == again
    assert first["checks"] == 6
    assert first["best"]["value"] >= first["given"]["value"]
    ones = [invoke("design", "saddle", "--checks", "6", "--json", "--seed", seed).record for seed in "12"]
    assert ones[0]["best"] != ones[1]["best"]


@pytest.mark.parametrize(("name", "order"), [("four-wheel", 4), ("rectangle", 2), ("ring-5", 1), ("ring-6", 2)])
def test_the_symmetry_is_kept_exactly(name: str, order: int) -> None:
    document, label, path = read_document(name)
    scene = build_scene(document, label, path)
    assert largest_symmetry(scene) == order
    freedom = Freedom(("headings", "speeds", "positions"), order=order)
    orbits = orbits_of(scene, order)
    assert orbits is not None
    vector = np.random.default_rng(3).random(freedom.numbers_per_wheel * len(orbits)).tolist()
    changed = build_scene(freedom.document(document, scene, vector), label, path)
    assert orbits_of(changed, order) is not None
    turn = 2 * np.pi / order
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    for orbit in orbits:
        for one, following in pairwise(orbit):
            first, second = changed.wheels[one], changed.wheels[following]
            for a, b in ((first.position, second.position), (first.unit_direction, second.unit_direction)):
                assert np.allclose(rotation @ [float(x) for x in a], [float(x) for x in b])
            assert first.speed == second.speed


@pytest.mark.parametrize("move", ["1/8", "0.125", 0.125, Fraction(1, 8), Decimal("0.125")])
def test_the_distance_that_wheels_may_move_is_any_rational_number(move: Any) -> None:
    """A fraction as typed, and numbers of Python."""
    scene = load_scene("four-wheel")
    assert read_freedom(scene, "positions", move, None).move == Fraction(1, 8)
    for none in ("0", "-1/8", "pi/4", "sqrt(2)", "far", math.nan):
        with pytest.raises(DesignError, match=r"^move: required a positive rational number such as 1/10, received"):
            read_freedom(scene, "positions", none, None)


def test_every_wheel_of_an_orbit_keeps_its_own_limit() -> None:
    document, label, path = read_document("four-wheel")
    document["wheel"] = [dict(entry) for entry in document["wheel"]]
    document["wheel"][2]["speed_limit"] = 3
    scene = build_scene(document, label, path)
    freedom = Freedom(("headings",), order=4)
    changed = build_scene(freedom.document(document, scene, [0.6]), label, path)
    assert [None if w.speed_limit is None else float(w.speed_limit) for w in changed.wheels] == [None, None, 3, None]


def test_every_wheel_of_an_orbit_keeps_its_name_and_its_axis() -> None:
    """Two wheels of one name would be refused, and rollers would turn about other axes than those that are stated."""
    document, label, path = read_document("four-wheel")
    document["wheel"] = [entry | {"name": name} for entry, name in zip(document["wheel"], "ABCD", strict=True)]
    document["wheel"][1]["axis"] = [1, 0]
    scene = build_scene(document, label, path)
    freedom = Freedom(("headings",), order=4)
    changed = build_scene(freedom.document(document, scene, [0.6]), label, path)
    assert [str(wheel.index) for wheel in changed.wheels] == list("ABCD")
    assert [wheel.axis and [float(x) for x in wheel.axis] for wheel in changed.wheels] == [None, [1, 0], None, None]


def test_headings_that_are_not_free_stay_as_they_are() -> None:
    document, label, path = read_document("four-wheel")
    document["wheel"] = [entry | {"heading": f"{40 * k} deg"} for k, entry in enumerate(document["wheel"])]
    scene = build_scene(document, label, path)
    for kinds in (("speeds",), ("positions",)):
        freedom = Freedom(kinds, order=4)
        vector = [0.6] * freedom.numbers_per_wheel
        changed = build_scene(freedom.document(document, scene, vector), label, path)
        own, found = ([[float(x) for x in wheel.unit_direction] for wheel in one.wheels] for one in (scene, changed))
        assert np.allclose(own, found, rtol=0, atol=1e-12), kinds


def test_the_start_is_the_scene_itself() -> None:
    document, label, path = read_document("rectangle")
    scene = build_scene(document, label, path)
    freedom = Freedom(("headings", "speeds", "positions"), slowest=Fraction(1, 2), fastest=Fraction(3, 2), order=2)
    same = build_scene(freedom.document(document, scene, freedom.start(scene)), label, path)
    for own, found in zip(scene.wheels, same.wheels, strict=True):
        for a, b in ((own.position, found.position), (own.direction, found.direction)):
            assert [str(x) for x in a] == [str(x) for x in b]
        assert str(own.speed) == str(found.speed)


def test_all_wheels_change_alike_along_each_line() -> None:
    """A ring becomes a larger ring, every wheel turns by one angle, and every speed is multiplied by one number."""
    document, label, path = read_document("ring-6")
    scene = build_scene(document, label, path)
    freedom = Freedom(("headings", "speeds", "positions"), order=2)
    turn, fast, outward, along_x, along_y = (np.array(line) for line in freedom.together(scene))
    start = np.array(freedom.start(scene))

    def changed(line: np.ndarray) -> list[Wheel]:
        vector = (start + line / 4).tolist()
        return list(build_scene(freedom.document(document, scene, vector), label, path).wheels)

    angles = [angle_of(new) - angle_of(own) for new, own in zip(changed(turn), scene.wheels, strict=True)]
    assert np.allclose(np.cos(angles), np.cos(np.pi / 4), atol=0.02)
    ratios = [float(new.speed) / float(own.speed) for new, own in zip(changed(fast), scene.wheels, strict=True)]
    assert min(ratios) == max(ratios) > 1
    radii = [far(wheel) for wheel in changed(outward)]
    assert np.allclose(radii, radii[0], atol=0.01)
    assert radii[0] > far(scene.wheels[0]) + 0.05
    for new, own in zip(changed(along_x), scene.wheels, strict=True):
        assert float(new.position[1]) == float(own.position[1])
    for new, own in zip(changed(along_y), scene.wheels, strict=True):
        assert float(new.position[0]) == float(own.position[0])


def far(wheel: Wheel) -> float:
    return float(np.hypot(float(wheel.position[0]), float(wheel.position[1])))


def angle_of(wheel: Wheel) -> float:
    return float(np.arctan2(float(wheel.direction[1]), float(wheel.direction[0])))


@pytest.mark.parametrize(
    "loads",
    [
        "[[0.25, 0.25, 0.25], [0.25, -0.25, 0.25], [0.25, -0.25, -0.25], [0.25, 0.25, -0.25]]",
        '{ kind = "measured", values = [1, 1, 1, 1] }',
    ],
)
def test_wheels_are_not_chosen_where_loads_are_stated_for_all_of_them(
    invoke: Invoke, tmp_path: Path, loads: str
) -> None:
    """What some of them would carry is not known, and the file itself is right."""
    document, _, _ = read_document("four-wheel")
    text = toml_text({key: value for key, value in document.items() if key != "contact"})
    (tmp_path / "stated.toml").write_text(f'{text}\n[contact]\nrule = "box"\nloads = {loads}\n', encoding="utf-8")
    outcome = invoke("design", "stated.toml", "--free", "wheels", "--symmetry", "1", "-o", "few.toml")
    assert (outcome.status, outcome.out) == (2, "")
    expected = "--free: required loads that some of the wheels have too, received loads stated for all wheels"
    assert outcome.err == f"nonsmooth: {expected}\n"
    assert invoke("design", "stated.toml", "--free", "speeds", "--checks", "1").status < 2


@thorough  # the small one: test_a_saddle_becomes_an_array_that_brings_bodies_home
def test_python_finds_what_the_command_finds(invoke: Invoke, tmp_path: Path) -> None:
    saddle = ns.load("saddle")
    assert isinstance(saddle, ns.Array)
    found = saddle.design(checks=20)
    assert found.to_dict() == invoke("design", "saddle", "--checks", "20", "--json").record
    assert (found.is_found, found.unmet, found.impossible, found.given_value) == (True, (), "", None)
    assert "comes home" in repr(found)
    assert len(repr(found).splitlines()) <= 12
    assert found.save(tmp_path / "found.toml").exists()
    again, own = ns.load(tmp_path / "found.toml"), found.array
    assert isinstance(again, ns.Array)
    assert isinstance(own, ns.Array)
    assert str(again.check().position) == str(own.check().position)
    with pytest.raises(
        ValueError, match=r"^free: required names among headings, speeds, positions, wheels, received 'colour'"
    ):
        saddle.design(free="colour")
    with pytest.raises(ns.SceneError, match=r"required a .tolerance. table"):
        saddle.design(maximize="tolerance")


def test_documents_are_read_again_as_they_were_written() -> None:
    document = {
        "name": 'a "quoted" \\ name',
        "friction": {"mu_roll": 1, "mu_side": Decimal("0.5")},
        "contact": {"loads": {"kind": "elastic", "height": "1/10"}},
        "wheel": [{"position": ["1", "sqrt(2)"], "heading": [1, 0]}, {"position": [0, 1], "speed": "1/3"}],
    }
    assert tomllib.loads(toml_text(document), parse_float=Decimal) == document
    with pytest.raises(TypeError, match="required a string"):
        toml_text({"name": object()})


def test_every_built_in_scene_survives_being_written(tmp_path: Path) -> None:
    for name in ("ring-5", "spiral-30", "mecanum-4", "off-center"):
        document, label, path = read_document(name)
        scene = build_scene(document, label, path)
        freedom = Freedom(("headings",))
        file = tmp_path / f"{name}.toml"
        file.write_text(toml_text(freedom.document(document, scene, freedom.start(scene))), encoding="utf-8")
        again = load_scene(file)
        for own, found in zip(scene.wheels, again.wheels, strict=True):
            assert str(own.speed) == str(found.speed)
            assert np.allclose([float(x) for x in own.position], [float(x) for x in found.position])


def test_the_fewest_wheels_are_too_few_without_any_one(invoke: Invoke, tmp_path: Path) -> None:
    """Every wheel that is left is needed, by checks of their own; all smaller choices were refuted."""
    options = ("--free", "wheels", "--symmetry", "1", "--checks", "40", "-o", "few.toml", "--json")
    record = invoke("design", "carton-on-6x6", *options).record
    fewest = record["fewest"]
    assert (fewest["all_checked"], fewest["undecided"], fewest["order"]) == (True, 0, 1)
    document = tomllib.loads((tmp_path / "few.toml").read_text(encoding="utf-8"), parse_float=Decimal)
    wheels = document["wheel"]
    assert len(wheels) == fewest["count"]
    assert invoke("check", "few.toml", "--require", "position", "--json").status == 0
    for k in range(len(wheels)):
        file = tmp_path / f"without-{k}.toml"
        file.write_text(toml_text({**document, "wheel": wheels[:k] + wheels[k + 1 :]}), encoding="utf-8")
        assert invoke("check", str(file), "--require", "position", "--json").status in (1, 2)


@pytest.mark.parametrize(
    ("given", "best", "improved", "words"),
    [
        (0.5, 0.5, False, "nothing is improved: "),
        (0.5, 0.5 + 1e-9, False, "nothing is improved: "),
        (0.5, 0.50004, True, "improved, but hardly: radius of the disc whence bodies come home: 0.5 -> 0.50004 (0.008"),
        (49.78, 99.56, True, "improved: radius of the disc whence bodies come home: 49.78 -> 99.56 (100 % more)"),
        (0.0, 2.0, True, "improved: radius of the disc whence bodies come home: 0 -> 2"),
        (None, 2.0, True, "improved: radius of the disc whence bodies come home is not known of the given array"),
        (2.0, None, None, "whether that is better than the given array is not known"),
    ],
)
def test_how_much_is_improved_is_said_by_both_values(
    given: float | None, best: float | None, improved: bool | None, words: str
) -> None:
    def evaluated(value: float | None) -> SimpleNamespace:
        return SimpleNamespace(value=value, unmet=(), why_not="")

    found = SimpleNamespace(is_found=True, base=evaluated(given), best=evaluated(best), fewest=None)
    found = SimpleNamespace(**vars(found), impossible="", checks=2, scene=SimpleNamespace(name="table"))
    wish = SimpleNamespace(maximize="basin", required=("position",))
    result: DesignResult[None] = DesignResult(cast("Any", found), cast("Any", wish))
    assert result.improved is improved
    assert result.summary().startswith(f"table: {words}")


@pytest.mark.parametrize(
    ("verdict", "basin"), [(Position.COMES_HOME, 0.25), (Position.COMES_NEAR, 0.25), (Position.STAYS_NEAR, None)]
)
def test_a_disc_of_bodies_that_turn_beside_the_point_is_no_basin(verdict: Position, basin: float | None) -> None:
    """Where only the pose is required, a body may circle beside the point within a disc that is certified, too."""
    position = Answer("position", verdict, (Fact("within", Quantity(Fraction(1, 4))),))
    assert OBJECTIVES["basin"](cast("Any", None), (position,)) == basin


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_rates_of_unlike_units_are_not_compared() -> None:
    """Under rollers the spiral brings bodies near by a certain time; better headings bring them home exponentially."""
    spiral = ns.load("spiral-30")
    assert isinstance(spiral, ns.Array)
    found = spiral.with_(rule="roller").design(maximize="rate", checks=3)
    record = found.to_dict()
    near, home = (record[name]["answers"]["position"] for name in ("given", "best"))
    assert (near["verdict"], home["verdict"]) == ("comes near", "comes home")
    assert record["given"]["value"] == pytest.approx((near["within"] - near["ends_within"]) / near["after"])
    assert record["best"]["value"] == home["rate"]
    assert record["improved"] is None
    shown = str(found.blocks()[0])
    assert "length per time of that and" in shown
    assert "% more" not in shown


@pytest.mark.usefixtures("without_paths", "without_other_rules")
def test_bodies_with_inertia_settle_sooner(invoke: Invoke, tmp_path: Path) -> None:
    """The value is that of the simulation of a check of the same array; without units there is none."""
    (tmp_path / "table.toml").write_text(HEAVY, encoding="utf-8")
    array = ns.load(tmp_path / "table.toml")
    assert isinstance(array, ns.Array)
    found = array.design(maximize="settling", checks=1)
    after = array.check().to_dict()["answers"]["position"]["inertia"]["settles_after"]
    assert found.to_dict()["given"]["value"] == pytest.approx(1 / after)
    assert " deg" in str(found.table())
    assert "maximize: required [units]" in invoke("design", "four-wheel", "--maximize", "settling").err
    refused = invoke("design", "four-wheel", "--maximize", "margin", "--rule", "box")
    assert 'contact.rule: required "nearest", of which the margin of feedback is known' in refused.err


SQUEEZE = """
name = "squeeze"
units = { length = "mm", speed = "m/s" }
friction = { mu_roll = 0.8, mu_side = 0.8 }
contact = { rule = "ellipse" }
grid = { rows = 6, columns = 6, pitch = 70 }
field = { kind = "elliptic", a = 1, b = 2, speed = 0.1 }
body = { shape = "rectangle", width = 330, height = 130, heading = "7 deg" }
"""


def test_a_design_for_headings_that_return(invoke: Invoke, tmp_path: Path) -> None:
    """The value is the widest arc that ``simulate --headings`` finds; a body without a shape has none."""
    (tmp_path / "squeeze.toml").write_text(SQUEEZE)
    scene = str(tmp_path / "squeeze.toml")
    found = invoke("design", scene, "--maximize", "heading", "--checks", "1", "--json")
    sampled = invoke("simulate", scene, "--headings", "36", "--json").record
    widths = [math.degrees(arc["last"] - arc["first"]) for arc in sampled["arcs"] if arc["returns"]]
    assert found.record["given"]["value"] == pytest.approx(max(widths)) != 0
    refused = invoke("design", "four-wheel", "--maximize", "heading")
    assert (refused.status, "a body with a shape" in refused.err) == (2, True)


HEAVY = """
name = "table"
units = { length = "mm", speed = "m/s" }
friction = { mu_roll = 0.8, mu_side = 0.8 }
contact = { rule = "ellipse" }
grid = { rows = 2, columns = 2, pitch = 200 }
field = { kind = "radial", speed = 0.1 }
"""
